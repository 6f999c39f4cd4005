# SPDX-License-Identifier: MIT
"""PLASOL: frictional hardening elastoplasticity with a Drucker-Prager cone (Barnichon 1998).

With I = tr sigma, II = sqrt(s:s/2), tension positive, and e the equivalent plastic strain (Cerfontaine,
Charlier & Collin 2018, Eq. 11):

    f   = II + m(phi) I - k(phi),       m = 2 sin phi / (sqrt3 (3 - sin phi)),
    k   = 6 c cos phi / (sqrt3 (3 - sin phi)),
    phi = phi_i + (phi_f - phi_i) e / (B + e),     e = int sqrt(2/3 de_p : de_p)  (deviatoric part)
    g   = II + m(psi) I                            (plastic potential)

The cohesion enters through k, so that phi -> 0 is the von Mises cylinder without a division by tan phi.
Backward Euler has one unknown, the multiplier dl. A trial state beyond the cone returns to the apex
I = k/m, where the plastic flow takes the deviatoric strain and as much volume as it needs, whatever psi.

Apex treatment. A cohesionless point beside an opening gap has no stress and no stiffness left. It keeps
the fraction ``APEX_STIFFNESS`` of its elastic response, so that the global tangent stays regular; the yield
function is then exceeded by at most that fraction of the trial excess.
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import lean
from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import formulas
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent, moduli
from fe_engine.soil.law import PLASTIC_STRAIN, SoilLaw, rows

PARAMETERS = ("bulk", "shear", "phi_i", "phi_f", "b_phi", "m_psi", "cohesion")
BULK, SHEAR, PHI_I, PHI_F, B_PHI, M_PSI, COHESION = range(len(PARAMETERS))
HISTORY = (PLASTIC_STRAIN,)
KAPPA = 0

APEX_STIFFNESS = 1.0e-5
_SQRT3 = math.sqrt(3.0)
MAX_ITERATIONS = 60


_sine = np.vectorize(math.sin, otypes=[float])


def pack(
    young: float, poisson: float, phi_i: float, phi_f: float, b_phi: float, psi: float, cohesion: float
) -> np.ndarray:
    """Return the packed parameters; moduli and cohesion in Pa, angles in rad.

    For a law without hardening set phi_i = phi_f. The caller guarantees the ranges: 0 <= phi < pi/2,
    cohesion >= 0, b_phi > 0.
    """
    bulk, shear = moduli(young, poisson)
    return rows(bulk, shear, phi_i, phi_f, b_phi, formulas.cone_slope(_sine(psi)), cohesion)


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., 7)."""
    return p[..., BULK], p[..., SHEAR]


_slope, _cohesion = lean(formulas.cone_slope), lean(formulas.cone_cohesion)
bracketed = lean(formulas.bracketed)


@lean
def cone_slope(phi):
    """Return the slope m(phi) of the compression cone in the I-II plane."""
    return _slope(math.sin(phi))


@lean
def mobilised(p, kappa):
    """Return the friction angle (rad) after the equivalent plastic strain kappa, and its derivative."""
    phi = p[PHI_I] + (p[PHI_F] - p[PHI_I]) * kappa / (p[B_PHI] + kappa)  # Cerfontaine et al. 2018, Eq. 11
    return phi, (p[PHI_F] - p[PHI_I]) * p[B_PHI] / (p[B_PHI] + kappa) ** 2  # dphi/de = (phi_f - phi_i) B/(B + e)^2


@lean
def strength(p, kappa):
    """Return m, k and their derivatives with respect to the equivalent plastic strain."""
    phi, dphi = mobilised(p, kappa)
    s, c = math.sin(phi), math.cos(phi)
    a = 3.0 - s
    m, k = _slope(s), _cohesion(s, c, p[COHESION])
    dm = 6.0 * c / (_SQRT3 * a * a) * dphi  # dm/dphi of m = 2 sin phi/(sqrt3 (3 - sin phi))
    # dk/dphi of k = 6 c cos phi/(sqrt3 (3 - sin phi))
    dk = 6.0 * p[COHESION] * (1.0 - 3.0 * s) / (_SQRT3 * a * a) * dphi
    return m, k, dm, dk


