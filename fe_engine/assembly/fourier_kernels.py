# SPDX-License-Identifier: MIT
"""Compiled loops over the points of a Fourier model: soil, its tangent, and contact; nothing is decided here.

Coefficients, and the forces on them, are arrays (n, 3, K), see elements.fourier. One thread: sums have one order.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fe_engine.assembly.kernels import row_of
from fe_engine.assembly.kernels_stations import guess_traction
from fe_engine.compiled import lean, njit
from fe_engine.contact.dispatch import linearise_contact, update_contact
from fe_engine.contact.law import Slide
from fe_engine.conventions import OK, REGIME_ELASTIC
from fe_engine.elements.fourier import add_amplitudes, add_force, amplitudes, strain_at
from fe_engine.soil.dispatch import of_laws, relax_soil, update_soil
from fe_engine.soil.elastic import stored_density, subtract_elastic_tangent
from fe_engine.soil.law import Point


class Soil(NamedTuple):
    """Section elements (ne, 8), see elements.fourier; waves (M, K, 2), numbers (K,) float, weight:
    radians of one azimuth.

    law (ne,) codes, parameters (ne, r, n), moduli (ne, r, 2) K and G in Pa: see material.soil_rows. relaxed: see
    soil.viscous. Layout of stress and history: see state.Fields.
    """

    quads: np.ndarray
    gradient: np.ndarray
    volume: np.ndarray
    waves: np.ndarray
    numbers: np.ndarray
    weight: float
    law: np.ndarray
    parameters: np.ndarray
    moduli: np.ndarray
    initial_stress: np.ndarray
    relaxed: float


class Contact(NamedTuple):
    """Stations: node (ns,), jump = operator (3, 3, K) : coefficients - body (3, nb) border, all in their frames.

    law (ns,) codes, parameters (ns, n) of the contact law.
    """

    node: np.ndarray
    operator: np.ndarray
    body: np.ndarray
    area: np.ndarray
    law: np.ndarray
    parameters: np.ndarray
    initial_pressure: np.ndarray


class Scratch(NamedTuple):
    """Room for one element: move (8, 3, K), strains and stresses (K, 6), strain and stress (6,), tangent (6, 6)."""

    move: np.ndarray
    strains: np.ndarray
    stresses: np.ndarray
    strain: np.ndarray
    stress: np.ndarray
    tangent: np.ndarray


@njit
def scratch(n_waves):
    """Return room for an element of so many slots."""
    return Scratch(
        np.empty((8, 3, n_waves)), np.empty((n_waves, 6)), np.empty((n_waves, 6)), np.empty(6), np.empty(6),
        np.empty((6, 6)),
    )  # fmt: skip


@lean
def gather(nodes, new, old, out):
    """Write the increment of the coefficients (8, 3, K) of an element."""
    for a in range(8):
        n = nodes[a]
        for i in range(3):
            for k in range(out.shape[2]):
                out[a, i, k] = new[n, i, k] - old[n, i, k]


@njit
def soil_forces(soil, old, new, regime, with_tangent, tangent, force):
    """Add the forces of the soil to force (n, 3, K); ``old`` and ``new`` are SoilState.

    With ``with_tangent``, tangent (ne, 4 M, 6, 6) gets what the points that are not elastic have beyond the elastic
    tangent, transposed, times the volume of the point. Returns -1, or the number of an element whose law did not
    converge.
    """
    room, states, out = scratch(soil.waves.shape[1]), (old, new), (regime, tangent, force)
    for e in range(soil.quads.shape[0]):
        gather(soil.quads[e], new.displacement, old.displacement, room.move)
        for g in range(4):
            if _point_forces(soil, (e, g), states, with_tangent, out, room) != OK:
                return e
    return -1


@lean
def _point_forces(soil, at, states, with_tangent, out, room):
    """Add the forces of all azimuths of a point of the section, see `soil_forces`; return the status of the law."""
    (e, g), (old, new), (regime, tangent, force) = at, states, out
    n_azimuths, (_, strains, stresses, strain, change, c) = soil.waves.shape[0], room
    row, code, volume = row_of(soil.moduli, g), soil.law[e], soil.weight * soil.volume[e, g]
    p, moduli = soil.parameters[e, row], soil.moduli[e, row]
    amplitudes(soil.gradient[e, g], room.move, soil.numbers, strains)  # E_k
    stresses[:] = 0.0
    for j in range(n_azimuths):
        point = g * n_azimuths + j
        strain_at(strains, soil.waves[j], strain)  # sum of E_k cos or sin(k theta_j)
        before = Point(old.stress[e, point], old.history[e, point])
        after = Point(new.stress[e, point], new.history[e, point])
        status, what = update_soil(code, p, strain, before, after, c, with_tangent)
        if status != OK:
            return status
        regime[e, point] = what
        if soil.relaxed < 1.0 and what != REGIME_ELASTIC:
            # Duvaut & Lions 1972
            relax_soil(code, p, moduli, soil.relaxed, strain, before, after, c, with_tangent)
        for i in range(6):
            # the initial stress is in equilibrium (docs/theory/soil.md)
            change[i] = after.stress[i] - soil.initial_stress[e, point, i]
        add_amplitudes(change, soil.waves[j], volume, stresses)  # sum over azimuths: int ... dtheta
        if with_tangent and what != REGIME_ELASTIC:
            subtract_elastic_tangent(moduli[0], moduli[1], c)  # C* - C: C is in the factors of the soil at rest
            for i in range(6):
                for m in range(6):
                    tangent[e, point, m, i] = volume * soil.relaxed * c[i, m]
    add_force(soil.gradient[e, g], stresses, soil.numbers, soil.quads[e], force)
    return OK


def soil_forces_of(law: np.ndarray) -> Any:
    """Return `soil_forces`, compiled for the laws of these codes."""
    return of_laws(tuple(np.unique(law).tolist()), _point_forces, soil_forces)


@njit
def plastic_product(soil, regime, tangent, x, out):
    """Add to out (n, 3, K) what the soil's tangent has beyond the elastic one, times x (n, 3, K)."""
    room = scratch(soil.waves.shape[1])
    for e in range(soil.quads.shape[0]):
        element_product(soil, e, regime[e], tangent[e], x, out, room)


