# SPDX-License-Identifier: MIT
"""Formulas of the yield surfaces, with plain math: the laws compile them, checks of a scene call them as they are.

No function calls another, so that each can be compiled alone.
"""

from __future__ import annotations

import math

SQRT3 = math.sqrt(3.0)
EXPONENT = -0.229  # of Van Eekelen's section
# The section of Van Eekelen's surface is convex up to here, rad
MAX_FRICTION = math.radians(46.5)


def cone_slope(sine: float) -> float:
    """Return slope m of the Drucker-Prager cone in the I-II plane from the sine of the friction or dilation angle."""
    return 2.0 * sine / (SQRT3 * (3.0 - sine))


def cone_cohesion(sine: float, cosine: float, cohesion: float) -> float:
    """Return strength k of the cone at I = 0 (unit of the cohesion) from sine and cosine of the friction angle."""
    return 6.0 * cohesion * cosine / (SQRT3 * (3.0 - sine))


def shape(phi: float) -> float:
    """Return the parameter b(phi) of Van Eekelen's section; phi in rad."""
    return math.tanh(math.atanh(math.sin(phi) / 3.0) / EXPONENT)


def shape_of_slope(m: float) -> float:
    """Return the parameter b of the angle whose cone has the slope m."""
    return math.tanh(math.atanh(SQRT3 * m / (2.0 + SQRT3 * m)) / EXPONENT)


def section(b: float, cos3: float) -> float:
    """Return the radius rho of Van Eekelen's section over that in compression; cos3 of three times the Lode angle."""
    return ((1.0 + b * cos3) / (1.0 + b)) ** EXPONENT


def turn(b: float, cos3: float, sin3: float) -> tuple[float, float]:
    """Return the direction T = -d(ln rho)/d(theta) of the flow across the meridian plane, and dT/dtheta."""
    along = 1.0 + b * cos3
    return 3.0 * EXPONENT * b * sin3 / along, 9.0 * EXPONENT * b * (cos3 + b) / (along * along)
