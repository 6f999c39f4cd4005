# SPDX-License-Identifier: MIT
"""Elements with a memory from rays and rays that turn back: one non-negative least-squares problem.

What elements carry along an imposed motion is linear in their stiffnesses B, and B is a sum of m m^T over fixed
directions m with factors >= 0: symmetric and positive. Elements that share gauge and hardening share their state, and
become one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import FanTable
from pysprings.memory.candidates import Candidates, around, candidates, force_directions
from pysprings.memory.elements import PLASTIC, PLATES, REVERSIBLE
from pysprings.memory.samples import Sample
from pysprings.memory.shares import Shares, at_rest, elastic_motions, shares_of, stiffnesses

Array = NDArray[np.float64]

STIFFNESS = 0.1  # weight of the initial stiffness beside a ray
SUBSTEP = 0.01  # largest step of the motion over the reach
FORGET = 1e-9  # share of the initial stiffness below which an element is left out
# Numbers of the state of an element that moves in two planes (a plate: gap and frictional ones; a reversible one keeps
# none), and of all elements: SoilDyn of OpenFAST keeps 1,200
PLASTIC_NUMBERS, PLATE_NUMBERS, MOST_NUMBERS = 5, 6, 1190


@dataclass(frozen=True, slots=True)
class ElementSet:
    """Calibrated elements.

    Attributes
    ----------
    rows : (n, COLUMNS) parameters, see `pysprings.memory.elements`; B in N/m.
    reach : size of the largest motion of the rays [m].
    shares : how the elements share out the reactions.
    residual : norm of what is left of the weighted equations, relative to their right sides.
    errors : largest error in H and M/L of each way, over the largest load of it.
    way : longest way of the calibration [m]: w beyond it is extrapolated.
    """

    rows: Array
    reach: float
    shares: Shares
    residual: float
    errors: dict[str, tuple[float, float]]
    way: float

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

    choice: elements to choose from, instead of those of `pysprings.memory.candidates`. What is chosen from them
    is chosen a second time, with what is `around` it. most: numbers that the state of the elements may have in two
    planes; of more elements those that carry most are kept, and fitted again. Reactions are shared out as along the
    recorded ways (`Sample.recorded`). others: ways at other rates, from which the water's part of p comes, too.
    """
    reach = max(float(np.hypot(*way.motions.T).max()) for way in ways if way.recorded)
    loads = [way.loads(table) for way in ways]
    first = choice or candidates(reach)
    _, _, chosen = _fitted(first, ways, loads, stiffness, reach)
    near = around(first.chosen(chosen))
    rows, left, chosen = _fitted(near, ways, loads, stiffness, reach)
    if numbers_of(rows) > most:
        few = near.chosen(chosen).chosen(_strongest(rows, ways, reach, most))
        rows, left, _ = _fitted(few, ways, loads, stiffness, reach)
    pairs = [(way, load) for way, load in zip(ways, loads, strict=True) if way.recorded]
    ways, loads = [way for way, _ in pairs], [load for _, load in pairs]
    shares, carried = shares_of(rows, ways, loads, table, SUBSTEP * reach, others)
    errors = {}
    for way, load, own in zip(ways, loads, carried, strict=True):
        worst = np.abs(own - load).max(axis=0) / np.abs(load).max()
        errors[way.name] = float(worst[0]), float(worst[1])
    longest = max(way_of(way.motions) for way in ways)
    return ElementSet(rows, reach, shares, left, errors, longest)


