# SPDX-License-Identifier: MIT
"""Consolidation through an interface between soil and soil, half way down a column drained at its top.

With T_w and K_N large a closed interface is not noticed: settlement and pressures are those of the same column of
distorted hexahedra without it, at every node (as KratosGeoMechanics compares a column with its interface elements).

A film that resists as b columns of soil, 2/T_w = b gamma_w H/k, holds the lower half back. The modes sin(M z/H)
above and cot(M/2) cos(M (1 - z/H)) below have the same flow at the film and drive it by their difference where

    M tan M = 2/b;   N = 1/4 - sin M/(4 M) + cot2(M/2) (1/4 + sin M/(4 M))
    U = 1 - sum exp(-M2 T)/(M2 N),   p(base)/q = sum cot(M/2) exp(-M2 T)/(M N)

by separation of variables, as Terzaghi's series, which is the limit b -> 0.
"""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from fe_engine.solve.newton import Newton
from tests.verification.blocks import loaded, make_newton
from tests.verification.cases.patch import distorted, split
from tests.verification.films import lay_film
from tests.verification.rows import Row, worst
from tests.verification.water import (
    MOBILITY,
    consolidation,
    consolidation_time,
    fill,
    follow,
    oedometer,
    oedometric_modulus,
)

LOAD = 100.0e3
CELLS = (2, 2, 16)
# Time factor: number of equal steps that lead to it
PLAN = {0.05: 15, 0.2: 25, 1.0: 80}
# Open to the water, and stiff
OPEN, STIFF = 1.0e-2, 1.0e12


def closed_form(time: float, resistance: float) -> tuple[float, float]:
    """U and p(base)/q at a time factor, with a film that resists as so many columns."""
    start = np.pi * np.arange(300)
    found = [brentq(lambda m: m * np.sin(m) - 2.0 / resistance * np.cos(m), s, s + np.pi / 2.0) for s in start]
    mode = np.array(found)
    lower = 1.0 / np.tan(mode / 2.0)
    norm = 0.25 - np.sin(mode) / (4.0 * mode) + lower**2 * (0.25 + np.sin(mode) / (4.0 * mode))
    left = np.exp(-(mode**2) * time) / (mode * norm)
    return float(1.0 - np.sum(left / mode)), float(np.sum(lower * left))


def without_interface() -> tuple[np.ndarray, np.ndarray]:
    """Settlements (times,) in m and pressures (times, n) in Pa of the whole column."""
    model, top = oedometer(distorted(CELLS, keep_levels=True))
    fill(model, top)
    return _consolidate(make_newton(model, 1e-9))


def with_interface(transfer: float) -> tuple[np.ndarray, np.ndarray]:
    """The same of the cut column: the nodes of the whole column, then those above the interface, then the film's."""
    mesh, faces, _, twin = split(distorted(CELLS, keep_levels=True))
    model, top = oedometer(mesh)
    laid = lay_film(model, faces, 1.0e-5, transfer, twin=twin, kn=STIFF)
    fill(model, np.concatenate([top, np.zeros(laid.film.n_nodes, dtype=bool)]), film=laid.film)
    return _consolidate(make_newton(model, 1e-9))


def _consolidate(newton: Newton) -> tuple[np.ndarray, np.ndarray]:
    stages = consolidation(loaded([LOAD]), consolidation_time(1.0), PLAN)
    found = [(s.committed.border[0], s.committed.pressure.copy()) for s, _ in follow(newton, stages)][1:]
    return np.array([f[0] for f in found]), np.array([f[1] for f in found])


@cache
def rows() -> tuple[Row, ...]:
    """The column with an open interface beside the whole one, and with a film that resists as one column of soil."""
    return (*_open(), *_resisting())


def _open() -> list[Row]:
    settlement, pressure = without_interface()
    ours, found = with_interface(OPEN)
    case, source = "consolidation, open interface between soils", "the column without interface"
    whole = pressure.shape[1]
    return [
        Row.error(case, "largest difference of the settlement", worst(ours, settlement), source, 1e-3),
        Row.error(case, "largest difference of the pressure", worst(found[:, :whole], pressure), source, 1e-3),
    ]


def _resisting() -> list[Row]:
    settlement, pressure = with_interface(2.0 * MOBILITY)
    mesh, _, _, _ = split(distorted(CELLS, keep_levels=True))
    base = np.flatnonzero(mesh.nodes[:, 2] == 1.0)
    case, source = "consolidation, film that resists as the column", "separation of variables"
    found = []
    for time, s, p in zip(PLAN, settlement, pressure, strict=True):
        degree, at_base = closed_form(time, 1.0)
        ours = s * oedometric_modulus() / LOAD
        found += [
            Row(case, f"U at T = {time:g}", "", ours, degree, source, 0.01),
            Row(case, f"p/q at the base, T = {time:g}", "", p[base].mean() / LOAD, at_base, source, 0.01),
        ]
    return found
