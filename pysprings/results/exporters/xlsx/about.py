# SPDX-License-Identifier: MIT
"""The text of the first sheet of the workbook: origin, units, signs, range of validity, measured error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.macro.fan import build_fan, has_fan
from pysprings.results.exporters.header import error_of_row, range_of_path
from pysprings.springs.springs import Springs

# Line of the About sheet -> defined name of its number.
LENGTHS = {
    "outer diameter [m]": "outer_diameter",
    "skirt length [m]": "skirt_length",
    "skirt thickness [m]": "skirt_thickness",
}

# Pattern -> what it holds; PATH is the name of a load path, K the number of a depth from the top.
MEANING = {
    "y_K.PATH, p_K.PATH": "p-y curve of the K-th depth from the top (mm, kN/m)",
    "theta.PATH, m_K.PATH, t_K.PATH": "rotation (mrad), distributed moment and vertical reaction of the K-th depth",
    "y_base.PATH, H_base.PATH, V_base.PATH, M_base.PATH": "tip (mm, kN, kN m)",
    "y_lid.PATH, H_lid.PATH, V_lid.PATH, M_lid.PATH": "lid (mm, kN, kN m)",
    "u.PATH, w.PATH, rotation.PATH, H.PATH, V.PATH, M.PATH": "motion and load of the full model (mm, mrad, kN, kN m)",
    "w_tz.PATH, V_tz.PATH, tz_K.PATH": "vertical paths: w (mm), V (kN), vertical reaction of the K-th depth (kN/m)",
    "K_3x3, K_6x6": "initial stiffness of the full model at mudline (kN, m, rad)",
    "outer_diameter, skirt_length, skirt_thickness": "lengths (m)",
    "all curves": "one row a step, the rows of unconverged steps included",
}

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
    "            H --->          acts at height arm above mudline: M = H*arm",
    "               |",
    "   +-----------O-----------+   lid, mudline, depth 0      O ----> x, u, y, H",
    "   |                       |                              |",
    "   |  p(z) on the caisson  |   skirt                      v   z = depth, w, V (down)",
    "   |  <---                 |",
    "   |                       |   depth L, tip               y axis: away from the reader",
    "",
    "   rotation and M: positive where it leans towards x (clockwise here); a load above mudline has M > 0",
)

_TERMS = (
    (
        "units",
        "kN, m, mm, mrad; the unit is in every heading. p, m and t are per metre of depth: multiply by the "
        "height of the slice for a force or moment per ring.",
    ),
    (
        "signs",
        "Reactions are positive when they oppose a positive displacement. y = u - rotation*depth (of a rigid caisson). "
        "w and V are positive down.",
    ),
    (
        "depth, slice",
        "where the forces of a slice act; slice = a part of the skirt, its last fifth as one: p of thinner slices at "
        "the tip depends on the mesh.",
    ),
    ("base, lid", "tip: H, V and M about the axis point at the depth of the tip; lid: about O."),
    ("balance", "H = sum p*dz + H_tip + H_lid;  M = -(sum p*z*dz + L*H_tip) + sum m*dz + M_tip + M_lid"),
    (
        "curves",
        "monotonic backbone, not cyclic. Each holds for the path it was read from: p(y) from one load height "
        "does not hold at another.",
    ),
)


def about_lines(
    springs: xr.DataTree, comparison: pd.DataFrame, summary: Mapping[str, str]
) -> Iterator[tuple[str, str, str]]:
    """Yield (kind, name, words) line by line; kind is title, text or mono."""
    if summary:
        yield "title", "Summary", ""
        yield from (("text", name, text) for name, text in summary.items())
        yield "text", "", ""
    yield "title", "Springs of a suction caisson", ""
    for key, name in _ORIGIN.items():
        if key in springs.attrs:
            yield "text", name, str(springs.attrs[key])
    yield "text", "", ""
    yield "title", "Axes and signs", ""
    yield from (("mono", "", line) for line in _SKETCH)
    yield "text", "", ""
    yield "title", "What the numbers are", ""
    yield from (("text", name, words) for name, words in _TERMS)
    yield "text", "", ""
    yield "title", "Names for formulas (PATH: a load path; K: number of a depth from the top)", ""
    yield from (("text", "", f"{pattern}: {words}") for pattern, words in MEANING.items())
    yield "text", "", ""
    yield "title", "Range of validity", ""
    given = Springs.of(springs)
    yield from (("text", "fan", words) for words in _fan(given))
    yield from (("text", f"path {name}", range_of_path(given.drainage, path)) for name, path in given.paths.items())
    yield "text", "", ""
    yield "title", "Error of a rigid body on these springs", ""
    yield from (("text", f"{row['path']}, {row['springs']}", error_of_row(row)) for _, row in comparison.iterrows())


def _fan(springs: Springs) -> Iterator[str]:
    """Yield a sentence on the range of the fan, and on its use beyond a spreadsheet; nothing without a fan."""
    if not has_fan(springs):
        return
    table = build_fan(springs)
    rays = zip(table.path, np.degrees(table.angle), 1e3 * table.range, strict=True)
    shown = ", ".join(f"{name} ({angle:.1f} deg, to {reach:.4g} mm)" for name, angle, reach in rays)
    yield (
        f"rays of constant rotation/u, angle in the plane (u, rotation*skirt_length), length in it: {shown}. "
        "`pysprings predict` interpolates between them; a curve in these sheets holds on its own ray only."
    )
