# SPDX-License-Identifier: MIT
"""Checks of undrained clay in total stress: strength, strain at half of it, and the initial state.

Total stress counts from the hydrostatic pressure of the water here, so that the initial vertical stress is the
effective one and K0 the ratio of effective stresses. Its shear must be within the strength.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo

from pysprings.core.units import quoted, show
from pysprings.scene.fields import Field, Interval, refuse
from pysprings.scene.positions import Clash

KEY = "shear_modulus_reduction"
LAW = "iwan-clay"
Pairs = tuple[tuple[float, float], ...]

MOST_POINTS = 10  # as `fe_engine.soil.iwan_clay`
_STRAINS, _RATIOS = "[1e-7, 0.5]", "(0, 1]"
_EXAMPLE = [[1e-5, 0.98], [1e-4, 0.83], [1e-3, 0.38], [1e-2, 0.07]]
_SAME_STRAIN = 1e-9
_FIRST = 1e-3  # share of the slope by which the backbone must bend at its first point: it begins with G_0


@dataclass(frozen=True)
class ReductionTable(Field):
    """Pairs of engineering shear strain and G/G_0: strains rise, ratios fall, the stress rises ever less steeply."""

    text: str

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if value is None:
            return value
        pairs = _pairs(value)
        faults = list(_faults(pairs))
        if faults:
            raise refuse("; ".join(faults))
        return tuple((float(strain), float(ratio)) for strain, ratio in pairs)

    def schema(self) -> dict[str, Any]:
        pair = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
        return {
            "description": f"{self.text} (strain in {_STRAINS}, G/G_0 in {_RATIOS})", "type": "array", "items": pair,
            "minItems": 2, "maxItems": MOST_POINTS, "examples": [_EXAMPLE],
        }  # fmt: skip

    def in_toml(self, value: Any) -> Any:
        return value if value is None else [list(pair) for pair in value]


Reduction = Annotated[
    Pairs | None,
    ReductionTable("backbone of iwan-clay: pairs of engineering shear strain and secant G/G_0, beside the stiffness"),
]


def _pairs(value: Any) -> list[tuple[float, float]]:
    """Return pairs of numbers; refuse what is none."""
    given = list(value) if isinstance(value, list | tuple) else []
    numbers = [_numbers(each) for each in given]
    if not 2 <= len(given) <= MOST_POINTS or any(each is None for each in numbers):
        raise refuse(f"expected 2 to {MOST_POINTS} pairs [shear strain, G/G_0] such as {_EXAMPLE}, got {quoted(value)}")
    return [each for each in numbers if each is not None]


def _numbers(pair: Any) -> tuple[float, float] | None:
    plain = isinstance(pair, list | tuple) and len(pair) == 2
    if not plain or any(isinstance(each, bool) or not isinstance(each, int | float) for each in pair):
        return None
    return float(pair[0]), float(pair[1])


def _faults(pairs: list[tuple[float, float]]) -> Iterator[str]:
    """Give what is wrong with pairs; those within their ranges are compared with each other."""
    outside = [
        f"row {number}: {name} {value:g} is not in {interval}"
        for number, pair in enumerate(pairs, 1)
        for name, value, interval in zip(("strain", "G/G_0"), pair, (_STRAINS, _RATIOS), strict=True)
        if not Interval(interval).holds(value)
    ]
    yield from outside
    if outside:
        return
    rows = list(enumerate(pairwise(pairs), 2))
    rising = [n for n, ((a, _), (b, _)) in rows if b <= a]
    yield from (f"row {n}: the strain must be more than that of the row before" for n in rising)
    if rising:
        return
    for n, ((a, r), (b, s)) in rows:
        if s > r:
            yield f"row {n}: G/G_0 must not be more than in the row before ({r:g})"
        elif b * s <= a * r:
            yield f"row {n}: the stress, G times strain, must be more than in the row before"
    slopes = _slopes(pairs)
    for n, (before, after) in enumerate(pairwise(slopes), 1):
        if after > before * (1.0 + (_SAME_STRAIN if n > 1 else -_FIRST)):
            text = f"row {n}: the stress must rise less steeply after it than before "
            yield f"{text}(slopes {before:.4g}, {after:.4g} G_0)"


def _slopes(pairs: list[tuple[float, float]]) -> NDArray[np.float64]:
    """Return the slopes over G_0 of the backbone from the origin to the first pair, and from pair to pair."""
    strain, ratio = np.array([(0.0, 1.0), *pairs]).T
    slopes: NDArray[np.float64] = np.diff(strain * ratio) / np.diff(strain)
    return slopes


def reduction_clashes(soil: Any) -> Iterator[Clash]:
    """Check that a table belongs to a law that has one, alone, and that its stresses are within the strength."""
    pairs = getattr(soil, KEY)
    if pairs is None:
        return
    if soil.yield_surface != LAW:
        yield Clash((("soil", KEY),), f'is not used by law "{soil.yield_surface}": only "{LAW}" has a table of G/G_0')
    if soil.strain_at_half_strength is not None:
        yield Clash((("soil", KEY), ("soil", "strain_at_half_strength")), "cannot be used with strain_at_half_strength")
    strain, ratio = pairs[-1]
    stress = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio)) * strain * ratio
    strength = soil.undrained_shear_strength
    if strength and stress > strength * (1.0 + _SAME_STRAIN):
        text = f"gives {stress / 1e3:.4g} kPa at a shear strain of {strain:g}, more than su ({show(strength, 'kPa')})"
        yield Clash((("soil", KEY), ("soil", "undrained_shear_strength"), ("soil", "rigidity_ratio")), text)


_ROUNDING = 1.0e-9
_ATMOSPHERE = 100.0e3  # Pa, p_a
ANISOTROPY_KEYS = ("compression_factor", "direct_shear_factor", "extension_factor")
# initial shear over |1 - K0| s'_v0, as each law measures it
TRESCA, VON_MISES = 0.5, 1.0 / math.sqrt(3.0)


def strength_clashes(soil: Any) -> Iterator[Clash]:
    """Check the strain at half of the strength, which is at least that of the elastic soil, su/(2 G)."""
    yield from _anisotropy_clashes(soil)
    yield from reduction_clashes(soil)
    half, strength = soil.strain_at_half_strength, soil.undrained_shear_strength
    shear = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio))
    if half is None or shear == 0.0:
        return
    least = 0.5 * strength / shear
    if half < least * (1.0 - _ROUNDING):
        keys = ("soil", "strain_at_half_strength"), ("soil", "rigidity_ratio"), ("soil", "undrained_shear_strength")
        yield Clash(keys, f"{half:g} must be at least su/(2 G), {least:.3g}: the soil is elastic below")


def small_strain_modulus(vertical_stress: Any, plasticity_index: Any, overconsolidation_ratio: Any) -> np.ndarray:
    """Return G_max (...,) in Pa of clay (Andersen 2015): p_a (s'_v0/p_a)^0.9 (30 + 75/(I_p/100 + 0.03)) OCR^0.5.

    ``vertical_stress`` s'_v0 in Pa, ``plasticity_index`` I_p in %.
    """
    factor = 30.0 + 75.0 / (np.asarray(plasticity_index) / 100.0 + 0.03)
    normalised = np.asarray(vertical_stress) / _ATMOSPHERE
    return np.asarray(_ATMOSPHERE * normalised**0.9 * factor * np.sqrt(overconsolidation_ratio))


def factors_of(values: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """Return su in compression, direct shear and extension over that of the soil; None where none is given."""
    given = [values.get(name) for name in ANISOTROPY_KEYS]
    if all(each is None for each in given):
        return None
    compression, direct, extension = (1.0 if each is None else float(each) for each in given)
    return compression, direct, extension


def _factors(soil: Any) -> tuple[float, float, float] | None:
    return factors_of({name: getattr(soil, name) for name in ANISOTROPY_KEYS})


def _anisotropy_clashes(soil: Any) -> Iterator[Clash]:
    """Check that factors of su belong to a law that has them, and are those of a surface."""
    factors = _factors(soil)
    if factors is None:
        return
    keys = tuple(("soil", name) for name in ANISOTROPY_KEYS if getattr(soil, name) is not None)
    if soil.yield_surface != "von-mises":
        yield Clash(keys, f'is not used by law "{soil.yield_surface}": su differs by direction in "von-mises" alone')
    if soil.strain_at_half_strength is not None:
        yield Clash((*keys, ("soil", "strain_at_half_strength")), "cannot be used with strain_at_half_strength")
    compression, direct, extension = factors
    if compression + extension <= direct:
        text = (
            f"compression and extension ({compression:g} + {extension:g}) must be more than direct shear ({direct:g})"
        )
        yield Clash(keys, text)


def triaxial_shares(compression: float, direct: float, extension: float) -> tuple[float, float]:
    """Return the strengths of triaxial compression and extension, in the unit of those given; see soil.anisotropic."""
    shift = 0.5 * (compression - extension)
    radius = math.sqrt(max(0.25 * (compression + extension) ** 2 - 0.25 * direct**2, 0.0))
    return radius + shift, radius - shift


def _rounded(stress: float) -> str:
    """Return a stress (Pa) with five digits."""
    return f"{1e-3 * stress:.5g} kPa"


def initial_shear(measure: float) -> Callable[[Any, tuple[float, float]], Iterator[Clash]]:
    """Make the check that the geostatic stress is within the strength; see `TRESCA` and `VON_MISES`."""

    def check(soil: Any, stresses: tuple[float, float]) -> Iterator[Clash]:
        strength, factors = soil.undrained_shear_strength, _factors(soil)
        if factors is not None:
            yield from _initial_anisotropic(soil, stresses, factors)
            return
        shear = measure * abs(1.0 - soil.K0) * max(stresses)
        most = strength if soil.strain_at_half_strength is None else strength * (1.0 - _ROUNDING)
        if shear > most + _ROUNDING * max(stresses):
            names = ("K0", "undrained_shear_strength", "surcharge")
            if soil.surcharge > 0.0 and max(stresses) <= soil.surcharge:  # at mudline
                names = ("surcharge", "undrained_shear_strength", "K0")
            keys = tuple(("soil", name) for name in names)
            yield Clash(keys, f"{_state(soil, stresses, shear)} into a soil of strength {_rounded(strength)}")

    return check


def _state(soil: Any, stresses: tuple[float, float], shear: float) -> str:
    """Return the beginning of a sentence on an initial shear stress [Pa], with what makes it."""
    vertical = f"a vertical effective stress of {_rounded(max(stresses))} (surcharge {_rounded(soil.surcharge)})"
    return f"K0 {soil.K0:g} with {vertical} puts an initial shear stress of {_rounded(shear)}"


def _initial_anisotropic(
    soil: Any, stresses: tuple[float, float], factors: tuple[float, float, float]
) -> Iterator[Clash]:
    """Check that the geostatic stress is between the triaxial strengths."""
    strength, shares = soil.undrained_shear_strength, triaxial_shares(*factors)
    shear = 0.5 * (1.0 - soil.K0) * max(stresses)  # compression with a vertical axis is positive
    low, high = -shares[1] * strength, shares[0] * strength
    slack = _ROUNDING * max(stresses)
    if not low - slack <= shear <= high + slack:
        names = ("K0", "undrained_shear_strength", "surcharge", *ANISOTROPY_KEYS)
        keys = tuple(("soil", name) for name in names if getattr(soil, name) is not None)
        allowed = f"triaxial strengths of {_rounded(low)} (extension) to {_rounded(high)}"
        yield Clash(keys, f"{_state(soil, stresses, shear)} into a soil with {allowed}")
