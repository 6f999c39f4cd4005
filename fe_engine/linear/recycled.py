# SPDX-License-Identifier: MIT
"""Newton steps by GMRES, preconditioned with the factors of an earlier tangent in single precision.

Plasticity changes the tangent's spectrum little from one increment to the next, and slip and gaps are followed (see
`preconditioner`): flexible GMRES (Saad 1993) with the factors of an earlier tangent needs a handful of solves for a
Newton step, each of which costs a few per cent of a factorisation. Factors in single precision do, at half the cost.
Accuracy is judged by the true residual, so that the quality of the factors affects only cost; a step is as exact as
Newton needs it (Dembo, Eisenstat & Steihaug 1982).

The border dofs are part of the system. What is controlled is met exactly: with b the increments of the border dofs,

    control b = violation:   b = b_p + N y,      equations of the border: P^T (.) = 0,

N spans the motions that are not controlled, P the forces that none of the unknown loads takes up. Border dofs count in
m (times ``scale``), and their equations in N.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, gcrotmk

from fe_engine.assembly.bordered import Residual, Tangent
from fe_engine.assembly.system import System
from fe_engine.errors import LinearSolverError
from fe_engine.linear.backends import Pardiso, make_backend
from fe_engine.linear.preconditioner import Control, Factors, Origin, SoilFactors, TangentFactors
from fe_engine.linear.solver import LinearSolver
from fe_engine.linear.sparse import times
from fe_engine.settings import Recycling

_NEW = 3.0  # iterations of a system with new factors
# The limits of settings.Recycling hold for this number of unknowns. A factorisation grows as n^2 and a solve as n^(4/3)
# (nested dissection in space), so that the limits grow with n^(2/3), by at most this factor.
_OF_UNKNOWNS = 50_000
_MOST_PATIENT = 4.0
_FRESH = 1.0e-6  # relative residual of a Newton step with new factors: one iteration more does it
_EXACT = 1.0e-10  # last change of a border stiffness that is refined
_SLACK = 2.0  # the true residual over that of GMRES, whose preconditioner is linear to seven digits only
_NOTHING = 1.0e-300


def control_of(control: np.ndarray, load: np.ndarray, violation: np.ndarray, scale: np.ndarray) -> Control:
    """Eliminate the combinations ``control`` (nc, nb), imposed by the forces ``load`` (nb, nc)."""
    imposed = np.linalg.lstsq(control / scale, violation, rcond=None)[0] / scale
    motions, forces = _kernel(control / scale), _kernel((load / scale[:, None]).T)
    return Control(imposed, motions / scale[:, None], forces / scale[:, None])


def _kernel(matrix: np.ndarray) -> np.ndarray:
    """Return the null space (nb, k) of a matrix (nc, nb), which all increments of a stage ask for."""
    return _kept_kernel(np.ascontiguousarray(matrix).tobytes(), matrix.shape)


@lru_cache(maxsize=32)
def _kept_kernel(entries: bytes, shape: tuple[int, int]) -> np.ndarray:
    basis: np.ndarray = null_space(np.frombuffer(entries).reshape(shape))
    return basis


class Recycled:
    """Solves for Newton steps with factors of earlier tangents as long as they are efficient.

    Factorisations and solves are added to those of ``counts``.

    Attributes
    ----------
    n_iterations, n_systems : GMRES iterations, and the systems that they were for.
    worn : whether the next system renews the factors.
    """

    def __init__(self, counts: LinearSolver, system: System, settings: Recycling) -> None:
        self.counts, self.clock = counts, counts.clock
        self.n_iterations = self.n_systems = 0
        self.worn = False
        self._factors = _factors(counts.backend.name, system, settings.many)
        patience = min((system.pattern.n_free / _OF_UNKNOWNS) ** (2.0 / 3.0), _MOST_PATIENT)
        self._refinements = settings.longest
        self._longest = int(settings.longest * max(patience, 1.0))
        self._comfortable = _NEW + settings.comfortable * patience
        self._valid = False
        self._spent: list[int] = []  # iterations of each system since the increment began or the factors were renewed

    @property
    def origin(self) -> Origin | None:
        """What the factors were made from, None where there are none. Factors made from it again are the same."""
        return self._factors.origin if self._valid else None

    def forget(self) -> None:
        """Have the next tangent factorised."""
        self._valid = self.worn = False

    def begin_increment(self) -> None:
        """Start to count: an abandoned attempt is no measure of the factors."""
        self._spent = []

    def end_increment(self) -> None:
        """Judge whether the factors have become too old to be of use to the next increment."""
        self.worn = bool(self._spent) and float(np.mean(self._spent)) > self._comfortable

    def factorise(self, tangent: Tangent) -> None:
        """Factorise a tangent, for use until the factors are renewed."""
        self.counts.n_factorisations += self.restore(self._factors.origin_of(tangent), tangent.matrix)
        self.counts.n_solves += 1

    def restore(self, origin: Origin, pattern: csr_matrix) -> bool:
        """Make the factors from their origin, on the pattern of the tangent; return False where they are there still.

        Nothing is counted: where a run goes on from a checkpoint, they have been before.
        """
        self.forget()  # until there are factors
        self.counts.close()
        with self.clock.phase("factorisation"):
            renewed = self._factors.make(origin, pattern)
        self._valid = True
        return renewed

    def border_stiffness(self, tangent: Tangent) -> np.ndarray:
        """Return stiffness (nb, nb) of the border, with the factors of this very tangent. Raises LinearSolverError."""
        self.factorise(tangent)
        shape = self._factors.solve(tangent.columns)
        for _ in range(self._refinements):
            more = self._factors.solve(tangent.columns - tangent.matrix @ shape)
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
        share: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the Newton step (n,), (nb,); ``unbalanced`` (nb,) are the border's residuals, in its own units.

        ``share`` of the residual may remain with earlier factors.
        Raises LinearSolverError.
        """
        if self.worn:
            self.forget()
        n, b = len(linear.free), control.imposed
        forces = -linear.free - tangent.columns @ b
        rhs = np.concatenate([forces, -control.forces.T @ (unbalanced + tangent.corner @ b)])
        x = self._gmres(tangent, control, rhs, share) if self._valid else None
        if x is None:
            self.factorise(tangent)
            self._spent = []
            x = self._gmres(tangent, control, rhs, min(share, _FRESH))
        if x is None:
            self.forget()
            raise LinearSolverError("GMRES does not converge with factors in single precision")
        return x[:n], b + control.motions @ x[n:]

    def _gmres(self, tangent: Tangent, control: Control, rhs: np.ndarray, tolerance: float) -> np.ndarray | None:
        """Solve for (free dofs, y); None where it takes too long.

        Preconditioned from the right, so that the residual that it minimises is that of the equations (rows scaled);
        the flexible kind keeps the preconditioned vectors, and the answer needs no solve of its own.
        """
        n, matrix, motions, forces = tangent.matrix.shape[0], tangent.matrix, control.motions, control.forces.T
        columns, rows, corner = tangent.columns @ motions, forces @ tangent.rows, forces @ tangent.corner @ motions
        scale = self._factors.origin.scale
        size = np.concatenate([scale, np.full(len(rhs) - n, np.median(scale))])

        taken = 0

        def precondition(v: np.ndarray) -> np.ndarray:
            nonlocal taken
            taken += 1
            z = self._factors.apply(v / size)
            if not np.all(np.isfinite(z)):
                raise LinearSolverError("the factors overflow in single precision")
            return z

        def apply(x: np.ndarray) -> np.ndarray:
            return size * np.concatenate([times(matrix, x[:n]) + columns @ x[n:], rows @ x[:n] + corner @ x[n:]])

        operator, inverse = (LinearOperator((len(rhs), len(rhs)), matvec=f, dtype=float) for f in (apply, precondition))
        b, longest = size * rhs, min(self._longest, len(rhs))
        with self.clock.phase("solve"):
            try:
                self._factors.follow(tangent, control)
                # one cycle, nothing carried over from system to system: flexible GMRES
                x, _ = gcrotmk(operator, b, rtol=tolerance, atol=0.0, maxiter=1, M=inverse, m=longest, k=0)
            except (np.linalg.LinAlgError, LinearSolverError):
                return None
            left = float(np.linalg.norm(b - apply(x))) / max(float(np.linalg.norm(b)), _NOTHING)
        self.counts.n_solves += taken
        self.n_iterations += taken
        self.n_systems += 1
        self._spent.append(taken)
        if taken >= self._longest or not left <= _SLACK * tolerance:
            return None
        if tolerance <= _FRESH:
            self.counts.worst_residual = max(self.counts.worst_residual, left)
        return x

    def condition_estimate(self, pattern: csr_matrix) -> float | None:
        """Return the condition of the tangent that the factors are of, see LinearSolver.condition_estimate."""
        return self._factors.condition_estimate(pattern, self.counts.equilibrate) if self._valid else None

    def close(self) -> None:
        """Release the factors."""
        self.forget()
        self._factors.close()


def _factors(name: str, system: System, many: float) -> Factors:
    backend = make_backend(name, system.pattern.n_free, system.model.symmetric, single=True)
    block = system.track_contact_block() if isinstance(backend, Pardiso) else None
    if block is None:
        return TangentFactors(backend)
    assert isinstance(backend, Pardiso)
    return SoilFactors(backend, block, many)
