# SPDX-License-Identifier: MIT
"""A table as it stands in a CSV file or an Excel workbook: its columns, numbers and lines, checked one by one."""

from __future__ import annotations

import csv
import difflib
import io
import os
import re
import zipfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.magnitudes import fault, unit_of_column
from pysprings.core.units import quoted
from pysprings.results.exporters.tables import PY_COLUMNS
from pysprings.results.tables.wide import is_wide, unfold
from pysprings.springs.numbers import name_fault

NEEDED = ("depth_m", "y_m", "p_N_per_m")
FAMILIES = ("py", "mtheta", "base", "lid", "tz")
TEXTS = ("path", "family", "side", "component")
# Sheets that are not read: words and pictures.
OTHER_SHEETS = ("about", "charts", "load-displacement", "stiffness 6x6")
SHEETS = {"py": "py", "p-y": "py", "mtheta": "mtheta", "m-theta": "mtheta", "base": "base", "tip": "base", "lid": "lid"}
MOST_WORDS = 200  # characters of what a library says
# Largest table: bytes (of a workbook when unpacked), lines of a sheet, and of a CSV file (ten seconds of checks).
MOST_BYTES, MOST_LINES, MOST_CSV_LINES = 50_000_000, 200_000, 300_000


@dataclass
class Faults:
    """Everything found wrong so far; `stop` raises it."""

    problems: list[Problem] = field(default_factory=list)
    _seen: set[tuple[Any, ...]] = field(default_factory=set)

    def add(self, place: tuple[str, int | None], key: str | None, message: str) -> None:
        """Note one problem at (file, line); the first one of a cell counts."""
        if (*place, key) not in self._seen:
            self._seen.add((*place, key))
            self.problems.append(Problem(file=place[0], line=place[1], key=key, message=message))

    def at(self, row: Any, key: str | None, message: str) -> None:
        """Note one problem in a row of a table (a named tuple with file and line)."""
        self.add((str(row.file), int(row.line)), key, message)

    def stop(self) -> None:
        """Raise UserInputError when there is any problem."""
        if not self.problems:
            return
        found = sorted(self.problems, key=lambda each: (each.file or "", each.line or 0))
        raise UserInputError(found)


def read_rows(path: str | os.PathLike[str], faults: Faults) -> pd.DataFrame:
    """Return the rows of a table: every column of `PY_COLUMNS`, numbers as numbers (NaN: blank), and `file`, `line`.

    Refuses missing, repeated and unknown columns and other units; notes cells that are not finite numbers and
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


def sheet_of(path: Path) -> tuple[list[str], list[tuple[int, list[Any]]]]:
    """Return heading and (line, cells) of a CSV file."""
    (place,) = _sheets(path, csv_only=True)
    return place[2], place[3]


Sheet = tuple[str, str | None, list[str], list[tuple[int, list[Any]]]]


def _sheets(path: Path, csv_only: bool = False) -> Iterator[Sheet]:
    """Yield (place, family of the sheet or None, heading, [(line, cells)]) for each sheet with a table."""
    if not path.is_file():
        raise UserInputError([Problem(file=str(path), message="is a folder" if path.is_dir() else "no such file")])
    if csv_only or path.suffix.lower() == ".csv":
        yield str(path), None, *_first_and_rest(_csv_lines(path))
        return
    for name, lines in _workbook(path):
        if lines and lines[0][1][0] == "depth [m]":
            message = "is the workbook for people that `pysprings run` writes; give the springs.nc or py.csv beside it"
            raise UserInputError([Problem(file=str(path), message=message)])
        if name.strip().lower() not in OTHER_SHEETS and lines:
            yield f"{path}[{name}]", SHEETS.get(name.strip().lower()), *_first_and_rest(lines)


def _first_and_rest(lines: list[tuple[int, list[Any]]]) -> tuple[list[str], list[tuple[int, list[Any]]]]:
    head = [str(cell or "").strip() for cell in lines[0][1]] if lines else []
    while head and not head[-1]:
        head.pop()
    return head, lines[1:]


def _csv_lines(path: Path) -> list[tuple[int, list[Any]]]:
    """Lines with something in them, numbered as an editor numbers them."""
    if (size := path.stat().st_size) > MOST_BYTES:
        raise _too_large(path, f"{size / 1e6:,.0f} MB, at most {MOST_BYTES / 1e6:.0f}")
    try:
        content = path.read_bytes()
        if (count := content.count(b"\n")) > MOST_CSV_LINES:
            raise _too_large(
                path, f"{count:,} lines, at most {MOST_CSV_LINES:,}; springs.nc of a run has no such limit"
            )
        with io.StringIO(content.decode("utf-8-sig"), newline="") as stream:
            reader = csv.reader(stream)
            lines = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserInputError([Problem(file=str(path), message=f"not a CSV file in UTF-8 ({error})")]) from None
    if lines and len(lines[0][1]) == 1 and re.search(r"[;\t]", lines[0][1][0]):
        message = "columns are separated by ';' or tabs: expected ',' (and decimal points)"
        raise UserInputError([Problem(str(path), lines[0][0], message=message)])
    return lines


def _workbook(path: Path) -> Iterator[tuple[str, list[tuple[int, list[Any]]]]]:
    import openpyxl

    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            size = sum(part.file_size for part in archive.infolist())
            if size > MOST_BYTES:
                raise _too_large(path, f"{size / 1e6:,.0f} MB when unpacked, at most {MOST_BYTES / 1e6:.0f}")
            book = openpyxl.load_workbook(stream, read_only=True, data_only=True)
            try:
                for sheet in book.worksheets:
                    yield sheet.title, list(_lines(path, sheet))
            finally:
                book.close()
    except (UserInputError, GeneratorExit):
        raise
    except Exception as error:  # a broken archive raises many types
        why = str(error) or type(error).__name__
        raise UserInputError([Problem(file=str(path), message=f"not an Excel workbook ({why[:MOST_WORDS]})")]) from None


def _lines(path: Path, sheet: Any) -> Iterator[tuple[int, list[Any]]]:
    """Yield (line, cells) of the lines of a sheet with something in them."""
    for line, cells in enumerate(sheet.iter_rows(values_only=True), start=1):
        if line > MOST_LINES:
            raise _too_large(path, f"sheet {quoted(sheet.title)} has more than {MOST_LINES:,} lines")
        if any(cell is not None for cell in cells):
            yield line, list(cells)


def _too_large(path: Path, message: str) -> UserInputError:
    return UserInputError([Problem(file=str(path), message=f"is too large for a table ({message})")])


def _typed(
    place: str, family: str | None, head: list[str], cells: Sequence[tuple[int, list[Any]]], faults: Faults
) -> pd.DataFrame:
    """Return one sheet's rows with the right types; note what is wrong with its columns and numbers."""
    before, width = len(faults.problems), len(head)
    _check_head(place, head, family, faults)
    if len(faults.problems) > before:
        return pd.DataFrame()
    for line, row in cells:
        if any(cell not in (None, "") for cell in row[width:]):
            faults.add((place, line), None, f"more cells than the {width} columns of the heading")
    columns = {name: [row[k] if k < len(row) else None for _, row in cells] for k, name in enumerate(head)}
    lines = np.array([line for line, _ in cells], dtype=np.int64)
    data: dict[str, Any] = {"file": place, "line": lines}
    for name in PY_COLUMNS:
        given = columns.get(name, [None] * len(lines))
        if name in TEXTS:
            data[name] = ["" if cell is None else str(cell).strip() for cell in given]
        else:
            data[name] = numbers(place, name, given, lines, faults)
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


