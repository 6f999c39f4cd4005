# SPDX-License-Identifier: MIT
"""The output of `pysprings predict`: states, marks, stiffness."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings.cli.support import print_table, refuse, to_stderr
from pysprings.core.columns import Column, Table, filled
from pysprings.core.errors import printable
from pysprings.core.process import uninterrupted
from pysprings.core.storage import replacing, write_text
from pysprings.core.text import json_text, number, percent
from pysprings.core.words import NOT_KNOWN, RANGE_END, SOLVED

ROUNDING = 1e-9  # loads below this share of the largest are rounding errors of zero

MARKS = ("beyond_end", "extrapolated", "off_path", "turned_back", "off_load", "off_rate", "past_peak", "unbounded",
         "linear_twist", "torsion_apart", "unchecked")  # fmt: skip
COLUMNS = (
    Column("u [mm]", "u", 5, 1e3),
    Column("w [mm]", "w", 5, 1e3),
    Column("rotation [deg]", "rotation", 5, 180.0 / math.pi),
    Column("H [kN]", "H", 5, 1e-3),
    Column("V [kN]", "V", 5, 1e-3),
    Column("M [kN m]", "M", 5, 1e-3),
    Column("direction [deg]", "direction", 5, 180.0 / math.pi),
    Column("T [kN m]", "T", 5, 1e-3),
    Column("twist [mrad]", "rot_z", 5, 1e3),
    Column("marks", lambda row: ", ".join(name for name in MARKS if row.get(name)), words=True),
)
# of a sequence in six degrees of freedom, which has no u
SPACE_COLUMNS = (
    *(Column(f"u_{axis} [mm]", f"u_{axis}", 4, 1e3) for axis in "xy"),
    Column("w [mm]", "w", 4, 1e3),
    *(Column(f"rot_{axis} [mrad]", f"rot_{axis}", 4, 1e3) for axis in "xyz"),
    *(Column(f"H_{axis} [kN]", f"H_{axis}", 4, 1e-3) for axis in "xy"),
    *(Column(f"M_{axis} [kN m]", f"M_{axis}", 4, 1e-3) for axis in "xy"),
    Column("T [kN m]", "T", 4, 1e-3),
    COLUMNS[-1],
)
LOADS = ("H", "V", "M", "H_x", "H_y", "M_x", "M_y", "T")


def prediction(states: xr.Dataset) -> dict[str, Any]:
    """Return the document that `pysprings predict --json` prints, in SI."""
    names = [name for name in states.data_vars if states[name].dims == ("step",)]
    units = {name: states[name].attrs.get("units", "1") for name in names}
    rows = [{name: states[name].values[step] for name in names} for step in range(states.sizes["step"])]
    return {"attributes": states.attrs, "units": units, "states": rows}


def write(states: xr.Dataset, matrices: dict[str, Any], out: Path) -> None:
    """Write an answer into a file whose ending chooses the form: csv, json or nc; SI."""
    ending = out.suffix.lower()
    if out.is_dir() or ending not in (".csv", ".json", ".nc"):
        refuse("--out", "name a file that ends in csv, json or nc", out)
    if ending == ".json":
        write_text(json_text(prediction(states) | matrices, indent=2) + "\n", out)
    elif ending == ".csv":
        write_text(_csv(states), out)
    else:
        lists = ("warnings", "remarks", "refusals", "beyond_range")
        with uninterrupted(), replacing(out) as temporary:
            texts = {name: "; ".join(states.attrs.get(name, ())) for name in lists}
            states.assign_attrs(texts).to_netcdf(temporary, engine="netcdf4")


def _csv(states: xr.Dataset) -> str:
    """Return the states as a table: one a line, the unit behind each name; attributes in front, behind #."""
    import pandas as pd

    names = [str(name) for name in states.data_vars if states[name].dims == ("step",)]
    units = {"m": "_m", "radian": "_rad", "N": "_N", "N m": "_Nm", "s": "_s"}
    columns = {f"{name}{units.get(str(states[name].attrs.get('units')), '')}": states[name].values for name in names}
    heads = [f"# {name}: {value}" for name, value in states.attrs.items() if not isinstance(value, list)]
    heads += [f"# {name}: {text}" for name in ("warnings", "remarks") for text in states.attrs.get(name, ())]
    return "\n".join([*map(printable, heads), pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")])


def print_prediction(states: xr.Dataset) -> None:
    """Print states (dimension step) as a table in mm, deg, kN and kN m, with their marks; rounding errors are 0."""
    rows = prediction(states)["states"]
    largest = max(abs(row[name]) for name in LOADS if name in states for row in rows)
    noise = dict.fromkeys(LOADS, ROUNDING * largest) | {"V": SOLVED * largest}
    clean = [row | {name: 0.0 for name in LOADS if name in row and abs(row[name]) <= noise[name]} for row in rows]
    print_table(Table.of(filled(COLUMNS if "u" in states else SPACE_COLUMNS, clean), clean))
    for text in sentences(states):
        print(text)


def sentences(states: xr.Dataset) -> list[str]:
    """Return lines on the last state: deviations, and but for a sequence the error of the mesh and largest loads."""
    texts = [deviations(states)]
    if states.attrs.get("question") != "sequence":
        texts += [mesh_error(states), capacity(states), vertical_capacity(states)]
    return [text for text in texts if text]


def deviations(states: xr.Dataset) -> str:
    """Return a line with the standard deviations of the last state on springs of an atlas; empty on other springs."""
    parts = []
    for column in COLUMNS:
        if (known := f"{column.source}_deviation") not in states:
            continue
        value, size = (abs(float(states[each].values[-1])) for each in (known, column.source))
        name, unit = column.head.rstrip("]").split(" [")
        if value > ROUNDING * size > 0.0:
            own = f"{column.factor * value:.3g} {unit} ({percent(100.0 * value / size)})"
            parts.append(f"{name} {own if np.isfinite(value) else 'without a bound'}")
    return f"standard deviation of the last state: {', '.join(parts)}" if parts else ""


def mesh_error(states: xr.Dataset) -> str:
    """Return a line with the error of the mesh that is estimated of the last load, and of a motion under that load.

    The latter is by the tangent: near the largest load it is a multiple of the former. Empty where none is known.
    """
    last = states.isel(step=-1)
    error = float(last.get("mesh_error_pct", np.nan))
    if not error > 0.0:
        return ""
    text = f"error of the mesh, estimated: load {percent(error)}"
    if states.attrs.get("control") != "load" or "stiffness" not in last:
        return text
    motions, parts = ["u", "rotation"], []
    tangent = last["stiffness"].sel(dof=motions, dof_conjugate=motions).values
    changes = np.linalg.lstsq(tangent, [float(last["H"]), float(last["M"])])[0]
    for name, change in zip(motions, np.abs(changes), strict=True):
        if (own := abs(float(last[name]))) > 0.0:
            parts.append(f"{name} {percent(error * change / own)}")
    return f"{text}; under that load {', '.join(parts)}, by the tangent" if parts else text


def capacity(states: xr.Dataset) -> str:
    """Return a line on the largest load that is known in the direction of the last state; empty without load."""
    attrs = states.attrs
    if "capacity_kind" not in attrs:
        return ""
    if attrs["capacity_kind"] == NOT_KNOWN:
        return f"capacity in this direction: {NOT_KNOWN} ({attrs['capacity_from']})"
    loads = [float(attrs[key]) for key in ("capacity_H_N", "capacity_M_Nm")]
    force, moment = (0.0 if abs(load) <= ROUNDING * max(map(abs, loads)) else 1e-3 * load for load in loads)
    used = 100.0 * float(states["utilisation"].values[-1])
    known = "largest load known" if attrs["capacity_kind"] == RANGE_END else "capacity"
    return (
        f"{known} in this direction: H = {number(force, 5)} kN with M = {number(moment, 5)} kN m, {used:.4g} % of it "
        f"used ({attrs['capacity_kind']}: {attrs['capacity_from']})"
    )


def vertical_capacity(states: xr.Dataset) -> str:
    """Return a line on the largest vertical load that is known; empty without V or vertical springs."""
    attrs = states.attrs
    V = float(states["V"].values[-1]) if "V" in states else 0.0
    if "capacity_V_kind" not in attrs or abs(V) <= ROUNDING * abs(float(attrs["capacity_V_N"])):
        return ""
    used = 100.0 * float(states["utilisation_V"].values[-1])
    known = "largest vertical load known" if attrs["capacity_V_kind"] == RANGE_END else "vertical capacity"
    return (
        f"{known}: V = {number(1e-3 * float(attrs['capacity_V_N']), 5)} kN, {used:.4g} % of it used "
        f"({attrs['capacity_V_kind']}: {attrs['capacity_V_from']})"
    )


@dataclass(frozen=True, slots=True)
class Matrices:
    """Stiffness of the springs at states (step, 3, 3) and at the one state (6, 6); the initial one (6, 6)."""

    at_states: xr.DataArray
    six_at_state: xr.DataArray | None
    six: xr.DataArray | None


def stiffness(matrices: Matrices) -> dict[str, Any]:
    """Return stiffnesses with their meaning; SI."""
    given = matrices.at_states
    document: dict[str, Any] = {"stiffness": _meaning(given) | {"matrices": given.values}}
    for key, six in (("stiffness_6x6_at_state", matrices.six_at_state), ("stiffness_6x6", matrices.six)):
        if six is not None:
            notes = {name: six.attrs[name] for name in ("torsion", "vertical") if name in six.attrs}
            document[key] = _meaning(six) | notes | {"matrix": six.values}
    return document


def _meaning(matrix: xr.DataArray) -> dict[str, Any]:
    return {"dofs": matrix["dof"].values, **{name: matrix.attrs[name] for name in ("long_name", "comment")}}


MOST_MATRICES = 1  # more states are printed as one line each


def print_stiffness(matrices: Matrices) -> None:
    """Print the springs' stiffness at one state as matrices, at several as a line each; then the initial 6x6 matrix."""
    given, six = matrices.at_states, matrices.six
    dofs = [str(name) for name in given["dof"].values]
    print(f"\n{given.attrs['long_name']} (MN, m, rad):")
    if given.sizes["step"] <= MOST_MATRICES:
        _print_matrix(given.isel(step=-1))
    else:
        n = len(dofs)
        coupled = [(i, j) for i in range(n) for j in range(n) if i == j or "w" not in (dofs[i], dofs[j])]
        lines = [
            [str(step), *(number(float(matrix[i, j]) * 1e-6, 5) for i, j in coupled)]
            for step, matrix in enumerate(given.values)
        ]
        print_table(Table("", ["step", *(f"{dofs[i]},{dofs[j]}" for i, j in coupled)], lines))
    if six is None:
        to_stderr("note: no 6x6 stiffness: a table without a vertical path has no vertical stiffness")
        return
    for matrix in (matrices.six_at_state, six):
        if matrix is not None:
            print(f"\n{matrix.attrs['long_name']}, 6x6 (MN, m, rad):")
            _print_matrix(matrix)
    to_stderr(f"note: {six.attrs['torsion']}")
    if matrices.six_at_state is not None:
        to_stderr(f"note: {matrices.six_at_state.attrs['vertical']}")


def _print_matrix(matrix: xr.DataArray) -> None:
    names = [str(name) for name in matrix["dof"].values]
    entries = [Column(f"per {name}", name, 5, 1e-6) for name in names]
    rows = [{"": name, **dict(zip(names, line, strict=True))} for name, line in zip(names, matrix.values, strict=True)]
    print_table(Table.of([Column("", "", words=True), *entries], rows))
