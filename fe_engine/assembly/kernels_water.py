# SPDX-License-Identifier: MIT
"""Compiled loops of the water: elements, stations and faces of the film.

Rows of the water are volumes that leave a node over the time step, times -scale (Pa/m): together with pressures in
units of scale this makes the coupling of forces and volumes symmetric, and gives the rows the size of forces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fe_engine.assembly.pattern import Pattern
from fe_engine.assembly.scatter import add_border, add_dof, add_entry
from fe_engine.compiled import njit
from fe_engine.contact import flow
from fe_engine.elements.interface import GAUSS_SHAPES, film_areas
from fe_engine.model import Model

_transmissivity, _exchange = flow.transmissivity, flow.exchange
_PRESSURE = 3  # the fourth dof of a node


class Step(NamedTuple):
    """Length of the time step in s, and scale in Pa/m of the unknowns of the water (see model.Water)."""

    time: float
    scale: float


class PackedFilm(NamedTuple):
    """The film as arrays: see interface.Film and pattern.Pattern; ``law`` is (D_0, T_w, mu_w, sealed).

    ``station_area`` (ns,) m2 is the area of every station that has a film.
    """

    station_nodes: np.ndarray
    station_offset: np.ndarray
    station_area: np.ndarray
    weight: np.ndarray
    face_nodes: np.ndarray
    face_offset: np.ndarray
    corners: np.ndarray
    gradient: np.ndarray
    area: np.ndarray
    law: np.ndarray


def pack_film(model: Model, pattern: Pattern) -> PackedFilm:
    """Return the film of a model as contiguous arrays; a model with water must have one."""
    film = model.water.film  # type: ignore[union-attr]
    assert film is not None
    return PackedFilm(
        pattern.station_film, pattern.film_offset, film_areas(model.stations.area, film.wetted),  # type: ignore[union-attr]
        film.weight.astype(float), pattern.face_nodes, pattern.face_offset,
        film.corners.astype(np.int64), np.ascontiguousarray(film.gradient), np.ascontiguousarray(film.area),
        np.array([film.residual_aperture, film.transfer, film.viscosity, float(film.sealed)]),
    )  # fmt: skip


@njit
def soil_water(hexes, pores, step, old, new, scatter, forces):
    """Add the water of all elements; ``pores`` is (H, S M + T, V, coupling), old and new (displacement, pressure).

    Returns the sum of the squares of what the elements' volumes have changed and what flows through their corners, m6.
    """
    seepage, storage, volume, coupling = pores
    dt, scale = step
    square = 0.0
    for e in range(hexes.shape[0]):
        nodes = hexes[e]
        change, total, mean = 0.0, 0.0, 0.0
        for a in range(8):
            n = nodes[a]
            mean += volume[e, a] * new[1][n]  # int p dV
            for i in range(3):
                total += coupling[e, a, i] * new[0][n, i]
                change += coupling[e, a, i] * (new[0][n, i] - old[0][n, i])  # dtheta, mean of the element
        square += (volume[e].sum() * total) ** 2
        for a in range(8):
            n = nodes[a]
            leaves, flows = volume[e, a] * change, 0.0  # Biot 1941: V_a dtheta + ...
            for b in range(8):
                p_new, p_old = new[1][nodes[b]], old[1][nodes[b]]
                leaves += storage[e, a, b] * (p_new - p_old)  # (S M + T) dp
                flows += dt * seepage[e, a, b] * p_new  # dt H p, backward Euler
            square += flows * flows
            add_dof(scatter, n, _PRESSURE, -scale * (leaves + flows), forces)
            for i in range(3):
                add_dof(scatter, n, i, -coupling[e, a, i] * mean, forces)  # f_a = -mean(grad N_a) int p dV
    return square


@njit
def soil_water_tangent(hexes, pores, shares, scale, scatter, offset, targets):
    """Add the tangent of the elements' water, which is constant: ``shares`` of storage and coupling, and of seepage."""
    seepage, storage, volume, coupling = pores
    still, flowing = shares
    for e in range(hexes.shape[0]):
        for a in range(8):
            n = hexes[e, a]
            for b in range(8):
                m, place = hexes[e, b], offset[e, a, b]
                flow_ab = still * storage[e, a, b] + flowing * seepage[e, a, b]
                add_entry(scatter, n, _PRESSURE, m, _PRESSURE, place, -scale * scale * flow_ab, targets)
                if still == 0.0:
                    continue
                for i in range(3):
                    force, squeezed = coupling[e, a, i] * volume[e, b], coupling[e, b, i] * volume[e, a]
                    add_entry(scatter, n, i, m, _PRESSURE, place, -scale * still * force, targets)
                    add_entry(scatter, n, _PRESSURE, m, i, place, -scale * still * squeezed, targets)


