# SPDX-License-Identifier: MIT
"""The answer of the macro-model along a way: a dataset by step, marked, warned of or refused where springs lack."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypedDict

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import BeyondSprings, Problem, RunIncomplete, refused
from pysprings.core.loads import NO_LOAD, same_loads
from pysprings.macro.capacity import past_ends
from pysprings.macro.model import MacroModel
from pysprings.macro.response import Between, Level, Support
from pysprings.macro.vertical_answer import Down, vertical_answer
from pysprings.macro.ways import RANGE_SLACK, Along, Control, Limit, Turns
from pysprings.springs.path import off_rate
from pysprings.springs.path_ends import MESH_ERROR

_KEPT = (
    "Conventions", "title", "source", "pysprings_version", "scene_sha256", "drainage", "outer_diameter_m",
    "skirt_length_m", "atlas_outside", "atlas_mesh",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Way:
    """States that were solved, and what was asked for.

    states, loads : (n, 2) = (u [m], rotation [rad]) and (H [N], M [N m]).
    control : what was imposed.
    V : vertical load asked for [N], one number or one a state (None: that of the springs).
    arm : height of the load [m]; None for independent cases.
    message : where the way ended before its aim; empty where it did not.
    time : (n,) [s] of the states from rest; None: not known.
    between : the way to the states (`pysprings.macro.response.Response.between`).
    along : what of the way is to be marked.
    """

    states: Array
    loads: Array
    control: Control
    V: Level = None
    arm: float | None = None
    message: str = ""
    along: Along = field(default_factory=Along)
    time: Array | None = None
    between: Between = None


def trace(
    model: MacroModel, control: Control, targets: Array, arm: float = 0.0, V: Level = None, time: Array | None = None
) -> xr.Dataset:
    """Return the answer of `MacroModel.solve` as a dataset by step, marked, warned of or refused where springs lack.

    A way that ends early holds the steps reached; `status` is then "partial" and `message` has the place.
    V [N] is one number, or one a target. time [s], one a target, from rest at 0 s: steps at another rate than that of
    springs that have one are marked.
    """
    targets = np.asarray(targets, dtype=float)
    V = None if V is None else np.asarray(V, dtype=float) if np.ndim(V) else float(V)
    states, loads, message = model.solve(control, targets, arm, V=V)
    n = len(states)
    down, at = V[:n] if isinstance(V, np.ndarray) else V, None if time is None else time[:n]
    along = model.response.along(control, targets, arm, states, down, model.rest_load)
    between = model.response.between(control, targets[:n], arm, states, down) if n else None
    answer = answer_dataset(model, Way(states, loads, control, down, float(arm), message, along, at, between))
    return answer if at is None else _timed(model, answer, states, at)


def _timed(model: MacroModel, answer: xr.Dataset, states: Array, time: Array) -> xr.Dataset:
    """Return an answer with the times (n,) [s] of its states, and marks of steps at another rate, from rest at 0 s."""
    values, warnings = rate_marks(model.rate, np.diff(states * [1.0, model.length], axis=0, prepend=0.0), time)
    if "off_rate" in values and "off_rate" in answer:  # of V
        values["off_rate"] = values["off_rate"] | answer["off_rate"].values
    timed = answer.assign(variables.described(values, "prediction"))
    return timed.assign_attrs(warnings=[*answer.attrs["warnings"], *warnings])


def rate_marks(rate: float | None, steps: Array, time: Array) -> tuple[dict[str, Array], list[str]]:
    """Return the time (n,) [s], and marks of steps (n, m) [m] off the rate of springs that have one; and a sentence."""
    if rate is None:
        return {"time": time}, []
    off = off_rate(rate, np.linalg.norm(steps, axis=1), np.diff(time, prepend=0.0))
    text = f"{off.sum()} of {off.size} steps are at another rate than that of the springs"
    return {"time": time, "off_rate": off.astype(np.int8)}, [text] if off.any() else []


def answer_dataset(model: MacroModel, way: Way) -> xr.Dataset:
    """Return the states and loads of a way as a dataset by step, with w, V, p, the stiffness, and marks."""
    states, u, rotation = way.states, *way.states.T
    support = model.response.support(states, way.time, way.V, way.between)
    down = vertical_answer(model, support.w, support.V, way.V, states)
    depth = model.origin.depth
    nowhere = np.zeros(u.size, dtype=bool)
    turned = way.along.turned or Turns(nowhere, nowhere)
    past, refusals = past_ends(model, states, support.used, way.loads, down.values.get("V"), way.along.aim)
    values = {
        "u": u,
        "rotation": rotation,
        "H": way.loads[:, 0],
        "M": way.loads[:, 1],
        "converged": np.ones(u.size, dtype=np.int8),
        "depth_bounds": model.origin["depth_bounds"],
        "usable": support.usable,
        "y": (u - rotation * depth[:, None]) * (np.nan if model.attrs.get("caisson_behaviour") == "elastic" else 1.0),
        "p": support.p,
        "range_used": support.used,
        "extrapolated": model.response.lasting(np.fmax(support.used, down.used) > 1.0 + RANGE_SLACK).astype(np.int8),
    } | down.values
    values["turned_back"] = turned.back.astype(np.int8)
    values |= _where_known(support, turned, model.response.lasting(support.off)) | _mesh_errors(
        model, states, down.values.get("V")
    )
    values["beyond_end"] = past.astype(np.int8)
    coords: dict[str, Any] = variables.described({"depth": depth}, "prediction") | {"step": np.arange(u.size)}
    coords |= variables.described({} if support.water is None else {"side": list(variables.SIDES)}, "prediction")
    tangent = model.tangents(states, down.tangent, way.V)
    coords |= {name: tangent.coords[name].variable for name in ("dof", "dof_conjugate")}
    lateral = tangent.values[:, ::2, ::2] if tangent.shape[1] == 3 else tangent.values
    spread = model.response.deviations(way.control, states, lateral, way.arm or 0.0)
    data = variables.described(values | dict(spread), "prediction") | {"stiffness": tangent.variable}
    return xr.Dataset(data, coords, _attributes(model, way, support, turned, down, refusals))


def _where_known(support: Support, turned: Turns, off: Marks) -> dict[str, Array]:
    """Return what not all springs have, by name; off (n,): away from the calibrated paths."""
    values: dict[str, Array] = {}
    if support.water is not None:
        values["p_water"] = support.water
    if support.distance is not None:
        values["path_distance"] = support.distance
    if support.softened is not None:
        values["past_peak"] = support.softened.astype(np.int8)
    if support.distance is not None or turned.aside.any():
        values["off_path"] = (off | turned.aside).astype(np.int8)
    return values


def _mesh_errors(model: MacroModel, states: Array, V: Array | None) -> dict[str, Array]:
    """Return the error of the mesh by step: the largest of the paths beside each state; nothing where none has one.

    Where a vertical load V (n,) [N] alone acts it is that of the vertical path in its direction: of a path it is a
    share of the change of V, here of V.
    """
    known = {name: end.mesh_error for name, end in model.ends.items()}
    if not np.isfinite(list(known.values())).any():
        return {}
    errors = np.array(
        [max((known[name] for name in names), default=np.nan) for names in model.response.paths_at(states)]
    )
    if V is not None and model.vertical is not None:
        rest = model.vertical.rest[1]
        for k in np.flatnonzero(~states.any(axis=1) & ~same_loads(V, rest)):
            branch, errors[k] = model.vertical.branch(V[k] - rest), np.nan
            if branch is not None:
                change, size = abs(branch.largest - rest), max(abs(branch.largest), abs(V[k]), NO_LOAD)
                errors[k] = known[branch.path] * change / size
    return {MESH_ERROR: errors}


def _attributes(
    model: MacroModel, way: Way, support: Support, turned: Turns, down: Down, refusals: list[str]
) -> dict[str, Any]:
    """Return the attributes of an answer: provenance, what was asked for, status, and sentences.

    refusals: beyond a limit load; beyond_range: what is beyond the calibrated range; warnings: other marks; remarks.
    """
    message = " ".join(filter(None, (way.message, down.message)))
    edge = filter(None, [str(model.attrs.get("atlas_outside", ""))])  # of the full models of an atlas
    beyond = np.flatnonzero(support.used > 1.0 + RANGE_SLACK)
    limit = way.along.limit(int(beyond[0])) if way.along.limit is not None and beyond.size else None
    outside = [_beyond(model, way.states, support.used, limit)] if beyond.size else []
    carried = f"; {limit}" if limit else ""
    return (
        origin_of(model.attrs)
        | {"springs": model.spring_set, "curves": model.response.curves}
        | model.response.provenance()
        | {"control": way.control}
        | ({} if way.arm is None else {"arm_m": way.arm})
        | ({} if model.rate is None else {"rate_m_per_s": model.rate})
        | (limit.attributes() if limit else {})
        | {"status": "partial" if message else "complete", "message": message}
        | {
            "warnings": [*support.notes, *turned.notes(), *down.notes, *edge, *way.along.notes],
            "beyond_range": outside + down.beyond,
        }
        | {"remarks": [*model.remarks, *down.remarks], "path_end": _ends(model), "balance": model.balance}
        | {"refusals": [f"{text}{carried}" for text in refusals]}
    )


def _ends(model: MacroModel) -> str:
    """Return how the paths behind the lateral springs ended, in one text."""
    ends = {name: model.ends[name].how for name in model.response.sources}
    return (
        ends[model.response.sources[0]] if len(ends) == 1 else ", ".join(f"{name}: {how}" for name, how in ends.items())
    )


def _beyond(model: MacroModel, states: Array, used: Array, limit: Limit | None) -> str:
    """Return a sentence on states beyond the range of the springs, with the load within it and how its paths ended."""
    where, what = model.response.range_words()
    text = f"beyond the range of {where} {used.max():.3g} times {what} calibrated "
    text += "displacement (limit 1)"
    (names,) = model.response.paths_at(states[[int(np.argmax(used))]])
    ends = [str(model.ends[name]) for name in names if name in model.ends]
    return "; ".join(filter(None, (text, "" if limit is None else str(limit), *ends)))


def origin_of(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Return those attributes of springs that each of their answers has: scene, program, caisson."""
    return {name: attrs[name] for name in _KEPT if name in attrs}


