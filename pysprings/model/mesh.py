# SPDX-License-Identifier: MIT
"""Polar hexahedral half mesh of the soil around a caisson, with its interface faces.

The plan is a disc of rings around a square core (so that no element collapses onto the axis); it is repeated
over the depth levels, and the cells of the skirt's slot are left out. The steel of a rigid caisson has no
elements. Rings are stretched by sqrt(D/sin D), D the azimuth step, so that each polygon encloses the area of
its circle: the leading geometric error of a faceted circle cancels.

Cells have one resolution for every caisson: numbers and sizes of a preset, carried over from the reference geometry.
The presets count cells for the caisson of Cerfontaine, Charlier & Collin (2018) in their domain of 24 m x 12 m. In
diameters, another caisson has cells of the same sizes beside wall, mudline and toe, which grow as much from one to the
next; a longer skirt has more of them, a wider domain more beyond the reach of theirs.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq

from fe_engine.mesh import Mesh

DIAMETER, LENGTH, THICKNESS = 7.8, 4.0, 0.1  # m, of the reference caisson
OUTSIDE, BELOW = 20.1, 8.0  # m of soil beside its skirt and below its tip

# Cells shrink away from the skirt only down to this sum of n cells of the first size over the length.
_MOST_SHRINKING = 2.0
_FAR = 1.6  # least growth of cells beyond the reach of the reference domain
_SAME = 1.0e-9
_MORE = 1.001  # of a size or a growth: rounding does not add a cell
_MOST_CELLS = 2000
_SLENDER = 2.0  # skirt length over diameter, beyond which the largest cell grows with the length


def graded(start: float, stop: float, n: int, first: float) -> np.ndarray:
    """Return the levels (n + 1,) from start to stop, the first cell of the given size, growing geometrically.

    Where there is hardly room for the first cell, all cells are the same: they would shrink to needles otherwise.
    """
    length = stop - start
    share = first / abs(length)
    if n == 1 or abs(n * share - 1.0) < 1e-9 or n * share > _MOST_SHRINKING:
        return np.linspace(start, stop, n + 1)
    ratio = brentq(lambda q: share * (q**n - 1.0) - (q - 1.0) if abs(q - 1.0) > 1e-12 else share * n - 1.0, *(
        (1.0 + 1e-9, min(50.0, 10.0 ** (300.0 / n))) if n * share < 1.0 else (1e-6, 1.0 - 1e-9)
    ))  # fmt: skip
    steps = np.cumsum(ratio ** np.arange(n))
    return np.concatenate([[start], start + length * steps / steps[-1]])


def graded_both(length: float, n: int, first: float, last: float) -> np.ndarray:
    """Return levels (n + 1,) from 0 to length; the end cells have the given sizes, and grow geometrically inwards."""

    def sizes(ratio: float) -> np.ndarray:
        rank = np.arange(n)
        with np.errstate(over="ignore"):  # of a size that is not the smaller one
            return np.minimum(first * ratio**rank, last * ratio ** rank[::-1])

    if n < 3 or sizes(1.0).sum() >= length:  # two cells have none between them that could grow
        return np.linspace(0.0, length, n + 1)
    levels = np.cumsum(sizes(brentq(lambda ratio: sizes(ratio).sum() - length, 1.0, 50.0)))
    return np.concatenate([[0.0], length * levels / levels[-1]])


def away(start: float, stop: float, n: int, first: float, near: float) -> np.ndarray:
    """Return levels from start to stop; those of n cells would reach ``near`` (m), the first of the given size.

    Nearer stops leave out cells; beyond ``near`` they go on growing.
    """
    length = stop - start
    if abs(length - near) <= _SAME * near:
        return graded(start, stop, n, first)
    levels = graded(0.0, near, n, first)
    if length < near:
        return graded(start, stop, max(1, int(np.searchsorted(levels, length * (1.0 - _SAME)))), first)
    last = levels[-1] - levels[-2]
    growth = max(_FAR, last / (levels[-2] - levels[-3])) if n > 1 else _FAR
    number = max(1, round(math.log(1.0 + (growth - 1.0) * (length - near) / (last * growth), growth)))
    steps = np.cumsum(growth ** np.arange(1, number + 1))
    return start + np.concatenate([levels, near + (length - near) * steps / steps[-1]])


def halved_towards(levels: np.ndarray, at: float, times: int) -> np.ndarray:
    """Return the levels with those of cells that are halved towards the level ``at``, on both sides of it."""
    i, parts = int(np.argmin(np.abs(levels - at))), 0.5 ** np.arange(1, times + 1)
    sides = [j for j in (i - 1, i + 1) if 0 <= j < len(levels)]
    return np.sort(np.concatenate([levels, *(levels[i] + (levels[j] - levels[i]) * parts for j in sides)]))


def down_the_skirt(length: float, diameter: float, n: int, first: float, last: float) -> np.ndarray:
    """Return levels from mudline to tip; n cells have the shares first and last of the reference skirt at its ends.

    The end cells of another skirt are no larger than those of the reference in diameters.
    """
    reference = LENGTH * diameter / DIAMETER
    if abs(length - reference) <= _SAME * length:
        return graded_both(length, n, first * length, last * length)
    cells = np.diff(graded_both(reference, n, first * reference, last * reference))
    # needles: a limited number of cells
    largest = cells.max() * max(1.0, length / (_SLENDER * diameter)) * _MORE
    growth = _growth(cells) * _MORE
    top, toe = _MORE * first * reference, _MORE * last * reference
    for number in range(1, _MOST_CELLS):
        try:
            levels = graded_both(length, number, first * reference, last * reference)
        except ValueError:  # too few cells to fill the length
            continue
        own = np.diff(levels)
        if own[0] <= top and own[-1] <= toe and own.max() <= largest and _growth(own) <= growth:
            return levels
    raise ValueError(f"more than {_MOST_CELLS} cells")


def across_the_tip(thickness: float, diameter: float, n: int, wall: float) -> int:
    """Return the number of cells across a tip; n is that of the reference, ``wall`` (m) the first one beside it."""
    largest = max(wall, THICKNESS * diameter / DIAMETER / n)
    return max(n, math.ceil(thickness / largest - _SAME))


def _growth(cells: np.ndarray) -> float:
    """Return the largest ratio of neighbouring cells."""
    ratio = cells[1:] / cells[:-1]
    return float(np.max(np.maximum(ratio, 1.0 / ratio), initial=1.0))


SURFACES = ("outer", "inner", "lid", "tip")


@dataclass(frozen=True)
class Geometry:
    """Caisson and soil domain, lengths in m; ``lines`` are depths where levels must stand."""

    inner_radius: float
    outer_radius: float
    skirt_length: float
    domain_radius: float
    domain_depth: float
    lines: tuple[float, ...] = ()


@dataclass(frozen=True)
class PlaneCounts:
    """Numbers of cells in a plane through the axis, and relative sizes of the smallest ones.

    ``plug`` and ``outer`` cells inside and outside;
    ``tip`` cells across the skirt's thickness below the tip; ``skirt`` and ``below`` layers; ``wall`` is the
    first cell size next to the skirt as a fraction of the outer radius, ``mudline`` and ``toe`` those below
    mudline and beside the tip as fractions of the skirt length. The singular stresses are at the tip; a thin
    layer below mudline has almost no confining stress once the lid lifts, and is not finer than it needs to be.
    The counts are those of the reference caisson, or of the caisson itself (``own``). Of a section the elements beside
    the skirt and its tip are halved towards them ``halvings`` times.
    """

    plug: int
    outer: int
    tip: int
    skirt: int
    below: int
    wall: float
    mudline: float
    toe: float
    own: bool = field(default=False, kw_only=True)
    halvings: int = field(default=0, kw_only=True)


@dataclass(frozen=True)
class Counts(PlaneCounts):
    """Counts with those of the ``azimuth``: cells over the half ring (a multiple of 4)."""

    azimuth: int


AnyCounts = TypeVar("AnyCounts", bound=PlaneCounts)

PRESETS = {
    "coarse": Counts(azimuth=8, plug=4, outer=8, tip=1, skirt=7, below=6, wall=0.10, mudline=0.10, toe=0.10),
    "medium": Counts(azimuth=12, plug=5, outer=11, tip=1, skirt=11, below=9, wall=0.07, mudline=0.06, toe=0.06),
    "paper": Counts(azimuth=16, plug=6, outer=24, tip=1, skirt=16, below=16, wall=0.04, mudline=0.05, toe=0.009),
    "fine": Counts(azimuth=40, plug=13, outer=26, tip=2, skirt=30, below=23, wall=0.022, mudline=0.03, toe=0.01),
}


def refine(counts: Counts, factor: float) -> Counts:
    """Scale all cell counts by a factor, and the first cell sizes by its inverse."""
    scaled = {n: max(1, round(getattr(counts, n) * factor)) for n in ("plug", "outer", "tip", "skirt", "below")}
    azimuth = max(4, 4 * round(counts.azimuth * factor / 4))
    sizes = {n: getattr(counts, n) / factor for n in ("wall", "mudline", "toe")}
    return replace(counts, azimuth=azimuth, **sizes, **scaled)


@dataclass(frozen=True)
class CaissonMesh:
    """The mesh and the order of its nodes, for the extraction.

    ``azimuth`` (na,) rad and ``depth`` (nz,) m are the coordinates of the interface nodes on both walls;
    ``boundary`` (nz,) bool marks depths where a layer ends, ``walls`` maps side -> (na, nz) node numbers.
    ``section`` are the quads (k, 4) of the symmetry plane.
    """

    mesh: Mesh
    azimuth: np.ndarray
    depth: np.ndarray
    boundary: np.ndarray
    walls: dict[str, np.ndarray]
    section: np.ndarray


def make_mesh(geometry: Geometry, counts: Counts) -> CaissonMesh:
    """Build the half mesh (y >= 0) of the soil; ``counts`` are those of the reference caisson."""
    radii, levels = _radii(geometry, counts), depths(geometry, counts)
    plan = _plan(geometry, counts.azimuth, radii)
    n_plan, n_skirt = len(plan.points), skirt_cells(geometry, levels)
    nodes = np.empty((len(levels), n_plan, 3))
    nodes[:, :, :2] = plan.points
    nodes[:, :, 2] = levels[:, None]
    inside = len(radii.plug)
    slot = (plan.ring >= inside) & (plan.ring < inside + len(radii.tip))
    layers = [plan.quads[~slot] if k < n_skirt else plan.quads for k in range(len(levels) - 1)]
    hexes = np.concatenate([np.hstack([q + k * n_plan, q + (k + 1) * n_plan]) for k, q in enumerate(layers)])
    offset = n_plan * np.arange(n_skirt + 1)
    outer, inner = (plan.rings[name][:, None] + offset for name in ("outer", "inner"))
    faces = {
        "outer": wall_faces(outer),
        "inner": wall_faces(inner)[:, [1, 0, 3, 2]],
        "lid": plan.quads[plan.ring < inside],
        "tip": plan.quads[slot] + n_skirt * n_plan,
    }
    sets = _node_sets(plan, len(levels))
    mesh, number = _compact(nodes.reshape(-1, 3), hexes, sets, faces)
    walls = {"outside": number[outer], "inside": number[inner]}
    azimuth = np.linspace(0.0, np.pi, counts.azimuth + 1)
    depth = levels[: n_skirt + 1]
    return CaissonMesh(mesh, azimuth, depth, stand_on(depth, geometry.lines), walls, _section(mesh))


@dataclass(frozen=True)
class _Plan:
    """Points (n, 2), quads (k, 4) with the ring each belongs to (-1 in the core), and the named rings' nodes."""

    points: np.ndarray
    quads: np.ndarray
    ring: np.ndarray
    rings: dict[str, np.ndarray]


