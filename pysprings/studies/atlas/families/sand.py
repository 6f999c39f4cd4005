# SPDX-License-Identifier: MIT
"""Caissons in one homogeneous, drained sand under a vertical load.

L/D, the friction angle, E/(gamma' D), the friction of the steel mu and V/(gamma' D^3) decide on loads over
F = gamma' D^2 (L + D) as functions of X = E rho/(gamma' D^2). E/(gamma' D) decides beside X because the friction
hardens with the plastic strain. The thickness of the skirt is a fixed share of D, the surcharge one of gamma' D.

All cases of a study move by the same share of D. In an atlas X is therefore `STRETCH` rho/D: none has to be filled in
from stiffer neighbours.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.families.base import Family, Scaled, Sizes, Symbols, diameter

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]


def _weight(scene: Scene) -> float:
    """Return gamma' D [Pa]."""
    return float(scene.soil.effective_unit_weight) * diameter(scene)


def _read(scene: Scene) -> Array:
    D, soil = diameter(scene), scene.soil
    V = float(scene.caisson.vertical_load)
    return np.array([
        scene.caisson.skirt_length / D, np.degrees(float(soil.friction_angle_final)),
        float(soil.young_modulus) / _weight(scene), float(scene.interface.friction_coefficient),
        V / (_weight(scene) * D**2),
    ])  # fmt: skip


def _even(values: Array) -> Array:
    length, angle, stiffness, friction, load = np.moveaxis(values, -1, 0)
    return np.stack([np.log(length), angle, np.log(stiffness), friction, np.log(load)], axis=-1)


def _sizes(scene: Scene) -> Sizes:
    D, L = diameter(scene), scene.caisson.skirt_length
    weight = _weight(scene)
    return Sizes(weight * D * (L + D), float(scene.soil.young_modulus) / weight)


SURCHARGE = 0.05  # over gamma' D: that of the studies
STRETCH = 1000.0  # X over rho/D of an atlas


def _ground(inputs: Array, zeta: Array) -> tuple[Array, Array]:
    """Return the vertical effective stress at rest over gamma' D, and the stiffness: the same at all depths."""
    stress = SURCHARGE + inputs[:, :1] * zeta
    return stress, np.ones_like(stress)


def _lid(inputs: Array) -> Array:
    """Return V/D^2 over gamma' D."""
    return np.asarray(inputs[:, 4])


FAMILY = Family(
    name="sand",
    labels=("L/D", "phi", "E/(gamma' D)", "mu", "V/(gamma' D^3)"),
    read=_read,
    even=_even,
    sizes=_sizes,
    free={
        "caisson": ("outer_diameter", "skirt_length", "lid_thickness", "vertical_load"),
        "interface": ("friction_coefficient",),
        "soil": ("friction_angle_final", "young_modulus", "effective_unit_weight", "hydraulic_conductivity"),
        "drainage": (
            "porosity", "water_bulk_modulus", "water_unit_weight", "water_viscosity", "water_depth", "stabilisation",
        ),
    },
    scaled=(
        Scaled("caisson", "skirt_thickness", ("m", 1.0), "D", diameter),
        Scaled("soil", "surcharge", ("Pa", 1.0), "gamma' D", _weight),
    ),
    short={
        "phi": "soil.friction_angle_final",
        "E": "soil.young_modulus",
        "gamma": "soil.effective_unit_weight",
        "mu": "interface.friction_coefficient",
        "V": "caisson.vertical_load",
    },
    stretch=STRETCH,
    ground=_ground,
    lid=_lid,
    symbols=Symbols(
        "s'_v(z)", "V/D^2", "E", "E sqrt(u^2 + (rotation L)^2)/(gamma' D^2)",
        ("ln(L/D)", "phi [deg]", "ln(E/(gamma' D))", "mu", "ln(V/(gamma' D^3))"),
    ),
)  # fmt: skip
