# SPDX-License-Identifier: MIT
"""Scene -> engine model: the only place that renames, and that decides what is carried (`omissions` lists the rest).

The engine has z down and y to the right of x, seen from above: its rotation about +y is positive where the tip of a
skirt moves towards +x. Everywhere else in pysprings rotation and M are positive where the caisson leans in the
direction of a positive H: about y to the left of x, with z up. Here signs turn, and nowhere else: the border dofs of a
model are those of the field (with w and V down), so its forces are those of the field.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_engine.elements import hex8, interface, rigid, solid_shell
from fe_engine.errors import MeshError
from fe_engine.mesh import Quality
from fe_engine.model import Linear, Model
from pysprings.core.arrays import Array
from pysprings.model.contact import SURFACE, contact_of
from pysprings.model.mesh import PRESETS, SURFACES, CaissonMesh, Counts, Geometry, make_mesh, refine
from pysprings.model.soil_laws import soil_materials
from pysprings.model.steel import SteelMesh, make_steel, with_steel
from pysprings.model.water import beside_steel, make_water
from pysprings.scene.model import Scene


@dataclass(frozen=True)
class Built:
    """A model with the mesh it came from and the vertical dead load of the half caisson (N).

    ``film_mesh_node`` is the mesh node of each film node (none when drained); ``steel`` is None where the caisson is
    rigid, and its nodes stand behind those of the soil in ``model.mesh`` (not in ``caisson.mesh``).
    """

    model: Model
    caisson: CaissonMesh
    quality: Quality
    balanced_load: float
    extra_load: float
    film_mesh_node: np.ndarray
    steel: SteelMesh | None = None

    def extra_load_of(self, load: float | str) -> float:
        """Return what a vertical load (N, whole caisson) has beyond the balanced one (N, half caisson)."""
        return extra_load(load, self.balanced_load)

    @property
    def part(self) -> float:
        """Part of the caisson that the model has."""
        return 0.5


def geometry_of(scene: Scene) -> Geometry:
    """Return the radii and depths of the scene, in m."""
    outer, extent = 0.5 * scene.caisson.outer_diameter, scene.extent
    return Geometry(
        inner_radius=outer - scene.caisson.skirt_thickness,
        outer_radius=outer,
        skirt_length=scene.caisson.skirt_length,
        domain_radius=extent.radius,
        domain_depth=extent.depth,
        lines=scene.ground.lines,
    )


def counts_of(scene: Scene) -> Counts:
    """Return the cell counts of the scene's preset, refined and overridden by the scene."""
    counts = PRESETS[scene.mesh.preset]
    if scene.mesh.refinement != 1.0:
        counts = refine(counts, scene.mesh.refinement)
    if scene.mesh.azimuth is not None:
        counts = replace(counts, azimuth=scene.mesh.azimuth)
    return counts


def build_model(scene: Scene) -> Built:
    """Build the half model of a scene (loads and reactions of the model are half the caisson's)."""
    return build_on(scene, _mesh(geometry_of(scene), counts_of(scene)))


def build_on(scene: Scene, caisson: CaissonMesh) -> Built:
    """Build the model of a scene on a mesh of the caisson and its soil."""
    geometry, mesh = geometry_of(scene), caisson.mesh
    quality = mesh.check()
    fixed, frames = _constraints(scene, caisson)
    stations = make_stations(geometry, caisson)
    pressure = initial_pressure(scene, stations)
    balanced = float(np.sum(pressure * stations.area * stations.frame[:, 0, 2]))
    water, film_mesh_node = make_water(scene, caisson, stations)
    steel = None if scene.caisson.behaviour == "rigid" else make_steel(caisson, scene.caisson.lid_thickness)
    depth = hex8.gauss_positions(mesh.nodes, mesh.hexes)[:, :, 2]
    materials, material = soil_materials(scene, depth)
    law, contact = contact_of(scene, stations, caisson.walls["inside"])
    model = Model(
        mesh=mesh,
        materials=materials,
        material=material,
        initial_stress=initial_stress(scene, depth),
        fixed=fixed,
        frames=frames,
        n_border=len(rigid.PLANE),
        border_scale=np.array([1.0, 1.0, geometry.outer_radius]),
        stations=stations,
        contact=contact,
        contact_laws=(law,),
        initial_pressure=pressure,
        water=water,
    )
    extra = extra_load(scene.caisson.vertical_load, balanced)
    if steel is not None:
        model = _add_steel(scene, model, steel)
    return Built(model, caisson, quality, balanced, extra, film_mesh_node, steel)


def _add_steel(scene: Scene, model: Model, steel: SteelMesh) -> Model:
    """Put the steel between the stations and the rigid motion."""
    assert model.stations is not None
    n, k = model.mesh.n_nodes, len(steel.nodes)
    mesh = replace(model.mesh, nodes=np.concatenate([model.mesh.nodes, steel.nodes]))
    fixed = np.concatenate([model.fixed, np.zeros((k, 3), dtype=bool)])
    fixed[steel.symmetry, 1] = True
    fixed[steel.held] = True
    nodes, weight = with_steel(model.stations, steel)
    stiffness = solid_shell.stiffness(mesh.nodes, steel.hexes, scene.caisson.young_modulus, scene.caisson.poisson_ratio)
    return replace(
        model,
        mesh=mesh,
        fixed=fixed,
        stations=replace(model.stations, nodes=nodes, weight=weight),
        linear=Linear(steel.hexes, stiffness),
        water=None if model.water is None else beside_steel(model.water, n, k),
    )


