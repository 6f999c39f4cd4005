# SPDX-License-Identifier: MIT
"""Results of the invented caisson as the accuracy study measures them: three kinds of paths, initial stiffness."""

from __future__ import annotations

from functools import cache

import xarray as xr

from tests.support.synthetic import Caisson, Path, make_result, stiffness

PATHS = (Path("pull", arm=8.0), Path("shift", kind="translation"), Path("turn", kind="rotation", size=-1e-3))
LENGTH = Caisson().length


@cache
def measured_result(caisson: Caisson | None = None, paths: tuple[Path, ...] = PATHS) -> xr.DataTree:
    c = caisson or Caisson()
    tree = make_result(paths, c)
    tree["stiffness_initial"] = xr.DataArray(stiffness(c), dims=("dof", "dof_conjugate"))
    tree.attrs["skirt_length_m"] = c.length
    return tree
