# SPDX-License-Identifier: MIT
"""Residual and tangent of a Fourier model; offers Newton what `assembly.System` does.

The tangent is never assembled. It is the soil's elastic stiffness, which the series takes apart into one matrix a
harmonic, the contact of the stations, which joins the harmonics on the interface alone, and what the points that yield
have beyond the elastic tangent, which is applied point by point (see fourier_linear).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.assembly import fourier_kernels as kernels
from fe_engine.assembly.bordered import Residual, summary
from fe_engine.assembly.harmonic_factors import HarmonicFactors
from fe_engine.assembly.kernels import SoilState
from fe_engine.assembly.kernels_stations import ContactState, PackedStations, no_iterate, pack_stations
from fe_engine.clock import Clock
from fe_engine.elements import fourier as elements
from fe_engine.errors import LawError, ModelError
from fe_engine.fourier_model import FourierModel, SectionMesh
from fe_engine.material import contact_gaps, soil_rows
from fe_engine.soil.elastic import elastic_tangent
from fe_engine.state import Fields, State


@dataclass(frozen=True)
class FourierPattern:
    """Equations of the coefficients: all of them, (n, 3, K) in a row, those that are held with nothing in theirs.

    held : (n, 3, K) bool; n_unknowns : number of the others. retained, interface : (nk,) nodes with stations and (m,)
    equations of what they have free; ``place`` (n, 3, K) is where a coefficient stands among these, or -1.
    On the axis u_r = U cos(theta) and u_theta = -U sin(theta): V is held there, and follows U.
    """

    held: np.ndarray
    axis: np.ndarray
    retained: np.ndarray
    interface: np.ndarray
    place: np.ndarray

    @property
    def n_free(self) -> int:
        """Number of equations, those that are held included."""
        return int(self.held.size)

    @property
    def n_unknowns(self) -> int:
        """Number of coefficients that are not held."""
        return int(np.count_nonzero(~self.held))

    @property
    def equation(self) -> np.ndarray:
        """Equation (n, 3, K) of each coefficient."""
        return np.arange(self.n_free).reshape(self.held.shape)

    def folded(self, force: np.ndarray) -> np.ndarray:
        """Return the forces (n, 3, K) on the coefficients that are free, in place, in a row (n_free,)."""
        force[self.axis, 0, 1:2] -= force[self.axis, 1, 1:2]
        force[self.held] = 0.0
        return force.ravel()

    def unfolded(self, x: np.ndarray) -> np.ndarray:
        """Return all coefficients (n, 3, K) from those that are free (n_free,)."""
        move = x.reshape(self.held.shape).copy()
        move[self.axis, 1, 1:2] = -move[self.axis, 0, 1:2]
        return move


@dataclass
class FourierTangent:
    """Tangent: elastic soil, contact (ns, 3, 3) of the stations in Pa/m, and what the soil's points have beyond.

    plastic : (ne, 4 M, 6, 6), times the volume of the point, N m; regime : (ne, 4 M), where elastic it has none.
    """

    contact: np.ndarray
    plastic: np.ndarray
    regime: np.ndarray


class FourierSystem:
    """A Fourier model made ready for evaluation: element geometry, equation numbers, factors of the soil at rest."""

    def __init__(self, model: FourierModel, clock: Clock | None = None) -> None:
        model.check()
        self.clock = clock or Clock()
        self.model = model
        self.time_step = 0.0
        gradient, volume = elements.geometry(model.mesh.nodes, model.mesh.quads)
        waves = elements.waves(elements.azimuths(model.azimuths), model.harmonics)
        self.soil = kernels.Soil(
            np.ascontiguousarray(model.mesh.quads, dtype=np.int64), gradient, volume, waves, np.pi / model.azimuths,
            *soil_rows(model), model.initial_stress,
        )  # fmt: skip
        self.pattern = make_pattern(model)
        self.factors = self._factorise(gradient, volume)
        self.schur = self._interface_stiffness()
        self.stations = pack_stations(model)
        self.contact = _contact(model, self.stations)
        self.is_pressure = np.zeros(self.pattern.n_free, dtype=bool)
        shape, ns = model.initial_stress.shape[:2], len(model.stations)
        self.regime = np.zeros(shape, dtype=np.int8)
        self.contact_state = np.zeros(ns, dtype=np.int8)
        self._plastic = np.zeros((*shape, 6, 6))
        self._iterate = no_iterate(ns)
        self.initial_contact_norm = self._contact_norm(np.zeros((ns, 3)))

    def _factorise(self, gradient: np.ndarray, volume: np.ndarray) -> HarmonicFactors:
        """Factorise the soil at rest."""
        model, p = self.model, self.pattern
        moduli, number = np.unique(self.soil.moduli.reshape(-1, 2), axis=0, return_inverse=True)
        each_point = np.array([_elastic(*each) for each in moduli])[number.ravel()]
        tangent = np.broadcast_to(each_point.reshape(model.mesh.n_elements, -1, 6, 6), (*volume.shape, 6, 6))
        waves = range(model.harmonics + 1)
        stiffness = np.array([elements.stiffness(gradient, volume, tangent, k) for k in waves])
        _hold(stiffness, p.held[model.mesh.quads], p.axis[model.mesh.quads])
        return HarmonicFactors(model.mesh.quads, p.retained, stiffness, p.held)

    def _interface_stiffness(self) -> np.ndarray:
        """Return what the elimination of the soil at rest leaves to the interface (m, m)."""
        place = self.pattern.place[self.pattern.retained]
        dense = np.zeros((len(self.pattern.interface),) * 2)
        for k, matrix in enumerate(self.factors.schur):
            at = place[..., k].ravel()
            free = at >= 0
            dense[np.ix_(at[free], at[free])] = matrix[np.ix_(free, free)]
        return dense

    def apply(self, state: State, free: np.ndarray, border: np.ndarray) -> None:
        """Set the trial displacement to the committed one plus the increments (n_free,), (nb,)."""
        state.trial.displacement[...] = state.committed.displacement + self.pattern.unfolded(free)
        state.trial.border[...] = state.committed.border + border

    # --- evaluation ---

    def residual(self, state: State) -> Residual:
        """Evaluate the residual of the laws at the trial displacement; the committed copy is only read."""
        with self.clock.phase("assembly"):
            return self._contact(state, self._soil(state, False))

    def linearise(self, state: State, fresh: bool) -> tuple[Residual, Residual, FourierTangent]:
        """Evaluate the residual of the laws, and the linear model that Newton solves next; see `assembly.System`."""
        with self.clock.phase("assembly"):
            forces = self._soil(state, True)
            judged = self._contact(state, forces.copy())
            border = np.zeros(self.model.n_border)
            if fresh:
                self._iterate.traction[:] = 0.0
            old, new = (ContactState(f.displacement, f.border, f.traction) for f in (state.committed, state.trial))
            kernels.linear_contact(self.contact, old, new, self._iterate, forces, border)
            linear = Residual(self.pattern.folded(forces), border, judged.contact_norm, *_counts(judged))
            return judged, linear, FourierTangent(self._iterate.tangent.copy(), self._plastic, self.regime.copy())

    def _soil(self, state: State, with_tangent: bool) -> np.ndarray:
        """Return forces (n, 3, K) of the soil; ``with_tangent`` adds yielding points to the tangent."""
        old, new = (SoilState(f.displacement, f.stress, f.history) for f in (state.committed, state.trial))
        force = np.zeros(self.model.displacement_shape)
        bad = kernels.soil_forces(self.soil, old, new, self.regime, with_tangent, self._plastic, force)
        if bad >= 0:
            r, z = self.model.mesh.nodes[self.model.mesh.quads[bad]].mean(axis=0)
            raise LawError(f"soil law did not converge in element {bad} at r={r:.3f}, z={z:.3f} m")
        return force

    def _contact(self, state: State, force: np.ndarray) -> Residual:
        """Add the contact forces of the law and sum up."""
        old, new = (ContactState(f.displacement, f.border, f.traction) for f in (state.committed, state.trial))
        border = np.zeros(self.model.n_border)
        kernels.contact_forces(self.contact, old, new, self.contact_state, force, border)
        norm = self._contact_norm(new.traction)
        return summary(self.pattern.folded(force), border, norm, 0.0, self.regime, self.contact_state)

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
        """Return what the tangent of the soil has beyond the elastic one, times x (n_free,)."""
        out = np.zeros(self.model.displacement_shape)
        kernels.plastic_product(self.soil, tangent.regime, tangent.plastic, self.pattern.unfolded(x), out)
        return self.pattern.folded(out)

    def contact_matrix(self, tangent: FourierTangent) -> np.ndarray:
        """Return the tangent (m + nb, m + nb) of the contact: equations of the interface, then the border."""
        size = len(self.pattern.interface) + self.model.n_border
        out = np.zeros((size, size))
        kernels.contact_matrix(self.contact, tangent.contact, self.pattern.place[self.contact.node], out)
        return out

    # --- what others ask ---

    def jumps(self, fields: Fields) -> np.ndarray:
        """Return the jumps (ns, 3) in m of all stations in their frames."""
        jumps: np.ndarray = kernels.station_jumps(self.contact, fields.displacement, fields.border)
        return jumps

    def gaps(self, fields: Fields) -> np.ndarray:
        """Return the openings (ns,) in m of all stations, 0 where they are closed."""
        return contact_gaps(self.model, self.jumps(fields)[:, 0])

    def solid_work(self, old: Fields, new: Fields) -> tuple[float, float, float]:
        """Return the work (J) of the soil from one state to the next: stored, dissipated, and of the initial stress."""
        states = (SoilState(f.displacement, f.stress, f.history) for f in (old, new))
        work: tuple[float, float, float] = kernels.soil_work(self.soil, *states)
        return work

    def elements_at(self, equations: np.ndarray) -> np.ndarray:
        """Return the elements that these equations belong to."""
        nodes = np.unravel_index(equations, self.model.displacement_shape)[0]
        return np.flatnonzero(np.isin(self.model.mesh.quads, nodes).any(axis=1))

    def stations_on(self, numbers: np.ndarray) -> np.ndarray:
        """Return whether each station (ns,) stands on one of these elements."""
        return np.isin(self.contact.node, self.model.mesh.quads[numbers])

    def strain_step(self, state: State, element: int, point: int) -> np.ndarray:
        """Return the strain increment (6,) of a point of an element, in cylindrical axes."""
        return kernels.strain_step(self.soil, element, point, state.committed.displacement, state.trial.displacement)

    def place_of_equation(self, equation: int) -> str:
        """Return the node, harmonic, direction and coordinates of a free equation, for messages."""
        node, component, k = np.unravel_index(equation, self.model.displacement_shape)
        r, z = self.model.mesh.nodes[node]
        element = int(np.argmax((self.model.mesh.quads == node).any(axis=1)))
        direction = ("r", "theta", "z")[component]
        return f"node {node} of element {element}, harmonic {k}, direction {direction}, at r={r:.3f}, z={z:.3f} m"


def _counts(residual: Residual) -> tuple[int, int, int, int]:
    return residual.n_plastic, residual.n_apex, residual.n_slip, residual.n_open


def _elastic(bulk: float, shear: float) -> np.ndarray:
    tangent = np.empty((6, 6))
    elastic_tangent(bulk, shear, 1.0, tangent)
    return tangent


def held_coefficients(mesh: SectionMesh, fixed: np.ndarray, harmonics: int) -> np.ndarray:
    """Return whether each coefficient (n, 3, K) is held, for fixed directions (n, 3).

    On the axis the motion is one of the whole cross-section: along z for k = 0, along x for k = 1, none for others.
    """
    axis, held = mesh.on_axis, np.zeros((mesh.n_nodes, 3, harmonics + 1), dtype=bool)
    held[fixed] = True
    held[:, 1, 0] = True
    held[axis, 0, 0] = True
    held[axis, :, 1:] = True
    held[axis, 0, 1:2] = fixed[axis, :1]
    return held


def make_pattern(model: FourierModel) -> FourierPattern:
    """Give numbers to the equations."""
    axis, held = model.mesh.on_axis, held_coefficients(model.mesh, model.fixed, model.harmonics)
    interface_nodes = np.unique(model.stations.nodes)
    if axis[interface_nodes].any():
        raise ModelError("a station stands on the axis, where it has no area")
    place = np.full(held.shape, -1)
    node, i, k = np.nonzero(~held[interface_nodes])
    place[interface_nodes[node], i, k] = np.arange(len(node))
    interface = np.ravel_multi_index((interface_nodes[node], i, k), held.shape)
    return FourierPattern(held, axis, interface_nodes, interface, place)


def _hold(stiffness: np.ndarray, held: np.ndarray, axis: np.ndarray) -> None:
    """Take what is held (ne, 8, 3, K) out of element stiffnesses (K, ne, 24, 24), in place.

    On the axis (ne, 8) V of k = 1 goes into U.
    """
    for k, matrices in enumerate(stiffness):
        if k == 1:
            for e, a in np.argwhere(axis):
                matrices[e, 3 * a] -= matrices[e, 3 * a + 1]
                matrices[e, :, 3 * a] -= matrices[e, :, 3 * a + 1]
        still = held[..., k].reshape(len(held), -1)
        matrices[still] = 0.0
        matrices.transpose(0, 2, 1)[still] = 0.0


def _contact(model: FourierModel, packed: PackedStations) -> kernels.Contact:
    """Return the stations with their operators on the coefficients of their nodes."""
    s = model.stations
    wave = elements.waves(s.azimuth, model.harmonics)
    c, d = np.cos(s.azimuth), np.sin(s.azimuth)
    turn = np.zeros((len(s), 3, 3))  # global from cylindrical components
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, -d, d, c, 1.0
    series = np.stack([wave[..., 0], wave[..., 1], wave[..., 0]], axis=1)
    operator = np.einsum("sij,sjk->sijk", s.frame @ turn, series)
    return kernels.Contact(
        s.nodes[:, 0].astype(np.int64), np.ascontiguousarray(operator), np.ascontiguousarray(s.frame @ s.body),
        packed.area, packed.law, packed.contact, packed.initial_pressure,
    )  # fmt: skip
