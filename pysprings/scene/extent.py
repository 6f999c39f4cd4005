# SPDX-License-Identifier: MIT
"""Size of the cylinder of soil that is modelled: given in the scene, or chosen by caisson and layers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pysprings.core.words import AUTO

if TYPE_CHECKING:
    from pysprings.scene.sections import Caisson, Domain, Soil

PAPER = {"radius": 24.0, "depth": 12.0}  # m, the domain of Cerfontaine, Charlier & Collin (2018)
# diameters between the axis and the side, and between the tip and the bottom: see `model.forecast.domain_effect`
RADIUS, BELOW_TIP = 40.0, 40.0
GROUND = 3.0  # diameters below the tip, where an automatic depth turns the soil into an elastic one: see `ground`
_OF_LAST = 1.0  # diameter of the last layer that is modelled at the least


@dataclass(frozen=True)
class Extent:
    """Radius and depth of the domain, m, the depth down to which the soil has its own values, and that of the tip."""

    radius: float
    depth: float
    ground: float
    tip: float


def make_extent(domain: Domain, caisson: Caisson, soil: Soil) -> Extent:
    """Return the size of the domain; what is "auto" follows from caisson and layers."""
    diameter, tip = caisson.outer_diameter, caisson.skirt_length
    last = max((layer.top for layer in soil.layers), default=0.0)
    radius = RADIUS * diameter if domain.radius == AUTO else float(domain.radius)
    if domain.depth != AUTO:
        return Extent(radius, float(domain.depth), float(domain.depth), tip)
    ground = max(tip + GROUND * diameter, last + _OF_LAST * diameter)
    return Extent(radius, max(tip + BELOW_TIP * diameter, 2.0 * ground), ground, tip)
