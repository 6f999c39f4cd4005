# SPDX-License-Identifier: MIT
"""Rows of a table file: columns, numbers and names, each checked with its line."""

import os
from pathlib import Path
from typing import Any

import pandas as pd

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Column, Faults, Sheet, Table, tables_of
from pysprings.core.tables.headings import TEXT
from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.results.exporters.tables import ENDS, PAIRS, PY_COLUMNS, parse
from pysprings.springs.checks import name_fault

NEEDED = ("depth_m", "y_m", "p_N_per_m")
FAMILIES = ("py", "mtheta", "base", "lid", "tz")
OF_BEAM = {"m": "mtheta", "tip": "base"}  # words of `springs --for beam`, whose curves are straight lines
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
    words = frame["family"].where(frame["family"] != "", family or "py")
    frame["straight"] = words.isin(OF_BEAM)
    frame["family"] = words.replace(OF_BEAM)
    known = frame["family"].isin(FAMILIES)
    for other in frame[~known].itertuples(index=False):
        table.faults.at(
            other,
            "family",
            f"{quoted(other.family)} is not one of {', '.join(FAMILIES)}{suggestion(str(other.family), FAMILIES)}",
        )
    return frame[known]


def _check_names(frame: pd.DataFrame, faults: Faults) -> None:
    """Note names of paths that other files and programs would misread."""
    wrong = {name: name_fault(name) for name in frame["path"].unique() if name}
    for row in frame[frame["path"].map(lambda name: bool(wrong.get(name)))].itertuples(index=False):
        faults.at(row, "path", f"{quoted(row.path)}: {wrong[str(row.path)]}")


Lines = list[tuple[int, list[Any]]]

Place = tuple[str, str, str]  # depth, top and bottom of the slice, as they stand in the heading

_FAMILIES = ("py", "mtheta")  # of PAIRS
_OF_LATERAL = ("y_m", "p_N_per_m", "m_Nm_per_m")  # blank on a vertical path


def is_wide(head: list[str]) -> bool:
    """Return whether a heading is that of a wide table."""
    return any((heading := parse(name)) is not None and heading[0] in PAIRS[0] for name in head)


def unfold(head: list[str], lines: Lines) -> tuple[list[str], Lines]:
    """Return heading and lines of the long format, other tables as they are; other columns stay for the checks."""
    if not is_wide(head):
        return head, lines
    by_depth: dict[Place, dict[str, int]] = {}  # depth and slice -> quantity -> column
    for column, text in enumerate(head):
        if (heading := parse(text)) is not None and any(heading[0] in pair for pair in PAIRS):
            by_depth.setdefault(heading[1], {})[heading[0]] = column
    ends = {wide: head.index(wide) for columns in ENDS.values() for wide in columns.values() if wide in head}
    used = {column for own in by_depth.values() for column in own.values()} | set(ends.values())
    others = [column for column in range(len(head)) if column not in used]
    quantities = [name for pair in PAIRS for name in pair]
    long = ["family", "depth_m", "depth_top_m", "depth_bottom_m", *quantities, *ENDS["base"]]
    return [*long, *(head[column] for column in others)], [
        (line, family + [row[column] if column < len(row) else None for column in others] + row[len(head) :])
        for line, row in lines
        for family in [*_depth_rows(row, by_depth, quantities), *_end_rows(row, by_depth, ends, quantities)]
    ]


def _depth_rows(row: list[Any], by_depth: dict[Place, dict[str, int]], quantities: list[str]) -> list[list[Any]]:
    """Return rows of the families by depth of one wide row: y and p, then m and t; t alone on a vertical path."""
    filled = []
    lateral = [column for own in by_depth.values() for name, column in own.items() if name in _OF_LATERAL]
    if all(_cell(row, column) in (None, "") for column in lateral):
        ends: list[Any] = [None] * len(ENDS["base"])
        t = [[None] * 3 + [_cell(row, own.get("t_N_per_m"))] for own in by_depth.values()]
        return [["tz", *place, *cells, *ends] for place, cells in zip(by_depth, t, strict=True)]
    for family, pair in zip(_FAMILIES, PAIRS, strict=True):
        for place, columns in by_depth.items():
            if not any(name in columns for name in pair):
                continue
            cells = [_cell(row, columns.get(name)) if name in pair else None for name in quantities]
            filled.append([family, *place, *cells, *[None] * len(ENDS["base"])])
    return filled


def _end_rows(
    row: list[Any], by_depth: dict[Place, dict[str, int]], ends: dict[str, int], quantities: list[str]
) -> list[list[Any]]:
    """Return rows of tip (at the bottom of the deepest slice) and lid (depth 0) of one wide row."""
    bottom = max((place[2] for place in by_depth), key=_size)
    filled: list[list[Any]] = []
    for family, columns in ENDS.items():
        if any(wide in ends for wide in columns.values()):
            at = bottom if family == "base" else "0"
            forces = [_cell(row, ends.get(wide)) for wide in columns.values()]
            filled.append([family, at, at, at, *[None] * len(quantities), *forces])
    return filled


def _cell(row: list[Any], column: int | None) -> Any:
    return row[column] if column is not None and column < len(row) else None


def _size(text: str) -> float:
    try:
        return float(text)
    except ValueError:  # the checks of the cells note it
        return float("-inf")
