# SPDX-License-Identifier: MIT
"""Compiled loops over elements; nothing is decided here.

Elements are computed in parallel batches into private blocks and scattered in order, so that sums have one
order and results do not depend on the number of threads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba as nb
import numpy as np

from fe_engine.assembly.scatter import scatter_force, scatter_stiffness
from fe_engine.compiled import lean, njit
from fe_engine.conventions import OK, REGIME_ELASTIC
from fe_engine.elements.hex8 import add_force, add_stiffness, b_bar, strain_at
from fe_engine.soil.dispatch import of_laws, relax_soil, update_soil
from fe_engine.soil.elastic import elastic_tangent, stored_density, subtract_elastic_tangent
from fe_engine.soil.law import Point

BATCH = 4096  # elements; the fewer batches, the less threads wait for each other; 19 MB of blocks
CHUNK = 16  # elements of one call


class Elements(NamedTuple):
    """Bricks of the soil.

    hexes (ne, 8) nodes; gradient (ne, 8, 8, 3), mean_gradient (ne, 8, 3) and volume (ne, 8): see hex8.geometry.
    law (ne,) codes, parameters (ne, r, n), moduli (ne, r, 2) K and G in Pa: see material.soil_rows.
    initial_stress (ne, 8, 6) Pa.
    frame_of (n,) index of each node's axes or -1, frames (k, 3, 3).
    relaxed: share of the way to the stress of the law, see soil.viscous.
    """

    hexes: np.ndarray
    gradient: np.ndarray
    mean_gradient: np.ndarray
    volume: np.ndarray
    law: np.ndarray
    parameters: np.ndarray
    moduli: np.ndarray
    initial_stress: np.ndarray
    frame_of: np.ndarray
    frames: np.ndarray
    relaxed: float


class SoilState(NamedTuple):
    """Displacement (n, 3) or coefficients, and of each point stress (ne, np, 6) and history (ne, np, nh)."""

    displacement: np.ndarray
    stress: np.ndarray
    history: np.ndarray


class Blocks(NamedTuple):
    """Results of a batch of elements, by slot: force (k, 24), stiffness (k, 24, 24), changed (k,): not all are elastic.

    By element: status (ne,) of the law, regime (ne, 8) of the points.
    """

    force: np.ndarray
    stiffness: np.ndarray
    changed: np.ndarray
    status: np.ndarray
    regime: np.ndarray


@lean
def row_of(rows, g):
    """Return the row of point g in rows (ne, r, n) of its element: they have one row, or one for each point."""
    return g if rows.shape[1] > 1 else 0


@njit
def gather(nodes, new, old, frame_of, table, out):
    """Write the displacement increment (8, 3) of an element in global axes."""
    for a in range(8):
        n = nodes[a]
        f = frame_of[n]
        for i in range(3):
            out[a, i] = new[n, i] - old[n, i]  # in the axes of the node
        if f >= 0:
            x, y, z = out[a, 0], out[a, 1], out[a, 2]
            for i in range(3):
                out[a, i] = table[f, 0, i] * x + table[f, 1, i] * y + table[f, 2, i] * z  # u = R^T u_node


@njit
def _to_nodal_axes(nodes, frame_of, table, force, stiffness, with_tangent):
    """Turn force (24,) and stiffness (24, 24) into the nodal axes of skew nodes."""
    t = np.empty(3)
    for a in range(8):
        f = frame_of[nodes[a]]
        if f < 0:
            continue
        for i in range(3):
            # f_node = R f, K_node = R K R^T
            t[i] = table[f, i, 0] * force[3 * a] + table[f, i, 1] * force[3 * a + 1] + table[f, i, 2] * force[3 * a + 2]
        for i in range(3):
            force[3 * a + i] = t[i]
        if not with_tangent:
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
def _chunk(start, first, last, elements, old, new, with_tangent, blocks):
    """Write forces and plastic stiffnesses of the elements ``start + first`` up to ``start + last`` into their slots.

    Updates their trial stress and history. One call for several elements: a call with so many arrays costs as much as
    a point of the soil.
    """
    # unpacked once: Numba counts references at each access to a field
    hexes, gradients, mean_gradients, volumes, laws, parameters, moduli, rest, frame_of, frames, relaxed = elements
    forces, stiffnesses, changes, statuses, regimes = blocks
    move = np.empty((8, 3))
    strain, change, tangent = np.empty(6), np.empty(6), np.empty((6, 6))
    b = np.zeros((6, 24))
    cb = np.empty((6, 24))
    for slot in range(first, last):
        e = start + slot
        gradient, mean_gradient, volume, initial_stress = gradients[e], mean_gradients[e], volumes[e], rest[e]
        stress_old, history_old, stress, history = old.stress[e], old.history[e], new.stress[e], new.history[e]
        force, stiffness, regime, changed = forces[slot], stiffnesses[slot if with_tangent else 0], regimes[e], False
        gather(hexes[e], new.displacement, old.displacement, frame_of, frames, move)
        force[:] = 0.0
        for g in range(8):
            row = row_of(moduli, g)
            p, own = parameters[e, row], moduli[e, row]
            strain_at(gradient[g], mean_gradient, move, strain)  # B-bar, Hughes 1980
            before, after = Point(stress_old[g], history_old[g]), Point(stress[g], history[g])
            status, what = update_soil(laws[e], p, strain, before, after, tangent, with_tangent)
            if status != OK:
                statuses[e] = status
                break
            regime[g] = what
            if relaxed < 1.0 and what != REGIME_ELASTIC:  # Duvaut & Lions 1972
                relax_soil(laws[e], p, own, relaxed, strain, before, after, tangent, with_tangent)
            for i in range(6):
                # the initial stress is in equilibrium (docs/theory/soil.md)
                change[i] = stress[g, i] - initial_stress[g, i]
            add_force(gradient[g], mean_gradient, volume[g], change, force)
            if with_tangent and what != REGIME_ELASTIC:
                if not changed:
                    stiffness[:, :] = 0.0
                    changed = True
                # C* - C; s of it counts with viscosity, see soil.viscous
                subtract_elastic_tangent(own[0], own[1], tangent)
                b_bar(gradient[g], mean_gradient, b)
                add_stiffness(b, tangent, relaxed * volume[g], cb, stiffness)
        changes[slot] = changed
        _to_nodal_axes(hexes[e], frame_of, frames, force, stiffness, changed)


@njit
def elastic_stiffness(elements, scatter, offset, targets):
    """Add the stiffness of all elements at rest, where every point is elastic, to the tangent's arrays."""
    tangent, b, cb = np.empty((6, 6)), np.zeros((6, 24)), np.empty((6, 24))
    force, stiffness = np.zeros(24), np.empty((24, 24))
    for e in range(elements.hexes.shape[0]):
        stiffness[:, :] = 0.0
        for g in range(8):
            row = row_of(elements.moduli, g)
            elastic_tangent(elements.moduli[e, row, 0], elements.moduli[e, row, 1], 1.0, tangent)
            b_bar(elements.gradient[e, g], elements.mean_gradient[e], b)
            add_stiffness(b, tangent, elements.volume[e, g], cb, stiffness)
        _to_nodal_axes(elements.hexes[e], elements.frame_of, elements.frames, force, stiffness, True)
        scatter_stiffness(elements.hexes[e], scatter, offset[e], stiffness, targets)


