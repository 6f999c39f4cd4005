# SPDX-License-Identifier: MIT
"""Preconditioners of the bordered system, made from an earlier tangent in single precision.

`SoilFactors` keeps the soil of the earlier tangent and has the contact of the present one: so that old factors serve
badly is stations that have opened, closed or begun to slip since, much more than soil that has yielded. All but the
equations of the interface are eliminated once; what is left is their soil's stiffness S (m, m), dense and small, and

    M = S + C,   C the contact of the present tangent,

is inverted for one contact C_0, and corrected for the equations J that have changed since (Woodbury 1950):

    M^-1 = W - W_J T W^J,   W = (S + C_0)^-1,   T = dC (1 + W_JJ dC)^-1.

The border dofs reach the interface only, and are eliminated there. `TangentFactors` are those of the earlier tangent as
a whole, for backends that cannot leave equations over, and for models whose border dofs reach further.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numba import get_num_threads
from scipy.linalg import lapack
from scipy.sparse import csr_matrix
from threadpoolctl import ThreadpoolController

from fe_engine.assembly.bordered import Tangent
from fe_engine.assembly.contact_block import ContactBlock
from fe_engine.errors import LinearSolverError
from fe_engine.linear.backends import Backend, Pardiso
from fe_engine.linear.solver import condition_estimate, equilibrated
from fe_engine.memory import require_for_blas

# Changes of the scaled contact (the diagonal of the tangent is 1 there) below this are neglected.
_FELT = 1.0e-2
_LARGE = 1000  # rows from which a dense matrix is factorised on all threads


def _nothing() -> np.ndarray:
    return np.zeros(0)


@dataclass(frozen=True)
class Control:
    """How the border moves: its imposed part (nb,), free motions N (nb, k), and force combinations P (nb, k)."""

    imposed: np.ndarray
    motions: np.ndarray
    forces: np.ndarray


@dataclass(frozen=True)
class Origin:
    """What factors were made from: single-precision entries of D K D, and D (n,).

    ``contact`` (k,), N/m, is that of W, which K then does without; else K has it, and columns, rows and corner are the
    border of that tangent.
    """

    entries: np.ndarray
    scale: np.ndarray
    columns: np.ndarray = field(default_factory=_nothing)
    rows: np.ndarray = field(default_factory=_nothing)
    corner: np.ndarray = field(default_factory=_nothing)
    contact: np.ndarray = field(default_factory=_nothing)


class Factors(Protocol):
    """What GMRES asks of a preconditioner.

    Attributes
    ----------
    origin : what it was made from. Made from it again it is the same.
    """

    origin: Origin

    def origin_of(self, tangent: Tangent) -> Origin:
        """Return what is to be kept of a tangent."""

    def make(self, origin: Origin, pattern: csr_matrix) -> bool:
        """Factorise; return False where the factors are there still."""

    def follow(self, tangent: Tangent, control: Control) -> None:
        """Take from the present tangent what the preconditioner can follow."""

    def apply(self, v: np.ndarray) -> np.ndarray:
        """Solve the bordered system for v (n + k,), roughly."""

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k) with the border at rest, roughly."""

    def condition_estimate(self, pattern: csr_matrix, equilibrated_too: bool) -> float | None:
        """Return the condition of the matrix that the factors are of; of D K D if ``equilibrated_too``."""

    def close(self) -> None:
        """Release the factors."""


