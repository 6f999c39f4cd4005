# SPDX-License-Identifier: MIT
"""Layers from a table: CSV or Excel with a row a layer, or a row a depth, units in the headings.

Headings are `NAME [unit]`, or `NAME from [unit]` and `NAME to [unit]` for values that are linear in the layer, as in
groundhog's soil profiles: `Depth from [m]`, `Depth to [m]`, `Soil type`, parameters. `top [m]` and `bottom [m]` stand
for the depths, too; `law` chooses the law of a layer. A NAME is a key of [soil], with spaces or underscores, or one of
`NAMES`. A cell "[5, 25]" holds the values at top and bottom. A value with a range has the columns `NAME low [unit]`,
`NAME best [unit]` and `NAME high [unit]` (LE, BE, HE or UE, too), or `NAME low from [unit]`, `NAME low to [unit]` ...

With `depth [m]` in place of the ends of layers a row is a point, and values are linear between points. Two points at
one depth are a layer boundary; points on a straight line make one layer.

openpile's layers have `top` and `bottom` as elevations, `weight` (total), `Su`, `G0`, `phi` and `eps50` without units:
m, kN/m3, kPa, degrees.

A row with su, without law and friction angle, is Tresca clay, unless [soil] names a law of clay. A row with relative
density, without law, friction angle and su, is `sand`. A total unit weight beside an effective one is not used.
"""

import itertools
import re
import warnings
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Column, Table, TableNote, one_table, split
from pysprings.core.tables.files import is_blank
from pysprings.core.tables.headings import ANY, TEXT
from pysprings.core.units import quoted, show, si_of
from pysprings.core.words import ESTIMATES
from pysprings.scene.by_depth import disordered, is_range, picked
from pysprings.scene.fields import FROM_TOML, Number, Quantity
from pysprings.scene.sections import BY_LAYER, Layer, plain_field
from pysprings.scene.soils import SOIL_LAWS

