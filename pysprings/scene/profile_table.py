# SPDX-License-Identifier: MIT
"""Layers from a table: CSV or Excel with a row a layer, units in the headings.

Headings are `NAME [unit]`, or `NAME from [unit]` and `NAME to [unit]` for values that are linear in the layer, as in
groundhog's soil profiles: `Depth from [m]`, `Depth to [m]`, `Soil type`, parameters. `top [m]` and `bottom [m]` stand
for the depths, too; `law` chooses the law of a layer. A NAME is a key of [soil], with spaces or underscores, or one of
`NAMES`. A cell "[5, 25]" holds the values at top and bottom.

openpile's layers have `top` and `bottom` as elevations, `weight` (total) and `Su` without units: m, kN/m3 and kPa.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import quoted
from pysprings.scene.fields import FROM_TOML, suggestion
from pysprings.scene.sections import BY_LAYER, Layer

TOTAL = "total unit weight"  # less that of water it is the effective one
WATER = 9.81  # kN/m3
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
    "su": "undrained_shear_strength",
}  # fmt: skip
_HEADING = re.compile(r"(?P<name>[^\[\]]+?)(?:\s+(?P<end>from|to))?\s*(?:\[(?P<unit>[^\[\]]*)\])?")
_PLAIN = ("name", "law")
_UNITS = {"top": "m", "bottom": "m", "weight": "kN/m^3", "su": "kPa"}  # of openpile's columns, where a heading has none
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
_PURE = ("", "-", "1")
MOST_ROWS = 100
MOST_BYTES = 1_000_000
_SAME = 1.0e-6  # m: depths closer than that are the same


def read_layers(file: Path) -> list[dict[str, Any]]:
    """Return the layers of a table as the scene file would hold them.

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


def _columns(heads: Sequence[str], file: str) -> tuple[list[tuple[str, str, str]], list[Problem]]:
    """Return (key, "from", "to" or "", unit) of each column, and what is wrong with the headings."""
    columns, wrong = [], []
    units = _UNITS if "weight" in [head.lower() for head in heads] and not any("[" in head for head in heads) else {}
    for head in heads:
        match = _HEADING.fullmatch(head)
        name = " ".join(match["name"].split()).lower().replace("_", " ") if match else ""
        whole = f"{name} {match['end']}" if match and match["end"] else name
        end = "" if match is None or whole in NAMES else match["end"] or ""
        key = (
            NAMES.get(whole) or NAMES.get(name) or {each.lower().replace("_", " "): each for each in BY_LAYER}.get(name)
        )
        if match is None or key not in {*BY_LAYER, "top", "bottom", TOTAL, *_PLAIN}:
            known = [*NAMES, *(each.replace("_", " ") for each in BY_LAYER)]
            wrong.append(Problem(file, 1, key=head, message=f"unknown column{suggestion(name, known)}"))
            key = ""
        columns.append((key or "", end, (match["unit"] or units.get(name, "")).strip() if match else ""))
    if "top" not in [key for key, _, _ in columns]:
        wrong.append(Problem(file, 1, message='no column "Depth from [m]" (or "top [m]")'))
    return columns, wrong


def _depths(columns: Sequence[tuple[str, str, str]], rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the rows with elevations, which fall from row to row, turned into depths below the first top."""
    at = [n for n, (key, _, _) in enumerate(columns) if key in ("top", "bottom")]
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


def _layer(
    columns: Sequence[tuple[str, str, str]], row: Sequence[str], file: str, line: int
) -> tuple[dict[str, Any], list[Problem]]:
    """Return a layer, `bottom` included, and what is wrong with its row."""
    layer: dict[str, Any] = {}
    wrong = []
    for (key, end, unit), cell in zip(columns, row, strict=False):
        if not key or not cell:
            continue
        try:
            value = cell if key in _PLAIN else _value(cell, unit)
        except ValueError:
            wrong.append(Problem(file, line, key=key, message=f"expected a number, got {quoted(cell)}"))
            continue
        if key == TOTAL:
            key, value = "effective_unit_weight", _submerged(cell, unit)
        if end:
            layer.setdefault(key, {})["top" if end == "from" else "bottom"] = value
        else:
            layer[key] = value
    return layer, [*wrong, *_refused(layer, file, line)]


def _value(cell: str, unit: str, less: float = 0.0) -> Any:
    """Return a number with its unit, or the table of a pair "[top, bottom]"; ``less`` is taken off, in the unit."""
    if cell[:1] in "[(":
        ends = _NUMBER.findall(cell)
        if len(ends) != 2:
            raise ValueError(cell)
        return {name: _value(end, unit, less) for name, end in zip(("top", "bottom"), ends, strict=True)}
    number = float(cell) - less
    return number if unit in _PURE else f"{number!r} {unit}"


def _submerged(cell: str, unit: str) -> Any:
    """Return the effective unit weight from a total one; in another unit than kN/m3 it is refused as it stands."""
    return _value(cell, unit, WATER if unit.replace("^", "").replace("³", "3") == "kN/m3" else math.inf)


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
    from pysprings.core.units import read, show

    for (line, bottom), below in zip(ends, layers[1:], strict=False):
        try:
            end, top = (read(str(each), "m") for each in (bottom, below.get("top")))
        except ValueError:
            continue  # refused already, or not given
        if abs(end - top) > _SAME:
            what = "overlap" if end > top else "leave a gap"
            text = f"the layers {what}: this one ends at {show(end, 'm')}, the next begins at {show(top, 'm')}"
            yield Problem(file, line, key="bottom", message=text)
