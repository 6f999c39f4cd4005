# SPDX-License-Identifier: MIT
"""Reactions along rays: a hyperbola h = X/(1 + X) times a polynomial in z/L, h and the even inputs.

Each ray of constant rotation L/u has its own formula: that couples the springs of displacement and rotation as the
soil does. Terms are chosen one by one, those first that take most of what is left (orthogonal matching pursuit), until
what they leave is below a tolerance.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.formulas.base import (
    LATERAL,
    PLACES,
    WHERE,
    Form,
    Place,
    Term,
    reactions,
    summed,
    units,
)  # fmt: skip
from pysprings.studies.atlas.samples import ROWS, Samples, share

Array = NDArray[np.float64]
_DEPTH, _WAY, _INPUTS = 3, 4, 2  # largest powers of z/L, of h, of all inputs together
_TOTALS = 3.0  # weight of the sum of a spring over depth, and of its first moment
TOLERANCE = 0.002  # of a spring over the load of its ray, root mean square
MOST = 200  # terms of a spring on a ray


def _fit(samples: Samples, place: Place) -> tuple[Term, ...]:
    from pysprings.studies.atlas.model import sums

    total, size = np.hypot(*sums(samples.values)), units(place)
    terms: list[Term] = []
    for spring in LATERAL:
        known = reactions(samples, place, spring)
        weight = size[spring][:, None, :, None] / total[:, :, None, :]
        terms += along_rays(spring, known, np.broadcast_to(weight, known.shape), place)
    return tuple(terms)


def along_rays(spring: str, known: Array, weight: Array, place: Place) -> list[Term]:
    """Return the terms of a spring along every ray from values over h and their weights (n, ray, depth, X)."""
    zeta = PLACES[spring]
    powers = _powers(zeta.size > 1, place.x.shape[1])
    columns = _columns(zeta, place)
    terms: list[Term] = []
    for ray, name in enumerate(place.rays):
        y, w = known[:, ray] * weight[:, ray], weight[:, ray]
        basis = np.stack([np.broadcast_to(summed([Term("", "", "", each, 1.0)], columns), y.shape) for each in powers])
        basis = basis * w
        if zeta.size > 1:
            basis = np.concatenate([basis, *(_TOTALS * _moment(basis, zeta, k) for k in (0, 1))], axis=2)
            y = np.concatenate([y, *(_TOTALS * _moment(y, zeta, k) for k in (0, 1))], axis=1)
        there = np.isfinite(y)
        values = chosen(basis[:, there].T, y[there], TOLERANCE, MOST)
        terms += [
            Term(spring, name, "reaction", power, float(value))
            for power, value in zip(powers, values, strict=True)
            if value
        ]
    return terms


def ray_values(terms: tuple[Term, ...], spring: str, place: Place) -> Array:
    """Return the sums of the terms of a spring (n, ray, depth, X)."""
    columns = _columns(PLACES[spring], place)
    shape = (len(place.inputs), PLACES[spring].size, place.X.size)
    return np.stack([
        np.broadcast_to(summed([each for each in terms if (each.spring, each.ray) == (spring, name)], columns), shape)
        for name in place.rays
    ], axis=1)  # fmt: skip


def _columns(zeta: Array, place: Place) -> list[Array]:
    """Return the variables of the terms, for values (n, depth, X)."""
    return [zeta[:, None], share(place.X), *(place.x[:, k, None, None] for k in range(place.x.shape[1]))]


def _moment(values: Array, zeta: Array, power: int) -> Array:
    """Return the sum over depth, or the first moment, with one depth."""
    return np.asarray((values * zeta[:, None] ** power).sum(axis=-2, keepdims=True))


def _powers(by_depth: bool, inputs: int) -> list[tuple[int, ...]]:
    mixed = [each for each in product(range(_INPUTS + 1), repeat=inputs) if sum(each) <= _INPUTS]
    return [
        (depth, way, *each)
        for depth in range(_DEPTH + 1 if by_depth else 1)
        for way in range(_WAY + 1)
        for each in mixed
    ]


def _solved(gram: Array, right: Array) -> Array:
    """Return the solution of normal equations, their columns scaled to one size, with a ridge of rounding."""
    size = np.sqrt(np.diag(gram))
    scaled = gram / np.outer(size, size) + 1e-12 * np.eye(len(size))
    return np.asarray(np.linalg.solve(scaled, right / size) / size)


def chosen(basis: Array, y: Array, tolerance: float, most: int) -> Array:
    """Return coefficients (k,) of a basis (n, k), most of them 0, that leave a root mean square below the tolerance."""
    gram, right, square = basis.T @ basis, basis.T @ y, float(y @ y)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    taken: list[int] = []
    found = np.zeros(0)
    while len(taken) < min(most, len(right)):
        left = (right - gram[:, taken] @ found) / size
        left[taken] = 0.0
        taken.append(int(np.argmax(np.abs(left))))
        found = _solved(gram[np.ix_(taken, taken)], right[taken])
        if square - float(right[taken] @ found) < len(y) * tolerance**2:
            break
    out = np.zeros(len(right))
    out[taken] = found
    return out


def _values(terms: tuple[Term, ...], place: Place) -> Array:
    out = np.zeros((len(place.inputs), place.angles.size, len(ROWS), place.X.size))
    size = units(place)
    for spring in LATERAL:
        out[:, :, WHERE[spring]] = ray_values(terms, spring, place) * size[spring][:, None, :, None]
    return out


FORM = Form(
    name="hyperbolic",
    label="hyperbolas along rays",
    formula=(
        "reaction = h times the sum of its terms, h = X/(1 + X), along each ray of constant rotation L/u;",
        "between rays as a fan (`pysprings.studies.atlas.between`).",
    ),
    variables=lambda n: ("z/L", "h", *(f"x{k + 1}" for k in range(n))),
    fit=_fit,
    values=_values,
)
