# SPDX-License-Identifier: MIT
"""Sequences of the full model beside springs: errors along each, and peaks, stiffness, work and damping by cycle.

All of them as tables: `pysprings compare --cycles`.

A sequence is a recorded path that turns back, bends, or whose load climbs. It is driven as the full model was: a pull
by u with the load at its height, other motions by u and rotation, loads by H and M. Errors are the largest distance
along the path over the largest value of the full model on it.

A branch goes from one turn to the next; two branches are a cycle where the second ends where the first began, in what
is imposed: else their work has stored energy in it. With the changes dH, dM, du, d(rotation) between the
turns that end a cycle, and the work W of it,

    W = integral of H du + M d(rotation),   damping ratio = 2 W/(pi (dH du + dM d(rotation))),

which is the area of the loop over 4 pi times the energy of a linear spring at its amplitude. The secant stiffness is
dH/du; dM/d(rotation) where u is held or H is constant.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.columns import Column, Table, records
from pysprings.core.errors import refused
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.macro.fan import WATER, FanTable, reaction_rows
from pysprings.macro.fan_springs import FanSprings
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.ways import Control
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

SETS = ("fan", "memory")
CLOSED = 0.02  # of the last branch, by which a cycle may stay open
_HELD = 1e-6  # share of the largest change below which a quantity is held


@dataclass(frozen=True, slots=True)
class Followed:
    """A sequence of the full model and of springs: motions (n, 2) = (u, rotation), loads (n, 2) = (H, M) of both.

    n is what the springs reached; `message` is where they ended before the end of the path. model: the springs. V (n,):
    vertical load that was given [N]; None: not known.
    """

    path: SpringPath
    springs: str
    control: Control
    full: tuple[Array, Array]
    macro: tuple[Array, Array]
    message: str
    model: MacroModel | None = None
    V: Array | None = None

    @property
    def imposed(self) -> Array:
        """What the full model was driven by (n, 2): loads, or motions of which u may be free."""
        return self.full[1] if self.control == "load" else self.full[0]

    @property
    def work(self) -> tuple[Array, Array]:
        """Work (n,) [J] that both have taken up from the start of the path."""
        return _work(*self.full), _work(*self.macro)


def control_of(path: SpringPath) -> Control:
    """Return what drove the full model along a path: loads, u with the load at its height, or both motions."""
    kind = PATH_KINDS[path.kind]
    return "load" if kind.force else "displacement" if kind.free_head else "state"


def follow_path(path: SpringPath, model: MacroModel) -> Followed:
    """Drive springs along a path of the full model, as that was driven."""
    motions = np.stack([path.u, path.rotation], axis=1)
    loads = np.stack([path["H"] - path["H"][0], path["M"] - path["M"][0]], axis=1)
    control = control_of(path)
    targets = loads if control == "load" else motions
    arm = path.arm if np.isfinite(path.arm) else 0.0
    found, carried, message = model.solve(control, targets, arm, V=path.given_loads)
    n = len(found)
    given, V = (motions[:n], loads[:n]), path.given_loads[:n]
    return Followed(path, model.spring_set, control, given, (found, carried), message, model, V)


def sequences(springs: Springs, sets: tuple[str, ...] = SETS) -> Iterator[Followed]:
    """Yield the sequences of a set of springs on each of these spring sets that the springs give."""
    for path in springs.paths.values():
        if not path.is_vertical and (path.turns_back or path.bends):
            own = springs.answering(path)
            for name in (name for name in sets if name in spring_sets(own)):
                yield follow_path(path, MacroModel.from_springs(own, name))


def errors(one: Followed) -> dict[str, Any]:
    """Return the errors [%] of a sequence: of what answers (H, M, u, rotation), of the work, and of w [m]."""
    answers = {"load": ("u", "rotation"), "displacement": ("H", "rotation")}.get(one.control, ("H", "M"))
    columns = {"u": (0, 0), "rotation": (0, 1), "H": (1, 0), "M": (1, 1)}
    row: dict[str, Any] = {"path": one.path.name, "role": one.path.role, "springs": one.springs}
    row |= {"states": len(one.full[0]), "answered": not one.message}
    for name, (part, column) in columns.items():
        row[f"{name}_error_pct"] = _largest(one.full[part][:, column], one.macro[part][:, column], name in answers)
    full, macro = one.work
    row["work_error_pct"] = 100.0 * float(macro[-1] / full[-1] - 1.0) if full.size and full[-1] else np.nan
    return row


def _largest(full: Array, macro: Array, answered: bool) -> float:
    size = float(np.abs(full).max(initial=0.0))
    return 100.0 * float(np.abs(macro - full).max()) / size if answered and size else np.nan


def cycles(one: Followed) -> pd.DataFrame:
    """Return one row a branch: peaks, secant stiffness, work of the cycle that ends with it, damping ratio, of both."""
    at, imposed = turns(one), _imposed(one)
    motion, load = measured(one)
    works = one.work
    rows = []
    for number, (start, end) in enumerate(pairwise(at), 1):
        row: dict[str, Any] = {"path": one.path.name, "springs": one.springs, "branch": number, "states": end - start}
        before = at[number - 2] if number > 1 else start
        open_by, size = (float(np.abs(imposed[end] - imposed[each]).max()) for each in (before, start))
        for who, (motions, loads), work in zip(("full", "macro"), (one.full, one.macro), works, strict=True):
            x, F = motions[:, motion], loads[:, load]
            row[f"x_end_{who}"], row[f"F_end_{who}"] = float(x[end]), float(F[end])
            change = float(x[end] - x[start])
            row[f"secant_{who}"] = float(F[end] - F[start]) / change if change else np.nan
            row[f"work_{who}_J"] = float(work[end] - work[start])
            area = float(((loads[end] - loads[start]) * (motions[end] - motions[start])).sum())
            whole = float(work[end] - work[before]) if open_by <= CLOSED * size else np.nan
            row[f"cycle_{who}_J"], row[f"damping_{who}"] = whole, 2.0 * whole / (np.pi * area) if area else np.nan
        rows.append(row)
    return pd.DataFrame(rows)


def turns(one: Followed) -> list[int]:
    """Return the states where the full model turns back, with the first and the last one.

    A step in which the vertical load changes is none: what is imposed laterally stays there, but for rounding.
    """
    imposed = _imposed(one)
    steps = np.diff(imposed, axis=0)
    lateral = np.abs(steps).sum(axis=1) > 0.0
    if one.V is not None:
        lateral &= np.diff(one.V) == 0.0
    moved = np.flatnonzero(lateral)
    back = (steps[moved[1:]] * steps[moved[:-1]]).sum(axis=1) < 0.0
    return [0, *moved[1:][back].tolist(), len(imposed) - 1]


def _imposed(one: Followed) -> Array:
    """Return what the full model was driven by, (n, 1) or (n, 2), over the largest of each."""
    scaled: Array = one.imposed / np.maximum(np.abs(one.imposed).max(axis=0), 1e-300)
    return scaled[:, :1] if one.control == "displacement" else scaled


def measured(one: Followed) -> tuple[int, int]:
    """Return the columns of motion and load of the cycles: (u, H), or (rotation, M) where u is held or H constant."""
    at, plane = turns(one), one.imposed
    later = plane[at[1] :, 0] if len(at) > 2 else plane[:, 0]
    held = float(np.ptp(later)) <= _HELD * float(np.abs(plane).max(initial=0.0))
    return (1, 1) if held else (0, 0)


def _work(motions: Array, loads: Array) -> Array:
    """Return the work (n,) [J] of loads along motions, trapezoid by step."""
    mean = 0.5 * (loads[1:] + loads[:-1])
    return np.concatenate([[0.0], np.cumsum((mean * np.diff(motions, axis=0)).sum(axis=1))])


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

    Raises UserInputError: no path turns back or bends, or the springs do not give the spring set.
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
    "where u is held or H constant; damping = 2 W/(pi (dH du + dM d(rotation))) of the cycle that ends with the "
    "branch, where it closes",
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
