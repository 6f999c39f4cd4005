# SPDX-License-Identifier: MIT
"""Types of the scene's fields: accepted values, message for others, JSON schema.

Each is a pydantic annotation, `radius: Annotated[float, Quantity("m", "(0, 1e4]", "...", "24 m")]`. From TOML
a dimensional value must be a text with its unit; from Python an SI number will do as well, and None where the
annotation has it (TOML leaves the key out).
"""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from types import NoneType
from typing import Any, ClassVar, get_args

from pydantic import ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from pysprings.core import units
from pysprings.core.text import suggestion
from pysprings.core.units import quoted, slip
from pysprings.core.written import is_device

FROM_TOML = {"bare_numbers": False}  # validation context of a scene that comes from a file
QUANTITY_PATTERN = r"^\s*[+\-−]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+\-]?[0-9]{1,4})?\s*[^0-9\s.,_'].*$"


def refuse(message: str, **context: Any) -> PydanticCustomError:
    """Return the error that carries a message for the user."""
    return PydanticCustomError("scene", "{message}", {"message": message, **context})


@dataclass(frozen=True)
class Interval:
    """An interval written as "[0, 0.5)"."""

    text: str

    @property
    def bounds(self) -> tuple[str, str]:
        low, high = self.text[1:-1].split(",")
        return low.strip(), high.strip()

    def holds(self, value: float, unit: str = "1") -> bool:
        """Return True if an SI value lies inside; the bounds are in `unit`."""
        low, high = (float(b) if unit == "1" else units.read(f"{b} {unit}", units.si_of(unit)) for b in self.bounds)
        above = value > low or (value == low and self.text[0] == "[")
        return above and (value < high or (value == high and self.text[-1] == "]"))


class Field(ABC):
    """Base of the field types: `validate` returns the value or raises `refuse(...)`."""

    @abstractmethod
    def validate(self, value: Any, info: ValidationInfo) -> Any:
        """Return the value that a model holds; `refuse(...)` what does not fit."""

    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """Return the JSON schema of what TOML may hold here."""

    def in_toml(self, value: Any) -> Any:
        """Return a value of the model as TOML (and JSON) would hold it."""
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        read = core_schema.with_info_plain_validator_function(self.validate)
        return core_schema.nullable_schema(read) if NoneType in get_args(source) else read

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: Any) -> dict[str, Any]:
        return self.schema()


def read_keys(given: Mapping[str, Any], read: Callable[[str, Any], Any]) -> tuple[dict[str, Any], list[str]]:
    """Return the values of a table by their keys, each as a function reads it, and what is wrong with the others."""
    values, wrong = {}, []
    for key, value in given.items():
        try:
            values[key] = read(key, value)
        except PydanticCustomError as error:
            wrong.append(f"{key}: {error.message()}")
    return values, wrong


def field_of(info: FieldInfo) -> Field:
    """Return our type of a model field."""
    return next(item for item in info.metadata if isinstance(item, Field))


@dataclass(frozen=True)
class Quantity(Field):
    """A number with a dimension, kept in SI.

    unit : the usual unit, in which `interval` is written and values are shown
    word : a text accepted in place of a quantity
    common : usual range of a layer's value in `unit`; `pysprings.scene.defaults` remarks on values beyond it
    """

    unit: str
    interval: str
    text: str
    example: str
    word: str | None = None
    common: tuple[float, float] | None = None

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if self.word is not None and value == self.word:
            return value
        return self.number(value, bare=(info.context or {}).get("bare_numbers", True))

    def number(self, value: Any, bare: bool) -> float:
        """Return the SI value of a text with unit, or of an SI number when bare numbers are allowed."""
        si_unit = units.si_of(self.unit)
        if isinstance(value, str):
            try:
                number = units.read(value, si_unit, self.example)
            except units.QuantityError as error:
                hint = f"; {quoted(self.word)} is possible too" if self.word else ""
                raise refuse(f"{error}{hint}") from None
            given = quoted(value)
            if wrong := slip(value, number, si_unit):
                raise refuse(f"{given} {wrong}")
        elif bare and _is_number(value):
            number, given = _as_float(value), f"{quoted(value)} {si_unit}"
        else:
            expected = f"expected a quantity with unit such as {quoted(self.example)}{_or_word(self.word)}"
            raise refuse(f"{expected}, got {quoted(value)}")
        if not Interval(self.interval).holds(number, self.unit):
            raise refuse(f"{given} is not in {self.interval} {self.unit}")
        return number

    def schema(self) -> dict[str, Any]:
        schema: dict[str, Any] = {"type": "string", "pattern": QUANTITY_PATTERN}
        if self.word:
            schema = {"anyOf": [{"const": self.word}, schema]}
        return {"description": f"{self.text} (in {self.interval} {self.unit})", "examples": [self.example], **schema}

    def in_toml(self, value: Any) -> Any:
        return value if value is None or value == self.word else units.show(value, self.unit)


