# SPDX-License-Identifier: MIT
"""Shear strength that is mobilised along a hyperbola, and the parameters of laws of undrained clay in total stress.

A point has mobilised the share x of its strength s. With the plastic shear strain g, work-conjugate to the shear,

    g = g_s (A(x) - A(x_0)),      A = x^2/(1 - x),

so that a monotonic test has gamma = x s/G + g_s A: half of the strength at gamma_50 = s/(2 G) + g_s/2. With g_s = s/G
it is the hyperbola tau = G gamma/(1 + G gamma/s); with g_s = 0 the soil is perfectly plastic. Unloading is elastic. x_0
is what the initial state has mobilised.

Backward Euler against a stiffness h (G, or 3 G/4 at a corner of Tresca's surface) is closed: from the trial shear t

    x + r A(x) = T,     r = h g_s/s,     T = (t + h (g + g_s A(x_0)))/s,     x = 2 T/(1 + T + sqrt((1 - T)^2 + 4 r T)).
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import lean
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import PLASTIC_STRAIN, rows

PARAMETERS = ("bulk", "shear", "strength", "strain", "mobilised")
BULK, SHEAR, STRENGTH, STRAIN, MOBILISED = range(len(PARAMETERS))
# History: plastic shear strain over sqrt(3), which is sqrt(2/3 de_p : de_p) away from the corners
HISTORY = (PLASTIC_STRAIN,)
KAPPA = 0
SQRT3 = math.sqrt(3.0)


def pack(young: float, poisson: float, strength: float, strain: float = 0.0, mobilised: float = 0.0) -> np.ndarray:
    """Return the packed parameters; each may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    strength : largest shear stress in Pa, > 0; see the law for the test that measures it.
    strain : g_s, scale of the plastic shear strain; see `scale_of`. 0 is perfect plasticity.
    mobilised : share x_0 of the strength that the initial state mobilises, [0, 1).
    """
    return rows(*moduli(young, poisson), strength, strain, mobilised)


def scale_of(half_strain: float, strength: float, shear: float) -> float:
    """Return g_s for the engineering shear strain at half of the strength, which is at least strength/(2 G)."""
    return 2.0 * half_strain - strength / shear


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., 5)."""
    return p[..., BULK], p[..., SHEAR]


@lean
def radius(p, kappa):
    """Return the shear stress in Pa at which a point yields again, after the plastic strain kappa."""
    if p[STRAIN] == 0.0:
        return p[STRENGTH]
    x = p[MOBILISED]
    a = x * x / (1.0 - x) + SQRT3 * kappa / p[STRAIN]  # A(x) = A(x_0) + g/g_s, g = sqrt3 e
    # x of x^2/(1 - x) = A, without a difference
    return p[STRENGTH] * (2.0 * a / (a + math.sqrt(a * (a + 4.0))) if a > 0.0 else 0.0)


@lean
def returned(p, kappa, trial, stiffness):
    """Return the shear stress (Pa) returned from ``trial`` (Pa) with a stiffness (Pa), and its derivative."""
    strength, strain, x = p[STRENGTH], p[STRAIN], p[MOBILISED]
    if strain == 0.0:
        return strength, 0.0
    r = stiffness * strain / strength  # r = h g_s/s
    t = (trial + stiffness * (SQRT3 * kappa + strain * x * x / (1.0 - x))) / strength  # T of the module docstring
    x = 2.0 * t / (1.0 + t + math.sqrt((1.0 - t) ** 2 + 4.0 * r * t))  # root of x + r A(x) = T
    left = (1.0 - x) ** 2
    return x * strength, left / (left + r * x * (2.0 - x))  # dx/dT = 1/(1 + r A'), A' = x (2 - x)/(1 - x)^2
