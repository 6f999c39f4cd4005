# SPDX-License-Identifier: MIT
"""The engine's law, and its parameters, of each word of `soil.yield_surface`; see `pysprings.scene.soil_laws`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fe_engine.material import Material
from fe_engine.soil import elastic, plasol, van_eekelen
from fe_engine.soil.law import SoilLaw

if TYPE_CHECKING:
    from pysprings.scene.load import Scene
    from pysprings.scene.model import Soil


@dataclass(frozen=True)
class EngineLaw:
    """A law of the engine, and how its parameters are packed from the keys of a soil."""

    law: SoilLaw
    pack: Callable[[Soil], np.ndarray]


def _friction(soil: Soil) -> np.ndarray:
    return plasol.pack(
        young=soil.young_modulus,
        poisson=soil.poisson_ratio,
        phi_i=soil.friction_angle_initial,
        phi_f=soil.friction_angle_final,
        b_phi=soil.hardening_parameter,
        psi=soil.dilation_angle,
        cohesion=soil.cohesion,
    )


def _elastic(soil: Soil) -> np.ndarray:
    return elastic.pack(young=soil.young_modulus, poisson=soil.poisson_ratio)


ENGINE_LAWS = {
    "drucker-prager": EngineLaw(plasol.LAW, _friction),
    "van-eekelen": EngineLaw(van_eekelen.LAW, _friction),
    "elastic": EngineLaw(elastic.LAW, _elastic),
}


def engine_law(scene: Scene) -> SoilLaw:
    """Return the engine's law of a scene's soil."""
    return ENGINE_LAWS[scene.soil.yield_surface].law


def soil_material(scene: Scene) -> Material:
    """Pack the soil law of the scene."""
    chosen = ENGINE_LAWS[scene.soil.yield_surface]
    return Material(chosen.law, chosen.pack(scene.soil))
