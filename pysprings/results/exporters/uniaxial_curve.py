# SPDX-License-Identifier: MIT
"""One uniaxial spring as a curve, and its table with few points: nodes where the curve bends, error measured.

Springs in several vertical planes have one law that answers alike in every direction of the motion. A spring that
stands at an angle c from the motion reads cos(c) of it, and cos(c) of its force counts. Two planes at right angles are
exact along each; between them plastic springs carry up to sqrt(2) times the load. With more planes the laws g of the
springs are chosen so that their sum over the planes is the law f of the motion:
sum over k of cos(c_k) g(cos(c_k) q) = f(q). The exact inverse grows from octave to octave, so g is a sum of curves
k q/(1 + (|q|/d)^4)^(1/4), k >= 0, by non-negative least squares over q, the mean of a motion along a plane and one
between two.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pysprings.core.arrays import Array
from pysprings.macro.curve_table import Row, SpringTable, stack
from pysprings.macro.solver import row_values

Direction = Literal["lateral", "rotation", "vertical"]

FINE = 40001  # samples of each side behind a table
FLOOR = 0.3  # of the largest reaction: errors of smaller ones count relative to this
BEND = 0.3  # least density of nodes, over the mean one
FAR = 10.0  # the far point of a table lies at this multiple of the range, on the last slope
STIFFEST = 1e-9  # least slope behind the range over the first one: some programs reject a flat end


@dataclass(frozen=True, slots=True, eq=False)
class Spring:
    """A spring that reads one displacement and acts against it.

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
    halves = {np.sign(end): _half(spring, end, share) for end in sides}
    if spring.odd:
        q, f, error = halves[1.0]
        halves[-1.0] = -q, -f, error
    none = np.zeros(0), np.zeros(0), 0.0
    (q0, f0, _), (q1, f1, _) = (halves.get(sign, none) for sign in (-1.0, 1.0))
    q, f = np.concatenate([q0[::-1], [0.0], q1]), np.concatenate([f0[::-1], [0.0], f1])
    return Table(spring, q, f, max(half[2] for half in halves.values()))


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
    f, sign = np.concatenate([[0.0], free]), np.sign(y[np.abs(y).argmax()])  # a curve may end at 0
    if (sign * np.diff(y) < 0.0).any():
        return f
    least = STIFFEST * f[1] / q[1] * np.diff(nodes) * np.sign(x[-1])  # a curve that only grows keeps growing
    return np.concatenate([[0.0], np.cumsum(sign * np.maximum(sign * np.diff(f), np.abs(least)))])


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


SHARP = 4.0  # of the bend of a curve: sums of sharp ones make soft ones, not the other way round
SCALES = np.append(2.0 ** np.arange(-10.0, 2.0), np.inf)  # d over the range
SIZES = np.array([0.003, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.85, 1.0])  # over the range
KNOTS = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 60)])  # over the range


def cosines(planes: int, between: bool = False) -> tuple[Array, Array]:
    """Return cosines between a motion and the planes, and how many planes have each; without those at right angles.

    between turns the motion into the middle between two planes.
    """
    turned = np.pi / planes * (np.arange(planes) + 0.5 * between)
    values, count = np.unique(np.abs(np.cos(turned)).round(14), return_counts=True)
    seen = values > 1e-9
    return values[seen], count[seen].astype(np.float64)


def curves(q: Array, reach: float) -> Array:
    """Return all curves (..., scales) at displacements q [m], per stiffness."""
    over = np.abs(q[..., None]) / (SCALES * reach)
    return q[..., None] / (1.0 + over**SHARP) ** (1.0 / SHARP)


def in_planes(q: Array, reach: float, planes: int) -> Array:
    """Return the sums (..., scales) of all curves over the planes at displacements q [m] of the motion."""
    directions = (False,) if planes == 2 else (False, True)
    total = np.zeros((*q.shape, SCALES.size))
    for between in directions:
        for c, n in zip(*cosines(planes, between), strict=True):
            total += n * c * curves(c * q, reach) / len(directions)
    return total


def together(rows: SpringTable, planes: int, between: bool = False) -> SpringTable:
    """Return the springs of all planes as rows of a motion along a plane, or between two."""
    values, count = cosines(planes, between)
    if values.size == 1 and values[0] == 1.0:
        return rows
    n = values.size
    a = np.concatenate([c * rows.a for c in values])
    b = np.concatenate([m * c * rows.b for c, m in zip(values, count, strict=True)])
    repeated = {key: np.concatenate([getattr(rows, key)] * n) for key in ("depth", "q", "r", "slope", "count")}
    marks = {key: np.concatenate([getattr(rows, key)] * n) for key in ("natural", "cut")}
    return replace(rows, name=rows.name * n, carrier=rows.carrier * n, a=a, b=b, **repeated, **marks)


def spread(rows: SpringTable, planes: int) -> SpringTable:
    """Return the laws of springs in several planes that together answer as the rows."""
    return rows if planes == 2 else stack([_spread(rows, j, planes) for j in range(len(rows.name))])


def _spread(rows: SpringTable, j: int, planes: int) -> Row:
    from scipy.optimize import nnls

    one, reach = slice(j, j + 1), float(rows.range[j])
    q = SIZES * reach
    f = row_values(rows.q[one], rows.r[one], rows.slope[one], rows.count[one], q[None])[0]
    sign = -1.0 if f.sum() < 0.0 else 1.0
    weight = 1.0 / np.maximum(np.abs(f), 0.02 * max(float(np.abs(f).max()), 1e-300))
    left = in_planes(q, reach, planes) * weight[:, None]
    scale = np.linalg.norm(left, axis=0)
    k = nnls(left / scale, sign * f * weight, maxiter=30 * SCALES.size)[0] / scale
    a, b = ((float(x[j, 0]), float(x[j, 1])) for x in (rows.a, rows.b))
    knots = KNOTS * reach
    force = sign * (curves(knots, reach) @ k)
    marks = bool(rows.natural[j]), bool(rows.cut[j])
    return Row(rows.name[j], float(rows.depth[j]), rows.carrier[j], a, b, knots, force, *marks)
