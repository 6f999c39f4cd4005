# SPDX-License-Identifier: MIT
"""Residual and tangent of a model on its fixed sparsity pattern."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.assembly import kernels, kernels_stations, kernels_water
from fe_engine.assembly.bordered import Residual, Tangent, summary
from fe_engine.assembly.contact_block import ContactBlock, contact_block
from fe_engine.assembly.kernels_stations import no_iterate
from fe_engine.assembly.kernels_water import Step
from fe_engine.assembly.pattern import make_pattern
from fe_engine.assembly.scatter import NOWHERE, Forces, Scatter, Targets
from fe_engine.clock import Clock
from fe_engine.elements import biot, hex8
from fe_engine.errors import LawError
from fe_engine.material import contact_gaps, soil_rows
from fe_engine.model import Model
from fe_engine.state import Fields, State


class System:
    """A model made ready for evaluation: element geometry, equation numbers, work arrays."""

    def __init__(self, model: Model, clock: Clock | None = None) -> None:
        model.check()
        self.clock = clock or Clock()
        self.model = model
        self.pattern = make_pattern(model)
        self.gradient, self.volume, self.mean_gradient = hex8.geometry(model.mesh.nodes, model.mesh.hexes)
        self.hexes = np.ascontiguousarray(model.mesh.hexes, dtype=np.int64)
        self.frame_of, self.frames = _frame_table(model)
        self.elements = kernels.Elements(
            self.hexes, self.gradient, self.mean_gradient, self.volume, *soil_rows(model), model.initial_stress,
            self.frame_of, self.frames, 1.0,
        )  # fmt: skip
        self.assemble = kernels.assembly_of(self.elements.law)
        self.time_step = 0.0  # s, of the present increment; only water asks for it
        self.keeps_steps = False  # each tangent has factors of its own
        self.sealed = False  # see fourier_system: bricks hold fixed pressures at any time
        self.stations = kernels_stations.pack_stations(model)
        self.regime = np.zeros((model.mesh.n_elements, 8), dtype=np.int8)
        self.contact_state = np.zeros(len(self.stations.area), dtype=np.int8)
        self.block: ContactBlock | None = None
        p = self.pattern
        self._scatter = Scatter(p.equation, p.weight, p.rank, p.indptr)
        if model.linear is not None:
            hexes, stiffness = model.linear.hexes, model.linear.stiffness
            self.linear = np.ascontiguousarray(hexes, dtype=np.int64), np.ascontiguousarray(stiffness, dtype=float)
        self._elastic = self._elastic_tangent()
        self._set_up_water()
        ns = len(self.stations.area)
        self.initial_contact_norm = float(np.linalg.norm(self.stations.area * self.stations.initial_pressure))  # N
        self._iterate = no_iterate(ns)
        self._matrix = csr_matrix(
            (np.zeros(len(p.indices)), p.indices, p.indptr.astype(np.int32)), shape=(p.n_free, p.n_free)
        )

    @property
    def matrix_pattern(self) -> csr_matrix:
        """A matrix (n_free, n_free) on the pattern of the tangent; its values are those of the last linearisation."""
        return self._matrix

    def track_contact_block(self) -> ContactBlock | None:
        """Record the contact part of each tangent from now on; return None if it is not a separate block."""
        if self.block is None:
            self.block = contact_block(self.model, self.pattern)
        return self.block

    def _set_up_water(self) -> None:
        water = self.model.water
        self.is_pressure = np.zeros(self.pattern.n_free, dtype=bool)
        if water is None:
            return
        free = self.pattern.equation[:, 3]
        self.is_pressure[free[free >= 0]] = True
        coupling = _in_nodal_axes(self.mean_gradient, self.hexes, self.frame_of, self.frames)
        self.pores = biot.make_pores(
            self.gradient, self.volume, coupling, water.mobility, water.storage, water.stabilisation
        ).only(water.wet)
        self.film = None if water.film is None else kernels_water.pack_film(self.model, self.pattern)
        self._soil_water = self._soil_water_tangent(1.0, 0.0), self._soil_water_tangent(0.0, 1.0)

    def _elastic_tangent(self) -> Targets:
        """Return constant part of the tangent: the soil at rest, where every point is elastic, and linear elements."""
        out = self._no_tangent()
        kernels.elastic_stiffness(self.elements, self._scatter, self.pattern.element_offset, out)
        if self.model.linear is not None:
            rest, p = np.zeros_like(self.model.mesh.nodes), self.pattern
            kernels.linear_elements(*self.linear, rest, self._scatter, p.linear_offset, self._no_forces(), out)
        return out

    def _no_tangent(self) -> Targets:
        n, nb_, p = self.pattern.n_free, self.model.n_border, self.pattern
        return Targets(True, np.zeros(len(p.indices)), np.zeros((n, nb_)), np.zeros((nb_, n)), np.zeros((nb_, nb_)))

    def _no_forces(self) -> Forces:
        return Forces(np.zeros(self.pattern.n_free), np.zeros(self.model.n_border))

    def _soil_water_tangent(self, still: float, flowing: float) -> Targets:
        """Return the constant parts of the tangent: storage and coupling, and seepage in one second."""
        assert self.model.water is not None
        out = self._no_tangent()
        scale, offset = self.model.water.scale, self.pattern.element_offset
        kernels_water.soil_water_tangent(
            self.hexes, self.pores.arrays, (still, flowing), scale, self._scatter, offset, out
        )
        return out

    @property
    def relaxed(self) -> float:
        """Share of the way to the stress of its law that the soil relaxes; see soil.viscous."""
        return self.elements.relaxed

    def relax(self, share: float) -> None:
        """Let the soil relax by this share of the way to the stress of its law from now on; see soil.viscous."""
        self.elements = self.elements._replace(relaxed=share)

    def apply(self, state: State, free: np.ndarray, border: np.ndarray) -> None:
        """Set the trial displacement to the committed one plus the increments (n_free,), (nb,)."""
        equation, weight = self.pattern.equation, self.pattern.weight
        move = np.zeros(equation.shape)
        is_free = equation >= 0
        move[is_free] = free[equation[is_free]]
        follows = equation <= -2
        move[follows] = weight[follows] * border[-2 - equation[follows]]
        state.trial.displacement[...] = state.committed.displacement + move[: self.model.mesh.n_nodes, :3]
        state.trial.border[...] = state.committed.border + border
        if self.model.water is not None:
            state.trial.pressure[...] = state.committed.pressure + self.model.water.scale * move[:, 3]

    def residual(self, state: State) -> Residual:
        """Evaluate the residual of the laws at the trial displacement; the committed copy is only read."""
        with self.clock.phase("assembly"):
            forces = self._soil(state, None)
            volume = self._pores(state, None, forces) + self._film(state, None, forces)
            return self._contact(state, forces, volume)

    def linearise(self, state: State, fresh: bool) -> tuple[Residual, Residual, Tangent]:
        """Evaluate the residual of the laws, and the linear model that Newton solves next.

        The two differ only at stations whose friction is linearised about a traction iterate (see
        contact.coulomb). ``fresh`` starts these iterates from the laws' tractions: the model is then the
        residual with its consistent tangent.
        """
        with self.clock.phase("assembly"):
            return self._linearise(state, fresh)

    def jumps(self, fields: Fields) -> np.ndarray:
        """Return the jumps (ns, 3) in m of all stations in their frames."""
        jumps: np.ndarray = kernels_stations.station_jumps(self.stations, fields.displacement, fields.border)
        return jumps

    def gaps(self, fields: Fields) -> np.ndarray:
        """Return the openings (ns,) in m of all stations, 0 where they are closed."""
        return contact_gaps(self.model, self.jumps(fields)[:, 0])

    def solid_work(self, old: Fields, new: Fields) -> tuple[float, float, float]:
        """Return the work (J) of solids from one state to the next: stored, dissipated, and of the initial stress."""
        stored, dissipated, initial = kernels.hex_work(self.elements, _soil_of(old), _soil_of(new))
        if self.model.linear is not None:
            energies = [kernels.linear_energy(*self.linear, each.displacement) for each in (old, new)]
            stored += energies[1] - energies[0]
        return stored, dissipated, initial

    def water_work(self, old: Fields, new: Fields) -> float:
        """Return the work (J) done against the pore pressures, by soil and gaps."""
        wet = self.model.water
        if wet is None:
            return 0.0
        pressure = 0.5 * (old.pressure + new.pressure)
        n = self.model.mesh.n_nodes
        move = (new.displacement - old.displacement)[self.hexes]
        _, _, volume, coupling = self.pores.arrays
        mean = np.einsum("eb,eb->e", volume, pressure[:n][self.hexes])  # int p dV
        soil = -float(np.einsum("e,eai,eai->", mean, coupling, move))  # -int p dtheta dV
        film = wet.film
        if film is None:
            return soil
        p = self.film_area * np.einsum("sc,sc->s", film.weight, pressure[n:][film.nodes])
        opened = [self.jumps(each)[:, 0] for each in (old, new)]
        return soil - float(p @ (opened[1] - opened[0]))

    @property
    def film_area(self) -> np.ndarray:
        """Areas (ns,) of the film at the stations, m2; 0 without a film."""
        film = None if self.model.water is None else self.film
        return np.zeros(len(self.stations.area)) if film is None else film.station_area

    def elements_at(self, equations: np.ndarray) -> np.ndarray:
        """Return the elements that these equations belong to; none where they are those of film nodes alone."""
        nodes = np.unique(np.nonzero(np.isin(self.pattern.equation, equations))[0])
        return np.flatnonzero(np.isin(self.hexes, nodes).any(axis=1))

    def stations_on(self, elements: np.ndarray) -> np.ndarray:
        """Return whether each station (ns,) stands on one of these elements."""
        return np.asarray(np.isin(self.stations.nodes, np.unique(self.hexes[elements])).any(axis=1))

    def strain_step(self, state: State, element: int, point: int) -> np.ndarray:
        """Return the strain increment (6,) of a point of an element."""
        old, new = state.committed.displacement, state.trial.displacement
        move, strain = np.empty((8, 3)), np.empty(6)
        kernels.gather(self.hexes[element], new, old, self.frame_of, self.frames, move)
        hex8.strain_at(self.gradient[element, point], self.mean_gradient[element], move, strain)
        return strain

    def remember_iterates(self) -> tuple[np.ndarray, ...]:
        """Copy of the traction iterates, for an evaluation that may be taken back."""
        return tuple(part.copy() for part in self._iterate)

    def take_back(self, iterates: tuple[np.ndarray, ...]) -> None:
        """Go on from these traction iterates, as if nothing had been linearised since."""
        for mine, part in zip(self._iterate, iterates, strict=True):
            mine[...] = part

    def _linearise(self, state: State, fresh: bool) -> tuple[Residual, Residual, Tangent]:
        rest = self._elastic
        self._matrix.data[...] = rest.data
        tangent = Tangent(self._matrix, rest.columns.copy(), rest.rows.copy(), rest.corner.copy())
        forces = self._soil(state, tangent)
        volume = self._pores(state, tangent, forces)
        soil = None if self.block is None else tangent.matrix.data[self.block.positions]
        volume += self._film(state, tangent, forces)
        linear = Forces(forces.free.copy(), forces.border.copy())
        judged = self._contact(state, forces, volume)
        if fresh:
            self._iterate.traction[:] = 0.0
        kernels_stations.station_tangent(
            self.stations, _contact_of(state.committed), _contact_of(state.trial), self._iterate, self._scatter,
            self.pattern.station_offset, linear, _targets(tangent),
        )  # fmt: skip
        if self.block is not None:
            tangent.contact = tangent.matrix.data[self.block.positions] - soil
        return judged, replace(judged, free=linear.free, border=linear.border), tangent

    def _soil(self, state: State, tangent: Tangent | None) -> Forces:
        """Return the forces of soil and linear elements; adds to the tangent if one is given."""
        forces, targets = self._no_forces(), _targets(tangent)
        bad = self.assemble(
            self.elements, _soil_of(state.committed), _soil_of(state.trial), self.regime, self._scatter,
            self.pattern.element_offset, forces, targets,
        )  # fmt: skip
        if bad >= 0:
            raise LawError(self._place("soil law did not converge", bad))
        if self.model.linear is not None:
            move = state.trial.displacement  # the tangent has them already
            kernels.linear_elements(*self.linear, move, self._scatter, self.pattern.linear_offset, forces, NOWHERE)
        return forces

    def _pores(self, state: State, tangent: Tangent | None, forces: Forces) -> float:
        """Add the forces and volumes of the soil's water; return the sum of squares of the changes of volume, m6."""
        water = self.model.water
        if water is None:
            return 0.0
        old, new = state.committed, state.trial
        square = kernels_water.soil_water(
            self.hexes, self.pores.arrays, Step(self.time_step, water.scale), (old.displacement, old.pressure),
            (new.displacement, new.pressure), self._scatter, forces,
        )  # fmt: skip
        if tangent is not None:
            parts = _targets(tangent), *self._soil_water
            for target, still, flowing in zip(*(each[1:] for each in parts), strict=True):
                target += still
                target += self.time_step * flowing  # backward Euler: dt H
        return float(square)

    def _film(self, state: State, tangent: Tangent | None, forces: Forces) -> float:
        """Add the forces and volumes of the film; return the sum of squares of the changes of volume, m6."""
        water = self.model.water
        if water is None or self.film is None:
            return 0.0
        gaps, pressure = (self.gaps(state.committed), self.gaps(state.trial)), state.trial.pressure
        packed, step = (self.stations, self.film), Step(self.time_step, water.scale)
        into = self._scatter, forces, _targets(tangent)
        square = kernels_water.station_water(*packed, step, gaps, pressure, *into)
        square += kernels_water.face_water(*packed, step, gaps[1], pressure, *into)
        return float(square)

    def _contact(self, state: State, forces: Forces, volume: float) -> Residual:
        """Add the contact forces of the law and sum up; ``volume`` is the sum of squares of the water's, m6."""
        old, new = _contact_of(state.committed), _contact_of(state.trial)
        square = kernels_stations.station_residual(self.stations, old, new, self.contact_state, self._scatter, forces)
        return summary(*forces, float(np.sqrt(square)), float(np.sqrt(volume)), self.regime, self.contact_state)

    def _place(self, what: str, element: int) -> str:
        centre = self.model.mesh.nodes[self.hexes[element]].mean(axis=0)
        return f"{what} in element {element} at x={centre[0]:.3f}, y={centre[1]:.3f}, z={centre[2]:.3f} m"

    def place_of_equation(self, equation: int) -> str:
        """Return the node, an element of it, direction and coordinates of a free equation, for messages."""
        node, component = np.argwhere(self.pattern.equation == equation)[0]
        n = self.model.mesh.n_nodes
        if node >= n:
            return f"film node {node - n}"
        x, y, z = self.model.mesh.nodes[node]
        mine = (self.hexes == node).any(axis=1)
        element = f"element {int(np.argmax(mine))}" if mine.any() else "a linear element"
        where = f"at x={x:.3f}, y={y:.3f}, z={z:.3f} m"
        what = "pore pressure" if component == 3 else f"direction {'xyz'[component]}"
        return f"node {node} of {element}, {what}, {where}"