def depths(geometry: Geometry, counts: PlaneCounts) -> np.ndarray:
    """Return the depth levels of the cells, in m."""
    length, diameter = geometry.skirt_length, 2.0 * geometry.outer_radius
    if counts.own:
        skirt = graded_both(length, counts.skirt, counts.mudline * length, counts.toe * length)
        below = graded(length, geometry.domain_depth, counts.below, skirt[-1] - skirt[-2])
    else:
        skirt = down_the_skirt(length, diameter, counts.skirt, counts.mudline, counts.toe)
        toe = skirt[-1] - skirt[-2]
        below = away(length, geometry.domain_depth, counts.below, toe, BELOW * diameter / DIAMETER)
    levels = np.concatenate([through(skirt, geometry.lines), through(below, geometry.lines)[1:]])
    return halved_towards(levels, length, counts.halvings)


def outside(geometry: Geometry, counts: PlaneCounts) -> np.ndarray:
    """Return the radii of cells between skirt and side, in m."""
    radius, first = geometry.outer_radius, counts.wall * geometry.outer_radius
    if counts.own:
        levels = graded(radius, geometry.domain_radius, counts.outer, first)
    else:
        levels = away(radius, geometry.domain_radius, counts.outer, first, OUTSIDE * 2.0 * radius / DIAMETER)
    return halved_towards(levels, radius, counts.halvings)


