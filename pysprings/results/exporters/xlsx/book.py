# SPDX-License-Identifier: MIT
"""A workbook of springs: its look, defined names, text of the first sheet, data with all paths below each other.

Every curve, length and matrix has a defined name, so that formulas need no cell addresses. Long sheets are for the
screen and for formulas: they print their first rows on one page, and state it.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray
from xlsxwriter.utility import xl_range_abs

from pysprings.macro.fan import build_fan, has_fan
from pysprings.results.exporters.header import error_of_row, range_of_path
from pysprings.results.sheets import HEAD
from pysprings.springs.path import paths_of
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


Array = NDArray[np.float64]

HEAD_ROWS = 3  # depth, slice, heading with unit
MOST_PRINTED = 45  # rows of a data sheet
# variable of a path -> heading, factor from SI
QUANTITIES = {
    "u": ("u [mm]", 1e3), "w": ("w [mm]", 1e3), "rotation": ("rotation [mrad]", 1e3), "H": ("H [kN]", 1e-3),
    "V": ("V [kN]", 1e-3), "M": ("M [kN m]", 1e-3),
}  # fmt: skip


@dataclass
class Cells:
    """A column of a sheet: heading with unit, values by path, depth and slice of the heading, defined name or none."""

    heading: str
    parts: list[Array]
    depth: float | str = ""
    slice: str = ""
    name: str = ""


def plain_names(paths: Iterable[str]) -> dict[str, str]:
    """Return the names of paths as defined names may hold them, unique in any case of letters."""
    plain: dict[str, str] = {}
    for name in paths:
        text = re.sub(r"[^A-Za-z0-9_]", "_", name)
        while text.lower() in [used.lower() for used in plain.values()]:
            text += "_"
        plain[name] = text
    return plain


class Book:
    """A workbook with its formats, and the paths of its springs by name, unconverged steps included."""

    def __init__(self, file: xlsxwriter.Workbook, springs: xr.DataTree) -> None:
        self.file, self.springs = file, springs
        paths = paths_of(springs)
        self.paths = {name: path.recorded for name, path in paths.items()}
        self.down = [name for name, path in paths.items() if path.is_vertical]
        self.lateral = [name for name in self.paths if name not in self.down]
        self.plain = plain_names(self.paths)
        self.head = file.add_format(HEAD)
        self.title = file.add_format({"bold": True, "font_size": 13})
        self.number = file.add_format({"num_format": "0.000"})
        self.tenth = file.add_format({"num_format": "#,##0.0"})
        self.text = file.add_format({"text_wrap": True, "valign": "top"})
        self.mono = file.add_format({"font_name": "Consolas"})
        self.left = file.add_format({"align": "left"})

    def sheet(self, name: str) -> Any:
        """Add a sheet that prints in landscape on A4, one page wide, with page numbers."""
        sheet = self.file.add_worksheet(name)
        sheet.set_landscape()
        sheet.set_paper(9)
        sheet.set_margins(left=0.4, right=0.4, top=0.6, bottom=0.6)
        sheet.fit_to_pages(1, 0)
        sheet.set_footer("&L&A&RPage &P of &N")
        return sheet

    def define(self, name: str, sheet: str, first: tuple[int, int], last: tuple[int, int], path: str = "") -> None:
        """Define a name for the cells from first to last (row, column); of one path when it is given."""
        full = f"{name}.{self.plain[path]}" if path else name
        self.file.define_name(full, f"='{sheet}'!{xl_range_abs(*first, *last)}")

    def rows(self, names: Iterable[str]) -> dict[str, tuple[int, int]]:
        """Return the first and last row of each path on a data sheet."""
        rows, first = {}, HEAD_ROWS
        for name in names:
            rows[name] = (first, first + self.paths[name].sizes["step"] - 1)
            first = rows[name][1] + 1
        return rows

    def of(self, names: Iterable[str], variable: str, name: str = "", form: str = "{}") -> Cells:
        """Return the column of a variable by step (H_tip: as H of `QUANTITIES`), with its defined name."""
        heading, factor = QUANTITIES[variable.partition("_")[0]]
        values = [self.paths[each][variable].values * factor for each in names]
        return Cells(form.format(heading), values, name=name)

    def by_depth(self, headings: Mapping[str, str], values: Sequence[Sequence[Array]]) -> Iterator[Cells]:
        """Yield columns of arrays (depth, step) by heading and path: for each depth one a heading, names numbered."""
        first = next(iter(self.paths.values()))
        for k, (depth, (top, bottom)) in enumerate(
            zip(first["depth"].values, first["depth_bounds"].values, strict=True)
        ):
            for (heading, name), parts in zip(headings.items(), values, strict=True):
                named = f"{name}_{k + 1}" if name else ""
                label = f"{top:.3f} - {bottom:.3f}"
                yield Cells(heading, [part[k] for part in parts], round(float(depth), 4), label, named)

    def fill(self, sheet: Any, names: Sequence[str], columns: Sequence[Cells]) -> None:
        """Write path, step, the columns and the converged mark of paths below three heading rows."""
        rows = self.rows(names)
        last = max(end for _, end in rows.values())
        for row, words in enumerate((["depth [m]"], ["slice [m]"], ["path", "step"])):
            sheet.write_row(row, 0, words, self.head)
        for name, (first, end) in rows.items():
            sheet.write_column(first, 0, [name] * (end - first + 1))
            sheet.write_column(first, 1, range(end - first + 1))
        marks = Cells("converged (1 = yes)", [self.paths[name]["converged"].values for name in names])
        for col, column in enumerate([*columns, marks], start=2):
            for row, head in enumerate((column.depth, column.slice, column.heading)):
                sheet.write(row, col, head, self.head)
            write_numbers(sheet, HEAD_ROWS, col, np.concatenate(column.parts), None if column is marks else self.number)
            for path, (first, end) in rows.items() if column.name else ():
                self.define(column.name, sheet.name, (first, col), (end, col), path)
        sheet.repeat_columns(0, 1)
        sheet.set_column(0, 0, 14)
        sheet.set_column(1, 1, 6)
        sheet.set_column(2, 2 + len(columns), 11)
        finish(sheet, HEAD_ROWS, last + 1 - HEAD_ROWS, 3 + len(columns), 2)


def write_numbers(sheet: Any, row: int, col: int, values: Any, form: Any) -> None:
    """Write numbers down a column; what is not known stays empty."""
    numbers = np.asarray(values, dtype=float).tolist()
    sheet.write_column(row, col, [None if np.isnan(value) else value for value in numbers], form)


def finish(sheet: Any, head: int, rows: int, columns: int, fixed: int) -> None:
    """Freeze and repeat the headings, filter below them, and print a look at the first rows."""
    sheet.set_row(head - 1, 45)
    sheet.freeze_panes(head, fixed)
    sheet.repeat_rows(0, head - 1)
    sheet.autofilter(head - 1, 0, head + rows - 1, columns - 1)
    shown = min(rows, MOST_PRINTED)
    sheet.print_area(0, 0, head + shown - 1, columns - 1)
    sheet.fit_to_pages(1, 1)
    cut = f": the first {shown} of {rows} rows are printed" if shown < rows else ""
    sheet.set_footer(f"&L&A{cut}&RPage &P of &N")
