# SPDX-License-Identifier: MIT
"""One uniaxial spring as a curve, and its table with few points: nodes where the curve bends, error measured."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Direction = Literal["lateral", "rotation", "vertical"]

FINE = 40001  # samples of each side behind a table
FLOOR = 0.3  # of the largest reaction: errors of smaller ones count relative to this
BEND = 0.3  # least density of nodes, over the mean one
FAR = 10.0  # the far point of a table lies at this multiple of the range, on the last slope
STIFFEST = 1e-9  # least slope behind the range over the first one: some programs reject a flat end


@dataclass(frozen=True, slots=True, eq=False)
class Spring:
    """A spring that reads one displacement and acts against it.

    Attributes
    ----------
    name : family (p, m, H_tip, M_tip, H_lid, M_lid, virtual, V).
    direction : lateral at its depth, rotation, or vertical.
    depth, height : place below mudline [m]; height of its slice [m], 0 for springs of tip, lid and virtual ones.
    low, high : range of the displacement [m, rad].
    force : displacement (n,) -> reaction (n,) [N, N m].
    """

    name: str
    direction: Direction
    depth: float
    height: float
    low: float
    high: float
    force: Callable[[Array], Array]

    @property
    def odd(self) -> bool:
        """True where the reaction only changes its sign with the displacement."""
        return self.direction != "vertical"


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A spring as points: q increasing through the origin, f; far points lie behind the range at both ends.

    error is the largest distance from the curve within the range, over the largest reaction.
    """

    spring: Spring
    q: Array
    f: Array
    error: float

    def within(self) -> tuple[Array, Array]:
        """Return the points without the far ones."""
        inside = (self.q >= self.spring.low * (1.0 + 1e-9)) & (self.q <= self.spring.high * (1.0 + 1e-9))
        return self.q[inside], self.f[inside]


def table(spring: Spring, points: int) -> Table:
    """Return a spring as a table of at most `points` points within its range."""
    sides = [end for end in (spring.low, spring.high) if end != 0.0]
    share = (points - 1) // len(sides)
    if share < 1:
        raise ValueError(f"{points} points are too few")
    halves = [_half(spring, end, share) for end in sides]
    if spring.odd:
        q, f, error = halves[-1]
        halves = [(-q, -f, error), (q, f, error)]
    q = np.concatenate([*(half[0][::-1] for half in halves[:-1]), [0.0], halves[-1][0]])
    f = np.concatenate([*(half[1][::-1] for half in halves[:-1]), [0.0], halves[-1][1]])
    return Table(spring, q, f, max(half[2] for half in halves))


def _half(spring: Spring, end: float, n: int) -> tuple[Array, Array, float]:
    """Return n points (n,) of one side without the origin, outwards, and the error over the largest reaction."""
    x = np.linspace(0.0, 1.0, FINE) ** 2 * end
    y = spring.force(x)
    size, q = float(np.abs(y).max()), _nodes(x, y, n)
    if size == 0.0:
        return q[1:], 0.0 * q[1:], 0.0
    f = _ordinates(x, y, q, size)
    between, at = np.interp(np.abs(x), np.abs(q), f) - y, f - spring.force(q)
    return q[1:], f[1:], float(max(np.abs(between).max(), np.abs(at).max())) / size


def _nodes(x: Array, y: Array, n: int) -> Array:
    """Return n + 1 nodes from the origin to the end of a fine curve, dense where chords would miss it."""
    sx, size = np.abs(x), np.maximum(np.abs(y), max(FLOOR * np.abs(y).max(), 1e-300))
    slope = np.diff(y) / np.diff(x)
    bend = np.abs(np.diff(slope)) / (0.5 * (sx[2:] - sx[:-2]))
    density = np.sqrt(bend / np.sqrt(size[1:-1] * size.max()))  # between absolute and relative errors
    density = np.concatenate([density[:1], density, density[-1:]])
    density += BEND * np.trapezoid(density, sx) / sx[-1] + 1e-300
    way = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(sx))])
    return np.interp(np.linspace(0.0, way[-1], n + 1), way, sx) * np.sign(x[-1])


def _ordinates(x: Array, y: Array, q: Array, size: float) -> Array:
    """Return ordinates at nodes whose straight lines are nearest to a fine curve, 0 at the origin."""
    from scipy.linalg import solveh_banded

    place, nodes = np.abs(x), np.abs(q)
    k = np.clip(np.searchsorted(nodes, place, side="right") - 1, 0, nodes.size - 2)
    share = (place - nodes[k]) / (nodes[k + 1] - nodes[k])
    # the samples are denser near the origin
    weight = np.gradient(place) / (np.maximum(np.abs(y), FLOOR * size) * size)
    own, next_, n = (1.0 - share) ** 2 * weight, share**2 * weight, nodes.size
    diagonal = np.bincount(k, own, n) + np.bincount(k + 1, next_, n)
    beside = np.bincount(k + 1, share * (1.0 - share) * weight, n)
    right = np.bincount(k, (1.0 - share) * weight * y, n) + np.bincount(k + 1, share * weight * y, n)
    free = solveh_banded(np.stack([beside, diagonal])[:, 1:], right[1:])
    f = np.concatenate([[0.0], free])
    if (np.sign(y[-1]) * np.diff(y) < 0.0).any():
        return f
    least = STIFFEST * f[1] / q[1] * np.diff(nodes) * np.sign(x[-1])  # a curve that only grows keeps growing
    return np.concatenate([[0.0], np.cumsum(np.sign(y[-1]) * np.maximum(np.sign(y[-1]) * np.diff(f), np.abs(least)))])


def with_far(given: Table) -> Table:
    """Return a table with a point behind each end, on the last slope, which is never flat."""
    q, f = given.q, given.f
    zero = int(np.searchsorted(q, 0.0))
    first = abs((f[zero] - f[zero - 1]) / (q[zero] - q[zero - 1]) if zero else f[1] / q[1])
    ends = []
    for end, inner in ((0, 1), (-1, -2)):
        slope = max((f[end] - f[inner]) / (q[end] - q[inner]), STIFFEST * first)
        far = FAR * (q[end] or -q[-1 - end])
        ends.append((far, f[end] + slope * (far - q[end])))
    (q0, f0), (q1, f1) = ends
    return Table(given.spring, np.array([q0, *q, q1]), np.array([f0, *f, f1]), given.error)
