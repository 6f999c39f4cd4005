# SPDX-License-Identifier: MIT
"""Drained sand with kinematic hardening: Drucker-Prager elements in parallel (see `overlay`), no dilation.

Strength is the cone of the final friction angle (`plasol`), R = k_f - m_f I. The backbone at the pressure -I = i_0 has
first yield at R_i, that of the initial friction angle, and the hardening of `plasol` in the mobilised strength,

    tau = R_i + (R_f - R_i) e/(B + e),      gamma = tau/G + sqrt3 e,      e the equivalent plastic strain.

At another pressure stress and strain of the backbone grow with R: strains in proportion to the pressure.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fe_engine.soil import formulas, overlay
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import SoilLaw


def pack(young: Any, poisson: Any, phi_i: Any, phi_f: Any, b_phi: Any, cohesion: Any, pressure: Any) -> np.ndarray:
    """Return the packed parameters; each may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    phi_i, phi_f : friction angles at first yield and at last, rad; 0 <= phi_i <= phi_f < pi/2.
    b_phi : equivalent plastic strain at half of the hardening, > 0.
    cohesion : Pa.
    pressure : mean effective stress (compression positive) at which the backbone is the one above, Pa, > 0.
    """
    young, poisson, phi_i, phi_f, b_phi, cohesion, pressure = np.broadcast_arrays(
        *(np.asarray(each, dtype=float) for each in (young, poisson, phi_i, phi_f, b_phi, cohesion, pressure))
    )
    shear = moduli(young, poisson)[1]
    m, k = _cone(phi_f, cohesion)
    m_i, k_i = _cone(phi_i, cohesion)
    strength = 3.0 * m * pressure + k  # R_f = k - m I at I = -3 p
    first = np.minimum(3.0 * m_i * pressure + k_i, strength)[..., None]
    # x = e/(B + e), so that e = B x/(1 - x)
    x = np.concatenate([[0.0], overlay.mobilised_shares(overlay.ELEMENTS - 2)])
    tau = first + (strength[..., None] - first) * x
    gamma = tau / shear[..., None] + np.sqrt(3.0) * b_phi[..., None] * x / (1.0 - x)
    hardening = (strength[..., None] - first) * (1.0 - x) ** 2 / (np.sqrt(3.0) * b_phi[..., None])  # dtau/d(sqrt3 e)
    slope = hardening * shear[..., None] / (hardening + shear[..., None])  # elastic and plastic strain in series
    return overlay.pack(young, poisson, m, k, *overlay.shares(tau, gamma, slope, shear, strength))


def _cone(phi: np.ndarray, cohesion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return slope m and strength k (Pa) of the cone of a friction angle (rad)."""
    sine, cosine = np.sin(phi), np.cos(phi)
    return np.asarray(formulas.cone_slope(sine)), np.asarray(formulas.cone_cohesion(sine, cosine, cohesion))  # type: ignore[arg-type]


LAW = SoilLaw("iwan-sand", overlay.PARAMETERS, overlay.HISTORY, pack, overlay.elastic_moduli, overlay.update)
