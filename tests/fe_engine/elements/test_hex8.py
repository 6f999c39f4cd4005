# SPDX-License-Identifier: MIT
"""Hexahedron: interpolation, B-bar operators, patch tests, no locking, no spurious modes."""

import numpy as np
import pytest

from fe_engine.conventions import CORNERS
from fe_engine.elements import hex8
from fe_engine.model import Model, Stage
from fe_engine.soil import elastic, plasol
from fe_engine.soil.elastic import elastic_matrix
from tests.support.models import box, rotation_matrix, run, soil, to_voigt

YOUNG, POISSON = 2.0e8, 0.3
POINTS = np.random.default_rng(1).uniform(-1.0, 1.0, (5, 3))
# displacement gradient: stretch, shear and rotation, mostly compression so that sand keeps its pressure
GRADIENT = 1.0e-3 * np.array([[-1.2, 0.7, -0.2], [0.1, 0.3, 0.5], [0.4, -0.6, -0.5]])


@pytest.fixture
def element():
    """Gradients, volumes and mean gradient of one distorted element, with its corners."""
    mesh = box((1, 1, 1), (1.0, 1.4, 0.8), distort=0.2)
    gradient, volume, mean = hex8.geometry(mesh.nodes, mesh.hexes)
    return mesh.nodes[mesh.hexes[0]], gradient[0], volume[0], mean[0]


def operator(gradient, mean):
    b = np.zeros((6, 24))
    hex8.b_bar(gradient, mean, b)
    return b


def stiffness_of(gradient, volume, mean, matrix):
    stiffness = np.zeros((24, 24))
    for g in range(8):
        hex8.add_stiffness(operator(gradient[g], mean), matrix, volume[g], np.empty((6, 24)), stiffness)
    return stiffness


# --- interpolation ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("xi", POINTS)
def test_shape_functions_reproduce_linear_fields(xi):
    assert hex8.shape(xi).sum() == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(hex8.shape(xi) @ CORNERS, xi, atol=1e-15)
    np.testing.assert_allclose(CORNERS.T @ hex8.shape_gradient(xi), np.eye(3), atol=1e-15)
    np.testing.assert_allclose(hex8.shape_gradient(xi).sum(axis=0), 0.0, atol=1e-15)


def test_shape_functions_are_one_at_their_own_corner():
    np.testing.assert_array_equal([hex8.shape(corner) for corner in CORNERS], np.eye(8))


@pytest.mark.parametrize("xi", POINTS)
def test_shape_gradient_is_the_derivative(xi):
    h = 1.0e-6
    difference = np.stack([(hex8.shape(xi + h * e) - hex8.shape(xi - h * e)) / (2.0 * h) for e in np.eye(3)], axis=1)
    np.testing.assert_allclose(hex8.shape_gradient(xi), difference, atol=1e-10)


def test_volume_does_not_depend_on_inner_nodes():
    mesh = box((3, 3, 3), (1.0, 2.0, 3.0))
    inner = np.all((mesh.nodes > 0.0) & (mesh.nodes < [1.0, 2.0, 3.0]), axis=1)
    mesh.nodes[inner] += np.random.default_rng(2).uniform(-0.1, 0.1, (inner.sum(), 3))
    _, volume, _ = hex8.geometry(mesh.nodes, mesh.hexes)
    assert volume.sum() == pytest.approx(6.0, rel=1e-13)
    assert np.ptp(volume.sum(axis=1)) > 0.01


def test_gauss_positions_give_the_centroid():
    mesh = box((2, 2, 2), (1.0, 2.0, 3.0))
    _, volume, _ = hex8.geometry(mesh.nodes, mesh.hexes)
    positions = hex8.gauss_positions(mesh.nodes, mesh.hexes)
    np.testing.assert_allclose(np.einsum("eg,egi->i", volume, positions) / 6.0, [0.5, 1.0, 1.5], rtol=1e-13)
    assert np.unique(np.round(positions[:, :, 0], 6)).size == 4


# --- operators --------------------------------------------------------------------------------------------


def test_linear_displacement_has_its_own_strain(element):
    corners, gradient, _, mean = element
    expected = to_voigt(0.5 * (GRADIENT + GRADIENT.T), 2.0)
    for g in range(8):
        strain = np.empty(6)
        hex8.strain_at(gradient[g], mean, corners @ GRADIENT.T, strain)
        np.testing.assert_allclose(strain, expected, atol=1e-17)
        np.testing.assert_allclose(operator(gradient[g], mean) @ (corners @ GRADIENT.T).ravel(), expected, atol=1e-17)


@pytest.mark.parametrize("axis", np.eye(3))
def test_rigid_motion_has_no_strain(element, axis):
    corners, gradient, _, mean = element
    for motion in (np.cross(axis, corners), np.tile(axis, (8, 1))):
        for g in range(8):
            strain = np.empty(6)
            hex8.strain_at(gradient[g], mean, motion, strain)
            np.testing.assert_allclose(strain, 0.0, atol=1e-14)


def test_volumetric_strain_is_the_element_mean(element):
    _, gradient, volume, mean = element
    motion = np.random.default_rng(3).normal(size=(8, 3))
    divergence = np.einsum("gai,ai->g", gradient, motion)
    assert np.ptp(divergence) > 0.1
    for g in range(8):
        strain = np.empty(6)
        hex8.strain_at(gradient[g], mean, motion, strain)
        assert strain[:3].sum() == pytest.approx(volume @ divergence / volume.sum(), rel=1e-12)


