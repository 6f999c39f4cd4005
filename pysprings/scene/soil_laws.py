# SPDX-License-Identifier: MIT
"""Soil laws as a scene names them: the keys that each uses, and what their values must meet together.

The engine's law of the same name is found in `pysprings.model.soil_laws`. A new law is one entry in each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from fe_engine.soil import formulas
from pysprings.core.units import show
from pysprings.scene.clay_laws import ANISOTROPY_KEYS, TRESCA, VON_MISES, initial_shear, strength_clashes
from pysprings.scene.positions import Clash

MOST_FRICTION = math.radians(60.0)
MOST_CONTRACTION = 0.95  # of the shear modulus, lost to plastic contraction at constant volume
_ANGLES = tuple(math.pi / 3.0 * i / 60.0 for i in range(61))  # Lode angles, from compression to extension


Soil = Any
"""Uniform values of a soil that its law judges, in SI, by the keys of a scene (`scene.layers.uniform_soils`)."""

# values of keys of a frictional soil that are not given
_FRICTIONAL: dict[str, Any] = {
    "poisson_ratio": 0.3, "friction_angle_initial": "auto", "hardening_parameter": 0.005, "dilation_angle": 0.0,
    "cohesion": 0.0,
}  # fmt: skip


@dataclass(frozen=True)
class SoilLaw:
    """A soil law of the scene.

    Attributes
    ----------
    name : its word in `soil.yield_surface`.
    keys : keys of [soil] that set its strength; the others' are not used.
    clashes : give what does not go together in a soil.
    initial : give what is wrong with its initial state, between two vertical effective stresses (Pa).
    least_friction : K0 -> least initial friction angle (rad) that holds the geostatic stress without cohesion.
    yields : whether the soil can yield.
    total_stress : whether it is undrained clay in total stress, which has no pore pressure as unknown.
    needs : keys of the initial state and the strength that have no default.
    defaults : values of keys that are not given.
    """

    name: str
    keys: tuple[str, ...]
    clashes: Callable[[Soil], Iterator[Clash]]
    initial: Callable[[Soil, tuple[float, float]], Iterator[Clash]]
    least_friction: Callable[[float], float]
    yields: bool = True
    total_stress: bool = False
    needs: tuple[str, ...] = ("friction_angle_final", "effective_unit_weight", "K0")
    defaults: Mapping[str, Any] = field(default_factory=lambda: dict(_FRICTIONAL))

    @property
    def changes_stiffness(self) -> bool:
        """Whether its stiffness may follow the stress and degrade with strain."""
        return DEGRADATION_KEYS[0] in self.keys


@dataclass(frozen=True)
class Surface:
    """Yield surface of a frictional soil by the Lode angle (0 in compression, pi/3 in extension).

    ``section`` (friction angle, Lode angle) -> radius over that in compression, and -d(its logarithm)/d(Lode angle).
    """

    section: Callable[[float, float], tuple[float, float]]
    angles: tuple[float, ...]


def _round(phi: float, lode_angle: float) -> tuple[float, float]:
    return 1.0, 0.0


def _van_eekelen(phi: float, lode_angle: float) -> tuple[float, float]:
    b = formulas.shape(phi)
    cos3, sin3 = math.cos(3.0 * lode_angle), math.sin(3.0 * lode_angle)
    return formulas.section(b, cos3), formulas.turn(b, cos3, sin3)[0]


CONE = Surface(_round, (0.0,))
VAN_EEKELEN = Surface(_van_eekelen, _ANGLES)


def _angles(soil: Soil, surface: Surface) -> Iterator[Clash]:
    """Check that no angle is more than the final friction angle; "auto" stands here as the angle that K0 needs."""
    final = f"friction_angle_final ({show(soil.friction_angle_final, 'deg')})"
    for name in ("friction_angle_initial", "dilation_angle"):
        value = getattr(soil, name)
        if value <= soil.friction_angle_final:
            continue
        if name == "friction_angle_initial" and value == _least_friction(surface)(soil.K0):
            keys = tuple(("soil", each) for each in ("K0", name, "friction_angle_final"))
            yield Clash(keys, f"{soil.K0:g} needs a friction angle of {math.degrees(value):.2f} deg, more than {final}")
        else:
            keys = ("soil", name), ("soil", "friction_angle_final")
            yield Clash(keys, f"{show(value, 'deg')} must not be more than {final}")


def _strength(soil: Soil) -> Iterator[Clash]:
    if soil.friction_angle_final == 0.0 and soil.cohesion == 0.0:
        keys = ("soil", "friction_angle_final"), ("soil", "cohesion")
        yield Clash(keys, "a soil without friction and cohesion has no strength")


def _elastic_clashes(soil: Soil) -> Iterator[Clash]:
    yield from _angles(soil, CONE)


def _cone_clashes(soil: Soil) -> Iterator[Clash]:
    yield from _angles(soil, CONE)
    yield from _strength(soil)
    yield from _contraction(soil, CONE)


def _van_eekelen_clashes(soil: Soil) -> Iterator[Clash]:
    yield from _angles(soil, VAN_EEKELEN)
    yield from _strength(soil)
    if soil.friction_angle_final > formulas.MAX_FRICTION:
        keys = ("soil", "friction_angle_final"), ("soil", "yield_surface")
        limit = f"Van Eekelen's surface is convex up to {show(formulas.MAX_FRICTION, 'deg')}"
        yield Clash(keys, f"{show(soil.friction_angle_final, 'deg')} is too much: {limit}")
        return
    yield from _contraction(soil, VAN_EEKELEN)


def _iwan_sand_clashes(soil: Soil) -> Iterator[Clash]:
    yield from _angles(soil, CONE)
    yield from _strength(soil)
    if soil.dilation_angle != 0.0:
        text = f"{show(soil.dilation_angle, 'deg')} would change the volume in every cycle: it must be 0 deg"
        yield Clash((("soil", "dilation_angle"), ("soil", "yield_surface")), text)


def _contraction(soil: Soil, surface: Surface) -> Iterator[Clash]:
    """Check that a contracting soil (dilation angle < 0) stays stable when its volume is held.

    The multiplier of the cone has the slope -(G + 9 K m m_psi) without hardening (`fe_engine.soil.plasol`): where it
    is not negative, the soil loses all strength at constant volume, and the return to the cone has two answers or none.
    """
    if _lost(soil, soil.dilation_angle, surface) <= MOST_CONTRACTION:
        return
    low, high = soil.dilation_angle, 0.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _lost(soil, middle, surface) > MOST_CONTRACTION else (low, middle)
    angle = math.degrees(high)
    keys = tuple(("soil", name) for name in ("dilation_angle", "poisson_ratio", "friction_angle_final"))
    with_these = f"Poisson ratio {soil.poisson_ratio:g} and {show(soil.friction_angle_final, 'deg')} of friction"
    yield Clash(keys, f"{show(soil.dilation_angle, 'deg')} is unstable: with {with_these} at least {angle:.2f} deg")


def _lost(soil: Soil, psi: float, surface: Surface) -> float:
    """Return the share of the shear modulus that plastic flow with this dilation angle (rad) takes at constant volume.

    -9 (K/G) m m_psi on the cone; on Van Eekelen's surface, where both slopes shrink by their sections, with -T T_psi of
    the flow across the meridian plane, at the worst Lode angle (`fe_engine.soil.van_eekelen`).
    """
    nu, phi = soil.poisson_ratio, soil.friction_angle_final
    slopes = formulas.cone_slope(math.sin(phi)) * formulas.cone_slope(math.sin(psi))
    cone = -6.0 * (1.0 + nu) / (1.0 - 2.0 * nu) * slopes
    worst = -math.inf
    for angle in surface.angles:
        (rho, turn), (rho_psi, turn_psi) = surface.section(phi, angle), surface.section(psi, angle)
        worst = max(worst, cone * rho * rho_psi - turn * turn_psi)
    return worst


def _initial_state(
    surface: Surface, angle: str = "friction_angle_initial"
) -> Callable[[Soil, tuple[float, float]], Iterator[Clash]]:
    """Make the check that the geostatic stress is inside the yield surface of the friction angle of that key.

    With compression positive and the vertical stress s: II = |1 - K0| s/sqrt(3), I = (1 + 2 K0) s, and the
    surface is II = m I + 6 c cos(phi)/(sqrt(3) (3 - sin(phi))), m = 2 sin(phi)/(sqrt(3) (3 - sin(phi))). For K0 > 1
    (extension) m and the cohesive part shrink by the section of the surface.
    """

    def check(soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        names = ("K0", angle, "cohesion", "surcharge", "effective_unit_weight", "yield_surface")
        keys = (*(("soil", name) for name in names), ("domain", "depth"))
        bottom = stresses[1]
        if bottom == 0.0 and soil.cohesion == 0.0 and not soil.effective_unit_weight:
            yield Clash((("soil", "surcharge"), *keys), "a soil without weight, surcharge and cohesion has no strength")
        phi = float(getattr(soil, angle))
        sine, cosine = math.sin(phi), math.cos(phi)
        slope, strength = formulas.cone_slope(sine), formulas.cone_cohesion(sine, cosine, soil.cohesion)
        less = surface.section(phi, math.pi / 3.0)[0]
        reaches = math.sqrt(3.0) * slope, math.sqrt(3.0) * slope * less
        if soil.K0 > 1.0:
            slope, strength = less * slope, less * strength
        shear, pressure = abs(1.0 - soil.K0) / math.sqrt(3.0), 1.0 + 2.0 * soil.K0
        worst = max((shear - slope * pressure) * vertical for vertical in stresses)
        if worst > strength + 1e-9 * bottom:
            first = angle == "friction_angle_initial"
            allowed = f"({show(phi, 'deg')}{_range(*reaches, soil)})"
            text = f"{soil.K0:g} puts the initial stress outside the {'initial ' * first}yield surface {allowed}"
            least = math.degrees(_least_friction(surface)(soil.K0))
            hint = f'; friction_angle_initial = "{math.ceil(100.0 * least) / 100.0:g} deg" or "auto" holds it'
            yield Clash(keys, text + (hint if first and least < math.degrees(soil.friction_angle_final) else ""))

    return check


def _least_friction(surface: Surface) -> Callable[[float], float]:
    """Make the least friction angle (rad) for K0, by bisection: see `_initial_state`."""

    def least(k0: float) -> float:
        low, high = 0.0, MOST_FRICTION
        required = abs(1.0 - k0) / math.sqrt(3.0) / (1.0 + 2.0 * k0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            less = surface.section(middle, math.pi / 3.0)[0] if k0 > 1.0 else 1.0
            low, high = (middle, high) if less * formulas.cone_slope(math.sin(middle)) < required else (low, middle)
        return high

    return least


def _range(compression: float, extension: float, soil: Soil) -> str:
    """Return the K0 that a cohesionless soil allows; sqrt(3) m in compression and in extension."""
    if soil.cohesion:
        return f", cohesion {show(soil.cohesion, 'kPa')}"
    low, high = (1.0 - compression) / (1.0 + 2.0 * compression), (1.0 + extension) / (1.0 - 2.0 * extension)
    return f" allows {low:.3f} to {high:.3f}"


def _nothing(*_: object) -> Iterator[Clash]:
    return iter(())


STIFFNESSES = ("young_modulus", "shear_modulus", "rigidity_ratio", "plasticity_index")  # the last two of clay alone
DEGRADATION_KEYS = ("degradation_strain", "degradation_limit")
STRENGTH_KEYS = ("friction_angle_initial", "friction_angle_final", "hardening_parameter", "dilation_angle", "cohesion")
FRICTION_KEYS = (*STRENGTH_KEYS, *DEGRADATION_KEYS)
CLAY_KEYS = (
    "undrained_shear_strength", "rigidity_ratio", "plasticity_index", "overconsolidation_ratio",
    "strain_at_half_strength", "shear_modulus_reduction", *ANISOTROPY_KEYS,
)  # fmt: skip
_IWAN = {**_FRICTIONAL, "friction_angle_initial": math.radians(5.0)}  # need not hold the initial stress
# an elastic soil still has a strength that checks read; without K0 the initial stress is isotropic
_ELASTIC = {**_FRICTIONAL, "friction_angle_final": MOST_FRICTION, "K0": 1.0}
_CLAY = {"poisson_ratio": 0.495, "K0": 1.0}  # almost constant volume; elements do not lock there


def _clay(name: str, measure: float) -> SoilLaw:
    check = initial_shear(measure)
    return SoilLaw(name, CLAY_KEYS, strength_clashes, check, lambda k0: 0.0, total_stress=True,
                   needs=("undrained_shear_strength", "effective_unit_weight"), defaults=_CLAY)  # fmt: skip


SOIL_LAWS = {
    law.name: law
    for law in (
        SoilLaw(
            "drucker-prager",
            FRICTION_KEYS,
            _cone_clashes,
            _initial_state(CONE),
            _least_friction(CONE),
        ),
        SoilLaw(
            "van-eekelen",
            FRICTION_KEYS,
            _van_eekelen_clashes,
            _initial_state(VAN_EEKELEN),
            _least_friction(VAN_EEKELEN),
        ),
        SoilLaw(
            "elastic",
            (),
            _elastic_clashes,
            _nothing,
            lambda k0: 0.0,
            yields=False,
            needs=("effective_unit_weight",),
            defaults=_ELASTIC,
        ),
        _clay("tresca", TRESCA),
        _clay("von-mises", VON_MISES),
        _clay("iwan-clay", VON_MISES),
        SoilLaw(
            "iwan-sand",
            STRENGTH_KEYS,
            _iwan_sand_clashes,
            _initial_state(CONE, "friction_angle_final"),
            _least_friction(CONE),
            defaults=_IWAN,
        ),
    )
}
