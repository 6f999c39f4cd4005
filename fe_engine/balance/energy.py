# SPDX-License-Identifier: MIT
"""Balance of energy of a model, every term from its own quantities.

    work + initial = elastic + plastic + penalty + friction + water

work is that of the loads' changes on the border dofs, initial that of the initial state (weight, surcharge and the
loads that hold the initial stress), both over the motion since the start. elastic is stored in the soil and in linear
elements, plastic is dissipated in the soil; penalty is stored in the contact springs, friction is dissipated on them,
and water is what the soil has done against pore pressures. With the means s of old and new stress over a step,
s:de = d(s:C^-1:s/2) + s:de_p holds without error, so that the imbalance is what Newton has left, and nothing else.
Plastic and friction grow, but for what a station seems to give back that opens within a step, where the mean of both
ends is not the traction on the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba as nb
import numpy as np

from fe_engine import kernels
from fe_engine.assembly import System
from fe_engine.contact.coulomb import KN, KT
from fe_engine.hex8 import strain_at
from fe_engine.kernels import gather
from fe_engine.soil.plasol import BULK, SHEAR
from fe_engine.state import Fields, initial_fields

TERMS = ("work", "initial", "elastic", "plastic", "penalty", "friction", "water")
WORK, INITIAL, ELASTIC, PLASTIC, PENALTY, FRICTION, WATER = range(len(TERMS))


@dataclass(frozen=True)
class Energy:
    """Energies in J since the initial state."""

    work: float
    initial: float
    elastic: float
    plastic: float
    penalty: float
    friction: float
    water: float

    @property
    def imbalance(self) -> float:
        """What is missing, J."""
        return self.work + self.initial - self.elastic - self.plastic - self.penalty - self.friction - self.water

    @property
    def moved(self) -> float:
        """Largest of the terms, which an imbalance is judged beside, J."""
        return max(abs(getattr(self, name)) for name in TERMS)


class EnergyBalance:
    """Follows the energy of a run from its initial state."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.initial = initial_fields(system.model)
        self.terms = np.zeros(len(TERMS))
        self._last = initial_fields(system.model)
        self._border = np.zeros(system.model.n_border)

    def advance(self, new: Fields, border: np.ndarray) -> None:
        """Add a step that ended in this state under these loads (nb,), counted from the initial state's."""
        old = self._last
        s, t = self.system, self.terms
        soil = _soil(
            s.hexes, (s.gradient, s.mean_gradient, s.volume), s.model.material, s.parameters, (s.frame_of, s.frames),
            (old.displacement, old.stress), (new.displacement, new.stress), self.initial.stress,
        )  # fmt: skip
        contact = self._contact(old, new)
        water = self._water(old, new)
        t[ELASTIC] += soil[0] + self._linear(old, new)
        t[PLASTIC] += soil[1]
        t[PENALTY] += contact[0]
        t[FRICTION] += contact[1]
        t[INITIAL] += soil[2] + contact[2]
        t[WATER] += water
        t[WORK] += 0.5 * (self._border + border) @ (new.border - old.border)
        self._border = np.array(border, dtype=float)
        old.copy_from(new)

    @property
    def totals(self) -> tuple[np.ndarray, np.ndarray]:
        """Terms added up over the steps (J), and the loads (nb,) at the last; see `go_on_from`."""
        return self.terms.copy(), self._border

    def go_on_from(self, state: Fields, terms: np.ndarray, border: np.ndarray) -> None:
        """Take up a saved state, with the `totals` that went with it."""
        self.terms[...] = terms
        self._border = np.array(border, dtype=float)
        self._last.copy_from(state)

    def now(self) -> Energy:
        """Return the energies up to the last step."""
        return Energy(*(float(value) for value in self.terms))

    def _linear(self, old: Fields, new: Fields) -> float:
        """Energy stored in linear elements."""
        if self.system.model.linear is None:
            return 0.0
        kept = [kernels.linear_energy(*self.system.linear, each.displacement) for each in (old, new)]
        return float(kept[1] - kept[0])

    def _contact(self, old: Fields, new: Fields) -> tuple[float, float, float]:
        """Stored, dissipated and initial work of the contact tractions."""
        s = self.system.stations
        if not len(s.area):
            return 0.0, 0.0, 0.0
        area, law = s.area, s.contact
        slide = kernels.station_jumps(s, new.displacement, new.border) - kernels.station_jumps(
            s, old.displacement, old.border
        )
        mean = 0.5 * (old.traction + new.traction)
        done = np.einsum("s,si,si->", area, mean, slide)
        springs = 0.5 / np.stack([law[:, KN], law[:, KT], law[:, KT]], axis=1)
        stored = np.einsum("s,si,si->", area, springs, new.traction**2 - old.traction**2)
        initial = np.einsum("s,si,si->", area, self.initial.traction, slide)
        return float(stored), float(done - stored), float(initial)

    def _water(self, old: Fields, new: Fields) -> float:
        """Work done against the pore pressures, by soil and gaps."""
        model, s = self.system.model, self.system
        if model.water is None:
            return 0.0
        pressure = 0.5 * (old.pressure + new.pressure)
        n = model.mesh.n_nodes
        move = (new.displacement - old.displacement)[s.hexes]
        _, _, volume, coupling = s.pores.arrays
        mean = np.einsum("eb,eb->e", volume, pressure[:n][s.hexes])
        soil = -float(np.einsum("e,eai,eai->", mean, coupling, move))
        film = model.water.film
        if film is None:
            return soil
        p = s.stations.area * np.einsum("sc,sc->s", film.weight, pressure[n:][film.nodes])
        opened = [kernels.station_jumps(s.stations, each.displacement, each.border)[:, 0] for each in (old, new)]
        return soil - float(p @ (opened[1] - opened[0]))


@nb.njit(cache=True)
def _soil(hexes, geometry, material, parameters, frames, old, new, initial_stress):
    """Return (stored, dissipated, initial) work of a step in J; ``old`` and ``new`` are (displacement, stress)."""
    gradient, mean_gradient, volume = geometry
    stored, dissipated, initial = 0.0, 0.0, 0.0
    move, strain = np.empty((8, 3)), np.empty(6)
    for e in range(hexes.shape[0]):
        p = parameters[material[e]]
        gather(hexes[e], new[0], old[0], frames, move)
        for g in range(8):
            strain_at(gradient[e, g], mean_gradient[e], move, strain)
            done, begun = 0.0, 0.0
            for i in range(6):
                done += 0.5 * (old[1][e, g, i] + new[1][e, g, i]) * strain[i]
                begun += initial_stress[e, g, i] * strain[i]
            kept = _stored(p, new[1][e, g]) - _stored(p, old[1][e, g])
            stored += volume[e, g] * kept
            dissipated += volume[e, g] * (done - kept)
            initial += volume[e, g] * begun
    return stored, dissipated, initial


@nb.njit(cache=True)
def _stored(p, stress):
    """Elastic energy density s:C^-1:s/2 = I^2/(18 K) + II^2/(2 G) of a stress (6,), in J/m3."""
    first = stress[0] + stress[1] + stress[2]
    square = 0.0
    for i in range(3):
        square += 0.5 * (stress[i] - first / 3.0) ** 2 + stress[i + 3] ** 2
    return first * first / (18.0 * p[BULK]) + square / (2.0 * p[SHEAR])
