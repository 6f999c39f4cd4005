# SPDX-License-Identifier: MIT
"""Tables in CSV files: UTF-8, commas, decimal points."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from pathlib import Path

from pysprings.core.errors import Problem, UserInputError
from pysprings.results.tables.reader import Line, Sheet, TableReader, refuse_large, too_large

MOST_LINES = 300_000  # ten seconds of checks


def lines_of(path: Path) -> list[Line]:
    """Return the lines that are not blank, numbered as an editor numbers them."""
    refuse_large(path, path.stat().st_size)
    try:
        content = path.read_bytes()
        if (count := content.count(b"\n")) > MOST_LINES:
            raise too_large(path, f"{count:,} lines, at most {MOST_LINES:,}; springs.nc of a run has no such limit")
        with io.StringIO(content.decode("utf-8-sig"), newline="") as stream:
            reader = csv.reader(stream)
            lines = [(reader.line_num, list(cells)) for cells in reader if any(cell.strip() for cell in cells)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserInputError([Problem(file=str(path), message=f"not a CSV file in UTF-8 ({error})")]) from None
    if lines and len(lines[0][1]) == 1 and re.search(r"[;\t]", lines[0][1][0]):
        message = "columns are separated by ';' or tabs: expected ',' (and decimal points)"
        raise UserInputError([Problem(str(path), lines[0][0], message=message)])
    return lines


def _sheets(path: Path) -> Iterator[Sheet]:
    yield Sheet("", lines_of(path))


CSV = TableReader("csv", (".csv",), _sheets)
