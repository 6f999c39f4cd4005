# SPDX-License-Identifier: MIT
"""What a scene does not give, with the values in its place, and what is unlikely in what it gives.

`pysprings check`, the summary of a run, its report and the heads of exported files take both from here.
A value that comes into its range when it is divided by 1000 or multiplied by it (by 10 else) is probably a slip of a
unit or a digit, and the sentence shows the value that was probably meant. 0 is a deliberate simplification.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from pydantic import BaseModel

from pysprings.core.path_kinds import LOADS, PATH_KINDS
from pysprings.core.units import read, show, si_of
from pysprings.scene.by_depth import ByDepth, of_surface
from pysprings.scene.fields import Interval
from pysprings.scene.ground import Stratum, given_values, moved_layers
from pysprings.scene.interface import adhesion_factor, holds_suction, without_suction
from pysprings.scene.layers import untaken
from pysprings.scene.scene_sections import SceneSections
from pysprings.scene.sections import SoilValues, plain_field
from pysprings.scene.soils import SOIL_LAWS
from pysprings.scene.soils.cyclic import CYCLIC

Row = dict[str, Any]  # of a value by default: key, value (a number in `unit`, or a word), unit ("" of a word)
_SECTIONS = ("caisson", "domain", "interface", "drainage", "mesh", "solver", "limit")
_NUMERICAL = ("mesh.", "solver.", "limit.", "domain.", "interface.normal_stiffness", "interface.shear_stiffness")
_STEEL = ("young_modulus", "poisson_ratio")
_BRICKS = "; bricks hold the nodes within it alone, a smaller patch: K_M was 4 to 17 % below that of series"
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
            if key == "water_depth" and value is None and holds_suction(scene):
                value = 0.0  # suction of a sealed surface ends at vapour pressure
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
    """Return a sentence on values beyond their common range, what the ground is made to be, and paths off a plane."""
    beyond = [path.name for path in scene.paths if path.in_space]
    off_plane = [f"off a plane, reactions of one mesh, not extrapolated: {', '.join(beyond)}"]
    of_ground = [*moved_layers(scene.soil, scene.extent), *_without_strength(scene), *_unknown(scene)]
    idle = (name for name in type(scene.soil).model_fields if name in untaken(scene.soil))
    of_ground += [f"soil.{name} has no effect: every layer has its own" for name in idle]
    of_ground += [*without_suction(scene), *_idle(scene), *implausible(scene)]
    bends = (
        "caisson.behaviour: loads act on a stiff patch of a quarter of the lid's radius, around which the lid bends as "
        f"a plate of {scene.caisson.lid_thickness:g} m without stiffeners: rotation, w, their "
        "stiffness and the point of rotation have that share, beside m, t and tip, too: the skirt turns and sinks less"
        f"{_BRICKS if scene.discretisation == 'hex8' else ''}"
    )
    return of_ground + ([bends] if scene.caisson.behaviour == "elastic" else []) + (off_plane if beyond else [])


def row_of(key: str, value: Any, model: type[BaseModel], name: str) -> Row:
    """Return the row of a value in SI, or of a word, of the field ``name`` of a section."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return {"key": key, "value": str(value), "unit": ""}
    unit = getattr(plain_field(name, model), "unit", "1")
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
        return () if flows else ("side_drainage",)
    if name == "interface":
        return (*(() if wet else _FLOW), *("friction_coefficient",) * _beside_clay(scene))
    if name == "drainage":
        dry = ("porosity", "water_bulk_modulus", "water_viscosity", "stabilisation")
        weight = () if holds_suction(scene) else ("water_unit_weight",)
        return ("stabilisation",) if wet else (*dry, *weight)
    forced = any(PATH_KINDS[path.kind].limited for path in scene.all_paths)
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
    ends = [law.derived(stratum, np.array(depth)) for depth in (stratum.top, stratum.bottom)]
    yield from ((key, value if value == ends[1][key] else "by depth") for key, value in ends[0].items())
    if law.gives_stiffness and not {"young_modulus", "shear_modulus"} & {*stratum.values}:
        yield "shear_modulus", "by density and stress"


