# SPDX-License-Identifier: MIT
"""Sand whose stiffness follows the stress, and degrades with shear strain, under any frictional surface.

Hypoelastic: both moduli of the law below are multiplied by c = c_p c_g, at constant Poisson's ratio (p compression
positive, p_0 the initial mean effective stress of the point, at which the law has its moduli K_0 and G_0):

    c_p = (p/p_0)^n                              (Hardin & Black 1968), held for p below FLOOR p_0 and above CEILING p_0
    c_g = d/dg [g/(1 + a g)],  a = 0.385/g_07    (Santos & Correia 2001), not below a given share

g = sqrt(2 e:e) is the shear strain (the engineering one in simple shear, 2/sqrt(3) (eps_1 - eps_3) in a triaxial test)
of the deviatoric strain e since it last turned back: after an increment with e:de < 0, e is that increment's, so that
the next one is stiff again. The increment that turns goes back along the curve: its answer is smooth in its strain.

Both are integrated over the increment, so that monotonic paths do not depend on its size:

    c_g = 1/((1 + a g_old)(1 + a g_new)),   c_p = (p_new - p_old)/(K_0 c_g de_v),   int dp/c_p(p) = K_0 c_g de_v.

p_new is that of the elastic trial. The law returns this trial with moduli c K_0 and c G_0. A change of p by plastic
flow alone acts in the next increment. With h the derivative of the law's answer by c the tangent is T, that of the law,
plus h dc/de; it is not symmetric. The plastic strain e, which grows by dl/c at the same trial stress, is all that makes
the answer depend on c by itself, so

    h = (T : de - (e_new - e_old) dsigma/de_old)/c,     T : de/c = (K_0, G_0) : de where elastic.
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import njit
from fe_engine.conventions import OK, REGIME_ELASTIC, REGIME_STIFFNESS
from fe_engine.soil import plasol
from fe_engine.soil.elastic import add_elastic_stress, subtract_elastic_tangent
from fe_engine.soil.frictional import SURFACES
from fe_engine.soil.law import SoilLaw

FLOOR, CEILING = 0.01, 100.0  # of the initial mean stress
_SMALL = 1.0e-6  # relative change of the mean stress below which its Taylor series is exact to rounding

_WIDTH = max(len(law.parameters) for law in SURFACES)
PARAMETERS = (
    "bulk", "shear", *(f"surface_{i}" for i in range(2, _WIDTH)),
    "surface", "pressure", "exponent", "degradation", "least",
)  # fmt: skip
BULK, SHEAR = 0, 1
SURFACE, PRESSURE, EXPONENT, DEGRADATION, LEAST = range(_WIDTH, _WIDTH + 5)
FIRST = 1  # history variable behind those of the surface
# parameters  | K_0 G_0 | others of the surface, 0 .. | code of the surface | p_0 | n | a | least c_g |
# history     | e of the surface | xx yy zz of the strain since the last turn | its xy yz zx, engineering |
HISTORY = (*plasol.HISTORY, "e_xx", "e_yy", "e_zz", "g_xy", "g_yz", "g_zx")
GAMMA_07 = 0.385  # a g_07: the secant modulus there is 72.2 % of the initial one

_returned = SURFACES.chain("update", "p, strain, old, new, tangent, with_tangent", __name__)
_hardened = SURFACES.chain("hardened", "p, strain, regime, old, new, out", __name__)


def pack(
    law: SoilLaw, rows: np.ndarray, pressure: np.ndarray | float, exponent: float, strain: float | None, least: float
) -> np.ndarray:
    """Return the packed parameters.

    Parameters
    ----------
    law, rows : the surface, and its packed parameters (..., n), whose moduli hold at ``pressure``.
    pressure : initial mean effective stress (...,) in Pa, > 0.
    exponent : n, [0, 1); 0 does not follow the stress.
    strain : g_07; None does not degrade.
    least : share of the stiffness that is left at large strains, (0, 1].
    """
    shape = np.broadcast_shapes(rows.shape[:-1], np.shape(pressure))
    packed = np.zeros((*shape, len(PARAMETERS)))
    packed[..., : rows.shape[-1]] = rows
    packed[..., SURFACE], packed[..., PRESSURE] = SURFACES.code(law), pressure
    packed[..., EXPONENT], packed[..., LEAST] = exponent, least
    packed[..., DEGRADATION] = 0.0 if strain is None else GAMMA_07 / strain
    return packed


def initial_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return K_0 and G_0 in Pa of packed parameters (..., n)."""
    return p[..., BULK], p[..., SHEAR]


@njit
def power(r, n):
    """Return c_p and its derivative at a mean stress r p_0."""
    inside = FLOOR < r < CEILING
    value = min(max(r, FLOOR), CEILING) ** n  # Hardin & Black 1968
    return value, n * value / r if inside else 0.0


@njit
def _along(r, n):
    """Return the integral of dr/c_p from FLOOR to r."""
    if r < FLOOR:
        return (r - FLOOR) / FLOOR**n
    inner = (min(r, CEILING) ** (1.0 - n) - FLOOR ** (1.0 - n)) / (1.0 - n)  # int r^-n dr between the limits
    return inner + max(r - CEILING, 0.0) / CEILING**n


@njit
def _at(u, n):
    """Return r from that integral."""
    if u < 0.0:
        return FLOOR + u * FLOOR**n
    most = (CEILING ** (1.0 - n) - FLOOR ** (1.0 - n)) / (1.0 - n)  # the integral at CEILING
    if u > most:
        return CEILING + (u - most) * CEILING**n
    return (FLOOR ** (1.0 - n) + (1.0 - n) * u) ** (1.0 / (1.0 - n))


