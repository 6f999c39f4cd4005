# SPDX-License-Identifier: MIT
"""Equation numbers of a Fourier model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fe_engine.elements import fourier as elements
from fe_engine.errors import ModelError
from fe_engine.fourier_model import FourierModel, SectionMesh


@dataclass(frozen=True)
class FourierPattern:
    """Equations of the coefficients: all of them, (n, 3, K) in a row, those that are held with nothing in theirs.

    held : (n, 3, K) bool; n_unknowns : number of the others. retained, interface : (nk,) nodes with stations and (m,)
    equations of what they have free; ``place`` (n, 3, K) is where a coefficient stands among these, or -1.
    On the axis u_r = U cos(theta) and u_theta = -U sin(theta): V is held there, and follows U.
    ``ones`` are the slots of k = 1.
    Equations of the pressures (np, K) stand behind those of the displacements; ``pressure_held`` (np, K) are those that
    are held, and ``film_place`` (np, K) is where those of the film stand in the interface, or -1.
    Where linear elements stand on the other side of the stations, ``opposite`` (nk,) are their nodes there, and
    ``beyond`` (m,) the equations that an equation of the interface has there, or -1; ``opposite`` is empty elsewhere.

    ::

        unknowns (n_free,)  | node 0: all U, all V, all W        | node 1 .. | p 0: P_0..P_N | p 1 .. | film .. |
                            |<-------------- n_moving = 3 n K -------------->|<---------- np K ---------------->|
        interface (m,)      | what is free of retained nodes | what is free of the film |    numbers of the row above
    """

    held: np.ndarray
    axis: np.ndarray
    retained: np.ndarray
    interface: np.ndarray
    place: np.ndarray
    pressure_held: np.ndarray
    film_place: np.ndarray
    opposite: np.ndarray
    beyond: np.ndarray
    ones: slice

    @property
    def n_moving(self) -> int:
        """Number of equations of the displacements, those that are held included."""
        return int(self.held.size)

    @property
    def n_free(self) -> int:
        """Number of equations, those that are held included."""
        return int(self.held.size + self.pressure_held.size)

    @property
    def n_unknowns(self) -> int:
        """Number of coefficients that are not held."""
        return int(np.count_nonzero(~self.held) + np.count_nonzero(~self.pressure_held))

    @property
    def equation(self) -> np.ndarray:
        """Equation (n, 3, K) of each coefficient of the displacement."""
        return np.arange(self.n_moving).reshape(self.held.shape)

    def folded(self, force: np.ndarray) -> np.ndarray:
        """Return the forces (n, 3, K) on the coefficients that are free, in place, in a row (n_moving,)."""
        force[self.axis, 0, self.ones] -= force[self.axis, 1, self.ones]  # V = -U there: its force goes to U
        force[self.held] = 0.0
        return force.ravel()

    def unfolded(self, x: np.ndarray) -> np.ndarray:
        """Return all coefficients (n, 3, K) from those that are free (n_moving,)."""
        move = x.reshape(self.held.shape).copy()
        move[self.axis, 1, self.ones] = -move[self.axis, 0, self.ones]
        return move

    def facing(self, move: np.ndarray) -> np.ndarray:
        """Return coefficients (n, 3, K) with the motion of the soil beside the stations counted from the other side."""
        if not len(self.opposite):
            return move
        relative = move.copy()
        relative[self.retained] -= move[self.opposite]
        return relative

    def add_across(self, across: np.ndarray, force: np.ndarray) -> None:
        """Add forces (n, 3, K) of the stations on the soil to forces (n, 3, K), and the opposite ones beyond."""
        force += across
        force[self.opposite] -= across[self.retained[: len(self.opposite)]]

    def jump(self, x: np.ndarray) -> np.ndarray:
        """Return what stations see (m,) of all equations' unknowns (n_free,)."""
        seen, joined = x[self.interface], self.beyond >= 0
        seen[joined] -= x[self.beyond[joined]]
        return seen

    def add_jump_forces(self, force: np.ndarray, out: np.ndarray) -> None:
        """Add forces (m,) of the stations to the rows (n_free,) of all equations: the transpose of `jump`."""
        joined = self.beyond >= 0
        out[self.interface] += force
        out[self.beyond[joined]] -= force[joined]

    def of_soil(self, n: int) -> FourierPattern:
        """Return the pattern of the first n nodes alone, those of the soil, as if the body were rigid."""
        less = self.held[n:].size
        interface = np.where(self.interface < self.held.size, self.interface, self.interface - less)
        none = np.full(len(interface), -1)
        return replace(
            self, held=self.held[:n], axis=self.axis[:n], place=self.place[:n], interface=interface,
            opposite=self.opposite[:0], beyond=none,
        )  # fmt: skip


