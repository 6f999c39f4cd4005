# SPDX-License-Identifier: MIT
"""What is installed under licences that are not open, and that `--version` and THIRD-PARTY.md say so."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from pysprings import __version__
from pysprings.core.licences import PROPRIETARY, TESTS_ONLY, Installed, installed, text
from tests.support.commands import command
from tests.support.place import ROOT

NOTES = (ROOT / "THIRD-PARTY.md").read_text(encoding="utf-8")


def test_packages_are_found_by_their_folders(tmp_path: Path) -> None:
    for name in ("mkl-2026.2.0.dist-info", "intel_openmp-2026.2.0.dist-info", "numpy-2.4.6.dist-info", "mkl"):
        (tmp_path / name).mkdir()
    found = installed([str(tmp_path), str(tmp_path / "gone")])
    assert found == [
        Installed("intel-openmp", "2026.2.0", PROPRIETARY["intel-openmp"]),
        Installed("mkl", "2026.2.0", PROPRIETARY["mkl"]),
    ]
    assert "proprietary, installed by the extra mkl" in text(found)
    assert "  mkl 2026.2.0: Intel Simplified Software License" in text(found).splitlines()


def test_both_name_every_open_solver_that_takes_their_place() -> None:
    here = text([Installed("mkl", "1", PROPRIETARY["mkl"])])
    notes = re.search(r"taken out again.*?\n\n", NOTES, re.DOTALL)
    for name in ("rslab", "superlu"):
        assert notes and name in here.lower() and name in notes[0].lower()


def test_without_them_nothing_is_proprietary(tmp_path: Path) -> None:
    assert text(installed([str(tmp_path)])).endswith("no proprietary package is installed")


def test_the_table_is_what_the_packages_say() -> None:
    """Every installed package whose metadata calls it proprietary, and its licence."""
    noted = {}
    for each in metadata.distributions():
        kinds = each.metadata.get_all("Classifier") or []
        if "License :: Other/Proprietary License" in kinds and "Apache" not in (each.metadata["License"] or ""):
            noted[each.metadata["Name"]] = (each.version, each.metadata["License"])
    if not noted:
        pytest.skip("no proprietary package is installed here")
    found = {each.name: (each.version, each.licence) for each in installed() if each.name in PROPRIETARY}
    assert found == noted


def test_version_prints_itself_first_and_then_the_licences() -> None:
    done = command("--version")
    assert done.code == 0
    first, *rest = done.out.splitlines()
    assert first == f"pysprings {__version__}"
    assert "\n".join(rest) == text(installed())


def extra(name: str) -> set[str]:
    """Return the packages of an extra, with those of the extras of this package that it names."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = set[str]()
    for line in project["optional-dependencies"][name]:
        own = re.fullmatch(r"pysprings\[(.*)\]", line)
        found |= set().union(*map(extra, own[1].split(","))) if own else {re.split(r"[^\w-]", line)[0].lower()}
    return found


def test_development_brings_open_packages_alone_and_ci_the_others_first() -> None:
    closed = {"pypardiso", "openseespy"}
    assert extra("mkl") | extra("opensees") == closed
    assert {"pytest", "dash", "scikit-learn"} < extra("dev")
    assert not extra("dev") & closed
    steps = re.findall(r"^make (\w+)", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    assert steps[:2] == ["extras", "test"]
    recipe = (ROOT / "Makefile").read_text(encoding="utf-8").split("\nextras:")[1].split("\n\n")[0]
    assert '".[dev,mkl,opensees]"' in recipe


def test_the_notes_name_every_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = [re.match(r"[A-Za-z0-9_.-]+", line)[0] for line in project["dependencies"]]  # type: ignore[index]
    assert len(names) > 10
    rows = {match.lower() for match in re.findall(r"^\| ([A-Za-z0-9_.-]+) \|", NOTES, re.MULTILINE)}
    assert {name.lower() for name in [*names, *PROPRIETARY, *TESTS_ONLY]} - rows == set()
    assert "THIRD-PARTY.md" in project["license-files"]
