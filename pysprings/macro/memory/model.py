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
from pysprings.macro.memory.marks import StepMarks, lateral_marks, off_load, off_rate
from pysprings.macro.memory.shares import elastic_of, ways_of
from pysprings.macro.memory.water import Water
from pysprings.macro.solver import Drive

Array = NDArray[np.float64]

_NO_ANSWER = "the elements carry no more than H = {:.6g} N, M = {:.6g} N m on the way to this step"


@dataclass(frozen=True, eq=False)
class MemoryModel:
    """Elements with a memory, and the layout of the reactions of a caisson.

    Attributes
    ----------
    elements : calibrated elements.
    table : fan of the rays: names, depths and actions of the reactions, and the size of the loads.
    V : vertical load [N] of the rays that turn back, or between two of theirs; NaN where it is not known.
    rate : their rate [m/s, of rho], or between two; None where springs do not depend on one.
    sets : number of sets that the elements are from: more than one between two vertical loads or rates.
    """

    elements: ElementSet
    table: FanTable
    V: float = np.nan
    rate: float | None = None
    sets: int = 1

    @cached_property
    def to_motion(self) -> Array:
        """Factors (2,) from (u, rotation) to (u, rotation*L) [m]."""
        return np.array([1.0, self.table.length])

    @cached_property
    def rest(self) -> tuple[float, float]:
        """w [m] and V [N] of the elements at rest."""
        w, V = (float(self.elements.shares.rest[self.table.name == name][0]) for name in ("w", "V"))
        return w, V

    def solve(self, control: Control, targets: Array, arm: float = 0.0) -> tuple[Array, Array, str]:
        """Follow targets (n, 2) from rest: states (k, 2) = (u, rotation), loads (k, 2) = (H, M), and where it ended.

        As `pysprings.macro.model.MacroModel.solve`, whose controls these are.
        """
        targets = np.asarray(targets, dtype=float)
        drive, aims = self.equations(control, targets, arm)
        motions, loads = np.zeros(aims.shape), np.zeros(aims.shape)
        states = np.zeros((len(self.elements.rows), STATES))
        way = np.concatenate([np.zeros((1, 2)), aims])
        motions, loads = np.zeros(way.shape), np.zeros(way.shape)
        n, at0, at1 = follow(self.elements.rows, drive, self.elements.largest, np.zeros(2), states, way, motions, loads)
        found, carried = motions[1:n] / self.to_motion, loads[1:n] * self.to_motion
        at = self._target(control, np.array([at0, at1]))
        return found, carried, "" if n == len(way) else ending(control, at, targets[n - 1], found, carried)

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

    def tangents(self, states: Array) -> Array:
        """Return the tangents (n, 2, 2) to (u, rotation) along states (n, 2) = (u, rotation), from rest on."""
        motions = np.ascontiguousarray(states * self.to_motion)
        loads, out = np.zeros(motions.shape), np.zeros((len(motions), 2, 2))
        tangents(self.elements.rows, motions, self.elements.largest, loads, out)
        scaled: Array = out * self.to_motion * self.to_motion[:, None]
        return scaled

    def reactions(self, states: Array, time: Array | None = None) -> Array:
        """Return all reactions (rows, n) of a fan along states (n, 2) = (u, rotation), from rest on.

        time (n,) [s] of the states, from 0 s at rest; None: at the rate of the elements. The water's part of p alone
        depends on it, and that of springs without a rate does not.
        """
        motions, shares = states * self.to_motion, self.elements.shares
        e, p = elastic_motions(self.elements.rows, motions, self.elements.largest)
        found = shares.reactions(self.elements.rows, e, p)
        if self.table.wet.any():
            found[self.table.wet] = self._water(motions, self.times(states) if time is None or not self.rate else time)
        return found

    def times(self, states: Array) -> Array:
        """Return the times (n,) [s] of states (n, 2) = (u, rotation) from rest at the rate of the elements, or 0."""
        ways = np.hypot(*np.diff(states * self.to_motion, axis=0, prepend=0.0).T).cumsum()
        found: Array = ways / self.rate if self.rate else np.zeros(len(ways))
        return found

    def _water(self, motions: Array, time: Array) -> Array | float:
        """Return p_water (rows, n) along motions (n, 2) [m], in steps of the largest size; NaN where not known."""
        water = self.elements.shares.water
        if water is None:
            return np.nan
        ways = np.hypot(*np.diff(motions, axis=0, prepend=0.0).T)
        ends = np.ceil(np.maximum(ways / self.elements.largest, 1.0)).cumsum()
        at, last = np.arange(1.0, ends[-1] + 1.0), np.concatenate([[0.0], ends])
        fine = np.stack([np.interp(at, last, np.concatenate([[0.0], column])) for column in motions.T], axis=1)
        e, _ = elastic_motions(self.elements.rows, fine, self.elements.largest)
        found = water.along(e, np.interp(at, last, np.concatenate([[0.0], time])), np.zeros(e.shape[1:]), water.rest)
        return found[:, ends.astype(int) - 1]


