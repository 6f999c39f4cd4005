# SPDX-License-Identifier: MIT
"""Quantities with units: `"200 MPa"` -> 200e6.

A quantity is `<number> <unit>`. pint has the units; the grammar is ours, so that no text is ever evaluated:

- number: decimal with a point, optional exponent; finite;
- unit: names joined by a space or `*`, powers `m^3`, `m**3`, `m3`, `m³`, `m-1` (one digit), divisors by `/`;
- a product after a `/` needs parentheses, `m/(Pa s)`: people read `m/Pa s` both ways;
- every name must have a dimension (no `percent`, `dB`, `pi`); an angle is never silently a pure number.

The largest numbers that a caisson can mean stand below, by unit (`LARGEST`): beyond them arithmetic overflows.
"""

import difflib
import json
import math
import re
import sys
from decimal import Decimal
from functools import cache
from typing import Any

from pysprings.core.errors import printable

MAX_LENGTH = 64
MOST_QUOTED = 40  # letters of a value in a message

# what each SI unit of the tool measures, for messages
MEANING = {
    "m": "a length",
    "m/s": "a velocity",
    "s": "a time",
    "N": "a force",
    "N m": "a moment",
    "N m/rad": "a rotational stiffness",
    "Pa": "a pressure or stress",
    "N/m^3": "a force per volume, or a stress per depth",
    "N/m^4": "a unit weight per depth",
    "rad/m": "an angle per depth",
    "rad": "an angle",
    "m/(Pa s)": "a velocity per pressure",
    "Pa s": "a viscosity",
}

_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?)(?![0-9.,_'])\s*(\S.*)", re.DOTALL)
_FACTOR = r"[A-Za-zµμ°]{1,24}(?:(?:\^|\*\*)?-?[1-9])?"
_PRODUCT = rf"{_FACTOR}(?:(?:\s*\*\s*|\s+){_FACTOR})*"
_DIVISOR = rf"\s*/\s*(?:{_FACTOR}|\(\s*{_PRODUCT}\s*\))"
_UNIT = re.compile(rf"(?P<top>1(?=\s*/)|{_PRODUCT})(?P<bottom>(?:{_DIVISOR})*)")
_NAME_AND_POWER = re.compile(r"([A-Za-zµμ°]+)(?:\^|\*\*)?(-?[1-9])?")
_SIGNS = str.maketrans({"−": "-", "·": "*", "⋅": "*"})
_SUPERSCRIPTS = str.maketrans("¹²³⁴⁵⁶⁷⁸⁹⁻", "123456789-")

_USUAL = (
    *("m", "mm", "cm", "km", "ft", "in", "N", "kN", "MN", "GN", "lbf", "kip", "Nm", "kNm", "MNm"),
    *("Pa", "kPa", "MPa", "GPa", "psi", "bar", "deg", "rad", "mrad", "s", "min", "hour", "day", "kg"),
)
# pint reads "Nm" as numbers per metre (of yarn); on a foundation it is a newton metre
_MOMENTS = {prefix + "Nm": prefix + "N" for prefix in ("", "k", "M", "G")}

Dimension = tuple[tuple[str, float], ...]

_METRE: Dimension = (("meter", 1.0),)
_NEWTON: Dimension = (("kilogram", 1.0), ("meter", 1.0), ("second", -2.0))
_RADIAN: Dimension = (("radian", 1.0),)
_PASCAL: Dimension = (("kilogram", 1.0), ("meter", -1.0), ("second", -2.0))
# What command lines and scenes are written in: pint takes 0.3 s, and gives the same values (a test compares them).
COMMON: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, _METRE), "cm": (1e-2, _METRE), "mm": (1e-3, _METRE),
    "N": (1.0, _NEWTON), "kN": (1e3, _NEWTON), "MN": (1e6, _NEWTON),
    "rad": (1.0, _RADIAN), "mrad": (1e-3, _RADIAN), "deg": (0.017453292519943295, _RADIAN),
    "Pa": (1.0, _PASCAL), "kPa": (1e3, _PASCAL), "MPa": (1e6, _PASCAL), "GPa": (1e9, _PASCAL),
    "s": (1.0, (("second", 1.0),)), "kg": (1.0, (("kilogram", 1.0),)),
}  # fmt: skip

# units of the field that pint does not have: how many of which force, and the power of the foot below it
_PER_FOOT = {
    "psf": (1, "lbf", 2), "ksf": (1, "kip", 2), "tsf": (2, "kip", 2), "pcf": (1, "lbf", 3), "kcf": (1, "kip", 3),
}  # fmt: skip

_TONS = ("ton", "tons")


class QuantityError(ValueError):
    """A text that is not the quantity expected; the message is for the user."""


