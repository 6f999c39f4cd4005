# SPDX-License-Identifier: MIT
"""Registries: names, order, unknown names, cases of other packages."""

import re
from dataclasses import dataclass

import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.registry import Registry


@dataclass(frozen=True)
class Case:
    name: str


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
