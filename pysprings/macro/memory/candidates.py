# SPDX-License-Identifier: MIT
"""The elements that a calibration chooses from; all lengths are shares of the reach of the rays.

Measured on three caissons (sand, soil with cohesion, clay): directions every 20 degrees and two slender gauges are
enough; hardening over a fifth of the reach carries the growth of the loads from cycle to cycle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.memory.elements import COLUMNS, GAP, PLASTIC

Array = NDArray[np.float64]

DIRECTIONS = 9  # of gauges, over 180 degrees
ASPECTS = (0.1, 0.3)  # of a gauge across its direction: there an element yields at 1/aspect of the motion
SMALLEST, LARGEST, SIZES = 1 / 5000, 1 / 2, 8  # motion at first yield
# gain a, and length h over which half of it is reached; gain 0: perfectly plastic
LAWS = (
    (0.0, 1.0),
    (2.0, 0.02),
    (2.0, 0.2),
    (2.0, 2.0),
    (10.0, 0.02),
    (10.0, 0.2),
    (10.0, 2.0),
    (50.0, 0.2),
    (50.0, 2.0),
)
MOST_GROWN = 1.0  # of d a: an element of a larger one would never come near its last size
FORCES = 9  # directions of the force of an element, over 180 degrees
GAP_DIRECTIONS, GAP_SIZES = 18, 8
_ELASTIC = 1e6  # size of an element that never yields


def mechanisms(reach: float) -> Array:
    """Return the plastic elements (n, COLUMNS) with B = I, for a reach [m]; the last one is elastic."""
    rows = [
        [PLASTIC, *gauge, 1.0, 0.0, 1.0, size, gain, length * reach]
        for gauge in _gauges()
        for size in np.geomspace(SMALLEST * reach, LARGEST * reach, SIZES)
        for gain, length in LAWS
        if size * gain < MOST_GROWN * reach
    ]
    return np.array([*rows, [PLASTIC, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, _ELASTIC * reach, 0.0, reach]])


def _gauges() -> list[tuple[float, float, float]]:
    """Return g11, g12, g22 of ellipses of size 1 along a direction and 1/aspect across it."""
    out = []
    for k in range(DIRECTIONS):
        c, s = np.cos(np.pi * k / DIRECTIONS), np.sin(np.pi * k / DIRECTIONS)
        out += [(c * c + (a * s) ** 2, (1.0 - a * a) * c * s, s * s + (a * c) ** 2) for a in ASPECTS]
    return out


def force_directions() -> Array:
    """Return unit vectors (FORCES, 2); B of an element is a sum of m m^T, which is symmetric and positive."""
    angle = np.arange(FORCES) * np.pi / FORCES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def gaps(reach: float) -> Array:
    """Return the gap elements (n, COLUMNS) of stiffness 1, for a reach [m]."""
    rows = np.zeros((GAP_DIRECTIONS * GAP_SIZES, COLUMNS))
    angle = np.repeat(np.arange(GAP_DIRECTIONS) * np.pi / GAP_DIRECTIONS, GAP_SIZES)
    rows[:, 0], rows[:, 4], rows[:, 5], rows[:, 6] = GAP, np.cos(angle), np.sin(angle), 1.0
    rows[:, 7] = np.tile(np.geomspace(SMALLEST * reach, LARGEST * reach, GAP_SIZES), GAP_DIRECTIONS)
    return rows
