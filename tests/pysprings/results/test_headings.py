# SPDX-License-Identifier: MIT
"""Units of headings and numbers of European spreadsheets: what is read, and what is refused because it is in doubt."""

from __future__ import annotations

import pytest

from pysprings.core.spreadsheets import Doubtful, rows_of
from pysprings.results.tables.faults import Faults
from pysprings.results.tables.headings import GRAVITY, read_headings
from pysprings.results.tables.load_cases import ALIASES, COLUMNS


def read(*head: str) -> list[tuple[str, float]]:
    faults = Faults()
    columns = read_headings("file", head, COLUMNS, faults, ALIASES)
    assert not faults.problems
    return [(column.name, column.factor) for column in columns if column]


@pytest.mark.parametrize(
    ("heading", "column", "factor"),
    [
        ("H_N", "H_N", 1.0),
        ("H [kN]", "H_N", 1e3),
        ("h (MN)", "H_N", 1e6),
        ("Horizontal [kN]", "H_N", 1e3),
        ("M [kNm]", "M_Nm", 1e3),
        ("M_kNm", "M_Nm", 1e3),
        ("moment [MN m]", "M_Nm", 1e6),
        ("M [t m]", "M_Nm", 1e3 * GRAVITY),
        ("V [t]", "V_N", 1e3 * GRAVITY),
        ("V, [kg]", "V_N", GRAVITY),
        ("height [mm]", "arm_m", 1e-3),
        ("arm_m", "arm_m", 1.0),
        ("direction [deg]", "direction_rad", 0.017453292519943295),
        ("M direction [deg]", "M_direction_rad", 0.017453292519943295),
        ("Limit State", "limit_state", 1.0),
        ("Load case", "name", 1.0),
        ("factor", "factor", 1.0),
        ("factor V [-]", "factor_V", 1.0),
        ("tilt [mrad]", "tilt_rad", 1e-3),
    ],
)
def test_headings(heading: str, column: str, factor: float) -> None:
    ((name, scale),) = read(heading)
    assert name == column
    assert scale == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    ("head", "message"),
    [
        (["H"], "no unit: write 'H [kN]'"),
        (["H [mm]"], "wrong unit \"mm\": expected a force such as 'H [kN]'"),
        (["H [mN]"], '"mN": m is milli, M is mega'),
        (["M [kN]"], "wrong unit \"kN\": expected a moment such as 'M [kN m]'"),
        (["H [foo]"], 'unknown unit "foo"'),
        (["factor [kN]"], '"kN": a column without unit'),
        (["Hh [kN]"], "unknown column"),
        (["H_N", "H [kN]"], 'column stands 2 times ("H_N", "H [kN]")'),
    ],
)
def test_headings_that_are_refused(head: list[str], message: str) -> None:
    faults = Faults()
    read_headings("file", head, COLUMNS, faults, ALIASES)
    (problem,) = faults.problems
    assert (problem.file, problem.line) == ("file", 1)
    assert problem.message.startswith(message)


@pytest.mark.parametrize(
    ("text", "cells"),
    [
        ("a,b\n1.5,2\n", ["1.5", "2"]),
        ("a;b\n1,5;2\n", ["1.5", "2"]),
        ("a;b\n-1,5e3;,5\n", ["-1.5e3", ".5"]),
        ("a;b\n1.5;2\n", ["1.5", "2"]),
        ("a;b\nx,y;DLC 6,1\n", ["x,y", "DLC 6,1"]),
        ('a,b\n"1,5",2\n', ["1,5", "2"]),  # no decimal comma there: refused as a number
    ],
)
def test_separators(text: str, cells: list[str]) -> None:
    assert rows_of(text)[1] == (2, cells)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a;b\n1,5;2.5\n", [None, "has a decimal point beside decimal commas in the same table"]),
        ("a;b\n1,250;3\n", ["may be 1.25 or 1250: write one digit more or less, or no separator", None]),
        ("a;b\n1.250;12.500\n", ["may be 1.25 or 1250: write one digit more or less, or no separator",
                                 "may be 12.5 or 12500: write one digit more or less, or no separator"]),
        ("a;b\n0,250;1,250\n", [None, None]),  # nobody writes a leading zero before thousands
    ],
)  # fmt: skip
def test_numbers_in_doubt(text: str, why: list[str | None]) -> None:
    cells = rows_of(text)[1][1]
    assert [cell.why if isinstance(cell, Doubtful) else None for cell in cells] == why
