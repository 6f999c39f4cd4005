# SPDX-License-Identifier: MIT
"""Load cases from a table: names, loads with units in the headings, directions, limit states, partial factors.

A row is a load; rows of one name act together and are added. `H` acts in the vertical plane of `direction` (an angle in
plan), `M` in that of `M direction` (that of H where not given), with M = -H arm for a load above mudline. A case is its
load in the vertical plane of its force, and beside it the moment across that plane and the torsion, for the answer.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import quoted
from pysprings.results.tables.faults import Faults, numbers
from pysprings.results.tables.file import sheet_of
from pysprings.results.tables.headings import Column, read_headings
from pysprings.springs.numbers import MOST_LETTERS

Array = NDArray[np.float64]

TEXTS = ("name", "limit_state")
NUMBERS = (
    "H_N", "M_Nm", "V_N", "arm_m", "direction_rad", "M_direction_rad", "factor", "factor_H", "factor_M", "factor_V",
    "tilt_rad", "T_Nm",
)  # fmt: skip
COLUMNS = (*TEXTS, *NUMBERS)
ALIASES = {
    "case": "name", "load case": "name", "id": "name", "state": "limit_state", "limit state": "limit_state",
    "horizontal": "H_N", "moment": "M_Nm", "vertical": "V_N", "height": "arm_m", "lever arm": "arm_m",
    "h direction": "direction_rad", "azimuth": "direction_rad", "tolerance": "tilt_rad",
    "torsion": "T_Nm", "mz": "T_Nm",
}  # fmt: skip
FORMS = "H with M or arm, M alone, or V alone"
# A moment across the plane of the force up to this share of the moment is rounding of angles
_ACROSS = 1e-6
MOST_FACTOR = 10.0
_TURN = 2.0 * np.pi * (1.0 + 1e-9)


@dataclass(frozen=True)
class LoadCases:
    """Load cases, n of them, in SI with their partial factors.

    Attributes
    ----------
    file : of the table.
    name, limit_state : by case; blank where not given.
    line : of the first row of each case.
    H, M : lateral load [N] and moment [N m] about the lid centre, in the plane of `direction`; M = -H arm.
    V : vertical load [N], positive down; NaN where not given.
    direction : of the plane [rad], in plan.
    tilt : largest rotation that is tolerated [rad]; NaN where not given.
    across : moment about the direction of H [N m], right-handed with z up: it bends across the plane of H.
    torsion : moment about the vertical axis [N m], right-handed with z up.
    remarks : by case, what the reader did that a user may not expect; blank for nothing.
    """

    file: str
    name: tuple[str, ...]
    limit_state: tuple[str, ...]
    line: NDArray[np.int64]
    H: Array
    M: Array
    V: Array
    direction: Array
    tilt: Array
    across: Array
    torsion: Array
    remarks: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.name)

    @property
    def loads(self) -> Array:
        """H and M of each case, (n, 2)."""
        return np.stack([self.H, self.M], axis=1)

    def refuse_out_of_plane(self, command: str) -> None:
        """Refuse cases with a moment across the plane of H or a torsion, for a command that cannot mark them."""
        problems = [
            Problem(self.file, int(self.line[k]), key=name, message=f"case '{self.name[k]}' has a {what} of "
                    f"{1e-3 * load[k]:.4g} kN m: `{command}` answers loads in one vertical plane without torsion")
            for name, what, load in (("M", "moment across the plane of H", self.across), ("T", "torsion", self.torsion))
            for k in np.flatnonzero(load)
        ]  # fmt: skip
        if problems:
            raise UserInputError(problems)


def read_load_cases(path: str | os.PathLike[str]) -> LoadCases:
    """Read load cases from a CSV file or an Excel workbook (its first sheet that holds anything).

    Raises
    ------
    UserInputError
        Every fault of the table, each with file, line and column.
    """
    faults, file = Faults(), Path(path)
    place = str(file)
    head, lines = sheet_of(file)
    columns = _columns(place, head, faults)
    faults.stop()
    at = np.array([line for line, _ in lines], dtype=np.int64)
    cells = {
        column.name: ([row[k] if k < len(row) else None for _, row in lines], column.factor)
        for k, column in enumerate(columns)
    }
    for line, row in lines:
        if any(cell not in (None, "") for cell in row[len(head) :]):
            faults.add((place, line), None, f"more cells than the {len(head)} columns of the heading")
    none: tuple[list[Any], float] = ([None] * at.size, 1.0)
    given = {name: cells.get(name, none) for name in COLUMNS}
    texts = {name: ["" if cell is None else str(cell).strip() for cell in given[name][0]] for name in TEXTS}
    values = {name: numbers(place, name, given[name][0], at, faults, given[name][1]) for name in NUMBERS}
    if not at.size:
        faults.add((place, None), None, "no rows")
    _check_texts(place, at, texts, faults)
    _check_rows(place, at, values, set(cells), faults)
    faults.stop()
    cases = _added(place, at, texts, values, faults)
    faults.stop()
    return cases


def _check_texts(place: str, at: NDArray[np.int64], texts: dict[str, list[str]], faults: Faults) -> None:
    """Note texts that a spreadsheet would read as a formula, or that cannot be printed."""
    for name, column in texts.items():
        for line, text in zip(at.tolist(), column, strict=True):
            if text.startswith(tuple("=+-@")) or len(text) > MOST_LETTERS or not text.isprintable():
                rule = f"a name has at most {MOST_LETTERS} characters, the first none of = + - @"
                faults.add((place, line), name, f"{quoted(text)}: {rule}")


def _columns(place: str, head: list[str], faults: Faults) -> list[Column]:
    """Return the column of each heading; note wrong headings, and loads that are missing or given twice."""
    if not head:
        faults.add((place, None), None, f"holds no table: expected a heading and a row a load ({FORMS})")
        return []
    read = read_headings(place, head, COLUMNS, faults, ALIASES)
    names = {column.name for column in read if column}
    if len(read) == len(names):
        if not names & {"H_N", "M_Nm", "V_N"}:
            faults.add((place, 1), None, f"no column with a load: expected {FORMS}")
        if {"M_Nm", "arm_m"} <= names and "H_N" not in names:
            faults.add((place, 1), "arm_m", "a height without H")
        if "arm_m" in names and not names & {"H_N", "M_Nm"}:
            faults.add((place, 1), "arm_m", "a height without H")
    return [column or Column("") for column in read]


def _check_rows(place: str, at: NDArray[np.int64], values: dict[str, Array], there: set[str], faults: Faults) -> None:
    """Note blank loads, moments that are given twice, factors and tolerances that are not positive."""
    bad = {(each.line, each.key) for each in faults.problems}
    for k, line in enumerate(at.tolist()):
        H, M, V, arm = (values[name][k] for name in ("H_N", "M_Nm", "V_N", "arm_m"))
        if np.isnan([H, M, V]).all() and not any(number == line for number, _ in bad):
            faults.add((place, line), None, f"no load: expected {FORMS}")
        if np.isfinite(arm) and np.isfinite(M):
            faults.add((place, line), "arm_m", "give either a moment or the height of H, not both (M = -H arm)")
        if np.isfinite(arm) and np.isnan(H) and (line, "H_N") not in bad:
            faults.add((place, line), "arm_m", "a height without H")
        for name in ("factor", "factor_H", "factor_M", "factor_V"):
            if values[name][k] < 0.0:
                faults.add((place, line), name, f"{values[name][k]:g} is negative: a partial factor is 0 or more")
            if values[name][k] > MOST_FACTOR:
                faults.add((place, line), name, f"{values[name][k]:g} is above {MOST_FACTOR:g}: 1.35 is usual, not 135")
        for name in ("direction_rad", "M_direction_rad"):
            if abs(values[name][k]) > _TURN:
                faults.add((place, line), name, f"{np.degrees(values[name][k]):.6g} deg is beyond one turn, 360 deg")
        if values["tilt_rad"][k] <= 0.0:
            faults.add((place, line), "tilt_rad", "a tolerance must be positive")
    if there & {"factor"} and there & {"factor_H", "factor_M", "factor_V"}:
        faults.add((place, 1), "factor", "give either one factor on H, M and V, or factor H, factor M and factor V")


def _added(
    place: str, at: NDArray[np.int64], texts: dict[str, list[str]], values: dict[str, Array], faults: Faults
) -> LoadCases:
    """Return the cases: factored loads of one name, added as vectors."""
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(texts["name"]):
        groups.setdefault(name or f"row {at[k]}", []).append(k)
    loads, remarks = _factored(values)
    cases = []
    for name, rows in groups.items():
        state = _one_text(place, at, texts["limit_state"], rows, faults)
        tilt = np.unique(values["tilt_rad"][rows][np.isfinite(values["tilt_rad"][rows])])
        if tilt.size > 1:
            faults.add((place, int(at[rows[1]])), "tilt_rad", f"rows of case '{name}' differ in their tolerance")
        H, M, across, direction = _in_plane(rows, loads, values)
        V = np.nan if np.isnan(loads["V"][rows]).all() else math.fsum(np.nan_to_num(loads["V"][rows]))
        numbers = (H, M, V, direction, float(tilt[0]) if tilt.size else np.nan, across, math.fsum(loads["T"][rows]))
        cases.append((name, state, int(at[rows[0]]), *numbers, _remark([remarks[k] for k in rows])))
    columns = list(zip(*cases, strict=True))
    names = ("H", "M", "V", "direction", "tilt", "across", "torsion")
    arrays = {each: np.array(column, dtype=float) for each, column in zip(names, columns[3:10], strict=True)}
    lines = np.array(columns[2], dtype=np.int64)
    return LoadCases(place, columns[0], columns[1], line=lines, remarks=columns[10], **arrays)


def _factored(values: dict[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Return H, M, V and T of each row with their factors (V: NaN where there is none), and remarks by row.

    The moment of a force has the factor of the force: M = -H arm, and M or T beside `factor H` without `factor M`.
    """
    one = np.nan_to_num(values["factor"], nan=1.0)
    by = {name: values[f"factor_{name}"] for name in "HMV"}
    moments = np.nan_to_num(values["M_Nm"]) != 0.0, np.nan_to_num(values["T_Nm"]) != 0.0
    taken = np.isnan(by["M"]) & np.isfinite(by["H"]) & (by["H"] != 1.0) & (moments[0] | moments[1])
    by["M"] = np.where(np.isnan(by["M"]), by["H"], by["M"])
    H, V = (np.nan_to_num(by[name], nan=1.0) * one for name in "HV")
    turning = np.nan_to_num(by["M"], nan=1.0) * one
    force = np.nan_to_num(values["H_N"])
    M = np.nan_to_num(values["M_Nm"]) * turning - np.nan_to_num(force * values["arm_m"]) * H
    loads = {"H": force * H, "M": M, "V": values["V_N"] * V, "T": np.nan_to_num(values["T_Nm"]) * turning}
    text = "factor H {:g} multiplies the moment, too (no factor M)"
    return loads, [text.format(by["H"][k]) if each else "" for k, each in enumerate(taken)]


