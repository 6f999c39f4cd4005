# SPDX-License-Identifier: MIT
"""Loads in the vertical plane of the horizontal force, and the moment across it; vertical loads that count as one.

Vertical loads are one, are close enough for the springs of one, or are those at which springs are made.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arrays import Array, Marks
from pysprings.core.text import with_prefix
from pysprings.core.words import SOLVED

ROUNDING = 1e-6  # share of a moment up to which its part across the plane of H is rounding of angles


@dataclass(frozen=True)
class InPlane:
    """Loads (n,) in the vertical plane of their force, else of their moment.

    H, M : force [N] and moment [N m] in the plane; M = H h of a force at height h.
    across : moment about the direction of the plane [N m], right-handed: it bends across the plane.
    direction : of the plane [rad], from x towards y.
    """

    H: Array
    M: Array
    across: Array
    direction: Array


def in_plane(force: Array, bending: Array, least: Array | None = None, plane: Array | None = None) -> InPlane:
    """Return loads in their planes.

    force : (n, 2) H_x, H_y [N].
    bending : (n, 2) moments in the planes of x and y, M_y and -M_x [N m].
    least : (n, 2) force [N] and moment [N m] that are rounding; by default of forces at heights up to 100 m.
    plane : (n, 2) unit vectors of the planes; by default along the force, else along the bending.
    """
    size, turn = np.hypot(*force.T), np.hypot(*bending.T)
    least = np.stack([0.01 * ROUNDING * turn, ROUNDING * turn], axis=1) if least is None else least
    if plane is None:
        lead = np.where(
            (size > least[:, 0])[:, None], force, np.where((turn > least[:, 1])[:, None], bending, [1.0, 0])
        )
        plane = lead / np.hypot(*lead.T)[:, None]
    across = plane[:, 1] * bending[:, 0] - plane[:, 0] * bending[:, 1]
    both = np.stack([(plane * bending).sum(axis=1), across])
    M, across = np.where(np.abs(both) <= least[:, 1], 0.0, both)
    return InPlane((plane * force).sum(axis=1), M, across, np.arctan2(plane[:, 1], plane[:, 0]))


SAME_LOAD = 1e-3  # vertical loads that differ by less than this share are one
NO_LOAD = 1.0  # or by this [N]
CLOSE_LOAD = 0.1  # vertical loads whose lateral springs are one, over the larger
_KEPT = 1.0 - CLOSE_LOAD * (1.0 - 1e-9)  # a little closer, for rounding


def same_load(a: float, b: float) -> bool:
    """Return whether two vertical loads [N] are one: they may differ by solver tolerances."""
    return bool(same_loads(a, b))


def same_loads(values: Array | float, other: Array | float) -> Marks:
    """Return which vertical loads (n,) [N] are one with another, or each with its own (n,)."""
    largest = np.maximum(np.abs(values), np.abs(other))
    same: Marks = np.abs(np.subtract(values, other)) <= np.maximum(SAME_LOAD * largest, NO_LOAD)
    return same


def close_loads(values: Array | float, other: Array | float) -> Marks:
    """Return which vertical loads [N] are so close to others that lateral springs of one hold for both.

    `benchmarks.macro` prints how much a tenth of V changes loads.
    """
    near: Marks = _apart(values, other) <= 1.0 + 1e-9  # of loads that are rounded
    return near


def _apart(values: Array | float, other: Array | float) -> Array:
    """Return differences of vertical loads [N] over the largest of `close_loads`."""
    most = np.maximum(CLOSE_LOAD * np.maximum(np.abs(values), np.abs(other)), NO_LOAD)
    return np.abs(np.subtract(values, other)) / most


def nearest(values: Array, loads: Array) -> NDArray[np.intp]:
    """Return which of loads (m,) [N] is nearest to each vertical load (n,) [N].

    Beyond all of them it is the one at that end; between two, that which is nearer by the measure of `close_loads`.
    """
    order = np.argsort(loads)
    own = np.clip(values, loads[order[0]], loads[order[-1]])
    above = np.searchsorted(loads[order], own).clip(0, order.size - 1)
    sides = order[np.stack([np.maximum(above - 1, 0), above])]
    low, high = (_apart(own, loads[side]) for side in sides)
    return sides[(high < low).astype(int), np.arange(own.size)]


def fewest_loads(values: Iterable[float], rest: float) -> tuple[float, ...]:
    """Return the fewest vertical loads [N], lightest first, that are close to all values which `rest` is not close to.

    A group of values has that value which is nearest to the middle of the group, where it is close to all of them, else
    the middle: the geometric mean of its ends, equally close to both (the arithmetic one at loads of a few newtons).
    """
    left = np.unique([value for value in values if not close_loads(value, rest)])
    found = []
    while left.size:
        # the farthest load that is close to the lightest value (stabbing of intervals from one end: the fewest)
        low = left[0]
        end = max(low / _KEPT, low * _KEPT, low + NO_LOAD)
        group = left[close_loads(left, end) | (left <= end)]
        product, half = float(low * group[-1]), float(0.5 * (low + group[-1]))
        middle = np.copysign(np.sqrt(product), half) if product > 0.0 else half
        own = min(group, key=lambda value: abs(value - middle))
        found.append(next(float(V) for V in (own, middle, half) if close_loads(group, V).all()))
        left = left[group.size :]
    return tuple(found)


def loads_in_words(H: float, M: float) -> str:
    """Return words for a load H [N], M [N m]; what rounding has left of zero is 0."""
    least = max(SOLVED * max(abs(H), abs(M)), NO_LOAD)
    force, moment = (0.0 if abs(x) < least else x for x in (H, M))
    return f"H = {with_prefix(force, 'N')} with M = {with_prefix(moment, 'N m')}"
