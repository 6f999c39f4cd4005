# SPDX-License-Identifier: MIT
"""Springs of one pull with an answer in closed form: linear ones, and ones that yield."""

import numpy as np
import xarray as xr

from pysprings.core import variables
from tests.support.synthetic import Caisson, Path, make_springs

LENGTH, RINGS = 4.0, 9
DEPTH = np.linspace(0.0, LENGTH, RINGS)
EDGES = np.concatenate([[0.0], 0.5 * (DEPTH[1:] + DEPTH[:-1]), [LENGTH]])
HEIGHT = np.diff(EDGES)


def springs_of(p, m, ends, u, rotation, stiffness=None) -> xr.DataTree:
    """Return the springs of one pull from p, m (depth, step), ends and states; all of p is outside and normal."""
    tree = make_springs((Path(steps=len(u) - 1),), Caisson(rings=RINGS, sectors=4))
    data = tree["paths/pull"].to_dataset(inherit=False).copy(deep=True)
    zero = np.zeros(len(u))
    new = {
        name: ("step", np.asarray(ends.get(name, zero), dtype=float)) for name in ("H_tip", "M_tip", "H_lid", "M_lid")
    }
    parts = np.zeros(data["p_component"].shape)
    parts[:, 0, 0, :] = p
    moment = np.zeros(data["m"].shape)
    moment[:, 0, :] = m
    new |= {
        "p": (("depth", "step"), p),
        "p_component": (data["p_component"].dims, parts),
        "m": (data["m"].dims, moment),
    }
    new |= {"u": ("step", u), "rotation": ("step", rotation)}
    new |= {"y": (("depth", "step"), u - rotation * DEPTH[:, None])}
    new |= {"depth_bounds": (("depth", "bound"), np.stack([EDGES[:-1], EDGES[1:]], 1))}
    data = data.drop_vars("depth_bounds").assign_coords(depth=DEPTH).assign(new)
    tree["paths/pull"].dataset = variables.attach(data, "springs_path")
    return tree


# Linear springs: p = K_P*y at every depth, m = K_M*rotation, tip and lid terms linear.
K_P, K_M, K_TIP, R_TIP, K_LID, R_LID = 3e8, 2e9, 4e8, 5e9, 2e8, 1e9


def linear_springs() -> xr.DataTree:
    u = np.linspace(0.0, 5e-3, 6)
    rotation = 0.15 * u
    tip = u - LENGTH * rotation
    ends = {"H_tip": K_TIP * tip, "M_tip": R_TIP * rotation, "H_lid": K_LID * u, "M_lid": R_LID * rotation}
    return springs_of(K_P * (u - rotation * DEPTH[:, None]), K_M * rotation * np.ones((RINGS, 1)), ends, u, rotation)


def linear_stiffness(spring_set: str) -> np.ndarray:
    """Return K of H = K_uu u + K_ur rotation, M = K_ru u + K_rr rotation, by the balance sums."""
    coupled = -np.sum(HEIGHT * DEPTH)
    k = np.array([[np.sum(HEIGHT), coupled], [coupled, np.sum(HEIGHT * DEPTH**2)]]) * K_P
    if spring_set == "full":
        k += K_TIP * np.array([[1.0, -LENGTH], [-LENGTH, LENGTH**2]])
        k += [[K_LID, 0.0], [0.0, K_M * LENGTH + R_TIP + R_LID]]
    return k


def bilinear_springs() -> xr.DataTree:
    """Return the springs that yield at 1 mm: translation alone, so that all curves turn at the same state."""
    u = np.array([0.0, 1e-3, 2e-3, 3e-3])
    p = np.tile([0.0, 3e5, 4e5, 5e5], (RINGS, 1))
    return springs_of(p, np.zeros((RINGS, 1)), {}, u, 0.0 * u)
