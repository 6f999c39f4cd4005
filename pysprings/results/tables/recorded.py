# SPDX-License-Identifier: MIT
"""A table that records paths of a rigid body, as our own `py.csv` does: back to a spring tree."""

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.path_kinds import VERTICAL
from pysprings.core.tables.table import Faults
from pysprings.macro.vertical import build_vertical
from pysprings.results.tables.curves import ROUNDING, net_rows, place_of, slices
from pysprings.springs.path import keeps_direction
from pysprings.springs.springs import Springs
from pysprings.springs.sums import resultants

Grid = dict[str, Array]  # column -> (depth, step)

COMPANIONS = ("mtheta", "base", "lid")
_NUMBERS = {
    "py": ("y_m", "p_N_per_m", "rotation_rad"),
    "mtheta": ("m_Nm_per_m",),
    "base": ("H_N", "M_Nm"),
    "lid": ("H_N", "M_Nm"),
}
_SPARE = ("w_m", "t_N_per_m", "V_N")  # the vertical direction, which a table may leave out
_DOWN = {"tz": ("t_N_per_m", "w_m"), "base": ("V_N", "w_m"), "lid": ("V_N", "w_m")}  # of a vertical path


def is_record(rows: pd.DataFrame) -> bool:
    """Return whether all rows of p have a step and a rotation: then they record the path of a rigid body."""
    py = rows[rows["family"] == "py"]
    return bool(py["step"].notna().all() and py["rotation_rad"].notna().all())


def build_tree(rows: pd.DataFrame, faults: Faults) -> xr.DataTree:
    """Return the spring tree of recorded paths, all of them for calibration; refuse every fault with its line.

    What a table does not hold is the full model's initial stiffness: that of the first steps of all rays stands in
    for it, by least squares. The vertical direction is known where a table has a vertical path (family tz) and t, V and
    w in the rows of the others; else w and V are left out.
    """
    paths = dict[str, xr.Dataset]()
    for name, own in rows[rows["converged"] != 0].groupby("path", sort=False):
        path = _path(own.reset_index(drop=True), faults)
        if path is not None:
            paths[str(name) or "table"] = path
    if not paths and not faults.problems:
        faults.add(place_of(rows), "converged", "no converged step")
    faults.stop()
    length = max(float(path["depth_bounds"].values[-1, 1]) for path in paths.values())
    attrs = {"title": f"table {rows['file'].iloc[0]}", "skirt_length_m": length}
    groups = {f"/paths/{name}": path for name, path in paths.items()}
    tree = xr.DataTree.from_dict({"/": xr.Dataset(attrs=attrs)} | groups)
    stiffness = _first_stiffness(Springs.of(tree))
    tree.dataset = tree.to_dataset().assign(stiffness_initial=_stiffness(stiffness, ["u", "rotation"]))
    down = all("V" in path and path.attrs["down"] for path in paths.values())
    vertical = build_vertical(Springs.of(tree)) if down else None
    if vertical is not None:
        full = np.insert(np.insert(stiffness, 1, 0.0, axis=0), 1, [0.0, vertical.stiffness, 0.0], axis=1)
        known = xr.Dataset({"stiffness_initial": _stiffness(full, ["u", "w", "rotation"])})
        tree.dataset = known.assign_attrs(attrs | {"first_steps": 1})
    return tree


def _stiffness(matrix: Array, dofs: list[str]) -> xr.DataArray:
    return xr.DataArray(matrix, {"dof": dofs, "dof_conjugate": dofs}, ("dof", "dof_conjugate"))


def _path(rows: pd.DataFrame, faults: Faults) -> xr.Dataset | None:
    """Return one path as a dataset; None where it has faults."""
    families = {str(name): part for name, part in rows.groupby("family", sort=False)}
    if "tz" in families:
        return _vertical_path(families, faults)
    if "py" not in families:
        faults.add(place_of(rows), "family", f"path '{rows['path'].iloc[0]}' has no p-y curves")
        return None
    own, known = Faults(), [family for family in COMPANIONS if family in families]
    lost = [family for family in COMPANIONS if family not in families]
    if known and lost:
        message = (
            f"companions {', '.join(known)} without {', '.join(lost)}: give all three (zeros if none), "
            "or p-y curves alone"
        )
        own.add(place_of(rows), "family", message)
    depth, bounds, _ = slices(net_rows(families["py"], own), None, own)
    if np.isnan(bounds).any() and not own.problems:
        own.add(place_of(rows), "depth_top_m", "depth_top_m and depth_bottom_m are needed beside step and rotation_rad")
    grids = {name: _grid(net_rows(families[name], own), name, own) for name in ("py", *known)}
    if own.problems:
        for each in own.problems:
            faults.add((each.file or "", each.line), each.key, each.message)
        return None
    before = len(faults.problems)
    _check_motion(depth, bounds[-1, 1], grids["py"], families, faults)
    _check_sizes(depth.size, grids, families, faults)
    return None if len(faults.problems) > before else _dataset(depth, bounds, grids)