def read(text: str, si_unit: str, example: str = "") -> float:
    """Return the value of a quantity in its SI unit.

    text : quantity such as "200 MPa"
    si_unit : SI unit of the answer (a key of MEANING), which fixes the dimension, e.g. "Pa"
    example : quantity shown in messages, e.g. "200 MPa"

    Raises QuantityError: not `<number> <unit>`, unknown unit, another dimension, not finite.
    """
    number, unit = parts(text, example or f"1 {si_unit}")
    try:
        scale, dimension = unit_of(unit)
    except QuantityError as error:
        raise QuantityError(f"{quoted(text)}: {error}") from None
    if dimension != unit_of(si_unit)[1]:
        is_what = _meaning(dimension) or f"not {MEANING[si_unit]}"
        expected = f"expected {MEANING[si_unit]} such as {quoted(example or f'1 {si_unit}')}"
        raise QuantityError(f"{quoted(text)} is {is_what}; {expected}")
    return _scaled(text, number, scale)


def show(value: float, unit: str) -> str:
    """Return an SI value as a quantity in a unit; reading it back gives exactly the same value."""
    scale = unit_of(unit)[0]
    power = _decimal_power(scale)
    digits = Decimal(repr(float(value)))
    exact = Decimal(repr(value / scale)) if power is None else digits.scaleb(-power)
    rounded = Decimal(f"{value / scale:.12g}")
    candidates = [f"{_plain(number)} {unit}" for number in (rounded, exact)]
    good = (text for text in candidates if read(text, si_of(unit)) == value)
    return next(good, f"{_plain(digits)} {si_of(unit)}")


def _plain(number: Decimal) -> str:
    """Write a decimal in full between 1e-3 and 1e5, else with an exponent; no padding zeros."""
    if number == 0:
        return "0"
    small = number.normalize()
    if -4 < small.adjusted() < 5:
        return f"{small:f}"
    return str(small).lower().replace("e+", "e") if "E" in str(small) else f"{small:e}".replace("e+", "e")


def si_of(unit: str) -> str:
    """Return the SI unit of the tool for a unit: "Pa" for "MPa"."""
    dimension = unit_of(unit)[1]
    return next(si for si in MEANING if unit_of(si)[1] == dimension)


def quoted(value: object) -> str:
    """Return a value as a user wrote it, on one line and not too long."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return printable(json.dumps(_shortened(value), ensure_ascii=False))
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, int) and value.bit_length() > 1000:
        return "a number with hundreds of digits"
    return _shortened(printable(value))


def _shortened(text: str) -> str:
    return text if len(text) <= MOST_QUOTED else text[: MOST_QUOTED - 3] + "..."


def parts(text: str, example: str = "1 m") -> tuple[str, str]:
    """Cut `<number> <unit>` in two, the number as text. Raises QuantityError."""
    if len(text) > MAX_LENGTH:
        raise QuantityError(f"{quoted(text)} is too long for a quantity (at most {MAX_LENGTH} characters)")
    match = _NUMBER.fullmatch(text.translate(_SIGNS).strip())
    if match:
        return match[1], match[2]
    grouped = re.match(r"\s*[+-]?[0-9]+[,_']", text)
    hint = " (write numbers with a decimal point and without separators)" if grouped else ""
    raise QuantityError(f"expected a quantity with unit such as {quoted(example)}, got {quoted(text)}{hint}")


def _scaled(text: str, number: str, scale: float) -> float:
    """Return number * scale, correctly rounded for decimal prefixes: "100 mm" is exactly 0.1."""
    digits = Decimal(number)
    power = _decimal_power(scale)
    value = float(digits) * scale if power is None else float(digits.scaleb(power))
    if not math.isfinite(value):
        raise QuantityError(f"{quoted(text)} is not a finite number")
    if value == 0.0 and digits:
        raise QuantityError(f"{quoted(text)} is too small to be represented")
    return value + 0.0  # turns a negative zero into zero


def _decimal_power(scale: float) -> int | None:
    """Return the power of ten that a scale is, else None."""
    power = round(math.log10(scale))
    return power if math.isclose(scale, float(f"1e{power}"), rel_tol=1e-12) else None


@cache
def unit_of(text: str) -> tuple[float, Dimension]:
    """Return SI scale and dimension (powers of kilogram, meter, second, radian ...) of a unit text."""
    match = _UNIT.fullmatch(text.translate(_SIGNS).translate(_SUPERSCRIPTS).strip())
    if match is None:
        ambiguous = re.search(r"/[^()/]*[^()/\s*][\s*]+[^()/\s*]", text)
        hint = " (after a / put a product in parentheses, as in m/(Pa s))" if ambiguous else ""
        raise QuantityError(f"{quoted(text)} is not a unit{hint}")
    factors = [(name, int(power or 1)) for name, power in _NAME_AND_POWER.findall(match["top"])]
    factors += [(name, -int(power or 1)) for name, power in _NAME_AND_POWER.findall(match["bottom"])]
    return _multiplied(factors, text)


def _multiplied(factors: list[tuple[str, int]], text: str) -> tuple[float, Dimension]:
    """Multiply powers of named units."""
    scale, powers = 1.0, dict[str, float]()
    for name, power in factors:
        size, base = _named(name)
        scale *= math.pow(size, power) if abs(math.log10(size) * power) < 300 else math.inf
        for unit, exponent in base:
            powers[unit] = powers.get(unit, 0.0) + power * exponent
    if not 0.0 < scale < math.inf:
        raise QuantityError(f"{quoted(text)} is too large or too small a unit")
    return scale, tuple(sorted((unit, power) for unit, power in powers.items() if power))


@cache
def _registry() -> Any:
    """Build pint's registry once: 0.3 s, paid only by those who read a quantity."""
    if sys.modules.get("pint", ()) is None:  # a command has it left out of xarray
        del sys.modules["pint"]
    import pint

    return pint.UnitRegistry()


