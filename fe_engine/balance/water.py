# SPDX-License-Identifier: MIT
"""Balance of the water of a model, every term on its own.

    expelled = compressed + in the film + flown out

expelled is the pore volume that the wet soil has lost, from the displacements of its boundary alone (divergence
theorem); compressed is S int p dV; the film holds sum of area times gap. What flows out is the Darcy flow into the
nodes of the drained boundary, added up over the steps, and what the cells of these nodes themselves have given off.
Nothing is read from a residual, so that the imbalance shows what Newton has left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fe_engine.assembly import kernels_water
from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.scatter import NOWHERE, Forces, Scatter
from fe_engine.assembly.system import System
from fe_engine.elements import fourier, interface
from fe_engine.mesh import FACES
from fe_engine.state import Fields


@dataclass(frozen=True)
class Balance:
    """Volumes of water in m3 since the initial state; ``moved`` is all that has flowed between nodes."""

    expelled: float
    compressed: float
    film: float
    outflow: float
    moved: float

    @property
    def imbalance(self) -> float:
        """What is missing, m3."""
        return self.expelled - self.compressed - self.film - self.outflow


class _Volumes(Protocol):
    """Volumes of a discretisation.

    Attributes
    ----------
    area_vectors : integrals of N_a n dA over the boundary of the soil, in the shape of the displacement, m2; nothing in
        coefficients that change no volume.
    """

    area_vectors: np.ndarray

    def compressed(self, change: np.ndarray) -> float:
        """Return the volume in m3 that a change of the pressures compresses."""

    def leaving(self, old: Fields, new: Fields, time_step: float) -> np.ndarray:
        """Return the volumes in m3 that leave each node between two states: by change of volume, and by flow."""

    def fixed(self, leaving: np.ndarray) -> float:
        """Return the sum of what leaves the nodes whose pressure is fixed."""

    def moved(self, leaving: np.ndarray) -> float:
        """Return the volume that has moved between nodes."""


class WaterBalance:
    """Follows the water of a run from its initial state."""

    def __init__(self, system: System | FourierSystem, initial: Fields) -> None:
        self.system, self.initial = system, initial
        self._volumes: _Volumes = _Bricks(system) if isinstance(system, System) else _Series(system)
        self.area_vectors = self._volumes.area_vectors
        self._flown_out, self._moved = 0.0, 0.0

    @property
    def totals(self) -> tuple[float, float]:
        """What has been added up over the steps, m3: flown out, moved; set to go on from a saved state."""
        return self._flown_out, self._moved

    @totals.setter
    def totals(self, volumes: tuple[float, float]) -> None:
        self._flown_out, self._moved = volumes

    def advance(self, now: Fields, time_step: float) -> None:
        """Add the flow of a step that ended in this state."""
        flow = self._volumes.leaving(now, now, time_step)
        self._flown_out -= self._volumes.fixed(flow)
        self._moved += self._volumes.moved(flow)

    def now(self, state: Fields) -> Balance:
        """Return the balance at a state that has been advanced to."""
        initial, system = self.initial, self.system
        own = self._volumes.fixed(self._volumes.leaving(initial, state, 0.0))
        expelled = -float(np.sum(self.area_vectors * (state.displacement - initial.displacement)))  # -int u.n dA
        compressed = self._volumes.compressed(state.pressure - initial.pressure)
        film = float(np.sum(system.film_area * (system.gaps(state) - system.gaps(initial))))  # A g_N
        return Balance(expelled, compressed, film, self._flown_out - own, self._moved)


class _Bricks:
    """See `_Volumes`; nodes (n + nf,)."""

    def __init__(self, system: System) -> None:
        assert system.model.water is not None
        self.system, self.water = system, system.model.water
        self.area_vectors = _boundary_area_vectors(system)
        n = system.pattern.n_nodes
        equation = np.full((n, 4), -1, dtype=np.int64)
        equation[:, 3] = np.arange(n)
        self._scatter = Scatter(equation, np.ones((n, 4)), system.pattern.rank, system.pattern.indptr)

    def compressed(self, change: np.ndarray) -> float:
        n = self.system.model.mesh.n_nodes
        return float(np.einsum("eab,eb->", self.system.pores.compression, change[:n][self.system.hexes]))

    def fixed(self, leaving: np.ndarray) -> float:
        return float(leaving[self.water.fixed].sum())

    def moved(self, leaving: np.ndarray) -> float:
        return 0.5 * float(np.abs(leaving).sum())

    def leaving(self, old: Fields, new: Fields, time_step: float) -> np.ndarray:
        s, step = self.system, kernels_water.Step(time_step, -1.0)
        out = Forces(np.zeros(self.system.pattern.n_nodes), np.zeros(0))
        fields = (old.displacement, old.pressure), (new.displacement, new.pressure)
        kernels_water.soil_water(s.hexes, s.pores.arrays, step, *fields, self._scatter, out)
        if s.film is not None:
            gaps = s.gaps(old), s.gaps(new)
            kernels_water.station_water(s.stations, s.film, step, gaps, new.pressure, self._scatter, out, NOWHERE)
            kernels_water.face_water(s.stations, s.film, step, gaps[1], new.pressure, self._scatter, out, NOWHERE)
        return out.free


class _Series:
    """See `_Volumes`; coefficients (np, K) of volumes of a revolution, or half: those of k = 0 are the whole of it."""

    def __init__(self, system: FourierSystem) -> None:
        assert system.water is not None
        self.system, self.wet = system, system.water
        model = system.model
        self.area_vectors = np.zeros(model.displacement_shape)
        vectors = section_area_vectors(model.mesh.nodes, model.mesh.quads[_wet(self.wet.water.wet)])
        self.area_vectors[:, 0, 0], self.area_vectors[:, 2, 0] = fourier.span(model.whole) * vectors.T
        k, m = model.numbers, 2 * len(model.numbers)
        wave = fourier.waves(fourier.azimuths(m, model.whole), model.harmonics, model.whole)[..., 0]
        self._around = wave * np.where(k == 0, 1.0, 2.0) / m  # volumes of m sectors from those of harmonics

    def compressed(self, change: np.ndarray) -> float:
        return float((self.wet.storage @ change.ravel())[:: change.shape[1]].sum())

    def fixed(self, leaving: np.ndarray) -> float:
        return float(leaving[self.wet.water.fixed, 0].sum())

    def moved(self, leaving: np.ndarray) -> float:
        return 0.5 * float(np.abs(leaving @ self._around.T).sum())

    def leaving(self, old: Fields, new: Fields, time_step: float) -> np.ndarray:
        system, step = self.system, kernels_water.Step(time_step, -1.0)
        forces = *np.zeros((2, *system.model.displacement_shape)), np.zeros(system.model.n_border)
        rows, _ = self.wet.add(step, old, new, (system.gaps(old), system.gaps(new)), forces)
        return rows


def section_area_vectors(nodes: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return integrals (n, 2) of N_a n r ds over the edges of a section, per radian: exact for straight edges."""
    edge = np.array([[0, 1, 4], [1, 2, 5], [2, 3, 6], [3, 0, 7]])
    lines = quads[:, edge].reshape(-1, 3)
    _, first, count = np.unique(lines[:, 2], return_index=True, return_counts=True)  # by its middle node
    inner = quads[:, [2, 3, 0, 1]].reshape(-1)  # a corner opposite of each
    vectors = np.zeros((len(nodes), 2))
    for (a, b, c), other in zip(lines[first[count == 1]], inner[first[count == 1]], strict=True):
        along = nodes[b] - nodes[a]
        normal = np.array([along[1], -along[0]])
        normal *= np.sign(normal @ (nodes[a] - nodes[other]))
        start, step = nodes[a, 0], nodes[b, 0] - nodes[a, 0]
        vectors[a] += start / 6.0 * normal  # int N r ds, Simpson's rule: exact for N r of third order
        vectors[c] += (2.0 * start / 3.0 + step / 3.0) * normal
        vectors[b] += (start / 6.0 + step / 6.0) * normal
    return vectors


def _wet(wet: np.ndarray | None) -> np.ndarray | slice:
    """Return the index of the elements that hold water."""
    return slice(None) if wet is None else wet


def _boundary_area_vectors(system: System) -> np.ndarray:
    """Return integrals (n, 3) of N_a n dA over the boundary of wet soil, in nodal axes; exact for bilinear faces."""
    mesh, water = system.model.mesh, system.model.water
    assert water is not None
    faces = mesh.hexes[_wet(water.wet)][:, FACES].reshape(-1, 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    vectors = interface.nodal_area_vectors(mesh.nodes, faces[first[count == 1]])
    for node, axes in system.model.frames.items():
        vectors[node] = axes @ vectors[node]
    return vectors
