# SPDX-License-Identifier: MIT
"""The vertical part of an answer: w, V, the stiffness of w, marks of loads that the springs lack, and the largest V.

A vertical load that the springs were not made for is answered from an elastic stiffness only where it differs from
theirs by no more than theirs: without vertical springs from 0 to twice the load of the paths.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import refused
from pysprings.core.loads import same_loads
from pysprings.core.text import with_prefix
from pysprings.core.words import RANGE_END, sudden
from pysprings.macro.model import MacroModel
from pysprings.macro.response import list_of, other_load
from pysprings.macro.vertical import VerticalTable, covered, share_left
from pysprings.springs.path import SpringPath, off_rate
from pysprings.springs.path_ends import LIMIT_LOAD, PathEnd

OTHER_RATE = "V is carried by vertical springs of another rate"
UNLOADED = "w under less than the V at rest, {:.5g} MN, is that of unloading: without that V before, w is smaller"
# A vertical spring may exceed its range by this share before it counts as extrapolated (rounding).
SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Down:
    """w, V and marks by step (none for springs from a table), tangent dV/dw and range used (n,), words.

    used is inf where an elastic stiffness answers beyond the loads that it may. beyond: sentences on V beyond the
    calibrated range; message: no w carries V, and w is that of the end of the curve then. remarks: what w belongs to.
    """

    values: dict[str, Array] = field(default_factory=dict)
    tangent: Array | None = None
    used: Array | float = 0.0
    notes: list[str] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)
    message: str = ""
    remarks: list[str] = field(default_factory=list)


class Carrier(Protocol):
    """What carries vertical loads; attributes as those of `MacroModel`."""

    @property
    def length(self) -> float:
        """Skirt length [m]."""

    @property
    def vertical(self) -> VerticalTable | None:
        """Vertical springs."""

    @property
    def ends(self) -> Mapping[str, PathEnd]:
        """How the paths of the springs ended."""

    @property
    def elastic_loads(self) -> tuple[float, float]:
        """Vertical loads [N] that an elastic stiffness may answer."""


def vertical_answer(
    model: MacroModel, w: Array | None, V: Array | None, imposed: float | Array | None, states: Array
) -> Down:
    """Return what goes with lateral states (n, 2) = (u, rotation) under a vertical load.

    w, V : Vertical displacement [m] and load [N] of the lateral springs by step; None if a table has none.
    imposed : Imposed vertical load [N], one number or one a step; None: that of the lateral springs.
    """
    if model.stiffness_initial is None or w is None or V is None:
        if imposed is not None:
            raise refused("V", "these springs come from a table without vertical paths (family tz): leave V out")
        return Down()
    response = model.response
    w = w + response.settled(model.vertical, imposed, model.settled)
    V = V if imposed is not None and response.follows(imposed) else _held(model, V)
    if imposed is None:
        return Down({**_other_rate(model, V, False), "w": w, "V": V, "off_load": np.zeros(w.size, dtype=np.int8)})
    down = np.full_like(V, imposed)
    other = ~same_loads(down, V)
    rest = response.rest[1]
    own = np.where(same_loads(V, rest), rest, V)  # on a path V is held to the tolerance of the solver
    far = ~covered(model.vertical, down, own)
    follows = response.follows(down)
    moved = response.lacks(down, far) & (states != 0.0).any(axis=1)
    marks = {"V": down, "off_load": moved.astype(np.int8)}
    if model.vertical is None:
        K = float(model.stiffness_initial[1, 1])
        elastic = f"w from the elastic vertical stiffness{sudden(model.attrs.get('drainage'))}"
        notes = [other_load(model.origin, down[other]) + elastic] if other.any() else []
        notes = [note if follows else f"{note}, lateral springs unchanged" for note in notes]
        notes += response.lacks_notes(down, moved) if follows else []
        past, beyond = past_elastic(model, down, other)
        return Down(
            marks | {"w": w + (down - V) / K, "off_load": (moved if follows else far | moved).astype(np.int8)},
            used=np.where(past, np.inf, 0.0),
            notes=notes,
            beyond=beyond,
        )
    there = response.settle(model.vertical, down)
    used, alone, timed = there[2], there[-1], _other_rate(model, down, other)
    left = _left(model.vertical, down[far & moved], own[far & moved])
    carried = {"converged": (~np.isnan(alone)).astype(np.int8)}
    return Down(
        marks | timed | carried | {"w": w + there[0] - model.vertical.displacements(V)[0]},
        there[1],
        np.nan_to_num(used, nan=np.inf),
        [f"{note}{left}" for note in response.lacks_notes(down, moved)]
        + [OTHER_RATE] * any(marks.any() for marks in timed.values()),
        beyond_springs(model, down, alone),
        no_equilibrium(model, down[np.isnan(alone)]),
        _unloaded(model.vertical, (down < own) & other, down),
    )


def _held(model: MacroModel, V: Array) -> Array:
    """Return V (n,) [N] of lateral springs: that at rest where their paths are given it; what solvers leave goes."""
    given = all(path.free_to_heave for path in model.behind)
    return np.full_like(V, model.response.rest[1]) if given else V


def _unloaded(table: VerticalTable, less: Marks, V: Array) -> list[str]:
    """Return a sentence on w where V (n,) [N] is less than at rest, and than that of the springs (marks)."""
    w, rest = table.rest
    return [UNLOADED.format(1e-6 * rest)] if w > 0.0 and (less & (rest > V)).any() else []


def _other_rate(model: MacroModel, V: Array, other: Marks | bool) -> dict[str, Any]:
    """Return the mark of V (n,) [N], where they are other than that at rest, whose vertical path has another rate.

    Nothing where the springs have no rate, or no vertical paths.
    """
    if model.rate is None or model.vertical is None:
        return {}
    rates = np.zeros(V.size)
    for branch, own in model.vertical.sides(V - model.vertical.rest[1]):
        rates[own] = branch.rate or 0.0
    return {"off_rate": (off_rate(model.rate, rates, np.ones(V.size)) & other).astype(np.int8)}


def _left(table: VerticalTable, V: Array, own: Array) -> str:
    """Return words for the least share of loads at equal motion that V (n,) [N] leaves of springs at V `own` (n,)."""
    least = share_left(table, V, own).min(initial=1.0)
    text = f", loads at equal motion at least {100.0 * least:.0f} % of those of the springs"
    return text if 0.0 < least < 1.0 else ""


def along_vertical(table: VerticalTable, path: SpringPath) -> xr.Dataset:
    """Return what the vertical springs answer at the w [m] of a path, with the variables and attrs of a prediction."""
    w = path.w
    rows, nothing = table.reactions(w), np.zeros(w.size)
    values = {"u": nothing, "w": w, "rotation": nothing, "H": nothing, "V": rows[-1], "M": nothing}
    used = table.used(w)
    marks = {"converged": np.ones(w.size), "extrapolated": used > 1.0 + SLACK, "off_path": nothing, "off_load": nothing}
    marks |= {"turned_back": nothing, "beyond_end": nothing}
    values |= {"range_used": used} | {name: mark.astype(np.int8) for name, mark in marks.items()}
    data: dict[str, Any] = variables.described(values, "prediction") | {
        "t": (("depth", "step"), rows[table.name == "t"], {"units": "N m-1"}),
        "u_at_load": ("step", nothing, {"units": "m"}),
    }
    data |= variables.described({"usable": np.ones(path.depth.size, dtype=np.int8)}, "prediction")
    coords = variables.described({"depth": path.depth}, "prediction") | {"step": np.arange(w.size)}
    attrs = {"springs": "vertical", "path": table.path, "status": "complete", "message": "", "warnings": []}
    return xr.Dataset(data, coords, attrs)


def beyond_springs(model: Carrier, V: Array, used: Array) -> list[str]:
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
            reach = f"they reach {used[beyond].max():.3g} times the calibrated displacement (limit 1)"
            worst = V[beyond][np.argmax(branch.sign * V[beyond])]
            sentences.append(
                f"V = {with_prefix(worst, 'N', 6)} is beyond the vertical springs (path {branch.path}): "
                f"{'no w carries it' if np.isnan(used[beyond]).any() else reach}; they carry "
                f"{model.vertical.limits()}; {model.ends[branch.path]}"
            )
    return sentences


def no_equilibrium(model: Carrier, V: Array) -> str:
    """Return a sentence on vertical loads (n,) [N] that no w carries; empty without any."""
    assert model.vertical is not None
    if not V.size:
        return ""
    return f"macro-model: no vertical equilibrium under V = {list_of(V)}; the springs carry {model.vertical.limits()}"


def largest_vertical(model: MacroModel, V: float) -> tuple[float, str, str]:
    """Return the largest known vertical load in the direction of V [N, positive down], its kind, and where it is from.

    Pressure takes the path downwards, tension the one upwards. NaN and blank words where that path is missing, or does
    not come to a load of this sign.
    """
    branch = None if model.vertical is None else model.vertical.branch(V)
    if branch is None or branch.sign * branch.largest <= 0.0:
        return np.nan, "", ""
    largest, end = branch.largest, model.ends.get(branch.path)
    if end is not None and end.how == LIMIT_LOAD:
        return largest, f"{LIMIT_LOAD} of the full model", f"path '{branch.path}' {end.words}"
    stopped = end is not None and end.failed
    kind = "limit load of the springs" if branch.is_flat and not stopped else RANGE_END
    pace = f" ({1e3 * branch.rate:.3g} mm/s)" if branch.rate and model.rate else ""
    source = f"path '{branch.path}'{pace}, at a settlement of {branch.sign * branch.end[0]:.4g} m from rest"
    return largest, kind, f"{source}; it stopped: {end.reason}" if end is not None and stopped else source


def with_vertical_use(model: MacroModel, answer: xr.Dataset) -> xr.Dataset:
    """Return an answer with `utilisation_V` by step or case, and the largest known V of its last state as attributes.

    Unchanged where it has no V or the springs no vertical paths.
    """
    if model.vertical is None or "V" not in answer:
        return answer
    V = answer["V"].values
    known = variables.GROUPS["prediction"]["utilisation_V"].attributes()
    added = answer.assign(utilisation_V=(answer["V"].dims, vertical_use(model, V)["utilisation_V"], known))
    largest, kind, source = largest_vertical(model, float(V[-1])) if V.size else (np.nan, "", "")
    of_last = {"capacity_V_N": largest, "capacity_V_kind": kind, "capacity_V_from": source}
    return added.assign_attrs(of_last) if kind else added


def vertical_use(model: MacroModel, V: Array) -> dict[str, Any]:
    """Return by vertical load V (n,) [N] the largest known one of its sign, its kind, and the share of it that is used.

    Names: capacity_V, capacity_V_kind, utilisation_V; NaN and blank where none is known.
    """
    down, up = (largest_vertical(model, sign) for sign in (1.0, -1.0))
    largest = np.where(V >= 0.0, down[0], up[0])
    kind = np.where(V >= 0.0, np.array(down[1], dtype=object), np.array(up[1], dtype=object))
    return {"capacity_V": largest, "capacity_V_kind": kind, "utilisation_V": V / largest}


def past_elastic(model: Carrier, V: Array, elastic: Marks) -> tuple[Marks, list[str]]:
    """Return which vertical loads V (n,) [N] are beyond an elastic stiffness, of those it answers, and a sentence."""
    low, high = model.elastic_loads
    marks = elastic & ((low > V) | (high < V)) & ~same_loads(V, low) & ~same_loads(V, high)
    if not marks.any():
        return marks, []
    worst = V[marks][np.argmax(np.abs(V[marks]))]
    return marks, [
        f"V = {with_prefix(worst, 'N', 6)}: without vertical springs in this direction V is known from "
        f"{with_prefix(low, 'N', 6)} to {with_prefix(high, 'N', 6)} "
        "(a change no larger than the vertical load of the paths): add a path of kind 'vertical'"
    ]
