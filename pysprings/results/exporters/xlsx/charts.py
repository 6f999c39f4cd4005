# SPDX-License-Identifier: MIT
"""The sheet of charts: those of a lateral path on a page, then those of the vertical paths."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import xarray as xr

from pysprings.results.exporters.xlsx.sheet import HEAD_ROWS, Book, datasets
from pysprings.springs.path import paths_of

ROWS, COLUMNS = 20, 9  # cells from a row of charts to the next, from a chart to the next one beside it
ACROSS = 3  # charts beside each other
ON_A_PAGE = 2  # rows of charts


def add_charts(book: Book, sheet: Any, springs: xr.DataTree, sets: Sequence[str]) -> None:
    """Insert charts of each lateral path: load-displacement, p-y by depth, m by depth, tip and lid; a page each."""
    depths = datasets(springs, book.rows)[0]["depth"].values
    shown = range(depths.size)
    load = [("full model", 2, 5)] + [(f"macro, {s}", 2, 8 + 3 * k) for k, s in enumerate(sets)]
    py = [(f"{depths[k]:.2f} m", 2 + 4 * k, 3 + 4 * k) for k in shown]
    mtheta = [(f"{depths[k]:.2f} m", 2, 4 + 4 * k) for k in shown]
    paths = paths_of(springs)
    lateral = [(name, rows) for name, rows in book.rows.items() if not paths[name].is_vertical]
    sheet.set_h_pagebreaks([ON_A_PAGE * ROWS * k for k in range(1, 1 + len(book.rows))])
    for place, (name, rows) in enumerate(lateral):
        charts = (
            ("load-displacement", f"{name}: load at the lid", load, "u [mm]", "H [kN]"),
            ("p-y", f"{name}: p-y, both sides, by depth", py, "y [mm]", "p [kN/m]"),
            ("m-theta", f"{name}: distributed moment by depth", mtheta, "rotation [mrad]", "m [kN m/m]"),
            ("base", f"{name}: force on the tip", [("H", 2, 5)], "y of the tip [mm]", "H [kN]"),
            ("lid", f"{name}: force under the lid", [("H", 2, 5)], "u [mm]", "H [kN]"),
        )
        for k, (data, title, series, x, y) in enumerate(charts):
            cell = (ON_A_PAGE * place + k // ACROSS) * ROWS, k % ACROSS * COLUMNS
            _insert(sheet, cell, _scatter(book, data, rows, series), title, x, y)


def add_vertical_charts(book: Book, sheet: Any, springs: xr.DataTree, above: int) -> None:
    """Insert a row of charts for each vertical path below those of `above` lateral paths: V, and t by depth, over w."""
    depths = datasets(springs, book.rows)[0]["depth"].values
    shown = range(depths.size)
    V = [("V", 2, 3), ("tip", 2, 4), ("lid", 2, 5)]
    t = [(f"{depths[k]:.2f} m", 2, 6 + 3 * k) for k in shown]
    for place, (name, rows) in enumerate(book.rows.items(), start=ON_A_PAGE * above):
        for col, (title, series, y) in enumerate((("vertical load", V, "V [kN]"), ("t-z by depth", t, "t [kN/m]"))):
            _insert(
                sheet,
                (place * ROWS, col * COLUMNS),
                _scatter(book, "t-z", rows, series),
                f"{name}: {title}",
                "w [mm]",
                y,
            )


def _insert(sheet: Any, cell: tuple[int, int], chart: Any, title: str, x: str, y: str) -> None:
    chart.set_title({"name": title, "name_font": {"size": 11}})
    chart.set_x_axis({"name": x, "major_gridlines": {"visible": True}, "label_position": "low"})
    chart.set_y_axis({"name": y, "label_position": "low"})
    chart.set_size({"width": 560, "height": 380})
    sheet.insert_chart(*cell, chart)


def _scatter(book: Book, sheet: str, rows: tuple[int, int], series: Iterable[tuple[str, int, int]]) -> Any:
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
