# SPDX-License-Identifier: MIT
"""Rigid body with the degrees of freedom (u, w, rotation) in the symmetry plane."""

from __future__ import annotations

import numpy as np

from fe_engine.conventions import ROTATION, U, W

N_DOFS = 3


def displacement_operator(position: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return R (ns, 3, 3) with displacement = R @ (u, w, rotation) at each position (ns, 3).

    Small rotations: u_x = u + rotation (z - z0), u_z = w - rotation (x - x0); z is down.
    """
    arm = np.asarray(position, dtype=float) - reference
    operator = np.zeros((len(arm), 3, N_DOFS))
    operator[:, 0, U] = 1.0
    operator[:, 2, W] = 1.0
    operator[:, 0, ROTATION] = arm[:, 2]  # u_x = rotation (z - z0), small
    operator[:, 2, ROTATION] = -arm[:, 0]
    return operator
