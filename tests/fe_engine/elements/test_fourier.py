# SPDX-License-Identifier: MIT
"""Elements in Fourier series: interpolation, strains against differences in space, rigid motions, patches, forces."""

import numpy as np
import pytest

from fe_engine.elements import fourier as elements
from fe_engine.soil.elastic import elastic_matrix

QUAD = np.array([[1.0, 0.2], [2.1, 0.1], [2.3, 1.4], [0.9, 1.2]])


def curved(corners=QUAD):
    """Nodes (8, 2) of an element with straight sides."""
    return np.concatenate([corners, 0.5 * (corners + np.roll(corners, -1, axis=0))])


def test_shape_functions_are_one_at_their_node_and_zero_at_others():
    values = np.array([elements.shape(*at) for at in elements.LOCAL])
    np.testing.assert_allclose(values, np.eye(8), atol=1e-15)


def test_gradients_are_the_derivatives_of_the_shape_functions():
    h, at = 1e-6, np.array([0.3, -0.7])
    for i in range(2):
        step = h * np.eye(2)[i]
        slope = (elements.shape(*(at + step)) - elements.shape(*(at - step))) / (2 * h)
        np.testing.assert_allclose(elements.shape_gradient(*at)[:, i], slope, atol=1e-9)


@pytest.mark.parametrize("k", [0, 1, 2, 5])
def test_strains_are_those_of_the_field_in_space(k):
    """u_r, u_theta, u_z of a bilinear field, differentiated by hand and by the element."""
    nodes, quads = curved(), np.arange(8)[None]
    gradient, _ = elements.geometry(nodes, quads)
    r, z = nodes.T
    move = np.zeros((8, 3, k + 1))
    move[:, 0, k], move[:, 1, k], move[:, 2, k] = 2 + 3 * r - z, 1 - r + 4 * z, 5 * r + 2 * z
    if k == 0:
        move[:, 1] = 0.0
    found = np.empty((k + 1, 6))
    for g, (r, z) in enumerate(elements.gauss_positions(nodes, quads)[0]):
        elements.amplitudes(gradient[0, g], move, np.arange(k + 1.0), found)
        u, v, w = 2 + 3 * r - z, (1 - r + 4 * z) * (k > 0), 5 * r + 2 * z
        v_r, v_z = (-1.0, 4.0) if k else (0.0, 0.0)
        wanted = [3, (u + k * v) / r, 2, v_r - v / r - k * u / r, v_z - k * w / r, -1 + 5]
        np.testing.assert_allclose(found[k], wanted, rtol=1e-12, atol=1e-12)


def rigid(nodes, k):
    """Coefficients (8, 3) of the rigid motions of a harmonic: along z; along x, and about y."""
    r, z = nodes.T
    if k == 0:
        return [np.stack([0 * r, 0 * r, 1 + 0 * r], axis=1)]
    return [np.stack([1 + 0 * r, -1 + 0 * r, 0 * r], axis=1), np.stack([z, -z, -r], axis=1)]


@pytest.mark.parametrize("k", [0, 1])
def test_rigid_motions_cost_no_energy(k):
    nodes, quads = curved(), np.arange(8)[None]
    gradient, volume = elements.geometry(nodes, quads)
    matrix = elements.stiffness(gradient, volume, elastic_matrix(2e8, 0.3)[None, None].repeat(4, axis=1), k)[0]
    motions = rigid(nodes, k)
    assert len(motions) in (1, 2)
    for motion in motions:
        np.testing.assert_allclose(matrix @ motion.ravel(), 0.0, atol=1e-6 * np.abs(matrix).max())


def test_every_other_motion_costs_energy():
    gradient, volume = elements.geometry(curved(), np.arange(8)[None])
    free = {0: 24 - 8 - 1, 1: 24 - 2, 2: 24}  # k = 0 has no u_theta
    for k, rank in free.items():
        matrix = elements.stiffness(gradient, volume, elastic_matrix(2e8, 0.3)[None, None].repeat(4, axis=1), k)[0]
        np.testing.assert_allclose(matrix, matrix.T, rtol=1e-12, atol=1e-3)
        found = np.linalg.matrix_rank(matrix, tol=1e-7 * np.abs(matrix).max())
        assert rank - 2 <= found <= rank  # two by two points leave at most two motions of one element without energy


def test_forces_are_the_transpose_of_strains():
    rng, nodes = np.random.default_rng(3), curved()
    gradient, _ = elements.geometry(nodes, np.arange(8)[None])
    move, stress = rng.normal(size=(8, 3, 4)), rng.normal(size=(4, 6))
    strain, force = np.empty((4, 6)), np.zeros((8, 3, 4))
    elements.amplitudes(gradient[0, 1], move, np.arange(4.0), strain)
    elements.add_force(gradient[0, 1], stress, np.arange(4.0), np.arange(8), force)
    assert np.sum(force * move) == pytest.approx(np.sum(stress * strain), rel=1e-12)
    wave = elements.waves(np.array([0.7]), 3)[0]
    at, back, point = np.empty(6), np.zeros((4, 6)), rng.normal(size=6)
    elements.strain_at(strain, wave, at)
    elements.add_amplitudes(point, wave, 2.0, back)
    assert np.sum(back * strain) == pytest.approx(2.0 * point @ at, rel=1e-12)


@pytest.mark.parametrize("harmonics", [1, 3, 6])
def test_azimuths_integrate_products_of_harmonics(harmonics):
    m = harmonics + 1
    wave = elements.waves(elements.azimuths(m), harmonics)
    cosine, sine = (np.pi / m * wave[..., i].T @ wave[..., i] for i in range(2))
    np.testing.assert_allclose(cosine, np.diag([np.pi] + [np.pi / 2] * harmonics), atol=1e-12)
    np.testing.assert_allclose(sine, np.diag([0.0] + [np.pi / 2] * harmonics), atol=1e-12)


def test_volume_is_that_of_a_ring():
    corners = np.array([[1.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 2.0]])
    _, volume = elements.geometry(curved(corners), np.arange(8)[None])
    assert 2 * np.pi * volume.sum() == pytest.approx(np.pi * (9 - 1) * 2, rel=1e-13)


def test_the_other_family_is_the_first_one_turned_by_a_quarter_of_a_wave():
    """cos and sin of k theta - pi/2, whatever k; torsion is constant. Products with other slots vanish."""
    angle = elements.azimuths(11, whole=True)
    wave, k = elements.waves(angle, 3, whole=True), elements.numbers(3, whole=True)
    assert k.tolist() == [0, 1, 2, 3, 1, 2, 3]
    turned = angle[:, None] - 0.5 * np.pi / k[4:]
    np.testing.assert_allclose(wave[:, 4:, 0], np.cos(k[4:] * turned), atol=1e-14)
    np.testing.assert_allclose(wave[:, 4:, 1], np.sin(k[4:] * turned), atol=1e-14)
    for i in range(2):
        products = 2.0 * np.pi / 11 * wave[..., i].T @ wave[..., i]
        np.testing.assert_allclose(products, np.diag([2.0 * np.pi] + [np.pi] * 6), atol=1e-12)
