# SPDX-License-Identifier: MIT
"""The linear system of a Fourier model with the soil at rest, everything eliminated but the interface.

Drained, `SoilAtRest` has the factors of every harmonic. With water these are factors, made anew for each time step, of

    [ K   -Q                  ] [u]
    [-Q^T -(S + dt (H + T))   ] [p]      T : transfer of the interface, the same whether it is open or closed

where the displacements of the interface and the pressures of the film stay.

Linear elements may stand between the stations of the interface and the border (`BesideLinear`). The stations join
soil and linear elements by their jumps j alone. With A what the soil at rest leaves to its side of the interface, C the
compliance of the linear elements there, f_s and f_t the forces on both, and q those of the stations,

    A u_s + q = f_s,   u_t = C (f_t + q),   j = u_s - u_t   =>   A N j + q = f_s - A N d,
    N = (1 + C A)^-1,   d = C (f_s + f_t),   u_s = N (j + d),

so that the interface has as many unknowns as beside a rigid body, harmonic by harmonic. Linear elements are few: C is
dense.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from fe_engine.assembly.fourier_pattern import FourierPattern, held_pressures, hold
from fe_engine.assembly.fourier_water import FourierWater
from fe_engine.assembly.harmonic_factors import HarmonicFactors, Part, order_of
from fe_engine.errors import LinearSolverError
from fe_engine.fourier_model import FourierModel
from fe_engine.state import Fields

_GIVES_WAY = 1.0e-3  # S times the modulus of the soil, from which on pivots of the water have a size in any order


class AtRest(Protocol):
    """The soil at rest, eliminated up to the equations of the interface (m,).

    Attributes
    ----------
    factors : of the soil; matrix : (m, m) what the elimination leaves to the interface.
    uneven : whether rows of the interface differ in size by so much that they have to be scaled.
    """

    factors: HarmonicFactors
    matrix: np.ndarray
    uneven: bool

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """Eliminate rhs (n_free,): return what `backward` needs, and what is left (m,) for the interface."""

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """Return the unknowns (n_free,), those of the interface (m,) being known; uses up ``swept``."""

    def of_soil(self, swept: Any) -> tuple[list[np.ndarray], Any]:
        """Return what the factors have swept, and what `follow` needs, of what `forward` has returned."""

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """Return what `follow` needs, and the load (m,) of the interface, of what the factors leave (nk, 3, K)."""

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """Return the unknowns (nk, 3, K) of the soil's retained nodes, those of the interface (m,) being known."""


