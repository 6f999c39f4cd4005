# SPDX-License-Identifier: MIT
"""Quantities: what is read, what is refused and how, and that nothing is evaluated."""

import math

import pytest
from hypothesis import given, settings, strategies as st

from pysprings.core import units
from pysprings.core.units import MEANING, QuantityError, quoted, read, show, si_of
from tests.support.watch import time_limit


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("200 MPa", "Pa", 200e6),
        ("7.8m", "m", 7.8),
        ("  7.8   m ", "m", 7.8),
        ("100 mm", "m", 0.1),
        (".5 m", "m", 0.5),
        ("5. m", "m", 5.0),
        ("+3e-2 cm", "m", 3e-4),
        ("0.05 mm/s", "m/s", 5e-5),
        ("3 mm/min", "m/s", 5e-5),
        ("1e10 N/m^3", "N/m^3", 1e10),
        ("10.56 kN/m³", "N/m^3", 10560.0),
        ("10.56 kN/m3", "N/m^3", 10560.0),
        ("10.56 kN/m**3", "N/m^3", 10560.0),
        ("10.56 kN m-3", "N/m^3", 10560.0),
        ("10.56 kN m⁻³", "N/m^3", 10560.0),
        ("1e-8 m/(Pa s)", "m/(Pa s)", 1e-8),
        ("1e-8 m/Pa/s", "m/(Pa s)", 1e-8),
        ("30 deg", "rad", math.radians(30)),
        ("30°", "rad", math.radians(30)),
        ("0.5 rad", "rad", 0.5),
        ("-3 MN m", "N m", -3e6),
        ("−3 MN·m", "N m", -3e6),  # the minus and the dot of word processors
        ("3 MNm", "N m", 3e6),
        ("3 kN*m", "N m", 3e3),
        ("-0 m", "m", 0.0),
        ("2 kip", "N", 8896.443230521),
        ("1 tsf", "Pa", 2000 * 4.4482216152605 / 0.3048**2),  # cones in American units
        ("5 m**3/m**2", "m", 5.0),
        ("5 N/m^-1", "N m", 5.0),  # a negative power behind a stroke counts twice
        ("5 kN/mm^-1", "N m", 5.0),
    ],
)
def test_reads(text: str, unit: str, value: float) -> None:
    assert read(text, unit) == pytest.approx(value, rel=1e-14, abs=0)


def test_decimal_prefixes_are_exact() -> None:
    """The scene's hash must not depend on whether a length is given in mm or m."""
    for number in ("0.1", "0.07", "2.01", "7.8", "60", "2.5", "0.05"):  # 0.07*0.001 and 2.01*1e6 are not
        assert read(f"{number} mm", "m") == float(f"{number}e-3")
        assert read(f"{number} MPa", "Pa") == float(f"{number}e6")


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("200", "Pa", 'expected a quantity with unit such as "1 Pa", got "200"'),
        ("m", "m", 'expected a quantity with unit such as "1 m", got "m"'),
        ("", "m", 'expected a quantity with unit such as "1 m", got ""'),
        ("nan m", "m", 'expected a quantity with unit such as "1 m", got "nan m"'),
        ("inf m", "m", 'expected a quantity with unit such as "1 m", got "inf m"'),
        ("1,5 m", "m", "write numbers with a decimal point and without separators"),
        ("1_000 m", "m", "write numbers with a decimal point and without separators"),
        ("1.2.3 m", "m", "expected a quantity"),
        ("0x10 m", "m", "is not a unit"),
        ("200 kN", "Pa", '"200 kN" is a force; expected a pressure or stress such as "1 Pa"'),
        ("20 degC", "Pa", '"20 degC" is not a pressure or stress; expected a pressure or stress'),
        ("2 m rad", "m", '"2 m rad" is not a length'),
        ("2 turn/s", "m/s", "is not a velocity"),
        ("200 MPA", "Pa", """unknown unit "MPA" (did you mean "MPa"?)"""),
        ("2 fnord", "m", 'unknown unit "fnord"'),
        ("5 percent m", "m", '"percent" has no dimension'),
        ("3 dB", "m", '"dB" has no dimension'),
        ("5 %", "m", '"%" is not a unit'),
        ("2 pi rad", "rad", '"pi" has no dimension'),
        ("1e-8 m/Pa s", "m/(Pa s)", "after a / put a product in parentheses, as in m/(Pa s)"),
        ("1e400 Pa", "Pa", '"1e400 Pa" is not a finite number'),
        ("9e9999 m", "m", "is not a finite number"),
        ("1e-400 Pa", "Pa", "is too small to be represented"),
        ("1e99999 m", "m", "is not a unit"),
        ("5 Qly9", "m", "is too large or too small a unit"),
        ("5 (m)", "m", "is not a unit"),
        ("5 m/", "m", "is not a unit"),
        ("5 m^", "m", "is not a unit"),
        ("5 m^12", "m", "is not a unit"),
        ("5 m 3", "m", "is not a unit"),
        ("5 m)", "m", "is not a unit"),
        ("1 1", "m", "is not a unit"),
        ("2 __class__", "m", "is not a unit"),
        ("3 __import__('os')", "m", "is not a unit"),
        ("9**9**9 m", "m", "is not a unit"),
        ("2 m**9**9", "m", "is not a unit"),
        ("2 " + "m " * 40, "m", "is too long for a quantity (at most 64 characters)"),
        ("2\x1b[31m", "m", '"2\\u001b[31m"'),
    ],
)
def test_refuses(text: str, unit: str, message: str) -> None:
    with pytest.raises(QuantityError) as error:
        read(text, unit)
    assert message in str(error.value)
    assert str(error.value).isprintable()


