# SPDX-License-Identifier: MIT
"""The engine's law, and its parameters, of each word of `soil.yield_surface`; see `pysprings.scene.soil_laws`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from fe_engine.material import Material
from fe_engine.soil import elastic, plasol, van_eekelen
from fe_engine.soil.law import SoilLaw
from pysprings.scene.by_depth import ByDepth
from pysprings.scene.ground import ground_of

if TYPE_CHECKING:
    from pysprings.scene.load import Scene


@dataclass(frozen=True)
class EngineLaw:
    """A law of the engine, and how its parameters are packed from the values of a soil (numbers, or arrays)."""

    law: SoilLaw
    pack: Callable[[Any], np.ndarray]


def _friction(soil: Any) -> np.ndarray:
    return plasol.pack(
        young=soil.young_modulus,
        poisson=soil.poisson_ratio,
        phi_i=soil.friction_angle_initial,
        phi_f=soil.friction_angle_final,
        b_phi=soil.hardening_parameter,
        psi=soil.dilation_angle,
        cohesion=soil.cohesion,
    )


def _elastic(soil: Any) -> np.ndarray:
    return elastic.pack(young=soil.young_modulus, poisson=soil.poisson_ratio)


ENGINE_LAWS = {
    "drucker-prager": EngineLaw(plasol.LAW, _friction),
    "van-eekelen": EngineLaw(van_eekelen.LAW, _friction),
    "elastic": EngineLaw(elastic.LAW, _elastic),
}


def engine_laws(scene: Scene) -> list[SoilLaw]:
    """Return the engine's laws of a scene's layers."""
    return [ENGINE_LAWS[each.law].law for each in ground_of(scene).strata]


def soil_materials(scene: Scene, depth: np.ndarray) -> tuple[list[Material], np.ndarray]:
    """Return the materials of the layers, and the number of each element's, for depths (ne, np) in m of its points.

    Values are constant in a layer, or those of each point where one of them varies with depth.
    """
    strata = ground_of(scene).strata
    number = ground_of(scene).number(depth.mean(axis=1))
    found = []
    for k, stratum in enumerate(strata):
        chosen = ENGINE_LAWS[stratum.law]
        values: dict[str, Any] = dict(stratum.values)
        if any(isinstance(value, ByDepth) for value in values.values()):
            values = {name: stratum.value(name, depth[number == k]) for name in values}
        found.append(Material(chosen.law, chosen.pack(SimpleNamespace(**values))))
    return found, np.asarray(number, dtype=np.int64)
