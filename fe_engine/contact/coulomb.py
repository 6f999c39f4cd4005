# SPDX-License-Identifier: MIT
"""Penalty contact with Coulomb friction (Cerfontaine, Charlier & Collin 2018, Eqs. 1-4).

    p'_N = -K_N g_N  in contact (g_N < 0), else 0;      tau rate = K_T g_T rate;      |tau| <= mu p'_N

The traction is work-conjugate to the jump: t = (-p'_N, tau_1, tau_2). The gap counts from the stress-free
state: an initial pressure p0 means an initial penetration p0/K_N, so g_N = w_N - p0/K_N with w_N the jump
since the initial state. Backward Euler; no dilatancy.

Newton on tau = P(tau_old + K_T dw) alone cycles: with K_T much stiffer than the soil, an iterate that slips
too far comes back as slip the other way and never meets the narrow stick range between. The law is therefore
linearised about a traction iterate tau_k of its own, as in the primal-dual active set method (Hueeber, Stadler
& Wohlmuth 2008): with the slip s = dw - (tau_k - tau_old)/K_T and any c > 0,

    tau = P(tau_k + c s),     P(eta) = eta  if |eta| <= mu p'_N,  else  mu p'_N eta/|eta|,

has the same solution, but reversed slip now asks for stick first. Where tau_k satisfies the law, this
linearisation is the consistent tangent of the update, whatever c; in slip it couples shear to the normal jump,

    dtau/dw_N = -mu K_N n,   dtau/dw_T = K_T mu p'_N / |tau_tr| (1 - n x n),   n = tau_tr/|tau_tr|,

and is not symmetric.
"""

from __future__ import annotations

import math

import numpy as np

from fe_engine.compiled import lean
from fe_engine.contact.law import ContactLaw
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP, CONTACT_STICK

PARAMETERS = ("kn", "kt", "mu")
KN, KT, MU = range(len(PARAMETERS))


def pack(kn: float, kt: float, mu: float) -> np.ndarray:
    """Return the packed parameters: penalties in N/m3 and the friction coefficient."""
    return np.array([kn, kt, mu])


# c as a fraction of K_T: small against the soil's stiffness, so that a slip reversal passes through stick
_ACTIVE_SET_FRACTION = 1.0e-3


@lean
def update(p, slide, traction):
    """Write the traction (3,) of one station, see law.ContactLaw; return the contact state.

    A station that was open has no committed shear and sticks where it closes again.
    """
    pressure = slide.initial_pressure - p[KN] * slide.jump[0]  # Eq. 2, from the initial p_0
    if pressure <= 0.0:  # Eq. 1: open
        for i in range(3):
            traction[i] = 0.0
        return CONTACT_OPEN
    traction[0] = -pressure
    return return_shear(p[KT], p[MU] * pressure, slide, traction)


@lean
def return_shear(kt, limit, slide, traction):
    """Write the shear traction of a closed station, at most ``limit`` (Pa, >= 0); return the contact state."""
    traction[1] = slide.traction_old[1] + kt * (slide.jump[1] - slide.jump_old[1])  # Eq. 3, backward Euler
    traction[2] = slide.traction_old[2] + kt * (slide.jump[2] - slide.jump_old[2])
    size = math.sqrt(traction[1] ** 2 + traction[2] ** 2)
    if size <= limit and limit > 0.0:  # Eq. 4: f <= 0
        return CONTACT_STICK
    if size == 0.0:
        return CONTACT_SLIP
    traction[1] *= limit / size  # back to f = 0 along the shear
    traction[2] *= limit / size
    return CONTACT_SLIP


@lean
def linearise(p, slide, guess, traction, tangent):
    """Write traction (3,) and tangent (3, 3): the law near the jump is traction + tangent d(jump).

    ``guess`` (3,) is the traction iterate; with guess = the law's own traction this returns that traction and
    the consistent tangent. Returns the contact state that was assumed.
    """
    pressure = slide.initial_pressure - p[KN] * slide.jump[0]
    for i in range(3):
        traction[i] = 0.0
        for j in range(3):
            tangent[i, j] = 0.0
    if pressure <= 0.0:
        return CONTACT_OPEN
    traction[0] = -pressure
    tangent[0, 0] = p[KN]  # dp/dw_N = -K_N, traction is -p
    if p[MU] <= 0.0:
        return CONTACT_SLIP
    return linearise_shear(p[KT], p[MU] * pressure, -p[MU] * p[KN], slide, guess, traction, tangent)


@lean
def linearise_shear(kt, limit, fall, slide, guess, traction, tangent):
    """Write shear and tangent of a station whose shear is limited; return the contact state that was assumed.

    ``limit`` is in Pa, > 0; ``fall`` is its derivative by the normal jump, in Pa/m.
    """
    jump, jump_old, traction_old, _ = slide
    c = _ACTIVE_SET_FRACTION * kt
    stick_1 = traction_old[1] + kt * (jump[1] - jump_old[1])  # Eq. 3
    stick_2 = traction_old[2] + kt * (jump[2] - jump_old[2])
    eta_1 = guess[1] + c / kt * (stick_1 - guess[1])  # eta = tau_k + c s, Hueeber et al. 2008
    eta_2 = guess[2] + c / kt * (stick_2 - guess[2])
    size = math.sqrt(eta_1 * eta_1 + eta_2 * eta_2)
    if size <= limit:  # P(eta) = eta
        traction[1], traction[2] = stick_1, stick_2
        tangent[1, 1] = tangent[2, 2] = kt
        return CONTACT_STICK
    n_1, n_2 = eta_1 / size, eta_2 / size
    ratio = limit / size
    # across the slip direction (-n_2, n_1): Newton on tau_x = ratio * eta_x with tau_x as unknown
    free = 1.0 - ratio * (1.0 - c / kt)
    across = -n_2 * guess[1] + n_1 * guess[2]
    across -= across / free
    stiffness = ratio * c / free  # K_T mu p'/|tau_tr| where tau_k satisfies the law
    traction[1] = limit * n_1 - across * n_2
    traction[2] = limit * n_2 + across * n_1
    tangent[1, 0], tangent[2, 0] = fall * n_1, fall * n_2  # along n: d(limit)/dw_N
    tangent[1, 1] = stiffness * n_2 * n_2
    tangent[2, 2] = stiffness * n_1 * n_1
    tangent[1, 2] = tangent[2, 1] = -stiffness * n_1 * n_2
    return CONTACT_SLIP


def gap(p: np.ndarray, initial_pressure: np.ndarray, normal_jump: np.ndarray) -> np.ndarray:
    """Return the opening in m (>= 0) from the normal jump since the initial state; arrays broadcast."""
    return np.maximum(normal_jump - initial_pressure / p[..., KN], 0.0)


def penalties(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the penalties K_N and K_T in N/m3 of packed parameters (..., 3)."""
    return p[..., KN], p[..., KT]


def smooth(p: np.ndarray) -> np.ndarray:
    """Return whether packed parameters (..., 3) are without friction."""
    frictionless: np.ndarray = p[..., MU] == 0.0
    return frictionless


LAW = ContactLaw("coulomb", PARAMETERS, pack, update, linearise, gap, penalties, smooth)
