# SPDX-License-Identifier: MIT
"""How the tests are arranged: what they share is in tests/support, and benchmarks do not depend on them."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.support.place import ROOT

# tests of a benchmark
OF_BENCHMARKS = {
    "tests/pysprings/full_model/test_accuracy_benchmarks.py",
    "tests/pysprings/memory/test_aims.py",
    "tests/pysprings/model/test_domain_effect.py",
    "tests/verification/test_openfast_turbine.py",
    "tests/verification/across.py",
    "tests/verification/test_peers.py",
}


def imported(file: Path) -> set[str]:
    """Return the modules that a file imports, functions and texts of programs aside."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
    return found


@cache
def imports_of(folder: str) -> dict[str, set[str]]:
    files = sorted((ROOT / folder).rglob("*.py"))
    assert len(files) > 5
    return {file.relative_to(ROOT).as_posix(): imported(file) for file in files}


def test_no_test_module_imports_another() -> None:
    found = [
        (file, name)
        for file, names in imports_of("tests").items()
        for name in names
        if name.startswith("tests.") and any(part.startswith("test_") for part in name.split("."))
    ]
    assert found == []


def test_benchmarks_do_not_import_tests() -> None:
    found = {
        file: {name for name in names if name.split(".")[0] == "tests"}
        for folder in ("benchmarks", "tools", "validation")
        for file, names in imports_of(folder).items()
    }
    assert {file: names for file, names in found.items() if names} == {}


def test_only_tests_of_benchmarks_import_them() -> None:
    found = {file for file, names in imports_of("tests").items() if any(n.split(".")[0] == "benchmarks" for n in names)}
    assert found == OF_BENCHMARKS


def test_no_test_replaces_a_private_name() -> None:
    """Settings are handed in, or the name is public."""
    patches = [
        (file.relative_to(ROOT).as_posix(), ast.unparse(node))
        for file in sorted((ROOT / "tests").rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "setattr"
    ]
    assert len(patches) > 20
    private = re.compile(r"""setattr\(.*?["'](?:[\w.]*\.)?_(?!_)""")
    assert [each for each in patches if private.match(each[1].partition(".")[2])] == []


def test_every_test_has_a_time_limit(request: pytest.FixtureRequest) -> None:
    if not request.config.pluginmanager.hasplugin("timeout"):
        pytest.skip("pytest-timeout is not loaded")
    limits = [item.get_closest_marker("timeout") for item in request.session.items]
    assert limits and all(limit is not None and 0 < limit.args[0] <= 3600 for limit in limits)
