# SPDX-License-Identifier: MIT
"""Tables of the report in reading order. A new table is one module in this folder and one entry here.

Other packages call `REPORT_TABLES.register`, or declare an entry point in the group `pysprings.report_tables`.
"""

from __future__ import annotations

from dataclasses import replace

from pysprings.core.registry import Registry
from pysprings.results.report import balances, inputs, load_cases, solution, springs, validity
from pysprings.results.report.table import ReportData, ReportTable, Section, Table

REPORT_TABLES: Registry[ReportTable] = Registry(
    "report table",
    (
        load_cases.CASES,
        springs.STIFFNESS,
        springs.SPRINGS,
        solution.END,
        solution.TILT,
        validity.COMPARISON,
        inputs.INPUTS,
        inputs.DEFAULTS,
        inputs.OMISSIONS,
        inputs.SETTINGS,
        inputs.MESH,
        solution.CONVERGENCE,
        solution.CUT_BACKS,
        balances.EQUILIBRIUM,
        solution.RINGS,
        balances.WATER,
        balances.ENERGY,
        validity.ESTIMATE,
        solution.GAPS,
        balances.COST,
    ),
    group="pysprings.report_tables",
)


def tables_of(section: Section, data: ReportData, path: str = "") -> list[Table]:
    """Return the tables of one section of the report, for the section "path" those of a path."""
    own = replace(data, path=path)
    return [
        table for each in REPORT_TABLES if each.section == section for table in each.build(own) if table is not None
    ]
