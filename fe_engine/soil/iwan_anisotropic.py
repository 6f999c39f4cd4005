# SPDX-License-Identifier: MIT
"""Undrained clay with kinematic hardening whose strength differs by direction: ellipsoids in parallel.

An element k of `overlay` has the share w_k of the shear modulus and, in place of a von Mises cylinder, the ellipsoid of
`anisotropic` with the strengths rho_k s_C, rho_k s_D and rho_k s_E, shifted by rho_k alpha. Simple shear on a
horizontal plane has the backbone of `iwan_clay` with the strength s_D; in another direction stress and strain of it
grow with the strength there. A path that does not start in the centres of the ellipsoids turns towards them: from an
isotropic stress, with s_C, s_D, s_E as 1.4, 1, 0.7, simple shear has up to 2 % less on the way to s_D, and loops settle
over some cycles. The initial deviator s0 is shared out as rho_k s0: a K0 state within the strength moves no element.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fe_engine.compiled import njit
from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import overlay
from fe_engine.soil.anisotropic import add_deviator, add_flow, coordinates, returned, surface as ellipsoid
from fe_engine.soil.elastic import elastic_tangent
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.overlay import BULK, ELEMENTS, FIRST, KAPPA, RADIUS, SHEAR

# parameters of the overlay, whose strength is s_D, then K, G, s_C, s_D, s_E of `anisotropic`
PARAMETERS = (*overlay.PARAMETERS, "bulk_2", "shear_2", "compression", "direct_shear", "extension")
_WHOLE = len(overlay.PARAMETERS)


def pack(backbone: np.ndarray, factors: Any) -> np.ndarray:
    """Return the packed parameters (..., n).

    Parameters
    ----------
    backbone : packed parameters (..., m) of `iwan_clay`, whose strength is that of simple shear.
    factors : (3,) strengths in plane strain compression, simple shear and extension, in one unit; s_C + s_E > s_D.
    """
    strengths = backbone[..., overlay.STRENGTH, None] * np.asarray(factors) / factors[1]
    return np.ascontiguousarray(np.concatenate([backbone, backbone[..., :2], strengths], axis=-1))


@njit
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    bulk, shear = p[BULK], p[SHEAR]
    volume = strain[0] + strain[1] + strain[2]
    mean = (old.stress[0] + old.stress[1] + old.stress[2]) / 3.0 + bulk * volume
    change, initial = overlay.deviator(strain, volume, shear), overlay.initial_deviator(old)
    whole, plastic, status = 0.0, 0.0, OK
    first, others, centre = ellipsoid(p[_WHOLE:])
    own, y = np.zeros(6), np.empty(5)
    if with_tangent:
        elastic_tangent(bulk, 0.0, 1.0, tangent)
    for i in range(6):
        new.stress[i] = mean if i < 3 else 0.0
    for k in range(ELEMENTS):
        rho = p[RADIUS + k]
        if rho == 0.0:
            continue
        own[0], own[1], own[3], own[4], own[5] = overlay.trial_deviator(p, k, change, initial, old.history)
        own[2] = -own[0] - own[1]
        coordinates(own, y)
        surface = first / (rho * rho), others / (rho * rho), rho * centre
        shrink, square, found = returned(surface, y)
        status = max(status, found)
        whole += shrink[1] * p[FIRST + k]
        if square >= 0.0:
            plastic += math.sqrt(0.5 * square)  # what II has lost, G w_k g_k
            if with_tangent:
                add_flow(p[FIRST + k] * shear, surface, shrink, y, tangent)
        for i in range(6):
            own[i] = 0.0
        add_deviator(y, own)
        overlay.keep(k, rho, (own[0], own[1], own[3], own[4], own[5]), initial, new)
    new.history[KAPPA] = old.history[KAPPA] + plastic / (math.sqrt(3.0) * shear)
    if with_tangent:
        overlay.add_elastic(0.0, whole * shear, tangent)
    return status, REGIME_CONE if plastic > 0.0 else REGIME_ELASTIC


LAW = SoilLaw(
    "iwan-anisotropic", PARAMETERS, overlay.HISTORY, pack, overlay.elastic_moduli, update, isotropic=False,
)  # fmt: skip
