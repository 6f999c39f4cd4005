# SPDX-License-Identifier: MIT
"""Patch tests of the pore pressure in distorted hexahedra.

constant : the same pressure p held on the whole boundary, and a vertical load q: at rest the effective stress is p
    (tension) on the sides and p - q along z, with the strains of a free piece under that stress.
linear : a linear pressure held on the boundary of soil that cannot move: at rest it is linear inside too.
"""

from functools import cache

import numpy as np

from fe_engine.model import Model, Stage
from fe_engine.state import Fields
from tests.verification.blocks import (
    POISSON,
    YOUNG,
    block_model,
    elastic_soil,
    followers,
    imposed,
    loaded,
    make_newton,
    run,
)
from tests.verification.cases.patch import distorted
from tests.verification.rows import Row, worst
from tests.verification.water import consolidation_time, fill, timed

P0, LOAD = 50.0e3, 30.0e3
_SOURCE = "patch test"


def _at_rest(model: Model, exact: np.ndarray, load: Stage) -> Fields:
    """State in which the soil has come to rest with its boundary at the exact pressure (n,) and nothing before."""
    boundary = ((model.mesh.nodes < 1e-9) | (model.mesh.nodes > 1.0 - 1e-9)).any(axis=1)
    fill(model, boundary, initial=np.where(boundary, exact, 0.0))
    unit = consolidation_time(1.0)
    state, _ = run(make_newton(model), timed(load, unit), timed(load, 20.0 * unit, 20))
    return state.committed


@cache
def rows() -> tuple[Row, ...]:
    """Constant pressure in a loaded piece of soil, linear pressure in soil that cannot move."""
    case = "patch test of the pressure, distorted hexahedra"
    errors = _constant() | _linear()
    return tuple(Row.error(case, f"largest error of the {name}", e, _SOURCE, 1e-9) for name, e in errors.items())


def _constant() -> dict[str, float]:
    mesh = distorted((3, 3, 3))
    fixed = mesh.nodes == 0.0
    fixed[:, 2] = mesh.nodes[:, 2] == 1.0
    model = block_model(mesh, elastic_soil(), fixed, 1)
    model.followers = followers(np.flatnonzero(mesh.nodes[:, 2] == 0.0), 2, 0)
    found = _at_rest(model, np.full(mesh.n_nodes, P0), loaded([LOAD]))
    stress = np.array([P0, P0, P0 - LOAD, 0.0, 0.0, 0.0])
    strain = ((1.0 + POISSON) * stress[:3] - POISSON * stress.sum()) / YOUNG
    return {
        "constant pressure": worst(found.pressure, P0),
        "effective stress": worst(found.stress, stress),
        "displacement": worst(found.displacement, strain * (mesh.nodes - [0.0, 0.0, 1.0])),
    }


def _linear() -> dict[str, float]:
    mesh = distorted((3, 3, 3))
    model = block_model(mesh, elastic_soil(), np.ones(mesh.nodes.shape, dtype=bool), 1)
    exact = P0 * (0.3 + mesh.nodes @ [1.0, -0.6, 0.4])
    return {"linear pressure": worst(_at_rest(model, exact, imposed([0.0])).pressure, exact)}
