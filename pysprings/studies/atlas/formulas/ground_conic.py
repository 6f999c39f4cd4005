# SPDX-License-Identifier: MIT
"""Conics of each spring with parameters that follow depth, L/D and the ground, fitted to all rays together.

The best that springs of their own displacement alone can do with four parameters each: the logarithms of ultimate,
stiffness and reach and the log odds of the curvature are linear in z/L and the even inputs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.formulas.base import (
    LATERAL,
    PLACES,
    Form,
    Place,
    Term,
    motions,
    reactions,
)  # fmt: skip
from pysprings.studies.atlas.formulas.conic import conics, ray_of
from pysprings.studies.atlas.formulas.curve import FIRST, LEAST, MOST, PARAMETERS, conic, fitted, start_of
from pysprings.studies.atlas.samples import Samples, share

Array = NDArray[np.float64]


def _fit(samples: Samples, place: Place) -> tuple[Term, ...]:
    return tuple(term for spring in LATERAL for term in _spring(samples, place, spring))


def _spring(samples: Samples, place: Place, spring: str) -> list[Term]:
    ray = ray_of(place, spring)
    x, y = motions(place, spring)[:, ray], reactions(samples, place, spring)[:, ray]
    n = place.x.shape[1]
    parts = [np.ones_like(x)] + [np.broadcast_to(place.x[:, k, None, None], x.shape) for k in range(n)]
    parts += [np.broadcast_to(PLACES[spring][:, None], x.shape)] * (PLACES[spring].size > 1)
    h = np.broadcast_to(share(place.X), x.shape)
    known = np.isfinite(y)
    sign = np.sign(x[known])
    x, y, h, basis = sign * x[known], sign * y[known], h[known], np.stack([part[known] for part in parts])
    stiffness = _stiffness(y * h / x, basis, h < share(place.X[FIRST]))

    def residuals(numbers: Array) -> Array:
        return np.asarray(
            conic(x, *_parameters(np.insert(numbers.reshape(3, -1), 1, stiffness, axis=0), basis)) / h - y
        )

    start = np.zeros((3, len(basis)))
    first = start_of(x, y * h)
    start[:, 0] = [*np.log([first[0], first[2]]), np.log(first[3] / (MOST - first[3]))]
    found = np.insert(fitted(residuals, start.ravel()).reshape(3, -1), 1, stiffness, axis=0)
    powers = [(0,) * (n + 1)] + [tuple(int(k == j + 1) for k in range(n + 1)) for j in range(n)] + [(1,) + (0,) * n]
    return [
        Term(spring, "", name, power, float(value))
        for name, row in zip(PARAMETERS, found, strict=True)
        for power, value in zip(powers, row, strict=False)
    ]


def _stiffness(secant: Array, basis: Array, first: NDArray[np.bool_]) -> Array:
    """Return the coefficients of the logarithm of the stiffness by the first points."""
    size = np.maximum(secant, 1e-3 * np.abs(secant[first]).mean() + LEAST)
    return np.asarray(np.linalg.lstsq(basis[:, first].T, np.log(size[first]), rcond=None)[0])


def _parameters(numbers: Array, basis: Array) -> list[Array]:
    """Return the four parameters of numbers (4, k) over a basis (k, ...): exponentials, a curvature between 0 and 1."""
    size = np.exp(np.clip(np.tensordot(numbers, basis, axes=1), -30.0, 30.0))
    return [*size[:3], MOST * size[3] / (1.0 + size[3])]


def _values(terms: tuple[Term, ...], place: Place) -> Array:
    def parameters(sums: list[Array]) -> list[Array]:
        return _parameters(np.eye(4), np.stack(np.broadcast_arrays(*sums)))

    return conics(terms, place, [place.x[:, k, None, None, None] for k in range(place.x.shape[1])], parameters)


FORM = Form(
    name="ground-conic",
    label="conic of each spring, parameters of the ground",
    formula=(
        "The conic of the form `conic`; ultimate y_u, stiffness k and reach x_u are exp(sum of their terms),",
        "the curvature is n = 0.999 e/(1 + e), e = exp(sum of its terms).",
    ),
    variables=lambda n: ("z/L", *(f"x{k + 1}" for k in range(n))),
    fit=_fit,
    values=_values,
    own_stiffness=True,
)