def _vertical_path(families: dict[str, pd.DataFrame], faults: Faults) -> xr.Dataset | None:
    """Return a path of t(z), tip and lid over w as a dataset; None where it has faults."""
    own, place = Faults(), place_of(families["tz"])
    if set(families) != set(_DOWN):
        faults.add(place, "family", "a vertical path has the families tz, base and lid, and no others")
        return None
    depth, bounds, _ = slices(net_rows(families["tz"], own), None, own)
    grids = {name: _grid(net_rows(part, own), name, own, _DOWN[name]) for name, part in families.items()}
    if not own.problems and np.isnan(bounds).any():
        own.add(place, "depth_top_m", "depth_top_m and depth_bottom_m are needed beside step and w_m")
    if not own.problems:
        n, w = grids["tz"]["step"].shape[1], grids["tz"]["w_m"][0]
        for name, grid in grids.items():
            if grid["step"].shape[1] != n or (np.abs(grid["w_m"] - w) > ROUNDING * np.abs(w).max()).any():
                own.add(place_of(families[name]), "w_m", "the caisson is rigid: one value a step, in all families")
        if n < 2:
            own.add(place, "step", "the initial state and at least one more step are needed")
    if own.problems:
        faults.problems += own.problems
        return None
    t, tip, lid = grids["tz"]["t_N_per_m"], grids["base"]["V_N"][0], grids["lid"]["V_N"][0]
    data: dict[str, tuple[tuple[str, ...], Array]] = {name: (("step",), np.zeros(n)) for name in ("u", "rotation")}
    data |= {"w": (("step",), w), "V_tip": (("step",), tip), "V_lid": (("step",), lid)}
    data |= {"V": (("step",), (bounds[:, 1] - bounds[:, 0]) @ t + tip + lid), "converged": (("step",), np.ones(n))}
    data |= {"t": (("depth", "side", "step"), t[:, None, :]), "depth_bounds": (("depth", "bound"), bounds)}
    attrs = {"role": "calibration", "kind": VERTICAL, "arm_m": np.nan, "down": True}
    return xr.Dataset(data, {"depth": depth, "side": ["net"], "step": np.arange(n)}, attrs)


def _grid(part: pd.DataFrame, family: str, faults: Faults, columns: tuple[str, ...] | None = None) -> Grid:
    """Return columns of one family as arrays (depth, step); note blanks, repeated and missing rows."""
    columns = columns or _NUMBERS[family]
    for column in (*columns, "step", "depth_m"):
        for row in part[part[column].isna()].itertuples(index=False):
            faults.at(row, column, "blank")
    twice = part.duplicated(["depth_m", "step"])
    for row in part[twice].itertuples(index=False):
        faults.at(row, "step", f"step {row.step:g} at depth {row.depth_m:g} m stands twice")
    shape = part["depth_m"].nunique(), part["step"].nunique()
    once = part[~twice].sort_values(["depth_m", "step"])
    if len(once) != shape[0] * shape[1] and not faults.problems:
        counts = once.groupby("depth_m")["step"].count()
        for depth in counts.index[counts < shape[1]]:
            place = place_of(once[once["depth_m"] == depth])
            faults.add(place, "step", f"depth {depth:g} m has {counts[depth]} of {shape[1]} steps ({family})")
    if faults.problems:
        return {}
    return {name: once[name].to_numpy(dtype=float).reshape(shape) for name in (*columns, *_SPARE, "line", "step")}


def _motion(depth: Array, py: Grid) -> tuple[Array, Array]:
    """Return u [m] and rotation [rad] by step, of a rigid body through the first ring."""
    rotation = py["rotation_rad"][0]
    return (py["y_m"] + rotation * depth[:, None])[0], rotation


