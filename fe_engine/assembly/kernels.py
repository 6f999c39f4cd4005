# SPDX-License-Identifier: MIT
"""Compiled loops over elements and stations; nothing is decided here.

Elements are computed in parallel batches into private blocks and scattered in order, so that sums have one
order and results do not depend on the number of threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numba as nb
import numpy as np

from fe_engine.compiled import njit
from fe_engine.contact import coulomb
from fe_engine.contact.coulomb import N_PARAMETERS
from fe_engine.conventions import OK, REGIME_ELASTIC
from fe_engine.elements.hex8 import add_force, add_stiffness, b_bar, strain_at
from fe_engine.fourier_model import FourierModel
from fe_engine.model import Model
from fe_engine.soil.dispatch import update_soil
from fe_engine.soil.elastic import elastic_tangent, subtract_elastic_tangent

BATCH = 4096  # the fewer, the less threads wait for each other; 19 MB of blocks
_update_contact = coulomb.update
_linearise_contact = coulomb.linearise


class Scatter(NamedTuple):
    """Where local entries go: see pattern.Pattern."""

    equation: np.ndarray
    weight: np.ndarray
    rank: np.ndarray
    indptr: np.ndarray


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
def gather(nodes, new, old, frames, out):
    """Increment of displacement (8, 3) of an element in global axes."""
    frame_of, table = frames
    for a in range(8):
        n = nodes[a]
        f = frame_of[n]
        for i in range(3):
            out[a, i] = new[n, i] - old[n, i]
        if f >= 0:
            x, y, z = out[a, 0], out[a, 1], out[a, 2]
            for i in range(3):
                out[a, i] = table[f, 0, i] * x + table[f, 1, i] * y + table[f, 2, i] * z


@njit
def _to_nodal_axes(nodes, frames, force, stiffness, want):
    """Turn force (24,) and stiffness (24, 24) into the nodal axes of skew nodes."""
    frame_of, table = frames
    t = np.empty(3)
    for a in range(8):
        f = frame_of[nodes[a]]
        if f < 0:
            continue
        for i in range(3):
            t[i] = table[f, i, 0] * force[3 * a] + table[f, i, 1] * force[3 * a + 1] + table[f, i, 2] * force[3 * a + 2]
        for i in range(3):
            force[3 * a + i] = t[i]
        if not want:
            continue
        for c in range(24):
            for i in range(3):
                t[i] = 0.0
                for k in range(3):
                    t[i] += table[f, i, k] * stiffness[3 * a + k, c]
            for i in range(3):
                stiffness[3 * a + i, c] = t[i]
        for r in range(24):
            for i in range(3):
                t[i] = 0.0
                for k in range(3):
                    t[i] += table[f, i, k] * stiffness[r, 3 * a + k]
            for i in range(3):
                stiffness[r, 3 * a + i] = t[i]


@njit
def _element(
    e, slot, hexes, shapes, material, laws, parameters, initial_stress, frames, old, new,
    regime, want, forces, stiffnesses, changed,
):  # fmt: skip
    """Force (24,) of element e into a slot, and what its stiffness (24, 24) has beyond the elastic one.

    Updates its trial stress and history; ``changed`` tells whether any point is not elastic.
    """
    gradient, mean_gradient, volume = shapes
    law, p = laws[material[e]], parameters[material[e]]
    force, stiffness = forces[slot], stiffnesses[slot if want else 0]
    move = np.empty((8, 3))
    strain = np.empty(6)
    change = np.empty(6)
    tangent = np.empty((6, 6))
    b = np.zeros((6, 24))
    cb = np.empty((6, 24))
    gather(hexes[e], new[0], old[0], frames, move)
    force[:] = 0.0
    changed[slot] = False
    for g in range(8):
        strain_at(gradient[e, g], mean_gradient[e], move, strain)
        status, what = update_soil(
            law, p, strain, old[1][e, g], old[2][e, g], new[1][e, g], new[2][e, g], tangent, want
        )
        if status != OK:
            return status
        regime[e, g] = what
        for i in range(6):
            change[i] = new[1][e, g, i] - initial_stress[e, g, i]
        add_force(gradient[e, g], mean_gradient[e], volume[e, g], change, force)
        if want and what != REGIME_ELASTIC:
            if not changed[slot]:
                stiffness[:, :] = 0.0
                changed[slot] = True
            subtract_elastic_tangent(p[0], p[1], tangent)
            b_bar(gradient[e, g], mean_gradient[e], b)
            add_stiffness(b, tangent, volume[e, g], cb, stiffness)
    _to_nodal_axes(hexes[e], frames, force, stiffness, changed[slot])
    return OK


@njit
def elastic_stiffness(hexes, shapes, material, parameters, frames, scatter, offset, targets):
    """Add the stiffness of all elements at rest, where every point is elastic, to the tangent's arrays."""
    gradient, mean_gradient, volume = shapes
    tangent, b, cb = np.empty((6, 6)), np.zeros((6, 24)), np.empty((6, 24))
    force, stiffness = np.zeros(24), np.empty((24, 24))
    for e in range(hexes.shape[0]):
        p = parameters[material[e]]
        elastic_tangent(p[0], p[1], 1.0, tangent)
        stiffness[:, :] = 0.0
        for g in range(8):
            b_bar(gradient[e, g], mean_gradient[e], b)
            add_stiffness(b, tangent, volume[e, g], cb, stiffness)
        _to_nodal_axes(hexes[e], frames, force, stiffness, True)
        _scatter_stiffness(hexes[e], scatter, offset[e], stiffness, targets)


