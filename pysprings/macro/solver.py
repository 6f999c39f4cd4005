# SPDX-License-Identifier: MIT
"""Equilibrium of a rigid body on nonlinear springs: reactions of a state and path following (jitted, `core.jit`).

State x = (u [m], rotation [rad]); loads F(x) = (H [N], M [N m]) and their tangent K (2, 2), by the law of the springs:

- ROWS: F = sum_j b_j r_j(a_j . x), K = sum_j b_j k_j a_j^T; a row reads one displacement;
- FAN: F = sum_k w_k(phi) R_k(rho) with rho = |(u, rotation*L)|, phi its angle, R_k the loads along ray k
  (`fan_loads`); rows 2k and 2k+1 hold H and M of ray k, knots are rho, a = (angle of the ray, L).

Every way to drive the body is a pair of constant 2x2 matrices:  g(x) = G x + C F(x) - c = 0

- lateral displacement, load at height arm: G = [[1, 0], [0, 0]], C = [[0, 0], [-arm, 1]], c = (u, 0)
- rotation, load at height arm:             G = [[0, 1], [0, 0]], C = [[0, 0], [-arm, 1]], c = (rotation, 0)
- loads:                                    G = 0, C = identity, c = (H, M)
- displacement and rotation imposed:        G = identity, C = 0, c = (u, rotation)
"""

import math
from typing import NamedTuple

import numpy as np

from pysprings.core.arrays import Array, Integers
from pysprings.core.jit import jitted

MAX_ITERATIONS = 30
# Residual at rest, relative to the size of the equation (forces: to what all springs can build up).
TOLERANCE = 1e-11
# A step is halved at most this often before the path is given up.
MAX_HALVINGS = 12
# Line search: shortest damping, and the decrease of the squared residual that a step must bring.
MIN_DAMPING = 1.0 / 64.0
ARMIJO = 1e-4
# Laws of springs, see above.
ROWS, FAN = 0, 1
# Below this distance from the origin [m] a fan has the tangent of the ray u > 0.
ORIGIN = 1e-12
# Rays whose reactions make up a state: those on both sides, and their neighbours, for the slope in angle.
STENCIL = 4


class SpringArrays(NamedTuple):
    """Springs as arrays, n rows.

    law : ROWS or FAN.
    a, b : (n, 2) displacement that a row reads, and its action on (H, M).
    knots, values, slopes : (n, k) displacements [m, rad], reactions, and their slopes.
    sizes : (n,) number of knots.
    """

    law: int
    a: Array
    b: Array
    knots: Array
    values: Array
    slopes: Array
    sizes: Integers


class Drive(NamedTuple):
    """Equations g(x) = G x + C F(x) - c that drive the body, without their right side c.

    G, C : (2, 2); scale : (2,) size of each equation.
    """

    G: Array
    C: Array
    scale: Array


@jitted
def spring_row(knots, values, slopes, count, q):
    """Return the reaction and stiffness dr/dq of one odd curve at q: cubic Hermite, last slope beyond the end."""
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


@jitted
def row_values(knots, values, slopes, count, q):
    """Return the reactions (n, states) of rows at their displacements q (n, states)."""
    out = np.empty_like(q)
    for j in range(q.shape[0]):
        for i in range(q.shape[1]):
            out[j, i] = spring_row(knots[j], values[j], slopes[j], count[j], q[j, i])[0]
    return out


@jitted
def reactions(springs, u, rotation, F, K):
    """Write the loads F (2,) = (H [N], M [N m]) and the tangent K (2, 2) of a state into the given arrays."""
    law, a, b, knots, values, slopes, count = springs
    if law == FAN:
        fan_loads(springs, u, rotation, F, K)
        return
    for i in range(2):
        F[i], K[i, 0], K[i, 1] = 0.0, 0.0, 0.0
    for j in range(count.size):
        q = a[j, 0] * u + a[j, 1] * rotation
        r, k = spring_row(knots[j], values[j], slopes[j], count[j], q)
        for i in range(2):
            F[i] += b[j, i] * r
            K[i, 0] += b[j, i] * k * a[j, 0]
            K[i, 1] += b[j, i] * k * a[j, 1]