@dataclass(frozen=True)
class Number(Field):
    """A pure number; ``word`` is a text accepted in its place, ``common`` its usual range in a layer.

    ``constant``: it does not vary inside a layer.
    """

    unit: ClassVar = "1"  # in which the interval is written
    interval: str
    text: str
    example: float
    word: str | None = None
    common: tuple[float, float] | None = None
    constant: bool = False

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if self.word is not None and value == self.word:
            return value
        if not _is_number(value):
            expected = f"expected a number without unit and quotes such as {self.example:g}{_or_word(self.word)}"
            raise refuse(f"{expected}, got {quoted(value)}")
        number = _as_float(value)
        if not Interval(self.interval).holds(number):
            raise refuse(f"{quoted(value)} is not in {self.interval}")
        return number

    def schema(self) -> dict[str, Any]:
        low, high = map(float, Interval(self.interval).bounds)
        bounds = {
            "minimum" if self.interval[0] == "[" else "exclusiveMinimum": low,
            "maximum" if self.interval[-1] == "]" else "exclusiveMaximum": high,
        }
        schema: dict[str, Any] = {"type": "number", **bounds}
        if self.word:
            schema = {"anyOf": [{"const": self.word}, schema]}
        return {"description": f"{self.text} (in {self.interval})", **schema}


def _or_word(word: str | None) -> str:
    return f" (or {quoted(word)})" if word else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _as_float(value: Any) -> float:
    try:
        return float(value) + 0.0
    except OverflowError:
        return math.inf


@dataclass(frozen=True)
class Count(Field):
    """A whole number."""

    low: int
    high: int
    text: str
    multiple_of: int = 1

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise refuse(f"expected a whole number such as {self.low}, got {quoted(value)}")
        count = int(value)
        if not self.low <= count <= self.high:
            raise refuse(f"{quoted(value)} is not in [{self.low}, {self.high}]")
        if count % self.multiple_of:
            raise refuse(f"{quoted(value)} is not a multiple of {self.multiple_of}")
        return count

    def schema(self) -> dict[str, Any]:
        about = f"{self.text} (in [{self.low}, {self.high}])"
        schema = {"description": about, "type": "integer", "minimum": self.low, "maximum": self.high}
        return schema if self.multiple_of == 1 else {**schema, "multipleOf": self.multiple_of}


@dataclass(frozen=True)
class Choice(Field):
    """One word of a list; `planned` words are known but refused as not available yet."""

    words: tuple[str, ...]
    text: str
    planned: tuple[str, ...] = ()

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        known = ", ".join(quoted(word) for word in self.words)
        if not isinstance(value, str):
            raise refuse(f"expected one of {known}, got {quoted(value)}")
        if value in self.planned:
            raise refuse(f"{quoted(value)} is not available yet; choose {known.replace(', ', ' or ')}")
        if value not in self.words:
            raise refuse(f"{quoted(value)} is not one of {known}{suggestion(value, self.words)}")
        return str(value)

    def schema(self) -> dict[str, Any]:
        return {"description": self.text, "enum": list(self.words)}


