# SPDX-License-Identifier: MIT
"""The answers to load cases for people: columns of terminal, workbook, page, and the report of their run."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd

from pysprings.core.columns import Column, Table, filled
from pysprings.results.layout import LOAD_CASES
from pysprings.results.report.table import ReportTable

OK = "ok"  # verdict of a case with an answer that the springs support, within its tolerance
KN, MN, MM = 1e-3, 1e-6, 1e3

COLUMNS = (
    Column("case", "name", words=True),
    Column("limit state", "limit_state", words=True),
    Column("direction [deg]", "direction_deg", brief=False),
    Column("H [kN]", "H_N", factor=KN),
    Column("M [kN m]", "M_Nm", factor=KN),
    Column("V [kN]", "V_N", factor=KN),
    Column("u [mm]", "u_m", factor=MM),
    Column("w [mm]", "w_m", factor=MM, brief=False),
    Column("rotation [deg]", "rotation_rad", factor=math.degrees(1.0)),
    Column("tilt tolerated [deg]", "tilt_limit_deg", brief=False),
    Column("tilt used", "tilt_used", form=3),
    Column("secant H/u [MN/m]", "secant_H_u_N_per_m", factor=MN, brief=False),
    Column("secant M/rotation [MN m/rad]", "secant_M_rotation_Nm", factor=MN, brief=False),
    Column("tangent K uu [MN/m]", "tangent_u_u_N_per_m", factor=MN, brief=False),
    Column("tangent K u,rotation [MN/rad]", "tangent_u_rotation_N", factor=MN, brief=False),
    Column("tangent K rotation,u [MN m/m]", "tangent_rotation_u_N", factor=MN, brief=False),
    Column("tangent K rotation,rotation [MN m/rad]", "tangent_rotation_rotation_Nm", factor=MN, brief=False),
    Column("tangent K ww [MN/m]", "tangent_w_w_N_per_m", factor=MN, brief=False),
    Column("utilisation", "utilisation", form=3),
    Column("V used", "utilisation_V", form=3),
    Column("capacity V [kN]", "capacity_V_N", factor=KN, brief=False),
    Column("of", "capacity_V_kind", brief=False, words=True),
    Column("capacity H [kN]", "H_capacity_N", factor=KN, brief=False),
    Column("capacity M [kN m]", "M_capacity_Nm", factor=KN, brief=False),
    Column("of", "capacity_kind", words=True),
    Column("range used", "range_used", brief=False, form=3),
    Column("across [kN m]", "across_Nm", factor=KN, brief=False),
    Column("torsion [kN m]", "torsion_Nm", factor=KN, brief=False),
    Column("u bound [mm]", "u_bound_m", factor=MM, brief=False),
    Column("rotation bound [deg]", "rotation_bound_rad", factor=math.degrees(1.0), brief=False),
    Column("utilisation bound", "utilisation_bound", brief=False, form=3),
    Column("verdict", "verdict", words=True),
    Column("mark", "marks", words=True),
    Column("remark", "remarks", words=True),
)
NOTE = (
    "M is about the lid centre at mudline, M = H arm; loads contain their partial factors. Utilisation is the load "
    "over the largest known one in its direction, H and M in proportion at the V of the case; of the end of the range: "
    "the springs reach no further, the capacity is larger. V used is V over the largest vertical load of the vertical "
    "springs. A case without an answer has no motion; its mark is the "
    "reason. A bound, for a moment across the plane of H and a torsion, has all of the moment in that plane and T over "
    "the radius added to H."
)


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


def table_of(answers: pd.DataFrame, brief: bool = False) -> Table:
    """Return the answers to load cases, in SI, as a table of a page; ``brief``: of a terminal."""
    rows = answers.to_dict("records")
    return Table.of(filled(COLUMNS, rows, brief), rows, closing(answers), NOTE, wide=True)


def read_answers(folder: Path) -> pd.DataFrame | None:
    """Return the answers to load cases that a folder of a run holds, in SI; None where it holds none."""
    file = folder / LOAD_CASES
    if not file.exists():
        return None
    texts = [str(column.source) for column in COLUMNS if column.words]
    frame = pd.read_csv(file, dtype=dict.fromkeys(texts, str), keep_default_na=False, na_values=[""])
    return frame.fillna(dict.fromkeys(texts, ""))


CASES = ReportTable("load_cases", "cases", lambda data: [] if data.cases is None else [table_of(data.cases)])
