# SPDX-License-Identifier: MIT
"""Compiled loops over the film of a Fourier model: exchange with the soil, storage of gaps, flow along the film.

Rows of the water are volumes times -scale, pressures count in units of scale: see kernels_water.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from fe_engine.assembly.kernels_water import Step
from fe_engine.compiled import njit
from fe_engine.contact import flow
from fe_engine.elements import fourier as elements
from fe_engine.elements.interface import film_areas
from fe_engine.fourier_model import FourierModel

_transmissivity, _exchange = flow.transmissivity, flow.exchange


class PackedFilm(NamedTuple):
    """The film as arrays: see fourier_model.RingFilm; pressures are numbered through, the soil's first.

    soil, film (ns, 2) pressures of each station, station_area (ns,) m2 of film there, share (ns, 2, K) the pressures'
    shares at its azimuth; ends (m, 2) pressures
    and gradient (m, 2, 2, K), along the line and around, of each point, station (m,), area (m,); law (D_0, T_w, mu_w).
    """

    soil: np.ndarray
    film: np.ndarray
    station_area: np.ndarray
    share: np.ndarray
    ends: np.ndarray
    gradient: np.ndarray
    station: np.ndarray
    area: np.ndarray
    law: np.ndarray


class FilmState(NamedTuple):
    """State on which the film's tangent depends: openings (ns,) in m, pressures (np, K) in Pa, and the time step."""

    gap: np.ndarray
    pressure: np.ndarray
    step: Step


def pack_film(model: FourierModel) -> PackedFilm | None:
    """Return the film of a model as contiguous arrays; None where there is none."""
    film = None if model.water is None else model.water.film
    if film is None:
        return None
    first = model.n_pressures - film.n_nodes
    wave = elements.waves(model.stations.azimuth, model.harmonics, model.whole)
    at = wave[film.station]
    along = film.slope[:, :, None] * at[:, None, :, 0]  # dp/ds of cos(k theta), or sin(k theta)
    around = film.over_radius[:, :, None] * (-model.numbers * at[..., 1])[:, None]  # (dp/dtheta)/r
    return PackedFilm(
        film.soil[film.nodes].astype(np.int64), (first + film.nodes).astype(np.int64),
        film_areas(model.stations.area, film.wetted),
        film.weight[:, :, None] * wave[:, None, :, 0], (first + film.ends).astype(np.int64),
        np.ascontiguousarray(np.stack([along, around], axis=1)), film.station.astype(np.int64),
        np.ascontiguousarray(film.area), np.array([film.residual_aperture, film.transfer, film.viscosity]),
    )  # fmt: skip


def transfer_matrix(film: PackedFilm, n: int) -> csr_matrix:
    """Return what leaves each pressure by transfer, (n K, n K) in m3/(Pa s)."""
    waves, area = film.share.shape[2], film.station_area
    nodes = np.concatenate([film.soil, film.film], axis=1)
    share = np.concatenate([film.share, -film.share], axis=1).reshape(len(area), -1)
    at = (nodes[:, :, None] * waves + np.arange(waves)).reshape(len(area), -1)
    # T_w A (p1 - p3): Cerfontaine et al. 2018, Eq. 6
    value = (film.law[1] * area)[:, None, None] * share[:, :, None] * share[:, None, :]
    row, column, value = np.broadcast_arrays(at[:, :, None], at[:, None, :], value)
    return coo_matrix((value.ravel(), (row.ravel(), column.ravel())), shape=(n * waves, n * waves)).tocsr()


@njit
def _at_station(nodes, share, pressure):
    """Return the pressure at a station from those of two nodes (np, K)."""
    pressure_there = 0.0
    for a in range(2):
        for m in range(share.shape[1]):
            pressure_there += share[a, m] * pressure[nodes[a], m]
    return pressure_there


