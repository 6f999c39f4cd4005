# SPDX-License-Identifier: MIT
"""Tables of the cost of a run: seconds by phase, totals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pysprings.core.text import number
from pysprings.results.report.table import ReportTable, Table


def cost_tables(run: Mapping[str, Any]) -> list[Table]:
    """Return the tables of cost from run.json: seconds by phase, then totals."""
    tables = []
    phases = {str(name): dict(value) for name, value in dict(run.get("phases") or {}).items()}
    if phases:
        keys = list(dict.fromkeys(key for value in phases.values() for key in value))
        rows = [[name, *(number(value.get(key, "-"), 3) for key in keys)] for name, value in phases.items()]
        tables.append(Table("Cost by phase", ["phase", *(_words(key) for key in keys)], rows))
    flat = {**run, **dict(run.get("solver") or {})}
    totals = [(words, number(flat[key] * factor)) for key, (words, factor) in _TOTALS.items() if key in flat]
    totals += [(key, str(run[key])) for key in ("python", "platform") if key in run]
    totals += [(str(name), str(value)) for name, value in dict(run.get("environment") or {}).items()]
    if totals:
        tables.append(Table("Totals", ("", ""), totals, head=False))
    return tables


_TOTALS: dict[str, tuple[str, float | int]] = {
    "wall_s": ("wall time [s]", 1.0),
    "cpu_s": ("processor time [s]", 1.0),
    "peak_memory_bytes": ("peak memory [MB]", 1e-6),
    "factorisations": ("factorisations", 1),
    "solves": ("solves", 1),
    "worst_linear_residual": ("worst residual of a linear solve", 1.0),
    "tolerance": ("Newton tolerance (relative residual)", 1.0),
}


def _words(key: str) -> str:
    return {"wall_s": "wall [s]", "cpu_s": "processor [s]"}.get(key, key.replace("_", " "))


COST = ReportTable("cost", "cost", lambda data: cost_tables(data.run))
