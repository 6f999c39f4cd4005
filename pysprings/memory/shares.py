# SPDX-License-Identifier: MIT
"""How elements share out the reactions: by depth, tip and lid, and the heave.

Lateral reactions and moments (rows that change their sign in the mirror image of a motion) are linear in the elastic
motions e of the elements,

    R = S F + D (e_1, e_2, ...),   F = (H, M/L),

with b.S = I and b.D = 0, b the action of a row on (H, M/L): they sum to the loads exactly. Vertical reactions and w
(even rows) are linear in the plastic ways p of the elements, as p/(1 + p/(s d)), and in |e|_G^2/d. The first adds up
on a way that turns back and forth, without end (s infinite) or up to a multiple of the size d of each element: small
motions then stop to settle the caisson, larger ones go on. The second goes up and down twice a cycle. D and the even
rows come from ridge regressions over the ways of the calibration. For the even rows s and the ridge are those with
which each ray that turns back is predicted best by the others. The water's part of p is in `water`.

Elements are fitted to motions and reactions along rays, between them, and along rays that turn back (`samples`). Pulls
with a free head are the fan's own, at several heights of the load: where the head is free, a small error of the load
across the motion is a large one of the motion, which rays do not show. Beyond the reach the elements go on as the fan
does, with a small weight: else they would carry no more there than at the reach.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.macro.fan import FanTable, reaction_rows
from pysprings.macro.response import cases
from pysprings.macro.solver import FAN, SpringArrays
from pysprings.macro.ways import RANGE_SLACK, equations
from pysprings.memory.elements import FRICTIONAL, GAP, PLASTIC, PLATES, REVERSIBLE, histories
from pysprings.memory.water import Water, ridge_fit, water_of
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

STEP = 10  # degrees between ways from the origin
POINTS, FIRST = 20, 1.0 / 500.0  # of a way, and its first point as a share of the last one
FLOOR = 0.02  # errors are relative to the load, and to this share of the largest of the way where that is more
BEYOND, LIGHT = (4 / 3, 5 / 3, 2.0), 0.1  # points over the reach, and their weight beside a ray
ARMS = (-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 16.0)  # heights of the loads of pulls, over L
# Rays that turn back: points every share of the reach, and behind each turn; weight beside a ray
EVERY, BEHIND, WEIGHT = 1.0 / 40.0, (2.5e-4, 7.5e-4, 2.5e-3, 5e-3, 1e-2, 2e-2, 4e-2), 0.7


@dataclass(frozen=True, slots=True)
class Sample:
    """A way: motions (n, 2) = (u, rotation*L) [m], reactions (rows, n) as a fan has them, weight of each point (n,).

    turns : whether the way turns back. recorded : whether the reactions are those of recorded paths along or beside it.
    time : of each point (n,) [s]; None where the springs have no rate.
    """

    name: str
    motions: Array
    reactions: Array
    weights: Array
    turns: bool
    recorded: bool = True
    time: Array | None = None

    def loads(self, table: FanTable) -> Array:
        """Return the loads (n, 2) = (H, M/L) [N] that the reactions sum to."""
        return self.reactions.T @ (table.b / [1.0, table.length])


def samples(springs: Springs, table: FanTable) -> list[Sample]:
    """Return the ways that springs with memory are calibrated on; those that turn back have a weight beside a ray."""
    rate = springs.remembering[0].rate if springs.rate_sets else None
    ways = [*_rays(table, rate), *(_turning(path, table, WEIGHT, rate) for path in springs.remembering)]
    return ways + [
        Sample(name, motions, rows, weight * _weights(rows, table, 0.0), False, recorded=False)
        for weight, made in ((1.0, _pulls(table)), (LIGHT, _beyond(table)))
        for name, motions, rows in made
    ]


def reach_of(table: FanTable, angles: Array) -> Array:
    """Return how far the fan supports directions (n,) [rad], in m: the shorter one of the rays beside each."""
    states = np.stack([np.cos(angles), np.sin(angles) / table.length], axis=1)
    used, _, _ = table.support(states)
    return 1.0 / used


def _angles(table: FanTable) -> Array:
    """Return directions (n,) [rad] every `STEP` degrees, and those of the rays."""
    rays = table.angle % np.pi - np.pi * (table.angle % np.pi > 0.5 * np.pi)
    return np.unique(np.round(np.concatenate([np.radians(np.arange(-90, 90, STEP)), rays]), 6))


def _beyond(table: FanTable) -> Iterator[tuple[str, Array, Array]]:
    """Yield ways up to the reach in one step, and on to twice the reach."""
    angles = _angles(table)
    for angle, reach in zip(angles, reach_of(table, angles), strict=True):
        motions = reach * np.array([1.0, *BEYOND])[:, None] * [np.cos(angle), np.sin(angle)]
        yield f"beyond {np.degrees(angle):.0f} degrees", motions, table.rows(motions / [1.0, table.length])


def _rays(table: FanTable, rate: float | None) -> Iterator[Sample]:
    angles = _angles(table)
    for angle, reach in zip(angles, reach_of(table, angles), strict=True):
        rho = np.geomspace(FIRST * reach, reach, POINTS)
        motions = rho[:, None] * [np.cos(angle), np.sin(angle)]
        rows = table.rows(motions / [1.0, table.length])
        time = None if rate is None else rho / rate
        yield Sample(f"{np.degrees(angle):.0f} degrees", motions, rows, _weights(rows, table, 0.0), False, time=time)


def _pulls(table: FanTable) -> Iterator[tuple[str, Array, Array]]:
    """Yield pulls with a free head on the fan, as far as its rays reach."""
    arrays = SpringArrays(FAN, *table.solver_arrays)
    targets = np.geomspace(FIRST, 1.0, POINTS)[:, None] * [float(table.range.max()), 0.0]
    for arm in ARMS:
        drive, aims = equations("displacement", targets, arm * table.length, table.load_scale)
        states, _, reached = cases(arrays, drive, aims)
        states = states[(reached > 0) & (table.support(states)[0] <= 1.0 + RANGE_SLACK)]
        if states.size:
            yield f"pull at {arm:g} L", states * [1.0, table.length], table.rows(states)


def _turning(path: SpringPath, table: FanTable, weight: float, rate: float | None) -> Sample:
    """Return a ray that turns back, at even distances of its way and close behind its turns."""
    motions = np.stack([path.u, path.turn], axis=1)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(motions, axis=0).T))])
    at = places(motions, way, float(np.max(np.hypot(*motions.T))))
    rows = np.stack([np.interp(at, way, row) for row in reaction_rows(path, bool(table.wet.any()))])
    motions = np.stack([np.interp(at, way, column) for column in motions.T], axis=1)
    timed = rate is not None and "time" in path
    time = np.interp(at, way, path["time"] - path["time"][0]) if timed else None
    return Sample(path.name, motions, rows, _weights(rows, table, weight), True, time=time)


def places(motions: Array, way: Array, reach: float) -> Array:
    """Return distances [m] along a way (n,) of motions (n, m) [m] from rest: even ones, and behind its turns."""
    steps = np.diff(motions, axis=0)
    turns = way[1:-1][(steps[1:] * steps[:-1]).sum(axis=1) < 0.0]
    behind = reach * np.array([0.0, *BEHIND])
    near = (np.array([0.0, *turns])[:, None] + 2.5 * behind).ravel()
    at = np.unique(np.concatenate([np.arange(way[-1], 0.0, -2.5 * EVERY * reach), near]))
    return at[(at > 0.0) & (at <= way[-1])]


def _weights(rows: Array, table: FanTable, way: float) -> Array:
    """Return the weight of each point (n,): one over the load of a ray.

    Of a way that turns: `way` over the geometric mean of the largest load so far and of the way, so that the first,
    small loops have their part beside the last one.
    """
    size = np.hypot(*(rows.T @ (table.b / [1.0, table.length])).T)
    known, factor = (np.sqrt(np.maximum.accumulate(size) * size.max()), way) if way else (size, 1.0)
    return factor / (np.sqrt(size.size) * np.maximum(known, FLOOR * size.max()))


RIDGE = 1e-3  # of the largest singular value of the regressors
# Of even rows: limits s of a way over the size of its element, ridges, least heave over the largest
GROWTHS, RIDGES, LEAST = (np.inf, 10.0, 3.0), (1e-3, 1e-2), 0.2
_NEVER = 1e-4  # of its size: the length h of an element that never yields is below (`candidates.mechanisms`)
TURNING = 1.5  # weight of the heave of a ray that turns back beside a ray


@dataclass(frozen=True, slots=True)
class Shares:
    """Reactions from states of elements; the rows are those of a fan (`pysprings.macro.fan.FanTable`).

    odd : rows that change their sign. rest : (rows,) values at rest.
    loads, elastic : (odd rows, 2) S [1, 1/m], and (odd rows, 2 n) D [N/m of e, N/m2].
    even : (even rows, 2 n) of p/(1 + p/(s d)), then of |e|_G^2/d.
    growth : s of the even rows, one number or one an element (n,).
    water : the water's part of p, in place of S and D of its rows; None where there is none.
    """

    odd: Marks
    rest: Array
    loads: Array
    elastic: Array
    even: Array
    growth: float | Array
    water: Water | None = None

    def reactions(self, rows: Array, e: Array, p: Array) -> Array:
        """Return all reactions (rows, n) from elastic motions e (n, elements, 2) and plastic ways p (n, elements).

        The water's part of p, which depends on time, is not among them.
        """
        carried = loads_of(rows, e)
        out = np.repeat(self.rest[:, None], len(e), axis=1)
        out[self.odd] += self.loads @ carried.T + self.elastic @ e.reshape(len(e), self.elastic.shape[1]).T
        out[~self.odd] += self.even @ even_motions(rows, e, p, self.growth).T
        return out


def elastic_of(rows: Array, states: Array, motion: Array) -> Array:
    """Return elastic motions (n, 2) [m] of elements in states (n, STATES) at a motion (2,) [m], as `histories`."""
    elastic: Array = states[:, :2].copy()
    plate, frictional = np.isin(rows[:, 0], PLATES), rows[:, 0] == FRICTIONAL
    n, pressed, (first, second) = rows[plate, 4:6], np.where(frictional, 0.0, rows[:, 1])[plate], states[plate, :2].T
    x = n @ motion
    elastic[plate] = (np.maximum(x + pressed - first, 0.0) - np.maximum(second + pressed - x, 0.0))[:, None] * n
    elastic[frictional] += states[frictional, 2:] * rows[frictional, 1:3]
    spring = rows[:, 0] == REVERSIBLE
    g11, g12, g22 = rows[spring, 1:4].T
    gauge = np.sqrt(g11 * motion[0] ** 2 + 2.0 * g12 * motion[0] * motion[1] + g22 * motion[1] ** 2)
    elastic[spring] = np.minimum(1.0, rows[spring, 7] / np.maximum(gauge, 1e-300))[:, None] * motion
    return elastic


def ways_of(rows: Array, states: Array) -> Array:
    """Return the plastic ways (n,) [m] of elements in states (n, STATES), as `histories`."""
    return np.where(rows[:, 0] == FRICTIONAL, states[:, 0] - states[:, 1], states[:, 2])


def _of_walls(rows: Array) -> Array:
    """Return B (n, 2, 2) [N/m] of the elements, of a plate for one wall, without friction."""
    B = np.stack([rows[:, [4, 5]], rows[:, [5, 6]]], axis=1)
    plate = np.isin(rows[:, 0], PLATES)
    n = rows[plate, 4:6]
    B[plate] = rows[plate, 6, None, None] * n[:, :, None] * n[:, None, :]
    return B


def stiffnesses(rows: Array) -> Array:
    """Return B (n, 2, 2) [N/m] of the elements; of a gap for one wall, of a frictional one for walls and friction."""
    B, frictional = _of_walls(rows), rows[:, 0] == FRICTIONAL
    B[frictional] = rows[frictional, 6, None, None] * np.eye(2)
    return B


def at_rest(rows: Array) -> Array:
    """Return the stiffness (n, 2, 2) [N/m] of the elements at rest.

    Twice B of a plate on which both walls press and do not yield yet; walls that press by all of d yield at once. Of
    frictional elements that of the walls: what their friction adds depends on the motion.
    """
    B = _of_walls(rows)
    B[(rows[:, 0] == GAP) & (rows[:, 1] > 0.0) & (rows[:, 1] < rows[:, 7])] *= 2.0
    return B


def loads_of(rows: Array, e: Array) -> Array:
    """Return the loads (n, 2) = (H, M/L) [N] of elastic motions e (n, elements, 2)."""
    return np.einsum("kab,nkb->na", stiffnesses(rows), e)


def even_motions(rows: Array, e: Array, p: Array, growth: float | Array) -> Array:
    """Return what even rows are linear in, (n, 2 elements) [m]: ways up to their limits, then stored energies."""
    d, G = rows[:, 7], np.stack([rows[:, [1, 2]], rows[:, [2, 3]]], axis=1)
    G[np.isin(rows[:, 0], PLATES)] = np.eye(2)
    stored = np.einsum("nka,kab,nkb->nk", e, G, e) / d
    stored[:, (rows[:, 0] == PLASTIC) & (rows[:, 9] < _NEVER * d)] = 0.0  # has no bound
    return np.concatenate([p / (1.0 + p / (growth * d)), stored], axis=1)


def shares_of(
    rows: Array,
    ways: Sequence[Sample],
    loads: Sequence[Array],
    table: FanTable,
    largest: float,
    others: Sequence[Sample] = (),
) -> tuple[Shares, list[Array]]:
    """Return the shares of elements, and the loads (n, 2) that they carry along each way.

    others: ways at other rates, for the water's part of p.
    """
    states = [elastic_motions(rows, way.motions, largest) for way in ways]
    carried = [loads_of(rows, e) for e, _ in states]
    odd, rest = ~table.even, np.where(table.even, table.r[:, 0, 0], 0.0)
    R, F, weights = (np.concatenate(parts) for parts in zip(*(
        (way.reactions.T, own, way.weights) for way, own in zip(ways, carried, strict=True)
    ), strict=True))  # fmt: skip
    b = table.b[odd] / [1.0, table.length]
    S = _balanced(np.linalg.lstsq(F * weights[:, None], R[:, odd] * weights[:, None], rcond=None)[0].T, b)
    e = np.concatenate([each.reshape(len(each), -1) for each, _ in states])
    D = ridge_fit(e, R[:, odd] - F @ S.T, weights, RIDGE)
    D -= S @ (b.T @ D)
    even = [way.reactions[~odd] - rest[~odd, None] for way in ways]
    heave = [heave_of(table, way)[0] for way in ways]
    weights = heave_weights([(own, way.turns) for way, own in zip(ways, heave, strict=True)])
    growth, ridge = _best(rows, ways, states, heave, weights)
    X = np.concatenate([even_motions(rows, *state, growth) for state in states])
    factors = ridge_fit(X, np.concatenate(even, axis=1).T, weights, ridge)
    states += [elastic_motions(rows, way.motions, largest) for way in others]
    return Shares(odd, rest, S, D, factors, growth, _water([*ways, *others], states, table)), carried


def elastic_motions(
    rows: Array, motions: Array, largest: float, along: Callable[..., None] = histories
) -> tuple[Array, Array]:
    """Return elastic motions (n, elements, m) and ways (n, elements) along motions (n, m) [m]: see `histories`."""
    e, p = np.zeros((len(motions), len(rows), motions.shape[1])), np.zeros((len(motions), len(rows)))
    along(np.ascontiguousarray(rows), np.ascontiguousarray(motions), largest, e, p)
    return e, p


def _water(ways: Sequence[Sample], states: Sequence[tuple[Array, Array]], table: FanTable) -> Water | None:
    """Return the water's part of p along the ways; None where it has none."""
    if not table.wet.any():
        return None
    times = [np.zeros(len(way.motions)) if way.time is None else way.time for way in ways]
    longest = next(float(time[-1]) for way, time in zip(ways, times, strict=True) if not way.turns)
    return water_of([e for e, _ in states], [way.reactions[table.wet] for way in ways], times, longest)