def extra_load(load: float | str, balanced: float, part: float = 0.5) -> float:
    """Return what a vertical load (N, whole caisson) has beyond the balanced one (N) of this part of the caisson."""
    return 0.0 if load == "balanced" else part * float(load) - balanced


def _mesh(geometry: Geometry, counts: Counts) -> CaissonMesh:
    try:
        return make_mesh(geometry, counts)
    except ValueError as error:  # the growth of cell sizes has no solution
        message = "cells cannot be graded in this geometry; change mesh.refinement, the preset or the domain"
        raise MeshError(message) from error


def make_stations(geometry: Geometry, caisson: CaissonMesh) -> interface.Stations:
    """Return the stations on the skirt (outside, inside), under the lid and under the tip.

    Nodal, but central on the faces of the tip that meet a wall: the nodes there carry the wall's stations.
    """
    nodes = caisson.mesh.nodes
    walls = np.unique(np.concatenate([wall.ravel() for wall in caisson.walls.values()]))
    parts = []
    for name in SURFACES:
        faces = caisson.mesh.face_sets[name]
        at_wall = np.isin(faces, walls).any(axis=1) & (name == "tip")
        groups = [interface.central_stations(nodes, faces[at_wall]), _nodal(nodes, faces[~at_wall], name)]
        parts += [(*columns, np.full(len(columns[0]), SURFACE[name])) for columns in groups]
    near, weight, normal, area, surface = (np.concatenate(column) for column in zip(*parts, strict=True))
    position = np.einsum("sa,sai->si", weight, nodes[near])
    return interface.Stations(
        position=position,
        frame=interface.local_frames(normal),
        area=area,
        nodes=near,
        weight=weight,
        body=body_operator(position),
        surface=surface,
    )


def _nodal(nodes: np.ndarray, faces: np.ndarray, surface: str) -> tuple[np.ndarray, ...]:
    """Return the nodal stations in the shape of central ones: four times the same node, all weight on the first."""
    node, normal, area = interface.nodal_stations(nodes, faces, _exact_normals(nodes, surface))
    weight = np.tile([1.0, 0.0, 0.0, 0.0], (len(node), 1))
    return np.repeat(node[:, None], 4, axis=1), weight, normal, area


def _exact_normals(nodes: np.ndarray, surface: str) -> np.ndarray:
    """Return the unit normals (n, 3) from the caisson into the soil, as if every node stood on the surface."""
    normal = np.zeros_like(nodes)
    if surface in ("lid", "tip"):
        normal[:, 2] = 1.0
        return normal
    radius = np.maximum(np.hypot(nodes[:, 0], nodes[:, 1]), 1e-300)
    sign = 1.0 if surface == "outer" else -1.0
    normal[:, :2] = sign * nodes[:, :2] / radius[:, None]
    return normal


def initial_stress(scene: Scene, depth: np.ndarray) -> np.ndarray:
    """Return the geostatic stress (..., 6), tension positive."""
    ground = scene.ground
    vertical = ground.vertical_stress(depth)
    stress = np.zeros((*depth.shape, 6))
    stress[..., 0] = stress[..., 1] = -ground.value("K0", depth) * vertical
    stress[..., 2] = -vertical
    return stress


def initial_pressure(scene: Scene, stations: interface.Stations) -> np.ndarray:
    """Return the contact pressure (ns,) that the geostatic stress puts on each station, in Pa."""
    ground, depth = scene.ground, stations.position[:, 2]
    upright = stations.frame[:, 0, 2] ** 2
    return ground.vertical_stress(depth) * (upright + ground.value("K0", depth) * (1.0 - upright))


def _constraints(scene: Scene, caisson: CaissonMesh) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Return the fixed dofs (n, 3) and the radial frames of the side's nodes."""
    mesh = caisson.mesh
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    frames: dict[int, np.ndarray] = {}
    fixed[mesh.node_sets["symmetry"], 1] = True
    side = mesh.node_sets["side"]
    if scene.domain.side == "roller":
        for node in side:
            x, y = mesh.nodes[node, :2] / np.hypot(*mesh.nodes[node, :2])
            if abs(y) > 1e-12:
                frames[int(node)] = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
        fixed[side, 0] = True
    else:
        fixed[side] = True
    fixed[mesh.node_sets["bottom"]] = True
    return fixed, frames


# --- signs of the field in a model of the engine ---

# u_x, u_y, w, rot_x, rot_y, rot_z of the field over those of the engine
SIGNS = np.array([1.0, -1.0, 1.0, 1.0, -1.0, -1.0])


def body_operator(position: Array, dofs: tuple[int, ...] = rigid.PLANE) -> Array:
    """Return R (n, 3, nb) with displacement = R @ q at positions (n, 3) [m] of the engine, about the lid centre.

    q are these of u_x, u_y, w, rot_x, rot_y, rot_z; by default (u, w, rotation): u_x = u - rotation z and
    u_z = w + rotation x, z down.
    """
    operator = rigid.displacement_operator(position, np.zeros(3)) * SIGNS
    return np.ascontiguousarray(operator[:, :, dofs])


def moments(position: Array, force: Array) -> Array:
    """Return the moments (n,) [N m] about the lid centre of forces (n, 3) [N] at positions (n, 3) [m]."""
    return np.asarray(force[:, 2] * position[:, 0] - force[:, 0] * position[:, 2])
