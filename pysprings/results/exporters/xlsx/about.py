# SPDX-License-Identifier: MIT
"""The text of the first sheet of the workbook: origin, units, signs, range of validity, measured error."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.macro.fan import build_fan, has_fan
from pysprings.results.exporters.xlsx.names import MEANING
from pysprings.springs.dataset import get_path, is_vertical, path_load, path_names
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance

_ORIGIN = {
    "title": "scene",
    "source": "made by",
    "scene_sha256": "scene sha256",
    "drainage": "drainage",
    "outer_diameter_m": "outer diameter [m]",
    "skirt_length_m": "skirt length [m]",
    "skirt_thickness_m": "skirt thickness [m]",
    "vertical_load_N": "vertical load [N]",
    "status": "status of the run",
    "history": "history",
}

_SKETCH = (
    "            H --->          acts at height arm above mudline: M = -H*arm",
    "               |",
    "   +-----------O-----------+   lid, mudline, depth 0      O ----> x, u, y, H",
    "   |                       |                              |",
    "   |  p(z) on the caisson  |   skirt                      v   z = depth, w, V (down)",
    "   |  <---                 |",
    "   |                       |   depth L, tip               y axis: towards the reader",
    "",
    "   rotation and M: right-hand about the y axis (counter-clockwise here); a pull H > 0 rotates < 0",
)

_MEANING = (
    (
        "units",
        "kN, m, mm, mrad; the unit is in every heading. p, m and t are per metre of depth: multiply by the "
        "height of the slice for a force or moment per ring.",
    ),
    (
        "signs",
        "Reactions are positive when they oppose a positive displacement. y = u + rotation*depth (of a rigid caisson). "
        "w and V are positive down.",
    ),
    ("depth, slice", "depth of the ring of stations; slice = the part of the skirt that it represents."),
    ("base, lid", "tip: H, V and M about the axis point at the depth of the tip; lid: about O."),
    ("balance", "H = sum p*dz + H_tip + H_lid;  M = sum (p*z + m)*dz + L*H_tip + M_tip + M_lid"),
    (
        "curves",
        "monotonic backbone, not cyclic. Each holds for the path it was read from: p(y) from one load height "
        "does not hold at another.",
    ),
)


def about_lines(springs: xr.DataTree, comparison: pd.DataFrame) -> Iterator[tuple[str, str, str]]:
    """Yield (kind, name, words) line by line; kind is title, text or mono."""
    yield "title", "Springs of a suction caisson", ""
    for key, name in _ORIGIN.items():
        if key in springs.attrs:
            yield "text", name, str(springs.attrs[key])
    yield "text", "", ""
    yield "title", "Axes and signs", ""
    yield from (("mono", "", line) for line in _SKETCH)
    yield "text", "", ""
    yield "title", "What the numbers are", ""
    yield from (("text", name, words) for name, words in _MEANING)
    yield "text", "", ""
    yield "title", "Names for formulas (PATH: a load path; K: number of a depth from the top)", ""
    yield from (("text", "", f"{pattern}: {words}") for pattern, words in MEANING.items())
    yield "text", "", ""
    yield "title", "Range of validity", ""
    yield from (("text", "fan", words) for words in _fan(springs))
    yield from (("text", f"path {name}", _range(springs, name)) for name in path_names(springs))
    yield "text", "", ""
    yield "title", "Error of a rigid body on these springs", ""
    yield from (("text", f"{row['path']}, {row['springs']}", _error(row)) for _, row in comparison.iterrows())


def _fan(springs: xr.DataTree) -> Iterator[str]:
    """Yield a sentence on the range of the fan, and on its use beyond a spreadsheet; nothing without a fan."""
    given = Springs.of(springs)
    if not has_fan(given):
        return
    table = build_fan(given)
    rays = zip(table.path, np.degrees(table.angle), 1e3 * table.range, strict=True)
    shown = ", ".join(f"{name} ({angle:.1f} deg, to {reach:.4g} mm)" for name, angle, reach in rays)
    yield (
        f"rays of constant rotation/u, angle in the plane (u, rotation*skirt_length), length in it: {shown}. "
        "`pysprings predict` interpolates between them; a curve in these sheets holds on its own ray only."
    )


def _range(springs: xr.DataTree, name: str) -> str:
    path = get_path(springs, name)
    missing = balance(path)
    u, rotation, load = (float(np.abs(path[key].values).max()) for key in ("u", "rotation", "H"))
    if is_vertical(springs, name):
        w, V = path["w"].values, path["V"].values
        return (
            f"{springs.attrs['drainage']} vertical, {path.attrs['role']}, {path.attrs['status']}: "
            f"w from {1e3 * w[0]:.4g} to {1e3 * w[-1]:.4g} mm, "
            f"V from {1e-3 * V[0]:.5g} to {1e-3 * V[-1]:.5g} kN; out of balance by "
            f"{missing['V']:.1e} (V). Beyond this range every use is an extrapolation."
        )
    return (
        f"{springs.attrs['drainage']} {path.attrs['kind']}, load {path.attrs['arm_m']:g} m above mudline, "
        f"{path.attrs['role']}, {path.attrs['status']}: |u| to {1e3 * u:.4g} mm, "
        f"|rotation| to {1e3 * rotation:.4g} mrad, |H| to {1e-3 * load:.5g} kN, V {1e-3 * path_load(path):.5g} kN; "
        f"out of balance by {missing['H']:.1e} (H), {missing['M']:.1e} (M). "
        "Beyond this range every use is an extrapolation."
    )


def _error(row: pd.Series) -> str:
    names = {"H": "load", "rotation": "rotation", "M": "moment", "u": "displacement at equal load",
             "V": "vertical load"}  # fmt: skip
    parts = [
        f"{words} {round(row[f'{key}_error_max_pct'], 2) + 0.0:+.2f} %"
        for key, words in names.items()
        if np.isfinite(row[f"{key}_error_max_pct"])
    ]
    source = f"springs of path {row['springs_from']}, {row['role']} path"
    errors = f"largest error against the full model: {', '.join(parts)}; eta {row['eta_large']:.4f}"
    return f"{errors} ({source}; {row['status']})"
