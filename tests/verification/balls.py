# SPDX-License-Identifier: MIT
"""One eighth of a ball in hexahedra: a cube with bulging faces in the middle, three blocks between it and the surface.

Its plane z = 0 is a quarter of a disc, meshed with quadrilaterals in the same way.
"""

import numpy as np

from fe_engine.elements import hex8
from fe_engine.mesh import FACES, Mesh
from tests.verification.blocks import box

# Half width of the cube over the radius, how far its corners are drawn in towards a sphere, and how much thinner than
# the mean the cells at the surface are
_CORE, _BULGE, _GRADING = 0.5, 0.5, 0.5


def eighth_ball(core: int, shell: int, radius: float = 1.0) -> Mesh:
    """Octant x, y, z > 0 of a ball about the origin; ``core`` cells along the cube, ``shell`` from it to the surface.

    The node set "surface" holds the nodes of the sphere. All is stretched so that the hexahedra fill the ball's volume.
    """
    inner = box((core,) * 3)
    pieces = [_bulged(inner.nodes)]
    hexes = [inner.hexes]
    block = box((core, core, shell))
    for axis in range(3):
        cube = np.roll(np.insert(block.nodes[:, :2], 2, 1.0, axis=1), axis, axis=1)
        sphere = np.tan(0.25 * np.pi * cube)
        sphere /= np.linalg.norm(sphere, axis=1)[:, None]
        share = (1.0 + _GRADING) * block.nodes[:, 2:] - _GRADING * block.nodes[:, 2:] ** 2
        hexes.append(block.hexes + sum(len(piece) for piece in pieces))
        pieces.append((1.0 - share) * _bulged(cube) + share * sphere)
    nodes, number = _merged(np.vstack(pieces))
    mesh = Mesh(nodes, number[np.vstack(hexes)])
    mesh.node_sets["surface"] = np.flatnonzero(np.linalg.norm(nodes, axis=1) > 1.0 - 1e-9)
    _, volume, _ = hex8.geometry(nodes, mesh.hexes)
    mesh.nodes *= radius * float(np.pi / 6.0 / volume.sum()) ** (1.0 / 3.0)
    mesh.check()
    return mesh


def faces_on(mesh: Mesh, chosen: np.ndarray) -> np.ndarray:
    """Faces (m, 4) of the elements all of whose corners are chosen, (n,) bool; normals point into the elements."""
    faces = mesh.hexes[:, FACES[:, ::-1]].reshape(-1, 4)
    return faces[chosen[faces].all(axis=1)]


def _bulged(cube: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the unit cube moved to the core; the origin stays."""
    largest = np.abs(cube).max(axis=1)
    roundness = largest / np.maximum(np.linalg.norm(cube, axis=1), 1e-300)
    return _CORE * cube * (1.0 - _BULGE * largest * (1.0 - roundness))[:, None]


def _merged(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct points, and the number of each given point among them."""
    _, first, number = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return points[first], number.ravel()
