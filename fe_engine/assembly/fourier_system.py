# SPDX-License-Identifier: MIT
"""Residual and tangent of a Fourier model; offers Newton what `assembly.System` does.

The tangent is never assembled. It is the soil's elastic stiffness, which the series takes apart into one matrix a
harmonic, the contact of the stations, which joins the harmonics on the interface alone, and what the points that yield
have beyond the elastic tangent, which is applied point by point (see solve.fourier_stage).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from fe_engine.assembly import fourier_kernels as kernels
from fe_engine.assembly.bordered import Residual, summary
from fe_engine.assembly.fourier_film import FilmState
from fe_engine.assembly.fourier_pattern import hold, make_pattern
from fe_engine.assembly.fourier_rest import AtRest, BesideLinear, DrySoil, LinearElements, WetSoil
from fe_engine.assembly.fourier_water import FourierWater
from fe_engine.assembly.harmonic_factors import KEPT_BYTES
from fe_engine.assembly.kernels import SoilState
from fe_engine.assembly.kernels_stations import ContactState, PackedStations, no_iterate, pack_stations
from fe_engine.clock import Clock
from fe_engine.conventions import REGIME_ELASTIC
from fe_engine.elements import fourier as elements
from fe_engine.errors import LawError
from fe_engine.fourier_model import FourierModel
from fe_engine.material import contact_gaps, soil_rows
from fe_engine.soil.elastic import elastic_tangent
from fe_engine.state import Fields, State, initial_fields


@dataclass
class FourierTangent:
    """Tangent: elastic soil, contact (ns, 3, 3) of the stations in Pa/m, and what the soil's points have beyond.

    plastic : (ne, 4 M, 6, 6), transposed, times the volume of the point, N m; regime : (ne, 4 M), where elastic it has
        none.
    time_step : s; film : state of the film, None without water.
    """

    contact: np.ndarray
    plastic: np.ndarray
    regime: np.ndarray
    time_step: float = 0.0
    film: FilmState | None = None


class FourierSystem:
    """A Fourier model made ready for evaluation: element geometry, equation numbers, factors of the soil at rest.

    Attributes
    ----------
    time_step : s, of the present increment; only water asks for it.
    keeps_steps : whether a time step that comes again needs no new factors.
    sealed : whether linear systems leave fixed pressures of the soil free, as in a time in which nothing flows: the
        stiffness of the initial state would otherwise have a first layer that drains, however short the time.
    """

    def __init__(self, model: FourierModel, clock: Clock | None = None) -> None:
        model.check()
        self.clock = clock or Clock()
        self.model = model
        self.time_step, self.sealed, self.keeps_steps = 0.0, False, model.water is not None
        gradient, volume = elements.geometry(model.mesh.nodes, model.mesh.quads)
        waves = elements.waves(elements.azimuths(model.azimuths, model.whole), model.harmonics, model.whole)
        weight = elements.span(model.whole) / model.azimuths
        self.soil = kernels.Soil(
            np.ascontiguousarray(model.mesh.quads, dtype=np.int64), gradient, volume, waves,
            model.numbers.astype(float), weight, *soil_rows(model), model.initial_stress, 1.0,
        )  # fmt: skip
        self.soil_forces = kernels.soil_forces_of(self.soil.law)
        self.pattern = make_pattern(model)
        self.stations = pack_stations(model)
        self.contact = _contact(model, self.stations)
        self.water = None if model.water is None else FourierWater(model, self.contact)
        self.linear = None if model.linear is None else LinearElements(model, self.pattern)
        soil = model, self.pattern.of_soil(model.n_soil), self._stiffness(gradient, volume)
        modulus = float((self.soil.moduli @ (1.0, 4.0 / 3.0)).min())  # K + 4 G/3
        self._at_rest = DrySoil(*soil) if self.water is None else WetSoil(*soil, self.water, modulus)
        self._kept: dict[tuple[float, bool], AtRest] = {}
        self._taken: Counter[tuple[float, bool]] = Counter()
        self._rest: tuple[tuple[float, bool], AtRest] | None = None  # that of the present step
        self.is_pressure = np.zeros(self.pattern.n_free, dtype=bool)
        self.is_pressure[self.pattern.n_moving :] = True
        shape, ns = model.initial_stress.shape[:2], len(model.stations)
        self.regime = np.zeros(shape, dtype=np.int8)
        self.contact_state = np.zeros(ns, dtype=np.int8)
        self._plastic = np.zeros((*shape, 6, 6))
        self._iterate = no_iterate(ns)
        self.initial_contact_norm = self._contact_norm(np.zeros((ns, 3)))

    def _stiffness(self, gradient: np.ndarray, volume: np.ndarray) -> np.ndarray:
        """Return the stiffness (N + 1, ne, 24, 24) of the elements at rest by harmonic, 0 in what is held."""
        model, p = self.model, self.pattern
        moduli, number = np.unique(self.soil.moduli.reshape(-1, 2), axis=0, return_inverse=True)
        each_point = np.array([_elastic(*each) for each in moduli])[number.ravel()]  # C of each pair of K and G
        tangent = np.broadcast_to(each_point.reshape(model.mesh.n_elements, -1, 6, 6), (*volume.shape, 6, 6))
        stiffness = np.array(
            [elements.stiffness(gradient, volume, tangent, k, model.whole) for k in range(model.harmonics + 1)]
        )
        hold(stiffness, p.held[model.mesh.quads], p.axis[model.mesh.quads])
        return stiffness

    def at_rest(self, time_step: float) -> AtRest:
        """Return the linear system with the soil at rest; with water that of a time step (s), to nine digits.

        Paths take the same time steps: systems are kept as far as there is room for them, those that most paths take.
        """
        wanted = (0.0, False) if self.water is None else (float(f"{time_step:.9g}"), self.sealed)
        if self._rest is None or self._rest[0] != wanted:
            self._taken[wanted] += 1
            if wanted not in self._kept:
                self._kept[wanted] = self._made(*wanted)
            self._rest = wanted, self._kept[wanted]
        return self._rest[1]

    def _made(self, time_step: float, sealed: bool) -> AtRest:
        soil = self._at_rest.at_rest(time_step, sealed)
        while self._kept and (len(self._kept) + 1) * soil.factors.n_bytes > KEPT_BYTES:
            del self._kept[min(self._kept, key=self._taken.__getitem__)]
        return soil if self.linear is None else BesideLinear(soil, self.linear, self.pattern)

    @property
    def relaxed(self) -> float:
        """Share of the way to the stress of its law that the soil relaxes; see soil.viscous."""
        return self.soil.relaxed

    def relax(self, share: float) -> None:
        """Let the soil relax by this share of the way to the stress of its law from now on; see soil.viscous."""
        self.soil = self.soil._replace(relaxed=share)

    def apply(self, state: State, free: np.ndarray, border: np.ndarray) -> None:
        """Set the trial displacement to the committed one plus the increments (n_free,), (nb,)."""
        n = self.pattern.n_moving
        state.trial.displacement[...] = state.committed.displacement + self.pattern.unfolded(free[:n])
        state.trial.border[...] = state.committed.border + border
        if self.model.water is not None:
            change = self.model.water.scale * free[n:].reshape(state.trial.pressure.shape)
            state.trial.pressure[...] = state.committed.pressure + change

    # --- evaluation ---

    def residual(self, state: State) -> Residual:
        """Evaluate the residual of the laws at the trial displacement; the committed copy is only read."""
        with self.clock.phase("assembly"):
            forces, square = self._forces(state, False)
            return self._contact(state, forces, square)

    def linearise(self, state: State, fresh: bool) -> tuple[Residual, Residual, FourierTangent]:
        """Evaluate the residual of the laws, and the linear model that Newton solves next; see `assembly.System`."""
        with self.clock.phase("assembly"):
            (force, across, border, rows), square = self._forces(state, True)
            judged = self._contact(state, (force.copy(), across.copy(), border.copy(), rows), square)
            if fresh:
                self._iterate.traction[:] = 0.0
            old, new = self._faces(state.committed), self._faces(state.trial)
            kernels.linear_contact(self.contact, old, new, self._iterate, across, border)
            self.pattern.add_across(across, force)
            linear = replace(judged, free=self._row(force, rows), border=border)
            return judged, linear, self._tangent(state.trial, self.regime.copy())

    def tangent_at_rest(self) -> FourierTangent:
        """Return the tangent at the initial state, where the soil is elastic: its law is not called."""
        still = initial_fields(self.model)
        faces = self._faces(still)
        across, border = np.zeros(still.displacement.shape), np.zeros(self.model.n_border)
        self._iterate.traction[:] = 0.0
        kernels.linear_contact(self.contact, faces, faces, self._iterate, across, border)
        return self._tangent(still, np.zeros_like(self.regime))

    def _tangent(self, fields: Fields, regime: np.ndarray) -> FourierTangent:
        """Return the tangent of the present iterate of the contact, and of points with this regime."""
        film = None
        if self.water is not None:
            film = FilmState(self.gaps(fields), fields.pressure.copy(), self.water.step(self.time_step))
        return FourierTangent(self._iterate.tangent.copy(), self._plastic, regime, self.time_step, film)

    def _faces(self, fields: Fields) -> ContactState:
        """Return what stations ask of a state: coefficients of what they see, border and tractions."""
        return ContactState(self.pattern.facing(fields.displacement), fields.border, fields.traction)

    def _forces(self, state: State, with_tangent: bool) -> tuple[tuple, float]:
        """Return forces (n, 3, K), those across the interface (n, 3, K), (nb,), rows (np, K) of the water.

        Without contact; and the sum of squares of the volumes of the water, m6.
        """
        force = self._soil(state, with_tangent)  # int B^T (s - s_0) dV
        if self.linear is not None:
            self.linear.add_force(state.trial.displacement, force)
        across, border = np.zeros(force.shape), np.zeros(self.model.n_border)
        rows, square = self._water(state, (force, across, border))
        return (force, across, border, rows), square

    def _row(self, force: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return forces (n, 3, K) and rows of the water (np, K) in one row, nothing in those that are held."""
        free = self.pattern.folded(force)
        if self.water is None:
            return free
        return np.concatenate([free, np.where(self.pattern.pressure_held, 0.0, rows).ravel()])

    def _soil(self, state: State, with_tangent: bool) -> np.ndarray:
        """Return forces (n, 3, K) of the soil; ``with_tangent`` adds yielding points to the tangent."""
        old, new = (SoilState(f.displacement, f.stress, f.history) for f in (state.committed, state.trial))
        force = np.zeros(self.model.displacement_shape)
        bad = self.soil_forces(self.soil, old, new, self.regime, with_tangent, self._plastic, force)
        if bad >= 0:
            r, z = self.model.mesh.nodes[self.model.mesh.quads[bad]].mean(axis=0)
            raise LawError(f"soil law did not converge in element {bad} at r={r:.3f}, z={z:.3f} m")
        return force

    def _water(self, state: State, forces: tuple) -> tuple[np.ndarray, float]:
        """Add the forces of the water; return its rows (np, K) and the sum of squares of its volumes, m6."""
        if self.water is None:
            return np.zeros((0, len(self.model.numbers))), 0.0
        gaps, step = (self.gaps(state.committed), self.gaps(state.trial)), self.water.step(self.time_step)
        return self.water.add(step, state.committed, state.trial, gaps, forces)

    def _contact(self, state: State, forces: tuple, volume: float) -> Residual:
        """Add the contact forces of the law and sum up.

        forces : see `_forces`; volumes of the water have the sum of squares ``volume``.
        """
        old, new = self._faces(state.committed), self._faces(state.trial)
        force, across, border, rows = forces
        kernels.contact_forces(self.contact, old, new, self.contact_state, across, border)
        self.pattern.add_across(across, force)
        norm = self._contact_norm(new.traction)
        free = self._row(force, rows)
        return summary(free, border, norm, float(np.sqrt(volume)), self.regime, self.contact_state)

    def _contact_norm(self, traction: np.ndarray) -> float:
        """Return the 2-norm of the change of the interface's forces on the coefficients, N."""
        force, border = np.zeros(self.model.displacement_shape), np.zeros(self.model.n_border)
        kernels.add_tractions(self.contact, traction, force, border)
        return float(np.linalg.norm(self.pattern.folded(force)))

    def remember_iterates(self) -> tuple[np.ndarray, ...]:
        """Copy of the traction iterates, for an evaluation that may be taken back."""
        return tuple(part.copy() for part in self._iterate)

    def take_back(self, iterates: tuple[np.ndarray, ...]) -> None:
        """Go on from these traction iterates, as if nothing had been linearised since."""
        for mine, part in zip(self._iterate, iterates, strict=True):
            mine[...] = part

    # --- tangent ---

    def plastic_product(self, tangent: FourierTangent, x: np.ndarray) -> np.ndarray:
        """Return what the tangent of the soil has beyond the elastic one, times x (n_moving,)."""
        out = np.zeros(self.model.displacement_shape)
        kernels.plastic_product(self.soil, tangent.regime, tangent.plastic, self.pattern.unfolded(x), out)
        return self.pattern.folded(out)

    def yielding(self, tangent: FourierTangent) -> tuple[np.ndarray, np.ndarray]:
        """Return the elements on which `plastic_product` has something, and their nodes (p,)."""
        elements = np.flatnonzero((tangent.regime != REGIME_ELASTIC).any(axis=1))
        return elements, np.unique(self.model.mesh.quads[elements])

    def contact_matrix(self, tangent: FourierTangent, out: np.ndarray | None = None) -> np.ndarray:
        """Return the tangent (m + nb, m + nb) of contact and film: equations of the interface, then the border.

        It is written into ``out`` where that is given.
        """
        size = len(self.pattern.interface) + self.model.n_border
        out = np.empty((size, size), order="F") if out is None else out
        out[...] = 0.0
        place = self.pattern.place[self.contact.node]
        kernels.contact_matrix(self.contact, tangent.contact, place, out)
        if self.water is not None and tangent.film is not None:
            self.water.film_matrix(tangent.film, place, self.pattern.film_place, out)
        return out

    # --- what others ask ---

    def jumps(self, fields: Fields) -> np.ndarray:
        """Return the jumps (ns, 3) in m of all stations in their frames."""
        jumps: np.ndarray = kernels.station_jumps(self.contact, self.pattern.facing(fields.displacement), fields.border)
        return jumps

    def gaps(self, fields: Fields) -> np.ndarray:
        """Return the openings (ns,) in m of all stations, 0 where they are closed."""
        return contact_gaps(self.model, self.jumps(fields)[:, 0])

    def solid_work(self, old: Fields, new: Fields) -> tuple[float, float, float]:
        """Return the work (J) of soil and linear elements in a step: stored, dissipated, and of the initial stress."""
        states = (SoilState(f.displacement, f.stress, f.history) for f in (old, new))
        stored, dissipated, initial = kernels.soil_work(self.soil, *states)
        if self.linear is not None:
            stored += self.linear.stored(new) - self.linear.stored(old)
        return stored, dissipated, initial

    def water_work(self, old: Fields, new: Fields) -> float:
        """Return the work (J) done against the pore pressures, by soil and gaps."""
        if self.water is None:
            return 0.0
        return self.water.work(old, new, self.jumps(new)[:, 0] - self.jumps(old)[:, 0])

    @property
    def film_area(self) -> np.ndarray:
        """Areas (ns,) of the film at the stations, m2; 0 without a film."""
        return np.zeros(len(self.stations.area)) if self.water is None else self.water.film_area

    def elements_at(self, equations: np.ndarray) -> np.ndarray:
        """Return the elements that these equations belong to; none where they are those of the film alone."""
        nodes = self._nodes_of(np.asarray(equations))
        return np.flatnonzero(np.isin(self.model.mesh.quads, nodes).any(axis=1))

    def stations_on(self, numbers: np.ndarray) -> np.ndarray:
        """Return whether each station (ns,) stands on one of these elements."""
        return np.isin(self.contact.node, self.model.mesh.quads[numbers])

    def strain_step(self, state: State, element: int, point: int) -> np.ndarray:
        """Return the strain increment (6,) of a point of an element, in cylindrical axes."""
        return kernels.strain_step(self.soil, element, point, state.committed.displacement, state.trial.displacement)

    def place_of_equation(self, equation: int) -> str:
        """Return the node, harmonic, direction and coordinates of a free equation, for messages."""
        n = self.pattern.n_moving
        node = int(self._nodes_of(np.array([equation]))[0]) if equation < n + self._n_soil_water else -1
        if node < 0:
            film, k = divmod(equation - n - self._n_soil_water, len(self.model.numbers))
            k = int(self.model.numbers[k])
            return f"film node {film}, harmonic {k}"
        r, z = self.model.mesh.nodes[node]
        mine = (self.model.mesh.quads == node).any(axis=1)
        element = f"element {int(np.argmax(mine))}" if mine.any() else "a linear element"
        if equation >= n:
            k, what = (equation - n) % len(self.model.numbers), "pore pressure"
        else:
            _, component, k = (int(i) for i in np.unravel_index(equation, self.model.displacement_shape))
            what = f"direction {('r', 'theta', 'z')[component]}"
        k = int(self.model.numbers[k])
        return f"node {node} of {element}, harmonic {k}, {what}, at r={r:.3f}, z={z:.3f} m"

    @property
    def _n_soil_water(self) -> int:
        """Number of equations of the soil's pressures."""
        return 0 if self.water is None else self.water.n_soil * len(self.model.numbers)

    def _nodes_of(self, equations: np.ndarray) -> np.ndarray:
        """Return nodes of the section that equations of displacements and of the soil's pressures belong to."""
        n, shape = self.pattern.n_moving, self.model.displacement_shape
        moving = equations[equations < n]
        corner = (equations[(equations >= n) & (equations < n + self._n_soil_water)] - n) // shape[2]
        nodes: np.ndarray = np.concatenate([np.unravel_index(moving, shape)[0], self.model.mesh.corners[corner]])
        return nodes


def _elastic(bulk: float, shear: float) -> np.ndarray:
    tangent = np.empty((6, 6))
    elastic_tangent(bulk, shear, 1.0, tangent)
    return tangent


def _contact(model: FourierModel, packed: PackedStations) -> kernels.Contact:
    """Return the stations with their operators on the coefficients of their nodes."""
    s = model.stations
    wave = elements.waves(s.azimuth, model.harmonics, model.whole)
    c, d = np.cos(s.azimuth), np.sin(s.azimuth)
    turn = np.zeros((len(s), 3, 3))  # global from cylindrical components
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, -d, d, c, 1.0  # e_r, e_theta in x, y
    series = np.stack([wave[..., 0], wave[..., 1], wave[..., 0]], axis=1)
    operator = np.einsum("sij,sjk->sijk", s.frame @ turn, series)
    return kernels.Contact(
        s.nodes[:, 0].astype(np.int64), np.ascontiguousarray(operator), np.ascontiguousarray(s.frame @ s.body),
        packed.area, packed.law, packed.contact, packed.initial_pressure,
    )  # fmt: skip
