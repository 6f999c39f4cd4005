# SPDX-License-Identifier: MIT
"""Sheets -> tables with the columns that a reader declares: numbers in SI and texts, each fault with its place.

The heading is the first row with two known columns: titles and comments may stand above it, and a
row of units, or of "from" and "to", below it. Columns without heading and values are left out, and so is an index.
"""

import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.core.arrays import Array, Integers
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.tables.files import (
    Cell,
    Line,
    NotANumber,
    Sheet,
    Shown,
    Style,
    in_percent,
    is_blank,
    number,
    sheets_of,
    style_of,
    text_of,
)
from pysprings.core.tables.headings import (
    SHARES,
    TEXT,
    Column,
    Heading,
    Headings,
    KeyHeadings,
    WrongHeading,
    is_unit,
    shows_another,
)
from pysprings.core.units import LARGEST, fault, quoted

Reshape = Callable[[list[str], list[Line]], tuple[list[str], list[Line]]]
Assume = Callable[[Sequence[str]], Mapping[str, str]]
_TITLES = 30  # lines above the heading at most
_INDEX = ("", "index", "#", "no", "no.", "nr", "nr.", "unnamed: 0")


class TableNote(UserWarning):
    """What a reader of tables left out or joined."""


@dataclass
class Faults:
    """All faults found so far; `stop` raises them."""

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
        problems = sorted(self.problems, key=lambda each: (each.file or "", each.line or 0))
        raise UserInputError(problems)


@dataclass
class Table:
    """Rows of a table and the columns that were found; ``lines`` are their numbers in the file.

    ``above`` are the lines above the heading: titles, comments, values beside their names.
    """

    place: str
    head: list[str]
    rows: list[list[Cell]]
    lines: Integers
    faults: Faults
    head_line: int = 1
    columns: dict[str, tuple[int, Heading]] = field(default_factory=dict)
    style: Style = field(default_factory=Style)
    wrong: set[str] = field(default_factory=set)
    above: list[Line] = field(default_factory=list)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        return len(self.rows)

    def key(self, name: str) -> str:
        """Return the heading of a column as the user wrote it."""
        return self.columns[name][1].text if name in self.columns else name

    def cells(self, name: str) -> list[Cell]:
        """Return the cells of a column; None where the table does not have it."""
        at = self.columns[name][0] if name in self.columns else -1
        return [row[at] if 0 <= at < len(row) else None for row in self.rows]

    def texts(self, name: str) -> list[str]:
        """Return a column as texts on one line; blank for a word of `BLANK`."""
        return [text_of(cell) for cell in self.cells(name)]

    def number(self, name: str, cell: Cell) -> float | None:
        """Return the number of a cell in the unit of its heading; None of a blank one. Raises NotANumber."""
        value = number(cell, self.style)
        if isinstance(cell, Shown) and shows_another(self.columns[name][1], cell.unit):
            shown = quoted(f"{value:g} {cell.unit}")
            raise NotANumber(f"{shown} is what the cell shows: write it in the unit of the heading")
        return value

    def numbers(self, name: str, most: bool = True) -> Array:
        """Return a column in SI; NaN where a cell is blank or refused; ``most``: at most the largest of its unit."""
        out = np.full(len(self), np.nan)
        if name not in self.columns:
            return out
        heading = self.columns[name][1]
        unit = heading.column.unit if heading.column.unit in LARGEST else "1"
        for k, cell in enumerate(self.cells(name)):
            try:
                value = self.number(name, cell)
            except NotANumber as error:
                self.fault(k, name, str(error))
                continue
            if value is None or name in self.wrong:
                continue
            value *= heading.factor * (100.0 if SHARES.get(heading.unit) == 1.0 and in_percent(cell) else 1.0)
            if wrong := fault(value, unit) if most else "" if math.isfinite(value) else "is not a finite number":
                self.fault(k, name, f"{quoted(cell)} {wrong}")
            else:
                out[k] = value
        return out

    def stop_at_head(self) -> None:
        """Raise UserInputError where the headings have faults: nothing can be checked below them."""
        if any((each.file, each.line) == (self.place, self.head_line) for each in self.faults.problems):
            self.faults.stop()

    def fault_without_unit(self, name: str, exact: bool = False) -> None:
        """Note a column of shares whose heading has no unit: percent or not? With ``exact`` its own name is SI."""
        if name in self.columns and name not in self.wrong and (heading := self.columns[name][1]).unit in ("", "1"):
            if (exact and heading.text == name) or re.search(r"[\[(]\s*1\s*[\])]", heading.text):
                return
            if all(in_percent(cell) or is_blank(cell) for cell in self.cells(name)):
                return  # shown in percent by a workbook
            text = f"has no unit: write '{heading.text} [%]', or '{heading.text} [-]' for a share of 1"
            self.fault(None, name, text)

    def fault(self, k: int | None, name: str | None, message: str) -> None:
        """Note a fault in a row (None: in the headings), under a column's own heading."""
        line = self.head_line if k is None else int(self.lines[k])
        self.faults.add((self.place, line), None if name is None else self.key(name), message)