@njit
def _scatter_force(nodes, scatter, force, free, border):
    for a in range(len(nodes)):
        for i in range(3):
            eq = scatter.equation[nodes[a], i]
            if eq >= 0:
                free[eq] += force[3 * a + i]
            elif eq <= -2:
                border[-2 - eq] += scatter.weight[nodes[a], i] * force[3 * a + i]


@njit
def _scatter_stiffness(nodes, scatter, offset, stiffness, targets):
    data, columns, rows, corner = targets
    for a in range(len(nodes)):
        for i in range(3):
            r = scatter.equation[nodes[a], i]
            if r == -1:
                continue
            for b in range(len(nodes)):
                for j in range(3):
                    c = scatter.equation[nodes[b], j]
                    if c == -1:
                        continue
                    value = stiffness[3 * a + i, 3 * b + j]
                    if r >= 0 and c >= 0:
                        data[scatter.indptr[r] + offset[a, b] + scatter.rank[nodes[b], j]] += value
                    elif r >= 0:
                        columns[r, -2 - c] += scatter.weight[nodes[b], j] * value
                    elif c >= 0:
                        rows[-2 - r, c] += scatter.weight[nodes[a], i] * value
                    else:
                        corner[-2 - r, -2 - c] += scatter.weight[nodes[a], i] * scatter.weight[nodes[b], j] * value


@njit(parallel=True)
def assemble_elements(
    hexes, shapes, material, laws, parameters, initial_stress, frames, old, new,
    regime, scatter, offset, want, free, border, targets,
):  # fmt: skip
    """Add all elements to free (n,), border (nb,) and, if wanted, their plastic part to the tangent's arrays.

    The elastic part of the tangent never changes: see `elastic_stiffness`. ``old`` and ``new`` are (displacement,
    stress, history). Returns -1, or the number of an element whose law did not converge.
    """
    ne = hexes.shape[0]
    size = BATCH if want else ne
    force = np.empty((min(size, ne), 24))
    stiffness = np.empty((BATCH if want else 1, 24, 24))
    status = np.zeros(ne, dtype=np.int64)
    changed = np.zeros(min(size, ne), dtype=np.bool_)
    for start in range(0, ne, size):
        count = min(size, ne - start)
        for k in nb.prange(count):
            slot = np.int64(k)  # prange counts in uint64, which turns to float beside int64
            status[start + slot] = _element(
                start + slot, slot, hexes, shapes, material, laws, parameters, initial_stress, frames, old, new,
                regime, want, force, stiffness, changed,
            )  # fmt: skip
        for k in range(count):
            e = start + k
            _scatter_force(hexes[e], scatter, force[k], free, border)
            if want and changed[k]:
                _scatter_stiffness(hexes[e], scatter, offset[e], stiffness[k], targets)
    for e in range(ne):
        if status[e] != OK:
            return e
    return -1


@njit
def linear_elements(hexes, stiffness, displacement, scatter, offset, want, free, border, targets):
    """Add the forces of elements of constant stiffness (nl, 24, 24), and their tangent if wanted."""
    force, move = np.empty(24), np.empty(24)
    for e in range(hexes.shape[0]):
        for a in range(8):
            for i in range(3):
                move[3 * a + i] = displacement[hexes[e, a], i]
        for r in range(24):
            force[r] = 0.0
            for c in range(24):
                force[r] += stiffness[e, r, c] * move[c]
        _scatter_force(hexes[e], scatter, force, free, border)
        if want:
            _scatter_stiffness(hexes[e], scatter, offset[e], stiffness[e], targets)


@njit
def linear_energy(hexes, stiffness, displacement):
    """Energy (J) stored in elements of constant stiffness."""
    total = 0.0
    for e in range(hexes.shape[0]):
        for r in range(24):
            force = 0.0
            for c in range(24):
                force += stiffness[e, r, c] * displacement[hexes[e, c // 3], c % 3]
            total += 0.5 * displacement[hexes[e, r // 3], r % 3] * force
    return total


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
            _add_dof(scatter, s.nodes[k, a], i, s.weight[k, a] * force, free, border)
        for j in range(len(border)):
            border[j] -= s.body[k, i, j] * force
    return square


@njit
def _add_dof(scatter, node, i, value, free, border):
    eq = scatter.equation[node, i]
    if eq >= 0:
        free[eq] += value
    elif eq <= -2:
        border[-2 - eq] += scatter.weight[node, i] * value


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
    _scatter_stiffness(s.nodes[k], scatter, offset, local, targets)
    for m in range(nb_):
        for i in range(3):
            column, row = 0.0, 0.0
            for j in range(3):
                column -= block[i, j] * s.body[k, j, m]
                row -= s.body[k, j, m] * block[j, i]
            for a in range(nn):
                _add_border(scatter, s.nodes[k, a], i, m, s.weight[k, a] * column, s.weight[k, a] * row, targets)
        for n in range(nb_):
            for i in range(3):
                for j in range(3):
                    targets[3][m, n] += s.body[k, i, m] * block[i, j] * s.body[k, j, n]


@njit
def _add_border(scatter, node, i, m, column, row, targets):
    """Couple dof i of a node with border dof m."""
    eq = scatter.equation[node, i]
    if eq >= 0:
        targets[1][eq, m] += column
        targets[2][m, eq] += row
    elif eq <= -2:
        share = scatter.weight[node, i]
        targets[3][-2 - eq, m] += share * column
        targets[3][m, -2 - eq] += share * row