@lean
def element_product(soil, e, regime, tangent, x, out, room):
    """Add the product of one element, see `plastic_product`."""
    n_azimuths, (move, strains, stresses, strain, stress, _) = soil.waves.shape[0], room
    yields = False
    for point in range(len(regime)):
        yields |= regime[point] != REGIME_ELASTIC
    if not yields:
        return
    for a in range(8):
        n = soil.quads[e, a]
        for i in range(3):
            for k in range(move.shape[2]):
                move[a, i, k] = x[n, i, k]
    for g in range(4):
        amplitudes(soil.gradient[e, g], move, soil.numbers, strains)
        stresses[:] = 0.0
        for j in range(n_azimuths):
            point = g * n_azimuths + j
            if regime[point] == REGIME_ELASTIC:
                continue
            strain_at(strains, soil.waves[j], strain)
            _times(tangent[point], strain, stress)
            add_amplitudes(stress, soil.waves[j], 1.0, stresses)
        add_force(soil.gradient[e, g], stresses, soil.numbers, soil.quads[e], out)


@lean
def _times(transposed, vector, out):
    """Write the product (6,) of a matrix, transposed (6, 6), and a vector (6,); sums are numbers, for vectors."""
    t, a, b, c, d, e, f = transposed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for m in range(6):
        x = vector[m]
        a += t[m, 0] * x
        b += t[m, 1] * x
        c += t[m, 2] * x
        d += t[m, 3] * x
        e += t[m, 4] * x
        f += t[m, 5] * x
    out[0], out[1], out[2], out[3], out[4], out[5] = a, b, c, d, e, f


@njit
def soil_work(soil, old, new):
    """Return (stored, dissipated, initial) work of a step in J; ``old`` and ``new`` are SoilState."""
    n_azimuths, n_waves = soil.waves.shape[0], soil.waves.shape[1]
    move, strains, strain = np.empty((8, 3, n_waves)), np.empty((n_waves, 6)), np.empty(6)
    stored, dissipated, initial = 0.0, 0.0, 0.0
    for e in range(soil.quads.shape[0]):
        gather(soil.quads[e], new.displacement, old.displacement, move)
        for g in range(4):
            row = row_of(soil.moduli, g)
            bulk, shear = soil.moduli[e, row, 0], soil.moduli[e, row, 1]
            amplitudes(soil.gradient[e, g], move, soil.numbers, strains)
            volume = soil.weight * soil.volume[e, g]
            for j in range(n_azimuths):
                point = g * n_azimuths + j
                strain_at(strains, soil.waves[j], strain)
                done, begun = 0.0, 0.0
                for i in range(6):
                    # mean stress times strain: see balance.energy
                    done += 0.5 * (old.stress[e, point, i] + new.stress[e, point, i]) * strain[i]
                    begun += soil.initial_stress[e, point, i] * strain[i]
                change = stored_density(bulk, shear, new.stress[e, point])
                change -= stored_density(bulk, shear, old.stress[e, point])
                stored += volume * change
                dissipated += volume * (done - change)
                initial += volume * begun
    return stored, dissipated, initial


