# SPDX-License-Identifier: MIT
"""Springs of coupled paths at one rate, whose water pressure relaxes as one Maxwell body."""

import numpy as np
import xarray as xr

from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.fans import DEPTH, LENGTH

RATE, TIME = 1e-4, 20.0  # m/s of rho; relaxation time [s]
AT_REST = 300.0  # N/m, that does not change
STIFFNESS = np.array([[2e7], [-8e6]]) * (1.0 + DEPTH)  # p_water over y, (side, depth) [N/m2]


def maxwell(x: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return z (..., n) of dz/dt = dx/dt - z/TIME along x (..., n): the exponential sum over 400 parts of each step."""
    out, z = np.zeros_like(x), np.zeros(x.shape[:-1])
    for k in range(1, x.shape[-1]):
        step = (time[k] - time[k - 1]) / 400
        for _ in range(400):
            z = (z + (x[..., k] - x[..., k - 1]) / 400) / (1.0 + step / TIME)
        out[..., k] = z
    return out


def tree(
    turning: tuple[float, ...] = (0.0, -30.0, -50.0),
    loops: tuple[tuple[float, float], ...] = (),
    rates: tuple[float, ...] = (RATE,),
) -> xr.DataTree:
    """Return a Winkler caisson's springs with times; water carries a part of p, which is what it is without.

    Loops have half the first rate.
    """
    bare = winkler.springs(turning, loops)
    groups = {"/": bare.to_dataset(inherit=False).assign_attrs(drainage="coupled")}
    for node in bare["paths"].children.values():
        held_back = node.attrs["role"] == "held-back"
        for number, rate in enumerate((0.5 * rates[0],) if held_back else rates):
            groups[f"/paths/{node.name}" + (f"_rate_{number}" if number else "")] = _timed(node, rate)
    return xr.DataTree.from_dict(groups, name="springs")


def _timed(node: xr.DataTree, rate: float) -> xr.Dataset:
    """Return a path at a rate of (u, rotation L), with the water of that rate."""
    path = node.to_dataset(inherit=False).copy(deep=True)
    ways = np.hypot(np.diff(path["u"]), np.diff(path["rotation"]) * LENGTH)
    time = np.append(0.0, np.cumsum(ways)) / rate
    path["time"] = ("step", time, {"long_name": "time", "units": "s"})
    relaxed = maxwell(path["u"].values + path["rotation"].values * DEPTH[:, None], time)
    p = path["p_component"].transpose("side", "component", "depth", "step").values.copy()
    water, normal = (list(path["component"].values).index(name) for name in ("water", "normal"))
    p[:, water] = STIFFNESS[:, :, None] * relaxed + AT_REST
    p[:, normal] -= p[:, water]
    return path.assign(p_component=path["p_component"].copy(data=np.moveaxis(p, 2, 0)))


def coupled(**paths: object) -> Springs:
    """Return `tree` as springs."""
    return Springs.of(tree(**paths))  # type: ignore[arg-type]
