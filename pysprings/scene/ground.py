# SPDX-License-Identifier: MIT
"""The ground of a scene by depth: its layers, their values, and the geostatic stress."""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from pysprings.scene.by_depth import ByDepth, Value, follows_stress
from pysprings.scene.sections import BY_LAYER, Extent, Layer, Soil
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS, STIFFNESSES
from pysprings.scene.soils.clay import TABLES, factors_of
from pysprings.scene.soils.law import SoilLaw

_OF_ELASTIC = ("poisson_ratio", "K0", "effective_unit_weight", "hydraulic_conductivity")
_MERGED = 1.0e-9  # m: depths closer than that are one
_UNUSED_CONDUCTIVITY = 1e-4  # m/s: a scale of time where water does not flow; where it does a scene gives its own


@dataclass(frozen=True)
class Stratum:
    """A layer between two depths (m) with the values of its soil.

    ``above`` is the vertical effective stress (Pa) at its top; ``number`` its place among the layers of the scene.
    ``tables`` are those of its law by key, None for one that is not given.
    ``like`` is the law of the soil above, where this is the elastic ground below it; ``drainage`` is the layer's own.
    """

    number: int
    name: str
    law: str
    top: float
    bottom: float
    above: float
    values: dict[str, Value]
    like: str = ""
    drainage: str | None = None
    tables: dict[str, Any] = field(default_factory=dict)

    def value(self, name: str, depth: np.ndarray) -> np.ndarray:
        """Return a value of the soil at depths (...,) of this layer; Young's modulus from what gives the stiffness."""
        if name == "young_modulus" and name not in self.values:
            return 2.0 * (1.0 + self.value("poisson_ratio", depth)) * self.shear_modulus(depth)
        given = self.values[name]
        if not isinstance(given, ByDepth):
            return np.full(np.shape(depth), given)
        stress = None if given.reference_stress is None else self.mean_stress(depth)
        return given.at(depth, self.top, self.bottom, stress)

    def shear_modulus(self, depth: np.ndarray) -> np.ndarray:
        """Return G (...,) in Pa at depths (...,) of this layer."""
        if "shear_modulus" in self.values:
            return self.value("shear_modulus", depth)
        if "young_modulus" not in self.values:
            return SOIL_LAWS[self.law].shear_modulus(self, depth)
        return self.value("young_modulus", depth) / (2.0 * (1.0 + self.value("poisson_ratio", depth)))

    def strength(self, depth: np.ndarray) -> np.ndarray:
        """Return what an adhesion factor refers to (...,) in Pa: su of undrained clay, the cohesion of another soil."""
        cap = SOIL_LAWS[self.like or self.law].cap
        return self.value(cap, depth) if cap in self.values else np.zeros(np.shape(depth))

    @property
    def total_stress(self) -> bool:
        """Whether the layer is undrained clay in total stress."""
        return SOIL_LAWS[self.like or self.law].total_stress

    def drainage_in(self, mode: str) -> str:
        """Return how water takes part in this layer of a scene with this drainage.mode; "total-stress" in clay."""
        return "total-stress" if self.total_stress else self.drainage or mode

    @property
    def exponent(self) -> float:
        """Exponent of the stress that the stiffness follows; 0 where it is frozen."""
        given = self.values.get("young_modulus", self.values.get("shear_modulus"))
        if given is None:
            return SOIL_LAWS[self.law].exponent(self)
        return float(given.exponent or 0.0) if isinstance(given, ByDepth) and follows_stress(given) else 0.0

    @property
    def stiffness_changes(self) -> bool:
        """Whether the stiffness follows the stress or degrades with shear strain."""
        changes = self.exponent > 0.0 or self.values.get("degradation_strain") is not None
        return changes and SOIL_LAWS[self.law].changes_stiffness

    @property
    def factors(self) -> tuple[float, float, float] | None:
        """Factors of su in compression, direct shear and extension; None where su is the same in all directions."""
        return factors_of(self.values)

    @property
    def varies(self) -> bool:
        """Whether any value differs from depth to depth."""
        return any(isinstance(value, ByDepth) for value in self.values.values())

    def vertical_stress(self, depth: np.ndarray) -> np.ndarray:
        """Return the initial vertical effective stress (...,) in Pa, compression positive."""
        down, weight = depth - self.top, self.values["effective_unit_weight"]
        if not isinstance(weight, ByDepth):
            return np.asarray(self.above + weight * down)
        stop = min(weight.to or self.bottom, self.bottom)  # the weight is constant below
        ends = weight.at(np.array([self.top, stop]), self.top, self.bottom)
        slope, linear = (ends[1] - ends[0]) / (stop - self.top), np.minimum(down, stop - self.top)
        return np.asarray(self.above + (ends[0] + 0.5 * slope * linear) * linear + ends[1] * (down - linear))

    def row(self, depth: float) -> dict[str, Any]:
        """Return what an engineer checks at a depth (m) of this layer, in SI; angles in degrees."""
        z = np.array(depth)
        value = SOIL_LAWS[self.law].derived(self, z) | {name: float(self.value(name, z)) for name in self.values}
        row: dict[str, Any] = {
            "layer": self.name,
            "law": self.law,
            "depth_m": depth,
            "effective_unit_weight_N_per_m3": value["effective_unit_weight"],
            "vertical_effective_stress_Pa": float(self.vertical_stress(z)),
            "K0": value["K0"],
            "shear_modulus_Pa": float(self.shear_modulus(z)),
        }
        if "undrained_shear_strength" in value:
            su = row["undrained_shear_strength_Pa"] = value["undrained_shear_strength"]
            if (factors := self.factors) is not None:
                names = ("compression", "direct_shear", "extension")
                row |= {f"su_{name}_Pa": su * factor for name, factor in zip(names, factors, strict=True)}
        elif SOIL_LAWS[self.law].yields:
            row["friction_angle_deg"] = math.degrees(value[SOIL_LAWS[self.law].friction])
            row["cohesion_Pa"] = value.get("cohesion", 0.0)
        row |= SOIL_LAWS[self.law].shown(self, z)
        if self.stiffness_changes:
            row["stiffness_exponent"] = self.exponent
            row["degradation_strain"] = value.get("degradation_strain")
        return row

    def mean_stress(self, depth: np.ndarray) -> np.ndarray:
        """Return the initial mean effective stress (...,) in Pa, compression positive."""
        return np.asarray((1.0 + 2.0 * self.value("K0", depth)) / 3.0 * self.vertical_stress(depth))