def _best(
    rows: Array, ways: Sequence[Sample], states: Sequence[tuple[Array, Array]], heave: Sequence[Array], weights: Array
) -> tuple[float, float]:
    """Return growth and ridge with which each ray that turns back is predicted best by all other ways."""
    ends = np.cumsum([0, *(len(way.motions) for way in ways)])
    known, errors = np.concatenate(heave)[:, None], {}
    turning = [k for k, way in enumerate(ways) if way.turns]
    for growth in GROWTHS if turning else GROWTHS[:1]:
        X = np.concatenate([even_motions(rows, *state, growth) for state in states])
        for ridge in RIDGES:
            errors[growth, ridge] = 0.0
            for k in turning:
                out = np.zeros(len(known), dtype=bool)
                out[ends[k] : ends[k + 1]] = True
                factors = ridge_fit(X[~out], known[~out], weights[~out], ridge)
                missing = np.abs(X[out] @ factors.T - known[out])[:, 0] * weights[out]
                errors[growth, ridge] += float(missing.max()) * np.sqrt(len(missing))
    return min(errors, key=lambda pair: errors[pair])


def heave_of(table: FanTable, way: Sample) -> Array:
    """Return the changes (2, n) of w [m] and V [N] along a way from rest."""
    places = [list(table.name).index(name) for name in ("w", "V")]
    return way.reactions[places] - table.r[places, 0, :1]


def heave_weights(ways: Sequence[tuple[Array, bool]]) -> Array:
    """Return weights (all points,) that make errors relative to the largest heave (n,) of a way, and if it turns."""
    largest = max(float(np.abs(w).max()) for w, _ in ways)
    sizes = [max(float(np.abs(w).max()), LEAST * largest, 1e-300) for w, _ in ways]
    return np.concatenate([
        np.full(len(w), (TURNING if turns else 1.0) / np.sqrt(len(w)) / size)
        for (w, turns), size in zip(ways, sizes, strict=True)
    ])  # fmt: skip


def _balanced(S: Array, b: Array) -> Array:
    """Return S (rows, 2) changed in proportion to its size such that b.S = I."""
    size = np.abs(S)
    for column in range(2):
        missing = np.eye(2)[column] - b.T @ S[:, column]
        weight = size[:, column, None] * b
        S[:, column] += weight @ np.linalg.lstsq(b.T @ weight, missing, rcond=None)[0]
    return S
