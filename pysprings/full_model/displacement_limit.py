# SPDX-License-Identifier: MIT
"""How far a given load may move the caisson: where it is further, the path has ended, whatever still converges.

A share of the diameter or a rotation (`[limit]` of the scene; 10 % and 5 degrees by default) ends a path of kind
"load": small displacements do not describe more, and no foundation is used there. A soil that carries the load without
a peak (clay as cohesion without friction) would go on to metres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.words import StopReason

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

# An increment that ends beyond this many times the limit is tried again with half its size
OVERSHOOT = 1.1


@dataclass(frozen=True)
class DisplacementLimit:
    """The limit for a caisson.

    Attributes
    ----------
    diameter, skirt_length : of the caisson [m].
    largest_share : of the diameter, by which the lid centre or the tip may move sideways, or the caisson up or down.
    largest_rotation : [rad].
    rest : vertical displacement [m, down] from which it counts.
    """

    diameter: float
    skirt_length: float
    largest_share: float
    largest_rotation: float
    rest: float = 0.0

    @classmethod
    def of(cls, scene: Scene, rest: float) -> DisplacementLimit:
        """Return the limit of a scene."""
        caisson, limit = scene.caisson, scene.limit
        return cls(caisson.outer_diameter, caisson.skirt_length, limit.displacement_over_diameter, limit.rotation, rest)

    def share(self, border: np.ndarray) -> float:
        """Return the share of the limit that a motion (u, w, rotation; m, rad) of the lid centre reaches."""
        return max(self._shift(border) / (self.largest_share * self.diameter), abs(border[2]) / self.largest_rotation)

    def text(self, border: np.ndarray) -> str:
        """Return words for how far the caisson has moved, and the limit."""
        turned = math.degrees(abs(border[2]))
        limit = f"{100.0 * self.largest_share:g} % of the diameter, {math.degrees(self.largest_rotation):g} deg"
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
        return float(max(abs(u), abs(u - rotation * self.skirt_length), abs(w - self.rest)))
