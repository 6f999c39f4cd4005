# SPDX-License-Identifier: MIT
"""Rows of a table file: columns, numbers and names, each checked with its line."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import quoted
from pysprings.results.exporters.tables import PY_COLUMNS
from pysprings.results.tables.csv_file import CSV
from pysprings.results.tables.faults import Faults, numbers
from pysprings.results.tables.headings import Column, read_headings
from pysprings.results.tables.reader import Line
from pysprings.results.tables.readers import reader_of
from pysprings.results.tables.wide import is_wide, unfold
from pysprings.springs.numbers import name_fault

NEEDED = ("depth_m", "y_m", "p_N_per_m")
FAMILIES = ("py", "mtheta", "base", "lid", "tz")
TEXTS = ("path", "family", "side", "component")
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
        _typed(place, family, *(unfold(head, cells) if is_wide(head) else (head, cells)), faults)
        for place, family, head, cells in _sheets(path)
    ]
    if not frames:
        faults.add((str(path), None), None, f"no sheet with a table; expected the columns {', '.join(NEEDED)}")
    if any(each.line in (None, 1) for each in faults.problems):
        faults.stop()  # the columns: nothing can be checked below them
    rows = pd.concat(frames, ignore_index=True)
    if not (rows["family"] == "py").any():
        faults.add((str(path), None), None, "no rows of p-y curves (family py)")
        faults.stop()
    return rows


def sheet_of(path: Path) -> tuple[list[str], list[Line]]:
    """Return heading and lines of the first table of a file that holds any."""
    _refuse_missing(path)
    sheets = (reader_of(path) or CSV).sheets(path)
    return _first_and_rest(next((sheet.lines for sheet in sheets if sheet.lines), []))


def _refuse_missing(path: Path) -> None:
    if not path.is_file():
        raise UserInputError([Problem(file=str(path), message="is a folder" if path.is_dir() else "no such file")])


def _sheets(path: Path) -> Iterator[tuple[str, str | None, list[str], list[Line]]]:
    """Yield (place, family of the sheet or None, heading, lines) for each sheet with a table."""
    _refuse_missing(path)
    for name, lines in (reader_of(path) or CSV).sheets(path):
        if not name:
            yield str(path), None, *_first_and_rest(lines)
            continue
        if lines and lines[0][1][0] == "depth [m]":
            message = "is the workbook for people that `pysprings run` writes; give the springs.nc or py.csv beside it"
            raise UserInputError([Problem(file=str(path), message=message)])
        if name.strip().lower() not in OTHER_SHEETS and lines:
            yield f"{path}[{name}]", SHEETS.get(name.strip().lower()), *_first_and_rest(lines)


def _first_and_rest(lines: list[Line]) -> tuple[list[str], list[Line]]:
    head = [str(cell or "").strip() for cell in lines[0][1]] if lines else []
    while head and not head[-1]:
        head.pop()
    return head, lines[1:]


def _typed(
    place: str, family: str | None, head: list[str], cells: Sequence[tuple[int, list[Any]]], faults: Faults
) -> pd.DataFrame:
    """Return one sheet's rows with the right types; note the faults of its columns and numbers."""
    before, width = len(faults.problems), len(head)
    read = _columns(place, head, family, faults)
    if len(faults.problems) > before:
        return pd.DataFrame()
    for line, row in cells:
        if any(cell not in (None, "") for cell in row[width:]):
            faults.add((place, line), None, f"more cells than the {width} columns of the heading")
    columns = {
        each.name: ([row[k] if k < len(row) else None for _, row in cells], each.factor) for k, each in enumerate(read)
    }
    lines = np.array([line for line, _ in cells], dtype=np.int64)
    data: dict[str, Any] = {"file": place, "line": lines}
    for name in PY_COLUMNS:
        given, factor = columns.get(name, ([None] * len(lines), 1.0))
        if name in TEXTS:
            data[name] = ["" if cell is None else str(cell).strip() for cell in given]
        else:
            data[name] = numbers(place, name, given, lines, faults, factor)
    frame = pd.DataFrame(data)
    _check_names(frame, faults)
    frame["family"] = frame["family"].where(frame["family"] != "", family or "py")
    known = frame["family"].isin(FAMILIES)
    for other in frame[~known].itertuples(index=False):
        faults.at(other, "family", f"{quoted(other.family)} is not one of {', '.join(FAMILIES)}")
    return frame[known]


def _check_names(frame: pd.DataFrame, faults: Faults) -> None:
    """Note names of paths that other files and programs would misread."""
    wrong = {name: name_fault(name) for name in frame["path"].unique() if name}
    for row in frame[frame["path"].map(lambda name: bool(wrong.get(name)))].itertuples(index=False):
        faults.at(row, "path", f"{quoted(row.path)}: {wrong[str(row.path)]}")


def _columns(place: str, head: list[str], family: str | None, faults: Faults) -> list[Column]:
    """Return the column of each heading; note faults of the headings and missing columns."""
    read = read_headings(place, head, PY_COLUMNS, faults)
    names = [column.name for column in read if column]
    if len(names) == len(head):
        for name in NEEDED if family in (None, "py") else ():
            if name not in names:
                faults.add((place, 1), name, f"missing column (needed: {', '.join(NEEDED)})")
    return [column for column in read if column]
