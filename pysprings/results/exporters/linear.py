# SPDX-License-Identifier: MIT
"""A foundation as one matrix 6 x 6: in another frame, and the error of its linear response on the paths."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.stiffness import stiffness_six
from pysprings.springs.springs import Springs

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

_ROUNDING = 1.0e-6
SHARES = (0.1, 0.5, 1.0)  # of the range of a path where the linear response is compared


def stiffness_z_up(springs: Springs, torsion: float) -> Array:
    """Return the initial stiffness (6, 6) at the lid centre with z up [N/m, N/rad, N m/rad].

    Axes: x along the load, z up, y completing a right-handed set. `torsion` [N m/rad] is the user's own.

    Raises
    ------
    UserInputError
        Springs from a table without vertical stiffness.
    """
    matrix: Array = stiffness_six(springs, z_up=True, symmetric=True).values.copy()
    matrix[5, 5] = torsion
    return matrix + 0.0


def linear_errors(springs: Springs) -> list[str]:
    """Return a sentence for each lateral path: the loads of the initial stiffness over those of the full model.

    H and M of the matrix at the recorded motion (u, rotation), relative to the largest size of each load on the path
    up to there, at `SHARES` of the range.
    """
    lines = []
    for name, path in springs.paths.items():
        if path.is_vertical:
            continue
        data = path.dataset
        motion = np.stack([data["u"].values, data["rotation"].values])
        size = np.hypot(motion[0], motion[1] * springs.length)
        linear = springs.lateral_stiffness @ motion
        parts = []
        for share in SHARES:
            step = int(np.argmin(np.abs(size - share * size.max())))
            words = ", ".join(_errors(linear, data, step, springs.length))
            parts.append(f"at u = {1e3 * motion[0, step]:.3g} mm, rotation = {1e3 * motion[1, step]:.3g} mrad: {words}")
        lines.append(f"path {name} ({path.dataset.attrs['role']}): {'; '.join(parts)}")
    return lines


def _errors(linear: np.ndarray, data: xr.Dataset, step: int, length: float) -> Iterator[str]:
    """Yield the error of H and of M at a step; a load that is rounding beside the other one has none."""
    sizes = [np.abs(data[load].values[: step + 1]).max(initial=0.0) for load in "HM"]
    whole = max(sizes[0] * length, sizes[1])
    for k, (load, size) in enumerate(zip("HM", sizes, strict=True)):
        if size * (length if load == "H" else 1.0) > _ROUNDING * whole:
            error = (linear[k, step] - data[load].values[step]) / size
            yield f"{load} {100.0 * error + 0.0:+.1f} %"
