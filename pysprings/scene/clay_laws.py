# SPDX-License-Identifier: MIT
"""Checks of undrained clay in total stress: strength, strain at half of it, and the initial state.

Total stress counts from the hydrostatic pressure of the water here, so that the initial vertical stress is the
effective one and K0 the ratio of effective stresses. Its shear must be within the strength.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from pysprings.core.units import show
from pysprings.scene.clash import Clash

_ROUNDING = 1.0e-9
# initial shear over |1 - K0| s'_v0, as each law measures it
TRESCA, VON_MISES = 0.5, 1.0 / math.sqrt(3.0)


def strength_clashes(soil: Any) -> Iterator[Clash]:
    """Check the strain at half of the strength, which is at least that of the elastic soil, su/(2 G)."""
    half, strength = soil.strain_at_half_strength, soil.undrained_shear_strength
    shear = soil.young_modulus / (2.0 * (1.0 + soil.poisson_ratio))
    if half is None or shear == 0.0:
        return
    least = 0.5 * strength / shear
    if half < least * (1.0 - _ROUNDING):
        keys = ("soil", "strain_at_half_strength"), ("soil", "rigidity_ratio"), ("soil", "undrained_shear_strength")
        yield Clash(keys, f"{half:g} must be at least su/(2 G), {least:.3g}: the soil is elastic below")


def initial_shear(measure: float) -> Callable[[Any, tuple[float, float]], Iterator[Clash]]:
    """Make the check that the geostatic stress is within the strength; see `TRESCA` and `VON_MISES`."""

    def check(soil: Any, stresses: tuple[float, float]) -> Iterator[Clash]:
        strength = soil.undrained_shear_strength
        shear = measure * abs(1.0 - soil.K0) * max(stresses)
        most = strength if soil.strain_at_half_strength is None else strength * (1.0 - _ROUNDING)
        if shear > most + _ROUNDING * max(stresses):
            keys = tuple(("soil", name) for name in ("K0", "undrained_shear_strength", "surcharge"))
            text = f"{soil.K0:g} puts an initial shear stress of {show(shear, 'kPa')} into a soil of strength"
            yield Clash(keys, f"{text} {show(strength, 'kPa')}")

    return check
