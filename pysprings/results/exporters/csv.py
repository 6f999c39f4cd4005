# SPDX-License-Identifier: MIT
"""CSV tables (SI, one header line, no comment lines): `pandas.read_csv(file)` reads them as they are."""

from __future__ import annotations

import os
from pathlib import Path

import pandas as pd
import xarray as xr

from pysprings.core.files.storage import write_text
from pysprings.results.exporters.tables import load_displacement, py_long
from pysprings.results.exporters.wide import py_wide

# Ten digits: far below what the model knows, and short enough to read.
_NUMBER = "%.10g"


def py_text(springs: xr.DataTree) -> str:
    """Return the long p-y table as CSV text."""
    return _csv(py_long(springs))


def write_py(springs: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Write the long p-y table; return the path."""
    return write_text(py_text(springs), path)


def wide_text(springs: xr.DataTree) -> str:
    """Return the wide p-y table (rows are steps, a pair of columns y, p a depth) as CSV text."""
    return _csv(py_wide(springs))


def write_wide(springs: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Write the wide p-y table; return the path."""
    return write_text(wide_text(springs), path)


def write_load_displacement(result: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Write loads and displacements of the whole caisson by step; return the path."""
    return write_text(_csv(load_displacement(result)), path)


def write_frame(frame: pd.DataFrame, path: str | os.PathLike[str]) -> Path:
    """Write any table, such as the comparison with the full model; return the path."""
    return write_text(_csv(frame), path)


def _csv(frame: pd.DataFrame) -> str:
    numbers = frame.select_dtypes("float").columns
    frame = frame.assign(**{str(name): frame[name] + 0.0 for name in numbers})  # -0 is written as 0
    return frame.to_csv(index=False, float_format=_NUMBER, lineterminator="\n")
