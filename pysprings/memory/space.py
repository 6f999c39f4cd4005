# SPDX-License-Identifier: MIT
"""Elements in the space of both planes: what they are made of, and their calibration on paths that leave one plane.

The planar elements of a calibration (`pysprings.memory.calibration`) are offered again: as round ones with one gauge of
both planes, and spread over azimuths, a plate, or a gauge, in each of `AZIMUTHS` planes. One non-negative least-squares
problem of the form of the planar one fits them to the planar ways along x, to the recorded paths that leave the plane,
and to all of them turned by half of the angle between two planes.

Torsion is carried by elements of its own, fitted to a twist: they do not share friction with the lateral ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.variables import TORSION
from pysprings.macro.fan import FanTable
from pysprings.memory import offered
from pysprings.memory.calibration import (
    FORGET,
    MOST_NUMBERS,
    STIFFNESS,
    ElementSet,
    SpaceElements,
    fitted,
    nonnegative,
    strongest,
    way_of,
)
from pysprings.memory.elements import COLUMNS, SPACE, SPACE_COLUMNS, STATES, SUBSTEP, histories, tangents
from pysprings.memory.shares import RIDGE, Sample, heave_of, heave_weights, loads_of, places
from pysprings.memory.water import ridge_fit
from pysprings.springs.path import SpacePath
from pysprings.springs.springs import Springs

WEIGHT, FLOOR = 2.0, 0.1  # of a path out of the plane beside a ray; errors are relative to this share of its load
PER_REACH = 0.4  # largest motion of rays that turn back, over the reach: places on a path follow from it
SHARE_NOTHING = (
    "the elements of torsion share no friction with the lateral ones, both carry too much (measured in sand: H by "
    "38 %, motions 40 % too small)"
)
# Of elements of torsion: number of sizes, gains, and lengths over the reach over which half of the gain is reached
TORSION_SIZES, TORSION_GAINS, TORSION_LENGTHS = 32, (1.0, 3.0, 10.0, 30.0, 100.0), (0.001, 0.005, 0.02, 0.1, 0.5, 2.0)


@dataclass(frozen=True, slots=True)
class SpaceWay:
    """A way out of one plane: motions (n, 5) [m] and loads (n, 5) [N] of `elements`, weight of each point (n,)."""

    name: str
    kind: str
    motions: Array
    loads: Array
    weights: Array


def way_out(path: SpacePath, radius: float, reach: float) -> SpaceWay:
    """Return the way of a path that leaves the plane, at even distances and close behind its turns."""
    motions, loads = path.motions(radius), path.loads(radius)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(motions, axis=0), axis=1))])
    at = places(motions, way, PER_REACH * reach)
    motions, loads = (np.stack([np.interp(at, way, each) for each in values.T], axis=1) for values in (motions, loads))
    size = np.linalg.norm(loads, axis=1)
    weights = WEIGHT / np.sqrt(len(at)) / np.maximum(size, FLOOR * size.max())
    return SpaceWay(path.name, path.kind, motions, loads, weights)


def calibrate_in_space(
    springs: Springs, planar: ElementSet, ways: Sequence[Sample], table: FanTable, stiffness: Array
) -> SpaceElements | None:
    """Return elements in space that follow planar ways, and the paths of springs that leave the plane.

    planar: elements of the plane. ways: those that they are calibrated on; stiffness (2, 2): the initial one [N/m].
    None without a path of the role "memory" that moves the lid centre out of the plane.
    """
    radius, reach = 0.5 * springs.diameter, planar.reach
    out = [way_out(path, radius, reach) for path in springs.turning]
    lateral, twists = ([way for way in out if (way.kind == "twist") == twist] for twist in (False, True))
    if not lateral:
        return None
    torsion, torsion_left = torsion_elements(twists, springs, reach)
    rows, left = _lateral(planar.rows, ways, lateral, table, stiffness, (reach, MOST_NUMBERS - STATES * len(torsion)))
    choice = offered.Offered.of_space(rows)
    p = _by_depth(choice, ways, springs, table, planar.largest)
    growth, longest = float(planar.shares.growth), max([planar.way, *(way_of(way.motions[:, :4]) for way in lateral)])
    even = _heave(choice, ways, springs, table, (planar.largest, growth))
    rows = np.concatenate([rows, torsion])
    farthest = max((float(np.abs(way.motions[:, 4]).max()) for way in twists), default=0.0)
    errors = {way.name: errors_of(rows, way.motions, way.loads, planar.largest) for way in lateral}
    return SpaceElements(rows, radius, farthest, *p, even, growth, longest, left, torsion_left, errors)


def _heave(
    choice: offered.Offered, ways: Sequence[Sample], springs: Springs, table: FanTable, sizes: tuple[float, float]
) -> Array:
    """Return w and V (2, 2 elements) by the ways and the stored energies of elements; sizes: largest step, growth.

    From the planar ways along x and turned, and the recorded paths that move the lid centre out of the plane; as even
    rows of the plane.
    """
    (largest, growth), angles = sizes, (0.0, 0.5 * np.pi / offered.AZIMUTHS)
    known = [(_turned(way.motions, a, 5), heave_of(table, way), way.turns) for a in angles for way in ways]
    for path in springs.turning:
        if path.kind != "twist":
            motions, change = path.motions(1.0), np.stack([path[name] - path[name][0] for name in ("w", "V")])
            known.append((motions, change, True))
    X = np.concatenate([offered.evened(choice, motions, largest, growth) for motions, _, _ in known])
    weights = heave_weights([(change[0], turns) for _, change, turns in known])
    return ridge_fit(X, np.concatenate([change for _, change, _ in known], axis=1).T, weights, RIDGE)


def _by_depth(
    choice: offered.Offered, ways: Sequence[Sample], springs: Springs, table: FanTable, largest: float
) -> tuple[Array, Array]:
    """Return p (k, 2) by the load (H, M/L) of a plane and (k, 2 elements) by the elastic motions of elements.

    From the recorded planar ways, and both planes of the paths out of them; a regression, as that of the plane.
    """
    known = [(way.motions, way.reactions[table.name == "p"][None], way.weights) for way in ways if way.recorded]
    for path in springs.turning:
        if path.kind != "twist":
            size = np.linalg.norm(path.loads(1.0)[:, :4], axis=1)
            weights = WEIGHT / np.sqrt(path.n) / np.maximum(size, FLOOR * size.max())
            known.append((path.motions(1.0), path.reactions(), weights))
    e, F, p, w = [], [], [], []
    for motions, found, weights in known:
        elastic = offered.elastic_motions(choice, motions, largest)
        for plane, values in enumerate(found):
            own = elastic[:, :, 2 * plane : 2 * plane + 2]
            e.append(own.reshape(len(own), -1))
            F.append(loads_of(choice.rows, own))
            p.append(values.T)
            w.append(weights)
    E, loads, P, weights = (np.concatenate(parts) for parts in (e, F, p, w))
    S = np.linalg.lstsq(loads * weights[:, None], P * weights[:, None], rcond=None)[0]
    return np.ascontiguousarray(S.T), ridge_fit(E, P - loads @ S, weights, RIDGE)


def _lateral(
    planar: Array,
    ways: Sequence[Sample],
    out: Sequence[SpaceWay],
    table: FanTable,
    stiffness: Array,
    limits: tuple[float, int],
) -> tuple[Array, float]:
    """Return elements (n, SPACE_COLUMNS) without torsion, and the residual; limits: reach [m], most numbers of state.

    All ways count as they are, and turned by half of the angle between two planes.
    """
    (reach, most), half = limits, 0.5 * np.pi / offered.AZIMUTHS
    known = list[offered.Known]()
    along = [(way.motions, way.loads(table), way.weights) for way in ways]
    for same in (along, [(way.motions, way.loads[:, :4], way.weights) for way in out]):
        known += same
        known += [(_turned(motions, half, 5), _turned(loads, half, 4), weights) for motions, loads, weights in same]
    choice, largest = offered.offered(planar), SUBSTEP * reach
    rows, left, chosen = fitted(choice, known, stiffness, largest)
    choice = choice.chosen(chosen)
    numbers = offered.numbers_of(rows, choice.spread)
    if numbers.sum() > most:
        choice = choice.chosen(strongest(rows, choice, known, largest, (numbers, most)))
        rows, left, chosen = fitted(choice, known, stiffness, largest)
        choice = choice.chosen(chosen)
    return offered.in_space(rows, choice.spread), left


def errors_of(rows: Array, motions: Array, loads: Array, largest: float) -> tuple[float, float]:
    """Return the largest error in H and M/L, as vectors, of elements along motions (n, 5), over the largest load."""
    found, stiffness = np.zeros(motions.shape), np.zeros((len(motions), SPACE, SPACE))
    tangents(rows, np.ascontiguousarray(motions), largest, found, stiffness)
    missing, size = found - loads, float(np.linalg.norm(loads[:, :4], axis=1).max())
    return float(np.hypot(*missing[:, :4:2].T).max() / size), float(np.hypot(*missing[:, 1:4:2].T).max() / size)


def _turned(values: Array, angle: float, columns: int) -> Array:
    """Return values (n, 2) of the plane of x, or those of both, turned about z by an angle [rad]: (n, columns)."""
    out = np.zeros((len(values), columns))
    out[:, : values.shape[1]] = values
    x, y, c, s = out[:, :2].copy(), out[:, 2:4].copy(), np.cos(angle), np.sin(angle)
    out[:, :2], out[:, 2:4] = c * x - s * y, s * x + c * y
    return out


def torsion_elements(twists: Sequence[SpaceWay], springs: Springs, reach: float) -> tuple[Array, float]:
    """Return elements of torsion (n, SPACE_COLUMNS) that follow twists, and the residual; none without a twist.

    Their sum at rest is the torsional stiffness of the full model, where it is known. reach [m]: that of the rays.
    """
    if not twists:
        return np.zeros((0, SPACE_COLUMNS)), 0.0
    rows = _twisting(reach)
    blocks, right = [], []
    for way in twists:
        motions = np.zeros((len(way.motions), 2))
        motions[:, 0] = way.motions[:, 4]
        e, p = np.zeros((len(motions), len(rows), 2)), np.zeros((len(motions), len(rows)))
        histories(rows, motions, SUBSTEP * reach, e, p)
        blocks.append(e[:, :, 0] * way.weights[:, None])
        right.append(way.loads[:, 4] * way.weights)
    known = springs.attrs.get(TORSION)
    if known is not None:
        blocks.append(np.full((1, len(rows)), STIFFNESS * (0.5 * springs.diameter) ** 2 / float(known)))
        right.append(np.array([STIFFNESS]))
    A, b = np.concatenate(blocks), np.concatenate(right)
    factors, left = nonnegative(A, b)
    rows[:, 4] *= factors
    keeps = rows[:, 4] > FORGET * rows[:, 4].sum()
    found = np.zeros((int(keeps.sum()), SPACE_COLUMNS))
    found[:, :COLUMNS], found[:, 12] = rows[keeps], 1.0
    return found, left


def _twisting(reach: float) -> Array:
    """Return the elements (n, COLUMNS) of one motion, of stiffness 1, from which those of torsion are chosen."""
    laws = [(0.0, 1.0), *product(TORSION_GAINS, TORSION_LENGTHS)]
    sizes = np.geomspace(0.1 * offered.SMALLEST * reach, offered.LARGEST * reach, TORSION_SIZES)
    parts = [[0.0, 1.0, size, gain, length * reach] for size in sizes for gain, length in laws]
    rows = offered.plastic_rows(np.array([*parts, [0.0, 1.0, 1e6 * reach, 0.0, reach]]))
    rows[:, 3], rows[:, 6] = 0.0, 0.0  # of one motion alone
    return rows
