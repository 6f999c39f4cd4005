# SPDX-License-Identifier: MIT
"""A sequence of loads or motions from a small table: one a line, in order."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.control import Control
from pysprings.results.tables.faults import Faults, numbers
from pysprings.results.tables.file import sheet_of
from pysprings.results.tables.headings import Column, read_headings

Array = NDArray[np.float64]

COLUMNS = ("H_N", "M_Nm", "V_N", "u_m", "rotation_rad", "arm_m", "time_s")
FORMS = "H_N with M_Nm or arm_m; u_m and rotation_rad; or one of u_m and rotation_rad with arm_m; V_N, time_s with any"


@dataclass(frozen=True, slots=True)
class Sequence:
    """Targets (n, 2) of a control, the height of the load [m]; V [N], time [s] by row (None: not given)."""

    control: Control
    targets: Array
    arm: float
    V: Array | None
    time: Array | None


def read_sequence(path: str | os.PathLike[str]) -> Sequence:
    """Read a sequence from a table with columns of `COLUMNS`, in any unit; loads, or motions, not both.

    Raises
    ------
    UserInputError
        Every fault, with file and line.
    """
    faults, path = Faults(), Path(path)
    head, lines = sheet_of(path)
    read = _columns(str(path), head, faults)
    faults.stop()
    at = np.array([line for line, _ in lines], dtype=np.int64)
    columns = {
        name: numbers(str(path), name, [row[k] if k < len(row) else None for _, row in lines], at, faults, factor)
        for k, (name, factor) in enumerate(read)
    }
    for name, values in columns.items():
        for line in at[np.isnan(values)]:
            faults.add((str(path), int(line)), name, "blank")
    if not len(at):
        faults.add((str(path), None), None, "no rows")
    if "u_m" in columns or "rotation_rad" in columns:
        arms = columns.get("arm_m", np.zeros(1))
        if np.unique(arms[np.isfinite(arms)]).size > 1:
            faults.add((str(path), 1), "arm_m", "a motion is followed at one load height: arm_m must not change")
    _forward(str(path), columns.get("time_s"), at, faults)
    faults.stop()
    return _built(columns)


def _forward(place: str, time: Array | None, at: NDArray[np.int64], faults: Faults) -> None:
    """Note every row whose time [s] is not later than that of the row before; the way begins at 0 s."""
    if time is None:
        return
    for line in at[np.diff(time, prepend=0.0) <= 0.0]:
        faults.add((place, int(line)), "time_s", "must be later than the row before, and than 0 s")


def _built(columns: dict[str, Array]) -> Sequence:
    zero, rest = np.zeros(len(next(iter(columns.values())))), (columns.get("V_N"), columns.get("time_s"))
    u, rotation = columns.get("u_m"), columns.get("rotation_rad")
    if u is not None and rotation is not None:
        return Sequence("state", np.stack([u, rotation], axis=1), 0.0, *rest)
    arm = columns.get("arm_m", zero)
    if u is not None:
        return Sequence("displacement", np.stack([u, zero], axis=1), float(arm[0]), *rest)
    if rotation is not None:
        return Sequence("rotation", np.stack([rotation, zero], axis=1), float(arm[0]), *rest)
    force = columns.get("H_N", zero)
    return Sequence("load", np.stack([force, columns.get("M_Nm", -force * arm)], axis=1), 0.0, *rest)


def _columns(place: str, head: list[str], faults: Faults) -> list[Column]:
    """Return the column of each heading; note what is wrong with the headings, or with their combination."""
    read = read_headings(place, head, COLUMNS, faults)
    if faults.problems:
        return []
    there = {column.name for column in read if column}
    loads, motions = there & {"H_N", "M_Nm"}, there & {"u_m", "rotation_rad"}
    if bool(loads) == bool(motions):
        faults.add((place, 1), None, f"expected either loads or motions: {FORMS}")
    elif {"M_Nm", "arm_m"} <= there or ("arm_m" in there and (len(motions) == 2 or loads == {"M_Nm"})):
        faults.add((place, 1), "arm_m", f"one column too many: {FORMS}")
    return [column for column in read if column]
