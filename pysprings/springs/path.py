# SPDX-License-Identifier: MIT
"""One load path of a full model or of a set of springs, with typed attributes and its arrays at the converged steps.

Two loads, directions or rates count as the same within the tolerances here.

A ray is a path from the origin that keeps its direction. A path and its mirror image (a motion towards -x) are one ray,
so its angle is in (-pi/2, pi/2].
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array, Marks
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import (
    LOADS,
    MEMORY,
    MOTIONS,
    PathKind,
    bends,
    driven,
    has_free_head,
    is_straight,
    kind_of,
    turns_back,
)
from pysprings.core.variables import EXTRAPOLATED
from pysprings.springs.path_ends import MARGIN, PathEnd, before_cavitation, end_of
from pysprings.springs.sums import by_depth, slice_heights

SAME_DIRECTION = math.radians(1.0)  # directions within this angle [rad] are one
STRAIGHT = 1e-3  # a path keeps its direction when all its states are within this angle [rad]
TOGETHER = 10.0**0.5  # paths whose rates differ by less than this factor belong to one set
CLOSE = 1.05  # a rate within this factor of a set's is that of the set


def is_rate(a: float, b: float) -> bool:
    """Return whether two rates [m/s] are one."""
    return max(a / b, b / a) <= CLOSE


def off_rate(own: float, ways: Array, times: Array) -> Marks:
    """Return which motions (n,) [m] in times (n,) [s] are off a rate [m/s] by half a decade; a rest has none."""
    expected = own * times
    return (ways > 0.0) & ((ways >= TOGETHER * expected) | (TOGETHER * ways <= expected))


# Motions and loads of a path out of one plane that springs answer; V is given, and w follows
SPACE_TURNS = tuple(name for name in MOTIONS if name != "w")
SPACE_LOADS = tuple(name for name in LOADS if name != "V")


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """A load path: what the full model recorded along it. Nothing of it may be changed.

    name : of the path.
    recorded : all steps, as the file holds them (`pysprings.core.variables`, groups ``result_path``, ``springs_path``).
    length : skirt length [m].
    """

    name: str
    recorded: xr.Dataset
    length: float

    @cached_property
    def dataset(self) -> xr.Dataset:
        """The converged steps, with the name as attribute ``path``."""
        return self._converged()

    @property
    def known(self) -> xr.Dataset:
        """The steps before cavitation; of a path for the memory of springs all."""
        return self.recorded if self.remembers else before_cavitation(self.recorded)

    def _converged(self) -> xr.Dataset:
        if "converged" not in self.recorded.variables:
            return self.recorded
        good = np.flatnonzero(self.recorded.variables["converged"].values == 1)
        whole = good.size == self.recorded.sizes["step"]
        return (self.recorded if whole else self.recorded.isel(step=good)).assign_attrs(path=self.name)

    # --- attributes ---

    @property
    def attrs(self) -> dict[Any, Any]:
        """Attributes as the file holds them."""
        return self.recorded.attrs

    @property
    def kind(self) -> str:
        """Kind of the path (`pysprings.core.path_kinds`), or "table"."""
        return str(self.attrs["kind"])

    @property
    def rules(self) -> PathKind:
        """Quantities that a path of this kind imposes and answers; not defined for paths of a table."""
        return kind_of(self.attrs)

    @property
    def role(self) -> str:
        """ "calibration", "memory" or "held-back"."""
        return str(self.attrs["role"])

    @property
    def calibrates(self) -> bool:
        """True where springs are made from the path, as from that of a table, which has no role."""
        return self.attrs.get("role", "calibration") == "calibration"

    @property
    def turns_back(self) -> bool:
        """True where the path has further parts after its first one (`then`)."""
        return turns_back(self.attrs)

    @property
    def remembers(self) -> bool:
        """True where the memory of springs is made from the path; one of a table has no role."""
        return self.attrs.get("role") == MEMORY

    @cached_property
    def load_changes(self) -> bool:
        """True where the vertical load that is given changes on the way."""
        return bool(len(np.unique(self.given_loads)) > 1)

    @property
    def is_vertical(self) -> bool:
        """True where the path moves the caisson vertically only."""
        return driven(self.attrs) == "w"

    @property
    def is_straight(self) -> bool:
        """True where rotation/u is constant by kind, or as a table was found to have it."""
        return is_straight(self.attrs)

    @property
    def bends(self) -> bool:
        """True where H and M change their ratio along the path."""
        return bends(self.attrs)

    @property
    def arm(self) -> float:
        """Height of the load above mudline [m]; NaN where it has none, as where the motion is imposed."""
        return float(self.attrs["arm_m"]) if has_free_head(self.attrs) else math.nan

    @property
    def free_to_heave(self) -> bool:
        """True where the vertical load is given, false where w is held."""
        return self.attrs.get("heave", "free") == "free"

    @cached_property
    def end(self) -> PathEnd:
        """How the path ended."""
        return end_of(self.name, self.dataset)

    # --- arrays ---

    def __contains__(self, name: object) -> bool:
        return name in self.recorded.variables

    def __getitem__(self, name: str) -> Array:
        """Return a variable at the converged steps, in SI."""
        return self.dataset.variables[name].values

    def by_depth(self, name: str) -> Array:
        """Return a variable summed over sides, (depth, step): "t" [N/m]."""
        return by_depth(self.dataset, name)

    @property
    def n(self) -> int:
        """Number of converged steps, the initial state included."""
        return int(self.dataset.sizes["step"])

    @property
    def depth(self) -> Array:
        """Depths (k,) of the reactions [m]."""
        return self["depth"]

    @cached_property
    def heights(self) -> Array:
        """Heights (k,) of their slices [m]."""
        return slice_heights(self.recorded)

    @property
    def u(self) -> Array:
        """Lateral displacement (n,) of the lid centre [m]."""
        return self["u"]

    @property
    def w(self) -> Array:
        """Vertical displacement (n,) [m], positive down."""
        return self["w"]

    @property
    def rotation(self) -> Array:
        """Rotation (n,) [rad], positive where the caisson leans towards +x."""
        return self["rotation"]

    @cached_property
    def turn(self) -> Array:
        """rotation*length (n,) [m]: the second coordinate of the plane of directions."""
        return self.rotation * self.length

    @cached_property
    def p(self) -> Array:
        """Lateral reaction of both sides, (depth, step) [N/m]."""
        return by_depth(self.dataset, "p")

    @cached_property
    def water(self) -> Array:
        """Part of p that pore water carries, (side, depth, step) [N/m]; no sides where it is not apart."""
        known = self.dataset.variables
        parts = known["component"].values.tolist() if "component" in known else []
        if "water" not in parts:
            return np.zeros((0, self.depth.size, self.n))
        values: Array = (
            known["p_component"].isel(component=parts.index("water")).transpose("side", "depth", "step").values
        )
        return values

    @cached_property
    def m(self) -> Array:
        """Distributed moment of both sides, (depth, step) [N m/m]."""
        return by_depth(self.dataset, "m")

    @property
    def load(self) -> float:
        """Vertical load [N] at the start; 0 where a table does not have it."""
        return float(self["V"][0]) if "V" in self else 0.0

    def under(self, drainage: str) -> str:
        """Return the vertical load at the start, those on the way and, where water flows, the rate in words."""
        rate = f", {1e3 * self.rate:.4g} mm/s of {'w' if self.is_vertical else 'rho'}" if self.rate else ""
        low, high = (1e-3 * float(end(self.given_loads)) for end in (np.min, np.max))
        way = "" if same_load(low, high) else f" at first, {low:.5g} to {high:.5g} kN on the way"
        return f"V {1e-3 * self.load:.5g} kN" + way + rate * ("coupled" in drainage.split(", "))

    @cached_property
    def given_loads(self) -> Array:
        """Vertical load (n,) [N] of each state: that of the state before where both are one (`same_load`).

        That of the start where w is imposed, so that V answers.
        """
        loads = np.full(self.n, self.load)
        if "V" in self and self.free_to_heave and not self.is_vertical:
            for k, V in enumerate(self["V"][1:], 1):
                loads[k] = loads[k - 1] if same_load(V, loads[k - 1]) else V
        return loads

    @cached_property
    def rate(self) -> float | None:
        """Rate rho/t at the end [m/s], rho = |(u, rotation*length)|; None where the path has no time.

        Of a path that turns back it is the mean over the way that it has come: a rest does not count. Of a vertical
        path it is that of w.
        """
        if "time" not in self or not float(self["time"][-1]) > 0.0:
            return None
        if self.is_vertical:
            return abs(float(self.w[-1] - self.w[0])) / float(self["time"][-1]) or None
        rho = float(np.hypot(self.u[-1], float(self.rotation[-1]) * self.length))
        if self.turns_back:
            ways, times = np.hypot(np.diff(self.u), np.diff(self.turn)), np.diff(self["time"])
            moved = (ways > 0.0) & (times > 0.0)
            return float((ways[moved] ** 2 / times[moved]).sum() / ways.sum()) if moved.any() else None
        return rho / float(self["time"][-1]) if rho > 0.0 else None


@dataclass(frozen=True, eq=False)
class SpringPath(RecordedPath):
    """A load path of a set of springs."""

    @cached_property
    def dataset(self) -> xr.Dataset:
        """The converged steps before cavitation, all of a path for memory, with the name as attribute ``path``."""
        found = self._converged()
        return found.drop_vars(MARGIN, errors="ignore") if self.remembers else before_cavitation(found)

    def at_steps(self, steps: Sequence[int]) -> Self:
        """Return the path with some of its converged steps alone, by number."""
        return type(self)(self.name, self.dataset.isel(step=list(steps)), self.length)


def in_planes(values: Array, length: float, radius: float) -> Array:
    """Return SPACE_TURNS (..., 5) as (u_x, rot_y L, u_y, -rot_x L, rot_z R), or SPACE_LOADS for 1/L and 1/R."""
    return values[..., [0, 3, 1, 2, 4]] * np.array([1.0, length, 1.0, -length, radius])


def out_of_planes(values: Array, length: float, radius: float) -> Array:
    """Return what `in_planes` gives for the same lengths as what it was made of."""
    return (values / np.array([1.0, length, 1.0, -length, radius]))[..., [0, 2, 3, 1, 4]]


@dataclass(frozen=True, eq=False)
class SpacePath(RecordedPath):
    """A path that leaves the plane of one load: motions `u_x, u_y, w, rot_x, rot_y, rot_z`, loads `H_x ... T`."""

    def turns(self) -> Array:
        """Return (u_x, u_y, rot_x, rot_y, rot_z) (n, 5) from rest, m and rad."""
        return self._from_rest(SPACE_TURNS)

    def pushes(self) -> Array:
        """Return (H_x, H_y, M_x, M_y, T) (n, 5) from rest, N and N m."""
        return self._from_rest(SPACE_LOADS)

    def motions(self, radius: float) -> Array:
        """Return (u_x, rot_y L, u_y, -rot_x L, rot_z R) (n, 5) [m] from rest; radius R [m] at the wall."""
        return in_planes(self.turns(), self.length, radius)

    def loads(self, radius: float) -> Array:
        """Return (H_x, M_y/L, H_y, -M_x/L, T/R) (n, 5) [N] from rest, conjugate to `motions`."""
        return in_planes(self.pushes(), 1.0 / self.length, 1.0 / radius)

    def reactions(self) -> Array:
        """Return p of both sides in the planes of x and y, (2, depth, n) [N/m], from rest."""
        p = np.stack([self.by_depth(f"p_{axis}") for axis in "xy"])
        return p - p[:, :, :1]

    def _from_rest(self, names: Sequence[str]) -> Array:
        values = np.stack([self[name] for name in names], axis=1)
        return values - values[0]


def space_paths_of(tree: xr.DataTree) -> dict[str, SpacePath]:
    """Return the paths of a result or of a spring file that leave the plane of one load, by name, in order."""
    nodes = tree.children["space"].children if "space" in tree.children else {}
    length = float(tree.attrs.get("skirt_length_m", np.nan))
    return {name: SpacePath(name, node.to_dataset(inherit=False), length) for name, node in nodes.items()}


def paths_of(tree: xr.DataTree, of_mesh: bool = False) -> dict[str, RecordedPath]:
    """Return the paths of a result or of a spring file by name, in order, as they were recorded.

    Reactions and motions of a result are those extrapolated from two meshes, where it has them; those of its own mesh
    for ``of_mesh``.
    """
    nodes = tree.children["paths"].children if "paths" in tree.children else {}
    length = float(tree.attrs.get("skirt_length_m", np.nan))
    return {name: RecordedPath(name, _recorded(node, of_mesh), length) for name, node in nodes.items()}


def _recorded(node: xr.DataTree, of_mesh: bool) -> xr.Dataset:
    own = node.to_dataset(inherit=False)
    if of_mesh or EXTRAPOLATED not in node.children:
        return own
    better = node.children[EXTRAPOLATED].to_dataset(inherit=False)
    values = {name: own.variables[name] for name in own.data_vars} | {
        name: better.variables[name] for name in better.data_vars
    }
    return xr.Dataset(values, own.coords, own.attrs | better.attrs)  # variables: nothing to align


# --- directions in the plane (u, rotation*L), L the skirt length ---

_ORIGIN = 1e-9  # share of the end below which the first state is the origin


def keeps_direction(u: Array, turn: Array) -> bool:
    """Return whether states (n,) = (u, turn) [m] keep the direction of the last one; a start at the origin has none."""
    rho = np.hypot(u, turn)
    first = 1 if rho[0] <= _ORIGIN * rho[-1] else 0  # the origin is met to rounding only
    return not (np.abs(u * turn[-1] - turn * u[-1]) > STRAIGHT * rho * rho[-1])[first:].any()


def ray_of(path: RecordedPath) -> tuple[float, float] | None:
    """Return angle [rad] in (-pi/2, pi/2] and size [m] of a straight path from the origin; None for any other."""
    u, v = path.u, path.turn
    rho = np.hypot(u, v)
    if rho[0] > _ORIGIN * rho[-1] or not (np.diff(rho) > 0.0).all() or not keeps_direction(u, v):
        return None
    angle = float(np.arctan2(v[-1], u[-1]))
    # an imposed displacement of 0 is met to rounding only: pure rotation is +pi/2, whatever the sign of u
    if abs(abs(angle) - 0.5 * np.pi) < 1e-9:
        return 0.5 * np.pi, float(rho[-1])
    return (angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi, float(rho[-1])


def rays_of(paths: Iterable[RecordedPath]) -> dict[str, float]:
    """Return the paths that are rays by increasing angle [rad]; of rays in one direction the longest alone."""
    candidates = [(ray[1], ray[0], path.name) for path in paths if (ray := ray_of(path)) is not None]
    distinct: list[tuple[float, str]] = []
    for _, angle, name in sorted(candidates, key=lambda each: -each[0]):
        if all(min(abs(angle - other), np.pi - abs(angle - other)) > SAME_DIRECTION for other, _ in distinct):
            distinct.append((angle, name))
    return {name: angle for angle, name in sorted(distinct)}


def pure_of(angles: Mapping[str, float]) -> tuple[str, str] | None:
    """Return the rays that are a pure translation and a pure rotation; None where one of them is missing."""
    translation = [name for name, angle in angles.items() if abs(angle) < SAME_DIRECTION]
    rotation = [name for name, angle in angles.items() if abs(angle) > 0.5 * np.pi - SAME_DIRECTION]
    return (translation[0], rotation[0]) if translation and rotation else None


def same_way(a: SpringPath, b: SpringPath) -> bool:
    """Return whether two paths are of one kind and load height and go in one direction."""
    arms = np.array([a.arm, b.arm])
    if a.kind != b.kind or not np.array_equal(arms[:1], arms[1:], equal_nan=True):
        return False
    if not (a.is_straight and b.is_straight):
        ends = [path.w[-1] - path.w[0] if path.is_vertical else path.u[-1] for path in (a, b)]
        return bool(np.sign(ends[0]) == np.sign(ends[1]))
    ways = [np.arctan2(path.turn[-1], path.u[-1]) for path in (a, b)]
    return bool(abs(ways[0] - ways[1]) < SAME_DIRECTION)
