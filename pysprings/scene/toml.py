# SPDX-License-Identifier: MIT
"""A scene as TOML text, with units, such that loading it gives an equal scene."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pysprings.scene.fields import Field, QuantityList
from pysprings.scene.model import Scene


def to_toml(scene: Scene) -> str:
    """Write every value of a scene, in its usual unit; values that are not set (None) are left out."""
    lines = [f"title = {_literal(scene.title)}"]
    for name in type(scene).model_fields:
        value = getattr(scene, name)
        if isinstance(value, BaseModel):
            lines += ["", f"[{name}]", *_pairs(value)]
    for path in scene.paths:
        lines += ["", "[[path]]", *_pairs(path)]
    return "\n".join(lines) + "\n"


def field_of(info: FieldInfo) -> Field:
    """Return our type of a model field."""
    return next(item for item in info.metadata if isinstance(item, Field))


def _pairs(section: BaseModel) -> Iterator[str]:
    for name, info in type(section).model_fields.items():
        value = getattr(section, name)
        if value is not None and value != ():
            yield f"{name} = {_literal(_in_toml(field_of(info), value, section))}"


def _in_toml(field: Field, value: Any, section: BaseModel) -> Any:
    if isinstance(field, QuantityList):
        return field.entries_in_toml(getattr(section, field.by_field), value)
    return field.in_toml(value)


def _literal(value: Any) -> str:
    """Return a TOML literal; JSON spells texts (on one line), numbers and flat lists the same."""
    return json.dumps(value, ensure_ascii=False)
