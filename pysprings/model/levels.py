# SPDX-License-Identifier: MIT
"""Levels of a graded mesh made to pass through given lines, such as boundaries of layers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_SAME = 1.0e-9  # of the whole length: lines closer to a level than that are that level


def through(levels: np.ndarray, lines: Sequence[float]) -> np.ndarray:
    """Return levels (m,) that stand on all ``lines``, with cells about as large as those of ``levels`` (n + 1,).

    Between two lines the cells follow the grading of ``levels``; each gap has one at the least. Lines beyond the ends
    do not count. Without lines between the levels these are returned as they are.
    """
    room = _SAME * (levels[-1] - levels[0])
    new = [x for x in lines if levels[0] + room < x < levels[-1] - room and np.min(np.abs(levels - x)) > room]
    if not new:
        return levels
    fixed = np.unique(np.concatenate([levels[[0, -1]], levels[stand_on(levels, lines)], new]))
    rank = np.interp(fixed, levels, np.arange(len(levels)))
    parts = [fixed[:1]]
    for a, b in zip(range(len(fixed) - 1), range(1, len(fixed)), strict=True):
        n = max(1, round(float(rank[b] - rank[a])))
        inner = np.interp(np.linspace(rank[a], rank[b], n + 1)[1:-1], np.arange(len(levels)), levels)
        parts += [inner, fixed[b : b + 1]]
    return np.concatenate(parts)


def stand_on(levels: np.ndarray, lines: Sequence[float]) -> np.ndarray:
    """Return which levels (n,) bool stand on a line."""
    room = _SAME * (levels[-1] - levels[0])
    return np.array([any(abs(x - line) <= room for line in lines) for x in levels])
