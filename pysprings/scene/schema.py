# SPDX-License-Identifier: MIT
"""JSON schema of a scene file, for editors: what TOML may hold, with units, ranges and defaults."""

from __future__ import annotations

from typing import Any

from pysprings.scene.fields import QuantityList
from pysprings.scene.load import SECTIONS
from pysprings.scene.model import Scene
from pysprings.scene.sections import Layer, Section
from pysprings.scene.toml import field_of

_PROFILE = "CSV or Excel table of the layers, in place of [[soil.layer]]; its path is relative to the scene file"
FILE_NAME = "pysprings.schema.json"


def scene_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 7) of a scene file."""
    title = Scene.model_fields["title"]
    properties: dict[str, Any] = {"title": {**field_of(title).schema(), "default": title.default}}
    for name, model in SECTIONS.items():
        table = _table(model)
        properties[name] = {"type": "array", "minItems": 1, "items": table} if name == "path" else table
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "pysprings scene",
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _table(model: type[Section]) -> dict[str, Any]:
    """Return the schema of one table."""
    properties = {}
    for name, info in model.model_fields.items():
        if name == "layers":
            properties["layer"] = {"type": "array", "items": _table(Layer)}
            properties["profile"] = {"type": "string", "description": _PROFILE, "examples": ["site.csv"]}
            continue
        field = field_of(info)
        properties[name] = field.schema()
        if not info.is_required() and info.default is not None and not isinstance(field, QuantityList):
            properties[name]["default"] = field.in_toml(info.default)
    required = [name for name, info in model.model_fields.items() if info.is_required()]
    about = " ".join((model.__doc__ or "").split())
    table = {"type": "object", "description": about, "additionalProperties": False, "properties": properties}
    return {**table, "required": required} if required else table
