# SPDX-License-Identifier: MIT
"""Steel of an elastic caisson in Fourier series against the closed forms of `steel_shell`: pulled ring, clamped lid.

The clamp of a solid holds the thickness, too, which Mindlin's plate does not have: 1.5 to 2 % at this
thickness, 2.5 % with the wide elements of `coarse` beside the clamp (0.31 m; more of them do not change it).
"""

from functools import cache

import numpy as np

from fe_engine.elements import fourier as elements
from fe_engine.soil.elastic import elastic_matrix
from pysprings.model.fourier import nodal_rings
from pysprings.model.fourier_mesh import FRICTIONAL, PRESETS, make_section
from pysprings.model.mesh import Geometry
from pysprings.model.steel import make_steel_rings
from tests.verification.cases.steel_shell import LID, RADIUS, WALL, YOUNG
from tests.verification.rows import Row

_RING = "thin ring pulled by two forces (Timoshenko, Strength of Materials)"
_PLATE = "clamped circular plate with shear (Mindlin)"


def solve(
    nodes: np.ndarray, quads: np.ndarray, poisson: float, k: int, fixed: np.ndarray, force: np.ndarray
) -> np.ndarray:
    """Coefficients (n, 3) of harmonic k under nodal forces (n, 3) of half a circle; fixed (n, 3) bool."""
    gradient, volume = elements.geometry(nodes, quads)
    tangent = np.broadcast_to(elastic_matrix(YOUNG, poisson), (*volume.shape, 6, 6))
    whole = np.zeros((3 * len(nodes), 3 * len(nodes)))
    for quad, matrix in zip(quads, elements.stiffness(gradient, volume, tangent, k), strict=True):
        at = (3 * quad[:, None] + np.arange(3)).ravel()
        whole[np.ix_(at, at)] += matrix
    free = np.flatnonzero(~fixed.ravel())
    u = np.zeros(3 * len(nodes))
    u[free] = np.linalg.solve(whole[np.ix_(free, free)], force.ravel()[free])
    return u.reshape(-1, 3)


def ovalisation(harmonics: int) -> tuple[float, float]:
    """Change of diameter along and across two pulling forces, over the closed form; one element."""
    height, force = 0.5, 1.0e5
    nodes = elements.LOCAL * [0.5 * WALL, 0.5 * height] + [RADIUS, 0.5 * height]
    quads = np.arange(8)[None]
    share = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 4.0, 0.0, 4.0]) / 12.0  # uniform along both faces
    along, across = 0.0, 0.0
    for k in range(0, harmonics + 1, 2):
        fixed = np.zeros((8, 3), bool)
        fixed[nodes[:, 1] == 0.0, 2] = True
        fixed[:, 1] |= k == 0
        u = solve(nodes, quads, 0.0, k, fixed, np.outer(share * force, [1.0, 0.0, 0.0]))
        along += 2.0 * float(share @ u[:, 0])
        across += 2.0 * float(share @ u[:, 0]) * (-1.0) ** (k // 2)
    unit = force * RADIUS**3 / (YOUNG * height * WALL**3 / 12.0)
    return along / (unit * (np.pi / 4.0 - 2.0 / np.pi)), -across / (unit * (2.0 / np.pi - 0.5))


def plate(preset: str, poisson: float = 0.3) -> float:
    """Deflection of the lid's centre under a uniform pressure, clamped along the skirt, over the closed form."""
    edge = 3.8
    section = make_section(Geometry(edge, 3.9, 4.0, 24.0, 12.0), PRESETS[FRICTIONAL][preset], patch=True)
    steel = make_steel_rings(section, LID)
    nodes, quads = steel.nodes, steel.quads - steel.quads.min()
    lid = (nodes[quads, 1] < 0.0).any(axis=1)
    r, z = nodes.T
    fixed = np.zeros((len(nodes), 3), bool)
    fixed[(r > edge * (1.0 - 1e-9)) | ~np.isin(np.arange(len(nodes)), quads[lid])] = True
    fixed[:, 1], fixed[r == 0.0, 0] = True, True
    top = np.flatnonzero((z == z.min()) & (r <= edge * (1.0 + 1e-9)))
    top = top[np.argsort(r[top])]
    force = np.zeros((len(nodes), 3))
    force[top, 2] = np.pi * nodal_rings(r[top])
    u = solve(nodes, quads[lid], poisson, 0, fixed, force)
    stiffness, shear = YOUNG * LID**3 / (12.0 * (1.0 - poisson**2)), YOUNG / (2.0 * (1.0 + poisson))
    exact = edge**4 / (64.0 * stiffness) + edge**2 / (4.0 * 5.0 / 6.0 * shear * LID)
    return float(u[r == 0.0, 2].mean() / exact)


@cache
def rows() -> tuple[Row, ...]:
    """Ring and lid."""
    case, (along, across) = "elastic caisson, rings of series", ovalisation(16)
    return (
        Row(case, "ring: change of diameter along the pull, k to 16", "", along, 1.0, _RING, 5e-3),
        Row(case, "ring: change of diameter across it, k to 16", "", across, 1.0, _RING, 5e-3),
        Row(case, "ring: change of diameter along the pull, k = 2 alone", "", ovalisation(2)[0], 1.0, _RING, None),
        *(Row(case, f"lid under pressure, `{preset}`: deflection", "", plate(preset), 1.0, _PLATE, allowed)
          for preset, allowed in (("coarse", 0.03), ("paper", 0.02))),
    )  # fmt: skip
