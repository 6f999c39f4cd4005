# SPDX-License-Identifier: MIT
"""Terzaghi's one-dimensional consolidation: a column drained at its top, closed at its base, loaded at once.

With T = c t/H2, M = pi (2 k + 1)/2 and c = mobility * oedometric modulus (incompressible water):

    U = settlement/(q H/E_oed) = 1 - sum 2/M2 exp(-M2 T),    p(base)/q = sum (2/M) sin(M) exp(-M2 T)

(Terzaghi 1923; Verruijt 2013, Theory and Problems of Poroelasticity). The order in the cell size is
taken from the difference with the same series whose modes decay as backward Euler lets them, 1/(1 + M2 dT) a step:
no error of time remains in it. The order in the step is taken on a mesh whose own error is 100 times less.
"""

from collections.abc import Iterable
from functools import cache

import numpy as np

from fe_engine.solve.newton import Newton
from tests.verification.blocks import box, loaded, make_newton
from tests.verification.rows import Row, fitted_rate
from tests.verification.water import (
    consolidation,
    consolidation_time,
    fill,
    follow,
    implicit_decay,
    oedometer,
    oedometric_modulus,
)

HEIGHT, WIDTH, LOAD = 2.0, 0.1, 100.0e3
# As printed in the reference table
SETTLEMENT = {
    0.01: 0.11284, 0.05: 0.25231, 0.1: 0.35682, 0.197: 0.50034, 0.3: 0.61324, 0.5: 0.76395, 0.848: 0.89998,
    1.0: 0.93126, 2.0: 0.99417,
}  # fmt: skip
BASE_PRESSURE = {0.05: 0.99687, 0.1: 0.94931, 0.2: 0.77231, 0.5: 0.37078, 1.0: 0.10798}
# Time factor: number of equal steps that lead to it. The base pressure at T = 1 needs most of them.
PLAN = {0.01: 40, 0.05: 40, 0.1: 25, 0.197: 50, 0.2: 2, 0.3: 50, 0.5: 100, 0.848: 170, 1.0: 70, 2.0: 50}
CELLS = 40
_SOURCE = "Terzaghi 1923, series"


def closed_form(time: float, steps: Iterable[float] | None = None) -> tuple[float, float]:
    """U and p(base)/q at a time factor; with steps, as backward Euler finds them on a perfect mesh."""
    mode = np.pi * (np.arange(20_000) + 0.5)
    left = np.exp(-(mode**2) * time) if steps is None else implicit_decay(mode**2, steps)
    return float(1.0 - np.sum(2.0 / mode**2 * left)), float(np.sum(2.0 / mode * np.sin(mode) * left))


def make_column(cells: int) -> Newton:
    """Column of square cross section whose top moves down with border dof 0; the top is drained."""
    mesh = box((1, 1, cells), (WIDTH, WIDTH, HEIGHT))
    model, top = oedometer(mesh)
    fill(model, top)
    return make_newton(model)


def consolidate(cells: int, plan: dict[float, int]) -> dict[float, tuple[float, float]]:
    """U and p(base)/q of the column at the time factors of the plan (see water.consolidation)."""
    newton = make_column(cells)
    stages = consolidation(loaded([LOAD * WIDTH**2]), consolidation_time(HEIGHT), plan)
    final = LOAD * HEIGHT / oedometric_modulus()
    found = [(s.committed.border[0] / final, s.committed.pressure[-1] / LOAD) for s, _ in follow(newton, stages)]
    return dict(zip(plan, found[1:], strict=True))


@cache
def rows() -> tuple[Row, ...]:
    """Degree of consolidation and base pressure, and the orders in cell size and step."""
    found = consolidate(CELLS, PLAN)
    case = "Terzaghi's consolidation"
    return (
        *(Row(case, f"U at T = {t:g}", "", found[t][0], u, _SOURCE, 0.01) for t, u in SETTLEMENT.items()),
        *(Row(case, f"p/q, base, T = {t:g}", "", found[t][1], p, _SOURCE, 0.01) for t, p in BASE_PRESSURE.items()),
        *_rates(case),
    )


def _rates(case: str) -> list[Row]:
    time, steps = 0.5, 10
    exact = closed_form(time, [time / steps] * steps)
    cells = (8, 16, 32)
    coarse = np.array([consolidate(n, {time: steps})[time] for n in cells]) - exact
    counts = (10, 20, 40)
    late = np.array([consolidate(64, {time: n})[time] for n in counts]) - closed_form(time)
    by_size, by_step = 1.0 / np.array(cells), 1.0 / np.array(counts)
    return [
        Row(case, "order in h of the error of U", "", fitted_rate(by_size, coarse[:, 0]), 2.0, "second order", 0.1),
        Row(case, "order in h of the error of p", "", fitted_rate(by_size, coarse[:, 1]), 2.0, "second order", 0.1),
        Row(case, "order in dt of the error of U", "", fitted_rate(by_step, late[:, 0]), 1.0, "first order", 0.1),
        Row(case, "order in dt of the error of p", "", fitted_rate(by_step, late[:, 1]), 1.0, "first order", 0.1),
    ]