def test_force_and_stiffness_use_the_operator_of_the_strain(element):
    _, gradient, volume, mean = element
    rng = np.random.default_rng(4)
    stress, matrix, motion = rng.normal(size=6), rng.normal(size=(6, 6)), rng.normal(size=(8, 3))
    b, strain, force, stiffness = operator(gradient[3], mean), np.empty(6), np.zeros(24), np.zeros((24, 24))
    hex8.strain_at(gradient[3], mean, motion, strain)
    hex8.add_force(gradient[3], mean, volume[3], stress, force)
    hex8.add_stiffness(b, matrix, volume[3], np.empty((6, 24)), stiffness)
    np.testing.assert_allclose(strain, b @ motion.ravel(), atol=1e-14)
    np.testing.assert_allclose(force, volume[3] * b.T @ stress, atol=1e-14)
    np.testing.assert_allclose(stiffness, volume[3] * b.T @ matrix @ b, atol=1e-14)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.499])
def test_stiffness_is_symmetric_with_six_rigid_modes(element, poisson):
    _, gradient, volume, mean = element
    stiffness = stiffness_of(gradient, volume, mean, elastic_matrix(1.0, poisson))
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-13 * stiffness.max())
    modes = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
    assert np.all(np.abs(modes[:6]) < 1.0e-12)
    assert modes[6] > 1.0e-2


# --- patch tests ------------------------------------------------------------------------------------------


def patch(law, frames):
    """Distorted block whose surface nodes follow u = GRADIENT x times one border dof."""
    plain = box((3, 2, 2), (1.5, 1.0, 1.0))
    mesh = box((3, 2, 2), (1.5, 1.0, 1.0), distort=0.15)
    outside = np.any((plain.nodes == 0.0) | (plain.nodes == [1.5, 1.0, 1.0]), axis=1)
    move = mesh.nodes @ GRADIENT.T
    turned = {node: rotation_matrix((1.0, node, 2.0), 0.3 * node) for node in range(mesh.n_nodes) if frames}
    for node, frame in turned.items():
        move[node] = frame @ move[node]
    rows = [(node, i, 0, move[node, i]) for node in np.flatnonzero(outside) for i in range(3)]
    stress = np.zeros((mesh.n_elements, 8, 6))
    stress[:, :, :3] = -1.0e5
    model = Model(
        mesh, [soil(law)], np.zeros(mesh.n_elements, dtype=np.int64), stress, np.zeros((mesh.n_nodes, 3), dtype=bool),
        frames=turned, followers=np.array(rows), n_border=1, border_scale=np.ones(1),
    )  # fmt: skip
    return model, move, outside


@pytest.mark.parametrize("frames", [False, True], ids=["global axes", "axes of their own"])
@pytest.mark.parametrize("law", [elastic.LAW, plasol.LAW], ids=["elastic", "sand"])
def test_patch_of_distorted_elements_keeps_a_constant_strain(law, frames):
    model, expected, outside = patch(law, frames)
    assert (~outside).sum() == 2
    out = run(model, stage_of_one_dof(), tolerance=1.0e-12)
    state = out.state.committed
    np.testing.assert_allclose(state.displacement, expected, atol=1e-12)
    np.testing.assert_allclose(state.stress, np.broadcast_to(state.stress[0, 0], state.stress.shape), atol=1e-3)
    assert state.history.shape[2] == (law == plasol.LAW) and np.all(state.history > 0.0)
    # work-conjugate of the border dof: stress change times strain times volume
    strain, change = to_voigt(0.5 * (GRADIENT + GRADIENT.T), 2.0), state.stress[0, 0] - model.initial_stress[0, 0]
    volume = out.driver.newton.system.volume.sum()
    assert out.steps[-1].multipliers[0] == pytest.approx(volume * strain @ change, rel=1e-9)


def stage_of_one_dof(value=1.0):
    """Stage that brings the only border dof to a value."""
    one = np.ones((1, 1))
    return Stage("test", one, np.array([value]), one, np.zeros(1), first_fraction=0.1, max_fraction=0.5)


# --- locking ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("poisson", [0.3, 0.499, 0.49999])
def test_thick_cylinder_does_not_lock(poisson):
    """Lame, plane strain: p = u_a E (b2 - a2) / ((1 + nu) a (a2 (1 - 2 nu) + b2)); a = 1 m, b = 3 m."""
    displacement, height, angle = 1.0e-3, 0.3, np.pi / 4.0
    mesh = box((10, 6, 1), (np.log(3.0), angle, height))
    log_radius, turn = mesh.nodes[:, 0].copy(), mesh.nodes[:, 1].copy()
    mesh.nodes[:, 0], mesh.nodes[:, 1] = np.exp(log_radius) * np.cos(turn), np.exp(log_radius) * np.sin(turn)
    frames = {node: rotation_matrix((0.0, 0.0, -1.0), turn[node]) for node in range(mesh.n_nodes)}
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    fixed[:, 2] = True
    fixed[(turn == 0.0) | (turn == angle), 1] = True
    inner = np.flatnonzero(log_radius == 0.0)
    model = Model(
        mesh, [soil(elastic.LAW, poisson=poisson)], np.zeros(mesh.n_elements, dtype=np.int64),
        np.zeros((mesh.n_elements, 8, 6)), fixed, frames=frames,
        followers=np.array([(node, 0, 0, 1.0) for node in inner]), n_border=1, border_scale=np.ones(1),
    )  # fmt: skip
    force = run(model, stage_of_one_dof(displacement)).steps[-1].multipliers[0]
    pressure = displacement * YOUNG * 8.0 / ((1.0 + poisson) * (1.0 - 2.0 * poisson + 9.0))
    assert force / (angle * height) == pytest.approx(pressure, rel=0.01)
