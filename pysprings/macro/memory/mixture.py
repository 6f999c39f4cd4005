# SPDX-License-Identifier: MIT
"""Sets of elements together: at a vertical load or a rate that lies between those with rays that turn back.

Each set follows the whole motion and carries a share of its loads,

    F = sum_i s_i F_i(q),   s_i >= 0,   sum_i s_i = 1,

as a fan is interpolated: linear in V, or in the logarithm of the rate (`pysprings.springs.between`,
`pysprings.springs.between`). This is a set of elements in parallel like each of them: no closed way gives work.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.memory.calibration import ElementSet
from pysprings.macro.memory.elements import PLATES
from pysprings.macro.memory.shares import Shares, stiffnesses
from pysprings.macro.memory.water import Water

Array = NDArray[np.float64]


def mixed(parts: Sequence[tuple[ElementSet, float]]) -> ElementSet:
    """Return one set that carries the loads and reactions of sets, each times its share."""
    parts = [(each, share) for each, share in parts if share > 0.0]
    if len(parts) == 1:
        return parts[0][0]
    sets = [each for each, _ in parts]
    errors = {name: error for each in sets for name, error in each.errors.items()}
    rows = np.concatenate([scaled(each.rows, share) for each, share in parts])
    reach, way = (min(getattr(each, name) for each in sets) for name in ("reach", "way"))
    return ElementSet(rows, reach, _shares(parts), max(each.residual for each in sets), errors, way)


def shares_at(V: Array, loads: Array) -> Array:
    """Return the shares (n, k) at vertical loads V (n,) [N] of sets at loads (k,); beyond them that of the nearest."""
    return np.stack([np.interp(V, loads, row) for row in np.eye(len(loads))], axis=-1)


def scaled(rows: Array, share: float) -> Array:
    """Return elements (n, COLUMNS) that carry a share of what these do."""
    out, plate = rows.copy(), np.isin(rows[:, 0], PLATES)
    out[plate, 6] *= share
    out[~plate, 4:7] *= share
    return out


def _shares(parts: Sequence[tuple[ElementSet, float]]) -> Shares:
    """Return the shares of the reactions of sets together.

    R = sum s_i (S_i F_i + D_i e_i) with one S = sum s_i S_i for all: what is missing, s_i (S_i - S) F_i, goes into D.
    """
    S = sum(share * each.shares.loads for each, share in parts)
    elastic, ways, stored, growth = [], [], [], []
    for each, share in parts:
        own, n = each.shares, len(each.rows)
        missing = np.einsum("ra,kab->rkb", own.loads - S, stiffnesses(each.rows))
        elastic.append(share * (own.elastic + missing.reshape(len(missing), 2 * n)))
        ways.append(share * own.even[:, :n])
        stored.append(share * own.even[:, n:])
        growth.append(np.broadcast_to(own.growth, n))
    first = parts[0][0].shares
    rest = sum(share * each.shares.rest for each, share in parts)
    even = np.concatenate([*ways, *stored], axis=1)
    water = _water([(each.shares.water, share) for each, share in parts if each.shares.water])
    return Shares(first.odd, np.asarray(rest), np.asarray(S), np.hstack(elastic), even, np.concatenate(growth), water)


def _water(parts: Sequence[tuple[Water, float]]) -> Water | None:
    """Return the water of sets together, each with its own elements and times; None where they have none."""
    if not parts:
        return None
    factors = np.concatenate([share * each.factors for each, share in parts], axis=2)
    return Water(factors, np.concatenate([each.times for each, _ in parts], axis=1))
