# SPDX-License-Identifier: MIT
"""What the plates of gap and frictional elements, one in each of two planes, change on a motion between them."""

from __future__ import annotations

import math

import numpy as np

from pysprings.macro.memory.elements import PLATES
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.memory.shares import elastic_motions, loads_of

_ANGLES = np.radians([-90.0, -60.0, -45.0, -30.0, 0.0, 30.0, 60.0])  # of (u, rotation L)
_WAY = np.concatenate([np.linspace(0.02, 0.5, 25), np.linspace(0.48, -0.5, 50), np.linspace(-0.48, 0.5, 50)])


def error_between_planes(memory: MemoryModel) -> tuple[float, float]:
    """Return the largest differences of H and M at 45 degrees between two planes, over the largest of each way.

    The ways go to half of the reach, back to the other side, and forth again, in seven directions of (u, rotation L).
    Plastic elements have no preferred plane; each plate of the others takes cos(45 deg) of the motion.
    """
    rows = memory.elements.rows
    plate = np.isin(rows[:, 0], PLATES)
    largest = np.zeros(2)
    for angle in _ANGLES:
        way = memory.elements.reach * _WAY[:, None] * np.array([math.cos(angle), math.sin(angle)])
        whole = loads_of(rows, elastic_motions(rows, way, memory.elements.largest)[0])
        if not plate.any():
            continue
        plates, half = rows[plate], math.sqrt(0.5)
        along = loads_of(plates, elastic_motions(plates, way, memory.elements.largest)[0])
        between = loads_of(plates, elastic_motions(plates, half * way, memory.elements.largest)[0]) / half
        largest = np.maximum(largest, np.abs(between - along).max(axis=0) / np.abs(whole).max())
    return float(largest[0]), float(largest[1])
