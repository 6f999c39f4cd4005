# SPDX-License-Identifier: MIT
"""The answers to load cases for people: cells for a terminal, the workbook, the page, and the report of their run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pysprings.core.text import number
from pysprings.results.layout import LOAD_CASES
from pysprings.results.report.table import ReportData, ReportTable, Table

OK = "ok"  # verdict of a case with an answer that the springs support, within its tolerance
KN, MN, MM = 1e-3, 1e-6, 1e3
_TEXTS = ("name", "limit_state", "marks", "remarks", "verdict", "capacity_kind", "capacity_V_kind")


@dataclass(frozen=True)
class Column:
    """A column for people: heading with unit, column of the table in SI, factor; `brief`: also on a terminal."""

    head: str
    source: str
    factor: float = 1.0
    brief: bool = True
    digits: int = 4

    @property
    def is_text(self) -> bool:
        """True for a column of words."""
        return self.source in _TEXTS

    def value(self, row: dict[Any, Any]) -> Any:
        """Return the text or number of a row; None where there is no number."""
        given = row[self.source]
        if self.is_text:
            return str(given)
        return None if given is None or math.isnan(given) else float(given) * self.factor + 0.0

    def cell(self, row: dict[Any, Any]) -> str:
        """Return the cell of a row as text."""
        value = self.value(row)
        return value if isinstance(value, str) else number(value, self.digits)


COLUMNS = (
    Column("case", "name"),
    Column("limit state", "limit_state"),
    Column("direction [deg]", "direction_deg", brief=False),
    Column("H [kN]", "H_N", KN),
    Column("M [kN m]", "M_Nm", KN),
    Column("V [kN]", "V_N", KN),
    Column("u [mm]", "u_m", MM),
    Column("w [mm]", "w_m", MM, brief=False),
    Column("rotation [deg]", "rotation_rad", math.degrees(1.0)),
    Column("tilt tolerated [deg]", "tilt_limit_deg", brief=False),
    Column("tilt used", "tilt_used", digits=3),
    Column("secant H/u [MN/m]", "secant_H_u_N_per_m", MN, brief=False),
    Column("secant M/rotation [MN m/rad]", "secant_M_rotation_Nm", MN, brief=False),
    Column("tangent K uu [MN/m]", "tangent_u_u_N_per_m", MN, brief=False),
    Column("tangent K u,rotation [MN/rad]", "tangent_u_rotation_N", MN, brief=False),
    Column("tangent K rotation,u [MN m/m]", "tangent_rotation_u_N", MN, brief=False),
    Column("tangent K rotation,rotation [MN m/rad]", "tangent_rotation_rotation_Nm", MN, brief=False),
    Column("tangent K ww [MN/m]", "tangent_w_w_N_per_m", MN, brief=False),
    Column("utilisation", "utilisation", digits=3),
    Column("V used", "utilisation_V", digits=3),
    Column("capacity V [kN]", "capacity_V_N", KN, brief=False),
    Column("of", "capacity_V_kind", brief=False),
    Column("capacity H [kN]", "H_capacity_N", KN, brief=False),
    Column("capacity M [kN m]", "M_capacity_Nm", KN, brief=False),
    Column("of", "capacity_kind"),
    Column("range used", "range_used", brief=False, digits=3),
    Column("across [kN m]", "across_Nm", KN, brief=False),
    Column("torsion [kN m]", "torsion_Nm", KN, brief=False),
    Column("u bound [mm]", "u_bound_m", MM, brief=False),
    Column("rotation bound [deg]", "rotation_bound_rad", math.degrees(1.0), brief=False),
    Column("utilisation bound", "utilisation_bound", brief=False, digits=3),
    Column("verdict", "verdict"),
    Column("mark", "marks"),
    Column("remark", "remarks"),
)
NOTE = (
    "M is about the lid centre at mudline, M = H arm; loads contain their partial factors. Utilisation is the load "
    "over the largest known one in its direction, H and M in proportion at the V of the case; of the end of the range: "
    "the springs reach no further, the capacity is larger. V used is V over the largest vertical load of the vertical "
    "springs. A case without an answer has no motion; its mark is the "
    "reason. A bound, for a moment across the plane of H and a torsion, has all of the moment in that plane and T over "
    "the radius added to H."
)


def columns_of(table: pd.DataFrame, brief: bool) -> list[Column]:
    """Return the columns that a table fills; for a terminal the brief ones."""
    rows = table.to_dict("records")
    return [
        column
        for column in COLUMNS
        if column.source in table
        and (column.brief or not brief)
        and any(column.cell(row) not in ("", "-") for row in rows)
    ]


def cells(table: pd.DataFrame, columns: list[Column]) -> list[list[str]]:
    """Return the rows of a table as texts below the heads of `columns`."""
    return [[column.cell(row) for column in columns] for row in table.to_dict("records")]


def closing(table: pd.DataFrame) -> str:
    """Return the counts of the verdicts and the cases that govern; a case without an answer does where it is beyond."""
    counts = table["verdict"].value_counts()
    parts = [f"{n:,} {verdict}" for verdict, n in counts.items()]
    text = f"{len(table):,} case{'' if len(table) == 1 else 's'}: {', '.join(parts)}"
    for column, words in (("tilt_used", "tilt used"), ("utilisation", "utilisation"), ("utilisation_V", "V used")):
        known = table[table[column].notna() & ((table["answered"] == 1) | (table[column] > 1.0))]
        if len(known):
            worst = known.sort_values([column, "name"]).iloc[-1]
            text += f"; largest {words} {worst[column]:.3g} in '{worst['name']}'"
    return text


def is_fine(table: pd.DataFrame) -> bool:
    """Return whether every case is ok."""
    return bool((table["verdict"] == OK).all())


def table_of(answers: pd.DataFrame) -> Table:
    """Return the answers to load cases, in SI, as a table of a page."""
    columns = columns_of(answers, brief=False)
    return Table(closing(answers), [column.head for column in columns], cells(answers, columns), NOTE, wide=True)


def read_answers(folder: Path) -> pd.DataFrame | None:
    """Return the answers to load cases that a folder of a run holds, in SI; None where it holds none."""
    file = folder / LOAD_CASES
    if not file.exists():
        return None
    frame = pd.read_csv(file, dtype=dict.fromkeys(_TEXTS, str), keep_default_na=False, na_values=[""])
    return frame.fillna(dict.fromkeys(_TEXTS, ""))


def _build(data: ReportData) -> list[Table | None]:
    return [] if data.cases is None else [table_of(data.cases)]


CASES = ReportTable("load_cases", "cases", _build)
