# SPDX-License-Identifier: MIT
"""The linear system of a Fourier model with the soil at rest, everything eliminated but the interface.

Drained, `SoilAtRest` has the factors of every harmonic. With water, `WetAtRest` solves, harmonic by harmonic,

    [ K   -Q                  ] [u]
    [-Q^T -(S + dt (H + T))   ] [p]      T : transfer of the interface, the same whether it is open or closed

without ever factorising that matrix: the factors of K serve all time steps. With the displacements I of the interface
held, G = Q^T K^-1 Q is made once (dense, the pressures of one harmonic), and a time step costs a Cholesky
factorisation of W = S + dt (H + T) + G. What is left are I and the pressures of the film.

Linear elements may stand between the stations of the interface and the border (`BesideLinear`). The stations join
soil and linear elements by their jumps j alone. With A what the soil at rest leaves to its side of the interface, C the
compliance of the linear elements there, f_s and f_t the forces on both, and q those of the stations,

    A u_s + q = f_s,   u_t = C (f_t + q),   j = u_s - u_t   =>   A N j + q = f_s - A N d,
    N = (1 + C A)^-1,   d = C (f_s + f_t),   u_s = N (j + d),

so that the interface has as many unknowns as beside a rigid body, harmonic by harmonic. Linear elements are few: C is
dense.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import coo_matrix, csr_matrix

from fe_engine.assembly.fourier_pattern import FourierPattern, held_pressures
from fe_engine.assembly.fourier_water import FourierWater
from fe_engine.assembly.harmonic_factors import HarmonicFactors
from fe_engine.errors import LinearSolverError
from fe_engine.fourier_model import FourierModel
from fe_engine.state import Fields


class AtRest(Protocol):
    """The soil at rest, eliminated up to the equations of the interface (m,).

    Attributes
    ----------
    matrix : (m, m) what the elimination leaves to the interface.
    uneven : whether rows of the interface differ in size by so much that they have to be scaled.
    local : where the factors of the soil may be gone through apart, for few nodes; None with water, which joins all.
    """

    matrix: np.ndarray
    uneven: bool
    local: Local | None

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """Eliminate rhs (n_free,): return what `backward` needs, and what is left (m,) for the interface."""

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """Return the unknowns (n_free,), those of the interface (m,) being known; uses up ``swept``."""


class Local(Protocol):
    """What stands between both ways through the factors of the soil."""

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """Return what `follow` needs, and the load (m,) of the interface, of what the factors leave (nk, 3, K)."""

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """Return the motions (nk, 3, K) of the soil's retained nodes, the unknowns of the interface (m,) known."""


class SoilAtRest:
    """Drained: see `AtRest`."""

    uneven = False

    def __init__(self, factors: HarmonicFactors, pattern: FourierPattern) -> None:
        self.local: Local | None = self
        self.factors, self.shape = factors, pattern.held.shape
        self.inside = pattern.place[pattern.retained]
        self._free = self.inside >= 0
        size = int(np.count_nonzero(self._free))
        self.matrix = np.zeros((size, size))
        for m in range(self.shape[2]):
            at, n = self.inside[..., m].ravel(), len(factors.schur)
            block = factors.schur[m if m < n else m - n + 1]
            free = at >= 0
            self.matrix[np.ix_(at[free], at[free])] = block[np.ix_(free, free)]

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        swept, left = self.factors.forward(rhs.reshape(self.shape))
        return swept, left[self._free]

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        return self.factors.backward(swept, self.follow(None, interface)).ravel()

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `Local`."""
        return None, left[self._free]

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """See `Local`."""
        whole = np.zeros(self.inside.shape)
        whole[self._free] = interface
        return whole


@dataclass(frozen=True)
class _Harmonic:
    """One harmonic at one time step: J (np, 3 nk + nf), W^-1 J, and the lower factor of W."""

    joint: np.ndarray
    solved: np.ndarray
    lower: np.ndarray

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Return W^-1 rhs for rhs (np,); LAPACK itself, since a wrapper costs as much as the solve."""
        x: np.ndarray = lapack.dpotrs(self.lower, rhs, lower=True)[0]
        return x


