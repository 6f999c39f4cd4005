# SPDX-License-Identifier: MIT
"""The header of files for other programs: origin, frame, units, conditions, range of validity, measured error."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.version import __version__
from pysprings.results.exporters.base import Source
from pysprings.springs.dataset import get_path, is_vertical, path_load, path_names
from pysprings.springs.path_ends import end_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance

_ERRORS = {
    "H": "load", "rotation": "rotation", "M": "moment", "u": "displacement at equal load", "V": "vertical load"
}  # fmt: skip


BACKBONE = "monotonic backbone of a nonlinear response, not cyclic"


def header(source: Source, target: str, frame: str, units: str, use: str = BACKBONE) -> list[str]:
    """Return the lines of a header, without comment signs.

    Parameters
    ----------
    source
        Springs of the export.
    target
        Program and kind of file.
    frame, units
        Axes with their signs, and units, of the numbers in the file.
    use
        A sentence on the kind of loading that the numbers stand for.
    """
    springs = source.springs
    attrs, given = springs.attrs, Springs.of(springs)
    rates = ", ".join(f"{1e3 * each.rate:.4g} mm/s" for each in given.rate_sets)
    return [
        f"{target}, written by pysprings {__version__}",
        f"scene: {attrs.get('title', 'not recorded')}; sha256 {attrs.get('scene_sha256', 'not recorded')}",
        f"springs by pysprings {attrs.get('pysprings_version', 'not recorded')}; "
        f"status {attrs.get('status', 'not recorded')}",
        f"frame: {frame}",
        f"units: {units}",
        f"drainage: {given.drainage}; rate: {rates or 'none: the springs do not depend on it'}; "
        f"vertical load at rest: {given.rest_load / 1e3:.6g} kN",
        use,
        *(f"range, path {name}: {range_of_path(springs, name)}" for name in path_names(springs)),
        *(
            f"measured error, path {row['path']}, springs {row['springs']}: {error_of_row(row)}"
            for row in source.comparison.to_dict("records")
        ),
    ]


def range_of_path(springs: xr.DataTree, name: str) -> str:
    """Return a sentence on the calibrated range of a path, its load, and its balance."""
    path = get_path(springs, name)
    missing, end = balance(path), end_of(name, path)
    ended = f" The path {end.words}." if end.failed else ""
    u, rotation, load = (float(np.abs(path[key].values).max()) for key in ("u", "rotation", "H"))
    if is_vertical(springs, name):
        w, V = path["w"].values, path["V"].values
        return (
            f"{springs.attrs['drainage']} vertical, {path.attrs['role']}, {path.attrs['status']}: "
            f"w from {1e3 * w[0]:.4g} to {1e3 * w[-1]:.4g} mm, "
            f"V from {1e-3 * V[0]:.5g} to {1e-3 * V[-1]:.5g} kN; out of balance by "
            f"{missing['V']:.1e} (V). Beyond this range every use is an extrapolation.{ended}"
        )
    return (
        f"{springs.attrs['drainage']} {path.attrs['kind']}, load {path.attrs['arm_m']:g} m above mudline, "
        f"{path.attrs['role']}, {path.attrs['status']}: |u| to {1e3 * u:.4g} mm, "
        f"|rotation| to {1e3 * rotation:.4g} mrad, |H| to {1e-3 * load:.5g} kN, V {1e-3 * path_load(path):.5g} kN; "
        f"out of balance by {missing['H']:.1e} (H), {missing['M']:.1e} (M). "
        f"Beyond this range every use is an extrapolation.{ended}"
    )


def error_of_row(row: pd.Series | dict) -> str:
    """Return a sentence on the errors of one row of the comparison."""
    parts = [
        f"{words} {round(row[f'{key}_error_max_pct'], 2) + 0.0:+.2f} %"
        for key, words in _ERRORS.items()
        if np.isfinite(row[f"{key}_error_max_pct"])
    ]
    source = f"springs of path {row['springs_from']}, {row['role']} path"
    errors = f"largest error against the full model: {', '.join(parts)}; eta {row['eta_large']:.4f}"
    return f"{errors} ({source}; {row['status']})"
