# SPDX-License-Identifier: MIT
"""Steel of an elastic caisson: solid shells of skirt and lid that match the soil's mesh node by node.

Every soil node on a wall or under the lid has a steel node at its place; the lid has another layer of nodes on its top.
Skirt and lid are one element thick and share the nodes of the skirt's upper edge. Soil nodes under the tip that lie
between the walls go with the mean of the wall's nodes there, by their place.

The displacement of steel nodes is counted from the rigid motion (u, w, rotation), which strains nothing. Its own rigid
part is taken out by holding a stiff patch at the lid's centre, over its whole thickness: (u, w, rotation) is therefore
the motion of that patch, and the load acts on it ("imposed at the top centre", Cerfontaine et al. 2018). The patch is
the foot of whatever stands on the caisson; a load on a single node would indent the lid the more the finer the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.elements.interface import Stations
from pysprings.model.mesh import CaissonMesh

# Radius of the patch over that of the skirt's inside; at least the nodes around the axis belong to it
PATCH = 0.25
_ROUNDING = 1.0 + 1.0e-6


@dataclass(frozen=True)
class SteelMesh:
    """Steel nodes and elements, numbered behind the soil's nodes.

    Attributes
    ----------
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
    nodes = np.concatenate([soil.nodes[copied], soil.nodes[under] - [0.0, 0.0, lid_thickness]])
    own, radius = first + np.arange(len(nodes)), np.hypot(nodes[:, 0], nodes[:, 1])
    return SteelMesh(
        nodes=nodes,
        hexes=np.concatenate([np.hstack([top[plates], number[plates]]), _skirt(walls)]),
        held=own[patch(radius, float(radius[nodes[:, 2] > 0.0].min()))],
        symmetry=own[np.abs(nodes[:, 1]) < 1e-12],
        walls=walls,
        partner=_partners(caisson, number, copied),
    )


def _skirt(walls: dict[str, np.ndarray]) -> np.ndarray:
    """Return the elements (k, 8) between the walls: around, down, outwards."""

    def face(wall: np.ndarray) -> np.ndarray:
        return np.stack([c.ravel() for c in (wall[:-1, :-1], wall[1:, :-1], wall[1:, 1:], wall[:-1, 1:])], axis=1)

    return np.hstack([face(walls["inside"]), face(walls["outside"])])


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
