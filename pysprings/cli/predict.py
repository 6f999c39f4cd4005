# SPDX-License-Identifier: MIT
"""The command `pysprings predict`: which question is asked, its answer, and how it is printed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.cli.support import print_table, refuse, say

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.macro.sets import AnySprings

Given = Mapping[str, float | None]

MISSING = 'missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve'


def answer(
    springs: AnySprings,
    given: Given,
    sequence: Path | None,
    kind: str | None,
    path: str | None,
    points: int,
    strict: bool,
) -> xr.Dataset:
    """Return the states asked for: the last one of a load or motion, all of a curve or sequence."""
    from pysprings.macro import predict

    common: dict[str, Any] = {"springs_kind": kind, "path": path, "strict": strict}
    height, down, limit = given["--arm"], given["--V"], given["--u-max"]
    if sequence is not None:
        from pysprings.results.tables.sequence import read_sequence

        wanted = read_sequence(sequence)
        V = wanted.V if wanted.V is not None else down
        states = predict.sequence(springs, wanted.targets, control=wanted.control, arm=wanted.arm, V=V, **common)
    elif limit is not None:
        states = predict.curve(springs, u_max=limit, arm=height or 0.0, n=points, V=down, **common)
    elif given["--u"] is not None or given["--rotation"] is not None:
        common |= {"u": given["--u"], "rotation": given["--rotation"]}
        states = predict.impose(springs, arm=height or 0.0, V=down, **common).isel(step=[-1])
    else:
        states = predict.predict(springs, H=given["--H"], arm=height, M=given["--M"], V=down, **common).isel(step=[-1])
    return states


def at_rate(springs: AnySprings, rate: float | None) -> AnySprings:
    """Return the springs at the rate [m/s] asked for; as they are without one."""
    if rate is None:
        return springs
    from pysprings.macro.user_curves import CurveSprings
    from pysprings.springs.springs import Springs

    if isinstance(springs, CurveSprings):
        refuse("--rate", "a table has no rates")
    if rate <= 0.0:
        refuse("--rate", f"{1e3 * rate:g} mm/s is not positive")
    return Springs.of(springs).at_rate(rate)


def initial_six(springs: AnySprings) -> xr.DataArray | None:
    """Return the initial stiffness 6x6; None where springs from a table do not know it."""
    from pysprings.macro.stiffness_six import has_six, stiffness_six

    return stiffness_six(springs) if has_six(springs) else None


def refuse_contradictions(given: Given, sequence: Path | None) -> None:
    """Refuse loads and motions that are missing or given twice."""
    there = {option for option, value in given.items() if value is not None}
    motions = there & {"--u", "--rotation"}
    if sequence is not None:
        for option in sorted(there - {"--V", "--skirt-length", "--rate"}):
            refuse(option, "give either this or --sequence: the file holds loads, motions and their height")
        return
    if not there & {"--H", "--M", "--V", "--u-max", "--u", "--rotation"}:
        refuse("--H", MISSING)
    if {"--H", "--u-max"} <= there:
        refuse("--u-max", "give either --H or --u-max: the load is an answer of the curve")
    if {"--u-max", "--M"} <= there:
        refuse("--M", "a curve needs the height of the load: give --arm instead")
    if motions and (other := sorted(there & {"--H", "--M", "--u-max"})):
        refuse(min(motions), f"give either this or {other[0]}: a load is the answer to a motion")
    if {"--arm", "--M"} <= there:
        refuse("--M", "give either --arm or --M, not both (M = -H*arm)")
    if len(motions) == 2 and "--arm" in there:
        refuse("--arm", "with --u and --rotation both loads are answers: leave --arm out")
    if "--arm" in there and not there & {"--H", "--u-max", "--u", "--rotation"}:
        refuse("--H", MISSING)


def stiffness_json(states: xr.Dataset, six: xr.DataArray | None) -> dict[str, Any]:
    """Return the tangents by state and the initial 6x6 matrix with what they mean; SI."""
    tangent = states["stiffness"]
    meaning = {"dofs": tangent["dof"].values, "comment": tangent.attrs["comment"], "matrices": tangent.values}
    if six is None:
        return {"stiffness": meaning}
    attrs = {name: six.attrs[name] for name in ("long_name", "comment", "torsion")}
    return {"stiffness": meaning, "stiffness_6x6": {"dofs": six["dof"].values, **attrs, "matrix": six.values}}


MOST_MATRICES = 1  # more states: a line each


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
        say("note: no 6x6 stiffness: a table without a vertical path has no vertical stiffness")
        return
    print(f"\n{six.attrs['long_name']}, 6x6 (MN, m, rad):")
    print_table(["", *(f"per {name}" for name in six["dof"].values)], _lines(six, [str(x) for x in six["dof"].values]))
    say(f"note: {six.attrs['torsion']}")


def _lines(matrix: xr.DataArray, names: list[str]) -> list[list[str]]:
    return [
        [name, *(f"{value * 1e-6 + 0.0:.5g}" for value in row)] for name, row in zip(names, matrix.values, strict=True)
    ]
