# SPDX-License-Identifier: MIT
"""A fan of rays: what it answers, where it holds, and the standard deviations of springs of an atlas.

Every mode of springs of an atlas adds loads dF(u, rotation) of its own. Under given loads it moves the caisson by
-K^-1 dF, K the tangent of the springs (2, 2); where u or the rotation is given with the height of the load, it changes
the load and the other motion; where both are given, it changes the loads. Modes are independent: their squares add.
What straight rays do not say of the rotation of a pull counts in addition. Near the largest load the motion grows
faster than along the tangent (`Spread.widening`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import refused
from pysprings.macro.fan import WIDEST, FanTable
from pysprings.macro.response import Between, Level, Response, Support
from pysprings.macro.solver import FAN, fan_rows
from pysprings.macro.ways import RANGE_SLACK, ROUNDING, Control
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import PathEnd
from pysprings.springs.springs import Springs
from pysprings.springs.sums import secant_slopes

_KNOTS = 1e-6  # share by which motions of modes may end before those of the paths (rounding)
BAND = 1.96  # deviations within which an answer is meant to lie
DEVIATIONS = ("u_deviation", "rotation_deviation", "H_deviation", "M_deviation")


@dataclass(frozen=True, eq=False)
class FanSprings(Response):
    """Springs between rays (`pysprings.macro.fan`); the attributes are those of `Response`.

    spread : standard deviation of springs of an atlas; None of all others.
    """

    table: FanTable
    origin: SpringPath
    sources: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    spread: Spread | None = None
    law: ClassVar[int] = FAN

    def reactions(self, states: Array, time: Array | None = None, V: Level = None, between: Between = None) -> Array:
        """Return all reactions (rows, n) at states (n, 2), or along them from rest at times (n,) [s] under V [N]."""
        return self.table.rows(states)

    def support(self, states: Array, time: Array | None = None, V: Level = None, between: Between = None) -> Support:
        """Return what goes with states (n, 2), and the angle to the rays: see `Response`."""
        table, rows = self.table, self.reactions(states, time, V, between)
        used, sector, nearest = table.support(states)
        off = (sector > WIDEST + RANGE_SLACK) & (states != 0.0).any(axis=1)
        usable = np.ones(self.origin.depth.size, dtype=np.int8)
        (w,), (V_,), p = (rows[table.name == name] for name in ("w", "V", "p"))
        water = rows[table.wet].reshape(-1, *p.shape) if table.wet.any() else None
        return Support(w, V_, p, usable, used, np.sin(nearest), off, sector_notes(sector, off), water)

    def range_used(self, states: Array) -> Array:
        """Return rho over that of the rays beside, by state (n, 2)."""
        return self.table.support(states)[0]

    def paths_at(self, states: Array) -> list[list[str]]:
        """Return the names of the rays beside each state (n, 2)."""
        path = self.table.path
        return [
            [name for name, weight in ((path[low], 1.0 - share), (path[high], share)) if weight > ROUNDING]
            for low, high, share in zip(*(each.tolist() for each in self.table.beside(states)), strict=True)
        ]

    def range_words(self) -> tuple[str, str]:
        """Return words for where springs end."""
        return f"the fan of {len(self.table.path)} paths: they reach", "the"

    def beyond(self, failed: list[PathEnd], states: Array, _over: Marks) -> Iterator[tuple[PathEnd, Marks]]:
        """Yield the ends of rays that failed, and the states beside each beyond its range: see `Response`."""
        table = self.table
        rho, sector, (low, high, place) = table.polar(states)[0], table.support(states)[1], table.beside(states)
        for end in failed:
            ray = table.path.index(end.path)
            beside = (low == ray) & ((sector > 0.0) | (place < 0.5)) | (high == ray) & ((sector > 0.0) | (place >= 0.5))
            yield end, beside & (rho > table.range[ray] * (1.0 + RANGE_SLACK))

    def farthest(self) -> float:
        """Return a motion [m] that leaves the range of the springs in most directions."""
        return float(self.table.range.max()) * (1.0 + 1e-3)

    def provenance(self) -> dict[str, Any]:
        """Return attributes on the rays."""
        rays = zip(self.table.path, np.degrees(self.table.angle), strict=True)
        text = ", ".join(f"{name} ({angle:.1f} deg)" for name, angle in rays)
        return {"path": f"{len(self.table.path)} paths", "rays": text}

    def deviations(self, control: Control, states: Array, tangents: Array, arm: float) -> Iterator[tuple[str, Array]]:
        """Yield the standard deviations of u, rotation, H, M of states (n, 2) with tangents (n, 2, 2), by name."""
        if self.spread is not None:
            found = self.spread.deviations(self.table, control, states, tangents, arm)
            yield from zip(DEVIATIONS, found.T, strict=True)

    def widening(self, states: Array, loads: Array, utilisation: Array) -> Array | None:
        """Return what deviations of motions are multiplied with near the largest load: see `Spread.widening`."""
        return None if self.spread is None else self.spread.widening(self.table, states, loads, utilisation)


def sector_notes(sector: Array, off: Marks) -> list[str]:
    """Return a sentence on states between rays too far apart."""
    text = (
        f"{off.sum()} of {off.size} states are between calibration paths {np.degrees(sector.max(initial=0.0)):.3g} "
        f"degrees apart in (u, rotation*skirt_length) (limit {np.degrees(WIDEST):.3g}): add a path between them"
    )
    return [text] if off.any() else []


@dataclass(frozen=True, slots=True)
class Spread:
    """Modes of springs on the rays of their fan: r, slope (2 m, ray, knot), H of all modes before M of all.

    turn : (knot,) standard deviation over the rotation under a load, at motions rho (knot,) [m].
    """

    r: Array
    slope: Array
    rho: Array
    turn: Array

    def loads(self, table: FanTable, states: Array) -> Array:
        """Return the loads (n, 2, m) that the modes add at states (n, 2) = (u, rotation)."""
        odd = np.zeros(len(self.r), dtype=bool)
        rows: Array = fan_rows(table.angle, table.rho, self.r, self.slope, table.count, odd, *table.polar(states))
        return np.ascontiguousarray(rows.T).reshape(len(states), 2, -1)

    def deviations(self, table: FanTable, control: Control, states: Array, tangents: Array, arm: float) -> Array:
        """Return those of u, rotation, H, M (n, 4), `DEVIATIONS`, of states (n, 2) with tangents (n, 2, 2)."""
        added = self.loads(table, states)
        changes = np.zeros((len(states), 4, added.shape[2]))
        if control == "state":
            changes[:, 2:] = added
        elif control == "load":
            changes[:, :2] = -_solved(tangents, added)
        else:
            free = 1 if control == "displacement" else 0
            # K[:, free] d(free) + dF = dH (1, arm): unknown are d(free) and dH
            matrix = np.stack([tangents[:, :, free], np.broadcast_to([-1.0, -arm], (len(states), 2))], axis=2)
            found = -_solved(matrix, added)
            changes[:, free], changes[:, 2], changes[:, 3] = found[:, 0], found[:, 1], arm * found[:, 1]
        answer = np.sqrt((changes**2).sum(axis=2))
        if control in ("load", "displacement"):
            turn = np.interp(table.polar(states)[0], self.rho, self.turn)
            answer[:, 1] = np.hypot(answer[:, 1], turn * states[:, 1])
        return answer

    def widening(self, table: FanTable, states: Array, loads: Array, utilisation: Array) -> Array:
        """Return what the deviations of motions (n, 2) under loads (n, 2) are multiplied with, for `BAND` of the load.

        Near the largest load, of which the loads are shares `utilisation` a (n,), the motion grows as that of a
        hyperbola, a/(1 - a), and not along its tangent. The largest load has the share d of `BAND` deviations that the
        last motion of the springs has in the same direction: (1 - a)/(1 - a (1 + d)), infinite where that load less d
        is below the load.
        """
        far = states * (self.rho[-1] / np.maximum(table.polar(states)[0], _KNOTS * self.rho[-1]))[:, None]
        plane = loads / [1.0, table.length]
        along = np.einsum("nkm,nk->nm", self.loads(table, far) / np.array([[1.0], [table.length]]), plane)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = BAND * utilisation * np.sqrt((along**2).sum(axis=1)) / (plane**2).sum(axis=1)
            left = 1.0 - utilisation * (1.0 + share)
            return np.where(np.isfinite(left), np.where(left > 0.0, (1.0 - utilisation) / left, np.inf), 1.0)


def build_spread(springs: Springs, table: FanTable) -> Spread | None:
    """Return the modes of springs on the rays of their fan; None for springs that have none.

    Raises UserInputError where their motions are not those of the paths.
    """
    data = springs.spread
    if data is None:
        return None
    rho, names = data["rho"].values, [str(name) for name in data["ray"].values]
    if set(table.path) - set(names) or table.range.max() > rho[-1] * (1.0 + _KNOTS):
        raise refused("atlas/rho", "the standard deviations do not belong to the paths of the file")
    modes = np.concatenate([data[f"{load}_mode"].values for load in ("H", "M")])
    r, slope = np.zeros((2, len(modes), *table.rho.shape))
    for k, (name, count) in enumerate(zip(table.path, table.count, strict=True)):
        knots = table.rho[k, :count]
        own = np.stack([np.interp(knots, rho, mode) for mode in modes[:, names.index(name)]])
        r[:, k, :count], slope[:, k, :count] = own, secant_slopes(knots, own, own[:, 1] / knots[1])
    return Spread(r, slope, rho, data["turn"].values)


def _solved(matrix: Array, right: Array) -> Array:
    """Return the solutions of systems (n, 2, 2); infinite where one is singular."""
    determinant = matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0]
    with np.errstate(all="ignore"):
        adjugate = np.empty_like(matrix)
        adjugate[:, 0, 0], adjugate[:, 1, 1] = matrix[:, 1, 1], matrix[:, 0, 0]
        adjugate[:, 0, 1], adjugate[:, 1, 0] = -matrix[:, 0, 1], -matrix[:, 1, 0]
        return np.asarray(adjugate @ right / determinant[:, None, None])
