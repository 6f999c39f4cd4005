# SPDX-License-Identifier: MIT
"""The answer of the macro-model: a dataset by step, marked where the springs do not support it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.macro.ends import past_ends
from pysprings.macro.fan import WIDEST, FanTable
from pysprings.macro.history import Turns
from pysprings.macro.limit import RANGE_SLACK, Limit, range_used
from pysprings.macro.softening import softening_notes
from pysprings.macro.solver import row_values
from pysprings.macro.vertical_answer import vertical_answer

if TYPE_CHECKING:
    from pysprings.macro.curve_table import SpringTable
    from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]

# States farther than this from the calibration path, relative to their size, are marked off_path.
OFF_PATH = 0.10

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
    model: MacroModel,
    states: Array,
    loads: Array,
    V: float | Array | None,
    drive: dict[str, Any],
    message: str,
    limit: Callable[[int], Limit] | None = None,
    turned: Turns | None = None,
    aim: Array | None = None,
) -> xr.Dataset:
    """Return states (n, 2) = (u, rotation) and loads (n, 2) = (H, M) as a dataset, with w, V, p and marks.

    V [N] is the vertical load asked for (None: that of the path); drive names the control and the load
    height; message tells where a path ended before its aim; limit finds the largest load within the range of the
    springs, given the first state beyond it; turned marks states after a turn of the way (None: independent states);
    aim (H, M) is the load that was not carried where the way ends before its aim.
    """
    u, rotation = states.T
    table = model.table
    found = _on_fan(model, table, states) if isinstance(table, FanTable) else _on_path(model, table, states)
    down = vertical_answer(model, found.w, found.V, V, states)
    message = " ".join(filter(None, (message, down.message)))
    depth = model.origin["depth"].values
    values = {
        "u": u,
        "rotation": rotation,
        "H": loads[:, 0],
        "M": loads[:, 1],
        "converged": np.ones(u.size, dtype=np.int8),
        "depth_bounds": model.origin["depth_bounds"].values,
        "usable": found.usable,
        "y": u + rotation * depth[:, None],
        "p": found.p,
        "range_used": found.used,
        "extrapolated": (np.fmax(found.used, down.used) > 1.0 + RANGE_SLACK).astype(np.int8),
    } | down.values
    nowhere = np.zeros(u.size, dtype=bool)
    turned = turned or Turns(nowhere, nowhere)
    values["turned_back"] = turned.back.astype(np.int8)
    if found.distance is not None:
        values["path_distance"] = found.distance
    if found.distance is not None or turned.aside.any():
        values["off_path"] = (found.off | turned.aside).astype(np.int8)
    past, refusals = past_ends(model, states, found.used, loads, down.values.get("V"), aim)
    values["beyond_end"] = (past | down.past).astype(np.int8)
    beyond = np.flatnonzero(found.used > 1.0 + RANGE_SLACK)
    notes = _beyond(model, found.used, limit(int(beyond[0])) if limit else None, drive) if beyond.size else []
    notes += found.notes + turned.notes() + down.notes
    attrs = (
        _provenance(model)
        | drive
        | {"status": "partial" if message else "complete", "message": message, "warnings": " | ".join(notes)}
        | {"remarks": " | ".join(model.remarks), "path_end": _ends(model)}
        | {"refusals": " | ".join(_with_limit(refusals, drive) + down.refusals)}
    )
    known = variables.GROUPS["prediction"]
    data = {name: (known[name].dims, value, known[name].attributes()) for name, value in values.items()}
    coords: dict[str, Any] = {"depth": ("depth", depth, known["depth"].attributes()), "step": np.arange(u.size)}
    tangent = model.tangents(states, down.tangent)
    coords |= {name: tangent.coords[name].variable for name in ("dof", "dof_conjugate")}
    return xr.Dataset(data | {"stiffness": tangent.variable}, coords, attrs)


def _ends(model: MacroModel) -> str:
    """How the paths behind the lateral springs ended, in one text."""
    found = {name: model.ends[name].how for name in model.sources}
    return found[model.sources[0]] if len(found) == 1 else ", ".join(f"{name}: {how}" for name, how in found.items())


def _with_limit(refusals: list[str], drive: dict[str, Any]) -> list[str]:
    """Refusals with what the springs carry on the way asked for, where that has been found (`_beyond`)."""
    if "limit_H_N" not in drive:
        return refusals
    limit = Limit(*(drive[f"limit_{name}"] for name in ("u_m", "rotation_rad", "H_N", "M_Nm")))
    return [f"{text}; {limit}" for text in refusals]


@dataclass(frozen=True, slots=True)
class _Found:
    """What the springs say at states besides the loads: w [m], V [N] by step, p (depth, step), and their support.

    w and V are None for springs from a table; distance is None where no path is known.
    """

    w: Array | None
    V: Array | None
    p: Array
    usable: NDArray[np.int8]
    used: Array
    distance: Array | None
    off: NDArray[np.bool_]
    notes: list[str]


def _on_path(model: MacroModel, table: SpringTable, states: Array) -> _Found:
    """Springs of one path."""
    depth, used = model.origin["depth"].values, range_used(table, states)
    p, usable = _lateral(table, depth, states), _usable(table, depth)
    if "u" not in model.origin:
        nowhere = np.zeros(used.size, dtype=bool)
        return _Found(None, None, p, usable, used, None, nowhere, softening_notes(table, states))
    distance = _distance(_track(model), states * [1.0, model.length])
    off = distance > OFF_PATH
    w, V = (None, None) if model.stiffness_initial is None else _path_vertical(model, *states.T)
    notes = _path_notes(model, distance, off)
    return _Found(w, V, p, usable, used, distance, off, notes)


def _on_fan(model: MacroModel, table: FanTable, states: Array) -> _Found:
    """Springs of a fan of rays."""
    rows, places = table.rows(states)
    used, sector, nearest = table.support(states, places)
    off = (sector > WIDEST + RANGE_SLACK) & (states != 0.0).any(axis=1)
    usable = np.ones(model.origin.sizes["depth"], dtype=np.int8)
    (w,), (V,), p = (rows[table.name == name] for name in ("w", "V", "p"))
    notes = _fan_notes(sector, off)
    known = model.stiffness_initial is not None
    return _Found(w if known else None, V if known else None, p, usable, used, np.sin(nearest), off, notes)


def _track(model: MacroModel) -> Array:
    """States (u, rotation*L) [m] of the path the springs come from."""
    return np.stack([model.origin["u"].values, model.origin["rotation"].values * model.length], axis=1)


def _lateral(t: SpringTable, depth: Array, states: Array) -> Array:
    """Net p (depth, step) [N/m] that the springs give; 0 where the set has no spring."""
    rows = np.flatnonzero(np.array(t.name) == "p")
    p = np.zeros((depth.size, len(states)))
    p[np.searchsorted(depth, t.depth[rows])] = row_values(
        t.q[rows], t.r[rows], t.slope[rows], t.count[rows], np.ascontiguousarray(t.a[rows] @ states.T)
    )
    return p


def _usable(t: SpringTable, depth: Array) -> NDArray[np.int8]:
    """1 at depths whose p is read from y over the whole path, else 0."""
    own = (np.array(t.name) == "p") & t.natural & ~t.cut
    return np.isin(depth, t.depth[own]).astype(np.int8)


def _path_vertical(model: MacroModel, u: Array, rotation: Array) -> tuple[Array, Array]:
    """w [m] and V [N] by step: functions of |u| (of |rotation| where that is the larger motion), flat beyond."""
    track = np.abs(_track(model))
    lead = int(np.argmax(track[-1] * [1.0, 0.999]))
    motion = np.abs(u) if lead == 0 else np.abs(rotation) * model.length
    grows = np.maximum.accumulate(track[:, lead])
    return np.interp(motion, grows, model.origin["w"].values), np.interp(motion, grows, model.origin["V"].values)


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


def _beyond(model: MacroModel, used: Array, limit: Limit | None, drive: dict[str, Any]) -> list[str]:
    """A sentence on states beyond the range of the springs; what they carry within it goes to the attributes, too."""
    n, table = int((used > 1.0 + RANGE_SLACK).sum()), model.table
    if isinstance(table, FanTable):
        where, what = f"the fan of {len(table.path)} paths: they reach", "the"
    else:
        where, what = f"path '{model.origin.attrs['path']}': springs reach", "their"
    text = f"{n} of {used.size} states are beyond the range of {where} {used.max():.3g} times {what} calibrated "
    text += "displacement (limit 1)"
    if limit is None:
        return [text]
    drive |= {"limit_H_N": limit.H, "limit_M_Nm": limit.M, "limit_u_m": limit.u, "limit_rotation_rad": limit.rotation}
    return [f"{text}; {limit}"]


def _path_notes(model: MacroModel, distance: Array, off: NDArray[np.bool_]) -> list[str]:
    """A sentence on states that are far from the one path the springs come from."""
    arm = float(model.origin.attrs["arm_m"])
    height = f" (load height {arm:g} m)" if np.isfinite(arm) else ""
    text = (
        f"{off.sum()} of {off.size} states are off the path '{model.origin.attrs['path']}'{height} "
        f"they come from, by up to {distance.max(initial=0.0):.0%} (limit {OFF_PATH:.0%}): "
        "springs do not transfer between load paths, check against the full model"
    )
    return [text] if off.any() else []


def _fan_notes(sector: Array, off: NDArray[np.bool_]) -> list[str]:
    """A sentence on states between rays too far apart."""
    text = (
        f"{off.sum()} of {off.size} states are between calibration paths {np.degrees(sector.max(initial=0.0)):.3g} "
        f"degrees apart in (u, rotation*skirt_length) (limit {np.degrees(WIDEST):.3g}): add a path between them"
    )
    return [text] if off.any() else []


def _provenance(model: MacroModel) -> dict[str, Any]:
    kept = {name: model.attrs[name] for name in _KEPT if name in model.attrs} | {"springs": model.spring_set}
    kept["curves"] = "monotonic backbone, odd, last slope beyond the calibrated range"
    if isinstance(model.table, FanTable):
        rays = zip(model.table.path, np.degrees(model.table.angle), strict=True)
        rays_text = ", ".join(f"{name} ({angle:.1f} deg)" for name, angle in rays)
        return kept | {"path": f"{len(model.table.path)} paths", "rays": rays_text}
    origin = model.origin.attrs
    arm = float(origin.get("arm_m", np.nan))
    kept |= {"calibration_arm_m": arm} if np.isfinite(arm) else {}
    return kept | {
        "path": origin["path"],
        "kind": origin["kind"],
        "n_other_carrier": int((~model.table.natural).sum()),
        "n_cut": int(model.table.cut.sum()),
    }
