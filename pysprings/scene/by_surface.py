# SPDX-License-Identifier: MIT
"""A value of the interface that may differ by surface of the caisson, and the field that reads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from pysprings.core.units import quoted
from pysprings.scene.fields import Field, Number, refuse, suggestion

SURFACES = ("outside", "inside", "lid", "tip")


@dataclass(frozen=True)
class BySurface(Field):
    """A number or a word for all surfaces, or a table with one for each of `SURFACES`.

    number : the numbers that are accepted; None: words alone.  words : the words that are accepted.
    """

    number: Number | None
    words: tuple[str, ...]
    text: str

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if value is None and self.number is not None:
            return value
        if not isinstance(value, Mapping):
            return self._one(value, info)
        wrong = [f"{quoted(each)}: unknown surface{suggestion(str(each), SURFACES)}" for each in value
                 if each not in SURFACES]  # fmt: skip
        wrong += [f"{each}: missing (a table has {', '.join(SURFACES)})" for each in SURFACES if each not in value]
        read = {}
        for name in (each for each in SURFACES if each in value):
            try:
                read[name] = self._one(value[name], info)
            except PydanticCustomError as error:
                wrong.append(f"{name}: {error.message()}")
        if wrong:
            raise refuse("; ".join(wrong))
        return read

    def _one(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, str) or self.number is None:
            known = ", ".join(quoted(word) for word in self.words)
            if value not in self.words:
                kind = f"a number or {known}" if self.number else f"one of {known}"
                hint = suggestion(value, self.words) if isinstance(value, str) else ""
                raise refuse(f"expected {kind}, got {quoted(value)}{hint}")
            return value
        return self.number.validate(value, info)

    def schema(self) -> dict[str, Any]:
        kinds: list[dict[str, Any]] = [{"enum": list(self.words)}]
        if self.number is not None:
            kinds.append(self.number.schema())
        table = {"type": "object", "additionalProperties": False, "required": list(SURFACES),
                 "properties": {name: {"anyOf": kinds} for name in SURFACES}}  # fmt: skip
        return {"description": f"{self.text}; one for all surfaces, or a table by surface", "anyOf": [*kinds, table]}


def of_surface(value: Any, surface: str) -> Any:
    """Return the value of one of `SURFACES`."""
    return value[surface] if isinstance(value, Mapping) else value
