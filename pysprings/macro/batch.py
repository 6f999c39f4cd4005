# SPDX-License-Identifier: MIT
"""Many independent load cases at once: motions, stiffness, range and capacity by case, marked and never raised."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Unpack

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.arguments import check_arrays
from pysprings.core.errors import refused
from pysprings.macro.answer import Way, answer_dataset
from pysprings.macro.capacity import FULL_LIMIT, capacities
from pysprings.macro.fan import RANGE_SLACK
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import SpringChoice, loads_of, model_of
from pysprings.macro.sets import AnySprings, Typed, typed
from pysprings.macro.vertical_capacity import with_vertical_use
from pysprings.springs.alike import NO_LOAD
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

TOGETHER = 0.01  # share by which vertical loads may differ that springs at one of them answer
_MOTIONS = ("u", "w", "rotation", "stiffness")
_NOT_BY_CASE = ["p", "p_water", "y", "usable", "depth", "depth_bounds", "side"]


def predict_batch(
    springs: AnySprings | MacroModel,
    *,
    H: float | Array,
    arm: float | Array | None = None,
    M: float | Array | None = None,
    V: float | Array | None = None,
    extrapolate: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Predict the motion under many independent loads (dimension case).

    H [N], arm [m] or M [N m], and V [N] are numbers or arrays of one shape.
    A thousand cases take about a second. What `predict` raises or warns of is a mark by case here:

    - `answered` 1: u, w, rotation and stiffness are the answer; 0: they are NaN, and `why_not` has the reason;
    - `extrapolated`: beyond the calibrated range, answered with extrapolate only;
    - `beyond_end`: beyond a limit load of the full model, never answered;
    - `converged` 0: no equilibrium (u, w, rotation NaN);
    - `off_path`, `off_load`: answered, and supported in part.

    `utilisation_V` is V over the largest known vertical load of its sign, where the springs have vertical paths.
    `utilisation` is the load over the largest known one in its direction, `capacity_H` [N], `capacity_M` [N m]; it is a
    capacity, or only the end of what is known (`capacity_kind`, `capacity_from`). `stiffness` (case, dof,
    dof_conjugate) is the tangent. Of springs at several vertical loads those at one V answer all cases within 1 % of
    each other; their w is that of their own V.
    """
    check_arrays(H=H, arm=arm, M=M, V=V)
    given = np.broadcast_arrays(*loads_of(H, arm, M), np.asarray(np.nan if V is None else V, dtype=float))
    force, moment, down = (np.atleast_1d(values).ravel() for values in given)
    if not force.size:
        raise refused("H", "no load case is given")
    source = springs if isinstance(springs, MacroModel) else typed(springs)  # what it derives is kept for all cases
    parts, order = [], []
    for rows in _together(down, _loads(source, choice.get("path"))):
        middle = rows.size // 2
        model = model_of(source, V=None if V is None else float(down[rows[middle]]), **choice)
        if model.memory is not None:
            raise refused("springs_kind", "springs with memory answer sequences, not independent cases: ask for 'fan'")
        targets = np.stack([force[rows], moment[rows]], axis=1)
        part = _answers(model, targets, None if V is None else down[rows], extrapolate)
        if V is not None and "off_load" in part and not part["off_load"].values[middle]:
            part["off_load"] = xr.zeros_like(part["off_load"])
        parts.append(part)
        order.append(rows)
    whole = parts[0] if len(parts) == 1 else xr.concat(parts, "case", combine_attrs="override", join="override")
    return whole.isel(case=np.argsort(np.concatenate(order)))


def _loads(springs: Typed | MacroModel, path: str | None) -> tuple[float, ...]:
    """Return the vertical loads [N] of lateral springs that depend on it; none where they do not."""
    sets = springs.load_sets if isinstance(springs, Springs) and path is None else ()
    return tuple(each.V for each in sets) if len(sets) > 1 else ()


def _together(V: Array, known: tuple[float, ...]) -> Iterator[NDArray[np.int64]]:
    """Yield the places of vertical loads (n,) that one V answers, by increasing V.

    All where none is given, or the springs do not depend on it; below and above the loads of the springs all of them,
    between them those that are within `TOGETHER`.
    """
    if not known or np.isnan(V).all():
        yield np.arange(V.size)
        return
    order = np.argsort(V, kind="stable")
    start = 0
    for k in range(1, V.size + 1):
        first, next_ = V[order[start]], V[order[min(k, V.size - 1)]]
        if k == V.size or not _alike(first, next_, known):
            yield order[start:k]
            start = k


def _alike(first: float, other: float, known: tuple[float, ...]) -> bool:
    """Return whether springs at one V [N] answer for another one that is not below it."""
    slack = max(TOGETHER * max(abs(first), abs(other)), NO_LOAD)
    low, high = min(known) - slack, max(known) + slack
    return other < low or first > high or (first >= low and other <= high and other - first <= slack)


def _answers(model: MacroModel, targets: Array, V: Array | None, extrapolate: bool) -> xr.Dataset:
    """Return the answers of one model to loads (n, 2) = (H, M) at vertical loads V (n,)."""
    states, loads, reached = model.solve_cases("load", targets)
    answer = with_vertical_use(model, answer_dataset(model, Way(states, loads, "load", V)))
    largest = capacities(model, targets, answer["V"].values if "V" in answer else None)
    limit = (largest.kind == FULL_LIMIT) & (largest.utilisation > 1.0 + RANGE_SLACK)
    past = (answer["beyond_end"].values == 1) | limit
    over = answer["extrapolated"].values == 1
    why = np.full(len(targets), "", dtype=object)
    for marks, text in _reasons(past, over & (not extrapolate), reached == 0):
        why[marks & (why == "")] = text
    answered = why == ""
    by_case: dict[str, Any] = {
        "H": targets[:, 0], "M": targets[:, 1], "converged": np.where(answered, reached, 0).astype(np.int8),
        "beyond_end": past.astype(np.int8), "answered": answered.astype(np.int8), "why_not": why,
        "utilisation": largest.utilisation, "capacity_H": largest.H, "capacity_M": largest.M,
        "capacity_kind": largest.kind, "capacity_from": largest.source,
    }  # fmt: skip
    cases = answer.drop_vars(_NOT_BY_CASE, errors="ignore").rename(step="case").drop_vars("case")
    for name in _MOTIONS:
        if name in cases:
            shape = (-1, *[1] * (cases[name].ndim - 1))
            cases[name] = cases[name].copy(data=np.where(answered.reshape(shape), cases[name].values, np.nan))
    return cases.assign({name: ("case", values, _UNITS.get(name, {})) for name, values in by_case.items()})


_UNITS = {
    "H": {"units": "N"}, "M": {"units": "N m"}, "capacity_H": {"units": "N"}, "capacity_M": {"units": "N m"},
    "utilisation": {"units": "1"},
}  # fmt: skip


def _reasons(past: Any, over: Any, lost: Any) -> Iterator[tuple[NDArray[np.bool_], str]]:
    yield past, "beyond a limit load of the full model"
    yield over, "beyond the calibrated range of the springs"
    yield lost, "no equilibrium"
