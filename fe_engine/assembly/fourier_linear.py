# SPDX-License-Identifier: MIT
"""Linear elements of a Fourier model, which stand between the stations of the interface and the border.

The stations join soil and linear elements by their jumps j alone. With A what the soil at rest leaves to its side of
the interface, C the compliance of the linear elements there, f_s and f_t the forces on both, and q those of the
stations,

    A u_s + q = f_s,   u_t = C (f_t + q),   j = u_s - u_t   =>   A N j + q = f_s - A N d,
    N = (1 + C A)^-1,   d = C (f_s + f_t),   u_s = N (j + d),

so that the interface has as many unknowns as beside a rigid body, harmonic by harmonic. Linear elements are few: C is
dense.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from fe_engine.assembly.fourier_pattern import FourierPattern
from fe_engine.assembly.fourier_rest import AtRest, folding
from fe_engine.assembly.harmonic_factors import Near
from fe_engine.errors import LinearSolverError
from fe_engine.fourier_model import FourierModel
from fe_engine.state import Fields


class LinearElements:
    """Stiffness and compliance of the linear elements.

    Attributes
    ----------
    stiffness : (n_moving, n_moving) on all coefficients, N/m.
    first : equation of their first node; those of displacements behind it are theirs.
    """

    def __init__(self, model: FourierModel, pattern: FourierPattern) -> None:
        assert model.linear is not None
        waves, quads, size = model.harmonics + 1, model.linear.quads, pattern.n_moving
        self.first = int(pattern.held[: model.n_soil].size)
        at = (3 * quads[:, :, None] + np.arange(3)).reshape(len(quads), -1) * waves
        at = at + np.arange(waves)[:, None, None]
        row, column, value = np.broadcast_arrays(at[..., None], at[..., None, :], model.linear.stiffness)
        entries = value.ravel(), (row.ravel(), column.ravel())
        self.stiffness = coo_matrix(entries, shape=(size, size)).tocsr()
        self._harmonics = self._invert(folding(pattern), pattern)

    def _invert(self, fold: csr_matrix, pattern: FourierPattern) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return equations (a,) of each harmonic, counted from the first, and their compliance (a, a) in m/N."""
        waves, theirs = pattern.held.shape[2], np.arange(pattern.n_moving) >= self.first
        matrix, free = (fold @ self.stiffness @ fold.T).tocsr(), theirs & ~pattern.held.ravel()
        inverted = []
        for k in range(waves):
            at = np.flatnonzero(free & (np.arange(pattern.n_moving) % waves == k))
            try:
                lower = np.linalg.cholesky(matrix[at][:, at].toarray())  # C = K^-1 = L^-T L^-1
            except np.linalg.LinAlgError as error:
                raise LinearSolverError("linear elements are not held") from error
            half = np.linalg.solve(lower, np.eye(len(at)))
            inverted.append((at - self.first, half.T @ half))
        return inverted

    def move(self, force: np.ndarray) -> np.ndarray:
        """Return the motions (n,) under forces (n,), both on equations from the first one on."""
        out = np.zeros(len(force))
        for at, compliance in self._harmonics:
            out[at] = compliance @ force[at]
        return out

    def compliance_at(self, k: int, equations: np.ndarray) -> np.ndarray:
        """Return the compliance (a, a) between equations (a,) of harmonic k, 0 where one is -1."""
        out = np.zeros((len(equations), len(equations)))
        there = equations >= 0
        at, compliance = self._harmonics[k]
        place = np.searchsorted(at, equations[there] - self.first)
        out[np.ix_(there, there)] = compliance[np.ix_(place, place)]
        return out

    def add_force(self, displacement: np.ndarray, force: np.ndarray) -> None:
        """Add the forces (n, 3, K) of coefficients (n, 3, K)."""
        force += (self.stiffness @ displacement.ravel()).reshape(force.shape)

    def stored(self, fields: Fields) -> float:
        """Return the energy (J) of the linear elements."""
        u = fields.displacement.ravel()
        return float(0.5 * u @ (self.stiffness @ u))


class BesideLinear:
    """Soil at rest beside linear elements: see `fourier_rest.AtRest`; unknowns of the interface are jumps."""

    def __init__(self, soil: AtRest, linear: LinearElements, pattern: FourierPattern) -> None:
        self.soil, self.linear = soil, linear
        self.uneven = soil.uneven
        self._n_moving, self._joined = pattern.n_moving, pattern.beyond >= 0
        self._beyond = pattern.beyond[self._joined] - linear.first
        harmonic = pattern.interface % pattern.held.shape[2]
        self.matrix = np.zeros_like(soil.matrix)
        self._reduced = np.zeros_like(soil.matrix)  # N
        for k in range(pattern.held.shape[2]):
            mine = np.flatnonzero(harmonic == k)
            block = np.ix_(mine, mine)
            unit = np.eye(len(mine))
            # N = (1 + C A)^-1
            reduced = np.linalg.solve(unit + linear.compliance_at(k, pattern.beyond[mine]) @ soil.matrix[block], unit)
            self._reduced[block] = reduced
            self.matrix[block] = soil.matrix[block] @ reduced  # A N

    def forward(self, rhs: np.ndarray, near: Near | None = None) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        first, n = self.linear.first, self._n_moving
        swept, left = self.soil.forward(np.concatenate([rhs[:first], rhs[n:]]), near)
        force = rhs[first:n].copy()
        force[self._beyond] += left[self._joined]
        shift = np.zeros(len(left))
        shift[self._joined] = self.linear.move(force)[self._beyond]  # d = C (f_s + f_t)
        return (swept, force, shift), left - self.matrix @ shift  # f_s - A N d

    def backward(self, swept: Any, interface: np.ndarray, near: Near | None = None) -> np.ndarray:
        """See `AtRest`."""
        of_soil, force, shift = swept
        first = self.linear.first
        moved = self._reduced @ (interface + shift)  # u_s = N (j + d)
        force[self._beyond] -= (self.soil.matrix @ moved)[self._joined]  # q + f_t = f_s + f_t - A u_s
        soil = self.soil.backward(of_soil, moved, near)
        return np.concatenate([soil[:first], self.linear.move(force), soil[first:]])
