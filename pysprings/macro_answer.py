# SPDX-License-Identifier: MIT
"""The answer of the macro-model: a dataset by step, marked where the springs do not support it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings import variables
from pysprings.errors import Problem, UserInputError
from pysprings.macro_solver import row_values

if TYPE_CHECKING:
    from pysprings.macro import MacroModel

Array = NDArray[np.float64]

# States farther than this from the calibration path, relative to their size, are marked off_path.
OFF_PATH = 0.10
# A spring may exceed its range by this share before it counts as extrapolated (rounding).
RANGE_SLACK = 1e-6

_KEPT = (
    "Conventions",
    "title",
    "source",
    "pysprings_version",
    "scene_sha256",
    "drainage",
    "outer_diameter_m",
    "skirt_length_m",
)


def answer_dataset(
    model: MacroModel, states: Array, loads: Array, V: float | None, drive: dict[str, Any], message: str
) -> xr.Dataset:
    """Return states (n, 2) = (u, rotation) and loads (n, 2) = (H, M) as a dataset, with w, V, p and marks.

    V [N] is the vertical load asked for (None: that of the path); drive names the control and the load
    height; message tells where a path ended before its aim.
    """
    u, rotation = states.T
    w, vertical, elastic = _vertical(model, u, rotation, V)
    used = _range_used(model, states)
    distance = _distance(_track(model), states * [1.0, model.length])
    depth = model.origin["depth"].values
    values = {
        "u": u,
        "w": w,
        "rotation": rotation,
        "H": loads[:, 0],
        "V": vertical,
        "M": loads[:, 1],
        "converged": np.ones(u.size, dtype=np.int8),
        "depth_bounds": model.origin["depth_bounds"].values,
        "usable": _usable(model),
        "y": u + rotation * depth[:, None],
        "p": _lateral(model, states),
        "range_used": used,
        "extrapolated": (used > 1.0 + RANGE_SLACK).astype(np.int8),
        "path_distance": distance,
        "off_path": (distance > OFF_PATH).astype(np.int8),
    }
    notes = _notes(model, values, V if elastic else None)
    attrs = (
        _provenance(model)
        | drive
        | {"status": "partial" if message else "complete", "message": message, "warnings": " | ".join(notes)}
    )
    table = variables.GROUPS["prediction"]
    data = {name: (table[name].dims, value, table[name].attributes()) for name, value in values.items()}
    coords = {"depth": ("depth", depth, table["depth"].attributes()), "step": np.arange(u.size)}
    return xr.Dataset(data, coords, attrs)


def _track(model: MacroModel) -> Array:
    """States (u, rotation*L) [m] of the path the springs come from."""
    return np.stack([model.origin["u"].values, model.origin["rotation"].values * model.length], axis=1)


def _range_used(model: MacroModel, states: Array) -> Array:
    """Largest displacement over its range, by state; curves kept in part are left out (flat beyond)."""
    whole = ~model.table.cut
    return (np.abs(states @ model.table.a[whole].T) / model.table.range[whole]).max(axis=1, initial=0.0)


def _lateral(model: MacroModel, states: Array) -> Array:
    """Net p (depth, step) [N/m] that the springs give; 0 where the set has no spring."""
    t, depth = model.table, model.origin["depth"].values
    rows = np.flatnonzero(np.array(t.name) == "p")
    p = np.zeros((depth.size, len(states)))
    p[np.searchsorted(depth, t.depth[rows])] = row_values(
        t.q[rows], t.r[rows], t.slope[rows], t.count[rows], np.ascontiguousarray(t.a[rows] @ states.T)
    )
    return p


def _usable(model: MacroModel) -> NDArray[np.int8]:
    """1 at depths whose p is read from y over the whole path, else 0."""
    t, depth = model.table, model.origin["depth"].values
    own = (np.array(t.name) == "p") & t.natural & ~t.cut
    return np.isin(depth, t.depth[own]).astype(np.int8)


def _vertical(model: MacroModel, u: Array, rotation: Array, V: float | None) -> tuple[Array, Array, bool]:
    """w [m] and V [N] by step, and whether V is another than the path's (then w has an elastic part).

    On the path, w is a function of |u| (of |rotation| where that is the larger motion), held flat beyond.
    """
    track = np.abs(_track(model))
    lead = int(np.argmax(track[-1] * [1.0, 0.999]))
    motion = np.abs(u) if lead == 0 else np.abs(rotation) * model.length
    grows = np.maximum.accumulate(track[:, lead])
    path_w, path_v = model.origin["w"].values, model.origin["V"].values
    w, on_path = np.interp(motion, grows, path_w - path_w[0]), np.interp(motion, grows, path_v)
    if V is None:
        return w, on_path, False
    check_finite(V=V)
    other = np.abs(V - on_path).max() > 1e-6 * max(abs(V), np.abs(on_path).max())
    return w + (V - on_path) / model.stiffness_initial[1, 1], np.full_like(u, V), bool(other)


def _distance(track: Array, states: Array) -> Array:
    """Distance of states (n, 2) from a polyline or its mirror image, over their size; last piece open."""
    start, piece = track[:-1], np.diff(track, axis=0)
    length2 = np.maximum((piece**2).sum(axis=1), 1e-300)
    ahead = np.append(np.ones(len(piece) - 1), np.inf)
    shortest = np.full(len(states), np.inf)
    for sign in (1.0, -1.0):
        offset = sign * states[:, None, :] - start
        along = np.clip((offset * piece).sum(axis=2) / length2, 0.0, ahead)
        gap = offset - along[:, :, None] * piece
        shortest = np.minimum(shortest, (gap**2).sum(axis=2).min(axis=1))
    size = (states**2).sum(axis=1)
    return np.sqrt(shortest / np.where(size > 0.0, size, np.inf))


def _notes(model: MacroModel, values: dict[str, Array], other_v: float | None) -> list[str]:
    """Sentences, with their numbers and limits, on what the springs do not support in an answer."""
    notes, n, name = [], values["u"].size, model.origin.attrs["path"]
    beyond, off = int(values["extrapolated"].sum()), int(values["off_path"].sum())
    if beyond:
        notes.append(
            f"{beyond} of {n} states are beyond the range of path '{name}': springs reach "
            f"{values['range_used'].max():.3g} times their calibrated displacement (limit 1)"
        )
    if off:
        notes.append(
            f"{off} of {n} states are off the path '{name}' (load height {model.origin.attrs['arm_m']:g} m) "
            f"they come from, by up to {values['path_distance'].max():.0%} (limit {OFF_PATH:.0%}): "
            "springs do not transfer between load paths, check against the full model"
        )
    if other_v is not None:
        notes.append(
            f"V = {other_v:.4g} N is not that of path '{name}' ({model.origin['V'].values[-1]:.4g} N): "
            "w from the elastic vertical stiffness, lateral springs unchanged"
        )
    return notes


def _provenance(model: MacroModel) -> dict[str, Any]:
    origin = model.origin.attrs
    return {name: model.attrs[name] for name in _KEPT if name in model.attrs} | {
        "springs": model.spring_set,
        "path": origin["path"],
        "kind": origin["kind"],
        "calibration_arm_m": float(origin["arm_m"]),
        "curves": "monotonic backbone, odd, last slope beyond the calibrated range",
        "n_other_carrier": int((~model.table.natural).sum()),
        "n_cut": int(model.table.cut.sum()),
    }


def check_finite(**values: float) -> None:
    """Refuse numbers that are not finite, by name."""
    bad = [name for name, value in values.items() if not np.isfinite(value)]
    if bad:
        raise UserInputError([Problem(key=name, message="not a finite number") for name in bad])


def refused(key: str, message: str) -> UserInputError:
    """Return the error for one bad argument."""
    return UserInputError([Problem(key=key, message=message)])
