# SPDX-License-Identifier: MIT
"""Checks of the layers of a scene: their order, and the values at both ends of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from pysprings.core.units import show
from pysprings.scene.by_depth import ByDepth, Profile, Value
from pysprings.scene.clash import Clash
from pysprings.scene.clay_laws import ANISOTROPY_KEYS
from pysprings.scene.extent import Extent
from pysprings.scene.fields import Interval
from pysprings.scene.ground import Stratum, make_ground
from pysprings.scene.positions import KeyPath
from pysprings.scene.reduction import KEY as REDUCTION
from pysprings.scene.sections import Soil
from pysprings.scene.soil_laws import DEGRADATION_KEYS

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
    optional = "strain_at_half_strength", "overconsolidation_ratio", *ANISOTROPY_KEYS, *DEGRADATION_KEYS
    return {**dict.fromkeys(optional), **values, REDUCTION: stratum.reduction}


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
            values = {name: value for name, value in stratum.values.items() if not _by_stress(value)}
            yield replace(stratum, number=number, values=values)


def _by_stress(value: Value) -> bool:
    return isinstance(value, ByDepth) and value.reference_stress is not None


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
