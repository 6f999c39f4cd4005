# SPDX-License-Identifier: MIT
"""Convergence of the macro-model with the number of depth slices: error against cost."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.columns import Column, Table, filled
from pysprings.core.errors import refused
from pysprings.macro.comparison import compare
from pysprings.macro.model import MacroModel
from pysprings.springs.springs import Springs
from pysprings.springs.sums import slice_heights

REPEATS = 5
POINTS = 50
_ERRORS = ("H_error_max_pct", "rotation_error_max_pct", "M_error_max_pct", "u_error_max_pct")


def merge_slices(springs: Springs | xr.DataTree, n: int) -> Springs:
    """Return springs with n depth slices, made of neighbours: p, m and t are means, y is that of the mean depth.

    Forces and distributed moments stay what they are; the moment of p within a merged slice is lost, as in a table
    with so few depths.
    """
    given = Springs.of(springs)
    depths = _depths(given)
    if not 1 <= n <= depths:
        raise refused("slices", f"{n} slices: the springs have 1 to {depths}")
    return given.with_paths(replace(path, recorded=_merged(path.recorded, n)) for path in given.paths.values())


def _depths(springs: Springs) -> int:
    return int(next(iter(springs.paths.values())).depth.size)


def _merged(path: xr.Dataset, n: int) -> xr.Dataset:
    height, bounds = slice_heights(path), path["depth_bounds"].values
    groups = np.array_split(np.arange(height.size), n)
    share = np.zeros((n, height.size))
    for row, group in enumerate(groups):
        share[row, group] = height[group] / height[group].sum()
    depth = share @ path["depth"].values
    ends = np.array([[bounds[group[0], 0], bounds[group[-1], 1]] for group in groups])
    data: dict[str, Any] = {}
    for name, variable in path.data_vars.items():
        if "depth" not in variable.dims:
            data[str(name)] = variable.variable
        elif name not in ("depth_bounds", "y"):
            data[str(name)] = (variable.dims, np.tensordot(share, variable.values, axes=(1, 0)), variable.attrs)
    y = share @ path["y"].transpose("depth", "step").values
    data |= {"depth_bounds": (path["depth_bounds"].dims, ends, path["depth_bounds"].attrs)}
    data |= {"y": (("depth", "step"), y, path["y"].attrs)}
    coords = {name: value.variable for name, value in path.coords.items() if "depth" not in value.dims}
    return xr.Dataset(data, coords | {"depth": ("depth", depth, path["depth"].attrs)}, path.attrs)


def slice_counts(springs: Springs) -> list[int]:
    """Return 1, 2, 4 ... and the number of slices that the springs have."""
    depths = _depths(springs)
    return sorted({2**k for k in range(depths.bit_length()) if 2**k < depths} | {depths})


def slice_convergence(
    springs: Springs | xr.DataTree, counts: Sequence[int] | None = None, springs_kind: str | None = None
) -> pd.DataFrame:
    """Return one row per number of slices, spring set and role of path: largest errors [%], eta, and cost.

    Errors are those of `comparison.compare` (their sizes), largest over the paths of a role. curve_ms is the time of a
    curve of 50 points on the last path, in this process, after a first one.
    """
    given, rows = Springs.of(springs), []
    for n in counts or slice_counts(given):
        coarse = merge_slices(given, n)
        frame = compare(coarse, springs_kind)
        frame = frame[frame["springs"] != "vertical"]
        for (spring_set, role), part in frame.groupby(["springs", "role"], sort=False):
            row: dict[str, Any] = {"slices": n, "springs": spring_set, "role": role}
            row |= {name: part[name].abs().max() for name in _ERRORS if name in part}
            row |= {"eta_large": part["eta_large"].min()}
            rows.append(row | {"curve_ms": 1e3 * curve_seconds(coarse, str(spring_set))})
    return pd.DataFrame(rows)


def curve_seconds(springs: Springs | xr.DataTree, spring_set: str) -> float:
    """Return the median time [s] of a curve of 50 points on the last lateral path, after a first one."""
    given = Springs.of(springs)
    path = [path for path in given.paths.values() if not path.is_vertical][-1]
    model = MacroModel.from_springs(given, spring_set)
    targets = np.zeros((POINTS, 2))
    targets[:, 0] = np.linspace(0.0, 0.5 * float(np.abs(path.u).max()), POINTS)
    times = []
    for _ in range(REPEATS + 1):
        start = time.perf_counter()
        model.solve("displacement", targets)
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:]))


_COLUMNS = (
    Column("slices", "slices"),
    Column("springs", "springs", words=True),
    Column("H max [%]", "H_error_max_pct"),
    Column("u max [%]", "u_error_max_pct"),
    Column("rot max [%]", "rotation_error_max_pct"),
    Column("M max [%]", "M_error_max_pct"),
    Column("eta large", "eta_large"),
    Column("50 points [ms]", "curve_ms"),
)


def to_text(frame: pd.DataFrame) -> str:
    """Return the convergence as tables for a terminal, one a role."""
    lines = []
    for role, part in frame.groupby("role", sort=False):
        rows = part.to_dict("records")
        text = Table.of(filled(_COLUMNS, rows), rows).text()
        lines += [f"{role} paths, largest errors by number of depth slices", text, ""]
    return "\n".join(lines)
