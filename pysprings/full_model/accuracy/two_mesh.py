# SPDX-License-Identifier: MIT
"""A run's own estimate of its discretisation error, from the same scene on a coarser mesh.

The difference of the two divided by r^p - 1 (r: ratio of the cell sizes, p: ORDERS) is the distance from what both tend
to, as in Richardson's extrapolation; SAFETY times that is the estimate, and of extrapolated paths the share UNSURE of
the difference. The coarser mesh of bricks has 0.7 times the cells in each direction: of all factors near 3/4 it is one
with which every preset loses sectors, too (their number is a multiple of 4), so that no direction keeps its error.

A Fourier series has two sizes, that of the elements in the section and the number N of harmonics. The coarser section
is run with N and with more harmonics; their difference is the share of the harmonics and is added: of paths that have
it in their reactions (`own_estimate`), LEFT of it.

`python -m benchmarks.error_estimates` sets estimates beside truths on scenes that no setting was made with.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pysprings.core.path_kinds import HELD_BACK, MEMORY
from pysprings.core.text import percent
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.measures import (
    LOAD,
    OTHER,
    PY,
    STIFFNESS,
    cell_size,
    curves_of,
    first_secant,
    off_plane_error,
    samples,
)
from pysprings.full_model.accuracy.presets import BRICKS, COARSEST_FACTOR, FOURIER
from pysprings.springs.path import paths_of, space_paths_of

if TYPE_CHECKING:
    from pysprings.scene.model import Scene
    from pysprings.scene.sections import Path

NO_OUTPUT = {"interface_fields": False, "section": False, "figures": False, "paraview": False}
FACTOR = {BRICKS: 0.7, FOURIER: 0.6}
# Without an order of its own: that of stresses in linear elements, which the singularity at the tip does not let pass.
USUAL_ORDER = 1.0
# Roache (1994) takes 3 for an order that two meshes cannot confirm; see benchmarks/error_estimates.py for ours.
SAFETY = {BRICKS: 3.0, FOURIER: 2.0}
# Of bricks, those of load and p(y) in the study of data/evidence/accuracy.csv. Of a series, two is that of stresses in
# quadratic elements, three that of their stiffness beside the tip's corners.
VERTICAL = "vertical load"
ORDERS = {
    BRICKS: {LOAD: 1.715, VERTICAL: 1.715, PY: 1.988},
    FOURIER: {LOAD: 1.711, VERTICAL: 1.711, PY: 2.0, STIFFNESS: 3.0},
}
# Shares of the difference of both meshes that extrapolation may leave: those that scenes ask for
# (data/evidence/error-estimates-clay.csv, -sand.csv, -dense.csv); p(y) near the tip has no order that it keeps, and its
# edge effect covers a skirt below SHORT D, where IN_SHORT counts.
SHORT = 0.5
UNSURE = {
    "sand": {LOAD: 0.6, VERTICAL: 0.35, OTHER: 0.4, PY: 0.9},
    "sand by density": {LOAD: 1.0, VERTICAL: 0.35, OTHER: 0.4, PY: 0.9},
    "clay": {LOAD: 0.35, VERTICAL: 0.35, OTHER: 0.4, PY: 0.9},
}
IN_SHORT = {
    "sand": {LOAD: 0.85, PY: 1.4},
    "sand by density": {LOAD: 1.2, PY: 1.4},
    "clay": {LOAD: 0.875, VERTICAL: 0.875, PY: 1.4},
}
# [%] of the change of V: bearing of the tip in sand falls with the first power of its cells, and two meshes agree too
# soon; with halved elements beside the tip HALVED of what these change is left, and LEAST_HALVED at least
# (data/evidence/error-estimates-vertical.csv)
LEAST_IN_SAND = {"vertical_max": 4.0}
HALVED, LEAST_HALVED = 0.5, 1.0
# Share of the difference of N and N + 2 harmonics that adding it leaves; N 3, clay with a gap, 10 % of D: 0.3 of loads.
LEFT = 0.5
SMALLEST_RATIO = 1.05  # of cell sizes: closer meshes give no estimate of their error

# Where the first increment's secant is farther from it, the stiffness at rest depends on which points of the mesh yield
# at once, and tends to nothing.
AT_REST = 0.001

# measure -> quantity whose order it takes
ESTIMATED = {
    "load_max": LOAD, "py_rms": PY, "rotation_max": OTHER, "vertical_max": VERTICAL, "stiffness": STIFFNESS,
}  # fmt: skip
DECISIVE = ("load_max", "py_rms")  # measures that choose the number of harmonics


def coarser(scene: Scene) -> Scene:
    """Return the scene on the coarser mesh, without pictures and fields; the same scene if there is no coarser one.

    Bricks have `few` of its paths; a series has all, since its springs are extrapolated from both meshes.
    """
    from pysprings.model.build import counts_of
    from pysprings.model.fourier import section_counts_of

    azimuth, kind = scene.mesh.azimuth, scene.discretisation
    factor = FACTOR[kind]
    changed: dict[str, Any] = {"refinement": max(factor * scene.mesh.refinement, COARSEST_FACTOR)}
    if azimuth is not None:
        changed["azimuth"] = max(8, 4 * round(factor * azimuth / 4))
    coarse = scene.replace(mesh=changed, output=NO_OUTPUT)
    same = section_counts_of if kind == FOURIER else counts_of
    if same(coarse) == same(scene):
        return scene
    return coarse if kind == FOURIER else few(coarse)


def few(scene: Scene) -> Scene:
    """Return a scene whose fan has a few paths (`pysprings.scene.fan.few_paths`); the scene itself without a fan."""
    from pysprings.scene.fan import few_paths

    paths = few_paths(scene.springs, scene.caisson)
    return with_paths(scene, (*scene.paths, *paths)) if paths else scene


def with_paths(scene: Scene, paths: Iterable[Path], **changed: Any) -> Scene:
    """Return a scene with paths in place of its own and its fan, and other sections changed.

    No springs are made of it: paths of the memory, which would need the others, are held back.
    """
    held = (path.model_copy(update={"role": HELD_BACK}) if path.role == MEMORY else path for path in paths)
    return scene.replace(paths=tuple(held), **changed)


def cell_ratio(scene: Scene, coarse: Scene) -> float | None:
    """Return the ratio of the cell sizes at wall, mudline and tip of a section and its coarser one; None of bricks.

    The error of a section comes from there. Its number of elements falls by less where the skirt has few of them.
    """
    if scene.discretisation != FOURIER:
        return None
    return scene.mesh.refinement / coarse.mesh.refinement


ByPath = dict[str, dict[str, float]]


def differences(fine: xr.DataTree, coarse: xr.DataTree) -> ByPath:
    """Return the difference [%] of two results by path and measure, of the paths that both have.

    The load of a vertical path is the change of V, a measure of its own: `vertical_max`.
    """
    paths = paths_of(fine, of_mesh=True)
    by_path = samples({"fine": curves_of(fine, of_mesh=True), "coarse": curves_of(coarse, True, paths)})
    found = {name: measures.errors(each["coarse"], each["fine"]) for name, each in by_path.items()}
    others, none = space_paths_of(coarse), dict.fromkeys(measures.MEASURES, float("nan"))
    for name, path in space_paths_of(fine).items():
        if name in others:
            length, radius = float(fine.attrs["skirt_length_m"]), 0.5 * float(fine.attrs["outer_diameter_m"])
            found[name] = none | {"load_max": off_plane_error(path.recorded, others[name].recorded, length, radius)}
    for name, each in found.items():
        vertical = name in paths and paths[name].rules.drives == "w"
        each["vertical_max"] = each["load_max"] if vertical else float("nan")
        each["load_max"] = float("nan") if vertical else each["load_max"]
    return found


def left_in(scene: Scene) -> dict[str, float]:
    """Return the share of the difference of both meshes that extrapolation may leave, by measure."""
    short = scene.caisson.skirt_length < SHORT * scene.caisson.outer_diameter
    dense = any(stratum.law == "sand" for stratum in scene.ground.strata)
    where = "clay" if scene.ground.total_stress else "sand by density" if dense else "sand"
    shares = UNSURE[where] | (IN_SHORT[where] if short else {})
    return {name: shares[quantity] for name, quantity in ESTIMATED.items() if quantity in shares}


def estimate(
    fine: xr.DataTree,
    coarse: xr.DataTree,
    richer: xr.DataTree | None = None,
    ratio: float | None = None,
    extrapolated: Mapping[str, Any] | None = None,
    near: Mapping[str, dict[str, float]] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return the estimate from a result and that of the coarser mesh, as run.json keeps it (percent).

    ``richer`` is the coarser mesh with more harmonics. ``ratio`` is that of the cell sizes; None: from the numbers of
    unknowns. ``extrapolated`` has the paths whose reactions are (`own_estimate`), and those that have the difference
    of the harmonics: what is left of their errors are its shares `left` (`left_in`) and LEFT of the differences.
    ``near`` has the differences to halved elements beside the tip, of paths that are extrapolated from these: HALVED of
    it is left.
    """
    unknowns = [int(tree.attrs["n_unknowns"]) for tree in (fine, coarse)]
    fewer = _size(coarse) / _size(fine)
    if fewer < SMALLEST_RATIO:
        return missing(f"no mesh with fewer cells: {unknowns[1]} unknowns beside {unknowns[0]}")
    ratio = fewer if ratio is None else ratio
    own, beyond = {**differences(fine, coarse), **near}, {} if richer is None else differences(richer, coarse)
    if not own:
        return missing("the runs have no path in common with two converged states")
    kind = str(fine.attrs.get("discretisation", BRICKS))
    result: dict[str, Any] = {
        "method": "two meshes", "refinement_factor": FACTOR[kind], "unknowns": unknowns, "cell_ratio": round(ratio, 4),
        "safety": SAFETY[kind], "order": {}, "difference_pct": {}, "estimate_pct": {},
    }  # fmt: skip
    if richer is not None and beyond:
        numbers = [int(tree.attrs["harmonics"]) for tree in (coarse, richer)]
        result |= {"method": "two meshes, two numbers of harmonics", "harmonics": numbers, "harmonics_pct": {}}
    better, left_of, least = list[str](), dict[str, float](), dict[str, float]()
    if extrapolated is not None:
        better, left_of, least = extrapolated["paths"], extrapolated["left"], extrapolated.get("least", {})
        result |= {"extrapolated": dict(extrapolated)}
    estimates: ByPath = {name: {} for name in own}
    for name, quantity in ESTIMATED.items():
        order = ORDERS[kind].get(quantity, USUAL_ORDER)
        result["order"][name] = extrapolated["order"] if extrapolated and better and name in left_of else order
        if quantity == STIFFNESS and not starts_elastic(fine):
            continue
        whole = SAFETY[kind] / (ratio**order - 1.0)
        more = _of_harmonics(name, own, beyond, extrapolated or {})
        for path, each in own.items():
            if not np.isfinite(each[name]):
                continue
            left = HALVED if path in near else left_of.get(name, whole) if path in better else whole
            estimates[path][name] = left * each[name] + more[path]
            if path in better:  # meshes may agree by chance
                floor = LEAST_HALVED if path in near else least.get(name, 0.0)
                floor = estimates[path].get("load_max", 0.0) if quantity == OTHER else floor
                estimates[path][name] = max(estimates[path][name], floor)
        for key, values in (("difference_pct", own), ("harmonics_pct", beyond)):
            finite = [each[name] for each in values.values() if np.isfinite(each[name])]
            if finite and key in result:
                result[key][name] = max(finite)
        if any(name in each for each in estimates.values()):
            result["estimate_pct"][name] = max(each[name] for each in estimates.values() if name in each)
    return result | _by_path(estimates) if result["estimate_pct"] else missing(_NOT_FINITE)


