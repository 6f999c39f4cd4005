# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set for design spreadsheets: kN, m, mm, mrad, with charts.

Sheets: About, charts, p-y, m-theta, t-z (of vertical paths, where there are any), base, lid, load-displacement,
stiffness 6x6. Data sheets hold all paths below
each other: columns path and step, then the values; the unit stands in every heading. Every curve has a defined name
(`xlsx_names`), so that formulas need no cell addresses.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray

from pysprings.core.files.storage import replacing
from pysprings.macro.comparison import compare, curves
from pysprings.macro.sets import spring_sets
from pysprings.results.exporters.tables import with_net
from pysprings.results.exporters.xlsx.about import about_lines
from pysprings.results.exporters.xlsx.names import LENGTHS, Names
from pysprings.results.exporters.xlsx.stiffness import write_stiffness
from pysprings.springs.dataset import is_vertical, path_dataset, path_names

# A text stays a text (a name may begin with =), and no temporary file is left elsewhere.
PLAIN = {"strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False, "in_memory": True}
KN, MM, MRAD = 1e-3, 1e3, 1e3
CHART_DEPTHS = 6


@dataclass
class _Book:
    """Workbook with its formats, and where each path's rows are on every data sheet."""

    file: xlsxwriter.Workbook
    head: Any
    title: Any
    number: Any
    text: Any
    mono: Any
    left: Any
    rows: dict[str, tuple[int, int]]
    names: Names


def write_workbook(springs: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Write the workbook atomically; return its path."""
    with (
        replacing(path) as temporary,
        xlsxwriter.Workbook(str(temporary), PLAIN) as file,
    ):
        book = _open(file, springs)
        comparison = compare(springs)
        down = [name for name in book.rows if is_vertical(springs, name)]
        before, behind = ("About", "charts", "p-y", "m-theta"), ("base", "lid", "load-displacement", "stiffness 6x6")
        names = (*before, *(["t-z"] if down else []), *behind)
        sheets = {name: file.add_worksheet(name) for name in names}
        _about(book, sheets["About"], about_lines(springs, comparison))
        _py(book, sheets["p-y"], springs)
        _mtheta(book, sheets["m-theta"], springs)
        if down:
            vertical = replace(book, rows=_rows(springs, down))
            _tz(vertical, sheets["t-z"], springs)
            _vertical_charts(vertical, sheets["charts"], springs, len(book.rows) - len(down))
        for part, name in (("tip", "base"), ("lid", "lid")):
            _end(book, sheets[name], springs, part)
        _load(book, sheets["load-displacement"], springs)
        write_stiffness(sheets["stiffness 6x6"], springs, book.names, book.title, book.head)
        _charts(book, sheets["charts"], springs)
    return Path(path)


def _open(file: xlsxwriter.Workbook, springs: xr.DataTree) -> _Book:
    file.set_properties(
        {"title": str(springs.attrs.get("title", "")), "comments": str(springs.attrs.get("source", ""))}
    )
    rows = _rows(springs, path_names(springs))
    return _Book(
        file=file,
        head=file.add_format({"bold": True, "bg_color": "#DDE6EE", "border": 1, "text_wrap": True, "valign": "top"}),
        title=file.add_format({"bold": True, "font_size": 13}),
        number=file.add_format({"num_format": "0.000"}),
        text=file.add_format({"text_wrap": True, "valign": "top"}),
        mono=file.add_format({"font_name": "Consolas"}),
        left=file.add_format({"align": "left"}),
        rows=rows,
        names=Names(file, rows),
    )


def _rows(springs: xr.DataTree, names: Iterable[str]) -> dict[str, tuple[int, int]]:
    """First and last row of each path, counted from the first row of data."""
    rows, first = {}, 0
    for name in names:
        n = path_dataset(springs, name).sizes["step"]
        rows[name] = (first, first + n - 1)
        first += n
    return rows


def _about(book: _Book, sheet: Any, lines: Iterable[tuple[str, str, str]]) -> None:
    sheet.set_column(0, 0, 26)
    sheet.set_column(1, 1, 110)
    formats = {"title": book.title, "text": book.text, "mono": book.mono}
    for row, (kind, name, words) in enumerate(lines):
        sheet.write_string(row, 0, name, book.title if kind == "title" else book.text)
        if name in LENGTHS:
            sheet.write_number(row, 1, float(words), book.left)
            book.names.define(LENGTHS[name], "About", (row, 1), (row, 1))
        elif words:
            sheet.write_string(row, 1, words, formats[kind])


HEAD_ROWS = 3  # depth, slice, heading with unit


def _fill(book: _Book, sheet: Any, springs: xr.DataTree, columns: Sequence[_Column]) -> None:
    """Write path, step, the columns and the converged mark below three heading rows; freeze them."""
    marks = [_Column("converged (1 = yes)", [path_dataset(springs, name)["converged"].values for name in book.rows])]
    for col, label in enumerate(("path", "step")):
        sheet.write_string(HEAD_ROWS - 1, col, label, book.head)
    sheet.write_string(0, 0, "depth [m]", book.head)
    sheet.write_string(1, 0, "slice [m]", book.head)
    for name, (first, last) in book.rows.items():
        for row in range(first, last + 1):
            sheet.write_string(HEAD_ROWS + row, 0, name)
            sheet.write_number(HEAD_ROWS + row, 1, row - first)
    for col, column in enumerate([*columns, *marks], start=2):
        for row, words in enumerate((column.depth, column.slice, column.heading)):
            sheet.write(row, col, words, book.head)
        values = np.concatenate([np.asarray(part, dtype=float) for part in column.parts])
        cells = [None if np.isnan(value) else value for value in values.tolist()]
        sheet.write_column(HEAD_ROWS, col, cells, None if col == len(columns) + 2 else book.number)
        for path, (first, last) in book.rows.items() if column.name else ():
            book.names.define(column.name, sheet.name, (HEAD_ROWS + first, col), (HEAD_ROWS + last, col), path)
    sheet.set_row(HEAD_ROWS - 1, 45)
    sheet.set_column(0, 0, 14)
    sheet.set_column(1, 1, 6)
    sheet.set_column(2, 2 + len(columns), 11)
    sheet.freeze_panes(HEAD_ROWS, 2)


@dataclass
class _Column:
    """One column: heading with unit, values by path, the depth and slice it belongs to, its name (blank: none)."""

    heading: str
    parts: list[NDArray[np.float64]]
    depth: float | str = ""
    slice: str = ""
    name: str = ""


def _paths(springs: xr.DataTree) -> list[xr.Dataset]:
    return [path_dataset(springs, name) for name in path_names(springs)]


def _by_depth(springs: xr.DataTree, headings: Mapping[str, str], values: Sequence[list[Any]]) -> list[_Column]:
    """Columns of arrays (depth, step): for each depth one column per heading (and its name, a number behind it)."""
    first = _paths(springs)[0]
    columns = []
    for k, depth in enumerate(first["depth"].values):
        top, bottom = first["depth_bounds"].values[k]
        label = f"{top:.3f} - {bottom:.3f}"
        for (heading, name), parts in zip(headings.items(), values, strict=True):
            named = f"{name}_{k + 1}" if name else ""
            columns.append(_Column(heading, [part[k] for part in parts], round(float(depth), 4), label, named))
    return columns


PY_HEADINGS = {"y [mm]": "y", "p net [kN/m]": "p", "p outside [kN/m]": "", "p inside [kN/m]": ""}


def _py(book: _Book, sheet: Any, springs: xr.DataTree) -> None:
    paths = _paths(springs)
    sides = [with_net(path["p"].sum("component").transpose("side", "depth", "step").values * KN, 0) for path in paths]
    y = [path["y"].transpose("depth", "step").values * MM for path in paths]
    values = [y, [side[2] for side in sides], [side[0] for side in sides], [side[1] for side in sides]]
    _fill(book, sheet, springs, _by_depth(springs, PY_HEADINGS, values))


M_HEADINGS = {"m net [kN m/m]": "m", "m outside [kN m/m]": "", "m inside [kN m/m]": "", "t net [kN/m]": "t"}


def _mtheta(book: _Book, sheet: Any, springs: xr.DataTree) -> None:
    paths = _paths(springs)
    m = [with_net(path["m"].transpose("side", "depth", "step").values * KN, 0) for path in paths]
    t = [path["t"].sum("side").transpose("depth", "step").values * KN for path in paths]
    values = [[part[2] for part in m], [part[0] for part in m], [part[1] for part in m], t]
    columns = [_series(paths, "rotation [mrad]", "rotation", MRAD, "theta"), _series(paths, "w [mm]", "w", MM)]
    _fill(book, sheet, springs, columns + _by_depth(springs, M_HEADINGS, values))


T_HEADINGS = {"t net [kN/m]": "tz", "t outside [kN/m]": "", "t inside [kN/m]": ""}


def _tz(book: _Book, sheet: Any, springs: xr.DataTree) -> None:
    """Vertical paths alone: V, its part on tip and lid, and t by depth, over w."""
    paths = [path_dataset(springs, name) for name in book.rows]
    t = [with_net(path["t"].transpose("side", "depth", "step").values * KN, 0) for path in paths]
    columns = [
        _series(paths, "w [mm]", "w", MM, "w_tz"),
        _series(paths, "V [kN]", "V", KN, "V_tz"),
        _series(paths, "V tip [kN]", "V_tip", KN),
        _series(paths, "V lid [kN]", "V_lid", KN),
    ]
    by_depth = _by_depth(springs, T_HEADINGS, [[part[side] for part in t] for side in (2, 0, 1)])
    _fill(book, sheet, springs, columns + by_depth)


def _series(paths: list[xr.Dataset], heading: str, name: str, scale: float, named: str = "") -> _Column:
    return _Column(heading, [path[name].values * scale for path in paths], name=named)


def _end(book: _Book, sheet: Any, springs: xr.DataTree, part: str) -> None:
    paths = _paths(springs)
    depth = float(springs.attrs["skirt_length_m"]) if part == "tip" else 0.0
    sheet_name = sheet.name
    y = [(path["u"].values + path["rotation"].values * depth) * MM for path in paths]
    columns = [
        _Column("y [mm]", y, name=f"y_{sheet_name}"),
        _series(paths, "rotation [mrad]", "rotation", MRAD),
        _series(paths, "w [mm]", "w", MM),
        _series(paths, "H [kN]", f"H_{part}", KN, f"H_{sheet_name}"),
        _series(paths, "V [kN]", f"V_{part}", KN, f"V_{sheet_name}"),
        _series(paths, "M [kN m]", f"M_{part}", KN, f"M_{sheet_name}"),
    ]
    for column in columns:
        column.depth = depth
    _fill(book, sheet, springs, columns)


LOAD_HEADINGS = (
    ("u [mm]", "u", MM),
    ("w [mm]", "w", MM),
    ("rotation [mrad]", "rotation", MRAD),
    ("H [kN]", "H", KN),
    ("V [kN]", "V", KN),
    ("M [kN m]", "M", KN),
)


def _load(book: _Book, sheet: Any, springs: xr.DataTree) -> None:
    """Full model, then the macro-model on each spring set at the same states; unreached cells stay empty."""
    paths = _paths(springs)
    columns = [_series(paths, f"full model {heading}", name, scale, name) for heading, name, scale in LOAD_HEADINGS]
    traces = [curves(springs, name) for name in book.rows]
    for spring_set in spring_sets(springs):
        for heading, name, scale in (LOAD_HEADINGS[3], LOAD_HEADINGS[2], LOAD_HEADINGS[5]):
            parts = [
                _spread(trace[spring_set][name].values * scale if spring_set in trace else np.zeros(0), path)
                for trace, path in zip(traces, paths, strict=True)
            ]
            columns.append(_Column(f"macro-model, {spring_set} springs: {heading}", parts))
    _fill(book, sheet, springs, columns)


def _spread(values: NDArray[np.float64], path: xr.Dataset) -> NDArray[np.float64]:
    """Values of the converged steps at their places among all steps."""
    out = np.full(path.sizes["step"], np.nan)
    good = np.flatnonzero(path["converged"].values == 1)
    out[good[: values.size]] = values
    return out


def _charts(book: _Book, sheet: Any, springs: xr.DataTree) -> None:
    """One row of charts a path: load-displacement, p-y by depth, m by depth, tip and lid."""
    depths = path_dataset(springs, next(iter(book.rows)))["depth"].values
    shown = np.unique(np.linspace(0, depths.size - 1, CHART_DEPTHS).astype(int))
    load = [("full model", 2, 5)] + [(f"macro, {s}", 2, 8 + 3 * k) for k, s in enumerate(spring_sets(springs))]
    py = [(f"{depths[k]:.2f} m", 2 + 4 * k, 3 + 4 * k) for k in shown]
    mtheta = [(f"{depths[k]:.2f} m", 2, 4 + 4 * k) for k in shown]
    lateral = [(name, rows) for name, rows in book.rows.items() if not is_vertical(springs, name)]
    for place, (name, rows) in enumerate(lateral):
        charts = (
            ("load-displacement", f"{name}: load at the lid", load, "u [mm]", "H [kN]"),
            ("p-y", f"{name}: p-y, both sides, by depth", py, "y [mm]", "p [kN/m]"),
            ("m-theta", f"{name}: distributed moment by depth", mtheta, "rotation [mrad]", "m [kN m/m]"),
            ("base", f"{name}: force on the tip", [("H", 2, 5)], "y of the tip [mm]", "H [kN]"),
            ("lid", f"{name}: force under the lid", [("H", 2, 5)], "u [mm]", "H [kN]"),
        )
        for col, (data, title, series, x, y) in enumerate(charts):
            _insert(sheet, (place * 20, col * 9), _scatter(book, data, rows, series), title, x, y)


def _vertical_charts(book: _Book, sheet: Any, springs: xr.DataTree, below: int) -> None:
    """One row of charts a vertical path, below those of the lateral ones: V, and t by depth, over w."""
    depths = path_dataset(springs, next(iter(book.rows)))["depth"].values
    shown = np.unique(np.linspace(0, depths.size - 1, CHART_DEPTHS).astype(int))
    V = [("V", 2, 3), ("tip", 2, 4), ("lid", 2, 5)]
    t = [(f"{depths[k]:.2f} m", 2, 6 + 3 * k) for k in shown]
    for place, (name, rows) in enumerate(book.rows.items(), start=below):
        for col, (title, series, y) in enumerate((("vertical load", V, "V [kN]"), ("t-z by depth", t, "t [kN/m]"))):
            _insert(sheet, (place * 20, col * 9), _scatter(book, "t-z", rows, series), f"{name}: {title}", "w [mm]", y)


def _insert(sheet: Any, cell: tuple[int, int], chart: Any, title: str, x: str, y: str) -> None:
    chart.set_title({"name": title, "name_font": {"size": 11}})
    chart.set_x_axis({"name": x, "major_gridlines": {"visible": True}, "label_position": "low"})
    chart.set_y_axis({"name": y, "label_position": "low"})
    chart.set_size({"width": 560, "height": 380})
    sheet.insert_chart(*cell, chart)


def _scatter(book: _Book, sheet: str, rows: tuple[int, int], series: Iterable[tuple[str, int, int]]) -> Any:
    chart = book.file.add_chart({"type": "scatter", "subtype": "straight_with_markers"})
    first, last = rows[0] + HEAD_ROWS, rows[1] + HEAD_ROWS
    for name, x, y in series:
        chart.add_series({
            "name": name,
            "categories": [sheet, first, x, last, x],
            "values": [sheet, first, y, last, y],
            "marker": {"type": "automatic", "size": 4},
            "line": {"width": 1.5},
        })  # fmt: skip
    return chart
