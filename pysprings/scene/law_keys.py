# SPDX-License-Identifier: MIT
"""Checks of the keys of a soil: those that do not fit its law, that exclude each other, that are missing."""

from __future__ import annotations

from collections.abc import Iterator

from pysprings.scene.by_depth import ByDepth, follows_stress
from pysprings.scene.clash import Clash
from pysprings.scene.law_defaults import STIFFNESSES
from pysprings.scene.positions import KeyPath
from pysprings.scene.sections import Layer, Soil
from pysprings.scene.soil_laws import CLAY_KEYS, FRICTION_KEYS, SOIL_LAWS


def laws_of(soil: Soil) -> list[str]:
    """Return the law of each layer, or that of the one soil."""
    return [each.law or soil.yield_surface for each in soil.layers] or [soil.yield_surface]


def given_keys(table: Soil | Layer) -> set[str]:
    """Return the keys that a table gives itself."""
    names = type(table).model_fields
    return {name for name in names if name in table.model_fields_set and getattr(table, name) is not None}


def key_clashes(soil: Soil) -> Iterator[Clash]:
    """Check that [soil] and every layer have the keys of their law, each value once."""
    laws = laws_of(soil)
    kinds = {SOIL_LAWS[law].total_stress for law in laws}
    if len(kinds) == 1:
        yield from _foreign(("soil",), given_keys(soil), laws[0])
    yield from _one_stiffness(("soil",), given_keys(soil))
    yield from _changing(("soil",), soil, laws if not soil.layers else [], soil)
    for number, layer in enumerate(soil.layers):
        here: KeyPath = ("soil", "layer", number)
        yield from _changing(here, layer, [laws[number]], soil)
        yield from _foreign(here, given_keys(layer), laws[number])
        yield from _one_stiffness(here, given_keys(layer))
    if soil.layers:
        for name in given_keys(soil):
            if isinstance(getattr(soil, name), ByDepth):
                yield Clash((("soil", name),), "a table by depth stands in a layer where there are layers")
    yield from _missing(soil, laws)
    yield from _at_rest(soil, laws)


def _foreign(here: KeyPath, given: set[str], law: str) -> Iterator[Clash]:
    """Give the keys that the law does not use: friction of a clay in total stress, strength su of another law."""
    clay = SOIL_LAWS[law].total_stress
    for name in FRICTION_KEYS if clay else CLAY_KEYS:
        if name in given:
            clays = ", ".join(f'"{each.name}"' for each in SOIL_LAWS.values() if each.total_stress)
            expected = "its strength is undrained_shear_strength" if clay else f"su is that of {clays}"
            yield Clash(((*here, name),), f'is not used by law "{law}": {expected}')


def _at_rest(soil: Soil, laws: list[str]) -> Iterator[Clash]:
    """Give K0 = "auto" of a soil without one friction angle."""
    for number, law in enumerate(laws):
        layer = soil.layers[number] if soil.layers else None
        own = getattr(layer, "K0", None)
        if (soil.K0 if own is None else own) != "auto":
            continue
        here: KeyPath = ("soil",) if own is None else ("soil", "layer", number)
        name = f"layer '{layer.name}': " if layer else ""
        angle = getattr(layer, "friction_angle_final", None)
        if "friction_angle_final" not in SOIL_LAWS[law].keys:
            text = f'"auto" is 1 - sin(phi), and law "{law}" has no friction angle: give a number'
            yield Clash(((*here, "K0"),), name + text)
        elif isinstance(angle, ByDepth):
            text = '"auto" is 1 - sin(phi) of a layer with one friction angle: give a number, or divide the layer'
            yield Clash(((*here, "K0"), ("soil", "layer", number, "friction_angle_final")), name + text)


def _changing(here: KeyPath, table: Soil | Layer, laws: list[str], soil: Soil) -> Iterator[Clash]:
    """Check that a stiffness that changes in a run belongs to a law with friction, and what belongs to another key."""
    constant = [law for law in laws if not SOIL_LAWS[law].changes_stiffness]
    for name in ("young_modulus", "shear_modulus"):
        if constant and follows_stress(getattr(table, name, None)):
            text = f'follows: the stiffness of law "{constant[0]}" does not change'
            yield Clash(((*here, name),), f'{text}; "drucker-prager" and "van-eekelen" follow')
    other = [law for law in constant if not SOIL_LAWS[law].total_stress]
    if other and "degradation_strain" in given_keys(table):
        yield Clash(((*here, "degradation_strain"),), f'is not used by law "{other[0]}"')
    strains = getattr(table, "degradation_strain", None), soil.degradation_strain
    if "degradation_limit" in given_keys(table) and strains == (None, None):
        yield Clash(((*here, "degradation_limit"),), "needs a degradation_strain")
    indices = getattr(table, "plasticity_index", None), soil.plasticity_index
    if "overconsolidation_ratio" in given_keys(table) and indices == (None, None):
        yield Clash(((*here, "overconsolidation_ratio"),), "needs a plasticity_index")


def _one_stiffness(here: KeyPath, given: set[str]) -> Iterator[Clash]:
    several = [name for name in STIFFNESSES if name in given]
    if len(several) > 1:
        yield Clash(tuple((*here, name) for name in reversed(several)), f"give one of {', '.join(several)}")


def _missing(soil: Soil, laws: list[str]) -> Iterator[Clash]:
    """Give clay in total stress without a strength or a stiffness."""
    stiff = given_keys(soil) & {*STIFFNESSES}
    for number, law in enumerate(laws):
        if not SOIL_LAWS[law].total_stress:
            continue
        layer = soil.layers[number] if soil.layers else None
        here: KeyPath = ("soil", "layer", number) if layer else ("soil",)
        given = given_keys(layer) if layer else given_keys(soil)
        place = ((*here, "law" if layer else "yield_surface"), ("soil", "yield_surface"))
        own = layer.undrained_shear_strength if layer else None  # type: ignore[attr-defined]
        strength = soil.undrained_shear_strength if own is None else own
        if strength is None or strength == 0.0:
            text = f'missing; law "{law}" needs it' if strength is None else "0: a soil without strength"
            yield Clash(((*here, "undrained_shear_strength"), ("soil", "undrained_shear_strength"), *place), text)
        if not (stiff or given & {*STIFFNESSES}):
            text = f'missing; law "{law}" needs it, or shear_modulus, or young_modulus, or plasticity_index'
            yield Clash(((*here, "rigidity_ratio"), *place), text)
