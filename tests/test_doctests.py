# SPDX-License-Identifier: MIT
"""The examples in docstrings run as they stand."""

import doctest
import importlib
import re

import pytest

from tests.support.place import ROOT

EXAMPLE = re.compile(r"^\s*>>> (?!.*doctest: \+SKIP)", re.M)
MODULES = sorted(
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("pysprings", "fe_engine")
    for file in (ROOT / package).rglob("*.py")
    if EXAMPLE.search(file.read_text(encoding="utf-8"))
)


def test_there_are_examples() -> None:
    assert len(MODULES) >= 3


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_run(name: str) -> None:
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0
