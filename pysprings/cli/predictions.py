# SPDX-License-Identifier: MIT
"""The output of `pysprings predict`: states, marks, stiffness."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from pysprings.cli.support import print_table, to_stderr

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


MARKS = ("beyond_end", "extrapolated", "off_path", "turned_back", "off_load")


def _marks(states: xr.Dataset, step: int) -> str:
    """Return the marks of one state that are set, by name."""
    return ", ".join(name for name in MARKS if name in states and states[name].values[step])


def remarks_of(states: xr.Dataset) -> str:
    """Return the remarks on the springs of an answer, one on each line."""
    return "\n".join(f"note: {remark}" for remark in states.attrs.get("remarks", ()))


def _figures(value: float, factor: float, noise: float) -> str:
    """Return a value in its unit with five figures; 0 for rounding errors."""
    return "0" if abs(value) <= noise else f"{value * factor:.5g}"


def stiffness(states: xr.Dataset, six: xr.DataArray | None) -> dict[str, Any]:
    """Return the tangents by state and the initial 6x6 matrix with their meaning; SI."""
    tangent = states["stiffness"]
    meaning = {"dofs": tangent["dof"].values, "comment": tangent.attrs["comment"], "matrices": tangent.values}
    if six is None:
        return {"stiffness": meaning}
    attrs = {name: six.attrs[name] for name in ("long_name", "comment", "torsion")}
    return {"stiffness": meaning, "stiffness_6x6": {"dofs": six["dof"].values, **attrs, "matrix": six.values}}


MOST_MATRICES = 1  # more states are printed as one line each


def print_stiffness(states: xr.Dataset, six: xr.DataArray | None) -> None:
    """Print the springs' tangent at one state as a matrix, at several as a line each; then the initial 6x6 matrix."""
    tangent = states["stiffness"]
    dofs = [str(name) for name in tangent["dof"].values]
    print("\nstiffness of the springs at the state, at mudline (MN, m, rad):")
    if tangent.sizes["step"] <= MOST_MATRICES:
        print_table(["", *(f"per {name}" for name in dofs)], _lines(tangent.isel(step=-1), dofs))
    else:
        n = len(dofs)
        coupled = [(i, j) for i in range(n) for j in range(n) if i == j or "w" not in (dofs[i], dofs[j])]
        lines = [
            [str(step), *(f"{matrix[i, j] * 1e-6:.5g}" for i, j in coupled)]
            for step, matrix in enumerate(tangent.values)
        ]
        print_table(["step", *(f"{dofs[i]},{dofs[j]}" for i, j in coupled)], lines)
    if six is None:
        to_stderr("note: no 6x6 stiffness: a table without a vertical path has no vertical stiffness")
        return
    print(f"\n{six.attrs['long_name']}, 6x6 (MN, m, rad):")
    print_table(["", *(f"per {name}" for name in six["dof"].values)], _lines(six, [str(x) for x in six["dof"].values]))
    to_stderr(f"note: {six.attrs['torsion']}")


def _lines(matrix: xr.DataArray, names: list[str]) -> list[list[str]]:
    return [
        [name, *(f"{value * 1e-6 + 0.0:.5g}" for value in row)] for name, row in zip(names, matrix.values, strict=True)
    ]
