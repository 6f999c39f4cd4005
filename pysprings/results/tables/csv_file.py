# SPDX-License-Identifier: MIT
"""Tables in CSV files: UTF-8, commas and decimal points, or semicolons and decimal commas."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.spreadsheets import rows_of
from pysprings.results.tables.reader import Line, Sheet, TableReader, refuse_large, too_large

MOST_LINES = 300_000  # ten seconds of checks


def lines_of(path: Path) -> list[Line]:
    """Return the lines that are not blank, numbered as an editor numbers them."""
    refuse_large(path, path.stat().st_size)
    try:
        content = path.read_bytes()
        if (count := content.count(b"\n")) > MOST_LINES:
            raise too_large(path, f"{count:,} lines, at most {MOST_LINES:,}; springs.nc of a run has no such limit")
        lines: list[Line] = [*rows_of(content.decode("utf-8-sig"))]
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserInputError([Problem(file=str(path), message=f"not a CSV file in UTF-8 ({error})")]) from None
    if lines and len(lines[0][1]) == 1 and "\t" in lines[0][1][0]:
        message = "columns are separated by tabs: expected ',' (and decimal points) or ';' (and decimal commas)"
        raise UserInputError([Problem(str(path), lines[0][0], message=message)])
    return lines


def _sheets(path: Path) -> Iterator[Sheet]:
    yield Sheet("", lines_of(path))


CSV = TableReader("csv", (".csv",), _sheets)
