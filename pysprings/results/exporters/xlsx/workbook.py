# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set for design spreadsheets: kN, m, mm, mrad, with charts.

Sheets: About, charts, p-y, m-theta, t-z (of vertical paths), base, lid, load-displacement, stiffness 6x6, tidy (a row
for each path, step and depth, for pivots). Data sheets hold all paths below each other: columns path and step, then
the values; every heading has its unit and a filter. Every sheet prints one page wide; long ones print their first rows,
and state it. Every curve has a defined name (`names`), so that formulas need no cell addresses.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray

from pysprings.core.files.storage import replacing
from pysprings.core.text import PLAIN_CELLS
from pysprings.macro.sets import spring_sets
from pysprings.results.exporters.base import Source
from pysprings.results.exporters.tables import with_net
from pysprings.results.exporters.xlsx.about import about_lines
from pysprings.results.exporters.xlsx.charts import add_charts, add_vertical_charts
from pysprings.results.exporters.xlsx.names import LENGTHS, Names
from pysprings.results.exporters.xlsx.sheet import (
    KN,
    MM,
    MRAD,
    Book,
    Column,
    by_depth,
    datasets,
    fill,
    rows_of,
    series,
    set_page,
)
from pysprings.results.exporters.xlsx.stiffness import write_stiffness
from pysprings.results.exporters.xlsx.tidy import write_tidy
from pysprings.springs.path import paths_of

# no temporary file is left elsewhere
PLAIN = {**PLAIN_CELLS, "in_memory": True}


def write_workbook(source: Source, path: str | os.PathLike[str]) -> Path:
    """Write the workbook atomically; return its path."""
    springs = source.tables
    with (
        replacing(path) as temporary,
        xlsxwriter.Workbook(str(temporary), PLAIN) as file,
    ):
        book = _open(file, springs)
        down = [path for path in paths_of(springs).values() if path.is_vertical]
        before = ("About", "charts", "p-y", "m-theta")
        behind = ("base", "lid", "load-displacement", "stiffness 6x6", "tidy")
        names = (*before, *(["t-z"] if down else []), *behind)
        sheets = {name: file.add_worksheet(name) for name in names}
        for sheet in sheets.values():
            set_page(sheet)
        _about(book, sheets["About"], about_lines(source.springs, source.comparison, source.summary))
        _py(book, sheets["p-y"], springs)
        _mtheta(book, sheets["m-theta"], springs)
        if down:
            vertical = replace(book, rows=rows_of(down))
            _tz(vertical, sheets["t-z"], springs)
            add_vertical_charts(vertical, sheets["charts"], springs, len(book.rows) - len(down))
        for part, name in (("tip", "base"), ("lid", "lid")):
            _end(book, sheets[name], springs, part)
        _load(book, sheets["load-displacement"], source)
        write_stiffness(book, sheets["stiffness 6x6"], springs)
        add_charts(book, sheets["charts"], springs, spring_sets(source.springs))
        write_tidy(book, sheets["tidy"], springs)
    return Path(path)


def _open(file: xlsxwriter.Workbook, springs: xr.DataTree) -> Book:
    file.set_properties(
        {"title": str(springs.attrs.get("title", "")), "comments": str(springs.attrs.get("source", ""))}
    )
    rows = rows_of(paths_of(springs).values())
    return Book(
        file=file,
        head=file.add_format({"bold": True, "bg_color": "#DDE6EE", "border": 1, "text_wrap": True, "valign": "top"}),
        title=file.add_format({"bold": True, "font_size": 13}),
        number=file.add_format({"num_format": "0.000"}),
        tenth=file.add_format({"num_format": "#,##0.0"}),
        text=file.add_format({"text_wrap": True, "valign": "top"}),
        mono=file.add_format({"font_name": "Consolas"}),
        left=file.add_format({"align": "left"}),
        rows=rows,
        names=Names(file, rows),
    )


