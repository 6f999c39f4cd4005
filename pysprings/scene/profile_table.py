# SPDX-License-Identifier: MIT
"""Layers from a table: CSV or Excel with a row a layer, units in the headings.

Headings are `NAME [unit]`, or `NAME from [unit]` and `NAME to [unit]` for values that are linear in the layer, as in
groundhog's soil profiles: `Depth from [m]`, `Depth to [m]`, `Soil type`, parameters. `top [m]` and `bottom [m]` stand
for the depths, too; `law` chooses the law of a layer. A NAME is a key of [soil], with spaces or underscores, or one of
`NAMES`. A cell "[5, 25]" holds the values at top and bottom.

openpile's layers have `top` and `bottom` as elevations, `weight` (total), `Su`, `G0`, `phi` and `eps50` without units:
m, kN/m3, kPa, degrees.

A row with su, without law and friction angle, is Tresca clay, unless [soil] names a law of clay. A total unit weight
beside an effective one is not used.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import QuantityError, quoted, read, show, si_of
from pysprings.scene.by_depth import Profile
from pysprings.scene.fields import FROM_TOML, Number, Quantity, suggestion
from pysprings.scene.sections import BY_LAYER, Layer
from pysprings.scene.soil_laws import SOIL_LAWS

TOTAL = "total unit weight"  # less that of water it is the effective one
WATER = 9.81  # kN/m3
EPS50 = "eps50"  # axial strain at half of su in a triaxial test: two thirds of the engineering shear strain
# other names of the keys, in lower case
NAMES = {
    "depth from": "top", "depth to": "bottom", "top": "top", "bottom": "bottom",
    "soil type": "name", "soil": "name", "layer": "name", "name": "name",
    "law": "law", "constitutive law": "law", "yield surface": "law",
    "e": "young_modulus", "young's modulus": "young_modulus", "poisson's ratio": "poisson_ratio", "nu": "poisson_ratio",
    "phi": "friction_angle_final", "effective friction angle": "friction_angle_final",
    "friction angle": "friction_angle_final", "psi": "dilation_angle", "c": "cohesion",
    "submerged unit weight": "effective_unit_weight", "weight": TOTAL, "total unit weight": TOTAL,
    "gamma'": "effective_unit_weight", "k0": "K0", "permeability": "hydraulic_conductivity",
    "su": "undrained_shear_strength", "g0": "shear_modulus", "g": "shear_modulus", "eps50": EPS50,
}  # fmt: skip
_HEADING = re.compile(r"(?P<name>[^\[\]]+?)(?:\s+(?P<end>from|to))?\s*(?:\[(?P<unit>[^\[\]]*)\])?")
_PLAIN = ("name", "law")
# of openpile's columns, where no heading has a unit
_UNITS = {"top": "m", "bottom": "m", "weight": "kN/m^3", "su": "kPa", "g0": "kPa", "phi": "deg"}
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
_PURE = ("", "-", "1")
_ENDS = {"from": "top", "to": "bottom"}
_PERCENT = "%"
_IN_PERCENT = ("plasticity_index",)
_DEPTHS = ("top", "bottom")
MOST_ROWS = 100
MOST_BYTES = 1_000_000
_SAME = 1.0e-6  # m: depths closer than that are the same


@dataclass(frozen=True)
class Column:
    """A column: its heading, the key that it gives ("": none), "from", "to" or "", its unit, whether that is wrong."""

    head: str
    key: str
    end: str
    unit: str
    wrong: bool = False


def read_layers(file: Path, law: object = None) -> list[dict[str, Any]]:
    """Return the layers of a table as the scene file would hold them; ``law`` is that of [soil], if it names one.

    Raises
    ------
    UserInputError
        One problem per thing that is wrong with the table: file, line, column and value.
    """
    rows = _rows(file)
    if len(rows) < 2:
        raise UserInputError([Problem(str(file), message="holds no layers: expected a heading and a row a layer")])
    columns, wrong = _columns(rows[0], str(file))
    layers, ends = [], []
    for line, row in enumerate(_depths(columns, rows[1:]), 2):
        layer, faults = _layer(columns, row, str(file), line)
        wrong += faults
        if _is_clay(layer, law):
            layer["law"] = "tresca"
        layers.append(layer)
        ends.append((line, layer.pop("bottom", None)))
    wrong += _joints(layers, ends, str(file))
    if wrong:
        raise UserInputError(wrong)
    end = ends[-1][1]
    for value in layers[-1].values():
        if isinstance(value, dict) and "bottom" in value and end is not None:
            value["to"] = end
    return layers


def _rows(file: Path) -> list[list[str]]:
    """Return the cells of a table as texts, without empty rows."""
    try:
        if file.stat().st_size > MOST_BYTES:
            raise UserInputError([Problem(str(file), message="is too large for a profile (more than 1 MB)")])
        cells = _workbook(file) if file.suffix.lower() == ".xlsx" else _text(file)
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or "it is neither CSV in UTF-8 nor an Excel workbook"
        raise UserInputError([Problem(str(file), key="soil.profile", message=f"cannot be read: {reason}")]) from error
    rows = [[cell.strip() for cell in row] for row in cells if any(cell.strip() for cell in row)]
    if len(rows) > MOST_ROWS + 1:
        raise UserInputError([Problem(str(file), message=f"holds more than {MOST_ROWS} layers")])
    return rows


def _text(file: Path) -> list[list[str]]:
    text = file.read_text(encoding="utf-8-sig")
    head = text.split("\n", 1)[0]
    separator = max(",;\t", key=head.count)
    rows = list(csv.reader(text.splitlines(), delimiter=separator))
    return [[cell.replace(",", ".") for cell in row] for row in rows] if separator != "," else rows


def _workbook(file: Path) -> list[list[str]]:
    from zipfile import BadZipFile

    import openpyxl

    try:
        sheet = openpyxl.load_workbook(file, read_only=True, data_only=True).worksheets[0]
    except (BadZipFile, KeyError) as error:
        raise ValueError(str(error)) from error
    return [["" if cell is None else str(cell) for cell in row] for row in sheet.iter_rows(values_only=True)]


def _columns(heads: Sequence[str], file: str) -> tuple[list[Column], list[Problem]]:
    """Return the columns, and what is wrong with the headings."""
    plain = "weight" in [head.lower() for head in heads] and not any("[" in head for head in heads)
    columns, wrong = [], []
    for head in heads:
        column = _column(head, _UNITS if plain else {})
        if not column.key:
            known = [*NAMES, *(each.replace("_", " ") for each in BY_LAYER)]
            near = suggestion(head.partition("[")[0].strip().lower(), known) or ": no value of a layer; delete it"
            wrong.append(Problem(file, 1, key=head, message=f"unknown column{near}"))
        elif fault := _unit_fault(column):
            wrong.append(Problem(file, 1, key=head, message=fault))
            column = replace(column, unit="m") if column.key in _DEPTHS else replace(column, wrong=True)
        columns.append(column)
    if "top" not in [column.key for column in columns]:
        wrong.append(Problem(file, 1, message='no column "Depth from [m]" (or "top [m]")'))
    if "effective_unit_weight" in [column.key for column in columns]:
        columns = [replace(column, key="") if column.key == TOTAL else column for column in columns]
    return columns, [*wrong, *_repeated(columns, file)]


def _column(head: str, units: dict[str, str]) -> Column:
    """Return the column of a heading; ``units`` are those of names without one."""
    match = _HEADING.fullmatch(head)
    if match is None:
        return Column(head, "", "", "")
    name = " ".join(match["name"].split()).lower().replace("_", " ")
    whole = f"{name} {match['end']}" if match["end"] else name
    own = {each.lower().replace("_", " "): each for each in BY_LAYER}
    key = NAMES.get(whole) or NAMES.get(name) or own.get(name) or ""
    end = "" if whole in NAMES else match["end"] or ""
    return Column(head, key, end, (match["unit"] or units.get(name, "")).strip())


def _unit_fault(column: Column) -> str:
    """Return what is wrong with the unit of a heading, or nothing."""
    if column.key in _PLAIN:
        return ""
    if column.key in _DEPTHS:
        field: Any = Quantity("m", "", "", "2 m")
    elif column.key == EPS50:
        field = Number("", "", 0.01)
    else:
        key = "effective_unit_weight" if column.key == TOTAL else column.key
        field = next(each for each in Layer.model_fields[key].metadata if isinstance(each, Quantity | Number | Profile))
    quantity = field.quantity if isinstance(field, Profile) else field
    if isinstance(quantity, Number):
        return "" if column.unit in (*_PURE, _PERCENT) else f"[{column.unit}]: a pure number has no unit"
    if column.unit in _PURE:
        return f"expected a unit in the heading such as [{quantity.unit}]"
    try:
        read(f"1 {column.unit}", si_of(quantity.unit), quantity.example)
    except QuantityError as error:
        return str(error).replace(quoted(f"1 {column.unit}"), f"[{column.unit}]", 1)
    return ""


def _repeated(columns: Sequence[Column], file: str) -> Iterator[Problem]:
    """Give the columns whose value an earlier one has given."""
    ends: dict[str, list[str]] = {}
    for column in columns:
        known = ends.setdefault(column.key, [])
        if column.key and known and not (column.end and column.end not in known and "" not in known):
            yield Problem(file, 1, key=column.head, message=f"another column gives {column.key}, too")
        known.append(column.end)


def _is_clay(layer: dict[str, Any], law: object) -> bool:
    """Return whether a row without a law is Tresca clay: it has su, no friction angle, and [soil] no law of clay."""
    named = isinstance(law, str) and law in SOIL_LAWS and SOIL_LAWS[law].total_stress
    return "undrained_shear_strength" in layer and not {"law", "friction_angle_final"} & set(layer) and not named


def _depths(columns: Sequence[Column], rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the rows with elevations, which fall from row to row, turned into depths below the first top."""
    at = [n for n, column in enumerate(columns) if column.key in _DEPTHS]
    filled = [list(row) for row in rows]
    try:
        levels = [[float(row[n]) for n in at if n < len(row) and row[n]] for row in rows]
    except ValueError:
        return filled  # refused where the cell is read
    flat = [level for row in levels for level in row]
    if not flat or flat[0] == max(flat) == min(flat) or any(b > a for a, b in itertools.pairwise(flat)):
        return filled
    for row in filled:
        for n in at:
            if n < len(row) and row[n]:
                row[n] = repr(flat[0] - float(row[n]))
    return filled


