# SPDX-License-Identifier: MIT
"""Elements with a memory, in parallel: what each carries along a motion, and their tangent (jitted, `core.jit`).

Motion q = (u, rotation*L) [m], loads F = (H, M/L) [N], L the skirt length; F is the sum of what elements carry. An
element keeps three numbers s. Its parameters are one row:

    kind, g11, g12, g22, b11, b12, b22, d, a, h

Plastic elements (kind 0) split the motion into an elastic and a plastic part, q = e + x, and carry

    f = B e,   |e|_G = sqrt(e.G e) <= r(p) = d (1 + a p/(p + h)),   p = integral of |dx|_G

with a radial return: the plastic motion goes along e. Their state is s = (e1, e2, p). B [N/m] is symmetric and
positive: the elastic energy is e.B e/2, the dissipation of a plastic motion dx = e c is c e.B e >= 0, so that no closed
way gives work. a = 0 is perfect plasticity, a > 0 isotropic hardening that saturates at d (1 + a).

Gap elements (kind 1) are a plate between two walls that yield at the motion d: along n = (b11, b12), x = n.q, with the
stiffness b22,

    f = n b22 [min(<x + c - s1>, d) - min(<s2 + c - x>, d)],

and a wall that yields is left behind: s1 >= x + c - d, s2 <= x - c + d. At rest both walls press on the plate by
c = g11 <= d: the soil is under pressure before the caisson moves, and the gap opens only beyond. The energy that both
walls store at rest, b22 c^2, is no more than what they dissipate before they have lost it, since they yield at d >= c:
no closed way from rest gives work. The state is s = (s1, s2, way the walls have come).

Reversible elements (kind 2) are nonlinear elastic, with B in proportion to G,

    f = B e,   e = q min(1, d/|q|_G):

the gradient of a convex function of q, without work in a closed way. They keep nothing, their numbers s are 0.

Frictional elements (kind 3) are a plate between the walls of a gap element that do not press at rest, N1 and N2 [m]
what is pressed of them. Along t = (g11, g12) the plate is held by friction (Coulomb) with the coefficient g22:

    f = b22 [n (N1 - N2) + t T],   T = e + t.dq, no more than g22 (N1 + N2) to both sides.

The walls store b22 (N1^2 + N2^2)/2, the friction b22 T^2/2; what slips or is lost with the pressure dissipates: no
closed way gives work. While the plate slips the tangent has no symmetry, and can be negative in some direction, as that
of any contact with friction. The state is s = (s1, s2, T).
"""

import math

import numpy as np

from pysprings.core.jit import jitted

PLASTIC, GAP, REVERSIBLE, FRICTIONAL = 0, 1, 2, 3
PLATES = (GAP, FRICTIONAL)  # between two walls
COLUMNS = 10  # parameters of an element
STATES = 3  # numbers that an element keeps
MAX_ITERATIONS = 40
TOLERANCE = 1e-9  # residual at rest, relative to the size of the equation
SHORTEST = 1e-4  # share of the way to a target below which no step is halved again
FREE = 3  # iterations that are taken whole: the first tangent is that of elements at rest, stiffer than what follows
MIN_DAMPING = 1.0 / 256.0
ARMIJO = 1e-4
# Where loads jump to the next equilibrium: most steps, largest motion over that of a step, drag over the stiffness, and
# most jumps on the way to one target: elements that jump with every small part of it carry no more
MOST_CREPT, FARTHEST, DRAG, MOST_JUMPS = 400, 10.0, 0.5, 1000


