# SPDX-License-Identifier: MIT
"""The largest vertical load that the vertical springs carry, downwards or upwards, and the share that is used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.core.words import RANGE_END
from pysprings.macro.vertical import FLAT, Branch
from pysprings.springs.path_ends import LIMIT_LOAD

if TYPE_CHECKING:
    from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]


def largest_vertical(model: MacroModel, V: float) -> tuple[float, str, str]:
    """Return the largest known vertical load in the direction of V [N, positive down], its kind, and where it is from.

    Pressure takes the path downwards, tension the one upwards. NaN and blank words where that path is missing, or does
    not come to a load of this sign.
    """
    sign = 1.0 if V >= 0.0 else -1.0
    branch = None if model.vertical is None else next((b for b in model.vertical.branches if b.sign == sign), None)
    if branch is None:
        return np.nan, "", ""
    largest = sign * float((sign * branch.r[-1]).max())
    if sign * largest <= 0.0:
        return np.nan, "", ""
    end = model.ends.get(branch.path)
    if end is not None and end.how == LIMIT_LOAD:
        return largest, f"{LIMIT_LOAD} of the full model", f"path '{branch.path}' {end.words}"
    stopped = end is not None and end.failed
    kind = "limit load of the springs" if _is_flat(branch) and not stopped else RANGE_END
    source = f"path '{branch.path}', at a settlement of {branch.sign * branch.end[0]:.4g} m from rest"
    return largest, kind, f"{source}; it stopped: {end.why}" if end is not None and stopped else source


def with_vertical_use(model: MacroModel, answer: xr.Dataset) -> xr.Dataset:
    """Return an answer with `utilisation_V` by step or case, and the largest known V of its last state as attributes.

    Unchanged where it has no V or the springs no vertical paths.
    """
    if model.vertical is None or "V" not in answer:
        return answer
    V = answer["V"].values
    known = variables.GROUPS["prediction"]["utilisation_V"].attributes()
    added = answer.assign(utilisation_V=(answer["V"].dims, vertical_use(model, V)["utilisation_V"], known))
    return added.assign_attrs(_attributes(*largest_vertical(model, float(V[-1])))) if V.size else added


def vertical_use(model: MacroModel, V: Array) -> dict[str, Any]:
    """Return by vertical load V (n,) [N] the largest known one of its sign, its kind, and the share of it that is used.

    Names: capacity_V, capacity_V_kind, utilisation_V; NaN and blank where none is known.
    """
    down, up = (largest_vertical(model, sign) for sign in (1.0, -1.0))
    largest = np.where(V >= 0.0, down[0], up[0])
    kind = np.where(V >= 0.0, np.array(down[1], dtype=object), np.array(up[1], dtype=object))
    return {"capacity_V": largest, "capacity_V_kind": kind, "utilisation_V": V / largest}


def _attributes(largest: float, kind: str, source: str) -> dict[str, Any]:
    return {"capacity_V_N": largest, "capacity_V_kind": kind, "capacity_V_from": source} if kind else {}


def _is_flat(branch: Branch) -> bool:
    """Return whether the load has stopped growing at the end of a curve."""
    chord = (branch.r[-1, -1] - branch.r[-1, -2]) / (branch.x[-1] - branch.x[-2])
    return bool(branch.sign * chord < FLAT * abs(branch.slope[-1, 0]))