@njit(parallel=True)
def assemble_elements(elements, old, new, regime, scatter, offset, forces, targets):
    """Add the forces of all elements and, with ``with_tangent``, their plastic part to the tangent's arrays.

    The elastic part of the tangent never changes: see `elastic_stiffness`. ``old`` and ``new`` are SoilState; trial
    stress and history are written, and regime (ne, 8). Returns -1, or the number of an element whose law did not
    converge.
    """
    ne, with_tangent = elements.hexes.shape[0], targets.with_tangent
    size = BATCH if with_tangent else ne
    force = np.empty((min(size, ne), 24))
    stiffness = np.empty((BATCH if with_tangent else 1, 24, 24))
    status = np.zeros(ne, dtype=np.int64)
    changed = np.zeros(min(size, ne), dtype=np.bool_)
    blocks = Blocks(force, stiffness, changed, status, regime)
    for start in range(0, ne, size):
        count = min(size, ne - start)
        for k in nb.prange((count + CHUNK - 1) // CHUNK):
            first = CHUNK * np.int64(k)  # prange counts in uint64, which turns to float beside int64
            _chunk(start, first, min(first + CHUNK, count), elements, old, new, with_tangent, blocks)
        for k in range(count):
            e = start + k
            scatter_force(elements.hexes[e], scatter, force[k], forces)
            if with_tangent and changed[k]:
                scatter_stiffness(elements.hexes[e], scatter, offset[e], stiffness[k], targets)
    for e in range(ne):
        if status[e] != OK:
            return e
    return -1


def assembly_of(law: np.ndarray) -> Any:
    """Return `assemble_elements`, compiled for the laws of these codes."""
    return of_laws(tuple(np.unique(law).tolist()), _chunk, assemble_elements)


@njit
def linear_elements(hexes, stiffness, displacement, scatter, offset, forces, targets):
    """Add the forces of elements of constant stiffness (nl, 24, 24), and their tangent on request."""
    force, move = np.empty(24), np.empty(24)
    for e in range(hexes.shape[0]):
        for a in range(8):
            for i in range(3):
                move[3 * a + i] = displacement[hexes[e, a], i]
        for r in range(24):
            force[r] = 0.0
            for c in range(24):
                force[r] += stiffness[e, r, c] * move[c]
        scatter_force(hexes[e], scatter, force, forces)
        if targets.with_tangent:
            scatter_stiffness(hexes[e], scatter, offset[e], stiffness[e], targets)


@njit
def linear_energy(hexes, stiffness, displacement):
    """Return the energy (J) stored in elements of constant stiffness."""
    total = 0.0
    for e in range(hexes.shape[0]):
        for r in range(24):
            force = 0.0
            for c in range(24):
                force += stiffness[e, r, c] * displacement[hexes[e, c // 3], c % 3]
            total += 0.5 * displacement[hexes[e, r // 3], r % 3] * force
    return total


@njit
def hex_work(elements, old, new):
    """Return (stored, dissipated, initial) work of a step in J; ``old`` and ``new`` are SoilState."""
    stored, dissipated, initial = 0.0, 0.0, 0.0
    move, strain = np.empty((8, 3)), np.empty(6)
    for e in range(elements.hexes.shape[0]):
        gather(elements.hexes[e], new.displacement, old.displacement, elements.frame_of, elements.frames, move)
        for g in range(8):
            row = row_of(elements.moduli, g)
            bulk, shear = elements.moduli[e, row, 0], elements.moduli[e, row, 1]
            strain_at(elements.gradient[e, g], elements.mean_gradient[e], move, strain)
            done, begun = 0.0, 0.0
            for i in range(6):
                # mean stress times strain: see balance.energy
                done += 0.5 * (old.stress[e, g, i] + new.stress[e, g, i]) * strain[i]
                begun += elements.initial_stress[e, g, i] * strain[i]
            # s:C^-1:s/2
            change = stored_density(bulk, shear, new.stress[e, g]) - stored_density(bulk, shear, old.stress[e, g])
            stored += elements.volume[e, g] * change
            dissipated += elements.volume[e, g] * (done - change)
            initial += elements.volume[e, g] * begun
    return stored, dissipated, initial
