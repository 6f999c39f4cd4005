# SPDX-License-Identifier: MIT
"""A fan of rays: reactions tabulated along several fixed ratios of rotation to displacement, and used in between.

p(y) and m(rotation) of one path do not hold on another. A state of a rigid caisson under a lateral load is a point
of the plane (u, rotation*L), L the skirt length: rho = |(u, rotation*L)|, phi = atan2(rotation*L, u). A ray is a
calibration path of constant phi (kind "translation", with or without rotation, or "rotation"). Along it every
reaction is tabulated over rho from the origin on: p, m and t by depth, tip and lid terms, and the heave. Between
the rays `solver.fan_stencil` interpolates in angle: exactly for a linear response, at every load height.

The mirror image of a ray (a motion towards -x) completes the plane: lateral reactions and moments change their sign,
vertical ones and w do not. Those are interpolated linearly in angle.

At the origin the slopes add up to the initial stiffness of the full model (under a dead load beyond the balanced one,
which may have made the soil yield, they are those of the first step). Interpolation along a ray is cubic, and
linear in the data: so the sum of the reactions is the load at every state, as it is at the recorded ones.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.errors import refused
from pysprings.macro.solver import fan_places, fan_rows
from pysprings.springs.path import STRAIGHT, SpringPath
from pysprings.springs.springs import FEWEST_RAYS, Springs
from pysprings.springs.sums import action, secant_slopes

# Between rays farther apart than this an answer is marked off_path [rad].
WIDEST = np.radians(60.0)
LAST = 0.02  # share of the range of a ray

_ENDS = ("H_tip", "M_tip", "H_lid", "M_lid")
_VERTICAL = ("V_tip", "V_lid", "w", "V")
WATER = "p_water"


@dataclass(frozen=True, slots=True)
class FanTable:
    """Reactions along rays. n rays at increasing angles, rows of reactions, k knots at most.

    path : tuple of str
        Calibration path of each ray.
    length : float
        Skirt length L [m].
    angle : (n,) float
        phi of each ray [rad], in (-pi/2, pi/2].
    rho : (n, k) float
        Knots [m], 0 first; inf beyond `count`.
    count : (n,) int
        Number of knots.
    name, depth : (rows,)
        Family (p, m, t, H_tip, M_tip, H_lid, M_lid, V_tip, V_lid, w, V, p_water) and depth [m] of each row. p_water
        is there where pore water carries a part of p: of all depths outside, then inside; it is part of p.
    even : (rows,) bool
        Whether the row keeps its sign in the mirror image of a motion.
    b : (rows, 2) float
        Action of a row on (H, M).
    r, slope : (rows, n, k) float
        Reactions and their slopes dr/drho.
    """

    path: tuple[str, ...]
    length: float
    angle: Array
    rho: Array
    count: Integers
    name: NDArray[np.str_]
    depth: Array
    even: Marks
    b: Array
    r: Array
    slope: Array

    @property
    def range(self) -> Array:
        """Largest calibrated rho of each ray [m]."""
        return self.rho[np.arange(self.count.size), self.count - 1]

    @property
    def wet(self) -> Marks:
        """Which rows (rows,) are p_water; none where no water carries a part of p."""
        return self.name == WATER

    @property
    def load_scale(self) -> Array:
        """Size of H [N] and M [N m] that the springs can build up, for tolerances."""
        peak = np.abs(self.r).max(axis=(1, 2))
        return np.maximum((np.abs(self.b) * peak[:, None]).sum(axis=0), 1e-300)

    @property
    def solver_arrays(self) -> tuple[Array, Array, Array, Array, Array, Integers]:
        """The loads (H, M) along each ray as the solver reads them: rows 2k and 2k+1 are those of ray k."""
        n = self.angle.size
        loads, slopes = (np.tensordot(x, self.b, axes=(0, 0)).transpose(0, 2, 1) for x in (self.r, self.slope))
        a = np.stack([np.repeat(self.angle, 2), np.full(2 * n, self.length)], axis=1)
        return (
            a,
            np.tile(np.eye(2), (n, 1)),
            np.repeat(self.rho, 2, axis=0),
            np.ascontiguousarray(loads.reshape(2 * n, -1)),
            np.ascontiguousarray(slopes.reshape(2 * n, -1)),
            np.repeat(self.count, 2),
        )

    def polar(self, states: Array) -> tuple[Array, Array]:
        """Return rho [m] and phi [rad] of states (n, 2) = (u, rotation)."""
        u, v = states[:, 0], states[:, 1] * self.length
        return np.hypot(u, v), np.arctan2(v, u)

    def rows(self, states: Array) -> Array:
        """Return all reactions (rows, n) at states (n, 2) = (u, rotation)."""
        return fan_rows(self.angle, self.rho, self.r, self.slope, self.count, self.even, *self.polar(states))

    def beside(self, states: Array) -> tuple[Integers, Integers, Array]:
        """Return the rays before and behind each of states (n, 2), and its place between them, a share (n,)."""
        places = fan_places(self.angle, self.polar(states)[1])
        return places[:, 0].astype(int), places[:, 1].astype(int), places[:, 2]

    def support(self, states: Array) -> tuple[Array, Array, Array]:
        """Return how far states are supported, each (n,): rho over the range, sector [rad], angle to a ray [rad].

        The range is the shorter one of the rays on both sides; on a ray, its own, and the sector is 0.
        """
        low, high, place = self.beside(states)
        # a single ray and its mirror image cannot be: there are two rays at least, so no sector is 0 modulo pi
        sector = (self.angle[high] - self.angle[low]) % np.pi
        nearest = np.minimum(place, 1.0 - place) * sector
        on_ray = nearest < STRAIGHT
        own = np.where(place < 0.5, self.range[low], self.range[high])
        reach = np.where(on_ray, own, np.minimum(self.range[low], self.range[high]))
        return self.polar(states)[0] / reach, np.where(on_ray, 0.0, sector), nearest


def build_fan(springs: Springs) -> FanTable:
    """Return the fan of all calibration paths of a spring set that are rays; refuse fewer than two."""
    angle = np.array(list(springs.rays.values()))
    if not springs.has_fan:
        message = (
            f"a fan needs at least {FEWEST_RAYS} calibration paths of different, constant ratios rotation to lateral "
            f"displacement (kinds translation and rotation); there are {angle.size}"
        )
        raise refused("springs", message)
    data, length = [springs.paths[name] for name in springs.rays], springs.length
    depth = data[0].depth
    if any(not np.array_equal(path.depth, depth) for path in data):
        raise refused("springs", "the calibration paths of a fan differ in their depths")
    count = np.array([path.n for path in data], dtype=np.int64)
    rho = np.full((len(data), int(count.max())), np.inf)
    wet = all(path.water.any() for path in data)
    name, place, even, b = _layout(depth, data[0].heights, length, len(data[0].water) if wet else 0)
    r = np.zeros((len(name), *rho.shape))
    slope = np.zeros_like(r)
    for k, path in enumerate(data):
        direction = np.array([np.cos(angle[k]), np.sin(angle[k])])
        along = path.u * direction[0] + path.turn * direction[1]  # < 0 where the path is the mirror image of the ray
        along[0] = 0.0
        rows = reaction_rows(path, wet) * np.where(even, 1.0, np.sign(along[-1]))[:, None]
        rho[k, : count[k]] = np.abs(along)
        r[:, k, : count[k]] = rows
        initial = (rows[:, 1] - rows[:, 0]) / rho[k, 1]
        if "w" not in path or float(path.w[0]) == 0.0:  # no dead load has changed the state at rest
            initial = initial_slopes(initial, b, springs.lateral_stiffness @ (direction / [1.0, length]))
        slope[:, k, : count[k]] = secant_slopes(np.abs(along), rows, initial)
        slope[:, k, count[k] - 1] = last_slopes(np.abs(along), rows, slope[:, k, count[k] - 1])
    return FanTable(tuple(springs.rays), length, angle, rho, count, name, place, even, b, r, slope)


def _layout(depth: Array, dz: Array, length: float, sides: int) -> tuple[NDArray[np.str_], Array, Marks, Array]:
    """Return the name, depth, parity and action on (H, M) of the rows, in the order of `reaction_rows`."""
    n, wet = depth.size, sides * depth.size
    name = np.array(["p"] * n + ["m"] * n + ["t"] * n + [*_ENDS, *_VERTICAL] + [WATER] * wet)
    ends = [length, length, 0.0, 0.0, length, 0.0, 0.0, 0.0]
    place = np.concatenate([np.tile(depth, 3), ends, np.tile(depth, sides)])
    even = np.isin(name, ("t", *_VERTICAL))
    height = np.concatenate([np.tile(dz, 3), np.zeros(len(ends) + wet)])
    idle = (even | (name == WATER)).tolist()
    rows = zip(name.tolist(), place.tolist(), height.tolist(), idle, strict=True)
    b = np.array([(0.0, 0.0) if no_load else action(each, z, h, length) for each, z, h, no_load in rows])
    return name, place, even, b


def reaction_rows(path: SpringPath, wet: bool) -> Array:
    """Return the reactions (rows, step), with those of water or not; odd ones as changes from the initial state."""
    ends = np.stack([path[name] for name in _ENDS])
    odd = np.concatenate([path.p, path.m])
    vertical = np.stack([path[name] for name in _VERTICAL])
    water = path.water.reshape(-1, path.n)[: None if wet else 0]
    parts = [odd - odd[:, :1], path.by_depth("t"), ends - ends[:, :1], vertical, water - water[:, :1]]
    return np.concatenate(parts)


def initial_slopes(secant: Array, b: Array, target: Array) -> Array:
    """Return slopes (rows,) at the origin whose sums b.T @ slopes are those of the full model, `target`.

    They are the secants of the first step, changed in proportion to their size as little as the sums allow.
    """
    size = np.abs(secant)
    missing = target - secant @ b
    multiplier = np.linalg.lstsq((b * size[:, None]).T @ b, missing, rcond=None)[0]
    return secant + size * (b @ multiplier)


def last_slopes(rho: Array, r: Array, slopes: Array) -> Array:
    """Return the slopes dr/drho (rows,) with which curves go on beyond their last knot: `slopes`, or a secant.

    A path that stopped ends in steps so short that a slope over them is noise. A state between rays reads the curves of
    the rays beside them, too, beyond their ends. Such a curve goes on with its secant over the last `LAST` of its
    range.
    """
    if rho[-1] - rho[-2] >= LAST * rho[-1]:
        return slopes
    before = int(np.searchsorted(rho, (1.0 - LAST) * rho[-1], side="right")) - 1
    return (r[:, -1] - r[:, before]) / (rho[-1] - rho[before])
