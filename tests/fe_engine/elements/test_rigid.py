# SPDX-License-Identifier: MIT
"""Rigid body: its displacement operator is the small-rotation limit of a real motion."""

from __future__ import annotations

import numpy as np
import pytest

from fe_engine.conventions import ROTATION, U, W
from fe_engine.elements import rigid
from tests.support.models import rotation_matrix

POINTS = np.array([[1.0, 2.0, 3.0], [-2.0, 0.5, 4.0], [0.3, 0.0, -0.2], [0.7, -1.0, 1.1]])
REFERENCE = np.array([0.3, 0.0, -0.2])


def test_rotation_column_is_the_derivative_of_a_finite_rotation():
    h = 1.0e-5
    plus, minus = ((POINTS - REFERENCE) @ rotation_matrix((0.0, 1.0, 0.0), a).T for a in (h, -h))
    operator = rigid.displacement_operator(POINTS, REFERENCE)
    np.testing.assert_allclose(operator[:, :, ROTATION], (plus - minus) / (2.0 * h), atol=1e-9)


def test_translations_move_every_point_alike():
    operator = rigid.displacement_operator(POINTS, REFERENCE)
    np.testing.assert_array_equal(operator[:, :, U], [[1.0, 0.0, 0.0]] * 4)
    np.testing.assert_array_equal(operator[:, :, W], [[0.0, 0.0, 1.0]] * 4)


def test_signs_with_z_down():
    """A positive rotation moves a point below the reference forward, and a point in front of it up."""
    motion = rigid.displacement_operator(np.array([[0.0, 0.0, 4.0], [3.0, 0.0, 0.0]]), np.zeros(3)) @ [0.0, 0.0, 0.01]
    np.testing.assert_allclose(motion, [[0.04, 0.0, 0.0], [0.0, 0.0, -0.03]], atol=1e-16)


@pytest.mark.parametrize("force", [[2.0, 0.0, 0.0], [0.0, 0.0, -3.0], [1.0, 5.0, 2.0]])
def test_transpose_gives_resultants(force):
    """Conjugates of (u, w, rotation): f_x, f_z and the moment about +y, r x f."""
    operator = rigid.displacement_operator(POINTS, REFERENCE)
    for point, rows in zip(POINTS, operator, strict=True):
        moment = np.cross(point - REFERENCE, force)[1]
        np.testing.assert_allclose(rows.T @ force, [force[0], force[2], moment], atol=1e-15)
