# SPDX-License-Identifier: MIT
"""One increment: Newton on the bordered system, globalised (see `globalisation`), judged and recorded.

Unknowns are the free dofs of the system and the few border dofs q (rigid body). With controls C q = target, imposed by
forces along the patterns G with unknown sizes lambda, and known border forces F, an iteration solves the linear system
of `linear_stage`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fe_engine.assembly.bordered import Residual
from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.errors import LawError, LinearSolverError, NotConverged
from fe_engine.linear.preconditioner import Origin
from fe_engine.linear.recycled import Recycled
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.globalisation import HALF, HALVINGS, Course
from fe_engine.solve.stage import Balance, FactorStage, LinearStage
from fe_engine.state import State

# Undrained soil under a uniform load moves no water at all, and rounding would be judged beside rounding: volumes count
# beside this share of the volume that the forces would press out at the stiffness of model.Water.scale, at the least.
_STILL = 1.0e-6
# A linear system is solved to this share of the tolerance and no further.
_AIM = 0.3
# An increment has converged when its border dofs and its volumes of water are so many times closer to balance than the
# tolerance asks of all equations: few numbers, of which each counts. The border's decide the rotation under a load near
# the centre of rotation, the volumes add up over the steps of a path.
_STRICT = 10.0
# Forces count beside this share of the initial contact forces at the least, below which a change is rounding.
_ROUNDING = 1.0e-6


@dataclass(frozen=True)
class Loading:
    """What an increment has to reach, in which time: see model.Stage; target (nc,) and force (nb,) are end values.

    ``relaxed`` is the share of the way to the stress of its law that the soil relaxes: see soil.viscous.
    """

    control: np.ndarray
    target: np.ndarray
    load: np.ndarray
    force: np.ndarray
    time_step: float = 0.0
    relaxed: float = 1.0

    def multipliers(self, border: np.ndarray) -> np.ndarray:
        """Return the sizes (nc,) of the unknown forces that balance the controlled combinations."""
        if not len(self.target):
            return np.zeros(0)
        return np.linalg.solve(self.control @ self.load, self.control @ (border - self.force))

    def unbalanced(self, border: np.ndarray) -> np.ndarray:
        """Return the border residual (nb,) that no unknown force takes up."""
        return border - self.force - self.load @ self.multipliers(border)


@dataclass
class Increment:
    """A converged increment: dof increments, end residual and the record."""

    free: np.ndarray
    border: np.ndarray
    residual: Residual
    record: list[dict[str, Any]] = field(default_factory=list)

    @property
    def iterations(self) -> int:
        """Number of linear solves it took."""
        return len(self.record) - 1


class Newton:
    """Solves increments of one system."""

    def __init__(self, system: System | FourierSystem, solver: LinearSolver | FourierStage, settings: Settings) -> None:
        self.system = system
        self.solver = solver  # counts and times the work
        self.settings = settings
        self.scale = system.model.border_scale
        self.stage: LinearStage
        if isinstance(solver, FourierStage):
            self.stage = solver
        else:
            assert isinstance(system, System)
            self.stage = FactorStage(system, solver, settings)

    @property
    def recycled(self) -> Recycled | None:
        """What solves with factors of earlier tangents, where the model is large enough for that."""
        return self.stage.recycled if isinstance(self.stage, FactorStage) else None

    def solve(
        self, state: State, loading: Loading, free: np.ndarray, border: np.ndarray, careful: bool = False
    ) -> Increment:
        """Find the increment from the committed state, starting at the guess free (n,), border (nb,).

        ``careful`` : an attempt at a larger increment has failed shortly before.

        The trial fields hold the solution on return; nothing is committed. Raises NotConverged.
        """
        self.system.time_step = loading.time_step
        self.system.relax(loading.relaxed)
        record: list[dict[str, Any]] = []
        self.stage.begin_increment(careful)
        course = Course(not (np.any(free) or np.any(border)), self.stage.bounds, self.stage.close_below)
        evaluated, ahead = self._linearise(state, True, (free, border), record), None
        for iteration in range(self.settings.max_iterations + 1):
            judged = evaluated[0]
            violation = loading.target - loading.control @ state.trial.border
            merit, error, strict = self._merit(judged, loading)
            record.append(_row(iteration, error, judged))
            if not np.isfinite(merit):
                raise NotConverged("residual is not finite", self._worst(judged), record)
            if strict <= self.settings.tolerance and _met(violation, loading.target):
                self.stage.end_increment()
                return Increment(free, border, judged, record)
            if iteration == self.settings.max_iterations:
                break
            if not course.add(merit, error):
                raise NotConverged("the residual stalls", self._worst(judged), record)
            step = ahead or self._direction(evaluated, state, loading, course.share(error, False), record)
            course.sizes.append(self._size(*step))
            damping, evaluated, ahead = self._advance(state, loading, (free, border), step, course, record)
            free, border = free + damping * step[0], border + damping * step[1]
            record[-1] |= {"damping": damping, "correction": damping * course.sizes[-1]}
        raise NotConverged(f"no convergence in {self.settings.max_iterations} iterations", self._worst(judged), record)

    def border_stiffness(self, state: State) -> np.ndarray:
        """Return the consistent tangent stiffness (nb, nb) of the border dofs at the committed state."""
        state.reset_trial()
        _, _, tangent = self.system.linearise(state, True)
        return self.stage.border_stiffness(tangent)

    def forget(self) -> None:
        """Drop what earlier increments have left: the next one depends on its state alone."""
        self.stage.forget()

    @property
    def origin(self) -> Origin | None:
        """What the factors that the next increment begins with were made from."""
        return self.stage.origin

    def restore(self, origin: Origin) -> None:
        """Begin the next increment with factors made from this."""
        self.stage.restore(origin)

    def condition_estimate(self) -> float | None:
        """Return the condition of the last tangent that was factorised, from below; None where there is none."""
        return self.stage.condition_estimate()

    def close(self) -> None:
        """Release all factors."""
        self.stage.close()

    def _linearise(
        self, state: State, fresh: bool, at: tuple[np.ndarray, np.ndarray], record: list
    ) -> tuple[Residual, Residual, Any]:
        self.system.apply(state, *at)
        try:
            return self.system.linearise(state, fresh)
        except LawError as error:
            raise NotConverged(str(error), "", record) from error

    def _direction(
        self, evaluated: tuple[Residual, Residual, Any], state: State, loading: Loading, share: float, record: list
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the Newton step (n,), (nb,) of the bordered system at the trial state; which may leave a ``share``."""
        judged, linear, tangent = evaluated
        violation = loading.target - loading.control @ state.trial.border
        balance = Balance(loading.control, loading.load, violation, loading.unbalanced(linear.border), self.scale)
        _, _, strict = self._merit(judged, loading)
        enough = min(max(share, _AIM * _ratio(self.settings.tolerance, strict)), self.stage.bounds[1])
        try:
            return self.stage.step(linear, tangent, balance, enough, not _met(violation, loading.target))
        except LinearSolverError as error:
            raise NotConverged(str(error), "", record) from error

    def _advance(
        self, state: State, loading: Loading, at: tuple, step: tuple, course: Course, record: list
    ) -> tuple[float, tuple[Residual, Residual, Any], tuple | None]:
        """Step length, the model there, and the step that follows from there where it is known already."""

        def point(length: float) -> tuple[np.ndarray, np.ndarray]:
            return at[0] + length * step[0], at[1] + length * step[1]

        if course.half:
            return HALF, self._linearise(state, False, point(HALF), record), None
        iterates = self.system.remember_iterates()
        full = np.inf
        try:
            evaluated = self._linearise(state, False, point(1.0), record)
            full, error, _ = self._merit(evaluated[0], loading)
            if course.accepts(full):
                return 1.0, evaluated, None
            if course.may_converge(error):
                ahead = self._direction(evaluated, state, loading, course.share(error, True), record)
                if self._size(*ahead) <= course.sizes[-1]:
                    return 1.0, evaluated, ahead
        except NotConverged:  # the laws or the solver have no answer there
            if len(course.merits) == 1:
                raise
        self.system.take_back(iterates)
        length = self._search(state, loading, point, full, course)
        return length, self._linearise(state, False, point(length), record), None

    def _search(self, state: State, loading: Loading, point: Callable, full: float, course: Course) -> float:
        """Return a step length by halving, from residuals: the first accepted, else the best; ``full`` is that of 1."""
        best, best_merit, length = 1.0, full if np.isfinite(full) else np.inf, 1.0
        for _ in range(HALVINGS):
            length *= 0.5
            self.system.apply(state, *point(length))
            try:
                residual = self.system.residual(state)
            except LawError:
                continue
            merit, _, _ = self._merit(residual, loading)
            if course.accepts(merit):
                return length
            if merit < best_merit:
                best, best_merit = length, merit
        return best

    def _merit(self, residual: Residual, loading: Loading) -> tuple[float, float, float]:
        """Return the residual norm in N, the worse relative error, and the error compared with the tolerance.

        Forces count relative to the contact forces (or the border's reactions or loads), volumes of water relative to
        the volumes that have changed or flowed. The last of the three is strict with the border and the water.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # an iterate that diverges has no finite merit
            square, water = residual.free**2, self.system.is_pressure
            border = float(np.linalg.norm(loading.unbalanced(residual.border) / self.scale))
            volumes = float(np.sum(square[water]))
            forces = float(np.sum(square) - volumes + border**2)
            reaction, load = (float(np.linalg.norm(f / self.scale)) for f in (residual.border, loading.force))
        reference = max(residual.contact_norm, reaction, load, _ROUNDING * self.system.initial_contact_norm)
        error = _ratio(np.sqrt(max(forces, 0.0)), reference)
        strict = max(error, _STRICT * _ratio(border, reference))
        if self.system.model.water is not None:
            scale = self.system.model.water.scale
            changed = max(residual.volume_norm, _STILL * reference / scale)
            left = _ratio(np.sqrt(volumes) / scale, changed)
            error, strict = max(error, left), max(strict, _STRICT * left)
        return float(np.sqrt(forces + volumes)), error, strict

    def _size(self, free: np.ndarray, border: np.ndarray) -> float:
        """Return the root mean square displacement of a step in m."""
        with np.errstate(over="ignore"):  # of an iterate that diverges
            return float(np.sqrt(np.mean(np.concatenate([free, border * self.scale]) ** 2)))

    def _worst(self, residual: Residual) -> str:
        if not len(residual.free):
            return ""
        return self.system.place_of_equation(int(np.argmax(np.abs(residual.free))))


def _ratio(part: float, whole: float) -> float:
    """Return the part/whole, 0 of nothing being 0."""
    return float(part) / float(whole) if whole > 0.0 else (0.0 if part == 0.0 else np.inf)


def _met(violation: np.ndarray, target: np.ndarray) -> bool:
    return bool(np.all(np.abs(violation) <= 1.0e-12 * np.abs(target) + 1.0e-15))


def _row(iteration: int, error: float, residual: Residual) -> dict[str, Any]:
    return {
        "iteration": iteration, "residual": error, "correction": 0.0, "damping": 1.0,
        "n_open": residual.n_open, "n_slip": residual.n_slip,
        "n_plastic": residual.n_plastic, "n_apex": residual.n_apex,
    }  # fmt: skip
