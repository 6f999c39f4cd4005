# SPDX-License-Identifier: MIT
"""Elements with a memory from rays and rays that turn back: one non-negative least-squares problem.

What elements carry along an imposed motion is linear in their stiffnesses B, and B is a sum of m m^T over fixed
directions m with factors >= 0: symmetric and positive. Elements that share gauge and hardening share their state, and
become one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.macro.fan import FanTable
from pysprings.macro.ways import RANGE_SLACK
from pysprings.memory.elements import OUTSIDE, PLASTIC, PLATES, REVERSIBLE, SUBSTEP
from pysprings.memory.offered import Candidates, Known, Offered, around, candidates, elastic_motions, force_directions
from pysprings.memory.shares import Sample, Shares, at_rest, shares_of, stiffnesses

NO_FARTHER = f"springs with memory are followed to {OUTSIDE:g} times their reach"
STIFFNESS = 0.1  # weight of the initial stiffness beside a ray
AT_ONCE = 200  # columns that join a fit together
FORGET = 1e-9  # share of the initial stiffness below which an element is left out
# Numbers of the state of an element that moves in two planes (a plate: gap and frictional ones; a reversible one keeps
# none), and of all elements: SoilDyn of OpenFAST keeps 1,200
PLASTIC_NUMBERS, PLATE_NUMBERS, MOST_NUMBERS = 5, 6, 1190


@dataclass(frozen=True, slots=True)
class SpaceElements:
    """Calibrated elements in space (`pysprings.memory.space`).

    rows : (n, SPACE_COLUMNS) parameters, see `pysprings.memory.elements`.
    radius : at the wall [m], which makes a length of the twist.
    twist : largest motion of the wall by a twist [m]; 0 without elements of torsion.
    p_loads, p_elastic : (k, 2) and (k, 2 m) p [N/m] at k depths in each plane, by its load (H, M/L) [N] and by the
        elastic motions [m] of the m elements without torsion (`pysprings.memory.offered.Offered.of_space`).
    even : (2, 2 m) changes of w [m] and V [N] by what even rows are linear in (`pysprings.memory.offered.evened`).
    growth, way : limit s of a way over the size of its element; longest way of the calibration [m], beyond it w is
        extrapolated; 0 where w and V are not those of the elements.
    residual, torsion_residual : norm of what is left of the weighted equations, relative to their right sides.
    errors : largest error in H and M/L (vectors) of each way out of the plane, over its largest load.
    """

    rows: Array
    radius: float
    twist: float
    p_loads: Array
    p_elastic: Array
    even: Array
    growth: float
    way: float
    residual: float
    torsion_residual: float
    errors: dict[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class ElementSet:
    """Calibrated elements.

    rows : (n, COLUMNS) parameters, see `pysprings.memory.elements`; B in N/m.
    reach : size of the largest motion of the rays [m].
    shares : how the elements share out the reactions.
    residual : norm of what is left of the weighted equations, relative to their right sides.
    errors : largest error in H and M/L of each way, over the largest load of it.
    way : longest way of the calibration [m]: w beyond it is extrapolated.
    space : elements in space; None without a path that leaves the plane.
    """

    rows: Array
    reach: float
    shares: Shares
    residual: float
    errors: dict[str, tuple[float, float]]
    way: float
    space: SpaceElements | None = None

    @property
    def largest(self) -> float:
        """Largest step of a motion [m]."""
        return SUBSTEP * self.reach


def calibrate(
    ways: Sequence[Sample],
    table: FanTable,
    stiffness: Array,
    choice: Candidates | None = None,
    most: int = MOST_NUMBERS,
    others: Sequence[Sample] = (),
) -> ElementSet:
    """Return the elements that follow the ways; stiffness (2, 2) is the initial one for (u, rotation*L) [N/m].

    choice: elements to choose from, instead of those of `pysprings.memory.offered`. What is chosen from them
    is chosen a second time, with what is `around` it. most: numbers that the state of the elements may have in two
    planes; of more elements those that carry most are kept, and fitted again. Reactions are shared out as along the
    recorded ways (`Sample.recorded`). others: ways at other rates, from which the water's part of p comes, too.
    """
    reach = max(float(np.hypot(*way.motions.T).max()) for way in ways if way.recorded)
    loads, largest = [way.loads(table) for way in ways], SUBSTEP * reach
    known = [(way.motions, load, way.weights) for way, load in zip(ways, loads, strict=True)]
    first = choice or candidates(reach)
    _, _, chosen = fitted(Offered.in_plane(first), known, stiffness, largest)
    near = Offered.in_plane(around(first.chosen(chosen)))
    rows, left, chosen = fitted(near, known, stiffness, largest)
    if numbers_of(rows) > most:
        few = near.chosen(chosen)
        few = few.chosen(strongest(rows, few, known, largest, (_numbers(rows[:, 0]), most)))
        rows, left, _ = fitted(few, known, stiffness, largest)
    pairs = [(way, load) for way, load in zip(ways, loads, strict=True) if way.recorded]
    ways, loads = [way for way, _ in pairs], [load for _, load in pairs]
    shares, carried = shares_of(rows, ways, loads, table, largest, others)
    errors = {}
    for way, load, own in zip(ways, loads, carried, strict=True):
        worst = np.abs(own - load).max(axis=0) / np.abs(load).max()
        errors[way.name] = float(worst[0]), float(worst[1])
    longest = max(way_of(way.motions) for way in ways)
    return ElementSet(rows, reach, shares, left, errors, longest)


def fitted(choice: Offered, known: Sequence[Known], stiffness: Array, largest: float) -> tuple[Array, float, Marks]:
    """Return elements (n, COLUMNS) chosen from those offered, the relative residual, and which are chosen.

    known: ways with their loads, in the plane of x or in space. largest: step of a motion [m].
    """
    A, b = _system(choice, known, stiffness, largest)
    factors, left = nonnegative(A, b)
    rows, chosen = _merged(choice, factors, FORGET * float(np.trace(stiffness)))
    return rows, left, chosen


def nonnegative(A: Array, b: Array) -> tuple[Array, float]:
    """Return the factors x >= 0 (n,) with the least |A x - b|, and that norm over |b|; columns of A (m, n) get norm 1.

    Lawson and Hanson (1974, chapter 23) on few columns at a time: those that x has, and those of the largest gradient
    A^T (b - A x) beside them, until no column has one. A hundred of ten thousand columns are in the answer.
    """
    from scipy.optimize import nnls  # a prediction by a fan does without SciPy

    size = np.linalg.norm(A, axis=0)
    size[size == 0.0] = 1.0
    A /= size
    x, left, before = np.zeros(A.shape[1]), float(np.linalg.norm(b)), np.inf
    none = 10.0 * max(A.shape) * np.finfo(float).eps * np.sqrt(len(b))  # rounding of a gradient, as `nnls` has it
    while left < before:
        used = np.flatnonzero(x)
        gradient = A.T @ (b - A[:, used] @ x[used])
        gradient[used] = 0.0
        steepest = np.argsort(-gradient)[:AT_ONCE]
        tried = np.concatenate([used, steepest[gradient[steepest] > none]])
        if tried.size == used.size:
            break
        before = left
        some, left = nnls(A[:, tried], b, maxiter=20 * tried.size)
        x[:] = 0.0
        x[tried] = some
    return x / size, float(left / np.linalg.norm(b))


def numbers_of(rows: Array) -> int:
    """Return how many numbers the state of elements has in two planes."""
    return int(_numbers(rows[:, 0]).sum())


def _numbers(kind: Array) -> Integers:
    return np.where(kind == REVERSIBLE, 0, np.where(kind == PLASTIC, PLASTIC_NUMBERS, PLATE_NUMBERS))


def strongest(
    rows: Array, choice: Offered, known: Sequence[Known], largest: float, limit: tuple[Integers, int]
) -> Marks:
    """Return which elements carry most along the ways, as many as have at most so many numbers together.

    rows (n, COLUMNS): those offered, with their stiffness. limit: numbers of each element (n,), and the most of all.
    """
    carried, (numbers, most) = np.zeros(len(rows)), limit
    for motions, _, weights in known:
        e = elastic_motions(replace(choice, rows=rows), motions, largest)
        for plane in range(0, e.shape[2], 2):
            forces = _forces(rows, e[:, :, plane : plane + 2]) * weights[:, None, None]
            carried += (forces**2).sum(axis=(0, 2))
    order = np.argsort(-carried)
    keeps = np.zeros(len(rows), dtype=bool)
    keeps[order[numbers[order].cumsum() <= most]] = True
    return keeps


def way_of(motions: Array) -> float:
    """Return how far motions (n, m) [m] go from the origin, back and forth [m]."""
    return float(np.linalg.norm(np.diff(motions, axis=0, prepend=np.zeros_like(motions[:1])), axis=1).sum())


def beyond_way(motions: Array, longest: float) -> tuple[str, ...]:
    """Return a sentence where motions (n, m) [m] come farther than the longest way of the calibration [m]."""
    come = way_of(motions) / longest
    text = (
        f"the motions add up to {come:.3g} times the longest way of the calibration: heave, settlement and "
        "vertical reactions are extrapolated beyond"
    )
    return (text,) if come > 1.0 + RANGE_SLACK else ()


def _system(choice: Offered, known: Sequence[Known], stiffness: Array, largest: float) -> tuple[Array, Array]:
    """Return matrix and right side of the equations, two a point and plane, and three of the initial stiffness.

    B of plastic elements has a factor in each direction of the force, that of others one factor alone.
    """
    m, plastic = force_directions(), choice.plastic
    single = choice.rows[~plastic]
    blocks, right = [], []
    for motions, load, weights in known:
        e = elastic_motions(choice, motions, largest)
        for plane in range(0, e.shape[2], 2):
            own = e[:, :, plane : plane + 2]
            sizes = own[:, plastic] @ m.T
            along = (sizes[:, None] * m.T[None, :, None]).reshape(len(load), 2, -1)
            forces = _forces(single, own[:, ~plastic]).transpose(0, 2, 1)
            weighted = np.concatenate([along, forces], axis=2) * weights[:, None, None]
            blocks.append(weighted.reshape(2 * len(load), -1))
            right.append((load[:, plane : plane + 2] * weights[:, None]).ravel())
    aim = np.array([stiffness[0, 0], 0.5 * (stiffness[0, 1] + stiffness[1, 0]), stiffness[1, 1]])
    own = np.stack([m[:, 0] ** 2, m[:, 0] * m[:, 1], m[:, 1] ** 2])
    B, n = at_rest(single), int(plastic.sum())
    first = np.concatenate([np.tile(own, n), np.stack([B[:, 0, 0], B[:, 0, 1], B[:, 1, 1]])], axis=1)
    blocks.append(STIFFNESS * first / np.abs(aim)[:, None])
    right.append(STIFFNESS * aim / np.abs(aim))
    return np.concatenate(blocks), np.concatenate(right)


def _forces(rows: Array, e: Array) -> Array:
    """Return the forces (n, elements, 2) of elastic motions e of elements."""
    return np.einsum("kab,nkb->nka", stiffnesses(rows), e)


def _merged(choice: Offered, factors: Array, least: float) -> tuple[Array, Marks]:
    """Return the chosen elements (n, COLUMNS) with stiffness, and which of all that are offered they are."""
    m, plastic, rows = force_directions(), choice.plastic, choice.rows.copy()
    n = int(plastic.sum())
    own, sizes = factors[: n * len(m)].reshape(n, len(m)), np.zeros(len(rows))
    sizes[plastic], sizes[~plastic] = own.sum(axis=1), factors[n * len(m) :]
    B = np.einsum("kj,ja,jb->kab", own, m, m)
    rows[plastic, 4], rows[plastic, 5], rows[plastic, 6] = B[:, 0, 0], B[:, 0, 1], B[:, 1, 1]
    plate, reversible = np.isin(rows[:, 0], PLATES), rows[:, 0] == REVERSIBLE
    rows[plate, 6] = sizes[plate]
    rows[reversible, 4:7] *= sizes[reversible, None]
    return rows[sizes > least], sizes > least
