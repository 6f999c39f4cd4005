# SPDX-License-Identifier: MIT
"""Water of elements in Fourier series: patches of pressure, volumes of linear motions, seepage of linear pressures."""

import numpy as np
import pytest

from fe_engine.elements import fourier
from fe_engine.elements.biot import corner_gradients, pore_matrices
from fe_engine.elements.interface import GAUSS_SHAPES
from tests.support.fourier_models import section

MESH = section(np.array([0.0, 0.7, 1.0, 2.5]), np.array([0.0, 0.4, 1.5]))
R, Z = MESH.nodes.T
VOLUME = 0.5 * np.pi * 2.5**2 * 1.5  # m3 of half the cylinder
MOBILITY, STORAGE = 2.0e-9, 3.0e-10


def whole(harmonics: int = 2):
    """Dense Q (3 n, nc), H and S M (nc, nc) of every harmonic."""
    parts = pore_matrices(MESH.nodes, MESH.quads, harmonics, MOBILITY, STORAGE)
    corner, n = MESH.corner_numbers(MESH.quads[:, :4]), len(MESH.corners)
    found = []
    for k in range(harmonics + 1):
        q, h, s = np.zeros((3 * MESH.n_nodes, n)), np.zeros((n, n)), np.zeros((n, n))
        for e, quad in enumerate(MESH.quads):
            moves = (3 * quad[:, None] + np.arange(3)).ravel()
            q[np.ix_(moves, corner[e])] += parts.coupling[k, e]
            h[np.ix_(corner[e], corner[e])] += parts.seepage[k, e]
            s[np.ix_(corner[e], corner[e])] += parts.storage[k, e]
        found.append((q, h, s))
    return found


def test_corner_functions_interpolate_linear_fields_and_their_slopes():
    at = fourier.gauss_positions(MESH.nodes, MESH.quads)
    corner = MESH.nodes[MESH.quads[:, :4]]
    np.testing.assert_allclose(np.einsum("ga,eai->egi", GAUSS_SHAPES, corner), at, rtol=1e-13)
    slope = np.einsum("egia,eaj->egij", corner_gradients(MESH.nodes, MESH.quads), corner)
    np.testing.assert_allclose(slope, np.broadcast_to(np.eye(2), slope.shape), atol=1e-12)


def test_volumes_of_linear_motions():
    (q0, _, _), (q1, _, _), _ = whole()
    swell = np.stack([0.01 * R, 0.0 * R, 0.03 * Z], axis=1).ravel()
    assert (q0.T @ swell).sum() == pytest.approx(0.05 * VOLUME, rel=1e-12)
    # a translation along x, u_r = cos(theta), u_theta = -sin(theta), changes no volume
    shift = np.stack([np.ones_like(R), -np.ones_like(R), 0.0 * R], axis=1).ravel()
    np.testing.assert_allclose(q1.T @ shift, 0.0, atol=1e-13)
    # u_x = x^2: swells by 2 x, of which the half circle has the moment int 2 x cos(theta) dV
    bulge = np.stack([0.75 * R**2, -0.25 * R**2, 0.0 * R], axis=1)  # cos^3 = (3 cos + cos 3)/4, k = 1 alone
    found = (q1.T @ bulge.ravel()).sum()
    swelling = 1.5 * R + 0.75 * R - 0.25 * R  # E_rr + E_tt of these amplitudes over R: 2 R
    assert np.allclose(swelling, 2.0 * R)
    assert found == pytest.approx(0.5 * np.pi * 2.0 * 2.5**3 / 3.0 * 1.5, rel=1e-12)


def test_an_even_pressure_pushes_on_the_boundary_alone():
    q, _, _ = whole()[0]
    force = (q @ np.ones(len(MESH.corners))).reshape(-1, 3)
    inner = (R > 0.0) & (R < 2.5) & (Z > 0.0) & (Z < 1.5)
    assert inner.any()
    np.testing.assert_allclose(force[inner], 0.0, atol=1e-13)
    assert force[R == 2.5, 0].sum() == pytest.approx(np.pi * 2.5 * 1.5, rel=1e-12)
    assert force[Z == 1.5, 2].sum() == pytest.approx(0.5 * np.pi * 2.5**2, rel=1e-12)


def test_linear_pressures_seep_evenly():
    r, z = MESH.nodes[MESH.corners].T
    (_, h0, s0), (_, h1, s1), (_, h2, _) = whole()
    assert z @ h0 @ z == pytest.approx(MOBILITY * VOLUME, rel=1e-12)  # p = z
    assert r @ h1 @ r == pytest.approx(MOBILITY * VOLUME, rel=1e-12)  # p = x
    np.testing.assert_allclose(h0 @ np.ones(len(r)), 0.0, atol=1e-20)
    assert np.ones(len(r)) @ s0 @ np.ones(len(r)) == pytest.approx(STORAGE * VOLUME, rel=1e-12)
    assert r @ s1 @ r == pytest.approx(STORAGE * 0.5 * np.pi * 2.5**4 / 4.0 * 1.5, rel=1e-3)  # 2 x 2 points
    inside = (r > 0.0) & (r < 2.5) & (z > 0.0) & (z < 1.5)
    assert np.abs((h1 @ r)[inside]).max() < 1e-12 * np.abs(h1 @ r).max()
    assert r @ h2 @ r > r @ h1 @ r
