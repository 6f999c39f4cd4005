# SPDX-License-Identifier: MIT
"""Files of springs that a run writes, for tests that read them back."""

from pathlib import Path

import pandas as pd
import xarray as xr

from pysprings.results.exporters import export
from pysprings.results.exporters.csv import write_frame
from pysprings.results.exporters.tables import load_displacement


def tables(folder: Path, springs: xr.DataTree) -> list[Path]:
    """Write the long and the wide p-y table; return both files."""
    names = {"csv": "py.csv", "wide": "py_wide.csv"}
    return [file for name, file_name in names.items() for file in export(springs, name, folder / file_name).files]


def all_tables(folder: Path, springs: xr.DataTree, result: xr.DataTree, comparison: pd.DataFrame) -> None:
    """Write the CSV tables of a run: springs, loads, comparison."""
    tables(folder, springs)
    write_frame(load_displacement(result), folder / "load_displacement.csv")
    write_frame(comparison, folder / "compare.csv")


def workbook(file: Path, springs: xr.DataTree) -> Path:
    """Write the workbook; return its path."""
    return export(springs, "xlsx", file).files[0]