@njit
def _pressures(s, f, k, pressure):
    """Return the pressure on side 1, in the film and on side 2 of a station, and whether side 2 holds water."""
    nn = s.nodes.shape[1]
    p1, p2, p3, porous = 0.0, 0.0, 0.0, False
    for a in range(nn):
        share = s.weight[k, a]
        if share > 0.0:
            p1 += share * pressure[s.nodes[k, a]]
        elif share < 0.0:
            p2 -= share * pressure[s.nodes[k, a]]
            porous = f.law[3] == 0.0
    for c in range(f.weight.shape[1]):
        p3 += f.weight[k, c] * pressure[f.station_nodes[k, nn + c]]
    return p1, p3, p2, porous


@njit
def _station_shares(s, f, k, side_1, side_2, film):
    """Write the shares of the station's nodes (mesh, then film) in p1, p2 and p3."""
    nn = s.nodes.shape[1]
    side_1[:] = 0.0
    side_2[:] = 0.0
    film[:] = 0.0
    for a in range(nn):
        side_1[a] = max(s.weight[k, a], 0.0)
        side_2[a] = max(-s.weight[k, a], 0.0)
    for c in range(f.weight.shape[1]):
        film[nn + c] = f.weight[k, c]


@njit
def station_water(s, f, step, gaps, pressure, scatter, forces, targets):
    """Add film pressure on both faces, storage of the gap and transfer to the sides; gaps are (old, new), (ns,) m.

    Returns the sum over the stations of the squared volumes of the gap and of the transfer, m6.
    """
    size, scale = f.station_nodes.shape[1], step.scale
    gap_old, gap = gaps
    side_1, side_2, film = np.empty(size), np.empty(size), np.empty(size)
    square = 0.0
    for k in range(len(s.area)):
        p1, p3, p2, porous = _pressures(s, f, k, pressure)
        _station_shares(s, f, k, side_1, side_2, film)
        transfer = step.time * f.law[1]
        second = transfer if porous else 0.0
        # Cerfontaine et al. 2018, Eqs. 6, 7, 9
        to_film, to_side_2, stored = _exchange(transfer, second, (p1, p3, p2), gap_old[k], gap[k])
        square += f.station_area[k] ** 2 * (gap[k] ** 2 + to_film**2 + to_side_2**2)
        for a in range(size):
            leaves = side_1[a] * to_film - side_2[a] * to_side_2 + film[a] * (stored - to_film + to_side_2)
            add_dof(scatter, f.station_nodes[k, a], _PRESSURE, -scale * f.station_area[k] * leaves, forces)
        # Cerfontaine et al. 2018, Eq. 8: p_N = p' + p_w, open or closed
        _press(s, k, f.station_area[k] * p3, scatter, forces)
        if targets.with_tangent:
            rates = transfer, second, scale
            _station_tangent(s, f, k, rates, gap[k] > 0.0, (side_1, side_2, film), scatter, targets)
    return square


@njit
def _press(s, k, push, scatter, forces):
    """Add the force (N) of the film pressure on the two faces of a station."""
    for i in range(3):
        force = -push * s.frame[k, 0, i]
        for a in range(s.nodes.shape[1]):
            add_dof(scatter, s.nodes[k, a], i, s.weight[k, a] * force, forces)
        for j in range(len(forces.border)):
            forces.border[j] -= s.body[k, i, j] * force


