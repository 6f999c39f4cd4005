# SPDX-License-Identifier: MIT
"""Headings of tables: a column and its unit, as `H_N`, `H [kN]`, `H (kN)` or `H_kN`; the factor to SI.

Any unit of the same dimension is read. Tonnes and kilograms stand for the weight of that mass (g = 9.80665 m/s2) where
a force is expected.
"""

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, Self

from pysprings.core.units import MEANING, QuantityError, quoted, unit_of, unit_of_column
from pysprings.core.words import ESTIMATES

GRAVITY = 9.80665  # m/s2
TEXT, ANY = "", "*"  # unit of a column of words, of one whose unit does not matter
PURE = ("", "-", "1")
SHARES = {"%": 1.0, "pct": 1.0, "percent": 1.0, "mm/m": 0.1, "ppm": 1e-4}  # in percent
_BRACKETS = re.compile(r"(?P<stem>[^\[\]()]+?)[\s,/:]*[\[(](?P<unit>[^\[\]()]*(?:\([^()]*\)[^\[\]()]*)?)[\])]")
_KEY = re.compile(r"\s*(?P<key>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_ENDINGS = ("_N_per_m", "_Nm_per_m", "_Nm", "_N", "_rad", "_m", "_s", "_Pa")
# of a unit for the wrong quantity, an example of the right one
_EXAMPLES = {
    "N": "kN", "N m": "kN m", "m": "mm", "rad": "deg", "N/m": "kN/m", "N m/m": "kN m/m", "Pa": "kPa", "N/m^3": "kN/m^3",
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column that a reader declares.

    name : of the column; a heading with exactly this text is in the unit of the column.
    unit : SI unit; "1" for a pure number, "" (`TEXT`) for words, "*" for a column whose unit does not matter.
    names : other names without the unit, in lower case.
    example : unit for messages.
    skipped : why the column is not used, for a note; blank for one that is.
    percent : factor of a pure number in percent; 0 where it has none.
    """

    name: str
    unit: str = "1"
    names: tuple[str, ...] = ()
    example: str = ""
    skipped: str = ""
    percent: float = 0.0

    @classmethod
    def named(cls, name: str, names: Sequence[str] = ()) -> Self:
        """Return a column of numbers whose name ends in its SI unit: "H_N"."""
        return cls(name, unit_of_column(name), tuple(names))

    @property
    def stem(self) -> str:
        """The name without its SI unit: "depth top" of "depth_top_m"."""
        ending = next((each for each in _ENDINGS if self.name.endswith(each)), "")
        return self.name.removesuffix(ending).replace("_", " ")

    @property
    def shown(self) -> str:
        """The column as people write it: "H [kN]"."""
        if self.unit in ("1", TEXT, ANY):
            return self.name
        return f"{self.stem} [{self.example or _EXAMPLES.get(self.unit, self.unit)}]"


class Heading(NamedTuple):
    """A heading that is read: its text, its column, the factor to SI, the unit as it stands there."""

    text: str
    column: Column
    factor: float = 1.0
    unit: str = ""


class WrongHeading(ValueError):
    """A heading that is no column, or has a wrong unit (then `column` is set); the message is for the user."""

    def __init__(self, message: str, column: Column | None = None) -> None:
        super().__init__(message)
        self.column = column


class Headings:
    """The columns of a reader, found by the headings of a table.

    ``assume`` returns, for the headings of a table, units of names that have none; ``lenient`` : unknown columns are
    left out, not refused.
    """

    def __init__(
        self, columns: Sequence[Column], assume: Callable[[Sequence[str]], Mapping[str, str]], lenient: bool = False
    ) -> None:
        self.columns, self.assume, self.lenient = columns, assume, lenient
        self.units: Mapping[str, str] = {}
        si = [each for each in columns if each.unit in ("1", TEXT, ANY) or unit_of_column(each.name) == each.unit]
        self._exact = {column.name: column for column in si}
        stems = {column.stem: column for column in columns}
        low = [stem.lower() for stem in stems]
        lower = {stem.lower(): column for stem, column in stems.items() if low.count(stem.lower()) == 1}
        others = {name: column for column in columns for name in column.names}
        self._stems = {**lower, **others, **stems}  # t is a name of the time, and T the torsion

    def column_of(self, text: str) -> tuple[Column, str, str | None] | None:
        """Return column, name and unit of a heading (None: it has no unit); None for an unknown one."""
        if (exact := self._exact.get(text)) is not None:
            return exact, exact.stem, exact.unit
        found = []
        for stem, unit in split(text):
            column = self._stems.get(stem) or self._stems.get(stem.lower())
            if column is not None and (unit is None or "[" in text or "(" in text or _is_unit(unit)):
                found.append((column, stem, unit))
        return next((each for each in found if _fits(each[0], each[2])), found[0] if found else None)

    def read(self, text: str) -> Heading:
        """Return what a heading means. Raises WrongHeading."""
        found = self.column_of(text)
        if found is None:
            raise WrongHeading(f"unknown column{self._hint(text)}")
        column, stem, unit = found
        if text in self._exact:
            return Heading(text, column, 1.0, column.unit)
        unit = self.units.get(stem.lower()) if unit is None else unit
        return Heading(text, column, _factor(column, stem, unit), unit or "")

    def _hint(self, text: str) -> str:
        name = next(split(text))[0].lower()
        known = {each.lower(): column for each, column in (self._stems | self._exact).items()}
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
        if near:
            return f" (did you mean '{known[near[0]].shown}'?)"
        known_as = [
            each.shown
            for each in self.columns
            if not each.skipped and not each.stem.endswith((" from", " to", *(f" {word}" for word in ESTIMATES)))
        ]
        return f"; known are {', '.join(known_as)}"


class KeyHeadings(Headings):
    """Headings KEY and KEY [unit] for keys of any name, as they stand there; a row of keys has a dot in one of them."""

    def __init__(self, words: Sequence[str]) -> None:
        super().__init__((), lambda head: {})
        self.words = words

    def column_of(self, text: str) -> tuple[Column, str, str | None] | None:
        match = _KEY.fullmatch(text)
        if match is None or ("." not in match["key"] and match["key"] not in self.words):
            return None
        return Column(match["key"], ANY), match["key"], match["unit"]

    def read(self, text: str) -> Heading:
        match = _KEY.fullmatch(text)
        if match is None:
            raise WrongHeading("expected a scene key, or KEY [unit]")
        return Heading(text, Column(match["key"], ANY), 1.0, (match["unit"] or "").strip())


def split(text: str) -> Iterator[tuple[str, str | None]]:
    """Yield the ways to read a heading as name and unit (None: without a unit), the likeliest first."""
    text = text.strip()
    if match := _BRACKETS.fullmatch(text):
        yield _words(match["stem"]), re.sub(r"(?<=[A-Za-z])[-.](?=[A-Za-z])", " ", match["unit"].strip())  # kN-m, kN.m
        return
    yield _words(text), None
    for cut in (each.start() for each in re.finditer(r"[_\s]", text)):
        unit = text[cut + 1 :].replace("_per_", "/").strip(" ,/:")
        for between in (" ", "/") if "_" in unit else ("",):
            yield _words(text[:cut]), unit.replace("_", between)


def _words(text: str) -> str:
    return " ".join(text.replace("_", " ").split()).strip(" ,/:")


@cache
def _is_unit(text: str) -> bool:
    if text in PURE or text in SHARES:
        return True
    try:
        return bool(unit_of(text)[1])
    except QuantityError:
        return False


def _fits(column: Column, unit: str | None) -> bool:
    """Return whether a unit has the dimension of a column; one without unit fits every column."""
    if unit is None or column.unit in ("1", TEXT, ANY) or not _is_unit(unit) or unit in (*PURE, *SHARES):
        return unit is None or column.unit in ("1", TEXT, ANY)
    return unit_of(unit)[1] == unit_of(column.unit)[1]


def is_unit(text: str) -> bool:
    """Return whether a text is a unit, in brackets or not; blank is none."""
    inner = text.strip().strip("[]()").strip()
    return bool(inner) and _is_unit(inner)


def shows_another(heading: Heading, unit: str) -> bool:
    """Return whether the unit that a cell shows is one, and not that of its heading; percent goes by itself."""
    if not is_unit(unit) or unit in SHARES or heading.column.unit == TEXT:
        return False
    if heading.column.unit == ANY:
        return not is_unit(heading.unit) or unit_of(unit) != unit_of(heading.unit)
    try:
        return not math.isclose(_factor(heading.column, "", unit), heading.factor)
    except WrongHeading:
        return True


def _factor(column: Column, stem: str, unit: str | None) -> float:
    """Return the factor from a unit to that of a column. Raises WrongHeading."""
    si = column.unit
    if si in (TEXT, ANY):
        return 1.0
    if si == "1":
        if unit is None or unit in PURE:
            return 1.0
        if unit in SHARES and column.percent:
            return SHARES[unit] * column.percent
        kind = f"'{stem} [-]' or '{stem} [%]'" if column.percent else "a column without unit"
        raise WrongHeading(f"wrong unit {quoted(unit)}: expected {kind}", column)
    example = column.example or _EXAMPLES.get(si, si)
    if unit is None or unit in PURE:
        raise WrongHeading(f"no unit: write '{stem} [{example}]'", column)
    try:
        scale, dimension = unit_of(unit)
        if dimension == unit_of(si)[1]:
            if si in ("N", "N m") and scale < 1.0:
                raise WrongHeading(f"{quoted(unit)}: m is milli, M is mega", column)
            return scale
        if si in ("N", "N m") and dimension == unit_of(si.replace("N", "kg"))[1]:
            return scale * GRAVITY
    except QuantityError as error:
        raise WrongHeading(str(error), column) from None
    expected = f"expected {MEANING.get(si, si)} such as '{stem} [{example}]'"
    raise WrongHeading(f"wrong unit {quoted(unit)}: {expected}", column)
