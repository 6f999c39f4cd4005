# SPDX-License-Identifier: MIT
"""Tables behind the CSV files, as data frames in SI with the unit in every column name.

Programs and spreadsheets read p-y curves as one pair of columns y, p for each depth: the wide table has a row for each
step. Then follow the companions by depth, and the forces on tip and lid; each heading names quantity, unit, depth and
slice:

    y_m z=0.5 [0.25..0.75]
"""

import re
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array, Integers
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.springs.path import RecordedPath, paths_of, space_paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import by_depth, displacement_at

# Column -> variable of a result path. The order is part of the public contract.
LOAD_DISPLACEMENT = {
    "time_s": "time",
    "u_m": "u",
    "w_m": "w",
    "rotation_rad": "rotation",
    "H_N": "H",
    "V_N": "V",
    "M_Nm": "M",
    "H_outer_N": "H_outer",
    "H_inner_N": "H_inner",
    "H_lid_N": "H_lid",
    "H_tip_N": "H_tip",
    "F_pw_N": "F_pw",
    "F_in_N": "F_in",
    "F_out_N": "F_out",
    "converged": "converged",
}

# The same of runs with a path that leaves the plane of x
IN_SPACE = {
    "time_s": "time",
    **{f"{name}_{'rad' if 'rot' in name else 'm'}": name for name in MOTIONS},
    **{f"{name}_{'Nm' if name in ('M_x', 'M_y', 'T') else 'N'}": name for name in LOADS},
    "converged": "converged",
}

# The first ten columns are the public contract; the rest hold the companions of p.
PY_COLUMNS = [
    *("path", "family", "depth_m", "depth_top_m", "depth_bottom_m", "side", "component", "step", "y_m", "p_N_per_m"),
    *("rotation_rad", "w_m", "m_Nm_per_m", "t_N_per_m", "H_N", "V_N", "M_Nm", "converged"),
]

_SIDES = ("outside", "inside", "net")
_COMPONENTS = ("normal", "shear", "water", "total")


def load_displacement(result: xr.DataTree) -> pd.DataFrame:
    """Return loads and displacements of the whole caisson by path and step (SI), unconverged steps marked.

    Where a path leaves the plane of x, all have the columns of six degrees of freedom.
    """
    paths, columns = {name: _timed(each.recorded) for name, each in paths_of(result).items()}, LOAD_DISPLACEMENT
    if leaves_plane(result):
        paths, columns = {name: _turned(path) for name, path in paths.items()}, IN_SPACE
        paths |= {name: each.recorded for name, each in space_paths_of(result).items()}
    frames = []
    for name, path in paths.items():
        n = path.sizes["step"]
        head = {"path": [name] * n, "step": np.arange(n)}
        frames.append(pd.DataFrame(head | {column: path[key].values for column, key in columns.items()}))
    return pd.concat(frames, ignore_index=True)


def leaves_plane(tree: xr.DataTree) -> bool:
    """Return whether a path of a result or of springs leaves the plane of x, or has another one."""
    return bool(space_paths_of(tree)) or any(each.attrs.get("direction_rad") for each in paths_of(tree).values())


def _timed(path: xr.Dataset) -> xr.Dataset:
    """Return a path with its time; that of springs without one is not known."""
    return path if "time" in path else path.assign(time=np.nan * path["w"])


def _turned(path: xr.Dataset) -> xr.Dataset:
    """Return a path in one plane with the variables of six degrees of freedom, in its direction."""
    angle, nothing = float(path.attrs.get("direction_rad", 0.0)), 0.0 * path["w"]
    along, across = np.cos(angle), np.sin(angle)
    names = {"u_x": along * path["u"], "u_y": across * path["u"], "H_x": along * path["H"], "H_y": across * path["H"]}
    names |= {"rot_x": -across * path["rotation"], "rot_y": along * path["rotation"], "rot_z": nothing}
    names |= {"M_x": -across * path["M"], "M_y": along * path["M"], "T": nothing}
    return path[["time", "w", "V", "converged"]].assign(names)