@jitted
def _plastic(row, state, d0, d1):
    """Advance a plastic element by a motion (d0, d1) [m]; return f1, f2 and its tangent t11, t12, t21, t22."""
    g11, g12, g22, b11, b12, b22, d, a, h = row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9]
    e0, e1, p = state[0] + d0, state[1] + d1, state[2]
    gauge = math.sqrt(e0 * (g11 * e0 + g12 * e1) + e1 * (g12 * e0 + g22 * e1))
    radius = d * (1.0 + a * p / (p + h)) if a != 0.0 else d
    share, slope = 1.0, 0.0
    yields = gauge > radius
    if yields:
        if a != 0.0:
            over = gauge + p - d
            c = over - h - a * d
            p = 0.5 * (c + math.sqrt(c * c + 4.0 * over * h))
            hardening = a * d * h / ((p + h) * (p + h))
            slope = hardening / (1.0 + hardening)
            share = (gauge + state[2] - p) / gauge
        else:
            p, share = p + gauge - d, d / gauge
    # d(share e)/dq = share I + e (slope - share) m^T / gauge
    t00, t01, t10, t11 = share, 0.0, 0.0, share
    if yields:
        factor = (slope - share) / (gauge * gauge)
        m0, m1 = factor * (g11 * e0 + g12 * e1), factor * (g12 * e0 + g22 * e1)
        t00, t01, t10, t11 = share + e0 * m0, e0 * m1, e1 * m0, share + e1 * m1
    e0, e1 = share * e0, share * e1
    state[0], state[1], state[2] = e0, e1, p
    return (
        b11 * e0 + b12 * e1, b12 * e0 + b22 * e1,
        b11 * t00 + b12 * t10, b11 * t01 + b12 * t11, b12 * t00 + b22 * t10, b12 * t01 + b22 * t11,
    )  # fmt: skip


@jitted
def _pressed(x, s, d):
    """Press a plate at x [m] against a wall at s [m] that yields at d; return what is pressed, its slope, the wall."""
    over = x - s
    if over > d:
        return d, 0.0, x - d
    if over > 0.0:
        return over, 1.0, s
    return 0.0, 0.0, s


@jitted
def _gap(row, state, x):
    """Advance a gap element to x [m] along its direction; return f and tangent as `_plastic`."""
    pressed, n0, n1, size, d = row[1], row[4], row[5], row[6], row[7]
    first, slope1, ahead = _pressed(x + pressed, state[0], d)
    second, slope2, behind = _pressed(pressed - x, -state[1], d)
    state[2] += ahead - state[0] + behind + state[1]
    state[0], state[1] = ahead, -behind
    force, stiffness = size * (first - second), size * (slope1 + slope2)
    cross = n0 * n1 * stiffness
    return n0 * force, n1 * force, n0 * n0 * stiffness, cross, cross, n1 * n1 * stiffness


@jitted
def _frictional(row, state, x, along):
    """Advance a frictional element to x [m] along n, by `along` [m] along t; return f and tangent as `_plastic`."""
    t0, t1, friction, n0, n1, size, d = row[1], row[2], row[3], row[4], row[5], row[6], row[7]
    first, slope1, state[0] = _pressed(x, state[0], d)
    second, slope2, behind = _pressed(-x, -state[1], d)
    state[1] = -behind
    held, most = state[2] + along, friction * (first + second)
    m0, m1 = t0, t1  # dT/dq
    if abs(held) > most:
        sign = 1.0 if held > 0.0 else -1.0
        held, slip = sign * most, sign * friction * (slope1 - slope2)
        m0, m1 = slip * n0, slip * n1
    state[2] = held
    force, stiffness = first - second, slope1 + slope2
    return (
        size * (n0 * force + t0 * held), size * (n1 * force + t1 * held),
        size * (n0 * n0 * stiffness + t0 * m0), size * (n0 * n1 * stiffness + t0 * m1),
        size * (n0 * n1 * stiffness + t1 * m0), size * (n1 * n1 * stiffness + t1 * m1),
    )  # fmt: skip


