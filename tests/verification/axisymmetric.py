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
from itertools import product

import numpy as np
from numpy.polynomial import legendre
from scipy.sparse import coo_array, csc_array, csr_array, kron
from scipy.sparse.linalg import splu

U, S, W = range(3)
# Terms of the strains' amplitudes rr, tt, zz, rz, rt, zt (engineering shear): factor, unknown, how often it is derived
# with respect to r and to z, power of r it is multiplied by
_STRAINS = (
    ((1.0, U, 1, 0, 0),),
    ((1.0, S, 0, 0, -1),),
    ((1.0, W, 0, 1, 0),),
    ((1.0, U, 0, 1, 0), (1.0, W, 1, 0, 0)),
    ((-1.0, U, 1, 0, 0), (1.0, S, 1, 0, 0), (-1.0, S, 0, 0, -1)),
    ((-1.0, U, 0, 1, 0), (1.0, S, 0, 1, 0), (-1.0, W, 0, 0, -1)),
)


def stiffness(
    radius: float, length: float, domain_radius: float, domain_depth: float, shear: float, poisson: float,
    cells: int = 10, order: int = 4, grading: float = 0.5,
) -> tuple[float, float, float, float]:  # fmt: skip
    """K_H (N/m), K_C (N), K_M (N m) and K_free (N/m) of a rigid caisson bonded to elastic soil.

    H = K_H u + K_C rotation and M = K_C u + K_M rotation at mudline, where depth z is down and the lateral displacement
    is u - rotation z, so that K_C < 0; K_free = K_H - K_C^2/K_M has no moment at mudline.

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
    radius: float, length: float, domain_radius: float, domain_depth: float, shear: float, poisson: float,
    cells: int = 10, order: int = 4, grading: float = 0.5,
) -> np.ndarray:  # fmt: skip
    """H and M (rows) over u and rotation (columns), (2, 2) in N and m; see `stiffness`."""
    r_lines, z_lines = _lines(radius, length, domain_radius, domain_depth, cells, grading)
    rule = Rule.of(order)
    r, z = (coordinate.ravel() for coordinate in np.meshgrid(rule.spread(r_lines), rule.spread(z_lines)))
    body = (r <= radius) & (z == 0.0) | (r == radius) & (z <= length)
    motion = np.zeros((len(r), 3, 2))
    motion[body, U, 0] = 1.0
    motion[body, U, 1] = -z[body]
    motion[body, W, 1] = r[body]
    fixed = np.zeros((len(r), 3), bool)
    fixed[body | (z == domain_depth)] = True
    fixed[r == domain_radius, U] = True
    fixed[r == 0.0, S:] = True
    k = _system(r_lines, z_lines, rule, shear, poisson)
    return _reactions(k, motion.reshape(-1, 2), np.flatnonzero(~fixed))


@dataclass(frozen=True)
class Rule:
    """Lagrange polynomials on Gauss-Lobatto nodes, and Gauss points that integrate their products (nearly, if over r).

    Attributes
    ----------
    nodes : (p + 1,) in -1 .. 1.
    points, weights : (g,) of Gauss.
    shapes : (2, g, p + 1) polynomials at the points, and their derivatives.
    """

    nodes: np.ndarray
    points: np.ndarray
    weights: np.ndarray
    shapes: np.ndarray

    @classmethod
    def of(cls, order: int) -> Rule:
        """The rule of polynomials of an order of 1 or more."""
        inner = legendre.legroots(legendre.legder(np.eye(order + 1)[order]))
        nodes = np.concatenate(([-1.0], np.sort(inner.real), [1.0]))
        points, weights = legendre.leggauss(order + 1)
        series = np.linalg.inv(legendre.legvander(nodes, order))
        shapes = [legendre.legval(points, series).T, legendre.legval(points, legendre.legder(series)).T]
        return cls(nodes, points, weights, np.array(shapes))

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


def _system(r_lines, z_lines, rule: Rule, shear: float, poisson: float) -> csc_array:
    """Stiffness (3 n, 3 n) over U, S, W of the nodes, which are numbered along r first.

    The cells are rectangles: each integral is one along r times one along z, and so is the matrix (Kronecker).
    """
    elastic = shear * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    elastic[:3, :3] += 2.0 * shear * poisson / (1.0 - 2.0 * poisson)
    along_r: dict[tuple[int, int], csr_array] = {}
    for i, j in zip(*np.nonzero(elastic), strict=True):
        for (f, m, r1, z1, p1), (g, n, r2, z2, p2) in product(_STRAINS[i], _STRAINS[j]):
            pair = coo_array(([np.pi * elastic[i, j] * f * g], ([m], [n])), shape=(3, 3))
            part = kron(_products(r_lines, rule, (r1, r2), 1 + p1 + p2), pair, "csr")
            along_r[z1, z2] = along_r.get((z1, z2), 0) + part
    return sum(kron(_products(z_lines, rule, derived, 0), part, "csc") for derived, part in along_r.items())


def _products(lines: np.ndarray, rule: Rule, derived: tuple[int, int], power: int) -> csr_array:
    """Integrals (n, n) along a line of x^power times two shape functions, each derived so many times."""
    half = 0.5 * np.diff(lines)[:, None]
    weight = rule.weights * half ** (1 - sum(derived)) * (lines[:-1, None] + half * (1.0 + rule.points)) ** power
    cells = np.einsum("eg,gi,gj->eij", weight, *rule.shapes[[*derived]])
    nodes = len(rule.nodes[1:]) * np.arange(len(half))[:, None] + np.arange(len(rule.nodes))
    rows, columns = np.broadcast_arrays(nodes[:, :, None], nodes[:, None, :])
    return csr_array((cells.ravel(), (rows.ravel(), columns.ravel())))


def _reactions(k: csc_array, motion: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Work (2, 2) of the body's reactions in one motion (row) when it moves by another (column)."""
    inner, load = k[free][:, free], -(k @ motion)[free]
    factors = splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    moved = factors.solve(load)
    displacement = motion.copy()
    displacement[free] = moved + factors.solve(load - inner @ moved)
    return motion.T @ (k @ displacement)
