# SPDX-License-Identifier: MIT
"""Scene -> pore water of soil and interface: what flows, where it drains, which film joins the faces."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fe_engine.elements import biot, interface
from fe_engine.elements.interface import Film, Stations
from fe_engine.fourier_model import SectionMesh
from fe_engine.mesh import Mesh
from fe_engine.model import Water
from fe_engine.soil.elastic import moduli
from pysprings.model.mesh import SURFACES, CaissonMesh
from pysprings.scene.ground import ground_of

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

# An undrained path lasts this share of the time in which water crosses the smallest cell: nothing flows.
_UNDRAINED = 1.0e-6


def make_water(scene: Scene, caisson: CaissonMesh, stations: Stations) -> tuple[Water | None, np.ndarray]:
    """Return the water of the scene, and the mesh node of each film node; None and no film where it is drained."""
    if scene.drainage.mode == "drained":
        return None, np.zeros(0, dtype=np.int64)
    mesh, drainage = caisson.mesh, scene.drainage
    film_mesh_node, film = _film(scene, mesh, stations)
    fixed = _drained_nodes(scene, caisson)
    depth = _depths(scene, mesh)
    bulk, shear = _moduli(scene, depth)
    modulus = drainage.water_bulk_modulus
    water = Water(
        mobility=mobility(scene, depth),
        storage=0.0 if isinstance(modulus, str) else drainage.porosity / modulus,
        stabilisation=drainage.stabilisation * biot.projection_factor(bulk, shear),
        fixed=np.concatenate([fixed, fixed[film_mesh_node]]),
        initial=np.zeros(mesh.n_nodes + film.n_nodes),
        scale=float(np.median(shear)) / _cell_size(mesh),
        film=film,
    )
    return water, film_mesh_node


def beside_steel(water: Water, n: int, k: int) -> Water:
    """Return the water of a model whose n nodes are followed by k of impervious steel, which hold no pressure."""
    return replace(
        water,
        fixed=np.insert(water.fixed, n, np.ones(k, dtype=bool)),
        initial=np.insert(water.initial, n, np.zeros(k)),
        film=None if water.film is None else replace(water.film, sealed=True),
    )


def mobility(scene: Scene, depth: np.ndarray) -> np.ndarray:
    """Return the hydraulic conductivity over the unit weight of water, m2/(Pa s), at depths (...,) in m."""
    return ground_of(scene).value("hydraulic_conductivity", depth) / scene.drainage.water_unit_weight


def _depths(scene: Scene, mesh: Mesh) -> np.ndarray:
    """Return depths (ne,) m of the centres of the elements; one depth, (), where the ground is the same everywhere."""
    if ground_of(scene).is_uniform:
        return np.array(0.0)
    return np.asarray(mesh.nodes[mesh.hexes].mean(axis=1)[:, 2])


def _moduli(scene: Scene, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return K and G in Pa at depths (...,) in m."""
    ground = ground_of(scene)
    bulk, shear = moduli(ground.value("young_modulus", depth), ground.value("poisson_ratio", depth))
    return np.asarray(bulk), np.asarray(shear)


def undrained_time(scene: Scene, mesh: Mesh | SectionMesh) -> float:
    """Return the time of an undrained path, s: a millionth of h2/c_v, with the shortest edge h and the largest c_v.

    c_v = k M/gamma_w, M = K + 4 G/3.
    """
    depth = np.unique(mesh.nodes[:, -1])
    bulk, shear = _moduli(scene, depth)
    consolidation = float(np.max(mobility(scene, depth) * (bulk + 4.0 * shear / 3.0)))
    return _UNDRAINED * mesh.shortest_edge() ** 2 / consolidation


def _cell_size(mesh: Mesh) -> float:
    """Return the typical edge of the cells, m: most of them are near the caisson."""
    return float(np.median(np.linalg.norm(mesh.nodes[mesh.hexes[:, 6]] - mesh.nodes[mesh.hexes[:, 0]], axis=1)))


def _drained_nodes(scene: Scene, caisson: CaissonMesh) -> np.ndarray:
    """Return nodes (n,) bool at hydrostatic pressure: mudline outside the caisson, and a side that drains."""
    mesh = caisson.mesh
    radius = np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1])
    rim = radius[caisson.walls["outside"][:, 0]].min()
    fixed: np.ndarray = (mesh.nodes[:, 2] == 0.0) & (radius > rim * (1.0 - 1e-9))
    if scene.domain.side_drainage == "drained":
        fixed[mesh.node_sets["side"]] = True
    return fixed


def _film(scene: Scene, mesh: Mesh, stations: Stations) -> tuple[np.ndarray, Film]:
    """Return one film from mudline outside round the tip to the lid: mesh node of each film node, and the film."""
    faces = np.concatenate([mesh.face_sets[name] for name in SURFACES])
    surface = np.repeat(np.arange(len(SURFACES)), [len(mesh.face_sets[name]) for name in SURFACES])
    node = np.unique(faces)
    number = np.full(mesh.n_nodes, -1)
    number[node] = np.arange(len(node))
    gradient, area = interface.film_geometry(mesh.nodes[node], number[faces])
    film = Film(
        n_nodes=len(node),
        nodes=number[stations.nodes],
        weight=stations.weight,
        faces=number[faces],
        corners=_corners(faces, surface, stations),
        gradient=gradient,
        area=area,
        residual_aperture=scene.interface.residual_aperture,
        transfer=scene.interface.transversal_conductivity,
        viscosity=scene.drainage.water_viscosity,
    )
    return node, film


def _corners(faces: np.ndarray, surface: np.ndarray, stations: Stations) -> np.ndarray:
    """Return the station (m, 4) of the gap at each corner of each face: the central one of the face or the node's."""
    central = stations.weight[:, 0] < 1.0
    of_face = {tuple(stations.nodes[k]): k for k in np.flatnonzero(central)}
    of_node = {(stations.surface[k], stations.nodes[k, 0]): k for k in np.flatnonzero(~central)}
    corners = []
    for nodes, on in zip(faces, surface, strict=True):
        own = of_face.get(tuple(nodes))
        corners.append([own] * 4 if own is not None else [of_node[on, node] for node in nodes])
    return np.array(corners)