@jitted
def _reversible(row, x0, x1):
    """Return f1, f2 and tangent, as `_plastic`, of a reversible element at a motion (x0, x1) [m], and its share e/q."""
    g11, g12, g22, b11, b12, b22, d = row[1], row[2], row[3], row[4], row[5], row[6], row[7]
    gauge = math.sqrt(x0 * (g11 * x0 + g12 * x1) + x1 * (g12 * x0 + g22 * x1))
    f0, f1 = b11 * x0 + b12 * x1, b12 * x0 + b22 * x1
    if gauge <= d:
        return f0, f1, b11, b12, b12, b22, 1.0
    share = d / gauge
    m0, m1 = (g11 * x0 + g12 * x1) / (gauge * gauge), (g12 * x0 + g22 * x1) / (gauge * gauge)
    return (
        share * f0, share * f1,
        share * (b11 - f0 * m0), share * (b12 - f0 * m1), share * (b12 - f1 * m0), share * (b22 - f1 * m1), share,
    )  # fmt: skip


@jitted
def advance(rows, q0, q1, states, F, K):
    """Advance all elements from a motion q0 (2,) to q1 (2,) [m].

    rows (n, COLUMNS); writes states (n, STATES), loads F (2,) [N] and tangent K (2, 2) [N/m].
    """
    f0, f1, k00, k01, k10, k11 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    d0, d1 = q1[0] - q0[0], q1[1] - q0[1]
    for k in range(rows.shape[0]):
        if rows[k, 0] == GAP:
            one = _gap(rows[k], states[k], rows[k, 4] * q1[0] + rows[k, 5] * q1[1])
        elif rows[k, 0] == REVERSIBLE:
            one = _reversible(rows[k], q1[0], q1[1])[:6]
        elif rows[k, 0] == FRICTIONAL:
            x, along = rows[k, 4] * q1[0] + rows[k, 5] * q1[1], rows[k, 1] * d0 + rows[k, 2] * d1
            one = _frictional(rows[k], states[k], x, along)
        else:
            one = _plastic(rows[k], states[k], d0, d1)
        f0, f1 = f0 + one[0], f1 + one[1]
        k00, k01, k10, k11 = k00 + one[2], k01 + one[3], k10 + one[4], k11 + one[5]
    F[0], F[1] = f0, f1
    K[0, 0], K[0, 1], K[1, 0], K[1, 1] = k00, k01, k10, k11


@jitted
def relax(rows, states, q, kept):
    """Take from elements at a motion q (2,) [m] what they carry, but for a share `kept`; writes states.

    Two walls that press on a plate keep what both press. Reversible elements keep all.
    """
    if kept >= 1.0:
        return
    for k in range(rows.shape[0]):
        if rows[k, 0] == PLASTIC:
            states[k, 0] *= kept
            states[k, 1] *= kept
        elif rows[k, 0] == GAP or rows[k, 0] == FRICTIONAL:
            x = rows[k, 4] * q[0] + rows[k, 5] * q[1]
            pressed = rows[k, 1] if rows[k, 0] == GAP else 0.0
            first, second = x + pressed - states[k, 0], states[k, 1] - x + pressed
            both = 0.5 * (first + second) if first > 0.0 and second > 0.0 else 0.0
            if first > 0.0:
                states[k, 0] = x + pressed - (both + kept * (first - both))
            if second > 0.0:
                states[k, 1] = x - pressed + (both + kept * (second - both))
            if rows[k, 0] == FRICTIONAL:
                states[k, 2] *= kept


