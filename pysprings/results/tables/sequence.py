# SPDX-License-Identifier: MIT
"""A sequence of loads or motions from a small table: one a line, in order."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pysprings.core.arguments import too_early
from pysprings.core.arrays import Array
from pysprings.core.tables import Column, Table, one_table
from pysprings.core.units import quoted
from pysprings.macro.ways import Control
from pysprings.springs.path import SPACE_LOADS, SPACE_TURNS

_UNITS = {"u": "m", "r": "rad", "H": "N", "M": "Nm", "T": "Nm"}
_TURNS, _PUSHES = (tuple(f"{name}_{_UNITS[name[0]]}" for name in names) for names in (SPACE_TURNS, SPACE_LOADS))
_OTHERS = (("fx", "f x", "hx"), ("fy", "f y", "hy"), ("mx",), ("my",), ("mz", "m z", "torsion"))  # of load cases
COLUMNS = tuple(
    Column.named(name, others)
    for name, others in {
        "H_N": ("horizontal",), "M_Nm": ("moment",), "V_N": ("vertical",), "u_m": (), "rotation_rad": (),
        "arm_m": ("height", "lever arm"), "time_s": ("t",), "w_m": (),
        **{name: () for name in _TURNS}, **dict(zip(_PUSHES, _OTHERS, strict=True)), "Fz_N": ("f z",),
    }.items()
)  # fmt: skip
FORMS = "H_N with M_Nm or arm_m; u_m and rotation_rad; or one of u_m and rotation_rad with arm_m; V_N, time_s with any"
_BESIDE = ("V_N", "Fz_N", "time_s", "arm_m", "w_m")  # of loads and motions
SPACE_FORMS = f"some of {', '.join(_PUSHES)}, or some of {', '.join(_TURNS)}; V_N (or Fz = -V), time_s with either"


@dataclass(frozen=True, slots=True)
class Sequence:
    """Targets (n, 2) of a control, the height of the load [m]; V [N], time [s] by row (None: not given).

    Of six degrees of freedom they are (n, 5) (`pysprings.macro.space.sequence_in_space`).
    """

    control: Control
    targets: Array
    arm: float
    V: Array | None
    time: Array | None

    @property
    def in_space(self) -> bool:
        """Whether the rows are loads or motions in six degrees of freedom."""
        return self.targets.shape[1] > 2


def read_sequence(path: str | os.PathLike[str]) -> Sequence:
    """Read a sequence from a table with columns of `COLUMNS`, in any unit; loads, or motions, not both.

    Every sequence begins at rest; a first row of zeros at 0 s is that state, and has the V there.

    Raises UserInputError: every fault, with file and line.
    """
    table = one_table(Path(path), COLUMNS, "a sequence")
    _check_columns(table)
    table.stop_at_head()
    columns = {name: table.numbers(name) for name in table.columns}
    for name, values in columns.items():
        for k in np.flatnonzero(np.isnan(values)):
            table.fault(int(k), name, "blank")
    table.faults.stop()
    if not len(table):
        table.fault(None, None, "no rows")
    given = [values for name, values in columns.items() if name not in _BESIDE]
    if "arm_m" in columns and len(table) > 1 and not any(values[0] for values in given):
        columns["arm_m"][0] = columns["arm_m"][1]  # at rest nothing has a height
    if ("u_m" in columns or "rotation_rad" in columns) and np.unique(columns.get("arm_m", np.zeros(1))).size > 1:
        table.fault(None, "arm_m", "a motion is followed at one load height: arm_m must not change")
    if "time_s" in columns:
        for k in np.flatnonzero(too_early(columns["time_s"], np.stack(given, axis=1))):
            table.fault(int(k), "time_s", "must be later than the row before, and than 0 s (but for a row at rest)")
    for k in np.flatnonzero(columns.get("w_m", np.zeros(0))):
        table.fault(int(k), "w_m", "w follows from the vertical load: leave the column out, or 0")
    table.faults.stop()
    if "Fz_N" in columns:
        columns["V_N"] = -columns.pop("Fz_N")
    return _built(columns)


def _built(columns: dict[str, Array]) -> Sequence:
    zero, rest = np.zeros(len(next(iter(columns.values())))), (columns.get("V_N"), columns.get("time_s"))
    if found := [names for names in (_TURNS, _PUSHES) if set(names) & set(columns)]:
        targets = np.stack([columns.get(name, zero) for name in found[0]], axis=1)
        return Sequence("state" if found[0] is _TURNS else "load", targets, 0.0, *rest)
    u, rotation = columns.get("u_m"), columns.get("rotation_rad")
    if u is not None and rotation is not None:
        return Sequence("state", np.stack([u, rotation], axis=1), 0.0, *rest)
    arm = columns.get("arm_m", zero)
    if u is not None:
        return Sequence("displacement", np.stack([u, zero], axis=1), float(arm[0]), *rest)
    if rotation is not None:
        return Sequence("rotation", np.stack([rotation, zero], axis=1), float(arm[0]), *rest)
    force = columns.get("H_N", zero)
    return Sequence("load", np.stack([force, columns.get("M_Nm", force * arm)], axis=1), 0.0, *rest)


def _check_columns(table: Table) -> None:
    """Note what is wrong with the combination of columns."""
    if table.faults.problems:
        return
    there = set(table.columns)
    if {"V_N", "Fz_N"} <= there:
        table.fault(None, "Fz_N", f"gives what {quoted(table.key('V_N'))} gives, too: keep one of them")
    there = {"V_N" if name == "Fz_N" else name for name in there}
    turns, pushes = there & set(_TURNS), there & set(_PUSHES)
    if turns or pushes:
        if others := sorted(there - {*_TURNS, *_PUSHES, "V_N", "time_s", "w_m"}):
            table.fault(None, others[0], f"of one plane, beside columns of six degrees of freedom: {SPACE_FORMS}")
        elif turns and pushes:
            table.fault(None, None, f"expected either loads or motions: {SPACE_FORMS}")
        return
    if "w_m" in there:
        table.fault(None, "w_m", f"one column too many: {FORMS}")
    loads, motions = there & {"H_N", "M_Nm"}, there & {"u_m", "rotation_rad"}
    if bool(loads) == bool(motions):
        table.fault(None, None, f"expected either loads or motions: {FORMS}")
    elif {"M_Nm", "arm_m"} <= there or ("arm_m" in there and (len(motions) == 2 or loads == {"M_Nm"})):
        table.fault(None, "arm_m", f"one column too many: {FORMS}")
