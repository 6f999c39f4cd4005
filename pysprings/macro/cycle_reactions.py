# SPDX-License-Identifier: MIT
"""Errors of the reactions of springs along a sequence of the full model: by family, and of p by depth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.macro.cycles import Followed
from pysprings.macro.fan import WATER, FanTable, reaction_rows

Array = NDArray[np.float64]

_FAMILIES = ("p", "m", "t", "H_tip", "M_tip", "H_lid", "M_lid", "V_tip", "V_lid", "w", WATER)
_VERTICAL = ("t", "V_tip", "V_lid", "w")


def reaction_errors(one: Followed) -> dict[str, Any]:
    """Return the largest error [%] of each family of reactions, and of w, over the largest value of the full model.

    The springs are at their own motion where the path was driven by loads. All are changes from the start of the path.
    NaN for vertical reactions and w where V changes on the way: what V itself does is not in the lateral springs.
    The water's part of p is there where the springs have it apart.
    """
    table, full, macro = _reactions(one)
    changes = one.V is not None and np.ptp(one.V) > 0.0
    row: dict[str, Any] = {"path": one.path.name, "role": one.path.role, "springs": one.springs}
    for name in (name for name in _FAMILIES if name in table.name):
        own = table.name == name
        size = float(np.abs(full[own]).max(initial=0.0))
        worst = float(np.abs(macro[own] - full[own]).max(initial=0.0))
        row[f"{name}_error_pct"] = np.nan if not size or (changes and name in _VERTICAL) else 100.0 * worst / size
    return row


def by_depth(one: Followed) -> pd.DataFrame:
    """Return a row a depth: largest p of the full model [N/m], and error of p [%] over the largest at any depth."""
    table, full, macro = _reactions(one)
    own = table.name == "p"
    peak, size = np.abs(full[own]).max(axis=1), float(np.abs(full[own]).max())
    error = np.abs(macro[own] - full[own]).max(axis=1)
    values = {"depth_m": table.depth[own], "p_full_N_per_m": peak, "p_error_pct": 100.0 * error / (size or np.nan)}
    return pd.DataFrame({"path": one.path.name, "springs": one.springs} | values)


def _reactions(one: Followed) -> tuple[FanTable, Array, Array]:
    """Return the layout of the reactions, and those of the full model and of the springs (rows, n), from the start."""
    assert one.model is not None
    table, memory, states = one.model.table, one.model.memory, one.macro[0]
    assert isinstance(table, FanTable)
    full = reaction_rows(one.path, bool(table.wet.any()))[:, : len(states)]
    time = one.path["time"][: len(states)] - one.path["time"][0] if "time" in one.path else None
    macro = table.rows(states)[0] if memory is None else memory.reactions(states, time, one.V)
    return table, full - full[:, :1], macro - table.r[:, 0, :1]
