# SPDX-License-Identifier: MIT
"""Tables in Excel workbooks, one a sheet."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import quoted
from pysprings.results.tables.reader import Line, Sheet, TableReader, refuse_large, too_large

MOST_LINES = 200_000  # of a sheet
MOST_WORDS = 200  # characters of a message of the library


def _sheets(path: Path) -> Iterator[Sheet]:
    import openpyxl

    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            refuse_large(path, sum(part.file_size for part in archive.infolist()), " when unpacked")
            book = openpyxl.load_workbook(stream, read_only=True, data_only=True)
            try:
                for sheet in book.worksheets:
                    yield Sheet(sheet.title, list(_lines(path, sheet)))
            finally:
                book.close()
    except (UserInputError, GeneratorExit):
        raise
    except Exception as error:  # a broken archive raises many types
        why = str(error) or type(error).__name__
        raise UserInputError([Problem(file=str(path), message=f"not an Excel workbook ({why[:MOST_WORDS]})")]) from None


def _lines(path: Path, sheet: Any) -> Iterator[Line]:
    """Yield the lines of a sheet that are not blank."""
    for line, cells in enumerate(sheet.iter_rows(values_only=True), start=1):
        if line > MOST_LINES:
            raise too_large(path, f"sheet {quoted(sheet.title)} has more than {MOST_LINES:,} lines")
        if any(cell is not None for cell in cells):
            yield line, list(cells)


XLSX = TableReader("xlsx", (".xlsx",), _sheets)
