# SPDX-License-Identifier: MIT
"""Springs with vertical paths of a known curve, and the same rays under several vertical loads."""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.macro.vertical import build_vertical
from pysprings.springs.springs import Springs
from tests.support import fans, synthetic

K, REST = 4e9, 2e6  # N/m, N: of the invented vertical springs
RAYS = [
    synthetic.Path("slide", "translation", size=1e-2, steps=12),
    synthetic.Path("turn", "rotation", size=-2e-3, steps=12),
]


def down_curve(w: np.ndarray) -> np.ndarray:
    """Return V(w) - V0 of the invented soil: a hyperbola, weaker upwards, with a limit of 3 MN there."""
    return K * w / (1.0 + np.where(w > 0.0, w / 5e-3, -K * w / 3e6))


def vertical_path(base: xr.Dataset, end: float, steps: int = 25) -> xr.Dataset:
    """Return a vertical path to w = end [m]: half of the change of V on the skirt, a quarter on tip and lid each."""
    w = end * np.linspace(0.0, 1.0, steps) ** 2
    change, dz = down_curve(w), np.diff(base["depth_bounds"].values, axis=1)[:, 0]
    out = base.isel(step=[0] * steps).assign_coords(step=np.arange(steps)).copy(deep=True)
    even = np.broadcast_to(change / dz.sum() / 4.0, (dz.size, 2, steps))
    out["t"] = out["t"] + xr.DataArray(even, dims=("depth", "side", "step"))
    out["V_tip"], out["V_lid"], out["V"] = out["V_tip"] + change / 4, out["V_lid"] + change / 4, out["V"] + change
    out["w"] = ("step", w)
    out.attrs = {"kind": "vertical", "role": "calibration", "arm_m": 0.0, "status": "complete", "heave": "free"}
    return variables.attach(out, "springs_path")


def vertical_springs(ends: tuple[float, ...] = (1e-2, -1e-2), heavier: tuple[float, ...] = ()) -> xr.DataTree:
    """Return two rays, vertical paths to w = ends, and the rays again under more V, with reactions stronger by it."""
    base = synthetic.make_springs(RAYS)
    groups = {"/": base.to_dataset(inherit=False)}
    K_zz = groups["/"]["stiffness_initial"].copy(deep=True)
    K_zz.values[1, 1] = K
    groups["/"] = groups["/"].assign(stiffness_initial=K_zz)
    for name in ("slide", "turn"):
        path = base[f"paths/{name}"].to_dataset(inherit=False)
        groups[f"/paths/{name}"] = path
        for V in heavier:
            groups[f"/paths/{name}_{V / 1e6:g}".replace(".", "_")] = pressed(path, V)
    for end in ends:
        name = "down" if end > 0.0 else "up"
        groups[f"/paths/{name}"] = vertical_path(groups["/paths/slide"], end)
    return xr.DataTree.from_dict(groups, name="springs")


def pressed(path: xr.Dataset, V: float) -> xr.Dataset:
    """Return the path under a vertical load V: the lid carries the rest, lateral reactions are proportional to V."""
    out = path.copy(deep=True)
    for name in ("p", "p_component", "m", "H", "M", "H_tip", "M_tip", "H_lid", "M_lid"):
        start = path[name].isel(step=0)
        out[name] = (start + (path[name] - start) * V / REST).transpose(*path[name].dims)
    out["V"], out["V_lid"] = out["V"] + V - REST, out["V_lid"] + V - REST
    table = build_vertical(Springs.of(vertical_springs()))
    assert table is not None
    out["w"] = out["w"] + table.displacement(V)
    return variables.attach(out, "springs_path")


def weaken(tree: xr.DataTree, name: str, share: float) -> xr.DataTree:
    """Have a vertical path carry a share of its change of V, at the same displacements; return the springs."""
    path = tree[f"paths/{name}"].to_dataset(inherit=False)
    for each in ("t", "V", "V_tip", "V_lid"):
        start = path[each].isel(step=0)
        path[each] = (start + share * (path[each] - start)).transpose(*path[each].dims)
    tree[f"paths/{name}"].dataset = path
    return tree


def fan_with_vertical(law: Callable[..., Any] = fans.potential) -> xr.DataTree:
    """Return the eight rays of a coupled law in closed form, with vertical paths down and up."""
    tree = fans.fan_springs(law)
    for end in (1e-2, -1e-2):
        path = vertical_path(tree["paths/ray_0"].to_dataset(inherit=False), end)
        tree[f"paths/{'down' if end > 0.0 else 'up'}"] = xr.DataTree(path)
    return tree
