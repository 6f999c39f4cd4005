# SPDX-License-Identifier: MIT
"""Answers to load cases for people: columns of terminal, workbook, page, and report of their run; tables of springs."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.columns import Column, Table, filled
from pysprings.core.path_kinds import HELD_BACK, beam_order
from pysprings.core.text import number
from pysprings.results.layout import LOAD_CASES
from pysprings.springs.path import RecordedPath
from pysprings.springs.springs import Springs
from pysprings.springs.sums import by_depth
from pysprings.springs.tip_zone import on_slices

_COLUMNS = ("depth [m]", "slice [m]", "y [mm]", "p outside [kN/m]", "p inside [kN/m]", "p net [kN/m]",
            "p at half of y [kN/m]", "m [kN m/m]")  # fmt: skip
_NOTE = (
    "At the last converged step; soil reactions, positive when they oppose a positive displacement. y: displacement of "
    "the caisson's mean fibre; p: lateral, m: moment of the vertical shear, both per metre of depth; normal stress, "
    "shear and water together. The last fifth of the skirt is one slice: p of thinner ones depends on the mesh. Every "
    "path and step is in springs.xlsx and py.csv on the same slices, and on those of the mesh in springs.nc. "
)


def spring_tables(springs: xr.DataTree | None, comparison: pd.DataFrame | None = None) -> list[Table]:
    """Return the table of the calibration path that a beam program would take (`beam_order`), and what it misses.

    None without springs, or without a lateral calibration path.
    """
    if springs is None:
        return []
    at_rest = float(springs.attrs.get("vertical_load_N", 0.0))
    paths = Springs.of(springs).paths.values()
    lateral = [path for path in paths if path.calibrates and not path.is_vertical]

    def use(path: RecordedPath) -> tuple[float, ...]:
        return *beam_order(path.attrs), round(abs(path.load - at_rest), -3)

    return [_table(path.name, on_slices(path.dataset), comparison) for path in sorted(lateral, key=use)[:1]]


def _table(name: str, path: xr.Dataset, comparison: pd.DataFrame | None) -> Table:
    p, m, y = by_depth(path, "p") * 1e-3, by_depth(path, "m") * 1e-3, path["y"].transpose("depth", "step").values * 1e3
    sides = path["p_component"].sum("component").transpose("side", "depth", "step").values * 1e-3
    order = [str(side) for side in path["side"].values]
    rows = [
        (
            number(float(depth)),
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
    title = f"Path {name}: {path.attrs['kind']}, {path.attrs['role']}"
    return Table(title, _COLUMNS, rows, _NOTE + _missed(name, path, comparison), wide=True)


def _missed(name: str, path: xr.Dataset, comparison: pd.DataFrame | None) -> str:
    """Return sentences on the share of H that p carries, and on the largest error of the p-y curves of a path alone.

    It is that on paths held back where these have one, else on all.
    """
    carried = float(by_depth(path, "p")[:, -1] @ np.diff(path["depth_bounds"].values, axis=1)[:, 0])
    load = float(path["H"].values[-1])
    text = f"p carries {100.0 * carried / load:.0f} % of H of this path, tip and lid the rest. " if load else ""
    if comparison is None or "H_error_max_pct" not in comparison:
        return text
    own = comparison["springs_from"] == name
    alone = comparison[own & (comparison["springs"] == "py") & comparison["H_error_max_pct"].notna()]
    if alone.empty:
        return text
    held = alone[alone["role"] == HELD_BACK]
    alone = held if len(held) else alone
    worst = alone.iloc[int(alone["H_error_max_pct"].abs().to_numpy().argmax())]
    return (
        f"{text}The curves hold for this path: its p-y curves alone are off the load of path {worst['path']} by "
        f"{worst['H_error_max_pct']:+.0f} %."
    )


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
    note = "At the lid centre. `pysprings predict OUT --H 1kN --stiffness` gives 6 x 6, and other reference points."
    return Table("Initial stiffness of the full model", heads, rows, note)


OK = "ok"  # verdict of a case with an answer that the springs support, within its tolerance
KN, MN, MM = 1e-3, 1e-6, 1e3

COLUMNS = (
    Column("case", "name", words=True),
    Column("estimate", "estimate", words=True),
    Column("limit state", "limit_state", words=True),
    Column("direction [deg]", "direction_deg", brief=False),
    Column("H [kN]", "H_N", factor=KN),
    Column("M [kN m]", "M_Nm", factor=KN),
    Column("V [kN]", "V_N", factor=KN),
    Column("nearest V of springs [kN]", "V_springs_N", factor=KN, brief=False),
    Column("springs at [mm/s]", "rate_m_per_s", factor=MM, brief=False),
    Column("u [mm]", "u_m", factor=MM),
    Column("deviation of u [mm]", "u_deviation_m", factor=MM, brief=False),
    Column("w [mm]", "w_m", factor=MM, brief=False),
    Column("rotation [deg]", "rotation_rad", factor=math.degrees(1.0)),
    Column("deviation of rotation [deg]", "rotation_deviation_rad", factor=math.degrees(1.0)),
    Column("u of the frame [mm]", "group_u_m", factor=MM, brief=False),
    Column("w of the frame [mm]", "group_w_m", factor=MM, brief=False),
    Column("rotation of the frame [deg]", "group_rotation_rad", factor=math.degrees(1.0), brief=False),
    Column("roll of the frame [deg]", "group_roll_rad", factor=math.degrees(1.0), brief=False),
    Column("tilt of the frame [deg]", "group_tilt_deg"),
    Column("tilt tolerated [deg]", "tilt_limit_deg", brief=False),
    Column("tilt used", "tilt_used", form=3),
    Column("secant H/u [MN/m]", "secant_H_u_N_per_m", factor=MN, brief=False),
    Column("secant M/rotation [MN m/rad]", "secant_M_rotation_Nm", factor=MN, brief=False),
    Column("tangent K uu [MN/m]", "tangent_u_u_N_per_m", factor=MN, brief=False),
    Column("tangent K u,rotation [MN/rad]", "tangent_u_rotation_N", factor=MN, brief=False),
    Column("tangent K rotation,u [MN m/m]", "tangent_rotation_u_N", factor=MN, brief=False),
    Column("tangent K rotation,rotation [MN m/rad]", "tangent_rotation_rotation_Nm", factor=MN, brief=False),
    Column("tangent K ww under V alone [MN/m]", "tangent_w_w_N_per_m", factor=MN, brief=False),
    Column("utilisation", "utilisation", form=3),
    Column("V used", "utilisation_V", form=3),
    Column("capacity V [kN]", "capacity_V_N", factor=KN, brief=False),
    Column("of", "capacity_V_kind", brief=False, words=True),
    Column("capacity H [kN]", "H_capacity_N", factor=KN, brief=False),
    Column("capacity M [kN m]", "M_capacity_Nm", factor=KN, brief=False),
    Column("of", "capacity_kind", words=True),
    Column("range used", "range_used", brief=False, form=3),
    Column("mesh error [%]", "mesh_error_pct", brief=False, form=3),
    Column("across [kN m]", "across_Nm", factor=KN),
    Column("torsion [kN m]", "torsion_Nm", factor=KN),
    Column("u_x [mm]", "u_x_m", factor=MM, brief=False),
    Column("u_y [mm]", "u_y_m", factor=MM, brief=False),
    Column("rot_x [mrad]", "rot_x_rad", factor=1e3, brief=False),
    Column("rot_y [mrad]", "rot_y_rad", factor=1e3, brief=False),
    Column("twist [mrad]", "twist_rad", factor=1e3, brief=False),
    Column("u bound [mm]", "u_bound_m", factor=MM, brief=False),
    Column("rotation bound [deg]", "rotation_bound_rad", factor=math.degrees(1.0), brief=False),
    Column("utilisation bound", "utilisation_bound", form=3),
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
    "the radius added to H, none where T governs; of a V beyond all springs, loads that fall in proportion to the "
    "largest V. The twist is T over the torsional stiffness at rest, the least one, or that of springs in "
    "space; of these u and rotation are sizes of vectors, and the utilisation has a bound alone. Of a group "
    "a row is a caisson, and the tilt that counts is that of the rigid frame; its twist, bending of caissons "
    "across the plane of H and interaction through the soil are left out."
)


_GOVERN = {
    "tilt_used": "tilt used", "tilt_bound": "bound of the tilt used", "utilisation": "utilisation",
    "utilisation_bound": "bound of the utilisation", "utilisation_V": "V used",
}  # fmt: skip


def closing(table: pd.DataFrame) -> str:
    """Return the counts of the verdicts and the cases that govern.

    A case without an answer does by its V, and where it is beyond.
    """
    counts = table["verdict"].value_counts()
    parts = [f"{n:,} {verdict}" for verdict, n in counts.items()]
    what = "row" if "group_u_m" in table else "case"
    text = f"{len(table):,} {what}{'' if len(table) == 1 else 's'}: {', '.join(parts)}"
    if what == "case" and {"rotation_bound_rad", "tilt_limit_deg"} <= set(table):  # a group tilts as its frame
        table = table.assign(tilt_bound=np.degrees(table["rotation_bound_rad"]) / table["tilt_limit_deg"])
    for column, words in _GOVERN.items():
        if column not in table:
            continue
        counts_always = (table[column] > 1.0) | (column == "utilisation_V")
        known = table[table[column].notna() & ((table["answered"] == 1) | counts_always)]
        if len(known):
            worst = known.sort_values([column, "name"]).iloc[-1]
            text += f"; largest {words} {worst[column]:.3g} in '{worst['name']}'"
            text += ", of cases that every estimate answers" * bool("estimate" in table and table[column].isna().any())
    return text


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
