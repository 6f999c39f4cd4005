# SPDX-License-Identifier: MIT
"""Caissons in one homogeneous, drained sand under a vertical load.

L/D, the friction angle, E/(gamma' D), the friction of the steel mu and V/(gamma' D^3) decide on loads over
F = gamma' D^2 (L + D) as functions of rho/D. The thickness of the skirt is a fixed share of D, the surcharge one of
gamma' D. All cases of a study move by the same share of D, so that X is `STRETCH` rho/D: none has to be filled in from
stiffer neighbours.
"""

from collections.abc import Iterator

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem
from pysprings.scene.model import Scene
from pysprings.studies.atlas.families.base import FREE, Family, Scaled, Sizes, diameter, first_layer

STRETCH = 1000.0  # X over rho/D


def _weight(scene: Scene) -> float:
    """Return gamma' D [Pa]."""
    return float(first_layer(scene).effective_unit_weight) * diameter(scene)


def _read(scene: Scene) -> Array:
    D, soil = diameter(scene), first_layer(scene)
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
    return Sizes(weight * D * (L + D), STRETCH)


def _odd(scene: Scene, _base: Scene) -> Iterator[Problem]:
    """Yield a problem for values that vary with depth, and for a vertical load without a number."""
    for key in _CONSTANT:
        if not isinstance(getattr(first_layer(scene), key), float):
            yield Problem(key=f"soil.{key}", message="the atlas needs one value at all depths")
    if isinstance(scene.caisson.vertical_load, str):
        yield Problem(key="caisson.vertical_load", message='the atlas needs a force, such as "2 MN"')


_CONSTANT = ("friction_angle_final", "young_modulus", "effective_unit_weight")
FAMILY = Family(
    name="sand",
    labels=("L/D", "phi", "E/(gamma' D)", "mu", "V/(gamma' D^3)"),
    read=_read,
    even=_even,
    sizes=_sizes,
    free={
        **FREE,
        "interface": ("friction_coefficient",),
        "soil.layer": (*_CONSTANT, "hydraulic_conductivity", "name", "drainage"),
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
    odd=_odd,
)  # fmt: skip
