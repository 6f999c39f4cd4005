# SPDX-License-Identifier: MIT
"""Elastic stiffness of a rigid caisson without thickness by axisymmetric elements: one plane (r, z) for the whole body.

The caisson's lateral motion has one wave around it, so that the soil's displacement is exactly

    u_r = U(r, z) cos(theta),   u_theta = V(r, z) sin(theta),   u_z = W(r, z) cos(theta)

and the three amplitudes are all there is to find (Wilson 1965, harmonic n = 1). Unknowns are U, S = U + V and W: the
displacement is single-valued on the axis where S = W = 0, and a rigid body has S = 0 throughout.

Displacement elements of high order, integrated in full, on cells that shrink geometrically towards the skirt, its tip
and the edge of the lid, where the stress is singular. At order 4 they do not lock: for R 3.9 m, L 4 m in 24 x 12 m at
nu = 0.4999, K_H, K_C, K_M and K_free lie 0.001, 0.003, 0.005 and 0.002 % above mixed elements (displacement of order
4, pressure of order 3) on the same cells; nu = 0.5 itself, which only mixed ones reach, is another 0.01 % higher.
Nothing of the project's own elements, meshes or solvers is used here, nor should it be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def stiffness(
    radius: float,
    length: float,
    domain_radius: float,
    domain_depth: float,
    shear: float,
    poisson: float,
    cells: int = 10,
    order: int = 4,
    grading: float = 0.5,
) -> tuple[float, float, float, float]:
    """K_H (N/m), K_C (N), K_M (N m) and K_free (N/m) of a rigid caisson bonded to elastic soil.

    H = K_H u + K_C rotation and M = K_C u + K_M rotation at mudline, where depth z is down and the lateral displacement
    is u + rotation z, so that K_C > 0; K_free = K_H - K_C^2/K_M has no moment at mudline.

    Parameters
    ----------
    radius, length : of the skirt, m; a length of 0 leaves the lid, a rough disc.
    domain_radius, domain_depth : of the soil, m; its side is a roller (u_r = 0), its bottom fixed.
    shear, poisson : shear modulus, Pa, and Poisson's ratio, below 0.5.
    cells : across the lid's radius, and across each half of the skirt.
    order : of the polynomials in a cell.
    grading : size of a cell over that of its neighbour farther from the skirt, below 1.
    """
    (k_h, k_c), (_, k_m) = matrix(
        radius, length, domain_radius, domain_depth, shear, poisson, cells=cells, order=order, grading=grading
    )
    return k_h, k_c, k_m, k_h - k_c**2 / k_m


def matrix(
    radius: float,
    length: float,
    domain_radius: float,
    domain_depth: float,
    shear: float,
    poisson: float,
    cells: int = 10,
    order: int = 4,
    grading: float = 0.5,
) -> np.ndarray:
    """H and M (rows) over u and rotation (columns), (2, 2) in N and m; see `stiffness`."""
    r_lines, z_lines = _lines(radius, length, domain_radius, domain_depth, cells, grading)
    rule = Rule.of(order)
    r, z = (coordinate.ravel() for coordinate in np.meshgrid(rule.spread(r_lines), rule.spread(z_lines)))
    dofs = 3 * _connectivity(len(r_lines) - 1, len(z_lines) - 1, order)[:, :, None] + np.arange(3)
    k = _assembled(_element_matrices(r_lines, z_lines, rule, shear, poisson), dofs.reshape(len(dofs), -1), 3 * len(r))
    body = (r <= radius) & (z == 0.0) | (r == radius) & (z <= length)
    motion = np.zeros((len(r), 3, 2))
    motion[body, 0, 0] = 1.0
    motion[body, 0, 1] = z[body]
    motion[body, 2, 1] = -r[body]
    fixed = np.zeros((len(r), 3), bool)
    fixed[body | (z == domain_depth)] = True
    fixed[r == domain_radius, 0] = True
    fixed[r == 0.0, 1:] = True
    return _reactions(k, motion.reshape(-1, 2), np.flatnonzero(~fixed))


@dataclass(frozen=True)
class Rule:
    """Lagrange polynomials on Gauss-Lobatto nodes, at Gauss points that integrate their products exactly.

    Attributes
    ----------
    nodes : (p + 1,) in -1 .. 1.
    points, weights : (g,) of Gauss.
    shape, slope : (g, p + 1) polynomials and their derivatives at the points.
    """

    nodes: np.ndarray
    points: np.ndarray
    weights: np.ndarray
    shape: np.ndarray
    slope: np.ndarray

    @classmethod
    def of(cls, order: int) -> Rule:
        """The rule of polynomials of an order of 1 or more."""
        inner = legendre.legroots(legendre.legder(np.eye(order + 1)[order]))
        nodes = np.concatenate(([-1.0], np.sort(inner), [1.0]))
        points, weights = legendre.leggauss(order + 1)
        series = np.linalg.inv(legendre.legvander(nodes, order))
        shape, slope = legendre.legval(points, series).T, legendre.legval(points, legendre.legder(series)).T
        return cls(nodes, points, weights, shape, slope)

    def spread(self, lines: np.ndarray) -> np.ndarray:
        """Coordinates of all nodes between lines (n + 1,), in their order; the lines themselves are kept exactly."""
        between = lines[:-1, None] + 0.5 * (self.nodes[:-1] + 1.0) * np.diff(lines)[:, None]
        return np.append(between, lines[-1])


def _lines(radius, length, domain_radius, domain_depth, cells, grading) -> tuple[np.ndarray, np.ndarray]:
    """Radii and depths (m) of the cells' borders."""
    share = _graded(cells, grading)
    inside = radius * (1.0 - share[::-1])
    r_lines = np.append(inside[:-1], _outward(radius, domain_radius, radius * share[1], grading))
    if length == 0.0:
        return r_lines, _outward(0.0, domain_depth, radius * share[1], grading)
    upper, half = 0.5 * length * share, 0.5 * length
    skirt = np.concatenate((upper, length - upper[-2:0:-1]))
    return r_lines, np.append(skirt, _outward(length, domain_depth, half * share[1], grading))


