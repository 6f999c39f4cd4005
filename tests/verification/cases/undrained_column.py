# SPDX-License-Identifier: MIT
"""A load on saturated soil that has no time to drain: the water carries it at every node.

k is 1e-12 m/s and the only step lasts 1e-3 s, in which water moves by 5 micrometres. In a laterally held column under
the pressure q

sealed at its top, the pressure is p = q/(1 + S E_oed) at every node, with the storage S of a real water (the loading
    efficiency: Jacob 1940; van der Kamp & Gale 1983), and q with incompressible water, where nothing moves at all;
drained at its top, with incompressible water, it is q everywhere below. Equal orders of displacement and pressure,
    left alone, answer with 0, 2 q, 0, 2 q ... (the equilibrium sees the mean pressure of an element only); the
    tool's stabilisation leaves nothing of that in a column of even layers (1/(2 G) would leave 0.15 q at the first
    nodes below the top, falling seven-fold a layer).

The measure of a checkerboard: half the root mean square of a node's error less the mean error of its neighbours
along edges, over q. Errors of +e and -e in turn have the measure e/q, smooth ones nearly none.
"""

from functools import cache

import numpy as np

from fe_engine.mesh import EDGES, Mesh
from tests.verification.balls import faces_on
from tests.verification.blocks import loaded, make_newton
from tests.verification.cases.patch import distorted
from tests.verification.films import lay_film
from tests.verification.rows import Row, worst
from tests.verification.water import WEIGHT, fill, follow, oedometer, oedometric_modulus, timed

LOAD, MOBILITY, STEP = 100.0e3, 1.0e-12 / WEIGHT, 1.0e-3
# Porosity 0.4 over the bulk modulus of water
STORAGE = 0.4 / 2.2e9
CELLS = (3, 3, 12)


def undrained_pressure(drained: bool, storage: float, stabilisation: float | None = None) -> tuple[Mesh, np.ndarray]:
    """Mesh and pressure (n,) in Pa after the step, top drained or sealed; the tool's stabilisation by default."""
    mesh = distorted(CELLS, keep_levels=True)
    model, top = oedometer(mesh)
    if not drained:
        # a plate on the stiffness of a contact: without it the sealed nodes could not change their volume, and
        # incompressible water would have no pressure of its own
        model.followers = np.zeros((0, 4))
        lay_film(model, faces_on(mesh, top), 0.0, 0.0, motion=np.array([[0.0], [0.0], [1.0]]))
    fill(model, top & drained, MOBILITY, storage=storage, stabilisation=stabilisation)
    ((state, _),) = follow(make_newton(model, 1e-9), [timed(loaded([LOAD]), STEP)])
    return mesh, state.committed.pressure


def checkerboard(mesh: Mesh, error: np.ndarray) -> float:
    """Half the root mean square of an error (n,) less the mean error of the neighbours along edges."""
    edges = np.unique(np.sort(mesh.hexes[:, EDGES].reshape(-1, 2), axis=1), axis=0)
    total, count = np.zeros(mesh.n_nodes), np.zeros(mesh.n_nodes)
    for a, b in (edges.T, edges.T[::-1]):
        np.add.at(total, a, error[b])
        np.add.at(count, a, 1.0)
    return float(0.5 * np.sqrt(np.mean((error - total / count) ** 2)))


@cache
def rows() -> tuple[Row, ...]:
    """Sealed column; drained column below its top layers; checkerboard with and without stabilisation."""
    _, sealed = undrained_pressure(False, STORAGE)
    _, still = undrained_pressure(False, 0.0)
    mesh, drained = undrained_pressure(True, 0.0)
    _, bare = undrained_pressure(True, 0.0, stabilisation=0.0)
    z = mesh.nodes[:, 2]
    exact = np.where(z == 0.0, 0.0, LOAD)
    with_it, without = (checkerboard(mesh, (p - exact) / LOAD) for p in (drained, bare))
    efficiency = 1.0 / (1.0 + STORAGE * oedometric_modulus())
    case = "undrained column, k 1e-12 m/s, step 1e-3 s"
    source = "the water carries the load"
    return (
        Row(case, "p/q, sealed top, mean", "", sealed.mean() / LOAD, efficiency, "loading efficiency", 1e-6),
        Row.error(case, "largest error of p, sealed top", worst(sealed, efficiency * LOAD), "loading efficiency", 1e-6),
        Row.error(case, "largest error of p, sealed top, incompressible water", worst(still, LOAD), source, 1e-6),
        Row.error(case, "largest error of p, drained top, lower half", worst(drained[z > 0.49], LOAD), source, 1e-4),
        Row.error(case, "checkerboard of p/q with the stabilisation", with_it, source, 0.05),
        Row(case, "checkerboard of p/q without it", "", without, 0.0, source, None),
    )
