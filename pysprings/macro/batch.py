# SPDX-License-Identifier: MIT
"""Many independent load cases at once: motions, stiffness, range and capacity by case, marked and never raised."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arguments import check_arrays, check_shapes
from pysprings.core.arrays import Array, Integers, Marks, Texts
from pysprings.core.errors import refused
from pysprings.core.loads import InPlane, in_plane
from pysprings.core.words import NOT_KNOWN
from pysprings.macro.answer import Way, answer_dataset
from pysprings.macro.capacity import FULL_LIMIT, Capacities, capacities, with_bound
from pysprings.macro.directions import off_plane, with_components
from pysprings.macro.fan_springs import DEVIATIONS
from pysprings.macro.model import AnySprings, MacroModel, typed
from pysprings.macro.predict import SpringChoice, loads_of, model_of
from pysprings.macro.space import SpaceAnswers, answers_in_space
from pysprings.macro.stiffness import torsion_of
from pysprings.macro.vertical import covered
from pysprings.macro.vertical_answer import vertical_use
from pysprings.macro.ways import RANGE_SLACK
from pysprings.springs.path import SPACE_LOADS, SPACE_TURNS
from pysprings.springs.springs import Springs

_GIVEN = ("H", "M", "V", "H_x", "H_y", "M_x", "M_y", "T", "direction", "rot_z")
_IN_PLANE = ("utilisation", "utilisation_V", "capacity_H", "capacity_M", "capacity_V")
_NO_CAPACITY: dict[str, Any] = {
    "utilisation": np.nan, "capacity_H": np.nan, "capacity_M": np.nan, "capacity_kind": NOT_KNOWN, "capacity_from": "",
}  # fmt: skip
_MOTIONS = ("u", "w", "rotation", "stiffness", *DEVIATIONS)
_OF_CASES = {  # unit and meaning of what answers by case alone have
    "H": ("N", "lateral load, in the plane of the case"),
    "M": ("N m", "moment about the lid centre at mudline, in the plane of H"),
    "answered": ("1", "1 where u, w, rotation, stiffness are the answer; 0: they are NaN"),
    "why_not": ("1", "why a case has no answer"),
    "utilisation": ("1", "load over the largest one that is known in its direction; see capacity_kind"),
    "capacity_H": ("N", "H of the largest load that is known in the direction of the load"),
    "capacity_M": ("N m", "M of the largest load that is known in the direction of the load"),
    "capacity_kind": ("1", "what ends the largest known load"),
    "capacity_from": ("1", "where the largest known load comes from"),
    "utilisation_V": ("1", "V over the largest vertical load that is known of its sign; see capacity_V_kind"),
    "capacity_V": ("N", "largest vertical load that is known of the sign of V"),
    "capacity_V_kind": ("1", "what ends the largest known vertical load"),
    "in_space": ("1", "1 where springs in space answer"),
    "plane_difference_pct": ("percent", "difference of springs in space from those in one plane, of (u, rotation L)"),
}
PAST, SIDEWAYS = "beyond a limit load of the full model", "beyond the calibrated range of the springs"
# largest difference of springs in space from those in one plane [%] that is no mark, and the mark
MOST_APART, APART = 2.0, "springs in space move {:.2g} % unlike those in one plane under H and M in the plane of H"
DOWN, LOST = "V beyond the calibrated range of the vertical springs", "no equilibrium"
ELASTIC = "V beyond what is known without vertical springs, 0 to twice that of the paths"
# attributes of one way of states: a batch has marks by case in their place
_OF_A_WAY = ("warnings", "beyond_range", "refusals", "status", "message")


def predict_batch(
    springs: AnySprings | MacroModel,
    *,
    H: float | Array | None = None,
    arm: float | Array | None = None,
    M: float | Array | None = None,
    V: float | Array | None = None,
    H_x: float | Array | None = None,
    H_y: float | Array | None = None,
    M_x: float | Array | None = None,
    M_y: float | Array | None = None,
    T: float | Array | None = None,
    extrapolate: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Predict the motion under many independent loads (dimension case).

    H [N], arm [m] or M [N m], and V [N] are numbers or arrays (n,); or components, right-handed with z up: H_x,
    H_y [N], M_x, M_y [N m] in place of H and M, and torsion T [N m]. Answers to these have their components, too
    (`direction`, `u_x` ...). A case whose H and M do not lie in one vertical plane, or that has T, is answered by
    springs in space (`answer_from_all_sides`). Without such springs the first is not answered; with T `rot_z` is T over
    the stiffness at rest (`linear_twist`; NaN where no full model has computed it), and T changes nothing else.
    Answer and marks of a case depend on that case alone, bit for bit. A thousand cases take about a second; of springs
    at several vertical loads, where every V has springs of its own, about fifteen. What `predict` raises or warns of is
    a mark by case here:

    - `answered` 1: u, w, rotation, stiffness, deviations are the answer; 0: they are NaN, and `why_not` has the reason;
    - `extrapolated`: beyond the calibrated range, answered with extrapolate only;
    - `beyond_end`: beyond a limit load of the full model, never answered;
    - `converged` 0: no equilibrium (u, w, rotation NaN);
    - `off_path`, `off_load`, `off_rate`, `past_peak`: answered, and supported in part.

    `utilisation_V` is V over the largest known vertical load of its sign, where the springs have vertical paths.
    `utilisation` is the load over the largest known one in its direction, `capacity_H` [N], `capacity_M` [N m]; it is a
    capacity, or only the end of what is known (`capacity_kind`, `capacity_from`), and NaN in a case without an answer
    whose V the lateral springs do not cover. `stiffness` (case, dof, dof_conjugate) is the tangent.
    """
    asked = {"H": H, "arm": arm, "M": M, "V": V, "H_x": H_x, "H_y": H_y, "M_x": M_x, "M_y": M_y, "T": T}
    check_arrays(**asked)
    check_shapes(**asked)
    down, parts = np.nan if V is None else V, any(each is not None for each in (H_x, H_y, M_x, M_y))
    if parts and not H is arm is M is None:
        raise refused("H", "give H with arm or M, or components, not both")
    if not parts and T is None:
        force, moment, down = _columns(*loads_of(H, arm, M), down)
        return _in_words(answer_loads(springs, np.stack([force, moment], axis=1), down, extrapolate, **choice))
    if not H is arm is M is None:
        H_x, M_y = loads_of(H, arm, M)
    given = (0.0 if each is None else each for each in (H_x, H_y, M_x, M_y, T))
    x, y, about_x, about_y, torsion, down = _columns(*given, down)
    loads = in_plane(np.stack([x, y], axis=1), np.stack([about_y, -about_x], axis=1))
    answers = answer_from_all_sides(springs, loads, torsion, down, extrapolate, **choice)
    by_space = answers["in_space"].values == 1 if "in_space" in answers else np.zeros(len(loads.H), dtype=bool)
    return _in_words(_off_plane(answers, np.where(by_space, 0.0, loads.across)))


