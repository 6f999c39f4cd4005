# SPDX-License-Identifier: MIT
"""Penalty contact with adhesion, friction and a limited tension: clay, and c-phi interfaces.

    p = -K_N g_N  down to p = -t;       tau rate = K_T g_T rate;       |tau| <= min(a, p + t) + mu max(p, 0)

p is the contact pressure over the hydrostatic pressure of the water, a the adhesion (alpha su, API RP 2GEO), t the
tension that the contact carries:

    t = 0       vented: it opens where the total normal stress falls to the water pressure (water fills the crack),
    t = inf     bonded: it never opens,
    t between   sealed: suction, down to cavitation at t = p_atm + gamma_w (h_w + z). An open station keeps t.

The adhesion falls in proportion to p + t below p + t = a: a limit that drops from a to 0 where the contact opens has no
tangent there, and Newton's method does not converge. Sign conventions, the gap and the linearisation about a traction
iterate are those of `coulomb`, of which this is the law with a = t = 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fe_engine.compiled import lean
from fe_engine.contact.coulomb import linearise_shear, return_shear
from fe_engine.contact.law import ContactLaw
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP

PARAMETERS = ("kn", "kt", "mu", "adhesion", "tension")
KN, KT, MU, ADHESION, TENSION = range(len(PARAMETERS))


def pack(kn: Any, kt: Any, mu: Any, adhesion: Any, tension: Any) -> np.ndarray:
    """Return the packed parameters (n,), or (k, n) where any is an array (k,).

    Penalties in N/m3, the friction coefficient, adhesion and largest tension in Pa (``inf``: bonded).
    """
    columns = np.broadcast_arrays(kn, kt, mu, adhesion, tension)
    return np.ascontiguousarray(np.stack(columns, axis=-1), dtype=float)


@lean
def shear_limit(p, pressure):
    """Return the largest shear in Pa at a contact pressure above -t, and its derivative by the pressure."""
    limit, slope, above = p[ADHESION], 0.0, pressure + p[TENSION]  # min(a, p + t), 0 at opening
    if above < limit:
        limit, slope = above, 1.0
    if pressure > 0.0:
        limit, slope = limit + p[MU] * pressure, slope + p[MU]  # + mu max(p, 0)
    return limit, slope


@lean
def update(p, slide, traction):
    """Write the traction (3,) of one station, see law.ContactLaw; return the contact state.

    A station that was open has no committed shear and sticks where it closes again.
    """
    pressure = slide.initial_pressure - p[KN] * slide.jump[0]
    if pressure <= -p[TENSION]:
        traction[0] = p[TENSION]
        traction[1] = traction[2] = 0.0
        return CONTACT_OPEN
    traction[0] = -pressure  # p = -K_N g_N: Cerfontaine et al. 2018, Eq. 2, from p_0
    return return_shear(p[KT], shear_limit(p, pressure)[0], slide, traction)


@lean
def linearise(p, slide, guess, traction, tangent):
    """Write traction (3,) and tangent (3, 3) about a traction iterate, see law.ContactLaw; return the contact state."""
    pressure = slide.initial_pressure - p[KN] * slide.jump[0]
    for i in range(3):
        traction[i] = 0.0
        for j in range(3):
            tangent[i, j] = 0.0
    if pressure <= -p[TENSION]:
        traction[0] = p[TENSION]
        return CONTACT_OPEN
    traction[0] = -pressure
    tangent[0, 0] = p[KN]
    limit, slope = shear_limit(p, pressure)
    if limit <= 0.0:
        return CONTACT_SLIP
    return linearise_shear(p[KT], limit, -slope * p[KN], slide, guess, traction, tangent)


def gap(p: np.ndarray, initial_pressure: np.ndarray, normal_jump: np.ndarray) -> np.ndarray:
    """Return the opening in m (>= 0) from the normal jump since the initial state; arrays broadcast."""
    return np.maximum(normal_jump - (initial_pressure + p[..., TENSION]) / p[..., KN], 0.0)


def penalties(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the penalties K_N and K_T in N/m3 of packed parameters (..., 5)."""
    return p[..., KN], p[..., KT]


def smooth(p: np.ndarray) -> np.ndarray:
    """Return whether packed parameters (..., 5) have neither friction nor adhesion."""
    frictionless: np.ndarray = (p[..., MU] == 0.0) & (p[..., ADHESION] == 0.0)
    return frictionless


LAW = ContactLaw("adhesion", PARAMETERS, pack, update, linearise, gap, penalties, smooth)
