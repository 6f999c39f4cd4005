# SPDX-License-Identifier: MIT
"""What a scene does not give, with the values in its place, and what is unlikely in what it gives.

`pysprings check`, the summary of a run, its report and the heads of exported files take both from here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel

from pysprings.core.path_kinds import PATH_KINDS
from pysprings.core.units import read, show, si_of
from pysprings.scene.by_depth import ByDepth, Profile
from pysprings.scene.fields import Number, Quantity
from pysprings.scene.ground import Stratum, given_values, moved_layers
from pysprings.scene.plausible import implausible
from pysprings.scene.scene_sections import SceneSections
from pysprings.scene.sections import SoilValues
from pysprings.scene.soil_laws import SOIL_LAWS

Row = dict[str, Any]  # of a value by default: key, value (a number in `unit`, or a word), unit ("" of a word)
_SECTIONS = ("caisson", "domain", "interface", "drainage", "mesh", "solver", "limit")
_NUMERICAL = ("mesh.", "solver.", "limit.", "domain.", "interface.normal_stiffness", "interface.shear_stiffness")
_STEEL = ("young_modulus", "poisson_ratio")
_FLOW = ("transversal_conductivity", "residual_aperture")


def defaulted(scene: SceneSections, known: Mapping[str, float] | None = None) -> list[Row]:
    """Return a row for each value in use that the scene does not give.

    ``known`` are numbers in SI, by dotted key, for what stands as a word: the vertical load in N behind "balanced", the
    penalty stiffnesses in N/m3 behind "auto".
    """
    extent = scene.extent
    numbers = {"domain.radius": extent.radius, "domain.depth": extent.depth, **(known or {})}
    rows = []
    for name in _SECTIONS:
        section, unused = getattr(scene, name), _unused(scene, name)
        for key in type(section).model_fields:
            value = getattr(section, key)
            if key not in section.model_fields_set and key not in unused and value is not None:
                rows.append(row_of(f"{name}.{key}", numbers.get(f"{name}.{key}", value), type(section), key))
    return [*rows, *_of_soil(scene), *_of_paths(scene)]


def defaulted_text(rows: list[Row], numerical: bool = True) -> str:
    """Return the values by default on one line; of mesh, penalty, domain and solver only where ``numerical``."""
    shown = [row for row in rows if numerical or not row["key"].startswith(_NUMERICAL)]
    return ", ".join(f"{row['key']} {value_text(row)}" for row in shown)


def value_text(row: Row) -> str:
    """Return the value of a row with its unit."""
    value = row["value"]
    number = value if isinstance(value, str) else f"{value:.6g}"
    return f"{number} {row['unit']}".removesuffix(" 1").strip()


def remarks(scene: SceneSections) -> list[str]:
    """Return a sentence on each value beyond its common range, and on what the ground is made to be."""
    return [*moved_layers(scene.soil, scene.extent), *_without_strength(scene), *implausible(scene)]


def row_of(key: str, value: Any, model: type[BaseModel], name: str) -> Row:
    """Return the row of a value in SI, or of a word, of the field ``name`` of a section."""
    known = Quantity | Number | Profile
    field = next((each for each in model.model_fields[name].metadata if isinstance(each, known)), None)
    quantity = field.quantity if isinstance(field, Profile) else field
    if not isinstance(value, int | float) or isinstance(value, bool):
        return {"key": key, "value": str(value), "unit": ""}
    unit = quantity.unit if quantity else "1"
    scale = 1.0 if unit == "1" else read(f"1 {unit}", si_of(unit))
    return {"key": key, "value": float(f"{value / scale:.10g}"), "unit": unit}


def _unused(scene: SceneSections, name: str) -> tuple[str, ...]:
    """Return the keys of a section that the scene makes no use of."""
    strata, mode = scene.ground.strata, scene.drainage.mode
    wet = any(each.drainage_in(mode) in ("coupled", "undrained") for each in strata)
    flows = any(each.drainage_in(mode) == "coupled" for each in strata)
    if name == "caisson":
        return () if scene.caisson.behaviour == "elastic" else _STEEL
    if name == "domain":
        return () if wet else ("side_drainage",)
    if name == "interface":
        beside = [each for each in strata if each.top <= scene.caisson.skirt_length]
        frictionless = ("friction_coefficient",) * all(each.total_stress for each in beside)
        return (*(() if flows else _FLOW), *frictionless)
    if name == "drainage":
        dry = ("porosity", "water_bulk_modulus", "water_viscosity", "stabilisation", "water_unit_weight")
        return ("stabilisation",) if wet else dry
    forced = any(PATH_KINDS[path.kind].limited for path in scene.load_paths)
    return () if name != "limit" or forced else tuple(type(scene.limit).model_fields)


def _of_soil(scene: SceneSections) -> Iterator[Row]:
    """Yield values of the ground that neither [soil] nor a layer gives; one row where they are those of all layers."""
    soil = scene.soil
    if "surcharge" not in soil.model_fields_set:
        yield row_of("soil.surcharge", soil.surcharge, SoilValues, "surcharge")
    if "yield_surface" not in soil.model_fields_set and not all(layer.law for layer in soil.layers or (None,) if layer):
        yield row_of("soil.yield_surface", soil.yield_surface, SoilValues, "yield_surface")
    strata = [each for each in scene.ground.strata if not each.like]
    by_key: dict[str, dict[int, Any]] = {}
    for stratum in strata:
        for key, value in _defaults_in(scene, stratum):
            by_key.setdefault(key, {})[stratum.number] = value
    for key, values in by_key.items():
        if len(values) == len(strata) and len({str(each) for each in values.values()}) == 1:
            yield row_of(f"soil.{key}", next(iter(values.values())), SoilValues, key)
        else:
            for number, value in values.items():
                yield row_of(f"soil.layer[{number}].{key}", value, SoilValues, key)


def _defaults_in(scene: SceneSections, stratum: Stratum) -> Iterator[tuple[str, Any]]:
    layer = scene.soil.layers[stratum.number] if scene.soil.layers else None
    given, law = given_values(scene.soil, layer), SOIL_LAWS[stratum.law]
    for key in law.defaults:
        if given[key] is None and (key in law.keys or key in ("poisson_ratio", "K0")):
            value = stratum.values[key]
            yield key, "by depth" if isinstance(value, ByDepth) else value


def _of_paths(scene: SceneSections) -> Iterator[Row]:
    """Yield the heights of loads that paths do not give, and the path of a scene without any."""
    if not scene.paths and scene.springs.reach is None:
        (path,) = scene.load_paths
        yield {"key": "path", "value": f"{path.kind} to {show(path.lateral_displacement or 0.0, 'mm')}", "unit": ""}
    for path in scene.paths:
        if "arm" in PATH_KINDS[path.kind].uses and "arm" not in path.model_fields_set:
            yield row_of(f"path.{path.name}.arm", path.arm, type(path), "arm")


def _without_strength(scene: SceneSections) -> Iterator[str]:
    """Yield a remark on ground that has no strength at mudline."""
    first = scene.ground.strata[0]
    at = np.array(0.0)
    if first.above > 0.0 or not SOIL_LAWS[first.law].yields or float(first.strength(at)) > 0.0:
        return
    why = "su is 0 there" if first.total_stress else "soil.surcharge is 0, and it has no cohesion"
    yield f"layer '{first.name}' has no strength at mudline: {why}; a soil.surcharge stands for what lies on it"