def tip_radii(geometry: Geometry, counts: PlaneCounts) -> np.ndarray:
    """Return the radii of cells across the tip, in m."""
    inner, radius = geometry.inner_radius, geometry.outer_radius
    n = counts.tip
    if not counts.own:
        n = across_the_tip(radius - inner, 2.0 * radius, n, counts.wall * radius)
    return np.linspace(inner, radius, n * 2**counts.halvings + 1)


def skirt_cells(geometry: Geometry, levels: np.ndarray) -> int:
    """Return the number of cells between mudline and tip."""
    return int(np.argmin(np.abs(levels - geometry.skirt_length)))


def counted(geometry: Geometry, counts: AnyCounts) -> AnyCounts:
    """Return the counts of the cells that the mesh has: numbers of a preset as above, and lines of the geometry."""
    levels = depths(geometry, counts)
    skirt = skirt_cells(geometry, levels)
    beside = len(outside(geometry, counts)) - 1
    tip = len(tip_radii(geometry, counts)) - 1
    return replace(counts, skirt=skirt, below=len(levels) - 1 - skirt, outer=beside, tip=tip)


@dataclass(frozen=True)
class _Radii:
    """Radii of the rings of nodes inside the skirt (k,), across the tip and outside, without the first of each."""

    plug: np.ndarray
    tip: np.ndarray
    outside: np.ndarray


