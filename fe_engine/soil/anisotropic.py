# SPDX-License-Identifier: MIT
"""Undrained clay in total stress whose strength differs in compression, direct simple shear and extension.

An ellipsoid in the space of deviatoric stress, symmetric about the vertical axis z, shifted towards compression:

    (3/4 s_zz + alpha)^2/R^2 + (((s_xx - s_yy)/2)^2 + s_xy^2 + s_yz^2 + s_zx^2)/s_D^2 = 1,
    alpha = (s_C - s_E)/2,     R^2 = ((s_C + s_E)/2)^2 - s_D^2/4,

flow associated, no plastic change of volume, perfectly plastic. s_C and s_E are the strengths (sigma_1 - sigma_3)/2 in
plane strain compression and extension with a vertical axis, s_D that of direct simple shear on a horizontal plane (and
of shear in a horizontal plane). Triaxial strengths are R + alpha and R - alpha. In the plane (s_zz - s_xx, s_zx) it is
the ellipse of Davis & Christian (1971), as NGI-ADP has it (Grimstad, Andresen & Jostad 2012); s_C = s_D = s_E is von
Mises' surface (`von_mises`).

In orthonormal coordinates y_1 .. y_5 of the deviator, y_1 = sqrt(3/2) s_zz counted from the centre, the surface is
m_1 y_1^2 + m_2 (y_2^2 + .. + y_5^2) = 1, and backward Euler is the closest point: y_i = y_i_trial/(1 + L m_i), where L
makes S(L) = sum m_i y_i^2 one. 1 - 1/sqrt(S) is almost a line in L, which Newton solves inside a bracket. With
u_i = m_i D_i y_i, D_i = 1/(1 + L m_i), the tangent d(y_i)/d(y_j trial) is D_i delta_ij - u_i u_j/sum(m_k u_k y_k).
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import njit
from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent, moduli
from fe_engine.soil.law import PLASTIC_STRAIN, SoilLaw, rows
from fe_engine.soil.plasol import bracketed

PARAMETERS = ("bulk", "shear", "compression", "direct_shear", "extension")
BULK, SHEAR, COMPRESSION, DIRECT_SHEAR, EXTENSION = range(len(PARAMETERS))
HISTORY = (PLASTIC_STRAIN,)
KAPPA = 0
MAX_ITERATIONS = 60
_TIGHT = 1.0e-14
_R2, _R6 = math.sqrt(0.5), math.sqrt(1.0 / 6.0)


def pack(young: float, poisson: float, compression: float, direct_shear: float, extension: float) -> np.ndarray:
    """Return the packed parameters; each may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    compression, direct_shear, extension : s_C, s_D and s_E in Pa, > 0, with s_C + s_E > s_D.
    """
    return rows(*moduli(young, poisson), compression, direct_shear, extension)


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., 5)."""
    return p[..., BULK], p[..., SHEAR]


@njit
def surface(p):
    """Return m_1, m_2 in 1/Pa2 and the coordinate y_1 of the centre in Pa."""
    shift = 0.5 * (p[COMPRESSION] - p[EXTENSION])
    square = 0.25 * (p[COMPRESSION] + p[EXTENSION]) ** 2 - 0.25 * p[DIRECT_SHEAR] ** 2
    # (3/4 s_zz)^2 = 3/8 y_1^2;  ((s_xx - s_yy)/2)^2 = y_2^2/2
    return 0.375 / square, 0.5 / p[DIRECT_SHEAR] ** 2, -4.0 / 3.0 * math.sqrt(1.5) * shift


@njit
def coordinates(stress, out):
    """Write the coordinates (5,) of the deviator of a stress (6,)."""
    out[0] = _R6 * (2.0 * stress[2] - stress[0] - stress[1])  # y_1 = sqrt(3/2) s_zz
    out[1] = _R2 * (stress[0] - stress[1])
    for i in range(3):
        out[2 + i] = stress[3 + i] / _R2


@njit
def add_deviator(y, stress):
    """Add the deviator of coordinates (5,) to a stress (6,)."""
    stress[0] += _R2 * y[1] - _R6 * y[0]
    stress[1] -= _R2 * y[1] + _R6 * y[0]
    stress[2] += 2.0 * _R6 * y[0]
    for i in range(3):
        stress[3 + i] += _R2 * y[2 + i]


