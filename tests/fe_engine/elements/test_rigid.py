# SPDX-License-Identifier: MIT
"""Rigid body: its displacement operator is the small-rotation limit of a real motion."""

import numpy as np
import pytest

from fe_engine.conventions import U, W
from fe_engine.elements import rigid
from tests.support.models import rotation_matrix

POINTS = np.array([[1.0, 2.0, 3.0], [-2.0, 0.5, 4.0], [0.3, 0.0, -0.2], [0.7, -1.0, 1.1]])
REFERENCE = np.array([0.3, 0.0, -0.2])


@pytest.mark.parametrize("axis", range(3))
def test_rotation_columns_are_derivatives_of_finite_rotations(axis):
    h = 1.0e-5
    plus, minus = ((POINTS - REFERENCE) @ rotation_matrix(tuple(np.eye(3)[axis]), a).T for a in (h, -h))
    operator = rigid.displacement_operator(POINTS, REFERENCE)[:, :, 3 + axis]
    np.testing.assert_allclose(operator, (plus - minus) / (2.0 * h), atol=1e-9)


def test_translations_move_every_point_alike():
    operator = rigid.in_plane(POINTS, REFERENCE)
    np.testing.assert_array_equal(operator[:, :, U], [[1.0, 0.0, 0.0]] * 4)
    np.testing.assert_array_equal(operator[:, :, W], [[0.0, 0.0, 1.0]] * 4)


def test_signs_with_z_down():
    """A positive rotation moves a point below the reference forward, and a point in front of it up."""
    motion = rigid.in_plane(np.array([[0.0, 0.0, 4.0], [3.0, 0.0, 0.0]]), np.zeros(3)) @ [0.0, 0.0, 0.01]
    np.testing.assert_allclose(motion, [[0.04, 0.0, 0.0], [0.0, 0.0, -0.03]], atol=1e-16)


@pytest.mark.parametrize("force", [[2.0, 0.0, 0.0], [0.0, 0.0, -3.0], [1.0, 5.0, 2.0]])
def test_transpose_gives_resultants(force):
    """Conjugates of (u, w, rotation): f_x, f_z and the moment about +y, r x f."""
    operator = rigid.in_plane(POINTS, REFERENCE)
    for point, rows in zip(POINTS, operator, strict=True):
        moment = np.cross(point - REFERENCE, force)[1]
        np.testing.assert_allclose(rows.T @ force, [force[0], force[2], moment], atol=1e-15)
