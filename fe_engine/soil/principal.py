# SPDX-License-Identifier: MIT
"""Principal values and directions of a stress, and tangents of laws that are written in them."""

from __future__ import annotations

import math

from fe_engine.compiled import lean

_SWEEPS = 20
_ZERO = 1.0e-32  # squared size of what is left beside the diagonal, over that of the stress


@lean
def principal(stress, values, directions):
    """Write principal values (3,), the largest first, and directions (3, 3), one a row, of a stress (6,).

    Jacobi rotations: directions are orthonormal to rounding where values meet, too.
    """
    a = ((stress[0], stress[3], stress[5]), (stress[3], stress[1], stress[4]), (stress[5], stress[4], stress[2]))
    m00, m11, m22, m01, m12, m20 = a[0][0], a[1][1], a[2][2], a[0][1], a[1][2], a[2][0]
    for i in range(3):
        for j in range(3):
            directions[i, j] = 1.0 if i == j else 0.0
    size = m00 * m00 + m11 * m11 + m22 * m22 + 2.0 * (m01 * m01 + m12 * m12 + m20 * m20)  # |a|^2, which rotations keep
    for _ in range(_SWEEPS):
        if m01 * m01 + m12 * m12 + m20 * m20 <= _ZERO * size:
            break
        c, s = _angle(m00, m11, m01)  # entry 01 becomes 0
        m00, m11 = _rotated(m00, m11, m01, c, s)
        m01, m20, m12 = 0.0, c * m20 - s * m12, s * m20 + c * m12
        _turn(directions, 0, 1, c, s)
        c, s = _angle(m11, m22, m12)  # entry 12
        m11, m22 = _rotated(m11, m22, m12, c, s)
        m12, m01, m20 = 0.0, c * m01 - s * m20, s * m01 + c * m20
        _turn(directions, 1, 2, c, s)
        c, s = _angle(m00, m22, m20)  # entry 20
        m00, m22 = _rotated(m00, m22, m20, c, s)
        m20, m01, m12 = 0.0, c * m01 - s * m12, s * m01 + c * m12
        _turn(directions, 0, 2, c, s)
    values[0], values[1], values[2] = m00, m11, m22
    _sort(values, directions, 0, 1)
    _sort(values, directions, 1, 2)
    _sort(values, directions, 0, 1)


@lean
def _angle(first, second, beside):
    """Return the cosine and sine of the rotation that removes the entry beside two diagonal ones."""
    if beside == 0.0:
        return 1.0, 0.0
    # cot of twice the angle; Jacobi takes the smaller root t of t^2 + 2 tau t = 1
    tau = (second - first) / (2.0 * beside)
    t = 1.0 / (abs(tau) + math.sqrt(1.0 + tau * tau))
    if tau < 0.0:
        t = -t
    c = 1.0 / math.sqrt(1.0 + t * t)
    return c, t * c


@lean
def _rotated(first, second, beside, c, s):
    """Return the diagonal entries after the rotation."""
    change = beside * s / c  # tan of the angle times the entry
    return first - change, second + change


@lean
def _turn(directions, i, j, c, s):
    for k in range(3):
        first, second = directions[i, k], directions[j, k]
        directions[i, k] = c * first - s * second
        directions[j, k] = s * first + c * second


@lean
def _sort(values, directions, i, j):
    if values[i] >= values[j]:
        return
    values[i], values[j] = values[j], values[i]
    for k in range(3):
        directions[i, k], directions[j, k] = directions[j, k], directions[i, k]


@lean
def compose(values, directions, stress):
    """Write the stress (6,) of principal values (3,) and directions (3, 3)."""
    for i in range(6):
        stress[i] = 0.0
    for a in range(3):
        x, y, z = directions[a, 0], directions[a, 1], directions[a, 2]
        v = values[a]
        stress[0] += v * x * x
        stress[1] += v * y * y
        stress[2] += v * z * z
        stress[3] += v * x * y
        stress[4] += v * y * z
        stress[5] += v * z * x


@lean
def spectral_tangent(directions, normal, shear, tangent):
    """Write the tangent (6, 6) of a law of principal values.

    ``normal`` (3, 3) is d(principal stress)/d(principal strain); shear (3,) is the stiffness between the strain and the
    stress of the directions (1, 2), (2, 3) and (3, 1), in tensor components.
    """
    for i in range(6):
        for j in range(6):
            tangent[i, j] = 0.0
    for a in range(3):
        for b in range(3):
            for i in range(6):
                # n_a n_a of the stress beside n_b n_b of the strain
                left = normal[a, b] * _product(directions, a, a, i)
                for j in range(6):
                    tangent[i, j] += left * _product(directions, b, b, j)
    for k in range(3):
        a, b = k, (k + 1) % 3
        for i in range(6):
            left = 2.0 * shear[k] * _product(directions, a, b, i)  # sym(n_a n_b): ab and ba
            for j in range(6):
                tangent[i, j] += left * _product(directions, a, b, j)


@lean
def _product(directions, a, b, i):
    """Return the component i of the symmetric part of n_a n_b."""
    if i < 3:
        return directions[a, i] * directions[b, i]
    j, k = i - 3, (i - 2) % 3
    return 0.5 * (directions[a, j] * directions[b, k] + directions[a, k] * directions[b, j])
