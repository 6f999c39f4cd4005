# SPDX-License-Identifier: MIT
"""Compiled loops over the stations of the interface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fe_engine.assembly.scatter import add_border, add_dof, scatter_stiffness
from fe_engine.compiled import njit
from fe_engine.contact import coulomb
from fe_engine.contact.coulomb import N_PARAMETERS
from fe_engine.fourier_model import FourierModel
from fe_engine.model import Model

_update_contact = coulomb.update
_linearise_contact = coulomb.linearise


class PackedStations(NamedTuple):
    """Stations as arrays: see interface.Stations; contact (ns, 3), initial pressure (ns,)."""

    frame: np.ndarray
    area: np.ndarray
    nodes: np.ndarray
    weight: np.ndarray
    body: np.ndarray
    contact: np.ndarray
    initial_pressure: np.ndarray


def pack_stations(model: Model | FourierModel) -> PackedStations:
    """Return the stations of a model as contiguous arrays (empty ones where it has no interface)."""
    s = model.stations
    if s is None:
        empty = np.zeros(0)
        return PackedStations(
            np.zeros((0, 3, 3)), empty, np.zeros((0, 1), np.int64), np.zeros((0, 1)), np.zeros((0, 3, 0)),
            np.zeros((0, 3)), empty,
        )  # fmt: skip
    return PackedStations(
        np.ascontiguousarray(s.frame), s.area.astype(float), s.nodes.astype(np.int64), s.weight.astype(float),
        np.ascontiguousarray(s.body), np.ascontiguousarray(np.broadcast_to(model.contact, (len(s), N_PARAMETERS))),
        model.initial_pressure.astype(float),
    )  # fmt: skip


@njit
def _jump(s, k, displacement, border, out):
    """Jump (3,) of station k in its frame: side 1 minus the motion of side 2."""
    x = np.zeros(3)
    for a in range(s.nodes.shape[1]):
        for i in range(3):
            x[i] += s.weight[k, a] * displacement[s.nodes[k, a], i]
    for j in range(len(border)):
        for i in range(3):
            x[i] -= s.body[k, i, j] * border[j]
    for i in range(3):
        out[i] = s.frame[k, i, 0] * x[0] + s.frame[k, i, 1] * x[1] + s.frame[k, i, 2] * x[2]


@njit
def station_jumps(s, displacement, border):
    """Jumps (ns, 3) in m of all stations in their frames."""
    out = np.empty((len(s.area), 3))
    for k in range(len(s.area)):
        _jump(s, k, displacement, border, out[k])
    return out


@njit
def station_residual(s, old, new, contact_state, scatter, free, border):
    """Add the contact forces of the law; ``old`` and ``new`` are (displacement, border, traction).

    Writes the trial traction; returns the sum over stations of the squared change of contact force, N2.
    """
    jump, jump_old = np.empty(3), np.empty(3)
    square = 0.0
    for k in range(len(s.area)):
        _jump(s, k, new[0], new[1], jump)
        _jump(s, k, old[0], old[1], jump_old)
        contact_state[k] = _update_contact(s.contact[k], s.initial_pressure[k], jump, jump_old, old[2][k], new[2][k])
        square += _scatter_traction(s, k, new[2][k], scatter, free, border)
    return square


@njit
def station_tangent(s, old, new, iterate, fresh, scatter, offset, free, border, targets):
    """Add the linearised contact forces and their tangent; see contact.coulomb.linearise.

    ``iterate`` is (jump, traction, tangent) of the last linearisation, which is advanced to the present jump
    to give the traction iterate, and then overwritten. ``fresh`` starts from the law's own traction instead.
    """
    jump, jump_old, guess = np.empty(3), np.empty(3), np.empty(3)
    rotated = np.empty((3, 3))
    for k in range(len(s.area)):
        _jump(s, k, new[0], new[1], jump)
        _jump(s, k, old[0], old[1], jump_old)
        # a station that the last linearisation saw open has no shear to go on from
        restart = fresh or iterate[1][k, 0] == 0.0
        for i in range(3):
            guess[i] = new[2][k, i] if restart else iterate[1][k, i]
            if not restart:
                for j in range(3):
                    guess[i] += iterate[2][k, i, j] * (jump[j] - iterate[0][k, j])
        _linearise_contact(
            s.contact[k], s.initial_pressure[k], jump, jump_old, old[2][k], guess,
            iterate[1][k], iterate[2][k],
        )  # fmt: skip
        iterate[0][k, :] = jump
        _scatter_traction(s, k, iterate[1][k], scatter, free, border)
        _rotate(s.frame[k], iterate[2][k], s.area[k], rotated)
        _scatter_station(s, k, rotated, scatter, offset[k], targets, len(border))


@njit
def _scatter_traction(s, k, traction, scatter, free, border):
    """Add the change of contact force of station k since the initial state; return its square."""
    frame, square = s.frame[k], 0.0
    for i in range(3):
        change = (traction[0] + s.initial_pressure[k]) * frame[0, i]
        force = s.area[k] * (change + traction[1] * frame[1, i] + traction[2] * frame[2, i])
        square += force * force
        for a in range(s.nodes.shape[1]):
            add_dof(scatter, s.nodes[k, a], i, s.weight[k, a] * force, free, border)
        for j in range(len(border)):
            border[j] -= s.body[k, i, j] * force
    return square


@njit
def _rotate(frame, tangent, area, out):
    """area * frame^T tangent frame."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                for m in range(3):
                    total += frame[k, i] * tangent[k, m] * frame[m, j]
            out[i, j] = area * total


@njit
def _scatter_station(s, k, block, scatter, offset, targets, nb_):
    """Add weight_a weight_b block to the node pairs and the body's rows, columns and corner."""
    nn = s.nodes.shape[1]
    local = np.empty((3 * nn, 3 * nn))
    for a in range(nn):
        for b in range(nn):
            for i in range(3):
                for j in range(3):
                    local[3 * a + i, 3 * b + j] = s.weight[k, a] * s.weight[k, b] * block[i, j]
    scatter_stiffness(s.nodes[k], scatter, offset, local, targets)
    for m in range(nb_):
        for i in range(3):
            column, row = 0.0, 0.0
            for j in range(3):
                column -= block[i, j] * s.body[k, j, m]
                row -= s.body[k, j, m] * block[j, i]
            for a in range(nn):
                add_border(scatter, s.nodes[k, a], i, m, s.weight[k, a] * column, s.weight[k, a] * row, targets)
        for n in range(nb_):
            for i in range(3):
                for j in range(3):
                    targets[3][m, n] += s.body[k, i, m] * block[i, j] * s.body[k, j, n]
