# SPDX-License-Identifier: MIT
"""How far two NetCDF files are apart that one scene has made twice."""

from pathlib import Path

import numpy as np
import xarray as xr

from pysprings.core.storage import read_tree


def difference(one: Path, other: Path) -> float:
    """Return the largest difference of two NetCDF files, relative to the largest value of each variable."""
    a, b = read_tree(one), read_tree(other)
    assert a.groups == b.groups, "other groups"
    return max((_of_datasets(a[group], b[group]) for group in a.groups), default=0.0)


def _of_datasets(a: xr.DataTree, b: xr.DataTree) -> float:
    worst = 0.0
    assert set(a.variables) == set(b.variables), "other variables"
    for name, variable in a.variables.items():
        x, y = variable.values, b.variables[name].values
        assert x.shape == y.shape and x.dtype == y.dtype, f"{name}: another shape"
        if x.dtype.kind == "f":
            scale = float(np.nanmax(np.abs(x), initial=0.0)) or 1.0
            worst = max(worst, float(np.nanmax(np.abs(x - y), initial=0.0)) / scale)
            assert (np.isnan(x) == np.isnan(y)).all(), f"{name}: NaN elsewhere"
        else:
            assert (x == y).all(), f"{name}: other values"
    return worst