def _layer(columns: Sequence[Column], row: Sequence[str], file: str, line: int) -> tuple[dict[str, Any], list[Problem]]:
    """Return a layer, `bottom` included, and what is wrong with its row."""
    layer: dict[str, Any] = {}
    wrong = []
    for column, cell in zip(columns, row, strict=False):
        if not column.key or not cell:
            continue
        try:
            read_as = replace(column, key="", unit="") if column.wrong else column
            value = cell if column.key in _PLAIN else _value(read_as, cell)
        except ValueError:
            wrong.append(Problem(file, line, key=column.key, message=f"expected a number, got {quoted(cell)}"))
            continue
        if column.wrong:
            continue  # its unit is refused already
        key = {TOTAL: "effective_unit_weight", EPS50: "strain_at_half_strength"}.get(column.key, column.key)
        if column.end:
            ends = layer.get(key)
            layer[key] = (ends if isinstance(ends, dict) else {}) | {_ENDS[column.end]: value}
        else:
            layer[key] = value
    if {"undrained_shear_strength", "friction_angle_final"} <= set(layer):
        text = "stands beside a friction angle: a layer has one of the two"
        wrong.append(Problem(file, line, key="undrained_shear_strength", message=text))
    return layer, [*wrong, *_refused(layer, file, line)]