def _remark(texts: Sequence[str]) -> str:
    return "; ".join(dict.fromkeys(text for text in texts if text))


def _one_text(place: str, at: NDArray[np.int64], given: list[str], rows: Sequence[int], faults: Faults) -> str:
    texts = list(dict.fromkeys(given[k] for k in rows if given[k]))
    if len(texts) > 1:
        faults.add((place, int(at[rows[1]])), "limit_state", f"rows of one case differ: {', '.join(texts)}")
    return texts[0] if texts else ""


def _in_plane(
    rows: Sequence[int], loads: dict[str, Array], values: dict[str, Array]
) -> tuple[float, float, float, float]:
    """Return H, M, the moment about the direction of H, and that direction, of the sum of some rows.

    Rows of one direction keep it; else it is that of the sum of H (H > 0), or, without H, that of the moment.
    """
    towards = np.nan_to_num(values["direction_rad"][rows])
    turning = np.where(np.isnan(values["M_direction_rad"][rows]), towards, values["M_direction_rad"][rows])
    force, moment = loads["H"][rows], loads["M"][rows]
    H, M = _sum(force, towards), _sum(moment, turning)
    acting = (force != 0.0) | (moment != 0.0)
    directions = np.unique(np.where(force != 0.0, towards, turning)[acting])
    if directions.size == 1:
        plane = np.array([np.cos(directions[0]), np.sin(directions[0])])
    elif np.hypot(*H) > _ACROSS * np.abs(force).sum():
        plane = H / np.hypot(*H)
    elif np.hypot(*M) > _ACROSS * np.abs(moment).sum():
        plane = -M / np.hypot(*M)
    else:
        plane = np.array([1.0, 0.0])
    across = float(plane[0] * M[1] - plane[1] * M[0])
    if abs(across) <= _ACROSS * np.abs(moment).sum():
        across = 0.0
    return float(plane @ H), float(plane @ M), across, float(np.arctan2(plane[1], plane[0]))


def _sum(size: Array, angle: Array) -> Array:
    return np.array([math.fsum(size * np.cos(angle)), math.fsum(size * np.sin(angle))])
