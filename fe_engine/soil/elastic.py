# SPDX-License-Identifier: MIT
"""Isotropic linear elasticity."""

from __future__ import annotations

from typing import Any

import numpy as np

from fe_engine.compiled import lean
from fe_engine.conventions import OK, REGIME_ELASTIC
from fe_engine.soil.law import SoilLaw, rows

PARAMETERS = ("bulk", "shear")
BULK, SHEAR = range(len(PARAMETERS))


def moduli(young: Any, poisson: Any) -> tuple[Any, Any]:
    """Return the bulk modulus K and shear modulus G in the unit of Young's modulus."""
    return young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


@lean
def add_elastic_stress(bulk, shear, strain, stress):
    """Add C:strain to stress (6,), in Pa."""
    volumetric = strain[0] + strain[1] + strain[2]
    lame = (bulk - 2.0 * shear / 3.0) * volumetric  # Hooke: s = lambda tr(eps) 1 + 2 G eps, lambda = K - 2 G/3
    for i in range(3):
        stress[i] += lame + 2.0 * shear * strain[i]
        stress[i + 3] += shear * strain[i + 3]  # engineering shear: tau = G gamma


@lean
def elastic_tangent(bulk, shear, factor, tangent):
    """Write factor times the elastic stiffness (6, 6), in Pa."""
    lame = factor * (bulk - 2.0 * shear / 3.0)  # C = lambda 1 x 1 + 2 G I
    for i in range(6):
        for j in range(6):
            tangent[i, j] = 0.0
    for i in range(3):
        for j in range(3):
            tangent[i, j] = lame
        tangent[i, i] += 2.0 * factor * shear
        tangent[i + 3, i + 3] = factor * shear


@lean
def subtract_elastic_tangent(bulk, shear, tangent):
    """Take the elastic stiffness off a tangent (6, 6), in Pa."""
    lame = bulk - 2.0 * shear / 3.0
    for i in range(3):
        for j in range(3):
            tangent[i, j] -= lame
        tangent[i, i] -= 2.0 * shear
        tangent[i + 3, i + 3] -= shear


@lean
def stored_density(bulk, shear, stress):
    """Return the elastic energy density s:C^-1:s/2 = I^2/(18 K) + II^2/(2 G) of a stress (6,), in J/m3."""
    first = stress[0] + stress[1] + stress[2]
    square = 0.0
    for i in range(3):
        # II^2 = s:s/2, in which each shear stands twice
        square += 0.5 * (stress[i] - first / 3.0) ** 2 + stress[i + 3] ** 2
    return first * first / (18.0 * bulk) + square / (2.0 * shear)


def pack(young: float, poisson: float) -> np.ndarray:
    """Return the packed parameters from Young's modulus (Pa) and Poisson's ratio."""
    return rows(*moduli(young, poisson))


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., 2)."""
    return p[..., BULK], p[..., SHEAR]


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Add the elastic stress of a strain increment (6,), see law.SoilLaw; return (OK, REGIME_ELASTIC)."""
    stress_old, stress = old.stress, new.stress
    for i in range(6):
        stress[i] = stress_old[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    if with_tangent:
        elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
    return OK, REGIME_ELASTIC


def elastic_matrix(young: float, poisson: float) -> np.ndarray:
    """Return the elastic stiffness (6, 6) in Pa, engineering shear strains."""
    tangent = np.empty((6, 6))
    elastic_tangent(*moduli(young, poisson), 1.0, tangent)
    return tangent


LAW = SoilLaw("elastic", PARAMETERS, (), pack, elastic_moduli, update, symmetric=True, yields=False)
