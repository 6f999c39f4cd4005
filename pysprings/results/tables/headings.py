# SPDX-License-Identifier: MIT
"""Headings of tables: a column and its unit, as `H_N`, `H [kN]`, `H (kN)` or `H_kN`; the factor to SI.

Columns have the names of our own files, with the SI unit behind them. Any unit of the same dimension is read. Tonnes
and kilograms stand for the weight of that mass (g = 9.80665 m/s2) where a force is expected.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from pysprings.core.magnitudes import unit_of_column
from pysprings.core.units import MEANING, QuantityError, quoted, unit_of
from pysprings.results.tables.faults import Faults

GRAVITY = 9.80665  # m/s2
_BRACKETS = re.compile(r"(?P<stem>[^\[\]()]+?)[\s,]*[\[(](?P<unit>[^\[\]()]*(?:\([^()]*\)[^\[\]()]*)?)[\])]")
_PURE = ("", "-", "1")
_ENDINGS = ("_N_per_m", "_Nm_per_m", "_Nm", "_N", "_rad", "_m", "_s")
# of a unit for the wrong quantity, an example of the right one
_EXAMPLES = {"N": "kN", "N m": "kN m", "m": "mm", "rad": "deg", "N/m": "kN/m", "N m/m": "kN m/m"}


class Column(NamedTuple):
    """A column of a table: its name, and the factor that makes its numbers SI."""

    name: str
    factor: float = 1.0


class _Wrong(ValueError):
    """A heading that is no column; the message is for the user."""


def read_headings(
    place: str, head: Sequence[str], columns: Sequence[str], faults: Faults, aliases: Mapping[str, str] | None = None
) -> list[Column | None]:
    """Return the column of each heading, None where it is none of `columns`; note the faults, repeated columns too.

    `aliases` are other names of columns without their unit, in lower case.
    """
    stems = _stems(columns, aliases or {})
    read: list[Column | None] = []
    for text in head:
        try:
            read.append(_column(text, columns, stems))
        except _Wrong as error:
            faults.add((place, 1), quoted(text), str(error))
            read.append(None)
    names = [column.name for column in read if column]
    for name in dict.fromkeys(names):
        if (count := names.count(name)) > 1:
            own = [text for text, column in zip(head, read, strict=True) if column and column.name == name]
            written = "" if set(own) == {name} else f" ({', '.join(map(quoted, own))})"
            faults.add((place, 1), quoted(name), f"column stands {count} times{written}")
    return read


def stem_of(column: str) -> str:
    """Return the name of a column without its SI unit: "depth_top" of "depth_top_m"."""
    return next((column.removesuffix(ending) for ending in _ENDINGS if column.endswith(ending)), column)


def _stems(columns: Sequence[str], aliases: Mapping[str, str]) -> dict[str, str]:
    """Return the columns by all their names without units; names differ in case where both are columns (m, M)."""
    stems = {stem_of(column).replace("_", " "): column for column in columns}
    low = [stem.lower() for stem in stems]
    stems |= {stem.lower(): column for stem, column in list(stems.items()) if low.count(stem.lower()) == 1}
    return {**aliases, **stems}


def _column(text: str, columns: Sequence[str], stems: Mapping[str, str]) -> Column:
    """Return the column of a heading. Raises _Wrong."""
    if text in columns:
        return Column(text)
    for stem, unit in _splits(text):
        if (column := stems.get(stem) or stems.get(stem.lower())) is not None:
            return Column(column, _factor(column, stem, unit))
    near = difflib.get_close_matches(text.lower(), [*columns, *stems], n=1, cutoff=0.6)
    shown = [_shown(column) for column in columns]
    hint = f" (did you mean '{_shown(stems.get(near[0], near[0]))}'?)" if near else f"; known are {', '.join(shown)}"
    raise _Wrong(f"unknown column{hint}")


def _splits(text: str) -> Iterator[tuple[str, str | None]]:
    """Yield the ways to read a heading as name and unit (None: without a unit)."""
    plain = " ".join(text.replace("_", " ").split())
    if match := _BRACKETS.fullmatch(text.strip()):
        yield " ".join(match["stem"].replace("_", " ").split()), match["unit"].strip()
        return
    yield plain, None
    for cut in (each.start() for each in re.finditer(r"[_\s]", text.strip())):
        unit = text.strip()[cut + 1 :].replace("_per_", "/").replace("_", " ")
        yield " ".join(text.strip()[:cut].replace("_", " ").split()), unit


def _factor(column: str, stem: str, unit: str | None) -> float:
    """Return the factor from a unit to that of a column. Raises _Wrong."""
    si = unit_of_column(column)
    if si == "1":
        if unit in _PURE or unit is None:
            return 1.0
        raise _Wrong(f"{quoted(unit)}: a column without unit")
    example = _EXAMPLES.get(si, si)
    if unit is None:
        raise _Wrong(f"no unit: write '{stem} [{example}]'")
    try:
        scale, dimension = unit_of(unit)
        if dimension == unit_of(si)[1]:
            return _no_slip(scale, unit, si)
        if si in ("N", "N m") and dimension == unit_of(si.replace("N", "kg"))[1]:
            return scale * GRAVITY
    except QuantityError as error:
        raise _Wrong(str(error)) from None
    raise _Wrong(f"wrong unit {quoted(unit)}: expected {MEANING.get(si, si)} such as '{stem} [{example}]'")


def _no_slip(scale: float, unit: str, si: str) -> float:
    if si in ("N", "N m") and scale < 1.0:
        raise _Wrong(f"{quoted(unit)}: m is milli, M is mega")
    return scale


def _shown(column: str) -> str:
    """Return a column as people write it: "H [kN]"."""
    si = unit_of_column(column)
    return column if si == "1" else f"{stem_of(column)} [{_EXAMPLES.get(si, si)}]"
