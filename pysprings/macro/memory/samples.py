# SPDX-License-Identifier: MIT
"""What elements are fitted to: motions and reactions along rays, between them, and along rays that turn back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import FanTable, reaction_rows
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

STEP = 10  # degrees between ways from the origin
POINTS, FIRST = 20, 1.0 / 500.0  # of a way, and its first point as a share of the last one
FLOOR = 0.05  # errors are relative to the load, and to this share of the largest of the way where that is more
# Rays that turn back: points every share of the reach, and behind each turn; weight beside a ray
EVERY, BEHIND, WEIGHT = 1.0 / 40.0, (2.5e-4, 7.5e-4, 2.5e-3, 5e-3, 1e-2, 2e-2, 4e-2), 0.7


@dataclass(frozen=True, slots=True)
class Sample:
    """A way: motions (n, 2) = (u, rotation*L) [m], reactions (rows, n) as a fan has them, weight of each point (n,).

    turns : whether the way turns back.
    """

    name: str
    motions: Array
    reactions: Array
    weights: Array
    turns: bool

    def loads(self, table: FanTable) -> Array:
        """Return the loads (n, 2) = (H, M/L) [N] that the reactions sum to."""
        summed: Array = self.reactions.T @ (table.b / [1.0, table.length])
        return summed


def samples(springs: Springs, table: FanTable, weight: float = WEIGHT) -> list[Sample]:
    """Return the ways that springs with memory are calibrated on; those that turn back have a weight beside a ray."""
    found = [*_rays(table), *(_turning(path, table, weight) for path in springs.remembering)]
    return [Sample(name, motions, rows, _weights(rows, table, way), way > 0.0) for name, motions, rows, way in found]


def reach_of(table: FanTable, angles: Array) -> Array:
    """Return how far the fan supports directions (n,) [rad], in m: the shorter one of the rays beside each."""
    states = np.stack([np.cos(angles), np.sin(angles) / table.length], axis=1)
    used, _, _ = table.support(states, table.rows(states)[1])
    return 1.0 / used


def _rays(table: FanTable) -> Iterator[tuple[str, Array, Array, float]]:
    angles = np.unique(np.round(np.concatenate([np.radians(np.arange(-90, 90, STEP)), table.angle % np.pi - np.pi * (
        table.angle % np.pi > 0.5 * np.pi)]), 6))  # fmt: skip
    for angle, reach in zip(angles, reach_of(table, angles), strict=True):
        rho = np.geomspace(FIRST * reach, reach, POINTS)
        motions = rho[:, None] * [np.cos(angle), np.sin(angle)]
        rows, _ = table.rows(motions / [1.0, table.length])
        yield f"{np.degrees(angle):.0f} degrees", motions, rows, 0.0


def _turning(path: SpringPath, table: FanTable, weight: float) -> tuple[str, Array, Array, float]:
    """Return a ray that turns back, at even distances of its way and close behind its turns."""
    motions = np.stack([path.u, path.turn], axis=1)
    steps = np.diff(motions, axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    turns = way[1:-1][(steps[1:] * steps[:-1]).sum(axis=1) < 0.0]
    reach = float(np.max(np.hypot(*motions.T)))
    behind = reach * np.array([0.0, *BEHIND])
    near = (np.array([0.0, *turns])[:, None] + 2.5 * behind).ravel()
    at = np.unique(np.concatenate([np.arange(way[-1], 0.0, -2.5 * EVERY * reach), near]))
    at = at[(at > 0.0) & (at <= way[-1])]
    rows = reaction_rows(path)
    return (
        path.name,
        np.stack([np.interp(at, way, column) for column in motions.T], axis=1),
        np.stack([np.interp(at, way, row) for row in rows]),
        weight,
    )


def _weights(rows: Array, table: FanTable, way: float) -> Array:
    """Return the weight of each point (n,): one over the load of a ray, one over the largest of a way that turns."""
    size = np.hypot(*(rows.T @ (table.b / [1.0, table.length])).T)
    floor, factor = (1.0, way) if way else (FLOOR, 1.0)
    weights: Array = factor / (np.sqrt(size.size) * np.maximum(size, floor * size.max()))
    return weights
