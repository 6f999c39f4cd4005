# SPDX-License-Identifier: MIT
"""What answers: one protocol for rows of springs (`RowSprings`), a fan of rays (`fan_springs`), springs with a memory.

Rows and fans are backbones: (H, M) is a function of the state (u, rotation). With a memory it depends on the whole way
to the state. All else of an answer (vertical loads, ends of paths, marks, words) asks `Response`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.text import with_prefix
from pysprings.macro.curve_table import SpringTable
from pysprings.macro.solver import ROWS, Drive, SpringArrays, follow, reactions, row_values, solve_cases, tangents
from pysprings.macro.ways import Along, Control, Limit, ending, equations, range_limit, turns
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import PathEnd

if TYPE_CHECKING:
    from pysprings.macro.fan import FanTable
    from pysprings.macro.vertical import VerticalTable


Level = float | Array | None  # vertical load [N], one or of each state; None: that of the springs
Between = tuple[Array, Integers] | None  # states (m, 2) on a way, and the places (n,) of those that are asked for
ELASTIC = "the springs are nonlinear elastic: a path that turns back goes back on the same curve, without hysteresis"


@dataclass(frozen=True, slots=True)
class Support:
    """Answers of springs at states, besides the loads: w [m], V [N] by step, p (depth, step), and their support.

    w and V are None where springs do not have them; distance is None where no path is known; water, the part of p that
    pore water carries (side, depth, step), where the springs do not have it; softened where no curve is known to
    soften.
    """

    w: Array | None
    V: Array | None
    p: Array
    usable: NDArray[np.int8]
    used: Array
    distance: Array | None
    off: Marks
    notes: list[str]
    water: Array | None = None
    softened: Marks | None = None


@dataclass(frozen=True, slots=True)
class ElementRows:
    """Elements that keep a state, for programs that step in time: none of a backbone.

    rows : (n, 17) thirteen parameters each (`pysprings.memory.elements`; without a direction: of both planes), and
        factors of w and V [1, N/m]: two of the way, two of the stored part.
    head : largest step [m], radius [m] and largest twist [m] of elements of torsion (0: none), way of the calibration
        [m] (0: w and V are those of the backbone), 1/s of the ways over their sizes, w [m] and V [N] at rest.
    numbers : of a state in two planes.
    sets : number of sets that they are from.
    in_space : whether they were calibrated on paths out of one plane.
    """

    rows: Array = field(default_factory=lambda: np.zeros((0, 17)))
    head: tuple[float, ...] = ()
    numbers: int = 0
    sets: int = 1
    in_space: bool = False

    @property
    def twists(self) -> bool:
        """Whether elements carry torsion."""
        return bool(self.head and self.head[1])


class Response(Protocol):
    """Lateral springs of a caisson, as a table of their backbones, and how they answer.

    table : the backbones as interpolation tables.
    origin : path that gives depths and the state at rest; the first ray of a fan; without states for free curves.
    sources : names of the paths that the springs come from.
    remarks : sentences that go with every answer.
    curves : what the springs are, in words.
    """

    table: SpringTable | FanTable
    origin: SpringPath
    sources: tuple[str, ...]
    remarks: tuple[str, ...]
    curves: ClassVar[str] = "monotonic backbone, odd, last slope beyond the calibrated range"
    law: ClassVar[int] = ROWS

    # --- each kind of springs has its own ---

    def support(self, states: Array, time: Array | None = None, V: Level = None, between: Between = None) -> Support:
        """Return what goes with states (n, 2) = (u, rotation) at times (n,) [s] under V [N], and where it holds.

        between : the way to the states, where springs remember it (`between`).
        """

    def range_used(self, states: Array) -> Array:
        """Return the largest displacement of a spring over its range, by state (n, 2)."""

    def paths_at(self, states: Array) -> list[list[str]]:
        """Return the names of the paths that the springs at each state (n, 2) come from."""

    def range_words(self) -> tuple[str, str]:
        """Return words for where springs end: what reaches beyond, and whose range it is."""

    def beyond(self, failed: list[PathEnd], states: Array, over: Marks) -> Iterator[tuple[PathEnd, Marks]]:
        """Yield ends of paths that failed, and the states beyond the range of each, of those `over` their range."""

    def farthest(self) -> float:
        """Return a motion [m] that leaves the range of the springs in most directions."""

    def provenance(self) -> dict[str, Any]:
        """Return attributes on the paths that the springs come from."""

    def sequence_remarks(self, V: Level = None) -> tuple[str, ...]:
        """Return sentences that go with sequences under V (n,) [N]."""
        return (ELASTIC,)

    def lasting(self, marks: Marks) -> Marks:
        """Return marks by state (n,) along a way, with the later states that what they mark bears on; here none."""
        return marks

    # --- a backbone ---

    @cached_property
    def arrays(self) -> SpringArrays:
        """The backbones as the solver reads them."""
        return SpringArrays(self.law, *self.table.solver_arrays)

    @property
    def rest(self) -> tuple[float, float]:
        """w [m] and V [N] of the springs at rest."""
        return float(self.origin.w[0]), self.origin.load

    @property
    def element_rows(self) -> ElementRows:
        """Elements that keep a state."""
        return ElementRows()

    def plane_notes(self) -> list[str]:
        """Return sentences on motions out of one plane, for programs that step in time."""
        return ["out of one plane of motion: the secant stiffness at the size of the whole motion, an assumption"]

    def solve(self, control: Control, targets: Array, arm: float = 0.0, V: Level = None) -> tuple[Array, Array, str]:
        """Follow the equilibrium through targets: see `pysprings.macro.model.MacroModel.solve`."""
        return self.go_on(control, targets, arm, (np.zeros(2), np.zeros(2)))

    def go_on(
        self, control: Control, targets: Array, arm: float, start: tuple[Array, Array]
    ) -> tuple[Array, Array, str]:
        """Follow the equilibrium of the backbone as `solve`, from a state (u, rotation) and its target."""
        state, first = start
        way = np.concatenate([[first], np.asarray(targets, dtype=float)])
        drive, aims = equations(control, way, arm, self.table.load_scale)
        out = np.zeros((2, *aims.shape))
        with np.errstate(all="ignore"):  # an iterate that runs away is given up, with or without Numba
            n, at0, at1 = follow(self.arrays, drive, state, aims, out[0], out[1])
        states, loads = out[0, 1:n], out[1, 1:n]
        message = "" if n == len(aims) else ending(control, (at0, at1), aims[n], states, loads)
        return states, loads, message + LOOSE * bool(message and not states.any() and self._is_loose)

    @property
    def _is_loose(self) -> bool:
        """Whether the springs leave the caisson at rest a motion that they do not resist."""
        K = self.loads_at(0.0, 0.0)[1] / np.outer([1.0, self.origin.length], [1.0, self.origin.length])
        return bool(np.linalg.matrix_rank(K, tol=1e-12 * np.abs(K).max(initial=1e-300)) < len(K))

    def solve_cases(self, loads: Array) -> tuple[Array, Array, NDArray[np.int8]]:
        """Return states, loads (n, 2) and a mark reached (n,) of independent loads (H, M), each from the origin."""
        return cases(self.arrays, *equations("load", np.asarray(loads, dtype=float), 0.0, self.table.load_scale))

    def loads_at(self, u: float, rotation: float) -> tuple[Array, Array]:
        """Return the loads (H [N], M [N m]) of the backbone at a state, and their tangent (2, 2) to (u, rotation)."""
        force, tangent = np.zeros(2), np.zeros((2, 2))
        reactions(self.arrays, float(u), float(rotation), force, tangent)
        return force, tangent

    def tangents(self, states: Array, V: Level = None) -> Array:
        """Return the tangents (n, 2, 2) to (u, rotation) at states (n, 2), or along them from rest under V [N]."""
        out = np.zeros((len(states), 2, 2))
        tangents(self.arrays, np.ascontiguousarray(states, dtype=float), out)
        return out

    def deviations(self, control: Control, states: Array, tangents: Array, arm: float) -> Iterator[tuple[str, Array]]:
        """Yield the standard deviations of an answer by name; none but of springs of an atlas."""
        yield from ()

    def widening(self, states: Array, loads: Array, utilisation: Array) -> Array | None:
        """Return what deviations of motions are multiplied with near the largest load; None but of an atlas."""
        return None

    def along(self, control: Control, targets: Array, arm: float, states: Array, V: Level, rest: float) -> Along:
        """Return what is to be marked along a way to targets (n, 2) that came to states (k, 2), from V at rest [N]."""

        def limit(first: int) -> Limit:
            return range_limit(self, control, targets[: first + 1], arm, states[:first])

        aim = targets[len(states)] if control == "load" and len(states) < len(targets) else None
        return Along(aim, turns(control, targets[: len(states)], self.origin.length, V, rest), limit)

    def between(self, control: Control, targets: Array, arm: float, states: Array, V: Level) -> Between:
        """Return states on the way to states (n, 2), which of them are those; None: straight, or of no consequence."""
        return None

    def check_state(self, asked: Literal["cases", "secant"]) -> None:
        """Raise UserInputError where independent cases, or the secant of a state, have no answer of these springs."""
        return None

    # --- a backbone under a vertical load ---

    def follows(self, V: Level) -> bool:
        """Return whether the springs follow vertical loads (n,) [N] that are not their own."""
        return False

    def lacks(self, V: Array, other: Marks) -> Marks:
        """Return which states under V (n,) [N] the springs do not cover, where `other` (n,) are not at their V."""
        return other

    def lacks_notes(self, V: Array, lacking: Marks) -> list[str]:
        """Return a sentence on states that lack springs at their V (n,) [N]."""
        return [other_load(self.origin, V[lacking]) + "lateral springs unchanged"] if lacking.any() else []

    def settle(self, vertical: VerticalTable, V: Array) -> Array:
        """Return w [m], tangent, range used, the last one of V alone, (3 or 4, n), of vertical springs under V [N]."""
        return vertical.displacements(V)

    def settled(self, vertical: VerticalTable | None, V: Level, between: float) -> float:
        """Return what w [m] of the lateral springs at rest lacks to that of the vertical ones, at the V of their start.

        between: that of springs between two vertical loads.
        """
        return between


def cases(arrays: SpringArrays, drive: Drive, aims: Array) -> tuple[Array, Array, NDArray[np.int8]]:
    """Return states, loads (n, 2) and a mark reached (n,) of independent right sides c (n, 2), each from the origin."""
    states, loads, reached = np.zeros(aims.shape), np.zeros(aims.shape), np.zeros(len(aims), dtype=np.int8)
    solve_cases(arrays, drive, np.ascontiguousarray(aims), states, loads, reached)
    return states, loads, reached


def other_load(origin: SpringPath, V: Array) -> str:
    """Return words for vertical loads [N] that are not that of a path."""
    return f"V = {list_of(V)} is not that of path '{origin.name}' ({with_prefix(origin.load, 'N', 6)}): "


def list_of(V: Array) -> str:
    """Return the first three of different loads [N] in words."""
    values = np.unique(V)
    return ", ".join(with_prefix(value, "N", 6) for value in values[:3]) + (" ..." if values.size > 3 else "")


LOOSE = "; at rest a motion meets no resistance: springs of one depth leave a turn free, and flat curves hold nothing"
# States farther than this from the calibration path, relative to their size, are marked off_path.
OFF_PATH = 0.10
FALL = 0.02  # share of its peak by which a curve falls before it counts as softening


@dataclass(frozen=True, eq=False)
class RowSprings(Response):
    """Springs of one path as rows (`pysprings.macro.curve_table`); the attributes are those of `Response`."""

    table: SpringTable
    origin: SpringPath
    sources: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def support(self, states: Array, time: Array | None = None, V: Level = None, between: Between = None) -> Support:
        """Return what goes with states (n, 2), and how far they are from the path: see `Response`."""
        used, p, usable = self.range_used(states), self._lateral(states), self._usable()
        if "u" not in self.origin:
            softened, notes = past_peak(self.table, states)
            return Support(None, None, p, usable, used, None, np.zeros(used.size, dtype=bool), notes, softened=softened)
        distance = _distance(self._track, states * [1.0, self.origin.length])
        off = distance > OFF_PATH
        return Support(*self._vertical(*states.T), p, usable, used, distance, off, self._notes(distance, off))

    def range_used(self, states: Array) -> Array:
        """Return the largest displacement over its range, by state (n, 2)."""
        counted = self._counted
        return (np.abs(self.table.read(states)[counted]) / self.table.range[counted, None]).max(axis=0, initial=0.0)

    @cached_property
    def _counted(self) -> Marks:
        """Rows whose range counts: not curves kept in part, but where all are, as of a swipe."""
        whole = ~self.table.cut
        return whole if whole.any() else np.ones_like(whole)

    def paths_at(self, states: Array) -> list[list[str]]:
        """Return the names of the paths that the springs come from, by state."""
        return [list(self._names)] * len(states)

    @property
    def _names(self) -> tuple[str, ...]:
        return self.sources or (self.origin.name,)

    def range_words(self) -> tuple[str, str]:
        """Return words for where springs end."""
        names = " and ".join(f"'{name}'" for name in self._names)
        return f"path{'s' * (len(self._names) > 1)} {names}: springs reach", "their"

    def beyond(self, failed: list[PathEnd], _states: Array, over: Marks) -> Iterator[tuple[PathEnd, Marks]]:
        """Yield the ends of paths that failed, and the states beyond the range: see `Response`."""
        yield from ((end, over) for end in failed)

    def farthest(self) -> float:
        """Return a motion [m] that leaves the range of the springs in most directions."""
        lengths = np.where(self.table.a[:, 0] == 0.0, self.origin.length, 1.0)
        return 2.0 * float((self.table.range * lengths)[self._counted].max(initial=1e-3))

    def provenance(self) -> dict[str, Any]:
        """Return attributes on the path that the springs come from."""
        arm, table = self.origin.arm, self.table
        return ({"calibration_arm_m": arm} if np.isfinite(arm) else {}) | {
            "path": self.origin.name,
            "kind": self.origin.kind,
            "n_other_carrier": int((~table.natural).sum()),
            "n_cut": int(table.cut.sum()),
        }

    @cached_property
    def _track(self) -> Array:
        """States (u, rotation*L) [m] of the path, as far as springs keep it: up to where it turns."""
        kept = int(self.table.count[self._counted].max(initial=0)) or None  # without springs all of it
        return np.stack([self.origin.u, self.origin.turn], axis=1)[:kept]

    def _lateral(self, states: Array) -> Array:
        """Return the net p (depth, step) [N/m] that the springs give; 0 where the set has no spring at that depth."""
        t, depth = self.table, self.origin.depth
        rows = np.flatnonzero((np.array(t.name) == "p") & np.isin(t.depth, depth))
        p = np.zeros((depth.size, len(states)))
        p[np.searchsorted(depth, t.depth[rows])] = row_values(
            t.q[rows], t.r[rows], t.slope[rows], t.count[rows], t.read(states)[rows]
        )
        return p

    def _usable(self) -> NDArray[np.int8]:
        """Return 1 at depths whose p is read from y over the whole path, else 0."""
        own = (np.array(self.table.name) == "p") & self.table.natural & ~self.table.cut
        return np.isin(self.origin.depth, self.table.depth[own]).astype(np.int8)

    def _vertical(self, u: Array, rotation: Array) -> tuple[Array | None, Array | None]:
        """Return w [m] and V [N] by step: functions of |u|, or of |rotation| where that moves more, flat beyond."""
        if "w" not in self.origin or "V" not in self.origin:
            return None, None
        track = np.abs(self._track)
        lead = int(np.argmax(track[-1] * [1.0, 0.999]))
        motion = np.abs(u) if lead == 0 else np.abs(rotation) * self.origin.length
        grows = np.maximum.accumulate(track[:, lead])
        w, V = (np.interp(motion, grows, each[: grows.size]) for each in (self.origin.w, self.origin["V"]))
        return w, V

    def _notes(self, distance: Array, off: Marks) -> list[str]:
        """Return a sentence on states that are far from the one path the springs come from."""
        arm = self.origin.arm
        height = f" (load height {arm:g} m)" if np.isfinite(arm) else ""
        text = (
            f"{off.sum()} of {off.size} states are off the path '{self.origin.name}'{height} "
            f"they come from, by up to {distance.max(initial=0.0):.0%} (limit {OFF_PATH:.0%}): "
            "springs do not transfer between load paths, check against the full model"
        )
        return [text] if off.any() else []


def _distance(track: Array, states: Array) -> Array:
    """Return the distance of states (n, 2) from a polyline or its mirror image, over their size; last piece open."""
    start, piece = track[:-1], np.diff(track, axis=0)
    length2 = np.maximum((piece**2).sum(axis=1), 1e-300)
    ahead = np.append(np.ones(len(piece) - 1), np.inf)
    shortest = np.full(len(states), np.inf)
    for sign in (1.0, -1.0):
        offset = sign * states[:, None, :] - start
        along = np.clip((offset * piece).sum(axis=2) / length2, 0.0, ahead)
        gap = offset - along[:, :, None] * piece
        shortest = np.minimum(shortest, (gap**2).sum(axis=2).min(axis=1))
    size = (states**2).sum(axis=1)
    return np.sqrt(shortest / np.where(size > 0.0, size, np.inf))


def past_peak(table: SpringTable, states: Array) -> tuple[Marks, list[str]]:
    """Return which states (n, 2) have a spring beyond the peak of a curve that softens, and a sentence on them."""
    known = np.arange(table.q.shape[1]) < table.count[:, None]
    size = np.where(known, np.abs(table.r), 0.0)
    rows, at = np.arange(len(size)), size.argmax(axis=1)
    peak, peak_at = size[rows, at], table.q[rows, at]
    behind = known & (np.arange(table.q.shape[1]) >= at[:, None])
    lowest = np.where(behind, size, np.inf).min(axis=1)
    soft = lowest < (1.0 - FALL) * peak
    past = soft & (np.abs(table.read(states).T) > peak_at)
    marks: Marks = past.any(axis=1)
    if not marks.any():
        return marks, []
    row = int(np.flatnonzero(past.any(axis=0))[0])
    name = str(table.name[row])
    unit = {"p": "N/m", "m": "N m/m"}.get(name, "N m" if name.startswith("M") else "N")
    high, low = (with_prefix(float(each[row]), unit) for each in (peak, lowest))
    place = f"{name} at {table.depth[row]:g} m falls from {high} to {low}"
    return marks, [
        f"{marks.sum()} of {len(states)} states are beyond the peak of a curve that softens ({place}): "
        "the equilibrium found there is one of several, and under a load it may not be stable"
    ]