def _in_words(answers: xr.Dataset) -> xr.Dataset:
    """Return answers with the meaning and the unit of every variable."""
    found = variables.attach(variables.attach(answers, "space_prediction"), "prediction")
    for name, (units, words) in _OF_CASES.items():
        if name in found:
            found[name].attrs = {"long_name": words, "units": units}
    if "direction" in found:
        for name, axis in (("u", "displacement"), ("rotation", "rotation")):
            found[name].attrs["comment"] = f"along `direction`; of springs in space the size of the {axis}"
    return found


def _columns(*values: float | Array) -> list[Array]:
    """Return numbers and arrays (n,) as rows (n,)."""
    columns = [np.atleast_1d(each) for each in np.broadcast_arrays(*(np.asarray(v, float) for v in values))]
    if not columns[0].size:
        raise refused("H", "no load case is given")
    return columns


def _off_plane(answers: xr.Dataset, across: Array) -> xr.Dataset:
    """Return answers without those to loads that have a moment (n,) [N m] across their plane."""
    inside = across == 0.0
    why = [off_plane(each) if each else text for text, each in zip(answers["why_not"].values, across, strict=True)]
    found = _blank(answers, inside, _GIVEN)
    values = {
        name: (found[name] * xr.DataArray(inside, dims="case")).astype(np.int8) for name in ("answered", "converged")
    }
    return found.assign(values | {"why_not": ("case", np.array(why, dtype=object))})