@njit
def station_water(s, f, step, gaps, pressure, force, border, rows):
    """Add film pressure on both faces, storage of gaps (old, new) and transfer; ``s`` is fourier_kernels.Contact.

    Writes to the forces (n, 3, K) and (nb,) and to the rows of the water (np, K). Returns the sum over the stations of
    the squared volumes of gap and transfer, m6.
    """
    square, transfer = 0.0, step.time * f.law[1]
    gap_old, gap = gaps
    for k in range(len(s.area)):
        p1, p3 = _at_station(f.soil[k], f.share[k], pressure), _at_station(f.film[k], f.share[k], pressure)
        # Cerfontaine et al. 2018, Eqs. 6 and 9; side 2 is impervious
        to_film, _, stored = _exchange(transfer, 0.0, (p1, p3, 0.0), gap_old[k], gap[k])
        square += f.station_area[k] ** 2 * (gap[k] ** 2 + to_film**2)
        size = -step.scale * f.station_area[k]
        for a in range(2):
            for m in range(f.share.shape[2]):
                rows[f.soil[k, a], m] += size * f.share[k, a, m] * to_film
                rows[f.film[k, a], m] += size * f.share[k, a, m] * (stored - to_film)
        press = -f.station_area[k] * p3  # Cerfontaine et al. 2018, Eq. 8: p_N = p' + p_w, open or closed
        for c in range(3):
            for m in range(s.operator.shape[3]):
                force[s.node[k], c, m] += s.operator[k, 0, c, m] * press
        for j in range(len(border)):
            border[j] -= s.body[k, 0, j] * press
    return square


@njit
def line_water(f, step, gap, pressure, rows):
    """Add the flow along the film; return the sum of the squared flows of its points, m6."""
    square = 0.0
    for q in range(len(f.area)):
        conductance, _ = _transmissivity(f.law[0], gap[f.station[q]], f.law[2])
        for i in range(2):
            # Cerfontaine et al. 2018, Eq. 5, along the line and around
            flux = step.time * f.area[q] * conductance * _at_station(f.ends[q], f.gradient[q, i], pressure)
            for a in range(2):
                for m in range(rows.shape[1]):
                    leaves = f.gradient[q, i, a, m] * flux
                    rows[f.ends[q, a], m] -= step.scale * leaves
                    square += leaves * leaves
    return square


@njit
def film_matrix(s, f, state, place, film_place, out):
    """Add the tangent of the film to out, whose equations are the interface's and then the border's.

    Transfer between the soil and the film, which never changes, is not in it. ``place`` (ns, 3, K) and ``film_place``
    (np, K) are where displacements and pressures of the film stand in the interface, -1 where they are held.
    """
    n_waves, n_border = s.operator.shape[3], s.body.shape[2]
    first, scale = out.shape[0] - n_border, state.step.scale
    row, at = np.empty(3 * n_waves + n_border), np.empty(3 * n_waves + n_border, dtype=np.int64)
    for k in range(len(s.area)):
        n = _normal_motion(s, k, place, first, row, at)
        for a in range(2):
            for m in range(n_waves):
                here = film_place[f.film[k, a], m]
                if here < 0:
                    continue
                value = -scale * f.station_area[k] * f.share[k, a, m]
                for b in range(n):
                    out[at[b], here] += value * row[b]  # film pressure on the faces
                    if state.gap[k] > 0.0:
                        out[here, at[b]] += value * row[b]  # storage of an open gap, Cerfontaine et al. 2018, Eq. 9
    for q in range(len(f.area)):
        station = f.station[q]
        conductance, slope = _transmissivity(f.law[0], state.gap[station], f.law[2])
        n = _normal_motion(s, station, place, first, row, at)
        size = -scale * state.step.time * f.area[q]
        for i in range(2):
            along = _at_station(f.ends[q], f.gradient[q, i], state.pressure)
            for a in range(2):
                for m in range(n_waves):
                    here = film_place[f.ends[q, a], m]
                    if here < 0:
                        continue
                    part = size * f.gradient[q, i, a, m]
                    for b in range(2):
                        for w in range(n_waves):
                            there = film_place[f.ends[q, b], w]
                            if there >= 0:
                                out[here, there] += scale * conductance * part * f.gradient[q, i, b, w]
                    if slope > 0.0:
                        for b in range(n):
                            # d(h^3)/dg_N, Cerfontaine et al. 2018, Eq. 10
                            out[here, at[b]] += part * slope * along * row[b]


@njit
def _normal_motion(s, k, place, first, row, at):
    """Write the derivatives of the gap of station k, and where they stand; return their number."""
    n = 0
    for c in range(3):
        for m in range(s.operator.shape[3]):
            if place[k, c, m] >= 0 and s.operator[k, 0, c, m] != 0.0:
                row[n], at[n] = s.operator[k, 0, c, m], place[k, c, m]
                n += 1
    for j in range(s.body.shape[2]):
        row[n], at[n] = -s.body[k, 0, j], first + j
        n += 1
    return n
