# SPDX-License-Identifier: MIT
"""Elements that a calibration offers: in one plane, or in space round and spread over azimuths; their elastic motions.

Elements in one plane are offered as they are. In space an element is round, with one gauge of both planes, or spread:
one in each of `AZIMUTHS` planes. Along a motion in the plane of x round ones are those of the plane.

All lengths are shares of the reach of the rays. Reversible elements are part of what clay, and soil with a gap, carry
without hysteresis. Frictional elements are what soil with a gap needs for a stiffness that is not symmetric: there they
halve what is left of the equations.

Measured on three caissons (sand, soil with cohesion, clay): directions every 20 degrees and two slender gauges are
enough; hardening over a fifth of the reach carries the growth of the loads from cycle to cycle. A second choice, among
the elements around the chosen ones, halves what pulls miss.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.memory import shares
from pysprings.memory.elements import (
    COLUMNS,
    FRICTIONAL,
    GAP,
    PLASTIC,
    PLATES,
    REVERSIBLE,
    SPACE_COLUMNS,
    SPACE_STATES,
    STATES,
    histories,
    round_histories,
)

DIRECTIONS = 9  # of gauges, over 180 degrees
ASPECTS = (0.1, 0.3)  # of a gauge across its direction: there an element yields at 1/aspect of the motion
SMALLEST, LARGEST, SIZES = 1 / 5000, 1 / 2, 8  # motion at first yield
# gain a, and length h over which half of it is reached; gain 0: perfectly plastic
LAWS = (
    (0.0, 1.0), (2.0, 0.02), (2.0, 0.2), (2.0, 2.0), (10.0, 0.02), (10.0, 0.2), (10.0, 2.0), (50.0, 0.2), (50.0, 2.0),
)  # fmt: skip
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

    def chosen(self, which: Marks) -> Self:
        """Return those of all elements, in the order of the kinds, that are marked."""
        parts = np.split(which, np.cumsum([len(own) for own in self[:-1]]))
        return type(self)(*(own[part] for own, part in zip(self, parts, strict=True)))


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
    changed = parameters.copy()
    changed[:, column] *= factor
    return changed


def plastic_rows(parameters: Array) -> Array:
    """Return plastic elements (n, COLUMNS) with B = I; gauges have the size 1 along their angle, 1/aspect across it."""
    angle, aspect, size, gain, length = parameters.T
    one, zero = np.ones(len(angle)), np.zeros(len(angle))
    return np.stack([one * PLASTIC, *_gauge(angle, aspect), one, zero, one, size, gain, length], axis=1)


def _gauge(angle: Array, aspect: Array) -> tuple[Array, Array, Array]:
    """Return G as (g11, g12, g22)."""
    c, s = np.cos(angle), np.sin(angle)
    return c * c + (aspect * s) ** 2, (1.0 - aspect**2) * c * s, s * s + (aspect * c) ** 2


def reversible_rows(parameters: Array) -> Array:
    """Return reversible elements (n, COLUMNS) with B = G."""
    angle, aspect, size = parameters.T
    gauge, one, zero = _gauge(angle, aspect), np.ones(len(angle)), np.zeros(len(angle))
    return np.stack([one * REVERSIBLE, *gauge, *gauge, size, zero, one], axis=1)


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
    return np.stack([one * FRICTIONAL, *t, friction, *n, one, size, zero, one], axis=1)


def force_directions() -> Array:
    """Return unit vectors (FORCES, 2); B of an element is a sum of m m^T, which is symmetric and positive."""
    angle = np.arange(FORCES) * np.pi / FORCES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


Known = tuple[Array, Array, Array]  # a way: motions (n, 2) or (n, 5) [m], loads (n, 2) or (n, 4) [N], weights (n,)

AZIMUTHS = 6  # planes over 180 degrees in which spread elements stand
PLATE_SIZES, GAUGE_SIZES = (0.7, 1.0, 1.4), (0.7,)  # factors to the planar elements that are spread


@dataclass(frozen=True, slots=True)
class Offered:
    """Elements (n, COLUMNS) of stiffness 1 to choose from, and which of them are spread over azimuths (n,)."""

    rows: Array
    spread: Marks

    @property
    def plastic(self) -> Marks:
        """Elements whose B is chosen in all its directions."""
        return self.rows[:, 0] == PLASTIC

    @classmethod
    def in_plane(cls, choice: Candidates) -> Self:
        """Return candidates of one plane: none is spread."""
        rows = np.concatenate(choice.rows)
        return cls(rows, np.zeros(len(rows), dtype=bool))

    @classmethod
    def of_space(cls, rows: Array) -> Self:
        """Return what `in_space` made elements in space of (n, SPACE_COLUMNS); those of torsion are left out."""
        parts = rows[:, COLUMNS:]
        spread, round_ = parts[:, :2].any(axis=1), ~parts.any(axis=1)
        one = scaled(rows[spread, :COLUMNS][: int(spread.sum()) // AZIMUTHS], 0.5 * AZIMUTHS)
        return cls(np.concatenate([rows[round_, :COLUMNS], one]), np.arange(round_.sum() + len(one)) >= round_.sum())

    def chosen(self, which: Marks) -> Self:
        """Return those that are marked."""
        return type(self)(self.rows[which], self.spread[which])


def azimuths() -> Array:
    """Return the azimuths (AZIMUTHS,) [rad] of the planes of spread elements, alike on both sides of x."""
    return (np.arange(AZIMUTHS) + 0.5) * np.pi / AZIMUTHS


def offered(rows: Array) -> Offered:
    """Return what planar elements (n, COLUMNS) offer in space."""
    unit, kind = rows.copy(), rows[:, 0]
    unit[kind == PLASTIC, 4:7] = 1.0, 0.0, 1.0
    unit[kind == REVERSIBLE, 4:7] = unit[kind == REVERSIBLE, 1:4]
    unit[np.isin(kind, PLATES), 6] = 1.0
    plate, plastic = np.isin(kind, PLATES), kind == PLASTIC
    parts = [unit[~plate]] + [_sized(unit[plate], factor) for factor in PLATE_SIZES]
    parts += [_sized(unit[plastic], factor) for factor in GAUGE_SIZES]
    found = np.concatenate(parts)
    return Offered(found, np.arange(len(found)) >= len(parts[0]))


def _sized(rows: Array, factor: float) -> Array:
    """Return elements of another size."""
    out, gap = rows.copy(), rows[:, 0] == GAP
    out[:, 7] *= factor
    out[gap, 1] *= factor
    return out


def in_space(rows: Array, spread: Marks) -> Array:
    """Return elements in space (m, SPACE_COLUMNS): round ones, and spread ones in each of their planes."""
    round_ = np.zeros((int((~spread).sum()), SPACE_COLUMNS))
    round_[:, :COLUMNS] = rows[~spread]
    own = scaled(rows[spread], 2.0 / AZIMUTHS)
    planes = [
        np.hstack([own, np.broadcast_to([np.cos(angle), np.sin(angle), 0.0], (len(own), 3))]) for angle in azimuths()
    ]
    return np.ascontiguousarray(np.concatenate([round_, *planes]))


def scaled(rows: Array, share: float | Array) -> Array:
    """Return elements (n, COLUMNS) that carry a share, or each its own (n,), of what these do."""
    out, each = rows.copy(), np.broadcast_to(share, len(rows))
    plate = np.isin(rows[:, 0], PLATES)  # n or t in columns 4 and 5
    out[:, 4:6] *= np.where(plate, 1.0, each)[:, None]
    out[:, 6] *= each
    return out


def numbers_of(rows: Array, spread: Marks) -> Integers:
    """Return how many numbers the state of each element has in space."""
    own = np.where(spread, STATES * AZIMUTHS, SPACE_STATES)
    return np.where(rows[:, 0] == REVERSIBLE, 0, own)


def numbers_in_space(rows: Array) -> int:
    """Return how many numbers the state of elements in space (n, SPACE_COLUMNS) has."""
    round_ = ~rows[:, COLUMNS:].any(axis=1)
    return int(np.where(rows[:, 0] == REVERSIBLE, 0, np.where(round_, SPACE_STATES, STATES)).sum())


def elastic_motions(choice: Offered, motions: Array, largest: float) -> Array:
    """Return elastic motions (n, elements, 2 planes) along motions (n, 2) in one plane, or (n, 5) in space.

    Those of the plane of x first; of spread elements the sum of their planes.
    """
    plane, spread = motions.shape[1] == 2, choice.spread
    n, m = len(motions), 2 if plane else 4
    along = histories if plane else round_histories
    one, _ = shares.elastic_motions(choice.rows[~spread], motions[:, :m], largest, along)
    if not spread.any():
        return one
    e = np.zeros((n, len(spread), m))
    e[:, ~spread] = one
    for angle in azimuths():
        c, s = np.cos(angle), np.sin(angle)
        way = c * motions[:, :2] + (0.0 if plane else s * motions[:, 2:4])
        own, _ = shares.elastic_motions(choice.rows[spread], way, largest)
        parts = [c * own] if plane else [c * own, s * own]
        e[:, spread] += 2.0 / AZIMUTHS * np.concatenate(parts, axis=2)
    return e


def evened(choice: Offered, motions: Array, largest: float, growth: float) -> Array:
    """Return what w and V are linear in, (n, 2 elements) [m], along motions (n, 5): ways, then stored energies.

    They are those of one plane (`pysprings.memory.shares`), of round elements with both planes in |e|_G^2, of spread
    ones the sum over their planes.
    """
    spread, out = choice.spread, np.zeros((len(motions), 2, len(choice.spread)))
    round_, directed = choice.rows[~spread], choice.rows[spread]
    e, p = shares.elastic_motions(round_, motions[:, :4], largest, round_histories)
    for plane in (e[:, :, :2], e[:, :, 2:]):
        way, stored = np.split(shares.even_motions(round_, plane, p, growth), 2, axis=1)
        out[:, 0, ~spread] = way
        out[:, 1, ~spread] += stored
    for angle in azimuths():
        own = np.cos(angle) * motions[:, :2] + np.sin(angle) * motions[:, 2:4]
        parts = shares.even_motions(directed, *shares.elastic_motions(directed, own, largest), growth)
        out[:, :, spread] += 2.0 / AZIMUTHS * parts.reshape(len(motions), 2, len(directed))
    return out.reshape(len(motions), 2 * len(spread))


def even_by_row(even: Array, choice: Offered, rows: int) -> Array:
    """Return factors (rows, 4) of rows of `in_space`: of w and V by the way, then by what is stored.

    even (2, 2 elements) is by element that was offered; rows behind those of the choice (torsion) have none.
    """
    parts = even.reshape(2, 2, -1).transpose(2, 1, 0).reshape(-1, 4)
    own = np.concatenate([parts[~choice.spread], *[2.0 / AZIMUTHS * parts[choice.spread]] * AZIMUTHS])
    return np.concatenate([own, np.zeros((rows - len(own), 4))])