def _of_harmonics(name: str, own: ByPath, beyond: ByPath, extrapolated: Mapping[str, Any]) -> dict[str, float]:
    """Return by path of ``own`` what harmonics leave of a measure [%], from their differences ``beyond``.

    A lateral path that did not run with more harmonics has the mean of those that did.
    """
    known = [each[name] for each in beyond.values() if np.isfinite(each["py_rms"]) and np.isfinite(each[name])]
    mean, corrected = float(np.mean(known)) if known else 0.0, extrapolated.get("harmonics_added", ())
    found = {path: mean * bool(np.isfinite(each["py_rms"])) for path, each in own.items()}
    found |= {path: float(np.nan_to_num(beyond[path][name])) for path in own if path in beyond}
    return {path: size * (LEFT if path in corrected else 1.0) for path, size in found.items()}


_NOT_FINITE = "the difference of both meshes has no finite value"
# of an estimate by path
_KEYS = {"load_max": "load_pct", "vertical_max": "load_pct", "py_rms": "py_pct", "rotation_max": "rotation_pct"}


def _by_path(estimates: ByPath) -> dict[str, Any]:
    """Return the entries of run.json on single paths: estimates, the worst path, and which quantity is worst there."""
    by_path = {
        path: {_KEYS[name]: value for name, value in each.items() if name in _KEYS} for path, each in estimates.items()
    }
    sizes = [(each[name], path, _KEYS[name]) for path, each in estimates.items() for name in DECISIVE if name in each]
    if not sizes:
        return {"by_path": by_path}
    _, path, quantity = max(sizes)
    return {"by_path": by_path, "worst_path": path, "worst_quantity": quantity.removesuffix("_pct")}


