# SPDX-License-Identifier: MIT
"""Balance of the water of a model, every term on its own.

    expelled = compressed + in the film + flown out

expelled is the pore volume that the soil has lost, from the displacements of its boundary alone (divergence theorem);
compressed is S int p dV; the film holds sum of area times gap. What flows out is the Darcy flow into the nodes of the
drained boundary, added up over the steps, and what the cells of these nodes themselves have given off. Nothing is read
from a residual, so that the imbalance shows what Newton has left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.assembly import kernels_water
from fe_engine.assembly.scatter import NOWHERE, Forces, Scatter
from fe_engine.assembly.system import System
from fe_engine.elements import interface
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


class WaterBalance:
    """Follows the water of a run from its initial state."""

    def __init__(self, system: System, initial: Fields) -> None:
        assert system.model.water is not None
        self.system, self.water = system, system.model.water
        self.initial = initial
        self.area_vectors = _boundary_area_vectors(system)
        n = system.pattern.n_nodes
        equation = np.full((n, 4), -1, dtype=np.int64)
        equation[:, 3] = np.arange(n)
        self._scatter = Scatter(equation, np.ones((n, 4)), system.pattern.rank, system.pattern.indptr)
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
        flow = self._leaving(now, now, time_step)
        self._flown_out -= float(flow[self.water.fixed].sum())
        self._moved += 0.5 * float(np.abs(flow).sum())

    def now(self, state: Fields) -> Balance:
        """Return the balance at a state that has been advanced to."""
        own = float(self._leaving(self.initial, state, 0.0)[self.water.fixed].sum())
        n = self.system.model.mesh.n_nodes
        expelled = -float(np.sum(self.area_vectors * (state.displacement - self.initial.displacement)))
        change = (state.pressure - self.initial.pressure)[:n][self.system.hexes]
        compressed = float(np.einsum("eab,eb->", self.system.pores.compression, change))
        film = 0.0
        if self.system.film is not None:
            opened = self._gap(state) - self._gap(self.initial)
            film = float(np.sum(self.system.stations.area * opened))
        return Balance(expelled, compressed, film, self._flown_out - own, self._moved)

    def _gap(self, state: Fields) -> np.ndarray:
        return self.system.gaps(state)

    def _leaving(self, old: Fields, new: Fields, time_step: float) -> np.ndarray:
        """Return volume (n + nf,) in m3 that leaves each node between two states: by change of volume, and by flow."""
        s, step = self.system, kernels_water.Step(time_step, -1.0)
        out = Forces(np.zeros(self.system.pattern.n_nodes), np.zeros(0))
        fields = (old.displacement, old.pressure), (new.displacement, new.pressure)
        kernels_water.soil_water(s.hexes, s.pores.arrays, step, *fields, self._scatter, out)
        if s.film is not None:
            gaps = self._gap(old), self._gap(new)
            kernels_water.station_water(s.stations, s.film, step, gaps, new.pressure, self._scatter, out, NOWHERE)
            kernels_water.face_water(s.stations, s.film, step, gaps[1], new.pressure, self._scatter, out, NOWHERE)
        return out.free


def _boundary_area_vectors(system: System) -> np.ndarray:
    """Return integrals (n, 3) of N_a n dA over the soil boundary, in nodal axes; exact for bilinear faces."""
    mesh = system.model.mesh
    faces = mesh.hexes[:, FACES].reshape(-1, 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    vectors = interface.nodal_area_vectors(mesh.nodes, faces[first[count == 1]])
    for node, axes in system.model.frames.items():
        vectors[node] = axes @ vectors[node]
    return vectors
