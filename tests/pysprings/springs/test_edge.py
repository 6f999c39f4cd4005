# SPDX-License-Identifier: MIT
"""Edge rings of the tip: which they are; springs on other slices carry the same load in every state."""

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.springs.checks import validate_springs
from pysprings.springs.path import paths_of
from pysprings.springs.sums import by_depth, resultants, with_moment
from pysprings.springs.tip_zone import edge_rings, reslice
from tests.support import synthetic

PATHS = (synthetic.Path("pull", size=8e-3, steps=8), synthetic.Path("turn", "rotation", size=2e-3, steps=5))


@pytest.mark.parametrize(
    ("bounds", "expected"),
    [
        ([0.0, 1.0, 2.0, 4.0], [False, False, True]),
        ([0.0, 2.0, 3.6, 3.9, 4.0], [False, False, True, True]),
        ([0.0, 4.0], [False]),
    ],
)
def test_edge_rings_lie_in_the_last_tenth_and_the_last_is_one(bounds: list[float], expected: list[bool]) -> None:
    path = xr.Dataset({"depth_bounds": (("depth", "bound"), np.column_stack([bounds[:-1], bounds[1:]]))})
    assert edge_rings(path).tolist() == expected


def test_a_moment_that_is_added_leaves_a_soft_layer_its_p() -> None:
    """Half a per cent of the moment, which the edge of the tip has beyond the middle of its slice; 0 stays 0."""
    z, heights = np.array([0.5, 1.5, 3.0, 5.0, 7.0]), np.array([1.0, 1.0, 2.0, 2.0, 2.0])
    p = np.stack([np.array([10.0, 20.0, 40.0, 2000.0, 9000.0]), np.zeros(5)], axis=1)
    moment = (heights * z) @ p * 1.005
    found = with_moment(p, moment, z, heights)
    np.testing.assert_allclose(heights @ found, heights @ p, rtol=1e-12)
    np.testing.assert_allclose((heights * z) @ found, moment, rtol=1e-12)
    assert (np.abs(found / np.where(p, p, 1.0) - 1.0)[:, 0] < 0.3).all() and not found[:, 1].any()


def springs_with_a_peak() -> xr.DataTree:
    """Springs whose last ring has several times the reaction, in balance."""
    springs = synthetic.make_springs(PATHS)
    for name in ("pull", "turn"):
        for p in ("p", "p_component"):
            springs[f"paths/{name}"][p][-1] *= 7.0
        springs[f"paths/{name}"]["t"][-1] += 3e3
        path = springs[f"paths/{name}"]
        for load, values in resultants(path.to_dataset(inherit=False)).items():
            path[load][:] = values
    return springs


@pytest.mark.parametrize("bounds", [None, [0.0, 4.0], [0.0, 0.7, 1.9, 2.0, 4.0]], ids=["tip zone", "one", "own"])
def test_other_slices_keep_the_loads_of_every_state(bounds: list[float] | None) -> None:
    springs = springs_with_a_peak()
    before = springs.copy(deep=True)
    new = reslice(springs, bounds)
    validate_springs(new)
    assert springs.identical(before)
    for name in ("pull", "turn"):
        old, path = paths_of(before)[name].dataset, paths_of(new)[name].dataset
        for load, values in resultants(old).items():
            assert np.allclose(resultants(path)[load], values, rtol=1e-12, atol=1e-9 * np.abs(values).max())
        expected = path["u"] - path["rotation"] * path["depth"]
        assert np.allclose(path["y"], expected.transpose(*path["y"].dims), atol=1e-12)
        assert path["depth_bounds"].values[[0, -1], [0, -1]].tolist() == [0.0, 4.0]
        for part in ("H_tip", "M_lid"):
            assert path[part].identical(old[part])


def test_the_zone_at_the_tip_has_the_mean_of_what_it_covers() -> None:
    springs = springs_with_a_peak()
    old, new = paths_of(springs)["pull"].dataset, paths_of(reslice(springs))["pull"].dataset
    bounds = new["depth_bounds"].values
    assert bounds[-1] == pytest.approx([3.2, 4.0])
    covered = np.clip(old["depth_bounds"].values[:, 1] - np.maximum(old["depth_bounds"].values[:, 0], 3.2), 0.0, None)
    assert np.allclose(by_depth(new, "p")[-1], covered @ by_depth(old, "p") / 0.8)
    assert len(bounds) < old.sizes["depth"]


def test_slices_as_they_are_change_nothing() -> None:
    springs = springs_with_a_peak()
    path = paths_of(springs)["pull"].dataset
    edges = [*path["depth_bounds"].values[:, 0], 4.0]
    same = paths_of(reslice(springs, edges))["pull"].dataset
    for name in ("p", "m", "t", "y"):
        assert np.allclose(same[name], path[name], rtol=1e-12, atol=1e-9)
    assert same["depth"].values.tolist() == path["depth"].values.tolist()


@pytest.mark.parametrize("bounds", [[0.0, 3.0], [0.0, 2.0, 1.0, 4.0], [4.0], 1.0])
def test_slices_that_do_not_cover_the_skirt_are_refused(bounds: object) -> None:
    with pytest.raises(UserInputError, match="from 0 to the skirt length, 4 m"):
        reslice(synthetic.make_springs(PATHS), bounds)  # type: ignore[arg-type]
