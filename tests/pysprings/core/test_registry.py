# SPDX-License-Identifier: MIT
"""Registries: names, order, unknown names, cases of other packages."""

import importlib.metadata
import re
from collections.abc import Iterable
from dataclasses import dataclass

import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.registry import Registry


@dataclass(frozen=True)
class Case:
    name: str


PLUGIN = Case("plugin")


def test_cases_by_name_in_order() -> None:
    registry = Registry("case", [Case("b"), Case("a")])
    assert registry.names() == ["b", "a"] and len(registry) == 2
    assert registry.register(Case("c-1")) is registry["c-1"]
    assert [item.name for item in registry] == ["b", "a", "c-1"]
    assert "a" in registry and "d" not in registry
    with registry.added(Case("d")):
        assert "d" in registry
    assert "d" not in registry


def test_an_unknown_name_is_user_input() -> None:
    registry = Registry("case", [Case("b"), Case("a")])
    with pytest.raises(UserInputError, match="fatal: user input: --to: 'x' is not one of b, a"):
        registry.find("x", "--to")
    assert registry.find("a", "--to") == Case("a")


@pytest.mark.parametrize("name", ["", "A", "two words", "1", "a/b"])
def test_names_that_are_refused(name: str) -> None:
    words = f"case {name!r}: a name has lower-case letters, digits, '-' and '_' only"
    with pytest.raises(ValueError, match=f"^{re.escape(words)}$"):
        Registry("case", [Case("a")]).register(Case(name))


def test_a_name_is_given_once() -> None:
    registry = Registry("case", [Case("a")])
    with pytest.raises(ValueError, match=r"^case 'a' is registered already$"):
        registry.register(Case("a"))
    registry.remove("a")
    assert registry.names() == [] and registry.register(Case("a")) == Case("a")


def entry_points(monkeypatch: pytest.MonkeyPatch, values: Iterable[str]) -> None:
    points = [importlib.metadata.EntryPoint(value.split(":")[1].lower(), value, "cases") for value in values]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: [p for p in points if p.group == group])


def test_entry_points_of_other_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    entry_points(monkeypatch, [f"{__name__}:PLUGIN"])
    registry = Registry("case", [Case("a")], group="cases")
    assert registry.names() == ["a", "plugin"]
    assert Registry("case", [Case("a")], group="cases")["plugin"] is PLUGIN
    assert Registry("case", [Case("a")], group="others").names() == ["a"]


def test_a_broken_entry_point_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    entry_points(monkeypatch, ["no_such_module:CASE", f"{__name__}:PLUGIN"])
    registry = Registry("case", [Case("a")], group="cases")
    with pytest.warns(UserWarning, match=r"case 'case' \(no_such_module:CASE\) is left out: ModuleNotFoundError"):
        assert registry.names() == ["a", "plugin"]
