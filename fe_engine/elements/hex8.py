# SPDX-License-Identifier: MIT
"""Eight-node hexahedron with 2x2x2 Gauss points and mean dilatation (B-bar).

The volumetric strain of every Gauss point is replaced by its element mean (Hughes 1980), which removes
volumetric locking in isochoric plastic flow and near incompressibility:

    eps_bar = dev(sym grad u) + theta_bar/3 I,   theta_bar = (1/V) int div u dV.
"""

from __future__ import annotations

import numpy as np

from fe_engine.compiled import njit
from fe_engine.conventions import CORNERS, XX, XY, YY, YZ, ZX, ZZ

GAUSS = CORNERS * (1.0 / np.sqrt(3.0))


def shape(xi: np.ndarray) -> np.ndarray:
    """Return the trilinear shape functions (8,) at the local point xi (3,)."""
    return np.prod(1.0 + CORNERS * xi, axis=1) / 8.0


def shape_gradient(xi: np.ndarray) -> np.ndarray:
    """Return the local gradient (8, 3) of the shape functions at the local point xi (3,)."""
    factors = 1.0 + CORNERS * xi
    gradient = np.empty((8, 3))
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        gradient[:, axis] = CORNERS[:, axis] * factors[:, others[0]] * factors[:, others[1]] / 8.0
    return gradient


_GAUSS_GRADIENTS = np.stack([shape_gradient(xi) for xi in GAUSS])
GAUSS_SHAPES = np.stack([shape(xi) for xi in GAUSS])


def geometry(nodes: np.ndarray, hexes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what the kernels need of the element shapes.

    Returns
    -------
    gradient : (ne, 8 gauss, 8 nodes, 3) gradients of the shape functions in 1/m
    volume : (ne, 8 gauss) Jacobian times Gauss weight in m3
    mean_gradient : (ne, 8 nodes, 3) volume mean of the gradients in 1/m
    """
    ne = len(hexes)
    gradient = np.empty((ne, 8, 8, 3))
    volume = np.empty((ne, 8))
    corner = nodes[hexes]
    for g in range(8):
        jacobian = np.einsum("eai,aj->eij", corner, _GAUSS_GRADIENTS[g])  # dx/dxi
        volume[:, g] = np.linalg.det(jacobian)
        gradient[:, g] = np.einsum("aj,eji->eai", _GAUSS_GRADIENTS[g], np.linalg.inv(jacobian))
    # Hughes 1980: (1/V) int grad N dV
    mean = np.einsum("eg,egai->eai", volume, gradient) / volume.sum(axis=1)[:, None, None]
    return gradient, volume, mean


def gauss_positions(nodes: np.ndarray, hexes: np.ndarray) -> np.ndarray:
    """Return the coordinates (ne, 8, 3) in m of the Gauss points."""
    return np.einsum("ga,eai->egi", GAUSS_SHAPES, nodes[hexes])


@njit(inline="never")
def strain_at(gradient, mean_gradient, displacement, strain):
    """Write the B-bar strain (6,) of one Gauss point; displacement is (8, 3)."""
    h = np.zeros((3, 3))
    mean = 0.0
    for a in range(8):
        for i in range(3):
            mean += mean_gradient[a, i] * displacement[a, i]
            for j in range(3):
                h[i, j] += displacement[a, i] * gradient[a, j]
    shift = (mean - h[0, 0] - h[1, 1] - h[2, 2]) / 3.0  # theta_bar/3 in place of tr(h)/3
    strain[XX] = h[0, 0] + shift
    strain[YY] = h[1, 1] + shift
    strain[ZZ] = h[2, 2] + shift
    strain[XY] = h[0, 1] + h[1, 0]
    strain[YZ] = h[1, 2] + h[2, 1]
    strain[ZX] = h[2, 0] + h[0, 2]


@njit(inline="never")
def add_force(gradient, mean_gradient, volume, s, force):
    """Add B-bar^T s dV of one Gauss point to force (24,); s is a stress (6,) in Pa."""
    mean = (s[XX] + s[YY] + s[ZZ]) / 3.0  # acts on the mean gradient, the deviator on the point's own
    for a in range(8):
        gx, gy, gz = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        mx = mean * (mean_gradient[a, 0] - gx)
        my = mean * (mean_gradient[a, 1] - gy)
        mz = mean * (mean_gradient[a, 2] - gz)
        force[3 * a] += volume * (s[XX] * gx + s[XY] * gy + s[ZX] * gz + mx)
        force[3 * a + 1] += volume * (s[XY] * gx + s[YY] * gy + s[YZ] * gz + my)
        force[3 * a + 2] += volume * (s[ZX] * gx + s[YZ] * gy + s[ZZ] * gz + mz)


@njit(inline="never")
def b_bar(gradient, mean_gradient, b):
    """Write the strain operator B-bar (6, 24) of one Gauss point."""
    for a in range(8):
        gx, gy, gz = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        # what the mean dilatation has more than the point's
        shift = ((mean_gradient[a, 0] - gx) / 3.0, (mean_gradient[a, 1] - gy) / 3.0, (mean_gradient[a, 2] - gz) / 3.0)
        for j in range(3):
            c = 3 * a + j
            b[XX, c] = shift[j]
            b[YY, c] = shift[j]
            b[ZZ, c] = shift[j]
            b[XY, c] = 0.0
            b[YZ, c] = 0.0
            b[ZX, c] = 0.0
        b[XX, 3 * a] += gx
        b[YY, 3 * a + 1] += gy
        b[ZZ, 3 * a + 2] += gz
        b[XY, 3 * a] = gy
        b[XY, 3 * a + 1] = gx
        b[YZ, 3 * a + 1] = gz
        b[YZ, 3 * a + 2] = gy
        b[ZX, 3 * a] = gz
        b[ZX, 3 * a + 2] = gx


@njit(inline="never", fastmath={"contract", "reassoc"})
def add_stiffness(b, tangent, volume, cb, stiffness):
    """Add B^T C B dV of one Gauss point to stiffness (24, 24) N/m; cb (6, 24) is scratch.

    b (6, 24) 1/m, tangent C (6, 6) Pa, volume dV m3. Sums over the six components are written out: the loops over
    columns then stay in registers, five times faster.
    """
    for i in range(6):
        t0, t1, t2 = volume * tangent[i, 0], volume * tangent[i, 1], volume * tangent[i, 2]
        t3, t4, t5 = volume * tangent[i, 3], volume * tangent[i, 4], volume * tangent[i, 5]
        for c in range(24):
            direct = t0 * b[0, c] + t1 * b[1, c] + t2 * b[2, c]
            cb[i, c] = direct + t3 * b[3, c] + t4 * b[4, c] + t5 * b[5, c]
    for r in range(24):
        b0, b1, b2, b3, b4, b5 = b[0, r], b[1, r], b[2, r], b[3, r], b[4, r], b[5, r]
        for c in range(24):
            direct = b0 * cb[0, c] + b1 * cb[1, c] + b2 * cb[2, c]
            stiffness[r, c] += direct + b3 * cb[3, c] + b4 * cb[4, c] + b5 * cb[5, c]
