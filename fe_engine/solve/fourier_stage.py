# SPDX-License-Identifier: MIT
"""Newton steps of a Fourier model by GMRES, preconditioned with elastic soil and the contact of the present tangent.

The tangent is P + D: P has the soil at rest with its water, contact and film of the stations and the border, D what the
soil that yields has beyond the elastic tangent. The series takes the soil at rest apart into one matrix a harmonic, and
all but the equations of the interface are eliminated (see `fourier_rest`): what that leaves, contact and border make a
dense matrix, which is factorised at each step. So P is inverted exactly. With x = P^-1 (rhs + v) there is

    (1 + D P^-1) v = -D P^-1 rhs,

where v has forces on elements that yield alone: GMRES (Saad & Schultz 1986) finds it in a few iterations, none where
the soil is elastic. It is cut short: a truncated Newton method (Dembo & Steihaug 1983). Its iterations ask P^-1 for
the nodes of these elements alone, in single precision, which is far closer than they are to go; x is made from v with
all of P^-1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.linalg import lapack, solve_triangular

from fe_engine.assembly.bordered import Residual
from fe_engine.assembly.fourier_system import FourierSystem, FourierTangent
from fe_engine.clock import Clock
from fe_engine.compiled import njit
from fe_engine.conventions import REGIME_ELASTIC
from fe_engine.errors import LinearSolverError
from fe_engine.linear.preconditioner import Control, Origin
from fe_engine.linear.recycled import control_of
from fe_engine.solve.fourier_near import NearProduct
from fe_engine.solve.stage import Balance

# Shares of its residual within which a system is solved: of an increment as large as the ones before it, and of one
# after a failed attempt, where exact steps follow soft modes too far
_BOUNDS, _CAREFUL = (1.0e-3, 1.0e-2), (1.0e-2, 0.1)
# Ten times the bricks' value: half steps cost little here, and lift-off of the lid stalls at residuals in between
_CLOSE = 1.0e-2
# Iterations of a Newton step. Where sand is about to localise the tangent has soft modes; an exact step follows them
# far beyond where they hold; the first iterations hardly contain them, and Newton judges by the true residual. Without
# this bound lift-off takes twice as many Newton steps, and a series of 10 harmonics stops before 2.5 mm of the paper's
# pull.
_FIRST_MODES = 15
_MOST = 200  # iterations where the answer is to be exact; more of them show a tangent that is nearly singular
_EXACT = 1.0e-10
_SINGLE = 1.0e-3  # share of the loads that factors in single precision may leave before refinement


class FourierStage:
    """Solves bordered systems of a Fourier model; see `linear_stage.LinearStage`.

    Attributes
    ----------
    n_factorisations, n_solves, n_iterations : dense factorisations, solves with P, and iterations so far.
    worst_residual : 0, since systems are solved as far as Newton asks.
    """

    close_below = _CLOSE

    def __init__(self, system: FourierSystem, clock: Clock | None = None) -> None:
        self.system, self.clock = system, clock or Clock()
        self.backend = SimpleNamespace(name="fourier", versions=dict)
        self.n_factorisations = self.n_solves = self.n_iterations = 0
        self.worst_residual = 0.0
        self.bounds = _BOUNDS
        self._room = Room({})

    # --- Newton's questions ---

    def begin_increment(self, careful: bool) -> None:
        """Choose how far systems are solved; no state is kept between increments."""
        self.bounds = _CAREFUL if careful else _BOUNDS

    def end_increment(self) -> None:
        """Do nothing: no state is kept between increments."""

    def forget(self) -> None:
        """Do nothing: no state is kept between increments."""

    @property
    def origin(self) -> Origin | None:
        """None: the next increment depends on the state alone."""
        return None

    def restore(self, origin: Origin) -> None:
        """Do nothing: there is no state to restore."""

    def condition_estimate(self) -> float | None:
        """Return None: no tangent is ever assembled."""
        return None

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def step(
        self, linear: Residual, tangent: FourierTangent, balance: Balance, share: float, imposed: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `linear_stage.LinearStage`."""
        control = control_of(balance.control, balance.load, balance.violation, balance.scale)
        p = self._preconditioner(tangent, control, False)
        rhs = p.right_hand_side(-linear.free, -balance.unbalanced)
        x = self._solve(p, tangent, rhs, share, None if imposed else float(np.linalg.norm(linear.free)))
        return p.motions(x)

    def border_stiffness(self, tangent: FourierTangent) -> np.ndarray:
        """Return the stiffness (nb, nb) of the border: its forces under unit motions."""
        return np.stack([self.border_forces(tangent, motion) for motion in np.eye(self.system.model.n_border)], axis=1)

    def border_forces(self, tangent: FourierTangent, motion: np.ndarray) -> np.ndarray:
        """Return the forces (nb,) on the border under a motion (nb,) of it."""
        nb, n = self.system.model.n_border, self.system.pattern.n_free
        none = np.zeros((nb, 0))
        p = self._preconditioner(tangent, Control(motion, none, none), True)
        x = self._solve(p, tangent, p.right_hand_side(np.zeros(n), np.zeros(nb)), _EXACT, None)
        return p.border_force(x)

    def _preconditioner(self, tangent: FourierTangent, control: Control, precise: bool) -> Preconditioner:
        with self.clock.phase("factorisation"):
            self.n_factorisations += 1
            return Preconditioner(self.system, tangent, control, self._room, precise)

    def _solve(
        self, p: Preconditioner, tangent: FourierTangent, rhs: np.ndarray, share: float, size: float | None
    ) -> np.ndarray:
        """Solve for rhs (n + k,), up to a share of ``size`` (N), or of what P alone leaves where that is None."""
        with self.clock.phase("solve"):
            self.n_solves += 1
            if (tangent.regime == REGIME_ELASTIC).all():  # P is the tangent
                return p.solve(rhs)
            yielding, exact = self.system.yielding(tangent), share == _EXACT
            rows = self.system.pattern.equation[yielding[1]].ravel()
            near = None if exact else NearProduct(self.system, tangent, yielding, p.rest, p.interface)

            def product(v: np.ndarray) -> np.ndarray:
                """Return D P^-1 v (r,) on the rows (r,) where D has something."""
                return self._product(p, tangent, np.bincount(rows, v, p.size))[rows] if near is None else near(v)

            v = -(self._product(p, tangent, rhs)[rows] if near is None else near.behind(*p.halfway(rhs)[:2]))
            left, both = float(np.linalg.norm(v)), rhs.copy()
            target = share * (left if size is None else size)
            if left > target:
                both[rows] += self._gmres(product, v, left, target, exact)
            return p.solve(both)

    def _product(self, p: Preconditioner, tangent: FourierTangent, v: np.ndarray) -> np.ndarray:
        """Return D P^-1 v (n_moving,) of forces (n + k,), by all factors."""
        return self.system.plastic_product(tangent, p.solve(v)[: self.system.pattern.n_moving])

    def _gmres(
        self, product: Callable[[np.ndarray], np.ndarray], v: np.ndarray, size: float, target: float, exact: bool
    ) -> np.ndarray:
        """Return the forces P x (r,) of (P + D) x = v (r,), of the norm ``size``, when ``target`` is left.

        product : D P^-1 of forces (r,). Stop after a few iterations where that is not to be ``exact``; raise
        LinearSolverError where it is and fails.
        """
        most = min(_MOST if exact else _FIRST_MODES, len(v))
        basis = np.empty((most + 1, len(v)))
        upper, turns, rhs = np.zeros((most + 1, most)), np.zeros((most, 2)), np.zeros(most + 1)
        basis[0], rhs[0] = v / size, size
        for k in range(most):
            w = basis[k] + product(basis[k])
            for _ in range(2 if exact else 1):  # rounding adds up over many iterations: twice (Daniel et al. 1976)
                shares = basis[: k + 1] @ w
                w -= shares @ basis[: k + 1]
                upper[: k + 1, k] += shares
            upper[k + 1, k] = length = np.linalg.norm(w)
            if not _turn(upper[:, k], turns, rhs, k):
                raise LinearSolverError("the tangent is singular")
            self.n_iterations += 1
            self.n_solves += 1
            if not np.isfinite(rhs[k + 1]):
                raise LinearSolverError("GMRES overflows")
            if abs(rhs[k + 1]) <= target or (k + 1 == most and not exact):
                self.n_solves += 1
                found: np.ndarray = solve_triangular(upper[: k + 1, : k + 1], rhs[: k + 1]) @ basis[: k + 1]
                return found
            basis[k + 1] = w / length
        raise LinearSolverError(f"GMRES leaves {abs(rhs[most]) / size:.1e} of the forces after {most} iterations")


