# SPDX-License-Identifier: MIT
"""Equilibrium of a rigid body on nonlinear springs: reactions of a state and path following, jitted.

State x = (u, rotation); loads F(x) = (H, M) = sum_j b_j r_j(a_j . x), tangent K = sum_j b_j k_j a_j^T (2, 2).
Every way to drive the body is a pair of constant 2x2 matrices:  g(x) = G x + C F(x) - c = 0

- lateral displacement, load at height arm: G = [[1, 0], [0, 0]], C = [[0, 0], [arm, 1]], c = (u, 0)
- rotation, load at height arm:             G = [[0, 1], [0, 0]], C = [[0, 0], [arm, 1]], c = (rotation, 0)
- loads:                                    G = 0, C = identity, c = (H, M)
- displacement and rotation imposed:        G = identity, C = 0, c = (u, rotation)
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

MAX_ITERATIONS = 30
# Residual at rest, relative to the size of the equation (forces: to what all springs can build up).
TOLERANCE = 1e-11
# A step is halved at most this often before the path is given up.
MAX_HALVINGS = 12
# Line search: shortest damping, and the decrease of the squared residual that a step must bring.
MIN_DAMPING = 1.0 / 64.0
ARMIJO = 1e-4


@njit(cache=True)
def spring_row(knots, values, slopes, count, q):
    """Reaction and stiffness dr/dq of one odd curve at q: cubic Hermite, last slope beyond the end."""
    x = abs(q)
    last = count - 1
    if x >= knots[last]:
        r, k = values[last] + slopes[last] * (x - knots[last]), slopes[last]
    else:
        low, high = 0, last
        while high - low > 1:
            middle = (low + high) // 2
            if x >= knots[middle]:
                low = middle
            else:
                high = middle
        h = knots[low + 1] - knots[low]
        s = (x - knots[low]) / h
        step, d0, d1 = (values[low + 1] - values[low]) / h, slopes[low], slopes[low + 1]
        c2, c3 = 3.0 * step - 2.0 * d0 - d1, d0 + d1 - 2.0 * step
        r = values[low] + h * s * (d0 + s * (c2 + s * c3))
        k = d0 + s * (2.0 * c2 + 3.0 * s * c3)
    return (-r if q < 0.0 else r), k


@njit(cache=True)
def row_values(knots, values, slopes, count, q):
    """Reactions (n, states) of rows at their displacements q (n, states)."""
    out = np.empty_like(q)
    for j in range(q.shape[0]):
        for i in range(q.shape[1]):
            out[j, i] = spring_row(knots[j], values[j], slopes[j], count[j], q[j, i])[0]
    return out


@njit(cache=True)
def reactions(a, b, knots, values, slopes, count, u, rotation, F, K):
    """Write the loads F (2,) = (H [N], M [N m]) and the tangent K (2, 2) of a state into the given arrays."""
    F[:] = 0.0
    K[:, :] = 0.0
    for j in range(count.size):
        q = a[j, 0] * u + a[j, 1] * rotation
        r, k = spring_row(knots[j], values[j], slopes[j], count[j], q)
        for i in range(2):
            F[i] += b[j, i] * r
            K[i, 0] += b[j, i] * k * a[j, 0]
            K[i, 1] += b[j, i] * k * a[j, 1]


@njit(cache=True)
def _merit(G, C, F, x0, x1, c0, c1, scale):
    """Residual of both equations over their sizes, and the largest of them."""
    g0 = (G[0, 0] * x0 + G[0, 1] * x1 + C[0, 0] * F[0] + C[0, 1] * F[1] - c0) / scale[0]
    g1 = (G[1, 0] * x0 + G[1, 1] * x1 + C[1, 0] * F[0] + C[1, 1] * F[1] - c1) / scale[1]
    return g0, g1, max(abs(g0), abs(g1))


@njit(cache=True)
def _newton(a, b, knots, values, slopes, count, G, C, scale, c0, c1, x, F, K):
    """Solve g(x) = 0 from x by Newton with line search; answer in x; return iterations, -1 on failure."""
    x0, x1 = x[0], x[1]
    reactions(a, b, knots, values, slopes, count, x0, x1, F, K)
    g0, g1, size = _merit(G, C, F, x0, x1, c0, c1, scale)
    for iteration in range(MAX_ITERATIONS):
        if size <= TOLERANCE:
            x[0], x[1] = x0, x1
            return iteration
        j00 = (G[0, 0] + C[0, 0] * K[0, 0] + C[0, 1] * K[1, 0]) / scale[0]
        j01 = (G[0, 1] + C[0, 0] * K[0, 1] + C[0, 1] * K[1, 1]) / scale[0]
        j10 = (G[1, 0] + C[1, 0] * K[0, 0] + C[1, 1] * K[1, 0]) / scale[1]
        j11 = (G[1, 1] + C[1, 0] * K[0, 1] + C[1, 1] * K[1, 1]) / scale[1]
        determinant = j00 * j11 - j01 * j10
        if determinant == 0.0 or not math.isfinite(determinant):
            return -1
        d0, d1 = -(j11 * g0 - j01 * g1) / determinant, -(j00 * g1 - j10 * g0) / determinant
        before, damping = g0 * g0 + g1 * g1, 1.0
        while True:
            y0, y1 = x0 + damping * d0, x1 + damping * d1
            reactions(a, b, knots, values, slopes, count, y0, y1, F, K)
            g0, g1, size = _merit(G, C, F, y0, y1, c0, c1, scale)
            if size <= TOLERANCE or g0 * g0 + g1 * g1 <= (1.0 - 2.0 * ARMIJO * damping) * before:
                break
            damping *= 0.5
            if damping < MIN_DAMPING:
                return -1
        x0, x1 = y0, y1
    return -1


@njit(cache=True)
def follow(a, b, knots, values, slopes, count, G, C, scale, start, targets, states, loads):
    """Follow the equilibrium from state `start` (where c is the first target) through all targets c (n, 2).

    Writes states (n, 2) = (u, rotation) and loads (n, 2) = (H, M). Between targets a failed step is halved.

    Returns
    -------
    tuple of int, float, float
        Number of targets reached; c of the last converged sub-step.
    """
    x, trial, F, K = start.copy(), start.copy(), np.zeros(2), np.zeros((2, 2))
    at0, at1 = targets[0, 0], targets[0, 1]
    for n in range(targets.shape[0]):
        done, width, halvings = 0.0, 1.0, 0
        from0, from1 = at0, at1
        while done < 1.0:
            aim = min(1.0, done + width)
            c0, c1 = from0 + aim * (targets[n, 0] - from0), from1 + aim * (targets[n, 1] - from1)
            trial[:] = x
            if _newton(a, b, knots, values, slopes, count, G, C, scale, c0, c1, trial, F, K) < 0:
                halvings += 1
                width *= 0.5
                if halvings > MAX_HALVINGS:
                    return n, at0, at1
            else:
                x[:], done, at0, at1 = trial, aim, c0, c1
        states[n] = x
        reactions(a, b, knots, values, slopes, count, x[0], x[1], F, K)
        loads[n] = F
    return targets.shape[0], at0, at1
