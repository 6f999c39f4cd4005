# SPDX-License-Identifier: MIT
"""Values with a range, `{ low = ..., best = ..., high = ... }`: one of the three counts, that of `soil.estimate`.

The value is picked where a scene is read, before anything is checked: nothing below the reader of scenes deals with
ranges. What the other two estimates would give is checked, too.
"""

from collections.abc import Iterator
from typing import Any

from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.core.words import ESTIMATES

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
        data["title"] = f"{own[:180]} ({given} estimate)"
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
