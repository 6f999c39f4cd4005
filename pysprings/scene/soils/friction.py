# SPDX-License-Identifier: MIT
"""Frictional soils that harden: a cone, Van Eekelen's surface, cones in parallel; and elastic soil."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fe_engine.soil import formulas
from pysprings.core.units import show
from pysprings.scene.fields import Field, Number, Quantity
from pysprings.scene.positions import Clash
from pysprings.scene.soils.law import Soil, SoilLaw, engine_law

if TYPE_CHECKING:
    from pysprings.scene.ground import Stratum

MOST_FRICTION = math.radians(60.0)
MOST_CONTRACTION = 0.95  # of the shear modulus, lost to plastic contraction at constant volume
LEAST_STIFFNESS = 0.2  # of the initial one, where degradation_limit is not given
LEAST_PRESSURE = 1.0e4  # Pa, of the backbone of "iwan-sand": strains at a given share of the strength grow with it
_ANGLES = tuple(math.pi / 3.0 * i / 60.0 for i in range(61))  # Lode angles, from compression to extension
_FIRST_YIELD = 'friction angle at first yield; "auto" (default) is the least that holds the initial stress'
_HARDENS = "equivalent plastic strain at half of the hardening; 0.005 where not given"
_DEGRADES = "shear strain gamma_0.7 at which sand has 72.2 % of its initial secant shear modulus"
_LEFT = "share of the initial stiffness left at large strains (0.2 where not given)"
# phi: plastic silt to dense sand
STRENGTH: dict[str, Field] = {
    "friction_angle_initial": Quantity("deg", "[0, 60]", _FIRST_YIELD, "5 deg", word="auto"),
    "friction_angle_final": Quantity(
        "deg", "[0, 60]", "friction angle when fully hardened", "30 deg", common=(20.0, 46.0)
    ),
    "hardening_parameter": Number("[1e-9, 10]", _HARDENS, 0.005, common=(1e-5, 0.1)),
    "dilation_angle": Quantity("deg", "[-30, 60]", "dilation angle; 0 where not given", "5 deg", common=(-10.0, 20.0)),
    "cohesion": Quantity("kPa", "[0, 1e5]", "cohesion; 0 where not given", "5 kPa", common=(0.05, 100.0)),
}
DEGRADATION: dict[str, Field] = {
    "degradation_strain": Number("[1e-6, 0.1]", _DEGRADES, 2e-4, common=(3e-5, 2e-3), constant=True),
    "degradation_limit": Number("[0.01, 1]", _LEFT, 0.2, constant=True),
}


@dataclass(frozen=True)
class Surface:
    """Yield surface of a frictional soil by the Lode angle (0 in compression, pi/3 in extension).

    ``section`` (friction angle, Lode angle) -> radius over that in compression, and -d(its logarithm)/d(Lode angle).
    """

    section: Callable[[float, float], tuple[float, float]]
    angles: tuple[float, ...]


def _van_eekelen(phi: float, lode_angle: float) -> tuple[float, float]:
    b = formulas.shape(phi)
    cos3, sin3 = math.cos(3.0 * lode_angle), math.sin(3.0 * lode_angle)
    return formulas.section(b, cos3), formulas.turn(b, cos3, sin3)[0]


CONE = Surface(lambda phi, lode_angle: (1.0, 0.0), (0.0,))
VAN_EEKELEN = Surface(_van_eekelen, _ANGLES)


class DruckerPrager(SoilLaw):
    """PLASOL with a Drucker-Prager cone; the base of the other laws with friction."""

    name = "drucker-prager"
    keys: ClassVar[Mapping[str, Field]] = STRENGTH | DEGRADATION
    needs: ClassVar[tuple[str, ...]] = ("friction_angle_final", "effective_unit_weight", "K0")
    defaults: ClassVar[Mapping[str, Any]] = {
        "poisson_ratio": 0.3, "friction_angle_initial": "auto", "hardening_parameter": 0.005, "dilation_angle": 0.0,
        "cohesion": 0.0,
    }  # fmt: skip
    friction = "friction_angle_final"
    changes_stiffness = True
    surface = CONE
    holds = "friction_angle_initial"  # key of the angle whose surface must hold the initial stress

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        yield from self._angles(soil)
        if soil.friction_angle_final == 0.0 and soil.cohesion == 0.0:
            keys = ("soil", "friction_angle_final"), ("soil", "cohesion")
            yield Clash(keys, "a soil without friction and cohesion has no strength")
        yield from self._flow(soil)
        yield from self._initial(soil, stresses)

    def least_friction(self, k0: float) -> float:
        """Return the least friction angle (rad) for K0, by bisection: see `_initial`."""
        low, high = 0.0, MOST_FRICTION
        required = abs(1.0 - k0) / math.sqrt(3.0) / (1.0 + 2.0 * k0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            less = self.surface.section(middle, math.pi / 3.0)[0] if k0 > 1.0 else 1.0
            low, high = (middle, high) if less * formulas.cone_slope(math.sin(middle)) < required else (low, middle)
        return high

    def word(self, stratum: Stratum) -> str:
        return "following" if stratum.stiffness_changes else self.name

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        surface = engine_law(self.name)
        rows = surface.pack(
            young=soil.young_modulus, poisson=soil.poisson_ratio, phi_i=soil.friction_angle_initial,
            phi_f=soil.friction_angle_final, b_phi=soil.hardening_parameter, psi=soil.dilation_angle,
            cohesion=soil.cohesion,
        )  # fmt: skip
        if not stratum.stiffness_changes:
            return rows
        stress = soil.mean_effective_stress if stratum.exponent else 1.0
        strain, least = (getattr(soil, name, None) for name in DEGRADATION)
        return self.engine(stratum).pack(surface, rows, stress, stratum.exponent, strain, least or LEAST_STIFFNESS)

    def _angles(self, soil: Soil) -> Iterator[Clash]:
        """Check that no angle is more than the final one; "auto" stands here as the angle that K0 needs."""
        final = f"friction_angle_final ({show(soil.friction_angle_final, 'deg')})"
        for name in ("friction_angle_initial", "dilation_angle"):
            value = getattr(soil, name)
            if value <= soil.friction_angle_final:
                continue
            keys = ("soil", name), ("soil", "friction_angle_final")
            if name == "friction_angle_initial" and value == self.least_friction(soil.K0):
                text = f"{soil.K0:g} needs a friction angle of {math.degrees(value):.2f} deg, more than {final}"
                yield Clash((("soil", "K0"), *keys), text)
            else:
                yield Clash(keys, f"{show(value, 'deg')} must not be more than {final}")

    def _flow(self, soil: Soil) -> Iterator[Clash]:
        """Check that a contracting soil (dilation angle < 0) stays stable when its volume is held.

        The multiplier of the cone has the slope -(G + 9 K m m_psi) without hardening (`fe_engine.soil.plasol`): where
        it is not negative, the soil loses all strength at constant volume, and the return has two answers or none.
        """
        if self._lost(soil, soil.dilation_angle) <= MOST_CONTRACTION:
            return
        low, high = soil.dilation_angle, 0.0
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._lost(soil, middle) > MOST_CONTRACTION else (low, middle)
        keys = tuple(("soil", name) for name in ("dilation_angle", "poisson_ratio", "friction_angle_final"))
        what = f"Poisson ratio {soil.poisson_ratio:g} and {show(soil.friction_angle_final, 'deg')} of friction"
        least = f"with {what} at least {math.degrees(high):.2f} deg"
        yield Clash(keys, f"{show(soil.dilation_angle, 'deg')} is unstable: {least}")

    def _lost(self, soil: Soil, psi: float) -> float:
        """Return the share of G that plastic flow with a dilation angle (rad) takes at constant volume.

        -9 (K/G) m m_psi on the cone; on Van Eekelen's surface, where both slopes shrink by their sections, with
        -T T_psi of the flow across the meridian plane, at the worst Lode angle (`fe_engine.soil.van_eekelen`).
        """
        nu, phi = soil.poisson_ratio, soil.friction_angle_final
        slopes = formulas.cone_slope(math.sin(phi)) * formulas.cone_slope(math.sin(psi))
        cone = -6.0 * (1.0 + nu) / (1.0 - 2.0 * nu) * slopes
        worst = -math.inf
        for angle in self.surface.angles:
            (rho, turn), (rho_psi, turn_psi) = self.surface.section(phi, angle), self.surface.section(psi, angle)
            worst = max(worst, cone * rho * rho_psi - turn * turn_psi)
        return worst

    def _initial(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Check that the geostatic stress is inside the yield surface of the angle that `holds` it.

        With compression positive and the vertical stress s: II = |1 - K0| s/sqrt(3), I = (1 + 2 K0) s, and the
        surface is II = m I + 6 c cos(phi)/(sqrt(3) (3 - sin(phi))), m = 2 sin(phi)/(sqrt(3) (3 - sin(phi))). For K0 > 1
        (extension) m and the cohesive part shrink by the section of the surface.
        """
        names = ("K0", self.holds, "cohesion", "surcharge", "effective_unit_weight", "yield_surface")
        keys = (*(("soil", name) for name in names), ("domain", "depth"))
        bottom = stresses[1]
        if bottom == 0.0 and soil.cohesion == 0.0 and not soil.effective_unit_weight:
            yield Clash((("soil", "surcharge"), *keys), "a soil without weight, surcharge and cohesion has no strength")
        phi = float(getattr(soil, self.holds))
        sine, cosine = math.sin(phi), math.cos(phi)
        slope, strength = formulas.cone_slope(sine), formulas.cone_cohesion(sine, cosine, soil.cohesion)
        less = self.surface.section(phi, math.pi / 3.0)[0]
        reaches = math.sqrt(3.0) * slope, math.sqrt(3.0) * slope * less
        if soil.K0 > 1.0:
            slope, strength = less * slope, less * strength
        shear, pressure = abs(1.0 - soil.K0) / math.sqrt(3.0), 1.0 + 2.0 * soil.K0
        worst = max((shear - slope * pressure) * vertical for vertical in stresses)
        if worst > strength + 1e-9 * bottom:
            first = self.holds == "friction_angle_initial"
            allowed = f"({show(phi, 'deg')}{_range(*reaches, soil)})"
            text = f"{soil.K0:g} puts the initial stress outside the {'initial ' * first}yield surface {allowed}"
            least = math.degrees(self.least_friction(soil.K0))
            hint = f'; friction_angle_initial = "{math.ceil(100.0 * least) / 100.0:g} deg" or "auto" holds it'
            yield Clash(keys, text + (hint if first and least < math.degrees(soil.friction_angle_final) else ""))


