# SPDX-License-Identifier: MIT
"""Files for other programs and people, one consumer a module: CSV tables, an Excel workbook, JSON.

Every writer replaces its file only when the new one is whole. Heavy libraries load when a writer is called.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

FORMATS = ("csv", "wide", "xlsx", "json")

PathLike = str | os.PathLike[str]


def csv_tables(
    folder: PathLike,
    springs: xr.DataTree,
    result: xr.DataTree | None = None,
    comparison: pd.DataFrame | None = None,
) -> list[Path]:
    """Write `py.csv` and `py_wide.csv`, given the data also `load_displacement.csv` and `compare.csv`."""
    from pysprings.results.exporters import csv

    written = [csv.write_py(springs, Path(folder) / "py.csv"), csv.write_wide(springs, Path(folder) / "py_wide.csv")]
    if result is not None:
        written.append(load_displacement_table(folder, result))
    if comparison is not None:
        written.append(csv.write_frame(comparison, Path(folder) / "compare.csv"))
    return written


def load_displacement_table(folder: PathLike, result: xr.DataTree) -> Path:
    """Write `load_displacement.csv` of a result that has no springs, or beside them; return its path."""
    from pysprings.results.exporters import csv

    return csv.write_load_displacement(result, Path(folder) / "load_displacement.csv")


def excel(path: PathLike, springs: xr.DataTree) -> Path:
    """Write the springs as an Excel workbook with charts (kN, m, mm, mrad); return its path."""
    from pysprings.results.exporters.xlsx import workbook

    return workbook.write_workbook(springs, path)


def paraview(folder: PathLike, result: xr.DataTree, note: Callable[[Path], object] | None = None) -> list[Path]:
    """Write ParaView files of a result that holds the whole model: a `.pvd` for each path, a `.vtu` for each step.

    `note` is called with each file when it is written.
    """
    from pysprings.results.exporters import vtu

    return vtu.write_paraview(result, Path(folder), note)


def export(springs: xr.DataTree, form: str, path: PathLike) -> Path:
    """Write the springs to one file in a form of `FORMATS` (csv: long p-y table, wide: wide one); return its path."""
    if form == "xlsx":
        return excel(path, springs)
    from pysprings.core.files.storage import write_text

    return write_text(text(springs, form), path)


def text(springs: xr.DataTree, form: str) -> str:
    """Return the springs as text, for a terminal or a pipe: "csv" (long p-y table), "wide" (wide one) or "json"."""
    if form in ("csv", "wide"):
        from pysprings.results.exporters import csv

        return csv.py_text(springs) if form == "csv" else csv.wide_text(springs)
    if form == "json":
        from pysprings.results.exporters import json

        return json.springs_text(springs)
    from pysprings.core.errors import Problem, UserInputError

    raise UserInputError([Problem(key="format", message=f"'{form}' is not one of {', '.join(FORMATS)}")])
