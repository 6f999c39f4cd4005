# SPDX-License-Identifier: MIT
"""The macro-model of a fan whose springs soften."""

import pytest

from pysprings.macro.model import MacroModel
from tests.support.fans import fan_springs, potential


@pytest.fixture(scope="session")
def bent() -> MacroModel:
    return MacroModel.from_springs(fan_springs(potential), "fan")
