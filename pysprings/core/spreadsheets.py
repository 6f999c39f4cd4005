# SPDX-License-Identifier: MIT
"""CSV text as spreadsheets write it: commas and decimal points, or semicolons and decimal commas (light).

In a table with semicolons "1,5" is 1.5. A number that can be read in two ways is no number: "1.5" beside decimal
commas, and "1,250" or "1.250" where every separator of the table has three digits behind it and may mean thousands.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator

Row = tuple[int, list[str]]  # number of the line, as editors count, and its cells

_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
_POINT = re.compile(r"\s*[+-]?\d*\.\d+(?:[eE][+-]?\d+)?\s*")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+\s*")


class Doubtful(str):
    """A cell whose number can be read in two ways; `why` is the reason. As a text it is what stands in the table."""

    __slots__ = ("why",)
    why: str

    def __new__(cls, text: str, why: str) -> Doubtful:
        """Return the text with the reason."""
        cell = super().__new__(cls, text)
        cell.why = why
        return cell


def rows_of(text: str) -> list[Row]:
    """Return the lines of CSV text that are not blank. Raises csv.Error."""
    separator = separator_of(text)
    with io.StringIO(text, newline="") as stream:
        reader = csv.reader(stream, delimiter=separator)
        rows = [(reader.line_num, list(cells)) for cells in reader if any(cell.strip() for cell in cells)]
    return rows if separator == "," else [rows[0], *_with_points(rows[1:])] if rows else []


def separator_of(text: str) -> str:
    """Return what separates the columns of CSV text: a semicolon where its first line has one, else a comma."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    return ";" if ";" in first else ","


def _with_points(rows: list[Row]) -> Iterator[Row]:
    """Yield the rows of a table with semicolons, decimal commas as points, and cells in doubt as such."""
    commas = [cell for _, cells in rows for cell in cells if _COMMA.fullmatch(cell)]
    points = [] if commas else [cell for _, cells in rows for cell in cells if _POINT.fullmatch(cell)]
    thousands = bool(commas or points) and all(_THOUSANDS.fullmatch(cell) for cell in (*commas, *points))
    for line, cells in rows:
        yield line, [_cell(cell, bool(commas), thousands) for cell in cells]


def _cell(cell: str, commas: bool, thousands: bool) -> str:
    comma, point = _COMMA.fullmatch(cell), _POINT.fullmatch(cell)
    if thousands and (comma or point) and _THOUSANDS.fullmatch(cell):
        whole = re.sub(r"[.,]", "", cell.strip())
        decimal = cell.strip().replace(",", ".")
        return Doubtful(cell, f"may be {float(decimal):g} or {whole}: write one digit more or less, or no separator")
    if point and commas:
        return Doubtful(cell, "has a decimal point beside decimal commas in the same table")
    return cell.replace(",", ".") if comma else cell
