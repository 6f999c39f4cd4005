# SPDX-License-Identifier: MIT
"""Scene files, damaged and extreme, through `pysprings check`: described, or refused in clear lines."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from pysprings.model.forecast import resources
from pysprings.model.stages import path_stages
from pysprings.scene.load import load_scene
from tests.fuzz.judge import run
from tests.fuzz.mutate import QUICK, budget
from tests.fuzz.scenes import damaged, typed

DAMAGED, TYPED = "scene files, damaged", "scenes over all ranges"


@pytest.fixture(autouse=True)
def _on_a_small_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes that take long to build are refused: the refusal is among what is tried."""
    monkeypatch.setattr(resources, "memory_limit", lambda: 0.45e9)


def check(kind: str, folder: Path, data: bytes) -> None:
    """Check a scene file; what is accepted is written and read back, and has finite stages."""
    file = folder / "scene.toml"
    file.write_bytes(data)
    if run(kind, folder, "check", file, "--json").code:
        return
    scene = load_scene(file)
    again = folder / "again.toml"
    again.write_text(scene.to_toml(), encoding="utf-8")
    assert load_scene(again) == scene
    for path in scene.paths:
        for stage in path_stages(scene, path, 1.0, 1.0):
            assert np.isfinite([*stage.target, *stage.force, stage.duration, *stage.stops]).all()
            assert 0.0 < stage.first_fraction <= 1.0
            assert 0.0 < stage.max_fraction <= 1.0


@budget(QUICK)
@given(data=damaged())
def test_damaged_scenes(tmp_path: Path, data: bytes) -> None:
    check(DAMAGED, tmp_path, data)


@pytest.mark.long
@budget(1300)
@given(data=damaged())
def test_many_damaged_scenes(tmp_path: Path, data: bytes) -> None:
    check(DAMAGED, tmp_path, data)


@budget(QUICK)
@given(text=typed())
def test_typed_scenes(tmp_path: Path, text: str) -> None:
    check(TYPED, tmp_path, text.encode())


@pytest.mark.long
@budget(900)
@given(text=typed())
def test_many_typed_scenes(tmp_path: Path, text: str) -> None:
    check(TYPED, tmp_path, text.encode())
