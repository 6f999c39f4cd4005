# SPDX-License-Identifier: MIT
"""Horizontal forces and moments in the vertical plane of the force, and the moment across it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUNDING = 1e-6  # share of a moment up to which its part across the plane of H is rounding of angles


@dataclass(frozen=True)
class InPlane:
    """Loads (n,) in the vertical plane of their force, else of their moment.

    Attributes
    ----------
    H, M : force [N] and moment [N m] in the plane; M = H h of a force at height h.
    across : moment about the direction of the plane [N m], right-handed: it bends across the plane.
    direction : of the plane [rad], from x towards y.
    """

    H: Array
    M: Array
    across: Array
    direction: Array


def in_plane(force: Array, bending: Array, least: Array | None = None, plane: Array | None = None) -> InPlane:
    """Return loads in their planes.

    Parameters
    ----------
    force : (n, 2) H_x, H_y [N].
    bending : (n, 2) moments in the planes of x and y, M_y and -M_x [N m].
    least : (n, 2) force [N] and moment [N m] that are rounding; by default of forces at heights up to 100 m.
    plane : (n, 2) unit vectors of the planes; by default along the force, else along the bending.
    """
    size, turn = np.hypot(*force.T), np.hypot(*bending.T)
    least = np.stack([0.01 * ROUNDING * turn, ROUNDING * turn], axis=1) if least is None else least
    if plane is None:
        lead = np.where(
            (size > least[:, 0])[:, None], force, np.where((turn > least[:, 1])[:, None], bending, [1.0, 0])
        )
        plane = lead / np.hypot(*lead.T)[:, None]
    across = plane[:, 1] * bending[:, 0] - plane[:, 0] * bending[:, 1]
    across = np.where(np.abs(across) <= least[:, 1], 0.0, across)
    H, M = ((plane * each).sum(axis=1) for each in (force, bending))
    return InPlane(H, M, across, np.arctan2(plane[:, 1], plane[:, 0]))
