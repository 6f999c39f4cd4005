# SPDX-License-Identifier: MIT
"""The output of `pysprings predict`: states, marks, stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.cli.support import print_table, refuse, to_stderr
from pysprings.core.errors import printable
from pysprings.core.files.storage import replacing, write_text
from pysprings.core.text import json_text
from pysprings.core.words import RANGE_END

if TYPE_CHECKING:
    import xarray as xr

ROUNDING = 1e-9  # loads below this share of the largest are rounding errors of zero

# columns of a prediction: name, unit, factor from SI
COLUMNS = (
    ("u", "mm", 1e3),
    ("w", "mm", 1e3),
    ("rotation", "deg", 180.0 / math.pi),
    ("H", "kN", 1e-3),
    ("V", "kN", 1e-3),
    ("M", "kN m", 1e-3),
)


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
        with replacing(out) as temporary:
            texts = {name: "; ".join(states.attrs.get(name, ())) for name in lists}
            states.assign_attrs(texts).to_netcdf(temporary, engine="netcdf4")


def _csv(states: xr.Dataset) -> str:
    """Return the states as a table: one a line, the unit behind each name; attributes in front, behind #."""
    import pandas as pd

    names = [str(name) for name in states.data_vars if states[name].dims == ("step",)]
    units = {"m": "_m", "radian": "_rad", "N": "_N", "N m": "_Nm"}
    columns = {f"{name}{units.get(str(states[name].attrs.get('units')), '')}": states[name].values for name in names}
    heads = [f"# {name}: {value}" for name, value in states.attrs.items() if not isinstance(value, list)]
    heads += [f"# {name}: {text}" for name in ("warnings", "remarks") for text in states.attrs.get(name, ())]
    return "\n".join([*map(printable, heads), pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")])


def print_prediction(states: xr.Dataset) -> None:
    """Print states (dimension step) as a table in mm, deg, kN and kN m, with their marks."""
    columns = [column for column in COLUMNS if column[0] in states]
    headers = [f"{name} [{unit}]" for name, unit, _ in columns]
    largest = max(abs(float(value)) for name in ("H", "V", "M") if name in states for value in states[name].values)
    noise = {name: ROUNDING * largest if name in ("H", "V", "M") else 0.0 for name, *_ in columns}
    cells = [[_figures(value, factor, noise[name]) for value in states[name].values] for name, _, factor in columns]
    if any(marks := [_marks(states, step) for step in range(states.sizes["step"])]):
        headers, cells = [*headers, "marks"], [*cells, marks]
    left = [head == "marks" for head in headers]
    print_table(headers, [list(row) for row in zip(*cells, strict=True)], left)
    if text := deviations(states):
        print(text)
    if states.attrs.get("question") != "sequence":
        for text in filter(None, (capacity(states), vertical_capacity(states))):
            print(text)


def deviations(states: xr.Dataset) -> str:
    """Return a line with the standard deviations of the last state on springs of an atlas; empty on other springs."""
    parts = []
    for name, unit, factor in COLUMNS:
        known = f"{name}_deviation"
        if known in states and (value := float(states[known].values[-1])) > 0.0:
            size = abs(float(states[name].values[-1]))
            share = f" ({100.0 * value / size:.2g} %)" if size > 0.0 else ""
            parts.append(f"{name} {factor * value:.3g} {unit}{share}")
    return f"standard deviation of the last state: {', '.join(parts)}" if parts else ""


def capacity(states: xr.Dataset) -> str:
    """Return a line on the largest load that is known in the direction of the last state; empty without load."""
    attrs = states.attrs
    if "capacity_kind" not in attrs:
        return ""
    loads = [float(attrs[key]) for key in ("capacity_H_N", "capacity_M_Nm")]
    force, moment = (0.0 if abs(load) <= ROUNDING * max(map(abs, loads)) else 1e-3 * load for load in loads)
    used = 100.0 * float(states["utilisation"].values[-1])
    known = "largest load known" if attrs["capacity_kind"] == RANGE_END else "capacity"
    return (
        f"{known} in this direction: H = {force:.5g} kN with M = {moment:.5g} kN m, {used:.4g} % of it used "
        f"({attrs['capacity_kind']}: {attrs['capacity_from']})"
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
        f"{known}: V = {1e-3 * float(attrs['capacity_V_N']):.5g} kN, {used:.4g} % of it used "
        f"({attrs['capacity_V_kind']}: {attrs['capacity_V_from']})"
    )


MARKS = ("beyond_end", "extrapolated", "off_path", "turned_back", "off_load", "off_rate", "past_peak")


def _marks(states: xr.Dataset, step: int) -> str:
    """Return the marks of one state that are set, by name."""
    return ", ".join(name for name in MARKS if name in states and states[name].values[step])


def remarks_of(states: xr.Dataset) -> str:
    """Return the remarks on the springs of an answer, one on each line."""
    return "\n".join(f"note: {remark}" for remark in states.attrs.get("remarks", ()))


def _figures(value: float, factor: float, noise: float) -> str:
    """Return a value in its unit with five figures; 0 for rounding errors."""
    return "0" if abs(value) <= noise else f"{value * factor:.5g}"


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
            document[key] = _meaning(six) | {"torsion": six.attrs["torsion"], "matrix": six.values}
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
        print_table(["", *(f"per {name}" for name in dofs)], _lines(given.isel(step=-1), dofs))
    else:
        n = len(dofs)
        coupled = [(i, j) for i in range(n) for j in range(n) if i == j or "w" not in (dofs[i], dofs[j])]
        lines = [
            [str(step), *(f"{matrix[i, j] * 1e-6:.5g}" for i, j in coupled)] for step, matrix in enumerate(given.values)
        ]
        print_table(["step", *(f"{dofs[i]},{dofs[j]}" for i, j in coupled)], lines)
    if six is None:
        to_stderr("note: no 6x6 stiffness: a table without a vertical path has no vertical stiffness")
        return
    for matrix in (matrices.six_at_state, six):
        if matrix is not None:
            print(f"\n{matrix.attrs['long_name']}, 6x6 (MN, m, rad):")
            names = [str(name) for name in matrix["dof"].values]
            print_table(["", *(f"per {name}" for name in names)], _lines(matrix, names))
    to_stderr(f"note: {six.attrs['torsion']}")


def _lines(matrix: xr.DataArray, names: list[str]) -> list[list[str]]:
    return [
        [name, *(f"{value * 1e-6 + 0.0:.5g}" for value in row)] for name, row in zip(names, matrix.values, strict=True)
    ]