def _blank(answers: xr.Dataset, inside: Marks, kept: tuple[str, ...]) -> xr.Dataset:
    """Return answers whose numbers, but for those to be kept, are NaN in cases that are not inside (n,)."""
    numbers = [str(name) for name, each in answers.items() if each.dtype.kind == "f" and name not in kept]
    return answers.assign({name: answers[name].where(xr.DataArray(inside, dims="case")) for name in numbers})


def answer_from_all_sides(
    springs: AnySprings | MacroModel,
    loads: InPlane,
    T: Array,
    V: Array,
    extrapolate: bool = False,
    space: SpaceAnswers | None = None,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Answer loads in their planes, with a moment across and T (n,) [N m], at V (n,) [N]; NaN: that of the springs.

    space: the springs in space of this choice, where the caller has them; else they are looked for.

    Cases with T or a moment across are answered by springs in space where there are any (`in_space` 1), each in
    proportion from rest: u and rotation are sizes of vectors, stiffness is NaN; `unchecked`, `torsion_apart` mark it
    as a sequence. Their utilisation and capacity are not known (NaN), but where H and M in the plane of H alone are
    beyond theirs, which are given then: the whole load is, too. What is beyond a limit load there, or beyond the
    vertical springs, has no answer. `plane_difference_pct`: difference of springs in space from the springs in one
    plane under that H and M. Without springs in space the part in the plane is answered.
    """
    source = springs if isinstance(springs, MacroModel) else typed(springs)
    answers = answer_loads(source, np.stack([loads.H, loads.M], axis=1), V, extrapolate, **choice)
    aside = (loads.across != 0.0) | (T != 0.0)
    if space is None and aside.any():
        space = answers_in_space(source, **choice)
    if space is not None and not space.response.has_torsion:
        aside = (loads.across != 0.0) & (T == 0.0)
    linear = np.ones(len(T), dtype=bool) if space is None else ~aside
    found = with_components(answers, loads, T, torsion_of(source), linear)
    return found if space is None else _by_space(found, space, (aside, V), extrapolate)


def _by_space(found: xr.Dataset, space: SpaceAnswers, cases: tuple[Marks, Array], extrapolate: bool) -> xr.Dataset:
    """Return answers with those of springs in space to cases aside of one plane, (marks (n,), V (n,) [N])."""
    aside, V = cases
    rows = np.flatnonzero(aside)
    own = space.cases(np.stack([found[name].values[rows] for name in SPACE_LOADS], axis=1), V[rows])
    why = np.array(
        [text if text in (PAST, DOWN, ELASTIC) else "" for text in found["why_not"].values[rows]], dtype=object
    )
    over = (own["extrapolated"] == 1) & (not extrapolate)
    for marks, text in ((over, SIDEWAYS), (own["converged"] == 0, LOST)):
        why[marks & (why == "")] = text
    answered = why == ""
    own["u"], own["rotation"] = np.hypot(own["u_x"], own["u_y"]), np.hypot(own["rot_x"], own["rot_y"])
    own |= {name: np.where(answered, own[name], np.nan) for name in ("u", "w", "rotation", *SPACE_TURNS)}
    own |= {"past_peak": np.zeros(len(rows), dtype=np.int8)} if "past_peak" in found else {}
    own |= {"answered": answered, "converged": answered, "why_not": why, "in_space": np.ones(len(rows), dtype=np.int8)}
    own["plane_difference_pct"] = _difference(found.isel(case=rows), space, V[rows])
    over = found["utilisation"].values[rows] > 1.0
    own |= {name: np.where(over, found[name].values[rows], none) for name, none in _NO_CAPACITY.items()}
    out, values = _blank(found, ~aside, (*_GIVEN, *_IN_PLANE)), {}
    for name, value in own.items():
        empty = np.full(len(V), np.nan) if value.dtype.kind == "f" else np.zeros(len(V), dtype=np.int8)
        every = out[name].values.copy() if name in out else empty
        every[rows] = value
        values[name] = ("case", every, out[name].attrs if name in out else {})
    return out.assign(values).assign_attrs(remarks=[*found.attrs["remarks"], space.errors], space_errors=space.errors)


def _difference(found: xr.Dataset, space: SpaceAnswers, V: Array) -> Array:
    """Return how far springs in space are from answers in a plane [%], of (u, rotation L) under their H and M."""
    c, s = np.cos(found["direction"].values), np.sin(found["direction"].values)
    H, M = found["H"].values, found["M"].values
    own = space.cases(np.stack([c * H, s * H, -s * M, c * M, 0.0 * H], axis=1), V)
    scale, lateral = np.array([1.0, 1.0, space.length, space.length]), SPACE_TURNS[:4]
    here, there = (scale * np.stack([each[name] for name in lateral], axis=1) for each in (own, found))
    size = np.linalg.norm(there, axis=1)
    return 100.0 * np.linalg.norm(here - there, axis=1) / np.where(size > 0.0, size, np.nan)


def answer_loads(
    springs: AnySprings | MacroModel, loads: Array, V: Array, extrapolate: bool = False, **choice: Unpack[SpringChoice]
) -> xr.Dataset:
    """Answer loads (n, 2) = (H [N], M [N m]) at vertical loads V (n,) [N]; NaN: that of the springs. See above."""
    source = springs if isinstance(springs, MacroModel) else typed(springs)  # what it derives is kept for all cases
    parts, order = [], []
    for at, rows in _alike(V, _range_of(source, choice.get("path"))):
        model = model_of(source, V=at, **choice)
        model.response.check_state("cases")
        parts.append(_answers(model, loads[rows], None if np.isnan(V[rows[0]]) else V[rows], extrapolate))
        order.append(rows)
    return _joined(parts, np.argsort(np.concatenate(order)))


def _range_of(springs: Any, path: str | None) -> tuple[float, float] | None:
    """Return the range [N] within which every vertical load has lateral springs of its own; None: there is none."""
    sets = springs.load_sets if isinstance(springs, Springs) and path is None else ()
    return (sets[0].V, sets[-1].V) if len(sets) > 1 else None


def _alike(V: Array, own: tuple[float, float] | None) -> Iterator[tuple[float | None, Integers]]:
    """Yield vertical loads [N] and the places in V (n,) that take the springs at them; None: those at rest.

    Between the loads of `own` every V has its own springs, beyond them those of the end; where it is None all have one.
    """
    key = np.where(np.isnan(V), np.nan, 0.0) if own is None else np.clip(V, *own)
    values, place = np.unique(key, return_inverse=True)
    order = np.argsort(place, kind="stable")
    for value, rows in zip(values, np.split(order, np.flatnonzero(np.diff(place[order])) + 1), strict=True):
        yield (None if own is None or np.isnan(value) else float(value)), rows


@dataclass(frozen=True, slots=True)
class _Part:
    """Answers of one model: dims, values by case and attributes of each variable; coordinates; attributes."""

    values: dict[str, tuple[tuple[Any, ...], Any, dict[str, Any]]]
    coords: dict[str, Any]
    attrs: dict[str, Any]


def _joined(parts: list[_Part], order: Integers) -> xr.Dataset:
    """Return answers of several models, by case, as one dataset in an order; attributes are those that all have.

    A remark that not all have is named as one of some V.
    """
    first = parts[0]
    data = {
        name: (dims, np.concatenate([part.values[name][1] for part in parts])[order], attrs)
        for name, (dims, _, attrs) in first.values.items()
    }
    attrs = {k: v for k, v in first.attrs.items() if k not in _OF_A_WAY and all(p.attrs.get(k) == v for p in parts)}
    own = [set(part.attrs["remarks"]) for part in parts]
    remarks = {text if all(text in each for each in own) else f"at some V: {text}" for text in set().union(*own)}
    return xr.Dataset(data, first.coords, attrs | {"remarks": sorted(remarks)})


def _answers(model: MacroModel, targets: Array, V: Array | None, extrapolate: bool) -> _Part:
    """Return the answers of one model to loads (n, 2) = (H, M) at vertical loads V (n,)."""
    states, loads, reached = model.response.solve_cases(targets)
    answer = answer_dataset(model, Way(states, loads, "load", V))
    reached = reached & answer["converged"].values  # that is of V
    held = V is None and not model.origin.free_to_heave  # V follows from the motion
    down = answer["V"].values if "V" in answer else None
    largest = capacities(model, targets, down)
    answer = with_bound(model, answer, targets, largest.utilisation)
    limit = (largest.kind == FULL_LIMIT) & (largest.utilisation > 1.0 + RANGE_SLACK)
    past = (answer["beyond_end"].values == 1) | limit
    over = (answer["extrapolated"].values == 1) & (not extrapolate)
    why = _why_not(model, past, over, answer["range_used"].values > 1.0 + RANGE_SLACK, reached == 0)
    answered = why == ""
    if V is not None:
        _forget(largest, ~answered & ~covered(model.vertical, V, np.full(len(V), model.origin.load)))
    values = {
        str(name): (("case", *each.dims[1:]), each.values, each.attrs)
        for name, each in answer.variables.items()
        if each.dims[:1] == ("step",) and name not in ("step", "y")
    }
    for name in (*_MOTIONS, *["V"] * held):
        if name in values:
            dims, motion, attrs = values[name]
            values[name] = dims, np.where(answered.reshape(-1, *[1] * (motion.ndim - 1)), motion, np.nan), attrs
    by_case: dict[str, Any] = {
        "H": targets[:, 0], "M": targets[:, 1], "converged": np.where(answered, reached, 0).astype(np.int8),
        "beyond_end": past.astype(np.int8), "answered": answered.astype(np.int8), "why_not": why,
        "utilisation": largest.utilisation, "capacity_H": largest.H, "capacity_M": largest.M,
        "capacity_kind": largest.kind, "capacity_from": largest.source,
    }  # fmt: skip
    by_case |= {} if down is None or model.vertical is None else vertical_use(model, down)
    values |= {name: (("case",), each, {}) for name, each in by_case.items()}
    return _Part(values, {name: answer.coords[name].variable for name in ("dof", "dof_conjugate")}, answer.attrs)


def _why_not(model: MacroModel, past: Marks, over: Marks, sideways: Marks, lost: Marks) -> Texts:
    """Return the first reason that leaves each case (n,) without an answer; blank where it has one."""
    why, beyond = np.full(len(past), "", dtype=object), ELASTIC if model.vertical is None else DOWN
    for marks, text in ((past, PAST), (over & sideways, SIDEWAYS), (over, beyond), (lost, LOST)):
        why[marks & (why == "")] = text
    return why


def _forget(largest: Capacities, lost: Marks) -> None:
    """Leave blank the largest loads of cases (n,) without an answer whose V is not that of the springs."""
    for values in (largest.H, largest.M, largest.utilisation):
        values[lost] = np.nan
    loaded = lost & (largest.kind != "")
    largest.kind[loaded], largest.source[loaded] = NOT_KNOWN, "no answer at this V"