@lean
def _excess(p, kappa_old, first, second, dl):
    """Yield function and its derivative after the plastic multiplier dl from the trial (I, II)."""
    m, k, dm, dk = strength(p, kappa_old + dl / _SQRT3)  # de = dl/sqrt3: |dg/ds| = 1/sqrt2
    i = first - 9.0 * p[BULK] * p[M_PSI] * dl  # I = I_tr - 9 K m_psi dl
    f = second - p[SHEAR] * dl + m * i - k  # II = II_tr - G dl;  f = II + m I - k (Barnichon 1998)
    slope = -p[SHEAR] - 9.0 * p[BULK] * m * p[M_PSI] + (dm * i - dk) / _SQRT3  # df/d(dl), through II, I and e
    return f, slope


@lean
def multiplier(p, kappa_old, first, second):
    """Return the root dl of the yield function on [0, II_tr/G] by Newton kept inside a shrinking bracket."""
    low, high = 0.0, second / p[SHEAR]  # at II_tr/G nothing is left of II
    scale = second + abs(first) * cone_slope(p[PHI_F]) + p[COHESION]
    dl = 0.0
    for _ in range(MAX_ITERATIONS):
        f, slope = _excess(p, kappa_old, first, second, dl)
        if f > 0.0:
            low = dl
        else:
            high = dl
        if abs(f) <= 1.0e-14 * scale or high - low <= 1.0e-16 * high:
            return dl, OK
        step = dl - f / slope if slope < 0.0 else low  # Newton, bisection where it leaves the bracket
        dl = bracketed(step, low, high)
    return dl, OK if abs(f) <= 1.0e-9 * scale else LAW_NOT_CONVERGED


@lean
def yield_function(p, stress, kappa):
    """Yield function f in Pa of a stress (6,); negative inside the elastic domain."""
    m, k, _, _ = strength(p, kappa)
    first = stress[0] + stress[1] + stress[2]
    return second_invariant(stress, first / 3.0) + m * first - k  # f = II + m I - k, Barnichon 1998


