# SPDX-License-Identifier: MIT
"""Cells of one resolution for every caisson: numbers and sizes of a preset, carried over from the reference geometry.

The presets count cells for the caisson of Cerfontaine, Charlier & Collin (2018) in their domain of 24 m x 12 m. In
diameters, another caisson has cells of the same sizes beside wall, mudline and toe, which grow as much from one to the
next; a longer skirt has more of them, a wider domain more beyond the reach of theirs.
"""

import math

import numpy as np
from scipy.optimize import brentq

DIAMETER, LENGTH, THICKNESS = 7.8, 4.0, 0.1  # m, of the reference caisson
OUTSIDE, BELOW = 20.1, 8.0  # m of soil beside its skirt and below its tip

# Cells shrink away from the skirt only down to this sum of n cells of the first size over the length.
_MOST_SHRINKING = 2.0
_FAR = 1.6  # least growth of cells beyond the reach of the reference domain
_SAME = 1.0e-9
_MORE = 1.001  # of a size or a growth: rounding does not add a cell
_MOST_CELLS = 2000
_SLENDER = 2.0  # skirt length over diameter, beyond which the largest cell grows with the length


def graded(start: float, stop: float, n: int, first: float) -> np.ndarray:
    """Return the levels (n + 1,) from start to stop, the first cell of the given size, growing geometrically.

    Where there is hardly room for the first cell, all cells are the same: they would shrink to needles otherwise.
    """
    length = stop - start
    share = first / abs(length)
    if n == 1 or abs(n * share - 1.0) < 1e-9 or n * share > _MOST_SHRINKING:
        return np.linspace(start, stop, n + 1)
    ratio = brentq(lambda q: share * (q**n - 1.0) - (q - 1.0) if abs(q - 1.0) > 1e-12 else share * n - 1.0, *(
        (1.0 + 1e-9, min(50.0, 10.0 ** (300.0 / n))) if n * share < 1.0 else (1e-6, 1.0 - 1e-9)
    ))  # fmt: skip
    steps = np.cumsum(ratio ** np.arange(n))
    return np.concatenate([[start], start + length * steps / steps[-1]])


def graded_both(length: float, n: int, first: float, last: float) -> np.ndarray:
    """Return levels (n + 1,) from 0 to length; the end cells have the given sizes, and grow geometrically inwards."""

    def sizes(ratio: float) -> np.ndarray:
        rank = np.arange(n)
        with np.errstate(over="ignore"):  # of a size that is not the smaller one
            return np.minimum(first * ratio**rank, last * ratio ** rank[::-1])

    if n < 3 or sizes(1.0).sum() >= length:  # two cells have none between them that could grow
        return np.linspace(0.0, length, n + 1)
    levels = np.cumsum(sizes(brentq(lambda ratio: sizes(ratio).sum() - length, 1.0, 50.0)))
    return np.concatenate([[0.0], length * levels / levels[-1]])


def away(start: float, stop: float, n: int, first: float, near: float) -> np.ndarray:
    """Return levels from start to stop; those of n cells would reach ``near`` (m), the first of the given size.

    Nearer stops leave out cells; beyond ``near`` they go on growing.
    """
    length = stop - start
    if abs(length - near) <= _SAME * near:
        return graded(start, stop, n, first)
    levels = graded(0.0, near, n, first)
    if length < near:
        return graded(start, stop, max(1, int(np.searchsorted(levels, length * (1.0 - _SAME)))), first)
    last = levels[-1] - levels[-2]
    growth = max(_FAR, last / (levels[-2] - levels[-3])) if n > 1 else _FAR
    number = max(1, round(math.log(1.0 + (growth - 1.0) * (length - near) / (last * growth), growth)))
    steps = np.cumsum(growth ** np.arange(1, number + 1))
    return start + np.concatenate([levels, near + (length - near) * steps / steps[-1]])


def down_the_skirt(length: float, diameter: float, n: int, first: float, last: float) -> np.ndarray:
    """Return levels from mudline to tip; n cells have the shares first and last of the reference skirt at its ends.

    The end cells of another skirt are no larger than those of the reference in diameters.
    """
    reference = LENGTH * diameter / DIAMETER
    if abs(length - reference) <= _SAME * length:
        return graded_both(length, n, first * length, last * length)
    cells = np.diff(graded_both(reference, n, first * reference, last * reference))
    # needles: a limited number of cells
    largest = cells.max() * max(1.0, length / (_SLENDER * diameter)) * _MORE
    growth = _growth(cells) * _MORE
    top, toe = _MORE * first * reference, _MORE * last * reference
    for number in range(1, _MOST_CELLS):
        try:
            levels = graded_both(length, number, first * reference, last * reference)
        except ValueError:  # too few cells to fill the length
            continue
        own = np.diff(levels)
        if own[0] <= top and own[-1] <= toe and own.max() <= largest and _growth(own) <= growth:
            return levels
    raise ValueError(f"more than {_MOST_CELLS} cells")


def across_the_tip(thickness: float, diameter: float, n: int, wall: float) -> int:
    """Return the number of cells across a tip; n is that of the reference, ``wall`` (m) the first one beside it."""
    largest = max(wall, THICKNESS * diameter / DIAMETER / n)
    return max(n, math.ceil(thickness / largest - _SAME))


def _growth(cells: np.ndarray) -> float:
    """Return the largest ratio of neighbouring cells."""
    ratio = cells[1:] / cells[:-1]
    return float(np.max(np.maximum(ratio, 1.0 / ratio), initial=1.0))
