# SPDX-License-Identifier: MIT
"""Cryer's sphere: drained at its surface, under an all-round pressure p0 that acts at once.

The pressure at the centre first rises above p0. With T = c t/R2, e = (1 - nu)/(1 - 2 nu) and incompressible water
(Cryer 1963; Verruijt 2013, Theory and Problems of Poroelasticity):

    p/p0 = e sum (sin X - X)/(e X cos(X)/2 + (e - 1) sin X) exp(-X2 T),   (1 - e X2/2) tan X = X

One eighth of the sphere; the nodes of its surface move along their radii by the same amount. The step's error at
T = 0.5 would take 1000 steps, so the figures are the limit dt -> 0 of two runs, the second with half the steps'
size (the order 1 in dt is proven on Terzaghi's column).
"""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from fe_engine.elements.interface import nodal_stations
from fe_engine.solve.newton import Newton
from tests.verification.balls import eighth_ball, faces_on
from tests.verification.blocks import block_model, elastic_soil, followers, loaded, make_newton
from tests.verification.rows import Row
from tests.verification.water import consolidation, consolidation_time, fill, follow

NU, P0 = 0.3, 100.0e3
# Centre p/p0 as printed in the reference table, with the peak and its time
CENTRE = {0.01: 1.1297, 0.05: 1.2476, 0.1: 1.0394, 0.5: 0.0630}
PEAK, PEAK_TIME = 1.249, 0.046
# Time factor: number of equal steps that lead to it, in the first of the two runs
PLAN = {0.01: 5, PEAK_TIME: 6, 0.05: 1, 0.1: 5, 0.5: 20}
CORE, SHELL = 6, 7
_SOURCE = "Cryer 1963, series"


def closed_form(time: float, poisson: float = NU) -> float:
    """p/p0 at the centre at a time factor."""
    e = (1.0 - poisson) / (1.0 - 2.0 * poisson)

    def characteristic(x: float) -> float:
        return (1.0 - 0.5 * e * x**2) * np.sin(x) - x * np.cos(x)

    # one root between each two zeros of the sine, none before the first
    root = np.array([brentq(characteristic, n * np.pi, (n + 1) * np.pi) for n in range(1, 400)])
    if characteristic(0.5) * characteristic(np.pi) < 0.0:
        root = np.append(brentq(characteristic, 0.5, np.pi), root)
    share = (np.sin(root) - root) / (0.5 * e * root * np.cos(root) + (e - 1.0) * np.sin(root))
    return float(e * np.sum(share * np.exp(-(root**2) * time)))


def make_sphere(core: int, shell: int) -> tuple[Newton, float]:
    """Eighth of a sphere of 1 m, and the force (N) on its border dof, the inward radial movement, for p0."""
    mesh = eighth_ball(core, shell)
    surface = mesh.node_sets["surface"]
    fixed = mesh.nodes < 1e-9
    fixed[surface, 1:] = True
    model = block_model(mesh, elastic_soil(), fixed, 1)
    model.frames = {int(node): _inward_frame(mesh.nodes[node]) for node in surface}
    model.followers = followers(surface, 0, 0)
    drained = np.isin(np.arange(mesh.n_nodes), surface)
    model.fixed[surface, 0] = False
    fill(model, drained)
    # faces_on gives normals into the ball, as the movement is
    _, _, area = nodal_stations(mesh.nodes, faces_on(mesh, drained), -mesh.nodes)
    return make_newton(model), P0 * float(area.sum())


def _inward_frame(position: np.ndarray) -> np.ndarray:
    """Rows (3, 3): the direction to the centre and two directions across it."""
    inward = -position / np.linalg.norm(position)
    across = np.cross(inward, np.eye(3)[int(np.argmin(np.abs(inward)))])
    across /= np.linalg.norm(across)
    return np.array([inward, across, np.cross(inward, across)])


def centre_pressure(core: int, shell: int, plan: dict[float, int], refine: int = 1) -> dict[float, float]:
    """p/p0 at the centre at the time factors of the plan (see water.consolidation)."""
    newton, force = make_sphere(core, shell)
    centre = int(np.argmin(np.linalg.norm(newton.system.model.mesh.nodes, axis=1)))
    stages = consolidation(loaded([force]), consolidation_time(1.0, NU), plan, refine)
    found = [float(state.committed.pressure[centre]) / P0 for state, _ in follow(newton, stages)]
    return dict(zip(plan, found[1:], strict=True))


@cache
def rows() -> tuple[Row, ...]:
    """Centre pressure at the four times and at the peak: the limit of two runs."""
    whole, half = (centre_pressure(CORE, SHELL, PLAN, refine) for refine in (1, 2))
    found = {t: 2.0 * half[t] - whole[t] for t in whole}
    case = "Cryer's sphere, nu 0.3"
    return (
        *(Row(case, f"p/p0 at the centre, T = {t:g}", "", found[t], p, _SOURCE, 0.01) for t, p in CENTRE.items()),
        Row(case, f"peak of p/p0 at the centre, T = {PEAK_TIME:g}", "", found[PEAK_TIME], PEAK, _SOURCE, 0.01),
    )
