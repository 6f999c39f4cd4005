# SPDX-License-Identifier: MIT
"""What SuperLU costs beside Pardiso: the laws beside runs that were measured, and what `check` prints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pysprings.model.forecast.resources import memory_bytes
from pysprings.model.forecast.run_time import superlu_bytes, superlu_time, uses_superlu
from tests.support import tiny
from tests.support.commands import command

BRICKS = {"mesh": {"discretisation": "hex8"}, "solver": {"linear": "superlu"}}


@pytest.mark.parametrize(("unknowns", "ratio", "peak"), [(4_631, 11.9 / 4.1, 0.45e9), (13_863, 81.6 / 13.8, 1.08e9)])
def test_laws_are_near_what_was_measured(unknowns: int, ratio: float, peak: float) -> None:
    """Drained, to 2.5 mm, `coarse` and `medium`."""
    assert superlu_time(unknowns) == pytest.approx(ratio, rel=0.05)
    assert memory_bytes(unknowns) + superlu_bytes(unknowns) == pytest.approx(peak, rel=0.15)
    assert superlu_time(100) == 1.0


def test_a_series_uses_neither() -> None:
    assert uses_superlu(tiny.paper(**BRICKS))
    assert not uses_superlu(tiny.paper(solver={"linear": "superlu"}, mesh={"discretisation": "fourier"}))


def test_check_prints_what_the_extra_would_save(tmp_path: Path) -> None:
    scene = tiny.write(tiny.paper(**BRICKS), tmp_path / "bricks.toml")
    about = json.loads(command("check", scene, "--json").out)
    assert 0.0 < about["time_with_pardiso_s"] < about["time_s"]
    assert 0.0 < about["memory_with_pardiso_GB"] < about["memory_GB"]
    assert "time with Pardiso (extra mkl)" in command("check", scene).out
    assert "Pardiso" not in command("check", scene, "--discretisation", "fourier").out