class TangentFactors:
    """An earlier tangent as a whole, border included."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self._made: np.ndarray | None = None  # entries that the backend's factors are of

    def origin_of(self, tangent: Tangent) -> Origin:
        """Return the scaled tangent and its border."""
        scale, scaled = equilibrated(tangent.matrix, np.float32)
        return Origin(scaled.data, scale, tangent.columns.copy(), tangent.rows.copy(), tangent.corner.copy())

    def make(self, origin: Origin, pattern: csr_matrix) -> bool:
        """See `Factors`."""
        renewed = self._factorise(origin, pattern)
        self.origin = origin
        self._shape = self.solve(origin.columns)
        self._stiffness = origin.corner - origin.rows @ self._shape
        return renewed

    def follow(self, tangent: Tangent, control: Control) -> None:
        """Choose the motions that are free; of the tangent nothing is taken."""
        forces, motions = control.forces.T, control.motions
        self._now = self._shape @ motions, forces @ self.origin.rows, forces @ self._stiffness @ motions

    def apply(self, v: np.ndarray) -> np.ndarray:
        """See `Factors`."""
        shape, rows, stiffness = self._now
        n = len(self.origin.scale)
        x = self.solve(v[:n])
        y = np.linalg.solve(stiffness, v[n:] - rows @ x)
        return np.concatenate([x - shape @ y, y])

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """See `Factors`."""
        d = _along(self.origin.scale, rhs)
        return d * self._scaled_solve(d * rhs).reshape(rhs.shape)

    def condition_estimate(self, pattern: csr_matrix, equilibrated_too: bool) -> float | None:
        """See `Factors`."""
        d, scaled = self.origin.scale, self._scaled(pattern)
        if equilibrated_too:
            return condition_estimate(lambda v: scaled @ v, self._scaled_solve, len(d))
        return condition_estimate(lambda v: (scaled @ (v / d)) / d, self.solve, len(d))

    def close(self) -> None:
        """See `Factors`."""
        self._made = None
        self._backend.close()

    def _factorise(self, origin: Origin, pattern: csr_matrix) -> bool:
        if self._made is not None and np.array_equal(self._made, origin.entries):
            return False
        self._made = None  # until there are factors
        self._backend.factorise(_on(pattern, origin.entries))
        self._made = origin.entries
        return True

    def _scaled_solve(self, rhs: np.ndarray) -> np.ndarray:
        return self._backend.solve(rhs)

    def _scaled(self, pattern: csr_matrix) -> csr_matrix:
        return _on(pattern, self.origin.entries)


class SoilFactors(TangentFactors):
    """The soil of an earlier tangent, with the contact and the border of the present one."""

    _backend: Pardiso

    def __init__(self, backend: Pardiso, block: ContactBlock, many: float) -> None:
        """Prepare; see settings.Recycling for ``many``."""
        super().__init__(backend)
        self._many = many
        backend.keep(block.equations)
        self._block = block
        self._inverse = np.zeros((0, 0), dtype=np.float32)  # W
        self._inverted: np.ndarray | None = None  # contact that W is of
        self._blas = ThreadpoolController().select(internal_api="openblas")

    def origin_of(self, tangent: Tangent) -> Origin:
        """Return the scaled soil, and the contact."""
        assert tangent.contact is not None
        scale, scaled = equilibrated(tangent.matrix, np.float32)
        entries, d = scaled.data, scale[self._block.equations]
        soil = tangent.matrix.data[self._block.positions] - tangent.contact  # K without C
        entries[self._block.positions] = d[self._block.row] * soil * d[self._block.column]
        return Origin(entries, scale, contact=tangent.contact)

    def make(self, origin: Origin, pattern: csr_matrix) -> bool:
        """See `Factors`."""
        renewed = self._factorise(origin, pattern)
        self._d = origin.scale[self._block.equations]
        if renewed or self._inverted is None or not np.array_equal(self._inverted, origin.contact):
            self._invert(origin.contact)
        self.origin, self._changed = origin, np.zeros(0, dtype=np.int64)
        return renewed

    def follow(self, tangent: Tangent, control: Control) -> None:
        """Correct the inverse for the contact that has changed, and eliminate the border."""
        assert tangent.contact is not None
        self._correct(tangent.contact)
        d, equations, forces = self._d, self._block.equations, control.forces.T
        shape = self._of_contact(d[:, None] * (tangent.columns[equations] @ control.motions))
        rows = forces @ tangent.rows[:, equations] * d
        # Schur complement of the border
        self._now = shape, rows, forces @ tangent.corner @ control.motions - rows @ shape

    def apply(self, v: np.ndarray) -> np.ndarray:
        """See `Factors`."""
        shape, rows, stiffness = self._now
        d, y = self.origin.scale, np.zeros(len(stiffness))

        def interface(reduced: np.ndarray) -> np.ndarray:
            z = self._of_contact(reduced)
            y[:] = np.linalg.solve(stiffness, v[len(d) :] - rows @ z)
            return z - shape @ y

        x = d * self._backend.solve_with(interface, d * v[: len(d)])
        return np.concatenate([x, y])

    def close(self) -> None:
        """See `Factors`."""
        super().close()
        self._inverted, self._inverse = None, np.zeros((0, 0), dtype=np.float32)

    def _scaled_solve(self, rhs: np.ndarray) -> np.ndarray:
        return self._backend.solve_with(self._of_contact, rhs)

    def _scaled(self, pattern: csr_matrix) -> csr_matrix:
        entries = self.origin.entries.astype(float)
        entries[self._block.positions] += self._scaled_contact(self.origin.contact)
        return _on(pattern, entries)

    def _scaled_contact(self, contact: np.ndarray) -> np.ndarray:
        return self._d[self._block.row] * contact * self._d[self._block.column]

    def _invert(self, contact: np.ndarray) -> None:
        """Form W of a contact."""
        self._inverted = None
        size = len(self._backend.schur)
        threads = get_num_threads() if size > _LARGE else 1
        # the matrix, and what it is solved for in place; the inverse that is replaced is there meanwhile
        require_for_blas(2.0 * 4.0 * size**2, threads, f"the inverse of the interface ({size:,} equations)")
        matrix = np.array(self._backend.schur, order="F")
        np.add.at(matrix, (self._block.row, self._block.column), self._scaled_contact(contact).astype(np.float32))
        with self._threads(len(matrix)):
            factors, pivots, wrong = lapack.sgetrf(matrix, overwrite_a=True)
            if wrong:
                raise LinearSolverError("the interface is singular in single precision")
            unit = np.eye(len(matrix), dtype=np.float32, order="F")
            # three times faster than sgetri
            self._inverse, self._inverted = lapack.sgetrs(factors, pivots, unit, overwrite_b=True)[0], contact

    def _correct(self, contact: np.ndarray) -> None:
        """Form T for the equations whose contact has changed."""
        block = self._block
        change = self._scaled_contact(contact - self.origin.contact)
        felt, hit = np.abs(change) > _FELT, np.zeros(len(block.equations), dtype=bool)
        hit[block.row[felt]] = hit[block.column[felt]] = True
        if np.count_nonzero(hit) > self._many * len(hit):
            self._invert(contact)
            self.origin = replace(self.origin, contact=contact)
            hit[:] = False
        self._changed = np.flatnonzero(hit)
        inside, local = hit[block.row] & hit[block.column], np.cumsum(hit) - 1
        delta = np.zeros((len(self._changed), len(self._changed)), dtype=np.float32)
        np.add.at(delta, (local[block.row[inside]], local[block.column[inside]]), change[inside])
        self._rows = np.ascontiguousarray(self._inverse[self._changed])
        with self._threads(len(delta)):
            among = np.eye(len(delta), dtype=np.float32) + self._rows[:, self._changed] @ delta
            # T = dC (1 + W_JJ dC)^-1, Woodbury 1950
            self._t = np.ascontiguousarray(np.linalg.solve(among.T, delta.T).T)

    def _threads(self, size: int) -> AbstractContextManager[object]:
        """Return all threads for a large matrix; after a small one they would spin for longer than it took."""
        return self._blas.limit(limits=get_num_threads()) if size > _LARGE else nullcontext()

    def _of_contact(self, rhs: np.ndarray) -> np.ndarray:
        """Apply M^-1 to rhs (m,) or (m, k)."""
        r = np.array(rhs, dtype=np.float32)
        if len(self._changed):
            r[self._changed] -= self._t @ (self._rows @ r)  # W (r - T W^J r) = M^-1 r
        return self._inverse @ r


def _along(scale: np.ndarray, rhs: np.ndarray) -> np.ndarray:
    return scale if rhs.ndim == 1 else scale[:, None]


def _on(pattern: csr_matrix, entries: np.ndarray) -> csr_matrix:
    return csr_matrix((entries, pattern.indices, pattern.indptr), shape=pattern.shape)
