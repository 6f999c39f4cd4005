# SPDX-License-Identifier: MIT
"""A scene as TOML text, with units, such that loading it gives an equal scene."""

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from pysprings.scene.fields import Field, QuantityList, field_of
from pysprings.scene.scene_sections import SceneSections


def to_toml(scene: SceneSections) -> str:
    """Write every value of a scene, in its usual unit; what the scene did not give is a comment, None is left out."""
    lines = [f"title = {_literal(scene.title)}"]
    for heading, section in _tables(scene):
        lines += ["", heading]
        for name, value in _pairs(section):
            lines.append(f"{'' if name in section.model_fields_set else '# '}{name} = {_literal(value)}")
    return "\n".join(lines) + "\n"


def sections(scene: SceneSections) -> list[tuple[str, list[tuple[str, Any]]]]:
    """Return (title, keys and values) of every section of a scene, values as in TOML; paths are numbered from 1."""
    listed: list[tuple[str, list[tuple[str, Any]]]] = [("scene", [("title", scene.title)])]
    count = Counter[str]()
    for heading, section in _tables(scene):
        name = heading.strip("[]")
        count[name] += 1
        listed.append((f"{name} {count[name]}" if heading.startswith("[[") else name, list(_pairs(section))))
    return listed


def _tables(scene: SceneSections) -> Iterator[tuple[str, BaseModel]]:
    """Yield (heading, section) of the tables of a scene."""
    for name in type(scene).model_fields:
        value = getattr(scene, name)
        if isinstance(value, BaseModel) and (name != "design" or [*_pairs(value)]):  # of no use without a value
            yield f"[{name}]", value
            yield from ((f"[[{name}.layer]]", layer) for layer in getattr(value, "layers", ()))
    for path in scene.paths:
        yield "[[path]]", path


def _pairs(section: BaseModel) -> Iterator[tuple[str, Any]]:
    """Yield key and value, as in TOML, of what is set in a section."""
    for name, info in type(section).model_fields.items():
        value = getattr(section, name)
        if value is not None and value != () and name != "layers":
            yield name, _in_toml(field_of(info), value, section)


def _in_toml(field: Field, value: Any, section: BaseModel) -> Any:
    if isinstance(field, QuantityList):
        return field.entries_in_toml(getattr(section, field.by_field, ""), value)
    return field.in_toml(value)


def _literal(value: Any) -> str:
    """Return a TOML literal; JSON spells texts (on one line), numbers and flat lists the same."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_literal(each)}' for key, each in value.items())} }}"
    return json.dumps(value, ensure_ascii=False)
