# SPDX-License-Identifier: MIT
"""Numbers read from a run: stresses over initial, gaps, slopes of the load curve and where it bends most.

A path is the `dataset` of a `pysprings.springs.path.RecordedPath` (converged steps), SI. Displacements are those of
the lid centre. Where a run has stopped before a displacement, its measures there are NaN.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

FRONT, BACK = 0.0, np.pi  # azimuth [rad]
BEND_FROM, BEND_TO = 0.2e-3, 10e-3  # m, range of the sharpest bend
_NEAR = 0.02  # a displacement counts as reached this share before its value
_HALF_WIDTH = 0.2  # of the displacement, for a tangent


def reached(path: xr.Dataset, u: float) -> bool:
    """Return whether the path has reached a displacement u [m]."""
    return bool(path["u"].values[-1] >= (1.0 - _NEAR) * u)


def at(path: xr.Dataset, name: str, u: float) -> Array:
    """Return a variable at displacement u [m], linear between steps; its dimensions without `step`, NaN beyond."""
    steps, values = path["u"].values, path[name].transpose("step", ...).values.astype(float)
    if not reached(path, u):
        return np.full(values.shape[1:], np.nan)
    k = int(np.clip(np.searchsorted(steps, u), 1, len(steps) - 1))
    share = float(np.clip((u - steps[k - 1]) / (steps[k] - steps[k - 1]), 0.0, 1.0))
    return np.asarray((1.0 - share) * values[k - 1] + share * values[k])


def load(path: xr.Dataset, u: float) -> float:
    """Load H [N] at displacement u [m]."""
    return float(at(path, "H", u))


def load_ratio(path: xr.Dataset, other: xr.Dataset, u: float) -> float:
    """Load of a path over that of another at displacement u [m]."""
    return load(path, u) / load(other, u)


def tangent(path: xr.Dataset, u: float) -> float:
    """Return the slope dH/du [N/m] at displacement u [m], over plus and minus a fifth of it."""
    low, high = (1.0 - _HALF_WIDTH) * u, (1.0 + _HALF_WIDTH) * u
    return (load(path, high) - load(path, low)) / (high - low)


def slope_ratio(path: xr.Dataset, early: float = 0.3e-3, late: float = 3e-3) -> float:
    """Return the tangent at an early over that at a late displacement [m]: 1 for a straight line."""
    return tangent(path, early) / tangent(path, late)


def secant_share(path: xr.Dataset, u: float, early: float = 0.1e-3) -> float:
    """Return the secant H/u at displacement u [m] over the early one: 1 where the caisson answers linearly up to u."""
    return (load(path, u) / u) / (load(path, early) / early)


def sharpest_bend(x: Array, y: Array, low: float = BEND_FROM, high: float = BEND_TO) -> tuple[float, float]:
    """Place (in units of x) and sharpness of the sharpest bend of a rising curve.

    The sharpness is -d(ln tangent)/d(ln x), by how many per cent the tangent falls when x grows by one per cent: 0 on
    a straight line, 1 - n on y = x^n, large at a kink. The curve is read at 14 places a factor apart, so that its
    steps do not matter; NaN where it ends before half of `high`.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if x[-1] < 0.5 * high:
        return float("nan"), float("nan")
    places = np.geomspace(low, min(high, float(x[-1])), 15)
    values = np.interp(places, x, y)
    slope = np.diff(values) / np.diff(places)
    middle = np.sqrt(places[1:] * places[:-1])
    if (slope <= 0.0).any():  # the load falls: a peak ends the search
        end = int(np.argmax(slope <= 0.0))
        slope, middle = slope[:end], middle[:end]
    if len(slope) < 3:
        return float("nan"), float("nan")
    fall = -(np.log(slope[2:] / slope[:-2])) / np.log(middle[2:] / middle[:-2])
    k = int(np.argmax(fall))
    return float(middle[1 + k]), float(fall[k])


def load_bend(path: xr.Dataset) -> tuple[float, float]:
    """Place [m] and sharpness of the sharpest bend of the load-displacement curve."""
    return sharpest_bend(path["u"].values, path["H"].values)


def by_depth(depths: Array, values: Array, at_depths: Sequence[float]) -> Array:
    """Read values at depths [m], linear between the rings."""
    return np.array([np.interp(depth, depths, values) for depth in at_depths])


def field(path: xr.Dataset, name: str, u: float, azimuth: float, side: str = "outside") -> Array:
    """Return a contact field at displacement u [m] and an azimuth [rad], by depth ring."""
    values = at(path[[name, "u"]].sel(side=side), name, u)
    order = [dim for dim in path[name].dims if dim not in ("step", "side")]
    station = int(np.argmin(np.abs(path["azimuth"].values - azimuth)))
    return values[station] if order[0] == "azimuth" else values[:, station]


def stress_ratio(
    path: xr.Dataset, u: float, azimuth: float, depths: Sequence[float], side: str = "outside"
) -> Array:  # fmt: skip
    """Return normal effective stress over its initial value at depths [m] between the rings, at displacement u [m]."""
    now = field(path, "normal_effective_stress", u, azimuth, side)
    start = path["normal_effective_stress"].sel(side=side).isel(step=0).transpose("azimuth", "depth").values
    station = int(np.argmin(np.abs(path["azimuth"].values - azimuth)))
    rings = path["depth"].values
    now, initial = by_depth(rings, now, depths), by_depth(rings, start[station], depths)
    return np.divide(now, initial, out=np.full_like(now, np.nan), where=initial > 0)


def rear_gap(path: xr.Dataset, u: float, side: str = "outside") -> Array:
    """Return the largest opening [m] on the rear half of the skirt by depth ring, at displacement u [m]."""
    values = at(path[["gap", "u"]].sel(side=side).transpose("step", "azimuth", "depth"), "gap", u)
    rear = path["azimuth"].values > 0.5 * np.pi
    return np.asarray(values[rear].max(axis=0))


def open_share(path: xr.Dataset, u: float) -> float:
    """Return the share of the outer back line (azimuth 180 deg) without contact stress at displacement u [m]."""
    stress = field(path, "normal_effective_stress", u, BACK)
    heights = np.diff(path["depth_bounds"].values, axis=1)[:, 0]
    if not np.isfinite(stress).all():
        return float("nan")
    return float(heights[stress <= 0.0].sum() / heights.sum())


def py_curve(path: xr.Dataset, depth: float) -> tuple[Array, Array]:
    """Return (y [m], p [N/m]) by step at a depth [m], linear between rings."""
    y, p = (path[name].transpose("depth", "step").values for name in ("y", "p"))
    rings = path["depth"].values
    k = int(np.clip(np.searchsorted(rings, depth), 1, len(rings) - 1))
    share = float((depth - rings[k - 1]) / (rings[k] - rings[k - 1]))
    return (1 - share) * y[k - 1] + share * y[k], (1 - share) * p[k - 1] + share * p[k]


def y_at(path: xr.Dataset, depth: float, u: float) -> float:
    """Return the displacement y [m] of the caisson's mean fibre at a depth [m], for u [m] of the lid centre."""
    return _when(path, py_curve(path, depth)[0], u)


def p_at(path: xr.Dataset, depth: float, u: float) -> float:
    """Return the reaction p [N/m] at a depth [m] when the lid centre has moved by u [m]."""
    return _when(path, py_curve(path, depth)[1], u)


def _when(path: xr.Dataset, values: Array, u: float) -> float:
    return float(np.interp(u, path["u"].values, values)) if reached(path, u) else float("nan")
