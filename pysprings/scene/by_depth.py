# SPDX-License-Identifier: MIT
"""Values of a layer of soil that vary with depth or with the initial stress, and the field that reads them; ranges.

Of a value with a range, `{ low = ..., best = ..., high = ... }`, one of the three counts, that of `soil.estimate`. It
is picked where a scene is read, before anything is checked: nothing below the reader of scenes deals with ranges. What
the other two estimates would give is checked, too.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from pydantic import ValidationInfo

from pysprings.core.text import suggestion
from pysprings.core.units import parts, quoted, unit_of
from pysprings.core.words import ESTIMATES, OF_ESTIMATE
from pysprings.scene.fields import QUANTITY_PATTERN, Choice, Field, Number, Quantity, read_keys, refuse


@dataclass(frozen=True)
class ByDepth:
    """A value that varies inside a layer; the keys that are not None decide how.

    top, bottom : values at top and bottom of the layer, linear between; with ``to`` (m) the second one is that at this
        depth, and of all below.
    top, gradient : value at the top and its increase per metre of depth.
    reference, reference_depth, depth_offset, exponent : reference ((z + offset)/reference_depth)^exponent, with z the
        depth below mudline in m.
    reference, reference_stress, exponent : reference (p'/reference_stress)^exponent, with p' the initial mean effective
        stress in Pa; with ``follows`` "stress" the value changes with p' in a run.
    """

    top: float | None = None
    bottom: float | None = None
    to: float | None = None
    gradient: float | None = None
    reference: float | None = None
    reference_depth: float | None = None
    depth_offset: float | None = None
    reference_stress: float | None = None
    exponent: float | None = None
    follows: str | None = None

    def at(self, depth: np.ndarray, top: float, bottom: float, stress: np.ndarray | None = None) -> np.ndarray:
        """Return the values at depths (...,) in m of a layer from ``top`` to ``bottom``.

        ``stress`` (...,) is the initial mean effective stress in Pa, compression positive; values by stress need it.
        """
        if self.bottom is not None:
            assert self.top is not None
            share = (depth - top) / (bottom - top)
            if self.to is not None:
                share = np.minimum((depth - top) / (self.to - top), 1.0)
            return np.asarray(self.top + share * (self.bottom - self.top))
        if self.gradient is not None:
            assert self.top is not None
            return np.asarray(self.top + self.gradient * (depth - top))
        assert self.reference is not None and self.exponent is not None
        if self.reference_depth is not None:
            base = (depth + (self.depth_offset or 0.0)) / self.reference_depth
        else:
            assert stress is not None and self.reference_stress is not None
            base = stress / self.reference_stress
        return np.asarray(self.reference * np.maximum(base, 0.0) ** self.exponent)


def follows_stress(value: object) -> bool:
    """Return whether a value changes with the mean effective stress in a run."""
    return isinstance(value, ByDepth) and value.follows is not None


Value = float | ByDepth  # "auto" is resolved where the ground is made
_ENDS = ({"top", "bottom"}, {"top", "bottom", "to"})
_LINEAR = (*_ENDS, {"top", "gradient"})
_BY_STRESS = {"reference", "reference_stress", "exponent"}
_POWERS = ({"reference", "reference_depth", "exponent"}, _BY_STRESS, {*_BY_STRESS, "follows"})
_DEPTH = Quantity("m", "(0, 1e4]", "", "5 m")
_OFFSET = Quantity("m", "[0, 1e4]", "", "1 m")
_STRESS = Quantity("kPa", "(0, 1e6]", "", "100 kPa")
_EXPONENT = Number("[0, 2]", "", 0.5)
_OWN = {
    "to": _DEPTH, "reference_depth": _DEPTH, "depth_offset": _OFFSET, "reference_stress": _STRESS,
    "exponent": _EXPONENT, "follows": Choice(("stress",), "stiffness follows the mean effective stress"),
}  # fmt: skip
_LEAST_LINEAR = 1.0  # exponents of a stiffness that follows the stress are less


@dataclass(frozen=True)
class Profile(Field):
    """A value of a layer: constant, linear between top and bottom, or (``powers``) a power of depth or stress.

    A pure number has no gradient: it is given at both ends.
    """

    quantity: Quantity | Number
    powers: bool = False

    @property
    def forms(self) -> tuple[set[str], ...]:
        """Sets of keys that a table of this value may have."""
        linear = _ENDS if isinstance(self.quantity, Number) else _LINEAR
        return (*linear, *(_POWERS if self.powers else ()))

    def validate(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, ByDepth):
            return value
        if not isinstance(value, Mapping):
            return self.quantity.validate(value, info)
        given = {name: each for name, each in value.items() if each is not None}
        fits = set(given) - {"depth_offset"} in self.forms
        if not fits or ("depth_offset" in given and "reference_depth" not in given):
            known = "; ".join(", ".join(sorted(form, reverse=True)) for form in self.forms)
            raise refuse(f"a value by depth has the keys {known}, got {', '.join(given) or 'none'}")
        read, wrong = read_keys(given, lambda name, each: self._field(name).validate(each, info))
        if "follows" in read and read.get("exponent", 0.0) >= _LEAST_LINEAR:
            wrong.append(f"exponent: {read['exponent']:g} must be less than 1 where the stiffness follows the stress")
        if wrong:
            raise refuse("; ".join(wrong))
        return ByDepth(**read)

    def _field(self, name: str) -> Field:
        """Return the field of a key of the table."""
        if name == "gradient":
            unit = f"{self.quantity.unit}/m"
            return Quantity(unit, "[-1e9, 1e9]", "", f"2 {unit}")
        return _OWN.get(name, self.quantity)

    def in_toml(self, value: Any) -> Any:
        if not isinstance(value, ByDepth):
            return self.quantity.in_toml(value)
        given = {each.name: getattr(value, each.name) for each in fields(value)}
        return {name: self._field(name).in_toml(each) for name, each in given.items() if each is not None}

    def schema(self) -> dict[str, Any]:
        text = {"type": "string", "pattern": QUANTITY_PATTERN}
        if isinstance(self.quantity, Number):
            return self._schema_of_number(text)
        keys: dict[str, Any] = {name: text for form in self.forms for name in sorted(form)}
        if self.powers:
            keys |= {"exponent": {"type": "number"}, "depth_offset": text, "follows": {"enum": ["stress"]}}
        table = {"type": "object", "additionalProperties": False, "properties": keys}
        about = f"{self.quantity.text} (in {self.quantity.interval} {self.quantity.unit}); a value, or a table by depth"
        return {"description": about, "anyOf": [{**text, "examples": [self.quantity.example]}, table]}

    def _schema_of_number(self, depth: dict[str, Any]) -> dict[str, Any]:
        one = self.quantity.schema()
        about = one.pop("description")
        ends = {key: {"type": "number"} for key in ("bottom", "top")}
        table = {"type": "object", "additionalProperties": False, "properties": {**ends, "to": depth}}
        return {"description": f"{about}; a number, or a table by depth", "anyOf": [one, table]}


def show(value: Value, quantity: Quantity) -> str:
    """Return a value as people write it, by depth included."""
    entry = Profile(quantity, powers=True).in_toml(value)
    return str(entry) if isinstance(entry, str) else ", ".join(f"{name} {quoted(each)}" for name, each in entry.items())


# --- a value of the interface that may differ by surface of the caisson, and the field that reads it ---

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
        if not isinstance(value, Mapping):
            return self._one(value, info)
        wrong = [f"{quoted(each)}: unknown surface{suggestion(str(each), SURFACES)}" for each in value
                 if each not in SURFACES]  # fmt: skip
        wrong += [f"{each}: missing (a table has {', '.join(SURFACES)})" for each in SURFACES if each not in value]
        known = {each: value[each] for each in SURFACES if each in value}
        read, unread = read_keys(known, lambda _, each: self._one(each, info))
        if wrong or unread:
            raise refuse("; ".join([*wrong, *unread]))
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


Keys = tuple[str | int, ...]


def is_range(value: object) -> bool:
    """Return whether a value of a scene is a table with a key of `ESTIMATES`."""
    return isinstance(value, dict) and not set(ESTIMATES).isdisjoint(value)


def ranges_in(value: Any, keys: Keys = ()) -> Iterator[tuple[Keys, dict[str, Any]]]:
    """Yield the place of each range, and its table."""
    if is_range(value):
        yield keys, value
    elif isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from ranges_in(inner, (*keys, key))


def incomplete(data: dict[str, Any]) -> Iterator[tuple[Keys, str]]:
    """Yield the place of each range that has not the three keys and no other, and what is wrong with it."""
    for keys, table in ranges_in(data):
        if set(table) != set(ESTIMATES):
            yield keys, f"a range has the keys low, best, high, got {', '.join(map(str, table))}"


# keys of which the largest value is that of the softest and weakest ground, and those of which it is the least
WEAKER = (
    "strain_at_half_strength", "mobilisation_strain", "hardening_parameter", "contraction", "plasticity_index",
    "cycles",
)  # fmt: skip
STRONGER = (
    "young_modulus", "shear_modulus", "rigidity_ratio", "undrained_shear_strength", "friction_angle_final",
    "critical_friction_angle", "cohesion", "relative_density", "degradation_strain", "degradation_limit",
    "friction_coefficient", "adhesion_factor", "compression_factor", "direct_shear_factor", "extension_factor",
    "friction_angle_initial", "dilation_angle", "softening_strain",
)  # fmt: skip


def disordered(data: dict[str, Any]) -> Iterator[tuple[Keys, str]]:
    """Yield the place of each range whose ends are the wrong way round or do not hold its best value, and the fault."""
    for keys, table in ranges_in(data):
        low, best, high = (_size(table.get(each)) for each in ESTIMATES)
        if low is None or best is None or high is None:
            continue
        key = next((each for each in reversed(keys) if each in WEAKER or each in STRONGER), None)
        if not min(low, high) <= best <= max(low, high):
            yield keys, f"best, {_shown(table['best'])}, is not between low and high"
        elif (key in WEAKER and low < high) or (key in STRONGER and low > high):
            least = "largest" if key in WEAKER else "least"
            yield keys, f"low is that of the softer and weaker ground, the {least} {key}: swap low and high"


def _size(value: Any) -> float | None:
    """Return a number, or that of a quantity, in SI; of a value by depth its first one; None for others."""
    if isinstance(value, dict):
        return _size(value.get("top", value.get("reference")))
    if isinstance(value, str):
        try:
            number, unit = parts(value)
            return float(number) * unit_of(unit)[0]
        except ValueError:
            return None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _shown(value: Any) -> str:
    return str(value.get("top", value.get("reference"))) if isinstance(value, dict) else str(value)


def picked(value: Any, estimate: str) -> Any:
    """Return a value, or a table of values, with one estimate in place of each range."""
    if is_range(value):
        return value.get(estimate, next(iter(value.values())))
    if isinstance(value, dict):
        return {key: picked(inner, estimate) for key, inner in value.items()}
    return [picked(inner, estimate) for inner in value] if isinstance(value, list) else value


def take_estimate(data: dict[str, Any], title: str) -> tuple[list[str], str]:
    """Take `soil.estimate` out of the data of a scene, and put it into the title.

    A scene has no such key: its values are those of one estimate. The title is in the heads of exported files, in
    pictures and pages; ``title`` is that of a scene without one. Returns the estimates that are checked, the chosen one
    first, and what is wrong with the key; blank for nothing.
    """
    soil, own = data.get("soil"), data.get("title", title)
    given = soil.pop("estimate", None) if isinstance(soil, dict) else None
    ranged = any(ranges_in(data))
    chosen = given if given in ESTIMATES else "best"
    wrong = ""
    if given is not None and given not in ESTIMATES:
        wrong = f"{quoted(given)} is not one of {', '.join(map(quoted, ESTIMATES))}{suggestion(str(given), ESTIMATES)}"
    elif given is not None and not ranged:
        wrong = "no value of the scene has a range { low, best, high }: all estimates are the same"
    elif given is not None and isinstance(own, str):
        data["title"] = f"{own[:180]} {OF_ESTIMATE.format(given)}"
    return [chosen, *(each for each in ESTIMATES if ranged and each != chosen)], wrong


ESTIMATE: dict[str, Any] = {
    "description": "which value of each range counts; best where not given",
    "enum": [*ESTIMATES],
}


def in_schema(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of a value that may be a range of such values."""
    one = {key: value for key, value in schema.items() if key not in ("description", "default")}
    table = {"type": "object", "additionalProperties": False, "required": [*ESTIMATES],
             "properties": {each: one for each in ESTIMATES}}  # fmt: skip
    return {**{key: value for key, value in schema.items() if key not in one}, "anyOf": [one, table]}
