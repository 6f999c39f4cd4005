# SPDX-License-Identifier: MIT
"""Stiffness of sand that follows the stress and degrades, on single points beside closed forms (see soil.following).

Isotropic compression from p_0: p^(1 - n) = p_0^(1 - n) + (1 - n) K_0 p_0^-n e_v. Simple shear: tau = G_0 g/(1 + a g),
a = 0.385/g_07, 72.2 % of G_0 g at g_07. A rectangle of compression and shear gives (G_1 - G_0) g^2/2.
"""

from functools import cache

import numpy as np

from fe_engine.soil import following, plasol
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import Point
from tests.verification.blocks import POISSON, YOUNG
from tests.verification.rows import Row

PRESSURE, EXPONENT, STRAIN, GAMMA_07 = 1.0e5, 0.5, 4.0e-4, 2.0e-4
BULK, SHEAR = moduli(YOUNG, POISSON)
_SQUEEZE, _SHEAR = -np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) / 3.0, np.eye(6)[3]


def _path(exponent: float, degradation: float | None, strains: list[np.ndarray]) -> tuple[np.ndarray, float]:
    """Stress (6,) at the end of increments of strain, and the work on the way in J/m3."""
    rows = plasol.pack(YOUNG, POISSON, 0.1, 0.5, 0.005, 0.0, 1.0e9)
    p = following.pack(plasol.LAW, rows, PRESSURE, exponent, degradation, 0.01)
    state = Point(-PRESSURE * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), np.zeros(len(following.HISTORY)))
    work = 0.0
    for strain in strains:
        new = Point(np.empty(6), np.empty(len(following.HISTORY)))
        following.update(p, strain, state, new, np.empty((6, 6)), False)
        work += float(0.5 * (state.stress + new.stress) @ strain)
        state = new
    return state.stress, work


@cache
def rows() -> tuple[Row, ...]:
    """Ends of compression, shear, and of a closed rectangle."""
    case, tight = "sand, stiffness in a run", 1e-8
    n, k = EXPONENT, BULK / PRESSURE
    end = (1.0 + (1.0 - n) * k * STRAIN) ** (1.0 / (1.0 - n))
    pressed = [-_path(n, None, [STRAIN / steps * _SQUEEZE] * steps)[0][0] / PRESSURE for steps in (1, 10)]
    sheared = [_path(0.0, GAMMA_07, [g / 10 * _SHEAR] * 10)[0][3] / (SHEAR * g) for g in (GAMMA_07, 5 * GAMMA_07)]
    round_trip = [each for part in (_SQUEEZE, _SHEAR, -_SQUEEZE, -_SHEAR) for each in [STRAIN / 10 * part] * 10]
    gained = -_path(n, None, round_trip)[1]
    return (
        Row(case, "isotropic compression, p/p_0, 1 increment", "", pressed[0], end, "closed form, Hardin", tight),
        Row(case, "isotropic compression, p/p_0, 10 increments", "", pressed[1], end, "closed form, Hardin", tight),
        Row(case, "simple shear to gamma_07, tau/(G_0 gamma)", "", sheared[0], 1.0 / 1.385, "Santos & Correia", tight),
        Row(case, "simple shear to 5 gamma_07", "", sheared[1], 1.0 / 2.925, "Santos & Correia", tight),
        Row(case, "energy that a rectangle of compression and shear gives", "J/m3", gained,
            0.5 * (end**n - 1.0) * SHEAR * STRAIN**2, "hypoelastic, closed form", 1e-3),
    )  # fmt: skip