def _about(book: Book, sheet: Any, lines: Iterable[tuple[str, str, str]]) -> None:
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
            if kind == "text":
                sheet.set_row(row, 15 * -(-max(len(words), 1) // 100))


PY_HEADINGS = {"y [mm]": "y", "p net [kN/m]": "p", "p outside [kN/m]": "", "p inside [kN/m]": ""}


def _py(book: Book, sheet: Any, springs: xr.DataTree) -> None:
    paths = datasets(springs)
    sides = [with_net(path["p"].sum("component").transpose("side", "depth", "step").values * KN, 0) for path in paths]
    y = [path["y"].transpose("depth", "step").values * MM for path in paths]
    values = [y, [side[2] for side in sides], [side[0] for side in sides], [side[1] for side in sides]]
    fill(book, sheet, springs, by_depth(springs, PY_HEADINGS, values))


M_HEADINGS = {"m net [kN m/m]": "m", "m outside [kN m/m]": "", "m inside [kN m/m]": "", "t net [kN/m]": "t"}


def _mtheta(book: Book, sheet: Any, springs: xr.DataTree) -> None:
    paths = datasets(springs)
    m = [with_net(path["m"].transpose("side", "depth", "step").values * KN, 0) for path in paths]
    t = [path["t"].sum("side").transpose("depth", "step").values * KN for path in paths]
    values = [[part[2] for part in m], [part[0] for part in m], [part[1] for part in m], t]
    columns = [series(paths, "rotation [mrad]", "rotation", MRAD, "theta"), series(paths, "w [mm]", "w", MM)]
    fill(book, sheet, springs, columns + by_depth(springs, M_HEADINGS, values))


T_HEADINGS = {"t net [kN/m]": "tz", "t outside [kN/m]": "", "t inside [kN/m]": ""}


def _tz(book: Book, sheet: Any, springs: xr.DataTree) -> None:
    """Write V, its part on tip and lid, and t by depth, over w; vertical paths only."""
    paths = datasets(springs, book.rows)
    t = [with_net(path["t"].transpose("side", "depth", "step").values * KN, 0) for path in paths]
    columns = [
        series(paths, "w [mm]", "w", MM, "w_tz"),
        series(paths, "V [kN]", "V", KN, "V_tz"),
        series(paths, "V tip [kN]", "V_tip", KN),
        series(paths, "V lid [kN]", "V_lid", KN),
    ]
    values = [[part[side] for part in t] for side in (2, 0, 1)]
    fill(book, sheet, springs, columns + by_depth(springs, T_HEADINGS, values))


def _end(book: Book, sheet: Any, springs: xr.DataTree, part: str) -> None:
    paths = datasets(springs)
    depth = float(springs.attrs["skirt_length_m"]) if part == "tip" else 0.0
    sheet_name = sheet.name
    y = [(path["u"].values - path["rotation"].values * depth) * MM for path in paths]
    columns = [
        Column("y [mm]", y, name=f"y_{sheet_name}"),
        series(paths, "rotation [mrad]", "rotation", MRAD),
        series(paths, "w [mm]", "w", MM),
        series(paths, "H [kN]", f"H_{part}", KN, f"H_{sheet_name}"),
        series(paths, "V [kN]", f"V_{part}", KN, f"V_{sheet_name}"),
        series(paths, "M [kN m]", f"M_{part}", KN, f"M_{sheet_name}"),
    ]
    for column in columns:
        column.depth = depth
    fill(book, sheet, springs, columns)


LOAD_HEADINGS = (
    ("u [mm]", "u", MM),
    ("w [mm]", "w", MM),
    ("rotation [mrad]", "rotation", MRAD),
    ("H [kN]", "H", KN),
    ("V [kN]", "V", KN),
    ("M [kN m]", "M", KN),
)


def _load(book: Book, sheet: Any, source: Source) -> None:
    """Write the full model, then the macro-model on each spring set at the same states; unreached cells stay empty."""
    springs = source.springs
    paths = datasets(springs)
    columns = [series(paths, f"full model {heading}", name, scale, name) for heading, name, scale in LOAD_HEADINGS]
    traces = [source.predictions[name] for name in book.rows]
    for spring_set in spring_sets(springs):
        for heading, name, scale in (LOAD_HEADINGS[3], LOAD_HEADINGS[2], LOAD_HEADINGS[5]):
            parts = [
                _spread(trace[spring_set][name].values * scale if spring_set in trace else np.zeros(0), path)
                for trace, path in zip(traces, paths, strict=True)
            ]
            columns.append(Column(f"macro-model, {spring_set} springs: {heading}", parts))
    fill(book, sheet, springs, columns)


def _spread(values: NDArray[np.float64], path: xr.Dataset) -> NDArray[np.float64]:
    """Return values of the converged steps at their places among all steps (NaN elsewhere)."""
    out = np.full(path.sizes["step"], np.nan)
    good = np.flatnonzero(path["converged"].values == 1)
    out[good[: values.size]] = values
    return out