def _range(compression: float, extension: float, soil: Soil) -> str:
    """Return the K0 that a cohesionless soil allows; sqrt(3) m in compression and in extension."""
    if soil.cohesion:
        return f", cohesion {show(soil.cohesion, 'kPa')}"
    low, high = (1.0 - compression) / (1.0 + 2.0 * compression), (1.0 + extension) / (1.0 - 2.0 * extension)
    return f" allows {low:.3f} to {high:.3f}"


class VanEekelen(DruckerPrager):
    """PLASOL with Van Eekelen's surface, convex up to a friction angle of 46.5 degrees."""

    name = "van-eekelen"
    surface = VAN_EEKELEN

    def _flow(self, soil: Soil) -> Iterator[Clash]:
        if soil.friction_angle_final > formulas.MAX_FRICTION:
            keys = ("soil", "friction_angle_final"), ("soil", "yield_surface")
            limit = f"Van Eekelen's surface is convex up to {show(formulas.MAX_FRICTION, 'deg')}"
            yield Clash(keys, f"{show(soil.friction_angle_final, 'deg')} is too much: {limit}")
            return
        yield from super()._flow(soil)


class IwanSand(DruckerPrager):
    """Cones in parallel: kinematic hardening without dilation."""

    name = "iwan-sand"
    keys = STRENGTH
    defaults: ClassVar[Mapping[str, Any]] = {
        **DruckerPrager.defaults,
        "friction_angle_initial": math.radians(5.0),  # need not hold the initial state
    }
    holds = "friction_angle_final"
    changes_stiffness = False
    by_stress = True

    def _flow(self, soil: Soil) -> Iterator[Clash]:
        if soil.dilation_angle != 0.0:
            text = f"{show(soil.dilation_angle, 'deg')} would change the volume in every cycle: it must be 0 deg"
            yield Clash((("soil", "dilation_angle"), ("soil", "yield_surface")), text)

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        pressure = np.maximum(soil.mean_effective_stress, LEAST_PRESSURE)
        return self.engine(stratum).pack(
            soil.young_modulus, soil.poisson_ratio, soil.friction_angle_initial, soil.friction_angle_final,
            soil.hardening_parameter, soil.cohesion, pressure,
        )  # fmt: skip


class Elastic(DruckerPrager):
    """Linear elastic soil; it still has a strength that checks read, and without K0 an isotropic initial stress."""

    name = "elastic"
    keys: ClassVar[Mapping[str, Field]] = {}
    unused = STRENGTH
    needs = ("effective_unit_weight",)
    defaults: ClassVar[Mapping[str, Any]] = {**DruckerPrager.defaults, "friction_angle_final": MOST_FRICTION, "K0": 1.0}
    friction = ""
    yields = changes_stiffness = False

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        yield from self._angles(soil)

    def least_friction(self, k0: float) -> float:
        return 0.0

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        return self.engine(stratum).pack(young=soil.young_modulus, poisson=soil.poisson_ratio)