def _radii(geometry: Geometry, counts: Counts) -> _Radii:
    half_width, wall = 0.5 * geometry.inner_radius, counts.wall * geometry.outer_radius
    plug = graded(geometry.inner_radius, half_width, counts.plug, wall)[-2::-1]
    return _Radii(plug, tip_radii(geometry, counts)[1:], outside(geometry, counts)[1:])


def _plan(geometry: Geometry, n: int, radii: _Radii) -> _Plan:
    half_width = 0.5 * geometry.inner_radius
    core, core_quads, rim = core_square(n, half_width)
    plug = radii.plug
    angle = np.linspace(0.0, np.pi, n + 1)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    circle[np.abs(circle) < 1e-15] = 0.0
    # from the core's rim to the inner face of the skirt the rings pass gradually into circles
    share = ((plug - half_width) / (geometry.inner_radius - half_width))[:, None, None]
    inside = (1.0 - share) * core[rim] + share * geometry.inner_radius * circle
    circles = np.concatenate([radii.tip, radii.outside])[:, None, None] * circle
    points = np.concatenate([core, inside.reshape(-1, 2), circles.reshape(-1, 2)])
    step = np.pi / n
    points *= np.sqrt(step / np.sin(step))
    n_rings = len(plug) + len(radii.tip) + len(radii.outside)
    chain = np.vstack([rim, len(core) + np.arange(n_rings * (n + 1)).reshape(n_rings, n + 1)])
    quads = [np.stack([a[:-1], b[:-1], b[1:], a[1:]], axis=1) for a, b in itertools.pairwise(chain)]
    inner = len(plug)
    named = {"inner": chain[inner], "outer": chain[inner + len(radii.tip)], "domain": chain[-1]}
    ring = np.concatenate([np.full(len(core_quads), -1), np.repeat(np.arange(n_rings), n)])
    return _Plan(points, np.concatenate([core_quads, *quads]), ring, named)


