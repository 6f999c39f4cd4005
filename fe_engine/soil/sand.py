# SPDX-License-Identifier: MIT
"""Sand by its relative density: peak strength and dilation of Bolton (1986), fading to the critical state.

With I = tr sigma, II = sqrt(s:s/2), tension positive, p' = -I/3, and e the equivalent plastic strain of `plasol`
(e = dl/sqrt3 summed up, from e_0, that of the initial state):

    f    = II + rho(theta, phi) m(phi) I                            (Van Eekelen's section, `van_eekelen`; no cohesion)
    phi  : sin phi = x sin phi_t,     phi_t = phi_c + 3 deg J,      x = (1 - exp(-e/B))^(1/n)
    J    = I_R / (1 + (e/F)^4),       I_R = D_r (Q - ln(p'/1 kPa)) - 1, between 0 and 4        (Bolton 1986)
    D    = 0.3 J/(1 + 0.1 J) x^n - C (1 - x^n)
    de_p = dl (s/(2 II) + m_psi 1),   m_psi = D/(3 sqrt3)

D is the plastic dilation over the plastic shear strain e; in triaxial compression 0.3 J is that over the axial strain.
x is the mobilised share of the strength, which grows like e^(1/n): the first strains are elastic. C contracts the sand
before it dilates. J fades over the plastic strain F, after which the sand shears at phi_c and constant volume.
The bounds of I_R are rounded (`formulas.dilatancy_index`), and p' is that before the increment.

The flow is radial in the deviatoric plane: theta is that of the trial stress, and backward Euler has one unknown dl,

    II = II_tr - G dl,     I = I_tr - 9 K m_psi(e) dl,     f(II, I, e) = 0,

which is decreasing while softening and contraction take less than G. Its root is found inside a bracket that shrinks.
A trial stress beyond the apex I = 0 returns there and keeps a small share of its elastic response, as in `plasol`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fe_engine.compiled import lean
from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import formulas
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent, moduli
from fe_engine.soil.law import SoilLaw, rows
from fe_engine.soil.lode import lode, section, shape_of_slope
from fe_engine.soil.plasol import APEX_STIFFNESS, HISTORY, KAPPA, MAX_ITERATIONS, bracketed, second_invariant

PARAMETERS = (
    "bulk", "shear", "phi_c", "density", "crushing", "exponent", "scale", "fade", "contraction", "kappa_0",
)  # fmt: skip
BULK, SHEAR, PHI_C, DENSITY, CRUSHING, EXPONENT, SCALE, FADE, CONTRACTION, KAPPA_0 = range(len(PARAMETERS))
_LEAST = 1.0e-16  # of x^n: below that share of the strength the sand is elastic
_TINY = 1.0e-30  # Pa, of a stress without a deviator
_SQRT3 = math.sqrt(3.0)


def pack(
    young: Any, poisson: Any, phi_c: Any, density: Any, crushing: Any, exponent: Any, scale: Any, fade: Any,
    contraction: Any, kappa_0: Any,
) -> np.ndarray:  # fmt: skip
    """Return the packed parameters; each may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    phi_c : critical friction angle in triaxial compression, rad.
    density, crushing : relative density D_r and Q of Bolton's index, 10 for quartz.
    exponent, scale : n and B of the mobilised share of strength.
    fade, contraction : F and C.
    kappa_0 : e_0, equivalent plastic strain of the initial state.
    """
    return rows(*moduli(young, poisson), phi_c, density, crushing, exponent, scale, fade, contraction, kappa_0)


_slope, dilatancy_index = lean(formulas.cone_slope), lean(formulas.dilatancy_index)


@lean
def mobilised(p, most, kappa):
    """Return sin(phi), its derivative by e, m_psi and its derivative; ``most`` is I_R, ``kappa`` e."""
    power = -math.expm1(-kappa / p[SCALE])  # x^n
    decay = 1.0 - power
    share = max(power, _LEAST) ** (1.0 / p[EXPONENT])
    d_share = share * decay / (p[EXPONENT] * power * p[SCALE]) if power > _LEAST else 0.0
    ratio = (kappa / p[FADE]) ** 2
    index = most / (1.0 + ratio * ratio)  # J
    d_index = -4.0 * index * ratio * kappa / ((1.0 + ratio * ratio) * p[FADE] ** 2)
    phi = p[PHI_C] + formulas.PER_INDEX * index  # phi_t, Bolton 1986
    sine, d_sine = share * math.sin(phi), d_share * math.sin(phi) + share * math.cos(phi) * formulas.PER_INDEX * d_index
    bend = 1.0 + 0.1 * index
    dilation = 0.3 * index / bend  # over the shear strain, where 0.3 J is that over the axial strain
    d_dilation = 0.3 / (bend * bend) * d_index
    d_power = decay / p[SCALE]
    flow = (dilation + p[CONTRACTION]) * power - p[CONTRACTION]  # D
    d_flow = d_dilation * power + (dilation + p[CONTRACTION]) * d_power
    return sine, d_sine, flow / (3.0 * _SQRT3), d_flow / (3.0 * _SQRT3)


@lean
def _surface(sine, cos3):
    """Return a = rho m of a mobilised friction angle, da/d(sin phi), and b."""
    m = _slope(sine)
    d_m = 6.0 / (_SQRT3 * (3.0 - sine) ** 2)  # dm/d(sin phi)
    b = shape_of_slope(m)
    rho = section(b, cos3)
    third = sine / 3.0
    d_b = (1.0 - b * b) / formulas.EXPONENT / (3.0 * (1.0 - third * third))  # b = tanh(atanh(sin phi/3)/n)
    d_rho = rho * formulas.EXPONENT * (cos3 - 1.0) / ((1.0 + b * cos3) * (1.0 + b)) * d_b
    return rho * m, d_rho * m + rho * d_m, b


@lean
def _excess(p, most, kappa_old, trial, dl):
    """Return f and its derivative after the plastic multiplier dl; ``trial`` is (I, II, cos 3 theta)."""
    kappa = kappa_old + dl / _SQRT3  # de = dl/sqrt3: |s/(2 II)| = 1/sqrt2
    sine, d_sine, m_psi, d_psi = mobilised(p, most, kappa)
    a, d_a, _ = _surface(sine, trial[2])
    first = trial[0] - 9.0 * p[BULK] * m_psi * dl  # I = I_tr - 9 K m_psi dl
    d_first = -9.0 * p[BULK] * (m_psi + d_psi * dl / _SQRT3)
    f = trial[1] - p[SHEAR] * dl + a * first  # II = II_tr - G dl
    return f, -p[SHEAR] + a * d_first + d_a * d_sine / _SQRT3 * first


@lean
def _multiplier(p, most, kappa_old, trial, f, slope):
    """Return the root dl of f on [0, II_tr/G] by Newton kept inside a shrinking bracket; f and its slope are at 0."""
    low, high = 0.0, trial[1] / p[SHEAR]
    scale = trial[1] + abs(trial[0])
    dl = 0.0
    for _ in range(MAX_ITERATIONS):
        if f > 0.0:
            low = dl
        else:
            high = dl
        if abs(f) <= 1.0e-14 * scale or high - low <= 1.0e-16 * high:
            return dl, OK
        step = dl - f / slope if slope < 0.0 else low  # Newton, bisection where it leaves the bracket
        dl = bracketed(step, low, high)
        f, slope = _excess(p, most, kappa_old, trial, dl)
    return dl, OK if abs(f) <= 1.0e-9 * scale else LAW_NOT_CONVERGED


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress_old, history_old = old
    stress, history = new
    for i in range(6):
        stress[i] = stress_old[i]
    most = dilatancy_index(p[DENSITY], p[CRUSHING], -(stress[0] + stress[1] + stress[2]) / 3.0)
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    kappa_old = history_old[KAPPA] + p[KAPPA_0]
    first = stress[0] + stress[1] + stress[2]
    second = second_invariant(stress, first / 3.0)
    state = lode(stress, first, max(second, _TINY))
    trial = (first, second, state.cos3)
    f, slope = _excess(p, most, kappa_old, trial, 0.0)
    if first <= 0.0 and f <= 0.0:
        history[KAPPA] = history_old[KAPPA]
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    # I > 0 with all of II returned, dl = II_tr/G: no point of the surface is close enough
    whole = second / p[SHEAR]
    if first - 9.0 * p[BULK] * mobilised(p, most, kappa_old + whole / _SQRT3)[2] * whole >= 0.0:
        history[KAPPA] = history_old[KAPPA] + whole / _SQRT3
        for i in range(6):
            stress[i] *= APEX_STIFFNESS
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], APEX_STIFFNESS, tangent)
        return OK, REGIME_APEX
    dl, status = _multiplier(p, most, kappa_old, trial, f, slope)
    history[KAPPA] = history_old[KAPPA] + dl / _SQRT3
    _return(p, (most, kappa_old), state, dl, stress, tangent, with_tangent)
    return status, REGIME_CONE


@lean
def _return(p, start, trial, dl, stress, tangent, with_tangent):
    """Turn the trial stress into the returned one; write the consistent tangent (6, 6).

    ``start`` is I_R and e before. f stays 0: d(dl) = (dII_tr + a dI_tr + I da/dtheta dtheta)/D with D = -df/d(dl).
    """
    bulk, shear, second = p[BULK], p[SHEAR], trial.second
    kappa = start[1] + dl / _SQRT3
    sine, _, m_psi, d_psi = mobilised(p, start[0], kappa)
    a, _, b = _surface(sine, trial.cos3)
    first = trial.first - 9.0 * bulk * m_psi * dl
    ratio = 1.0 - shear * dl / second  # s shrinks along s_tr
    if with_tangent:
        slope = -_excess(p, start[0], start[1], (trial.first, second, trial.cos3), dl)[1]
        a_theta = -3.0 * formulas.EXPONENT * b * trial.sin3 / (1.0 + b * trial.cos3) * a  # d(ln rho)/dtheta
        squeeze = 9.0 * bulk * (m_psi + d_psi * dl / _SQRT3)
        root2 = math.sqrt(2.0)
        elastic_tangent(0.0, shear, ratio, tangent)
        for j in range(6):
            d_second = root2 * shear * trial.n[j]  # dII_tr = s:ds/(2 II); n = s/(sqrt2 II)
            d_theta = root2 * shear * trial.across[j] / second
            d_first = 3.0 * bulk if j < 3 else 0.0
            d_dl = (d_second + a * d_first + first * a_theta * d_theta) / slope
            along = root2 * ((1.0 - ratio) * d_second - shear * d_dl)  # s_tr d(ratio)
            for i in range(6):
                tangent[i, j] += trial.n[i] * along
                if i < 3:
                    tangent[i, j] += (d_first - squeeze * d_dl) / 3.0
    for i in range(6):
        stress[i] = ratio * root_of_two(trial, i) + (first / 3.0 if i < 3 else 0.0)


@lean
def root_of_two(trial, i):
    """Return component i of the trial deviator."""
    return math.sqrt(2.0) * trial.second * trial.n[i]


@lean
def hardened(p, strain, regime, old, new, out):
    """Write the derivative (6,) of an answer by the plastic strain before, see law.SoilLaw."""
    for i in range(6):
        out[i] = 0.0
    if regime == REGIME_APEX:  # a share of the trial stress
        return
    dl = _SQRT3 * (new.history[KAPPA] - old.history[KAPPA])
    first = new.stress[0] + new.stress[1] + new.stress[2]
    at = lode(new.stress, first, max(second_invariant(new.stress, first / 3.0), _TINY))
    most = dilatancy_index(p[DENSITY], p[CRUSHING], -(old.stress[0] + old.stress[1] + old.stress[2]) / 3.0)
    sine, d_sine, m_psi, d_psi = mobilised(p, most, new.history[KAPPA] + p[KAPPA_0])
    a, d_a, _ = _surface(sine, at.cos3)
    swells, more = 9.0 * p[BULK] * (m_psi + d_psi * dl / _SQRT3), 9.0 * p[BULK] * d_psi * dl  # -dI/d(dl), -dI/de_old
    strength = d_a * d_sine * first
    d_dl = (strength - a * more) / (p[SHEAR] + a * swells - strength / _SQRT3)  # f stays 0
    for i in range(6):
        out[i] = -math.sqrt(2.0) * p[SHEAR] * d_dl * at.n[i] - ((swells * d_dl + more) / 3.0 if i < 3 else 0.0)


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., n)."""
    return p[..., BULK], p[..., SHEAR]


LAW = SoilLaw("sand", PARAMETERS, HISTORY, pack, elastic_moduli, update, hardened=hardened)
