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

import numpy as np

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
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

    def __init__(self, system: System | FourierSystem) -> None:
        self.system = system
        self.initial = initial_fields(system.model)
        self.terms = np.zeros(len(TERMS))
        self._last = initial_fields(system.model)
        self._border = np.zeros(system.model.n_border)

    def advance(self, new: Fields, border: np.ndarray) -> None:
        """Add a step that ended in this state under these loads (nb,), counted from the initial state's."""
        old = self._last
        s, t = self.system, self.terms
        soil = s.solid_work(old, new)
        contact = self._contact(old, new)
        water = s.water_work(old, new)
        t[ELASTIC] += soil[0]
        t[PLASTIC] += soil[1]
        t[PENALTY] += contact[0]
        t[FRICTION] += contact[1]
        t[INITIAL] += soil[2] + contact[2]
        t[WATER] += water
        t[WORK] += 0.5 * (self._border + border) @ (new.border - old.border)  # mean load times motion
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

    def _contact(self, old: Fields, new: Fields) -> tuple[float, float, float]:
        """Return the stored, dissipated and initial work of the contact tractions."""
        s = self.system.stations
        if not len(s.area):
            return 0.0, 0.0, 0.0
        area, penalty = s.area, s.penalties[:, [0, 1, 1]]
        slide = self.system.jumps(new) - self.system.jumps(old)
        mean = 0.5 * (old.traction + new.traction)
        done = np.einsum("s,si,si->", area, mean, slide)
        # t^2/(2 K), K_N and K_T
        stored = np.einsum("s,si,si->", area, 0.5 / penalty, new.traction**2 - old.traction**2)
        initial = np.einsum("s,si,si->", area, self.initial.traction, slide)
        return float(stored), float(done - stored), float(initial)
