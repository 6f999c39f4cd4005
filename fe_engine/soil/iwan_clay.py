# SPDX-License-Identifier: MIT
"""Undrained clay in total stress with kinematic hardening: von Mises elements in parallel (see `overlay`).

Strength s, shear modulus and backbone are those of the law "von-mises" (see `mobilised`),

    gamma = x s/G + g_s x^2/(1 - x),      tau = x s,

in simple shear and plane strain. Unloading follows Masing's rules. With g_s = s/G the secant is
G/G_0 = 1/(1 + gamma G_0/s), and the damping ratio of a loop of this hyperbola goes to 2/pi.

A table of G/G_0 by strain gives a polygon instead: elastic up to its first line, through all points of the table, and
on along its last line up to the strength. Contours of cyclic tests (`pack_contours`) give one that begins with G, too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fe_engine.soil import overlay
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import SoilLaw

MOST_POINTS = overlay.ELEMENTS  # of a table: one line from point to point for each element, and the strength


def pack(young: Any, poisson: Any, strength: Any, strain: Any = 0.0) -> np.ndarray:
    """Return the packed parameters; each may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    strength : largest shear stress in simple shear in Pa, > 0.
    strain : g_s, scale of the plastic shear strain (`mobilised.scale_of`). 0 is perfect plasticity.
    """
    strength, strain = np.broadcast_arrays(np.asarray(strength, dtype=float), np.asarray(strain, dtype=float))
    shear = np.broadcast_to(moduli(young, poisson)[1], strength.shape)
    x, s = overlay.mobilised_shares(overlay.ELEMENTS - 1), strength[..., None]
    # backbone of `mobilised`: gamma = tau/G + g_s A(x)
    gamma = x * s / shear[..., None] + strain[..., None] * x * x / (1.0 - x)
    # dtau/dgamma, A' = x (2 - x)/(1 - x)^2
    slope = s / (s / shear[..., None] + strain[..., None] * x * (2.0 - x) / (1.0 - x) ** 2)
    return overlay.pack(young, poisson, 0.0, strength, *overlay.shares(x * s, gamma, slope, shear, strength))


def pack_table(young: Any, poisson: Any, strength: Any, strain: Any, ratio: Any) -> np.ndarray:
    """Return the packed parameters of a backbone given by points; each of the first three may be an array.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    strength : largest shear stress in simple shear in Pa, > 0.
    strain, ratio : engineering shear strain and secant modulus over the shear modulus, (n,), 2 to MOST_POINTS points
        of a concave curve below the strength.
    """
    strength, strain = np.asarray(strength, dtype=float), np.asarray(strain, dtype=float)
    shear = np.broadcast_to(moduli(young, poisson)[1], np.broadcast_shapes(strength.shape, np.shape(young)))
    tau = shear[..., None] * np.asarray(ratio, dtype=float) * strain  # tau = G gamma (G_sec/G)
    line = np.minimum(np.arange(overlay.ELEMENTS - 1), strain.size - 2)  # the last one counts once: no change of slope
    slope = (np.diff(tau) / np.diff(strain))[..., line]
    return overlay.pack(
        young, poisson, 0.0, strength, *overlay.shares(tau[..., line], strain[line], slope, shear, strength)
    )


def pack_contours(young: Any, poisson: Any, strength: Any, strain: Any, ratio: Any) -> np.ndarray:
    """Return the packed parameters of a backbone through points far beyond the elastic strains.

    From G = slope at 0 to the first point it is the hyperbola tau = gamma (G + b gamma)/(1 + a gamma) through the first
    two points, or through the first alone (b = 0) where these bend more than a hyperbola; then lines from point to
    point, and the last stress as the strength.

    Parameters
    ----------
    young, poisson : elastic constants; Young's modulus in Pa.
    strength : unit of the stresses in Pa, > 0; the first three may be arrays.
    strain, ratio : engineering shear strain and stress in that unit, (n,), 2 to 6 points of a concave curve, the first
        below G.
    """
    strain, ratio = np.asarray(strain, dtype=float), np.asarray(ratio, dtype=float)
    unit = np.asarray(strength, dtype=float)
    shear = np.broadcast_to(moduli(young, poisson)[1], np.broadcast_shapes(unit.shape, np.shape(young)))[..., None]
    tau = ratio * unit[..., None]
    secant = (tau / strain)[..., :2]
    # G + b gamma = (tau/gamma) (1 + a gamma) at both points
    bend = np.diff((secant - shear) / strain[:2], axis=-1) / -np.diff(secant, axis=-1)
    bends = bend > 0.0
    a = np.where(bends, bend, (shear / secant[..., :1] - 1.0) / strain[0])
    b = np.where(bends, (secant[..., :1] - shear) / strain[0] + secant[..., :1] * a, 0.0)
    on = tau[..., :1] * overlay.mobilised_shares(overlay.ELEMENTS - strain.size)
    left = shear - a * on
    gamma = 2.0 * on / (left + np.sqrt(left * left + 4.0 * b * on))  # root of tau (1 + a gamma) = gamma (G + b gamma)
    below = 1.0 + a * gamma
    slope = (shear + 2.0 * b * gamma - a * on) / below
    lines = np.diff(tau, axis=-1) / np.diff(strain)
    start = np.broadcast_to(strain[:-1], lines.shape)
    stress, at, slope = (
        np.concatenate(pair, axis=-1) for pair in ((on, tau[..., :-1]), (gamma, start), (slope, lines))
    )
    last = tau[..., -1]
    return overlay.pack(young, poisson, 0.0, last, *overlay.shares(stress, at, slope, shear[..., 0], last))


LAW = SoilLaw("iwan-clay", overlay.PARAMETERS, overlay.HISTORY, pack, overlay.elastic_moduli, overlay.update)
