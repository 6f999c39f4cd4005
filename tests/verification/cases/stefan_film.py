# SPDX-License-Identifier: MIT
"""Opening film: a disc is pulled off a flat bed at a speed v; the water must come in from the rim (Stefan 1874).

With the aperture h, the radius R and no pressure at the rim (lubrication theory; Reynolds 1886):

    p(r) = -3 mu v (R2 - r2)/h3,    F = 3 pi mu v R4/(2 h3)

The disc is the rigid body, the bed is soil that neither moves nor takes water (T_w = 0). One quarter of the disc, the
plane z = 0 of an eighth of a ball. Twice at h = 1 mm: all of it residual aperture, or half of it opened by the pull.
"""

from functools import cache

import numpy as np

from fe_engine.solve.newton import Newton
from tests.verification.balls import eighth_ball, faces_on
from tests.verification.blocks import block_model, elastic_soil, imposed, make_newton
from tests.verification.films import lay_film
from tests.verification.rows import Row
from tests.verification.water import VISCOSITY, fill, follow, timed

RADIUS, SPEED, APERTURE = 1.0, 1.0e-5, 1.0e-3
# As printed in the reference table: suction at the centre (Pa), force (N)
PRESSURE, FORCE = 30.0, 47.1
CORE, SHELL = 6, 6
_SOURCE = "Stefan 1874, closed form"


def closed_form() -> tuple[float, float]:
    """Suction at the centre (Pa) and force (N)."""
    suction = 3.0 * VISCOSITY * SPEED * RADIUS**2 / APERTURE**3
    return suction, 0.5 * np.pi * RADIUS**2 * suction


def make_disc(core: int, shell: int, residual: float) -> tuple[Newton, np.ndarray]:
    """Quarter of the disc, which moves down with border dof 0, and the distance (m) of each film node from its axis."""
    mesh = eighth_ball(core, shell, RADIUS)
    bed = mesh.nodes[:, 2] == 0.0
    model = block_model(mesh, elastic_soil(), np.ones(mesh.nodes.shape, dtype=bool), 1)
    faces = faces_on(mesh, bed)
    mesh.nodes *= RADIUS * np.sqrt(0.25 * np.pi / _plan_area(mesh.nodes, faces))
    found = lay_film(model, faces, residual, 0.0, pressure=0.0, motion=np.array([[0.0], [0.0], [1.0]]))
    rim = np.isin(found.nodes, mesh.node_sets["surface"])
    # the water of the bed stays as it is
    fill(model, np.concatenate([np.ones(mesh.n_nodes, dtype=bool), rim]), film=found.film)
    return make_newton(model), np.hypot(*found.position[:, :2].T)


def _plan_area(nodes: np.ndarray, faces: np.ndarray) -> float:
    """Area (m2) of plane quadrilaterals: half the cross product of their diagonals."""
    corner = nodes[faces]
    return float(0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1).sum())


def pull(residual: float, gap: float) -> tuple[float, float, float]:
    """Pull at SPEED to a gap (m); return suction at the centre (Pa), force (N), worst error of p over its centre's."""
    newton, radius = make_disc(CORE, SHELL, residual)
    ((state, step),) = follow(newton, [timed(imposed([-gap]), gap / SPEED)])
    suction = -state.committed.pressure[newton.system.model.mesh.n_nodes :]
    exact = closed_form()[0] * np.maximum(1.0 - (radius / RADIUS) ** 2, 0.0)
    error = float(np.abs(suction - exact).max()) / exact.max()
    return float(suction[np.argmin(radius)]), -4.0 * float(step.multipliers[0]), error


@cache
def rows() -> tuple[Row, ...]:
    """Pressure and force with a residual aperture of 1 mm, and with one of 0.5 mm that has opened by 0.5 mm."""
    found, exact = [], closed_form()
    for residual, gap in ((APERTURE, 1.0e-9), (0.5 * APERTURE, 0.5 * APERTURE)):
        case = f"opening film, {1e3 * residual:g} mm + {0.0 if gap < 1e-6 else 1e3 * gap:g} mm gap"
        suction, force, error = pull(residual, gap)
        found += [
            Row(case, "suction at the centre", "Pa", suction, exact[0], _SOURCE, 0.01),
            Row(case, "force on the disc", "N", force, exact[1], _SOURCE, 0.01),
            Row.error(case, "largest error of the pressure over the centre's", error, _SOURCE, 0.01),
        ]
    return tuple(found)
