# SPDX-License-Identifier: MIT
"""Springs with a memory step by step, with a state that is kept."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import xarray as xr

from pysprings.core.arguments import check_arrays, check_numbers
from pysprings.core.arrays import Array
from pysprings.core.errors import BeyondSprings, Problem, refused
from pysprings.core.loads import loads_in_words
from pysprings.macro.fan import WIDEST
from pysprings.macro.model import choose_set
from pysprings.macro.vertical import VerticalTable, covered
from pysprings.macro.ways import RANGE_SLACK, Control
from pysprings.memory.build import build_memory
from pysprings.memory.elements import STATES, advance
from pysprings.memory.mixture import ChangingLoad, Past
from pysprings.memory.model import MemorySprings
from pysprings.memory.shares import elastic_of
from pysprings.memory.water import Water
from pysprings.springs.path import off_rate
from pysprings.springs.springs import Springs

MARKS = ("extrapolated", "off_path", "off_load", "off_rate", "heave_extrapolated", "torsion_apart")
_NO_ANSWER = "the elements carry no more than {} on the way to this step"


@dataclass(frozen=True, slots=True)
class StepMarks:
    """What of a state the springs do not cover; the words are those of a prediction.

    range_used : size of the motion over that of the rays beside it; the state is extrapolated beyond 1.
    off_path : True between rays too far apart.
    off_load : True where V is not that of the elements, or near its capacity. off_rate : True where the motion is
        faster or slower than their rate by half a decade. None where V, or the time of the step, is not given, or the
        springs have no rate.
    way_used : motions added up over the longest way of the calibration; heave is extrapolated beyond 1.
    torsion_apart : True in space where torsion and a lateral load act together.
    """

    range_used: float
    off_path: bool
    off_load: bool | None
    off_rate: bool | None
    way_used: float
    torsion_apart: bool = False

    @property
    def extrapolated(self) -> bool:
        """True beyond the rays."""
        return self.range_used > 1.0 + RANGE_SLACK

    @property
    def heave_extrapolated(self) -> bool:
        """True where the motions add up to more than the ways of the calibration."""
        return self.way_used > 1.0 + RANGE_SLACK

    @property
    def names(self) -> tuple[str, ...]:
        """The marks that are set."""
        return tuple(name for name in MARKS if getattr(self, name))


class MemoryStepper:
    """A state of springs with a memory that goes on step by step, for time stepping.

    `advance` finds a trial state from the committed one, `commit` keeps it; without `commit` the next `advance` starts
    from the same committed state. The attributes may be set to those of another time: all else follows from the next
    `advance`.

    state : (elements, 3) committed numbers of the elements.
    motion, load : committed (u [m], rotation [rad]) and (H [N], M [N m]).
    way : committed motions added up [m].
    past : committed vertical load [N] of the elements, and what they keep of its changes (`pysprings.memory.mixture`).
    offset : (rows,) what vertical reactions and w have kept from other vertical loads.
    water : committed numbers of the water's part of p, see `pysprings.memory.water`; None where there is none.
    """

    def __init__(self, model: MemorySprings) -> None:
        self.model = model
        self.past = Past.at(model.V if np.isfinite(model.V) else 0.0)
        self._loads = model.changing or ChangingLoad(np.array([self.V]), (model.elements,), np.inf, np.inf)
        self.state, self.offset = np.zeros((len(self._loads.rows), STATES)), np.zeros(len(model.table.name))
        self.motion, self.load, self.way = np.zeros(2), np.zeros(2), 0.0
        self._water = model.elements.shares.water if model.changing is None else None
        self.water = None if self._water is None else self._water.rest
        self._trial, self._then = (self.state.copy(), self.motion.copy(), self.load.copy()), self.past
        self._conditions: tuple[float | None, float | None] = None, None

    @classmethod
    def of(cls, springs: Springs | xr.DataTree, *, V: float | None = None, rate: float | None = None) -> Self:
        """Return a stepper at rest on springs at a vertical load [N] (None: that at rest) and a rate [m/s, of rho].

        Raises UserInputError: no ray turns back at this load and rate; of springs at several rates none is given.
        """
        chosen = Springs.of(springs).at(rate=rate, V=V)
        choose_set(chosen, "memory", None)
        return cls(build_memory(chosen))

    def advance(
        self,
        *,
        motion: tuple[float, float] | None = None,
        load: tuple[float, float] | None = None,
        V: float | None = None,
        duration: float | None = None,
    ) -> Array:
        """Go to a motion (u [m], rotation [rad]) or under a load (H [N], M [N m]); return the other one (2,).

        V [N] is the vertical load at the end of the step, where the springs have rays on which V changes; None: that of
        the step before. Else it changes nothing of the answer, as the duration [s] of the step: `marks` compares both
        with the vertical load and the rate of the paths that the elements come from. In the time of a step water
        drains: see `reactions`.

        Raises BeyondSprings: the elements do not carry the load.
        Raises UserInputError: neither, or both, are given, or no two numbers.
        """
        check_step(motion, load, V, duration)
        control: Control = "load" if motion is None else "state"
        check_arrays(motion=motion, load=load)
        model, aim = self.model, np.array([load if motion is None else motion], dtype=float)
        if aim.shape != (1, 2):
            raise refused("load" if motion is None else "motion", "give two numbers: u and rotation, or H and M")
        drive, aims = model.equations(control, aim, 0.0)
        start = self.load / model.to_motion if motion is None else self.motion * model.to_motion
        way, state = np.concatenate([start[None], aims]), self.state.copy()
        now = self.V if V is None or model.changing is None else V
        q, carried, at, then = self._loads.step(drive, self.motion * model.to_motion, state, way, self.past, now)
        if carried is None:
            carried_so_far = loads_in_words(*np.array(at) * model.to_motion)
            raise BeyondSprings([Problem(key="springs", message=_NO_ANSWER.format(carried_so_far))])
        self._trial, self._then = (state, q / model.to_motion, carried * model.to_motion), then
        self._conditions = V, duration
        return self._trial[1 if motion is None else 2].copy()

    @property
    def V(self) -> float:
        """Committed vertical load [N] of the elements."""
        return self.past.V

    @property
    def marks(self) -> StepMarks:
        """What of the last trial state the springs do not cover; before the first step that of the state at rest."""
        model, (V, duration) = self.model, self._conditions
        state, moved = self._trial[1][None], self._moved
        used, sector, _ = model.table.support(state)
        return StepMarks(
            range_used=float(used[0]),
            off_path=bool(sector[0] > WIDEST + RANGE_SLACK and state.any()),  # between rays too far apart
            off_load=self._off_load(V),
            off_rate=rate_mark(model.rate, moved, duration),
            way_used=(self.way + moved) / model.elements.way,
        )

    def _off_load(self, V: float | None) -> bool | None:
        if V is None or self.model.changing is None:
            return load_mark(self.model.vertical, V, self.model.V)
        return not self.model.changing.covers(np.array([V]))[0]

    @property
    def reactions(self) -> Array:
        """All reactions (rows,) of the last trial state, w and V among them, in the rows of `model.table`.

        w and V are the part of the elements: what a V that changes adds is that of the vertical springs
        (`pysprings.macro.vertical.VerticalTable.history`). The water's part of p is that after the duration of the
        step; without one, after a step at the rate of the elements. It is NaN where the springs follow V.
        """
        model, V = self.model, np.array([self._then.mobilised])
        found = self._loads.mixed(self._by_set(*self._trial[:2]), V)[:, 0] + self._kept()
        if model.table.wet.any():
            found[model.table.wet] = np.nan if self._water is None else self._drained(self._water)[0]
        return found

    def _by_set(self, state: Array, motion: Array) -> Array:
        """Return the reactions (sets, rows, 1) of each set in a state at a motion (u [m], rotation [rad])."""
        e, p = self._loads.elastic(state, motion * self.model.to_motion)
        return self._loads.by_set(e[None], p[None])

    def _kept(self) -> Array:
        """Return what vertical reactions and w (rows,) keep from other vertical loads after the last trial step."""
        loads = self.past.mobilised, self._then.mobilised
        if loads[0] == loads[1]:
            return self.offset
        rows = self._by_set(self.state, self.motion)
        left, there = (self._loads.mixed(rows, np.array([V]))[:, 0] for V in loads)
        return self.offset + np.where(self._loads.odd, 0.0, left - there)

    def _drained(self, water: Water) -> tuple[Array, Array]:
        """Return p_water (water rows,) of the last trial state, and the numbers that it leaves.

        The way is divided into steps of the largest size, and straight: under a load it is so only nearly.
        """
        model, (_, duration) = self.model, self._conditions
        assert self.water is not None
        rows, state, F, K, after = self._loads.rows, self.state.copy(), np.zeros(2), np.zeros((2, 2)), self.water.copy()
        time = (duration or self._moved / model.rate) if model.rate else 0.0
        n = max(1, int(np.ceil(self._moved / self._loads.largest)))
        way = np.linspace(self.motion, self._trial[1], n + 1) * model.to_motion
        start, e = elastic_of(rows, state, way[0]), np.empty((n, len(rows), 2))
        for k in range(n):
            advance(rows, way[k], way[k + 1], state, F, K)
            e[k] = elastic_of(rows, state, way[k + 1])
        return water.along(e, time * np.arange(1, n + 1) / n, start, after)[:, -1], after

    @property
    def _moved(self) -> float:
        return float(np.hypot(*((self._trial[1] - self.motion) * self.model.to_motion)))

    @property
    def tangent(self) -> Array:
        """Tangent (2, 2) of (H, M) to (u, rotation) at the end of the last trial step.

        Consistent with `advance` for steps that are not divided (up to a hundredth of the reach), and nearly so where
        V changes; before the first step it is that at rest.
        """
        model, F, K, state = self.model, np.zeros(2), np.zeros((2, 2)), self.state.copy()
        start, end = self.motion * model.to_motion, self._trial[1] * model.to_motion
        self._loads.changed(self.past, self._then.V, state, start)
        advance(self._loads.rows_at(self._then.mobilised), start, end, state, F, K)
        return K * model.to_motion * model.to_motion[:, None]

    def commit(self) -> None:
        """Keep the last trial state."""
        state, motion, load = self._trial
        if self._water is not None:
            self.water = self._drained(self._water)[1]
        self.way += self._moved
        self.offset, self.past = self._kept(), self._then
        self.state, self.motion, self.load = state.copy(), motion.copy(), load.copy()
        self._conditions = self._conditions[0], None  # what has drained has


def check_step(motion: Any, load: Any, V: float | None, duration: float | None) -> None:
    """Refuse a step to neither a motion nor a load, or to both, a V [N] that is no number, a duration [s] up to 0."""
    if (motion is None) == (load is None):
        raise refused("motion", "give a motion or a load")
    check_numbers(V=V, duration=duration)
    if duration is not None and duration <= 0.0:
        raise refused("duration", f"{duration:g} s must be more than 0 s")


def load_mark(vertical: VerticalTable | None, V: float | None, own: float) -> bool | None:
    """Return whether V [N] is not that of the elements, or near its capacity; None where either is not given."""
    return None if V is None or not np.isfinite(own) else not covered(vertical, np.array([V]), np.array([own]))[0]


def rate_mark(rate: float | None, moved: float, duration: float | None) -> bool | None:
    """Return whether a motion [m] in a time [s] is off a rate [m/s] by half a decade; None without either."""
    return None if rate is None or duration is None else bool(off_rate(rate, np.array(moved), np.array(duration)))
