# SPDX-License-Identifier: MIT
"""The elements that a calibration chooses from; all lengths are shares of the reach of the rays.

Reversible elements are part of what clay, and soil with a gap, carry without hysteresis. Frictional elements are what
soil with a gap needs for a stiffness that is not symmetric: there they halve what is left of the equations.

Measured on three caissons (sand, soil with cohesion, clay): directions every 20 degrees and two slender gauges are
enough; hardening over a fifth of the reach carries the growth of the loads from cycle to cycle. A second choice, among
the elements around the chosen ones, halves what pulls miss.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pysprings.memory.elements import COLUMNS, FRICTIONAL, GAP, PLASTIC, REVERSIBLE

Array = NDArray[np.float64]

DIRECTIONS = 9  # of gauges, over 180 degrees
ASPECTS = (0.1, 0.3)  # of a gauge across its direction: there an element yields at 1/aspect of the motion
SMALLEST, LARGEST, SIZES = 1 / 5000, 1 / 2, 8  # motion at first yield
# gain a, and length h over which half of it is reached; gain 0: perfectly plastic
LAWS = (
    (0.0, 1.0),
    (2.0, 0.02),
    (2.0, 0.2),
    (2.0, 2.0),
    (10.0, 0.02),
    (10.0, 0.2),
    (10.0, 2.0),
    (50.0, 0.2),
    (50.0, 2.0),
)
MOST_GROWN = 1.0  # of d a: an element of a larger one would never come near its last size
FORCES = 9  # directions of the force of an element, over 180 degrees
GAP_DIRECTIONS, GAP_SIZES = 18, 8
PRESSED = (0.0, 0.3, 1.0)  # by which the walls of a gap element press on the plate at rest, over d
FRICTIONAL_DIRECTIONS, FRICTIONAL_SMALLEST, FRICTIONAL_SIZES = 9, 1 / 500, 5  # of walls, and of friction
FRICTION = (0.25, 0.5, 1.0)  # coefficients
REVERSIBLE_DIRECTIONS, REVERSIBLE_SIZES, REVERSIBLE_LARGEST = 18, 10, 2 / 3
_ELASTIC = 1e6  # size of an element that never yields
_NEVER = 1e-4  # of its size: the length h of such an element is below
_ASPECT, _GAIN, _LENGTH = 1.7, 2.0, 3.0  # factors to the elements around one


class Candidates(NamedTuple):
    """Parameters of elements by kind: `mechanisms`, `gaps`, `frictional`, `springs`."""

    plastic: Array
    gap: Array
    frictional: Array
    reversible: Array

    @property
    def rows(self) -> tuple[Array, Array, Array, Array]:
        """Rows (n, COLUMNS) of each kind, of stiffness 1."""
        return (
            plastic_rows(self.plastic),
            gap_rows(self.gap),
            frictional_rows(self.frictional),
            reversible_rows(self.reversible),
        )

    def chosen(self, which: NDArray[np.bool_]) -> Candidates:
        """Return those of all elements, in the order of the kinds, that are marked."""
        parts = np.split(which, np.cumsum([len(own) for own in self[:-1]]))
        return Candidates(*(own[part] for own, part in zip(self, parts, strict=True)))


def candidates(reach: float) -> Candidates:
    """Return all elements to choose from, for a reach [m]."""
    return Candidates(mechanisms(reach), gaps(reach), frictional(reach), springs(reach))


def mechanisms(reach: float) -> Array:
    """Return plastic elements (n, 5) for a reach [m]: angle [rad] and aspect of the gauge, d [m], a, h [m].

    The last one is elastic.
    """
    found = [
        [np.pi * k / DIRECTIONS, aspect, size, gain, length * reach]
        for k in range(DIRECTIONS)
        for aspect in ASPECTS
        for size in np.geomspace(SMALLEST * reach, LARGEST * reach, SIZES)
        for gain, length in LAWS
        if size * gain < MOST_GROWN * reach
    ]
    return np.array([*found, [0.0, 1.0, _ELASTIC * reach, 0.0, reach]])


def gaps(reach: float) -> Array:
    """Return gap elements (n, 3) for a reach [m]: angle [rad], d [m], and how far the walls press at rest, over d."""
    angles, sizes = np.arange(GAP_DIRECTIONS) * np.pi / GAP_DIRECTIONS, np.geomspace(SMALLEST, LARGEST, GAP_SIZES)
    return np.array([[angle, size * reach, share] for angle in angles for size in sizes for share in PRESSED])


def frictional(reach: float) -> Array:
    """Return frictional elements (n, 4) for a reach [m]: angles of walls and friction [rad], d [m], coefficient."""
    angles = np.arange(FRICTIONAL_DIRECTIONS) * np.pi / FRICTIONAL_DIRECTIONS
    sizes = np.geomspace(FRICTIONAL_SMALLEST * reach, LARGEST * reach, FRICTIONAL_SIZES)
    return np.array([[walls, own, d, mu] for walls in angles for own in angles for d in sizes for mu in FRICTION])


def springs(reach: float) -> Array:
    """Return reversible elements (n, 3) for a reach [m]: angle [rad] and aspect of the gauge, d [m]."""
    sizes = np.geomspace(SMALLEST * reach, REVERSIBLE_LARGEST * reach, REVERSIBLE_SIZES)
    angles = np.arange(REVERSIBLE_DIRECTIONS) * np.pi / REVERSIBLE_DIRECTIONS
    round_ = [[0.0, 1.0, size] for size in sizes]
    return np.array([[angle, aspect, size] for aspect in ASPECTS for angle in angles for size in sizes] + round_)


def around(centre: Candidates) -> Candidates:
    """Return elements and those around them, half a step of the grid away in one of their parameters.

    Reversible elements are taken as they are.
    """
    plastic, gap, held, reversible = centre
    step = (LARGEST / SMALLEST) ** (1.0 / (3.0 * (SIZES - 1)))
    plates, found, contacts = [gap], [plastic], [held]
    yields = plastic[plastic[:, 4] > plastic[:, 2] * _NEVER]
    hardens = yields[yields[:, 3] != 0.0]
    for sign in (-1.0, 1.0):
        found += [_moved(yields, 0, sign * 0.5 * np.pi / DIRECTIONS), _scaled(yields, 1, _ASPECT**sign)]
        found += [_scaled(yields, 2, step**sign), _scaled(hardens, 3, _GAIN**sign), _scaled(hardens, 4, _LENGTH**sign)]
        plates += [_moved(gap, 0, sign * 0.5 * np.pi / GAP_DIRECTIONS), _scaled(gap, 1, step**sign)]
        contacts += [_moved(held, 0, sign * 0.5 * np.pi / FRICTIONAL_DIRECTIONS), _scaled(held, 2, step**sign)]
    return Candidates(np.concatenate(found), np.concatenate(plates), np.concatenate(contacts), reversible)


def _moved(parameters: Array, column: int, change: float) -> Array:
    moved = parameters.copy()
    moved[:, column] += change
    return moved


def _scaled(parameters: Array, column: int, factor: float) -> Array:
    scaled = parameters.copy()
    scaled[:, column] *= factor
    return scaled


def plastic_rows(parameters: Array) -> Array:
    """Return plastic elements (n, COLUMNS) with B = I; gauges have the size 1 along their angle, 1/aspect across it."""
    angle, aspect, size, gain, length = parameters.T
    one, zero = np.ones(len(angle)), np.zeros(len(angle))
    rows: Array = np.stack([one * PLASTIC, *_gauge(angle, aspect), one, zero, one, size, gain, length], axis=1)
    return rows


def _gauge(angle: Array, aspect: Array) -> tuple[Array, Array, Array]:
    """Return G as (g11, g12, g22)."""
    c, s = np.cos(angle), np.sin(angle)
    return c * c + (aspect * s) ** 2, (1.0 - aspect**2) * c * s, s * s + (aspect * c) ** 2


def reversible_rows(parameters: Array) -> Array:
    """Return reversible elements (n, COLUMNS) with B = G."""
    angle, aspect, size = parameters.T
    gauge, one, zero = _gauge(angle, aspect), np.ones(len(angle)), np.zeros(len(angle))
    rows: Array = np.stack([one * REVERSIBLE, *gauge, *gauge, size, zero, one], axis=1)
    return rows


def gap_rows(parameters: Array) -> Array:
    """Return gap elements (n, COLUMNS) of stiffness 1."""
    rows = np.zeros((len(parameters), COLUMNS))
    rows[:, 0], rows[:, 4], rows[:, 5] = GAP, np.cos(parameters[:, 0]), np.sin(parameters[:, 0])
    rows[:, 6], rows[:, 7] = 1.0, parameters[:, 1]
    rows[:, 1] = parameters[:, 1] * parameters[:, 2]
    return rows


def frictional_rows(parameters: Array) -> Array:
    """Return frictional elements (n, COLUMNS) of stiffness 1."""
    walls, own, size, friction = parameters.T
    one, zero = np.ones(len(walls)), np.zeros(len(walls))
    n, t = (np.cos(walls), np.sin(walls)), (np.cos(own), np.sin(own))
    rows: Array = np.stack([one * FRICTIONAL, *t, friction, *n, one, size, zero, one], axis=1)
    return rows


def force_directions() -> Array:
    """Return unit vectors (FORCES, 2); B of an element is a sum of m m^T, which is symmetric and positive."""
    angle = np.arange(FORCES) * np.pi / FORCES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
