# SPDX-License-Identifier: MIT
"""Checks of the layers of a scene: the keys that their laws use, their order, and the values at both ends of each."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from pysprings.core.units import show
from pysprings.scene.by_depth import ByDepth, Profile, follows_stress
from pysprings.scene.fields import Interval, Quantity
from pysprings.scene.ground import Stratum, given_values, make_ground
from pysprings.scene.positions import Clash, KeyPath
from pysprings.scene.sections import BY_LAYER, Extent, Layer, Soil, plain_field
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS, STIFFNESSES, owners


def laws_of(soil: Soil) -> list[str]:
    """Return the law of each layer, or that of the one soil."""
    return [each.law or soil.yield_surface for each in soil.layers] or [soil.yield_surface]


def given_keys(table: Soil | Layer) -> set[str]:
    """Return the keys that a table gives itself."""
    names = type(table).model_fields
    return {name for name in names if name in table.model_fields_set and getattr(table, name) is not None}


def untaken(soil: Soil) -> set[str]:
    """Return the keys of [soil] that have no effect: every layer that could take one has its own."""

    def takes(layer: Layer, law: str, name: str) -> bool:
        if name == "yield_surface":
            return layer.law is None
        rivals = STIFFNESSES if name in STIFFNESSES else (name,)
        used = name not in LAW_KEYS or name in (*SOIL_LAWS[law].keys, *SOIL_LAWS[law].unused)
        return used and all(getattr(layer, each) is None for each in rivals)

    pairs = list(zip(soil.layers, laws_of(soil), strict=False))  # no layers: one soil, which takes all
    names = given_keys(soil) & {"yield_surface", *BY_LAYER} if pairs else set[str]()
    return {name for name in names if not any(takes(layer, law, name) for layer, law in pairs)}


def key_clashes(soil: Soil) -> Iterator[Clash]:
    """Check that [soil] and every layer have the keys of their law, each value once."""
    laws = laws_of(soil)
    for here, table, own in _tables(soil, laws):
        given = given_keys(table)
        yield from _foreign(here, given, own)
        several = [name for name in STIFFNESSES if name in given]
        if len(several) > 1:
            yield Clash(tuple((*here, name) for name in reversed(several)), f"give one of {', '.join(several)}")
        yield from _changing(here, table, own, soil)
    for name in given_keys(soil) if soil.layers else ():
        if isinstance(getattr(soil, name), ByDepth):
            yield Clash((("soil", name),), "a table by depth stands in a layer where there are layers")
    yield from _without_strength(soil, laws)
    yield from _at_rest(soil, laws)


def _tables(soil: Soil, laws: list[str]) -> Iterator[tuple[KeyPath, Soil | Layer, list[str]]]:
    """Give [soil] and each layer, with the laws that take their values from it."""
    yield ("soil",), soil, laws
    for number, layer in enumerate(soil.layers):
        yield ("soil", "layer", number), layer, [laws[number]]


def _foreign(here: KeyPath, given: set[str], laws: list[str]) -> Iterator[Clash]:
    """Give the keys that none of the laws uses."""
    taken = {key for law in laws for key in (*SOIL_LAWS[law].keys, *SOIL_LAWS[law].unused)}
    for name in LAW_KEYS:
        if name in given and name not in taken:
            of_sand = name.startswith(("friction", "hardening", "dilation", "cohesion"))
            clay = SOIL_LAWS[laws[0]].total_stress and of_sand
            expected = f"its strength is {SOIL_LAWS[laws[0]].cap}" if clay else f"it is that of {owners(name)}"
            yield Clash(((*here, name),), f'is not used by law "{laws[0]}": {expected}')


def _at_rest(soil: Soil, laws: list[str]) -> Iterator[Clash]:
    """Give K0 = "auto" of a soil without one friction angle."""
    for number, law in enumerate(laws):
        layer = soil.layers[number] if soil.layers else None
        own = getattr(layer, "K0", None)
        if (soil.K0 if own is None else own) != "auto":
            continue
        here: KeyPath = ("soil",) if own is None else ("soil", "layer", number)
        name = f"layer '{layer.name}': " if layer else ""
        friction = SOIL_LAWS[law].friction
        angle = getattr(layer, friction, None) if friction else None
        if not friction:
            text = f'"auto" is 1 - sin(phi), and law "{law}" has no friction angle: give a number'
            yield Clash(((*here, "K0"),), name + text)
        elif isinstance(angle, ByDepth):
            text = '"auto" is 1 - sin(phi) of a layer with one friction angle: give a number, or divide the layer'
            yield Clash(((*here, "K0"), ("soil", "layer", number, friction)), name + text)


def _changing(here: KeyPath, table: Soil | Layer, laws: list[str], soil: Soil) -> Iterator[Clash]:
    """Check that a stiffness that follows the stress belongs to a law that has it, and what belongs to another key."""
    constant = [law for law in laws if not SOIL_LAWS[law].changes_stiffness]
    own = len(laws) == 1 or table is not soil
    for name in ("young_modulus", "shear_modulus"):
        if constant and own and follows_stress(getattr(table, name, None)):
            text = f'follows: the stiffness of law "{constant[0]}" does not change'
            follow = ", ".join(f'"{law.name}"' for law in SOIL_LAWS.values() if law.changes_stiffness)
            yield Clash(((*here, name),), f"{text}; it does in {follow}")
    degrades = all(SOIL_LAWS[law].gives_stiffness for law in laws)
    needs = {} if degrades else {"degradation_limit": "degradation_strain"}
    for name, needed in (needs | {"overconsolidation_ratio": "plasticity_index"}).items():
        if name in given_keys(table) and (getattr(table, needed, None), getattr(soil, needed)) == (None, None):
            yield Clash(((*here, name),), f"needs a {needed}")


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
        needed = {} if law.gives_stiffness else {law.stiffnesses[0]: law.stiffnesses}
        needed |= {key: (key,) for key in law.needs}
        needed |= {"hydraulic_conductivity": ("hydraulic_conductivity",)} if flows else {}
        for key, instead in needed.items():
            if all(given[each] is None for each in instead):
                lacking.setdefault((key, name), []).append(number)
    for (key, law_name), numbers in lacking.items():
        keys = SOIL_LAWS[law_name].stiffnesses
        keys = keys if key in keys else (key,)
        tables = [*(_here(soil, number) for number in numbers), ("soil",)] if soil.layers else [("soil",)]
        places = [(*table, each) for table in tables for each in keys]
        there: list[KeyPath] = [(*tables[0], "law"), ("soil", "yield_surface"), ("soil", "layer")]
        names = [f"'{soil.layers[number].name}'" for number in numbers] if soil.layers else []
        where = f" in layer {', '.join(names[:_MOST_NAMED])}{', ...' * (len(names) > _MOST_NAMED)}" if names else ""
        yield Clash((*places, *there), f"missing{where}; {_reason(law_name, key, keys[1:])}; such as {_example(key)}")


_MOST_NAMED = 8


def _reason(law: str, key: str, others: tuple[str, ...]) -> str:
    if key == "hydraulic_conductivity":
        return "water flows in it"
    clay = ' (undrained clay: law "tresca" with undrained_shear_strength)' * (key == "friction_angle_final")
    return f'law "{law}" needs {", or ".join(["it", *others])}{clay}'


def _example(key: str) -> str:
    """Return an example of a key of the ground as a scene has it."""
    example = plain_field(key).example
    return f'{key} = "{example}"' if isinstance(example, str) else f"{key} = {example:g}"


def _read(field: Any) -> float:
    """Return the example of a field in SI."""
    return float(field.number(field.example, bare=False) if isinstance(field, Quantity) else field.example)


def with_stand_ins(soil: Soil) -> Soil:
    """Return a soil in which examples stand where values are missing, so that the rest of it can be checked."""
    keys = {"young_modulus", "hydraulic_conductivity", *(key for law in SOIL_LAWS.values() for key in law.needs)}
    lacking = {key: plain_field(key) for key in keys if getattr(soil, key) is None}
    return soil.model_copy(update={key: _read(each) for key, each in lacking.items()})


_STATIONS = 33  # depths of a layer where its values are checked


def layer_order(soil: Soil, domain: Extent) -> Iterator[Clash]:
    """Check that layers begin at mudline, stand in order, and end inside the domain."""
    for number, layer in enumerate(soil.layers):
        here: KeyPath = ("soil", "layer", number, "top")
        if number == 0 and layer.top != 0.0:
            yield Clash((here,), f"{show(layer.top, 'm')}: the first layer begins at mudline (0 m)")
        before = soil.layers[number - 1].top if number else -1.0
        if layer.top <= before:
            text = f"{show(layer.top, 'm')} must be below the top of the layer before ({show(before, 'm')})"
            yield Clash((here, ("soil", "layer", number - 1, "top")), text)
        if layer.top >= domain.depth:
            text = f"{show(layer.top, 'm')} is not above the bottom of the domain ({show(domain.depth, 'm')})"
            yield Clash((here, ("domain", "depth")), text)


def open_ends(soil: Soil, domain: Extent) -> Iterator[Clash]:
    """Check that values at the bottom of the last layer have a depth where the domain gives none."""
    if domain.depth == domain.ground:
        return
    layer, here = (soil.layers[-1], ("layer", len(soil.layers) - 1)) if soil.layers else (soil, ())
    for name in type(layer).model_fields:
        value = getattr(layer, name)
        if isinstance(value, ByDepth) and value.bottom is not None and value.to is None:
            text = "a value at the bottom of the last layer needs its depth, `to`, or a domain.depth"
            yield Clash((("soil", *here, name), ("domain", "depth")), text)


def uniform_soils(soil: Soil, domain: Extent) -> Iterator[tuple[Any, tuple[float, float], int | None]]:
    """Give soils of constant values for what is checked of one: the soil, or the ends of each layer.

    With each come the vertical effective stresses (Pa) between which it stands, and the number of its layer.
    """
    ground = make_ground(soil, domain)
    if not soil.layers and ground.is_uniform:
        bottom = float(ground.strata[0].vertical_stress(np.array(domain.ground)))
        yield soil.model_copy(update=_at(ground.strata[0], domain.ground)), (soil.surcharge, bottom), None
        return
    for stratum in (each for each in ground.strata if not each.like):
        number = stratum.number if soil.layers else None
        for depth in (stratum.top, stratum.bottom) if stratum.varies else (stratum.bottom,):
            end = float(stratum.vertical_stress(np.array(depth)))
            stresses = (end, end) if stratum.varies else (stratum.above, end)
            uniform = soil.model_copy(update={**_at(stratum, depth), "yield_surface": stratum.law, "layers": ()})
            yield uniform, stresses, number


def _at(stratum: Stratum, depth: float) -> dict[str, Any]:
    """Return the values of a layer at a depth (m), Young's modulus among them; None for those it does not have."""
    values = {name: float(stratum.value(name, np.array(depth))) for name in (*stratum.values, "young_modulus")}
    return {**dict.fromkeys(LAW_KEYS), **values, **stratum.tables}


