# SPDX-License-Identifier: MIT
"""When two loads, two directions or two rates count as the same: each tolerance once."""

from __future__ import annotations

import math

SAME_LOAD = 1e-3  # vertical loads that differ by less than this share are one
NO_LOAD = 1.0  # or by this [N]
SAME_DIRECTION = math.radians(1.0)  # directions within this angle [rad] are one
STRAIGHT = 1e-3  # a path keeps its direction when all its states are within this angle [rad]
TOGETHER = 10.0**0.5  # paths whose rates differ by less than this factor belong to one set
CLOSE = 1.05  # a rate within this factor of a set's is that of the set


def same_load(a: float, b: float) -> bool:
    """Return whether two vertical loads [N] are one: they may differ by solver tolerances."""
    return abs(a - b) <= max(SAME_LOAD * max(abs(a), abs(b)), NO_LOAD)


def is_rate(a: float, b: float) -> bool:
    """Return whether two rates [m/s] are one."""
    return max(a / b, b / a) <= CLOSE
