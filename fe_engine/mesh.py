# SPDX-License-Identifier: MIT
"""Mesh of eight-node hexahedra: nodes, elements, named sets and quality."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fe_engine.conventions import CORNERS
from fe_engine.errors import MeshError

EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]])

# Corners of the six faces, normals pointing out of the element
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


@dataclass(frozen=True)
class Quality:
    """Quality figures of a mesh.

    ``min_jacobian`` is the smallest corner Jacobian divided by the product of the three edge lengths that
    meet there (1 for a brick, <= 0 for an inverted corner); ``max_aspect`` is the largest ratio of the
    longest to the shortest edge of an element.
    """

    min_jacobian: float
    max_aspect: float
    worst_element: int


@dataclass
class Mesh:
    """Nodes (n, 3) in m, hexahedra (ne, 8) and named node and face sets.

    Attributes
    ----------
    nodes : (n, 3) float, coordinates in m.
    hexes : (ne, 8) int, corner order of ``conventions.CORNERS``.
    node_sets : name -> (k,) int.
    face_sets : name -> (k, 4) int, each face with its normal pointing out of side 2 into the soil.
    """

    nodes: np.ndarray
    hexes: np.ndarray
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    face_sets: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    @property
    def n_elements(self) -> int:
        """Number of hexahedra."""
        return len(self.hexes)

    def shortest_edge(self) -> float:
        """Return the length of the shortest edge, m."""
        return float(_edge_lengths(self.nodes[self.hexes]).min())

    def check(self) -> Quality:
        """Return the quality figures; raise MeshError on inverted elements or unused nodes."""
        used = np.zeros(self.n_nodes, dtype=bool)
        used[self.hexes] = True
        if not used.all():
            raise MeshError(f"node {int(np.argmin(used))} belongs to no element")
        quality = measure_quality(self.nodes, self.hexes)
        if quality.min_jacobian <= 0.0:
            centre = self.nodes[self.hexes[quality.worst_element]].mean(axis=0)
            raise MeshError(f"element {quality.worst_element} near {np.round(centre, 3)} is inverted or flat")
        return quality


def measure_quality(nodes: np.ndarray, hexes: np.ndarray) -> Quality:
    """Return the scaled corner Jacobian and aspect ratio extremes of the elements."""
    corner = nodes[hexes]
    length = _edge_lengths(corner)
    aspect = length.max(axis=1) / np.maximum(length.min(axis=1), 1e-300)
    scaled = np.stack([_corner_jacobian(corner, k) for k in range(8)], axis=1)
    worst = scaled.min(axis=1)
    return Quality(float(worst.min()), float(aspect.max()), int(np.argmin(worst)))


def _edge_lengths(corner: np.ndarray) -> np.ndarray:
    """Return the lengths (ne, 12) of the edges of elements with corners (ne, 8, 3), m."""
    lengths: np.ndarray = np.linalg.norm(corner[:, EDGES[:, 1]] - corner[:, EDGES[:, 0]], axis=2)
    return lengths


def _corner_jacobian(corner: np.ndarray, k: int) -> np.ndarray:
    """Return the scaled Jacobian (ne,) at corner k: triple product of the three edges over their lengths."""
    neighbours = [int(np.flatnonzero((CORNERS[k] * flip == CORNERS).all(axis=1))[0]) for flip in _FLIPS]
    edges = [(corner[:, n] - corner[:, k]) * -CORNERS[k, axis] for axis, n in enumerate(neighbours)]
    volume = np.einsum("ei,ei->e", edges[0], np.cross(edges[1], edges[2]))
    return volume / np.maximum(np.prod([np.linalg.norm(e, axis=1) for e in edges], axis=0), 1e-300)


_FLIPS = np.array([[-1, 1, 1], [1, -1, 1], [1, 1, -1]], dtype=float)
