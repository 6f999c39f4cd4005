# SPDX-License-Identifier: MIT
"""Types of arrays, and cubic curves through recorded points."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Marks = NDArray[np.bool_]
Texts = NDArray[np.object_]


def secant_slopes(rho: Array, r: Array, initial: Array) -> Array:
    """Return slopes dr/drho (rows, k) at the knots rho (k,), 0 first, from the secants S = (r - r(0))/rho.

    S(0) = initial (rows,). dS/ds is that of a parabola through three neighbours in s = ln(1 + rho/rho_1), as steps
    grow from the first one on. Exact for a linear response; linear in r and initial, unlike
    `pysprings.macro.curve_table.pchip_slopes`: slopes of a sum are the sum of the slopes.
    """
    secant = np.concatenate([initial[:, None], (r[:, 1:] - r[:, :1]) / rho[1:]], axis=1)
    h = np.diff(np.log1p(rho / rho[1]))
    rise = np.diff(secant, axis=1) / h
    bend = np.empty_like(r)
    if h.size == 1:
        bend[:] = rise
    else:
        share = h[1:] / (h[1:] + h[:-1])
        bend[:, 1:-1] = share * rise[:, :-1] + (1.0 - share) * rise[:, 1:]
        bend[:, 0], bend[:, -1] = 2.0 * rise[:, 0] - bend[:, 1], 2.0 * rise[:, -1] - bend[:, -2]
    return secant + bend * rho / (rho + rho[1])
