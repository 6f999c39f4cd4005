# SPDX-License-Identifier: MIT
"""Backbone of clay after cycles, from contours of cyclic tests, at an equivalent number of cycles and average shear.

A row of contours has N, the average and the cyclic shear stress over su, and the average and the cyclic shear strain
that they have made after N cycles (Andersen 2015). Rows of one N and one tau_a/su are a curve at the peak of a cycle,

    tau = tau_a + tau_cy      over      gamma = gamma_a + gamma_cy,

linear in log(gamma) between its rows. Between curves tau at a strain is linear in tau_a/su and in log(N). The strains
of the backbone are those of the curves around it, and lines between them; before the first of them it is the hyperbola
of `fe_engine.soil.iwan_clay.pack_contours`, behind the last one the strength. Nothing beyond the contours is made up.

Of a storm, parcels of cycles with their load over the largest one, N follows by strain accumulation (Andersen 2015):
from the smallest load to the largest, a parcel begins at the number of its own cycles that has the strain so far. All
ground has one utilisation, tau/su under the largest load; a load that is below all contours does not count.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationInfo

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Column, one_table
from pysprings.core.units import quoted
from pysprings.scene.fields import Field, Interval, Number, Text, read_keys, refuse

Pairs = tuple[tuple[float, float], ...]
Rows = tuple[tuple[float, ...], ...]

CYCLIC = "cyclic"
MOST_STRAINS = 6  # of the backbone: lines between them, and those of the hyperbola, are elements of the law
_ROUND = 0.02  # share of the stress by which a point may lie below the line between its neighbours
_COLUMNS = (
    Column("N", "1", ("number of cycles", "cycles")), Column("tau_a/su", "1", ("tau a/su", "average stress/su")),
    Column("tau_cy/su", "1", ("tau cy/su", "cyclic stress/su")),
    Column("gamma_a", "1", ("gamma a", "average shear strain"), percent=0.01),
    Column("gamma_cy", "1", ("gamma cy", "cyclic shear strain"), percent=0.01),
)  # fmt: skip
_INTERVALS = ("[1, 1e9]", "[0, 2]", "[0, 2]", "[0, 1]", "[0, 1]")  # a stress in kPa is no share of su
_PARCELS = (Column("N", "1", ("number of cycles", "cycles")), Column("load/largest", "1", ("share",), percent=0.01))
_OF_PARCELS = ("(0, 1e9]", "(0, 1]")
_KEYS: dict[str, Field] = {
    "average": Number("[0, 2]", "tau_a/su", 0.0), "name": Text("name of the table"),
    "cycles": Number("[1, 1e9]", "equivalent number of cycles", 10.0),
    "utilisation": Number("(0, 5]", "tau/su under the largest load of the parcels", 0.6),
}  # fmt: skip
_TABLES = {"contours": (_COLUMNS, _INTERVALS), "parcels": (_PARCELS, _OF_PARCELS)}


@dataclass(frozen=True)
class Cyclic:
    """Contours: rows (n, 5) of N, tau_a/su, tau_cy/su, gamma_a, gamma_cy; N and tau_a/su; the name of the table.

    In place of N: parcels (m, 2) of cycles and load over the largest, and tau/su under the largest load.
    """

    contours: Rows
    average: float
    name: str
    cycles: float | None = None
    parcels: Rows | None = None
    utilisation: float | None = None

    @property
    def number(self) -> float:
        """N, given or of the parcels."""
        return self._counted[0]

    @property
    def left_out(self) -> float:
        """Cycles of parcels that stay below the first strain of the contours: N does not count them."""
        return self._counted[1]

    @cached_property
    def _counted(self) -> tuple[float, float]:
        """N, and the cycles of parcels that do not count.

        Raises ValueError: parcels that leave the contours, that do not reach them, or without the largest load.
        """
        if self.parcels is None or self.utilisation is None:
            return float(self.cycles or 0.0), 0.0
        if self.utilisation <= self.average or max(share for _, share in self.parcels) != 1.0:
            raise ValueError("parcels: utilisation must be above average, and the largest load/largest 1")
        strain, number, left = 0.0, 0.0, 0.0
        first, most = (extreme(row[0] for row in self.contours) for extreme in (min, max))
        outside = f"N is outside the contours of {self.name}, {first:g} to {most:g}"
        sums = dict.fromkeys(sorted(share for _, share in self.parcels), 0.0)
        for cycles, share in self.parcels:
            sums[share] += cycles
        for share, cycles in sums.items():
            stress = self.average + share * (self.utilisation - self.average)
            if self._strain(most, stress) == 0.0:
                left += cycles
                continue
            number = self._begins(strain, stress) + cycles
            of = f"parcels: the row of load/largest {share:g}, tau/su {stress:.3g} after {number:.4g} cycles"
            if number > most:
                raise ValueError(f"{of}: {outside}")
            own = self._strain(number, stress)
            left, strain = left + (cycles if own == 0.0 else 0.0), max(strain, own)
            if strain == math.inf:
                raise ValueError(f"{of}: strain is beyond the last contour of {self.name}")
        if strain == 0.0:
            raise ValueError(f"parcels: none reaches the first strain of the contours of {self.name}")
        if number < first:
            raise ValueError(f"{of}: {outside}")
        return number, left

    def _strain(self, number: float, stress: float) -> float:
        """Return the strain of a stress after a number of cycles; 0 below the first contour, inf beyond the last.

        Before the first N it grows in proportion.
        """
        first = min(row[0] for row in self.contours)
        strain, tau = self._at(max(number, first))
        if not tau[0] <= stress <= tau[-1]:
            return 0.0 if stress < tau[0] else math.inf
        return float(np.exp(np.interp(stress, tau, np.log(strain)))) * min(number / first, 1.0)

    def _begins(self, strain: float, stress: float) -> float:
        """Return the number of cycles of a stress that has a strain; before the first N in proportion."""
        low, high = (extreme(row[0] for row in self.contours) for extreme in (min, max))
        if (first := self._strain(low, stress)) >= strain:
            return low * strain / first if first else 0.0
        for _ in range(60):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if self._strain(middle, stress) < strain else (low, middle)
        return low

    @cached_property
    def curve(self) -> Pairs:
        """Strain and tau/su of the backbone, from its first contour to its last one.

        Raises
        ------
        ValueError
            N or tau_a/su outside the contours, or contours that are no curve.
        """
        return _bent(*self._at(self.number))

    def _at(self, cycles: float) -> tuple[Array, Array]:
        """Return strain and tau/su after a number of cycles."""
        rows = np.array(self.contours)
        numbers = np.unique(rows[:, 0])
        curves = []
        for number, share in _around(numbers, cycles, "cycles", math.log):
            own = rows[rows[:, 0] == number]
            curves += [
                (_curve(own[own[:, 1] == each]), share * part)
                for each, part in _around(np.unique(own[:, 1]), self.average, "average", float, f" at N {number:g}")
            ]
        low, high = max(strain[0] for (strain, _), _ in curves), min(strain[-1] for (strain, _), _ in curves)
        strain = np.unique([each for (own, _), _ in curves for each in own if low <= each <= high])
        if len(strain) < 2:
            raise ValueError("the contours around it have fewer than two strains in common")
        stress = sum(share * np.interp(np.log(strain), np.log(own), tau) for (own, tau), share in curves)
        return strain, np.asarray(stress)

    @property
    def text(self) -> str:
        """What titles and heads of files have."""
        left = f", {self.left_out:g} cycles below the contours left out" if self.left_out else ""
        return f"cyclic: {self.name}, N {self.number:.4g}, tau_a/su {self.average:g}{left}"


def _around(levels: Array, value: float, key: str, scale: Any, where: str = "") -> Iterator[tuple[float, float]]:
    """Yield the levels on both sides of a value, with their shares on a scale; that level alone which it meets."""
    low, high = float(levels[0]), float(levels[-1])
    if not low <= value <= high:
        raise ValueError(f"{key}: {value:g} is outside the contours{where}, {low:g} to {high:g}")
    at = int(np.searchsorted(levels, value))
    if levels[at] == value:
        yield value, 1.0
        return
    below, above = float(levels[at - 1]), float(levels[at])
    share = (scale(value) - scale(below)) / (scale(above) - scale(below))
    yield from ((below, 1.0 - share), (above, share))


def _curve(rows: Array) -> tuple[Array, Array]:
    """Return strain and tau/su, rising, of the rows of one N and tau_a/su."""
    strain, stress = rows[:, 3] + rows[:, 4], rows[:, 1] + rows[:, 2]
    order = np.argsort(strain)
    strain, stress = strain[order], stress[order]
    where = f"N {rows[0, 0]:g}, tau_a/su {rows[0, 1]:g}"
    if len(strain) < 2 or strain[0] <= 0.0:
        raise ValueError(f"the curve of {where} needs two rows at least, with strains above 0")
    if (wrong := (np.diff(strain) <= 0.0) | (np.diff(stress) < 0.0)).any():
        at = 100.0 * strain[1:][wrong][0]
        raise ValueError(f"the curve of {where} has a stress that falls, or two of one strain, at {at:.3g} %")
    return strain, stress


def _refuse_growth(rows: Array) -> None:
    """Raise ValueError where, at one strain and tau_a/su, the stress of more cycles is larger."""
    for average in np.unique(rows[:, 1]):
        own = rows[rows[:, 1] == average]
        curves = [(number, *_curve(own[own[:, 0] == number])) for number in np.unique(own[:, 0])]
        for (few, x, fewer), (many, own_x, more) in pairwise(curves):
            both = x[(x >= own_x[0]) & (x <= own_x[-1])]
            if (np.interp(both, own_x, more) > (1.0 + _ROUND) * np.interp(both, x, fewer)).any():
                raise ValueError(f"contours of N {many:g} are above those of N {few:g} (tau_a/su {average:g})")


def _bent(strain: Array, stress: Array) -> Pairs:
    """Return the points of a curve that bends downwards, at most `MOST_STRAINS`: the others change it least."""
    points = list(zip(strain.tolist(), stress.tolist(), strict=True))
    if _above((0.0, 0.0), *points[:2]) <= 0.0:  # the law would have no stiffness that falls
        raise ValueError("the backbone of the contours does not bend downwards at its first strain")
    while len(points) > 2:
        rises = [_above(*points[k - 1 : k + 2]) for k in range(1, len(points) - 1)]
        if min(rises) < -_ROUND:
            at = points[int(np.argmin(rises)) + 1][0]
            raise ValueError(f"the backbone of the contours bends upwards at a strain of {100.0 * at:.3g} %")
        if len(points) <= MOST_STRAINS and min(rises) > 0.0:
            break
        del points[int(np.argmin(rises)) + 1]
    return tuple((float(f"{x:.6g}"), float(f"{t:.6g}")) for x, t in points)


def _above(before: tuple[float, float], at: tuple[float, float], after: tuple[float, float]) -> float:
    """Return by which share of it the stress of a point is above the line between its neighbours."""
    line = before[1] + (after[1] - before[1]) * (at[0] - before[0]) / (after[0] - before[0])
    return 1.0 - line / at[1]


@dataclass(frozen=True)
class CyclicTable(Field):
    """A table { contours = "file.csv", cycles = 10, average = 0.3 }; where the file is read, contours are its rows."""

    text: str

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, Cyclic):
            return value
        given = {"average": 0.0, "name": "contours", **value} if isinstance(value, Mapping) else {}
        given = {key: each for key, each in given.items() if each is not None}
        if {*given} - {"average", "name"} not in ({"contours", "cycles"}, {"contours", "parcels", "utilisation"}):
            example = '{ contours = "file.csv", cycles = 10, average = 0.3 }'
            have = f"one with {', '.join(value) or 'no key'}" if isinstance(value, Mapping) else quoted(value)
            raise refuse(f"expected a table {example}, or parcels and utilisation for cycles, got {have}")
        read, wrong = read_keys(
            given, lambda name, each: _rows(name, each) if name in _TABLES else _KEYS[name].validate(each, info)
        )
        if not wrong:
            cyclic = Cyclic(**read)
            try:
                _refuse_growth(np.array(cyclic.contours))
                return cyclic if cyclic.curve else None
            except ValueError as error:
                wrong = [str(error)]
        raise refuse("; ".join(wrong))

    def schema(self) -> dict[str, Any]:
        properties = {name: {"anyOf": [{"type": "string"}, {"type": "array"}]} for name in _TABLES}
        properties |= {name: field.schema() for name, field in _KEYS.items()}
        return {"description": self.text, "type": "object", "additionalProperties": False,
                "required": ["contours"], "properties": properties}  # fmt: skip

    def in_toml(self, value: Any) -> Any:
        given = {} if value is None else {each.name: getattr(value, each.name) for each in fields(value)}
        return {key: [list(row) for row in each] if key in _TABLES else each for key, each in given.items()
                if each is not None} or None  # fmt: skip


def _rows(name: str, value: Any) -> Rows:
    """Return the rows of a table that is read already; refuse others."""
    width = len(_TABLES[name][0])
    try:
        return tuple(map(tuple, np.array(value, dtype=float).reshape(-1, width).tolist()))
    except (TypeError, ValueError):
        raise refuse(f"expected a table of a file, or rows of {width} numbers, got {quoted(value)}") from None


def read_rows(file: Path, kind: str) -> list[list[float]]:
    """Return the rows of a table of contours, or of parcels; averages that it does not have are 0.

    Raises UserInputError: one problem per thing that is wrong with the table: file, line, column and value.
    """
    columns, intervals = _TABLES[kind]
    table = one_table(file, columns, kind)
    for each in columns:
        if each.name not in table and each.name not in ("tau_a/su", "gamma_a"):
            names = ", ".join(column.name for column in columns)
            table.fault(None, None, f"no column '{each.name}': {kind} have {names}")
    for name in ("gamma_a", "gamma_cy"):
        table.fault_without_unit(name)
    table.faults.stop()
    found = []
    for column, interval in zip(columns, intervals, strict=True):
        values = table.numbers(column.name, most=False) if column.name in table else np.zeros(len(table))
        for k in range(len(table)):
            if not Interval(interval).holds(float(values[k])):
                text = "is blank" if np.isnan(values[k]) else f"{values[k]:g} is not in {interval}"
                table.fault(k, column.name, text)
        found.append(values)
    table.faults.stop()
    if not len(table):
        raise UserInputError([Problem(str(file), message=f"holds no {kind}: expected a heading and a row for each")])
    return [[float(f"{each:.9g}") for each in row] for row in np.stack(found, axis=1).tolist()]


def read_files(soil: Any, folder: Path) -> tuple[bool, list[Problem]]:
    """Put the rows of tables into the `cyclic` of a soil and its layers in the data of a scene.

    Return whether there are any, and what is wrong with them.
    """
    found, problems = False, list[Problem]()
    layers = soil.get("layer", ()) if isinstance(soil, dict) else ()
    for table in (soil, *(layers if isinstance(layers, list) else ())):
        given = table.get(CYCLIC) if isinstance(table, dict) else None
        names = (
            {kind: given[kind] for kind in _TABLES if isinstance(given.get(kind), str)}
            if isinstance(given, dict)
            else {}
        )
        found, before = found or bool(names), len(problems)
        for kind, name in names.items():
            try:
                table[CYCLIC] = {**table[CYCLIC], kind: read_rows(folder / name, kind)}
            except UserInputError as error:
                problems += [each for each in error.problems if each not in problems]
        if "contours" in names:
            table[CYCLIC]["name"] = Path(names["contours"]).name
        if len(problems) > before:
            del table[CYCLIC]
    return found, problems


def titled(title: str, found: Sequence[Cyclic]) -> str:
    """Return a title that names the contours of a scene, N and tau_a/su, in place of those that it names."""
    plain, texts = re.sub(r" \(cyclic: .*\)$", "", title), dict.fromkeys(each.text for each in found)
    mark = f" ({'; '.join(texts)[:150]})"
    return plain[: 200 - len(mark)] + mark if texts else plain