def _check_motion(depth: Array, length: float, py: Grid, families: dict[str, pd.DataFrame], faults: Faults) -> None:
    """Add a fault for each row of p that does not move with the rigid body; depth and length in m."""
    u, rotation = _motion(depth, py)
    size = max(np.abs(py["y_m"]).max(), np.abs(rotation).max() * depth[-1], 1e-300)
    wrong = np.abs(py["y_m"] - u + rotation * depth[:, None]) > ROUNDING * size
    wrong |= np.abs(py["rotation_rad"] - rotation) * length > ROUNDING * size
    text = "is not u - rotation_rad*depth_m with one u and rotation a step; for free curves leave rotation_rad out"
    if wrong.any() and not (np.abs(np.ptp(py["y_m"] - rotation * depth[:, None], axis=0)) > ROUNDING * size).any():
        text = (
            "is u + rotation_rad*depth_m, as in earlier versions: turn the signs of rotation_rad, m_Nm_per_m and M_Nm"
        )
    file = str(families["py"]["file"].iloc[0])
    for line in py["line"][wrong]:
        faults.add((file, int(line)), "y_m", text)
    if py["step"].shape[1] < 2:
        faults.add((file, int(py["line"][0, 0])), "step", "the initial state and at least one more step are needed")


def _check_sizes(n_depths: int, grids: dict[str, Grid], families: dict[str, pd.DataFrame], faults: Faults) -> None:
    """Add a fault for each family whose depths or steps are not those of p."""
    n = grids["py"]["step"].shape[1]
    for family, grid in grids.items():
        rows = n_depths if family in ("py", "mtheta") else 1
        if grid["step"].shape != (rows, n):
            text = f"{family} does not have the {rows} depths and {n} steps of p"
            faults.add(place_of(families[family]), "family", text)


def _dataset(depth: Array, bounds: Array, grids: dict[str, Grid]) -> xr.Dataset:
    """Return the path of checked grids (depth, step); ``down``: the table has the vertical direction."""
    (u, rotation), py = _motion(depth, grids["py"]), grids["py"]
    n = u.size
    data: dict[str, tuple[tuple[str, ...], Array]] = {
        "u": (("step",), u),
        "rotation": (("step",), rotation),
        "depth_bounds": (("depth", "bound"), bounds),
        "p": (("depth", "step"), py["p_N_per_m"]),
        "converged": (("step",), np.ones(n)),
    }
    down = False
    if "mtheta" in grids:
        data |= {"m": (("depth", "side", "step"), grids["mtheta"]["m_Nm_per_m"][:, None, :])}
        for family, part in (("base", "tip"), ("lid", "lid")):
            data |= {f"H_{part}": (("step",), grids[family]["H_N"][0])}
            data |= {f"M_{part}": (("step",), grids[family]["M_Nm"][0])}
        vertical, down = _vertical(bounds, grids)
        data |= vertical
    attrs = {"role": "calibration", "kind": "table", "arm_m": np.nan, "down": down}
    attrs["straight"] = keeps_direction(u, rotation * bounds[-1, 1])
    coords = {"depth": depth, "side": ["net"], "step": np.arange(n)}
    return xr.Dataset(data, coords, attrs)


def _vertical(bounds: Array, grids: dict[str, Grid]) -> tuple[dict[str, tuple[tuple[str, ...], Array]], bool]:
    """Return the vertical motion and reactions, and whether the table has them; missing columns count as zero."""
    w, tip, lid = grids["py"]["w_m"][0], grids["base"]["V_N"][0], grids["lid"]["V_N"][0]
    t = grids["mtheta"]["t_N_per_m"]
    down = all(bool(np.isfinite(values).all()) for values in (w, tip, lid, t))
    if not down:
        w, tip, lid, t = (np.zeros(values.shape) for values in (w, tip, lid, t))
    V = (bounds[:, 1] - bounds[:, 0]) @ t + tip + lid
    by_step = {"w": w, "V": V, "V_tip": tip, "V_lid": lid}
    steps = {name: (("step",), values) for name, values in by_step.items()}
    return {**steps, "t": (("depth", "side", "step"), t[:, None, :])}, down


def _first_stiffness(springs: Springs) -> Array:
    """Return the stiffness (2, 2) that fits the first steps of all rays best; zero for one ray or p alone."""
    first, loads = [], []
    for name in springs.rays:
        path = springs.paths[name]
        if "m" not in path:
            return np.zeros((2, 2))
        sums = resultants(path.dataset)
        size = np.hypot(path.u[1], path.rotation[1])
        first.append(np.array([path.u[1], path.rotation[1]]) / size)
        loads.append(np.array([sums[load][1] - sums[load][0] for load in ("H", "M")]) / size)
    if len(first) < 2:
        return np.zeros((2, 2))
    return np.linalg.lstsq(np.array(first), np.array(loads), rcond=None)[0].T
