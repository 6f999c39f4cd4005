# SPDX-License-Identifier: MIT
"""Does the contact pressure alternate from point to point around the rings of a skirt?

Interfaces with a stiff penalty and coupled integration points show pressures that swing about the true ones
(Schellekens & de Borst 1993): stations open beside loaded ones. The measures are taken ring by ring (one side,
one depth, one step), on p'_N at the stations 0..pi of the half model and their mirror images:

    d_i = (p_{i-1} - 2 p_i + p_{i+1}) / mean        second difference

over the mean of the ring's p now, or in the first step where that is larger (a ring that is all but open has no
significant mean).

- ``second_difference``: the largest |d_i|. It also sees real curvature: a pressure that follows 1 + a cos(theta)
  gives a (azimuth step)^2, and the edge of an open zone gives the pressure beside it.
- ``alternation``: the largest min(|d_{i-1}|, |d_i|, |d_{i+1}|) where the three change sign from one to the next. A
  smooth curve, a kink and a step give next to nothing, a swing from point to point of +-s about the mean 4 s.
- ``isolated_open``: stations without pressure between two neighbours that carry some; an open zone that begins,
  narrower than the spacing of the stations, counts as one. A ring of bricks on a boundary of layers has two slices, and
  counts in each.
"""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

_DIMS = ("step", "side", "depth", "azimuth")


def contact_alternation(path: xr.Dataset) -> dict[str, Any] | None:
    """Measure alternation of the contact pressure along a path; None where interface fields were not kept.

    Parameters
    ----------
    path : normal_effective_stress (step, side, azimuth, depth) Pa, compression positive; azimuth from 0 to pi.

    Returns
    -------
    ``second_difference`` and ``alternation`` (dimensionless, largest over all steps and rings) with the places
    ``second_difference_at`` and ``alternation_at``; ``isolated_open`` (largest number at one step, both sides)
    with ``isolated_open_at_step``; ``stations``, the number of stations evaluated in each step.
    """
    if "normal_effective_stress" not in path or path.sizes["azimuth"] < 3:
        return None
    pressure = path["normal_effective_stress"].transpose(*_DIMS).values.astype(float)
    difference = _second_difference(pressure)
    swing = _swing(difference)
    isolated = _isolated_open(pressure).sum(axis=(1, 2, 3))
    return {
        "second_difference": float(np.abs(difference).max(initial=0.0)),
        "second_difference_at": _place(path, np.abs(difference)),
        "alternation": float(swing.max(initial=0.0)),
        "alternation_at": _place(path, swing),
        "isolated_open": int(isolated.max(initial=0)),
        "isolated_open_at_step": int(path["step"].values[int(np.argmax(isolated))]) if isolated.any() else None,
        "stations": int(np.prod(pressure.shape[1:])),
    }


def _mirrored(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values (..., azimuth) with a mirror image beyond each end: the loading plane is a symmetry plane."""
    return np.concatenate([values[..., 1:2], values, values[..., -2:-1]], axis=-1)


def _second_difference(pressure: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return second difference around each ring over the ring's mean pressure, see above; 0 without any pressure."""
    ring = _mirrored(pressure)
    share = np.ones(pressure.shape[-1])
    share[[0, -1]] = 0.5  # the stations in the symmetry plane count once on the whole ring, the others twice
    mean = (pressure * share).sum(axis=-1, keepdims=True) / share.sum()
    mean = np.maximum(mean, mean[:1])
    return (ring[..., :-2] - 2.0 * pressure + ring[..., 2:]) / np.where(mean > 0.0, mean, np.inf)


def _swing(difference: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return smallest size of three second differences that follow each other, where their signs alternate, else 0."""
    ring = _mirrored(difference)
    before, here, after = ring[..., :-2], difference, ring[..., 2:]
    size = np.minimum(np.minimum(np.abs(before), np.abs(here)), np.abs(after))
    return np.where((before * here < 0.0) & (here * after < 0.0), size, 0.0)


def _isolated_open(pressure: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return True where a station carries nothing and both neighbours in its ring do."""
    loaded = _mirrored(pressure) > 0.0
    return ~loaded[..., 1:-1] & loaded[..., :-2] & loaded[..., 2:]


def _place(path: xr.Dataset, measure: NDArray[np.float64]) -> str:
    """Return words for the place of the largest value; empty where all are 0."""
    if not measure.any():
        return ""
    step, side, depth, azimuth = np.unravel_index(int(np.argmax(measure)), measure.shape)
    degrees = np.degrees(float(path["azimuth"].values[azimuth]))
    where = f"azimuth {degrees:.0f}°, depth {float(path['depth'].values[depth]):.2f} m"
    return f"{path['side'].values[side]}, {where}, step {int(path['step'].values[step])}"
