# SPDX-License-Identifier: MIT
"""Springs of one path, or of two pure ones, as rows: what they answer, and where they hold."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.curve_table import SpringTable
from pysprings.macro.response import Response, Support
from pysprings.macro.solver import row_values
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import PathEnd

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]

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

    def support(self, states: Array, time: Array | None = None, V: float | Array | None = None) -> Support:
        """Return what goes with states (n, 2), and how far they are from the path: see `Response`."""
        used, p, usable = self.range_used(states), self._lateral(states), self._usable()
        if "u" not in self.origin:
            softened, notes = past_peak(self.table, states)
            return Support(None, None, p, usable, used, None, np.zeros(used.size, dtype=bool), notes, softened=softened)
        distance = _distance(self._track, states * [1.0, self.origin.length])
        off = distance > OFF_PATH
        return Support(*self._vertical(*states.T), p, usable, used, distance, off, self._notes(distance, off))

    def range_used(self, states: Array) -> Array:
        """Return the largest displacement over its range, by state (n, 2); curves kept in part do not count."""
        whole = ~self.table.cut
        return (np.abs(self.table.read(states)[whole]) / self.table.range[whole, None]).max(axis=0, initial=0.0)

    def paths_at(self, states: Array) -> list[list[str]]:
        """Return the name of the one path, by state."""
        return [[self.origin.name]] * len(states)

    def range_words(self) -> tuple[str, str]:
        """Return words for where springs end."""
        return f"path '{self.origin.name}': springs reach", "their"

    def beyond(self, failed: list[PathEnd], _states: Array, over: Marks) -> Iterator[tuple[PathEnd, Marks]]:
        """Yield the ends of paths that failed, and the states beyond the range: see `Response`."""
        yield from ((end, over) for end in failed)

    def farthest(self) -> float:
        """Return a motion [m] that leaves the range of the springs in most directions."""
        lengths = np.where(self.table.a[:, 0] == 0.0, self.origin.length, 1.0)
        return 2.0 * float((self.table.range * lengths)[~self.table.cut].max(initial=1e-3))

    def provenance(self) -> dict[str, Any]:
        """Return attributes on the path that the springs come from."""
        arm, table = float(self.origin.attrs.get("arm_m", np.nan)), self.table
        return ({"calibration_arm_m": arm} if np.isfinite(arm) else {}) | {
            "path": self.origin.name,
            "kind": self.origin.kind,
            "n_other_carrier": int((~table.natural).sum()),
            "n_cut": int(table.cut.sum()),
        }

    @cached_property
    def _track(self) -> Array:
        """States (u, rotation*L) [m] of the path."""
        return np.stack([self.origin.u, self.origin.turn], axis=1)

    def _lateral(self, states: Array) -> Array:
        """Return the net p (depth, step) [N/m] that the springs give; 0 where the set has no spring."""
        t, depth = self.table, self.origin.depth
        rows = np.flatnonzero(np.array(t.name) == "p")
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
        return np.interp(motion, grows, self.origin.w), np.interp(motion, grows, self.origin["V"])

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
    marks: NDArray[np.bool_] = past.any(axis=1)
    if not marks.any():
        return marks, []
    row = int(np.flatnonzero(past.any(axis=0))[0])
    place = f"{table.name[row]} at {table.depth[row]:g} m falls from {peak[row]:.4g} to {lowest[row]:.4g}"
    return marks, [
        f"{marks.sum()} of {len(states)} states are beyond the peak of a curve that softens ({place}): "
        "the equilibrium found there is one of several, and under a load it may not be stable"
    ]
