# SPDX-License-Identifier: MIT
"""Springs that soften: states beyond the peak of a curve, where equilibrium is one of several and may be unstable."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pysprings.macro.curve_table import SpringTable

Array = NDArray[np.float64]

FALL = 0.02  # share of its peak by which a curve falls before it counts as softening


def past_peak(table: SpringTable, states: Array) -> tuple[NDArray[np.bool_], list[str]]:
    """Return which states (n, 2) have a spring beyond the peak of a curve that softens, and a sentence on them."""
    known = np.arange(table.q.shape[1]) < table.count[:, None]
    size = np.where(known, np.abs(table.r), 0.0)
    rows, at = np.arange(len(size)), size.argmax(axis=1)
    peak, peak_at = size[rows, at], table.q[rows, at]
    behind = known & (np.arange(table.q.shape[1]) >= at[:, None])
    lowest = np.where(behind, size, np.inf).min(axis=1)
    soft = lowest < (1.0 - FALL) * peak
    past = soft & (np.abs(table.read(states).T) > peak_at)
    marks: NDArray[np.bool_] = past.any(axis=1)
    if not marks.any():
        return marks, []
    row = int(np.flatnonzero(past.any(axis=0))[0])
    place = f"{table.name[row]} at {table.depth[row]:g} m falls from {peak[row]:.4g} to {lowest[row]:.4g}"
    return marks, [
        f"{marks.sum()} of {len(states)} states are beyond the peak of a curve that softens ({place}): "
        "the equilibrium found there is one of several, and under a load it may not be stable"
    ]