def _value(column: Column, cell: str) -> Any:
    """Return a number with its unit, or the table of a pair "[top, bottom]"."""
    if cell[:1] in "[(":
        ends = _NUMBER.findall(cell)
        if len(ends) != 2:
            raise ValueError(cell)
        return {name: _value(column, end) for name, end in zip(("top", "bottom"), ends, strict=True)}
    number = float(cell)
    if column.key == TOTAL:
        return _submerged(number, column.unit)
    if column.unit == _PERCENT and column.key not in _IN_PERCENT:
        number /= 100.0
    if column.key == EPS50:
        number *= 1.5
    return number if column.unit in (*_PURE, _PERCENT) else f"{number!r} {column.unit}"


def _submerged(number: float, unit: str) -> str:
    """Return the effective unit weight of a total one."""
    total = read(f"{number!r} {unit}", "N/m^3")
    return show(round(total - 1e3 * WATER, 6), "kN/m^3")


def _refused(layer: dict[str, Any], file: str, line: int) -> Iterator[Problem]:
    """Give what the scene refuses of a layer."""
    checked = dict(layer)
    bottom = checked.pop("bottom", None)
    for values in (checked, {"top": bottom} if bottom is not None else {}):
        try:
            if values:
                Layer.model_validate(values, context=FROM_TOML)
        except ValidationError as error:
            for item in error.errors(include_url=False):
                key = "bottom" if values is not checked else str(item["loc"][0])
                message = item.get("ctx", {}).get("message", "missing" if item["type"] == "missing" else item["msg"])
                yield Problem(file, line, key=key, message=message)


def _joints(layers: Sequence[dict[str, Any]], ends: Sequence[tuple[int, Any]], file: str) -> Iterator[Problem]:
    """Check that each layer begins where the one above it ends."""
    for (line, bottom), below in zip(ends, layers[1:], strict=False):
        try:
            end, top = (read(str(each), "m") for each in (bottom, below.get("top")))
        except ValueError:
            continue  # refused already, or not given
        if abs(end - top) > _SAME:
            what = "overlap" if end > top else "leave a gap"
            text = f"the layers {what}: this one ends at {show(end, 'm')}, the next begins at {show(top, 'm')}"
            yield Problem(file, line, key="bottom", message=text)
