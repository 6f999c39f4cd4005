# SPDX-License-Identifier: MIT
"""Tables of the balances: forces and moments, water, energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.columns import Column, Table
from pysprings.core.text import number
from pysprings.full_model.run_record import RunRecord
from pysprings.results.report.table import ReportTable

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.full_model.run_record import PathFigures


def equilibrium_table(tree: xr.DataTree) -> Table:
    """Return the table of the equilibrium check over the converged steps of a result or of springs.

    Missing: the sum of the soil reactions less the applied load (`pysprings.springs.sums.balance`).
    """
    from pysprings.springs.path import paths_of
    from pysprings.springs.sums import balance

    rows = []
    for name, recorded in paths_of(tree).items():
        path = recorded.dataset
        for load, missing in balance(path).items() if path.sizes["step"] else ():
            unit = "kN m" if load == "M" else "kN"
            largest = f"{float(np.abs(path[load]).max()) / 1e3 + 0.0:.4g} {unit}"
            rows.append((name, load, largest, f"{missing:.1e}"))
    note = (
        "H = sum p dz + H_tip + H_lid; V = sum t dz + V_tip + V_lid; "
        "M = -(sum p z dz + L H_tip) + sum m dz + M_tip + M_lid. Missing: reactions less load, over the largest part."
    )
    return Table("Equilibrium check", ("path", "load", "largest load", "missing (relative)"), rows, note)


def water_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """Return the table of the balance of the water at the end of each path; None for a drained run."""
    paths = {name: path.water for name, path in figures.items() if path.water}
    if not paths:
        return None
    rows = [{"path": name, **water} for name, water in paths.items()]
    note = (
        "Since the initial state, whole caisson: expelled = compressed + in gaps + outflow. Expelled is the pore "
        "volume that the soil has lost, from the displacements of its boundary; the outflow is Darcy flow over the "
        "drained boundary. The largest imbalance of all steps is shown. Pressure: the range of the excess on the path."
    )
    return Table.of(_WATER, rows, "Balance of the water", note, wide=True)


def energy_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """Return the table of the balance of energy at the end of each path; None where it was not computed."""
    paths = {name: path.energy for name, path in figures.items() if path.energy}
    if not paths:
        return None
    rows = [{"path": name, **energy} for name, energy in paths.items()]
    note = (
        "Since the initial state, whole caisson: work + initial = elastic + plastic + penalty + friction + water. "
        "Initial is the work of weight, surcharge and initial contact pressure, penalty what contact springs store, "
        "water what is done against pore pressures. The imbalance is the residual of Newton, over the largest term."
    )
    return Table.of(_ENERGY, rows, "Balance of energy", note, wide=True)


_PATH = Column("path", "path", words=True)
_WATER = (
    _PATH,
    Column("expelled [m\u00b3]", "expelled_m3"),
    Column("compressed [m\u00b3]", "compressed_m3"),
    Column("in gaps [m\u00b3]", "film_m3"),
    Column("outflow [m\u00b3]", "outflow_m3"),
    Column("imbalance / exchanged", "worst_imbalance_over_exchanged", ".1e"),
    Column("pressure [kPa]", lambda row: f"{row['pressure_min_Pa'] / 1e3:.3g} to {row['pressure_max_Pa'] / 1e3:.3g}"),
)
_TERMS = ("work", "initial", "elastic", "plastic", "penalty", "friction", "water")
_ENERGY = (
    _PATH,
    *(Column(f"{term} [kJ]", f"{term}_J", factor=1e-3) for term in _TERMS),
    Column("imbalance / largest", "imbalance_over_largest_term", ".1e"),
)
EQUILIBRIUM = ReportTable(
    "equilibrium", "checks", lambda data: [equilibrium_table(data.result if data.springs is None else data.springs)]
)
WATER = ReportTable("water", "checks", lambda data: [water_table(data.figures)])
ENERGY = ReportTable("energy", "checks", lambda data: [energy_table(data.figures)])


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
