# SPDX-License-Identifier: MIT
"""w of springs with memory under a vertical load that changes: what the elements and the vertical springs each do."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import BeyondSprings
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, sequence
from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.vertical import K, vertical_path

LOADS = np.array([[3e5, 0.0], [-1e5, 0.0], [3e5, 0.0], [0.0, 0.0]])


def model() -> MacroModel:
    """Springs with memory whose elements settle, and vertical springs of a known curve."""
    tree = winkler.with_invented_memory(settling=True)
    for name, end in (("down", 1e-2), ("up", -1e-2)):
        path = vertical_path(tree["paths/ray_0"].to_dataset(inherit=False), end)
        tree[f"paths/{name}"] = xr.DataTree(path)
    return MacroModel.from_springs(Springs.of(tree), "memory")


def test_a_vertical_load_moves_w_on_the_curve_of_the_vertical_springs_and_changes_nothing_else() -> None:
    springs = model()
    change = np.array([0.0, 1e6, 2e6, 3e6])
    plain = sequence(springs, LOADS, extrapolate=True)
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        moved = sequence(springs, LOADS, V=springs.rest_load + change, extrapolate=True)
    for name in ("H", "M", "u", "rotation"):
        np.testing.assert_array_equal(moved[name].values, plain[name].values)
    np.testing.assert_allclose((moved["w"] - plain["w"]).values, change / (K - change / 5e-3), atol=1e-7)
    np.testing.assert_array_equal(moved["off_load"].values, change > 0.0)
    assert np.ptp(plain["w"].values) > 1e-4


def test_a_vertical_load_that_the_vertical_springs_do_not_reach_is_refused() -> None:
    springs = model()
    with pytest.raises(BeyondSprings, match="is beyond the vertical springs"):
        sequence(springs, LOADS, V=springs.rest_load - 2.99e6)