@dataclass(frozen=True)
class Flag(Field):
    """true or false; `words` are accepted in their place: pairs of a word and the value that it stands for."""

    text: str
    words: tuple[tuple[str, bool | str], ...] = ()

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, bool):
            return value
        if isinstance(value, str) and value in dict(self.words):
            return dict(self.words)[value]
        known = ", ".join(("true", "false", *(quoted(word) for word, _ in self.words)))
        raise refuse(f"expected {' or '.join(known.rsplit(', ', 1))}, got {quoted(value)}")

    def schema(self) -> dict[str, Any]:
        flag = {"description": self.text, "type": "boolean"}
        if not self.words:
            return flag
        words = {"enum": [word for word, _ in self.words]}
        return {"description": self.text, "anyOf": [{"type": "boolean"}, words]}


@dataclass(frozen=True)
class Text(Field):
    """A text on one line; restricted by `pattern`, described by `meaning`; with `names_files` a valid file name."""

    text: str
    pattern: str = r"[^\x00-\x1f\x7f-\x9f\u2028\u2029]{1,200}"
    meaning: str = "1 to 200 characters on one line"
    names_files: bool = False

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, str):
            raise refuse(f"expected a text in quotes, got {quoted(value)}")
        if not re.fullmatch(self.pattern, value) or not value.strip():
            raise refuse(f"{quoted(value)} is not {self.meaning}")
        if self.names_files and is_device(value):
            raise refuse(f"{quoted(value)} names files, too, and Windows takes such a file for a device")
        return str(value)

    def schema(self) -> dict[str, Any]:
        return {"description": self.text, "type": "string", "pattern": f"^{self.pattern}$"}


@dataclass(frozen=True)
class QuantityList(Field):
    """A list of quantities whose kind depends on an earlier field of the same section, or is one for all.

    by_field : name of that field ("": one for all);  quantities : pairs of its value and the quantity of the entries
    word : text that stands for a list in scene files, whose reader puts the list in its place
    """

    by_field: str
    quantities: tuple[tuple[str, Quantity], ...]
    text: str
    word: str = ""

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, list | tuple):
            raise refuse(f"expected {self._expected}, got {quoted(value)}")
        kind = info.data.get(self.by_field, "")  # "" is no value of a field
        quantity = dict(self.quantities).get(kind)
        if quantity is None:  # the other field is refused already
            return ()
        entries, wrong = [], []
        for index, entry in enumerate(value):
            try:
                entries.append(self._read(entry, kind, quantity, info))
            except PydanticCustomError as error:
                wrong.append((index, error.message()))
        if wrong:
            raise refuse("; ".join(message for _, message in wrong), entries=wrong)
        return tuple(entries)

    @property
    def _expected(self) -> str:
        hint = f" (or, in a scene file, {quoted(self.word)})" if self.word else ""
        return f"a list of quantities such as [{quoted(self._example())}]{hint}"

    def _read(self, entry: Any, kind: str, quantity: Quantity, info: ValidationInfo) -> Any:
        return quantity.validate(entry, info)

    def _example(self) -> str:
        return self.quantities[0][1].example

    def entries_in_toml(self, kind: str, values: Sequence[Any]) -> list[str]:
        """Return the entries as TOML would hold them, for the given value of the other field."""
        return [self._show(kind, value) for value in values]

    def _show(self, kind: str, entry: Any) -> str:
        return str(dict(self.quantities)[kind].in_toml(entry))

    def schema(self) -> dict[str, Any]:
        entry = {"type": "string", "pattern": QUANTITY_PATTERN}
        one = dict(self.quantities).get("")  # of all
        about = f"{self.text} (each in {one.interval} {one.unit})" if one else self.text
        schema = {"description": about, "type": "array", "items": entry, "examples": [[self._example()]]}
        return {"description": about, "anyOf": [{"const": self.word}, schema]} if self.word else schema
