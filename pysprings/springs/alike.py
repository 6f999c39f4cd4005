# SPDX-License-Identifier: MIT
"""When two loads count as the same."""

from __future__ import annotations

SAME_LOAD = 1e-3  # vertical loads that differ by less than this share are one
NO_LOAD = 1.0  # or by this [N]


def same_load(a: float, b: float) -> bool:
    """Tell whether two vertical loads [N] are one: solver tolerances are between them."""
    return abs(a - b) <= max(SAME_LOAD * max(abs(a), abs(b)), NO_LOAD)
