# SPDX-License-Identifier: MIT
"""Stations on faces: places, areas, normals, frames; a rotated interface gives the rotated answer."""

import numpy as np
import pytest

from fe_engine.assembly.system import System
from fe_engine.contact import coulomb
from fe_engine.elements.interface import Stations, local_frames, nodal_stations
from fe_engine.model import Model
from fe_engine.state import State
from tests.support.models import box, gauss_stations, placed, rotation_matrix, soil, to_matrix, to_voigt

SQUARE = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
FACE = np.array([[0, 1, 2, 3]])


def cylinder(n, radius=2.0, height=1.5):
    """Faces of a quarter of a wall of n facets with normals outwards."""
    angle = np.linspace(0.0, np.pi / 2.0, n + 1)
    ring = radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(n + 1)], axis=1)
    k = np.arange(n)
    faces = np.stack([k, k + 1, k + n + 2, k + n + 1], axis=1)
    return np.vstack([ring, ring + np.array([0.0, 0.0, height])]), faces


# --- places, areas, normals -------------------------------------------------------------------------------


def test_rectangle_has_a_quarter_at_each_node_and_point():
    node, normal, area = nodal_stations(SQUARE, FACE)
    np.testing.assert_array_equal(node, [0, 1, 2, 3])
    np.testing.assert_allclose(area, 1.5, rtol=1e-14)
    np.testing.assert_allclose(normal, [[0.0, 0.0, 1.0]] * 4, atol=1e-15)
    nodes, weight, normal, area = gauss_stations(SQUARE, FACE)
    np.testing.assert_allclose(area, 1.5, rtol=1e-14)
    np.testing.assert_allclose(normal, [[0.0, 0.0, 1.0]] * 4, atol=1e-15)
    np.testing.assert_array_equal(nodes, [[0, 1, 2, 3]] * 4)
    points = weight @ SQUARE - [1.0, 1.5, 0.0]
    np.testing.assert_allclose(np.abs(points[:, :2]), [[1.0 / 3**0.5, 1.5 / 3**0.5]] * 4, rtol=1e-14)


def test_normal_follows_the_order_of_the_corners():
    _, normal, area = nodal_stations(SQUARE, FACE[:, ::-1])
    np.testing.assert_allclose(normal, [[0.0, 0.0, -1.0]] * 4, atol=1e-15)
    assert np.all(area > 0.0)


def test_nodal_area_of_a_distorted_face_is_the_integral_of_the_shape_function():
    corners = SQUARE.copy()
    corners[2] = [2.5, 3.5, 0.0]
    _, _, area = nodal_stations(corners, FACE)
    _, weight, _, gauss = gauss_stations(corners, FACE)
    np.testing.assert_allclose(area, weight.T @ gauss, rtol=1e-13)
    # triangles (0, 1, 2) and (0, 2, 3)
    assert area.sum() == pytest.approx(0.5 * 2.0 * 3.5 + 0.5 * 2.5 * 3.0, rel=1e-13)


def test_nodes_shared_by_faces_collect_their_areas():
    nodes, faces = cylinder(4)
    _, normal, area = nodal_stations(nodes, faces)
    facet = 2.0 * np.sin(np.pi / 16.0) * 2.0 * 1.5
    vectors = area[:, None] * normal
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1)[[0, 5]], facet / 4.0, rtol=1e-13)
    # between two facets the mean normal is the radius, and the area is seen along it
    np.testing.assert_allclose(normal[1:4], nodes[1:4] / 2.0, atol=1e-14)
    np.testing.assert_allclose(area[1:4], facet / 2.0 * np.cos(np.pi / 16.0), rtol=1e-13)


@pytest.mark.parametrize("exact", [False, True], ids=["facet normals", "exact normals"])
def test_pressure_on_a_quarter_of_a_cylinder_has_the_resultant_of_its_projection(exact):
    nodes, faces = cylinder(16)
    radial = nodes * [0.5, 0.5, 0.0] if exact else None
    _, normal, area = nodal_stations(nodes, faces, radial)
    expected = [2.0 * 1.5, 2.0 * 1.5, 0.0]
    np.testing.assert_allclose(area @ normal, expected, rtol=3e-3 if exact else 1e-13, atol=1e-14)
    if exact:
        np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-14)
        np.testing.assert_allclose(normal, nodes * [0.5, 0.5, 0.0], atol=1e-15)


def test_gauss_and_nodal_rules_agree_on_the_closed_surface_vector():
    """The area vector of a warped face depends on its edges only: half the cross product of the diagonals."""
    corners = SQUARE.copy()
    corners[2, 2], corners[0, 0] = 0.6, -0.3
    expected = 0.5 * np.cross(corners[2] - corners[0], corners[3] - corners[1])
    _, _, normal, area = gauss_stations(corners, FACE)
    np.testing.assert_allclose(area @ normal, expected, rtol=1e-13)
    _, normal, area = nodal_stations(corners, FACE)
    np.testing.assert_allclose(area @ normal, expected, rtol=1e-13)


