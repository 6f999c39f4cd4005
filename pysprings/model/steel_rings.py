# SPDX-License-Identifier: MIT
"""Steel of an elastic caisson beside Fourier series: rings of the same quadratic elements that fit the soil's section.

With 2 x 2 points one element through the thickness bends without locking. Skirt and lid stand where the bricks' do
(see `steel`), and the displacement is counted from the same rigid motion: that of a stiff patch at the lid's centre, on
which the load acts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fe_engine.elements import fourier as elements
from fe_engine.fourier_model import FourierModel, LinearRings, SectionMesh
from fe_engine.soil.elastic import elastic_matrix
from pysprings.model.fourier_mesh import CaissonSection
from pysprings.model.steel import patch

_AROUND = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]  # nodes of an element on a grid of halves


@dataclass(frozen=True)
class SteelRings:
    """Steel nodes and elements, numbered behind the soil's nodes.

    Attributes
    ----------
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
    grid = np.stack([(a + p) * len(depth) + b + q for p, q in _AROUND], axis=1)
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
    stiffness = [elements.stiffness(gradient, volume, tangent, k) for k in range(model.harmonics + 1)]
    nodes = np.hstack([stations.nodes, steel.partner[stations.nodes]])
    weight = np.hstack([stations.weight, -stations.weight])
    return replace(
        model,
        mesh=mesh,
        fixed=fixed,
        stations=replace(stations, nodes=nodes, weight=weight),
        linear=LinearRings(steel.quads, np.array(stiffness)),
    )
