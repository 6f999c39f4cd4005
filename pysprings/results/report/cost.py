# SPDX-License-Identifier: MIT
"""Tables of the cost of a run: seconds by phase, totals."""

from __future__ import annotations

from pysprings.core.text import number
from pysprings.full_model.run_record import RunRecord
from pysprings.results.report.table import ReportTable, Table


def cost_tables(run: RunRecord | None) -> list[Table]:
    """Return the tables of the cost of a run: seconds by phase, then totals; none without a record."""
    if run is None:
        return []
    tables = []
    if run.phases:
        keys = list(dict.fromkeys(key for value in run.phases.values() for key in value))
        rows = [[name, *(number(value.get(key, "-"), 3) for key in keys)] for name, value in run.phases.items()]
        tables.append(Table("Cost by phase", ["phase", *(_words(key) for key in keys)], rows))
    solver = run.solver
    figures: dict[str, float | None] = {
        "wall time [s]": run.wall_s,
        "processor time [s]": run.cpu_s,
        "peak memory [MB]": run.peak_memory_bytes * 1e-6,
        "factorisations": solver.factorisations,
        "solves": solver.solves,
        "worst residual of a linear solve": solver.worst_linear_residual,
        "Newton tolerance (relative residual)": solver.tolerance,
    }
    totals = [(words, number(value)) for words, value in figures.items() if value is not None]
    totals += [("python", run.python), ("platform", run.platform), *run.environment.items()]
    tables.append(Table("Totals", ("", ""), totals, head=False))
    return tables


def _words(key: str) -> str:
    return {"wall_s": "wall [s]", "cpu_s": "processor [s]"}.get(key, key.replace("_", " "))


COST = ReportTable("cost", "cost", lambda data: cost_tables(data.run))