ASK = "predict --extrapolate (extrapolate=True) answers beyond it, marked"


class MacroWarning(UserWarning):
    """An answer of the macro-model that the springs support only in part."""


class PredictionNotConverged(RunIncomplete):
    """No equilibrium was found beyond a load; the message names it and the part that was reached."""


class Care(TypedDict, total=False):
    """Keywords on answers that springs support in part.

    strict : refuse every answer with a mark.
    extrapolate : answer beyond the calibrated range, with marks; without, that is refused.
    """

    strict: bool
    extrapolate: bool


def raise_or_warn(answer: xr.Dataset, strict: bool = False, extrapolate: bool = False) -> xr.Dataset:
    """Return an answer; raise where it is beyond the springs or partial, warn (raise, when strict) where it is marked.

    Every answer passes here but those of `predict_batch`, which are marked by case.
    """
    if strict and extrapolate:
        raise refused("strict", "refuses what extrapolate asks for: give one of them")
    if answer.attrs["refusals"]:
        raise _refusal(answer.attrs["refusals"])
    beyond = answer.attrs["beyond_range"]
    if beyond and not extrapolate:
        raise _refusal([f"{text}; {ASK}" for text in beyond])
    if answer.attrs["status"] != "complete":
        raise PredictionNotConverged(answer.attrs["message"])
    notes = [*beyond, *answer.attrs["warnings"]]
    marks = [*notes, *filter(None, [str(answer.attrs.get("atlas_mesh", ""))])]
    if strict and marks:
        raise refused("strict", "; ".join(marks))
    for note in notes:
        warnings.warn(note, MacroWarning, stacklevel=4)
    return answer.assign_attrs(warnings=notes)


def _refusal(texts: list[str]) -> BeyondSprings:
    return BeyondSprings([Problem(key="springs", message=text) for text in texts])
