# SPDX-License-Identifier: MIT
"""Checks of the keys of a soil: those that do not fit its law, that exclude each other, that are missing."""

from __future__ import annotations

from collections.abc import Iterator

from pysprings.scene.by_depth import ByDepth, Profile, follows_stress
from pysprings.scene.clash import Clash
from pysprings.scene.fields import Number, Quantity
from pysprings.scene.ground import given_values
from pysprings.scene.positions import KeyPath
from pysprings.scene.sections import Layer, Soil, SoilValues
from pysprings.scene.soil_laws import CLAY_KEYS, FRICTION_KEYS, SOIL_LAWS, STIFFNESSES


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
    yield from _without_strength(soil, laws)
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


def _without_strength(soil: Soil, laws: list[str]) -> Iterator[Clash]:
    """Give clay whose strength is 0 at every depth."""
    for number, law in enumerate(laws):
        layer = soil.layers[number] if soil.layers else None
        if SOIL_LAWS[law].total_stress and given_values(soil, layer)["undrained_shear_strength"] == 0.0:
            keys = (*_here(soil, number), "undrained_shear_strength"), ("soil", "undrained_shear_strength")
            yield Clash(keys, "0: a soil without strength")


def _here(soil: Soil, number: int) -> KeyPath:
    return ("soil", "layer", number) if soil.layers else ("soil",)


def missing(soil: Soil, mode: str) -> Iterator[Clash]:
    """Give every key without which layers cannot be computed, with these layers; ``mode`` is drainage.mode."""
    lacking: dict[tuple[str, str], list[int]] = {}  # key and law -> numbers of the layers
    for number, name in enumerate(laws_of(soil)):
        layer, law = soil.layers[number] if soil.layers else None, SOIL_LAWS[name]
        given = given_values(soil, layer)
        flows = not law.total_stress and (getattr(layer, "drainage", None) or mode) == "coupled"
        needed = {_stiffnesses(name)[0]: _stiffnesses(name), **{key: (key,) for key in law.needs}}
        needed |= {"hydraulic_conductivity": ("hydraulic_conductivity",)} if flows else {}
        for key, instead in needed.items():
            if all(given[each] is None for each in instead):
                lacking.setdefault((key, name), []).append(number)
    for (key, law_name), numbers in lacking.items():
        keys = _stiffnesses(law_name) if key in _stiffnesses(law_name) else (key,)
        tables = [*(_here(soil, number) for number in numbers), ("soil",)] if soil.layers else [("soil",)]
        places = [(*table, each) for table in tables for each in keys]
        there: list[KeyPath] = [(*tables[0], "law"), ("soil", "yield_surface"), ("soil", "layer")]
        names = [f"'{soil.layers[number].name}'" for number in numbers] if soil.layers else []
        where = f" in layer {', '.join(names[:_MOST_NAMED])}{', ...' * (len(names) > _MOST_NAMED)}" if names else ""
        yield Clash((*places, *there), f"missing{where}; {_reason(law_name, key, keys[1:])}; such as {_example(key)}")


def _stiffnesses(law: str) -> tuple[str, ...]:
    return _OF_CLAY if SOIL_LAWS[law].total_stress else STIFFNESSES[:2]


_MOST_NAMED = 8
_OF_CLAY = ("rigidity_ratio", "shear_modulus", "young_modulus", "plasticity_index")


def _reason(law: str, key: str, others: tuple[str, ...]) -> str:
    if key == "hydraulic_conductivity":
        return "water flows in it"
    clay = ' (undrained clay: law "tresca" with undrained_shear_strength)' * (key == "friction_angle_final")
    return f'law "{law}" needs {", or ".join(["it", *others])}{clay}'


def _example(key: str) -> str:
    """Return an example of a key of the ground as a scene has it."""
    field = next(
        each for each in SoilValues.model_fields[key].metadata if isinstance(each, Quantity | Number | Profile)
    )
    quantity = field.quantity if isinstance(field, Profile) else field
    return f'{key} = "{quantity.example}"' if isinstance(quantity, Quantity) else f"{key} = {quantity.example:g}"


_STAND_INS = {
    "young_modulus": 1e8, "friction_angle_final": 0.5, "effective_unit_weight": 1e4, "K0": 1.0,
    "undrained_shear_strength": 1e4, "hydraulic_conductivity": 1e-4,
}  # fmt: skip


def with_stand_ins(soil: Soil) -> Soil:
    """Return a soil in which something stands where values are missing, so that the rest of it can be checked."""
    return soil.model_copy(update={key: value for key, value in _STAND_INS.items() if getattr(soil, key) is None})
