# SPDX-License-Identifier: MIT
"""Mesh quality figures and refusals."""

import numpy as np
import pytest

from fe_engine.conventions import CORNERS
from fe_engine.elements.hex8 import geometry
from fe_engine.errors import MeshError
from fe_engine.mesh import EDGES, Mesh, measure_quality
from tests.support.models import box, rotation_matrix


def test_counts():
    mesh = box((2, 3, 1), (1.0, 1.0, 1.0))
    assert (mesh.n_nodes, mesh.n_elements) == (24, 6)


def test_edges_join_corners_that_differ_in_one_coordinate():
    difference = np.abs(CORNERS[EDGES[:, 0]] - CORNERS[EDGES[:, 1]]).sum(axis=1)
    np.testing.assert_array_equal(difference, 2.0)
    assert len({tuple(sorted(edge)) for edge in EDGES.tolist()}) == 12


def test_brick_has_unit_jacobian_and_its_own_aspect():
    quality = box((2, 2, 2), (1.0, 2.0, 6.0)).check()
    assert quality.min_jacobian == pytest.approx(1.0, rel=1e-14)
    assert quality.max_aspect == pytest.approx(6.0, rel=1e-14)


def test_sheared_cell_has_the_sine_of_its_angle():
    mesh = box((1, 1, 1), (1.0, 1.0, 1.0))
    mesh.nodes[:, 0] += mesh.nodes[:, 2]
    assert mesh.check().min_jacobian == pytest.approx(np.sin(np.pi / 4.0), rel=1e-14)


def test_quality_does_not_depend_on_orientation_or_unit():
    mesh = box((2, 2, 2), (1.0, 1.5, 2.0), distort=0.2)
    moved = 1000.0 * mesh.nodes @ rotation_matrix((1.0, 2.0, 3.0), 1.0).T
    straight, turned = mesh.check(), measure_quality(moved, mesh.hexes)
    assert straight.min_jacobian < 0.95
    assert turned.min_jacobian == pytest.approx(straight.min_jacobian, rel=1e-12)
    assert turned.max_aspect == pytest.approx(straight.max_aspect, rel=1e-12)
    assert turned.worst_element == straight.worst_element


@pytest.mark.parametrize("corner", range(8))
def test_a_corner_pulled_inside_out_is_refused_with_its_element(corner):
    """The Jacobian of the Gauss points would still be positive for some of these."""
    mesh = box((2, 1, 1), (2.0, 1.0, 1.0))
    node = mesh.hexes[1, corner]
    mesh.nodes[node] += 1.3 * (mesh.nodes[mesh.hexes[1]].mean(axis=0) - mesh.nodes[node])
    with pytest.raises(MeshError, match=r"element \d near .* is inverted or flat"):
        mesh.check()


def test_the_worst_element_is_named():
    mesh = box((3, 1, 1), (3.0, 1.0, 1.0))
    mesh.hexes[1] = mesh.hexes[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    assert np.all(geometry(mesh.nodes, mesh.hexes)[1][1] < 0.0)
    with pytest.raises(MeshError, match="element 1 near"):
        mesh.check()


def test_a_node_without_an_element_is_refused():
    mesh = box((1, 1, 1), (1.0, 1.0, 1.0))
    loose = Mesh(np.vstack([mesh.nodes, [5.0, 5.0, 5.0]]), mesh.hexes)
    with pytest.raises(MeshError, match="node 8 belongs to no element"):
        loose.check()
