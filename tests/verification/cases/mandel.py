# SPDX-License-Identifier: MIT
"""Mandel's problem: a strip between smooth rigid plates, loaded at once and drained at its sides.

The pressure at the centre first rises above its initial value p0 = F/(2 a) (Mandel-Cryer effect), since the sides
drain and soften first. With T = c t/a2 and incompressible water (Mandel 1953; Cheng & Detournay 1988):

    p(x)/p0 = sum 2 sin(A)/(A - sin A cos A) (cos(A x/a) - cos A) exp(-A2 T),   tan A = (1 - nu)/(1/2 - nu) A

One quarter of the strip, of width a in x, in plane strain; its solution does not vary along z: one cell is enough.
"""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from fe_engine.solve.newton import Newton
from tests.verification.blocks import block_model, box, followers, loaded, make_newton
from tests.verification.rows import Row
from tests.verification.water import consolidation, consolidation_time, elastic, fill, follow

NU, P0 = 0.2, 100.0e3
WIDTH, SIDE = 1.0, 0.05
# Centre p/p0 as printed in the reference table, with the peak and its time
CENTRE = {0.01: 1.0438, 0.1: 1.0954, 0.5: 0.5928, 1.0: 0.2588}
PEAK, PEAK_TIME = 1.107, 0.072
# Time factor: number of equal steps that lead to it
PLAN = {0.01: 20, PEAK_TIME: 50, 0.1: 20, 0.5: 160, 1.0: 200}
CELLS = 32
_SOURCE = "Mandel 1953, series"


def closed_form(time: float, x: float = 0.0, poisson: float = NU) -> float:
    """p/p0 at x/a and a time factor."""
    slope = (1.0 - poisson) / (0.5 - poisson)
    # one root in each quarter turn where the tangent is positive; 0 itself is none
    ends = [(max(n * np.pi, 0.1), (n + 0.5) * np.pi) for n in range(400)]
    root = np.array([brentq(lambda a: np.sin(a) - slope * a * np.cos(a), *pair) for pair in ends])
    share = 2.0 * np.sin(root) / (root - np.sin(root) * np.cos(root))
    return float(np.sum(share * (np.cos(root * x) - np.cos(root)) * np.exp(-(root**2) * time)))


def make_strip(cells: int) -> Newton:
    """Quarter of the strip; its top plate moves down with border dof 0, the side x = a is drained."""
    mesh = box((cells, 1, 1), (WIDTH, SIDE, SIDE))
    fixed = np.zeros(mesh.nodes.shape, dtype=bool)
    fixed[:, 0] = mesh.nodes[:, 0] == 0.0
    fixed[:, 1] = True
    fixed[:, 2] = mesh.nodes[:, 2] == SIDE
    model = block_model(mesh, elastic(NU), fixed, 1)
    model.followers = followers(np.flatnonzero(mesh.nodes[:, 2] == 0.0), 2, 0)
    fill(model, mesh.nodes[:, 0] == WIDTH, poisson=NU)
    return make_newton(model)


def centre_pressure(cells: int, plan: dict[float, int]) -> dict[float, float]:
    """p/p0 at the centre at the time factors of the plan (see water.consolidation); 0 is just after the load."""
    newton = make_strip(cells)
    # half of the load on the plate is carried by the water at first
    stages = consolidation(loaded([2.0 * P0 * WIDTH * SIDE]), consolidation_time(WIDTH, NU), plan)
    found = [float(state.committed.pressure[0]) / P0 for state, _ in follow(newton, stages)]
    return dict(zip([0.0, *plan], found, strict=True))


@cache
def rows() -> tuple[Row, ...]:
    """Centre pressure just after the load, at the four times, and at the peak."""
    found = centre_pressure(CELLS, PLAN)
    case = "Mandel's strip, nu 0.2"
    return (
        Row(case, "p/p0 at the centre, just after the load", "", found[0.0], 1.0, "undrained", 0.01),
        *(Row(case, f"p/p0 at the centre, T = {t:g}", "", found[t], p, _SOURCE, 0.01) for t, p in CENTRE.items()),
        Row(case, f"peak of p/p0 at the centre, T = {PEAK_TIME:g}", "", found[PEAK_TIME], PEAK, _SOURCE, 0.01),
    )