def core_square(n: int, half_width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a half square with rounded sides: points, quads and the rim nodes ordered by azimuth."""
    nx, ny = n // 2, n // 4
    xi, eta = np.meshgrid(np.linspace(-1.0, 1.0, nx + 1), np.linspace(0.0, 1.0, ny + 1), indexing="ij")
    disc = np.stack([xi * np.sqrt(1.0 - eta**2 / 2.0), eta * np.sqrt(1.0 - xi**2 / 2.0)], axis=-1)
    square = np.stack([xi, eta], axis=-1)
    points = half_width * (0.4 * square + 0.5 * disc)
    index = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    rim = np.concatenate([index[-1, :], index[-2::-1, -1], index[0, -2::-1]])
    return points.reshape(-1, 2), quads, rim


def wall_faces(wall: np.ndarray) -> np.ndarray:
    """Return the faces (k, 4) of a wall of nodes (na, nz) with the normal away from the axis."""
    corners = [wall[:-1, :-1], wall[1:, :-1], wall[1:, 1:], wall[:-1, 1:]]
    return np.stack([c.ravel() for c in corners], axis=1)


def _node_sets(plan: _Plan, n_levels: int) -> dict[str, np.ndarray]:
    """Return the symmetry plane, side and bottom of the domain."""
    n_plan = len(plan.points)
    offset = n_plan * np.arange(n_levels)[:, None]
    plane = np.flatnonzero(np.abs(plan.points[:, 1]) < 1e-12)
    return {
        "symmetry": (plane + offset).ravel(),
        "side": (plan.rings["domain"] + offset).ravel(),
        "bottom": np.arange(n_plan) + (n_levels - 1) * n_plan,
    }


def _compact(
    nodes: np.ndarray, hexes: np.ndarray, sets: dict[str, np.ndarray], faces: dict[str, np.ndarray]
) -> tuple[Mesh, np.ndarray]:
    """Drop the nodes that no element uses; return the mesh and the new number of each old node (-1: dropped)."""
    used = np.zeros(len(nodes), dtype=bool)
    used[hexes] = True
    number = np.where(used, np.cumsum(used) - 1, -1)
    node_sets = {name: number[ids][number[ids] >= 0] for name, ids in sets.items()}
    return Mesh(nodes[used], number[hexes], node_sets, {k: number[f] for k, f in faces.items()}), number


def _section(mesh: Mesh) -> np.ndarray:
    """Return the quads (k, 4) of the element faces that lie in the symmetry plane y = 0."""
    local = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    quads = mesh.hexes[:, local].reshape(-1, 4)
    return quads[(np.abs(mesh.nodes[quads, 1]) < 1e-9).all(axis=1)]


def through(levels: np.ndarray, lines: Sequence[float]) -> np.ndarray:
    """Return levels (m,) that stand on all ``lines``, with cells about as large as those of ``levels`` (n + 1,).

    Between two lines the cells follow the grading of ``levels``; each gap has one at the least. Lines beyond the ends
    do not count. Without lines between the levels these are returned as they are.
    """
    room = _SAME * (levels[-1] - levels[0])
    new = [x for x in lines if levels[0] + room < x < levels[-1] - room and np.min(np.abs(levels - x)) > room]
    if not new:
        return levels
    fixed = np.unique(np.concatenate([levels[[0, -1]], levels[stand_on(levels, lines)], new]))
    rank = np.interp(fixed, levels, np.arange(len(levels)))
    parts = [fixed[:1]]
    for a, b in zip(range(len(fixed) - 1), range(1, len(fixed)), strict=True):
        n = max(1, round(float(rank[b] - rank[a])))
        inner = np.interp(np.linspace(rank[a], rank[b], n + 1)[1:-1], np.arange(len(levels)), levels)
        parts += [inner, fixed[b : b + 1]]
    return np.concatenate(parts)


def stand_on(levels: np.ndarray, lines: Sequence[float]) -> np.ndarray:
    """Return which levels (n,) bool stand on a line."""
    room = _SAME * (levels[-1] - levels[0])
    return np.array([any(abs(x - line) <= room for line in lines) for x in levels])
