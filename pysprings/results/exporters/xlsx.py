# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set for design spreadsheets: kN, m, mm, mrad, with charts.

Sheets: About, charts, p-y, m-theta, t-z (of vertical paths), base, lid, load-displacement, six degrees (where a path
leaves the plane of x), stiffness 6x6, tidy (a row for each path, step and depth, for pivots). Data sheets hold all
paths below each other: columns path and step, then the values; every heading has its unit and a filter.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
import xlsxwriter
from xlsxwriter.utility import xl_range_abs

from pysprings.core.arrays import Array
from pysprings.core.storage import replacing
from pysprings.core.variables import known_torsion
from pysprings.macro.fan import build_fan
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.stiffness import AT_REST, NO_TORSION, stiffness_six
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.results.exporters.header import error_of_row, of_atlas, range_of_path
from pysprings.results.exporters.tables import leaves_plane, load_displacement, with_net
from pysprings.results.sheets import HEAD, PLAIN_CELLS
from pysprings.springs.path import paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import by_depth, displacement_at

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
        if text := str(springs.attrs.get(key, "")):
            yield "text", name, text
    given = Springs.of(springs)
    yield from (("text", "atlas", words) for words in of_atlas(given))
    yield "text", "", ""
    yield "title", "Axes and signs", ""
    yield from (("mono", "", line) for line in _SKETCH)
    yield "text", "", ""
    yield "title", "What the numbers are", ""
    yield from (("text", name, words) for name, words in _TERMS)
    yield "text", "", ""
    yield "title", "Names for formulas (PATH: a load path; K: number of a depth from the top)", ""
    words = {pattern: text.replace("the full model", given.reference) for pattern, text in MEANING.items()}
    yield from (("text", "", f"{pattern}: {text}") for pattern, text in words.items())
    yield "text", "", ""
    yield "title", "Range of validity", ""
    yield from (("text", "fan", words) for words in _fan(given))
    yield from (("text", f"path {name}", range_of_path(given.drainage, path)) for name, path in given.paths.items())
    yield from (
        ("text", f"path {path.name}", f"{path.kind}, {path.role}, {path.attrs['status']}: {_OUT_OF_PLANE}")
        for path in given.space.values()
    )
    yield "text", "", ""
    yield "title", "Error of a rigid body on these springs", ""
    yield from (
        ("text", f"{row['path']}, {row['springs']}", error_of_row(row, given.reference))
        for _, row in comparison.iterrows()
    )


_SIX_DEGREES = "six degrees"  # sheet
_OUT_OF_PLANE = (
    f"it leaves the plane of one load; motions and loads are in sheet '{_SIX_DEGREES}', reactions by depth (p_x, p_y, "
    "t, torque) in springs.nc and its JSON, group 'space', not in these sheets; of an extrapolated run H and M are "
    "those of its mesh, which load_displacement.csv has, times what the extrapolation makes of a translation"
)


def _fan(springs: Springs) -> Iterator[str]:
    """Yield a sentence on the range of the fan, and on its use beyond a spreadsheet; nothing without a fan."""
    if not springs.has_fan:
        return
    table = build_fan(springs)
    rays = zip(table.path, np.degrees(table.angle), 1e3 * table.range, strict=True)
    shown = ", ".join(f"{name} ({angle:.1f} deg, to {reach:.4g} mm)" for name, angle, reach in rays)
    yield (
        f"rays of constant rotation/u, angle in the plane (u, rotation*skirt_length), length in it: {shown}. "
        "`pysprings predict` interpolates between them; a curve in these sheets holds on its own ray only."
    )


HEAD_ROWS = 3  # depth, slice, heading with unit
ROUNDING, FEW_DIGITS = 1e-9, 0.1  # mm, mrad, kN ...: below the second the format 0.000 hides digits
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


_SIDES_APART = ("outside", "inside")  # words of headings; an atlas has both sides together


