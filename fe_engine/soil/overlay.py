# SPDX-License-Identifier: MIT
"""Kinematic hardening by elements in parallel (Iwan 1967; overlay model of Besseling 1958 and Zienkiewicz et al. 1972).

The deviator is a sum over elements, s = sum s_k. All have the strain of the point; each is elastic and perfectly
plastic with a share w_k of the shear modulus and a share rho_k of the strength R (sum w = sum rho = 1),

    ds_k = 2 G w_k (de - de_k),     II(s_k) = sqrt(s_k:s_k/2) <= rho_k R(I),     de_k ~ s_k,     R(I) = k - m I,

with I = tr sigma, tension positive. The mean stress is elastic: no plastic change of volume. With m = 0 the surfaces
are von Mises cylinders, otherwise Drucker-Prager cones with a common apex I = k/m, whose sizes follow the pressure.

Where I does not change, unloading and reloading follow the curve of first loading, twice as large in stress and
strain, and a larger load goes on with what it left (the four rules of Masing 1926 and Pyke 1979). Each element
dissipates s_k:de_k >= 0, and what the elements store is a quadratic form: no closed path gives energy.

Shares (`shares`) come from the backbone tau(gamma) of simple shear. The distribution of yield strains is -tau''/G
(Iwan 1967); a bin between two points of the backbone becomes one element with its weight and its mean. The law then
has the tangents of the backbone there, at most 2.5 % more stress between them (hyperbola), and G and strength exactly.

The deviator s0 of the initial state is shared out like the strength, rho_k s0: a K0 state has the stiffness G in all
directions. History keeps s_k - rho_k s0; s0 is what the stress has more than their sum.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fe_engine.compiled import lean
from fe_engine.conventions import OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import PLASTIC_STRAIN, rows
from fe_engine.soil.plasol import APEX_STIFFNESS

ELEMENTS = 10
PARAMETERS = (
    "bulk", "shear", "slope", "strength",
    *(f"stiffness_{k}" for k in range(ELEMENTS)), *(f"radius_{k}" for k in range(ELEMENTS)),
)  # fmt: skip
BULK, SHEAR, SLOPE, STRENGTH = range(4)
FIRST, RADIUS = 4, 4 + ELEMENTS  # of w_k and rho_k among the parameters
# parameters  | K G m k | w_0 .. w_9 | rho_0 .. rho_9 |
# history     | e | xx yy xy yz zx of s_0 - rho_0 s0 | .. of s_1 - rho_1 s0 | .. |     e: plastic shear strain/sqrt(3)
HISTORY = (PLASTIC_STRAIN, *(f"element_{k}_{c}" for k in range(ELEMENTS) for c in ("xx", "yy", "xy", "yz", "zx")))
KAPPA, SHEARS = 0, 1
_SQRT3 = math.sqrt(3.0)
_ROUNDING = 1e-13  # shares below are none


def mobilised_shares(number: int) -> np.ndarray:
    """Return the shares (number,) of the strength at the points of a backbone, close to each other at both ends."""
    return np.asarray(np.sin(0.5 * np.pi * np.arange(1, number + 1) / (number + 1)) ** 2)


def shares(tau: Any, gamma: Any, slope: Any, shear: Any, strength: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return w and rho (..., ELEMENTS), each with the sum 1, of a concave backbone.

    Parameters
    ----------
    tau, gamma, slope : stress (Pa), strain and tangent (Pa) at ELEMENTS - 1 points (..., ELEMENTS - 1), rising.
    shear, strength : initial tangent and last stress (...,), Pa.
    """
    shear, strength = np.asarray(shear, dtype=float)[..., None], np.asarray(strength, dtype=float)[..., None]
    zero = np.zeros(np.broadcast_shapes(np.shape(tau), shear.shape, strength.shape)[:-1] + (1,))
    slopes = np.concatenate([zero + shear, slope + zero, zero], axis=-1)
    axis = np.concatenate([zero, tau - gamma * slope + zero, zero + strength], axis=-1)  # where tangents meet gamma = 0
    # Iwan 1967: -tau''/G, bin by bin; rho alike from the axis
    w, rho = -np.diff(slopes, axis=-1) / shear, np.diff(axis, axis=-1) / strength
    return np.where(w > _ROUNDING, w, 0.0), np.where(rho > _ROUNDING, rho, 0.0)