def _of_paths(scene: SceneSections) -> Iterator[Row]:
    """Yield the heights of loads that paths do not give, and the path of a scene without any."""
    if not scene.paths and scene.springs.reach is None:
        (path,) = scene.load_paths
        yield {"key": "path", "value": f"{path.kind} to {show(path.lateral_displacement or 0.0, 'mm')}", "unit": ""}
    for path in scene.paths:
        if not path.given(LOADS) and "arm" in PATH_KINDS[path.kind].uses and "arm" not in path.model_fields_set:
            yield row_of(f"path.{path.name}.arm", path.arm, type(path), "arm")


def _beside_clay(scene: SceneSections) -> bool:
    return all(each.total_stress for each in scene.ground.strata if each.top <= scene.caisson.skirt_length)


def _idle(scene: SceneSections) -> Iterator[str]:
    """Yield a remark on keys of the fan and on friction that the scene gives and makes no use of."""
    springs = scene.springs
    given = [key for key in ("rays", "vertical_loads", "rates", "memory", "directions") if getattr(springs, key)]
    if given and springs.reach is None:
        yield f"springs.{', '.join(given)}: no effect, since there is no fan without springs.reach"
    elif len(springs.rates) > 1 and scene.drainage.mode != "coupled":
        yield f"springs.rates: no water flows in time: the paths are computed {len(springs.rates)} times, all the same"
    if _beside_clay(scene) and "friction_coefficient" in scene.interface.model_fields_set:
        yield "interface.friction_coefficient has no effect: beside undrained clay adhesion_factor limits the shear"


def _without_strength(scene: SceneSections) -> Iterator[str]:
    """Yield a remark on ground that has no strength at mudline."""
    first = scene.ground.strata[0]
    at = np.array(0.0)
    if first.above > 0.0 or not SOIL_LAWS[first.law].yields or float(first.strength(at)) > 0.0:
        return
    why = "su is 0 there" if first.total_stress else "soil.surcharge is 0, and it has no cohesion"
    yield f"layer '{first.name}' has no strength at mudline: {why}; a soil.surcharge stands for what lies on it"


def _unknown(scene: SceneSections) -> Iterator[str]:
    """Yield a remark where the values of the last layer are not known to a diameter below the skirt tip."""
    last, tip = scene.soil.layers[-1:], scene.caisson.skirt_length
    for layer in last:
        if layer.known_to is not None and layer.known_to < tip + scene.caisson.outer_diameter:
            known = f"layer '{layer.name}': its values are known to {layer.known_to:g} m and hold on below"
            yield f"{known}: the skirt tip stands at {tip:g} m, and the ground to a diameter below it carries"


# --- common ranges of every number of a scene, and a sentence on each value beyond its own ---

_STATIONS = 9
_SLIPS = (1e3, 1e-3, 10.0, 0.1)  # value over the one that was meant
_POISSON = 0.48


@dataclass(frozen=True)
class Range:
    """Common range of a number in ``unit``; ``scale`` is the unit in SI, ``what`` follows the name of the key."""

    low: float
    high: float
    unit: str = ""
    scale: float = 1.0
    what: str = ""


