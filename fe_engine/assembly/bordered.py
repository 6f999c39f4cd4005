# SPDX-License-Identifier: MIT
"""Residual and tangent of a system with border dofs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP, REGIME_APEX, REGIME_CONE


@dataclass
class Residual:
    """Internal forces of the change from the initial state, N (border rows in their own units).

    ``free`` (n_free,) and ``border`` (nb,) are internal minus nothing: external border forces are subtracted by
    the caller. ``contact_norm`` is the 2-norm of the change of the interface's nodal forces, the scale that
    tolerances refer to. ``volume_norm`` is that of the water: the 2-norm of the volumes (m3) of elements and gaps that
    have changed and of those that flow in the step, 0 when drained; rows of the water are volumes times -scale (see
    model.Water).
    """

    free: np.ndarray
    border: np.ndarray
    contact_norm: float
    n_plastic: int
    n_apex: int
    n_slip: int
    n_open: int
    volume_norm: float = 0.0


@dataclass
class Tangent:
    """Bordered tangent, of the free equations and the border dofs (rigid body, imposed patterns).

    ::

                    n_free        nb
        n_free  |  matrix     | columns |     matrix: sparse, see pattern.Pattern
        nb      |  rows       | corner  |     the others: dense

    ``contact`` (k,) is what stations and film have added to the entries of the contact block, None where there is none.
    """

    matrix: csr_matrix
    columns: np.ndarray
    rows: np.ndarray
    corner: np.ndarray
    contact: np.ndarray | None = None


def summary(
    free: np.ndarray, border: np.ndarray, contact: float, volume: float, regime: np.ndarray, contact_state: np.ndarray
) -> Residual:
    """Return the residual with its norms, and the numbers of points and stations in each regime."""
    return Residual(
        free, border, contact,
        n_plastic=int(np.count_nonzero(regime == REGIME_CONE)),
        n_apex=int(np.count_nonzero(regime == REGIME_APEX)),
        n_slip=int(np.count_nonzero(contact_state == CONTACT_SLIP)),
        n_open=int(np.count_nonzero(contact_state == CONTACT_OPEN)),
        volume_norm=volume,
    )  # fmt: skip