@jitted
def fan_stencil(angles, phi, rays, signs, weights, turns):
    """Write the rays around an angle phi, their signs, weights w and dw/dphi, each (4,); return the place t in between.

    Rays are half-lines at increasing angles (n,) in (-pi/2, pi/2]; their mirror images (sign -1) fill the other
    half of the plane. Between the rays 1 and 2 (1, 2 of the stencil 0, 1, 2, 3; D the angle between them) the
    reaction per rho is, with t = (phi - phi1)/D,
        g(phi) = [sin(phi2 - phi) S1 + sin(phi - phi1) S2] / sin D + D [c1 t (1-t)^2 - c2 t^2 (1-t)].
    The first part is exact for any linear response, g = A cos(phi) + B sin(phi). c1, c2 turn its slopes at the
    rays into the mean of both sides', weighted as in a parabola through three points (they vanish for a linear
    response): g has a continuous slope and an error of third order in D. Callers pass angles with a step, [::1], as
    `fan_loads` does: views of one kind, compiled once.
    """
    n, sign = angles.size, 1.0
    while phi < angles[0]:
        phi += math.pi
        sign = -sign
    while phi >= angles[0] + math.pi:
        phi -= math.pi
        sign = -sign
    low = 0
    while low < n - 1 and phi >= angles[low + 1]:
        low += 1
    at = np.empty(STENCIL)
    for k in range(STENCIL):
        place = low - 1 + k
        rays[k] = place % n
        lap = place // n
        at[k] = angles[rays[k]] + lap * math.pi
        signs[k] = sign if lap % 2 == 0 else -sign
    d0, d, d2 = at[1] - at[0], at[2] - at[1], at[3] - at[2]
    t = (phi - at[1]) / d
    weights[:], turns[:] = 0.0, 0.0
    weights[1], weights[2] = math.sin(at[2] - phi) / math.sin(d), math.sin(phi - at[1]) / math.sin(d)
    turns[1], turns[2] = -math.cos(at[2] - phi) / math.sin(d), math.cos(phi - at[1]) / math.sin(d)
    bump1, bump2 = d * t * (1.0 - t) ** 2, -d * t * t * (1.0 - t)
    tilt1, tilt2 = (1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0)
    # c1 = share1 (slope from the left - slope from the right) at ray 1; c2 = share2 (right - left) at ray 2
    share1, share2 = d / (d0 + d), d / (d + d2)
    for k, c1, c2 in (
        (0, -1.0 / math.sin(d0), 0.0),
        (1, 1.0 / math.tan(d0) + 1.0 / math.tan(d), 1.0 / math.sin(d)),
        (2, -1.0 / math.sin(d), -1.0 / math.tan(d2) - 1.0 / math.tan(d)),
        (3, 0.0, 1.0 / math.sin(d2)),
    ):
        weights[k] += share1 * c1 * bump1 + share2 * c2 * bump2
        turns[k] += share1 * c1 * tilt1 + share2 * c2 * tilt2
    return t


@jitted
def fan_loads(springs, u, rotation, F, K):
    """Write the loads F (2,) and the tangent K (2, 2) of a state on a fan of rays into the given arrays."""
    _, a, _, knots, values, slopes, count = springs
    length = a[0, 1]
    v = rotation * length
    rho = math.hypot(u, v)
    cosine, sine = (u / rho, v / rho) if rho > ORIGIN else (1.0, 0.0)
    rays, signs = np.empty(STENCIL, np.int64), np.empty(STENCIL)
    weights, turns = np.empty(STENCIL), np.empty(STENCIL)
    fan_stencil(a[::2, 0], math.atan2(sine, cosine), rays, signs, weights, turns)
    for i in range(2):
        force, along, across = 0.0, 0.0, 0.0
        for k in range(STENCIL):
            j = 2 * rays[k] + i
            r, slope = spring_row(knots[j], values[j], slopes[j], count[j], rho)
            force += signs[k] * weights[k] * r
            along += signs[k] * weights[k] * slope
            across += signs[k] * turns[k] * (r / rho if rho > ORIGIN else slope)
        F[i] = force
        K[i, 0] = along * cosine - across * sine
        K[i, 1] = (along * sine + across * cosine) * length


@jitted
def fan_rows(angles, knots, values, slopes, count, even, rho, phi):
    """Return all reactions (rows, states) of a fan.

    knots (rays, k), values and slopes (rows, rays, k); rho [m] and phi [rad] by state. Rows that keep their sign in
    the mirror image of a motion (`even`) are interpolated linearly in angle.
    """
    out = np.zeros((even.size, rho.size))
    rays, signs = np.empty(STENCIL, np.int64), np.empty(STENCIL)
    weights, turns = np.empty(STENCIL), np.empty(STENCIL)
    for i in range(rho.size):
        t = fan_stencil(angles[::1], phi[i], rays, signs, weights, turns)
        for k in range(STENCIL):
            mean = (0.0, 1.0 - t, t, 0.0)[k]
            ray = rays[k]
            for j in range(even.size):
                factor = mean if even[j] else signs[k] * weights[k]
                if factor != 0.0:
                    out[j, i] += factor * spring_row(knots[ray], values[j, ray], slopes[j, ray], count[ray], rho[i])[0]
    return out


