# SPDX-License-Identifier: MIT
"""The SoilDyn library, built once, and points on spring files of models."""

from pathlib import Path

import pytest

from pysprings.macro.model import MacroModel
from pysprings.results.exporters.soildyn.library import build, spring_text
from tests.support.foundation import Point, PointOn


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("library"))


@pytest.fixture
def point_on(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> PointOn:
    """A point on the springs of a model, whose file NAME.txt in the present folder has no header."""
    monkeypatch.chdir(tmp_path)  # names of files have 45 letters at most

    def made(model: MacroModel, torsion: float = 1e9, total: bool = True, stop: bool = False, name="caisson") -> Point:
        Path(f"{name}.txt").write_text(spring_text([], model, torsion, total, stop))
        return Point(library, f"./{name}.txt")

    return made
