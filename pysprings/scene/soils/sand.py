# SPDX-License-Identifier: MIT
"""Sand by its relative density: strength and dilation of Bolton (1986), stiffness of Brinkgreve et al. (2010).

What a scene does not give follows from the relative density D_r:

    G_0       = (60 + 68 D_r) MPa (p'/100 kPa)^m,  m = 0.7 - D_r/3.2      Brinkgreve et al. 2010, of p'
    gamma_0.7 = (2 - D_r) 1e-4                                              the same
    B         = 0.024 exp(-2.2 (D_r - 0.5))          mobilisation_strain    fitted to 25 drained triaxial tests on
    F, C      = 0.2, 0.4                softening_strain, contraction       Karlsruhe fine sand (Wichtmann &
    n         = 4                                                           Triantafyllidis 2016)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fe_engine.soil import formulas
from pysprings.scene.fields import Field, Number, Quantity
from pysprings.scene.positions import Clash
from pysprings.scene.soils.friction import DEGRADATION, LEAST_STIFFNESS, MOST_CONTRACTION
from pysprings.scene.soils.law import Soil, SoilLaw, engine_law

if TYPE_CHECKING:
    from pysprings.scene.ground import Stratum

CRUSHING = 10.0  # Q of Bolton's index, quartz
EXPONENT = 4.0  # n
_MOST_MOBILISED = 0.95  # of sin(phi_t) in the initial state
_DENSITY = "relative density; strength, dilation and, where not given, stiffness follow from it"
_CRITICAL = "friction angle of the critical state in triaxial compression; 33 deg (quartz) where not given"
_MOBILISES = "plastic strain over which the strength is mobilised, B; by the density where not given"
_SOFTENS = "plastic strain over which peak and dilation fade to the critical state, F; 0.2 where not given"
_CONTRACTS = "plastic contraction over shear strain at first yield; 0.4 where not given"
_KEYS: dict[str, Field] = {
    "relative_density": Number("[0.01, 1.2]", _DENSITY, 0.7, common=(0.15, 1.0)),
    "critical_friction_angle": Quantity("deg", "[20, 40]", _CRITICAL, "33 deg", common=(29.0, 37.0)),
    "mobilisation_strain": Number("[1e-4, 0.5]", _MOBILISES, 0.015, common=(3e-3, 0.1)),
    "softening_strain": Number("[0.01, 1e3]", _SOFTENS, 0.2, common=(0.05, 0.5)),
    "contraction": Number("[0, 1.5]", _CONTRACTS, 0.4, common=(0.0, 1.0)),
}


class Sand(SoilLaw):
    """Sand that hardens, dilates to a peak and softens to the critical state, with small-strain stiffness."""

    name = "sand"
    keys: ClassVar[Mapping[str, Field]] = _KEYS | DEGRADATION
    defaults: ClassVar[Mapping[str, Any]] = {
        "poisson_ratio": 0.2, "critical_friction_angle": math.radians(33.0), "softening_strain": 0.2,
        "contraction": 0.4, "degradation_limit": LEAST_STIFFNESS,
    }  # fmt: skip
    needs = ("relative_density", "effective_unit_weight", "K0")
    friction = "critical_friction_angle"
    changes_stiffness = gives_stiffness = by_stress = True

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        if stresses[1] == 0.0 and not soil.effective_unit_weight:
            keys = ("soil", "surcharge"), ("soil", "effective_unit_weight")
            yield Clash(keys, "a soil without weight, surcharge and cohesion has no strength")
            return
        sine, pressure = _at_rest(soil.K0), (1.0 + 2.0 * soil.K0) / 3.0 * stresses[1]
        index = formulas.dilatancy_index(soil.relative_density, CRUSHING, pressure)
        most = soil.critical_friction_angle + formulas.PER_INDEX * index
        if sine > _MOST_MOBILISED * math.sin(most):
            angle, peak = math.degrees(math.asin(sine)), math.degrees(most)
            text = f"{soil.K0:g} mobilises {angle:.4g} deg of friction, of {peak:.3g} deg at the peak: too much"
            yield Clash((("soil", "K0"), ("soil", "relative_density")), text)
        # the largest share of G that contraction takes at constant volume, 9 (K/G) a m_psi over x: fe_engine.soil.sand,
        # at the largest friction angle that a falling p' gives
        most = soil.critical_friction_angle + formulas.PER_INDEX * formulas.MOST_INDEX
        share = 0.535 * soil.contraction / math.sqrt(3.0) * formulas.cone_slope(math.sin(most))
        lost = 2.0 * (1.0 + soil.poisson_ratio) / (1.0 - 2.0 * soil.poisson_ratio) * share
        if lost > MOST_CONTRACTION:
            least = soil.contraction * MOST_CONTRACTION / lost
            keys = ("soil", "contraction"), ("soil", "poisson_ratio")
            text = f"{soil.contraction:g} is unstable with Poisson ratio {soil.poisson_ratio:g}: at most {least:.3g}"
            yield Clash(keys, text)

    def shear_modulus(self, stratum: Stratum, depth: np.ndarray) -> np.ndarray:
        density = stratum.value("relative_density", depth)
        return np.asarray((60e6 + 68e6 * density) * (stratum.mean_stress(depth) / 1e5) ** _exponent(density))

    def exponent(self, stratum: Stratum) -> float:
        middle = np.array(0.5 * (stratum.top + stratum.bottom))
        return float(_exponent(stratum.value("relative_density", middle)))

    def derived(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        density = float(stratum.value("relative_density", depth))
        values = {"degradation_strain": _reference(density), "mobilisation_strain": float(mobilisation(density))}
        return {name: value for name, value in values.items() if name not in stratum.values}

    def shown(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        density, critical = (float(stratum.value(name, depth)) for name in ("relative_density", self.friction))
        index = formulas.dilatancy_index(density, CRUSHING, float(stratum.mean_stress(depth)))
        peak = math.degrees(critical + formulas.PER_INDEX * index)
        return {"relative_density": density, "dilatancy_index": index, "peak_friction_angle_deg": peak}

    def word(self, stratum: Stratum) -> str:
        return "following"

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        density, critical, surface = soil.relative_density, soil.critical_friction_angle, engine_law(self.name)
        scale = getattr(soil, "mobilisation_strain", None)
        scale = mobilisation(density) if scale is None else scale
        index = np.vectorize(formulas.dilatancy_index)(density, CRUSHING, soil.mean_effective_stress)
        share = np.minimum(_at_rest(soil.K0) / np.sin(critical + formulas.PER_INDEX * index), _MOST_MOBILISED)
        start = -scale * np.log1p(-(share**EXPONENT))  # e_0, from x^n = 1 - exp(-e/B) of the initial state
        rows = surface.pack(
            soil.young_modulus, soil.poisson_ratio, critical, density, CRUSHING, EXPONENT, scale,
            soil.softening_strain, soil.contraction, start,
        )  # fmt: skip
        given = getattr(soil, "degradation_strain", None)
        strain, exponent = _reference(density) if given is None else given, stratum.exponent
        if not {"young_modulus", "shear_modulus"} & {*stratum.values}:
            exponent = _exponent(density)
        pressure = np.maximum(soil.mean_effective_stress, 1.0)
        return self.engine(stratum).pack(surface, rows, pressure, exponent, strain, soil.degradation_limit)


def _at_rest(k0: Any) -> Any:
    """Return sin of the friction angle that the initial state mobilises, the same in compression and extension."""
    return np.abs(1.0 - k0) / (1.0 + k0)


def _exponent(density: Any) -> Any:
    return 0.7 - density / 3.2


def _reference(density: Any) -> Any:
    return (2.0 - density) * 1e-4


def mobilisation(density: Any) -> Any:
    """Return B of a relative density where a scene gives none."""
    return 0.024 * np.exp(-2.2 * (density - 0.5))
