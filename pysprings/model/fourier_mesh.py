# SPDX-License-Identifier: MIT
"""Section (r, z) of the soil around a caisson for Fourier series: quadratic quads, fine beside the toe.

Lines stand on the axis, both faces of the skirt and the side, and on mudline, toe and bottom. The skirt has its
thickness: its slot holds no elements.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_engine.fourier_model import SectionMesh
from pysprings.model.mesh import Geometry, PlaneCounts, depths, graded, halved_towards, outside, skirt_cells, tip_radii
from pysprings.model.steel import AROUND, PATCH
from pysprings.scene.model import Scene


@dataclass(frozen=True)
class SectionCounts(PlaneCounts):
    """Counts with the highest harmonic N of the series.

    The soil law is evaluated at N + 3 azimuths of the half circle, contact at N + 1.
    """

    harmonics: int


# A name means an error of the load of 5, 2, 1, 0.5 % after extrapolation from the section and its coarser one, with the
# harmonics that a run finds: data/evidence/sections.csv. Eight elements along the skirt, and five on the coarser
# section, resolve p(z). What a clay carries at collapse is too large by a share of the cells at wall and toe; cells of
# their size make sand localise.
FRICTIONAL, COHESIVE = "frictional", "cohesive"
_SAND = {
    "coarse": SectionCounts(plug=3, outer=6, tip=1, skirt=8, below=5, wall=0.08, mudline=0.15, toe=0.04, harmonics=3),
    "medium": SectionCounts(plug=4, outer=8, tip=1, skirt=8, below=7, wall=0.06, mudline=0.15, toe=0.03, harmonics=3),
    "paper": SectionCounts(plug=4, outer=9, tip=1, skirt=8, below=8, wall=0.05, mudline=0.15, toe=0.025, harmonics=3),
    "fine": SectionCounts(plug=6, outer=12, tip=1, skirt=11, below=11, wall=0.03, mudline=0.1, toe=0.015, harmonics=5),
}
_CLAY = {
    "coarse": SectionCounts(plug=5, outer=7, tip=1, skirt=8, below=6, wall=0.02, mudline=0.15, toe=0.02, harmonics=3),
    "medium": SectionCounts(plug=6, outer=10, tip=1, skirt=11, below=8, wall=0.01, mudline=0.12, toe=0.01, harmonics=3),
    "paper": SectionCounts(plug=7, outer=12, tip=1, skirt=11, below=9, wall=0.007, mudline=0.1, toe=0.007, harmonics=3),
    "fine": SectionCounts(plug=9, outer=15, tip=1, skirt=13, below=12, wall=0.004, mudline=0.1, toe=0.004, harmonics=5),
}
PRESETS = {FRICTIONAL: _SAND, COHESIVE: _CLAY}
_LEAST_SKIRT = 3  # elements: fewer cannot have two sizes at their ends and grow in between
# Elements under the lid of an elastic caisson, over those of a rigid one: K_M of a lid of 0.1 m (D 8 m, `coarse`) is
# 4 % above the limit of finer meshes, with as many as a rigid one 26 %
LID = 3


@dataclass(frozen=True)
class CaissonSection:
    """The section and what extraction needs of it.

    depth : (nz,) m of the nodes of the skirt's faces, three an element; walls : side -> (nz,) nodes; lid, tip : nodes
    by radius, faces' corners included.
    """

    mesh: SectionMesh
    depth: np.ndarray
    walls: dict[str, np.ndarray]
    lid: np.ndarray
    tip: np.ndarray

    @property
    def lines(self) -> dict[str, np.ndarray]:
        """Nodes along each surface of the caisson, three an element."""
        return {"outer": self.walls["outside"], "inner": self.walls["inside"], "lid": self.lid, "tip": self.tip}


def make_section(geometry: Geometry, counts: SectionCounts, patch: bool = False) -> CaissonSection:
    """Build the section of the soil; elements end at the edge of the lid's stiff ``patch`` (see steel.PATCH)."""
    r, z = _radii(geometry, counts, patch), depths(geometry, counts)
    i, j = np.meshgrid(np.arange(len(r) - 1), np.arange(len(z) - 1), indexing="ij")
    inner, toe = 2 * int(np.argmin(np.abs(r - geometry.inner_radius))), 2 * skirt_cells(geometry, z)
    outer = inner + 2 * (len(tip_radii(geometry, counts)) - 1)
    slot = (2 * i >= inner) & (2 * i < outer) & (2 * j < toe)
    # nodes on a grid of half elements
    a, b = 2 * i[~slot], 2 * j[~slot]
    width = 2 * len(z) - 1
    grid = np.stack([(a + p) * width + b + q for p, q in AROUND], axis=1)
    points = np.stack(np.meshgrid(_halved(r), _halved(z), indexing="ij"), axis=-1).reshape(-1, 2)
    used = np.unique(grid)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))

    def line(p: np.ndarray | int, q: np.ndarray | int) -> np.ndarray:
        corners = number[np.asarray(p) * width + np.asarray(q)]
        return np.asarray(corners[corners >= 0])

    down, whole = np.arange(toe + 1), np.arange(2 * len(r) - 1)
    sets = {"side": line(2 * len(r) - 2, np.arange(width)), "bottom": line(whole, width - 1)}
    mesh = SectionMesh(points[used], number[grid], sets)
    return CaissonSection(
        mesh, _halved(z)[: toe + 1], {"outside": line(outer, down), "inside": line(inner, down)},
        line(np.arange(inner + 1), 0), line(np.arange(inner, outer + 1), toe),
    )  # fmt: skip


def ground_of_sections(scene: Scene) -> str:
    """Return which sections a scene has: those of clay where all of its ground is under total stress."""
    return COHESIVE if scene.ground.total_stress else FRICTIONAL


def refine_section(counts: SectionCounts, factor: float) -> SectionCounts:
    """Scale all numbers of elements by a factor, and the first sizes by its inverse; the harmonics stay.

    At least three elements stand along the skirt.
    """
    scaled = {n: max(1, round(getattr(counts, n) * factor)) for n in ("plug", "outer", "tip", "skirt", "below")}
    scaled["skirt"] = max(_LEAST_SKIRT, scaled["skirt"])
    sizes = {n: getattr(counts, n) / factor for n in ("wall", "mudline", "toe")}
    return replace(counts, **sizes, **scaled)


def _radii(geometry: Geometry, counts: SectionCounts, patch: bool) -> np.ndarray:
    wall = counts.wall * geometry.outer_radius
    if patch:  # takes the place of the element at the axis; the lid that bends around it has more elements than soil
        edge = PATCH * geometry.inner_radius
        plug = np.append(graded(geometry.inner_radius, edge, LID * counts.plug - 1, wall), 0.0)[::-1]
    else:
        plug = graded(geometry.inner_radius, 0.0, counts.plug, wall)[::-1]
    plug[0] = 0.0
    plug = halved_towards(plug, geometry.inner_radius, counts.halvings)
    return np.concatenate([plug, tip_radii(geometry, counts)[1:], outside(geometry, counts)[1:]])


def _halved(lines: np.ndarray) -> np.ndarray:
    """Return the lines with the middles between them."""
    halved = np.empty(2 * len(lines) - 1)
    halved[::2], halved[1::2] = lines, 0.5 * (lines[1:] + lines[:-1])
    return halved
