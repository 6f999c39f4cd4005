# SPDX-License-Identifier: MIT
"""Cards of SACS PSI: fixed columns, six characters a number (metric: m, cm, kN/cm, kN/cm2).

Columns after the SACS 2024 PSI manual, 2.4.3.7, 2.4.3.8 and 2.4.5.2 (sections on T-Z, Q-Z and P-Y curves of the user).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WIDTH = 6  # characters of a number
PAIRS = 5  # a line
MOST = 30  # points of a curve: more need a number of points on the header that was not seen in use
_NUMBER = re.compile(r"([-+]?\d*\.\d*)([-+]\d+)?")


@dataclass(frozen=True, slots=True)
class Kind:
    """Words and columns of a family of curves: header, stratum, data; its factor and where that stands.

    Reactions are multiplied by the factor: T and Q in kN/cm2 are small, and have more digits in units of 0.001.
    """

    head: str
    stratum: str
    data: str
    column: int
    factor: str


PY = Kind("SOIL LATERAL HEAD", "SOIL P-Y", "P-Y", 37, " 1.0")
TZ = Kind("SOIL TZAXIAL HEAD", "SOIL T-Z", "T-Z", 39, " 0.001")
QZ = Kind("SOIL BEARING HEAD", "SOIL BEAR", "T-Z", 39, " 0.001")


@dataclass(frozen=True, slots=True, eq=False)
class Stratum:
    """A curve between two depths below the pile head [m]: reactions f over displacements q in the units of the cards.

    Symmetric curves hold q >= 0.
    """

    top: float
    bottom: float
    q: Array
    f: Array
    symmetric: bool


def number(value: float) -> str:
    """Return at most six characters, those nearest to a value; small ones in Fortran's way ("1.23-4")."""
    cells = [f"{value:.{digits}f}" for digits in range(6)]
    cells[0] += "."
    cells = [re.sub(r"^(-?)0\.(?=\d)", r"\1.", cell) for cell in cells]
    if value:
        for digits in range(5):
            mantissa, power = f"{value:.{digits}e}".split("e")
            cells.append(f"{mantissa}{'' if digits else '.'}{int(power):+d}")
    fitting = [cell for cell in cells if len(cell) <= WIDTH]
    return min(fitting, key=lambda cell: (abs(read(cell) - value), len(cell)))


def read(cell: str) -> float:
    """Return the value of a number of a card."""
    found = _NUMBER.fullmatch(cell.strip())
    if found is None:
        raise ValueError(f"'{cell}' is no number of a card")
    return float(f"{found[1]}e{found[2] or 0}")


def rounded(stratum: Stratum) -> Stratum:
    """Return a stratum with the numbers as the cards hold them; displacements that are alike there count once."""
    q, f = (np.array([read(number(float(value))) for value in values]) for values in (stratum.q, stratum.f))
    keep = np.concatenate([[True], np.diff(q) > 0.0])
    return Stratum(stratum.top, stratum.bottom, q[keep], f[keep], stratum.symmetric)


def cards(kind: Kind, strata: Sequence[Stratum], name: str, diameter: float | None = None) -> Iterator[str]:
    """Yield the lines of a family; diameter [cm] is the reference of P-Y curves (the pile's own: P stays as it is)."""
    most = max(each.q.size for each in strata)
    reference = [(28, f"{diameter:6.1f}")] if diameter is not None else []
    yield _card((1, kind.head), (18, f"{len(strata):3d}"), (21, f"{most:3d}"), *reference, (41, f"{name:4.4s}"))
    for each in strata:
        marks = (14, "SLOC"), (18, "SM" if each.symmetric else "  "), (22, f"{each.q.size:2d}")
        yield _card(
            (1, kind.stratum), *marks, (25, _depth(each.top)), (31, _depth(each.bottom)), (kind.column, kind.factor)
        )
        for k in range(0, each.q.size, PAIRS):
            cells = [number(float(v)) for pair in zip(each.f, each.q, strict=True) for v in pair][2 * k :][: 2 * PAIRS]
            fields = [(18 + WIDTH * i, f"{cell:>{WIDTH}}") for i, cell in enumerate(cells)]
            yield _card((1, "SOIL"), (14, kind.data), *fields)


def _depth(value: float) -> str:
    cell = f"{value:6.3f}"
    return cell if len(cell) <= WIDTH else f"{value:6.2f}"


def _card(*fields: tuple[int, str]) -> str:
    """Return a line of 80 columns with fields from their first columns (1-based) on."""
    line = [" "] * 80
    for start, words in fields:
        line[start - 1 : start - 1 + len(words)] = words
    return "".join(line).rstrip()
