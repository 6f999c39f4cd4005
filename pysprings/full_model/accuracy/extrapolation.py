# SPDX-License-Identifier: MIT
"""Extrapolates the paths of a result at equal motion from two meshes of one family (Richardson 1911).

Each reaction and each free motion q of the finer mesh becomes q + (q - q_c)/(r^o - 1): q_c is that of the coarser mesh
where the path has come as far, r the ratio of the cells, o the order that the study of sections found (docs/evidence,
"Sections"). What two harmonics more change on the coarser mesh is added: both errors are small, and their product is
left out (the combination technique, Griebel, Schneider and Zenger 1992). One share for all quantities keeps what is
linear in them: sums of reactions remain the loads, a load its height, y(z) = u - rotation z.

Vertical paths in sand depend on the elements beside the tip, and on little else. They are run again with those halved,
in a series of one harmonic (they are axisymmetric): q - (1 + 1/(2^o - 1)) (q - q_h), with o = 1 where the tip bears.
"""

from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from pysprings.core import variables
from pysprings.core.arrays import Array
from pysprings.core.path_kinds import PATH_KINDS, direction_of_load
from pysprings.full_model.accuracy.measures import driver_of
from pysprings.springs.path import RecordedPath, paths_of
from pysprings.springs.path_ends import MESH_ERROR, end_numbers
from pysprings.springs.tip_zone import distributed_like

PUSHED, PULLED = 1.0, 2.0  # of vertical paths in sand, in the elements beside the tip (error-estimates-vertical.csv)
_DEPTHS = ("p_component", "m", "t")
_ORDER = ("depth", "side", "component", "step")
_SAME = 1e-9  # of the way: states within it are one


class NotAlike(ValueError):
    """The path of the coarser mesh does not come as far, or the ways of both have no common measure."""


def share_of(ratio: float, order: float) -> float:
    """Return what is added of the difference of two meshes: 1/(r^o - 1)."""
    return 1.0 / (ratio**order - 1.0)


@dataclass
class Extrapolated:
    """A result with extrapolated paths.

    Each path that is extrapolated has a group `extrapolated` beside its own values (`springs.path.paths_of` takes it in
    their place). halved : those that are from smaller elements beside the tip; not_alike : by path why it is not
    extrapolated; without : by extrapolated path why it lacks what more harmonics change.
    """

    tree: xr.DataTree
    halved: list[str] = field(default_factory=list)
    not_alike: dict[str, str] = field(default_factory=dict)
    without: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, better: xr.Dataset) -> None:
        """Add the extrapolated variables of a path."""
        self.tree[f"paths/{name}"].attrs["meshes"] = f"one; '{variables.EXTRAPOLATED}' has what {MESH_ERROR} is of"
        self.tree[f"paths/{name}/{variables.EXTRAPOLATED}"] = xr.DataTree(better.assign_attrs(meshes="two"))


@dataclass(frozen=True)
class Beside:
    """Paths of a result on other meshes.

    coarse : on the coarser mesh; richer : on that with more harmonics; halved : on its own with smaller elements beside
    the tip.
    """

    coarse: xr.DataTree
    richer: xr.DataTree | None = None
    halved: xr.DataTree | None = None


def extrapolated(fine: xr.DataTree, beside: Beside, share: float) -> Extrapolated:
    """Extrapolate the paths of the finer mesh from those of the coarser one."""
    found, trees = Extrapolated(fine.copy(deep=False)), (beside.coarse, beside.richer, beside.halved)
    other, more, near = ({} if tree is None else paths_of(tree, of_mesh=True) for tree in trees)
    for name, path in paths_of(fine, of_mesh=True).items():
        cells, harmonics = None, None
        try:
            cells = _beside(path, other.get(name))
        except NotAlike as error:
            found.not_alike[name] = str(error)
        with suppress(NotAlike):
            if name in near:
                whole = -1.0 - share_of(2.0, _order_at_tip(path))
                halves = _from_rest(path, _beside(path, near[name]), cells, share / whole)
                found.add(name, _path(path, whole, halves))
                found.halved.append(name)
                found.not_alike.pop(name, None)
                continue
        if cells is None:
            continue
        try:
            harmonics = None if beside.richer is None else _beside(path, more.get(name))
        except NotAlike as error:
            found.without[name] = str(error)
        found.add(name, _path(path, share, cells, harmonics))
    return found


def _order_at_tip(path: RecordedPath) -> float:
    """Return the order of a vertical path in the elements beside the tip, by where its largest motion goes."""
    moved = path.recorded["w"].values - path.recorded["w"].values[0]
    return PUSHED if moved[np.abs(moved).argmax()] > 0.0 else PULLED


def has_equal_motion(path: RecordedPath) -> bool:
    """Return whether a motion drives a path, so that meshes can be compared at equal motion."""
    return not PATH_KINDS[path.kind].force  # of a load that climbs, too


Reactions = dict[str, Array]


