# SPDX-License-Identifier: MIT
"""Measures of an answer of the macro-model beside a path of the full model.

Accuracy, after the PISA project (Byrne et al. 2020, Geotechnique 70:1030):
    eta = (A_ref - A_diff) / A_ref,  A_ref = area under the full model's load-displacement curve,
    A_diff = area between both curves; 1 is perfect.
"large" runs to the end of the path; "small" to a lateral displacement of outer diameter / 10 000 (PISA's
value). On a rotation path the curve is M against rotation, and "small" is that displacement over the skirt
length.

Relative errors leave out states below 1 % of the largest displacement (or rotation) of the path. Where the answer may
pass through zero (on a swipe, under a load that climbs, on a path that turns back) or does (M of a ray), errors are
relative to the largest one of the path.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array, Marks
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.springs.path import RecordedPath, SpringPath
from pysprings.springs.path_ends import RESIDUAL

# Relative errors leave out states below this share of the largest displacement (or rotation) of the path.
SKIP_BELOW = 0.01
SMALL_OVER_DIAMETER = 1e-4
# The point of rotation is followed on paths with a free head, where it is nearer than this many diameters.
FAR = 100.0
NO_TURN = 1e-15  # rad: what rounding leaves of a rotation that is held

_ERRORS = ("H", "rotation", "M", "V")
_UNITS = {"u": "m", "w": "m", "rotation": "rad", "H": "N", "V": "N", "M": "Nm"}


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


def abscissa(path: SpringPath) -> Array:
    """Return the displacement (or rotation) (n,) that drives a path; of one that bends or turns its way come, in m."""
    x = path[path.rules.drives]
    if path.turns_back:
        steps = np.abs(np.diff(path.u, prepend=path.u[:1])) + np.abs(np.diff(path.turn, prepend=path.turn[:1]))
        return np.cumsum(steps)
    return np.abs(x) + path.length * np.abs(path.rotation) if path.bends else x


def carried(path: RecordedPath) -> set[str]:
    """Return which of H and M a path has; not what the iteration leaves of one beside the other."""
    arms = {label: arm for label, arm in (("H", path.length), ("M", 1.0)) if label in path}
    sizes = {label: arm * float(np.abs(path[label]).max(initial=0.0)) for label, arm in arms.items()}
    return {label for label, size in sizes.items() if size > RESIDUAL * max(sizes.values())}


def errors(path: SpringPath, answer: xr.Dataset, x: Array, answers: tuple[str, ...]) -> dict[str, float]:
    """Return the largest (by size, signed) and last relative error [%] of each answer; NaN for what is imposed.

    NaN, too, for what the iteration leaves of M beside H, or of H beside M.
    """
    out, loaded = dict[str, float](), carried(path)
    for label in _ERRORS:
        worst = last = np.nan
        if label in answers and (label not in ("H", "M") or label in loaded):
            reference = path[label][: x.size]
            change = reference - reference[0] if label == "V" and reference.size else reference
            counted = change[_counted(x)]
            crosses = path.bends or path.turns_back or counted.min(initial=0.0) < 0.0 < counted.max(initial=0.0)
            scale = np.full_like(reference, np.abs(reference).max(initial=0.0)) if crosses else change
            worst, last = _relative_errors(x, scale, scale + answer[label].values - reference)
        out |= {f"{label}_error_max_pct": worst, f"{label}_error_end_pct": last}
    return out


def between(by_name: Mapping[str, float]) -> dict[str, float]:
    """Return the largest errors of springs with fewer states under names of their own; NaN where there are none."""
    return {f"{label}_error_between_pct": by_name.get(f"{label}_error_max_pct", np.nan) for label in _ERRORS}


def _counted(x: Array) -> Marks:
    """Return which states (n,) count in relative errors: large enough."""
    return (np.abs(x) >= SKIP_BELOW * np.abs(x).max(initial=0.0)) & (x != 0.0)


def _relative_errors(x: Array, reference: Array, answer: Array) -> tuple[float, float]:
    """Return the largest (signed) and last error [%] over the states that count, with a reference that is not zero."""
    counted = _counted(x) & (reference != 0.0)
    if not counted.any():
        return np.nan, np.nan
    error = 100.0 * (answer[counted] / reference[counted] - 1.0)
    return float(error[np.argmax(np.abs(error))]), float(error[-1])


def ends(path: SpringPath, answer: xr.Dataset) -> dict[str, float]:
    """Return motion and loads of both models in the last state that the answer reaches."""
    n, row = answer.sizes["step"], dict[str, float]()
    for label, units in _UNITS.items():
        row[f"{label}_end_full_{units}"] = float(path[label][n - 1]) if n else np.nan
        row[f"{label}_end_macro_{units}"] = float(answer[label].values[-1]) if n else np.nan
    return row


def at_equal_load(path: SpringPath, answer: xr.Dataset) -> dict[str, Any]:
    """Return the largest and last error [%] of the displacement at equal load, and the states whose load is carried.

    The largest stands there for states up to half of the largest load of the path, too.
    """
    values = answer["u_at_load"].values
    reached = np.isfinite(values)
    x, worst, last, within = path.u[: values.size][reached], np.nan, np.nan, np.nan
    if PATH_KINDS[path.kind].drives == "u":  # elsewhere u is 0, or what rounding has left of it
        scale = np.full_like(x, np.abs(x).max(initial=0.0)) if path.turns_back else x
        own = scale + values[reached] - x
        worst, last = _relative_errors(x, scale, own)
        load = np.hypot(path["H"], path["M"] / path.length)
        half = (load <= 0.5 * load.max(initial=0.0))[: values.size][reached]
        within, _ = _relative_errors(x, np.where(half, scale, 0.0), own)
    out = {"u_error_max_pct": worst, "u_error_end_pct": last, "u_error_half_pct": within}
    return out | {"states_at_load": int(reached.sum()) - 1}


def distances(path: SpringPath, answer: xr.Dataset) -> dict[str, float]:
    """Return the largest distances [m] of the points of rotation and of the change of w, at equal displacement."""
    n = answer.sizes["step"]
    w = (answer["w"].values - answer["w"].values[:1]) - (path.w[:n] - path.w[:1])
    largest = float(w[np.argmax(np.abs(w))]) if n else np.nan
    return {"rotation_point_error_max_m": _point_error(path, answer, n), "w_error_max_m": largest}


def _point_error(path: SpringPath, answer: xr.Dataset, n: int) -> float:
    """Return the largest distance [m] between both points of rotation; NaN: none to follow."""
    u, rotation = path.u[:n], path.rotation[:n]
    near = _counted(u) & (np.abs(rotation) * path.length * FAR > np.abs(u)) & (answer["rotation"].values != 0.0)
    if not PATH_KINDS[path.kind].free_head or not near.any():
        return float("nan")
    own = answer["u"].values[near] / answer["rotation"].values[near]
    return float(np.abs(own - u[near] / rotation[near]).max())


def rotation_points(path: SpringPath, answer: xr.Dataset) -> dict[str, float]:
    """Return the depth u/rotation [m] of the point at rest in the last state of both models; NaN for a translation."""
    n, found = answer.sizes["step"], {}
    both = {"full": (path.u, path.rotation), "macro": (answer["u"].values, answer["rotation"].values)}
    for who, (u, rotation) in both.items():
        x, turn = (float(u[n - 1]), float(rotation[n - 1])) if n else (0.0, 0.0)
        # an imposed rotation of 0 is met to rounding only
        turns = abs(turn) * path.length > max(1e-9 * abs(x), NO_TURN * path.length)
        found[f"rotation_point_{who}_m"] = x / turn if turns else float("nan")
    return found
