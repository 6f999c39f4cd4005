# SPDX-License-Identifier: MIT
"""Steel of an elastic caisson: solid shells of skirt and lid that match the soil's mesh node by node.

Every soil node on a wall or under the lid has a steel node at its place; the lid has another layer of nodes on its top.
Skirt and lid are one element thick and share the nodes of the skirt's upper edge. Soil nodes under the tip that lie
between the walls go with the mean of the wall's nodes there, by their place.

The displacement of steel nodes is counted from the rigid motion (u, w, rotation), which strains nothing. Its own rigid
part is taken out by holding a stiff patch at the lid's centre, over its whole thickness: (u, w, rotation) is therefore
the motion of that patch, and the load acts on it ("imposed at the top centre", Cerfontaine et al. 2018). The patch is
the foot of whatever stands on the caisson; a load on a single node would indent the lid the more the finer the mesh.

The steel of a section (`make_steel_rings`) stands where that of the bricks does, and its displacement is counted from
the same rigid motion. With 2 x 2 points one element through the thickness bends without locking.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fe_engine.elements import fourier as elements
from fe_engine.elements.interface import Stations
from fe_engine.fourier_model import FourierModel, LinearRings, SectionMesh
from fe_engine.soil.elastic import elastic_matrix
from pysprings.model.mesh import CaissonMesh, wall_faces

if TYPE_CHECKING:
    from pysprings.model.fourier_mesh import CaissonSection

# Radius of the patch over that of the skirt's inside; at least the nodes around the axis belong to it
PATCH = 0.25
_ROUNDING = 1.0 + 1.0e-6


@dataclass(frozen=True)
class SteelMesh:
    """Steel nodes and elements, numbered behind the soil's nodes.

    nodes : (k, 3) m; hexes : (nl, 8), third local direction through the thickness.
    held : (h,) nodes of the patch; symmetry : (s,) nodes on the plane y = 0.
    walls : side -> (na, nz) nodes, as in CaissonMesh.
    partner : soil node -> ((steel node, share), ...) that moves with it.
    """

    nodes: np.ndarray
    hexes: np.ndarray
    held: np.ndarray
    symmetry: np.ndarray
    walls: dict[str, np.ndarray]
    partner: dict[int, tuple[tuple[int, float], ...]]

    @property
    def n_elements(self) -> int:
        """Number of steel elements."""
        return len(self.hexes)


def make_steel(caisson: CaissonMesh, lid_thickness: float) -> SteelMesh:
    """Build the steel that fits a soil mesh; lid_thickness in m."""
    soil, first = caisson.mesh, caisson.mesh.n_nodes
    inner, outer = caisson.walls["inside"], caisson.walls["outside"]
    lid = soil.face_sets["lid"]
    under = np.unique(np.concatenate([lid.ravel(), inner[:, 0], outer[:, 0]]))
    copied = np.unique(np.concatenate([under, inner.ravel(), outer.ravel()]))
    number = np.full(first, -1)
    number[copied] = first + np.arange(len(copied))
    top = np.full(first, -1)
    top[under] = first + len(copied) + np.arange(len(under))
    rim = np.stack([inner[:-1, 0], outer[:-1, 0], outer[1:, 0], inner[1:, 0]], axis=1)
    plates = np.concatenate([lid, rim])
    walls = {side: number[wall] for side, wall in caisson.walls.items()}
    skirt = np.hstack([wall_faces(walls["inside"]), wall_faces(walls["outside"])])  # around, down, outwards
    nodes = np.concatenate([soil.nodes[copied], soil.nodes[under] - [0.0, 0.0, lid_thickness]])
    own, radius = first + np.arange(len(nodes)), np.hypot(nodes[:, 0], nodes[:, 1])
    return SteelMesh(
        nodes=nodes,
        hexes=np.concatenate([np.hstack([top[plates], number[plates]]), skirt]),
        held=own[patch(radius, float(radius[nodes[:, 2] > 0.0].min()))],
        symmetry=own[np.abs(nodes[:, 1]) < 1e-12],
        walls=walls,
        partner=_partners(caisson, number, copied),
    )


def patch(radius: np.ndarray, inside: float) -> np.ndarray:
    """Return the nodes (k,) bool of the lid's centre, from their radii (m) and that of the skirt's inside."""
    ring = float(radius[radius > 1e-9 * inside].min())
    return radius <= max(PATCH * inside, ring) * _ROUNDING


def _partners(caisson: CaissonMesh, number: np.ndarray, copied: np.ndarray) -> dict[int, tuple[tuple[int, float], ...]]:
    """Return the steel nodes that each interface node of the soil goes with."""
    partners: dict[int, tuple[tuple[int, float], ...]] = {int(node): ((int(number[node]), 1.0),) for node in copied}
    nodes, inner, outer = caisson.mesh.nodes, caisson.walls["inside"][:, -1], caisson.walls["outside"][:, -1]
    azimuth = np.arctan2(nodes[inner, 1], nodes[inner, 0])
    for node in np.setdiff1d(caisson.mesh.face_sets["tip"], copied):
        i = int(np.argmin(np.abs(azimuth - np.arctan2(nodes[node, 1], nodes[node, 0]))))
        span = nodes[outer[i]] - nodes[inner[i]]
        share = float((nodes[node] - nodes[inner[i]]) @ span / (span @ span))
        partners[int(node)] = ((int(number[inner[i]]), 1.0 - share), (int(number[outer[i]]), share))
    return partners


def with_steel(stations: Stations, steel: SteelMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights (ns, 8) of stations between soil (first four) and steel (negative weights)."""
    width = stations.nodes.shape[1]
    nodes = np.repeat(stations.nodes[:, :1], 2 * width, axis=1)
    weight = np.zeros(nodes.shape)
    nodes[:, :width], weight[:, :width] = stations.nodes, stations.weight
    for k in range(len(stations)):
        shares: dict[int, float] = {}
        for node, share in zip(stations.nodes[k], stations.weight[k], strict=True):
            for partner, part in steel.partner[int(node)] if share else ():
                shares[partner] = shares.get(partner, 0.0) + share * part
        for at, (partner, share) in enumerate(shares.items(), start=width):
            nodes[k, at], weight[k, at] = partner, -share
        nodes[k, width + len(shares) :] = nodes[k, width]
    return nodes, weight


