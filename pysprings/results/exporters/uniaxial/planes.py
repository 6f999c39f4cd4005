# SPDX-License-Identifier: MIT
"""Springs in several vertical planes: one law that answers alike in every direction of the motion.

A spring that stands at an angle c from the motion reads cos(c) of it, and cos(c) of its force counts. Two planes at
right angles are exact along each; between them plastic springs carry up to sqrt(2) times the load. With more planes
the laws g of the springs are chosen so that their sum over the planes is the law f of the motion:
sum over k of cos(c_k) g(cos(c_k) q) = f(q). The exact inverse grows from octave to octave, so g is a sum of curves
k q/(1 + (|q|/d)^4)^(1/4), k >= 0, by non-negative least squares over q, the mean of a motion along a plane and one
between two.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.curve_table import Row, SpringTable, stack
from pysprings.macro.solver import row_values

Array = NDArray[np.float64]

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
    values: Array = q[..., None] / (1.0 + over**SHARP) ** (1.0 / SHARP)
    return values


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
