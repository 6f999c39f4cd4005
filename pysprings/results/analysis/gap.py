# SPDX-License-Identifier: MIT
"""Where the interface is open, and how wide: skirt, lid and tip at a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

MM, DEG = 1e3, 180.0 / np.pi  # from SI to the units of the texts

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Opening:
    """The widest opening of one surface: width [m] and a description of its place."""

    surface: str
    width: float
    place: str

    def text(self) -> str:
        """Return a label of two lines: ``outside: max 0.043 mm``, ``at azimuth 180 deg, depth 0.25 m``."""
        if not self.width > 0:
            return f"{self.surface}: closed everywhere"
        return f"{self.surface}: max {self.width * MM:.3g} mm\nat {self.place}"


def openings(path: xr.Dataset, step: int) -> list[Opening]:
    """Return the widest opening [m] of each surface of the caisson at a step, with its place."""
    widest = [_skirt_opening(path, step, str(side)) for side in path["side"].values]
    for surface, name in (("lid", "under the lid"), ("tip", "under the tip")):
        if f"{surface}_gap" in path:
            widest.append(_plan_opening(path, step, surface, name))
    return widest


def skirt_gap(path: xr.Dataset, step: int, side: str) -> NDArray[np.float64]:
    """Return the opening [m] of one side, shape (depth, azimuth); penetration counts as closed."""
    values = path["gap"].sel(side=side).transpose("step", "depth", "azimuth").values[step]
    return np.maximum(values, 0.0)


def _skirt_opening(path: xr.Dataset, step: int, side: str) -> Opening:
    gap = skirt_gap(path, step, side)
    if not np.isfinite(gap).any():
        return Opening(side, 0.0, "")
    k, i = np.unravel_index(np.nanargmax(gap), gap.shape)
    place = f"azimuth {path['azimuth'].values[i] * DEG:.0f}°, depth {path['depth'].values[k]:.2f} m"
    return Opening(side, float(gap[k, i]), place)


def _plan_opening(path: xr.Dataset, step: int, surface: str, name: str) -> Opening:
    x, y, gap = plan_gap(path, step, surface)
    if not np.isfinite(gap).any():
        return Opening(name, 0.0, "")
    k = int(np.nanargmax(gap))
    place = f"azimuth {np.arctan2(abs(y[k]), x[k]) * DEG:.0f}°, radius {np.hypot(x[k], y[k]):.2f} m"
    return Opening(name, float(gap[k]), place)


def plan_gap(path: xr.Dataset, step: int, surface: str) -> tuple[NDArray[np.float64], ...]:
    """Return x, y and opening [m] of the stations under the lid or the tip, each (point,)."""
    gap = path[f"{surface}_gap"].transpose("step", f"{surface}_point").values[step]
    return path[f"{surface}_x"].values, path[f"{surface}_y"].values, np.maximum(gap, 0.0)