@njit
def strain_step(soil, e, point, old, new):
    """Return the strain increment (6,) of a point between two displacements."""
    n_azimuths, n_waves = soil.waves.shape[0], soil.waves.shape[1]
    move, strains, strain = np.empty((8, 3, n_waves)), np.empty((n_waves, 6)), np.empty(6)
    gather(soil.quads[e], new, old, move)
    amplitudes(soil.gradient[e, point // n_azimuths], move, soil.numbers, strains)
    strain_at(strains, soil.waves[point % n_azimuths], strain)
    return strain


@lean
def _jump(s, k, displacement, border, out):
    """Write the jump (3,) of station k in its frame: soil minus body."""
    node = s.node[k]
    for i in range(3):
        out[i] = 0.0
        for c in range(3):
            for m in range(displacement.shape[2]):
                out[i] += s.operator[k, i, c, m] * displacement[node, c, m]  # frame u(theta)
        for j in range(len(border)):
            out[i] -= s.body[k, i, j] * border[j]  # - R q


@njit
def station_jumps(s, displacement, border):
    """Return the jumps (ns, 3) in m of all stations in their frames."""
    out = np.empty((len(s.area), 3))
    for k in range(len(s.area)):
        _jump(s, k, displacement, border, out[k])
    return out


@lean
def _add_traction(s, k, traction, free, border):
    """Add the change of contact force of station k since the initial state."""
    node = s.node[k]
    for i in range(3):
        force = s.area[k] * (traction[i] + (s.initial_pressure[k] if i == 0 else 0.0))  # traction is (-p, tau_1, tau_2)
        for c in range(3):
            for m in range(s.operator.shape[3]):
                free[node, c, m] += s.operator[k, i, c, m] * force
        for j in range(len(border)):
            border[j] -= s.body[k, i, j] * force  # reaction on the body: -R^T f


@njit
def add_tractions(s, traction, free, border):
    """Add the changes of the contact forces of all stations, for tractions (ns, 3)."""
    for k in range(len(s.area)):
        _add_traction(s, k, traction[k], free, border)


@njit
def contact_forces(s, old, new, contact_state, free, border):
    """Add the contact forces of the law; ``old`` and ``new`` are ContactState."""
    jump, jump_old = np.empty(3), np.empty(3)
    for k in range(len(s.area)):
        _jump(s, k, new.displacement, new.border, jump)
        _jump(s, k, old.displacement, old.border, jump_old)
        slide = Slide(jump, jump_old, old.traction[k], s.initial_pressure[k])
        contact_state[k] = update_contact(s.law[k], s.parameters[k], slide, new.traction[k])
        _add_traction(s, k, new.traction[k], free, border)


@njit
def linear_contact(s, old, new, iterate, free, border):
    """Add the linearised contact forces; see kernels_stations.station_tangent. ``iterate`` gets the tangents."""
    jump, jump_old, guess = np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(s.area)):
        _jump(s, k, new.displacement, new.border, jump)
        _jump(s, k, old.displacement, old.border, jump_old)
        guess_traction(iterate, k, new.traction[k], jump, guess)  # tau_k of Hueeber et al. 2008 at the present jump
        slide = Slide(jump, jump_old, old.traction[k], s.initial_pressure[k])
        linearise_contact(s.law[k], s.parameters[k], slide, guess, iterate.traction[k], iterate.tangent[k])
        for i in range(3):
            iterate.jump[k, i] = jump[i]
        _add_traction(s, k, iterate.traction[k], free, border)


@njit
def contact_matrix(s, tangent, place, out):
    """Add the tangents (ns, 3, 3) of the stations to out (m + nb, m + nb): the interface, then the border.

    ``place`` (ns, 3, K) is where a coefficient stands in the interface, -1 where it is held.
    """
    n_waves, n_border = s.operator.shape[3], s.body.shape[2]
    m = out.shape[0] - n_border
    width = 3 * n_waves + n_border
    row, at = np.zeros((3, width)), np.zeros(width, dtype=np.int64)
    for k in range(len(s.area)):
        n = 0
        for c in range(3):
            for w in range(n_waves):
                if place[k, c, w] >= 0:
                    at[n] = place[k, c, w]
                    for i in range(3):
                        row[i, n] = s.operator[k, i, c, w]
                    n += 1
        for j in range(n_border):
            at[n] = m + j
            for i in range(3):
                row[i, n] = -s.body[k, i, j]
            n += 1
        for a in range(n):
            for i in range(3):
                left = 0.0
                for h in range(3):
                    left += row[h, a] * tangent[k, h, i]  # operator^T tangent operator, area by area
                left *= s.area[k]
                if left != 0.0:
                    for b in range(n):
                        out[at[a], at[b]] += left * row[i, b]
