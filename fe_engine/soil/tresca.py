# SPDX-License-Identifier: MIT
"""Undrained clay in total stress: Tresca's surface, exact with its corners, and hyperbolic mobilisation.

    f = (sigma_1 - sigma_3)/2 - x s,      flow associated, no plastic change of volume

with principal stresses sigma_1 >= sigma_2 >= sigma_3 (tension positive) and the share x of the strength s that is
mobilised (see `mobilised`). s is the undrained strength su, the same in triaxial tests, plane strain and simple shear.

Return (de Souza Neto, Peric & Owen 2008, section 8.1, for which hardening here has a closed form). Principal directions
are those of the trial stress. With the trial values s_i and the plastic shear strain dg, work-conjugate to the shear,

    plane:   sigma_1 = s_1 - G dg,      sigma_3 = s_3 + G dg,      shear from (s_1 - s_3)/2 against G,

unless sigma_2 = s_2 is then outside the two. Where it is above sigma_1 (a corner, triaxial extension)

    sigma_1 = sigma_2 = (s_1 + s_2)/2 - G dg/2,  sigma_3 = s_3 + G dg,  shear from (s_1 + s_2 - 2 s_3)/4 against 3 G/4,

and alike where it is below sigma_3 (triaxial compression). The tangent is that of an isotropic function of the trial
stress: d(sigma_i)/d(s_j) in the principal directions, (sigma_i - sigma_j)/(s_i - s_j) between them.
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import lean, njit
from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import mobilised
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.mobilised import BULK, KAPPA, SHEAR, SQRT3, radius, returned

_SWEEPS = 20
_ZERO = 1.0e-32  # squared size of what is left beside the diagonal, over that of the stress


@njit
def yield_function(p, stress, kappa):
    """Yield function f in Pa of a stress (6,); negative inside the elastic domain."""
    values, directions = np.empty(3), np.empty((3, 3))
    principal(stress, values, directions)
    return 0.5 * (values[0] - values[2]) - radius(p, kappa)  # f = (sigma_1 - sigma_3)/2 - x s


@njit
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress_old, history_old = old
    stress, history = new
    for i in range(6):
        stress[i] = stress_old[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    kappa = history_old[KAPPA]
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    deviator, trial, directions = np.empty(6), np.empty(3), np.empty((3, 3))
    for i in range(3):
        deviator[i] = stress[i] - mean
        deviator[i + 3] = stress[i + 3]
    principal(deviator, trial, directions)
    if 0.5 * (trial[0] - trial[2]) <= radius(p, kappa):  # f of the trial state
        history[KAPPA] = kappa
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    values, slopes = np.empty(3), np.empty((3, 3))
    history[KAPPA] = kappa + _return(p, kappa, trial, values, slopes) / SQRT3
    compose(values, directions, stress)
    for i in range(3):
        stress[i] += mean
    if with_tangent:
        _tangent(p, trial, values, slopes, directions, tangent)
    return OK, REGIME_CONE


@njit
def _return(p, kappa, trial, values, slopes):
    """Write principal stresses (3,) and their slopes (3, 3) by the trial ones; return the plastic shear strain."""
    stiffness = p[SHEAR]
    start = 0.5 * (trial[0] - trial[2])
    shear, slope = returned(p, kappa, start, stiffness)
    plastic = (start - shear) / stiffness
    values[0], values[1], values[2] = trial[0] - stiffness * plastic, trial[1], trial[2] + stiffness * plastic  # plane
    if values[0] >= values[1] >= values[2]:  # the order holds: no corner (de Souza Neto et al. 2008, section 8.1)
        half = 0.5 * (1.0 - slope)  # d(sigma_1)/d(s_1) = 1 - half, d(sigma_1)/d(s_3) = half
        for i in range(3):
            for j in range(3):
                slopes[i, j] = 1.0 if i == j else 0.0
        slopes[0, 0] -= half
        slopes[0, 2] += half
        slopes[2, 0] += half
        slopes[2, 2] -= half
        return plastic
    # the pair of equal stresses is 0, 1 (one = 2 is alone, sign +1) or 1, 2 (one = 0, sign -1)
    one, sign = (2, 1.0) if values[1] > values[0] else (0, -1.0)
    first, second = (0, 1) if one == 2 else (1, 2)
    pair = 0.5 * (trial[first] + trial[second])
    start = 0.5 * sign * (pair - trial[one])
    # each of the pair moves by half of what the single one does
    shear, slope = returned(p, kappa, start, 0.75 * stiffness)
    plastic = (start - shear) / (0.75 * stiffness)
    values[first] = values[second] = pair - 0.5 * sign * stiffness * plastic
    values[one] = trial[one] + sign * stiffness * plastic
    share = (1.0 - slope) / 3.0  # d(pair)/d(single trial value)
    for i in (first, second):
        for j in (first, second):
            slopes[i, j] = 0.5 - 0.5 * share
        slopes[i, one] = share
        slopes[one, i] = share
    slopes[one, one] = 1.0 - 2.0 * share
    return plastic


@njit
def _tangent(p, trial, values, slopes, directions, tangent):
    """Write the consistent tangent (6, 6) from slopes (3, 3) of principal stresses by deviatoric trial ones."""
    bulk, shear = p[BULK], p[SHEAR]
    normal, between = np.empty((3, 3)), np.empty(3)
    for i in range(3):
        total = slopes[i, 0] + slopes[i, 1] + slopes[i, 2]
        for j in range(3):
            # K + 2 G d(sigma_i)/d(s_k) (delta_kj - 1/3): strain to trial deviator
            normal[i, j] = bulk + 2.0 * shear * (slopes[i, j] - total / 3.0)
    for k in range(3):
        i, j = k, (k + 1) % 3
        apart = trial[i] - trial[j]
        # isotropic function; its limit where the two trial values meet
        ratio = (values[i] - values[j]) / apart if apart != 0.0 else slopes[i, i] - slopes[i, j]
        between[k] = 2.0 * shear * ratio
    spectral_tangent(directions, normal, between, tangent)


# --- principal values and directions, and tangents of laws written in them ---


@lean
def principal(stress, values, directions):
    """Write principal values (3,), the largest first, and directions (3, 3), one a row, of a stress (6,).

    Jacobi rotations: directions are orthonormal to rounding where values meet, too.
    """
    a = ((stress[0], stress[3], stress[5]), (stress[3], stress[1], stress[4]), (stress[5], stress[4], stress[2]))
    m00, m11, m22, m01, m12, m20 = a[0][0], a[1][1], a[2][2], a[0][1], a[1][2], a[2][0]
    for i in range(3):
        for j in range(3):
            directions[i, j] = 1.0 if i == j else 0.0
    size = m00 * m00 + m11 * m11 + m22 * m22 + 2.0 * (m01 * m01 + m12 * m12 + m20 * m20)  # |a|^2, which rotations keep
    for _ in range(_SWEEPS):
        if m01 * m01 + m12 * m12 + m20 * m20 <= _ZERO * size:
            break
        c, s = _angle(m00, m11, m01)  # entry 01 becomes 0
        m00, m11 = _rotated(m00, m11, m01, c, s)
        m01, m20, m12 = 0.0, c * m20 - s * m12, s * m20 + c * m12
        _turn(directions, 0, 1, c, s)
        c, s = _angle(m11, m22, m12)  # entry 12
        m11, m22 = _rotated(m11, m22, m12, c, s)
        m12, m01, m20 = 0.0, c * m01 - s * m20, s * m01 + c * m20
        _turn(directions, 1, 2, c, s)
        c, s = _angle(m00, m22, m20)  # entry 20
        m00, m22 = _rotated(m00, m22, m20, c, s)
        m20, m01, m12 = 0.0, c * m01 - s * m12, s * m01 + c * m12
        _turn(directions, 0, 2, c, s)
    values[0], values[1], values[2] = m00, m11, m22
    _sort(values, directions, 0, 1)
    _sort(values, directions, 1, 2)
    _sort(values, directions, 0, 1)


@lean
def _angle(first, second, beside):
    """Return the cosine and sine of the rotation that removes the entry beside two diagonal ones."""
    if beside == 0.0:
        return 1.0, 0.0
    # cot of twice the angle; Jacobi takes the smaller root t of t^2 + 2 tau t = 1
    tau = (second - first) / (2.0 * beside)
    t = 1.0 / (abs(tau) + math.sqrt(1.0 + tau * tau))
    if tau < 0.0:
        t = -t
    c = 1.0 / math.sqrt(1.0 + t * t)
    return c, t * c


@lean
def _rotated(first, second, beside, c, s):
    """Return the diagonal entries after the rotation."""
    change = beside * s / c  # tan of the angle times the entry
    return first - change, second + change


@lean
def _turn(directions, i, j, c, s):
    for k in range(3):
        first, second = directions[i, k], directions[j, k]
        directions[i, k] = c * first - s * second
        directions[j, k] = s * first + c * second


@lean
def _sort(values, directions, i, j):
    if values[i] >= values[j]:
        return
    values[i], values[j] = values[j], values[i]
    for k in range(3):
        directions[i, k], directions[j, k] = directions[j, k], directions[i, k]


@lean
def compose(values, directions, stress):
    """Write the stress (6,) of principal values (3,) and directions (3, 3)."""
    for i in range(6):
        stress[i] = 0.0
    for a in range(3):
        x, y, z = directions[a, 0], directions[a, 1], directions[a, 2]
        v = values[a]
        stress[0] += v * x * x
        stress[1] += v * y * y
        stress[2] += v * z * z
        stress[3] += v * x * y
        stress[4] += v * y * z
        stress[5] += v * z * x


@lean
def spectral_tangent(directions, normal, shear, tangent):
    """Write the tangent (6, 6) of a law of principal values.

    ``normal`` (3, 3) is d(principal stress)/d(principal strain); shear (3,) is the stiffness between the strain and the
    stress of the directions (1, 2), (2, 3) and (3, 1), in tensor components.
    """
    for i in range(6):
        for j in range(6):
            tangent[i, j] = 0.0
    for a in range(3):
        for b in range(3):
            for i in range(6):
                # n_a n_a of the stress beside n_b n_b of the strain
                left = normal[a, b] * _product(directions, a, a, i)
                for j in range(6):
                    tangent[i, j] += left * _product(directions, b, b, j)
    for k in range(3):
        a, b = k, (k + 1) % 3
        for i in range(6):
            left = 2.0 * shear[k] * _product(directions, a, b, i)  # sym(n_a n_b): ab and ba
            for j in range(6):
                tangent[i, j] += left * _product(directions, a, b, j)


@lean
def _product(directions, a, b, i):
    """Return the component i of the symmetric part of n_a n_b."""
    if i < 3:
        return directions[a, i] * directions[b, i]
    j, k = i - 3, (i - 2) % 3
    return 0.5 * (directions[a, j] * directions[b, k] + directions[a, k] * directions[b, j])


LAW = SoilLaw(
    "tresca", mobilised.PARAMETERS, mobilised.HISTORY, mobilised.pack, mobilised.elastic_moduli, update,
)  # fmt: skip