def values_inside(soil: Soil, domain: Extent) -> Iterator[Clash]:
    """Check that values by depth stay within the range of their key all over the layer."""
    strata = _with_room(soil, domain) if [*layer_order(soil, domain)] else make_ground(soil, domain).strata
    for stratum in strata:
        yield from () if stratum.like else _inside(soil, stratum)


def _with_room(soil: Soil, domain: Extent) -> Iterator[Stratum]:
    """Give the layers that end below their top where not all stand in order; values by stress, unknown, left out."""
    ends = [*(each.top for each in soil.layers[1:]), domain.ground]
    for number, (layer, end) in enumerate(zip(soil.layers, ends, strict=True)):
        if layer.top < end:
            pair = soil.model_copy(update={"layers": soil.layers[number : number + 2]})
            stratum = make_ground(pair, domain).strata[0]
            stresses = {name: getattr(value, "reference_stress", None) for name, value in stratum.values.items()}
            known = {name: value for name, value in stratum.values.items() if stresses[name] is None}
            yield replace(stratum, number=number, values=known)


def _inside(soil: Soil, stratum: Stratum) -> Iterator[Clash]:
    depth = np.linspace(stratum.top, stratum.bottom, _STATIONS)
    layer, here = (soil.layers[stratum.number], ("layer", stratum.number)) if soil.layers else (soil, ())
    for name, info in type(layer).model_fields.items():
        profile = next((each for each in info.metadata if isinstance(each, Profile)), None)
        if profile is None or not isinstance(getattr(layer, name), ByDepth) or name not in stratum.values:
            continue
        value, quantity = stratum.value(name, depth), profile.quantity
        unit, at_most = quantity.unit, f"{quantity.interval} {quantity.unit}".removesuffix(" 1")
        inside = depth > 0.0 if profile.powers else np.full(depth.shape, True)
        holds = [Interval(quantity.interval).holds(float(each), unit) for each in value]
        bad = np.flatnonzero(~np.array(holds) & inside)
        where = ("soil", *here, name)
        if len(bad):
            what = show(float(value[bad[0]]), unit).removesuffix(" 1")
            yield Clash((where,), f"{what} at a depth of {show(float(depth[bad[0]]), 'm')} is not in {at_most}")
        elif not value.any():
            yield Clash((where,), "0 at every depth: a soil without strength or stiffness")


def in_layer(clash: Clash, soil: Soil, number: int | None) -> Clash:
    """Return a clash of a uniform soil with the keys of its layer."""
    if number is None:
        return clash

    def key(path: KeyPath) -> KeyPath:
        name = "law" if path[-1] == "yield_surface" else str(path[-1])
        layer = soil.layers[number]
        own = path[0] == "soil" and getattr(layer, name, None) is not None
        return ("soil", "layer", number, name) if own else path

    return Clash(tuple(key(path) for path in clash.keys), f"layer '{soil.layers[number].name}': {clash.message}")
