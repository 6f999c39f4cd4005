# SPDX-License-Identifier: MIT
"""The vertical part of an answer: w, V, the stiffness of w, and marks of vertical loads that the springs lack."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.core.errors import refused
from pysprings.macro.ends import past_elastic
from pysprings.macro.vertical import VerticalTable
from pysprings.springs.path import SpringPath, same_load

if TYPE_CHECKING:
    from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]

# A vertical spring may exceed its range by this share before it counts as extrapolated (rounding).
SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Down:
    """w, V and marks by step (none for springs from a table), tangent dV/dw and range used (n,), words.

    used is inf where an elastic stiffness answers beyond the loads that it may. beyond: sentences on V beyond the
    calibrated range; message: no w carries V, and w is that of the end of the curve then.
    """

    values: dict[str, Array] = field(default_factory=dict)
    tangent: Array | None = None
    used: Array | float = 0.0
    notes: list[str] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)
    message: str = ""


def vertical_answer(
    model: MacroModel, w: Array | None, V: Array | None, imposed: float | Array | None, states: Array
) -> Down:
    """Return what goes with lateral states (n, 2) = (u, rotation) under a vertical load.

    Parameters
    ----------
    w, V
        Vertical displacement [m] and load [N] of the lateral springs by step; None if a table has none.
    imposed
        Imposed vertical load [N], one number or one a step; None: that of the lateral springs.
    """
    if model.stiffness_initial is None or w is None or V is None:
        if imposed is not None:
            raise refused("V", "these springs come from a table without vertical paths (family tz): leave V out")
        return Down()
    w = w + _settled(model, imposed)
    if imposed is None:
        return Down({"w": w, "V": V, "off_load": np.zeros(w.size, dtype=np.int8)})
    down = np.full_like(V, imposed)
    other = np.array([not same_load(a, b) for a, b in zip(down, V, strict=True)], dtype=bool)
    follows = model.memory is not None and model.memory.under(down) is not None
    lacks = other if model.memory is None else model.memory.lacks(down, other)
    moved = lacks & (states != 0.0).any(axis=1)
    marks = {"V": down, "off_load": moved.astype(np.int8)}
    if model.vertical is None:
        K = float(model.stiffness_initial[1, 1])
        notes = [_not_the_paths(model, down[other]) + "w from the elastic vertical stiffness"] if other.any() else []
        notes = [note if follows and not moved.any() else f"{note}, lateral springs unchanged" for note in notes]
        past, beyond = past_elastic(model, down, other)
        lacking = moved if follows else other | moved
        return Down(
            marks | {"w": w + (down - V) / K, "off_load": lacking.astype(np.int8)},
            used=np.where(past, np.inf, 0.0),
            notes=notes,
            beyond=beyond,
        )
    there = model.vertical.displacements(down) if model.memory is None else model.vertical.history(down)
    used, own = there[2], there[-1]
    return Down(
        marks | {"w": w + there[0] - model.vertical.displacements(V)[0]},
        there[1],
        np.nan_to_num(used, nan=np.inf),
        _notes(model, down, moved),
        _beyond(model, down, own),
        _no_equilibrium(model, down[np.isnan(own)]),
    )


def _settled(model: MacroModel, V: float | Array | None) -> float:
    """Return what w [m] of the lateral springs at rest lacks to that of the vertical ones, at the V of their start."""
    changing = None if model.memory is None else model.memory.under(V)
    if model.memory is None or model.vertical is None or changing is None:
        return model.settled
    w, load = model.memory.rest_under(V)
    recorded = any(same_load(load, each) for each in changing.loads)
    return 0.0 if recorded else float(model.vertical.displacement(load)[0]) - w


def _notes(model: MacroModel, down: Array, moved: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on states under another V than that of the lateral springs, or after one."""
    if not moved.any():
        return []
    if model.memory is None:
        return [_not_the_paths(model, down[moved]) + "lateral springs unchanged"]
    there = "unchanged" if model.memory.under(down) is None else "are those at the nearest load"
    text = f"{moved.sum()} of {moved.size} states are under another V than {model.memory.loads_text()}, or come after "
    return [f"{text}one: lateral springs {there}"]


def along_vertical(table: VerticalTable, path: SpringPath) -> xr.Dataset:
    """Return what the vertical springs answer at the w [m] of a path, with the variables and attrs of a prediction."""
    w = path.w
    rows, nothing = table.reactions(w), np.zeros(w.size)
    known = variables.GROUPS["prediction"]
    values = {"u": nothing, "w": w, "rotation": nothing, "H": nothing, "V": rows[-1], "M": nothing}
    used = np.array([table.used(float(value)) for value in w])
    marks = {"converged": np.ones(w.size), "extrapolated": used > 1.0 + SLACK, "off_path": nothing, "off_load": nothing}
    marks |= {"turned_back": nothing, "beyond_end": nothing}
    values |= {"range_used": used} | {name: mark.astype(np.int8) for name, mark in marks.items()}
    data: dict[str, Any] = {name: (known[name].dims, x, known[name].attributes()) for name, x in values.items()}
    data |= {
        "t": (("depth", "step"), rows[table.name == "t"], {"units": "N m-1"}),
        "u_at_load": ("step", nothing, {"units": "m"}),
        "usable": ("depth", np.ones(path.depth.size, dtype=np.int8), known["usable"].attributes()),
    }
    coords = {"depth": ("depth", path.depth, known["depth"].attributes()), "step": np.arange(w.size)}
    attrs = {"springs": "vertical", "path": table.path, "status": "complete", "message": "", "warnings": []}
    return xr.Dataset(data, coords, attrs)


def _beyond(model: MacroModel, V: Array, used: Array) -> list[str]:
    """Return the sentences on vertical loads (n,) beyond the vertical springs."""
    assert model.vertical is not None
    _, sentences = past_elastic(model, V, np.isinf(used))
    if np.isinf(used).any() and not sentences:
        direction = "upwards" if model.vertical.branch(1.0) else "downwards"
        sentences = [f"no vertical path leads {direction}: w would be that of the elastic vertical stiffness"]
    for branch in model.vertical.branches:
        over = np.isnan(used) | ((used > 1.0 + SLACK) & np.isfinite(used))
        beyond = over & (branch.sign * (V - model.vertical.rest[1]) > 0.0)
        if beyond.any():
            reach = np.nan_to_num(used[beyond], nan=np.inf).max()
            worst = V[beyond][np.argmax(branch.sign * V[beyond])]
            sentences.append(
                f"V = {worst:.7g} N is beyond the vertical springs (path {branch.path}): they reach {reach:.3g} "
                f"times the calibrated displacement (limit 1); they carry {model.vertical.limits()}; "
                f"{model.ends[branch.path]}"
            )
    return sentences


def _no_equilibrium(model: MacroModel, V: Array) -> str:
    assert model.vertical is not None
    if not V.size:
        return ""
    return f"macro-model: no vertical equilibrium under V = {_list(V)} N; the springs carry {model.vertical.limits()}"


def _not_the_paths(model: MacroModel, V: Array) -> str:
    path, own = model.origin.name, model.origin.load
    return f"V = {_list(V)} N is not that of path '{path}' ({own:.7g} N): "


def _list(V: Array) -> str:
    values = np.unique(V)
    return ", ".join(f"{value:.7g}" for value in values[:3]) + (" ..." if values.size > 3 else "")
