# SPDX-License-Identifier: MIT
"""PLASOL with Van Eekelen's surface (1980): the cone whose section has the strength of sand in extension, too.

Parameters, history, hardening and apex are those of `plasol`. With cos(3 theta) = -(3 sqrt3/2) III/II^3, III = det s:
theta (Lode angle) is 0 in triaxial compression and pi/3 in extension,

    f = II + rho(theta, phi) (m(phi) I - k(phi)),   rho = ((1 + b cos(3 theta))/(1 + b))^n,   n = -0.229,
    g = II + rho(theta, psi) m(psi) (I - I_g)       (plastic potential)

where m and k are the cone's, which is the compression meridian, and b(phi) gives both meridians the same friction
angle: rho at pi/3 is (3 - sin phi)/(3 + sin phi). In Barnichon's (1998) words m rho is a (1 + b sin 3beta)^n with
a = m/(1 + b)^n; his b = ((r_C/r_E)^(1/n) - 1)/((r_C/r_E)^(1/n) + 1) is tanh(atanh(sin phi/3)/n). The surface is convex
to 46.5 degrees (|b| < 0.7926), and without friction it is the von Mises cylinder.

The potential is the same surface for psi; its constant I_g is such that it passes through the stress. Its direction
across the meridian plane is then a function of theta alone,

    T = -d(ln rho(theta, psi))/d(theta),   |de_p| ~ dl sqrt(1 + T^2)/sqrt3,

which is that of f where psi = phi (associated), and nothing where psi = 0: the potential is von Mises, the flow radial,
theta stays what the trial stress has, and the multiplier is the only unknown. A fixed I_g would give sections that are
not convex while the mobilised friction is below psi.

Return. Principal directions are those of the trial stress (I_t, Q, theta_t). With w = G dl/(G dl + II) in [0, 1]
backward Euler is

    theta_t - theta = delta,   tan(delta) = w T(theta),     II = (1 - w) Q cos(delta),   G dl = w Q cos(delta),
    I = I_t - 9 K m(psi) rho(theta, psi) dl,                e = e_old + dl sqrt(1 + T^2)/sqrt3.

Because the potential is convex, the first has one root for every w; the yield function of the rest is a function of w
alone, above zero at w = 0 and below it at w = 1 where II = 0, unless the stress is beyond the apex. Both are solved by
Newton inside a bracket that shrinks: there is no strain for which they fail. A stress beyond the apex has w = 1, where
dl sqrt(1 + T^2) = Q/G, and returns as on the cone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fe_engine.compiled import lean
from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import plasol
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent
from fe_engine.soil.formulas import EXPONENT
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.lode import lode, rotated, section, shape, shape_of_slope, turn_of
from fe_engine.soil.plasol import BULK, COHESION, KAPPA, M_PSI, PHI_F, SHEAR, mobilised, return_to_apex, strength

cone_slope, second_invariant, bracketed = plasol.cone_slope, plasol.second_invariant, plasol.bracketed
_SQRT3, _SQRT6 = math.sqrt(3.0), math.sqrt(6.0)
MAX_ITERATIONS = 80
_TINY = 1.0e-30  # Pa, of a stress without a deviator


class _Point(NamedTuple):
    """Returned point: delta, II, I, yield function, and what their changes need."""

    w: float
    delta: float
    second: float
    first: float
    f: float
    turn: float  # T
    turn_slope: float  # dT/dtheta
    m_psi: float
    rho: float
    rho_theta: float
    rho_kappa: float
    m: float
    reach: float  # k - m I
    reach_kappa: float


@lean
def _section_change(p, kappa, cos3, sin3):
    """Return the radius rho of the yield surface, and its derivatives with respect to theta and to kappa."""
    phi, dphi = mobilised(p, kappa)
    b = shape(phi)
    rho = section(b, cos3)
    along = 1.0 + b * cos3
    sine = math.sin(phi) / 3.0
    # db/de: b = tanh(atanh(sin phi/3)/n), phi of Cerfontaine et al. 2018, Eq. 11
    db = (1.0 - b * b) / EXPONENT * math.cos(phi) / (3.0 * (1.0 - sine * sine)) * dphi
    d_theta = -3.0 * EXPONENT * b * sin3 / along  # d(ln rho)/d(theta)
    d_kappa = EXPONENT * (cos3 - 1.0) / (along * (1.0 + b)) * db  # d(ln rho)/db db/de
    return rho, rho * d_theta, rho * d_kappa


@lean
def _deflection(trial, b_psi, w, delta):
    """Return the root delta of tan(delta) = w T(theta_t - delta), from a first guess."""
    if b_psi == 0.0 or w == 0.0:
        return 0.0
    theta = math.atan2(trial.sin3, trial.cos3) / 3.0
    # T has one sign, and is 0 at both meridians
    low, high = (0.0, theta) if b_psi < 0.0 else (theta - math.pi / 3.0, 0.0)
    delta = min(max(delta, low), high)
    for _ in range(MAX_ITERATIONS):
        cos3, sin3 = rotated(trial, delta)
        turn, slope = turn_of(b_psi, cos3, sin3)
        excess = delta - math.atan(w * turn)  # tan(delta) = w T(theta_t - delta)
        if excess < 0.0:
            low = delta
        else:
            high = delta
        step = delta - excess / (1.0 + w * slope / (1.0 + (w * turn) ** 2))  # Newton; dT/d(delta) = -dT/d(theta)
        new = bracketed(step, low, high)
        if abs(new - delta) <= 1.0e-15 * abs(new):
            return new
        delta = new
    return delta


@lean
def _evaluate(p, b_psi, kappa_old, trial, w, guess):
    """Return the point after the share w of the way to the axis."""
    delta = _deflection(trial, b_psi, w, guess)
    cos3, sin3 = rotated(trial, delta)
    turn, turn_slope = turn_of(b_psi, cos3, sin3)
    m_psi = p[M_PSI] * section(b_psi, cos3)  # m(psi) rho(theta, psi): dilation on this meridian
    shrunk = trial.second * math.cos(delta)  # Q cos(delta)
    dl = w * shrunk / p[SHEAR]  # G dl = w Q cos(delta)
    kappa = kappa_old + dl * math.sqrt(1.0 + turn * turn) / _SQRT3  # de = dl sqrt(1 + T^2)/sqrt3
    first = trial.first - 9.0 * p[BULK] * m_psi * dl  # I = I_t - 9 K m(psi) rho(theta, psi) dl
    m, k, dm, dk = strength(p, kappa)
    rho, rho_theta, rho_kappa = _section_change(p, kappa, cos3, sin3)
    reach = k - m * first  # II that the cone allows
    second = (1.0 - w) * shrunk  # II = (1 - w) Q cos(delta)
    return _Point(
        w, delta, second, first, second - rho * reach, turn, turn_slope, m_psi, rho, rho_theta, rho_kappa, m, reach,
        dk - dm * first,
    )  # fmt: skip


@lean
def _change(p, trial, at, dw, d_second, d_theta, d_first):
    """Change (II, delta, I, f, kappa) of the point with w and with the trial stress."""
    cosine, sine = math.cos(at.delta), math.sin(at.delta)
    # tan(delta) = w T(theta_t - delta), differentiated
    d_delta = (at.turn * dw + at.w * at.turn_slope * d_theta) / (1.0 + (at.w * at.turn) ** 2 + at.w * at.turn_slope)
    angle = d_theta - d_delta  # change of theta = theta_t - delta
    shrunk, d_shrunk = trial.second * cosine, cosine * d_second - trial.second * sine * d_delta
    dl, d_dl = at.w * shrunk / p[SHEAR], (dw * shrunk + at.w * d_shrunk) / p[SHEAR]
    length = math.sqrt(1.0 + at.turn**2)
    # de = dl sqrt(1 + T^2)/sqrt3, differentiated
    d_kappa = (length * d_dl + dl * at.turn * at.turn_slope / length * angle) / _SQRT3
    # d(m_psi)/d(theta) = -T m_psi
    new_first = d_first - 9.0 * p[BULK] * at.m_psi * (d_dl - dl * at.turn * angle)
    new_second = (1.0 - at.w) * d_shrunk - dw * shrunk
    d_rho = at.rho_theta * angle + at.rho_kappa * d_kappa  # rho(theta, phi(e))
    # f = II - rho (k - m I), differentiated
    d_f = new_second - d_rho * at.reach - at.rho * (at.reach_kappa * d_kappa - at.m * new_first)
    return new_second, d_delta, new_first, d_f, d_kappa


@lean
def solve(p, b_psi, kappa_old, trial):
    """Return the point on the yield surface: Newton for w kept inside a shrinking bracket."""
    low, high = 0.0, 1.0
    scale = trial.second + abs(trial.first) * cone_slope(p[PHI_F]) + p[COHESION]
    at = _evaluate(p, b_psi, kappa_old, trial, 0.0, 0.0)
    for _ in range(MAX_ITERATIONS):
        if at.f > 0.0:
            low = at.w
        else:
            high = at.w
        if abs(at.f) <= 1.0e-14 * scale or high - low <= 1.0e-16 * high:
            return at, OK
        slope = _change(p, trial, at, 1.0, 0.0, 0.0, 0.0)[3]  # df/dw
        step = at.w - at.f / slope if slope < 0.0 else low
        w = bracketed(step, low, high)
        at = _evaluate(p, b_psi, kappa_old, trial, w, at.delta)
    return at, OK if abs(at.f) <= 1.0e-9 * scale else LAW_NOT_CONVERGED


@lean
def yield_function(p, stress, kappa):
    """Yield function f in Pa of a stress (6,); negative inside the elastic domain."""
    m, k, _, _ = strength(p, kappa)
    first = stress[0] + stress[1] + stress[2]
    second = second_invariant(stress, first / 3.0)
    rho = 1.0
    if second > 0.0:
        rho = section(shape(mobilised(p, kappa)[0]), lode(stress, first, second).cos3)
    return second + rho * (m * first - k)  # f, Van Eekelen 1980 in the form of Barnichon 1998


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress_old, history_old = old
    stress, history = new
    for i in range(6):
        stress[i] = stress_old[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    kappa_old = history_old[KAPPA]
    if yield_function(p, stress, kappa_old) <= 0.0:
        history[KAPPA] = kappa_old
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    first = stress[0] + stress[1] + stress[2]
    second = second_invariant(stress, first / 3.0)
    if second <= 0.0:
        return_to_apex(p, kappa_old, (first, second), new, tangent, with_tangent)
        return OK, REGIME_APEX
    b_psi = shape_of_slope(p[M_PSI])
    trial = lode(stress, first, second)
    if _evaluate(p, b_psi, kappa_old, trial, 1.0, 0.0).f >= 0.0:  # f > 0 with II = 0: beyond the apex
        return_to_apex(p, kappa_old, (first, second), new, tangent, with_tangent)
        return OK, REGIME_APEX
    at, status = solve(p, b_psi, kappa_old, trial)
    _return(p, kappa_old, trial, at, stress, history)
    if with_tangent:
        _tangent(p, trial, at, tangent)
    return status, REGIME_CONE


@lean
def _return(p, kappa_old, trial, at, stress, history):
    """Write the returned stress and the history."""
    dl = at.w * trial.second * math.cos(at.delta) / p[SHEAR]
    history[KAPPA] = kappa_old + dl * math.sqrt(1.0 + at.turn**2) / _SQRT3
    # |s| = sqrt2 II, at the angle delta to the trial
    radius, cosine, sine = math.sqrt(2.0) * at.second, math.cos(at.delta), math.sin(at.delta)
    for i in range(6):
        stress[i] = radius * (cosine * trial.n[i] - sine * trial.across[i]) + (at.first / 3.0 if i < 3 else 0.0)


@lean
def _tangent(p, trial, at, tangent):
    """Write the consistent tangent (6, 6) by columns: the change of the returned stress with each strain.

    The deviator is sqrt2 II (cos(delta) n - sin(delta) t), t across the meridian plane. Near the meridians t turns
    fast, but it then comes with sin(delta) = u sin(3 theta_t), where u is smooth and so is sin(3 theta) t.
    """
    bulk, shear = p[BULK], p[SHEAR]
    n, t = trial.n, trial.across
    cosine, sine = math.cos(at.delta), math.sin(at.delta)
    u = sine / trial.sin3
    cube = -trial.cos3 / _SQRT6
    slope = _change(p, trial, at, 1.0, 0.0, 0.0, 0.0)[3]
    root2 = math.sqrt(2.0)
    for j in range(6):
        # n : ds and t : ds for the change of trial deviator ds = 2 G dev(unit strain); for shear both halves of it
        along, turned = 2.0 * shear * n[j], 2.0 * shear * t[j]
        d_second, d_theta = along / root2, turned / (root2 * trial.second)
        d_first = 3.0 * bulk if j < 3 else 0.0
        dw = -_change(p, trial, at, 0.0, d_second, d_theta, d_first)[3] / slope  # f stays 0: df = 0 gives dw
        new_second, d_delta, new_first, _, _ = _change(p, trial, at, dw, d_second, d_theta, d_first)
        # unit change dn = (ds - n (n : ds))/(sqrt2 Q)
        d = (
            _unit(j, 0, shear, along, n, trial.second), _unit(j, 1, shear, along, n, trial.second),
            _unit(j, 2, shear, along, n, trial.second), _unit(j, 3, shear, along, n, trial.second),
            _unit(j, 4, shear, along, n, trial.second), _unit(j, 5, shear, along, n, trial.second),
        )  # fmt: skip
        products = _symmetric_product(n, d)
        from_n = sine * (3.0 * d_theta - d_delta)
        from_t = cosine * d_delta - 3.0 * trial.cos3 * u * d_theta
        for i in range(6):
            moved = cosine * d[i] - u * _SQRT6 * (products[i] - cube * d[i])
            turn = from_n * n[i] - from_t * t[i] + moved
            tangent[i, j] = root2 * (new_second * (cosine * n[i] - sine * t[i]) + at.second * turn)
            if i < 3:
                tangent[i, j] += new_first / 3.0


@lean
def _unit(j, i, shear, along, n, second):
    """Return the component i of the change of n with the strain j; ``along`` is n : ds."""
    change = -along * n[i]
    if i == j:
        change += 2.0 * shear if i < 3 else shear
    if i < 3 and j < 3:
        change -= 2.0 * shear / 3.0
    return change / (math.sqrt(2.0) * second)


@lean
def _symmetric_product(a, b):
    """Return a.b + b.a of two symmetric tensors (6,)."""
    return (
        2.0 * (a[0] * b[0] + a[3] * b[3] + a[5] * b[5]),
        2.0 * (a[1] * b[1] + a[3] * b[3] + a[4] * b[4]),
        2.0 * (a[2] * b[2] + a[4] * b[4] + a[5] * b[5]),
        (a[0] + a[1]) * b[3] + (b[0] + b[1]) * a[3] + a[4] * b[5] + a[5] * b[4],
        (a[1] + a[2]) * b[4] + (b[1] + b[2]) * a[4] + a[3] * b[5] + a[5] * b[3],
        (a[0] + a[2]) * b[5] + (b[0] + b[2]) * a[5] + a[3] * b[4] + a[4] * b[3],
    )


@lean
def hardened(p, strain, regime, old, new, out):
    """Write the derivative (6,) of an answer by the plastic strain before, see law.SoilLaw."""
    if regime == REGIME_APEX:
        plasol.hardened(p, strain, regime, old, new, out)
        return
    for i in range(6):
        out[i] = old.stress[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, out)
    first, end = out[0] + out[1] + out[2], new.stress[0] + new.stress[1] + new.stress[2]
    trial = lode(out, first, second_invariant(out, first / 3.0))
    second = second_invariant(new.stress, end / 3.0)
    there = lode(new.stress, end, max(second, _TINY))
    b_psi = shape_of_slope(p[M_PSI])
    turn = turn_of(b_psi, there.cos3, there.sin3)[0]
    way = p[SHEAR] * _SQRT3 * (new.history[KAPPA] - old.history[KAPPA]) / math.sqrt(1.0 + turn * turn)  # G dl
    w = way / (way + second)
    at = _evaluate(p, b_psi, old.history[KAPPA], trial, w, math.atan(w * turn))
    d_f = -at.rho_kappa * at.reach - at.rho * at.reach_kappa  # by the plastic strain before, at the same w
    dw = -d_f / _change(p, trial, at, 1.0, 0.0, 0.0, 0.0)[3]  # f stays 0
    new_second, d_delta, new_first, _, _ = _change(p, trial, at, dw, 0.0, 0.0, 0.0)
    cosine, sine = math.cos(at.delta), math.sin(at.delta)
    along, across = new_second * cosine - at.second * sine * d_delta, new_second * sine + at.second * cosine * d_delta
    for i in range(6):
        out[i] = math.sqrt(2.0) * (along * trial.n[i] - across * trial.across[i]) + (new_first / 3.0 if i < 3 else 0.0)


LAW = SoilLaw(
    "van-eekelen", plasol.PARAMETERS, plasol.HISTORY, plasol.pack, plasol.elastic_moduli, update, hardened=hardened
)