@njit
def by_stress(p, pressure, squeeze):
    """Return c_p over an increment, and its derivative by ``squeeze``.

    ``pressure`` (Pa) is the mean stress before, ``squeeze`` c_g times the volumetric strain, both compression positive.
    """
    n, r, stiffness = p[EXPONENT], pressure / p[PRESSURE], p[BULK] / p[PRESSURE]
    value, slope = power(r, n)
    if n == 0.0:
        return 1.0, 0.0
    if abs(stiffness * squeeze * value) <= _SMALL * max(r, FLOOR):
        half = 0.5 * slope * value * stiffness  # the secant's first derivative is half of the tangent's
        return value + half * squeeze, half
    end = _at(_along(r, n) + stiffness * squeeze, n)  # int dp/c_p = K_0 c_g de_v
    secant = (end - r) / (stiffness * squeeze)  # c_p = (p_new - p_old)/(K_0 c_g de_v)
    return secant, (power(end, n)[0] - secant) / squeeze  # d(end)/d(squeeze) = c_p(end) K_0/p_0


@njit
def _length(e):
    """Return g of a deviatoric strain (6,)."""
    return math.sqrt(2.0 * (e[0] ** 2 + e[1] ** 2 + e[2] ** 2) + e[3] ** 2 + e[4] ** 2 + e[5] ** 2)


@njit
def by_strain(p, strain, old, new, slope):
    """Return c_g over an increment (6,); write the strain since the last turn (6,), and dc_g/d(strain) (6,)."""
    mean, along = (strain[0] + strain[1] + strain[2]) / 3.0, 0.0
    for i in range(6):
        change = strain[i] - (mean if i < 3 else 0.0)
        along += (2.0 if i < 3 else 1.0) * old[i] * change  # 2 e:de, engineering shear
        new[i] = old[i] + change
    a, begun, end = p[DEGRADATION], _length(old), _length(new)
    value = 1.0 / ((1.0 + a * begun) * (1.0 + a * end))  # Santos & Correia 2001: mean of d/dg [g/(1 + a g)]
    free = value > p[LEAST] and end > 0.0
    for i in range(6):
        slope[i] = -a * value / (1.0 + a * end) * (2.0 if i < 3 else 1.0) * new[i] / end if free else 0.0
        if along < 0.0:  # turned back: e is this increment's
            new[i] -= old[i]
    return max(value, p[LEAST])


@njit
def factor_of(p, strain, old, kept, gradient):
    """Return c over an increment (6,); write the strain since the last turn (6,) and dc/d(strain) (6,)."""
    strained = by_strain(p, strain, old.history[FIRST:], kept, gradient)
    volume = -(strain[0] + strain[1] + strain[2])
    pressed, rate = by_stress(p, -(old.stress[0] + old.stress[1] + old.stress[2]) / 3.0, strained * volume)
    for j in range(6):
        # dc/d(eps) = c_p dc_g + c_g dc_p, dc_p through c_g de_v
        by_volume = volume * gradient[j] - (strained if j < 3 else 0.0)
        gradient[j] = pressed * gradient[j] + strained * rate * by_volume
    return strained * pressed  # c = c_g c_p


@njit
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    gradient, scaled = np.empty(6), p.copy()
    factor = factor_of(p, strain, old, new.history[FIRST:], gradient)
    scaled[BULK], scaled[SHEAR] = factor * p[BULK], factor * p[SHEAR]
    status, regime = _returned(int(p[SURFACE]), scaled, strain, old, new, tangent, with_tangent)
    if status != OK:
        return status, regime
    if with_tangent:
        by_factor, grown = np.zeros(6), new.history[0] - old.history[0]
        if regime != REGIME_ELASTIC:
            _hardened(int(p[SURFACE]), scaled, strain, regime, old, new, by_factor)
        for i in range(6):
            by_factor[i] *= -grown
            for j in range(6):
                by_factor[i] += tangent[i, j] * strain[j]
        for j in range(6):
            for i in range(6):
                tangent[i, j] += by_factor[i] * gradient[j] / factor  # h dc/d(eps)
    return OK, REGIME_STIFFNESS if regime == REGIME_ELASTIC else regime


@njit
def relax(p, moduli, share, strain, old, new, tangent, with_tangent):
    """Relax a point towards its law from the trial stress of its own stiffness, see law.SoilLaw and `viscous`.

    The strain since the last turn is no state that relaxes. With the elastic stiffness C that the loops assemble,
    C + s (T - C) is s C* + (1 - s) C_tr where T = C* + (1 - s)/s (C_tr - C), C_tr = c C + (C : de) dc/d(eps).
    """
    rest, gradient, by_factor = 1.0 - share, np.empty(6), np.zeros(6)
    factor = factor_of(p, strain, old, np.empty(6), gradient)
    for i in range(6):
        new.stress[i] = share * new.stress[i] + rest * old.stress[i]  # s sigma* + (1 - s) sigma_trial
    add_elastic_stress(rest * factor * moduli[0], rest * factor * moduli[1], strain, new.stress)
    for i in range(FIRST):
        new.history[i] = share * new.history[i] + rest * old.history[i]
    if with_tangent:
        add_elastic_stress(moduli[0], moduli[1], strain, by_factor)
        lost = (1.0 - factor) * rest / share
        subtract_elastic_tangent(lost * moduli[0], lost * moduli[1], tangent)
        for j in range(6):
            for i in range(6):
                tangent[i, j] += rest / share * by_factor[i] * gradient[j]


LAW = SoilLaw("following", PARAMETERS, HISTORY, pack, initial_moduli, update, relax)