def _fitted(
    choice: Candidates, ways: Sequence[Sample], loads: Sequence[Array], stiffness: Array, reach: float
) -> tuple[Array, float, NDArray[np.bool_]]:
    """Return elements (n, COLUMNS) chosen from candidates, the relative residual, and which are chosen."""
    from scipy.optimize import nnls  # a prediction by a fan does without SciPy

    plastic, *others = choice.rows
    single = np.concatenate(others)
    A, b = _system(plastic, single, ways, loads, stiffness, reach)
    size = np.linalg.norm(A, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    factors, left = nnls(A / size, b, maxiter=20 * A.shape[1])
    rows, chosen = _merged(plastic, single, factors / size, FORGET * float(np.trace(stiffness)))
    return rows, float(left / np.linalg.norm(b)), chosen


def numbers_of(rows: Array) -> int:
    """Return how many numbers the state of elements has in two planes."""
    return int(_numbers(rows[:, 0]).sum())


def _numbers(kind: Array) -> NDArray[np.int64]:
    return np.where(kind == REVERSIBLE, 0, np.where(kind == PLASTIC, PLASTIC_NUMBERS, PLATE_NUMBERS))


def _strongest(rows: Array, ways: Sequence[Sample], reach: float, most: int) -> NDArray[np.bool_]:
    """Return which elements carry most along the ways, as many as have this many numbers together."""
    carried = np.zeros(len(rows))
    for way in ways:
        e = elastic_motions(rows, way.motions, SUBSTEP * reach)[0]
        forces = _forces(rows, e) * way.weights[:, None, None]
        carried += (forces**2).sum(axis=(0, 2))
    order = np.argsort(-carried)
    numbers = _numbers(rows[order, 0]).cumsum()
    keeps = np.zeros(len(rows), dtype=bool)
    keeps[order[numbers <= most]] = True
    return keeps


def way_of(motions: Array) -> float:
    """Return how far motions (n, 2) [m] go from the origin, back and forth [m]."""
    return float(np.hypot(*np.diff(motions, axis=0, prepend=np.zeros((1, 2))).T).sum())


def _system(
    plastic: Array, single: Array, ways: Sequence[Sample], loads: Sequence[Array], stiffness: Array, reach: float
) -> tuple[Array, Array]:
    """Return matrix and right side of the equations, two a point, and three of the initial stiffness.

    single: rows of elements whose B has one factor alone, all but plastic ones.
    """
    m = force_directions()
    blocks, right = [], []
    for way, load in zip(ways, loads, strict=True):
        e = elastic_motions(plastic, way.motions, SUBSTEP * reach)[0] @ m.T
        along = (e[:, None] * m.T[None, :, None]).reshape(len(load), 2, -1)
        forces = _forces(single, elastic_motions(single, way.motions, SUBSTEP * reach)[0]).transpose(0, 2, 1)
        weighted = np.concatenate([along, forces], axis=2) * way.weights[:, None, None]
        blocks.append(weighted.reshape(2 * len(load), -1))
        right.append((load * way.weights[:, None]).ravel())
    aim = np.array([stiffness[0, 0], 0.5 * (stiffness[0, 1] + stiffness[1, 0]), stiffness[1, 1]])
    own = np.stack([m[:, 0] ** 2, m[:, 0] * m[:, 1], m[:, 1] ** 2])
    B = at_rest(single)
    first = np.concatenate([np.tile(own, len(plastic)), np.stack([B[:, 0, 0], B[:, 0, 1], B[:, 1, 1]])], axis=1)
    blocks.append(STIFFNESS * first / np.abs(aim)[:, None])
    right.append(STIFFNESS * aim / np.abs(aim))
    return np.concatenate(blocks), np.concatenate(right)


def _forces(rows: Array, e: Array) -> Array:
    """Return the forces (n, elements, 2) of elastic motions e of elements."""
    forces: Array = np.einsum("kab,nkb->nka", stiffnesses(rows), e)
    return forces


def _merged(plastic: Array, single: Array, factors: Array, least: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return the chosen elements (n, COLUMNS) with stiffness, and which of all (plastic, then single) they are."""
    m = force_directions()
    own = factors[: len(plastic) * len(m)].reshape(len(plastic), len(m))
    B = np.einsum("kj,ja,jb->kab", own, m, m)
    rows = plastic.copy()
    rows[:, 4], rows[:, 5], rows[:, 6] = B[:, 0, 0], B[:, 0, 1], B[:, 1, 1]
    others, sizes = single.copy(), factors[len(plastic) * len(m) :]
    plate = np.isin(others[:, 0], PLATES)
    others[plate, 6] = sizes[plate]
    others[~plate, 4:7] *= sizes[~plate, None]
    chosen = np.concatenate([own.sum(axis=1), sizes]) > least
    return np.concatenate([rows, others])[chosen], chosen
