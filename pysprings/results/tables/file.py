# SPDX-License-Identifier: MIT
"""Rows of a table file: columns, numbers and names, each checked with its line."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pandas as pd

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Column, Faults, Sheet, Table, tables_of
from pysprings.core.tables.headings import TEXT
from pysprings.core.units import quoted
from pysprings.results.exporters.tables import PY_COLUMNS
from pysprings.results.tables.wide import unfold
from pysprings.springs.numbers import name_fault

NEEDED = ("depth_m", "y_m", "p_N_per_m")
FAMILIES = ("py", "mtheta", "base", "lid", "tz")
TEXTS = ("path", "family", "side", "component")
COLUMNS = tuple(Column(name, TEXT) if name in TEXTS else Column.named(name) for name in PY_COLUMNS)
# Sheets that are not read: words and pictures.
OTHER_SHEETS = ("about", "charts", "load-displacement", "stiffness 6x6")
SHEETS = {"py": "py", "p-y": "py", "mtheta": "mtheta", "m-theta": "mtheta", "base": "base", "tip": "base", "lid": "lid"}


def read_rows(path: str | os.PathLike[str], faults: Faults) -> pd.DataFrame:
    """Return the rows of a table: every column of `PY_COLUMNS`, numbers as numbers (NaN: blank), and `file`, `line`.

    Refuses missing, repeated and unknown columns and units that do not fit; notes cells that are not finite numbers and
    unknown families, for the checks that follow to add theirs.
    """
    path = Path(path)
    frames = [
        _typed(table, SHEETS.get(_name(sheet)) if sheet.name else None)
        for sheet, table in tables_of(path, COLUMNS, faults, _is_read, unfold)
    ]
    if not frames:
        faults.add((str(path), None), None, f"no sheet with a table; expected the columns {', '.join(NEEDED)}")
    if not all(len(frame.columns) for frame in frames) or any(each.line is None for each in faults.problems):
        faults.stop()  # the columns: nothing can be checked below them
    rows = pd.concat(frames, ignore_index=True)
    if not (rows["family"] == "py").any():
        faults.add((str(path), None), None, "no rows of p-y curves (family py)")
        faults.stop()
    return rows


def _name(sheet: Sheet) -> str:
    return sheet.name.strip().lower()


def _is_read(sheet: Sheet) -> bool:
    """Return whether a sheet holds springs; refuse the workbook that a run writes for people."""
    if sheet.name and [cells[0] for _, cells in sheet.lines[:2]] == ["depth [m]", "slice [m]"]:
        message = "is the workbook for people that `pysprings run` writes; give the springs.nc or py.csv beside it"
        raise UserInputError([Problem(file=sheet.place.rpartition("[")[0], message=message)])
    return not sheet.name or bool(sheet.lines and _name(sheet) not in OTHER_SHEETS)


def _typed(table: Table, family: str | None) -> pd.DataFrame:
    """Return one sheet's rows with the right types; note the faults of its columns and numbers."""
    headings = any(each.file == table.place and each.line == table.head_line for each in table.faults.problems)
    for name in NEEDED if family in (None, "py") and not headings else ():
        if name not in table:
            table.fault(None, name, f"missing column (needed: {', '.join(NEEDED)})")
            headings = True
    if headings:
        return pd.DataFrame()
    data: dict[str, Any] = {"file": table.place, "line": table.lines}
    data |= {name: table.texts(name) if name in TEXTS else table.numbers(name) for name in PY_COLUMNS}
    frame = pd.DataFrame(data)
    _check_names(frame, table.faults)
    frame["family"] = frame["family"].where(frame["family"] != "", family or "py")
    known = frame["family"].isin(FAMILIES)
    for other in frame[~known].itertuples(index=False):
        table.faults.at(other, "family", f"{quoted(other.family)} is not one of {', '.join(FAMILIES)}")
    return frame[known]


def _check_names(frame: pd.DataFrame, faults: Faults) -> None:
    """Note names of paths that other files and programs would misread."""
    wrong = {name: name_fault(name) for name in frame["path"].unique() if name}
    for row in frame[frame["path"].map(lambda name: bool(wrong.get(name)))].itertuples(index=False):
        faults.at(row, "path", f"{quoted(row.path)}: {wrong[str(row.path)]}")
