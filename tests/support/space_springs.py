# SPDX-License-Identifier: MIT
"""Springs with memory in space: invented elements, and those calibrated on the outside law of `space_paths`."""

from functools import cache

import numpy as np
import pytest

from pysprings.memory import build
from pysprings.memory.build import with_memory
from pysprings.memory.calibration import calibrate
from pysprings.memory.elements import PLASTIC, PLATES, SPACE_COLUMNS
from pysprings.memory.offered import Candidates, in_space
from pysprings.memory.shares import samples
from pysprings.springs.springs import Springs
from tests.support import space_paths
from tests.support.winkler import REACH, mixed


def few(reach):
    """Perfectly plastic candidates alone, quick to calibrate, for rays of a reach [m]."""
    sizes = np.geomspace(2e-3, 1.0, 7) * reach
    angles = np.arange(9) * np.pi / 9
    plastic = np.array([[a, g, d, 0.0, reach] for a in angles for g in (0.1, 0.3) for d in sizes])
    return Candidates(plastic, *[np.zeros((0, n)) for n in (3, 4, 3)])


def planar(table, springs):
    """Planar elements of the Winkler springs from `few` candidates."""
    scale = np.array([1.0, springs.length])
    stiffness = springs.lateral_stiffness / scale / scale[:, None]
    return calibrate(samples(springs, table), table, stiffness, few(REACH))


@cache
def elements(seed=1, n=8):
    """Elements of all kinds in space, (n, SPACE_COLUMNS): round and spread ones, and torsion."""
    rows = mixed(n, seed)
    spread = np.isin(rows[:, 0], PLATES) | (np.arange(len(rows)) % 2 == 0) & (rows[:, 0] == PLASTIC)
    twist = np.zeros((3, SPACE_COLUMNS))
    twist[:, :10], twist[:, 12] = rows[rows[:, 0] == PLASTIC][:3], 1.0
    return np.concatenate([in_space(rows, spread), twist])


@cache
def calibrated(twisted=True):
    """Springs on the outside law with their elements in space, as a file holds them."""
    tree = space_paths.springs(twisted)
    springs = Springs.of(tree)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "calibrate", lambda _ways, table, *_args, **_named: planar(table, springs))
        return with_memory(tree)
