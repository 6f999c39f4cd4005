# SPDX-License-Identifier: MIT
"""Sequences of the full model beside springs: errors along each, and peaks, stiffness, work and damping by cycle.

A sequence is a recorded path that turns back, bends, or whose load climbs. It is driven as the full model was: a pull
by u with the load at its height, other motions by u and rotation, loads by H and M. Errors are the largest distance
along the path over the largest value of the full model on it.

A branch goes from one turn to the next; two branches are a cycle. With the changes dH, dM, du, d(rotation) between the
turns that end a cycle, and the work W of it,

    W = integral of H du + M d(rotation),   damping ratio = 2 W/(pi (dH du + dM d(rotation))),

which is the area of the loop over 4 pi times the energy of a linear spring at its amplitude. The secant stiffness is
dH/du; dM/d(rotation) where u is held or H is constant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.path_kinds import PATH_KINDS
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.ways import Control
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

SETS = ("fan", "memory")
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
    def work(self) -> tuple[Array, Array]:
        """Work (n,) [J] that both have taken up from the start of the path."""
        return _work(*self.full), _work(*self.macro)


def is_sequence(path: SpringPath) -> bool:
    """Return whether a path turns back, or H and M change their ratio on it."""
    return not path.is_vertical and (path.turns_back or path.bends)


def follow_path(path: SpringPath, model: MacroModel) -> Followed:
    """Drive springs along a path of the full model, as that was driven."""
    motions = np.stack([path.u, path.rotation], axis=1)
    loads = np.stack([path["H"] - path["H"][0], path["M"] - path["M"][0]], axis=1)
    kind = PATH_KINDS[path.kind]
    control: Control = "load" if kind.force else "displacement" if kind.free_head else "state"
    targets = loads if kind.force else motions
    arm = path.arm if np.isfinite(path.arm) else 0.0
    found, carried, message = model.solve(control, targets, arm, V=path.given_loads)
    n = len(found)
    given, V = (motions[:n], loads[:n]), path.given_loads[:n]
    return Followed(path, model.spring_set, control, given, (found, carried), message, model, V)


def sequences(springs: Springs, sets: tuple[str, ...] = SETS) -> Iterator[Followed]:
    """Yield the sequences of a set of springs on each of these spring sets that the springs give."""
    for path in springs.paths.values():
        if is_sequence(path):
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
    at = turns(one)
    motion, load = _measured(one)
    works = one.work
    rows = []
    for number, (start, end) in enumerate(pairwise(at), 1):
        row: dict[str, Any] = {"path": one.path.name, "springs": one.springs, "branch": number, "states": end - start}
        for who, (motions, loads), work in zip(("full", "macro"), (one.full, one.macro), works, strict=True):
            x, F = motions[:, motion], loads[:, load]
            row[f"x_end_{who}"], row[f"F_end_{who}"] = float(x[end]), float(F[end])
            change = float(x[end] - x[start])
            row[f"secant_{who}"] = float(F[end] - F[start]) / change if change else np.nan
            row[f"work_{who}_J"] = float(work[end] - work[start])
            before = at[number - 2] if number > 1 else None
            area = float(((loads[end] - loads[start]) * (motions[end] - motions[start])).sum())
            whole = np.nan if before is None else float(work[end] - work[before])
            row[f"cycle_{who}_J"], row[f"damping_{who}"] = whole, 2.0 * whole / (np.pi * area) if area else np.nan
        rows.append(row)
    return pd.DataFrame(rows)


def turns(one: Followed) -> list[int]:
    """Return the states where the full model turns back, with the first and the last one.

    A step in which the vertical load changes is none: what is imposed laterally stays there, but for rounding.
    """
    plane = one.full[1] if one.control == "load" else one.full[0]
    scaled = plane / np.maximum(np.abs(plane).max(axis=0), 1e-300)
    if one.control == "displacement":
        scaled = scaled[:, :1]
    steps = np.diff(scaled, axis=0)
    lateral = np.abs(steps).sum(axis=1) > 0.0
    if one.V is not None:
        lateral &= np.diff(one.V) == 0.0
    moved = np.flatnonzero(lateral)
    back = (steps[moved[1:]] * steps[moved[:-1]]).sum(axis=1) < 0.0
    return [0, *moved[1:][back].tolist(), len(plane) - 1]


def _measured(one: Followed) -> tuple[int, int]:
    """Return the columns of motion and load of the cycles: (u, H), or (rotation, M) where u is held or H constant."""
    at = turns(one)
    plane = one.full[1] if one.control == "load" else one.full[0]
    later = plane[at[1] :, 0] if len(at) > 2 else plane[:, 0]
    held = float(np.ptp(later)) <= _HELD * float(np.abs(plane).max(initial=0.0))
    return (1, 1) if held else (0, 0)


def _work(motions: Array, loads: Array) -> Array:
    """Return the work (n,) [J] of loads along motions, trapezoid by step."""
    mean = 0.5 * (loads[1:] + loads[:-1])
    return np.concatenate([[0.0], np.cumsum((mean * np.diff(motions, axis=0)).sum(axis=1))])
