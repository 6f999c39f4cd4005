# SPDX-License-Identifier: MIT
"""Result -> springs: the same numbers, paths that carry springs, and the balance of a real run."""

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.macro.comparison import compare
from pysprings.macro.predict import predict
from pysprings.springs.checks import SCHEMA, extract_springs
from pysprings.springs.path import paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance
from tests.support import tiny


@pytest.fixture
def result() -> xr.DataTree:
    """Two paths of the same run, free to be changed."""
    tree = tiny.result().copy(deep=True)
    tree["paths/again"] = tree["paths/pull"].copy(deep=True)
    return tree


def test_springs_hold_the_reactions_of_the_result() -> None:
    result = tiny.result()
    springs = extract_springs(result)
    path, full = springs["paths/pull"].to_dataset(inherit=False), result["paths/pull"].to_dataset(inherit=False)
    np.testing.assert_array_equal(path["p_component"], full["p_component"])
    for name in ("m", "t", "y", "u", "rotation", "H", "M", "H_tip", "M_lid", "depth_bounds", "time"):
        np.testing.assert_array_equal(path[name], full[name])
    np.testing.assert_array_equal(springs["stiffness_initial"], result["stiffness_initial"])
    assert path.attrs == full.attrs
    assert springs.attrs["schema"] == SCHEMA
    for name in ("scene_sha256", "scene_toml", "outer_diameter_m", "vertical_load_N", "mesh_preset", "status"):
        assert springs.attrs[name] == result.attrs[name]
    assert "section" not in springs.children


def test_reactions_balance_the_load_of_a_real_run() -> None:
    missing = balance(Springs.of(extract_springs(tiny.result())).path().dataset)
    assert max(missing.values()) < 1e-6
    assert missing["H"] < 1e-12  # not by tolerance: the load is the sum of the same tractions


def test_a_path_without_a_converged_step_has_no_springs(result: xr.DataTree) -> None:
    result["paths/again"]["converged"][1:] = 0
    assert list(paths_of(extract_springs(result))) == ["pull"]
    result["paths/pull"].dataset = result["paths/pull"].to_dataset(inherit=False).isel(step=[0])
    with pytest.raises(UserInputError, match="no path has a converged step: no springs can be made"):
        extract_springs(result)


def test_one_converged_step_makes_a_straight_spring(result: xr.DataTree) -> None:
    """An elastic path of one step says all there is to say."""
    result["paths/pull"].dataset = result["paths/pull"].to_dataset(inherit=False).isel(step=[0, 1])
    springs = extract_springs(result)
    end = paths_of(springs)["pull"].dataset.isel(step=-1)
    half = predict(springs, H=0.5 * float(end["H"]), arm=0.0)
    assert float(half["u"]) == pytest.approx(0.5 * float(end["u"]), rel=1e-6)


def test_an_empty_result_is_refused() -> None:
    with pytest.raises(UserInputError, match="no springs can be made"):
        extract_springs(xr.DataTree())


def test_springs_and_results_of_earlier_versions_are_refused_by_every_reader(result: xr.DataTree) -> None:
    """Opened by xarray itself, too: their signs differ."""
    springs, old = extract_springs(result), result.copy(deep=False)
    del old.attrs["schema"]
    springs.attrs["schema"] = f"{SCHEMA[:-1]}3"
    for ask in (lambda: predict(springs, H=1e3), lambda: compare(springs), lambda: extract_springs(old)):
        with pytest.raises(UserInputError, match="schema: "):
            ask()
