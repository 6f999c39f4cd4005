# SPDX-License-Identifier: MIT
"""Elements that a calibration offers: in one plane, or in space round and spread over azimuths; their elastic motions.

Elements in one plane are offered as they are. In space an element is round, with one gauge of both planes, or spread:
one in each of `AZIMUTHS` planes. Along a motion in the plane of x round ones are those of the plane.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.memory.candidates import Candidates
from pysprings.memory.elements import (
    COLUMNS,
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
from pysprings.memory.shares import even_motions

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]
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
    def in_plane(cls, choice: Candidates) -> "Offered":
        """Return candidates of one plane: none is spread."""
        rows = np.concatenate(choice.rows)
        return cls(rows, np.zeros(len(rows), dtype=bool))

    @classmethod
    def of_space(cls, rows: Array) -> "Offered":
        """Return what `in_space` made elements in space of (n, SPACE_COLUMNS); those of torsion are left out."""
        parts = rows[:, COLUMNS:]
        spread, round_ = parts[:, :2].any(axis=1), ~parts.any(axis=1)
        one = rows[spread, :COLUMNS][: int(spread.sum()) // AZIMUTHS].copy()
        _share(one, 0.5 * AZIMUTHS)
        return cls(np.concatenate([rows[round_, :COLUMNS], one]), np.arange(round_.sum() + len(one)) >= round_.sum())

    def with_rows(self, rows: Array) -> "Offered":
        """Return the same with other parameters of its elements."""
        return Offered(rows, self.spread)

    def chosen(self, which: Marks) -> "Offered":
        """Return those that are marked."""
        return Offered(self.rows[which], self.spread[which])


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
    own = rows[spread].copy()
    _share(own, 2.0 / AZIMUTHS)
    planes = [
        np.hstack([own, np.broadcast_to([np.cos(angle), np.sin(angle), 0.0], (len(own), 3))]) for angle in azimuths()
    ]
    return np.ascontiguousarray(np.concatenate([round_, *planes]))


def _share(rows: Array, share: float) -> None:
    """Multiply the stiffness of elements (n, COLUMNS)."""
    plate = np.isin(rows[:, 0], PLATES)
    rows[plate, 6] *= share
    rows[~plate, 4:7] *= share


def numbers_of(rows: Array, spread: Marks) -> NDArray[np.int64]:
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
    one = _along(along, choice.rows[~spread], motions[:, :m], largest)
    if not spread.any():
        return one
    e = np.zeros((n, len(spread), m))
    e[:, ~spread] = one
    for angle in azimuths():
        c, s = np.cos(angle), np.sin(angle)
        way = c * motions[:, :2] + (0.0 if plane else s * motions[:, 2:4])
        own = _along(histories, choice.rows[spread], way, largest)
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
    e, p = _histories(round_histories, round_, motions[:, :4], largest)
    for plane in (e[:, :, :2], e[:, :, 2:]):
        way, stored = np.split(even_motions(round_, plane, p, growth), 2, axis=1)
        out[:, 0, ~spread] = way
        out[:, 1, ~spread] += stored
    for angle in azimuths():
        own = np.cos(angle) * motions[:, :2] + np.sin(angle) * motions[:, 2:4]
        parts = even_motions(directed, *_histories(histories, directed, own, largest), growth)
        out[:, :, spread] += 2.0 / AZIMUTHS * parts.reshape(len(motions), 2, len(directed))
    return out.reshape(len(motions), 2 * len(spread))


def even_by_row(even: Array, choice: Offered, rows: int) -> Array:
    """Return factors (rows, 4) of rows of `in_space`: of w and V by the way, then by what is stored.

    even (2, 2 elements) is by element that was offered; rows behind those of the choice (torsion) have none.
    """
    parts = even.reshape(2, 2, -1).transpose(2, 1, 0).reshape(-1, 4)
    own = np.concatenate([parts[~choice.spread], *[2.0 / AZIMUTHS * parts[choice.spread]] * AZIMUTHS])
    return np.concatenate([own, np.zeros((rows - len(own), 4))])


def _along(along: Callable[..., None], rows: Array, motions: Array, largest: float) -> Array:
    """Return the elastic motions (n, elements, m) of rows along motions (n, m) [m]."""
    return _histories(along, rows, motions, largest)[0]


def _histories(along: Callable[..., None], rows: Array, motions: Array, largest: float) -> tuple[Array, Array]:
    """Return the elastic motions (n, elements, m) and ways (n, elements) of rows along motions (n, m) [m]."""
    e, p = np.zeros((len(motions), len(rows), motions.shape[1])), np.zeros((len(motions), len(rows)))
    along(np.ascontiguousarray(rows), np.ascontiguousarray(motions), largest, e, p)
    return e, p
