# SPDX-License-Identifier: MIT
"""Isotropic linear elasticity."""

from __future__ import annotations

import numba as nb
import numpy as np


def moduli(young: float, poisson: float) -> tuple[float, float]:
    """Bulk modulus K and shear modulus G in the unit of Young's modulus."""
    return young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


@nb.njit(cache=True)
def add_elastic_stress(bulk, shear, strain, stress):
    """Add C:strain to stress (6,), in Pa."""
    volumetric = strain[0] + strain[1] + strain[2]
    lame = (bulk - 2.0 * shear / 3.0) * volumetric
    for i in range(3):
        stress[i] += lame + 2.0 * shear * strain[i]
        stress[i + 3] += shear * strain[i + 3]


@nb.njit(cache=True)
def elastic_tangent(bulk, shear, factor, tangent):
    """Write factor times the elastic stiffness (6, 6), in Pa."""
    lame = factor * (bulk - 2.0 * shear / 3.0)
    for i in range(6):
        for j in range(6):
            tangent[i, j] = 0.0
    for i in range(3):
        for j in range(3):
            tangent[i, j] = lame
        tangent[i, i] += 2.0 * factor * shear
        tangent[i + 3, i + 3] = factor * shear


@nb.njit(cache=True)
def subtract_elastic_tangent(bulk, shear, tangent):
    """Take the elastic stiffness off a tangent (6, 6), in Pa."""
    lame = bulk - 2.0 * shear / 3.0
    for i in range(3):
        for j in range(3):
            tangent[i, j] -= lame
        tangent[i, i] -= 2.0 * shear
        tangent[i + 3, i + 3] -= shear


def elastic_matrix(young: float, poisson: float) -> np.ndarray:
    """Elastic stiffness (6, 6) in Pa, engineering shear strains."""
    tangent = np.empty((6, 6))
    elastic_tangent(*moduli(young, poisson), 1.0, tangent)
    return tangent
