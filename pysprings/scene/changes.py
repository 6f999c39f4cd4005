# SPDX-License-Identifier: MIT
"""Values that replace those of a scene file: `soil.young_modulus="80 MPa"`, `path.pull.arm="5 m"`."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.text import suggestion
from pysprings.core.units import quoted

OPTION = "--set"


@dataclass(frozen=True)
class Change:
    """A key of a scene, as the path of its tables, and its new value as TOML has it."""

    keys: tuple[str, ...]
    value: Any


VERTICAL_LOAD = ("caisson", "vertical_load")


def vertical_load(V: float) -> Change:
    """Return the change of the caisson's vertical load to V [N]."""
    return Change(VERTICAL_LOAD, f"{V:.12g} N")


def read_changes(texts: Sequence[str]) -> list[Change]:
    """Return changes of texts KEY=VALUE; a value that is no TOML is a text. Raises UserInputError."""
    changes, problems = [], []
    for text in texts:
        name, sign, value = text.partition("=")
        keys = tuple(part.strip() for part in name.split("."))
        if not sign or not all(keys):
            message = f'{quoted(text)} is not KEY=VALUE, such as soil.young_modulus="80 MPa"'
            problems.append(Problem(key=OPTION, message=message))
            continue
        changes.append(Change(keys, _value(value.strip())))
    if problems:
        raise UserInputError(problems)
    return changes


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        return text


def applied(data: dict[str, Any], changes: Sequence[Change]) -> list[tuple[str | int, ...]]:
    """Put changes into the data of a scene file; return their places there. Raises UserInputError."""
    places = list[tuple[str | int, ...]]()
    for change in changes:
        table: Any = data
        place: list[str | int] = []
        for key in change.keys[:-1]:
            if isinstance(table, list):
                number = _entry(table, key, change)
                table = table[number]
                place.append(number)
            else:
                table = _table(table, key, change)
                place.append(key)
        if not isinstance(table, dict):
            raise _refused(change, "is a list: name one of its tables, and a key of it")
        own = (*place, change.keys[-1])
        if any(own[: len(each)] == each[: len(own)] for each in places):
            raise _refused(change, "has a value already: each key takes one, from --set, an option or an axis")
        table[change.keys[-1]] = change.value
        places.append(own)
    return places


def named(data: Any, place: Sequence[str | int]) -> tuple[str, ...]:
    """Return the keys of a change at a place of the data: entries of lists by their names, or numbers from 1.

    Raises UserInputError: the name of one is the number of another.
    """
    keys = list[str]()
    for part in place:
        name = str(part)
        if isinstance(part, int):
            names = names_of(data)
            name = names[part]
            if names.count(name) > 1:
                text = f"the name {quoted(name)} is the number of another one: give each a name of its own"
                raise UserInputError([Problem(key=".".join(keys), message=text)])
        keys.append(name)
        data = data[part]
    return tuple(keys)


def names_of(tables: list[Any]) -> list[str]:
    """Return the names of the entries of a list, as changes have them: numbers from 1 of others.

    A name that stands twice, as those of a sounding through sand, clay and sand do, or that has a dot, is none.
    """
    given = [str(each.get("name", "")) if isinstance(each, dict) else "" for each in tables]
    own = [name if name and "." not in name and given.count(name) == 1 else "" for name in given]
    return [name or str(k + 1) for k, name in enumerate(own)]


def _table(table: Any, key: str, change: Change) -> Any:
    inner = table.setdefault(key, {}) if isinstance(table, dict) else None
    if not isinstance(inner, dict | list):
        raise _refused(change, f"'{key}' is a value, not a table")
    return inner


def _entry(tables: list[Any], name: str, change: Change) -> int:
    names = names_of(tables)
    given = [each.get("name") for each in tables if isinstance(each, dict)]
    if (count := max(names.count(name), given.count(name))) > 1:
        raise _refused(change, f"{count} have the name '{name}': give each a name of its own, or take its number")
    if name in names:
        return names.index(name)
    raise _refused(change, f"no '{name}'{suggestion(name, names)}; there are: {', '.join(names) or 'none'}")


def _refused(change: Change, message: str) -> UserInputError:
    return UserInputError([Problem(key=f"{OPTION} {'.'.join(change.keys)}", message=message)])
