# SPDX-License-Identifier: MIT
"""Solid shells of the elastic caisson against closed forms: a pulled ring, a tube bent as a beam, a clamped plate.

The sizes are those of the paper's caisson: wall 0.1 m at a radius of 3.85 m, lid 0.4 m thick. The ring is what a skirt
is when it turns oval; 16 cells around its half are the `paper` preset's, 8 those of `coarse`.
"""

from functools import cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from fe_engine.elements import hex8, solid_shell
from fe_engine.soil.elastic import elastic_matrix
from pysprings.model.mesh import PRESETS, Geometry, make_mesh
from pysprings.model.steel import make_steel
from tests.verification.rows import Row, fitted_rate

YOUNG, RADIUS, WALL, LID = 200.0e9, 3.85, 0.1, 0.4
_RING = "thin ring pulled by two forces (Timoshenko, Strength of Materials)"
_PLATE = "clamped circular plate with shear (Mindlin)"


def solve(nodes: np.ndarray, hexes: np.ndarray, k: np.ndarray, fixed: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Displacement (n, 3) under nodal forces; fixed (n, 3) bool."""
    dof = (3 * hexes[:, :, None] + np.arange(3)).reshape(len(hexes), 24)
    rows, columns = np.repeat(dof, 24, axis=1).ravel(), np.tile(dof, (1, 24)).ravel()
    matrix = coo_array((k.ravel(), (rows, columns)), shape=(3 * len(nodes),) * 2).tocsc()
    free = np.flatnonzero(~fixed.ravel())
    u = np.zeros(3 * len(nodes))
    u[free] = spsolve(matrix[free][:, free], force.ravel()[free])
    return u.reshape(-1, 3)


def tube(around: int, along: int, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Half a tube (y >= 0) of one layer: nodes by (wall, azimuth, level), elements around, along, outwards."""
    angle, z = np.linspace(0.0, np.pi, around + 1), np.linspace(0.0, length, along + 1)
    r, a, h = np.meshgrid([RADIUS - 0.5 * WALL, RADIUS + 0.5 * WALL], angle, z, indexing="ij")
    nodes = np.stack([r * np.cos(a), r * np.sin(a), h], axis=-1)
    number = np.arange(r.size).reshape(r.shape)
    sides = ((slice(None, -1), slice(None, -1)), (slice(1, None), slice(None, -1)), (slice(1, None), slice(1, None)),
             (slice(None, -1), slice(1, None)))  # fmt: skip
    corners = [number[wall][side].ravel() for wall in (0, 1) for side in sides]
    return nodes.reshape(-1, 3), np.stack(corners, axis=1)


def ovalisation(around: int, bricks: bool = False) -> tuple[float, float]:
    """Change of diameter along and across two pulling forces, over the closed form."""
    height, force = 0.5, 1.0e5
    nodes, hexes = tube(around, 1, height)
    k = brick_stiffness(nodes, hexes) if bricks else solid_shell.stiffness(nodes, hexes, YOUNG, 0.0)
    fixed, load = np.zeros(nodes.shape, bool), np.zeros(nodes.shape)
    plane, middle = np.abs(nodes[:, 1]) < 1e-9, np.abs(nodes[:, 0]) < 1e-9
    fixed[plane, 1], fixed[middle, 0], fixed[nodes[:, 2] == 0.0, 2] = True, True, True
    front, back = plane & (nodes[:, 0] > 0.0), plane & (nodes[:, 0] < 0.0)
    load[front, 0], load[back, 0] = 0.5 * force / front.sum(), -0.5 * force / back.sum()
    u = solve(nodes, hexes, k, fixed, load)
    unit = force * RADIUS**3 / (YOUNG * height * WALL**3 / 12.0)
    along = u[front, 0].mean() - u[back, 0].mean()
    return along / (unit * (np.pi / 4.0 - 2.0 / np.pi)), 2.0 * u[middle, 1].mean() / (unit * (0.5 - 2.0 / np.pi))


def brick_stiffness(nodes: np.ndarray, hexes: np.ndarray) -> np.ndarray:
    """Stiffness of the soil's bricks (mean dilatation), to compare."""
    gradient, volume, mean = hex8.geometry(nodes, hexes)
    k, b, cb = np.zeros((len(hexes), 24, 24)), np.zeros((6, 24)), np.empty((6, 24))
    for e in range(len(hexes)):
        for g in range(8):
            hex8.b_bar(gradient[e, g], mean[e], b)
            hex8.add_stiffness(b, elastic_matrix(YOUNG, 0.0), volume[e, g], cb, k[e])
    return k


def bending(around: int, along: int, length: float = 60.0) -> float:
    """Deflection of a tube that is held at one end and sheared as a beam at the other, over P L3/3 E I + 2 P L/G A."""
    nodes, hexes = tube(around, along, length)
    fixed, load = np.zeros(nodes.shape, bool), np.zeros(nodes.shape)
    fixed[np.abs(nodes[:, 1]) < 1e-9, 1], fixed[nodes[:, 2] == 0.0] = True, True
    end = nodes[:, 2] == length
    angle = np.arctan2(nodes[end, 1], nodes[end, 0])
    share = np.sin(angle) ** 2 / np.sum(np.sin(angle) ** 2)  # of the shear flow, along x
    load[end, 0], load[end, 1] = share, -share * np.cos(angle) / np.maximum(np.sin(angle), 1e-9)
    u = solve(nodes, hexes, solid_shell.stiffness(nodes, hexes, YOUNG, 0.0), fixed, load)
    inertia, area = np.pi * RADIUS**3 * WALL, 2.0 * np.pi * RADIUS * WALL
    # half the tube carries half the force: 2 is the unit load of the whole one
    exact = 2.0 * (length**3 / (3.0 * YOUNG * inertia) + 2.0 * length / (0.5 * YOUNG * area))
    return float(np.sum(u[end, 0] * share) / exact)


def plate(preset: str, poisson: float = 0.3) -> float:
    """Deflection of the lid's centre under a uniform pressure, clamped along the skirt, over the closed form."""
    geometry = Geometry(3.8, 3.9, 4.0, 24.0, 12.0)
    caisson = make_mesh(geometry, PRESETS[preset])
    steel = make_steel(caisson, LID)
    nodes = np.concatenate([caisson.mesh.nodes, steel.nodes])
    lid = steel.hexes[(nodes[steel.hexes, 2] < 0.0).any(axis=1)]
    number, used = np.unique(lid, return_inverse=True)
    points, plates = nodes[number], used.reshape(lid.shape)
    radius = np.hypot(points[:, 0], points[:, 1])
    a = np.hypot(*nodes[steel.walls["inside"][0, 0], :2])  # clamped at the inner edge of the skirt
    fixed, load = np.zeros(points.shape, bool), np.zeros(points.shape)
    fixed[radius > a * (1.0 - 1e-6)] = True
    fixed[np.abs(points[:, 1]) < 1e-9, 1] = True
    for corners in plates[:, 4:]:
        p = points[corners]
        area = 0.5 * np.linalg.norm(np.cross(p[2] - p[0], p[3] - p[1]))
        load[corners, 2] += 0.25 * area
    u = solve(points, plates, solid_shell.stiffness(points, plates, YOUNG, poisson), fixed, load)
    stiffness, shear = YOUNG * LID**3 / (12.0 * (1.0 - poisson**2)), YOUNG / (2.0 * (1.0 + poisson))
    edge = 3.8
    exact = edge**4 / (64.0 * stiffness) + edge**2 / (4.0 * 5.0 / 6.0 * shear * LID)
    return float(u[radius < 1e-9, 2].mean() / exact)


@cache
def rows() -> tuple[Row, ...]:
    """Ring, tube and plate."""
    cells = (8, 16, 32)
    rings = {n: ovalisation(n) for n in cells}
    case = "elastic caisson, solid shells"
    rows = [
        Row(case, f"ring of {n} cells a half: change of diameter along the pull", "", rings[n][0], 1.0, _RING, allowed)
        for n, allowed in zip(cells, (0.08, 0.02, 0.005), strict=True)
    ]
    rate = fitted_rate(1.0 / np.array(cells), [1.0 - rings[n][1] for n in cells])
    return (
        *rows,
        Row(case, "ring: change of diameter across it, 16 cells", "", rings[16][1], 1.0, _RING, 0.02),
        Row(case, "ring: order in the cell size", "", rate, 2.0, "second order", 0.15),
        Row(case, "ring of 16 plain bricks (what the soil has), to compare", "", ovalisation(16, True)[0], 1.0, _RING,
            None),
        Row(case, "tube of 16 x 24 cells bent as a beam", "", bending(16, 24), 1.0, "P L3/3EI + 2PL/GA", 0.02),
        *(Row(case, f"lid under pressure, `{preset}`: deflection", "", plate(preset), 1.0, _PLATE, allowed)
          for preset, allowed in (("coarse", 0.06), ("paper", 0.03))),
    )  # fmt: skip
