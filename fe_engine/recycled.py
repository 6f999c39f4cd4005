# SPDX-License-Identifier: MIT
"""Newton steps by GMRES, preconditioned with the factors of an earlier tangent in single precision.

Plasticity, slip and gaps change the tangent's spectrum little from one iteration to the next, and even from the state
at rest to loads in service: flexible GMRES (Saad 1993) with the factors of an earlier tangent needs a handful of
solves for a Newton step, each of which costs a few per cent of a factorisation. Factors in single precision do, at half
the cost. How exact the answer is, the residual of the equations decides, whatever the factors are; a step is as exact
as Newton needs it (Dembo, Eisenstat & Steihaug 1982).

The border dofs are part of the system. What is controlled is met exactly: with b the increments of the border dofs,

    control b = violation:   b = b_p + N y,      equations of the border: P^T (.) = 0,

N spans the motions that are not controlled, P the forces that none of the unknown loads takes up. Border dofs count in
m (times ``scale``), and their equations in N.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator

from fe_engine.assembly import Residual, Tangent
from fe_engine.backends import make_backend
from fe_engine.errors import LinearSolverError
from fe_engine.linear import LinearSolver, condition_estimate, equilibrated
from fe_engine.sparse import times

# From so many unknowns on it pays; below, a factorisation costs no more than a few iterations.
WORTH_FROM = 10_000
# GMRES gives up after so many iterations, which cost as much as new factors; they are also renewed after an increment
# that needed more than so many in the mean of its systems, and late in an increment, whose states then go to and fro.
_LONGEST, _COMFORTABLE, _LATE = 30, 7.0, 5
# Relative residuals of a Newton step: with old factors, and with new ones, where one iteration more does it.
_ENOUGH, _FRESH = 1.0e-2, 1.0e-6
_EXACT = 1.0e-10  # last change of a border stiffness that is refined
_LOOSEST = 0.1  # of a step whose residual Newton needs to fall a little only
_SLACK = 2.0  # the true residual over that of GMRES, whose preconditioner is linear to seven digits only
_NOTHING = 1.0e-300


@dataclass(frozen=True)
class Control:
    """How the border moves: its imposed part (nb,), free motions N (nb, k), and force combinations P (nb, k)."""

    imposed: np.ndarray
    motions: np.ndarray
    forces: np.ndarray


def control_of(control: np.ndarray, load: np.ndarray, violation: np.ndarray, scale: np.ndarray) -> Control:
    """Eliminate the combinations ``control`` (nc, nb), imposed by the forces ``load`` (nb, nc)."""
    imposed = np.linalg.lstsq(control / scale, violation, rcond=None)[0] / scale
    motions = null_space(control / scale) / scale[:, None]
    return Control(imposed, motions, null_space((load / scale[:, None]).T) / scale[:, None])


@dataclass(frozen=True)
class Origin:
    """What factors were made from: single-precision entries of D K D, D (n,), and the border of that tangent."""

    entries: np.ndarray
    scale: np.ndarray
    columns: np.ndarray
    rows: np.ndarray
    corner: np.ndarray


class Recycled:
    """Solves for Newton steps with factors that serve as long as they do.

    Factorisations and solves are added to those of ``counts``.

    Attributes
    ----------
    n_iterations, n_systems : GMRES iterations, and the systems that they were for.
    worn : whether the next system renews the factors.
    origin : what the factors were made from, None where there are none. Factors made from it again are the same.
    """

    def __init__(self, counts: LinearSolver, n_unknowns: int, symmetric: bool = False) -> None:
        self.counts, self.clock = counts, counts.clock
        self.n_iterations = self.n_systems = 0
        self.origin: Origin | None = None
        self.worn = False
        self._backend = make_backend(counts.backend.name, n_unknowns, symmetric, single=True)
        self._shape = self._stiffness = np.zeros((0, 0))  # K^-1 columns, and the border's stiffness
        self._kept: np.ndarray | None = None  # entries that the backend's factors are of
        self._spent: list[int] = []  # iterations of each system since the increment began or the factors were renewed

    def forget(self) -> None:
        """Have the next tangent factorised."""
        self.origin, self.worn = None, False

    def begin_increment(self) -> None:
        """Start to count: an attempt that was given up says nothing of the factors."""
        self._spent = []

    def end_increment(self) -> None:
        """Judge whether the factors have become too old to be of use to the next increment."""
        self.worn = bool(self._spent) and float(np.mean(self._spent)) > _COMFORTABLE

    def factorise(self, tangent: Tangent) -> None:
        """Factorise a tangent; it serves until the factors are renewed."""
        scale, scaled = equilibrated(tangent.matrix, np.float32)
        border = tangent.columns.copy(), tangent.rows.copy(), tangent.corner.copy()
        origin = Origin(scaled.data, scale, *border)
        self.counts.n_factorisations += self.restore(origin, tangent.matrix)
        self.counts.n_solves += 1

    def restore(self, origin: Origin, pattern: csr_matrix) -> bool:
        """Make the factors from their origin, on the pattern of the tangent; return False where they are there still.

        Nothing is counted: where a run goes on from a checkpoint, they have been before.
        """
        self.origin = None  # until there are factors
        self.counts.close()
        renew = self._kept is None or not np.array_equal(self._kept, origin.entries)
        if renew:
            self._kept = None
            matrix = csr_matrix((origin.entries, pattern.indices, pattern.indptr), shape=pattern.shape)
            with self.clock.phase("factorisation"):
                self._backend.factorise(matrix)
        self.origin, self.worn, self._kept = origin, False, origin.entries
        self._shape = self._precondition(origin.columns)
        self._stiffness = origin.corner - origin.rows @ self._shape
        return renew

    def border_stiffness(self, tangent: Tangent) -> np.ndarray:
        """Stiffness (nb, nb) of the border, with the factors of this very tangent. Raises LinearSolverError."""
        self.factorise(tangent)
        shape = self._shape
        for _ in range(_LONGEST):
            more = self._precondition(tangent.columns - tangent.matrix @ shape)
            shape = shape + more
            self.counts.n_solves += 1
            stiffness = tangent.corner - tangent.rows @ shape
            size = np.sqrt(np.abs(np.diagonal(stiffness)))
            if np.all(np.abs(tangent.rows @ more) <= _EXACT * np.outer(size, size)):
                return stiffness
        raise LinearSolverError("refinement of factors in single precision does not converge")

    def step(
        self,
        linear: Residual,
        tangent: Tangent,
        control: Control,
        unbalanced: np.ndarray,
        wanted: float,
        iteration: int,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Newton step (n,), (nb,); ``unbalanced`` (nb,) are the border's residuals, in its own units.

        ``wanted`` is the share of the residual that may be left: no system is solved to less than Newton can use.
        Raises LinearSolverError.
        """
        if iteration >= _LATE or self.worn:
            self.origin = None
        n, b = len(linear.free), control.imposed
        forces = -linear.free - tangent.columns @ b
        rhs = np.concatenate([forces, -control.forces.T @ (unbalanced + tangent.corner @ b)])
        x = None if self.origin is None else self._gmres(tangent, control, rhs, max(_ENOUGH, min(wanted, _LOOSEST)))
        if x is None:
            self.factorise(tangent)
            self._spent = []
            x = self._gmres(tangent, control, rhs, _FRESH)
        if x is None:
            self.forget()
            raise LinearSolverError("GMRES does not converge with factors in single precision")
        return x[:n], b + control.motions @ x[n:]

    def _gmres(self, tangent: Tangent, control: Control, rhs: np.ndarray, tolerance: float) -> np.ndarray | None:
        """Solve for (free dofs, y); None where it takes too long.

        Preconditioned from the right, so that the residual that it minimises is that of the equations (rows scaled);
        the flexible kind keeps the preconditioned vectors, and the answer needs no solve of its own.
        """
        from pyamg.krylov import fgmres  # half a second, which small models need not spend

        assert self.origin is not None
        n, matrix, motions, forces = tangent.matrix.shape[0], tangent.matrix, control.motions, control.forces.T
        columns, rows, corner = tangent.columns @ motions, forces @ tangent.rows, forces @ tangent.corner @ motions
        shape, old_rows = self._shape @ motions, forces @ self.origin.rows
        stiffness = forces @ self._stiffness @ motions
        size = np.concatenate([self.origin.scale, np.full(len(rhs) - n, np.median(self.origin.scale))])

        def precondition(v: np.ndarray) -> np.ndarray:
            v = v / size
            x = self._precondition(v[:n])
            y = np.linalg.solve(stiffness, v[n:] - old_rows @ x)
            return np.concatenate([x - shape @ y, y])

        def apply(x: np.ndarray) -> np.ndarray:
            return size * np.concatenate([times(matrix, x[:n]) + columns @ x[n:], rows @ x[:n] + corner @ x[n:]])

        residuals: list[float] = []
        operator, inverse = (LinearOperator((len(rhs), len(rhs)), matvec=f, dtype=float) for f in (apply, precondition))
        with self.clock.phase("solve"):
            try:
                x, _ = fgmres(
                    operator, size * rhs, tol=tolerance, restart=min(_LONGEST, len(rhs)), maxiter=1, M=inverse,
                    residuals=residuals,
                )  # fmt: skip
            except np.linalg.LinAlgError:
                return None
        taken, left = len(residuals) - 1, residuals[-1] / max(residuals[0], _NOTHING)  # the last one is computed anew
        self.counts.n_solves += taken
        self.n_iterations += taken
        self.n_systems += 1
        self._spent.append(taken)
        if taken >= _LONGEST or not left <= _SLACK * tolerance:
            return None
        if tolerance == _FRESH:
            self.counts.worst_residual = max(self.counts.worst_residual, left)
        return x

    def _precondition(self, rhs: np.ndarray) -> np.ndarray:
        """Apply the factors to rhs (n,) or (n, k)."""
        assert self.origin is not None
        d = self.origin.scale if rhs.ndim == 1 else self.origin.scale[:, None]
        return d * self._backend.solve(d * rhs).reshape(rhs.shape)

    def condition_estimate(self, pattern: csr_matrix) -> float | None:
        """Condition of the tangent that the factors are of, see LinearSolver.condition_estimate."""
        if self.origin is None:
            return None
        d = self.origin.scale
        scaled = csr_matrix((self.origin.entries, pattern.indices, pattern.indptr), shape=pattern.shape)
        if self.counts.equilibrate:
            return condition_estimate(lambda v: scaled @ v, self._backend.solve, len(d))
        return condition_estimate(lambda v: (scaled @ (v / d)) / d, self._precondition, len(d))

    def close(self) -> None:
        """Release the factors."""
        self.origin = self._kept = None
        self._backend.close()
