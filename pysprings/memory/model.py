# SPDX-License-Identifier: MIT
"""Springs with a memory: the response of elements along sequences from rest."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.errors import refused
from pysprings.core.loads import same_load
from pysprings.core.text import with_prefix
from pysprings.macro.fan_springs import FanSprings
from pysprings.macro.response import Between, ElementRows, Level
from pysprings.macro.solver import Drive
from pysprings.macro.vertical import VerticalTable
from pysprings.macro.ways import Along, Control, ending, equations
from pysprings.memory.calibration import NO_FARTHER, ElementSet, beyond_way, numbers_of
from pysprings.memory.elements import COLUMNS, PLATES, SPACE, SPACE_COLUMNS, SPACE_STATES, STATES, follow, tangents
from pysprings.memory.mixture import ChangingLoad
from pysprings.memory.offered import Offered, even_by_row, numbers_in_space
from pysprings.memory.shares import elastic_motions, even_motions, loads_of
from pysprings.memory.space import SHARE_NOTHING

_NOT_ASKED = {
    "cases": "springs with memory answer sequences, not independent cases: ask for 'fan'",
    "secant": "springs with memory have no secant stiffness of a state: ask for the springs 'fan'",
}

_FOLLOW = (
    "the springs follow a V that changes: on sequences held back they were 2 to 16 % off in clay, 7 to 14 % in sand, "
    "and 25 to 28 % short of its motion far from yield (`compare RESULT --cycles`: those of a run)"
)
_IN_SPACE = "elements in the space of both planes, calibrated on paths out of one plane"

PART = 4.0  # a way under loads is divided where its motion is longer than this, in largest steps of the elements

# ways on which motions between the planes are tried: directions of (u, rotation L), motions over the reach
_ANGLES = np.radians([-90.0, -60.0, -45.0, -30.0, 0.0, 30.0, 60.0])  # of (u, rotation L)
_WAY = np.concatenate([np.linspace(0.02, 0.5, 25), np.linspace(0.48, -0.5, 50), np.linspace(-0.48, 0.5, 50)])


@dataclass(frozen=True, eq=False)
class MemorySprings(FanSprings):
    """Elements with a memory (`pysprings.memory.elements`) that share out the reactions of a fan.

    table : fan of the rays: names, depths and actions of the reactions, and the size of the loads.
    elements : calibrated elements.
    V : vertical load [N] of the rays that turn back, or between two of theirs; NaN where it is not known.
    rate : their rate [m/s, of rho], or between two; None where springs do not depend on one.
    sets : number of sets that the elements are from: more than one between two vertical loads or rates.
    changing : elements under a V that changes; None where the springs have no rays on which V changes.
    vertical : vertical springs beside them; None where there are none.
    """

    elements: ElementSet = field(kw_only=True)
    V: float = field(default=np.nan, kw_only=True)
    rate: float | None = field(default=None, kw_only=True)
    sets: int = field(default=1, kw_only=True)
    changing: ChangingLoad | None = field(default=None, kw_only=True)
    vertical: VerticalTable | None = field(default=None, kw_only=True)
    curves: ClassVar[str] = "elastoplastic elements in parallel, which remember reversals"

    @cached_property
    def to_motion(self) -> Array:
        """Factors (2,) from (u, rotation) to (u, rotation*L) [m]."""
        return np.array([1.0, self.table.length])

    @cached_property
    def rest(self) -> tuple[float, float]:
        """w [m] and V [N] of the elements at rest."""
        return self._w_and_load(self.elements.shares.rest)

    def _w_and_load(self, rows: Array) -> tuple[float, float]:
        """Return w [m] and V [N] of all reactions (rows,)."""
        w, V = (float(rows[self.table.name == name][0]) for name in ("w", "V"))
        return w, V

    @property
    def element_rows(self) -> ElementRows:
        """The elements for programs that step in time: those in space, or else those of the plane."""
        own, names = self.elements, self.table.name[~self.elements.shares.odd].tolist()
        if own.space is not None:
            rows, twist = own.space.rows, own.space.twist
            radius, limit = own.space.radius if twist else 0.0, 1.0 / own.space.growth
            head = (own.largest, radius, twist, own.space.way, limit, *self.rest)
            whole = np.hstack([rows, even_by_row(own.space.even, Offered.of_space(rows), len(rows))])
            return ElementRows(whole, head, numbers_in_space(rows), self.sets, True)
        down = [names.index(name) for name in ("w", "V")]
        factors = own.shares.even[down].reshape(2, 2, -1).transpose(2, 1, 0).reshape(-1, 4)
        limit = 1.0 / float(np.asarray(own.shares.growth)) if self.sets == 1 else 0.0
        head = (own.largest, 0.0, 0.0, own.way, limit, *self.rest)
        rows = np.concatenate([own.rows, np.zeros((len(own.rows), SPACE_COLUMNS - COLUMNS)), factors], axis=1)
        return ElementRows(rows, head, numbers_of(own.rows), self.sets)

    def plane_notes(self) -> list[str]:
        """Return sentences on motions out of one plane: of elements in space, or at 45 degrees between plates."""
        if self.elements.space is not None:
            return [_IN_SPACE, *[f"torsion and lateral loads together: {SHARE_NOTHING}"] * self.element_rows.twists]
        shares = self.elements.shares
        H, M, w = error_between_planes(self.elements, shares.even[self.table.name[~shares.odd].tolist().index("w")])
        return [
            "out of one plane of motion: elements with one gauge of the motion in both planes, an assumption",
            f"gap and frictional elements stand in the planes of x and y: at 45 degrees between them loads differ by "
            f"up to {100 * H:.2g} % in H and {100 * M:.2g} % in M, and w by up to {100 * w:.2g} %, of the largest on a "
            "way to half of the reach, back and forth",
        ]

    def sequence_remarks(self, V: Level = None) -> tuple[str, ...]:
        """Return a sentence where springs follow V (n,) [N] that changes."""
        return (_FOLLOW,) if self.under(V) is not None and np.ptp(np.asarray(V, dtype=float)) > 0.0 else ()

    def lasting(self, marks: Marks) -> Marks:
        """Return marks by state (n,) along a way, and all that come after: elements remember where they were."""
        return np.logical_or.accumulate(marks)

    def check_state(self, asked: Literal["cases", "secant"]) -> None:
        """Raise UserInputError: a state alone has no answer, it depends on the way to it."""
        raise refused("springs_kind", _NOT_ASKED[asked])

    def under(self, V: Level) -> ChangingLoad | None:
        """Return the elements that follow vertical loads (n,) [N]; None where all are that of the elements, or none."""
        if self.changing is None or V is None:
            return None
        return None if all(same_load(self.V, each) for each in np.unique(V)) else self.changing

    def follows(self, V: Level) -> bool:
        """Return whether the elements follow vertical loads (n,) [N] that are not their own."""
        return self.under(V) is not None

    def lacks(self, V: Array, other: Marks) -> Marks:
        """Return which states under V (n,) [N] the elements do not follow, where `other` (n,) are not at their V.

        They are those from the first one on that is not at their V, or, with rays on which V changes, beyond its range.
        """
        changing = self.under(V)
        beyond = other if changing is None else other & ~changing.covers(V)
        return np.logical_or.accumulate(beyond)

    def rest_under(self, V: Level) -> tuple[float, float]:
        """Return w [m] and V [N] of the elements at rest, at the first of vertical loads (n,) [N] that they follow."""
        changing = self.under(V)
        if changing is None or V is None:
            return self.rest
        rows = np.stack([each.shares.rest for each in changing.sets])
        return self._w_and_load(changing.mixed(rows[:, :, None], np.ravel(V)[:1])[:, 0])

    def lacks_notes(self, V: Array, lacking: Marks) -> list[str]:
        """Return a sentence on states under another V [N] than the elements follow, or after one."""
        if not lacking.any():
            return []
        own, there = f"that of the elements ({with_prefix(self.V, 'N', 6)})", "unchanged"
        if self.changing is not None:
            low, high = self.changing.loads[[0, -1]]
            own = f"those of the elements ({with_prefix(low, 'N', 6)} to {with_prefix(high, 'N', 6)})"
        if self.follows(V):
            there = "are those at the nearest load"
        text = f"{lacking.sum()} of {lacking.size} states are under another V than {own}, or come after one"
        return [f"{text}: lateral springs {there}"]

    def settle(self, vertical: VerticalTable, V: Array) -> Array:
        """Return w [m], tangent, range used and that of V alone, (4, n), of vertical springs after all V (n,) [N]."""
        return vertical.history(V)

    def settled(self, vertical: VerticalTable | None, V: Level, between: float) -> float:
        """Return what w [m] at rest lacks to that of the vertical springs, at the first of V [N]: see `Response`."""
        if vertical is None or self.under(V) is None:
            return between
        return vertical.lacking(*self.rest_under(V))

    def along(self, control: Control, targets: Array, arm: float, states: Array, V: Level, rest: float) -> Along:
        """Return a sentence where states (k, 2) come farther than the calibration; turns are no mark."""
        return Along(notes=beyond_way(states * self.to_motion, self.elements.way))

    def solve(self, control: Control, targets: Array, arm: float = 0.0, V: Level = None) -> tuple[Array, Array, str]:
        """Follow targets (n, 2) from rest: see `pysprings.macro.model.MacroModel.solve`.

        V (n,) [N]: vertical load of each target; one number, or None, is that of the elements.
        """
        targets = np.asarray(targets, dtype=float)
        drive, aims = self.equations(control, targets, arm)
        changing, elements = self.under(V), self.elements
        motions, carried, at = (
            followed(elements.rows, drive, elements.largest, aims)
            if changing is None
            else changing.follow(drive, aims, _each(V, aims))
        )
        states, loads, n = motions / self.to_motion, carried * self.to_motion, len(motions)
        if n == len(aims):
            return states, loads, ""
        end = self._target(control, np.array(at))
        return states, loads, f"{ending(control, end, targets[n], states, loads)}; {NO_FARTHER}"

    def between(self, control: Control, targets: Array, arm: float, states: Array, V: Level) -> Between:
        """Return states on the way to states (n, 2) that targets (n, 2) lead to: see `Response`.

        None where motions are imposed, which go straight, where steps are short, or where the springs follow V.
        """
        if control == "state" or self.under(V) is not None:
            return None
        divided = divided_way(targets, states * self.to_motion, self.elements.largest)
        return None if divided is None else joined(self.solve(control, divided[0], arm)[0], states, divided[1])

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

    def tangents(self, states: Array, V: Level = None) -> Array:
        """Return the tangents (n, 2, 2) to (u, rotation) along states (n, 2) = (u, rotation), from rest on.

        V (n,) [N]: as in `solve`.
        """
        motions, changing = np.ascontiguousarray(states * self.to_motion), self.under(V)
        loads, out = np.zeros(motions.shape), np.zeros((len(motions), 2, 2))
        if changing is None:
            tangents(self.elements.rows, motions, self.elements.largest, loads, out)
        else:
            out = changing.tangents(motions, _each(V, motions))
        return out * self.to_motion * self.to_motion[:, None]

    def reactions(self, states: Array, time: Array | None = None, V: Level = None, between: Between = None) -> Array:
        """Return all reactions (rows, n) of a fan along states (n, 2) = (u, rotation), from rest on.

        The way from state to state is straight, or that of `between`. time (n,) [s] of the states, from 0 s at rest;
        None: at the rate of the elements. The water's part of p alone depends on it, and that of springs without a rate
        does not. V (n,) [N]: as in `solve`.
        """
        if between is not None:
            fine, ends = between
            known = None if time is None else np.interp(np.arange(len(fine)), np.append(-1, ends), np.append(0.0, time))
            return self.reactions(fine, known, V)[:, ends]
        changing = self.under(V)
        if changing is not None:
            found = changing.reactions(states * self.to_motion, _each(V, states))
            found[self.table.wet] = np.nan  # the water of a V that changes is not known
            return found
        motions, shares = states * self.to_motion, self.elements.shares
        e, p = elastic_motions(self.elements.rows, motions, self.elements.largest)
        found = shares.reactions(self.elements.rows, e, p)
        if self.table.wet.any():
            found[self.table.wet] = self._water(motions, self._times(states) if time is None or not self.rate else time)
        return found

    def _times(self, states: Array) -> Array:
        """Return the times (n,) [s] of states (n, 2) = (u, rotation) from rest at the rate of the elements, or 0."""
        ways = np.hypot(*np.diff(states * self.to_motion, axis=0, prepend=0.0).T).cumsum()
        return ways / self.rate if self.rate else np.zeros(len(ways))

    def _water(self, motions: Array, time: Array) -> Array | float:
        """Return p_water (rows, n) along motions (n, 2) [m], in steps of the largest size; NaN where not known."""
        water = self.elements.shares.water
        if water is None or not len(motions):
            return np.nan
        ways = np.hypot(*np.diff(motions, axis=0, prepend=0.0).T)
        ends = np.ceil(np.maximum(ways / self.elements.largest, 1.0)).cumsum()
        at, last = np.arange(1.0, ends[-1] + 1.0), np.concatenate([[0.0], ends])
        fine = np.stack([np.interp(at, last, np.concatenate([[0.0], column])) for column in motions.T], axis=1)
        e, _ = elastic_motions(self.elements.rows, fine, self.elements.largest)
        found = water.along(e, np.interp(at, last, np.concatenate([[0.0], time])), np.zeros(e.shape[1:]), water.rest)
        return found[:, ends.astype(int) - 1]


def followed(rows: Array, drive: Drive, largest: float, aims: Array) -> tuple[Array, Array, Array]:
    """Follow aims (n, m) of the equations of `drive` from rest in steps up to the largest [m], m = 2 or 5.

    Returns motions and loads (k, m) of the aims that were reached, and the right side (m,) where it ended.
    """
    m, way = aims.shape[1], np.concatenate([np.zeros_like(aims[:1]), aims])
    motions, loads = np.zeros(way.shape), np.zeros(way.shape)
    states = np.zeros((len(rows), SPACE_STATES if m == SPACE else STATES))
    n, at = follow(rows, drive, largest, np.zeros(m), states, way, motions, loads)
    return motions[1:n], loads[1:n], at


def divided_way(targets: Array, motions: Array, largest: float) -> Between:
    """Return targets on the way to targets (n, m), and which of them are those; None where the way needs no more.

    Under loads in proportion a motion is not straight: its parts, to motions (n, m) [m], are of `PART` largest steps.
    """
    parts = np.ceil(np.linalg.norm(np.diff(motions, axis=0, prepend=0.0), axis=1) / (PART * largest)).clip(1.0)
    if (parts == 1.0).all():
        return None
    number = np.repeat(parts, parts.astype(int))
    ends = parts.cumsum().astype(int) - 1
    at = (1.0 / number).cumsum()
    at[ends] = np.arange(1.0, len(parts) + 1.0)
    whole = np.vstack([np.zeros_like(targets[:1]), targets])
    return np.stack([np.interp(at, np.arange(len(whole)), column) for column in whole.T], axis=1), ends


def joined(way: Array, states: Array, ends: Integers) -> Between:
    """Return a way through states (n, m), at its `ends`; None where it did not come to the last one."""
    if len(way) <= ends[-1]:
        return None
    way[ends] = states
    return way, ends


def _each(V: Level, states: Array) -> Array:
    """Return the vertical load (n,) [N] of each state."""
    return np.broadcast_to(np.asarray(V, dtype=float), len(states)).copy()


def error_between_planes(elements: ElementSet, settling: Array) -> tuple[float, float, float]:
    """Return the largest differences of H, M and w at 45 degrees between two planes, over the largest of each way.

    The ways go to half of the reach, back to the other side, and forth again, in seven directions of (u, rotation L).
    Plastic elements have no preferred plane; each plate of the others takes cos(45 deg) of the motion. settling are
    the factors of w (2 elements,) of `Shares.even`.
    """
    rows, growth, half = elements.rows, elements.shares.growth, math.sqrt(0.5)
    plate, largest = np.isin(rows[:, 0], PLATES), np.zeros(3)
    if not plate.any():
        return 0.0, 0.0, 0.0
    for angle in _ANGLES:
        way = elements.reach * _WAY[:, None] * np.array([math.cos(angle), math.sin(angle)])
        e, p = elastic_motions(rows, way, elements.largest)
        answers = [(loads_of(rows, e), even_motions(rows, e, p, growth) @ settling)]
        e[:, plate], p[:, plate] = elastic_motions(rows[plate], half * way, elements.largest)
        e[:, plate], p[:, plate] = e[:, plate] / half, p[:, plate] / half**2  # of two plates together
        answers.append((loads_of(rows, e), even_motions(rows, e, p, growth) @ settling))
        (load, w), (other, moved) = answers
        changes = [*(np.abs(other - load).max(axis=0) / np.abs(load).max()), np.abs(moved - w).max() / _size(w)]
        largest = np.maximum(largest, changes)
    return float(largest[0]), float(largest[1]), float(largest[2])


def _size(values: Array) -> float:
    return max(float(np.abs(values).max()), 1e-300)
