# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set for design spreadsheets: kN, m, mm, mrad, with charts.

Sheets: About, charts, p-y, m-theta, t-z (of vertical paths), base, lid, load-displacement, stiffness 6x6, tidy (a row
for each path, step and depth, for pivots). Data sheets hold all paths below each other: columns path and step, then
the values; every heading has its unit and a filter.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray

from pysprings.core.storage import replacing
from pysprings.core.variables import known_torsion
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.stiffness import AT_REST, FULL_MODEL, NO_TORSION, stiffness_six
from pysprings.results.exporters.base import Source
from pysprings.results.exporters.tables import with_net
from pysprings.results.exporters.xlsx.book import LENGTHS, QUANTITIES, Book, Cells, about_lines, finish, write_numbers
from pysprings.results.sheets import PLAIN_CELLS
from pysprings.springs.sums import by_depth

KN, MM = 1e-3, 1e3


def write_workbook(source: Source, path: str | os.PathLike[str]) -> Path:
    """Write the workbook atomically; return its path."""
    springs = source.tables
    # in memory: no temporary file is left elsewhere
    with replacing(path) as temporary, xlsxwriter.Workbook(str(temporary), {**PLAIN_CELLS, "in_memory": True}) as file:
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
        _stiffness(book, book.sheet("stiffness 6x6"))
        add_charts(book, charts, spring_sets(source.springs))
        _tidy(book, book.sheet("tidy"))
    return Path(path)


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


def _sides(path: xr.Dataset, name: str) -> NDArray[np.float64]:
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
    ends = [book.of(book.down, f"V_{part}", form=f"V {part} [kN]") for part in ("tip", "lid")]
    headings = {"t net [kN/m]": "tz", "t outside [kN/m]": "", "t inside [kN/m]": ""}
    by = book.by_depth(headings, [[each[side] for each in t] for side in (2, 0, 1)])
    book.fill(sheet, book.down, [book.of(book.down, "w", "w_tz"), book.of(book.down, "V", "V_tz"), *ends, *by])


def _end(book: Book, sheet: Any, part: str) -> None:
    depth = float(book.springs.attrs["skirt_length_m"]) if part == "tip" else 0.0
    y = [(path["u"].values - path["rotation"].values * depth) * MM for path in book.paths.values()]
    names = list(book.paths)
    columns = [Cells("y [mm]", y, name=f"y_{sheet.name}"), book.of(names, "rotation"), book.of(names, "w")]
    columns += [book.of(names, f"{load}_{part}", f"{load}_{sheet.name}") for load in ("H", "V", "M")]
    for column in columns:
        column.depth = depth
    book.fill(sheet, names, columns)


def _load(book: Book, sheet: Any, source: Source) -> None:
    """Write the full model, then the macro-model on each spring set at the same states; unreached cells stay empty."""
    names = list(book.paths)
    columns = [book.of(names, variable, variable, "full model {}") for variable in QUANTITIES]
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
    "Springs of one path at rest: slope of the first recorded step, below the full model's initial one; w is the full "
    "model's elastic stiffness.",
)


def _stiffness(book: Book, sheet: Any) -> None:
    """Write the full model's initial stiffness as 6 x 6, then the 3 x 3 of the full model and of each spring set."""
    sheet.set_column(0, 0, 30)
    sheet.set_column(1, 6, 16)
    row = _block(book, sheet, 0, f"{FULL_MODEL} at the lid centre, 6 x 6", stiffness_six(book.springs).values, _SIX)
    book.define("K_6x6", sheet.name, (2, 1), (7, 6))
    torsion = NO_TORSION if known_torsion(book.springs.attrs) is None else AT_REST
    notes = [_NOTES[0], f"{torsion[0].upper()}{torsion[1:]}.".replace("rot_z", "rz"), *_NOTES[1:]]
    sheet.write_column(row, 0, notes)
    row += len(notes) + 1
    book.define("K_3x3", sheet.name, (row + 2, 1), (row + 4, 3))
    full = book.springs.dataset["stiffness_initial"].values
    row = _block(book, sheet, row, f"{FULL_MODEL} at the lid centre, 3 x 3", full, _THREE)
    breaks = [0]
    for words, matrix in _sets(book):
        if row + 3 + len(matrix) > breaks[-1] + PRINTED:
            breaks.append(row)
        row = _block(book, sheet, row, f"stiffness of the springs at rest: {words}", matrix, _THREE)
    sheet.set_h_pagebreaks(breaks[1:])


def _sets(book: Book) -> list[tuple[str, NDArray[np.float64]]]:
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
    book: Book, sheet: Any, row: int, words: str, matrix: NDArray[np.float64], labels: Sequence[Sequence[str]]
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

Series = Sequence[tuple[str, int, int]]  # name, columns of x and y


def add_charts(book: Book, sheet: Any, sets: Sequence[str]) -> None:
    """Insert charts of each lateral path: load-displacement, p-y by depth, m by depth, tip and lid; a page each.

    Below are a row of charts for each vertical path: V, and t by depth, over w.
    """
    depths = [f"{z:.2f} m" for z in next(iter(book.paths.values()))["depth"].values]
    load: Series = [("full model", 2, 5)] + [(f"macro, {s}", 2, 8 + 3 * k) for k, s in enumerate(sets)]
    py = [(z, 2 + 4 * k, 3 + 4 * k) for k, z in enumerate(depths)]
    mtheta = [(z, 2, 4 + 4 * k) for k, z in enumerate(depths)]
    V = [("V", 2, 3), ("tip", 2, 4), ("lid", 2, 5)]
    lateral = (
        ("load-displacement", "load at the lid", load, "u [mm]", "H [kN]"),
        ("p-y", "p-y, both sides, by depth", py, "y [mm]", "p [kN/m]"),
        ("m-theta", "distributed moment by depth", mtheta, "rotation [mrad]", "m [kN m/m]"),
        ("base", "force on the tip", [("H", 2, 5)], "y of the tip [mm]", "H [kN]"),
        ("lid", "force under the lid", [("H", 2, 5)], "u [mm]", "H [kN]"),
    )
    vertical = (
        ("t-z", "vertical load", V, "w [mm]", "V [kN]"),
        ("t-z", "t-z by depth", [(z, 2, 6 + 3 * k) for k, z in enumerate(depths)], "w [mm]", "t [kN/m]"),
    )
    sheet.set_h_pagebreaks([ON_A_PAGE * CHART_ROWS * k for k in range(1, 1 + len(book.paths))])
    whole, down = book.rows(book.paths), book.rows(book.down)
    for place, name in enumerate(book.lateral):
        _insert(book, sheet, ON_A_PAGE * place, name, whole[name], lateral)
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