TOTAL = "total_unit_weight"  # less that of water it is the effective one
WATER = 9.81e3  # N/m3
EPS50 = "eps50"  # axial strain at half of su in a triaxial test: two thirds of the engineering shear strain
VELOCITY = "shear_wave_velocity"
DENSITY = "relative_density"
# names of columns that are no keys of [soil], and other names of those, in lower case
NAMES: dict[str, tuple[str, ...]] = {
    "top": ("depth from", "z from", "top depth", "depth top", "from"),
    "bottom": ("depth to", "z to", "base", "bottom depth", "base depth", "depth bottom", "depth base", "to"),
    "depth": ("z", "depth below mudline", "depth below seabed"),
    "name": ("soil type", "soil", "layer", "soil unit", "unit", "material"),
    "law": ("constitutive law", "yield surface"),
    "young_modulus": ("e", "e'", "young's modulus", "youngs modulus"),
    "poisson_ratio": ("poisson's ratio", "poissons ratio", "nu", "nu'"),
    "friction_angle_final": ("phi", "phi'", "effective friction angle", "friction angle", "φ", "φ'"),
    "dilation_angle": ("psi", "dilatancy angle"), "cohesion": ("c", "c'", "effective cohesion"),
    "effective_unit_weight": ("submerged unit weight", "buoyant unit weight", "gamma'", "γ'"),
    "K0": ("k0",), "hydraulic_conductivity": ("permeability", "k"),
    "undrained_shear_strength": ("su", "cu", "s u", "c u"), "plasticity_index": ("pi", "ip"),
    "overconsolidation_ratio": ("ocr",), "rigidity_ratio": ("g/su", "g/cu", "rigidity index", "ir"),
    "shear_modulus": ("g0", "g", "gmax", "g max", "g 0", "small strain shear modulus"),
    "strain_at_half_strength": (),
    DENSITY: ("dr", "density index", "id", "d r"), "critical_friction_angle": ("phi cv", "phi cs", "phi crit"),
    TOTAL: ("weight", "bulk unit weight", "saturated unit weight", "gamma sat", "gamma bulk"),
    EPS50: ("epsilon 50",), VELOCITY: ("vs", "v s"),
}  # fmt: skip
_STRESSES = (
    "hydrostatic pressure", "pore pressure", "vertical effective stress", "vertical total stress", "effective stress",
    "total stress", "effective vertical stress", "overburden",
)  # fmt: skip
_UNUSED = (
    "water content", "w", "liquid limit", "plastic limit",
    "void ratio", "location identifier", "location", "borehole", "remarks", "comment", "comments",
    "description", "source",
)  # fmt: skip
_SKIPPED = {
    "stresses follow from the unit weights": _STRESSES, "no value of a layer": _UNUSED,
    "that of water counts 9.81 kN/m3": ("water unit weight", "gamma w"),
}  # fmt: skip
_UNSURE = {"unit weight": "total or effective? write 'Total unit weight' or 'Effective unit weight'"}
_UNSURE |= dict.fromkeys(("gamma", "bulk weight"), _UNSURE["unit weight"])
# of openpile's columns, where no heading has a unit
_UNITS = {"top": "m", "bottom": "m", "weight": "kN/m^3", "su": "kPa", "g0": "kPa", "phi": "deg"}
_KINDS = {
    "a CPT": ("qc", "qt", "fs", "rf", "u2", "cone resistance", "sleeve friction", "friction ratio", "ic"),
    "a list of laboratory tests": ("sample", "specimen", "test", "test type", "type", "su peak", "location", "bh"),
}
_STIFF = ("young_modulus", "shear_modulus", "rigidity_ratio")
_STRONG = ("friction_angle_final", "undrained_shear_strength", "cohesion", DENSITY)
# of the name of a column: key, estimate, end
_PARTS = re.compile(rf"(.+?)(?: ({'|'.join(ESTIMATES)}))?(?: (from|to))?")
_PAIR = re.compile(r"\s*[\[(]\s*([-+.\deE]+)\s*[,;]\s*([-+.\deE]+)\s*[\])]\s*")
# behind the key in the names of columns
_SHORT = {"low": ("le",), "best": ("be",), "high": ("he", "ue")}  # lower, best, higher or upper estimate
_COLUMN_PARTS = ("from", "to", *(f"{each}{end}" for each in ESTIMATES for end in ("", " from", " to")))
MOST_LAYERS = 100
REMARK, MOST_WORDS = "remark", 200  # of a layer, letters
WORDS = ("name", "law", REMARK)


def field_of(key: str) -> Quantity | Number:
    """Return the type of the values of a column: unit, interval, example."""
    if key in ("top", "bottom", "depth"):
        return Quantity("m", "[-1e4, 1e4]", "", "2 m")
    if key == VELOCITY:
        return Quantity("m/s", "(0, 1e4]", "", "200 m/s")
    if key == EPS50:
        return Number("", "", 0.01)
    field: Quantity | Number = plain_field("effective_unit_weight" if key == TOTAL else key)
    return field


@cache
def columns() -> tuple[Column, ...]:
    """Return the columns of a table of layers; a value has those of its ends, and of its range, too."""
    out = [Column(key, TEXT, NAMES.get(key, ())) for key in WORDS]
    for key in dict.fromkeys([*NAMES, *BY_LAYER]):
        if key in WORDS:
            continue
        field, names = field_of(key), NAMES.get(key, ())
        unit, percent = ("1", 1.0 if key == "plasticity_index" else 0.01) if isinstance(field, Number) else ("", 0.0)
        unit, example = unit or si_of(field.unit), "" if isinstance(field, Number) else field.unit
        out.append(Column(key, unit, names, example, "", percent))
        if key not in ("top", "bottom", "depth", VELOCITY):
            for part in _COLUMN_PARTS:
                first, *rest = part.split()
                parts = [" ".join([each, *rest]) for each in (first, *_SHORT.get(first, ()))]
                others = tuple(f"{name} {each}" for name in (key.replace("_", " "), *names) for each in parts)
                out.append(Column(f"{key} {part}", unit, others, example, "", percent))
    for why, names in _SKIPPED.items():
        out += [Column(name, ANY, (f"{name} from", f"{name} to"), skipped=why) for name in names]
    return tuple(out)