@dataclass(frozen=True)
class Ground:
    """Layers from mudline to the bottom of the domain."""

    strata: tuple[Stratum, ...]

    @cached_property
    def lines(self) -> tuple[float, ...]:
        """Depths (m) where one layer ends and the next begins."""
        return tuple(each.top for each in self.strata[1:])

    @property
    def is_uniform(self) -> bool:
        """Whether all values are the same at all depths, but for the elastic ground."""
        return len(self.strata) == 1 + bool(self.strata[-1].like) and not self.strata[0].varies

    @property
    def total_stress(self) -> bool:
        """Whether all layers are undrained clay in total stress."""
        return all(each.total_stress for each in self.strata)

    def number(self, depth: np.ndarray) -> np.ndarray:
        """Return the number (...,) of the layer at each depth; a boundary belongs to the layer above it."""
        return np.searchsorted(np.array(self.lines) + _MERGED, depth, side="left")

    def value(self, name: str, depth: np.ndarray) -> np.ndarray:
        """Return a value of the soil at depths (...,), in SI."""
        return self._by_layer(depth, lambda stratum, z: stratum.value(name, z))

    def vertical_stress(self, depth: np.ndarray) -> np.ndarray:
        """Return the initial vertical effective stress (...,) in Pa, compression positive."""
        return self._by_layer(depth, Stratum.vertical_stress)

    def strength(self, depth: np.ndarray) -> np.ndarray:
        """Return what an adhesion factor refers to (...,) in Pa: su of undrained clay, the cohesion of another soil."""
        return self._by_layer(depth, Stratum.strength)

    def in_total_stress(self, depth: np.ndarray) -> np.ndarray:
        """Return whether each depth (...,) lies in undrained clay in total stress."""
        return np.array([each.total_stress for each in self.strata])[self.number(depth)]

    def holds_water(self, depth: np.ndarray, mode: str) -> np.ndarray:
        """Return whether pore pressures are unknown at each depth (...,) in a scene with this drainage.mode."""
        wet = [each.drainage_in(mode) in ("coupled", "undrained") for each in self.strata]
        return np.array(wet)[self.number(depth)]

    def _by_layer(self, depth: np.ndarray, of: Callable[[Stratum, np.ndarray], np.ndarray]) -> np.ndarray:
        depth = np.asarray(depth, dtype=float)
        if len(self.strata) == 1:
            return of(self.strata[0], depth)
        number, values = self.number(depth), np.empty(depth.shape)
        for k in np.unique(number):
            values[number == k] = of(self.strata[k], depth[number == k])
        return values