def starts_elastic(tree: xr.DataTree) -> bool:
    """Return whether the first increment of each path goes along the stiffness at rest, within AT_REST.

    Paths that bend have no secant to compare.
    """
    matrix = tree.dataset["stiffness_initial"].values
    ratios = [first_secant(matrix, path.dataset) for path in paths_of(tree, of_mesh=True).values()]
    return all(abs(ratio - 1.0) <= AT_REST for ratio in ratios if ratio is not None)


def _size(tree: xr.DataTree) -> float:
    """Return the size of the cells of a result's mesh, up to a factor."""
    harmonics = tree.attrs.get("harmonics")
    return cell_size(int(tree.attrs["n_unknowns"]), None if harmonics is None else int(harmonics))


def missing(why: str) -> dict[str, Any]:
    """Return what stands in the place of an estimate that cannot be made."""
    return {"method": "two meshes", "estimate_pct": {}, "why_not": why}


def words(estimated: Mapping[str, Any]) -> str:
    """Return an estimate in words, one line."""
    if not estimated["estimate_pct"]:
        return f"no estimate of the discretisation error: {estimated['why_not']}"
    series, how = estimated.get("harmonics"), estimated.get("extrapolated") or {}
    beside = "" if series is None else f", {series[0]} and {series[1]} harmonics"
    safe = f"safety factor {estimated['safety']:g} included"
    safe = f"what extrapolation by order {how['order']:g} leaves" if how.get("paths") else safe
    return (
        f"estimated discretisation error: {short(estimated)} (two meshes, {estimated['unknowns'][1]:,} and "
        f"{estimated['unknowns'][0]:,} unknowns{beside}; {safe})"
    )


def short(estimated: Mapping[str, Any]) -> str:
    """Return the numbers of an estimate, its worst path, and the paths that stopped on the coarser mesh."""
    parts = [f"{head(name)} {percent(value)}" for name, value in estimated["estimate_pct"].items()]
    if worst := estimated.get("worst_path"):
        quantity = {"py": "p-y"}.get(str(estimated.get("worst_quantity")), "load")
        parts.append(f"largest of load and p-y: {quantity} of path {worst}")
    return "; ".join([", ".join(parts), *([text] if (text := companion_text(estimated)) else [])])


def head(name: str) -> str:
    """Return the words of a measure of an estimate in lines and tables."""
    return "V" if name == "vertical_max" else measures.MEASURES[name].head


def companion_text(estimated: Mapping[str, Any]) -> str:
    """Return which paths stopped on the coarser mesh, where the estimate ends; empty without any."""
    stopped = estimated.get("companion_stopped") or {}
    if not stopped:
        return ""
    names = ", ".join(f"{name} ({why})" for name, why in stopped.items())
    of = estimated.get("companion_paths")
    count = f"{len(stopped)} of {of} paths" if of else f"{len(stopped)} paths"
    return f"companion stopped on {count}: {names}; the estimate ends there"
