# SPDX-License-Identifier: MIT
"""Units of headings and numbers of European spreadsheets: what is read, and what is refused because it is in doubt."""

import pytest

from pysprings.core.tables.files import NotANumber, number, style_of
from pysprings.core.tables.headings import GRAVITY, Column, Headings, WrongHeading
from pysprings.core.tables.load_cases import COLUMNS

KNOWN = Headings(COLUMNS, lambda head: {})


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
        ("direction [°]", "direction_rad", 0.017453292519943295),
        ("H / kN", "H_N", 1e3),
        ("M_kN_m", "M_Nm", 1e3),
        ("M [kN-m]", "M_Nm", 1e3),
        ("Fx [kip]", "Fx_N", 4448.2216152605),
    ],
)
def test_headings(heading: str, column: str, factor: float) -> None:
    read = KNOWN.read(heading)
    assert read.column.name == column
    assert read.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    ("heading", "factor"),
    [("strain [%]", 0.01), ("strain_pct", 0.01), ("strain [percent]", 0.01), ("strain [mm/m]", 1e-3),
     ("strain_ppm", 1e-6), ("strain [-]", 1.0)],
)  # fmt: skip
def test_units_of_a_share(heading: str, factor: float) -> None:
    """Of a column that may be in percent; of others they are no units."""
    assert Headings([Column("strain", percent=0.01)], lambda head: {}).read(heading).factor == pytest.approx(factor)
    if heading != "strain [-]":
        with pytest.raises(WrongHeading, match="expected a column without unit"):
            Headings([Column("strain")], lambda head: {}).read(heading)


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("H", "no unit: write 'H [kN]'"),
        ("H [mm]", "wrong unit \"mm\": expected a force such as 'H [kN]'"),
        ("H [mN]", '"mN": m is milli, M is mega'),
        ("M [kN]", "wrong unit \"kN\": expected a moment such as 'M [kN m]'"),
        ("H [foo]", 'unknown unit "foo"'),
        ("factor [kN]", 'wrong unit "kN": expected a column without unit'),
        ("Hh [kN]", "unknown column"),
    ],
)
def test_headings_that_are_refused(heading: str, message: str) -> None:
    with pytest.raises(WrongHeading) as caught:
        KNOWN.read(heading)
    assert str(caught.value).startswith(message)


DOUBT = ": write one digit more or less, or no separator"
BESIDE = "has a decimal point beside decimal commas in the same table"


@pytest.mark.parametrize(
    ("cells", "decimals", "numbers"),
    [
        (["1.5", "2"], False, [1.5, 2.0]),
        (["1,5", "2"], True, [1.5, 2.0]),
        (["-1,5e3", ",5", "−2"], True, [-1500.0, 0.5, -2.0]),
        (["1.5", "", "nan", "-", "n/a"], True, [1.5, None, None, None, None]),
        (["1,5"], False, ['"1,5" is not a number: a decimal comma needs semicolons between the cells']),
        (["1,5", "2.5"], True, [1.5, f'"2.5" {BESIDE}']),
        (["9,5", "150.000"], True, [9.5, f'"150.000" {BESIDE}']),
        (["1,250"], True, [f'"1,250" may be 1.25 or 1250{DOUBT}']),
        (["1.250", "12.500"], True, [f'"1.250" may be 1.25 or 1250{DOUBT}', f'"12.500" may be 12.5 or 12500{DOUBT}']),
        (["0,250", "1,250"], True, [0.25, 1.25]),  # nobody writes a leading zero before thousands
        (["1 250", "1'250", "1,250.5"], False, [f'"{each}" is not a number: write it without separators of thousands'
                                               for each in ("1 250", "1'250")] + ['"1,250.5" is not a number: write it '
                                                                                  "without separators of thousands"]),
        (["1_000", "0x10", "5 kPa", "#REF!", "inf", "=1+1"], False,
         ['"1_000" is not a number: write it without separators of thousands', '"0x10" is not a number',
          '"5 kPa" is not a number', '"#REF!" is an error of the spreadsheet: mend its formula',
          '"inf" is not a finite number', '"=1+1" is not a number: it is a formula; write its value']),
        ([True, 3, 2.5, None], False, ["true is not a number", 3.0, 2.5, None]),
    ],
)  # fmt: skip
def test_numbers(cells: list[object], decimals: bool, numbers: list[object]) -> None:
    style, read = style_of(cells, decimals), []
    for cell in cells:
        try:
            read.append(number(cell, style))
        except NotANumber as error:
            read.append(str(error))
    assert read == numbers