def one_table(
    path: Path, columns: Sequence[Column], what: str, assume: Assume = lambda head: {}, lenient: bool = False,
    sheets: list[Sheet] | None = None,
) -> Table:  # fmt: skip
    """Return the one table of a file that holds ``what``; its faults wait for `stop`.

    ``lenient``: unknown columns are left out with a note.  ``sheets`` : those of the file, where they are read already.

    Raises UserInputError: no file, no table, more than one sheet that has one, merged or hidden cells.
    """
    return _one(path, Headings(columns, assume, lenient), what, sheets)


def keyed_table(path: Path, words: Sequence[str], what: str) -> Table:
    """Return the one table of a file whose headings are keys of a scene, or ``words``: columns by key, any unit."""
    return _one(path, KeyHeadings(words), what)


def _one(path: Path, known: Headings, what: str, sheets: list[Sheet] | None = None) -> Table:
    sheets = _best(sheets_of(path) if sheets is None else sheets, known)
    seen = [sheet for sheet in sheets if not sheet.hidden]
    found = [sheet for sheet in seen if _head(sheet, known)[1] > 1]
    if len(found) > 1:
        names = ", ".join(quoted(sheet.name) for sheet in found)
        raise refused(None, f"the sheets {names} each hold {what}: keep one of them", path)
    if not found and any(_head(sheet, known)[1] > 1 for sheet in sheets):
        raise refused(None, f"the sheet that holds {what} is hidden: unhide it", path)
    chosen = found or [sheet for sheet in seen if sheet.lines][:1]
    return _table(chosen[0] if chosen else Sheet(str(path), "", []), known, Faults())


def tables_of(
    path: Path, columns: Sequence[Column], faults: Faults, wanted: Callable[[Sheet], bool], reshape: Reshape
) -> list[tuple[Sheet, Table]]:
    """Return the visible sheets of a file that are wanted with their tables, whose lines `reshape` changes before."""
    known = Headings(columns, lambda head: {})
    sheets = [sheet for sheet in _best(sheets_of(path), known) if not sheet.hidden and wanted(sheet)]
    if any(_head(sheet, known)[1] > 1 for sheet in sheets):  # then pages of words are no tables
        sheets = [each for each in sheets if _head(each, known)[1] or max(map(_width, each.lines), default=0) > 2]
    return [(sheet, _table(sheet, known, faults, reshape)) for sheet in sheets]


def _width(line: Line) -> int:
    return sum(not is_blank(cell) for cell in line[1])


def _best(sheets: list[Sheet], known: Headings) -> list[Sheet]:
    """Return the sheets; of a text that reads with several separators the one with the most known headings."""
    if sheets and sheets[0].separator:
        return [max(sheets, key=lambda sheet: _head(sheet, known)[1])]
    return sheets


def _head(sheet: Sheet, known: Headings) -> tuple[int, int]:
    """Return the place of the heading among the lines, the first with two known columns, and their number."""
    best, count = 0, 0
    comments = next((k for k, (_, cells) in enumerate(sheet.lines) if not _begins_with_hash(cells)), 0)
    for k, (_, cells) in enumerate(sheet.lines[: comments + _TITLES]):
        texts = [text_of(cell) for cell in cells if isinstance(cell, str) and text_of(cell)]
        own = len({column[0].name for text in texts if (column := known.column_of(text))})
        if own > 1:
            return k, own
        if own > count and own == len(texts):
            best, count = k, own
    return best, count


def _table(sheet: Sheet, known: Headings, faults: Faults, reshape: Reshape | None = None) -> Table:
    at = _head(sheet, known)[0]
    lines = sheet.lines[at:]
    while lines and text_of(lines[0][1][0] if lines[0][1] else None).startswith("# ") and len(lines) > 1:
        lines = lines[1:]  # comments of a table without known columns
    head = [text_of(cell) if cell is not None else "" for cell in lines[0][1]] if lines else []
    line = lines[0][0] if lines else 1
    head, used = _joined(head, lines, sheet)
    body = [each for each in lines[used:] if not _is_comment(each)]
    while head and not head[-1] and all(is_blank(cells[len(head) - 1]) for _, cells in body if len(cells) >= len(head)):
        head.pop()
    if reshape is not None:
        head, body = reshape(head, body)
    numbers = np.array([number for number, _ in body], dtype=np.int64)
    table = Table(sheet.place, head, [cells for _, cells in body], numbers, faults, line, above=sheet.lines[:at])
    _refuse_merged(table, sheet)
    _read_head(table, known)
    _refuse_hidden(table, sheet)
    words = {k for k, heading in table.columns.values() if heading.column.unit == TEXT}
    cells = (cell for row in table.rows for k, cell in enumerate(row) if k not in words)
    table.style = style_of(cells, sheet.separator != ",")
    for k, row in enumerate(table.rows):
        if any(not is_blank(cell) for cell in row[len(head) :]):
            table.fault(k, None, f"more cells than the {len(head)} columns of the heading")
        if _begins_with_hash(row):
            table.fault(k, None, "begins with #: delete the row, or the sign")
    return table


