# SPDX-License-Identifier: MIT
"""Bonded caissons in one layer of undrained clay, su = su_m + k z, G = I_r su, under a vertical load V.

By dimensional analysis L/D, k D/su_m, the adhesion alpha and V decide on loads over F = su D (L + D), su at half the
skirt length, as functions of X = I_r rho/D: elastic perfectly plastic soil in total stress has no other scale of
motion. V is over V_0 = 9 su_tip A + alpha su S, A the area of the base, S that of the outer skirt: roughly what the
ground carries. The thickness of the skirt is a fixed share of D.

With a gap the skirt comes off the soil outside, where the tension would be: one more input, as the gap opens where the
total stress falls to the water pressure, so that gamma' D/su, su at half the skirt length, decides. Inside, under the
lid and at the tip the contact holds (suction).
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem
from pysprings.scene.by_depth import ByDepth
from pysprings.scene.model import Scene
from pysprings.studies.atlas.families.base import FREE, Family, Scaled, Sizes, diameter, first_layer


def strength(scene: Scene) -> tuple[float, float]:
    """Return su at mudline [Pa] and its gradient [Pa/m]."""
    su = first_layer(scene).undrained_shear_strength
    if isinstance(su, ByDepth):
        return float(su.top or 0.0), float(su.gradient or 0.0)
    return float(su), 0.0


def strength_at_half(scene: Scene) -> float:
    """Return su at half the skirt length [Pa]."""
    top, gradient = strength(scene)
    return top + 0.5 * gradient * scene.caisson.skirt_length


def _carried(scene: Scene, alpha: float) -> float:
    """Return V_0 [N]."""
    top, gradient = strength(scene)
    D, L = diameter(scene), scene.caisson.skirt_length
    return BASE * (top + gradient * L) * 0.25 * np.pi * D**2 + alpha * strength_at_half(scene) * np.pi * D * L


def read(scene: Scene) -> Array:
    """Return L/D, k D/su_m, alpha, V/V_0; a balanced V is none."""
    top, gradient = strength(scene)
    D, V = diameter(scene), scene.caisson.vertical_load
    adhesion: Any = scene.interface.adhesion_factor
    alpha = float(adhesion)
    share = 0.0 if isinstance(V, str) else float(V) / _carried(scene, alpha)
    return np.array([scene.caisson.skirt_length / D, gradient * D / top, alpha, share])


def even(values: Array) -> Array:
    """Return ln(L/D), ln(1 + k D/su_m), alpha, V/V_0."""
    length, growth, alpha, load = np.moveaxis(values, -1, 0)
    return np.stack([np.log(length), np.log1p(growth), alpha, load], axis=-1)


def _sizes(scene: Scene) -> Sizes:
    D, L, ratio = diameter(scene), scene.caisson.skirt_length, first_layer(scene).rigidity_ratio
    assert ratio is not None
    return Sizes(strength_at_half(scene) * D * (L + D), float(ratio))


def _at_rest(scene: Scene) -> float:
    """Return the vertical load [N] that the initial stress below the skirt tip carries."""
    D, t = diameter(scene), scene.caisson.skirt_thickness
    return float(scene.ground.vertical_stress(np.array([scene.caisson.skirt_length]))[0]) * np.pi * (D - t) * t


def _odd(scene: Scene, _base: Scene) -> Iterator[Problem]:
    """Yield a problem for a strength that is not linear, or an adhesion that differs between surfaces."""
    su = first_layer(scene).undrained_shear_strength
    if isinstance(su, ByDepth) and (su.gradient is None or not su.top):
        text = "the atlas needs { top, gradient } with a top above zero, or one value"
        yield Problem(key="soil.layer.undrained_shear_strength", message=text)
    if not isinstance(scene.interface.adhesion_factor, float | int):
        yield Problem(key="interface.adhesion_factor", message="the atlas needs one number for all surfaces")
    ratio = first_layer(scene).rigidity_ratio
    if ratio is None or isinstance(ratio, ByDepth):
        text = "missing: the atlas needs G/su" if ratio is None else "the atlas needs one G/su at all depths"
        yield Problem(key="soil.layer.rigidity_ratio", message=text)


BASE = 9.0  # of V_0
_LAYER = "soil.layer.clay"
FAMILY = Family(
    name="clay",
    labels=("L/D", "k D/su_m", "alpha", "V/V_0"),
    read=read,
    even=even,
    sizes=_sizes,
    free={
        **FREE,
        "interface": ("adhesion_factor", "friction_coefficient"),
        "soil.layer": (
            "undrained_shear_strength", "rigidity_ratio", "effective_unit_weight", "name", "drainage",
            "hydraulic_conductivity",
        ),
    },
    scaled=(Scaled("caisson", "skirt_thickness", ("m", 1.0), "D", diameter),),
    short={
        "su": f"{_LAYER}.undrained_shear_strength.top",
        "gradient": f"{_LAYER}.undrained_shear_strength.gradient",
        "G/su": f"{_LAYER}.rigidity_ratio",
        "alpha": "interface.adhesion_factor",
        "V": "caisson.vertical_load",
    },
    odd=_odd,
    at_rest=_at_rest,
    under_load=("under V full models had 22 % less to 13 % more load at u/D below 0.1 su/G, beyond the deviations",),
)  # fmt: skip

_WEIGHT = "effective_unit_weight"


def _read_gap(scene: Scene) -> Array:
    weight = float(getattr(first_layer(scene), _WEIGHT)) * diameter(scene) / strength_at_half(scene)
    return np.append(read(scene), weight)


def _even_gap(values: Array) -> Array:
    return np.concatenate([even(values[..., :-1]), np.log(values[..., -1:])], axis=-1)


def _odd_gap(scene: Scene, base: Scene) -> Iterator[Problem]:
    yield from FAMILY.odd(scene, base)
    if not isinstance(getattr(first_layer(scene), _WEIGHT), float | int):
        yield Problem(key=f"soil.layer.{_WEIGHT}", message="the atlas needs one unit weight at all depths")


GAP_FAMILY = replace(
    FAMILY,
    name="clay-gap",
    labels=(*FAMILY.labels, "gamma' D/su"),
    read=_read_gap,
    even=_even_gap,
    short={**FAMILY.short, "gamma": f"soil.layer.clay.{_WEIGHT}"},
    odd=_odd_gap,
    at_rest=None,
)
