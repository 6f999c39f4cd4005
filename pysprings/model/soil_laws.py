# SPDX-License-Identifier: MIT
"""The engine's law, and its parameters, of each word of `soil.yield_surface`; see `pysprings.scene.soil_laws`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from fe_engine.material import Material
from fe_engine.soil import (
    anisotropic,
    elastic,
    following,
    iwan_clay,
    iwan_sand,
    mobilised,
    plasol,
    tresca,
    van_eekelen,
    von_mises,
)
from fe_engine.soil.law import SoilLaw
from pysprings.scene.clay_laws import KEY as REDUCTION
from pysprings.scene.clay_laws import TRESCA, VON_MISES
from pysprings.scene.ground import Stratum
from pysprings.scene.soil_laws import DEGRADATION_KEYS

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

LEAST_PRESSURE = 1.0e4  # Pa, of the backbone of "iwan-sand": strains at a given share of the strength grow with it
LEAST_STIFFNESS = 0.2  # of the initial one, where degradation_limit is not given


@dataclass(frozen=True)
class EngineLaw:
    """A law of the engine, and how its parameters are packed from the values of a soil (numbers, or arrays).

    by_stress : whether the parameters follow the initial stress, so that they differ from point to point.
    """

    law: SoilLaw
    pack: Callable[[Any], np.ndarray]
    by_stress: bool = False


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


def _clay(measure: float) -> Callable[[Any], np.ndarray]:
    """Make the packing of a clay law, which measures the initial shear stress by ``measure`` |1 - K0| s'_v0."""

    def pack(soil: Any) -> np.ndarray:
        young, poisson, strength = soil.young_modulus, soil.poisson_ratio, soil.undrained_shear_strength
        half = getattr(soil, "strain_at_half_strength", None)
        if half is None:
            return mobilised.pack(young, poisson, strength)
        scale = mobilised.scale_of(half, strength, young / (2.0 * (1.0 + poisson)))
        shear = measure * np.abs(1.0 - soil.K0) * soil.vertical_effective_stress
        return mobilised.pack(young, poisson, strength, np.maximum(scale, 0.0), shear / strength)

    return pack


def _iwan_clay(soil: Any) -> np.ndarray:
    young, poisson, strength = soil.young_modulus, soil.poisson_ratio, soil.undrained_shear_strength
    if (table := getattr(soil, REDUCTION, None)) is not None:
        return iwan_clay.pack_table(young, poisson, strength, *np.array(table).T)
    shear = young / (2.0 * (1.0 + poisson))
    half = getattr(soil, "strain_at_half_strength", None)
    scale = strength / shear if half is None else np.maximum(mobilised.scale_of(half, strength, shear), 0.0)
    return iwan_clay.pack(young, poisson, strength, scale)


def _iwan_sand(soil: Any) -> np.ndarray:
    return iwan_sand.pack(
        young=soil.young_modulus,
        poisson=soil.poisson_ratio,
        phi_i=soil.friction_angle_initial,
        phi_f=soil.friction_angle_final,
        b_phi=soil.hardening_parameter,
        cohesion=soil.cohesion,
        pressure=np.maximum((1.0 + 2.0 * soil.K0) / 3.0 * soil.vertical_effective_stress, LEAST_PRESSURE),
    )


ENGINE_LAWS = {
    "drucker-prager": EngineLaw(plasol.LAW, _friction),
    "van-eekelen": EngineLaw(van_eekelen.LAW, _friction),
    "elastic": EngineLaw(elastic.LAW, _elastic),
    "tresca": EngineLaw(tresca.LAW, _clay(TRESCA)),
    "von-mises": EngineLaw(von_mises.LAW, _clay(VON_MISES)),
    "iwan-clay": EngineLaw(iwan_clay.LAW, _iwan_clay),
    "iwan-sand": EngineLaw(iwan_sand.LAW, _iwan_sand, by_stress=True),
}


def engine_laws(scene: Scene) -> list[SoilLaw]:
    """Return the engine's laws of a scene's layers."""
    return [_engine_law(each) for each in scene.ground.strata]


def _engine_law(stratum: Stratum) -> SoilLaw:
    """Return the law of a layer: that of its word, or the one whose stiffness changes or whose su has directions."""
    if stratum.factors is not None:
        return anisotropic.LAW
    return following.LAW if stratum.stiffness_changes else ENGINE_LAWS[stratum.law].law


def soil_materials(scene: Scene, depth: np.ndarray) -> tuple[list[Material], np.ndarray]:
    """Return the materials of the layers, and the number of each element's, for depths (ne, np) in m of its points.

    Values are constant in a layer, or those of each point where one of them varies with depth.
    """
    strata = scene.ground.strata
    number = scene.ground.number(depth.mean(axis=1))
    materials = []
    for k, stratum in enumerate(strata):
        materials.append(Material(_engine_law(stratum), _packed(stratum, depth[number == k])))
    return materials, np.asarray(number, dtype=np.int64)


def _packed(stratum: Stratum, depth: np.ndarray) -> np.ndarray:
    """Return the packed parameters of a layer for depths (k, np) of its points."""
    chosen, values = ENGINE_LAWS[stratum.law], _values(stratum, depth)
    if stratum.factors is not None:
        strengths = (values.undrained_shear_strength * factor for factor in stratum.factors)
        return anisotropic.pack(values.young_modulus, values.poisson_ratio, *strengths)
    rows = chosen.pack(values)
    if not stratum.stiffness_changes:
        return rows
    stress = stratum.mean_stress(depth) if stratum.exponent else 1.0
    strain, least = (stratum.values.get(name) for name in DEGRADATION_KEYS)
    return following.pack(chosen.law, rows, stress, stratum.exponent, strain, least or LEAST_STIFFNESS)  # type: ignore[arg-type]


def _values(stratum: Stratum, depth: np.ndarray) -> SimpleNamespace:
    """Return the values of a layer as numbers, or as arrays (k, np) of its points where one of them varies."""
    names = [*stratum.values, "young_modulus"]
    # what is mobilised follows the stress
    if stratum.varies or ENGINE_LAWS[stratum.law].by_stress or "strain_at_half_strength" in stratum.values:
        values: dict[str, Any] = {name: stratum.value(name, depth) for name in names}
        values |= {REDUCTION: stratum.reduction, "vertical_effective_stress": stratum.vertical_stress(depth)}
        return SimpleNamespace(**values)
    constant: dict[str, Any] = {name: float(stratum.value(name, np.array(0.0))) for name in names}
    return SimpleNamespace(**constant | {REDUCTION: stratum.reduction})
