# SPDX-License-Identifier: MIT
"""The springs as tables of the report: reactions by depth at the end of each path, and those of tip and lid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.text import number
from pysprings.results.report.table import ReportTable, Table
from pysprings.springs.dataset import get_path, is_vertical, path_names
from pysprings.springs.edge import edge_rings
from pysprings.springs.sums import net_m, net_p

if TYPE_CHECKING:
    import xarray as xr

_COLUMNS = ("depth [m]", "slice [m]", "y [mm]", "p outside [kN/m]", "p inside [kN/m]", "p net [kN/m]",
            "p at half of y [kN/m]", "m [kN m/m]")  # fmt: skip
_NOTE = (
    "At the last converged step; soil reactions, positive when they oppose a positive displacement. y: displacement of "
    "the caisson's mean fibre; p: lateral, m: moment of the vertical shear, both per metre of depth; normal stress, "
    "shear and water together. *: edge ring of the tip, whose p depends on the mesh; its force does not. Every path "
    "and step is in springs.xlsx, py.csv and springs.nc."
)


def spring_tables(springs: xr.DataTree | None) -> list[Table]:
    """Return the table of the first lateral path of a spring set; none without springs."""
    if springs is None:
        return []
    lateral = [name for name in path_names(springs) if not is_vertical(springs, name)]
    return [_table(name, get_path(springs, name)) for name in lateral[:1]]


def _table(name: str, path: xr.Dataset) -> Table:
    p, m, y = net_p(path).values * 1e-3, net_m(path).values * 1e-3, path["y"].transpose("depth", "step").values * 1e3
    sides = path["p"].sum("component").transpose("side", "depth", "step").values * 1e-3
    edge = edge_rings(path)
    order = [str(side) for side in path["side"].values]
    rows = [
        (
            number(float(depth)) + ("*" if edge[k] else ""),
            "{:.2f} to {:.2f}".format(*path["depth_bounds"].values[k]),
            number(y[k, -1]),
            number(sides[order.index("outside"), k, -1]),
            number(sides[order.index("inside"), k, -1]),
            number(p[k, -1]),
            _at_half(y[k], p[k]),
            number(m[k, -1]),
        )
        for k, depth in enumerate(path["depth"].values)
    ]
    for part in ("tip", "lid"):
        force, moment = (float(path[f"{letter}_{part}"].values[-1]) * 1e-3 for letter in ("H", "M"))
        rows.append((part, "", "", "", "", f"H {number(force)} kN", "", f"M {number(moment)} kN m"))
    return Table(f"Path {name}", _COLUMNS, rows, _NOTE, wide=True)


def _at_half(y: np.ndarray, p: np.ndarray) -> str:
    """Return the reaction at half of the last displacement, where y only grows in size; '-' elsewhere."""
    size = np.abs(y)
    if (np.diff(size) <= 0.0).any():
        return "-"
    return number(float(np.interp(0.5 * size[-1], size, p)))


def stiffness_table(result: xr.DataTree) -> Table | None:
    """Return the table of the initial stiffness of the full model; None for results without it."""
    if "stiffness_initial" not in result.dataset:
        return None
    matrix = result.dataset["stiffness_initial"]
    dofs = [str(name) for name in matrix["dof"].values]
    loads = {"u": "H [MN]", "w": "V [MN]", "rotation": "M [MN m]"}
    least = 1e-12 * float(np.abs(matrix.values).max())  # symmetry makes the others zero but for rounding
    values = [[number(1e-6 * float(value) if abs(value) > least else 0.0, 6) for value in row] for row in matrix.values]
    rows = [[loads[name], *cells] for name, cells in zip(dofs, values, strict=True)]
    heads = ("", "per u [m]", "per w [m]", "per rotation [rad]")
    note = "At the lid centre, z down. `pysprings predict --stiffness` gives 6 x 6, other axes and reference points."
    return Table("Initial stiffness of the full model", heads, rows, note)


STIFFNESS = ReportTable("stiffness", "springs", lambda data: [stiffness_table(data.result)])
SPRINGS = ReportTable("springs", "springs", lambda data: spring_tables(data.springs))
