# SPDX-License-Identifier: MIT
"""File formats of tables (light). A new reader is one module in this folder and one entry here.

Other packages call `TABLE_READERS.register`, or declare an entry point in the group `pysprings.table_readers`.
"""

from __future__ import annotations

import os
from pathlib import Path

from pysprings.core.registry import Registry
from pysprings.results.tables import csv_file, xlsx_file
from pysprings.results.tables.reader import TableReader

TABLE_READERS: Registry[TableReader] = Registry(
    "table reader", (csv_file.CSV, xlsx_file.XLSX), group="pysprings.table_readers"
)


def reader_of(path: str | os.PathLike[str]) -> TableReader | None:
    """Return the reader for the ending of a file; None for an unknown one."""
    ending = Path(path).suffix.lower()
    return next((each for each in TABLE_READERS if ending in each.suffixes), None)


def endings() -> list[str]:
    """Return the endings of all files that can be read."""
    return [suffix for each in TABLE_READERS for suffix in each.suffixes]
