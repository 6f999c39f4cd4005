# SPDX-License-Identifier: MIT
"""Backbone of clay as a table of the secant shear modulus, G/G_0 by shear strain, and what it needs of the soil."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo

from pysprings.core.units import quoted, show
from pysprings.scene.clash import Clash
from pysprings.scene.fields import Field, Interval, refuse

KEY = "shear_modulus_reduction"
LAW = "iwan-clay"
Pairs = tuple[tuple[float, float], ...]

MOST_POINTS = 10  # as `fe_engine.soil.iwan_clay`
_STRAINS, _RATIOS = "[1e-7, 0.5]", "(0, 1]"
_EXAMPLE = [[1e-5, 0.98], [1e-4, 0.83], [1e-3, 0.38], [1e-2, 0.07]]
_ROUNDING = 1e-9
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
        if after > before * (1.0 + (_ROUNDING if n > 1 else -_FIRST)):
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
    if strength and stress > strength * (1.0 + _ROUNDING):
        text = f"gives {stress / 1e3:.4g} kPa at a shear strain of {strain:g}, more than su ({show(strength, 'kPa')})"
        yield Clash((("soil", KEY), ("soil", "undrained_shear_strength"), ("soil", "rigidity_ratio")), text)