def _path(fine: RecordedPath, share: float, cells: Reactions, harmonics: Reactions | None = None) -> xr.Dataset:
    """Return the extrapolated variables of a path, from those of coarser cells, and of these with more harmonics."""
    own, new = fine.recorded, {}
    steps = np.flatnonzero(own["converged"].values == 1)
    rules = PATH_KINDS[fine.kind]
    held = set() if rules.conjugate else {"u", "rotation"} & set(rules.holds)  # not w: both meshes settle before
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

    Beyond the end of a path at its limit load the difference of both stays as it is there.
    Raises NotAlike: the path did not come as far there, or has no equal motion.
    """
    if path is None:
        raise NotAlike("it did not start on the coarser mesh")
    own, other = fine.recorded, path.dataset
    if not has_equal_motion(fine):
        raise NotAlike("a load drives it: both meshes have no equal motion")
    at, known = _way(fine), _way(path)
    flat = str(other.attrs["status"]) == "limit load"
    if at[-1] > known[-1] * (1.0 + _SAME) and not flat:
        raise NotAlike(f"it stopped on the coarser mesh at {100.0 * known[-1] / at[-1]:.0f} % of its way")
    way, at, found = at, np.minimum(at, known[-1]), {}
    for name in (name for name in variables.GROUPS[variables.EXTRAPOLATED] if name in own and name in other):
        if name in ("p", "y"):
            continue
        found[name] = _between(known, other[name].transpose(*_axes(own, name)).values, at)
    _resliced(found, other, fine.dataset)
    beyond = way > at
    for name in found if beyond.any() else ():
        values = fine.dataset[name].transpose(*_axes(own, name)).values
        found[name][..., beyond] += values[..., beyond] - _between(way, values, known[-1:])
    return found


def _from_rest(fine: RecordedPath, halved: Reactions, coarse: Reactions | None, share: float) -> Reactions:
    """Return reactions with halved elements, of which the change from rest counts: at rest a path is as all others are.

    ``share`` of the difference from the coarser mesh at rest stands for that from halved elements.
    """
    for name, values in halved.items():
        rest = fine.dataset[name].transpose(*_axes(fine.recorded, name)).values[..., :1]
        other = rest if coarse is None else coarse[name][..., :1]
        halved[name] = values - values[..., :1] + rest - share * (rest - other)
    return halved


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
    return variables.attach(values, variables.EXTRAPOLATED)


def _way(one: RecordedPath) -> Array:
    """Return how far a path has come at each step [m], growing.

    Rests of a timed path count by their time, and changes of the vertical load while nothing moves by their size.

    Raises NotAlike: there is no step; states share a place: a load changes while nothing moves.
    """
    path = one.dataset
    if path.sizes["step"] < 2:
        raise NotAlike("no step of it converged")
    if direction_of_load(path.attrs) is not None:
        way = driver_of(path, one.length)
    else:
        sizes = {"u": 1.0, "w": 1.0, "rotation": one.length}
        holds = PATH_KINDS[str(path.attrs["kind"])].holds
        moved = [sizes[name] * np.abs(np.diff(path[name].values)) for name in holds]
        way = np.concatenate([[0.0], np.cumsum(np.sum(moved, axis=0))])
    time = path["time"].values - path["time"].values[0]
    rests = np.diff(way, prepend=-np.inf) <= _SAME * way[-1]
    loads = np.cumsum(rests * np.abs(np.diff(one.given_loads, prepend=one.given_loads[0])))
    way = way + way[-1] * sum(other / other[-1] for other in (time, loads) if other[-1] > 0.0)
    if not (np.diff(way) > _SAME * way[-1]).all():
        raise NotAlike("its load changes while it rests")
    return np.asarray(way)


def _between(x: Array, values: Array, at: Array) -> Array:
    """Return values (..., n) between the places x (n,): cubic, its slopes those of parabolas through three states.

    It is linear in the values, so that sums of reactions are kept.
    """
    order: Literal[1, 2] = 2 if x.size > 2 else 1
    slopes = np.gradient(values, x, axis=-1, edge_order=order)
    return np.asarray(CubicHermiteSpline(x, values, slopes, axis=-1)(at))


def _resliced(found: Reactions, path: xr.Dataset, fine: xr.Dataset) -> None:
    """Put reactions per metre of a path (depth, ..., step) into the slices of a finer mesh, at the same states.

    In each of its slices p, m and t differ by one value from those of the finer mesh: jumps between layers and the peak
    at the tip stay where they are. Force is kept; m takes what the place of p changes, so that the moment is, too.
    """
    put = partial(distributed_like, slices=fine["depth_bounds"].values, bounds=path["depth_bounds"].values)
    levers = _levers(found, path)
    for name in (name for name in _DEPTHS if name in found):
        found[name] = put(fine[name].transpose(*_axes(fine, name)).values, values=found[name])
    moved = _levers(found, fine)
    found["m"] = found["m"] + moved - put(moved, values=levers)


def _levers(found: Reactions, path: xr.Dataset) -> Array:
    """Return p times its depth [N], (depth, side, step)."""
    return np.asarray(path["depth"].values[:, None, None] * found["p_component"].sum(axis=2))
