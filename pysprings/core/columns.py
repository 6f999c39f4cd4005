# SPDX-License-Identifier: MIT
"""Columns of tables for people, declared once for terminal, Markdown, page and workbook: heading, unit, figures."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from pysprings.core.text import markdown_table, number, plain_table

if TYPE_CHECKING:
    import pandas as pd

Row = Mapping[Any, Any]
# a number, with the letter of a quantity before it and its unit behind it; "-" and blank: there is none
_NUMBER = re.compile(r"([A-Z] )?[-+]?[\d,]*\.?\d+(e[-+]?\d+)?( [A-Za-z%/]+)*|-|")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table: how a value of a row, in SI, is shown.

    head : heading, with the unit.
    source : key of the value in a row, or a function of the row.
    form : figures of a number, or a format such as ".2f".
    factor : from the value of a row to the unit of the heading.
    words : whether it holds texts, which are set to the left.
    brief : whether the short form of the table has it.
    """

    head: str
    source: str | Callable[[Row], Any]
    form: int | str = 4
    factor: float = 1.0
    words: bool = False
    brief: bool = True

    def value(self, row: Row) -> Any:
        """Return the text or number of a row in the unit of the heading; None where there is none."""
        given = self.source(row) if callable(self.source) else row.get(self.source)
        if self.words or isinstance(given, str):
            return "" if given is None else str(given)
        if given is None or (not isinstance(given, list | tuple) and math.isnan(given)):
            return None
        if not isinstance(given, float) and self.factor == 1.0:
            return given
        return float(f"{given * self.factor:.12g}") + 0.0  # 2000, not 1999.9999999997: a factor's rounding

    def cell(self, row: Row) -> str:
        """Return the cell of a row as text; "-" where there is no number."""
        value = self.value(row)
        if isinstance(value, str):
            return value
        if value is None or isinstance(self.form, int):
            return "-" if value is None else number(value, int(self.form))
        text = format(int(value) if self.form.endswith("d") else value, self.form)
        return text if re.search("[1-9]", text) else text.removeprefix("-")  # no -0.00


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a frame by column name, as plain values; missing ones are None."""
    plain = frame.astype(object).where(frame.notna(), None)
    return [{str(name): value for name, value in row.items()} for row in plain.to_dict("records")]


def filled(columns: Iterable[Column], rows: Sequence[Row], brief: bool = False) -> list[Column]:
    """Return the columns that hold anything in the rows; with ``brief`` those of the short form."""
    return [
        column
        for column in columns
        if (column.brief or not brief) and any(column.cell(row) not in ("", "-") for row in rows)
    ]


@dataclass(frozen=True)
class Table:
    """A table for people, cells as text.

    title : Caption; blank for none.
    columns : Headings with units.
    rows : Cells by row.
    note : Remark below the table.
    head : Show the headings.
    wide : The table scrolls where a page is narrow, and has small type in print.
    left : Whether each of the first columns is set to the left on a terminal; the others are not.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    head: bool = True
    wide: bool = False
    left: Sequence[bool] = (True,)

    @classmethod
    def of(
        cls, columns: Sequence[Column], rows: Iterable[Row], title: str = "", note: str = "", wide: bool = False
    ) -> Table:
        """Return the table of declared columns, a row of cells for each of the rows."""
        cells = [[column.cell(row) for column in columns] for row in rows]
        left = [column.words for column in columns]
        return cls(title, [column.head for column in columns], cells, note, wide=wide, left=left)

    @cached_property
    def numeric(self) -> list[bool]:
        """Whether each column holds numbers alone, which are set to the right; none in a table without headings."""
        columns = [[str(row[k]) for row in self.rows] for k in range(len(self.columns))]
        return [
            self.head and any(cell.strip("-") for cell in cells) and all(_NUMBER.fullmatch(cell) for cell in cells)
            for cells in columns
        ]

    def text(self) -> str:
        """Return the table for a terminal."""
        return plain_table(self.columns, self.rows, self.left)

    def markdown(self, numbers: bool = False) -> str:
        """Return the table in Markdown; with ``numbers``, all columns but the first are set to the right."""
        return markdown_table(self.columns, self.rows, numbers)