class WetSoil:
    """What all time steps share: Q, G, and Q with the soil inside eliminated."""

    def __init__(self, rest: SoilAtRest, water: FourierWater, pattern: FourierPattern) -> None:
        mesh = water.model.mesh
        on_axis = mesh.on_axis[mesh.corners]
        self.rest, self.water = rest, water
        self.scale = water.water.scale
        self.n_soil, self.waves = water.n_soil, pattern.held.shape[2]
        self.free = ~pattern.pressure_held
        self.sealed = self.free.copy()  # where nothing is held but in dry soil, and what has to vanish on the axis
        self.sealed[: self.n_soil] = ~held_pressures(water.dry, on_axis, self.waves)
        self.film_place = pattern.film_place[self.n_soil :]
        self.size = len(pattern.interface)
        coupling = folding(pattern) @ water.coupling[: pattern.n_moving, : self.n_soil * self.waves]
        # Q on free displacements
        self.coupling = (self.scale * coupling @ _diagonal(self.sealed[: self.n_soil].ravel())).tocsr()
        self.squeezed = self.coupling.T.tocsr()
        self.left, self.compliance = self._eliminate()
        flow, waves = water.seepage + water.exchange, range(self.waves)
        self.storage, self.flow = ([water.harmonic(each, k) for k in waves] for each in (water.storage, flow))

    def _eliminate(self) -> tuple[np.ndarray, np.ndarray]:
        """Return Q left to the interface (K, np, 3 nk), and G (K, np, np)."""
        factors, shape, n = self.rest.factors, self.rest.shape, self.n_soil
        none = np.zeros((len(factors.retained), *shape[1:]))
        left = np.empty((self.waves, n, 3 * len(factors.retained)))
        compliance = np.empty((self.waves, n, n))
        for j in range(n):
            unit = np.zeros((n, self.waves))
            unit[j] = 1.0
            swept, interface = factors.forward((self.coupling @ unit.ravel()).reshape(shape))
            inner = factors.backward(swept, none)
            left[:, j] = interface.reshape(-1, self.waves).T  # Q_I - K_Ii K_ii^-1 Q_i, a row a pressure
            compliance[:, :, j] = (self.squeezed @ inner.ravel()).reshape(n, self.waves).T  # G = Q^T K^-1 Q
        return left, 0.5 * (compliance + compliance.transpose(0, 2, 1))

    def harmonic(self, k: int, time_step: float, sealed: bool) -> _Harmonic:
        """Factorise W of a harmonic and eliminate its pressures; see `WetAtRest`."""
        n, square = self.n_soil, self.scale**2
        free = (self.sealed if sealed else self.free)[:, k]
        whole = (square * (self.storage[k] + time_step * self.flow[k])).toarray()  # S + dt (H + T)
        matrix = (whole[:n, :n] + self.compliance[k]) * np.outer(free[:n], free[:n])  # W = S + dt (H + T) + G
        matrix[np.diag_indices(n)] += ~free[:n]
        joint = np.hstack([self.left[k] * free[:n, None], whole[:n, n:] * np.outer(free[:n], free[n:])])
        lower, wrong = lapack.dpotrf(np.asfortranarray(matrix), lower=True, overwrite_a=True)
        if wrong:
            raise LinearSolverError("the pressures of a harmonic are not held by the soil")
        return _Harmonic(joint, lapack.dpotrs(lower, joint, lower=True)[0], lower)


class WetAtRest:
    """With water, at one time step (s): see `AtRest`. Where it is ``sealed``, fixed pressures of the soil are free.

    Raises LinearSolverError.
    """

    uneven = True
    local: Local | None = None

    def __init__(self, soil: WetSoil, time_step: float, sealed: bool = False) -> None:
        self.soil, self._rest = soil, soil.rest
        self._free = soil.sealed[: soil.n_soil] if sealed else soil.free[: soil.n_soil]
        self._harmonics = [soil.harmonic(k, time_step, sealed) for k in range(soil.waves)]
        self.matrix = np.zeros((soil.size, soil.size))
        m = len(self._rest.matrix)
        self.matrix[:m, :m] = self._rest.matrix
        self._places, inside, n = [], self._rest.inside, soil.n_soil
        for k, each in enumerate(self._harmonics):
            at = np.concatenate([inside[..., k].ravel(), soil.film_place[:, k]])
            block = each.joint.T @ each.solved  # J^T W^-1 J
            film = slice(inside[..., k].size, None)
            block[film, film] -= soil.scale**2 * time_step * soil.flow[k][n:, n:].toarray()
            free = at >= 0
            self.matrix[np.ix_(at[free], at[free])] += block[np.ix_(free, free)]
            self._places.append((at[free], free))

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        soil, factors, shape = self.soil, self._rest.factors, self._rest.shape
        n_u, n_p = int(np.prod(shape)), soil.n_soil * soil.waves
        swept, left = factors.forward(rhs[:n_u].reshape(shape))
        inner = factors.backward(swept, np.zeros(left.shape))  # K^-1 f with I held
        squeezed = (rhs[n_u : n_u + n_p] + soil.squeezed @ inner.ravel()).reshape(-1, soil.waves)
        squeezed *= self._free
        film = rhs[n_u + n_p :].reshape(-1, soil.waves)
        interface, pressure = np.empty(soil.size), np.empty(squeezed.shape)
        for k, (each, (at, free)) in enumerate(zip(self._harmonics, self._places, strict=True)):
            pressure[:, k] = each.solve(squeezed[:, k])  # W^-1 (q + Q^T K^-1 f) = -p with I at rest
            whole = np.concatenate([left[..., k].ravel(), film[:, k]]) - pressure[:, k] @ each.joint
            interface[at] = whole[free]
        return (inner, pressure), interface

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        soil, rest = self.soil, self._rest
        inner, pressure = swept
        inside = np.zeros(rest.inside.shape)
        film = np.zeros((len(soil.film_place), soil.waves))
        for k, (each, (at, free)) in enumerate(zip(self._harmonics, self._places, strict=True)):
            whole = np.zeros(len(free))
            whole[free] = interface[at]
            pressure[:, k] = -pressure[:, k] - each.solved @ whole  # p of the motion of I and of the film
            inside[..., k], film[:, k] = whole[: inside[..., k].size].reshape(-1, 3), whole[inside[..., k].size :]
        again, _ = rest.factors.forward((soil.coupling @ pressure.ravel()).reshape(rest.shape))  # u = K^-1 (f + Q p)
        move = inner + rest.factors.backward(again, inside)
        return np.concatenate([move.ravel(), pressure.ravel(), film.ravel()])


