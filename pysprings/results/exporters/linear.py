# SPDX-License-Identifier: MIT
"""A foundation as one matrix 6 x 6: in another frame, and the error of its linear response on the paths."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.core.text import plain_table
from pysprings.macro.stiffness import stiffness_six
from pysprings.springs.springs import Springs

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SMALL = 0.01  # share of H L or of M in the larger of both below which an error of the load means nothing
SHARES = (0.1, 0.5, 1.0)  # of the range of a path where the linear response is compared
_HEAD = (
    "error of the linear response in H and M at 10, 50 and 100 % of the range of each path, in percent of the largest "
    f"H and M on the path ('-': below {100 * SMALL:g} % of the other load):"
)
_COLUMNS = ("path", "role", "u [mm]", "rotation [mrad]", *(f"{load} {100 * s:g} %" for load in "HM" for s in SHARES))


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
    """Return the lines of a table with a row for each lateral path: errors of the initial stiffness in H and M.

    Loads of the matrix at the recorded motion (u, rotation) less those of the full model, relative to the largest size
    of each load on the whole path, at `SHARES` of the range.
    """
    rows = []
    for name, path in springs.paths.items():
        if path.is_vertical:
            continue
        data = path.dataset
        motion = np.stack([data["u"].values, data["rotation"].values])
        size = np.hypot(motion[0], motion[1] * springs.length)
        steps = [int(np.argmin(np.abs(size - share * size.max()))) for share in SHARES]
        end = [f"{1e3 * value + 0.0:.3g}" for value in motion[:, steps[-1]]]
        words = _words(springs.lateral_stiffness @ motion, data, springs.length, steps)
        rows.append((name, str(data.attrs["role"]), *end, *words))
    return [_HEAD, *plain_table(_COLUMNS, rows, (True, True)).splitlines()] if rows else []


def _words(linear: Array, data: xr.Dataset, length: float, steps: Sequence[int]) -> list[str]:
    """Return the errors of H, then of M, at steps; "-" of a load that is small beside the other one."""
    sizes = [float(np.abs(data[load].values).max(initial=0.0)) for load in "HM"]
    whole = max(sizes[0] * length, sizes[1])
    words = []
    for row, (load, size, arm) in enumerate(zip("HM", sizes, (length, 1.0), strict=True)):
        counts = size * arm > SMALL * whole
        for step in steps:
            error = 100.0 * (linear[row, step] - float(data[load][step])) / size if counts else 0.0
            words.append(f"{error + 0.0:+.1f}" if counts else "-")
    return words
