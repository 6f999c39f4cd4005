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
PER_INDEX = math.radians(3.0)  # of friction for each unit of I_R in triaxial compression, Bolton 1986
MOST_INDEX = 4.0  # of I_R, Bolton 1986
LEAST_PRESSURE = 1.0e3  # Pa, of I_R
_ROUND = 0.1  # of I_R, over which its bounds are rounded


def cone_slope(sine: float) -> float:
    """Return slope m of the Drucker-Prager cone in the I-II plane from the sine of the friction or dilation angle."""
    # m of the cone through triaxial compression (docs/theory/soil.md, PLASOL)
    return 2.0 * sine / (SQRT3 * (3.0 - sine))


def cone_cohesion(sine: float, cosine: float, cohesion: float) -> float:
    """Return strength k of the cone at I = 0 (unit of the cohesion) from sine and cosine of the friction angle."""
    return 6.0 * cohesion * cosine / (SQRT3 * (3.0 - sine))  # k alike, with 6 c cos phi: no division by tan phi


def shape(phi: float) -> float:
    """Return the parameter b(phi) of Van Eekelen's section; phi in rad."""
    # ((r_C/r_E)^(1/n) - 1)/((r_C/r_E)^(1/n) + 1), Barnichon 1998, with ln(r_C/r_E) = 2 atanh(sin phi/3)
    return math.tanh(math.atanh(math.sin(phi) / 3.0) / EXPONENT)


def shape_of_slope(m: float) -> float:
    """Return the parameter b of the angle whose cone has the slope m."""
    # sin phi/3 = sqrt3 m/(2 + sqrt3 m), from the slope m of the cone
    return math.tanh(math.atanh(SQRT3 * m / (2.0 + SQRT3 * m)) / EXPONENT)


def section(b: float, cos3: float) -> float:
    """Return the radius rho of Van Eekelen's section over that in compression; cos3 of three times the Lode angle."""
    return ((1.0 + b * cos3) / (1.0 + b)) ** EXPONENT  # Van Eekelen 1980, over its value at theta = 0


def turn(b: float, cos3: float, sin3: float) -> tuple[float, float]:
    """Return the direction T = -d(ln rho)/d(theta) of the flow across the meridian plane, and dT/dtheta."""
    along = 1.0 + b * cos3
    # ln rho = n ln(1 + b cos(3 theta)) + const., differentiated once and twice
    return 3.0 * EXPONENT * b * sin3 / along, 9.0 * EXPONENT * b * (cos3 + b) / (along * along)


def bracketed(step: float, low: float, high: float) -> float:
    """Return a Newton step; the middle of its bracket where it leaves it."""
    return step if low < step < high else 0.5 * (low + high)


def dilatancy_index(density: float, crushing: float, pressure: float) -> float:
    """Return I_R of a relative density and Q at a mean effective stress in Pa, compression positive."""
    plain = density * (crushing - math.log(1.0e-3 * max(pressure, LEAST_PRESSURE))) - 1.0  # Bolton 1986
    low = 0.5 * (plain + math.sqrt(plain * plain + _ROUND * _ROUND))
    above = MOST_INDEX - low
    return MOST_INDEX - 0.5 * (above + math.sqrt(above * above + _ROUND * _ROUND))
