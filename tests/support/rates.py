# SPDX-License-Identifier: MIT
"""Springs of coupled rays at several rates, and vertical paths beside them at a rate of their own."""

import numpy as np
import xarray as xr

from pysprings.springs.path import paths_of
from tests.support import synthetic
from tests.support.vertical import RAYS, vertical_path

LENGTH = 4.0


def at_two_rates(stronger: float = 1.2, speeds: tuple[float, ...] = (1e-5, 1e-3)) -> xr.DataTree:
    """Two rays, each once at a slow and once at a fast rate (m/s of rho), where all reactions change more."""
    base = synthetic.make_springs(RAYS)
    groups: dict[str, xr.Dataset] = {"/": base.to_dataset(inherit=False)}
    groups["/"].attrs = {**base.attrs, "drainage": "coupled"}
    for number, speed in enumerate(speeds):
        for name in paths_of(base):
            path = base[f"paths/{name}"].to_dataset(inherit=False).copy(deep=True)
            rho = np.hypot(path["u"], path["rotation"] * LENGTH)
            path["time"] = ("step", (rho / speed).values, base[f"paths/{name}/V"].attrs | {"units": "s"})
            path["time"].attrs = {"long_name": "time", "units": "s"}
            scaled = "p p_component m t H V M H_tip V_tip M_tip H_lid V_lid M_lid"
            for variable in scaled.split():
                start = path[variable].isel(step=0)  # the state at rest is the same
                path[variable] = (start + (path[variable] - start) * stronger**number).transpose(*path[variable].dims)
                path[variable].attrs = base[f"paths/{name}/{variable}"].attrs
            groups[f"/paths/{name}{number}"] = path
    return xr.DataTree.from_dict(groups)


def with_vertical(*rates: float, stronger: float = 1.5) -> xr.DataTree:
    """The rays at 1e-5 and 1e-3 m/s, with vertical paths at rates of w [m/s], each stronger than the one before."""
    tree = at_two_rates()
    for number, rate in enumerate(rates):
        for name, end in (("down", 1e-2), ("up", -1e-2)):
            path = vertical_path(tree["paths/slide0"].to_dataset(inherit=False).drop_vars("time"), end)
            for variable in ("t", "V", "V_tip", "V_lid"):
                start, attrs = path[variable].isel(step=0), path[variable].attrs
                changed = start + (path[variable] - start) * stronger**number
                path[variable] = changed.transpose(*path[variable].dims).assign_attrs(attrs)
            path["time"] = ("step", np.abs(path["w"].values) / rate, {"long_name": "time", "units": "s"})
            tree[f"paths/{name}{f'_rate_{number}' if number else ''}"] = xr.DataTree(path)
    return tree
