# SPDX-License-Identifier: MIT
"""Pore water of a Fourier model: its forces and volumes, and what the linear solver needs of it.

Rows of the water are volumes that leave a node over the time step, times -scale: see kernels_water. Matrices stand on
all coefficients: displacements (n, 3, K) and pressures (np, K) in a row.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from fe_engine.assembly import fourier_film
from fe_engine.assembly.fourier_film import FilmState
from fe_engine.assembly.fourier_kernels import Contact
from fe_engine.assembly.kernels_water import Step
from fe_engine.elements.biot import N_CORNERS, pore_matrices
from fe_engine.errors import ModelError
from fe_engine.fourier_model import FourierModel
from fe_engine.state import Fields

_ORTHOGONAL = 1.0e-9  # coupling of two harmonics that is rounding


class FourierWater:
    """Constant matrices of the soil's water, and its film.

    Attributes
    ----------
    coupling : (n_u, n_p) Q in m2; seepage : (n_p, n_p) in m3/(Pa s); storage : (n_p, n_p) in m3/Pa.
    exchange : (n_p, n_p) m3/(Pa s), transfer between soil and film.
    dry : (n_soil,) bool, corners of elements without water alone; corner : (ne, 4) pressures of the elements.
    pores : matrices of the elements.
    """

    def __init__(self, model: FourierModel, contact: Contact) -> None:
        assert model.water is not None
        self.model, self.water, self.contact = model, model.water, contact
        mesh, self._waves = model.mesh, len(model.numbers)
        self.film = fourier_film.pack_film(model)
        self.n_soil = len(mesh.corners)
        self._quads = mesh.quads
        self.corner = mesh.corner_numbers(mesh.quads[:, :N_CORNERS])
        self.dry = np.zeros(self.n_soil, dtype=bool)
        if self.water.wet is not None:
            self.dry[:] = True
            self.dry[self.corner[self.water.wet]] = False
        matter = self.water.mobility, self.water.storage
        parts = pore_matrices(mesh.nodes, mesh.quads, model.harmonics, *matter, model.whole)
        self.pores = parts = parts.only(self.water.wet)
        self._swelling = parts.coupling.sum(axis=-1)
        k = np.arange(self._waves)[:, None, None]
        ne = mesh.n_elements
        moves = (3 * mesh.quads[:, :, None] + np.arange(3)).reshape(ne, -1) * self._waves + k
        presses = self.corner * self._waves + k
        shape = int(np.prod(model.displacement_shape)), model.n_pressures * self._waves
        self.coupling = _assembled(parts.coupling, moves, presses, shape)
        self.seepage = _assembled(parts.seepage, presses, presses, (shape[1], shape[1]))
        self.storage = _assembled(parts.storage, presses, presses, (shape[1], shape[1]))
        self._squeezed = self.coupling.T.tocsr()
        self.exchange = self._exchange()

    def harmonic(self, matrix: csr_matrix, k: int) -> csr_matrix:
        """Return the part (np, np) of a matrix of the pressures that belongs to a harmonic."""
        return matrix[k :: self._waves, k :: self._waves].tocsr()

    def _exchange(self) -> csr_matrix:
        n, waves = self.model.n_pressures, range(self._waves)
        if self.film is None:
            return csr_matrix((n * self._waves, n * self._waves))
        whole = fourier_film.transfer_matrix(self.film, n)
        between = [whole[k :: self._waves, m :: self._waves] for k in waves for m in waves if m != k]
        if max((abs(each).max() for each in between), default=0.0) > _ORTHOGONAL * abs(whole).max():
            raise ModelError("stations of a film stand at equidistant azimuths, more of them than harmonics")
        return whole

    def step(self, time_step: float) -> Step:
        """Return a time step (s) with the scale of the pressures."""
        return Step(time_step, self.water.scale)

    def add(
        self, step: Step, old: Fields, new: Fields, gaps: tuple[np.ndarray, np.ndarray], forces: tuple
    ) -> tuple[np.ndarray, float]:
        """Add the forces of the water.

        Parameters
        ----------
        gaps : openings (ns,) of the old and the new state, m.
        forces : (n, 3, K) on the soil, (n, 3, K) across the interface on its side of it, and (nb,).

        Returns
        -------
        rows : (np, K) of the water, and the sum of squares of the volumes that have changed and that flow, m6.
        """
        force, across, border = forces
        # Biot 1941: total = effective - p: f = -Q P
        force -= (self.coupling @ new.pressure.ravel()).reshape(force.shape)
        rows = -step.scale * self.leaving(step, old, new)
        square = self._squares(step, new)
        if self.film is not None:
            pressure = new.pressure
            square += fourier_film.station_water(self.contact, self.film, step, gaps, pressure, across, border, rows)
            square += fourier_film.line_water(self.film, step, gaps[1], pressure, rows)
        return rows, square

    def leaving(self, step: Step, old: Fields, new: Fields) -> np.ndarray:
        """Return the volumes (np, K) in m3 that leave the soil at each pressure, without the film."""
        move, change = (new.displacement - old.displacement).ravel(), (new.pressure - old.pressure).ravel()
        # Q^T du + S M dP + dt H P, backward Euler
        volumes = self._squeezed @ move + self.storage @ change + step.time * (self.seepage @ new.pressure.ravel())
        return volumes.reshape(new.pressure.shape)

    def _squares(self, step: Step, state: Fields) -> float:
        """Return sum of squares of the changes of the elements' volumes and of what flows through their corners, m6."""
        move = state.displacement[self._quads].transpose(3, 0, 1, 2).reshape(self._swelling.shape)
        pressure = state.pressure[self.corner].transpose(2, 0, 1)
        flow = step.time * np.matmul(self.pores.seepage, pressure[..., None])
        return float(np.sum(np.sum(self._swelling * move, axis=-1) ** 2) + np.sum(flow**2))

    def film_matrix(self, state: FilmState, place: np.ndarray, film_place: np.ndarray, out: np.ndarray) -> None:
        """Add the film's part of a tangent; see fourier_film.film_matrix."""
        if self.film is not None:
            fourier_film.film_matrix(self.contact, self.film, state, place, film_place, out)

    def film_pressure(self, pressure: np.ndarray) -> np.ndarray:
        """Return the pressure (ns,) of the film at every station from coefficients (np, K), Pa; 0 without a film."""
        if self.film is None:
            return np.zeros(len(self.contact.area))
        pressures: np.ndarray = np.einsum("sak,sak->s", self.film.share, pressure[self.film.film])
        return pressures

    def work(self, old: Fields, new: Fields, opened: np.ndarray) -> float:
        """Return work (J) against the pore pressures by soil and gaps, for changes ``opened`` (ns,) of the jumps."""
        pressure = 0.5 * (old.pressure + new.pressure)
        move = (new.displacement - old.displacement).ravel()
        soil = -float(pressure.ravel() @ (self._squeezed @ move))  # -int p dtheta dV
        return soil - float(np.sum(self.film_area * self.film_pressure(pressure) * opened))

    @property
    def film_area(self) -> np.ndarray:
        """Areas (ns,) of the film at the stations, m2."""
        return np.zeros(len(self.contact.area)) if self.film is None else self.film.station_area


def _assembled(blocks: np.ndarray, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> csr_matrix:
    """Return the sum of blocks (K, ne, a, b) at rows (K, ne, a) and columns (K, ne, b)."""
    row, column, value = np.broadcast_arrays(rows[..., None], columns[..., None, :], blocks)
    return coo_matrix((value.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsr()