def _is_comment(line: Line) -> bool:
    """Return whether a line is a comment: a text that begins with # and nothing beside it."""
    return _begins_with_hash(line[1]) and all(is_blank(cell) for cell in line[1][1:])


def _begins_with_hash(cells: list[Cell]) -> bool:
    return bool(cells) and isinstance(cells[0], str) and cells[0].lstrip().startswith("#")


def _joined(head: list[str], lines: list[Line], sheet: Sheet) -> tuple[list[str], int]:
    """Return the headings with the row of units (or of from and to) below them, and the number of their lines."""
    below = [text_of(cell) if cell is not None else "" for cell in lines[1][1]] if len(lines) > 1 else []
    filled = [text for text in below if text]
    ends = ("from", "to", "top", "bottom")
    if len(filled) < 2 or not all(text.lower() in ends or (text != "1" and is_unit(text)) for text in filled):
        return head, 1
    head = head + [""] * (len(below) - len(head))
    for top, left, bottom, right in sheet.merged:
        if top == lines[0][0] and bottom <= lines[1][0]:
            head[left - 1 : right] = [head[left - 1]] * (right - left + 1)
    joined = []
    for text, extra in zip(head, [*below, *[""] * len(head)], strict=False):
        name, unit = re.fullmatch(r"(.*?)\s*([\[(][^\[\]]*[\])])?", text).groups()  # type: ignore[union-attr]
        if unit and is_unit(extra) and extra.strip("[]()") != unit.strip("[]()"):
            return head, 1  # two units for one column: the row is refused where it is read
        if extra.lower() in ends:
            text = f"{name} {extra.lower()} {unit or ''}".strip()
        elif is_unit(extra) and not unit:
            text = f"{text} [{extra.strip().strip('[]()')}]"
        joined.append(text)
    warnings.warn(f"{sheet.place}:{lines[1][0]}: read as the second row of the heading", TableNote, stacklevel=2)
    return joined, 2


def _read_head(table: Table, known: Headings) -> None:
    """Find the column of each heading; note wrong ones, repeated ones, and values below no heading."""
    by_name: dict[str, list[str]] = {}
    skipped: dict[str, list[str]] = {}
    known.units = known.assume(table.head)
    for k, text in enumerate(table.head):
        if text.lower() in _INDEX:
            own = [row[k] for row in table.rows if k < len(row) and not is_blank(row[k])]
            if not own or (k == 0 and _counts(own)):
                continue
        if not text:
            message = f"column {k + 1} has values and no heading: give it one, or delete it"
            table.faults.add((table.place, table.head_line), f"column {k + 1}", message)
            continue
        try:
            heading = known.read(text)
        except WrongHeading as error:
            if error.column is None and known.lenient:
                skipped.setdefault("unknown columns", []).append(text)
                continue
            table.faults.add((table.place, table.head_line), quoted(text), str(error))
            if error.column is None:
                continue
            heading = Heading(text, error.column)
            table.wrong.add(error.column.name)
        if heading.column.skipped:
            skipped.setdefault(heading.column.skipped, []).append(text)
            continue
        by_name.setdefault(heading.column.name, []).append(text)
        table.columns.setdefault(heading.column.name, (k, heading))
    for name, texts in by_name.items():
        if known.lenient:
            skipped.setdefault("columns that stand twice: the first one counts", []).extend(texts[1:])
        elif len(texts) > 1:
            written = "" if set(texts) == {name} else f" ({', '.join(map(quoted, texts))})"
            message = f"column stands {len(texts)} times{written}"
            table.faults.add((table.place, table.head_line), quoted(name), message)
    for why, texts in ((why, texts) for why, texts in skipped.items() if texts):
        warnings.warn(f"{table.place}: not used: {', '.join(map(quoted, texts))} ({why})", TableNote, stacklevel=2)


def _counts(cells: Sequence[Cell]) -> bool:
    """Return whether cells count from 0 or 1 upwards, as the index of a table does."""
    try:
        values = [number(cell, Style()) for cell in cells]
    except NotANumber:
        return False
    return values in ([float(k) for k in range(len(values))], [float(k + 1) for k in range(len(values))])


def _refuse_merged(table: Table, sheet: Sheet) -> None:
    """Note merged cells among the values: one value of theirs is stored, the others are blank."""
    if not len(table):
        return
    from openpyxl.utils import get_column_letter as letter

    for top, left, bottom, right in sheet.merged:
        first = int(table.lines[0])
        if bottom >= first and top <= int(table.lines[-1]):
            corners = f"{letter(left)}{top}:{letter(right)}{bottom}"
            message = f"the cells {corners} are merged: unmerge them, and fill in each of them"
            table.faults.add((table.place, max(top, first)), corners, message)


def _refuse_hidden(table: Table, sheet: Sheet) -> None:
    """Note rows, and columns that are used, which the sheet does not show."""
    for k, line in enumerate(table.lines.tolist()):
        if line in sheet.hidden_lines:
            table.fault(k, None, "the row is hidden: unhide it, or delete it")
    for k, heading in table.columns.values():
        if k + 1 in sheet.hidden_columns:
            table.fault(None, heading.column.name, "the column is hidden: unhide it, or delete it")
