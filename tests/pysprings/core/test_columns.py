# SPDX-License-Identifier: MIT
"""Columns of tables: cells in the unit of the heading, nothing that looks like a number where there is none."""

import numpy as np
import pytest

from pysprings.core.columns import Column, Table, filled

ROWS = [{"name": "a|b", "H": 12345678.0, "n": 12000, "x": -0.001}, {"name": "c", "H": np.nan, "n": None, "x": 2.0}]
NAME = Column("name", "name", words=True)


@pytest.mark.parametrize(
    ("column", "cells"),
    [
        (NAME, ["a|b", "c"]),
        (Column("H [kN]", "H", factor=1e-3), ["12,346", "-"]),
        (Column("H [MN]", "H", ".2f", 1e-6), ["12.35", "-"]),
        (Column("n", "n"), ["12,000", "-"]),
        (Column("n", "n", "d"), ["12000", "-"]),
        (Column("x", "x", ".2f"), ["0.00", "2.00"]),
        (Column("x", "x", "+.1f"), ["0.0", "+2.0"]),
        (Column("twice", lambda row: 2.0 * row["x"], 3), ["-0.002", "4"]),
        (Column("none", "missing"), ["-", "-"]),
        (Column("none", "missing", words=True), ["", ""]),
    ],
)
def test_cells(column: Column, cells: list[str]) -> None:
    assert [column.cell(row) for row in ROWS] == cells
    assert filled([column], ROWS) == ([] if set(cells) <= {"", "-"} else [column])


def test_values_are_in_the_unit_of_the_heading() -> None:
    column = Column("H [MN]", "H", factor=1e-6, brief=False)
    assert [column.value(row) for row in ROWS] == [12.345678, None]
    assert Column("H [kN]", "H", factor=1e-3).value({"H": 1999999.9999999998}) == 2000.0  # of 2 MN in a workbook
    assert str(Column("x", "x").value({"x": -0.0})) == "0.0"
    assert filled([column], ROWS, brief=True) == []


def test_one_table_as_text_and_markdown() -> None:
    table = Table.of([NAME, Column("H [kN]", "H", factor=1e-3)], ROWS, "title", "note", wide=True)
    assert table.text().split("\n") == ["name  H [kN]", "----  ------", "a|b   12,346", "c          -"]
    assert table.markdown(numbers=True).split("\n")[1:3] == ["| --- | --: |", "| a\\|b | 12,346 |"]
    assert table.numeric == [False, True] and table.numeric is table.numeric  # read once, however many cells ask
    assert (table.title, table.note, table.wide) == ("title", "note", True)
