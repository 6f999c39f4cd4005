# SPDX-License-Identifier: MIT
"""The answer of the macro-model: a dataset by step, marked where the springs do not support it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.macro.ends import past_ends
from pysprings.macro.fan import RANGE_SLACK, WIDEST, FanTable
from pysprings.macro.history import Control, Turns
from pysprings.macro.limit import Limit, past_peak, paths_at, range_used
from pysprings.macro.solver import row_values
from pysprings.macro.spread import NAMES, deviations
from pysprings.macro.vertical_answer import Down, vertical_answer

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
    "atlas_outside",
    "atlas_mesh",
)


@dataclass(frozen=True, slots=True)
class Way:
    """States that were solved, and what was asked for.

    Attributes
    ----------
    states, loads : (n, 2) = (u [m], rotation [rad]) and (H [N], M [N m]).
    control : what was imposed.
    V : vertical load asked for [N], one number or one a state (None: that of the springs).
    arm : height of the load [m]; None for independent cases.
    message : where the way ended before its aim; empty where it did not.
    time : (n,) [s] of the states from rest; None: not known.
    aim : load (H, M) that was not carried where the way ended before it.
    turned : marks of states after a turn of the way; None for independent states.
    limit : returns the largest load within the range of the springs, given the number of the first state beyond it.
    """

    states: Array
    loads: Array
    control: Control
    V: float | Array | None = None
    arm: float | None = None
    message: str = ""
    aim: Array | None = None
    turned: Turns | None = None
    limit: Callable[[int], Limit] | None = None
    time: Array | None = None


def answer_dataset(model: MacroModel, way: Way) -> xr.Dataset:
    """Return the states and loads of a way as a dataset by step, with w, V, p, the stiffness, and marks."""
    states, u, rotation = way.states, *way.states.T
    support = _supported(model, states, way)
    down = vertical_answer(model, support.w, support.V, way.V, states)
    depth = model.origin.depth
    nowhere = np.zeros(u.size, dtype=bool)
    turned = way.turned or Turns(nowhere, nowhere)
    past, refusals = past_ends(model, states, support.used, way.loads, down.values.get("V"), way.aim)
    values = {
        "u": u,
        "rotation": rotation,
        "H": way.loads[:, 0],
        "M": way.loads[:, 1],
        "converged": np.ones(u.size, dtype=np.int8),
        "depth_bounds": model.origin["depth_bounds"],
        "usable": support.usable,
        "y": u - rotation * depth[:, None],
        "p": support.p,
        "range_used": support.used,
        "extrapolated": (np.fmax(support.used, down.used) > 1.0 + RANGE_SLACK).astype(np.int8),
    } | down.values
    values["turned_back"] = turned.back.astype(np.int8)
    if support.water is not None:
        values["p_water"] = support.water
    if support.distance is not None:
        values["path_distance"] = support.distance
    if support.softened is not None:
        values["past_peak"] = support.softened.astype(np.int8)
    if support.distance is not None or turned.aside.any():
        values["off_path"] = (support.off | turned.aside).astype(np.int8)
    values["beyond_end"] = past.astype(np.int8)
    known = variables.GROUPS["prediction"]
    data = {name: (known[name].dims, value, known[name].attributes()) for name, value in values.items()}
    coords: dict[str, Any] = {"depth": ("depth", depth, known["depth"].attributes()), "step": np.arange(u.size)}
    if support.water is not None:
        coords["side"] = ("side", list(variables.SIDES), known["side"].attributes())
    tangent = model.tangents(states, down.tangent, way.V)
    coords |= {name: tangent.coords[name].variable for name in ("dof", "dof_conjugate")}
    data |= {name: (("step",), value, known[name].attributes()) for name, value in _deviations(model, way, tangent)}
    attrs = _attributes(model, way, support, turned, down, refusals)
    return xr.Dataset(data | {"stiffness": tangent.variable}, coords, attrs)


def _deviations(model: MacroModel, way: Way, tangent: xr.DataArray) -> Iterator[tuple[str, Array]]:
    """Yield the standard deviations of springs of an atlas, by name; none of other springs."""
    if model.spread is None or not isinstance(model.table, FanTable):
        return
    lateral = tangent.values[:, ::2, ::2] if tangent.shape[1] == 3 else tangent.values
    spread = deviations(model.spread, model.table, way.control, way.states, lateral, way.arm or 0.0)
    yield from zip(NAMES, spread.T, strict=True)


def _attributes(
    model: MacroModel, way: Way, support: _Support, turned: Turns, down: Down, refusals: list[str]
) -> dict[str, Any]:
    """Return the attributes of an answer: provenance, what was asked for, status, and sentences.

    refusals: beyond a limit load; beyond_range: what is beyond the calibrated range; warnings: other marks; remarks.
    """
    message = " ".join(filter(None, (way.message, down.message)))
    beyond = np.flatnonzero(support.used > 1.0 + RANGE_SLACK)
    limit = way.limit(int(beyond[0])) if way.limit is not None and beyond.size else None
    outside = [_beyond(model, way.states, support.used, limit)] if beyond.size else []
    carried = f"; {limit}" if limit else ""
    return (
        _provenance(model)
        | {"control": way.control}
        | ({} if way.arm is None else {"arm_m": way.arm})
        | (limit.attributes() if limit else {})
        | {"status": "partial" if message else "complete", "message": message}
        | {
            "warnings": support.notes + turned.notes() + down.notes + _outside(model),
            "beyond_range": outside + down.beyond,
        }
        | {"remarks": list(model.remarks), "path_end": _ends(model), "balance": model.balance}
        | {"refusals": [f"{text}{carried}" for text in refusals]}
    )


def _outside(model: MacroModel) -> list[str]:
    """Return a sentence on springs of an atlas at or beyond the edge of its full models."""
    text = str(model.attrs.get("atlas_outside", ""))
    return [text] if text else []


def _ends(model: MacroModel) -> str:
    """Return how the paths behind the lateral springs ended, in one text."""
    ends = {name: model.ends[name].how for name in model.sources}
    return ends[model.sources[0]] if len(ends) == 1 else ", ".join(f"{name}: {how}" for name, how in ends.items())


@dataclass(frozen=True, slots=True)
class _Support:
    """Answers of the springs at states, besides the loads: w [m], V [N] by step, p (depth, step), and their support.

    w and V are None for springs from a table; distance is None where no path is known; water, the part of p that pore
    water carries (side, depth, step), where the springs do not have it; softened where no curve is known to soften.
    """

    w: Array | None
    V: Array | None
    p: Array
    usable: NDArray[np.int8]
    used: Array
    distance: Array | None
    off: NDArray[np.bool_]
    notes: list[str]
    water: Array | None = None
    softened: NDArray[np.bool_] | None = None


def _supported(model: MacroModel, states: Array, way: Way) -> _Support:
    table = model.table
    return _on_fan(model, table, states, way) if isinstance(table, FanTable) else _on_path(model, table, states)


def _on_path(model: MacroModel, table: SpringTable, states: Array) -> _Support:
    """Return the springs of one path."""
    depth, used = model.origin.depth, range_used(table, states)
    p, usable = _lateral(table, depth, states), _usable(table, depth)
    if "u" not in model.origin:
        softened, notes = past_peak(table, states)
        return _Support(None, None, p, usable, used, None, np.zeros(used.size, dtype=bool), notes, softened=softened)
    distance = _distance(_track(model), states * [1.0, model.length])
    off = distance > OFF_PATH
    w, V = (None, None) if model.stiffness_initial is None else _path_vertical(model, *states.T)
    notes = _path_notes(model, distance, off)
    return _Support(w, V, p, usable, used, distance, off, notes)


def _on_fan(model: MacroModel, table: FanTable, states: Array, way: Way) -> _Support:
    """Return the springs of a fan of rays."""
    rows, places = table.rows(states)
    if model.memory is not None:
        rows = model.memory.reactions(states, way.time, way.V)
    used, sector, nearest = table.support(states, places)
    off = (sector > WIDEST + RANGE_SLACK) & (states != 0.0).any(axis=1)
    usable = np.ones(model.origin.depth.size, dtype=np.int8)
    (w,), (V,), p = (rows[table.name == name] for name in ("w", "V", "p"))
    notes = _fan_notes(sector, off)
    known = model.stiffness_initial is not None
    water = rows[table.wet].reshape(-1, *p.shape) if table.wet.any() else None
    return _Support(w if known else None, V if known else None, p, usable, used, np.sin(nearest), off, notes, water)


def _track(model: MacroModel) -> Array:
    """Return the states (u, rotation*L) [m] of the path the springs come from."""
    return np.stack([model.origin.u, model.origin.turn], axis=1)


def _lateral(t: SpringTable, depth: Array, states: Array) -> Array:
    """Return the net p (depth, step) [N/m] that the springs give; 0 where the set has no spring."""
    rows = np.flatnonzero(np.array(t.name) == "p")
    p = np.zeros((depth.size, len(states)))
    p[np.searchsorted(depth, t.depth[rows])] = row_values(
        t.q[rows], t.r[rows], t.slope[rows], t.count[rows], t.read(states)[rows]
    )
    return p


def _usable(t: SpringTable, depth: Array) -> NDArray[np.int8]:
    """Return 1 at depths whose p is read from y over the whole path, else 0."""
    own = (np.array(t.name) == "p") & t.natural & ~t.cut
    return np.isin(depth, t.depth[own]).astype(np.int8)


def _path_vertical(model: MacroModel, u: Array, rotation: Array) -> tuple[Array, Array]:
    """Return w [m] and V [N] by step: functions of |u| (of |rotation| where that is the larger motion), flat beyond."""
    track = np.abs(_track(model))
    lead = int(np.argmax(track[-1] * [1.0, 0.999]))
    motion = np.abs(u) if lead == 0 else np.abs(rotation) * model.length
    grows = np.maximum.accumulate(track[:, lead])
    return np.interp(motion, grows, model.origin.w), np.interp(motion, grows, model.origin["V"])


def _distance(track: Array, states: Array) -> Array:
    """Return the distance of states (n, 2) from a polyline or its mirror image, over their size; last piece open."""
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


def _beyond(model: MacroModel, states: Array, used: Array, limit: Limit | None) -> str:
    """Return a sentence on states beyond the range of the springs, with the load within it and how its paths ended."""
    table = model.table
    if isinstance(table, FanTable):
        where, what = f"the fan of {len(table.path)} paths: they reach", "the"
    else:
        where, what = f"path '{model.origin.name}': springs reach", "their"
    text = f"beyond the range of {where} {used.max():.3g} times {what} calibrated "
    text += "displacement (limit 1)"
    ends = [str(model.ends[name]) for name in paths_at(model, states[int(np.argmax(used))]) if name in model.ends]
    return "; ".join(filter(None, (text, "" if limit is None else str(limit), *ends)))


def _path_notes(model: MacroModel, distance: Array, off: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on states that are far from the one path the springs come from."""
    arm = model.origin.arm
    height = f" (load height {arm:g} m)" if np.isfinite(arm) else ""
    text = (
        f"{off.sum()} of {off.size} states are off the path '{model.origin.name}'{height} "
        f"they come from, by up to {distance.max(initial=0.0):.0%} (limit {OFF_PATH:.0%}): "
        "springs do not transfer between load paths, check against the full model"
    )
    return [text] if off.any() else []


