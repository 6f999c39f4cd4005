# SPDX-License-Identifier: MIT
"""The quantities whose error is measured, from one path of a full-model result (all its converged states).

What drives a path and what answers depends on its kind (`core.path_kinds`). A path on which H and M do not grow in
proportion (a swipe, a load that climbs) is followed along |u| + |rotation| L, as in `macro.comparison`.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from pysprings.core.path_kinds import PATH_KINDS, kind_of

Array = NDArray[np.float64]

# The contact pressure is sought down to this share of the skirt: at its tip the exact one is singular in elastic soil,
# and the largest value there depends on how fine the mesh is, without a limit.
PRESSURE_DOWN_TO = 0.9
_PRESSURE_DEPTHS = 19


def driver(path: xr.Dataset, length: float) -> Array:
    """Return the size of what drives a path, (step,): m, or rad on a rotation path; L = ``length`` in m."""
    kind = kind_of(path.attrs)
    if kind.bends:
        return np.abs(path["u"].values) + length * np.abs(path["rotation"].values)
    return np.abs(path[kind.drives].values - path[kind.drives].values[0])


def load(path: xr.Dataset) -> Array:
    """Return the load that answers what is driven, (step,): H [N], M [N m] of a rotation, change of V [N].

    Of a translation with a rotation in proportion to u it is H + M rotation/u, the work of both loads over u: H alone
    may cross zero on such a path.
    """
    kind = kind_of(path.attrs)
    values: Array = path[kind.load].values
    if kind.load == "V":
        return values - values[0]
    return values + _turn(path) * path["M"].values if kind.straight and kind.drives == "u" else values


def _turn(path: xr.Dataset) -> float:
    """Return the rotation over u (rad/m) of a straight path that moves the lid centre."""
    u, rotation = path["u"].values[-1], path["rotation"].values[-1]
    return float(rotation / u) if u else 0.0


def other(path: xr.Dataset) -> Array | None:
    """Return the second answer, (step,): the rotation of a free head [rad], else M [N m], H [N] of a rotation."""
    name = kind_of(path.attrs).companion
    return None if name is None else path[name].values


def pressure(path: xr.Dataset, length: float) -> Array | None:
    """Return the largest effective contact pressure on the skirt, (step,) Pa, to 0.9 of its length; None: not kept.

    Pressure is positive; the largest is over both sides, all azimuths and _PRESSURE_DEPTHS depths, the same on every
    mesh. Linear between the depths of the rings.
    """
    if "normal_effective_stress" not in path:
        return None
    share = _linear_shares(path["depth"].values, np.linspace(0.0, PRESSURE_DOWN_TO * length, _PRESSURE_DEPTHS))
    stress = path["normal_effective_stress"].transpose("step", "side", "azimuth", "depth").values
    return np.asarray((stress @ share).max(axis=(1, 2, 3)), dtype=float)


def slice_curves(path: xr.Dataset, length: float, n: int) -> tuple[Array, Array]:
    """Return y [m] and p [N/m] of n equal slices of the skirt, (n, step) each.

    p is the force on the slice over its height. The force above a depth is known at the bounds of the rings; between
    them it is a cubic spline, so that sums of p dz stay what they are and slices may end inside a ring. y is that of
    the middle of the slice.
    """
    edges = np.linspace(0.0, length, n + 1)
    bounds = path["depth_bounds"].values
    forces = path["p"].transpose("depth", "step").values * np.diff(bounds, axis=1)
    above = np.concatenate([np.zeros_like(forces[:1]), np.cumsum(forces, axis=0)])
    force = CubicSpline(np.append(bounds[:, 0], bounds[-1, 1]), above)
    p = np.diff(force(np.clip(edges, bounds[0, 0], bounds[-1, 1])), axis=0) / np.diff(edges)[:, None]
    y = path["y"].transpose("depth", "step").values
    middle = _linear_shares(path["depth"].values, 0.5 * (edges[1:] + edges[:-1]))
    return middle.T @ (y - y[:, :1]), p


def _linear_shares(depth: Array, at: Array) -> Array:
    """Return the shares (depth, at) of values by depth in those at other depths: linear between, constant beyond."""
    return np.stack([np.interp(at, depth, row) for row in np.eye(depth.size)])


def initial_stiffness(stiffness: Array, path: xr.Dataset) -> float:
    """Return the slope of the load over what is driven at rest, from the stiffness (3, 3) in u, w, rotation.

    H/u [N/m] under a load at its arm (at the first one, of a load that climbs), or of a swipe with the ratio of
    rotation and u of its first step; (H + M rotation/u)/u of a translation; M/rotation [N m/rad] about the lid centre;
    V/w [N/m].
    """
    kind, heave_free = PATH_KINDS[str(path.attrs["kind"])], path.attrs.get("heave", "free") == "free"
    if kind.drives == "w":
        return float(stiffness[1, 1])
    K = stiffness[np.ix_([0, 2], [0, 2])]
    if heave_free:  # w follows so that V stays
        K = K - np.outer(stiffness[[0, 2], 1], stiffness[1, [0, 2]]) / stiffness[1, 1]
    if kind.free_head:
        arm = float(path.attrs.get("arm_from_m", path.attrs["arm_m"]))
        return float(1.0 / np.linalg.solve(K, np.array([1.0, arm]))[0])
    if kind.drives == "rotation":
        return float(K[1, 1])
    if kind.straight:
        turn = _turn(path)
        return float(K[0, 0] + (K[0, 1] + K[1, 0]) * turn + K[1, 1] * turn**2)
    u, rotation = path["u"].values[1], path["rotation"].values[1]
    return float(K[0, 0] + K[0, 1] * (rotation / u if u else 0.0))


def first_secant(stiffness: Array, path: xr.Dataset) -> float | None:
    """Return the secant of the first increment over the initial stiffness (`initial_stiffness`).

    None of a path that bends, and of one without an increment.
    """
    driven = path[kind_of(path.attrs).drives].values
    if kind_of(path.attrs).bends or driven.size < 2 or driven[1] == driven[0]:
        return None
    secant = (load(path)[1] - load(path)[0]) / (driven[1] - driven[0])
    return float(secant) / initial_stiffness(stiffness, path)
