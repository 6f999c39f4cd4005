# SPDX-License-Identifier: MIT
"""Order of convergence from three meshes, and extrapolation to cells of no size.

A quantity Q on meshes of cell size h1 > h2 > h3 is taken as Q = Q* + C h^p (Richardson 1911). The order p solves

    (Q1 - Q2)/(Q2 - Q3) = (h1^p - h2^p)/(h2^p - h3^p)

(Roache 1994, for unequal ratios of h). Of a curve, the left side is the ratio of the differences in the sense of least
squares, d12.d23/d23.d23, one order for the whole curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]

LOWEST, HIGHEST = 0.5, 4.0  # orders that are believed
NEEDED = 3  # meshes


@dataclass(frozen=True)
class Reference:
    """Limit of a quantity on ever finer meshes: values, and ``beside``, whose distance from them is their uncertainty.

    ``order`` is None where the finest mesh is taken as it is; ``note`` is the cause. ``beside`` is the finest mesh if
    the values are extrapolated from it, else the mesh before it.
    """

    values: Array
    beside: Array
    order: float | None
    note: str

    @property
    def extrapolated(self) -> bool:
        """Whether the values are better than those of the finest mesh."""
        return self.order is not None


def cell_size(unknowns: float, harmonics: int | None = None) -> float:
    """Return the size h of the cells of a mesh with so many unknowns, up to a factor.

    unknowns^(-1/3) of bricks; (unknowns/(N + 1))^(-1/2) of a section with N harmonics.
    """
    if harmonics is not None:
        return (float(unknowns) / (harmonics + 1)) ** -0.5
    return float(unknowns) ** (-1.0 / 3.0)


def order_from(ratio: float, h: Sequence[float]) -> float:
    """Return the order p of three cell sizes h (falling) whose differences have this ratio; NaN outside the range."""
    h1, h2, h3 = (value / h[2] for value in h)

    def excess(p: float) -> float:
        return float((h1**p - h2**p) / (h2**p - h3**p)) - ratio

    if not excess(LOWEST) <= 0.0 <= excess(HIGHEST):
        return float("nan")
    return float(brentq(excess, LOWEST, HIGHEST, xtol=1e-12))


def extrapolate(values: Sequence[Array], h: Sequence[float]) -> Reference:
    """Return what values (one array a mesh, the finest last; NaN is left out) tend to as h (falling) goes to 0."""
    finest = values[-1]
    if len(values) == 1:
        return Reference(finest, np.full_like(finest, np.nan), None, "one mesh: nothing to compare it with")
    if len(values) < NEEDED:
        return Reference(finest, values[-2], None, f"{len(values)} meshes: no order, the finest mesh as it is")
    q1, q2, q3 = values[-3:]
    d12, d23 = q1 - q2, q2 - q3
    counted = np.isfinite(d12) & np.isfinite(d23)
    size = float(d23[counted] @ d23[counted])
    if size == 0.0:
        return Reference(finest, q2, None, "the two finest meshes agree: the finest mesh as it is")
    ratio = float(d12[counted] @ d23[counted]) / size
    if ratio <= 0.0:
        return Reference(finest, q2, None, "the differences change sign: the finest mesh as it is")
    p = order_from(ratio, h[-3:])
    if np.isnan(p):
        text = f"the order is not in [{LOWEST:g}, {HIGHEST:g}] (differences {ratio:.3g} to 1): the finest mesh as it is"
        return Reference(finest, q2, None, text)
    return Reference(q3 - d23 / ((h[-2] / h[-1]) ** p - 1.0), q3, p, f"extrapolated with order {p:.2f}")
