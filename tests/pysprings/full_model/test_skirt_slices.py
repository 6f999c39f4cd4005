# SPDX-License-Identifier: MIT
"""Slices of the skirt on levels of uneven heights: what they cover, and forces and moments that they keep."""

import numpy as np
import pytest

from pysprings.full_model.collect import SkirtSlices, slices_of_elements, slices_of_rings

RINGS = np.array([0.0, 0.4, 1.0, 1.2, 3.0])


def of_bricks(*boundaries: float) -> SkirtSlices:
    return slices_of_rings(RINGS, np.isin(RINGS, boundaries))


def test_rings_of_one_layer_have_a_slice_each():
    slices = of_bricks()
    np.testing.assert_allclose(slices.bounds, [[0.0, 0.2], [0.2, 0.7], [0.7, 1.1], [1.1, 2.1], [2.1, 3.0]])
    np.testing.assert_array_equal(slices.depth, RINGS)
    np.testing.assert_array_equal(slices.shares, np.eye(5))
    np.testing.assert_array_equal(slices.main_ring, np.arange(5))


def test_a_ring_on_a_boundary_has_a_slice_on_each_side():
    slices = of_bricks(1.2)
    np.testing.assert_allclose(slices.bounds, [[0.0, 0.2], [0.2, 0.7], [0.7, 1.1], [1.1, 1.2], [1.2, 2.1], [2.1, 3.0]])
    np.testing.assert_allclose(slices.depth, [0.0, 0.4, 1.0, 1.15, 1.65, 3.0])
    np.testing.assert_allclose(slices.shares[3:5, 3], [0.1, 0.9])
    np.testing.assert_array_equal(slices.main_ring, [0, 1, 2, 3, 3, 4])


@pytest.mark.parametrize("ends", [(0.0,), (3.0,)])
def test_a_boundary_at_an_end_of_the_skirt_cuts_no_slice(ends):
    assert len(of_bricks(*ends).depth) == len(RINGS)


@pytest.mark.parametrize(
    "slices",
    [of_bricks(), of_bricks(0.4), of_bricks(1.0, 1.2), slices_of_elements(RINGS)],
    ids=["one layer", "a boundary", "a thin layer", "series"],
)
def test_slices_keep_forces_and_moments(slices):
    force = np.array([3.0, -1.0, 4.0, 1.0, -5.0])
    assert slices.forces(force).sum() == pytest.approx(force.sum())
    moment = slices.forces(force) @ slices.depth + slices.turning(force).sum()
    assert moment == pytest.approx(force @ RINGS)
    np.testing.assert_array_equal(slices.bounds[1:, 0], slices.bounds[:-1, 1])
    assert (slices.height > 0.0).all() and slices.height.sum() == pytest.approx(3.0)
    np.testing.assert_allclose(slices.on_lines(np.stack([2.0 - 3.0 * RINGS] * 2)), [2.0 - 3.0 * slices.depth] * 2)


def test_elements_share_the_force_of_a_node_by_their_heights():
    slices = slices_of_elements(np.array([0.0, 0.5, 1.0, 2.5, 4.0]))
    np.testing.assert_allclose(slices.shares, [[1, 1, 0.25, 0, 0], [0, 0, 0.75, 1, 1]])
    np.testing.assert_allclose(slices.bounds, [[0.0, 1.0], [1.0, 4.0]])