def pack(young: Any, poisson: Any, slope: Any, strength: Any, w: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Return the packed parameters; Young's modulus and strength k in Pa, slope m, shares (..., ELEMENTS)."""
    columns = [*np.moveaxis(np.asarray(w), -1, 0), *np.moveaxis(np.asarray(rho), -1, 0)]
    return rows(*moduli(young, poisson), slope, strength, *columns)


def elastic_moduli(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear modulus in Pa of packed parameters (..., n)."""
    return p[..., BULK], p[..., SHEAR]


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    bulk, shear = p[BULK], p[SHEAR]
    volume = strain[0] + strain[1] + strain[2]
    mean = (old.stress[0] + old.stress[1] + old.stress[2]) / 3.0 + bulk * volume
    size = p[STRENGTH] - 3.0 * p[SLOPE] * mean  # R(I) = k - m I
    opens = size <= 0.0 and p[SLOPE] > 0.0
    if opens:
        apex = p[STRENGTH] / p[SLOPE] / 3.0
        mean, bulk = apex + APEX_STIFFNESS * (mean - apex), APEX_STIFFNESS * bulk
    change, initial = deviator(strain, volume, shear), initial_deviator(old)
    for i in range(6):
        new.stress[i] = mean if i < 3 else 0.0
        if with_tangent:
            for j in range(6):
                tangent[i, j] = 0.0
    whole, plastic, yields = 0.0, 0.0, False
    for k in range(ELEMENTS):
        a, b, c, d, e = trial_deviator(p, k, change, initial, old.history)
        # II of the trial deviator, s_zz = -(s_xx + s_yy)
        trial, rho, ratio = math.sqrt(a * a + b * b + a * b + c * c + d * d + e * e), p[RADIUS + k], 1.0
        if opens:
            ratio = APEX_STIFFNESS
        elif trial > rho * size:
            ratio = rho * size / trial  # II(s_k) = rho_k R: back along its own deviator
            if with_tangent:
                _add_yielding(p, k, ratio, trial, (a, b, -a - b, c, d, e), tangent)
        whole, plastic, yields = whole + ratio * p[FIRST + k], plastic + (1.0 - ratio) * trial, yields or ratio < 1.0
        keep(k, rho, (ratio * a, ratio * b, ratio * c, ratio * d, ratio * e), initial, new)
    new.history[KAPPA] = old.history[KAPPA] + plastic / (_SQRT3 * shear)  # G w_k g_k is what II has lost; g = sqrt3 e
    if with_tangent:
        add_elastic(bulk, whole * shear, tangent)
    return OK, REGIME_APEX if opens else (REGIME_CONE if yields else REGIME_ELASTIC)


@lean
def trial_deviator(p, k, change, initial, history):
    """Return xx, yy, xy, yz, zx of the trial deviator of an element, Pa."""
    w, rho, at = p[FIRST + k], p[RADIUS + k], SHEARS + 5 * k
    return (
        history[at] + rho * initial[0] + w * change[0], history[at + 1] + rho * initial[1] + w * change[1],
        history[at + 2] + rho * initial[2] + w * change[2], history[at + 3] + rho * initial[3] + w * change[3],
        history[at + 4] + rho * initial[4] + w * change[4],
    )  # fmt: skip


@lean
def keep(k, rho, deviator, initial, new):
    """Add the deviator of an element to the stress, and write its history."""
    at = SHEARS + 5 * k
    for i in range(5):
        new.history[at + i] = deviator[i] - rho * initial[i]
    new.stress[0] += deviator[0]
    new.stress[1] += deviator[1]
    new.stress[2] -= deviator[0] + deviator[1]
    for i in range(3):
        new.stress[3 + i] += deviator[2 + i]


@lean
def deviator(strain, volume, shear):
    """Return xx, yy, xy, yz, zx of the elastic deviator of a strain increment, Pa."""
    third = volume / 3.0
    return (
        2.0 * shear * (strain[0] - third), 2.0 * shear * (strain[1] - third),
        shear * strain[3], shear * strain[4], shear * strain[5],
    )  # fmt: skip


@lean
def initial_deviator(old):
    """Return xx, yy, xy, yz, zx of the deviator of the initial state, Pa."""
    mean = (old.stress[0] + old.stress[1] + old.stress[2]) / 3.0
    s0, s1, s3, s4, s5 = old.stress[0] - mean, old.stress[1] - mean, old.stress[3], old.stress[4], old.stress[5]
    for k in range(ELEMENTS):
        at = SHEARS + 5 * k
        s0, s1, s3 = s0 - old.history[at], s1 - old.history[at + 1], s3 - old.history[at + 2]
        s4, s5 = s4 - old.history[at + 3], s5 - old.history[at + 4]
    return s0, s1, s3, s4, s5


@lean
def _add_yielding(p, k, ratio, trial, deviator, tangent):
    """Add what a returned element has less along its deviator (6), and what the pressure gives it."""
    along = ratio * p[FIRST + k] * p[SHEAR] / (trial * trial)  # 2 G w_k ratio N x N, N:N = 1, with N = s_k/(sqrt2 II)
    pressure = 3.0 * p[BULK] * p[SLOPE] * p[RADIUS + k] / trial  # rho_k dR = -3 K m rho_k tr(d eps), along s_k/II
    for i in range(6):
        for j in range(6):
            tangent[i, j] -= along * deviator[i] * deviator[j]
        for j in range(3):
            tangent[i, j] -= pressure * deviator[i]


@lean
def add_elastic(bulk, shear, tangent):
    """Add the elastic stiffness (6, 6) of two moduli, Pa."""
    lame = bulk - 2.0 * shear / 3.0
    for i in range(3):
        for j in range(3):
            tangent[i, j] += lame
        tangent[i, i] += 2.0 * shear
        tangent[i + 3, i + 3] += shear