class Book:
    """A workbook with its formats, and the paths of its springs by name, unconverged steps included."""

    def __init__(self, file: xlsxwriter.Workbook, springs: xr.DataTree) -> None:
        self.file, self.springs = file, springs
        paths = paths_of(springs)
        self.paths = {name: path.recorded for name, path in paths.items()}
        self.down = [name for name, path in paths.items() if path.is_vertical]
        self.lateral = [name for name in self.paths if name not in self.down]
        self.plain = plain_names(self.paths)
        given = Springs.of(springs)
        self.recorded = given.reference.removeprefix("the ")  # what the paths are of
        self.left_out = _SIDES_APART if given.of_atlas else ()
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

    def of(self, names: Iterable[str], variable: str, name: str = "", head: str = "") -> Cells:
        """Return the column of a variable by step (H_tip: as H of `QUANTITIES`), with its defined name."""
        heading, factor = QUANTITIES[variable.partition("_")[0]]
        values = [self.paths[each][variable].values * factor for each in names]
        return Cells(head or heading, values, name=name)

    def by_depth(self, headings: Mapping[str, str], values: Sequence[Sequence[Array]]) -> Iterator[Cells]:
        """Yield columns of arrays (depth, step) by heading and path: for each depth one a heading, names numbered."""
        first = next(iter(self.paths.values()))
        for k, (depth, (top, bottom)) in enumerate(
            zip(first["depth"].values, first["depth_bounds"].values, strict=True)
        ):
            for (heading, name), parts in zip(headings.items(), values, strict=True):
                if any(side in heading for side in self.left_out):
                    continue
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
    """Write numbers down a column; what is not known stays empty, and small numbers keep their digits."""
    for k, value in enumerate(np.asarray(values, dtype=float).tolist()):
        if not np.isnan(value):
            sheet.write_number(row + k, col, value, None if ROUNDING < abs(value) < FEW_DIGITS else form)


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


KN, MM = 1e-3, 1e3


def write(source: Source, target: Target, _options: Options) -> Exported:
    """Write the workbook of springs atomically."""
    springs, options = source.tables, {**PLAIN_CELLS, "in_memory": True}  # no temporary file is left elsewhere
    with replacing(target.path) as temporary, xlsxwriter.Workbook(str(temporary), options) as file:
        about = {"title": str(springs.attrs.get("title", "")), "comments": str(springs.attrs.get("source", ""))}
        file.set_properties(about)
        book = Book(file, springs)
        _about(book, book.sheet("About"), source)
        charts = book.sheet("charts")
        _py(book, book.sheet("p-y"))
        _mtheta(book, book.sheet("m-theta"))
        if book.down:
            _tz(book, book.sheet("t-z"))
        for part, name in (("tip", "base"), ("lid", "lid")):
            _end(book, book.sheet(name), part)
        _load(book, book.sheet("load-displacement"), source)
        if leaves_plane(source.springs):
            _in_space(book, book.sheet(_SIX_DEGREES), load_displacement(source.springs))
        _stiffness(book, book.sheet("stiffness 6x6"))
        add_charts(book, charts, spring_sets(source.springs))
        _tidy(book, book.sheet("tidy"))
    return Exported([target.path])