def _targets(tangent: Tangent | None) -> Targets:
    return Targets(True, tangent.matrix.data, tangent.columns, tangent.rows, tangent.corner) if tangent else NOWHERE


def _soil_of(fields: Fields) -> kernels.SoilState:
    return kernels.SoilState(fields.displacement, fields.stress, fields.history)


def _contact_of(fields: Fields) -> kernels_stations.ContactState:
    return kernels_stations.ContactState(fields.displacement, fields.border, fields.traction)


def _in_nodal_axes(gradient: np.ndarray, hexes: np.ndarray, frame_of: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Turn gradients (ne, 8, 3) into the axes of the nodes they belong to."""
    turned = gradient.copy()
    element, corner = np.nonzero(frame_of[hexes] >= 0)
    axes = frames[frame_of[hexes[element, corner]]]
    turned[element, corner] = np.einsum("kij,kj->ki", axes, gradient[element, corner])
    return turned


def _frame_table(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of each node's frame (-1: global axes) and the frames (k, 3, 3)."""
    frame_of = np.full(model.mesh.n_nodes, -1, dtype=np.int64)
    frame_of[list(model.frames)] = np.arange(len(model.frames))
    frames = np.array(list(model.frames.values())).reshape(-1, 3, 3)
    return frame_of, frames
