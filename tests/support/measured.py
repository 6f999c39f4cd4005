# SPDX-License-Identifier: MIT
"""Results of the invented caisson as the accuracy study measures them: three kinds of paths, initial stiffness."""

from functools import cache

import xarray as xr

from pysprings.full_model.accuracy.measures import cell_size
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


def with_error(
    unknowns: int, order: float = 2.0, slope: float = 100.0, harmonics: int | None = None, beside: float = 0.0
) -> xr.DataTree:
    """A result whose loads and reactions are wrong by slope * h^order + beside, relative to the limit."""
    tree = measured_result().copy(deep=True)
    factor = 1.0 + slope * cell_size(unknowns, harmonics) ** order + beside
    if harmonics is not None:
        tree.attrs |= {"discretisation": "fourier", "harmonics": harmonics}
    for path in tree["paths"].children.values():
        for name in ("H", "M", "p"):
            path[name] = path[name] * factor
    tree.attrs["n_unknowns"] = unknowns
    tree.attrs["status"] = "complete"
    return tree
