# SPDX-License-Identifier: MIT
"""Zero-thickness interface: stations (integration points), their local frames and jump operators.

A station carries an area, a local frame (normal, tangent 1, tangent 2) and the operator that turns
displacements into a jump:  jump = frame @ (sum_a weight_a u_a - R q),  with u_a the nodes it touches (the
weights of a deformable side 2 are negative) and R q the motion of a rigid side 2.

Two rules place the stations on quadrilateral faces.

``nodal``
    One station per node, on the area lumped there (Newton-Cotes). With a stiff penalty this is the rule to
    use: each contact constraint meets displacement components of its own. At an edge between two surfaces a node
    carries two stations; friction on both would hold it twice over.
``central``
    One station at the centre of each face. For faces that meet a wall at an edge: a node there carries the
    wall's station already, and two laws on one node open and close each other in turn.

2x2 Gauss points a face would each couple its four nodes: for K_N h >> E the pressures of neighbouring points alternate
about the true ones then (Schellekens & de Borst 1993; the verification measures it).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_GAUSS = _CORNERS / np.sqrt(3.0)


@dataclass(frozen=True)
class Stations:
    """Integration points of an interface.

    Attributes
    ----------
    position : (ns, 3) m.
    frame : (ns, 3, 3) rows are normal (into side 1), tangent 1, tangent 2.
    area : (ns,) m2.
    nodes : (ns, nn) int, weight : (ns, nn) share of each node in the displacement of the station.
    body : (ns, 3, nb) displacement operator of the rigid side 2 (zero where there is none).
    surface : (ns,) int, a label: which surface the station stands on.
    """

    position: np.ndarray
    frame: np.ndarray
    area: np.ndarray
    nodes: np.ndarray
    weight: np.ndarray
    body: np.ndarray
    surface: np.ndarray

    def __len__(self) -> int:
        return len(self.area)


@dataclass(frozen=True)
class Film:
    """Water inside the interface: pressure nodes of its own, and the faces along which it flows.

    Attributes
    ----------
    n_nodes : number of film nodes.
    nodes : (ns, k) film nodes of every station, weight : (ns, k) their shares (sum 1).
    faces : (m, 4) film nodes, corners : (m, 4) the station whose gap holds at each corner.
    gradient : (m, 4 gauss, 4 nodes, 3) surface gradients in 1/m, area : (m, 4) m2, see film_geometry; 0 where a face
        has no film.
    residual_aperture : D_0, m; transfer : T_w, m/(Pa s); viscosity : Pa s.
    sealed : no water passes to side 2, though it is deformable.
    wetted : (ns,) share of every station's area that has a film; None: all of it.
    """

    n_nodes: int
    nodes: np.ndarray
    weight: np.ndarray
    faces: np.ndarray
    corners: np.ndarray
    gradient: np.ndarray
    area: np.ndarray
    residual_aperture: float
    transfer: float
    viscosity: float
    sealed: bool = False
    wetted: np.ndarray | None = None


def film_areas(area: np.ndarray, wetted: np.ndarray | None) -> np.ndarray:
    """Return the areas (ns,) m2 of the film at stations of these areas (ns,); see Film.wetted."""
    return area.astype(float) if wetted is None else area * wetted


def film_geometry(nodes: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface gradients (m, 4 gauss, 4 nodes, 3) of bilinear faces in 1/m, and areas (m, 4) in m2.

    With the tangents t_a = dx/dxi_a and the metric g_ab = t_a.t_b, grad N = t_a g^ab dN/dxi_b.
    """
    corner = nodes[faces]
    gradient, area = np.empty((len(faces), 4, 4, 3)), np.empty((len(faces), 4))
    for g, (xi, eta) in enumerate(_GAUSS):
        local = shape_gradient(xi, eta)
        tangent = np.einsum("aj,fai->fji", local, corner)
        metric = np.einsum("fji,fki->fjk", tangent, tangent)  # g_ab = t_a.t_b
        gradient[:, g] = np.einsum("aj,fjk,fki->fai", local, np.linalg.inv(metric), tangent)  # t_a g^ab dN/dxi_b
        area[:, g] = np.sqrt(np.linalg.det(metric))  # dA = sqrt(det g) dxi deta
    return gradient, area


def nodal_stations(
    nodes: np.ndarray, faces: np.ndarray, normals: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place one station on every node of the faces.

    Parameters
    ----------
    nodes : (n, 3); faces : (nf, 4) with normals into side 1.
    normals : (n, 3) exact unit normals of the nodes, or None for the area-weighted mean of the facets.

    Returns
    -------
    node : (ns,) node numbers; normal : (ns, 3) unit normals; area : (ns,) lumped area projected on the normal,
    so that a uniform pressure has the resultant of the faceted surface.
    """
    node = np.unique(faces)
    vector = nodal_area_vectors(nodes, faces)[node]
    normal = vector / np.linalg.norm(vector, axis=1)[:, None] if normals is None else normals[node]
    return node, normal, np.einsum("si,si->s", vector, normal)  # Newton-Cotes: Schellekens & de Borst 1993


def nodal_area_vectors(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the integrals (n, 3) of N_a n dA over bilinear faces (nf, 4), in m2."""
    vectors = np.zeros((len(nodes), 3))
    for _, shape, area_vector in face_points(nodes[faces]):
        for a in range(4):
            np.add.at(vectors, faces[:, a], shape[a] * area_vector)
    return vectors


def central_stations(nodes: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Place one station at the centre of every face.

    Returns nodes (ns, 4), weight (ns, 4), normal (ns, 3) and area (ns,) in m2.
    """
    vector = np.sum([area_vector for _, _, area_vector in face_points(nodes[faces])], axis=0)
    area = np.linalg.norm(vector, axis=1)
    return faces, np.full(faces.shape, 0.25), vector / area[:, None], area


def face_points(corner: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return the position, shape values and area vector (nf, 3) of the four Gauss points of each face."""
    points = []
    for xi, eta in _GAUSS:
        shape = _shape(xi, eta)
        d_xi, d_eta = np.einsum("aj,fai->jfi", shape_gradient(xi, eta), corner)
        # n dA = t_1 x t_2 dxi deta
        points.append((np.einsum("a,fai->fi", shape, corner), shape, np.cross(d_xi, d_eta)))
    return points


def _shape(xi: float, eta: float) -> np.ndarray:
    return (1.0 + _CORNERS[:, 0] * xi) * (1.0 + _CORNERS[:, 1] * eta) / 4.0


def shape_gradient(xi: float, eta: float) -> np.ndarray:
    """Return the local gradient (4, 2) of the bilinear shape functions."""
    return _CORNERS * (1.0 + _CORNERS[:, ::-1] * [eta, xi]) / 4.0


GAUSS_SHAPES = np.stack([_shape(xi, eta) for xi, eta in _GAUSS])


def local_frames(normal: np.ndarray) -> np.ndarray:
    """Return frames (ns, 3, 3) with rows n, t1, t2 (right-handed).

    On walls t1 is horizontal and t2 points down; on horizontal faces t1 follows x.
    """
    down = np.array([0.0, 0.0, 1.0])
    flat = np.abs(normal[:, 2]) > 0.9
    second = down - normal * normal[:, 2:3]
    along_x = np.array([1.0, 0.0, 0.0])
    first_flat = along_x - normal * normal[:, 0:1]
    second[flat] = np.cross(normal[flat], first_flat[flat])
    second /= np.linalg.norm(second, axis=1)[:, None]
    return np.stack([normal, np.cross(second, normal), second], axis=1)
