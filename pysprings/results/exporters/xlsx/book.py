# SPDX-License-Identifier: MIT
"""A workbook of springs: its look, defined names, and sheets of data with all paths below each other.

Every curve, length and matrix has a defined name, so that formulas need no cell addresses. Long sheets are for the
screen and for formulas: they print their first rows on one page, and state it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
import xlsxwriter
from numpy.typing import NDArray
from xlsxwriter.utility import xl_range_abs

from pysprings.results.sheets import HEAD
from pysprings.springs.path import paths_of

Array = NDArray[np.float64]

HEAD_ROWS = 3  # depth, slice, heading with unit
MOST_PRINTED = 45  # rows of a data sheet
# variable of a path -> heading, factor from SI
QUANTITIES = {
    "u": ("u [mm]", 1e3), "w": ("w [mm]", 1e3), "rotation": ("rotation [mrad]", 1e3), "H": ("H [kN]", 1e-3),
    "V": ("V [kN]", 1e-3), "M": ("M [kN m]", 1e-3),
}  # fmt: skip


@dataclass
class Column:
    """One column: heading with unit, values by path, depth and slice of the heading, defined name (blank: none)."""

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

    def of(self, names: Iterable[str], variable: str, name: str = "", form: str = "{}") -> Column:
        """Return the column of a variable by step (H_tip: as H of `QUANTITIES`), with its defined name."""
        heading, factor = QUANTITIES[variable.partition("_")[0]]
        values = [self.paths[each][variable].values * factor for each in names]
        return Column(form.format(heading), values, name=name)

    def by_depth(self, headings: Mapping[str, str], values: Sequence[Sequence[Array]]) -> Iterator[Column]:
        """Yield columns of arrays (depth, step) by heading and path: for each depth one a heading, names numbered."""
        first = next(iter(self.paths.values()))
        for k, (depth, (top, bottom)) in enumerate(
            zip(first["depth"].values, first["depth_bounds"].values, strict=True)
        ):
            for (heading, name), parts in zip(headings.items(), values, strict=True):
                named = f"{name}_{k + 1}" if name else ""
                label = f"{top:.3f} - {bottom:.3f}"
                yield Column(heading, [part[k] for part in parts], round(float(depth), 4), label, named)

    def fill(self, sheet: Any, names: Sequence[str], columns: Sequence[Column]) -> None:
        """Write path, step, the columns and the converged mark of paths below three heading rows."""
        rows = self.rows(names)
        last = max(end for _, end in rows.values())
        for row, words in enumerate((["depth [m]"], ["slice [m]"], ["path", "step"])):
            sheet.write_row(row, 0, words, self.head)
        for name, (first, end) in rows.items():
            sheet.write_column(first, 0, [name] * (end - first + 1))
            sheet.write_column(first, 1, range(end - first + 1))
        marks = Column("converged (1 = yes)", [self.paths[name]["converged"].values for name in names])
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
