# SPDX-License-Identifier: MIT
"""Stages in increments: predictor, step control, cut-back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fe_engine.errors import ModelError, NotConverged
from fe_engine.model import Stage
from fe_engine.soil.viscous import share_of
from fe_engine.solve.newton import Increment, Loading, Newton
from fe_engine.solve.step_size import GROWTH, StepSize
from fe_engine.state import State


@dataclass
class Step:
    """A committed step: where in the stage it ended, the time it lasted (s), what it took, and what limited its size.

    ``limit`` is one of step_size.LIMITS.
    """

    stage: str
    fraction: float
    multipliers: np.ndarray
    increment: Increment
    cut_backs: int
    time_step: float = 0.0
    limit: str = ""


@dataclass(frozen=True)
class Position:
    """Where a stage stands after a commit: what decides the next increment, beside state, force and n_steps.

    start (nc,) is the controlled motion at the start of the stage, ``done`` the fraction reached, ``next`` the size of
    the next step, ``last`` the size and the increments (n_free,), (nb,) of the last step.
    """

    start: np.ndarray
    done: float
    next: StepSize
    last: tuple[float, np.ndarray, np.ndarray] | None = None


@dataclass
class Driver:
    """Runs stages one after the other and keeps the record of every iteration, failed attempts included.

    ``given_up`` holds (stage, fraction, error) of each failed attempt, ``aim`` what the present one is to reach,
    ``stiffness`` (N/m) that of the border in the last increment, where a given force changed (else None): the work of
    that change over the square of the motion, no less than the smallest eigenvalue. ``position`` is where the last
    commit left the stage: a new driver goes on from there as this one would have. ``refusal`` is asked with the motion
    of the border (nb,) that an increment has converged to: where it returns a reason, the attempt is given up and a
    smaller one made. ``failed`` is called after a failed attempt beyond the first increment of a stage; what it raises
    ends the path. The relaxation time of a stage counts once an attempt has been given up: a run without one is that of
    the law itself.
    """

    newton: Newton
    state: State
    record: list[dict[str, Any]] = field(default_factory=list)
    given_up: list[tuple[str, float, NotConverged]] = field(default_factory=list)
    aim: tuple[str, float] = ("", 0.0)
    n_steps: int = 0
    force: np.ndarray | None = None
    stiffness: float | None = None
    position: Position | None = None
    refusal: Callable[[np.ndarray], str] | None = None
    failed: Callable[[], object] | None = None

    def run(self, stage: Stage, on_step: Callable[[Step], None], position: Position | None = None) -> None:
        """Run a stage, or the rest of it from a position; ``on_step`` is called after each commit.

        Raises NotConverged with the last history.
        """
        if self.newton.system.model.water is not None and not stage.duration > 0.0:
            raise ModelError(f"stage '{stage.name}' has no duration: water needs time to flow, however short")
        known = self.position.last if stage.continues and self.position is not None else None
        at = position or Position(
            stage.control @ self.state.committed.border, 0.0, StepSize(min(stage.first_fraction, 1.0)), known
        )
        force = np.zeros(len(stage.force)) if self.force is None else self.force
        start, done, size, last = at.start, at.done, at.next, at.last
        cuts = 0
        while done < 1.0:
            if self.newton.system.keeps_steps:
                size = size.on_grid(stage.duration, stage.max_fraction)
            target = _next(done, size.size, stage.stops)
            step = target - done
            loading = Loading(
                stage.control,
                start + target * (stage.target - start),
                stage.load,
                force + target * (stage.force - force),
                step * stage.duration,
                share_of(step, self._lag(stage)),
            )
            try:
                increment = self._attempt(stage, loading, target, self._guess(last, step), cuts > 0 or size.wait > 0)
            except NotConverged:
                size = size.after_failure(step, again=cuts > 0)
                cuts += 1
                if last is not None and self.failed is not None:
                    self.failed()
                if size.exhausted:
                    raise
                continue
            self.state.commit()
            self.stiffness = self._stiffness(step * (stage.force - force), increment.border)
            last, done = (step, increment.free, increment.border), target
            held = "stop" if step < size.size * (1.0 - 1.0e-9) and size.limit != "cut-back" else size.limit
            size = size.after_success(step, increment.iterations, stage.max_fraction)
            self.position = Position(start, done, size, last)
            forces = loading.multipliers(increment.residual.border)
            on_step(Step(stage.name, done, forces, increment, cuts, loading.time_step, held))
            cuts = 0
        self.force = np.array(stage.force, dtype=float)

    def _lag(self, stage: Stage) -> float:
        """Return the relaxation time of the soil: none until an attempt has been given up."""
        return stage.lag if self.given_up else 0.0

    def _attempt(
        self, stage: Stage, loading: Loading, target: float, guess: tuple[np.ndarray, np.ndarray], careful: bool
    ) -> Increment:
        self.state.reset_trial()
        self.aim = (stage.name, target)
        label = {"stage": stage.name, "step": self.n_steps + 1, "load_fraction": target}
        try:
            increment = self.newton.solve(self.state, loading, *guess, careful)
            if self.refusal is not None and (reason := self.refusal(self.state.trial.border)):
                raise NotConverged(reason, history=increment.record, refused=True)
        except NotConverged as error:
            self.record += [label | row | {"converged": False} for row in error.history]
            self.given_up.append((stage.name, target, error))
            raise
        self.record += [label | row | {"converged": True} for row in increment.record]
        self.n_steps += 1
        return increment

    def _stiffness(self, force: np.ndarray, border: np.ndarray) -> float | None:
        """Return the stiffness (N/m) beside a change of the given force (nb,) and the motion (nb,) that it caused."""
        square = float(np.sum((border * self.newton.scale) ** 2))
        return float(force @ border) / square if np.any(force) and square > 0.0 else None

    def _guess(self, last: tuple[float, np.ndarray, np.ndarray] | None, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Extrapolate the last increment: every point then starts in the regime it is likely to stay in."""
        if last is None:
            n, nb = self.newton.system.pattern.n_free, self.newton.system.model.n_border
            return np.zeros(n), np.zeros(nb)
        ratio = size / last[0]
        return ratio * last[1], ratio * last[2]


def fewest_increments(stage: Stage) -> int:
    """Return the number of increments of a stage whose every one converges at once: steps grow as fast as they may."""
    size, done, number = min(stage.first_fraction, 1.0), 0.0, 0
    while size < stage.max_fraction and done < 1.0:
        done, size, number = done + size, GROWTH * size, number + 1
    number += math.ceil(max(1.0 - done, 0.0) / stage.max_fraction * (1.0 - 1.0e-9))
    return max(number, len(stage.stops))


def _next(done: float, size: float, stops: tuple[float, ...]) -> float:
    """End of the next increment: never past a stop, and no sliver left before one."""
    stop = min((s for s in stops if done + 1.0e-12 < s < 1.0 - 1.0e-12), default=1.0)
    room = stop - done
    if size >= room * (1.0 - 1.0e-9):
        return stop
    return done + (0.5 * room if 2.0 * size > room else size)