def py_long(springs: xr.DataTree) -> pd.DataFrame:
    """Return every spring of every path in the long format (SI): one row per place and step.

    Families: `py` p by side (outside, inside, net) and component (normal, shear, water, total); `mtheta`
    distributed moment m and vertical reaction t by side; `base` forces on the skirt tip; `lid` forces under
    the lid. A vertical path has `tz` (t by side over w) in place of the first two. Each row has the displacements
    of its place (y, rotation, w); what a family does not have is blank. Springs of an atlas are net and total alone.
    """
    frames = []
    for name, recorded in paths_of(springs).items():
        path = recorded.recorded
        if recorded.is_vertical:
            along = [_side_rows(path, "tz", {"t_N_per_m": "t"})]
        else:
            along = [_py_rows(path), _side_rows(path, "mtheta", {"m_Nm_per_m": "m", "t_N_per_m": "t"})]
        for family in (*along, _end_rows(path, "base"), _end_rows(path, "lid")):
            family.insert(0, "path", name)
            frames.append(family)
    # integer columns and texts stay what they are; a missing column becomes blank cells
    table = pd.concat([frame.reindex(columns=PY_COLUMNS) for frame in frames], ignore_index=True)
    if Springs.of(springs).of_atlas:
        whole = (table["side"] == "net") & ~table["component"].isin(_COMPONENTS[:-1])
        table = table[table["side"].isna() | whole].reset_index(drop=True)
    return table


def with_net(array: Array, axis: int) -> Array:
    """Append the sum along an axis as its last entry."""
    return np.concatenate([array, array.sum(axis=axis, keepdims=True)], axis=axis)


def _py_rows(path: xr.Dataset) -> pd.DataFrame:
    p = path["p_component"].transpose("depth", "side", "component", "step").values
    p = with_net(with_net(p, 1), 2)
    labels = {"side": _SIDES, "component": _COMPONENTS}
    return _rows(path, "py", labels, {"p_N_per_m": p})


def _side_rows(path: xr.Dataset, family: str, names: dict[str, str]) -> pd.DataFrame:
    """Return the rows of variables by side, named by column."""
    sides = {column: path[name].transpose("depth", "side", "step").values for column, name in names.items()}
    return _rows(path, family, {"side": _SIDES}, {column: with_net(each, 1) for column, each in sides.items()})


def _rows(path: xr.Dataset, family: str, labels: dict[str, tuple[str, ...]], values: dict[str, Any]) -> pd.DataFrame:
    """Lay arrays (depth, labels..., step) out as rows, step running fastest."""
    shape = next(iter(values.values())).shape
    index = np.indices(shape).reshape(len(shape), -1)
    depth, step = index[0], index[-1]
    bounds = path["depth_bounds"].values
    data: dict[str, Any] = {
        "family": family,
        "depth_m": path["depth"].values[depth],
        "depth_top_m": bounds[depth, 0],
        "depth_bottom_m": bounds[depth, 1],
    }
    data |= {name: np.array(words)[index[1 + k]] for k, (name, words) in enumerate(labels.items())}
    data |= {"step": step, "y_m": path["y"].transpose("depth", "step").values[depth, step]}
    return pd.DataFrame(data | {name: array.ravel() for name, array in values.items()} | _motion(path, step))


def _motion(path: xr.Dataset, step: Integers) -> dict[str, Any]:
    columns = {"rotation_rad": "rotation", "w_m": "w", "converged": "converged"}
    return {column: path[name].values[step] for column, name in columns.items()}


def _end_rows(path: xr.Dataset, family: str) -> pd.DataFrame:
    """Return the forces on the tip (family base, at the depth of the tip) or on the lid (depth 0)."""
    part = {"base": "tip", "lid": "lid"}[family]
    depth = float(path["depth_bounds"].values[-1, 1]) if family == "base" else 0.0
    step = np.arange(path.sizes["step"])
    data: dict[str, Any] = {"family": family, "depth_m": depth, "depth_top_m": depth, "depth_bottom_m": depth}
    data |= {"step": step, "y_m": displacement_at(path, depth)} | _motion(path, step)
    forces = {"H_N": f"H_{part}", "V_N": f"V_{part}", "M_Nm": f"M_{part}"}
    return pd.DataFrame(data | {column: path[name].values for column, name in forces.items()})


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
    return pd.concat([_wide_path(path) for path in paths_of(springs).values()], ignore_index=True)


def _wide_path(recorded: RecordedPath) -> pd.DataFrame:
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
        "m_Nm_per_m": by_depth(path, "m"),
        "t_N_per_m": by_depth(path, "t"),
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