def _check_head(place: str, head: list[str], family: str | None, faults: Faults) -> None:
    at = (place, 1)
    for name, count in Counter(head).items():
        if count > 1:
            faults.add(at, quoted(name), f"column stands {count} times")
    wrong = {name: meant(name) for name in head if name not in PY_COLUMNS}
    for name, column in wrong.items():
        if column:
            faults.add(at, quoted(name), f"wrong name or unit: expected '{column}' (SI; convert the numbers)")
        else:
            near = difflib.get_close_matches(name, PY_COLUMNS, n=1, cutoff=0.6)
            hint = f" (did you mean '{near[0]}'?)" if near else f"; known are {', '.join(PY_COLUMNS)}"
            faults.add(at, quoted(name), f"unknown column{hint}")
    for name in NEEDED if family in (None, "py") else ():
        if name not in head and name not in wrong.values():
            faults.add(at, name, f"missing column (needed: {', '.join(NEEDED)})")


def meant(name: str, columns: Sequence[str] = PY_COLUMNS) -> str | None:
    """Return the column that differs from a name in its unit only: `y_m` for `y_mm` or `y [mm]`."""
    stem = re.split(r"[\s_\[(/,]", name.strip(), maxsplit=1)[0]
    if name.startswith(("depth_top", "depth_bottom")):
        stem = "_".join(name.split("_")[:2])
    known = {_stem(column): column for column in columns if "_" in column}
    return known.get(stem)


def _stem(column: str) -> str:
    return column.rsplit("_m", 1)[0] if column.startswith("depth") else column.split("_")[0]


def numbers(place: str, name: str, given: list[Any], lines: np.ndarray, faults: Faults) -> np.ndarray:
    """Numbers of a column; NaN where a cell is blank, no number, or of a size that nothing has."""
    unit = unit_of_column(name)
    out = np.full(len(given), np.nan)
    for k, cell in enumerate(given):
        if cell is None or (isinstance(cell, str) and not cell.strip()):
            continue
        try:
            value = float(cell)
        except (TypeError, ValueError):
            faults.add((place, int(lines[k])), name, f"{quoted(cell)} is not a number")
            continue
        if wrong := fault(value, unit):
            faults.add((place, int(lines[k])), name, f"{quoted(cell)} {wrong}")
            continue
        out[k] = value
    return out