@cache
def _named(name: str) -> tuple[float, Dimension]:
    """Return SI scale and powers of base units of one unit name."""
    if name in _TONS:
        raise QuantityError(f"{quoted(name)} is 907, 1000 or 1016 kg: write t for 1000 kg")
    if name in _MOMENTS:
        scale, newton = _named(_MOMENTS[name])
        return scale, tuple((unit, power + (unit == "meter")) for unit, power in newton)
    if name in COMMON:
        return COMMON[name]
    if name in _PER_FOOT:
        count, force, power = _PER_FOOT[name]
        scale, dimension = unit_of(f"{force}/ft^{power}")
        return count * scale, dimension
    registry = _registry()
    try:
        scale, base = registry.get_base_units(registry.parse_units(name))
        dimension = tuple((str(unit), float(power)) for unit, power in base._units.items())
    except Exception as error:  # pint raises many types for unknown units
        raise QuantityError(f"unknown unit {quoted(name)}{_suggestion(name)}") from error
    if not dimension:
        raise QuantityError(f"{quoted(name)} has no dimension; write the number out")
    return float(scale), dimension


def _suggestion(name: str) -> str:
    same = [unit for unit in _USUAL if unit.lower() == name.lower()]
    near = same or difflib.get_close_matches(name, _USUAL, n=1, cutoff=0.6)
    return f" (did you mean {quoted(near[0])}?)" if near else ""


def _meaning(dimension: Dimension) -> str:
    """Return the quantity of a dimension; empty for one that the tool does not use."""
    known = (meaning for unit, meaning in MEANING.items() if unit_of(unit)[1] == dimension)
    return next(known, "" if dimension else "a pure number")


# Generous by some orders of magnitude; products of a few of them stay far from overflow.
LARGEST = {
    "m": 1e5, "rad": 1e2, "s": 1e15, "m/s": 1e5,
    "N": 1e15, "N m": 1e18, "N/m": 1e15, "N m/m": 1e18, "N m/rad": 1e21, "Pa": 1e15,
    "1": 1e9,
}  # fmt: skip
# A length or rotation that is not zero is at least this: what rounding leaves of zero passes, quotients stay finite.
SMALLEST = {"m": 1e-60, "rad": 1e-60}
SMALLEST_AT_ALL = 1e-150  # of any number that is not zero: quotients of two stay finite

# Motion under a load that counts as failure: displacement over diameter, and rotation [rad] (default of `[limit]`)
MOST_MOVED, MOST_TURNED = 0.1, math.radians(5.0)

SMALLEST_LOAD = 1.0  # N, N m: below it, millinewtons were meant to be meganewtons

_ENDINGS = {
    "_N_per_m": "N/m", "_Nm_per_m": "N m/m", "_Nm": "N m", "_N": "N", "_rad": "rad", "_m": "m", "_s": "s",
}  # fmt: skip


def unit_of_column(name: str) -> str:
    """Return the unit of a column of a table by the end of its name; "1" for a pure number."""
    return next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "1")


def fault(value: float, unit: str) -> str:
    """Return the fault in the size of a number in a unit of `LARGEST`; empty if there is none."""
    if not math.isfinite(value):
        return "is not a finite number"
    if abs(value) > LARGEST[unit]:
        return f"is not in [{-LARGEST[unit]:.0e}, {LARGEST[unit]:.0e}]{_with(unit)}"
    if 0.0 < abs(value) < SMALLEST.get(unit, 0.0):
        return f"is too small: at least {SMALLEST[unit]:.0e}{_with(unit)}, or 0"
    return ""


def slip(text: str, value: float, unit: str) -> str:
    """Return a message on a load written in millinewtons, which is next to nothing; empty for others."""
    if "mN" in text and 0.0 < abs(value) < SMALLEST_LOAD:
        return f"is {value:.3g} {unit}: m is milli, M is mega"
    return ""


def _with(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


ATMOSPHERE = 101_325.0  # Pa, standard atmosphere (ISO 2533)
VAPOUR = 2_339.0  # Pa, saturated vapour of water at 20 deg C (IAPWS)
