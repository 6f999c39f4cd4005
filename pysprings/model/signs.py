# SPDX-License-Identifier: MIT
"""Signs of the field in a model of the engine.

The engine has z down and y to the right of x, seen from above: its rotation about +y is positive where the tip of a
skirt moves towards +x. Everywhere else in pysprings rotation and M are positive where the caisson leans in the
direction of a positive H: about y to the left of x, with z up. Here the sign turns, and nowhere else: the third border
dof of a model is the rotation of the field, so its force is the M of the field.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fe_engine.conventions import ROTATION
from fe_engine.elements import rigid

Array = NDArray[np.float64]


def body_operator(position: Array) -> Array:
    """Return R (n, 3, 3) with displacement = R @ (u, w, rotation) at positions (n, 3) [m], about the lid centre.

    u_x = u - rotation z and u_z = w + rotation x, z down.
    """
    operator = rigid.displacement_operator(position, np.zeros(3))
    operator[:, :, ROTATION] *= -1.0
    return operator


def moments(position: Array, force: Array) -> Array:
    """Return the moments (n,) [N m] about the lid centre of forces (n, 3) [N] at positions (n, 3) [m]."""
    return np.asarray(force[:, 2] * position[:, 0] - force[:, 0] * position[:, 2])
