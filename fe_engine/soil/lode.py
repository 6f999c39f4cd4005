# SPDX-License-Identifier: MIT
"""Lode angle of a stress with its directions, and the section of Van Eekelen's surface over it (see van_eekelen)."""

from __future__ import annotations

import math
from typing import NamedTuple

from fe_engine.compiled import lean
from fe_engine.soil import formulas

_SQRT6 = math.sqrt(6.0)
_AT_MERIDIAN = 1.0e-12  # sin(3 theta) where the direction across the meridian plane has no meaning any more


class Trial(NamedTuple):
    """Trial stress: I, II, cos and sin of 3 theta, unit deviator n, and unit tensor across its meridian plane."""

    first: float
    second: float
    cos3: float
    sin3: float
    n: tuple[float, float, float, float, float, float]
    across: tuple[float, float, float, float, float, float]


shape, section = lean(formulas.shape), lean(formulas.section)
shape_of_slope, turn_of = lean(formulas.shape_of_slope), lean(formulas.turn)


@lean
def lode(stress, first, second):
    """Return the Lode angle and directions of a stress (6,) that has a deviator."""
    scale = 1.0 / (math.sqrt(2.0) * second)  # n = s/|s|, |s| = sqrt2 II
    mean = first / 3.0
    x, y, z = (stress[0] - mean) * scale, (stress[1] - mean) * scale, (stress[2] - mean) * scale
    xy, yz, zx = stress[3] * scale, stress[4] * scale, stress[5] * scale
    # n.n: xx, yy, zz, and xy, yz, zx
    s0, s1, s2 = x * x + xy * xy + zx * zx, y * y + xy * xy + yz * yz, z * z + yz * yz + zx * zx
    s3, s4, s5 = xy * (x + y) + yz * zx, yz * (y + z) + xy * zx, zx * (x + z) + xy * yz
    cube = x * s0 + y * s1 + z * s2 + 2.0 * (xy * s3 + yz * s4 + zx * s5)  # tr(n^3)
    # n.n - 1/3 - tr(n^3) n: traceless, normal to n, of length sin(3 theta)/sqrt6
    third = (s0 + s1 + s2) / 3.0
    c0, c1, c2 = s0 - third - cube * x, s1 - third - cube * y, s2 - third - cube * z
    c3, c4, c5 = s3 - cube * xy, s4 - cube * yz, s5 - cube * zx
    length = _SQRT6 * math.sqrt(c0 * c0 + c1 * c1 + c2 * c2 + 2.0 * (c3 * c3 + c4 * c4 + c5 * c5))
    sin3 = min(max(length, _AT_MERIDIAN), 1.0)
    cos3 = min(max(-_SQRT6 * cube, -1.0), 1.0)  # -(3 sqrt3/2) III/II^3, III = |s|^3 tr(n^3)/3
    f = _SQRT6 / sin3
    across = (f * c0, f * c1, f * c2, f * c3, f * c4, f * c5)
    return Trial(first, second, cos3, sin3, (x, y, z, xy, yz, zx), across)


@lean
def rotated(trial, delta):
    """Return the cos and sin of 3 (theta_t - delta)."""
    c, s = math.cos(3.0 * delta), math.sin(3.0 * delta)
    return trial.cos3 * c + trial.sin3 * s, trial.sin3 * c - trial.cos3 * s
