# SPDX-License-Identifier: MIT
"""A path of a run as curves over what drives it, and the same at displacements that several runs share.

Runs of one scene on other meshes, or with other steps, stop at other states and have other depths. They are compared at
POINTS equally spaced displacements from 0 (not counted) to the end that all of them reach, and p(y) at as many values
of y in SLICES equal slices of the skirt. Between recorded steps the curves are monotone cubic (Fritsch & Carlson 1980,
SciPy's PchipInterpolator): straight lines between the steps of one run and the steps of another would differ by more
than the meshes do. A path that turns back (`then`) is compared up to where it turns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from pysprings.full_model.accuracy import quantities
from pysprings.springs.path import paths_of

Array = NDArray[np.float64]

POINTS = 40
SLICES = 8
# A slice is left out where its y stays below this share of the largest: p(y) there is that of the point of rotation.
SMALL_Y = 0.05

LOAD, OTHER, PY, STIFFNESS, PRESSURE = "load", "rotation", "py", "stiffness", "pressure"
QUANTITIES = (LOAD, PY, OTHER, STIFFNESS, PRESSURE)


@dataclass(frozen=True)
class Curve:
    """A path of one run: ``x`` (n,) what drives it, from 0 and growing; by state (n,) or slice and state (k, n).

    ``by_x`` maps LOAD, OTHER and PRESSURE to their values, without those that the path does not have; y [m] and
    p [N/m] are means of the slices; ``stiffness`` is the slope of the load at rest.
    """

    x: Array
    by_x: Mapping[str, Array]
    y: Array
    p: Array
    stiffness: float


@dataclass(frozen=True)
class Grid:
    """Where runs are compared on a path: ``x`` (POINTS,), and ``y`` (k, POINTS), NaN in slices that are left out."""

    x: Array
    y: Array


Sample = dict[str, Array]
"""Values of the quantities on a grid; NaN where a slice is left out."""


def curves_of(result: xr.DataTree) -> dict[str, Curve]:
    """Return the curves of a full-model result, by path; paths without two states that move on are left out."""
    curves = {}
    for name, recorded in paths_of(result).items():
        path = recorded.dataset
        if path.sizes["step"] < 2:  # stopped during its dead load or in its first step
            continue
        length = float(result.attrs["skirt_length_m"])
        x = quantities.driver(path, length)
        rising = leading(x)
        if rising.size < 2:
            continue
        y, p = quantities.slice_curves(path, length, SLICES)
        by_x = {LOAD: quantities.load(path), OTHER: quantities.other(path), PRESSURE: quantities.pressure(path, length)}
        curves[name] = Curve(
            x[rising],
            {key: values[rising] for key, values in by_x.items() if values is not None},
            y[:, rising],
            p[:, rising],
            quantities.initial_stiffness(result.dataset["stiffness_initial"].values, path),
        )
    return curves


def leading(x: Array) -> NDArray[np.int_]:
    """Return the numbers of the states that lead on from the first one; states that repeat a value are skipped.

    >>> leading(np.array([0.0, 1.0, 1.0, 2.0, 1.5, 3.0])).tolist()
    [0, 1, 3]
    """
    rising = [0]
    for k in range(1, x.size):
        if x[k] > x[rising[-1]]:
            rising.append(k)
        elif x[k] < x[rising[-1]]:
            break
    return np.array(rising, dtype=int)


def common_grid(curves: Sequence[Curve]) -> Grid:
    """Return the points where all of these runs of one path have a value."""
    end = min(float(curve.x[-1]) for curve in curves)
    share = np.arange(1, POINTS + 1) / POINTS
    ends = np.array([_y_ends(curve) for curve in curves])  # (runs, k)
    reach = np.abs(ends).min(axis=0)
    same_sign = np.abs(np.sign(ends).sum(axis=0)) == len(curves)
    usable = same_sign & (reach >= SMALL_Y * reach.max(initial=0.0)) & (reach > 0.0)
    y = np.where(usable, np.sign(ends[0]) * reach, np.nan)[:, None] * share
    return Grid(end * share, y)


def sampled(curve: Curve, grid: Grid) -> Sample:
    """Return the quantities of a run on a grid that its curves reach."""
    values = {name: _between(curve.x, values, grid.x) for name, values in curve.by_x.items()}
    values[PY] = np.full(grid.y.shape, np.nan)
    for k, y in enumerate(grid.y):
        if np.isfinite(y).all():
            sign = np.sign(y[-1])
            rising = leading(sign * curve.y[k])
            values[PY][k] = _between(sign * curve.y[k, rising], curve.p[k, rising], sign * y)
    values[STIFFNESS] = np.array([curve.stiffness])
    return values


def common_grids(runs: Mapping[str, Mapping[str, Curve]]) -> dict[str, Grid]:
    """Return {path: grid} of runs {run: {path: curve}}, for the paths that all of them have."""
    paths = [name for name in next(iter(runs.values())) if all(name in curves for curves in runs.values())]
    return {path: common_grid([curves[path] for curves in runs.values()]) for path in paths}


def samples(
    runs: Mapping[str, Mapping[str, Curve]], grids: Mapping[str, Grid] | None = None
) -> dict[str, dict[str, Sample]]:
    """Return {path: {run: sample}} of runs {run: {path: curve}} on grids that all reach (None: the common ones)."""
    return {
        path: {run: sampled(curves[path], grid) for run, curves in runs.items()}
        for path, grid in (common_grids(runs) if grids is None else grids).items()
    }


def _y_ends(curve: Curve) -> Array:
    """Return the end (k,) of the first stretch of y that leads away from 0, with its sign; 0 without one."""
    ends = np.zeros(len(curve.y))
    for k, y in enumerate(curve.y):
        sign = np.sign(y[1] - y[0])
        ends[k] = y[leading(sign * y)[-1]] if sign else 0.0
    return ends


def _between(x: Array, values: Array, at: Array) -> Array:
    """Return the monotone cubic through (x, values) at points within their range (rounding beyond it is cut)."""
    return np.asarray(PchipInterpolator(x, values)(np.clip(at, x[0], x[-1])), dtype=float)
