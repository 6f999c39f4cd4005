# SPDX-License-Identifier: MIT
"""Reactions of a path at equal motion, extrapolated from two meshes of one family (Richardson 1911).

Each reaction and each free motion q of the finer mesh becomes q + (q - q_c)/(r^o - 1): q_c is that of the coarser mesh
where the path has come as far, r the ratio of the cells, o the order that the study of sections found (docs/evidence,
"Sections"). What two harmonics more change on the coarser mesh is added: both errors are small, and their product is
left out (the combination technique, Griebel, Schneider and Zenger 1992). One share for all quantities keeps what is
linear in them: sums of reactions remain the loads, a load its height, y(z) = u - rotation z.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from pysprings.core import variables
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.core.variables import EXTRAPOLATED
from pysprings.model.fourier_mesh import COHESIVE, FRICTIONAL
from pysprings.springs.path import RecordedPath, paths_of
from pysprings.springs.path_ends import end_numbers
from pysprings.springs.sums import with_moment

Array = NDArray[np.float64]
# Collapse loads of clay fall more slowly with the cells than those of sand (data/evidence/sections.csv).
ORDERS = {FRICTIONAL: 2.0, COHESIVE: 1.7}
LEAST_RATIO = 1.6  # of the cells: closer meshes would multiply what is not of the mesh, such as tolerances and steps
_DEPTHS = ("p_component", "m", "t")
_ORDER = ("depth", "side", "component", "step")
_SAME = 1e-9  # of the way: states within it are one


class NotAlike(ValueError):
    """The path of the coarser mesh does not come as far, or the ways of both have no common measure."""


def share_of(ratio: float, order: float) -> float:
    """Return what is added of the difference of two meshes: 1/(r^o - 1)."""
    return 1.0 / (ratio**order - 1.0)


def extrapolated(
    fine: xr.DataTree, coarse: xr.DataTree, share: float, richer: xr.DataTree | None = None
) -> tuple[xr.DataTree, dict[str, str], dict[str, str]]:
    """Return the result of the finer mesh with extrapolated paths, and by path why it is not extrapolated.

    ``richer`` is the coarser mesh with more harmonics; the last item has the extrapolated paths that lack what these
    change, with the reason. Each path that is extrapolated has a group `extrapolated` beside its own values
    (`springs.path.paths_of` takes it in their place).
    """
    tree, not_alike, without = fine.copy(deep=False), {}, {}
    other, more = paths_of(coarse, of_mesh=True), {} if richer is None else paths_of(richer, of_mesh=True)
    for name, path in paths_of(fine, of_mesh=True).items():
        try:
            cells, harmonics = _beside(path, other.get(name)), None
        except NotAlike as error:
            not_alike[name] = str(error)
            continue
        try:
            harmonics = None if richer is None else _beside(path, more.get(name))
        except NotAlike as error:
            without[name] = str(error)
        tree[f"paths/{name}/{EXTRAPOLATED}"] = xr.DataTree(_path(path, share, cells, harmonics))
    return tree, not_alike, without


def has_equal_motion(path: RecordedPath) -> bool:
    """Return whether a motion drives a path, so that meshes can be compared at equal motion."""
    return not (path.rules.force or path.rules.conjugate)


Reactions = dict[str, Array]


def _path(fine: RecordedPath, share: float, cells: Reactions, harmonics: Reactions | None = None) -> xr.Dataset:
    """Return the extrapolated variables of a path, from those of coarser cells, and of these with more harmonics."""
    own, new = fine.recorded, {}
    steps = np.flatnonzero(own["converged"].values == 1)
    held = {"u", "w", "rotation"} & set(PATH_KINDS[fine.kind].holds)
    for name in (name for name in cells if name not in held):
        order = _axes(own, name)
        values = np.array(own[name].transpose(*order).values, dtype=float)
        values[..., steps] += share * (values[..., steps] - cells[name])
        if harmonics is not None:
            values[..., steps] += harmonics[name] - cells[name]
        new[name] = (order, values)
    return _with_sums(own, new)


def _axes(path: xr.Dataset, name: str) -> tuple[str, ...]:
    return tuple(sorted(map(str, path[name].dims), key=_ORDER.index))


def _beside(fine: RecordedPath, path: RecordedPath | None) -> Reactions:
    """Return reactions and free motions of a path of another mesh at the converged steps and the slices of the finer.

    Raises NotAlike: the path did not come as far there, or has no equal motion.
    """
    if path is None:
        raise NotAlike("it did not start on the coarser mesh")
    own, other = fine.recorded, path.dataset
    if not has_equal_motion(fine):
        raise NotAlike("a load drives it: both meshes have no equal motion")
    at, known = _way(fine.dataset, fine.length), _way(other, fine.length)
    flat = str(other.attrs["status"]) == "limit load"  # its reactions stay beyond
    if at[-1] > known[-1] * (1.0 + _SAME) and not flat:
        raise NotAlike(f"it stopped on the coarser mesh at {100.0 * known[-1] / at[-1]:.0f} % of its way")
    at, found = np.minimum(at, known[-1]), {}
    for name in (name for name in variables.GROUPS[EXTRAPOLATED] if name in own and name in other):
        if name in ("p", "y"):
            continue
        values = other[name].transpose(*_axes(own, name)).values
        if name in _DEPTHS:
            bounds, depth = own["depth_bounds"].values, own["depth"].values
            values = _resliced(values, other, bounds, depth, levers=name == "p_component")
        found[name] = _between(known, values, at)
    return found


def _with_sums(own: xr.Dataset, new: dict[str, tuple[tuple[str, ...], Array]]) -> xr.Dataset:
    """Return the variables with p, the sum over sides and components, and y, in the order of the path's own."""
    p = new["p_component"][1].sum(axis=(1, 2))
    u, turn = (new[n][1] if n in new else own[n].values for n in ("u", "rotation"))
    moved = (u - own["u"].values) - np.outer(own["depth"].values, turn - own["rotation"].values)
    y = own["y"].transpose("depth", "step").values + moved
    found = xr.Dataset(new | {"p": (("depth", "step"), p), "y": (("depth", "step"), y)})
    whole = own.assign({name: found[name].transpose(*own[name].dims) for name in found})
    values = whole[list(found)].drop_vars(list(whole[list(found)].coords))
    values.attrs = end_numbers(whole)
    return variables.attach(values, EXTRAPOLATED)


