# SPDX-License-Identifier: MIT
"""Undrained clay in total stress: Tresca, von Mises with su by direction, and von Mises elements in parallel.

Total stress counts from the hydrostatic pressure of the water here, so that the initial vertical stress is the
effective one and K0 the ratio of effective stresses. Its shear must be within the strength.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import ValidationInfo

from pysprings.core.units import quoted, show
from pysprings.scene.by_depth import Profile
from pysprings.scene.fields import Field, Interval, Number, Quantity, refuse
from pysprings.scene.positions import Clash
from pysprings.scene.soils.cyclic import CYCLIC, CyclicTable
from pysprings.scene.soils.law import Soil, SoilLaw

if TYPE_CHECKING:
    from pysprings.scene.ground import Stratum

REDUCTION = "shear_modulus_reduction"
TABLES = (REDUCTION, CYCLIC)  # of a layer, beside its numbers
FACTORS = ("compression_factor", "direct_shear_factor", "extension_factor")

MOST_POINTS = 10  # as `fe_engine.soil.iwan_clay`
_STRAINS, _RATIOS = "[1e-7, 0.5]", "(0, 1]"
_EXAMPLE = [[1e-5, 0.98], [1e-4, 0.83], [1e-3, 0.38], [1e-2, 0.07]]
_SAME_STRAIN = 1e-9
_FIRST = 1e-3  # share of the slope by which the backbone must bend at its first point: it begins with G_0
_ROUNDING = 1.0e-9
_ATMOSPHERE = 100.0e3  # Pa, p_a


@dataclass(frozen=True)
class ReductionTable(Field):
    """Pairs of engineering shear strain and G/G_0: strains rise, ratios fall, the stress rises ever less steeply."""

    text: str

    def validate(self, value: Any, info: ValidationInfo) -> Any:
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
    strain, ratio = np.array([(0.0, 1.0), *pairs]).T
    slopes = np.diff(strain * ratio) / np.diff(strain)  # over G_0, of the backbone from the origin on
    for n, (before, after) in enumerate(pairwise(slopes), 1):
        if after > before * (1.0 + (_SAME_STRAIN if n > 1 else -_FIRST)):
            text = f"row {n}: the stress must rise less steeply after it than before "
            yield f"{text}(slopes {before:.4g}, {after:.4g} G_0)"


def small_strain_modulus(vertical_stress: Any, plasticity_index: Any, overconsolidation_ratio: Any) -> np.ndarray:
    """Return G_max (...,) in Pa of clay (Andersen 2015): p_a (s'_v0/p_a)^0.9 (30 + 75/(I_p/100 + 0.03)) OCR^0.5.

    ``vertical_stress`` s'_v0 in Pa, ``plasticity_index`` I_p in %.
    """
    factor = 30.0 + 75.0 / (np.asarray(plasticity_index) / 100.0 + 0.03)
    normalised = np.asarray(vertical_stress) / _ATMOSPHERE
    return np.asarray(_ATMOSPHERE * normalised**0.9 * factor * np.sqrt(overconsolidation_ratio))


def factors_of(values: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """Return su in compression, direct shear and extension over that of the soil; None where none is given."""
    given = [values.get(name) for name in FACTORS]
    if all(each is None for each in given):
        return None
    compression, direct, extension = (1.0 if each is None else float(each) for each in given)
    return compression, direct, extension


def triaxial_shares(compression: float, direct: float, extension: float) -> tuple[float, float]:
    """Return the strengths of triaxial compression and extension, in the unit of those given; see soil.anisotropic."""
    shift = 0.5 * (compression - extension)
    radius = math.sqrt(max(0.25 * (compression + extension) ** 2 - 0.25 * direct**2, 0.0))
    return radius + shift, radius - shift


# su: from normally consolidated clay to stiff clay, beyond 300 kPa is rock
_SU_TEXT = "undrained shear strength: any test for tresca, plane strain or DSS for von-mises"
_SU = Quantity("kPa", "[0, 1e5]", _SU_TEXT, "5 kPa", common=(0.5, 300.0))
_RIGIDITY = Number("[1, 1e5]", "shear modulus over su, instead of young_modulus", 200.0)
_INDEX_TEXT = "plasticity index in %; gives small-strain G of clay, with overconsolidation_ratio"
_INDEX = Number("[0, 160]", _INDEX_TEXT, 40.0, common=(5.0, 130.0))
OCR = Number("[1, 40]", "overconsolidation ratio, 1 where not given; beside plasticity_index", 1.5)
_HALF_TEXT = "engineering shear strain at su/2 (1.5 eps50 of a triaxial test)"
_HALF = Number("[1e-6, 0.5]", _HALF_TEXT, 0.01, common=(1e-3, 0.06))
_TABLE = "backbone of iwan-clay: pairs of engineering shear strain and secant G/G_0, beside the stiffness"
_CYCLIC = "backbone of iwan-clay from contours of cyclic tests at a number of cycles and tau_a/su, beside the stiffness"
CLAY: dict[str, Field] = {
    "undrained_shear_strength": Profile(_SU), "rigidity_ratio": Profile(_RIGIDITY), "plasticity_index": Profile(_INDEX),
    "overconsolidation_ratio": Profile(OCR), "strain_at_half_strength": Profile(_HALF),
}  # fmt: skip


def _factor(what: str, example: float, common: tuple[float, float]) -> Number:
    return Number("[0.1, 5]", f"su in {what} over undrained_shear_strength", example, common=common, constant=True)


class Tresca(SoilLaw):
    """Tresca's surface; the base of the other laws of clay."""

    name = "tresca"
    keys: ClassVar[Mapping[str, Field]] = CLAY
    needs = ("undrained_shear_strength", "effective_unit_weight")
    defaults: ClassVar[Mapping[str, Any]] = {
        "poisson_ratio": 0.495,
        "K0": 1.0,
    }  # almost constant volume; elements do not lock there
    stiffnesses = ("rigidity_ratio", "shear_modulus", "young_modulus", "plasticity_index")
    cap = "undrained_shear_strength"
    total_stress = True
    measure = 0.5  # initial shear over |1 - K0| s'_v0, as the law measures it

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Check the strain at half of the strength, at least that of the elastic soil, su/(2 G), and the state."""
        half, strength = soil.strain_at_half_strength, soil.undrained_shear_strength
        shear = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio))
        if half is not None and shear > 0.0 and half < (least := 0.5 * strength / shear) * (1.0 - _ROUNDING):
            names = ("strain_at_half_strength", "rigidity_ratio", "undrained_shear_strength")
            of = f"{least:.3g} of su {_rounded(strength)} and G {_rounded(shear)}"
            text = f"{half:g} must be at least su/(2 G), {of}: the soil is elastic below"
            yield Clash(tuple(("soil", name) for name in names), text)
        yield from self._initial(soil, stresses)

    def shear_modulus(self, stratum: Stratum, depth: np.ndarray) -> np.ndarray:
        if "plasticity_index" not in stratum.values:
            return stratum.value("rigidity_ratio", depth) * stratum.value("undrained_shear_strength", depth)
        given = "overconsolidation_ratio" in stratum.values
        ratio = stratum.value("overconsolidation_ratio", depth) if given else 1.0
        return small_strain_modulus(stratum.vertical_stress(depth), stratum.value("plasticity_index", depth), ratio)

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        from fe_engine.soil import mobilised

        young, poisson, strength = soil.young_modulus, soil.poisson_ratio, soil.undrained_shear_strength
        half = getattr(soil, "strain_at_half_strength", None)
        if half is None:
            return mobilised.pack(young, poisson, strength)
        scale = mobilised.scale_of(half, strength, young / (2.0 * (1.0 + poisson)))
        shear = self.measure * np.abs(1.0 - soil.K0) * soil.vertical_effective_stress
        return mobilised.pack(young, poisson, strength, np.maximum(scale, 0.0), shear / strength)

    def strength(self, soil: Soil) -> float:
        """Return the largest shear stress (Pa) of simple shear."""
        return float(soil.undrained_shear_strength)

    def _initial(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Check that the geostatic stress is within the strength, of a law that mobilises it below the strength."""
        strength = self.strength(soil)
        shear = self.measure * abs(1.0 - soil.K0) * max(stresses)
        slack = _ROUNDING * max(stresses)
        if shear > strength + (slack if soil.strain_at_half_strength is None else -slack):
            names = ("K0", "undrained_shear_strength", "surcharge")
            if soil.surcharge > 0.0 and max(stresses) <= soil.surcharge:  # at mudline
                names = ("surcharge", "undrained_shear_strength", "K0")
            keys = tuple(("soil", name) for name in names)
            yield Clash(keys, f"{_state(soil, stresses, shear)} into a soil of strength {_rounded(strength)}")


def _rounded(stress: float) -> str:
    """Return a stress (Pa) with five digits."""
    return f"{1e-3 * stress:.5g} kPa"


def _state(soil: Soil, stresses: tuple[float, float], shear: float) -> str:
    """Return the beginning of a sentence on an initial shear stress [Pa], with what makes it."""
    vertical = f"a vertical effective stress of {_rounded(max(stresses))} (surcharge {_rounded(soil.surcharge)})"
    return f"K0 {soil.K0:g} with {vertical} puts an initial shear stress of {_rounded(shear)}"


class VonMises(Tresca):
    """Von Mises cylinder, or, with factors of su by direction, an ellipsoid that prefers the vertical."""

    name = "von-mises"
    keys: ClassVar[Mapping[str, Field]] = CLAY | {
        "compression_factor": _factor("plane strain compression", 1.3, (0.7, 1.8)),
        "direct_shear_factor": _factor("direct simple shear", 1.0, (0.6, 1.4)),
        "extension_factor": _factor("plane strain extension", 0.7, (0.3, 1.2)),
    }
    measure = 1.0 / math.sqrt(3.0)
    hardens = False  # with factors by direction

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        if (factors := factors_of(vars(soil))) is not None:
            keys = tuple(("soil", name) for name in FACTORS if getattr(soil, name) is not None)
            if soil.strain_at_half_strength is not None and not self.hardens:
                yield Clash((*keys, ("soil", "strain_at_half_strength")), "cannot be used with strain_at_half_strength")
            compression, direct, extension = factors
            if compression + extension <= direct:
                pair = f"compression and extension ({compression:g} + {extension:g})"
                yield Clash(keys, f"{pair} must be more than direct shear ({direct:g})")
        yield from super().faults(soil, stresses)

    def derived(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        return {name: 1.0 for name in FACTORS if stratum.factors is not None and name not in stratum.values}

    def word(self, stratum: Stratum) -> str:
        return self.name if stratum.factors is None else "anisotropic"

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        if stratum.factors is None:
            return super().pack(stratum, soil)
        strengths = (soil.undrained_shear_strength * factor for factor in stratum.factors)
        return self.engine(stratum).pack(soil.young_modulus, soil.poisson_ratio, *strengths)

    def _initial(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Check that the geostatic stress is within the strength, or between the triaxial strengths."""
        if (factors := factors_of(vars(soil))) is None:
            yield from super()._initial(soil, stresses)
            return
        strength, shares = self.strength(soil), triaxial_shares(*factors)
        shear = 0.5 * (1.0 - soil.K0) * max(stresses)  # compression with a vertical axis is positive
        low, high = -shares[1] * strength, shares[0] * strength
        slack = _ROUNDING * max(stresses)
        if not low - slack <= shear <= high + slack:
            names = ("K0", "undrained_shear_strength", "surcharge", *FACTORS)
            keys = tuple(("soil", name) for name in names if getattr(soil, name) is not None)
            allowed = f"triaxial strengths of {_rounded(low)} (extension) to {_rounded(high)}"
            yield Clash(keys, f"{_state(soil, stresses, shear)} into a soil with {allowed}")


class IwanClay(VonMises):
    """Elements in parallel: kinematic hardening along a hyperbola, a table of G/G_0, or contours of cyclic tests.

    With factors of su by direction these are of simple shear, with the strength there.
    """

    name = "iwan-clay"
    keys: ClassVar[Mapping[str, Field]] = {
        **VonMises.keys,
        REDUCTION: ReductionTable(_TABLE),
        CYCLIC: CyclicTable(_CYCLIC),
    }
    hardens = True

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Check that a backbone stands alone, and that its stresses are within the strength and below those of G."""
        if (cyclic := getattr(soil, CYCLIC)) is not None:
            for other in ("strain_at_half_strength", REDUCTION):
                if getattr(soil, other) is not None:
                    yield Clash((("soil", CYCLIC), ("soil", other)), f"cannot be used with {other}")
            (strain, ratio), strength = cyclic.curve[0], _of_simple_shear(soil)
            shear = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio))
            if shear * strain <= ratio * strength:
                text = f"its first contour, {ratio:g} su at {100.0 * strain:g} %, is stiffer than G: G/su must be more"
                keys = tuple(("soil", name) for name in (CYCLIC, "rigidity_ratio", "undrained_shear_strength"))
                yield Clash(keys, f"{text} than {ratio / strain:.4g}, not {shear / strength:.4g}")
        if (pairs := getattr(soil, REDUCTION)) is not None:
            if soil.strain_at_half_strength is not None:
                pair = ("soil", REDUCTION), ("soil", "strain_at_half_strength")
                yield Clash(pair, "cannot be used with strain_at_half_strength")
            strain, ratio = pairs[-1]
            stress = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio)) * strain * ratio
            strength = _of_simple_shear(soil)
            if strength and stress > strength * (1.0 + _SAME_STRAIN):
                at = f"{stress / 1e3:.4g} kPa at a shear strain of {strain:g}"
                keys = tuple(("soil", name) for name in (REDUCTION, "undrained_shear_strength", "rigidity_ratio"))
                yield Clash(keys, f"gives {at}, more than su ({show(strength, 'kPa')})")
        yield from super().faults(soil, stresses)

    def strength(self, soil: Soil) -> float:
        cyclic = getattr(soil, CYCLIC)
        return float(soil.undrained_shear_strength * (1.0 if cyclic is None else cyclic.curve[-1][1]))

    def shown(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        cyclic = stratum.tables[CYCLIC]
        if cyclic is None:
            return {}
        strength = stratum.value("undrained_shear_strength", depth) * (stratum.factors or (1.0, 1.0, 1.0))[1]
        return {"cyclic_strength_Pa": float(strength) * cyclic.curve[-1][1]}

    def word(self, stratum: Stratum) -> str:
        return self.name if stratum.factors is None else "iwan-anisotropic"

    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        from fe_engine.soil import iwan_clay, mobilised

        young, poisson, strength = soil.young_modulus, soil.poisson_ratio, _of_simple_shear(soil)
        if (pairs := stratum.tables[REDUCTION]) is not None:
            rows = iwan_clay.pack_table(young, poisson, strength, *np.array(pairs).T)
        elif (cyclic := stratum.tables[CYCLIC]) is not None:
            rows = iwan_clay.pack_contours(young, poisson, strength, *np.array(cyclic.curve).T)
        else:
            shear, half = young / (2.0 * (1.0 + poisson)), getattr(soil, "strain_at_half_strength", None)
            scale = strength / shear if half is None else np.maximum(mobilised.scale_of(half, strength, shear), 0.0)
            rows = iwan_clay.pack(young, poisson, strength, scale)
        return rows if stratum.factors is None else self.engine(stratum).pack(rows, stratum.factors)


def _of_simple_shear(soil: Soil) -> Any:
    """Return su of direct simple shear (...,) in Pa."""
    factor = getattr(soil, "direct_shear_factor", None)
    return soil.undrained_shear_strength * (1.0 if factor is None else factor)
