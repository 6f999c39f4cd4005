# SPDX-License-Identifier: MIT
"""Scene -> Fourier model of the engine, as `build` makes one of bricks."""

from dataclasses import dataclass, replace

import numpy as np

from fe_engine.elements import fourier as elements, interface, rigid
from fe_engine.errors import MeshError
from fe_engine.fourier_model import FourierModel, RingStations, SectionMesh
from fe_engine.mesh import Quality
from pysprings.model.build import (
    Built,
    body_operator,
    build_model,
    extra_load,
    geometry_of,
    initial_pressure,
    initial_stress,
)
from pysprings.model.contact import SURFACE, contact_of
from pysprings.model.fourier_mesh import (
    PRESETS,
    CaissonSection,
    SectionCounts,
    ground_of_sections,
    make_section,
    refine_section,
)
from pysprings.model.soil_laws import soil_materials
from pysprings.model.steel import SteelRings, add_steel, make_steel_rings
from pysprings.model.water import make_series_water
from pysprings.scene.model import Scene

SIDES = {"outside": "outer", "inside": "inner"}


@dataclass(frozen=True)
class BuiltFourier:
    """A Fourier model with the section it came from and the vertical dead load (N) of its part of the caisson.

    ``azimuth`` are the azimuths (na,) of the stations.
    """

    model: FourierModel
    section: CaissonSection
    azimuth: np.ndarray
    quality: Quality
    balanced_load: float
    extra_load: float
    steel: SteelRings | None = None

    def extra_load_of(self, load: float | str) -> float:
        """Return what a vertical load (N, whole caisson) has beyond the balanced one (N, of the model)."""
        return extra_load(load, self.balanced_load, self.part)

    @property
    def part(self) -> float:
        """Part of the caisson that the model has: all, or half."""
        return 1.0 if self.model.whole else 0.5


def section_counts_of(scene: Scene) -> SectionCounts:
    """Return the numbers of elements and harmonics of the scene's preset, as the scene overrides them."""
    counts = PRESETS[ground_of_sections(scene)][scene.mesh.preset]
    if scene.mesh.refinement != 1.0:
        counts = refine_section(counts, scene.mesh.refinement)
    harmonics = counts.harmonics if scene.mesh.harmonics is None else scene.mesh.harmonics
    return replace(counts, harmonics=harmonics, halvings=scene.mesh.halvings)


def build_fourier(scene: Scene, whole: bool = False) -> BuiltFourier:
    """Build the half model of a scene (loads and reactions of the model are half the caisson's), or the whole one."""
    return build_on_section(scene, section_counts_of(scene), whole)


def build_torsion(scene: Scene) -> BuiltFourier:
    """Build the whole model of a scene in torsion alone, on the section of its series; at rest water takes no part."""
    return build_on_section(scene, replace(section_counts_of(scene), harmonics=0), whole=True)


def azimuths_of(harmonics: int, whole: bool) -> tuple[int, int]:
    """Return the numbers of azimuths of the soil law and of the stations, of half a circle or the whole one.

    Around the whole circle a pull is to have the same answer in every direction: with 13, 19, 24 azimuths of the law
    and N 3 the force across it is up to 0.6, 0.25, 0.05 % of H. Where a pull points at one of 2 N + 2 stations, and
    away from another, they stick and slip in turn (four times the Newton steps); 2 N + 1 rarely do.
    """
    return (max(24, 2 * harmonics + 14), 2 * harmonics + 1) if whole else (harmonics + 3, harmonics + 1)


def build_on_section(scene: Scene, counts: SectionCounts, whole: bool = False) -> BuiltFourier:
    """Build the model of a scene with these numbers of elements and harmonics."""
    section = section_of(scene, counts)
    mesh, harmonics = section.mesh, counts.harmonics
    quality, (law_azimuths, contact_azimuths) = mesh.check(), azimuths_of(harmonics, whole)
    dofs = rigid.SPACE if whole else rigid.PLANE
    azimuth = elements.azimuths(contact_azimuths, whole)
    stations = make_ring_stations(section, azimuth, dofs)
    pressure = initial_pressure(scene, stations)
    balanced = float(np.sum(pressure * stations.area * stations.frame[:, 0, 2]))
    depth = elements.gauss_positions(mesh.nodes, mesh.quads)[:, :, 1]
    materials, material = soil_materials(scene, depth)
    law, contact = contact_of(scene, stations, section.walls["inside"])
    water = make_series_water(scene, section, stations, harmonics, whole) if harmonics else None  # none in torsion
    model = FourierModel(
        mesh=mesh,
        harmonics=harmonics,
        azimuths=law_azimuths,
        materials=materials,
        material=material,
        initial_stress=initial_stress(scene, np.repeat(depth, law_azimuths, axis=1)),
        fixed=fixed_directions(scene, mesh),
        n_border=len(dofs),
        border_scale=np.where(np.array(dofs) < 3, 1.0, geometry_of(scene).outer_radius),
        stations=stations,
        contact=contact,
        contact_laws=(law,),
        initial_pressure=pressure,
        water=water,
        whole=whole,
    )
    steel = None if scene.caisson.behaviour == "rigid" else make_steel_rings(section, scene.caisson.lid_thickness)
    if steel is not None:
        model = add_steel(model, steel, scene.caisson.young_modulus, scene.caisson.poisson_ratio)
    extra = extra_load(scene.caisson.vertical_load, balanced, 1.0 if whole else 0.5)
    return BuiltFourier(model, section, azimuth, quality, balanced, extra, steel)