def key_of(name: str) -> str | None:
    """Return the key of [soil] for another name of it: "phi" is friction_angle_final."""
    low = name.lower().replace("_", " ")
    return next((key for key, names in NAMES.items() if low in names and key in BY_LAYER), None)


def read_layers(file: Path, soil: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Return the layers of a table as the scene file would hold them; ``soil`` are the values of [soil].

    Raises UserInputError: one problem per thing that is wrong with the table: file, line, column and value.
    """
    soil = soil or {}
    _refuse_others(file)
    table = one_table(file, columns(), "layers", _assumed)
    _refuse_kinds(table)
    if not len(table):
        raise UserInputError([Problem(str(file), message="holds no layers: expected a heading and a row a layer")])
    _split_pairs(table)
    _leave_out_words(table)
    _check_columns(table, soil)
    values = {name: table.numbers(name, most=False) for name in table.columns if name not in WORDS}
    ends = row_ends(table, values)
    _check_units(table, values, ends)
    layers = [_layer(table, values, k) for k in range(len(table))]
    for layer, text in zip(layers, table.texts(REMARK) if "top" in table else (), strict=False):
        layer |= {REMARK: text[:MOST_WORDS]} if text else {}
    if "depth" in table and "top" not in table:
        table.faults.stop()
        layers, ends = between(table, layers, ends[0])
    beside: list[str] = []
    for k, layer in enumerate(layers):
        layer["top"] = show(float(np.nan_to_num(ends[0][k])), "m")
        if {"undrained_shear_strength", "friction_angle_final"} <= set(layer):
            text = "stands beside a friction angle: a layer has one of the two"
            table.fault(min(k, len(table) - 1), "undrained_shear_strength", text)
        _check_layer(table, layer, k)
        if _is_clay(layer, soil.get("yield_surface")):
            layer["law"] = "tresca"
        if DENSITY in layer and not _is_sand(layer, soil):
            del layer[DENSITY]
            beside.append(str(layer.get("name", k + 1)))
    if beside:
        text = f"relative density of {', '.join(beside)} (law sand has no other strength beside it)"
        warnings.warn(f"{table.place}: not used: {text}", TableNote, stacklevel=2)
    check_joints(table, *ends)
    if len(layers) > MOST_LAYERS:
        table.faults.add((table.place, None), None, f"holds {len(layers)} layers, at most {MOST_LAYERS}: join some")
    table.faults.stop()
    if np.isfinite(ends[1][-1]):
        layers[-1]["known_to"] = show(float(ends[1][-1]), "m")
        for value in layers[-1].values():
            for each in value.values() if is_range(value) else (value,):
                if isinstance(each, dict):
                    each["to"] = show(float(ends[1][-1]), "m")
    return layers


def _assumed(head: Sequence[str]) -> Mapping[str, str]:
    """Return the units of openpile's columns where no heading has a unit."""
    plain = "weight" in [text.lower() for text in head] and not any("[" in text or "(" in text for text in head)
    return _UNITS if plain else {}


def _refuse_others(file: Path) -> None:
    """Refuse files of soil investigations in formats of their own."""
    try:
        with file.open("rb") as stream:
            start = stream.read(2000).decode("latin-1").lstrip("\ufeff").lstrip()
    except OSError:
        return  # refused by the reader
    if start.upper().startswith("#GEFID") or re.match(r'"?GROUP"?,"?SCPT', start):
        raise _is_kind(str(file), "a CPT")
    if re.match(r'"?GROUP"?,', start):
        raise _is_kind(str(file), "an AGS file")


def _refuse_kinds(table: Table) -> None:
    """Refuse tables of measurements by their headings."""
    stems = {next(split(text))[0].lower() for text in table.head} - {""}
    for kind, names in _KINDS.items():
        if len(stems & set(names)) >= 2:
            raise _is_kind(table.place, kind)
    for text in table.head:
        if why := _UNSURE.get(next(split(text))[0].lower()):
            table.faults.problems = [each for each in table.faults.problems if each.key != f'"{text}"']
            table.faults.problems.append(Problem(table.place, table.head_line, key=f'"{text}"', message=why))


def _is_kind(place: str, kind: str) -> UserInputError:
    what = "`pysprings ground FILE --out site.csv` makes one of it; or write one with a row a layer: Depth from [m], " \
           "Depth to [m], unit weight, strength and stiffness"  # fmt: skip
    return UserInputError([Problem(place, key="soil.profile", message=f"is {kind}, no table of layers: {what}")])


def _split_pairs(table: Table) -> None:
    """Put the second number of cells "[5, 25]" into a column of its own."""
    for name, (k, heading) in list(table.columns.items()):
        found = {n: _PAIR.fullmatch(cell) for n, cell in enumerate(table.cells(name)) if isinstance(cell, str)}
        if not any(found.values()):
            continue
        table.columns[f"{name} to"] = (len(table.head), heading)
        table.wrong |= {f"{name} to"} if name in table.wrong else set()
        table.head.append("")
        for n, row in enumerate(table.rows):
            row += [None] * (len(table.head) - len(row))
            if pair := found.get(n):
                row[k], row[-1] = float(pair[1]), float(pair[2])


def _leave_out_words(table: Table) -> None:
    """Leave out a column of relative density in words: "medium dense"."""
    for name in [each for each in table.columns if _parts(each)[0] == DENSITY]:
        if any(isinstance(cell, str) and re.search("[a-z]{4}", cell.lower()) for cell in table.cells(name)):
            warnings.warn(f"{table.place}: not used: {quoted(table.key(name))} (words)", TableNote, stacklevel=2)
            del table.columns[name]


def _check_columns(table: Table, soil: Mapping[str, Any]) -> None:
    """Note missing and repeated columns, and a table whose rows give neither stiffness nor strength."""
    parts = {name: _parts(name) for name in table.columns}
    keys = {key for key, _, _ in parts.values()}
    if not keys & {"top", "depth"}:
        table.fault(None, None, 'no column "Depth from [m]" (or "top [m]", or "depth [m]" of points)')
    if {"top", "depth"} <= keys:
        table.fault(None, "depth", "stands beside the ends of layers: keep one of them")
    for key in keys - {"top", "bottom", "depth"}:
        given = {estimate for other, estimate, _ in parts.values() if other == key}
        for estimate in sorted(given):
            _check_ends(table, f"{key} {estimate}".rstrip())
        if any(given) and given != set(ESTIMATES):
            missing = [each for each in ESTIMATES if each not in given]
            what = f"needs a column '{key} {missing[0]}' beside it" if missing else "another column gives it, too"
            table.fault(None, next(name for name in parts if parts[name][0] == key), what)
    if VELOCITY in keys and TOTAL not in keys:
        table.fault(None, VELOCITY, "needs the total unit weight beside it: G = rho Vs^2")
    given = keys | set(soil) | {"shear_modulus" if VELOCITY in keys else ""}
    if not table.faults.problems and not given & {*_STIFF, *_STRONG, "law"}:
        table.fault(None, None, "no column gives stiffness or strength: names and unit weights alone are no ground")


def _parts(name: str) -> tuple[str, str, str]:
    """Return key, estimate and end of a column; blank for none."""
    key, estimate, end = _PARTS.fullmatch(name).groups()  # type: ignore[union-attr]
    return str(key), estimate or "", end or ""


def _check_ends(table: Table, stem: str) -> None:
    """Note an end of a value without the other, and ends beside one value for the whole layer."""
    if stem in table and f"{stem} from" in table:
        table.fault(None, f"{stem} from", f"another column gives {stem}, too")
    ends = (f"{stem} from", f"{stem} to")
    for end, other in (ends, ends[::-1]):
        if end in table and other not in table and stem not in table:
            table.fault(None, end, f"needs a column '{other}' beside it")


def row_ends(table: Table, values: dict[str, Array]) -> tuple[Array, Array]:
    """Return top and bottom of each row [m]; elevations, which fall from row to row, are depths below the first."""
    none = np.full(len(table), np.nan)
    top = values.get("top", values.get("depth", none))
    name = "top" if "top" in table else "depth"
    for k in np.flatnonzero(np.isnan(top)).tolist() if name in table else ():
        table.fault(k, name, "blank")
    ends = np.stack([top, values.get("bottom", none)], axis=1)
    flat = ends[np.isfinite(ends)]
    if flat.size and flat.min() < min(flat.max(), 0.0) and not (np.diff(flat) > 0.0).any():
        if abs(flat[0]) > SAME:
            text = f"{table.place}: elevations: the first one, {flat[0]:g} m, is taken as mudline"
            warnings.warn(text, TableNote, stacklevel=2)
        ends = flat[0] - ends
    return ends[:, 0], ends[:, 1]


def _check_units(table: Table, values: Mapping[str, Array], ends: tuple[Array, Array]) -> None:
    """Note depths and moduli whose unit is wrong: no ground ends there, none yields at a strain of 1."""
    name = next((each for each in ("bottom", "top") if each in table), "depth")
    depths = np.nan_to_num(ends[1] if name == "bottom" else ends[0])
    for k in np.flatnonzero(depths > DEEPEST).tolist():
        table.fault(k, name, f"{show(float(depths[k]), 'm')} below mudline: is the unit of the depths right?")
    if 0.0 < depths.max() < SHALLOWEST:
        end = f"the table ends {show(float(depths.max()), 'm')} below mudline"
        table.fault(int(depths.argmax()), name, f"{end}: is the unit of the depths right?")
    for stiff, column in values.items():
        key, estimate, end = _parts(stiff)
        stem = f"undrained_shear_strength {estimate}".rstrip()
        strong = [each for each in (f"{stem} {end}".rstrip(), stem, f"{stem} from") if each in values]
        su = values[strong[0]] if strong and key in _STIFF[:2] else np.full(len(table), np.nan)
        for k in np.flatnonzero(column < su).tolist():
            stiffness, strength = show(float(column[k]), "kPa"), show(float(su[k]), "kPa")
            table.fault(k, stiff, f"{stiffness} is below su, {strength}: is its unit right?")


def _layer(table: Table, values: dict[str, Array], k: int) -> dict[str, Any]:
    """Return the values of a row, without its depths."""
    layer: dict[str, Any] = {each: text for each in ("name", "law") if (text := table.texts(each)[k])}
    row = {name: float(column[k]) for name, column in values.items() if np.isfinite(column[k])}
    for key, estimate in dict.fromkeys(_parts(name)[:2] for name in row):
        if key in ("top", "bottom", "depth", VELOCITY):
            continue
        if key == TOTAL and any(each.startswith("effective_unit_weight") for each in row):
            continue
        value = _value(table, row, k, key, estimate)
        target = {TOTAL: "effective_unit_weight", EPS50: "strain_at_half_strength"}.get(key, key)
        if value is not None and estimate:
            three = layer.setdefault(target, {})
            if is_range(three) or not three:
                three[estimate] = value
        elif value is not None:
            layer.setdefault(target, value)
    for key, value in layer.items():
        for missing in set(ESTIMATES) - set(value) if is_range(value) else ():
            table.fault(
                k, _name_of(table, key, missing), "a value of the range is blank: fill in low, best and high, or none"
            )
    if VELOCITY in row and not {"shear_modulus", "young_modulus"} & set(layer):
        if TOTAL in row:
            stiffness = row[TOTAL] / WATER * 1000.0 * row[VELOCITY] ** 2
            layer["shear_modulus"] = show(float(f"{stiffness:.12g}"), "MPa")
        else:
            table.fault(k, VELOCITY, "needs the total unit weight beside it: G = rho Vs^2")
    return layer


def _value(table: Table, row: Mapping[str, float], k: int, key: str, estimate: str) -> Any:
    """Return a value of row k as the scene file would hold it; None where one end of it is blank, which is noted."""
    stem = f"{key} {estimate}".rstrip()
    first, last = row.get(stem, row.get(f"{stem} from")), row.get(f"{stem} to")
    if first is None or (last is None and stem not in row):
        missing = f"{stem} from" if first is None else f"{stem} to"
        if is_blank(table.cells(missing)[k]):
            table.fault(k, missing, "blank beside the value at the other end of the layer")
        return None
    value = _text(key, first)
    return value if last is None else {"top": value, "bottom": _text(key, last)}


def _text(key: str, value: float) -> float | str:
    """Return a value as the scene file would hold it."""
    field = field_of(key)
    if key == EPS50:
        value *= 1.5
    if key == TOTAL:
        value = round(value - WATER, 6)
    return float(f"{value:.15g}") if isinstance(field, Number) else show(value, field.unit)


def _is_clay(layer: dict[str, Any], law: object) -> bool:
    """Return whether a row without a law is Tresca clay: it has su, no friction angle, and [soil] no law of clay."""
    named = isinstance(law, str) and law in SOIL_LAWS and SOIL_LAWS[law].total_stress
    return "undrained_shear_strength" in layer and not {"law", "friction_angle_final"} & set(layer) and not named


def _is_sand(layer: dict[str, Any], soil: Mapping[str, Any]) -> bool:
    """Return whether the relative density of a row counts: it has law sand, which a row without other strength gets."""
    law = soil.get("yield_surface")
    if (
        "law" not in layer
        and law != "sand"
        and {"friction_angle_final", "undrained_shear_strength"}.isdisjoint({*layer, *soil})
    ):
        layer["law"] = "sand"
    return bool(layer.get("law", law) == "sand")


def _check_layer(table: Table, layer: dict[str, Any], k: int) -> None:
    """Note what the scene refuses of a layer, with each estimate of its ranges."""
    for keys, message in disordered(layer):
        table.fault(min(k, len(table) - 1), _name_of(table, str(keys[0]), "low"), message)
    for estimate in ESTIMATES if any(map(is_range, layer.values())) else ESTIMATES[1:2]:
        try:
            Layer.model_validate(picked(layer, estimate), context=FROM_TOML)
        except ValidationError as error:
            for item in error.errors(include_url=False):
                key = str(item["loc"][0])
                message = item.get("ctx", {}).get("message", "missing" if item["type"] == "missing" else item["msg"])
                name = _name_of(table, key, estimate if is_range(layer.get(key)) else "")
                table.fault(min(k, len(table) - 1), name, message)


def _name_of(table: Table, key: str, estimate: str = "") -> str:
    """Return the column that gives a key of a layer, or an estimate of it."""
    others = {"effective_unit_weight": TOTAL, "strain_at_half_strength": EPS50, "shear_modulus": VELOCITY,
              "top": "depth"}  # fmt: skip
    own = [name for name in table.columns if _parts(name)[0] in (key, others.get(key, key))]
    return next((name for name in own if _parts(name)[1] == estimate), own[0] if own else key)


def check_joints(table: Table, tops: Array, bottoms: Array) -> None:
    """Note layers that do not begin where the one above them ends."""
    if "bottom" not in table:
        for k in np.flatnonzero(np.diff(tops) <= 0.0).tolist() if "top" in table else ():
            table.fault(k + 1, "top", "is not below the layer above it")
        return
    for k, (end, top) in enumerate(zip(bottoms, tops[1:], strict=False)):
        if abs(end - top) > SAME:
            what = "overlap" if end > top else "leave a gap"
            text = f"the layers {what}: this one ends at {show(end, 'm')}, the next begins at {show(top, 'm')}"
            table.fault(k, "bottom", text)


DEEPEST, SHALLOWEST = 1.0e3, 0.1  # m, ends of tables of ground
SAME = 1.0e-6  # m: depths closer than that are the same
_STRAIGHT = 1.0e-9  # share of a value by which a point may be off the straight line through its neighbours


def between(table: Table, points: list[dict[str, Any]], depth: Array) -> tuple[list[dict[str, Any]], Any]:
    """Return the layers between points, linear, and their ends; the first value holds up to mudline."""
    for k in np.flatnonzero(np.diff(depth) < 0.0).tolist():
        table.fault(k + 1, "depth", "is above the point before: depths of points grow")
    if any(table.texts(REMARK)):
        warnings.warn(f"{table.place}: remarks of points are not used: those of layers are", TableNote, stacklevel=3)
    layers: list[dict[str, Any]] = []
    spans: list[tuple[float, float]] = []
    for k, (above, below) in enumerate(itertools.pairwise(points)):
        if depth[k + 1] - depth[k] <= SAME:
            continue
        layer = {name: value for name, value in above.items() if name in ("name", "law")}
        for name in dict.fromkeys([*above, *below]):
            if (name in above) != (name in below) and name not in ("name", "law"):
                where = k + 1 if name in above else k
                table.fault(where, name, "blank, and not at the next point: write two points at a layer boundary")
            elif name not in ("name", "law"):
                layer[name] = _line(above[name], below[name])
        if layers and spans[-1][1] == depth[k] and _is_straight(layers[-1], layer, spans[-1], float(depth[k + 1])):
            for one, other in zip(_values(layers[-1]).values(), _values(layer).values(), strict=True):
                if isinstance(other, dict):
                    one["bottom"] = other["bottom"]
            spans[-1] = (spans[-1][0], float(depth[k + 1]))
        else:
            layers.append(layer)
            spans.append((float(depth[k]), float(depth[k + 1])))
    table.faults.stop()
    if not layers:
        table.fault(None, "depth", "needs two points at least")
        table.faults.stop()
    if spans[0][0] > 0.0:
        what = f"{table.place}: the values of the first point, at {spans[0][0]:g} m, hold up to mudline"
        warnings.warn(what, TableNote, stacklevel=2)
        first = {name: points[0].get(name, value) for name, value in layers[0].items()}
        layers.insert(0, first)
        spans.insert(0, (0.0, spans[0][0]))
    return layers, tuple(np.array(spans).T)


def _line(above: Any, below: Any) -> Any:
    """Return what is linear between two values, or between those of each estimate of a range."""
    if is_range(above) and is_range(below):
        return {each: _line(above.get(each), below.get(each)) for each in above}
    return above if above == below else {"top": above, "bottom": below}


def _values(layer: dict[str, Any]) -> dict[tuple[str, str], Any]:
    """Return the values of a layer by key and estimate, which is blank where there is no range."""
    ranges = {name: value if is_range(value) else {"": value} for name, value in layer.items()}
    return {(name, estimate): value for name, inner in ranges.items() for estimate, value in inner.items()}


def _is_straight(one: dict[str, Any], other: dict[str, Any], span: tuple[float, float], end: float) -> bool:
    """Return whether a layer goes on in the line of the one above it."""
    above, below = _values(one), _values(other)
    if above.keys() != below.keys():
        return False
    for name, value in above.items():
        next_value = below[name]
        if isinstance(value, dict) != isinstance(next_value, dict):
            return False
        if not isinstance(value, dict):
            if value != next_value:
                return False
            continue
        top, middle, bottom = (_size(each) for each in (value["top"], value["bottom"], next_value["bottom"]))
        line = top + (bottom - top) * (span[1] - span[0]) / (end - span[0])
        if _size(next_value["top"]) != middle or abs(line - middle) > _STRAIGHT * max(abs(top), abs(bottom)):
            return False
    return True


def _size(value: float | str) -> float:
    return float(value.split()[0]) if isinstance(value, str) else value
