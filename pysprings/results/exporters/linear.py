# SPDX-License-Identifier: MIT
"""A foundation as one matrix 6 x 6: in another frame, and the error of its linear response on the paths."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.path_kinds import has_free_head
from pysprings.core.text import plain_table
from pysprings.macro.model import MacroModel
from pysprings.macro.stiffness import Form, in_form, secant, stiffness_six
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

SMALL = 0.01  # share of H L or of M in the larger of both below which an error of the load means nothing
SHARES = (0.1, 0.5, 1.0)  # of the range of a path where the linear response is compared
_HEAD = (
    "error of the linear response in H and M at 10, 50 and 100 % of the range of each path, in percent of the largest "
    f"H and M on the path ('-': below {100 * SMALL:g} % of the other load):"
)
AT_REST = (
    "linear: stiffness at rest, which the caisson has at no load; beside it secants of the springs, and its errors"
)
_SECANTS = (
    "stiffness at rest, and the secant of the springs at 10 and 50 % of the range of paths [MN/m, MN/rad, MN m/rad]:"
)
_SECANT_COLUMNS = ("state", "|u| [mm]", "|rotation| [mrad]", "Kxx", "Kxty", "Ktyty")
_COLUMNS = ("path", "role", "u [mm]", "rotation [mrad]", *(f"{load} {100 * s:g} %" for load in "HM" for s in SHARES))


def at_lid(springs: Springs) -> Array:
    """Return the initial stiffness (6, 6) at the lid centre [N/m, N/rad, N m/rad], symmetric.

    Axes are those of `stiffness_six`; so is torsion.

    Raises
    ------
    UserInputError
        Springs from a table without vertical stiffness.
    """
    matrix: Array = stiffness_six(springs, symmetric=True).values + 0.0
    return matrix


def linear_words(springs: Springs) -> list[str]:
    """Return the lines that stand beside a matrix of the caisson at rest: what it is, secants, and its errors."""
    return [AT_REST, *secants(springs), *linear_errors(springs)]


def secants(springs: Springs) -> list[str]:
    """Return the lines of a table: stiffness at rest, then the secants at 10 and 50 % of the range of lateral paths.

    The secant is that of the springs that predict, at recorded states of the paths with a free head (of all lateral
    ones where there is none), in the frame and the words of the matrix.
    """
    lateral = [path for path in springs.paths.values() if not path.is_vertical]
    rows = [("at rest", "", "", *_entries(at_lid(springs)[np.ix_([0, 4], [0, 4])]))]
    for path in [each for each in lateral if has_free_head(each.attrs)] or lateral:
        model = MacroModel.from_springs(springs.answering(path))
        motion = np.stack([path.u, path.rotation])
        for share, step in zip(SHARES[:2], _steps(motion, springs.length), strict=False):
            matrix = in_form(secant(model, *motion[:, step]), Form(symmetric=True))
            size = [f"{1e3 * value + 0.0:.3g}" for value in np.abs(motion[:, step])]
            rows.append((f"{path.name}, {100 * share:g} %", *size, *_entries(matrix[np.ix_([0, -1], [0, -1])])))
    return [_SECANTS, *plain_table(_SECANT_COLUMNS, rows).splitlines()]


def _entries(matrix: Array) -> list[str]:
    return [f"{1e-6 * value:.4g}" for value in (matrix[0, 0], matrix[0, 1], matrix[1, 1])]


def _steps(motion: Array, length: float) -> list[int]:
    """Return the steps at `SHARES` of the largest size of a motion (2, step)."""
    size = np.hypot(motion[0], motion[1] * length)
    return [int(np.argmin(np.abs(size - share * size.max()))) for share in SHARES]


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
        steps = _steps(motion, springs.length)
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