def test_example_is_the_caller_s() -> None:
    with pytest.raises(QuantityError, match='such as "200 MPa", got "3"'):
        read("3", "Pa", "200 MPa")


@settings(deadline=None)
@given(st.text(alphabet="0123456789.eE+-*/^() mNPask°µ%_'\"\n", max_size=80))
def test_hostile_texts_end_in_a_number_or_a_message(text: str) -> None:
    with time_limit(60.0):  # a text that is evaluated, 9**9**9**9, never ends
        try:
            assert math.isfinite(read(text, "m"))
        except QuantityError as error:
            assert str(error).isprintable()


UNITS = ("m", "mm", "MPa", "kPa", "GPa", "kN/m^3", "N/m^3", "mm/s", "m/s", "deg", "MN", "m/(Pa s)", "rad", "N")


@settings(deadline=None)
@given(
    st.floats(allow_nan=False, allow_infinity=False, min_value=-1e300, max_value=1e300).filter(
        lambda x: x == 0 or abs(x) > 1e-290
    ),
    st.sampled_from(UNITS),
)
def test_show_is_read_back_exactly(value: float, unit: str) -> None:
    assert read(show(value, unit), si_of(unit)) == value


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (200e6, "MPa", "200 MPa"),
        (math.radians(30), "deg", "30 deg"),
        (1e10, "N/m^3", "1e10 N/m^3"),
        (1e-8, "m/(Pa s)", "1e-8 m/(Pa s)"),
        (1e-5, "mm", "0.01 mm"),
        (0.0, "kPa", "0 kPa"),
        (-0.02, "mm", "-20 mm"),
    ],
)
def test_show_is_short(value: float, unit: str, text: str) -> None:
    assert show(value, unit) == text


def test_every_meaning_is_a_unit() -> None:
    assert MEANING
    for unit in MEANING:
        assert read(f"1 {unit}", unit) == 1.0
        assert si_of(unit) == unit


def test_quoted_is_short_and_on_one_line() -> None:
    assert quoted("a\nb") == '"a\\nb"'
    assert quoted("x" * 100) == '"' + "x" * 37 + '..."'
    assert quoted("\u202e") == '"\\u202e"'
    assert quoted(True) == "true"
    assert quoted(10**400) == "a number with hundreds of digits"
    assert quoted(10**5000) == "a number with hundreds of digits"
    assert quoted([1]) == "a list"
    assert quoted({}) == "a table"


@pytest.mark.parametrize("name", list(units.COMMON))
def test_common_units_are_those_of_pint(name: str) -> None:
    scale, base = units._registry().get_base_units(units._registry().parse_units(name))
    assert units.COMMON[name][0] == pytest.approx(float(scale), rel=1e-15)
    assert sorted(units.COMMON[name][1]) == sorted((str(unit), float(power)) for unit, power in base._units.items())