def held_coefficients(mesh: SectionMesh, fixed: np.ndarray, harmonics: int, whole: bool = False) -> np.ndarray:
    """Return whether each coefficient (n, 3, K) is held, for fixed directions (n, 3).

    On the axis the motion is one of the whole cross-section: along z for k = 0, along x or y for k = 1, none else.
    """
    axis, slots = mesh.on_axis, len(elements.numbers(harmonics, whole))
    held = np.zeros((mesh.n_nodes, 3, slots), dtype=bool)
    held[fixed] = True
    held[:, 1, 0] |= not whole  # no torsion of a half
    held[axis, :2, 0] = True  # u_r = u_theta = 0 on the axis
    held[axis, :, 1:] = True
    held[axis, 0, slots_of_one(harmonics)] = fixed[axis, :1]  # u_r = U cos(theta), u_theta = -U sin(theta): along x
    return held


def slots_of_one(harmonics: int) -> slice:
    """Return the slots of k = 1 in an axis (K,): one of each family; none without harmonics."""
    return slice(1, None, harmonics) if harmonics else slice(1, 1)


def hold(stiffness: np.ndarray, held: np.ndarray, axis: np.ndarray) -> None:
    """Take what is held (ne, 8, 3, K) out of element stiffnesses (K, ne, 24, 24), in place.

    On the axis (ne, 8) V of k = 1 goes into U.
    """
    for k, matrices in enumerate(stiffness):
        if k == 1:
            for e, a in np.argwhere(axis):
                matrices[e, 3 * a] -= matrices[e, 3 * a + 1]  # V = -U on the axis: rows and columns fold
                matrices[e, :, 3 * a] -= matrices[e, :, 3 * a + 1]
        still = held[..., k].reshape(len(held), -1)
        matrices[still] = 0.0
        matrices.transpose(0, 2, 1)[still] = 0.0


def held_pressures(fixed: np.ndarray, on_axis: np.ndarray, slots: int) -> np.ndarray:
    """Return whether each coefficient (np, K) is held, for pressures (np,) that are fixed and those on the axis.

    On the axis those of k >= 1 are held: all slots but the first.
    """
    held = np.repeat(fixed[:, None], slots, axis=1)
    held[on_axis, 1:] = True
    return held


def make_pattern(model: FourierModel) -> FourierPattern:
    """Return numbers for all equations."""
    ones, axis = slots_of_one(model.harmonics), model.mesh.on_axis
    held = held_coefficients(model.mesh, model.fixed, model.harmonics, model.whole)
    retained, first = np.unique(model.stations.nodes[:, 0], return_index=True)
    if axis[retained].any():
        raise ModelError("a station stands on the axis, where it has no area")
    place = np.full(held.shape, -1)
    at, i, k = np.nonzero(~held[retained])
    place[retained[at], i, k] = np.arange(len(at))
    interface = np.ravel_multi_index((retained[at], i, k), held.shape)
    node = model.pressure_nodes
    fixed = np.zeros(0, dtype=bool) if model.water is None else model.water.fixed
    still = held_pressures(fixed, axis[node], len(model.numbers))
    film = ~still
    film[: len(model.mesh.corners)] = False
    film_place = np.full(still.shape, -1)
    film_place[film] = len(at) + np.arange(np.count_nonzero(film))
    opposite = model.stations.nodes[first, 1] if model.linear is not None else retained[:0]
    beyond = np.full(len(interface) + int(np.count_nonzero(film)), -1)
    if len(opposite):
        if (held[retained] & ~held[opposite]).any():
            raise ModelError("a linear element is free beside soil that is held")
        there = np.ravel_multi_index((opposite[at], i, k), held.shape)
        beyond[: len(interface)] = np.where(held.ravel()[there], -1, there)
    interface = np.concatenate([interface, held.size + np.flatnonzero(film)])
    return FourierPattern(held, axis, retained, interface, place, still, film_place, opposite, beyond, ones)