@lean
def second_invariant(stress, mean):
    """Return II = sqrt(s:s/2) of a stress (6,) with the given mean."""
    square = 0.0
    for i in range(3):
        square += 0.5 * (stress[i] - mean) ** 2 + stress[i + 3] ** 2
    return math.sqrt(square)


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress_old, history_old = old
    stress, history = new
    for i in range(6):
        stress[i] = stress_old[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    kappa_old = history_old[KAPPA]
    first = stress[0] + stress[1] + stress[2]
    second = second_invariant(stress, first / 3.0)
    m, k, _, _ = strength(p, kappa_old)
    if second + m * first - k <= 0.0:  # f of the trial state with the old strength
        history[KAPPA] = kappa_old
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    # f > 0 with all of II returned: no point of the cone is close enough
    if second <= 0.0 or _excess(p, kappa_old, first, second, second / p[SHEAR])[0] >= 0.0:
        return_to_apex(p, kappa_old, (first, second), new, tangent, with_tangent)
        return OK, REGIME_APEX
    dl, status = multiplier(p, kappa_old, first, second)
    _return_to_cone(p, kappa_old, (first, second), dl, new, tangent, with_tangent)
    return status, REGIME_CONE


@lean
def _return_to_cone(p, kappa_old, trial, dl, new, tangent, with_tangent):
    """Turn the trial stress, of invariants ``trial``, into the returned one; consistent tangent.

    The tangent is not symmetric unless psi = phi.
    """
    first, second = trial
    stress, history = new
    bulk, shear, m_psi = p[BULK], p[SHEAR], p[M_PSI]
    kappa = kappa_old + dl / _SQRT3
    ratio = 1.0 - shear * dl / second  # II/II_tr: s shrinks along s_tr
    first_new = first - 9.0 * bulk * m_psi * dl  # I = I_tr - 9 K m_psi dl
    history[KAPPA] = kappa
    if with_tangent:
        _cone_tangent(p, kappa, trial, first_new, dl, stress, tangent)
    for i in range(3):
        stress[i] = ratio * (stress[i] - first / 3.0) + first_new / 3.0
        stress[i + 3] *= ratio


@lean
def _deviator(stress, first, i):
    """Return component i of the deviator of a stress (6,) with the trace ``first``."""
    return stress[i] - first / 3.0 if i < 3 else stress[i]


@lean
def _cone_tangent(p, kappa, invariants, first_new, dl, trial, tangent):
    """Write the consistent tangent (6, 6) on the cone; trial is the elastic trial stress, of these invariants."""
    first, second = invariants
    bulk, shear, m_psi = p[BULK], p[SHEAR], p[M_PSI]
    m, _, dm, dk = strength(p, kappa)
    denominator = shear + 9.0 * bulk * m * m_psi - (dm * first_new - dk) / _SQRT3  # D = -df/d(dl)
    elastic_tangent(0.0, shear, 1.0 - shear * dl / second, tangent)  # 2 G (1 - G dl/II_tr) I_dev
    turning = 4.0 * shear * shear * dl / second  # factor of N x N: N = s_tr/(2 II_tr) turns with the strain
    for i in range(6):
        n_i = _deviator(trial, first, i) * (0.5 / second)
        flow = 2.0 * shear * n_i + (3.0 * bulk * m_psi if i < 3 else 0.0)  # C : dg/dsigma = 2 G N + 3 K m_psi 1
        for j in range(6):
            n_j = _deviator(trial, first, j) * (0.5 / second)
            # d(dl)/d(eps) = (2 G N + 3 K m 1)/D
            normal = (2.0 * shear * n_j + (3.0 * bulk * m if j < 3 else 0.0)) / denominator
            tangent[i, j] += turning * n_i * n_j - flow * normal
    for i in range(3):
        for j in range(3):
            tangent[i, j] += bulk  # K 1 x 1


@lean
def return_to_apex(p, kappa_old, trial, new, tangent, with_tangent):
    """Put the point on the apex, plus the residual elastic fraction of the trial stress, of invariants ``trial``."""
    first, second = trial
    stress, history = new
    kappa = kappa_old + second / (_SQRT3 * p[SHEAR])  # all of II_tr flows: dl = II_tr/G
    m, k, dm, dk = strength(p, kappa)
    mean = k / m / 3.0 if k > 0.0 else 0.0  # the apex: f = 0 at II = 0
    history[KAPPA] = kappa
    if with_tangent:
        # the apex moves along the hydrostatic axis as friction hardens: d(k/m)/de
        drift = (dk - k / m * dm) / m / 3.0 if k > 0.0 else 0.0
        _apex_tangent(p, drift, first, second, stress, tangent)
    for i in range(3):
        stress[i] = mean + APEX_STIFFNESS * (stress[i] - mean)
        stress[i + 3] *= APEX_STIFFNESS


@lean
def _apex_tangent(p, drift, first, second, trial, tangent):
    """Write the tangent (6, 6) at the apex; drift is d(mean stress at the apex)/d(kappa)."""
    elastic_tangent(p[BULK], p[SHEAR], APEX_STIFFNESS, tangent)
    if second <= 0.0 or drift == 0.0:
        return
    factor = (1.0 - APEX_STIFFNESS) * drift * 2.0 / _SQRT3  # de/d(eps) = 2 N/sqrt3
    for j in range(6):
        n_j = (trial[j] - (first / 3.0 if j < 3 else 0.0)) / (2.0 * second)
        for i in range(3):
            tangent[i, j] += factor * n_j


@lean
def hardened(p, strain, regime, old, new, out):
    """Write the derivative (6,) of an answer by the plastic strain before, see law.SoilLaw."""
    m, k, dm, dk = strength(p, new.history[KAPPA])
    if regime == REGIME_APEX:
        for i in range(6):
            moves = i < 3 and k > 0.0
            out[i] = (1.0 - APEX_STIFFNESS) * (dk - k / m * dm) / m / 3.0 if moves else 0.0  # d(k/m)/de
        return
    first = new.stress[0] + new.stress[1] + new.stress[2]
    second = second_invariant(new.stress, first / 3.0)
    by_strain = dm * first - dk  # df/de
    swells = 9.0 * p[BULK] * p[M_PSI]  # -dI/d(dl)
    d_dl = by_strain / (p[SHEAR] + m * swells - by_strain / _SQRT3)  # f stays 0
    for i in range(6):
        along = _deviator(new.stress, first, i) / second if second > 0.0 else 0.0
        out[i] = -d_dl * (p[SHEAR] * along + (swells / 3.0 if i < 3 else 0.0))


LAW = SoilLaw("drucker-prager", PARAMETERS, HISTORY, pack, elastic_moduli, update, hardened=hardened)