def section_of(scene: Scene, counts: SectionCounts) -> CaissonSection:
    """Make the section of a scene with these numbers of elements. Raises MeshError."""
    try:
        return make_section(geometry_of(scene), counts, patch=scene.caisson.behaviour == "elastic")
    except ValueError as error:  # the growth of cell sizes has no solution
        message = "elements cannot be graded in this geometry; change mesh.refinement, the preset or the domain"
        raise MeshError(message) from error


def make_ring_stations(
    section: CaissonSection, azimuth: np.ndarray, dofs: tuple[int, ...] = rigid.PLANE
) -> RingStations:
    """Return the stations at every azimuth on the nodes of the skirt, the lid and the tip.

    The corners of the tip carry stations of the wall and of the tip. Without the latter the load depends on the number
    of elements across the tip: one is 0.4 % below four at 2.5 mm of the paper's pull, 1 % at 20 mm.
    """
    nodes = section.mesh.nodes
    radius, depth = nodes[:, 0], nodes[:, 1]
    parts = []
    for name, line in section.lines.items():
        area = nodal_rings(radius[line]) if name in ("lid", "tip") else nodal_lengths(depth[line]) * radius[line]
        parts.append((line, area, np.full(len(line), SURFACE[name])))
    node, strip, surface = (np.concatenate(part) for part in zip(*parts, strict=True))
    felt = strip > 0.0  # none on the axis
    node, strip, surface = node[felt], strip[felt], surface[felt]
    angle = np.tile(azimuth, len(node))
    node, surface = np.repeat(node, len(azimuth)), np.repeat(surface, len(azimuth))
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    position = np.concatenate([radius[node, None] * around, depth[node, None]], axis=1)
    normal = np.zeros_like(position)
    upright = (surface == SURFACE["lid"]) | (surface == SURFACE["tip"])
    normal[upright, 2] = 1.0
    outwards = np.where(surface == SURFACE["outer"], 1.0, -1.0)[:, None]
    normal[~upright, :2] = (outwards * around)[~upright]
    return RingStations(
        position=position,
        frame=interface.local_frames(normal),
        area=np.repeat(strip, len(azimuth)) * elements.span(dofs == rigid.SPACE) / len(azimuth),
        nodes=node[:, None],
        weight=np.ones((len(node), 1)),
        body=body_operator(position, dofs),
        surface=surface,
        azimuth=angle,
    )


def nodal_lengths(x: np.ndarray) -> np.ndarray:
    """Return the integrals of the quadratic shape functions of a line (Simpson) over nodes at x, three an element."""
    lengths, step = np.zeros(len(x)), x[2::2] - x[:-2:2]
    for first, share in zip((0, 1, 2), (1.0, 4.0, 1.0), strict=True):
        lengths[first : len(x) - 2 + first : 2] += share * step / 6.0
    return lengths


def nodal_rings(r: np.ndarray) -> np.ndarray:
    """Return the integrals of the quadratic shape functions times r, m2 per radian; they add up to that of r."""
    areas, start, step = np.zeros(len(r)), r[:-2:2], r[2::2] - r[:-2:2]
    for first, (constant, slope) in enumerate([(1 / 6, 0.0), (2 / 3, 1 / 3), (1 / 6, 1 / 6)]):
        areas[first : len(r) - 2 + first : 2] += step * (constant * start + slope * step)
    return areas


def fixed_directions(scene: Scene, mesh: SectionMesh) -> np.ndarray:
    """Return the fixed directions (n, 3) of the side and the bottom."""
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    side = mesh.node_sets["side"]
    fixed[side, 0] = True
    if scene.domain.side != "roller":
        fixed[side] = True
    fixed[mesh.node_sets["bottom"]] = True
    return fixed


# --- scene -> model in the scene's discretisation ---


def build(scene: Scene) -> Built | BuiltFourier:
    """Build the model of a scene in its discretisation. Raises FEError."""
    return build_fourier(scene) if scene.discretisation == "fourier" else build_model(scene)