# --- frames -----------------------------------------------------------------------------------------------

NORMALS = {
    "wall in front": (1.0, 0.0, 0.0),
    "wall at the back": (-1.0, 0.0, 0.0),
    "wall at the side": (0.0, 1.0, 0.0),
    "oblique wall": (0.6, -0.8, 0.0),
    "facing down": (0.0, 0.0, 1.0),
    "facing up": (0.0, 0.0, -1.0),
    "steep slope": (0.6, 0.3, 0.4),
    "flat slope": (0.1, -0.2, 0.97),
}


@pytest.mark.parametrize("normal", NORMALS.values(), ids=NORMALS)
def test_frames_are_right_handed(normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    frame = local_frames(normal[None])[0]
    np.testing.assert_allclose(frame[0], normal, rtol=1e-15)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("name", [name for name in NORMALS if "wall" in name])
def test_on_walls_the_first_tangent_is_level_and_the_second_points_down(name):
    frame = local_frames(np.array([NORMALS[name]]))[0]
    np.testing.assert_allclose(frame[2], [0.0, 0.0, 1.0], atol=1e-15)
    assert frame[1, 2] == 0.0


@pytest.mark.parametrize("name", ["facing down", "facing up"])
def test_on_horizontal_faces_the_first_tangent_is_x(name):
    np.testing.assert_allclose(local_frames(np.array([NORMALS[name]]))[0, 1], [1.0, 0.0, 0.0], atol=1e-15)


def test_slopes_keep_the_second_tangent_pointing_down_and_the_first_level():
    normal = np.array([NORMALS["steep slope"]])
    frame = local_frames(normal / np.linalg.norm(normal))[0]
    assert frame[2, 2] > 0.0
    assert frame[1, 2] == pytest.approx(0.0, abs=1e-15)


# --- rotated interface ------------------------------------------------------------------------------------


def block_on_a_plate(turn, rule):
    """Soil block on a plate that moves with three translations; everything turned by a rotation."""
    mesh = box((2, 2, 1), (1.0, 1.0, 0.7), distort=0.1)
    mesh.nodes[:] = mesh.nodes @ turn.T
    faces = mesh.face_sets["top"]
    nodes, weight, normal, area = placed(mesh.nodes, faces, rule)
    ns = len(area)
    stations = Stations(
        np.zeros((ns, 3)), local_frames(normal), area, nodes, weight, np.tile(np.eye(3), (ns, 1, 1)),
        np.zeros(ns, dtype=np.int64),
    )  # fmt: skip
    stress = np.zeros((mesh.n_elements, 8, 6))
    stress[:] = to_voigt(turn @ to_matrix(-1.0e4 * np.array([1.0, 0.8, 1.2, 0.1, 0.0, -0.1])) @ turn.T)
    return Model(
        mesh, [soil(phi_i=0.3, phi_f=0.6)], np.zeros(mesh.n_elements, dtype=np.int64), stress,
        np.zeros((mesh.n_nodes, 3), dtype=bool), n_border=3, border_scale=np.ones(3), stations=stations,
        contact=coulomb.pack(1.0e8, 1.0e8, 0.5)[None], initial_pressure=np.full(ns, 1.2e4),
    )  # fmt: skip


def two_moves(turn, rule):
    """Residual after one committed and one trial move, turned back, and the contact states seen."""
    model = block_on_a_plate(turn, rule)
    system, state, rng = System(model), State(model), np.random.default_rng(4)
    for _ in range(2):
        state.commit()
        move = 6.0e-5 * rng.normal(size=(model.mesh.n_nodes, 3))
        plate = 6.0e-5 * rng.normal(size=3)
        system.apply(state, (move @ turn.T).ravel(), turn @ plate)
        out = system.residual(state)
    assert out.n_plastic > 0
    forces = np.vstack([out.free.reshape(-1, 3), out.border]) @ turn
    return forces, out.contact_norm, system.contact_state.copy()


@pytest.mark.parametrize("rule", ["nodal", "gauss"])
@pytest.mark.parametrize(
    ("axis", "angle"), [((0.0, 0.0, 1.0), 0.5), ((1.0, 0.0, 0.0), np.pi / 2), ((1.0, 2.0, -1.0), 2.0)]
)
def test_rotated_model_gives_the_rotated_forces(axis, angle, rule):
    straight, norm, states = two_moves(np.eye(3), rule)
    turned, norm_turned, states_turned = two_moves(rotation_matrix(axis, angle), rule)
    assert set(states) == {0, 1, 2}
    np.testing.assert_array_equal(states_turned, states)
    np.testing.assert_allclose(turned, straight, atol=1e-9 * np.abs(straight).max())
    assert norm_turned == pytest.approx(norm, rel=1e-9)
