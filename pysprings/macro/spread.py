# SPDX-License-Identifier: MIT
"""Standard deviations of answers on springs of an atlas.

Every mode of the springs adds loads dF(u, rotation) of its own. Under given loads it moves the caisson by
-K^-1 dF, K the tangent of the springs (2, 2); where u or the rotation is given with the height of the load, it changes
the load and the other motion; where both are given, it changes the loads. Modes are independent: their squares add.
What straight rays do not say of the rotation of a pull counts in addition. Near the
largest load the motion grows faster than along the tangent (`widening`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.macro.fan import FanTable, secant_slopes
from pysprings.macro.history import Control
from pysprings.macro.solver import fan_rows
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]
_ROUNDING = 1e-6
BAND = 1.96  # deviations within which an answer is meant to lie
NAMES = ("u_deviation", "rotation_deviation", "H_deviation", "M_deviation")


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
        rows, _ = fan_rows(table.angle, table.rho, self.r, self.slope, table.count, odd, *table.polar(states))
        return np.ascontiguousarray(rows.T).reshape(len(states), 2, -1)


def build_spread(springs: Springs, table: FanTable) -> Spread | None:
    """Return the modes of springs on the rays of their fan; None for springs that have none.

    Raises UserInputError where their motions are not those of the paths.
    """
    data = springs.spread
    if data is None:
        return None
    rho, names = data["rho"].values, [str(name) for name in data["ray"].values]
    if set(table.path) - set(names) or table.range.max() > rho[-1] * (1.0 + _ROUNDING):
        raise refused("atlas/rho", "the standard deviations do not belong to the paths of the file")
    modes = np.concatenate([data[f"{load}_mode"].values for load in ("H", "M")])
    r, slope = np.zeros((2, len(modes), *table.rho.shape))
    for k, (name, count) in enumerate(zip(table.path, table.count, strict=True)):
        knots = table.rho[k, :count]
        own = np.stack([np.interp(knots, rho, mode) for mode in modes[:, names.index(name)]])
        r[:, k, :count], slope[:, k, :count] = own, secant_slopes(knots, own, own[:, 1] / knots[1])
    return Spread(r, slope, rho, data["turn"].values)


def deviations(spread: Spread, table: FanTable, control: Control, states: Array, tangents: Array, arm: float) -> Array:
    """Return standard deviations (n, 4) of u, rotation, H, M (`NAMES`) of states (n, 2) with tangents (n, 2, 2)."""
    added = spread.loads(table, states)
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
        turn = np.interp(table.polar(states)[0], spread.rho, spread.turn)
        answer[:, 1] = np.hypot(answer[:, 1], turn * states[:, 1])
    return answer


def widening(spread: Spread, table: FanTable, states: Array, loads: Array, utilisation: Array) -> Array:
    """Return what the deviations of motions (n, 2) under loads (n, 2) are multiplied with, for `BAND` of the load.

    Near the largest load, of which the loads are shares `utilisation` a (n,), the motion grows as that of a hyperbola,
    a/(1 - a), and not along its tangent. The largest load has the share d of `BAND` deviations that the last motion of
    the springs has in the same direction: (1 - a)/(1 - a (1 + d)), infinite where that load less d is below the load.
    """
    far = states * (spread.rho[-1] / np.maximum(table.polar(states)[0], _ROUNDING * spread.rho[-1]))[:, None]
    plane = loads / [1.0, table.length]
    along = np.einsum("nkm,nk->nm", spread.loads(table, far) / np.array([[1.0], [table.length]]), plane)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = BAND * utilisation * np.sqrt((along**2).sum(axis=1)) / (plane**2).sum(axis=1)
        left = 1.0 - utilisation * (1.0 + share)
        return np.where(np.isfinite(left), np.where(left > 0.0, (1.0 - utilisation) / left, np.inf), 1.0)


def _solved(matrix: Array, right: Array) -> Array:
    """Return the solutions of systems (n, 2, 2); infinite where one is singular."""
    determinant = matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0]
    with np.errstate(all="ignore"):
        adjugate = np.empty_like(matrix)
        adjugate[:, 0, 0], adjugate[:, 1, 1] = matrix[:, 1, 1], matrix[:, 0, 0]
        adjugate[:, 0, 1], adjugate[:, 1, 0] = -matrix[:, 0, 1], -matrix[:, 1, 0]
        return np.asarray(adjugate @ right / determinant[:, None, None])
