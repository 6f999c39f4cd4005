# SPDX-License-Identifier: MIT
"""Solid shells: rigid motions, rank, patch tests; and linear elements beside the soil's, entry by entry."""

import numpy as np
import pytest

from fe_engine.conventions import CORNERS
from fe_engine.elements import solid_shell
from fe_engine.errors import ModelError
from fe_engine.mesh import Mesh
from fe_engine.model import Linear
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.state import State
from tests.support import models

YOUNG, POISSON = 200.0e9, 0.3
ONE = np.arange(8)[None]


def wall(distort: float = 0.0, through: float = 0.0) -> np.ndarray:
    """Corners (8, 3) of a thin element, distorted in its plane and through its thickness."""
    rng = np.random.default_rng(4)
    nodes = CORNERS * [1.0, 0.7, 0.05]
    plan = distort * rng.uniform(-1.0, 1.0, (4, 2))
    nodes[:, :2] += np.vstack([plan, plan])
    return nodes + through * rng.uniform(-1.0, 1.0, (8, 3))


def test_it_has_six_motions_without_strain():
    nodes = wall(0.1, 0.01)
    k = solid_shell.stiffness(nodes, ONE, YOUNG, POISSON)[0]
    values = np.linalg.eigvalsh(k)
    assert np.abs(values[:6]).max() < 1e-12 * values[-1] < 1e-3 * values[6]
    np.testing.assert_allclose(k, k.T, atol=1e-13 * np.abs(k).max())
    for axis in np.eye(3):
        for motion in (np.tile(axis, (8, 1)), np.cross(axis, nodes)):
            assert np.abs(k @ motion.ravel()).max() < 1e-13 * np.abs(k).max()


@pytest.mark.parametrize("component", range(6))
def test_uniform_strain_stores_the_energy_of_a_solid(component):
    """In walls whose two faces are alike, however distorted in plan."""
    nodes, strain = wall(0.15), np.eye(6)[component]
    gradient = models.to_matrix(strain, 0.5)
    u = (nodes @ gradient).ravel()
    k = solid_shell.stiffness(nodes, ONE, YOUNG, POISSON)[0]
    x, y = nodes[:4, 0], nodes[:4, 1]
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert u @ k @ u == pytest.approx(strain @ elastic_matrix(YOUNG, POISSON) @ strain * area * 0.1, rel=1e-12)


def test_bending_has_the_stiffness_of_a_plate():
    """Cylindrical bending with curvature c: energy E/(1 - nu2) t3/12 c2/2 an area, no stress through the thickness."""
    nodes, c = wall(), 1e-3
    x, z = nodes[:, 0], nodes[:, 2]
    u = np.stack([-c * x * z, 0.0 * x, 0.5 * c * x**2], axis=1).ravel()
    k = solid_shell.stiffness(nodes, ONE, YOUNG, POISSON)[0]
    thinned = np.tile([False, False, True], 8)  # thickness strain finds itself: free the mean of each pair
    free = np.flatnonzero(thinned)[4:]
    held = np.setdiff1d(np.arange(24), free)
    u[free] = np.linalg.solve(k[np.ix_(free, free)], -k[np.ix_(free, held)] @ u[held])
    area, stiffness = 2.0 * 1.4, YOUNG / (1.0 - POISSON**2) * 0.1**3 / 12.0
    assert u @ k @ u == pytest.approx(stiffness * c**2 * area, rel=1e-9)


def steel_beside(model):
    """A model with two linear elements over its first hexahedra and some nodes of their own."""
    mesh = model.mesh
    rng = np.random.default_rng(8)
    free = np.setdiff1d(np.arange(mesh.n_nodes), list(model.frames))[:8]
    own = np.arange(mesh.n_nodes, mesh.n_nodes + 4)
    model.mesh = Mesh(np.vstack([mesh.nodes, rng.normal(size=(4, 3))]), mesh.hexes)
    model.fixed = np.vstack([model.fixed, np.zeros((4, 3), dtype=bool)])
    hexes = np.array([free, np.concatenate([own, free[:4]])])
    half = rng.normal(size=(2, 24, 24))
    model.linear = Linear(hexes, 1.0e8 * (half + half.transpose(0, 2, 1)))
    return model


def test_assembly_adds_force_and_stiffness_of_every_linear_element():
    from fe_engine.assembly.system import System

    model = steel_beside(models.mixed())
    system, state = System(model), State(model)
    rng = np.random.default_rng(3)
    free, border = 1e-4 * rng.normal(size=system.pattern.n_free), 1e-4 * rng.normal(size=4)
    system.apply(state, free, border)
    judged, _, tangent = system.linearise(state, True)
    linear, model.linear = model.linear, Linear(model.linear.hexes, 0.0 * model.linear.stiffness)
    bare = System(model)
    bare.apply(other := State(model), free, border)
    without, _, bare_tangent = bare.linearise(other, True)
    equation, weight, n = system.pattern.equation, system.pattern.weight, system.pattern.n_free
    force, stiffness = np.zeros(n + 4), np.zeros((n + 4, n + 4))
    for nodes, k in zip(linear.hexes, linear.stiffness, strict=True):
        e, share = equation[nodes].ravel(), weight[nodes].ravel()
        place, there = np.where(e >= 0, e, n - 2 - e), e != -1
        f = k @ state.trial.displacement[nodes].ravel()
        for a in np.flatnonzero(there):
            scale_a = 1.0 if e[a] >= 0 else share[a]
            force[place[a]] += scale_a * f[a]
            for b in np.flatnonzero(there):
                stiffness[place[a], place[b]] += scale_a * (1.0 if e[b] >= 0 else share[b]) * k[a, b]
    np.testing.assert_allclose(judged.free - without.free, force[:n], atol=1e-9 * np.abs(force).max())
    np.testing.assert_allclose(judged.border - without.border, force[n:], atol=1e-9 * np.abs(force).max())
    scale = 1e-12 * np.abs(tangent.matrix.data).max()
    added = (tangent.matrix - bare_tangent.matrix).toarray()
    np.testing.assert_allclose(added, stiffness[:n, :n], atol=scale)
    np.testing.assert_allclose(tangent.columns - bare_tangent.columns, stiffness[:n, n:], atol=scale)
    np.testing.assert_allclose(tangent.rows - bare_tangent.rows, stiffness[n:, :n], atol=scale)
    np.testing.assert_allclose(tangent.corner - bare_tangent.corner, stiffness[n:, n:], atol=scale)


def test_linear_elements_do_not_stand_on_turned_nodes():
    model = steel_beside(models.mixed())
    model.linear.hexes[0, 0] = next(iter(model.frames))
    with pytest.raises(ModelError, match="axes of its own and a linear element"):
        model.check()
