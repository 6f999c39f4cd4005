# SPDX-License-Identifier: MIT
"""Sheets of data: heading rows with depth, slice and unit, then the rows of all paths below each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray

from pysprings.results.exporters.xlsx.names import Names
from pysprings.springs.path import RecordedPath, paths_of

KN, MM, MRAD = 1e-3, 1e3, 1e3
HEAD_ROWS = 3  # depth, slice, heading with unit
MOST_PRINTED = 45  # rows of a data sheet


@dataclass
class Book:
    """Workbook with its formats, and first and last row of each path on every data sheet."""

    file: xlsxwriter.Workbook
    head: Any
    title: Any
    number: Any
    tenth: Any
    text: Any
    mono: Any
    left: Any
    rows: dict[str, tuple[int, int]]
    names: Names


@dataclass
class Column:
    """One column: heading with unit, values by path, depth and slice of the heading, defined name (blank: none)."""

    heading: str
    parts: list[NDArray[np.float64]]
    depth: float | str = ""
    slice: str = ""
    name: str = ""


def rows_of(paths: Iterable[RecordedPath]) -> dict[str, tuple[int, int]]:
    """Return the first and last row of each path, counted from the first row of data."""
    rows, first = {}, 0
    for path in paths:
        n = path.recorded.sizes["step"]
        rows[path.name] = (first, first + n - 1)
        first += n
    return rows


def fill(book: Book, sheet: Any, springs: xr.DataTree, columns: Sequence[Column]) -> None:
    """Write path, step, the columns and the converged mark below three heading rows; freeze them."""
    marks = [Column("converged (1 = yes)", [path["converged"].values for path in datasets(springs, book.rows)])]
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
    sheet.repeat_rows(0, HEAD_ROWS - 1)
    sheet.repeat_columns(0, 1)
    last = max(end for _, end in book.rows.values())
    sheet.autofilter(HEAD_ROWS - 1, 0, HEAD_ROWS + last, 2 + len(columns))
    print_a_look(sheet, HEAD_ROWS, last + 1, 3 + len(columns))


def set_page(sheet: Any) -> None:
    """Print a sheet in landscape on A4, one page wide, with page numbers."""
    sheet.set_landscape()
    sheet.set_paper(9)
    sheet.set_margins(left=0.4, right=0.4, top=0.6, bottom=0.6)
    sheet.fit_to_pages(1, 0)
    sheet.set_footer("&L&A&RPage &P of &N")


def print_a_look(sheet: Any, head: int, rows: int, columns: int) -> None:
    """Print the first rows of a long sheet on one page, and state it at its foot; after `set_page`.

    Such a sheet is for the screen and for formulas.
    """
    shown = min(rows, MOST_PRINTED)
    sheet.print_area(0, 0, head + shown - 1, columns - 1)
    sheet.fit_to_pages(1, 1)
    cut = f": the first {shown} of {rows} rows are printed" if shown < rows else ""
    sheet.set_footer(f"&L&A{cut}&RPage &P of &N")


def datasets(springs: xr.DataTree, names: Iterable[str] | None = None) -> list[xr.Dataset]:
    """Return all paths, or those of some names, unconverged steps included."""
    paths = paths_of(springs)
    return [paths[name].recorded for name in (paths if names is None else names)]


def by_depth(springs: xr.DataTree, headings: Mapping[str, str], values: Sequence[list[Any]]) -> list[Column]:
    """Return columns of arrays (depth, step): for each depth one per heading; a name gets the number of the depth."""
    first = datasets(springs)[0]
    columns = []
    for k, depth in enumerate(first["depth"].values):
        top, bottom = first["depth_bounds"].values[k]
        label = f"{top:.3f} - {bottom:.3f}"
        for (heading, name), parts in zip(headings.items(), values, strict=True):
            named = f"{name}_{k + 1}" if name else ""
            columns.append(Column(heading, [part[k] for part in parts], round(float(depth), 4), label, named))
    return columns


def series(paths: list[xr.Dataset], heading: str, name: str, scale: float, named: str = "") -> Column:
    """Return the column of a variable by step, with its defined name."""
    return Column(heading, [path[name].values * scale for path in paths], name=named)
