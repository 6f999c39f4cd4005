# SPDX-License-Identifier: MIT
"""The four-parameter conic of PISA (Byrne et al. 2020, Geotechnique 70(11), equation 10) and its fit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PARAMETERS = ("ultimate", "stiffness", "reach", "curvature")
MOST = 0.999  # of the curvature
FIRST = 4  # points of X whose secants give the stiffness
LEAST = 1e-12
_ROOM = np.log(50.0)  # that a logarithm may go away from its start, or from 0


def conic(x: Array, ultimate: Array, stiffness: Array, reach: Array, curvature: Array) -> Array:
    """Return y of the conic at x: slope `stiffness` at 0, y = `ultimate` from x = `reach` on, odd in x.

    -n (y/y_u - x/x_u)^2 + (1 - n) (y/y_u - x k/y_u) (y/y_u - 1) = 0, n the curvature from 0 (bilinear) to 1 (straight).
    """
    size, reach = np.abs(x), np.maximum(reach, ultimate / stiffness)
    X = np.minimum(size / reach, 1.0)
    K = X * (reach * stiffness / ultimate)
    a = 1.0 - 2.0 * curvature
    b = 2.0 * curvature * X - (1.0 - curvature) * (1.0 + K)
    c = K * (1.0 - curvature) - curvature * X**2
    root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
    q = np.where(b < 0.0, root - b, -root - b)  # of the two forms of the root, the one without cancellation
    value = np.where(b < 0.0, 2.0 * c / np.where(b < 0.0, q, 1.0), q / np.where(b < 0.0, 1.0, 2.0 * a))
    return np.asarray(np.sign(x) * ultimate * np.where(size >= reach, 1.0, value))


def fitted(residuals: Callable[[Array], Array], start: Array) -> Array:
    """Return the numbers of the least squares from a start."""
    from scipy.optimize import least_squares

    low, high = np.minimum(start, 0.0) - _ROOM, np.maximum(start, 0.0) + _ROOM
    return np.asarray(least_squares(residuals, start, bounds=(low, high), max_nfev=100).x)


def start_of(x: Array, y: Array) -> tuple[float, float, float, float]:
    """Return ultimate, stiffness, reach and curvature to start from, of points (k,) of |x| > 0 and y."""
    order = np.argsort(np.abs(x))
    x, y = np.abs(x)[order], (y * np.sign(x))[order]
    few = max(len(x) // 20, 1)
    ultimate = max(float(np.median(y[-few:])), 1e-3 * float(np.abs(y).max()))
    stiffness = max(float(np.median(y[:few] / x[:few])), 1e-3 * ultimate / float(x[-1]))
    return 1.1 * ultimate, stiffness, max(1.5 * float(x[-1]), 4.0 * ultimate / stiffness), 0.5
