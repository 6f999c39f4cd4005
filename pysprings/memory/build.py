# SPDX-License-Identifier: MIT
"""Springs -> model with a memory: calibrated from their rays, or read where a file holds the elements."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.errors import refused
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import MEMORY
from pysprings.core.progress import Progress
from pysprings.macro.fan import build_fan
from pysprings.macro.vertical import build_vertical
from pysprings.memory.calibration import ElementSet, SpaceElements, calibrate
from pysprings.memory.elements import YIELDED
from pysprings.memory.mixture import LAG, RENEWED, ChangingLoad, fitted, mixed, shares_at
from pysprings.memory.model import MemorySprings
from pysprings.memory.shares import Sample, Shares, samples
from pysprings.memory.space import calibrate_in_space
from pysprings.memory.water import Water
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs, memory_groups

MISSING = (
    "no ray that turns back at this vertical load and rate: monotonic paths do not show how the soil reacts on "
    "reversal. Run the scene with `[springs] memory = true`, or add a translation or rotation with `then` and "
    'role = "memory"'
)
CALIBRATED = (
    "the file has no elements that belong to its paths: they were calibrated for this answer. `pysprings springs FILE "
    "--out NEW.nc` writes a file that has them"
)
VERSION = 9
SPACE_VERSION = b"space 3"  # of elements in space
CHANGE = f"{MEMORY}_load_change"
_SPACE = {
    "space_rows": ("space_element", "space_parameter"), "space_p_loads": ("space_depth", "space_load"),
    "space_p_elastic": ("space_depth", "space_motion"), "space_even": ("space_vertical", "space_way"),
}  # fmt: skip
_HEAD = ("rows", "odd", "rest", "loads", "elastic", "even")


def has_memory(springs: Springs) -> bool:
    """Return whether springs have a fan, and rays that turn back at its rate, at some vertical load."""
    return springs.has_fan and bool(_at_loads(springs))


def build_memory(springs: Springs) -> MemorySprings:
    """Return springs with a memory at one rate and vertical load; with the stored elements where they are theirs.

    Between two rates, or vertical loads, with rays that turn back they have the elements of both, each with its share;
    beyond the loads those of the nearest.

    Raises UserInputError: the springs have no fan, or no ray that turns back at their rate.
    """
    table, (V, parts), known = build_fan(springs), _parts(springs), _at_loads(springs)
    turning = _recorded(parts[0][0])[0][0].remembering[0]
    rate = float(springs.attrs["rate_m_per_s"]) if springs.parts else turning.rate
    sets, needed = sum(len(_recorded(at)) for at, _ in parts), _needed(springs)
    found = {load: _elements(at) for load, at in known.items() if any(at is each for each in needed)}
    paths = springs.remembering or [path for path in springs.paths.values() if path.remembers]  # of another load
    return MemorySprings(
        table, springs.paths[table.path[0]], (*table.path, *(path.name for path in paths)),
        () if has_elements(springs) else (CALIBRATED,),
        elements=mixed([(found[load], share) for load, at in known.items() for each, share in parts if each is at]),
        V=V, rate=rate if springs.rate_sets else None, sets=sets,
        changing=_changing(springs, found) if _follows(springs) else None, vertical=build_vertical(springs),
    )  # fmt: skip


def _follows(springs: Springs) -> bool:
    """Return whether springs have paths on which V changes, and elements at several vertical loads that follow it."""
    return bool(springs.changing) and len(_at_loads(springs)) > 1 and not springs.rate_sets


def _needed(springs: Springs) -> list[Springs]:
    """Return the springs at the vertical loads whose elements the model has."""
    return [*_at_loads(springs).values()] if _follows(springs) else [at for at, _ in _parts(springs)[1]]


def _changing(springs: Springs, sets: Mapping[float, ElementSet]) -> ChangingLoad:
    """Return the elements at vertical loads [N] under a V that changes, stored or fitted."""
    loads, stored = np.array(list(sets)), _stored_change(springs)
    if stored is not None:
        virgin, reloading = (float(stored.attrs[name]) for name in ("virgin_N", "reloading_N"))
        return ChangingLoad(loads, tuple(sets.values()), virgin, reloading)
    paths = []
    for path in springs.changing:
        carried = np.stack([path["H"] - path["H"][0], (path["M"] - path["M"][0]) / path.length], axis=1)
        paths.append((np.stack([path.u, path.turn], axis=1), carried, path.given_loads))
    return fitted(loads, tuple(sets.values()), paths)


def _stored_change(springs: Springs) -> xr.Dataset | None:
    """Return what is stored of a V that changes, fitted to the paths of springs; None without."""
    stored = (springs.whole or springs).memory.get(CHANGE)
    own = stored is not None and stored.attrs["paths_sha256"] == _change_digest(springs)
    return stored if own else None


def _change_digest(springs: Springs) -> str:
    """Return the SHA-256 (hex) of what elements under a V that changes are fitted to, and of their law."""
    law = repr((YIELDED, LAG, RENEWED))
    found = hashlib.sha256("".join([law, *(digest(at) for at in _at_loads(springs).values())]).encode())
    for path in springs.changing:
        for values in (path.u, path.rotation, path["H"], path["M"], path.given_loads):
            found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()


def has_elements(springs: Springs) -> bool:
    """Return whether all elements of the model are stored in the springs: else `build_memory` calibrates them."""
    whole = all(_stored(part) is not None for at in _needed(springs) for part, _ in _recorded(at))
    return whole and (not _follows(springs) or _stored_change(springs) is not None)


def _parts(springs: Springs) -> tuple[float, list[tuple[Springs, float]]]:
    """Return the vertical load [N] of springs, and the springs with rays that turn back about it, with their shares."""
    known = _at_loads(springs)
    if not known:
        raise refused("springs", MISSING)
    own = springs.rest_load if springs.blended_loads else springs.paths[next(iter(springs.rays))].load
    V = _between(own, list(known))
    shares = shares_at(np.array([V]), np.array(list(known)))[0].tolist()
    return V, [(at, share) for at, share in zip(known.values(), shares, strict=True) if share > 0.0]


def _recorded(springs: Springs) -> tuple[tuple[Springs, float], ...]:
    """Return the springs at recorded rates that springs lie between, each with its share; or themselves."""
    return springs.parts or ((springs, 1.0),)


def _turns(springs: Springs) -> bool:
    """Return whether springs at one of their vertical loads have rays that turn back there, at their rate."""
    return springs.blended_loads is None and all(part.remembering for part, _ in _recorded(springs))


def _at_loads(springs: Springs) -> dict[float, Springs]:
    """Return the springs at each vertical load [N] with rays that turn back, by increasing load."""
    whole = springs.whole or springs
    several = len(whole.load_sets) > 1
    each = [whole.at_load(one.V) for one in whole.load_sets] if several else [springs]
    return {_recorded(at)[0][0].remembering[0].load: at for at in each if _turns(at)}


def _between(V: float, loads: Sequence[float]) -> float:
    """Return V [N] within the range of vertical loads; one of them where both are one."""
    inside = min(max(V, loads[0]), loads[-1])
    return next((load for load in loads if same_load(load, inside)), inside)


def _elements(springs: Springs) -> ElementSet:
    """Return the elements at one vertical load: stored ones, calibrated ones, or those of two rates together."""
    if springs.parts:
        return mixed([(_elements(part), share) for part, share in springs.parts])
    stored = _stored(springs)
    return _calibrated(springs) if stored is None else from_dataset(stored)


def _stored(springs: Springs) -> xr.Dataset | None:
    """Return the stored elements that were calibrated on the paths of springs; None without."""
    own = digest(springs)
    return next((stored for stored in springs.memory.values() if stored.attrs.get("paths_sha256") == own), None)


def _calibrated(springs: Springs) -> ElementSet:
    scale, table = np.array([1.0, springs.length]), build_fan(springs)
    stiffness, others = springs.lateral_stiffness / scale / scale[:, None], list[Sample]()
    for at in _at_other_rates(springs):
        others += [way for way in samples(at, build_fan(at)) if way.recorded]
    ways = samples(springs, table)
    planar = calibrate(ways, table, stiffness, others=others)
    return replace(planar, space=calibrate_in_space(springs, planar, ways, table, stiffness))


def _at_other_rates(springs: Springs) -> list[Springs]:
    """Return springs at the other rates, at the same vertical load; none where no water carries a part of p."""
    whole, own = springs.every_rate, springs.paths[next(iter(springs.rays))]
    if whole is None or not own.water.any():
        return []
    found = [whole.at(rate=one.rate, V=own.load) for one in whole.rate_sets if own.name not in one.paths]
    return [at for at in found if at.has_fan and at.remembering and same_load(at.remembering[0].load, own.load)]


def with_memory(tree: xr.DataTree, progress: Progress | None = None) -> xr.DataTree:
    """Return springs with the calibrated elements in the group "memory"; as they are where they have no memory.

    Stored elements that belong to the paths stay, others are calibrated.
    Each vertical load and rate has its own elements: "memory" those of the load at rest and the slowest rate,
    "memory_load_1", "memory_rate_1", "memory_load_1_rate_1" those of the next ones. "memory_load_change" has what a V
    that changes does to them.
    """
    springs = Springs.of(tree)
    rates: list[float | None] = [one.rate for one in springs.rate_sets] if len(springs.rate_sets) > 1 else [None]
    loads = sorted((one.V for one in springs.load_sets), key=lambda V: not same_load(V, springs.rest_load))
    found: dict[str, xr.Dataset] = {}
    say = partial(progress or (lambda *_: None), "springs with memory")
    sets = [*product(enumerate(loads), enumerate(rates))]
    for number, ((load, V), (pace, rate)) in enumerate(sets):
        at = springs.at(rate=rate, V=V)
        stored = {each.attrs["paths_sha256"] for each in found.values()}
        if at.has_fan and _turns(at) and digest(at) not in stored:  # a lone path at a load has springs of others
            name = f"/{MEMORY}" + (f"_load_{load}" if load else "") + (f"_rate_{pace}" if pace else "")
            known = _stored(at)
            if known is None:
                say(number / len(sets), f"elements of set {number + 1} of {len(sets)}")
                known = memory_dataset(at, _calibrated(at))
                say((number + 1) / len(sets), "")
            found[name] = known
    if not found:
        return tree
    if _follows(springs):
        found[f"/{CHANGE}"] = _change_dataset(springs, xr.DataTree.from_dict(_groups(tree) | found, name=tree.name))
    return xr.DataTree.from_dict(_groups(tree) | found, name=tree.name)


def _change_dataset(springs: Springs, whole: xr.DataTree) -> xr.Dataset:
    """Return what a V that changes does to the elements of springs as a group; whole: springs with all elements."""
    stored, parts = _stored_change(springs), Springs.of(whole)
    if stored is not None:
        return stored
    change = _changing(parts, {load: _elements(at) for load, at in _at_loads(parts).items()})
    attrs = {"virgin_N": change.virgin, "reloading_N": change.reloading, "paths_sha256": _change_digest(springs)}
    return xr.Dataset(attrs=attrs)


def _groups(tree: xr.DataTree) -> dict[str, xr.Dataset]:
    """Return the groups of a tree but those of elements."""
    older = {f"/{name}" for name in memory_groups(tree)}
    return {node.path: node.to_dataset(inherit=False) for node in tree.subtree if node.path not in older}


def memory_dataset(springs: Springs, elements: ElementSet) -> xr.Dataset:
    """Return the elements of springs as the group "memory" of a spring file."""
    dims = {
        "rows": ("element", "parameter"), "odd": ("row",), "rest": ("row",), "loads": ("odd_row", "load"),
        "elastic": ("odd_row", "motion"), "even": ("even_row", "way"),
    }  # fmt: skip
    shares = elements.shares
    values = {"rows": elements.rows, "odd": shares.odd.astype(np.int8)}
    values |= {name: getattr(shares, name) for name in _HEAD[2:]}
    if shares.water is not None:
        dims |= {"water": ("water_row", "relaxation", "way"), "times": ("relaxation", "element")}
        values |= {"water": shares.water.factors, "times": shares.water.times}
    data = {name: (dims[name], value, {"units": "1"}) for name, value in values.items()}
    attrs: dict[str, Any] = {"version": VERSION, "reach_m": elements.reach, "residual": elements.residual}
    attrs |= {"heave_growth": shares.growth, "way_m": elements.way}
    attrs |= {"paths_sha256": digest(springs)} | _error_attrs(elements.errors)
    if elements.space is not None:
        for name, of in _SPACE.items():
            data[name] = (of, getattr(elements.space, name.removeprefix("space_")), {"units": "1"})
        attrs |= _space_attrs(elements.space)
    return xr.Dataset(data, attrs=attrs)


def _space_attrs(space: SpaceElements) -> dict[str, Any]:
    """Return what a spring file holds of elements in space beside their rows."""
    return {
        "radius_m": space.radius, "twist_m": space.twist, "space_growth": space.growth, "space_way_m": space.way,
        "space_residual": space.residual, "torsion_residual": space.torsion_residual,
    } | _error_attrs(space.errors, "space_")  # fmt: skip


def _error_attrs(errors: Mapping[str, tuple[float, float]], of: str = "") -> dict[str, Any]:
    """Return the errors in H and M of each way as a spring file holds them."""
    ways = {f"{of}ways": list(errors)}
    return ways | {f"{of}{load}_errors": [pair[k] for pair in errors.values()] for k, load in enumerate("HM")}


def _errors(attrs: Mapping[Any, Any], of: str = "") -> dict[str, tuple[float, float]]:
    """Return the errors in H and M of each way that a spring file holds."""
    ways, *errors = (np.atleast_1d(attrs[f"{of}{name}"]) for name in ("ways", "H_errors", "M_errors"))
    return {str(way): (float(H), float(M)) for way, H, M in zip(ways, *errors, strict=True)}


def _space_of(stored: xr.Dataset) -> SpaceElements | None:
    """Return the elements in space of the group "memory" of a spring file; None where it has none."""
    if "space_rows" not in stored:
        return None
    rows, loads, elastic, even = (np.ascontiguousarray(stored[name].values) for name in _SPACE)
    names = ("radius_m", "twist_m", "space_growth", "space_way_m", "space_residual", "torsion_residual")
    radius, twist, growth, way, residual, of_torsion = (float(stored.attrs[name]) for name in names)
    errors = _errors(stored.attrs, "space_")
    return SpaceElements(rows, radius, twist, loads, elastic, even, growth, way, residual, of_torsion, errors)


def from_dataset(stored: xr.Dataset) -> ElementSet:
    """Return the elements of the group "memory" of a spring file."""
    rows, odd, rest, loads, elastic, even = (stored[name].values for name in _HEAD)
    attrs, errors = stored.attrs, _errors(stored.attrs)
    water = Water(stored["water"].values, stored["times"].values) if "water" in stored else None
    shares = Shares(odd.astype(bool), rest, loads, elastic, even, float(attrs["heave_growth"]), water)
    reach, residual, way = (float(attrs[name]) for name in ("reach_m", "residual", "way_m"))
    return ElementSet(np.ascontiguousarray(rows), reach, shares, residual, errors, way, _space_of(stored))


def digest(springs: Springs) -> str:
    """Return the SHA-256 (hex) of the loads, motions and rates of the paths that elements are calibrated on."""
    found = hashlib.sha256(f"{VERSION} {springs.length!r}".encode())
    for path in _calibrating(springs):
        found.update(f" {path.rate or 0.0:.6g}".encode())
        for values in (path.u, path.rotation, path["H"], path["M"]):
            found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    wet = [path for at in (springs, *_at_other_rates(springs)) for path in _calibrating(at)]
    for path in wet if "time" in wet[0] and wet[0].water.any() else ():
        for values in (path.u, path.rotation, path.water, path["time"]):
            found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    for space in springs.turning:
        found.update(SPACE_VERSION)
        for values in (space.motions(0.5 * springs.diameter), space.loads(0.5 * springs.diameter)):
            found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()


def _calibrating(springs: Springs) -> list[SpringPath]:
    """Return the paths that elements are calibrated on."""
    return [*(springs.paths[name] for name in springs.rays), *springs.remembering]