_DEG = math.radians(1.0)
# By dotted key. "/D", "/D2": over the diameter (-), over the area of the caisson (kPa).
RANGES = {
    "caisson.outer_diameter": Range(1.0, 40.0, "m"),
    "caisson.skirt_length": Range(0.1, 8.0, "diameters", what="/D"),
    "caisson.skirt_thickness": Range(0.0015, 0.02, "diameters", what="/D"),
    "caisson.lid_thickness": Range(0.01, 3.0, "m"),
    "caisson.young_modulus": Range(20.0, 220.0, "GPa", 1e9),
    "caisson.poisson_ratio": Range(0.1, 0.35),
    "caisson.vertical_load": Range(2.0, 1000.0, "kPa", 1e3, "/D2"),
    "domain.radius": Range(0.5, 200.0, "diameters", what="/D"),
    "domain.depth": Range(0.01, 400.0, "diameters", what="/D"),
    "soil.surcharge": Range(0.1, 100.0, "kPa", 1e3),
    "interface.friction_coefficient": Range(0.1, 0.8),
    "drainage.porosity": Range(0.2, 0.8),
    "drainage.water_bulk_modulus": Range(1e-3, 2.5, "GPa", 1e9),
    "drainage.water_unit_weight": Range(9.7, 10.4, "kN/m3", 1e3),
    "drainage.water_viscosity": Range(5e-4, 2e-3, "Pa s"),
    "drainage.water_depth": Range(0.5, 3000.0, "m"),
    "interface.transversal_conductivity": Range(1e-14, 1e-4, "m/(Pa s)"),
    "interface.residual_aperture": Range(1e-4, 1.0, "mm", 1e-3),
    "path.arm": Range(0.02, 20.0, "diameters", what="/D"),
    "path.lateral_displacement": Range(1e-5, 0.5, "diameters", what="/D"),
    "path.vertical_displacement": Range(1e-5, 0.5, "diameters", what="/D"),
    "path.rotation": Range(1e-4, 15.0, "deg", _DEG),
    "path.lateral_force": Range(0.1, 2000.0, "kPa", 1e3, "/D2"),
    "path.vertical_load": Range(2.0, 1000.0, "kPa", 1e3, "/D2"),
    "path.rate": Range(1e-6, 1e3, "mm/s", 1e-3),
    "springs.reach": Range(1e-4, 0.3, "diameters", what="/D"),
    "design.lateral_force": Range(0.1, 2000.0, "kPa", 1e3, "/D2"),
    "design.arm": Range(0.02, 20.0, "diameters", what="/D"),
}
# G/su: Eu/su of 200 to 1000 (Duncan & Buchignani 1976) is 65 to 350, small strains up to 2000; su/s'_v0: from normally
# consolidated clay (Jamiolkowski et al. 1985: 0.23 +- 0.04) to stiff clay
_RIGIDITY = Range(20.0, 2000.0)
_NORMALISED = Range(0.15, 10.0)
_ALPHA = Range(0.2, 1.0)


def implausible(scene: SceneSections) -> list[str]:
    """Return a sentence for each number of a scene that is beyond its common range."""
    found = [f"layer '{layer.name}': {layer.remark}" for layer in scene.soil.layers if layer.remark]
    found += [*_of_sections(scene), *_odd_paths(scene)]
    for stratum in (each for each in scene.ground.strata if not each.like):
        found += [*_of_stratum(stratum, scene.drainage.mode)]
        found += _of_clay(scene, stratum) if stratum.total_stress else ()
    return found


def _of_sections(scene: SceneSections) -> Iterator[str]:
    for key, common in RANGES.items():
        section, _, name = key.partition(".")
        if section == "path" or name not in getattr(scene, section).model_fields_set:
            continue
        yield from _number(scene, key, getattr(getattr(scene, section), name), common)
    if isinstance(load := scene.caisson.vertical_load, float) and load < 0.0:
        yield f"caisson.vertical_load: {show(load, 'MN')} pulls the caisson up: V is positive down"
    given = scene.springs.vertical_loads
    yield from (text for V in given for text in _number(scene, "springs.vertical_loads", V, _V))
    yield from (text for v in scene.springs.rates for text in _number(scene, "springs.rates", v, RANGES["path.rate"]))


_V = RANGES["caisson.vertical_load"]


def _odd_paths(scene: SceneSections) -> Iterator[str]:
    for path in scene.paths:
        kind = PATH_KINDS[path.kind]
        for key, common in RANGES.items():
            name = key.removeprefix("path.")
            if name != key and (name == kind.imposed or name not in ("lateral_displacement", "rotation")):
                yield from _number(scene, f"path.{path.name}.{name}", getattr(path, name), common)