@njit
def yield_function(p, stress, kappa):
    """Yield function, S - 1, of a stress (6,); negative inside the elastic domain."""
    first, others, centre = surface(p)
    y = np.empty(5)
    coordinates(stress, y)
    # S - 1; ellipse of Davis & Christian 1971 in the plane of y_1 and s_zx
    return first * (y[0] - centre) ** 2 + others * (y[1] ** 2 + y[2] ** 2 + y[3] ** 2 + y[4] ** 2) - 1.0


@njit
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress = new.stress
    for i in range(6):
        stress[i] = old.stress[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    new.history[KAPPA] = old.history[KAPPA]
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    y = np.empty(5)
    coordinates(stress, y)
    shrink, square, status = returned(surface(p), y)
    if square < 0.0:
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    new.history[KAPPA] += math.sqrt(square / 1.5) / (2.0 * p[SHEAR])
    if with_tangent:
        elastic_tangent(p[BULK], shrink[1] * p[SHEAR], 1.0, tangent)
        add_flow(p[SHEAR], surface(p), shrink, y, tangent)
    for i in range(6):
        stress[i] = mean if i < 3 else 0.0
    add_deviator(y, stress)
    return status, REGIME_CONE


@njit
def returned(surface, y):
    """Return coordinates y (5,) in Pa to the surface in place: D_1 and D_2, (2 G)^2 de_p:de_p, status.

    Inside the surface the second is -1, and y stays.
    """
    first, others, centre = surface
    y[0] -= centre
    beside = y[1] ** 2 + y[2] ** 2 + y[3] ** 2 + y[4] ** 2
    if first * y[0] ** 2 + others * beside <= 1.0:  # S of the trial state
        y[0] += centre
        return (1.0, 1.0), -1.0, OK
    length, status = _closest(first * y[0] ** 2, others * beside, first, others)
    shrink = 1.0 / (1.0 + length * first), 1.0 / (1.0 + length * others)  # D_1, D_2
    square = 0.0
    for i in range(5):
        factor = shrink[0] if i == 0 else shrink[1]
        square += ((1.0 - factor) * y[i]) ** 2
        y[i] *= factor
    y[0] += centre
    return shrink, square, status


@njit
def _closest(one, two, first, others):
    """Return L for which one/(1 + L m_1)^2 + two/(1 + L m_2)^2 is 1, and the status."""
    most = math.sqrt(one + two) - 1.0
    # S between S_trial/(1 + L m)^2 of the larger and the smaller m
    low, high = most / max(first, others), most / min(first, others)
    length = low
    for _ in range(MAX_ITERATIONS):
        a, b = 1.0 + length * first, 1.0 + length * others
        s = one / (a * a) + two / (b * b)  # S(L)
        slope = -2.0 * (one * first / (a * a * a) + two * others / (b * b * b))
        g = 1.0 - 1.0 / math.sqrt(s)  # almost a line in L
        if g > 0.0:
            low = length
        else:
            high = length
        if abs(g) <= _TIGHT or high - low <= _TIGHT * high:
            return length, OK
        step = length - g * 2.0 * s * math.sqrt(s) / slope  # Newton on g: dg/dL = dS/dL/(2 S^(3/2))
        length = bracketed(step, low, high)
    return length, OK if abs(g) <= 1.0e-9 else LAW_NOT_CONVERGED


@njit
def add_flow(shear, surface, shrink, y, tangent):
    """Add to the stiffness with the shear modulus D_2 G what makes it the consistent tangent (6, 6) at y (5,).

    2 G ((D_1 - D_2) b b - v v/sum(m_k u_k y_k)), b the direction of y_1 and v that of u.
    """
    first, others, centre = surface
    u, weight = np.empty(5), 0.0
    for i in range(5):
        k = 0 if i == 0 else 1
        own = y[i] - centre if i == 0 else y[i]
        m = first if i == 0 else others
        u[i] = m * shrink[k] * own
        weight += m * u[i] * own  # sum(m_k u_k y_k)
    b, v, axis = np.zeros(6), np.zeros(6), np.zeros(5)
    axis[0] = 1.0
    add_deviator(axis, b)
    add_deviator(u, v)
    along, across = 2.0 * shear * (shrink[0] - shrink[1]), 2.0 * shear / weight
    for i in range(6):
        for j in range(6):
            tangent[i, j] += along * b[i] * b[j] - across * v[i] * v[j]


LAW = SoilLaw("anisotropic", PARAMETERS, HISTORY, pack, elastic_moduli, update, isotropic=False)
