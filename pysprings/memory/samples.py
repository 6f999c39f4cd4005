# SPDX-License-Identifier: MIT
"""What elements are fitted to: motions and reactions along rays, between them, and along rays that turn back.

Pulls with a free head are the fan's own, at several heights of the load: where the head is free, a small error of the
load across the motion is a large one of the motion, which rays do not show. Beyond the reach the elements go on as the
fan does, with a small weight: else they would carry no more there than at the reach.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import FanTable, reaction_rows
from pysprings.macro.solver import FAN, SpringArrays, solve_cases
from pysprings.macro.ways import RANGE_SLACK, equations
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

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
        summed: Array = self.reactions.T @ (table.b / [1.0, table.length])
        return summed


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
    used, _, _ = table.support(states, table.rows(states)[1])
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
        yield f"beyond {np.degrees(angle):.0f} degrees", motions, table.rows(motions / [1.0, table.length])[0]


def _rays(table: FanTable, rate: float | None) -> Iterator[Sample]:
    angles = _angles(table)
    for angle, reach in zip(angles, reach_of(table, angles), strict=True):
        rho = np.geomspace(FIRST * reach, reach, POINTS)
        motions = rho[:, None] * [np.cos(angle), np.sin(angle)]
        rows, _ = table.rows(motions / [1.0, table.length])
        time = None if rate is None else rho / rate
        yield Sample(f"{np.degrees(angle):.0f} degrees", motions, rows, _weights(rows, table, 0.0), False, time=time)


def _pulls(table: FanTable) -> Iterator[tuple[str, Array, Array]]:
    """Yield pulls with a free head on the fan, as far as its rays reach."""
    arrays = SpringArrays(FAN, *table.solver_arrays)
    targets = np.geomspace(FIRST, 1.0, POINTS)[:, None] * [float(table.range.max()), 0.0]
    for arm in ARMS:
        drive, aims = equations("displacement", targets, arm * table.length, table.load_scale)
        states, loads, reached = np.zeros(aims.shape), np.zeros(aims.shape), np.zeros(len(aims), dtype=np.int8)
        solve_cases(arrays, drive, np.ascontiguousarray(aims), states, loads, reached)
        rows, places = table.rows(states)
        inside = (reached > 0) & (table.support(states, places)[0] <= 1.0 + RANGE_SLACK)
        if inside.any():
            yield f"pull at {arm:g} L", states[inside] * [1.0, table.length], rows[:, inside]


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
    found: Array = at[(at > 0.0) & (at <= way[-1])]
    return found


def _weights(rows: Array, table: FanTable, way: float) -> Array:
    """Return the weight of each point (n,): one over the load of a ray.

    Of a way that turns: `way` over the geometric mean of the largest load so far and of the way, so that the first,
    small loops have their part beside the last one.
    """
    size = np.hypot(*(rows.T @ (table.b / [1.0, table.length])).T)
    known, factor = (np.sqrt(np.maximum.accumulate(size) * size.max()), way) if way else (size, 1.0)
    weights: Array = factor / (np.sqrt(size.size) * np.maximum(known, FLOOR * size.max()))
    return weights
