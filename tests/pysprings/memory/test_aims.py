# SPDX-License-Identifier: MIT
"""Aims of springs with memory: errors of a known size are found, and counted beside their limits."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from benchmarks import memory_aims
from benchmarks.memory_aims import Aim, met
from pysprings.macro.cycles import Followed
from pysprings.springs.path import SpringPath
from tests.support import winkler


def test_loads_that_are_four_per_cent_too_large_are_that_in_peaks_and_work() -> None:
    u = np.concatenate([np.linspace(a, b, 20)[1:] for a, b in ((0, 5), (5, 0), (0, 5), (5, -5), (-5, 5))]) * 1e-3
    H = winkler.masing(u)
    motions, loads = np.stack([u, 0.1 * u], axis=1), np.stack([H, 0.2 * H], axis=1)
    path = cast(SpringPath, SimpleNamespace(name="loop", role="held-back"))
    one = Followed(path, "memory", "displacement", (motions, loads), (motions, 1.04 * loads), "")
    assert memory_aims.loop_errors(one) == pytest.approx([4.0, 4.0])


def test_a_path_without_an_answer_meets_no_aim_and_one_without_a_limit_does_not_count() -> None:
    found = [
        Aim("loads", "a", "u", 3.0, 4.0),
        Aim("loads", "a", "rotation", 9.0, 4.0),
        Aim("loads", "b", "u", 50.0, np.inf),
    ]
    assert met(found) == "1 of 2" and found[1].over == 5.0
    assert met([Aim("climb", "c", "u", np.inf, 4.0)]) == "0 of 1"