@jitted
def histories(rows, ways, largest, elastic, paths):
    """Write the elastic motion (n, elements, 2) [m] and the way (n, elements) [m] of elements along a way (n, 2).

    The way starts at the origin; steps longer than `largest` [m] are divided. The elastic motion of gap and
    frictional elements is their force over their stiffness; their way is that of the walls. Reversible elements have
    none.
    """
    state, one = np.empty(STATES), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for k in range(rows.shape[0]):
        state[:] = 0.0
        x0, x1 = 0.0, 0.0
        if rows[k, 0] == REVERSIBLE:
            for i in range(ways.shape[0]):
                share = _reversible(rows[k], ways[i, 0], ways[i, 1])[6]
                elastic[i, k, 0], elastic[i, k, 1], paths[i, k] = share * ways[i, 0], share * ways[i, 1], 0.0
            continue
        for i in range(ways.shape[0]):
            d0, d1 = ways[i, 0] - x0, ways[i, 1] - x1
            parts = max(1, math.ceil(math.hypot(d0, d1) / largest))
            for j in range(parts):
                share = (j + 1.0) / parts
                x = rows[k, 4] * (x0 + share * d0) + rows[k, 5] * (x1 + share * d1)
                if rows[k, 0] == GAP:
                    one = _gap(rows[k], state, x)
                elif rows[k, 0] == FRICTIONAL:
                    one = _frictional(rows[k], state, x, (rows[k, 1] * d0 + rows[k, 2] * d1) / parts)
                else:
                    one = _plastic(rows[k], state, d0 / parts, d1 / parts)
            x0, x1 = ways[i, 0], ways[i, 1]
            paths[i, k] = state[0] - state[1] if rows[k, 0] == FRICTIONAL else state[2]
            if rows[k, 0] == GAP or rows[k, 0] == FRICTIONAL:
                elastic[i, k, 0], elastic[i, k, 1] = one[0] / rows[k, 6], one[1] / rows[k, 6]
            else:
                elastic[i, k, 0], elastic[i, k, 1] = state[0], state[1]


@jitted
def tangents(rows, ways, largest, loads, out):
    """Write the loads (n, 2) [N] and tangents (n, 2, 2) [N/m] along a way (n, 2) [m] from the origin."""
    states, q0, q1 = np.zeros((rows.shape[0], STATES)), np.zeros(2), np.zeros(2)
    F, K = np.zeros(2), np.zeros((2, 2))
    for i in range(ways.shape[0]):
        start0, start1 = q0[0], q0[1]
        d0, d1 = ways[i, 0] - start0, ways[i, 1] - start1
        parts = max(1, math.ceil(math.hypot(d0, d1) / largest))
        for j in range(parts):
            share = (j + 1.0) / parts
            q1[0], q1[1] = start0 + share * d0, start1 + share * d1
            advance(rows, q0, q1, states, F, K)
            q0[0], q0[1] = q1[0], q1[1]
        loads[i], out[i] = F, K


@jitted
def _residual(drive, q, F, c, g):
    """Write the residual of both equations over their sizes, g (2,); return the largest of them."""
    G, C, scale = drive
    for i in range(2):
        g[i] = (G[i, 0] * q[0] + G[i, 1] * q[1] + C[i, 0] * F[0] + C[i, 1] * F[1] - c[i]) / scale[i]
    return max(abs(g[0]), abs(g[1]))


@jitted
def _dragged(rows, drag, q0, q, trial, F, K):
    """Advance all elements from q0 to q as `advance`, and add a drag [N/m] against the motion."""
    advance(rows, q0, q, trial, F, K)
    for i in range(2):
        F[i] += drag * (q[i] - q0[i])
        K[i, i] += drag


@jitted
def _newton(rows, drive, drag, q0, c, q, states, trial, F, K, g):
    """Solve G q + C F = c from a committed state at q0, starting at q; answer in q, trial, F, K; return success.

    F holds the drag [N/m] times the motion from q0, too.
    """
    G, C, scale = drive
    trial[:, :] = states
    _dragged(rows, drag, q0, q, trial, F, K)
    size = _residual(drive, q, F, c, g)
    J, guess = np.empty((2, 2)), np.empty(2)
    for iteration in range(MAX_ITERATIONS):
        if size <= TOLERANCE:
            return True
        for i in range(2):
            for j in range(2):
                J[i, j] = (G[i, j] + C[i, 0] * K[0, j] + C[i, 1] * K[1, j]) / scale[i]
        determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        if determinant == 0.0 or not math.isfinite(determinant):
            return False
        d0 = -(J[1, 1] * g[0] - J[0, 1] * g[1]) / determinant
        d1 = -(J[0, 0] * g[1] - J[1, 0] * g[0]) / determinant
        before, damping = g[0] * g[0] + g[1] * g[1], 1.0
        while True:
            guess[0], guess[1] = q[0] + damping * d0, q[1] + damping * d1
            trial[:, :] = states
            _dragged(rows, drag, q0, guess, trial, F, K)
            size = _residual(drive, guess, F, c, g)
            if iteration < FREE or size <= TOLERANCE:
                break
            if g[0] * g[0] + g[1] * g[1] <= (1.0 - 2.0 * ARMIJO * damping) * before:
                break
            damping *= 0.5
            if damping < MIN_DAMPING:
                return False
        q[0], q[1] = guess[0], guess[1]
    return size <= TOLERANCE