def in_layers(soil: Soil) -> Soil:
    """Return a soil in one form: a surcharge, and layers, one at the least, that have all their values."""
    layers = []
    for layer in soil.layers or (None,):
        law = (layer.law if layer else None) or soil.yield_surface
        given: dict[str, Any] = {"top": 0.0} if layer is None else {
            "top": layer.top, "name": layer.name, "drainage": layer.drainage,
        }  # fmt: skip
        given |= {"law": law, **dict.fromkeys(BY_LAYER), **values_of(soil, layer)}
        layers.append(Layer.model_construct(**given | dict.fromkeys(TABLES) | _tables(soil, layer, law)))
    return Soil.model_construct(surcharge=soil.surcharge, layers=tuple(layers))


def make_ground(soil: Soil, extent: Extent) -> Ground:
    """Return the ground of a soil; its layers must stand in order.

    A domain of automatic depth reaches far below the ground that matters. From ``extent.ground`` down the soil is
    elastic with the stiffness that it has there: strengths and stresses of a profile are not carried on without end.
    """
    layers = soil.layers
    strata, above = [], soil.surcharge
    for number, top, bottom in _places(soil, extent):
        layer = layers[number] if layers else None
        name, law = (layer.name, layer.law or soil.yield_surface) if layer else ("soil", soil.yield_surface)
        water = layer.drainage if layer else None
        strata.append(Stratum(number, name, law, top, bottom, above, values_of(soil, layer), drainage=water,
                              tables=_tables(soil, layer, law)))  # fmt: skip
        above = float(strata[-1].vertical_stress(np.array(bottom)))
    if extent.depth > extent.ground:
        strata.append(_elastic(strata[-1], extent.depth, above))
    return Ground(tuple(strata))


def _places(soil: Soil, extent: Extent) -> list[tuple[int, float, float]]:
    """Return number, top and bottom (m) of each layer that is modelled, boundaries near the tip moved onto it.

    Cells of the mesh stand on tip and boundaries: a sliver between two of them would decide the largest aspect ratio
    and often whether a run comes to its end. A layer thinner than `thinnest` belongs to the one below it, the last one
    to that above.
    """
    least = thinnest(extent)
    tops = [extent.tip if abs(each.top - extent.tip) <= least else each.top for each in soil.layers] or [0.0]
    places: list[tuple[int, float, float]] = []
    top = tops[0]
    for number, bottom in enumerate([*tops[1:], extent.ground]):
        if bottom - top > least or len(tops) == 1:
            places.append((number, top, bottom))
            top = bottom
    number, top, _ = places.pop() if places else (0, tops[0], 0.0)
    return [*places, (number, top, extent.ground)]


def thinnest(extent: Extent) -> float:
    """Return the thickness (m) below which two levels are one: 1 mm, or 0.1 % of the skirt length."""
    return max(1.0e-3, 1.0e-3 * extent.tip)