class SoilAtRest:
    """Soil alone beside the interface: see `AtRest`.

    factors : of n nodes of displacements, and of pressures as nodes with one row each.
    inside : (nk, 3, K) where unknowns of retained nodes stand in the interface, or -1.
    """

    def __init__(self, factors: HarmonicFactors, inside: np.ndarray, n: int) -> None:
        self.factors, self.inside, self.n = factors, inside, n
        self.uneven = factors.n_nodes > n
        self._free = inside >= 0
        size = int(np.count_nonzero(self._free))
        self.matrix = np.zeros((size, size), order="F")
        for m in range(factors.n_waves):
            at, half = inside[..., m].ravel(), len(factors.schur)
            block = factors.schur[m if m < half else m - half + 1]
            free = at >= 0
            self.matrix[np.ix_(at[free], at[free])] = block[np.ix_(free, free)]

    def forward(self, rhs: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        whole = np.zeros((self.factors.n_nodes, 3, self.factors.n_waves))
        move = whole[: self.n]
        move[...] = rhs[: move.size].reshape(move.shape)
        whole[self.n :, 0] = rhs[move.size :].reshape(-1, self.factors.n_waves)
        swept, left = self.factors.forward(whole)
        return swept, left[self._free]

    def backward(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        whole = self.factors.backward(swept, self.follow(None, interface))
        return np.concatenate([whole[: self.n].ravel(), whole[self.n :, 0].ravel()])

    def of_soil(self, swept: Any) -> tuple[list[np.ndarray], Any]:
        """See `AtRest`."""
        return swept, None

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        return None, left[self._free]

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        whole = np.zeros(self.inside.shape)
        whole[self._free] = interface
        return whole


class DrySoil:
    """Soil without water: stiffness (N + 1, ne, 24, 24) of the elements, and the pattern of its nodes."""

    def __init__(self, model: FourierModel, pattern: FourierPattern, stiffness: np.ndarray) -> None:
        order = order_of([model.mesh.quads], pattern.retained, np.zeros(model.n_soil, dtype=bool))
        factors = HarmonicFactors(order, [(model.mesh.quads, stiffness)], pattern.held)
        self._rest = SoilAtRest(factors, pattern.place[pattern.retained], model.n_soil)

    def at_rest(self, _time_step: float, _sealed: bool) -> SoilAtRest:
        """Return the soil at rest, the same at all times."""
        return self._rest


class WetSoil:
    """Soil with water: as `DrySoil`; pressures have numbers behind the nodes of the soil.

    modulus : the least K + 4 G/3, Pa.
    """

    def __init__(
        self, model: FourierModel, pattern: FourierPattern, stiffness: np.ndarray, water: FourierWater, modulus: float
    ) -> None:
        self._pattern, self._stiffness, self._water, self.n = pattern, stiffness, water, model.n_soil
        mesh, film, n = model.mesh, np.arange(water.n_soil, model.n_pressures), model.n_soil
        self._on_axis = mesh.on_axis[mesh.corners]
        self._coupled = np.hstack([mesh.quads, n + water.corner])
        self._axis = np.hstack([pattern.axis[mesh.quads], np.zeros(water.corner.shape, dtype=bool)])
        pairs = coo_matrix(water.harmonic(water.exchange, 0))
        between = np.stack([pairs.row, pairs.col], axis=1)[pairs.row < pairs.col]
        self._transfer = _transfer(water, between, len(stiffness), n)
        inside = np.full((len(film), 3, pattern.held.shape[2]), -1)
        inside[:, 0] = pattern.film_place[film]
        self._inside = np.concatenate([pattern.place[pattern.retained], inside])
        retained = np.concatenate([pattern.retained, n + film])
        pressures = np.arange(n + model.n_pressures) >= n
        pressures[retained] = False
        stiff = water.water.storage * modulus < _GIVES_WAY
        # the retained share rows, whether or not water goes through the interface
        self._order = order_of([self._coupled, n + between, retained[None]], retained, pressures, stiff)

    def at_rest(self, time_step: float, sealed: bool) -> SoilAtRest:
        """Return the soil at a time step (s); where it is ``sealed``, fixed pressures of the soil are free.

        Raises LinearSolverError.
        """
        held = self._held(sealed)
        return SoilAtRest(HarmonicFactors(self._order, self._parts(time_step, held), held), self._inside, self.n)

    def _held(self, sealed: bool) -> np.ndarray:
        """Return whether each unknown (n + np, 3, K) is held; rows of the pressures but the first are."""
        still = self._pattern.pressure_held.copy()
        if sealed:  # where nothing is held but in dry soil, and what has to vanish on the axis
            still[: self._water.n_soil] = held_pressures(self._water.dry, self._on_axis, still.shape[1])
        pressures = np.ones((len(still), 3, still.shape[1]), dtype=bool)
        pressures[:, 0] = still
        return np.concatenate([self._pattern.held, pressures])

    def _parts(self, time_step: float, held: np.ndarray) -> list[Part]:
        """Return the parts of the matrix: K, -Q and -(S + dt (H + T)), pressures in their scale."""
        water, stiffness = self._water, self._stiffness
        waves, scale, square = len(stiffness), water.water.scale, water.water.scale**2
        soil = np.zeros((waves, len(self._coupled), 36, 36))
        soil[:, :, :24, :24] = stiffness
        soil[:, :, :24, 24::3] = -scale * water.pores.coupling[:waves]
        soil[:, :, 24::3, :24] = soil[:, :, :24, 24::3].transpose(0, 1, 3, 2)
        soil[:, :, 24::3, 24::3] = -square * (water.pores.storage[:waves] + time_step * water.pores.seepage[:waves])
        parts = [(self._coupled, soil), *((at, -square * time_step * each) for at, each in self._transfer)]
        for elements, matrices in parts:
            axis = self._axis if elements is self._coupled else np.zeros(elements.shape, dtype=bool)
            hold(matrices, held[elements], axis)
        return parts


def _transfer(water: FourierWater, pairs: np.ndarray, waves: int, n: int) -> list[Part]:
    """Return the parts of T: what two pressures (m, 2) have in common, and each alone, numbered behind n nodes."""
    if not len(pairs):
        return []
    alone = np.arange(pairs.max() + 1)[:, None]
    between, own = np.zeros((waves, len(pairs), 6, 6)), np.zeros((waves, len(alone), 3, 3))
    for k in range(waves):
        transfer = water.harmonic(water.exchange, k)
        between[k, :, 0, 3] = between[k, :, 3, 0] = transfer[tuple(pairs.T)]
        own[k, :, 0, 0] = transfer.diagonal()[: len(alone)]
    return [(n + pairs, between), (n + alone, own)]


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
        self.factors, self.uneven = soil.factors, soil.uneven
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

    def of_soil(self, swept: Any) -> tuple[list[np.ndarray], Any]:
        """See `AtRest`."""
        return self.soil.of_soil(swept[0])[0], swept[1:]

    def lead(self, left: np.ndarray) -> tuple[Any, np.ndarray]:
        """See `AtRest`."""
        return self._loaded(np.zeros(self._n_moving - self.linear.first), self.soil.lead(left)[1])

    def follow(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        """See `AtRest`."""
        return self.soil.follow(None, self._reduced @ (interface + kept[1]))

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