class LinearElements:
    """Stiffness and compliance of the linear elements.

    Attributes
    ----------
    stiffness : (n_moving, n_moving) on all coefficients, N/m.
    first : equation of their first node; those of displacements behind it are theirs.
    """

    def __init__(self, model: FourierModel, pattern: FourierPattern) -> None:
        assert model.linear is not None
        waves, quads, size = len(model.numbers), model.linear.quads, pattern.n_moving
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
    """Soil at rest beside linear elements: see `AtRest`; unknowns of the interface are jumps."""

    def __init__(self, soil: AtRest, linear: LinearElements, pattern: FourierPattern) -> None:
        self.soil, self.linear = soil, linear
        self.uneven, self._local = soil.uneven, soil.local
        self.local: Local | None = self if soil.local else None
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

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        first, n = self.linear.first, self._n_moving
        swept, left = self.soil.forward(np.concatenate([rhs[:first], rhs[n:]]))
        kept, load = self._loaded(rhs[first:n].copy(), left)
        return (swept, *kept), load

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        of_soil, force, shift = swept
        first = self.linear.first
        moved = self._reduced @ (interface + shift)  # u_s = N (j + d)
        force[self._beyond] -= (self.soil.matrix @ moved)[self._joined]  # q + f_t = f_s + f_t - A u_s
        soil = self.soil.backward(of_soil, moved)
        return np.concatenate([soil[:first], self.linear.move(force), soil[first:]])

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `Local`."""
        assert self._local is not None
        return self._loaded(np.zeros(self._n_moving - self.linear.first), self._local.lead(left)[1])

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """See `Local`."""
        assert self._local is not None
        return self._local.follow(None, self._reduced @ (interface + kept[1]))

    def _loaded(self, force: np.ndarray, left: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
        """Return f_s + f_t and d for forces f_t on the linear elements, and the load of the interface; in place."""
        force[self._beyond] += left[self._joined]
        shift = np.zeros(len(left))
        shift[self._joined] = self.linear.move(force)[self._beyond]  # d = C (f_s + f_t)
        return (force, shift), left - self.matrix @ shift  # f_s - A N d


def _diagonal(values: np.ndarray) -> csr_matrix:
    n = np.arange(len(values))
    return coo_matrix((values.astype(float), (n, n))).tocsr()


def folding(pattern: FourierPattern) -> csr_matrix:
    """Return the matrix of `FourierPattern.folded`: forces on all coefficients to those that are free."""
    equation = np.arange(pattern.held.size).reshape(pattern.held.shape)
    r, t = (equation[pattern.axis, i][:, pattern.ones].ravel() for i in (0, 1))
    n = equation.ravel()
    row, column = np.concatenate([n, r]), np.concatenate([n, t])
    value = np.concatenate([np.ones(len(n)), -np.ones(len(r))])
    whole = coo_matrix((value, (row, column)), shape=(len(n), len(n))).tocsr()
    return _diagonal(~pattern.held.ravel()) @ whole
