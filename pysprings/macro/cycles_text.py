# SPDX-License-Identifier: MIT
"""All sequences of the full model beside springs, as tables: `pysprings compare --cycles`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.columns import Column, Table, records
from pysprings.core.errors import refused
from pysprings.macro.cycles import SETS, Followed, cycles, errors, sequences
from pysprings.macro.fan import WATER, FanTable, reaction_rows
from pysprings.macro.fan_springs import FanSprings
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

_FAMILIES = ("p", "m", "t", "H_tip", "M_tip", "H_lid", "M_lid", "V_tip", "V_lid", "w", WATER)
_VERTICAL = ("t", "V_tip", "V_lid", "w")


def reaction_errors(one: Followed) -> dict[str, Any]:
    """Return the largest error [%] of each family of reactions, and of w, over the largest value of the full model.

    The springs are at their own motion where the path was driven by loads. All are changes from the start of the path.
    NaN for vertical reactions and w where V changes on the way: what V itself does is not in the lateral springs.
    The water's part of p is there where the springs have it apart.
    """
    table, full, macro = _reactions(one)
    changes = one.V is not None and np.ptp(one.V) > 0.0
    row: dict[str, Any] = {"path": one.path.name, "role": one.path.role, "springs": one.springs}
    for name in (name for name in _FAMILIES if name in table.name):
        own = table.name == name
        size = float(np.abs(full[own]).max(initial=0.0))
        worst = float(np.abs(macro[own] - full[own]).max(initial=0.0))
        row[f"{name}_error_pct"] = np.nan if not size or (changes and name in _VERTICAL) else 100.0 * worst / size
    return row


def by_depth(one: Followed) -> pd.DataFrame:
    """Return a row a depth: largest p of the full model [N/m], and error of p [%] over the largest at any depth."""
    table, full, macro = _reactions(one)
    own = table.name == "p"
    peak, size = np.abs(full[own]).max(axis=1), float(np.abs(full[own]).max())
    error = np.abs(macro[own] - full[own]).max(axis=1)
    values = {"depth_m": table.depth[own], "p_full_N_per_m": peak, "p_error_pct": 100.0 * error / (size or np.nan)}
    return pd.DataFrame({"path": one.path.name, "springs": one.springs} | values)


def _reactions(one: Followed) -> tuple[FanTable, Array, Array]:
    """Return the layout of the reactions, and those of the full model and of the springs (rows, n), from the start."""
    assert one.model is not None
    response, states = one.model.response, one.macro[0]
    assert isinstance(response, FanSprings)
    table = response.table
    full = reaction_rows(one.path, bool(table.wet.any()))[:, : len(states)]
    time = one.path["time"][: len(states)] - one.path["time"][0] if "time" in one.path else None
    macro = response.reactions(states, time, one.V)
    return table, full - full[:, :1], macro - table.r[:, 0, :1]


@dataclass(frozen=True, slots=True)
class Cycles:
    """Errors of all sequences, one row a path and spring set, their branches (`cycles`), and errors of the reactions.

    depths : one row a path, spring set and depth: largest p of the full model there and error of p.
    """

    errors: pd.DataFrame
    branches: pd.DataFrame
    reactions: pd.DataFrame
    depths: pd.DataFrame


def compare_cycles(source: Springs | xr.DataTree, springs_kind: str | None = None) -> Cycles:
    """Return errors and branches of all sequences of a set of springs.

    Raises
    ------
    UserInputError
        No path turns back or bends, or the springs do not give the spring set.
    """
    springs = Springs.of(source)
    sets = SETS if springs_kind is None else (springs_kind,)
    found = list(sequences(springs, sets))
    if not found:
        raise refused("springs", "no path turns back or bends, or the springs do not give this spring set for one")
    branches = pd.concat([cycles(one) for one in found], ignore_index=True)
    return Cycles(
        pd.DataFrame([errors(one) for one in found]),
        branches,
        pd.DataFrame([reaction_errors(one) for one in found]),
        pd.concat([by_depth(one) for one in found], ignore_index=True),
    )


_COLUMNS = (
    Column("path", "path", words=True),
    Column("springs", "springs", words=True),
    Column("branch", "branch"),
    Column("secant full", "secant_full", factor=1e-6),
    Column("macro", "secant_macro", factor=1e-6),
    Column("peak full", "F_end_full", factor=1e-3),
    Column("macro", "F_end_macro", factor=1e-3),
    Column("work full [kJ]", "work_full_J", factor=1e-3),
    Column("macro [kJ]", "work_macro_J", factor=1e-3),
    Column("damping full", "damping_full"),
    Column("macro", "damping_macro"),
)
_NOTES = (
    "errors: largest distance along the path over the largest value of the full model, of what answers",
    "a branch goes from turn to turn; peak: H [kN] at its end, secant stiffness dH/du [MN/m]; M [kN m] and [MN m/rad] "
    "where u is held or H constant; damping = 2 W/(pi (dH du + dM d(rotation))) of the cycle that ends with the branch",
    "reactions: largest distance at any depth over the largest value of the full model on the path, as changes from "
    "the start, at the motion of the springs. p error by depth: over the largest p at any depth",
)


def to_text(found: Cycles) -> str:
    """Return the tables for a terminal."""
    tables = [_errors(found.errors), _table(_COLUMNS, found.branches), _errors(found.reactions), *_depths(found.depths)]
    return "\n\n".join([*(each.text() for each in tables), "\n".join(_NOTES)]) + "\n"


def _table(columns: Iterable[Column], frame: pd.DataFrame) -> Table:
    return Table.of(list(columns), frame.to_dict("records"))


def _errors(frame: pd.DataFrame) -> Table:
    """Return the table of errors, a column of each in percent."""
    heads = {str(name): str(name).replace("_error_pct", " [%]") for name in frame}
    return _table((Column(head, name, words=head == name) for name, head in heads.items()), frame)


def _depths(frame: pd.DataFrame) -> list[Table]:
    """Return a table for each spring set: error of p [%], a row a depth and a column a path."""
    tables = []
    for springs, own in frame.groupby("springs", sort=False):
        paths = list(dict.fromkeys(own["path"]))
        wide = own.pivot_table(index="depth_m", columns="path", values="p_error_pct")[paths].reset_index()
        depth = Column(f"p error [%], {springs}: depth [m]", "depth_m")
        tables.append(_table([depth, *(Column(name, name) for name in paths)], wide))
    return tables


def to_dict(found: Cycles) -> dict[str, Any]:
    """Return the tables for JSON (SI); what is undefined is None."""
    names = ("errors", "branches", "reactions", "depths")
    return {name: records(getattr(found, name)) for name in names} | {"definitions": list(_NOTES)}
