# SPDX-License-Identifier: MIT
"""Random scenes through a whole run: no error of the program, no lost result, no balance that does not close."""

from pathlib import Path

import pytest

from tests.fuzz.runs import faults


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")  # as outside of pytest, words on stderr
@pytest.mark.parametrize("seed", range(30))
def test_a_random_scene_runs_or_is_refused_in_words(seed: int, tmp_path: Path) -> None:
    _, wrong = faults(seed, tmp_path)
    assert wrong == []
