# SPDX-License-Identifier: MIT
"""The package's front door, and what the project files promise."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import pysprings
from pysprings.errors import Problem, RunIncomplete, UserInputError

ROOT = Path(__file__).parents[2]


def test_every_name_of_the_front_door_opens() -> None:
    for name in pysprings.__all__:
        assert getattr(pysprings, name) is not None
    assert set(pysprings.__all__) <= set(dir(pysprings))
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        _ = pysprings.nonsense  # type: ignore[attr-defined]


def test_import_is_light() -> None:
    heavy = {"numpy", "pydantic", "xarray", "typer"}
    code = f"import sys, pysprings; print(sorted({heavy!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(("name", "module"), [("run", "full_model"), ("compare", "comparison")])
def test_functions_are_not_hidden_by_modules(name: str, module: str) -> None:
    home = import_module(f"pysprings.{module}")
    assert getattr(pysprings, name) is getattr(home, name)


def test_problem_text() -> None:
    assert str(Problem("a.toml", 3, 4, "soil.K0", "bad")) == "a.toml:3:4: soil.K0: bad"
    assert str(Problem(file="a.toml", message="bad")) == "a.toml: bad"
    assert str(Problem(key="--H", message="bad")) == "--H: bad"
    assert str(Problem(message="two\nlines \x1b[31m")) == "two\\nlines \\x1b[31m"


def test_user_input_error_has_a_line_per_problem() -> None:
    error = UserInputError([Problem(message="one"), Problem(message="two")])
    assert str(error) == "fatal: user input: one\nfatal: user input: two"
    assert error.exit_code == 2


def test_run_incomplete_knows_its_folder() -> None:
    assert RunIncomplete("x", "out").folder == Path("out")
    assert (RunIncomplete("x").folder, RunIncomplete("x").exit_code) == (None, 3)


def project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_contract_on_laws_names_every_other_module_of_the_engine() -> None:
    """import-linter can only forbid: an engine module missing from its list is a hole in the contract."""
    contracts = {contract["id"]: contract for contract in project()["tool"]["importlinter"]["contracts"]}
    contract = contracts["laws-alone"]
    allowed = {*contract["source_modules"], "fe_engine.conventions"}
    modules = {
        f"fe_engine.{path.stem}"
        for path in (ROOT / "fe_engine").iterdir()
        if (path.suffix == ".py" and path.stem != "__init__") or (path / "__init__.py").exists()
    }
    assert modules - allowed <= set(contract["forbidden_modules"])


def test_every_source_file_names_its_licence() -> None:
    for folder in ("fe_engine", "pysprings", "tests"):
        for path in (ROOT / folder).rglob("*.py"):
            assert path.read_text(encoding="utf-8").startswith("# SPDX-License-Identifier: MIT\n"), path
