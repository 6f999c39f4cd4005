# SPDX-License-Identifier: MIT
"""How far a given load may move the caisson: where it is further, the path has ended, whatever still converges.

Ten per cent of the diameter or five degrees end a path of kind "load": small displacements do not describe more, and
no foundation is used there. A soil that carries the load without a peak (clay as cohesion without friction) would go
on to metres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pysprings.core.stop_reasons import StopReason

LARGEST_SHARE = 0.1  # of the diameter: lid centre or tip sideways, or the caisson up or down
LARGEST_ROTATION = math.radians(5.0)
# An increment that ends beyond this many times the limit is tried again with half its size
OVERSHOOT = 1.5


@dataclass(frozen=True)
class DisplacementLimit:
    """The limit for a caisson (m), whose vertical displacement counts from ``rest`` (m, down)."""

    diameter: float
    skirt_length: float
    rest: float = 0.0

    def share(self, border: np.ndarray) -> float:
        """Return the share of the limit that a motion (u, w, rotation; m, rad) of the lid centre reaches."""
        return max(self._shift(border) / (LARGEST_SHARE * self.diameter), abs(border[2]) / LARGEST_ROTATION)

    def text(self, border: np.ndarray) -> str:
        """Return words for how far the caisson has moved, and the limit."""
        turned = math.degrees(abs(border[2]))
        limit = f"{LARGEST_SHARE:.0%} of the diameter, {math.degrees(LARGEST_ROTATION):g} deg"
        return f"the caisson has moved by {self._shift(border):.3g} m and turned by {turned:.2g} deg (limit {limit})"

    def refusal(self, border: np.ndarray) -> str:
        """Return why an increment that ends there is not taken, "" where it is."""
        return (
            f"{StopReason.DISPLACEMENT_LIMIT}: an increment leads too far, {self.text(border)}"
            if self.share(border) > OVERSHOOT
            else ""
        )

    def _shift(self, border: np.ndarray) -> float:
        u, w, rotation = border
        return float(max(abs(u), abs(u + rotation * self.skirt_length), abs(w - self.rest)))