@jitted
def fan_places(angles, phi):
    """Return the place of each angle phi [rad] in its sector (states, 3): ray before, ray behind, share."""
    places = np.empty((phi.size, 3))
    rays, signs = np.empty(STENCIL, np.int64), np.empty(STENCIL)
    weights, turns = np.empty(STENCIL), np.empty(STENCIL)
    for i in range(phi.size):
        places[i, 2] = fan_stencil(angles[::1], phi[i], rays, signs, weights, turns)
        places[i, 0], places[i, 1] = rays[1], rays[2]
    return places


@jitted
def _merit(drive, F, x0, x1, c0, c1):
    """Return the residual of both equations over their sizes, and the largest of them."""
    G, C, scale = drive
    g0 = (G[0, 0] * x0 + G[0, 1] * x1 + C[0, 0] * F[0] + C[0, 1] * F[1] - c0) / scale[0]
    g1 = (G[1, 0] * x0 + G[1, 1] * x1 + C[1, 0] * F[0] + C[1, 1] * F[1] - c1) / scale[1]
    return g0, g1, max(abs(g0), abs(g1))


@jitted
def _newton(springs, drive, c0, c1, x, F, K):
    """Solve g(x) = 0 from x by Newton with line search; answer in x; return iterations, -1 on failure."""
    G, C, scale = drive
    x0, x1 = x[0], x[1]
    reactions(springs, x0, x1, F, K)
    g0, g1, size = _merit(drive, F, x0, x1, c0, c1)
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
            reactions(springs, y0, y1, F, K)
            g0, g1, size = _merit(drive, F, y0, y1, c0, c1)
            if size <= TOLERANCE or g0 * g0 + g1 * g1 <= (1.0 - 2.0 * ARMIJO * damping) * before:
                break
            damping *= 0.5
            if damping < MIN_DAMPING:
                return -1
        x0, x1 = y0, y1
    return -1


@jitted
def tangents(springs, states, out):
    """Write the tangents (n, 2, 2) of states (n, 2) = (u, rotation)."""
    F = np.zeros(2)
    for i in range(states.shape[0]):
        reactions(springs, states[i, 0], states[i, 1], F, out[i])


@jitted
def follow(springs, drive, start, targets, states, loads):
    """Follow the equilibrium from state `start` (where c is the first target) through all targets c (n, 2).

    Writes states (n, 2) = (u, rotation) and loads (n, 2) = (H, M). Between targets a failed step is halved; where that
    does not help, the last state found stands at the target that was not reached.

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
            trial[0], trial[1] = x[0], x[1]
            if _newton(springs, drive, c0, c1, trial, F, K) < 0:
                halvings += 1
                width *= 0.5
                if halvings > MAX_HALVINGS:
                    states[n, 0], states[n, 1] = x[0], x[1]
                    reactions(springs, x[0], x[1], loads[n], K)
                    return n, at0, at1
            else:
                x[0], x[1], done, at0, at1 = trial[0], trial[1], aim, c0, c1
        states[n, 0], states[n, 1] = x[0], x[1]
        reactions(springs, x[0], x[1], loads[n], K)
    return targets.shape[0], at0, at1


@jitted
def follow_ways(springs, G, C, scale, starts, aims, states, loads, reached):
    """Follow n ways with equations of their own from starts (n, 2) through aims (n, k, 2).

    G, C (n, 2, 2) and scale (n, 2) are those of each way (`Drive`). Writes states and loads (n, k, 2), and how many
    aims were reached (n,), as `follow` does for each.
    """
    for i in range(starts.shape[0]):
        drive = Drive(G[i], C[i], scale[i])
        reached[i] = follow(springs, drive, starts[i], aims[i], states[i], loads[i])[0]


@jitted
def solve_cases(springs, drive, targets, states, loads, reached):
    """Solve independent cases c (n, 2), each from the origin; write their states and loads (n, 2), reached 1 or 0.

    A case without equilibrium holds the last state that was found on the straight way to it.
    """
    start, way = np.zeros(2), np.zeros((2, 2))
    x, F = np.zeros((2, 2)), np.zeros((2, 2))
    for i in range(targets.shape[0]):
        way[1] = targets[i]
        n, _, _ = follow(springs, drive, start, way, x, F)
        states[i], loads[i], reached[i] = x[1], F[1], n - 1
