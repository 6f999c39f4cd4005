# SPDX-License-Identifier: MIT
"""Paths out of one plane of the caisson on Winkler springs of `winkler.py`, solved on their own.

At each depth Masing's perfectly plastic springs act in the direction of their motion: radial return of (y_x, y_y), and
of the two rotations. A twist meets the same springs of its own.
"""

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.path_kinds import LOADS, MOTIONS
from tests.support import winkler
from tests.support.fans import DEPTH, HEIGHT, LENGTH

RADIUS, TORSION = 4.0, 5e9  # of the wall [m], N m/rad at rest
REACH = winkler.RHO[-1]


def round_masing(x: np.ndarray) -> np.ndarray:
    """Return the force (..., 2, n) of round springs of stiffness 1 along motions x (..., 2, n) from rest."""
    out, elastic = np.zeros_like(x), np.zeros((winkler.SIZES.size, *x.shape[:-1]))
    before = np.zeros(x.shape[:-1])
    limits = winkler.SIZES.reshape(-1, *[1] * before.ndim)
    for k in range(x.shape[-1]):
        elastic = elastic + x[..., k] - before
        size = np.linalg.norm(elastic, axis=-1, keepdims=True)
        elastic = elastic * np.minimum(1.0, limits / np.maximum(size, 1e-300))
        before = x[..., k]
        out[..., k] = np.tensordot(winkler.SHARES, elastic, axes=1)
    return out


def by_depth(turns: np.ndarray) -> np.ndarray:
    """Return p (depth, 2, n) [N/m] in the planes of x and y along motions (n, 5) from rest."""
    u, lean = turns[:, :2].T, np.stack([turns[:, 3], -turns[:, 2]])
    return winkler.P_STIFFNESS * round_masing(u - lean * DEPTH[:, None, None])


def pushes(turns: np.ndarray) -> np.ndarray:
    """Return (H_x, H_y, M_x, M_y, T) (n, 5) along motions (u_x, u_y, rot_x, rot_y, rot_z) (n, 5) from rest."""
    lean = np.stack([turns[:, 3], -turns[:, 2]])  # in the planes of x and y
    p, m = by_depth(turns), winkler.M_STIFFNESS * round_masing(LENGTH * lean) / LENGTH
    H = np.einsum("dan,d->an", p, HEIGHT)
    M = np.einsum("dan,d->an", -p * DEPTH[:, None, None], HEIGHT) + m * LENGTH
    wall = RADIUS * turns[:, 4]
    T = TORSION / RADIUS * winkler.masing(wall)
    return np.stack([*H, -M[1], M[0], T], axis=1)


def path(turns: np.ndarray, kind: str, role: str) -> xr.Dataset:
    """Return a path of the schema out of motions (n, 5) that begin at rest, with the loads of the springs."""
    n, none = len(turns), np.zeros((DEPTH.size, 2, len(turns)))
    names = [name for name in MOTIONS if name != "w"], [name for name in LOADS if name != "V"]
    values = dict(zip(names[0], turns.T, strict=True)) | dict(zip(names[1], pushes(turns).T, strict=True))
    values |= {"w": np.full(n, 3e-3), "V": np.full(n, 2e6), "time": np.arange(n, dtype=float)}
    data = {name: ("step", value) for name, value in values.items()} | {"converged": ("step", np.ones(n, np.int8))}
    p, dims = by_depth(turns), ("depth", "side", "step")
    data |= {f"p_{axis}": (dims, np.stack([p[:, k], 0.0 * p[:, k]], 1)) for k, axis in enumerate("xy")}
    data |= {name: (dims, none) for name in ("t", "torque")}
    edges = np.concatenate([[0.0], np.cumsum(HEIGHT)])
    data["depth_bounds"] = ("depth", "bound"), np.stack([edges[:-1], edges[1:]], axis=1)
    coords = {"depth": DEPTH, "side": list(variables.SIDES)}
    attrs = {"kind": kind, "role": role, "arm_m": 0.0, "status": "complete", "heave": "free"}
    return variables.attach(xr.Dataset(data, coords, attrs), "space_path")


def circle(radius: float, n: int = 72) -> np.ndarray:
    """Return motions to a radius [m] along x, and once round."""
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    first = np.linspace(0.0, radius, 12)[:-1]
    u = np.concatenate([np.stack([first, 0.0 * first], 1), radius * np.stack([np.cos(angle), np.sin(angle)], 1)])
    return np.hstack([u, np.zeros((len(u), 3))])


def twist(ends: tuple[float, ...]) -> np.ndarray:
    """Return motions of a twist [rad] to ends, one after the other."""
    way = np.concatenate([np.linspace(a, b, 25)[:-1] for a, b in zip((0.0, *ends), ends, strict=False)] + [ends[-1:]])
    return np.stack([*np.zeros((4, way.size)), way], axis=1)


def elbow(first: float, second: float, lean: float = 0.0) -> np.ndarray:
    """Return motions along x, then along y [m], and a lean towards both of `lean` over the motion [rad/m]."""
    one, two = np.linspace(0.0, first, 20), np.linspace(0.0, second, 40)[1:]
    u = np.concatenate([np.stack([one, 0.0 * one], 1), np.stack([first + 0.0 * two, two], 1)])
    return np.stack([*u.T, -lean * u[:, 1], lean * u[:, 0], np.zeros(len(u))], axis=1)


def springs(twisted: bool = True) -> xr.DataTree:
    """Return the springs of `winkler.springs` with a circle, a twist, and an elbow that is held back."""
    tree, wall = winkler.springs(), REACH / RADIUS
    paths = {"circle": path(circle(0.4 * REACH), "circle", "memory")}
    if twisted:
        paths["twist"] = path(twist((0.1 * wall, -0.1 * wall, 0.5 * wall, -0.5 * wall, wall)), "twist", "memory")
    paths["elbow"] = path(elbow(0.3 * REACH, 0.6 * REACH, 0.1 / LENGTH), "pull", "held-back")
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    groups["/"] = groups["/"].assign_attrs(outer_diameter_m=2.0 * RADIUS)
    return xr.DataTree.from_dict(groups | {f"/space/{name}": each for name, each in paths.items()}, name=tree.name)
