# SPDX-License-Identifier: MIT
"""The macro-model beside the full model: errors by path and spring set, at the recorded displacements.

A path is followed as the full model was driven: lateral displacement with the load at its height (pull,
load), or displacement and rotation imposed (translation, rotation, swipe). Errors are those of the answer: load and
rotation for the first, H and M for the second. With the sets "py" and "full" a calibration path is answered by its
own springs, a held-back path by the springs of the first calibration path. The set "fan" is made from all rays
among the calibration paths and answers every path; "pisa" takes its lateral families from the pure translation among
them and its moments from the pure rotation. Where calibration paths have several rates, every path is answered at its
own, and so it is with several vertical loads (`pysprings.springs.rates`, `pysprings.springs.dead_loads`). A path of
kind "vertical" is answered by the vertical springs (set "vertical"): V at equal w, its errors relative to the change of
V from rest.

A held-back path with a `vertical_load` of its own is answered under that load; `off_load_states` counts the states
where no lateral springs know it, `w_error_...` is the largest distance of w.

On a swipe and under a load that climbs, whose states are imposed, errors are relative to the largest H or M of the
path.

Read the other way, `u_error_...` is the displacement that the macro-model needs for the full model's load (H and M of
each recorded state), over the full model's, minus 1. `rotation_point_...`: depth of the point of the axis at rest.

On their own paths the full set and the fan meet the recorded states by construction. What they do between them is
measured too: `..._error_between_pct` is the largest error when every second recorded state is left out of the
springs.

Accuracy, after the PISA project (Byrne et al. 2020, Geotechnique 70:1030):
    eta = (A_ref - A_diff) / A_ref,  A_ref = area under the full model's load-displacement curve,
    A_diff = area between both curves; 1 is perfect.
"large" runs to the end of the path; "small" to a lateral displacement of outer diameter / 10 000 (PISA's
value). On a rotation path the curve is M against rotation, and "small" is that displacement over the skirt
length.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.path_kinds import PATH_KINDS, VERTICAL, bends, kind_of
from pysprings.macro.control import Control
from pysprings.macro.model import MacroModel
from pysprings.macro.sets import spring_sets
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.vertical import build_vertical
from pysprings.macro.vertical_answer import along_vertical, refused
from pysprings.springs.dataset import SCHEMA, get_path, path_load, path_names
from pysprings.springs.dead_loads import for_path

Array = NDArray[np.float64]

# Relative errors leave out states below this share of the largest displacement (or rotation) of the path.
SKIP_BELOW = 0.01
SMALL_OVER_DIAMETER = 1e-4

_ERRORS = ("H", "rotation", "M", "V")

AT_LOAD = {"long_name": "lateral displacement of the lid centre under the load of the full model", "units": "m"}
# The point of rotation is followed on paths with a free head, where it is nearer than this many diameters.
FAR = 100.0
NO_TURN = 1e-15  # rad: what rounding leaves of a rotation that is held


def compare(model: xr.DataTree, springs_kind: str | None = None) -> pd.DataFrame:
    """Return one row per path and spring set: eta, errors [%], ends of both models, point of rotation.

    Parameters
    ----------
    model
        Springs (`open_springs`), or a full-model result, whose springs are extracted first.
    springs_kind
        One spring set instead of all those that the model has.
    """
    springs = _springs_of(model)
    sets = spring_sets(for_path(springs, get_path(springs)))
    if springs_kind is not None and springs_kind not in sets:
        raise refused("springs_kind", f"no springs '{springs_kind}' here; there are: {', '.join(sets)}")
    rows = [
        _row(springs, name, spring_set, trace)
        for name in path_names(springs)
        for spring_set, trace in curves(springs, name, springs_kind).items()
    ]
    frame = pd.DataFrame(rows)
    frame.attrs = {name: springs.attrs.get(name, "") for name in ("title", "pysprings_version", "scene_sha256")}
    return frame


def curves(springs: xr.DataTree, path: str, springs_kind: str | None = None) -> dict[str, xr.Dataset]:
    """Return the macro-model's answer along one path of the full model, by spring set ("py", "full", "fan").

    The states are those the full model recorded, the initial state included. springs_kind: only this set. A vertical
    path has the one set "vertical", or none where there are no vertical springs.
    """
    full = get_path(springs, path)
    springs = for_path(springs, full)
    if full.attrs["kind"] == VERTICAL:
        table = build_vertical(springs) if springs_kind is None else None
        return {} if table is None else {VERTICAL: along_vertical(table, full)}
    kinds = spring_sets(springs) if springs_kind is None else [springs_kind]
    return {kind: _along(full, MacroModel.from_springs(springs, kind, _source(full, kind))) for kind in kinds}


def _source(full: xr.Dataset, spring_set: str) -> str | None:
    """Path whose springs answer a path of the full model: its own when it calibrates; None for the usual ones."""
    own = not SPRING_SETS[spring_set].several and full.attrs["role"] == "calibration"
    return full.attrs["path"] if own else None


def _along(full: xr.Dataset, model: MacroModel) -> xr.Dataset:
    """Drive a macro-model as the full model was driven, through the states it recorded."""
    control, *_ = _driver(full)
    targets = np.stack([full["u"].values, full["rotation"].values], axis=1)
    V = path_load(full) if full.attrs.get("heave", "free") == "free" else None
    trace = model.trace(control, targets, float(full.attrs["arm_m"]), V)
    return trace.assign(u_at_load=("step", _at_load(full, model, trace.sizes["step"]), AT_LOAD))


def _at_load(full: xr.Dataset, model: MacroModel, n: int) -> Array:
    """Displacement u [m] of the macro-model under the loads of the full model, by state; NaN beyond what it carries."""
    states, _, _ = model.solve("load", np.stack([full["H"].values[:n], full["M"].values[:n]], axis=1))
    return np.append(states[:, 0], np.full(n - len(states), np.nan))


def _thinned(springs: xr.DataTree, path: str) -> xr.DataTree:
    """Springs without every second recorded state of one path; its ends stay."""
    full = get_path(springs, path)
    last = full.sizes["step"] - 1
    kept = sorted({*range(0, last + 1, 2), last})
    thinned = springs.copy()
    thinned[f"paths/{path}"] = xr.DataTree(full.isel(step=kept))
    return thinned


def states(springs: xr.DataTree) -> pd.DataFrame:
    """Return both models state by state (SI): path, springs, step, and u, rotation, H, M of each."""
    frames = []
    for name in path_names(springs):
        full = get_path(springs, name)
        for spring_set, trace in curves(springs, name).items():
            n = trace.sizes["step"]
            data: dict[str, Any] = {"path": name, "springs": spring_set, "step": full["step"].values[:n]}
            for label, units in (("u", "m"), ("rotation", "rad"), ("H", "N"), ("M", "Nm")):
                data[f"{label}_full_{units}"] = full[label].values[:n]
                data[f"{label}_macro_{units}"] = trace[label].values
            frames.append(pd.DataFrame(data))
    return pd.concat(frames, ignore_index=True)


def _springs_of(model: xr.DataTree) -> xr.DataTree:
    if model.attrs.get("schema") == SCHEMA:
        return model
    from pysprings.springs.extract import extract_springs  # only a full result needs it

    return extract_springs(model)


def _row(springs: xr.DataTree, name: str, spring_set: str, trace: xr.Dataset) -> dict[str, Any]:
    full = get_path(springs, name)
    _, driver, load, answers = _driver(full)
    n = trace.sizes["step"]
    length = float(springs.attrs["skirt_length_m"])
    x, reference, answer = _abscissa(full, driver, length)[:n], full[load].values[:n], trace[load].values
    small = springs.attrs["outer_diameter_m"] * SMALL_OVER_DIAMETER
    small = small / springs.attrs["skirt_length_m"] if driver == "rotation" else small
    if driver == "w":  # what is there at rest is no answer
        x, reference, answer = x - x[0], reference - reference[0], answer - reference[0]
    row: dict[str, Any] = {
        "path": name,
        "role": full.attrs["role"],
        "kind": full.attrs["kind"],
        "arm_m": float(full.attrs["arm_m"]),
        "springs": spring_set,
        "springs_from": trace.attrs["path"],
        "V_N": path_load(full),
        "status": trace.attrs["message"] or "complete",
        "states": n - 1,
        "eta_small": eta(x, reference, answer, small),
        "eta_large": eta(x, reference, answer),
    }
    row |= _errors(full, trace, x, answers) | _between(springs, full, spring_set, answers)
    for label, units in (("u", "m"), ("w", "m"), ("rotation", "rad"), ("H", "N"), ("V", "N"), ("M", "Nm")):
        row |= {
            f"{label}_end_full_{units}": float(full[label].values[n - 1]) if n else np.nan,
            f"{label}_end_macro_{units}": float(trace[label].values[-1]) if n else np.nan,
        }
    both = (("full", full), ("macro", trace))
    row |= {f"rotation_point_{who}_m": _rotation_point(data, n, length) for who, data in both}
    row |= _at_equal_load(full, trace) | {"rotation_point_error_max_m": _point_error(full, trace, length)}
    row["w_error_max_m"] = _largest(trace["w"].values - full["w"].values[:n])
    return row | {
        "small_at": small,
        "skip_below": SKIP_BELOW,
        "depths": trace.sizes["depth"],
        "depths_unusable": int((trace["usable"] == 0).sum()),
        "extrapolated_states": int(trace["extrapolated"].sum()),
        "off_path_states": int(trace["off_path"].sum()),
        "off_load_states": int(trace["off_load"].sum()),
    }


def _largest(difference: Array) -> float:
    """The value of the largest size, NaN of none."""
    return float(difference[np.argmax(np.abs(difference))]) if difference.size else np.nan


def _abscissa(full: xr.Dataset, driver: str, length: float) -> Array:
    """Displacement (or rotation) that drives a path; of a path that bends the way it has come, in m."""
    x: Array = full[driver].values
    return np.abs(x) + length * np.abs(full["rotation"].values) if bends(full.attrs) else x


def _driver(full: xr.Dataset) -> tuple[Control, str, str, tuple[str, ...]]:
    """Return how a path of the full model is followed: control, driving variable, its load, answers with an error."""
    kind = kind_of(full.attrs)
    return "displacement" if kind.free_head else "state", kind.drives, kind.load, kind.answers


def _errors(full: xr.Dataset, trace: xr.Dataset, x: Array, answers: tuple[str, ...]) -> dict[str, float]:
    """Largest (by size, signed) and last relative error [%] of each answer; NaN for what is imposed."""
    out: dict[str, float] = {}
    for label in _ERRORS:
        worst = last = np.nan
        if label in answers:
            reference = full[label].values[: x.size]
            change = reference - reference[0] if label == "V" and reference.size else reference
            # H or M may pass through zero there: errors count beside the largest of the path
            scale = np.full_like(reference, np.abs(reference).max(initial=0.0)) if bends(full.attrs) else change
            worst, last = _relative_errors(x, scale, scale + trace[label].values - reference)
        out |= {f"{label}_error_max_pct": worst, f"{label}_error_end_pct": last}
    return out


def _relative_errors(x: Array, reference: Array, answer: Array) -> tuple[float, float]:
    """Largest (signed) and last error [%] over the states that count: large enough, reference not zero."""
    counted = (np.abs(x) >= SKIP_BELOW * np.abs(x).max(initial=0.0)) & (x != 0.0) & (reference != 0.0)
    if not counted.any():
        return np.nan, np.nan
    error = 100.0 * (answer[counted] / reference[counted] - 1.0)
    return float(error[np.argmax(np.abs(error))]), float(error[-1])


def _between(springs: xr.DataTree, full: xr.Dataset, spring_set: str, answers: tuple[str, ...]) -> dict[str, float]:
    """Largest error [%] on a calibration path when every second state is left out of its own springs."""
    out = {f"{label}_error_between_pct": np.nan for label in _ERRORS}
    name, driver = full.attrs["path"], _driver(full)[1]
    springs = for_path(springs, full)
    if spring_set == VERTICAL:
        return out | _between_vertical(springs, full)
    if SPRING_SETS[spring_set].reproduces(springs, full) and full.sizes["step"] > 4:
        model = MacroModel.from_springs(_thinned(springs, name), spring_set, _source(full, spring_set))
        trace = _along(full, model)
        x = _abscissa(full, driver, float(springs.attrs["skirt_length_m"]))
        found = _errors(full, trace, x[: trace.sizes["step"]], answers)
        out = {f"{label}_error_between_pct": found[f"{label}_error_max_pct"] for label in _ERRORS}
    return out


def _between_vertical(springs: xr.DataTree, full: xr.Dataset) -> dict[str, float]:
    """Largest error [%] of V on a vertical calibration path when every second state is left out of its springs."""
    if full.attrs["role"] != "calibration" or full.sizes["step"] <= 4:
        return {}
    table = build_vertical(_thinned(springs, full.attrs["path"]))
    assert table is not None  # the path itself
    w = full["w"].values
    return {"V_error_between_pct": _errors(full, along_vertical(table, full), w - w[0], ("V",))["V_error_max_pct"]}


def eta(x: Array, reference: Array, answer: Array, end: float | None = None) -> float:
    """Return the accuracy eta of an answer to a reference curve over displacement x, up to |x| = end.

    Both curves are straight between their points; areas by the trapezoid rule. NaN when the reference has no
    area.
    """
    size = np.abs(x)
    if end is not None and size.size and size[-1] > end:
        grid = np.append(size[size < end], end)
        reference, answer = np.interp(grid, size, reference), np.interp(grid, size, answer)
        size = grid
    area = float(np.trapezoid(np.abs(reference), size))
    return 1.0 - float(np.trapezoid(np.abs(answer - reference), size)) / area if area else float("nan")


def _at_equal_load(full: xr.Dataset, trace: xr.Dataset) -> dict[str, Any]:
    """Largest and last error [%] of the displacement at equal load, and the states whose load is carried."""
    answer = trace["u_at_load"].values
    reached = np.isfinite(answer)
    x, worst, last = full["u"].values[: answer.size][reached], np.nan, np.nan
    if PATH_KINDS[full.attrs["kind"]].drives == "u":  # there u is 0, or what rounding has left of it
        worst, last = _relative_errors(x, x, answer[reached])
    return {"u_error_max_pct": worst, "u_error_end_pct": last, "states_at_load": int(reached.sum()) - 1}


def _point_error(full: xr.Dataset, trace: xr.Dataset, length: float) -> float:
    """Largest distance [m] between both points of rotation, at equal displacement; NaN: none to follow."""
    n = trace.sizes["step"]
    u, rotation = full["u"].values[:n], full["rotation"].values[:n]
    near = (np.abs(rotation) * length * FAR > np.abs(u)) & (np.abs(u) >= SKIP_BELOW * np.abs(u).max(initial=0.0))
    near &= (u != 0.0) & (trace["rotation"].values != 0.0)
    if not PATH_KINDS[full.attrs["kind"]].free_head or not near.any():
        return float("nan")
    own = trace["u"].values[near] / trace["rotation"].values[near]
    return float(np.abs(own - u[near] / rotation[near]).max())


def _rotation_point(data: Mapping[Any, Any], n: int, length: float) -> float:
    """Depth [m] of the point of the axis at rest in the last state, -u/rotation; NaN for a translation."""
    u, rotation = (float(data[name][n - 1]) if n else 0.0 for name in ("u", "rotation"))
    # an imposed rotation of 0 is met to rounding only
    turns = abs(rotation) * length > max(1e-9 * abs(u), NO_TURN * length)
    return -u / rotation if turns else float("nan")