@jitted
def _creep(rows, drive, largest, c, q, states, trial, F, K, g):
    """Creep from a committed state at q to the next equilibrium under c; return success. Writes q, states, F.

    Elements whose force is not along their gauge, or with friction, can have no equilibrium beside the last one. Steps
    against a drag lead to the next one, if it is within some steps of the largest size; the drag goes down as they are
    found.
    """
    start0, start1, q0 = q[0], q[1], q.copy()
    trial[:, :] = states
    advance(rows, q0, q0, trial, F, K)
    drag = DRAG * (abs(K[0, 0]) + abs(K[1, 1]))
    for _ in range(MOST_CREPT):
        found = _newton(rows, drive, drag, q0, c, q, states, trial, F, K, g)
        if not found:
            drag *= 4.0
            q[:] = q0
            continue
        states[:, :] = trial
        for i in range(2):
            F[i] -= drag * (q[i] - q0[i])
        q0[:] = q
        if _residual(drive, q, F, c, g) <= TOLERANCE:
            return True
        if math.hypot(q[0] - start0, q[1] - start1) > FARTHEST * largest:
            return False
        drag *= 0.5
    return False


@jitted
def follow(rows, drive, largest, start, states, targets, motions, loads):
    """Follow a sequence of targets c (n, 2) from a committed state (motion `start` (2,), where c is `targets[0]`).

    drive holds G, C (2, 2) and scale (2,) of the equations G q + C F = c. A step longer than `largest` [m], or one that
    does not converge, is halved, down to SHORTEST; where none converges the elements creep to the next equilibrium.
    Writes motions and loads (n, 2), and the last state found into `states`.

    Returns
    -------
    tuple of int, float, float
        Number of targets reached, the first one included; c of the last step that converged.
    """
    q0, q, last = start.copy(), start.copy(), targets[0].copy()
    trial = states.copy()
    F, K, c, g = np.zeros(2), np.zeros((2, 2)), np.zeros(2), np.zeros(2)
    for n in range(targets.shape[0]):
        done, width, jumps = 0.0, 1.0, 0
        from0, from1 = last[0], last[1]
        while done < 1.0:
            aim = min(1.0, done + width)
            c[0] = from0 + aim * (targets[n, 0] - from0)
            c[1] = from1 + aim * (targets[n, 1] - from1)
            q[0], q[1] = q0[0], q0[1]
            found = _newton(rows, drive, 0.0, q0, c, q, states, trial, F, K, g)
            if found and math.hypot(q[0] - q0[0], q[1] - q0[1]) > largest and width > SHORTEST:
                width *= 0.5
                continue
            if not found:
                if width > SHORTEST:
                    width *= 0.5
                    continue
                q[0], q[1] = q0[0], q0[1]
                jumps += 1
                if jumps > MOST_JUMPS or not _creep(rows, drive, largest, c, q, states, trial, F, K, g):
                    return n, last[0], last[1]
                width = 1.0
            else:
                states[:, :] = trial
            q0[0], q0[1] = q[0], q[1]
            done, last[0], last[1] = aim, c[0], c[1]
        motions[n], loads[n] = q0, F
    return targets.shape[0], last[0], last[1]