def _graded(cells: int, grading: float) -> np.ndarray:
    """Lines (cells + 1,) from 0 to 1, closest at 0."""
    lines = np.append(0.0, np.cumsum(grading ** np.arange(cells)[::-1]))
    return lines / lines[-1]


def _outward(start: float, end: float, first: float, grading: float) -> np.ndarray:
    """Lines (m) from start to end, growing from about the size of the first cell."""
    cells = np.log1p((end - start) / first * (1.0 / grading - 1.0)) / -np.log(grading)
    lines = start + (end - start) * _graded(int(np.ceil(cells)), grading)
    lines[-1] = end
    return lines


def _connectivity(columns: int, rows: int, order: int) -> np.ndarray:
    """Nodes (e, m) of each cell; nodes are numbered along r first, and so are those within a cell."""
    width = columns * order + 1
    corner = order * (np.arange(columns) + width * np.arange(rows)[:, None])
    inside = np.arange(order + 1) + width * np.arange(order + 1)[:, None]
    return corner.reshape(-1, 1) + inside.ravel()


def _element_matrices(r_lines, z_lines, rule: Rule, shear: float, poisson: float) -> np.ndarray:
    """Stiffness (e, 3 m, 3 m) of the cells over U, S, W of their nodes."""
    width, height = (size.reshape(-1, 1) for size in np.meshgrid(np.diff(r_lines), np.diff(z_lines)))
    left = np.tile(r_lines[:-1], len(z_lines) - 1)[:, None]
    count = len(rule.points)
    r = left + 0.5 * width * (1.0 + np.tile(rule.points, count))
    weight = np.pi * r * 0.25 * width * height * np.kron(rule.weights, rule.weights)
    along_r, along_z = np.kron(rule.shape, rule.slope), np.kron(rule.slope, rule.shape)
    b = _strains(np.kron(rule.shape, rule.shape) / r[:, :, None],
                 2.0 / width[:, :, None] * along_r, 2.0 / height[:, :, None] * along_z)  # fmt: skip
    elastic = shear * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    elastic[:3, :3] += 2.0 * shear * poisson / (1.0 - 2.0 * poisson)
    root = np.linalg.cholesky(elastic).T @ b
    root *= np.sqrt(weight)[:, :, None, None]
    root = root.reshape(len(r), 6 * count**2, -1)
    return root.transpose(0, 2, 1) @ root


def _strains(over_r: np.ndarray, d_r: np.ndarray, d_z: np.ndarray) -> np.ndarray:
    """Amplitudes of rr, tt, zz, rz, rt, zt (engineering shear), (e, g, 6, 3 m), from N/r, dN/dr, dN/dz (e, g, m)."""
    b = np.zeros((*over_r.shape[:2], 6, over_r.shape[2], 3))
    u, s, w = np.moveaxis(b, -1, 0)
    u[:, :, 0], s[:, :, 1], w[:, :, 2] = d_r, over_r, d_z
    u[:, :, 3], w[:, :, 3] = d_z, d_r
    u[:, :, 4], s[:, :, 4] = -d_r, d_r - over_r
    u[:, :, 5], s[:, :, 5], w[:, :, 5] = -d_z, d_z, -over_r
    return b.reshape(*b.shape[:3], -1)


def _assembled(elements: np.ndarray, dofs: np.ndarray, size: int) -> csc_array:
    """Sparse matrix from those of the elements (e, n, n), whose dofs are (e, n)."""
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return csc_array((elements.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))


def _reactions(k: csc_array, motion: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Work (2, 2) of the body's reactions in one motion (row) when it moves by another (column)."""
    inner, load = k[free][:, free], -(k @ motion)[free]
    factors = splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    moved = factors.solve(load)
    displacement = motion.copy()
    displacement[free] = moved + factors.solve(load - inner @ moved)
    return motion.T @ (k @ displacement)
