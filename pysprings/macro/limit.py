# SPDX-License-Identifier: MIT
"""The largest load that springs carry within their calibrated range, on the way to a load or displacement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import RANGE_SLACK, FanTable
from pysprings.macro.history import Control

if TYPE_CHECKING:
    from pysprings.macro.curve_table import SpringTable
    from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]

BISECTIONS = 40
# Loads below this share of the other one are what rounding has left of zero.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Limit:
    """Last state within the range of the springs: u [m], rotation [rad], and its loads H [N], M [N m]."""

    u: float
    rotation: float
    H: float
    M: float

    def attributes(self) -> dict[str, float]:
        """Return the limit as attributes of an answer."""
        return {"limit_H_N": self.H, "limit_M_Nm": self.M, "limit_u_m": self.u, "limit_rotation_rad": self.rotation}

    def __str__(self) -> str:
        largest = max(abs(self.H), abs(self.M))
        force, moment = (0.0 if abs(x) < ROUNDING * largest else x for x in (self.H, self.M))
        return (
            f"within their range they carry H = {force:.4g} N with M = {moment:.4g} N m "
            f"(at u = {self.u:.4g} m, rotation = {self.rotation:.4g} rad)"
        )


def paths_at(model: MacroModel, state: Array) -> list[str]:
    """Return the names of the paths that the lateral springs at a state (2,) come from."""
    table = model.table
    if not isinstance(table, FanTable):
        return [model.origin.name]
    place = table.rows(state[None])[1][0]
    low, high, share = int(place[0]), int(place[1]), float(place[2])
    return [name for name, weight in ((table.path[low], 1.0 - share), (table.path[high], share)) if weight > ROUNDING]


def range_used(table: SpringTable | FanTable, states: Array) -> Array:
    """Return the largest displacement of a spring over its range, by state (n, 2); curves kept in part do not count."""
    if isinstance(table, FanTable):
        return table.support(states, table.rows(states)[1])[0]
    whole = ~table.cut
    return (np.abs(table.read(states)[whole]) / table.range[whole, None]).max(axis=0, initial=0.0)


def range_limit(model: MacroModel, control: Control, targets: Array, arm: float, states: Array) -> Limit:
    """Return where the way to the last of some targets (n, 2) leaves the range, by bisection of its last piece.

    states (n-1, 2) are those of the targets before it, all of them within the range.
    """
    origin = np.zeros((1, 2))
    before, state = np.concatenate([origin, targets[:-1]])[-1], np.concatenate([origin, states])[-1]
    last, load = state, model.reactions(*state)[0]
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        aim = before + middle * (targets[-1] - before)
        reached, loads, message = model.solve(control, aim[None], arm, (state, before))
        if not message and range_used(model.table, reached)[0] <= 1.0 + RANGE_SLACK:
            low, last, load = middle, reached[0], loads[0]
        else:
            high = middle
    return Limit(float(last[0]), float(last[1]), float(load[0]), float(load[1]))


FALL = 0.02  # share of its peak by which a curve falls before it counts as softening


def past_peak(table: SpringTable, states: Array) -> tuple[NDArray[np.bool_], list[str]]:
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
