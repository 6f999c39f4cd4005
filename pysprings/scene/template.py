# SPDX-License-Identifier: MIT
"""`pysprings init`: a commented scene from a template, and the JSON schema beside it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import refused

if TYPE_CHECKING:
    from pysprings.scene.sections import Section

_PROFILE = "CSV or Excel table of the layers, in place of [[soil.layer]]; its path is relative to the scene file"
FILE_NAME = "pysprings.schema.json"


def scene_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 7) of a scene file."""
    from pysprings.scene import fields, load, model

    title = model.Scene.model_fields["title"]
    properties: dict[str, Any] = {"title": {**fields.field_of(title).schema(), "default": title.default}}
    for name, section in load.SECTIONS.items():
        table = _table(section)
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
    from pysprings.scene import fields, sections
    from pysprings.scene.by_depth import ESTIMATE

    properties = {}
    for name, info in model.model_fields.items():
        if name == "layers":
            properties["layer"] = {"type": "array", "items": _table(sections.Layer)}
            properties["profile"] = {"type": "string", "description": _PROFILE, "examples": ["site.csv"]}
            properties["estimate"] = ESTIMATE
            continue
        field = fields.field_of(info)
        properties[name] = field.schema()
        if not info.is_required() and info.default is not None and not isinstance(field, fields.QuantityList):
            properties[name]["default"] = field.in_toml(info.default)
    required = [name for name, info in model.model_fields.items() if info.is_required()]
    about = " ".join((model.__doc__ or "").split())
    table = {"type": "object", "description": about, "additionalProperties": False, "properties": properties}
    return {**table, "required": required} if required else table


def _with_ranges(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the schema with a range in place of each value of the soil, too."""
    from pysprings.scene.by_depth import in_schema
    from pysprings.scene.sections import BY_LAYER

    soil = schema["properties"]["soil"]["properties"]
    for table in (soil, soil["layer"]["items"]["properties"]):
        table |= {key: in_schema(each) for key, each in table.items() if key in BY_LAYER}
    return schema


FOLDER = Path(__file__).parent / "templates"


def template_names() -> list[str]:
    """Return the names of the templates, sorted."""
    return sorted(file.stem for file in FOLDER.glob("*.toml"))


def template_text(name: str) -> str:
    """Return the text of a template, or refuse an unknown name."""
    from pysprings.core.text import suggestion

    known = template_names()
    if name not in known:
        hint = suggestion(name, known) or f" (there is: {', '.join(known)})"
        raise refused("--template", f"no template '{name}'{hint}")
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def write_scene(file: Path, template: str, force: bool = False) -> list[Path]:
    """Write a scene and its schema; an existing scene is refused, an existing schema kept, unless `force`.

    Returns the files written.
    """
    text = template_text(template)
    schema = file.with_name(FILE_NAME)
    if file == schema:
        raise refused(None, "is the name of the schema; choose another for the scene", file)
    if (file.exists() or file.is_symlink()) and not force:
        raise refused(None, "exists already; choose another name, or --force to replace it", file)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("w" if force else "x", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
        if schema.exists() and not force:
            return [file]
        text = json.dumps(_with_ranges(scene_schema()), indent=2, ensure_ascii=False)
        schema.write_text(f"{text}\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise refused(None, f"cannot be written ({error.strerror})", error.filename or file) from None
    return [file, schema]