def _about(book: Book, sheet: Any, source: Source) -> None:
    sheet.set_column(0, 0, 26)
    sheet.set_column(1, 1, 110)
    formats = {"title": book.title, "text": book.text, "mono": book.mono}
    for row, (kind, name, words) in enumerate(about_lines(source.springs, source.comparison, source.summary)):
        sheet.write_string(row, 0, name, book.title if kind == "title" else book.text)
        if name in LENGTHS:
            sheet.write_number(row, 1, float(words), book.left)
            book.define(LENGTHS[name], "About", (row, 1), (row, 1))
        elif words:
            sheet.write_string(row, 1, words, formats[kind])
            if kind == "text":
                sheet.set_row(row, 15 * -(-max(len(words), 1) // 100))


def _sides(path: xr.Dataset, name: str) -> Array:
    """Return p, m or t (outside, inside, net; depth, step) [kN/m, kN m/m]."""
    values = path["p_component"].sum("component") if name == "p" else path[name]
    return with_net(values.transpose("side", "depth", "step").values * KN, 0)


def _py(book: Book, sheet: Any) -> None:
    y = [path["y"].transpose("depth", "step").values * MM for path in book.paths.values()]
    p = [_sides(path, "p") for path in book.paths.values()]
    headings = {"y [mm]": "y", "p net [kN/m]": "p", "p outside [kN/m]": "", "p inside [kN/m]": ""}
    values = [y, *([each[side] for each in p] for side in (2, 0, 1))]
    book.fill(sheet, list(book.paths), [*book.by_depth(headings, values)])


def _mtheta(book: Book, sheet: Any) -> None:
    m = [_sides(path, "m") for path in book.paths.values()]
    t = [path["t"].sum("side").transpose("depth", "step").values * KN for path in book.paths.values()]
    headings = {"m net [kN m/m]": "m", "m outside [kN m/m]": "", "m inside [kN m/m]": "", "t net [kN/m]": "t"}
    values = [*([each[side] for each in m] for side in (2, 0, 1)), t]
    names = list(book.paths)
    columns = [book.of(names, "rotation", "theta"), book.of(names, "w"), *book.by_depth(headings, values)]
    book.fill(sheet, names, columns)


def _tz(book: Book, sheet: Any) -> None:
    """Write V, its part on tip and lid, and t by depth, over w; vertical paths only."""
    t = [_sides(book.paths[name], "t") for name in book.down]
    ends = [book.of(book.down, f"V_{part}", head=f"V {part} [kN]") for part in ("tip", "lid")]
    headings = {"t net [kN/m]": "tz", "t outside [kN/m]": "", "t inside [kN/m]": ""}
    by = book.by_depth(headings, [[each[side] for each in t] for side in (2, 0, 1)])
    book.fill(sheet, book.down, [book.of(book.down, "w", "w_tz"), book.of(book.down, "V", "V_tz"), *ends, *by])


def _end(book: Book, sheet: Any, part: str) -> None:
    depth = float(book.springs.attrs["skirt_length_m"]) if part == "tip" else 0.0
    y = [displacement_at(path, depth) * MM for path in book.paths.values()]
    names = list(book.paths)
    columns = [Cells("y [mm]", y, name=f"y_{sheet.name}"), book.of(names, "rotation"), book.of(names, "w")]
    columns += [book.of(names, f"{load}_{part}", f"{load}_{sheet.name}") for load in ("H", "V", "M")]
    for column in columns:
        column.depth = depth
    book.fill(sheet, names, columns)


def _load(book: Book, sheet: Any, source: Source) -> None:
    """Write the recorded paths, then the macro-model on each spring set there; unreached cells stay empty."""
    names = list(book.paths)
    columns = [book.of(names, each, each, f"{book.recorded} {head}") for each, (head, _) in QUANTITIES.items()]
    for spring_set in spring_sets(source.springs):
        for variable in ("H", "rotation", "M"):
            heading, factor = QUANTITIES[variable]
            parts = []
            for name, path in book.paths.items():
                trace = source.predictions[name].get(spring_set)
                out, good = np.full(path.sizes["step"], np.nan), np.flatnonzero(path["converged"].values == 1)
                values = np.zeros(0) if trace is None else trace[variable].values * factor
                out[good[: values.size]] = values
                parts.append(out)
            columns.append(Cells(f"macro-model, {spring_set} springs: {heading}", parts))
    book.fill(sheet, names, columns)


_SMALL = {"m": ("mm", 1e3), "rad": ("mrad", 1e3), "N": ("kN", 1e-3), "Nm": ("kN m", 1e-3), "s": ("s", 1.0)}


def _in_space(book: Book, sheet: Any, frame: pd.DataFrame) -> None:
    """Write motions and loads of all paths by step, z up, rotations right-handed, one heading row."""
    for col, name in enumerate(frame):
        quantity, _, unit = str(name).rpartition("_")
        unit, factor = _SMALL.get(unit, ("", 1.0))
        sheet.write(0, col, f"{quantity} [{unit}]" if unit else str(name), book.head)
        if name == "path":
            sheet.write_column(1, col, frame[name])
        else:
            write_numbers(sheet, 1, col, factor * frame[name], book.number if unit else None)
    sheet.set_column(0, 0, 14)
    finish(sheet, 1, len(frame), frame.shape[1], 2)


_TIDY = (
    "path", "role", "step", "converged (1 = yes)", "depth [m]", "slice top [m]", "slice bottom [m]",
    "u [mm]", "w [mm]", "rotation [mrad]", "y [mm]",
    "p net [kN/m]", "m net [kN m/m]", "t net [kN/m]",
)  # fmt: skip


def _tidy(book: Book, sheet: Any) -> None:
    """Write the net reactions of all paths: a row for each path, step and depth, one heading row, for pivots."""
    sheet.write_row(0, 0, _TIDY, book.head)
    row = 1
    for name, path in book.paths.items():
        step, depth = (index.ravel() for index in np.indices((path.sizes["step"], path.sizes["depth"])))
        sheet.write_column(row, 0, [name] * step.size)
        sheet.write_column(row, 1, [str(path.attrs.get("role", ""))] * step.size)
        columns = [
            step, path["converged"].values[step], path["depth"].values[depth], *path["depth_bounds"].values[depth].T,
            *(path[key].values[step] * QUANTITIES[key][1] for key in ("u", "w", "rotation")),
            path["y"].transpose("step", "depth").values.ravel() * MM,
            *(by_depth(path, key).T.ravel() * KN for key in ("p", "m", "t")),
        ]  # fmt: skip
        for col, values in enumerate(columns, start=2):
            write_numbers(sheet, row, col, values, book.number if col >= 4 else None)
        row += step.size
    sheet.set_column(0, 1, 14)
    sheet.set_column(2, len(_TIDY) - 1, 11)
    finish(sheet, 1, row - 1, len(_TIDY), 1)


PRINTED = 31  # rows of a printed page of stiffnesses
_SIX = (("Fx [kN]", "Fy [kN]", "Fz [kN]", "Mx [kN m]", "My [kN m]", "Mz [kN m]"),
        ("per x [m]", "per y [m]", "per z [m]", "per rx [rad]", "per ry [rad]", "per rz [rad]"))  # fmt: skip
_THREE = (("H [kN]", "V [kN]", "M [kN m]"), ("per u [m]", "per w [m]", "per rotation [rad]"))
_NOTES = (
    "Axes: x along the load, y to its left seen from above, z up; rotations right-hand. The caisson at rest is "
    "axisymmetric: what holds for (x, ry) holds for (y, -rx).",
    "About another point: `pysprings predict ... --stiffness --reference-depth LENGTH`.",
    "Springs of one path at rest: slope of the first recorded step, below the initial one above; w has the elastic "
    "stiffness above.",
)


def _stiffness(book: Book, sheet: Any) -> None:
    """Write the full model's initial stiffness as 6 x 6, then the 3 x 3 of the full model and of each spring set."""
    sheet.set_column(0, 0, 30)
    sheet.set_column(1, 6, 16)
    six = stiffness_six(book.springs)
    row = _block(book, sheet, 0, f"{six.attrs['long_name']}, 6 x 6", six.values, _SIX)
    book.define("K_6x6", sheet.name, (2, 1), (7, 6))
    torsion = NO_TORSION if known_torsion(book.springs.attrs) is None else AT_REST
    notes = [_NOTES[0], f"{torsion[0].upper()}{torsion[1:]}.".replace("rot_z", "rz"), *_NOTES[1:]]
    sheet.write_column(row, 0, notes)
    row += len(notes) + 1
    book.define("K_3x3", sheet.name, (row + 2, 1), (row + 4, 3))
    full = book.springs.dataset["stiffness_initial"].values
    row = _block(book, sheet, row, f"{six.attrs['long_name']}, 3 x 3", full, _THREE)
    breaks = [0]
    for words, matrix in _sets(book):
        if row + 3 + len(matrix) > breaks[-1] + PRINTED:
            breaks.append(row)
        row = _block(book, sheet, row, f"stiffness of the springs at rest: {words}", matrix, _THREE)
    sheet.set_h_pagebreaks(breaks[1:])


def _sets(book: Book) -> list[tuple[str, Array]]:
    """Return the stiffness of each spring set at rest, those of several paths first, with its words."""
    sets = [SPRING_SETS[name] for name in spring_sets(book.springs)]
    chosen: list[tuple[str, str, str | None]] = [
        (each.label, each.name, None) for each in reversed(sets) if each.several
    ]
    alone = [each.name for each in sets if not each.several]
    chosen += [(f"{each} springs of path {name}", each, name) for name in book.lateral for each in alone]
    models = [(words, MacroModel.from_springs(book.springs, each, name)) for words, each, name in chosen]
    return [(words, model.tangent_stiffness().values) for words, model in models]


def _block(
    book: Book, sheet: Any, row: int, words: str, matrix: Array, labels: Sequence[Sequence[str]]
) -> int:  # fmt: skip
    """Write one matrix in kN, m, rad with its labels; return the row behind it."""
    sheet.write_string(row, 0, words, book.title)
    sheet.write_row(row + 1, 1, labels[1], book.head)
    sheet.write_column(row + 2, 0, labels[0], book.head)
    for line, values in enumerate((matrix * KN + 0.0).tolist()):
        sheet.write_row(row + 2 + line, 1, values, book.tenth)
    return row + 3 + len(labels[0])


CHART_ROWS, CHART_COLUMNS = 20, 9  # cells from a row of charts to the next, from a chart to the next one beside it
ACROSS = 3  # charts beside each other
ON_A_PAGE = 2  # rows of charts
HELD = 1e-9  # of the largest y: less motion [m, rad] is rounding

Series = Sequence[tuple[str, int, int]]  # name, columns of x and y


def add_charts(book: Book, sheet: Any, sets: Sequence[str]) -> None:
    """Insert charts of each lateral path: load-displacement, p-y by depth, m by depth, tip and lid; a page each.

    Below are a row of charts for each vertical path: V, and t by depth, over w.
    """
    depths = [f"{z:.2f} m" for z in next(iter(book.paths.values()))["depth"].values]
    py = [(z, 2 + 4 * k, 3 + 4 * k) for k, z in enumerate(depths)]
    mtheta = ("m-theta", "distributed moment by depth", [(z, 2, 4 + 4 * k) for k, z in enumerate(depths)],
              "rotation [mrad]", "m [kN m/m]")  # fmt: skip
    V = [("V", 2, 3), ("tip", 2, 4), ("lid", 2, 5)]

    def lateral(path: xr.Dataset) -> Iterator[Any]:
        """Yield the charts of a path, none over a motion that it holds at 0: M over rotation where u is held."""
        turns, moves = (np.ptp(path[each].values) > HELD * np.abs(path["y"].values).max() for each in ("rotation", "u"))
        x, y, motion, load = (2, 5, "u [mm]", "H [kN]") if moves else (4, 7, "rotation [mrad]", "M [kN m]")
        macro: Series = [(f"macro, {s}", x, y + 3 + 3 * k) for k, s in enumerate(sets)]
        yield "load-displacement", "load at the lid", [(book.recorded, x, y), *macro], motion, load
        yield "p-y", "p-y, both sides, by depth", py, "y [mm]", "p [kN/m]"
        yield from [mtheta] if turns else []
        yield "base", "force on the tip", [("H", 2, 5)], "y of the tip [mm]", "H [kN]"
        yield "lid", "load under the lid", [(load[0], 2 if moves else 3, y)], motion, load

    vertical = (
        ("t-z", "vertical load", V, "w [mm]", "V [kN]"),
        ("t-z", "t-z by depth", [(z, 2, 6 + 3 * k) for k, z in enumerate(depths)], "w [mm]", "t [kN/m]"),
    )
    sheet.set_h_pagebreaks([ON_A_PAGE * CHART_ROWS * k for k in range(1, 1 + len(book.paths))])
    whole, down = book.rows(book.paths), book.rows(book.down)
    for place, name in enumerate(book.lateral):
        _insert(book, sheet, ON_A_PAGE * place, name, whole[name], lateral(book.paths[name]))
    for place, name in enumerate(book.down, start=ON_A_PAGE * len(book.lateral)):
        _insert(book, sheet, place, name, down[name], vertical)


def _insert(book: Book, sheet: Any, place: int, path: str, rows: tuple[int, int], charts: Iterable[Any]) -> None:
    """Insert the charts of one path from a row of charts on."""
    for k, (data, title, series, x_title, y_title) in enumerate(charts):
        chart = book.file.add_chart({"type": "scatter", "subtype": "straight_with_markers"})
        for name, x, y in series:
            chart.add_series({
                "name": name,
                "categories": [data, rows[0], x, rows[1], x],
                "values": [data, rows[0], y, rows[1], y],
                "marker": {"type": "automatic", "size": 4},
                "line": {"width": 1.5},
            })  # fmt: skip
        chart.set_title({"name": f"{path}: {title}", "name_font": {"size": 11}})
        chart.set_x_axis({"name": x_title, "major_gridlines": {"visible": True}, "label_position": "low"})
        chart.set_y_axis({"name": y_title, "label_position": "low"})
        chart.set_size({"width": 560, "height": 380})
        sheet.insert_chart((place + k // ACROSS) * CHART_ROWS, k % ACROSS * CHART_COLUMNS, chart)