def _fan_notes(sector: Array, off: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on states between rays too far apart."""
    text = (
        f"{off.sum()} of {off.size} states are between calibration paths {np.degrees(sector.max(initial=0.0)):.3g} "
        f"degrees apart in (u, rotation*skirt_length) (limit {np.degrees(WIDEST):.3g}): add a path between them"
    )
    return [text] if off.any() else []


def _provenance(model: MacroModel) -> dict[str, Any]:
    attrs = {name: model.attrs[name] for name in _KEPT if name in model.attrs} | {"springs": model.spring_set}
    attrs["curves"] = "monotonic backbone, odd, last slope beyond the calibrated range"
    if model.memory is not None:
        attrs["curves"] = "elastoplastic elements in parallel, which remember reversals"
    if isinstance(model.table, FanTable):
        rays = zip(model.table.path, np.degrees(model.table.angle), strict=True)
        rays_text = ", ".join(f"{name} ({angle:.1f} deg)" for name, angle in rays)
        return attrs | {"path": f"{len(model.table.path)} paths", "rays": rays_text}
    arm = float(model.origin.attrs.get("arm_m", np.nan))
    attrs |= {"calibration_arm_m": arm} if np.isfinite(arm) else {}
    return attrs | {
        "path": model.origin.name,
        "kind": model.origin.kind,
        "n_other_carrier": int((~model.table.natural).sum()),
        "n_cut": int(model.table.cut.sum()),
    }
