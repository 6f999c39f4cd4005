# SPDX-License-Identifier: MIT
"""Linear systems by a sparse direct solver: counted, timed, and every answer checked against its equations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.clock import Clock
from fe_engine.errors import LinearSolverError
from fe_engine.linear.backends import make_backend
from fe_engine.linear.sparse import scaled_entries

# relative residuals of a linear solve: refined above the first, refused above the second
_REFINE_ABOVE = 1.0e-9
_RESIDUAL_LIMIT = 1.0e-6
_POWER_ITERATIONS = 10  # of the condition estimate


class LinearSolver:
    """Counts, times and checks the work of a backend.

    ``equilibrate`` solves D A D y = D b, x = D y with D = 1/sqrt|diagonal of A|: the rows of water are smaller than
    those of forces by any factor, and a backend judges pivots by the largest entry of the matrix. ``symmetric``: see
    `make_backend`; the residual is that of the whole matrix, so that a promise not kept is refused with the solution.
    """

    def __init__(
        self, name: str, n_unknowns: int, clock: Clock | None = None, equilibrate: bool = False,
        symmetric: bool = False,
    ) -> None:  # fmt: skip
        self.backend = make_backend(name, n_unknowns, symmetric)
        self.equilibrate = equilibrate
        self.clock = clock or Clock()
        self.n_factorisations = 0
        self.n_solves = 0
        self.worst_residual = 0.0
        self._matrix: csr_matrix | None = None

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise a tangent."""
        with self.clock.phase("factorisation"):
            self._matrix = matrix
            if self.equilibrate:
                self._scale, self._matrix = equilibrated(matrix)
            self.backend.factorise(self._matrix)
        self.n_factorisations += 1

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k); refine once and refuse a solution that does not satisfy the equations."""
        with self.clock.phase("solve"):
            d = (self._scale if rhs.ndim == 1 else self._scale[:, None]) if self.equilibrate else 1.0
            rhs = d * rhs
            x = self.backend.solve(rhs).reshape(rhs.shape)
            error = self._relative_residual(x, rhs)
            if error > _REFINE_ABOVE:
                x = x + self.backend.solve(rhs - self._matrix @ x).reshape(rhs.shape)
                error = self._relative_residual(x, rhs)
        self.n_solves += 1
        self.worst_residual = max(self.worst_residual, error)
        if not error <= _RESIDUAL_LIMIT:
            raise LinearSolverError(f"{self.backend.name} returned a solution with relative residual {error:.1e}")
        return d * x

    def condition_estimate(self) -> float | None:
        """Return largest over smallest modulus of the eigenvalues of the last matrix, from below, by power iterations.

        None where nothing has been factorised yet, or the factors give no answer.
        """
        matrix = self._matrix
        return None if matrix is None else condition_estimate(lambda v: matrix @ v, self.backend.solve, matrix.shape[0])

    def close(self) -> None:
        """Release the factors; a condition estimate is no longer available."""
        self._matrix = None
        self.backend.close()

    def _relative_residual(self, x: np.ndarray, rhs: np.ndarray) -> float:
        """Return the largest residual over right-hand side, column by column."""
        residual = np.linalg.norm(rhs - self._matrix @ x, axis=0)
        scale = np.linalg.norm(rhs, axis=0)
        return float(np.max(residual / np.where(scale > 0.0, scale, 1.0)))


def equilibrated(matrix: csr_matrix, kind: type = np.float64) -> tuple[np.ndarray, csr_matrix]:
    """Scale D (n,), 1/sqrt|diagonal| with 1 where that is 0, and D A D in the precision ``kind``, on A's pattern."""
    diagonal = np.abs(matrix.diagonal())
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))  # D A D has 1 on its diagonal
    entries = scaled_entries(matrix, scale, kind)
    return scale, csr_matrix((entries, matrix.indices, matrix.indptr), shape=matrix.shape)


def condition_estimate(
    apply: Callable[[np.ndarray], np.ndarray], solve: Callable[[np.ndarray], np.ndarray], n: int
) -> float | None:
    """Estimate the condition of a map of (n,) and its inverse by power iterations, from below; None if that fails."""
    start = np.random.default_rng(1).normal(size=n)
    largest = _growth(apply, start)
    try:
        smallest = _growth(solve, start)
    except LinearSolverError:
        return None
    return float(largest * smallest) if np.isfinite(largest * smallest) else None


def _growth(apply: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> float:
    """Return the modulus of the largest eigenvalue of a linear map, from below."""
    v, size = start / np.linalg.norm(start), 0.0
    for _ in range(_POWER_ITERATIONS):
        v = apply(v).reshape(start.shape)
        size = float(np.linalg.norm(v))
        if not 0.0 < size < np.inf:
            return size
        v = v / size
    return size