def _way(path: xr.Dataset, length: float) -> Array:
    """Return how far a path has come at each step [m], growing; rests of a timed path count by their time.

    Raises NotAlike: states share a place: a load changes while nothing moves.
    """
    rules = PATH_KINDS[str(path.attrs["kind"])]
    sizes = {"u": 1.0, "w": 1.0, "rotation": length}
    moved = [sizes[name] * np.abs(np.diff(path[name].values)) for name in rules.holds]
    way = np.concatenate([[0.0], np.cumsum(np.sum(moved, axis=0))])
    time = path["time"].values - path["time"].values[0]
    way = way + (way[-1] * time / time[-1] if time[-1] > 0.0 else 0.0)
    if path.sizes["step"] < 2 or not (np.diff(way) > _SAME * way[-1]).all():
        raise NotAlike("its load changes while it rests")
    return np.asarray(way)


def _between(x: Array, values: Array, at: Array) -> Array:
    """Return values (..., n) between the places x (n,): cubic, its slopes those of parabolas through three states.

    It is linear in the values, so that sums of reactions are kept.
    """
    order: Literal[1, 2] = 2 if x.size > 2 else 1
    slopes = np.gradient(values, x, axis=-1, edge_order=order)
    return np.asarray(CubicHermiteSpline(x, values, slopes, axis=-1)(at))


def _resliced(values: Array, path: xr.Dataset, bounds: Array, depth: Array, levers: bool) -> Array:
    """Return a reaction per metre (depth, ..., step) in other slices: force, and of p its moment, are kept."""
    edges = path["depth_bounds"].values
    heights, new = np.diff(edges, axis=1)[:, 0], np.diff(bounds, axis=1)[:, 0]
    force = np.tensordot(np.diag(heights), values, axes=1)
    above = np.concatenate([np.zeros_like(force[:1]), np.cumsum(force, axis=0)])
    lines = np.append(bounds[:, 0], bounds[-1, 1])
    down = np.append(edges[:, 0], edges[-1, 1])
    at = CubicSpline(down, above, axis=0)(np.clip(lines, down[0], down[-1]))
    shape = (-1,) + (1,) * (values.ndim - 1)
    found = np.diff(at, axis=0) / new.reshape(shape)
    if levers:
        before = np.tensordot(path["depth"].values * heights, values, axes=1)
        found = with_moment(found, before, depth, new)
    return np.asarray(found)