# --- steel of a section ---

AROUND = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]  # nodes of an element on a grid of halves


@dataclass(frozen=True)
class SteelRings:
    """Steel nodes and elements, numbered behind the soil's nodes.

    nodes : (k, 2), r and z in m; quads : (nl, 8).
    held : (h,) nodes of the patch.
    walls : side -> (nz,) nodes, as in CaissonSection.
    partner : (n,) steel node at the place of each soil node of the interface, -1 elsewhere.
    """

    nodes: np.ndarray
    quads: np.ndarray
    held: np.ndarray
    walls: dict[str, np.ndarray]
    partner: np.ndarray

    @property
    def n_elements(self) -> int:
        """Number of steel elements of the section."""
        return len(self.quads)


def make_steel_rings(section: CaissonSection, lid_thickness: float) -> SteelRings:
    """Build the steel that fits a section; lid_thickness in m."""
    soil, first = section.mesh.nodes, section.mesh.n_nodes
    inner = len(section.lid) - 1  # on a grid of half elements: radii by depths, of which the lid has the first two
    radius = soil[np.concatenate([section.lid, section.tip[1:]]), 0]
    depth = np.concatenate([[-lid_thickness, -0.5 * lid_thickness], section.depth])
    i, j = np.meshgrid(np.arange(0, len(radius) - 1, 2), np.arange(0, len(depth) - 1, 2), indexing="ij")
    steel = (j == 0) | (i >= inner)
    a, b = i[steel], j[steel]
    grid = np.stack([(a + p) * len(depth) + b + q for p, q in AROUND], axis=1)
    used, quads = np.unique(grid, return_inverse=True)
    number = np.full(len(radius) * len(depth), -1)
    number[used] = first + np.arange(len(used))
    place = number.reshape(len(radius), len(depth))
    nodes = np.stack([radius[used // len(depth)], depth[used % len(depth)]], axis=1)
    walls = {"inside": place[inner, 2:], "outside": place[-1, 2:]}
    partner = np.full(first, -1)
    partner[section.lid], partner[section.tip] = place[: inner + 1, 2], place[inner:, -1]
    for side, wall in section.walls.items():
        partner[wall] = walls[side]
    held = first + np.flatnonzero(patch(nodes[:, 0], float(radius[inner])))
    return SteelRings(nodes, first + quads.reshape(-1, 8), held, walls, partner)


def with_rings(soil: SectionMesh, fixed: np.ndarray, steel: SteelRings) -> tuple[SectionMesh, np.ndarray]:
    """Return the section and its fixed directions (n, 3) with the nodes of the steel, of which the patch is held."""
    mesh = SectionMesh(np.concatenate([soil.nodes, steel.nodes]), soil.quads, soil.node_sets)
    both = np.concatenate([fixed, np.zeros((len(steel.nodes), 3), dtype=bool)])
    both[steel.held] = True
    return mesh, both


def add_steel(model: FourierModel, steel: SteelRings, young: float, poisson: float) -> FourierModel:
    """Put the steel between the stations and the rigid motion; Young's modulus in Pa."""
    stations, (mesh, fixed) = model.stations, with_rings(model.mesh, model.fixed, steel)
    gradient, volume = elements.geometry(mesh.nodes, steel.quads)
    tangent = np.broadcast_to(elastic_matrix(young, poisson), (*volume.shape, 6, 6))
    matrices = [elements.stiffness(gradient, volume, tangent, k, model.whole) for k in range(model.harmonics + 1)]
    nodes = np.hstack([stations.nodes, steel.partner[stations.nodes]])
    weight = np.hstack([stations.weight, -stations.weight])
    return replace(
        model,
        mesh=mesh,
        fixed=fixed,
        stations=replace(stations, nodes=nodes, weight=weight),
        linear=LinearRings(steel.quads, np.array(matrices)[model.numbers]),
    )