def _number(scene: SceneSections, key: str, value: object, common: Range) -> Iterator[str]:
    """Yield a sentence on a number in SI; words and what is not given have none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return
    diameter = scene.caisson.outer_diameter
    over = {"": 1.0, "/D": diameter, "/D2": 0.25 * math.pi * diameter**2}[common.what]
    size = abs(value) / over / common.scale
    if text := _beyond(size, common):
        yield f"{key}: {text}{' (over the area of the caisson)' if common.what == '/D2' else ''}"


def _beyond(value: float, common: Range) -> str:
    """Return the words on a number beyond its range, with what was probably meant; empty for others."""
    if value == 0.0 or common.low * (1.0 - 1e-9) <= value <= common.high * (1.0 + 1e-9):
        return ""
    unit = f" {common.unit}" if common.unit else ""
    text = f"{value:.3g}{unit} is outside the common range {common.low:g} to {common.high:g}{unit}"
    meant = next((slip for slip in _SLIPS if common.low <= value / slip <= common.high), None)
    if meant is None:
        return text
    way = f"{meant:g} times too large" if meant > 1.0 else f"{1.0 / meant:g} times too small"
    return f"{text}: {way}? {value / meant:.3g}{unit} is inside"


def _of_stratum(stratum: Stratum, mode: str) -> Iterator[str]:
    """Yield sentences on the values of a layer that its law uses."""
    depth, unused = _depths(stratum), {*SOIL_LAWS[stratum.law].unused}
    unused |= set() if stratum.drainage_in(mode) == "coupled" else {"hydraulic_conductivity"}
    for name in dict.fromkeys(["shear_modulus", *stratum.values]):
        if (common := _common(name)) is not None and name not in unused:
            of = stratum.shear_modulus if name == "shear_modulus" else partial(stratum.value, name)
            yield from _worst(stratum, name, of, depth, common)


@cache
def _common(name: str) -> Range | None:
    """Return the common range of a key of a layer."""
    field = plain_field(name)
    if field.common is None:
        return None
    unit = field.unit.removeprefix("1")
    low, high = field.common
    return Range(low, high, unit, read(f"1 {unit}", si_of(unit)) if unit else 1.0)


def wrong_value(key: str, value: float) -> str:
    """Return what is wrong with a value of a layer (SI) that a table gives: outside what a scene takes, or a code."""
    field = plain_field(key)
    unit = field.unit.removeprefix("1")
    shown = f"{value / (read(f'1 {unit}', si_of(unit)) if unit else 1.0):.6g}"
    if not Interval(field.interval).holds(value, field.unit):
        return f"{key} {f'{shown} {unit}'.strip()} is not in {field.interval} {unit}".strip()
    common = _common(key)
    if common and re.fullmatch(r"9{3,}(?:\.(?:9+|25))?", shown) and _beyond(value / common.scale, common):
        return f"{key} {f'{shown} {unit}'.strip()} looks like a code for no value: leave the cell blank"
    return ""


def beyond_common(key: str, value: float) -> str:
    """Return the words on a value of a layer (SI) beyond its common range; empty for others."""
    common = _common(key)
    return _beyond(value / common.scale, common) if common else ""


def _of_clay(scene: SceneSections, stratum: Stratum) -> Iterator[str]:
    """Yield sentences on what goes together in a layer of undrained clay."""
    depth = _depths(stratum)
    yield from _worst(stratum, "G/su", lambda z: stratum.shear_modulus(z) / stratum.strength(z), depth, _RIGIDITY)
    if float(stratum.vertical_stress(depth).min()) > 0.0:
        ratio = "su over the vertical effective stress"
        yield from _worst(
            stratum, ratio, lambda z: stratum.strength(z) / stratum.vertical_stress(z), depth, _NORMALISED
        )
    falls = CYCLIC in SOIL_LAWS[stratum.law].keys or "strain_at_half_strength" in stratum.values  # along a backbone
    if "plasticity_index" in stratum.values and not falls:
        why = "plasticity_index gives G of small strains, which holds up to su without strain_at_half_strength"
        yield f"layer '{stratum.name}': {why}"
    if float(stratum.value("poisson_ratio", depth).min()) < _POISSON:
        yield f"layer '{stratum.name}': poisson_ratio below {_POISSON:g} lets undrained clay change its volume"
    beside = depth[depth <= scene.caisson.skirt_length]
    for side in ("outside", "inside") if len(beside) else ():
        if of_surface(scene.interface.adhesion_factor, side) is not None:
            factor = partial(adhesion_factor, scene.interface, stratum, side)
            yield from _worst(stratum, f"adhesion factor {side}", factor, beside, _ALPHA)


def _depths(stratum: Stratum) -> np.ndarray:
    """Return depths (m) inside a layer: at its ends some values are 0."""
    return stratum.top + (np.arange(_STATIONS) + 0.5) / _STATIONS * (stratum.bottom - stratum.top)


def _worst(
    stratum: Stratum, what: str, of: Callable[[np.ndarray], np.ndarray], depth: np.ndarray, common: Range
) -> Iterator[str]:
    """Yield a sentence on the least and the largest value in a layer where they are beyond the range."""
    value = np.asarray(of(depth)) / common.scale
    ends = {int(np.argmin(value)), int(np.argmax(value))}
    for k in sorted(ends):
        if text := _beyond(float(value[k]), common):
            yield f"layer '{stratum.name}': {what} at {depth[k]:.3g} m: {text}"