@njit
def _station_tangent(s, f, k, rates, is_open, shares, scatter, targets):
    """Add the tangent of station k; rates are the transfer to side 1 and to side 2, and the scale."""
    transfer_1, transfer_2, scale = rates
    nn, size = s.nodes.shape[1], f.station_nodes.shape[1]
    side_1, side_2, film = shares
    n_border = targets.corner.shape[0]
    for a in range(size):
        row = f.station_nodes[k, a]
        for b in range(size):
            column = f.station_nodes[k, b]
            first = (side_1[a] - film[a]) * transfer_1 * (side_1[b] - film[b])  # d(to_film): p1 - p3
            second = (side_2[a] - film[a]) * transfer_2 * (side_2[b] - film[b])  # d(to_side_2): p3 - p2
            value = -scale * scale * f.station_area[k] * (first + second)
            if value != 0.0:
                add_entry(scatter, row, _PRESSURE, column, _PRESSURE, f.station_offset[k, a, b], value, targets)
        if film[a] == 0.0:
            continue
        share = -scale * f.station_area[k] * film[a]
        for b in range(nn):
            column = s.nodes[k, b]
            for i in range(3):
                value = share * s.frame[k, 0, i] * s.weight[k, b]
                if value == 0.0:
                    continue
                add_entry(scatter, column, i, row, _PRESSURE, f.station_offset[k, b, a], value, targets)
                if is_open:
                    add_entry(scatter, row, _PRESSURE, column, i, f.station_offset[k, a, b], value, targets)
        for m in range(n_border):
            value = 0.0
            for i in range(3):
                value -= share * s.frame[k, 0, i] * s.body[k, i, m]
            add_border(scatter, row, _PRESSURE, m, value if is_open else 0.0, value, targets)


@njit
def face_water(s, f, step, gap, pressure, scatter, forces, targets):
    """Add the flow along the film; return the sum of the squared flows of its faces, m6."""
    dt, scale = step
    square = 0.0
    conductance, slope = np.empty(4), np.empty(4)
    for k in range(len(f.area)):
        for c in range(4):
            # Cerfontaine et al. 2018, Eq. 10, at the corner's gap
            conductance[c], slope[c] = _transmissivity(f.law[0], gap[f.corners[k, c]], f.law[2])
        for g in range(4):
            mean = 0.0
            for c in range(4):
                mean += GAUSS_SHAPES[g, c] * conductance[c]
            flux = np.zeros(3)
            for b in range(4):
                for i in range(3):
                    flux[i] += f.gradient[k, g, b, i] * pressure[f.face_nodes[k, b]]  # grad p3
            for a in range(4):
                row, along = f.face_nodes[k, a], 0.0
                for i in range(3):
                    along += f.gradient[k, g, a, i] * flux[i]  # grad N_a . grad p3: Cerfontaine et al. 2018, Eq. 5
                share = -scale * dt * f.area[k, g]
                add_dof(scatter, row, _PRESSURE, share * mean * along, forces)
                square += (share / scale * mean * along) ** 2
                if not targets.with_tangent:
                    continue
                for b in range(4):
                    product = 0.0
                    for i in range(3):
                        product += f.gradient[k, g, a, i] * f.gradient[k, g, b, i]
                    add_entry(scatter, row, _PRESSURE, f.face_nodes[k, b], _PRESSURE, f.face_offset[k, a, b],
                         scale * share * mean * product, targets)  # fmt: skip
                for c in range(4):
                    if slope[c] > 0.0:
                        _add_gap(s, f, k, c, a, share * GAUSS_SHAPES[g, c] * slope[c] * along, scatter, targets)
    return square


@njit
def _add_gap(s, f, k, c, a, value, scatter, targets):
    """Couple film node a of face k with the motion that opens the gap at its corner c."""
    nn = s.nodes.shape[1]
    station, row = f.corners[k, c], f.face_nodes[k, a]
    for b in range(nn):
        for i in range(3):
            part = value * s.frame[station, 0, i] * s.weight[station, b]
            if part != 0.0:
                column, place = s.nodes[station, b], 4 + c * nn + b
                add_entry(scatter, row, _PRESSURE, column, i, f.face_offset[k, a, place], part, targets)
    for m in range(targets.corner.shape[0]):
        part = 0.0
        for i in range(3):
            part -= value * s.frame[station, 0, i] * s.body[station, i, m]
        add_border(scatter, row, _PRESSURE, m, part, 0.0, targets)
