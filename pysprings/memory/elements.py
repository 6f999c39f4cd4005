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

Elements in space move with q = (u_x, rot_y L, u_y, -rot_x L, rot_z R), R the radius at the wall, and loads
F = (H_x, M_y/L, H_y, -M_x/L, T/R). Their rows go on with (px, py, pz): an element with a direction takes the motion

    a = px (q1, q2) + py (q3, q4) + pz (q5, 0)

as those above take theirs, and its force f goes back the same way: px = cos, py = sin of the azimuth of its plane, or
pz = 1 for torsion. Elements in one plane are those with px = 1. Round elements, (0, 0, 0), have one gauge of both
planes,

    |e|_G^2 = (e1, e2).G (e1, e2) + (e3, e4).G (e3, e4),   f = (B (e1, e2), B (e3, e4)),

and the state s = (e1, e2, p, e3, e4): the motion in any one plane is that of the element in that plane.
"""

import math

import numpy as np

from pysprings.core.jit import jitted

PLASTIC, GAP, REVERSIBLE, FRICTIONAL = 0, 1, 2, 3
PLATES = (GAP, FRICTIONAL)  # between two walls
COLUMNS = 10  # parameters of an element in one plane
STATES = 3  # numbers that it keeps
SPACE_COLUMNS, SPACE_STATES, SPACE = 13, 5, 5  # parameters and numbers of one in space, motions
MAX_ITERATIONS = 40
TOLERANCE = 1e-9  # residual at rest, relative to the size of the equation
SHORTEST = 1e-4  # share of the way to a target below which no step is halved again
YIELDED = 8  # power of what an element carries over its limit, with which a V that changes takes a part of it
FREE = 3  # iterations that are taken whole: the first tangent is that of elements at rest, stiffer than what follows
MIN_DAMPING = 1.0 / 256.0
ARMIJO = 1e-4
# Where loads jump to the next equilibrium: most steps, largest motion over that of a step, drag over the stiffness, and
# most jumps on the way to one target: elements that jump with every small part of it carry no more
MOST_CREPT, FARTHEST, DRAG, MOST_JUMPS = 400, 10.0, 0.5, 1000
# Largest step of a motion over the reach; and how many reaches from rest elements are followed on their last slope
SUBSTEP, OUTSIDE = 0.01, 20.0


@jitted
def _returned(row, gauge, p):
    """Return a plastic element to its gauge: share of e that is left, its slope, p, and whether it yields."""
    d, a, h = row[7], row[8], row[9]
    radius = d * (1.0 + a * p / (p + h)) if a != 0.0 else d
    if not gauge > radius:
        return 1.0, 0.0, p, False
    if a == 0.0:
        return d / gauge, 0.0, p + gauge - d, True
    over = gauge + p - d
    c = over - h - a * d
    grown = 0.5 * (c + math.sqrt(c * c + 4.0 * over * h))
    hardening = a * d * h / ((grown + h) * (grown + h))
    return (gauge + p - grown) / gauge, hardening / (1.0 + hardening), grown, True


@jitted
def _plastic(row, state, d0, d1):
    """Advance a plastic element by a motion (d0, d1) [m]; return f1, f2 and its tangent t11, t12, t21, t22."""
    g11, g12, g22, b11, b12, b22 = row[1], row[2], row[3], row[4], row[5], row[6]
    e0, e1 = state[0] + d0, state[1] + d1
    gauge = math.sqrt(e0 * (g11 * e0 + g12 * e1) + e1 * (g12 * e0 + g22 * e1))
    share, slope, p, yields = _returned(row, gauge, state[2])
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
def _one(row, state, x0, x1, d0, d1):
    """Advance an element in one plane by (d0, d1) to (x0, x1) [m]; return f and tangent as `_plastic`."""
    if row[0] == GAP:
        return _gap(row, state, row[4] * x0 + row[5] * x1)
    if row[0] == REVERSIBLE:
        return _reversible(row, x0, x1)[:6]
    if row[0] == FRICTIONAL:
        return _frictional(row, state, row[4] * x0 + row[5] * x1, row[1] * d0 + row[2] * d1)
    return _plastic(row, state, d0, d1)


@jitted
def _rounded(row, state, q0, q1):
    """Advance a round element from a motion q0 to q1 [m]; return its share of e, and (slope - share)/gauge^2.

    state (5,) holds the trial motion e, not yet times its share, and p at the end.
    """
    g11, g12, g22 = row[1], row[2], row[3]
    if row[0] == REVERSIBLE:
        state[0], state[1], state[3], state[4] = q1[0], q1[1], q1[2], q1[3]
    else:
        state[0], state[1] = state[0] + (q1[0] - q0[0]), state[1] + (q1[1] - q0[1])
        state[3], state[4] = state[3] + (q1[2] - q0[2]), state[4] + (q1[3] - q0[3])
    x = state[0] * (g11 * state[0] + g12 * state[1]) + state[1] * (g12 * state[0] + g22 * state[1])
    y = state[3] * (g11 * state[3] + g12 * state[4]) + state[4] * (g12 * state[3] + g22 * state[4])
    gauge = math.sqrt(x + y)
    if row[0] == REVERSIBLE:
        share = row[7] / gauge if gauge > row[7] else 1.0
        return share, -share / (gauge * gauge) if gauge > row[7] else 0.0
    share, slope, state[2], yields = _returned(row, gauge, state[2])
    return share, (slope - share) / (gauge * gauge) if yields else 0.0


@jitted
def _round(row, state, q0, q1, F, K):
    """Advance a round element from q0 to q1 (5,) [m]; add its loads and tangent to F (5,), K (5, 5)."""
    g11, g12, g22, b11, b12, b22 = row[1], row[2], row[3], row[4], row[5], row[6]
    share, factor = _rounded(row, state, q0, q1)
    for i in range(2):
        e0, e1 = state[3 * i], state[3 * i + 1]
        f0, f1 = b11 * e0 + b12 * e1, b12 * e0 + b22 * e1
        F[2 * i] += share * f0
        F[2 * i + 1] += share * f1
        K[2 * i, 2 * i] += share * b11
        K[2 * i, 2 * i + 1] += share * b12
        K[2 * i + 1, 2 * i] += share * b12
        K[2 * i + 1, 2 * i + 1] += share * b22
        if factor != 0.0:
            for j in range(2):
                c0, c1 = state[3 * j], state[3 * j + 1]
                m0, m1 = factor * (g11 * c0 + g12 * c1), factor * (g12 * c0 + g22 * c1)
                K[2 * i, 2 * j] += f0 * m0
                K[2 * i, 2 * j + 1] += f0 * m1
                K[2 * i + 1, 2 * j] += f1 * m0
                K[2 * i + 1, 2 * j + 1] += f1 * m1
    if row[0] == REVERSIBLE:
        state[:] = 0.0
        return
    for i in (0, 1, 3, 4):
        state[i] *= share


@jitted
def _directed(row, state, q0, q1, F, K):
    """Advance an element with a direction from q0 to q1 (5,) [m]; add its loads and tangent to F (5,), K (5, 5)."""
    px, py, pz = row[10], row[11], row[12]
    x0, x1 = px * q1[0] + py * q1[2] + pz * q1[4], px * q1[1] + py * q1[3]
    start0, start1 = px * q0[0] + py * q0[2] + pz * q0[4], px * q0[1] + py * q0[3]
    f0, f1, k00, k01, k10, k11 = _one(row, state, x0, x1, x0 - start0, x1 - start1)
    F[4] += pz * f0
    K[4, 4] += pz * pz * k00
    for i in range(2):
        pi = row[10 + i]
        F[2 * i] += pi * f0
        F[2 * i + 1] += pi * f1
        K[4, 2 * i] += pz * pi * k00
        K[4, 2 * i + 1] += pz * pi * k01
        K[2 * i, 4] += pz * pi * k00
        K[2 * i + 1, 4] += pz * pi * k10
        for j in range(2):
            pp = pi * row[10 + j]
            K[2 * i, 2 * j] += pp * k00
            K[2 * i, 2 * j + 1] += pp * k01
            K[2 * i + 1, 2 * j] += pp * k10
            K[2 * i + 1, 2 * j + 1] += pp * k11


@jitted
def advance(rows, q0, q1, states, F, K):
    """Advance all elements from a motion q0 to q1 [m], (2,) in one plane, (5,) in space.

    rows (n, COLUMNS or SPACE_COLUMNS); writes states (n, STATES or SPACE_STATES), loads F [N] and tangent K [N/m].
    """
    if q1.shape[0] == SPACE:
        F[:] = 0.0
        K[:, :] = 0.0
        for k in range(rows.shape[0]):
            if rows[k, 10] == 0.0 and rows[k, 11] == 0.0 and rows[k, 12] == 0.0:
                _round(rows[k], states[k], q0, q1, F, K)
            else:
                _directed(rows[k], states[k], q0, q1, F, K)
        return
    f0, f1, k00, k01, k10, k11 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    d0, d1 = q1[0] - q0[0], q1[1] - q0[1]
    for k in range(rows.shape[0]):  # written out: calls of `_one` take 1.5 times as long
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
def relax(rows, states, q, change):
    """Take from elements at a motion q (2,) [m] a part of what they carry; writes states.

    They keep exp(-change x^YIELDED) of it, x what they carry over their limit: those that yield lose, others nearly
    nothing. Two walls that press on a plate keep what both press. Reversible elements keep all.
    """
    for k in range(rows.shape[0]):
        row, state, d = rows[k], states[k], rows[k, 7]
        if row[0] == PLASTIC:
            e0, e1, p = state[0], state[1], state[2]
            gauge = math.sqrt(e0 * (row[1] * e0 + row[2] * e1) + e1 * (row[2] * e0 + row[3] * e1))
            radius = d * (1.0 + row[8] * p / (p + row[9])) if row[8] != 0.0 else d
            share = _kept(change, gauge, radius)
            state[0], state[1] = share * e0, share * e1
        elif row[0] == GAP or row[0] == FRICTIONAL:
            x = row[4] * q[0] + row[5] * q[1]
            pressed = row[1] if row[0] == GAP else 0.0
            first, second = max(x + pressed - state[0], 0.0), max(state[1] - x + pressed, 0.0)
            if row[0] == FRICTIONAL:
                state[2] *= _kept(change, abs(state[2]), row[3] * (first + second))
            both = 0.5 * (first + second) if first > 0.0 and second > 0.0 else 0.0
            share = _kept(change, max(first, second), d)
            if first > 0.0:
                state[0] = x + pressed - both - share * (first - both)
            if second > 0.0:
                state[1] = x - pressed + both + share * (second - both)


@jitted
def _kept(change, carried, limit):
    """Return the share that is kept of what an element carries, at most its limit."""
    return math.exp(-change * min(1.0, carried / limit) ** YIELDED) if limit > 0.0 else 1.0


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
                if rows[k, 0] == FRICTIONAL:
                    x = rows[k, 4] * (x0 + share * d0) + rows[k, 5] * (x1 + share * d1)
                    one = _frictional(rows[k], state, x, (rows[k, 1] * d0 + rows[k, 2] * d1) / parts)
                else:
                    one = _one(rows[k], state, x0 + share * d0, x1 + share * d1, d0 / parts, d1 / parts)
            x0, x1 = ways[i, 0], ways[i, 1]
            paths[i, k] = state[0] - state[1] if rows[k, 0] == FRICTIONAL else state[2]
            if rows[k, 0] == GAP or rows[k, 0] == FRICTIONAL:
                elastic[i, k, 0], elastic[i, k, 1] = one[0] / rows[k, 6], one[1] / rows[k, 6]
            else:
                elastic[i, k, 0], elastic[i, k, 1] = state[0], state[1]


@jitted
def round_histories(rows, ways, largest, elastic, paths):
    """Write elastic motions (n, elements, 4) and ways (n, elements) [m] of round elements along a way (n, 4).

    The motions are (e1, e2) of the plane of x, then of that of y; else as `histories`.
    """
    state, start, end = np.empty(SPACE_STATES), np.empty(4), np.empty(4)
    for k in range(rows.shape[0]):
        state[:] = 0.0
        start[:] = 0.0
        for i in range(ways.shape[0]):
            before = start.copy()
            way = _distance(ways[i], before)
            parts = max(1, math.ceil(way / largest)) if rows[k, 0] == PLASTIC else 1
            for j in range(parts):
                end[:] = before + (j + 1.0) / parts * (ways[i] - before)
                share = _rounded(rows[k], state, start, end)[0]
                for m in (0, 1, 3, 4):
                    state[m] *= share
                start[:] = end
            elastic[i, k, 0], elastic[i, k, 1] = state[0], state[1]
            elastic[i, k, 2], elastic[i, k, 3] = state[3], state[4]
            paths[i, k] = state[2] if rows[k, 0] == PLASTIC else 0.0


@jitted
def tangents(rows, ways, largest, loads, out):
    """Write the loads (n, m) [N] and tangents (n, m, m) [N/m] along a way (n, m) [m] from the origin, m = 2 or 5."""
    m = ways.shape[1]
    states, q0, q1 = np.zeros((rows.shape[0], m if m == SPACE else STATES)), np.zeros(m), np.zeros(m)
    F, K = np.zeros(m), np.zeros((m, m))
    for i in range(ways.shape[0]):
        start = q0.copy()
        parts = max(1, math.ceil(_distance(ways[i], start) / largest))
        for j in range(parts):
            share = (j + 1.0) / parts
            for a in range(m):
                q1[a] = start[a] + share * (ways[i, a] - start[a])
            advance(rows, q0, q1, states, F, K)
            q0[:] = q1
        loads[i], out[i] = F, K


@jitted
def _residual(drive, q, F, c, g):
    """Write the residual of all equations over their sizes, g; return the largest of them."""
    G, C, scale = drive
    worst = 0.0
    for i in range(g.shape[0]):
        left = 0.0
        for j in range(g.shape[0]):
            left += G[i, j] * q[j]
        for j in range(g.shape[0]):
            left += C[i, j] * F[j]
        g[i] = (left - c[i]) / scale[i]
        worst = max(worst, abs(g[i]))
        if g[i] != g[i]:
            return math.inf
    return worst


@jitted
def _dragged(rows, drag, q0, q, trial, F, K):
    """Advance all elements from q0 to q as `advance`, and add a drag [N/m] against the motion."""
    advance(rows, q0, q, trial, F, K)
    for i in range(q.shape[0]):
        F[i] += drag * (q[i] - q0[i])
        K[i, i] += drag


@jitted
def _solved(J, g, d):
    """Write the solution d of J d = -g; return False where there is none. J is overwritten."""
    m = g.shape[0]
    if m == 2:
        determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        if determinant == 0.0 or not math.isfinite(determinant):
            return False
        d[0] = -(J[1, 1] * g[0] - J[0, 1] * g[1]) / determinant
        d[1] = -(J[0, 0] * g[1] - J[1, 0] * g[0]) / determinant
        return True
    for i in range(m):
        d[i] = -g[i]
    for k in range(m):  # Gaussian elimination with the largest pivot of the column
        top = k + int(np.argmax(np.abs(J[k:, k])))
        if J[top, k] == 0.0 or not math.isfinite(J[top, k]):
            return False
        for j in range(k, m):
            J[k, j], J[top, j] = J[top, j], J[k, j]
        d[k], d[top] = d[top], d[k]
        for i in range(k + 1, m):
            factor = J[i, k] / J[k, k]
            d[i] -= factor * d[k]
            for j in range(k, m):
                J[i, j] -= factor * J[k, j]
    for k in range(m - 1, -1, -1):
        for j in range(k + 1, m):
            d[k] -= J[k, j] * d[j]
        d[k] /= J[k, k]
    return True


@jitted
def _distance(a, b):
    """Return the distance of two motions [m]."""
    if a.shape[0] == 2:
        return math.hypot(a[0] - b[0], a[1] - b[1])
    squares = 0.0
    for i in range(a.shape[0]):
        squares += (a[i] - b[i]) * (a[i] - b[i])
    return math.sqrt(squares)


@jitted
def _squares(g):
    """Return the sum of the squares of g."""
    found = 0.0
    for i in range(g.shape[0]):
        found += g[i] * g[i]
    return found


@jitted
def _newton(rows, drive, drag, q0, c, q, states, trial, F, K, g):
    """Solve G q + C F = c from a committed state at q0, starting at q; answer in q, trial, F, K; return success.

    F holds the drag [N/m] times the motion from q0, too.
    """
    G, C, scale = drive
    m = q.shape[0]
    trial[:, :] = states
    _dragged(rows, drag, q0, q, trial, F, K)
    size = _residual(drive, q, F, c, g)
    J, guess, d = np.empty((m, m)), np.empty(m), np.empty(m)
    for iteration in range(MAX_ITERATIONS):
        if size <= TOLERANCE:
            return True
        for i in range(m):
            for j in range(m):
                left = G[i, j]
                for k in range(m):
                    left += C[i, k] * K[k, j]
                J[i, j] = left / scale[i]
        if not _solved(J, g, d):
            return False
        before, damping = _squares(g), 1.0
        while True:
            for i in range(m):
                guess[i] = q[i] + damping * d[i]
            trial[:, :] = states
            _dragged(rows, drag, q0, guess, trial, F, K)
            size = _residual(drive, guess, F, c, g)
            if iteration < FREE or size <= TOLERANCE:
                break
            if _squares(g) <= (1.0 - 2.0 * ARMIJO * damping) * before:
                break
            damping *= 0.5
            if damping < MIN_DAMPING:
                return False
        q[:] = guess
    return size <= TOLERANCE


@jitted
def _creep(rows, drive, largest, c, q, states, trial, F, K, g):
    """Creep from a committed state at q to the next equilibrium under c; return success. Writes q, states, F.

    Elements whose force is not along their gauge, or with friction, can have no equilibrium beside the last one. Steps
    against a drag lead to the next one, if it is within some steps of the largest size; the drag goes down as they are
    found.
    """
    start, q0 = q.copy(), q.copy()
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
        for i in range(q.shape[0]):
            F[i] -= drag * (q[i] - q0[i])
        q0[:] = q
        if _residual(drive, q, F, c, g) <= TOLERANCE:
            return True
        if _distance(q, start) > FARTHEST * largest:
            return False
        drag *= 0.5
    return False


@jitted
def follow(rows, drive, largest, start, states, targets, motions, loads):
    """Follow a sequence of targets c (n, m) from a committed state (motion `start` (m,), where c is `targets[0]`).

    drive holds G, C (m, m) and scale (m,) of the equations G q + C F = c; m = 2 in one plane, 5 in space. A step longer
    than `largest` [m], or one that does not converge, is halved, down to SHORTEST; where none converges the elements
    creep to the next equilibrium. It ends OUTSIDE reaches from rest. Writes motions and loads (n, m), and into `states`
    the last state found.

    Returns
    -------
    tuple of int, array
        Number of targets reached, the first one included; c (m,) of the last step that converged.
    """
    m = start.shape[0]
    q0, q, last, first, rest = start.copy(), start.copy(), targets[0].copy(), targets[0].copy(), np.zeros(m)
    trial = states.copy()
    F, K, c, g = np.zeros(m), np.zeros((m, m)), np.zeros(m), np.zeros(m)
    for n in range(targets.shape[0]):
        done, width, jumps = 0.0, 1.0, 0
        first[:] = last
        while done < 1.0:
            aim = min(1.0, done + width)
            for i in range(m):
                c[i] = first[i] + aim * (targets[n, i] - first[i])
            q[:] = q0
            found = _newton(rows, drive, 0.0, q0, c, q, states, trial, F, K, g)
            if found and _distance(q, q0) > largest and width > SHORTEST:
                width *= 0.5
                continue
            if not found:
                if width > SHORTEST:
                    width *= 0.5
                    continue
                q[:] = q0
                jumps += 1
                if jumps > MOST_JUMPS or not _creep(rows, drive, largest, c, q, states, trial, F, K, g):
                    return n, last
                width = 1.0
            else:
                states[:, :] = trial
            if _distance(q, rest) > OUTSIDE / SUBSTEP * largest:
                return n, last
            q0[:] = q
            last[:] = c
            done = aim
        motions[n], loads[n] = q0, F
    return targets.shape[0], last
