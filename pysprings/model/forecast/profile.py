# SPDX-License-Identifier: MIT
"""The ground of a scene by depth as `check` prints it, and values that are outside common ranges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.units import show
from pysprings.scene.ground import Stratum, ground_of
from pysprings.scene.interface import adhesion_factor, uses_adhesion
from pysprings.scene.soil_laws import SOIL_LAWS

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

# Common ranges of undrained clay. G/su: Eu/su of 200 to 1000 (Duncan & Buchignani 1976) is 65 to 350, small-strain
# stiffness up to 2000. su/s'_v0: from normally consolidated (Jamiolkowski et al. 1985: 0.23 +- 0.04) to stiff clay.
_RIGIDITY = (20.0, 2000.0)
_NORMALISED = (0.15, 10.0)
_STRENGTH = 300e3  # Pa; soils beyond are rocks
_ALPHA = (0.2, 1.0)
_POISSON = 0.48
_STATIONS = 9


def profile(scene: Scene) -> list[dict[str, Any]]:
    """Return a row for top and bottom of each layer, in SI; adhesion factors where the interface has adhesion."""
    rows, ground = [], ground_of(scene)
    for stratum in ground.strata:
        for depth in (stratum.top, stratum.bottom):
            row = stratum.row(depth)
            if uses_adhesion(scene) and stratum.top <= scene.caisson.skirt_length:
                for side in ("outside", "inside"):
                    factor = adhesion_factor(scene.interface, stratum, side, np.array(depth))
                    row[f"adhesion_factor_{side}"] = float(factor)
            rows.append(row)
    return rows


_SHEAR_MODULUS = (0.1, 1e5)  # MPa: peat at mudline to rock
_UNIT_WEIGHT = (3.0, 14.0)  # kN/m3, submerged: soft clay to very dense sand and gravel
_FRICTION = (20.0, 46.0)  # degrees: plastic silt to very dense sand at low stress


def unusual_values(scene: Scene) -> list[str]:
    """Return a sentence for each value outside the common range."""
    strata = [each for each in ground_of(scene).strata if not each.like]
    odd = [text for stratum in strata for text in _odd(stratum)]
    return odd + [text for stratum in strata if stratum.total_stress for text in _unusual(scene, stratum)]


def _odd(stratum: Stratum) -> Iterator[str]:
    """Check what any soil has, and the friction of sand, at the ends of a layer."""
    where, depth = f"layer '{stratum.name}'", np.array([stratum.top, stratum.bottom])
    weight = 1e-3 * stratum.value("effective_unit_weight", depth)
    if weight.any():  # soil without weight is a deliberate simplification
        yield from _outside(where, "effective unit weight [kN/m3]", weight, _UNIT_WEIGHT, depth)
    if stratum.total_stress:
        return
    modulus = 1e-6 * stratum.shear_modulus(depth)
    yield from _outside(where, "shear modulus [MPa]", modulus, _SHEAR_MODULUS, depth)
    if SOIL_LAWS[stratum.law].yields:
        friction = np.degrees(stratum.value("friction_angle_final", depth))
        yield from _outside(where, "friction angle [deg]", friction, _FRICTION, depth)


def _unusual(scene: Scene, stratum: Stratum) -> Iterator[str]:
    """Check a layer at a few depths inside it."""
    share = (np.arange(_STATIONS) + 0.5) / _STATIONS
    depth = stratum.top + share * (stratum.bottom - stratum.top)
    strength, stress = stratum.strength(depth), stratum.vertical_stress(depth)
    where = f"layer '{stratum.name}'"
    yield from _outside(where, "G/su", stratum.shear_modulus(depth) / strength, _RIGIDITY, depth)
    if stress.min() > 0.0:
        yield from _outside(where, "su over the vertical effective stress", strength / stress, _NORMALISED, depth)
    if strength.max() > _STRENGTH:
        yield f"{where}: su of {show(float(strength.max()), 'kPa')} is that of rock"
    if float(stratum.value("poisson_ratio", depth).min()) < _POISSON:
        yield f"{where}: poisson_ratio below {_POISSON:g} lets undrained clay change its volume"
    beside = depth[depth <= scene.caisson.skirt_length]
    for side in ("outside", "inside") if len(beside) else ():
        factor = adhesion_factor(scene.interface, stratum, side, beside)
        yield from _outside(where, f"adhesion factor {side}", factor, _ALPHA, beside)


def _outside(where: str, what: str, value: np.ndarray, common: tuple[float, float], depth: np.ndarray) -> Iterator[str]:
    """Name the values that are furthest below and above the common range."""
    low, high = common
    least, largest = int(np.argmin(value)), int(np.argmax(value))
    for worst in [*[least] * bool(value[least] < low), *[largest] * bool(value[largest] > high)]:
        found = f"{float(f'{value[worst]:.3g}'):g} at {depth[worst]:.3g} m"
        yield f"{where}: {what} of {found} is outside the common range {low:g} to {high:g}"
