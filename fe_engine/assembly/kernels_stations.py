# SPDX-License-Identifier: MIT
"""Compiled loops over the stations of the interface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fe_engine.assembly.scatter import add_border, add_dof, scatter_stiffness
from fe_engine.compiled import lean, njit
from fe_engine.contact.dispatch import linearise_contact, update_contact
from fe_engine.contact.law import Slide
from fe_engine.fourier_model import FourierModel
from fe_engine.material import contact_rows
from fe_engine.model import Model


class PackedStations(NamedTuple):
    """Stations as arrays: see interface.Stations.

    law (ns,) codes, contact (ns, n) parameters, penalties (ns, 2) K_N and K_T in N/m3; initial_pressure (ns,) Pa.
    """

    frame: np.ndarray
    area: np.ndarray
    nodes: np.ndarray
    weight: np.ndarray
    body: np.ndarray
    law: np.ndarray
    contact: np.ndarray
    penalties: np.ndarray
    initial_pressure: np.ndarray


class ContactState(NamedTuple):
    """Displacement (n, 3) or coefficients, border (nb,), and traction (ns, 3) of the stations."""

    displacement: np.ndarray
    border: np.ndarray
    traction: np.ndarray


class Iterate(NamedTuple):
    """Last linear model of each station: traction (ns, 3) and tangent (ns, 3, 3) at a jump (ns, 3)."""

    jump: np.ndarray
    traction: np.ndarray
    tangent: np.ndarray


def pack_stations(model: Model | FourierModel) -> PackedStations:
    """Return the stations of a model as contiguous arrays (empty ones where it has no interface)."""
    s = model.stations
    if s is None:
        empty = np.zeros(0)
        return PackedStations(
            np.zeros((0, 3, 3)), empty, np.zeros((0, 1), np.int64), np.zeros((0, 1)), np.zeros((0, 3, 0)),
            np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 2)), empty,
        )  # fmt: skip
    return PackedStations(
        np.ascontiguousarray(s.frame), s.area.astype(float), s.nodes.astype(np.int64), s.weight.astype(float),
        np.ascontiguousarray(s.body), *contact_rows(model), model.initial_pressure.astype(float),
    )  # fmt: skip


def no_iterate(ns: int) -> Iterate:
    """Return an iterate from which every station starts afresh."""
    return Iterate(np.zeros((ns, 3)), np.zeros((ns, 3)), np.zeros((ns, 3, 3)))


@njit
def _jump(s, k, displacement, border, out):
    """Write the jump (3,) of station k in its frame: side 1 minus the motion of side 2."""
    x = np.zeros(3)
    for a in range(s.nodes.shape[1]):
        for i in range(3):
            x[i] += s.weight[k, a] * displacement[s.nodes[k, a], i]  # sum of w_a u_a
    for j in range(len(border)):
        for i in range(3):
            x[i] -= s.body[k, i, j] * border[j]  # - R q
    for i in range(3):
        out[i] = s.frame[k, i, 0] * x[0] + s.frame[k, i, 1] * x[1] + s.frame[k, i, 2] * x[2]


@njit
def station_jumps(s, displacement, border):
    """Return the jumps (ns, 3) in m of all stations in their frames."""
    out = np.empty((len(s.area), 3))
    for k in range(len(s.area)):
        _jump(s, k, displacement, border, out[k])
    return out


@lean
def guess_traction(iterate, k, traction, jump, guess):
    """Write the traction iterate (3,) of station k at a jump (3,), ``traction`` being the law's own."""
    restart = iterate.traction[k, 0] == 0.0  # open, or no linear model yet
    for i in range(3):
        guess[i] = traction[i] if restart else iterate.traction[k, i]
        if not restart:
            for j in range(3):
                # tau_k of Hueeber et al. 2008 at the present jump
                guess[i] += iterate.tangent[k, i, j] * (jump[j] - iterate.jump[k, j])


@njit
def station_residual(s, old, new, contact_state, scatter, forces):
    """Add the contact forces of the law; ``old`` and ``new`` are ContactState.

    Writes the trial traction and contact_state (ns,). Returns the sum over stations of the squared change of contact
    force, N2.
    """
    jump, jump_old = np.empty(3), np.empty(3)
    square = 0.0
    for k in range(len(s.area)):
        _jump(s, k, new.displacement, new.border, jump)
        _jump(s, k, old.displacement, old.border, jump_old)
        slide = Slide(jump, jump_old, old.traction[k], s.initial_pressure[k])
        contact_state[k] = update_contact(s.law[k], s.contact[k], slide, new.traction[k])
        square += _scatter_traction(s, k, new.traction[k], scatter, forces)
    return square


@njit
def station_tangent(s, old, new, iterate, scatter, offset, forces, targets):
    """Add the linearised contact forces and their tangent; see law.ContactLaw.

    ``iterate`` is the last linear model, which is advanced to the present jump to give the traction iterate, and then
    overwritten. A station without pressure there (open, or no linear model yet) starts from the law's own traction.
    """
    jump, jump_old, guess = np.empty(3), np.empty(3), np.empty(3)
    rotated = np.empty((3, 3))
    for k in range(len(s.area)):
        _jump(s, k, new.displacement, new.border, jump)
        _jump(s, k, old.displacement, old.border, jump_old)
        guess_traction(iterate, k, new.traction[k], jump, guess)
        slide = Slide(jump, jump_old, old.traction[k], s.initial_pressure[k])
        linearise_contact(s.law[k], s.contact[k], slide, guess, iterate.traction[k], iterate.tangent[k])
        iterate.jump[k, :] = jump
        _scatter_traction(s, k, iterate.traction[k], scatter, forces)
        _rotate(s.frame[k], iterate.tangent[k], s.area[k], rotated)
        _scatter_station(s, k, rotated, scatter, offset[k], targets, len(new.border))


@njit
def _scatter_traction(s, k, traction, scatter, forces):
    """Add the change of contact force of station k since the initial state; return its square."""
    frame, square = s.frame[k], 0.0
    for i in range(3):
        change = (traction[0] + s.initial_pressure[k]) * frame[0, i]  # traction is (-p, tau_1, tau_2)
        force = s.area[k] * (change + traction[1] * frame[1, i] + traction[2] * frame[2, i])
        square += force * force
        for a in range(s.nodes.shape[1]):
            add_dof(scatter, s.nodes[k, a], i, s.weight[k, a] * force, forces)
        for j in range(len(forces.border)):
            forces.border[j] -= s.body[k, i, j] * force  # reaction on side 2: -R^T f
    return square


@njit
def _rotate(frame, tangent, area, out):
    """Write area * frame^T tangent frame."""
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
                    targets.corner[m, n] += s.body[k, i, m] * block[i, j] * s.body[k, j, n]
