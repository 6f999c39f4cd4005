# SPDX-License-Identifier: MIT
"""Which of several choices no other one beats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def front(cost: Sequence[float], error: Sequence[float]) -> list[int]:
    """Return the numbers of the choices that none is both cheaper and better than, by cost; NaN is never among them.

    >>> front([1.0, 2.0, 3.0, 4.0], [9.0, 4.0, 5.0, 1.0])
    [0, 1, 3]
    """
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    counted = np.flatnonzero(np.isfinite(costs) & np.isfinite(errors))
    best, best_ones = np.inf, []
    for k in counted[np.lexsort((errors[counted], costs[counted]))]:
        if errors[k] < best:
            best = errors[k]
            best_ones.append(int(k))
    return best_ones
