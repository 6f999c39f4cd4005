# SPDX-License-Identifier: MIT
"""Newton's bordered linear system: what Newton asks of whoever solves it, and the way through sparse factors.

With increments du of the free dofs and dq of the border dofs, controls C, patterns G of unknown forces lambda,

    [ K  B  .  ] [ du     ]   [ -r_free                  ]
    [ R  D -G  ] [ dq     ] = [ -(r_border - F - G l)    ]
    [ .  C  .  ] [ dlambda]   [ violation of the control ]

`FactorStage` eliminates du: K is factorised alone, and the small Schur complement S = D - R K^-1 B is the tangent
stiffness of the border dofs. Large models solve the same system with earlier factors (see `recycled`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.assembly.bordered import Residual, Tangent
from fe_engine.assembly.system import System
from fe_engine.errors import LinearSolverError
from fe_engine.linear.preconditioner import Origin
from fe_engine.linear.recycled import Recycled, control_of
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.globalisation import CLOSE, bounds

# Where motions are imposed anew, the right-hand side is dominated by penalty forces, because the soil has not moved
# yet: thousands of times the forces that balance in the end. Such a system is solved to this share.
_IMPOSED = 1.0e-6


@dataclass(frozen=True)
class Balance:
    """What the border has to meet: control (nc, nb) by forces ``load`` (nb, nc), and what is left.

    violation : (nc,) of the control; unbalanced : (nb,) border residual that no unknown force takes up; scale : (nb,)
    lengths, see model.Model.
    """

    control: np.ndarray
    load: np.ndarray
    violation: np.ndarray
    unbalanced: np.ndarray
    scale: np.ndarray


class LinearStage(Protocol):
    """Solves bordered systems for Newton.

    Attributes
    ----------
    bounds : shares of its residual within which a linear system is to be solved.
    close_below : relative residual below which an increment that stalls goes on by half steps.
    """

    bounds: tuple[float, float]
    close_below: float

    def begin_increment(self, careful: bool) -> None:
        """Begin to count for an increment, which is ``careful`` where a larger one has failed shortly before."""

    def end_increment(self) -> None:
        """Judge after an increment that has converged."""

    def forget(self) -> None:
        """Drop what earlier increments have left."""

    def step(self, linear: Residual, tangent: Any, balance: Balance, share: float, imposed: bool) -> tuple[Any, Any]:
        """Return the Newton step (n,), (nb,), leaving a ``share`` of the residual; raise LinearSolverError.

        ``imposed``: this very system imposes motions anew.
        """

    def border_stiffness(self, tangent: Any) -> np.ndarray:
        """Return the tangent stiffness (nb, nb) of the border dofs."""

    @property
    def origin(self) -> Origin | None:
        """What the next increment begins with and a checkpoint has to keep; None where that is nothing."""

    def restore(self, origin: Origin) -> None:
        """Begin the next increment with this."""

    def condition_estimate(self) -> float | None:
        """Return the condition of the last matrix that was factorised, from below; None where there is none."""

    def close(self) -> None:
        """Release all factors."""


class FactorStage:
    """Solves with factors of the tangent, or of an earlier one in large models (see settings.Recycling)."""

    close_below = CLOSE

    def __init__(self, system: System, solver: LinearSolver, settings: Settings) -> None:
        self.system, self.solver = system, solver
        self.bounds = settings.shares or bounds(system.pattern.n_free)
        large = system.pattern.n_free >= settings.recycling.start
        self.recycled = Recycled(solver, system, settings.recycling) if large else None

    def begin_increment(self, careful: bool) -> None:
        """See `LinearStage`."""
        if self.recycled is not None:
            self.recycled.begin_increment()

    def end_increment(self) -> None:
        """See `LinearStage`."""
        if self.recycled is not None:
            self.recycled.end_increment()

    def forget(self) -> None:
        """See `LinearStage`."""
        if self.recycled is not None:
            self.recycled.forget()

    def step(
        self, linear: Residual, tangent: Tangent, balance: Balance, share: float, imposed: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `LinearStage`."""
        if self.recycled is not None:
            target = min(_IMPOSED, self.bounds[0]) if imposed else share
            control = control_of(balance.control, balance.load, balance.violation, balance.scale)
            try:
                return self.recycled.step(linear, tangent, control, balance.unbalanced, target)
            except LinearSolverError:  # single precision does not do here
                self.recycled.close()  # not both factors at a time
        self.solver.factorise(tangent.matrix)
        solved = self.solver.solve(np.column_stack([-linear.free, tangent.columns]))
        step, shape = solved[:, 0], solved[:, 1:]
        stiffness = tangent.corner - tangent.rows @ shape
        n_border, n_control = balance.load.shape
        if n_border == 0:
            return step, np.zeros(0)
        matrix = np.block([[stiffness, -balance.load], [balance.control, np.zeros((n_control, n_control))]])
        rhs = np.concatenate([-balance.unbalanced - tangent.rows @ step, balance.violation])
        try:
            solution = np.linalg.solve(matrix, rhs)
        except np.linalg.LinAlgError as error:
            raise LinearSolverError("the tangent stiffness of the border dofs is singular") from error
        return step - shape @ solution[:n_border], solution[:n_border]

    def border_stiffness(self, tangent: Tangent) -> np.ndarray:
        """See `LinearStage`."""
        if self.recycled is not None:
            try:
                return self.recycled.border_stiffness(tangent)
            except LinearSolverError:
                self.recycled.forget()
        self.solver.factorise(tangent.matrix)
        stiffness: np.ndarray = tangent.corner - tangent.rows @ self.solver.solve(tangent.columns)
        return stiffness

    @property
    def origin(self) -> Origin | None:
        """What the factors that the next increment begins with were made from."""
        return None if self.recycled is None or self.recycled.worn else self.recycled.origin

    def restore(self, origin: Origin) -> None:
        """Begin the next increment with factors made from this."""
        if self.recycled is not None:
            self.recycled.restore(origin, self._pattern)

    def condition_estimate(self) -> float | None:
        """See `LinearStage`."""
        if self.recycled is None or self.recycled.origin is None:
            return self.solver.condition_estimate()
        return self.recycled.condition_estimate(self._pattern)

    def close(self) -> None:
        """See `LinearStage`."""
        self.solver.close()
        if self.recycled is not None:
            self.recycled.close()

    @property
    def _pattern(self) -> csr_matrix:
        return self.system.matrix_pattern
