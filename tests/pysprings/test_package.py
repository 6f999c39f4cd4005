# SPDX-License-Identifier: MIT
"""The package's front door, and what the project files promise."""

import re
import shutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import pysprings
from pysprings.core.errors import Problem, RunIncomplete, UserInputError
from tests.support.place import ROOT


def test_every_name_of_the_front_door_opens() -> None:
    for name in pysprings.__all__:
        assert getattr(pysprings, name) is not None
    assert set(pysprings.__all__) <= set(dir(pysprings))
    with pytest.raises(AttributeError, match="No pysprings attribute nonsense"):
        _ = pysprings.nonsense  # type: ignore[attr-defined]


def test_import_is_light() -> None:
    heavy = {"numpy", "pydantic", "xarray", "typer"}
    code = f"import sys, pysprings; print(sorted({heavy!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("name", ["errors", "exporters", "plots"])
def test_modules_of_the_front_door_open_where_nothing_else_is_imported(name: str) -> None:
    done = subprocess.run([sys.executable, "-c", f"import pysprings; pysprings.{name}"], check=False, cwd=ROOT)
    assert done.returncode == 0


@pytest.mark.parametrize(("name", "module"), [("run", "full_model.compute"), ("compare", "macro.comparison")])
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


def test_every_source_file_names_its_licence() -> None:
    for folder in ("fe_engine", "pysprings", "tests", "benchmarks", "tools"):
        files = sorted((ROOT / folder).rglob("*.py"))
        assert len(files) > 5
        for path in files:
            assert path.read_text(encoding="utf-8").startswith("# SPDX-License-Identifier: MIT\n"), path


VERSIONS = ("3.11", "3.12", "3.13", "3.14", "3.15")


def test_classifiers_name_the_interpreters_that_are_tried() -> None:
    about = project()["project"]
    assert about["requires-python"] == f">={VERSIONS[0]}"
    named = [line.rpartition(" ")[2] for line in about["classifiers"] if "Python :: 3." in line]
    assert tuple(named) == VERSIONS


@pytest.fixture(scope="module")
def index() -> str:
    """The path of uv, where it reaches a package index; else the tests that need one are skipped, by name."""
    found = shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")
    if found is None:
        pytest.skip("uv is not installed (it comes with the extra `dev`)")
    done = subprocess.run(
        [found, "pip", "compile", "--quiet", "-"], input="filelock\n", capture_output=True, text=True, timeout=60
    )
    if done.returncode:
        pytest.skip(f"no package index is reachable: {done.stderr.strip().splitlines()[-1:]}")
    return found


@pytest.mark.slow
def test_every_dependency_has_wheels_for_every_interpreter(index: str, tmp_path: Path) -> None:
    """All are asked for at once: they wait for the package index."""
    wanted = {re.match(r"[A-Za-z0-9_.-]+", line)[0].lower() for line in project()["project"]["dependencies"]}  # type: ignore[index]
    command = [index, "pip", "compile", "--quiet", "--no-header", "--no-annotate", "--only-binary", ":all:"]
    command += ["--extra", "dev", str(ROOT / "pyproject.toml")]
    asked = {}
    for version in VERSIONS:
        own = [*command, "--python-version", version, "--output-file", tmp_path / version]
        asked[version] = subprocess.Popen(own, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = {version: one.communicate(timeout=300)[1] for version, one in asked.items()}
    assert len(wanted) > 10 and not {version: said[version] for version, one in asked.items() if one.returncode}
    for version in VERSIONS:
        lines = (tmp_path / version).read_text(encoding="utf-8").splitlines()
        assert wanted <= {line.partition("==")[0].lower() for line in lines}, version