@dataclass(frozen=True)
class Room:
    """Arrays that serve one step after the other: fresh pages of memory cost as much as the factorisation."""

    arrays: dict[tuple[str, int], np.ndarray]

    def square(self, name: str, size: int) -> np.ndarray:
        """Return an array (size, size) in Fortran's order, with what the last user left in it."""
        if (name, size) not in self.arrays:
            self.arrays[name, size] = np.empty((size, size), order="F")
        return self.arrays[name, size]


class Preconditioner:
    """P, inverted: elastic soil, contact of one tangent, and a border of which some motions are free.

    Vectors are (n + k,): free equations, then the free motions of the border or its forces along them. size : n + k;
    rest : the soil at rest; single : whether the factors are in single precision. The next one of a room takes its
    place.
    """

    def __init__(
        self, system: FourierSystem, tangent: FourierTangent, control: Control, room: Room, precise: bool
    ) -> None:
        self.n, self.control = system.pattern.n_free, control
        self._pattern, self.rest = system.pattern, system.at_rest(tangent.time_step)
        m = self._m = len(self._pattern.interface)
        whole = room.square("contact", m + system.model.n_border)
        self._contact = contact = system.contact_matrix(tangent, whole)
        k = control.motions.shape[1]
        self.size = self.n + k
        matrix = room.square("sum", m + k)
        np.add(self.rest.matrix, contact[:m, :m], out=matrix[:m, :m])
        matrix[:m, m:] = contact[:m, m:] @ control.motions
        matrix[m:, :m] = control.forces.T @ contact[m:, :m]
        matrix[m:, m:] = control.forces.T @ contact[m:, m:] @ control.motions
        self._row, self._matrix = None, matrix
        if self.rest.uneven:
            largest = np.abs(matrix).max(axis=1)
            self._row = 1.0 / np.where(largest > 0.0, largest, 1.0)
            matrix *= self._row[:, None]
        self._factorise(not (precise or self.rest.uneven))

    def _factorise(self, single: bool) -> None:
        """Factorise what the interface and the border are left with; see `_solved` for single precision."""
        self.single = single
        if single:
            matrix = self._matrix.astype(np.float32)
            self._lu, self._pivots, wrong = lapack.sgetrf(matrix, overwrite_a=True)
            if wrong:
                self._factorise(False)
        else:
            self._lu, self._pivots, wrong = lapack.dgetrf(self._matrix, overwrite_a=True)
            if wrong:
                raise LinearSolverError("the interface is singular")

    def right_hand_side(self, free: np.ndarray, border: np.ndarray) -> np.ndarray:
        """Return the right-hand side (n + k,) of forces (n,), (nb,), less those of the imposed motions."""
        m = self._m
        imposed = self._contact[:, m:] @ self.control.imposed
        rhs = np.concatenate([free, self.control.forces.T @ (border - imposed[m:])])
        self._pattern.add_jump_forces(-imposed[:m], rhs[: self.n])
        return rhs

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Apply the inverse to rhs (n + k,)."""
        swept, interface, border = self.halfway(rhs)
        return np.concatenate([self.rest.backward(swept, interface), border])

    def halfway(self, rhs: np.ndarray) -> tuple[Any, np.ndarray, np.ndarray]:
        """Return the way of rhs (n + k,) to the interface, and the unknowns (m,) there and (k,) of the border."""
        swept, left = self.rest.forward(rhs[: self.n])
        middle = self._solved(np.concatenate([left, rhs[self.n :]]))
        return swept, middle[: self._m], middle[self._m :]

    def interface(self, load: np.ndarray) -> np.ndarray:
        """Return the unknowns (m,) of the interface under its load (m,) alone, unrefined."""
        whole = np.concatenate([load, np.zeros(self.size - self.n)])
        return self._applied(whole if self._row is None else whole * self._row)[: self._m]

    def _solved(self, load: np.ndarray) -> np.ndarray:
        """Return the unknowns (m + k,) under loads (m + k,), those of single precision refined once (Wilkinson 1963).

        Where they leave too much of the loads, single precision does not do: factorise in double precision.
        """
        if self._row is not None:
            load = load * self._row
        if not self.single:
            return self._applied(load)
        with np.errstate(over="ignore", invalid="ignore"):  # forces of an iterate that diverges
            x = self._applied(load)
            left = load - self._matrix @ x
        if np.linalg.norm(left) <= _SINGLE * np.linalg.norm(load):
            return x + self._applied(left)
        self._factorise(False)
        return self._applied(load)

    def _applied(self, load: np.ndarray) -> np.ndarray:
        solve = lapack.sgetrs if self.single else lapack.dgetrs
        x: np.ndarray = solve(self._lu, self._pivots, load)[0].astype(float, copy=False)
        return x

    def motions(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the motions (n,), (nb,) of a solution, the imposed ones included."""
        return x[: self.n], self.control.imposed + self.control.motions @ x[self.n :]

    def border_force(self, x: np.ndarray) -> np.ndarray:
        """Return the forces (nb,) on the border under a solution."""
        free, border = self.motions(x)
        m = self._m
        force: np.ndarray = self._contact[m:, :m] @ self._pattern.jump(free) + self._contact[m:, m:] @ border
        return force


@njit
def _turn(column, turns, rhs, k):
    """Make a column (k + 2,) of the Hessenberg matrix upper triangular by plane rotations, of which one is new.

    False where the column has nothing that is new.
    """
    for j in range(k):
        c, s = turns[j, 0], turns[j, 1]
        column[j], column[j + 1] = c * column[j] + s * column[j + 1], c * column[j + 1] - s * column[j]
    size = np.hypot(column[k], column[k + 1])
    if size == 0.0:
        return False
    c, s = column[k] / size, column[k + 1] / size
    turns[k, 0], turns[k, 1] = c, s
    column[k], column[k + 1] = size, 0.0
    rhs[k], rhs[k + 1] = c * rhs[k], -s * rhs[k]
    return True