class MemoryStepper:
    """A state of springs with a memory that goes on step by step, for time stepping.

    `advance` finds a trial state from the committed one, `commit` keeps it; without `commit` the next `advance` starts
    from the same committed state.

    Attributes
    ----------
    state : (elements, 3) committed numbers of the elements.
    motion, load : committed (u [m], rotation [rad]) and (H [N], M [N m]).
    way : committed motions added up [m].
    water : committed numbers of the water's part of p, see `pysprings.macro.memory.water`; None where there is none.
    """

    def __init__(self, model: MemoryModel) -> None:
        self.model = model
        self.state = np.zeros((len(model.elements.rows), STATES))
        self.motion, self.load, self.way = np.zeros(2), np.zeros(2), 0.0
        water = model.elements.shares.water
        self.water = None if water is None else water.rest
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

        V [N] and the duration [s] of the step change nothing of the answer: `marks` compares them with the vertical
        load and the rate of the paths that the elements come from. In the time of a step water drains: see `reactions`.

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
        state, first = self.state.copy(), self.motion * model.to_motion
        n, at0, at1 = follow(model.elements.rows, drive, model.elements.largest, first, state, way, found, carried)
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
            off_load=off_load(model.V, V),
            off_rate=off_rate(model.rate, moved, duration),
            way_used=(self.way + moved) / model.elements.way,
        )

    @property
    def reactions(self) -> Array:
        """All reactions (rows,) of the last trial state, w and V among them, in the rows of `model.table`.

        The water's part of p is that after the duration of the step; without one, after a step at the rate of the
        elements.
        """
        (state, motion, _), model = self._trial, self.model
        rows, shares = model.elements.rows, model.elements.shares
        e = elastic_of(rows, state, motion * model.to_motion)
        found: Array = shares.reactions(rows, e[None], ways_of(rows, state)[None])[:, 0]
        water = shares.water
        if model.table.wet.any():
            found[model.table.wet] = np.nan if water is None else self._drained(water)[0]
        return found

    def _drained(self, water: Water) -> tuple[Array, Array]:
        """Return p_water (water rows,) of the last trial state, and the numbers that it leaves."""
        model, (_, duration) = self.model, self._conditions
        rows, pairs = model.elements.rows, ((self.state, self.motion), self._trial[:2])
        start, end = (elastic_of(rows, state, motion * model.to_motion) for state, motion in pairs)
        step = (duration or self._moved / model.rate) if model.rate else 0.0
        assert self.water is not None
        after = self.water.copy()
        return water.along(end[None], np.array([step]), start, after)[:, 0], after

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
        advance(model.elements.rows, start, end, self.state.copy(), F, K)
        scaled: Array = K * model.to_motion * model.to_motion[:, None]
        return scaled

    def commit(self) -> None:
        """Keep the last trial state."""
        state, motion, load = self._trial
        water = self.model.elements.shares.water
        if water is not None:
            self.water = self._drained(water)[1]
        self.way += self._moved
        self.state, self.motion, self.load = state.copy(), motion.copy(), load.copy()
