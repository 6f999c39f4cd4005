# SPDX-License-Identifier: MIT
"""The wide table: one row for each step, one pair of columns y, p for each depth, ready to be pasted.

Programs and spreadsheets read p-y curves as one pair of columns for each depth. Then follow the companions by depth,
and the forces on tip and lid. SI; each heading names quantity, unit, depth and slice:

    y_m z=0.5 [0.25..0.75]
"""

import re

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.springs.path import RecordedPath, paths_of
from pysprings.springs.sums import by_depth, net_m

# Quantities by depth: pairs that belong beside each other.
PAIRS = (("y_m", "p_N_per_m"), ("m_Nm_per_m", "t_N_per_m"))
# Families of the long table -> column of the long table -> column of the wide one.
ENDS = {
    family: {"H_N": f"H_{part}_N", "V_N": f"V_{part}_N", "M_Nm": f"M_{part}_Nm"}
    for family, part in (("base", "tip"), ("lid", "lid"))
}

_HEADING = re.compile(r"(?P<name>\w+) z=(?P<depth>\S+) \[(?P<top>\S+?)\.\.(?P<bottom>\S+)\]")


def heading(name: str, depth: float, bounds: np.ndarray) -> str:
    """Return the heading of a quantity at a depth [m] with the top and bottom of its slice [m]."""
    return f"{name} z={depth:.10g} [{bounds[0]:.10g}..{bounds[1]:.10g}]"


def parse(text: str) -> tuple[str, tuple[str, str, str]] | None:
    """Return quantity and (depth, top, bottom) as they stand in a heading; None for any other text."""
    match = _HEADING.fullmatch(text.strip())
    return None if match is None else (match["name"], (match["depth"], match["top"], match["bottom"]))


def py_wide(springs: xr.DataTree) -> pd.DataFrame:
    """Return the springs in the wide format (SI): one row per path and step, both sides and all components together.

    Columns: path, step, converged, rotation_rad, w_m; for each depth the pair y_m, p_N_per_m; for each depth the pair
    m_Nm_per_m, t_N_per_m; H, V, M of tip and lid. A vertical path has no y, p and m.
    """
    return pd.concat([_path(path) for path in paths_of(springs).values()], ignore_index=True)


def _path(recorded: RecordedPath) -> pd.DataFrame:
    path = recorded.recorded
    n = path.sizes["step"]
    columns = {
        "path": np.full(n, recorded.name),
        "step": np.arange(n),
        "converged": path["converged"].values,
        "rotation_rad": path["rotation"].values,
        "w_m": path["w"].values,
    }
    values = {
        "y_m": path["y"].transpose("depth", "step").values,
        "p_N_per_m": by_depth(path, "p"),
        "m_Nm_per_m": net_m(path).values,
        "t_N_per_m": path["t"].sum("side").transpose("depth", "step").values,
    }
    if recorded.is_vertical:
        values |= {quantity: np.full_like(values["y_m"], np.nan) for quantity in ("y_m", "p_N_per_m", "m_Nm_per_m")}
    depth, bounds = path["depth"].values, path["depth_bounds"].values
    for pair in PAIRS:
        for k, z in enumerate(depth):
            columns |= {heading(quantity, float(z), bounds[k]): values[quantity][k] for quantity in pair}
    for ends in ENDS.values():
        columns |= {wide: path[wide.rpartition("_")[0]].values for wide in ends.values()}
    return pd.DataFrame(columns)
