# SPDX-License-Identifier: MIT
"""PISA's form: each spring a conic of its own displacement, its parameters linear in z/L or, at tip and lid, in L/D.

Lateral springs come from the pure translation, moments from the ray that turns most: neither depends on the other
motion, and no parameter on the ground, which acts through the sizes of reactions and motions alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.formulas.base import (
    LATERAL,
    PLACES,
    TURNING,
    WHERE,
    Form,
    Place,
    Term,
    motions,
    reactions,
    summed,
    units,
)  # fmt: skip
from pysprings.studies.atlas.formulas.curve import FIRST, LEAST, MOST, PARAMETERS, conic, fitted, start_of
from pysprings.studies.atlas.samples import ROWS, Samples, share

Array = NDArray[np.float64]


def _fit(samples: Samples, place: Place) -> tuple[Term, ...]:
    return tuple(term for spring in LATERAL for term in _spring(samples, place, spring))


def _spring(samples: Samples, place: Place, spring: str) -> list[Term]:
    """Return the terms of one spring: parameters at both ends of z/L or of L/D, positive."""
    ray = ray_of(place, spring)
    x, y = motions(place, spring)[:, ray], reactions(samples, place, spring)[:, ray]
    sign = np.sign(np.sin(place.angles[ray])) if spring in TURNING else 1.0
    by_depth = PLACES[spring].size > 1
    low, high = (0.0, 1.0) if by_depth else (float(place.inputs[:, 0].min()), float(place.inputs[:, 0].max()))
    where = np.broadcast_to(PLACES[spring][:, None] if by_depth else place.inputs[:, :1, None], x.shape)
    part = (where - low) / (high - low)
    h = np.broadcast_to(share(place.X), x.shape)
    known = np.isfinite(y)
    x, y, part, h = sign * x[known], sign * y[known], part[known], h[known]
    stiffness = _stiffness(x, y * h, part, h < share(place.X[FIRST]))

    def parameters(numbers: Array) -> Array:
        rest = _positive(numbers.reshape(2, 3))
        return np.insert(rest, 1, stiffness, axis=1)

    def residuals(numbers: Array) -> Array:
        ends = parameters(numbers)
        return np.asarray(conic(x, *(ends[0, :, None] * (1.0 - part) + ends[1, :, None] * part)) / h - y)

    first = start_of(x, y * h)
    start = np.array([*np.log([first[0], first[2]]), np.log(first[3] / (MOST - first[3]))])
    ends = parameters(fitted(residuals, np.tile(start, 2)))
    slope = (ends[1] - ends[0]) / (high - low)
    power = (1, 0) if by_depth else (0, 1)
    return [
        Term(spring, "", name, powers, float(value))
        for name, constant, change in zip(PARAMETERS, ends[0] - slope * low, slope, strict=True)
        for powers, value in (((0, 0), constant), (power, change))
    ]


def ray_of(place: Place, spring: str) -> int:
    """Return the ray that a spring of its own displacement comes from: the purest translation or rotation."""
    part = np.abs(np.sin(place.angles)) if spring in TURNING else np.cos(place.angles)
    return int(np.argmax(part))


def _stiffness(x: Array, y: Array, part: Array, first: NDArray[np.bool_]) -> Array:
    """Return the stiffness at both ends (2,) by the first points; ratios count."""
    secant, part = (y / x)[first], part[first]
    secant = np.maximum(secant, 1e-3 * np.abs(secant).mean() + LEAST)

    def residuals(numbers: Array) -> Array:
        low, high = np.exp(numbers)
        return np.asarray(np.log((low * (1.0 - part) + high * part) / secant))

    return np.asarray(np.exp(fitted(residuals, np.full(2, np.log(secant).mean()))))


def _positive(numbers: Array) -> Array:
    """Return ultimate, reach and curvature (..., 3) of any real numbers: above 0, the curvature below 1."""
    ends: Array = np.exp(np.clip(numbers, -30.0, 30.0))
    ends[..., 2] = MOST * ends[..., 2] / (1.0 + ends[..., 2])
    return ends


def _values(terms: tuple[Term, ...], place: Place) -> Array:
    def parameters(sums: list[Array]) -> list[Array]:
        return [*sums[:3], np.clip(sums[3], 0.0, MOST)]

    return conics(terms, place, [place.inputs[:, :1, None, None]], parameters)


def conics(
    terms: tuple[Term, ...], place: Place, inputs: list[Array], parameters: Callable[[list[Array]], list[Array]]
) -> Array:
    """Return rows (n, ray, row, X) of conics; ``parameters`` makes the four of each spring from the sums of its terms.

    ``inputs``: variables of the terms beside z/L, shaped for (n, ray, depth, X).
    """
    out = np.zeros((len(place.inputs), place.angles.size, len(ROWS), place.X.size))
    size, h = units(place), share(place.X)
    for spring in LATERAL:
        variables = [PLACES[spring][:, None], *inputs]
        sums = [
            summed([each for each in terms if (each.spring, each.parameter) == (spring, name)], variables)
            for name in PARAMETERS
        ]
        reaction = conic(motions(place, spring), *parameters(sums)) / h
        out[:, :, WHERE[spring]] = reaction * size[spring][:, None, :, None]
    return out


FORM = Form(
    name="conic",
    label="conic of each spring (PISA)",
    formula=(
        "-n (y/y_u - x/x_u)^2 + (1 - n) (y/y_u - x k/y_u) (y/y_u - 1) = 0 for x < x_u, x_u not below y_u/k;",
        "y = y_u beyond; y(-x) = -y(x).",
        "ultimate y_u, stiffness k, reach x_u and curvature n are sums of their terms.",
    ),
    variables=lambda _n: ("z/L", "L/D"),
    fit=_fit,
    values=_values,
    own_stiffness=True,
)
