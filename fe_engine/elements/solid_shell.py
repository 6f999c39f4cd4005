# SPDX-License-Identifier: MIT
"""Stiffness of an eight-node solid shell: a linear elastic brick that is thin along its third local direction.

Plain bricks are far too stiff for a thin bent wall (30 times for the paper's skirt, see the verification), and even
incompatible modes do not help where the cells are wedges of a ring. With the covariant strains
e_ij = (G_i.u_,j + G_j.u_,i)/2 of the local directions 1, 2 (in the middle surface) and 3 (through the thickness):

- 2 e_13 and 2 e_23 are taken at the middles of the edges, and interpolated (Dvorkin & Bathe 1984): no shear locking;
- e_33 is taken at the corners of the middle surface, and interpolated (Betsch & Stein 1995): no locking of rings;
- seven incompatible strains (Simo & Rifai 1990; modes of Vu-Quoc & Tan 2003) in e_11, e_22, e_12 for bending in the
  plane of the wall, and in e_33 so that the thickness may change as a bent wall's does. They are condensed.

One layer of these carries membrane action and bending of a wall. All that the engine needs of them is their stiffness.
"""

from __future__ import annotations

import numpy as np

from fe_engine.elements.hex8 import GAUSS, shape_gradient
from fe_engine.soil.elastic import elastic_matrix

# Index pairs of the strain components 11 22 33 12 23 31 (engineering shear): the Voigt order of the engine
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
_SHEAR_23 = (np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
_SHEAR_31 = (np.array([0.0, -1.0, 0.0]), np.array([0.0, 1.0, 0.0]))
_CORNERS = tuple(np.array([x, y, 0.0]) for x, y in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))


def stiffness(nodes: np.ndarray, hexes: np.ndarray, young: float, poisson: float) -> np.ndarray:
    """Return the stiffness matrices (ne, 24, 24) in N/m; Young's modulus in Pa.

    ``hexes`` (ne, 8) have the corner order of `hex8`; corners 0-3 and 4-7 are on the two faces of the wall.
    """
    corner = nodes[hexes]
    elastic, centre = elastic_matrix(young, poisson), np.zeros(3)  # Hooke
    base_0 = _base(corner, centre)
    turn_0, volume_0 = _to_cartesian(base_0), np.linalg.det(base_0)
    ne = len(hexes)
    k_uu, k_ua, k_aa = np.zeros((ne, 24, 24)), np.zeros((ne, 24, 7)), np.zeros((ne, 7, 7))
    sampled = _sampled(corner)
    for point in GAUSS:
        base = _base(corner, point)
        volume = np.linalg.det(base)
        # Dvorkin & Bathe 1984, Betsch & Stein 1995
        b = _to_cartesian(base) @ _assumed(_covariant(corner, point), sampled, point)
        # Simo & Rifai 1990: det J_0/det J T_0, work-free under a constant stress
        g = (volume_0 / volume)[:, None, None] * (turn_0 @ _modes(point))
        cb, cg = elastic @ b, elastic @ g
        weight = volume[:, None, None]
        k_uu += weight * (b.transpose(0, 2, 1) @ cb)
        k_ua += weight * (b.transpose(0, 2, 1) @ cg)
        k_aa += weight * (g.transpose(0, 2, 1) @ cg)
    # modes condensed: they carry no load
    return np.asarray(k_uu - k_ua @ np.linalg.solve(k_aa, k_ua.transpose(0, 2, 1)))


def _base(corner: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the covariant base vectors (ne, 3, 3), rows G_i = dX/dxi_i."""
    return np.asarray(np.einsum("ai,eak->eik", shape_gradient(point), corner))


def _covariant(corner: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the covariant strains (ne, 6, 24) of nodal displacements at a local point."""
    gradient, base = shape_gradient(point), _base(corner, point)
    b = np.zeros((len(corner), 6, 8, 3))
    for row, (i, j) in enumerate(_PAIRS):
        b[:, row] = gradient[None, :, j, None] * base[:, None, i, :]  # G_i.u_,j
        if i != j:
            b[:, row] += gradient[None, :, i, None] * base[:, None, j, :]
    return b.reshape(len(corner), 6, 24)


def _sampled(corner: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
    """Return the strains (ne, 24) at the points where they are taken: 33 at the corners, 23 and 31 at the edges."""
    return (
        [_covariant(corner, point)[:, 2] for point in _CORNERS],
        [_covariant(corner, point)[:, 4] for point in _SHEAR_23],
        [_covariant(corner, point)[:, 5] for point in _SHEAR_31],
    )


def _assumed(b: np.ndarray, sampled: tuple, point: np.ndarray) -> np.ndarray:
    """Replace e_33, e_23 and e_31 by what is interpolated from the sampled points."""
    x, y, _ = point
    thickness, shear_23, shear_31 = sampled
    b[:, 2] = sum(  # Betsch & Stein 1995: bilinear from the four corners
        0.25 * (1.0 + x * at[0]) * (1.0 + y * at[1]) * row for at, row in zip(_CORNERS, thickness, strict=True)
    )
    # Dvorkin & Bathe 1984: 23 is linear in xi_1, 31 in xi_2
    b[:, 4] = 0.5 * (1.0 - x) * shear_23[0] + 0.5 * (1.0 + x) * shear_23[1]
    b[:, 5] = 0.5 * (1.0 - y) * shear_31[0] + 0.5 * (1.0 + y) * shear_31[1]
    return b


def _modes(point: np.ndarray) -> np.ndarray:
    """Return the incompatible strains (6, 7) in covariant components; their means over the element vanish."""
    x, y, z = point
    modes = np.zeros((6, 7))
    modes[0, 0], modes[1, 1], modes[3, 2], modes[3, 3] = x, y, x, y  # membrane: bending in the plane of the wall
    modes[2, 4:] = z, x * z, y * z  # thickness: linear over it, as Poisson's ratio asks in bending
    return modes


def _to_cartesian(base: np.ndarray) -> np.ndarray:
    """Turn covariant strains (engineering shear) into Cartesian ones: (ne, 6, 6), e_kl = e_ij G^i_k G^j_l."""
    dual = np.linalg.inv(base)  # [k, i] is the k-th component of the contravariant base vector G^i
    turn = np.zeros((len(base), 6, 6))
    for row, (k, m) in enumerate(_PAIRS):
        for column, (i, j) in enumerate(_PAIRS):
            value = dual[:, k, i] * dual[:, m, j]
            if i != j:
                value = 0.5 * (value + dual[:, k, j] * dual[:, m, i])
            turn[:, row, column] = value * (1.0 if k == m else 2.0)
    return turn
