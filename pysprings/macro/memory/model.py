# SPDX-License-Identifier: MIT
"""Springs with a memory, asked along sequences from rest, or step by step with a state that is kept."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arguments import check_numbers
from pysprings.core.errors import BeyondSprings, Problem, refused
from pysprings.macro.control import Control, ending, equations
from pysprings.macro.fan import RANGE_SLACK, FanTable
from pysprings.macro.memory.calibration import ElementSet, elastic_motions, way_of
from pysprings.macro.memory.elements import STATES, advance, follow, tangents
from pysprings.macro.memory.marks import StepMarks, lateral_marks, off_rate
from pysprings.macro.memory.mixture import LoadedSets
from pysprings.macro.memory.shares import elastic_of, ways_of
from pysprings.macro.solver import Drive
from pysprings.springs.alike import same_load

Array = NDArray[np.float64]

_NO_ANSWER = "the elements carry no more than H = {:.6g} N, M = {:.6g} N m on the way to this step"


@dataclass(frozen=True, eq=False)
class MemoryModel:
    """Elements with a memory, and the layout of the reactions of a caisson.

    Attributes
    ----------
    elements : calibrated elements, at V.
    table : fan of the rays: names, depths and actions of the reactions, and the size of the loads.
    V : vertical load [N] of the rays that turn back, or between two of theirs; NaN where it is not known.
    rate : their rate [m/s, of rho]; None where springs do not depend on one.
    loaded : elements at all vertical loads with rays that turn back; None where these have one.
    """

    elements: ElementSet
    table: FanTable
    V: float = np.nan
    rate: float | None = None
    loaded: LoadedSets | None = None

    @cached_property
    def to_motion(self) -> Array:
        """Factors (2,) from (u, rotation) to (u, rotation*L) [m]."""
        return np.array([1.0, self.table.length])

    @cached_property
    def down(self) -> int:
        """Row of w among the reactions."""
        return int(np.flatnonzero(self.table.name == "w")[0])

    @cached_property
    def rest(self) -> tuple[float, float]:
        """w [m] and V [N] of the elements at rest."""
        w, V = (float(self.elements.shares.rest[self.table.name == name][0]) for name in ("w", "V"))
        return w, V

    def covers(self, V: Array) -> NDArray[np.bool_]:
        """Return which vertical loads (n,) [N] the elements are made for."""
        if self.loaded is not None:
            return self.loaded.covers(V)
        return np.array([not np.isfinite(self.V) or same_load(self.V, float(value)) for value in V], dtype=bool)

    def solve(
        self, control: Control, targets: Array, arm: float = 0.0, V: Array | None = None
    ) -> tuple[Array, Array, str]:
        """Follow targets (n, 2) from rest: states (k, 2) = (u, rotation), loads (k, 2) = (H, M), and where it ended.

        As `pysprings.macro.model.MacroModel.solve`, whose controls these are. V (n,) [N] by target changes the shares
        of the elements at several vertical loads; None: V of the model.
        """
        targets = np.asarray(targets, dtype=float)
        drive, aims = self.equations(control, targets, arm)
        rows, sets, largest = self.parallel(V)
        way = np.concatenate([np.zeros((1, 2)), aims])
        shares = self.shares(None if V is None else np.concatenate([V[:1], V]), len(way))
        motions, loads = np.zeros(way.shape), np.zeros(way.shape)
        states = np.zeros((len(rows), STATES))
        n, at0, at1 = follow(rows, sets, drive, largest, np.zeros(2), states, way, shares, motions, loads)
        found, carried = motions[1:n] / self.to_motion, loads[1:n] * self.to_motion
        at = self._target(control, np.array([at0, at1]))
        return found, carried, "" if n == len(way) else ending(control, at, targets[n - 1], found, carried)

    def parallel(self, V: Array | None) -> tuple[Array, NDArray[np.int64], float]:
        """Return the elements that follow a motion, the set of each, and the largest step [m]; V as in `solve`."""
        if V is None or self.loaded is None:
            return self.elements.rows, np.zeros(len(self.elements.rows), dtype=np.int64), self.elements.largest
        return self.loaded.rows, self.loaded.of, self.loaded.largest

    def shares(self, V: Array | None, n: int) -> Array:
        """Return the shares (n, sets) of the sets of `parallel` at n points; V (n,) [N] as in `solve`."""
        return np.ones((n, 1)) if V is None or self.loaded is None else self.loaded.shares(V)

    def equations(self, control: Control, targets: Array, arm: float) -> tuple[Drive, Array]:
        """Return the equations of a control in (u, rotation*L) and (H, M/L), and their right sides (n, 2)."""
        L = self.table.length
        (G, C, scale), aims = equations(control, targets, arm, self.table.load_scale)
        if control in ("load", "state"):
            aims = aims / self.to_motion if control == "load" else aims * self.to_motion
            factor = 1.0 / self.to_motion if control == "load" else self.to_motion
            size = float(np.max(scale * factor))
            return Drive(G, C, np.full(2, size)), np.ascontiguousarray(aims)
        G, C = G / [1.0, L], C * [1.0, L]
        return Drive(np.ascontiguousarray(G), np.ascontiguousarray(C), scale), np.ascontiguousarray(aims)

    def _target(self, control: Control, c: Array) -> tuple[float, float]:
        factor = {"load": self.to_motion, "state": 1.0 / self.to_motion}.get(control, np.ones(2))
        return float(c[0] * factor[0]), float(c[1] * factor[1])

    def notes(self, states: Array) -> list[str]:
        """Return a sentence where states (n, 2) = (u, rotation) come farther than the ways of the calibration."""
        come = way_of(states * self.to_motion) / self.elements.way
        text = (
            f"the motions add up to {come:.3g} times the way of the rays that turn back: heave, settlement and "
            "vertical reactions are extrapolated beyond"
        )
        return [text] if come > 1.0 + RANGE_SLACK else []

    def off_rates(self, states: Array, time: Array) -> NDArray[np.bool_]:
        """Return where steps to states (n, 2) = (u, rotation) at times (n,) [s], from rest at 0 s, are off the rate."""
        ways = np.hypot(*np.diff(states * self.to_motion, axis=0, prepend=0.0).T)
        steps = zip(ways, np.diff(time, prepend=0.0), strict=True)
        return np.array([bool(off_rate(self.rate, float(way), float(step))) for way, step in steps])

    def tangents(self, states: Array, V: Array | None = None) -> Array:
        """Return the tangents (n, 2, 2) to (u, rotation) along states (n, 2) = (u, rotation), from rest on; V (n,)."""
        motions = np.ascontiguousarray(states * self.to_motion)
        loads, out = np.zeros(motions.shape), np.zeros((len(motions), 2, 2))
        rows, sets, largest = self.parallel(V)
        tangents(rows, sets, motions, self.shares(V, len(motions)), largest, loads, out)
        scaled: Array = out * self.to_motion * self.to_motion[:, None]
        return scaled

    def reactions(self, states: Array, V: Array | None = None) -> Array:
        """Return all reactions (rows, n) of a fan along states (n, 2) = (u, rotation), from rest on; V (n,) [N].

        w is without what V itself moves: see `pysprings.macro.memory.mixture`.
        """
        motions = states * self.to_motion
        if V is not None and self.loaded is not None:
            return self.loaded.reactions(motions, V, self.down, self.rest[0])
        e, p = elastic_motions(self.elements.rows, motions, self.elements.largest)
        return self.elements.shares.reactions(self.elements.rows, e, p)


class MemoryStepper:
    """A state of springs with a memory that goes on step by step, for time stepping.

    `advance` finds a trial state from the committed one, `commit` keeps it; without `commit` the next `advance` starts
    from the same committed state.

    Attributes
    ----------
    state : (elements, 3) committed numbers of the elements, those at all vertical loads.
    motion, load : committed (u [m], rotation [rad]) and (H [N], M [N m]).
    V : committed vertical load [N]; NaN where the model has none.
    way : committed motions added up [m].
    """

    def __init__(self, model: MemoryModel) -> None:
        self.model, self.V, self.way = model, model.V, 0.0
        rows = model.parallel(self._loads(model.V))[0]
        self.state, self.motion, self.load = np.zeros((len(rows), STATES)), np.zeros(2), np.zeros(2)
        self._sunk = model.rest[0]
        self._trial = self.state.copy(), self.motion.copy(), self.load.copy()
        self._conditions: tuple[float | None, float | None] = None, None

    def advance(
        self,
        *,
        motion: tuple[float, float] | None = None,
        load: tuple[float, float] | None = None,
        V: float | None = None,
        duration: float | None = None,
    ) -> Array:
        """Go to a motion (u [m], rotation [rad]) or under a load (H [N], M [N m]); return the other one (2,).

        V [N] at the end of the step (None: as before) changes what elements at several vertical loads carry; `marks`
        compares it, and the duration [s] of the step, with the paths that the elements come from.

        Raises
        ------
        BeyondSprings
            The elements do not carry the load.
        UserInputError
            Neither, or both, are given.
        """
        if (motion is None) == (load is None):
            raise refused("motion", "give a motion or a load")
        check_numbers(V=V, duration=duration)
        if duration is not None and duration <= 0.0:
            raise refused("duration", f"{duration:g} s must be more than 0 s")
        control: Control = "load" if motion is None else "state"
        model, aim = self.model, np.array([load if motion is None else motion], dtype=float)
        drive, aims = model.equations(control, aim, 0.0)
        start = self.load / model.to_motion if motion is None else self.motion * model.to_motion
        way, found, carried = np.concatenate([start[None], aims]), np.zeros((2, 2)), np.zeros((2, 2))
        state, first, loads = self.state.copy(), self.motion * model.to_motion, self._loads(self.V, V)
        rows, sets, largest = model.parallel(loads)
        shares = model.shares(loads, 2)
        n, at0, at1 = follow(rows, sets, drive, largest, first, state, way, shares, found, carried)
        if n < len(way):
            H, M = np.array([at0, at1]) * model.to_motion
            raise BeyondSprings([Problem(key="springs", message=_NO_ANSWER.format(H, M))])
        self._trial = state, found[1] / model.to_motion, carried[1] * model.to_motion
        self._conditions = V, duration
        answer: Array = self._trial[1 if motion is None else 2].copy()
        return answer

    @property
    def marks(self) -> StepMarks:
        """What of the last trial state the springs do not cover; before the first step that of the state at rest."""
        model, (V, duration) = self.model, self._conditions
        used, aside = lateral_marks(model.table, (float(self._trial[1][0]), float(self._trial[1][1])))
        moved = self._moved
        return StepMarks(
            range_used=used,
            extrapolated=used > 1.0 + RANGE_SLACK,
            off_path=aside,
            off_load=None if V is None or not np.isfinite(model.V) else not bool(model.covers(np.array([V]))[0]),
            off_rate=off_rate(model.rate, moved, duration),
            way_used=(self.way + moved) / model.elements.way,
        )

    @property
    def reactions(self) -> Array:
        """All reactions (rows,) of the last trial state, w and V among them, in the rows of `model.table`.

        w is without what a change of V itself moves: that is of the vertical springs.
        """
        (state, motion, _), model = self._trial, self.model
        loads = self._loads(self.V, self._conditions[0])
        if loads is not None and model.loaded is not None:
            found: Array = model.loaded.shares(loads[1:])[0] @ model.loaded.reactions_of(state, motion * model.to_motion)
            found[model.down] = self._sunk + self._sinks
            return found
        rows, shares = model.elements.rows, model.elements.shares
        e = elastic_of(rows, state, motion * model.to_motion)
        alone: Array = shares.reactions(rows, e[None], ways_of(rows, state)[None])[:, 0]
        return alone

    def _loads(self, *V: float | None) -> Array | None:
        """Return vertical loads [N] by point, None for the committed one; None where elements have one V alone."""
        if self.model.loaded is None:
            return None
        return np.array([self.V if value is None else value for value in V])

    @property
    def _sinks(self) -> float:
        """What w changes by in the last trial step, without what V itself moves [m]."""
        loads, model = self._loads(self.V, self._conditions[0]), self.model
        if loads is None or model.loaded is None:
            return 0.0
        before, after = (
            model.loaded.reactions_of(state, motion * model.to_motion)[:, model.down]
            for state, motion in ((self.state, self.motion), self._trial[:2])
        )
        return float(model.loaded.shares(loads).mean(axis=0) @ (after - before))

    @property
    def _moved(self) -> float:
        return float(np.hypot(*((self._trial[1] - self.motion) * self.model.to_motion)))

    @property
    def tangent(self) -> Array:
        """Tangent (2, 2) of (H, M) to (u, rotation) at the end of the last trial step.

        Consistent with `advance` for steps that are not divided (up to a hundredth of the reach); before the first
        step it is that at rest.
        """
        model, F, K = self.model, np.zeros(2), np.zeros((2, 2))
        start, end = self.motion * model.to_motion, self._trial[1] * model.to_motion
        loads = self._loads(self.V, self._conditions[0])
        rows, sets, _ = model.parallel(loads)
        share = np.ascontiguousarray(model.shares(loads, 2)[-1][sets])
        advance(rows, share, start, end, self.state.copy(), F, K)
        scaled: Array = K * model.to_motion * model.to_motion[:, None]
        return scaled

    def commit(self) -> None:
        """Keep the last trial state."""
        state, motion, load = self._trial
        self._sunk += self._sinks
        self.way += self._moved
        self.V = self.V if self._conditions[0] is None else self._conditions[0]
        self.state, self.motion, self.load = state.copy(), motion.copy(), load.copy()
