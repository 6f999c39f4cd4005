# SPDX-License-Identifier: MIT
"""Rigid body with six degrees of freedom, of which a body that moves in the plane of x and z has three."""

from __future__ import annotations

import numpy as np

N_DOFS = 6
# Of u_x, u_y, u_z and the rotations about x, y, z those of a motion in the plane of x and z: u, w, rotation
PLANE, SPACE = (0, 2, 4), tuple(range(N_DOFS))


def displacement_operator(position: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return R (ns, 3, 6) with displacement = R @ q at each position (ns, 3), q = (u_0, rotations).

    Small rotations, right-handed: u = u_0 + rotations x (position - reference); z is down.
    """
    arm = np.asarray(position, dtype=float) - reference
    operator = np.zeros((len(arm), 3, N_DOFS))
    x, y, z = arm.T
    operator[:, range(3), range(3)] = 1.0
    operator[:, 1, 3], operator[:, 2, 3] = -z, y
    operator[:, 0, 4], operator[:, 2, 4] = z, -x
    operator[:, 0, 5], operator[:, 1, 5] = -y, x
    return operator


def in_plane(position: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return the operator (ns, 3, 3) of a motion (u, w, rotation) in the plane of x and z."""
    return np.ascontiguousarray(displacement_operator(position, reference)[:, :, PLANE])