def moved_layers(soil: Soil, extent: Extent) -> list[str]:
    """Return a sentence on each layer whose top is moved, or that is too thin to be modelled."""
    places, least = {number: top for number, top, _ in _places(soil, extent)}, f"{1e3 * thinnest(extent):.9g} mm"
    texts = []
    for number, layer in enumerate(soil.layers):
        if number not in places:
            texts.append(f"layer '{layer.name}' is thinner than {least} and not modelled")
        elif places[number] != layer.top:
            where = " (the skirt tip)" if places[number] == extent.tip else ""
            to = f"moved to {places[number]:.9g} m{where}, less than {least} away"
            texts.append(f"layer '{layer.name}': its top at {layer.top:.9g} m is {to}")
    return texts


def _elastic(above: Stratum, bottom: float, stress: float) -> Stratum:
    """Return the elastic ground below a layer."""
    end = np.array(above.bottom)
    values: dict[str, Value] = {name: float(above.value(name, end)) for name in _OF_ELASTIC if name in above.values}
    with suppress(KeyError):  # a soil without what gives its stiffness is refused
        values["young_modulus"] = float(above.value("young_modulus", end))
    name = f"{above.name}, elastic"
    return Stratum(
        above.number, name, "elastic", above.bottom, bottom, stress, values, above.law, above.drainage
    )  # fmt: skip


def _tables(soil: Soil, layer: Layer | None, law: str) -> dict[str, Any]:
    """Return the tables of a layer that its law has, those of the soil where it gives none."""
    return given_values(soil, layer, [name for name in TABLES if name in SOIL_LAWS[law].keys])


def given_values(soil: Soil, layer: Layer | None, names: Iterable[str] = BY_LAYER) -> dict[str, Any]:
    """Return the values of a layer, those of the soil where it gives none; None for those that neither gives."""
    own = {name: getattr(layer, name, None) for name in names}
    return {name: getattr(soil, name) if value is None else value for name, value in own.items()}


def values_of(soil: Soil, layer: Layer | None) -> dict[str, Value]:
    """Return the values of a layer that its law uses; where the scene gives none those of the soil, then of the law."""
    law = SOIL_LAWS[(layer.law if layer else None) or soil.yield_surface]
    defaults = {**law.defaults, "hydraulic_conductivity": _UNUSED_CONDUCTIVITY}
    values: dict[str, Any] = {
        name: defaults.get(name) if value is None else value for name, value in given_values(soil, layer).items()
    }
    if values["K0"] == "auto":
        values["K0"] = at_rest(values[law.friction]) if values.get(law.friction) is not None else 1.0
    if values["friction_angle_initial"] == "auto":
        values["friction_angle_initial"] = max(law.least_friction(each) for each in _ends(values["K0"]))
    own = {name: getattr(layer, name, None) for name in STIFFNESSES}
    dropped = {each for each in STIFFNESSES if each != _stiffness(soil, own, law)}
    dropped |= {*LAW_KEYS} - {*law.keys, *law.unused, *STIFFNESSES}
    return {name: value for name, value in values.items() if value is not None and name not in dropped}


def at_rest(friction_angle: Value) -> float:
    """Return 1 - sin(phi), K0 of a normally consolidated soil (Jaky 1944); phi in rad, that at the top of a layer."""
    phi = friction_angle.top if isinstance(friction_angle, ByDepth) else friction_angle
    assert phi is not None
    return 1.0 - math.sin(phi)


def _ends(value: Value) -> tuple[float, ...]:
    """Return a number, or both ends of one that is linear in a layer."""
    if not isinstance(value, ByDepth):
        return (value,)
    assert value.top is not None and value.bottom is not None
    return value.top, value.bottom


def _stiffness(soil: Soil, own: dict[str, Any], law: SoilLaw) -> str:
    """Return the key that gives the stiffness: the layer's own, else that of the soil, Young's modulus last."""
    known = [name for name in STIFFNESSES if name in law.stiffnesses]
    for values in (own, {name: getattr(soil, name) for name in known[1:]}):
        for name in known:
            if values.get(name) is not None:
                return name
    return "young_modulus"
