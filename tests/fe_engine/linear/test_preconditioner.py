# SPDX-License-Identifier: MIT
"""Factors of an earlier soil with the contact of the present: how exact they are where contact alone has changed."""

import numpy as np
import pytest

from fe_engine.assembly.contact_block import contact_block
from fe_engine.assembly.system import System
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP
from fe_engine.linear.backends import make_backend
from fe_engine.linear.preconditioner import Control, SoilFactors, TangentFactors
from fe_engine.settings import Recycling
from fe_engine.soil import elastic
from fe_engine.state import State
from tests.support.models import CONTACT, footing, mixed, replace, soil, wet

pytest.importorskip("pypardiso")
ALL_FREE = Control(np.zeros(3), np.eye(3), np.eye(3))
MANY = Recycling().many
SLIDES = np.array([1.0e-6, 1.0e-6, 8.0e-6])  # the footing lifts its heel, slips beside it and sticks at its toe


def elastic_footing():
    """A footing on elastic soil: from state to state nothing but its contact changes."""
    return footing(soil(elastic.LAW), contact=(*CONTACT[:2], 0.2))


def moved(system, border):
    """Tangent where the body alone has moved."""
    state = State(system.model)
    system.time_step = 1.0
    system.apply(state, np.zeros(system.pattern.n_free), np.asarray(border))
    return system.linearise(state, True)[2]


def copied(tangent):
    """A tangent whose entries the next linearisation does not overwrite."""
    return replace(tangent, matrix=tangent.matrix.copy())


def left(factors, tangent, control=ALL_FREE):
    """Residual that the preconditioner leaves of a bordered system, over its right-hand side."""
    n, k = tangent.matrix.shape[0], control.motions.shape[1]
    d = factors.origin.scale
    rhs = np.random.default_rng(3).normal(size=n + k) / np.concatenate([d, np.full(k, np.median(d))])
    factors.follow(tangent, control)
    x = factors.apply(rhs)
    forces, border = control.forces.T, control.motions @ x[n:]
    residual = rhs - np.concatenate(
        [tangent.matrix @ x[:n] + tangent.columns @ border, forces @ (tangent.rows @ x[:n] + tangent.corner @ border)]
    )
    scale = np.concatenate([d, np.full(k, np.median(d))])
    return np.linalg.norm(scale * residual) / np.linalg.norm(scale * rhs)


def soil_factors(system, many=MANY):
    block = system.track_contact_block()
    return SoilFactors(make_backend("pardiso", system.pattern.n_free, single=True), block, many)


@pytest.mark.parametrize("many", [0.0, 1.0], ids=["inverted anew", "corrected"])
def test_contact_that_opens_and_slips_is_followed_exactly(many):
    system = System(elastic_footing())
    factors = soil_factors(system, many)
    rest = copied(moved(system, np.zeros(3)))
    factors.make(factors.origin_of(rest), rest.matrix)
    assert left(factors, rest) < 1.0e-4
    now = copied(moved(system, SLIDES))
    assert {CONTACT_OPEN, CONTACT_SLIP} <= set(system.contact_state)
    assert left(factors, now) < 2.0e-3
    assert left(factors, rest) < 1.0e-4  # and back
    whole = TangentFactors(make_backend("pardiso", system.pattern.n_free, single=True))
    whole.make(whole.origin_of(rest), rest.matrix)
    assert left(whole, now) > 0.1  # which the factors of the whole earlier tangent do not


def test_controlled_motions_are_left_out():
    system = System(elastic_footing())
    factors = soil_factors(system)
    now = copied(moved(system, SLIDES))
    factors.make(factors.origin_of(now), now.matrix)
    two = np.eye(3)[:, 1:]
    assert left(factors, now, Control(np.zeros(3), two, two)) < 1.0e-4
    none = np.zeros((3, 0))
    assert left(factors, now, Control(np.zeros(3), none, none)) < 1.0e-4


def test_factors_made_again_from_their_origin_are_the_same():
    """Also where the interface has been inverted anew since."""
    system = System(elastic_footing())
    one, two = soil_factors(system, many=0.0), soil_factors(system)
    rest, now = (copied(moved(system, at)) for at in (np.zeros(3), SLIDES))
    one.make(one.origin_of(rest), rest.matrix)
    one.follow(now, ALL_FREE)
    assert not np.array_equal(one.origin.contact, rest.contact)
    two.make(one.origin, rest.matrix)
    two.follow(now, ALL_FREE)
    v = np.random.default_rng(1).normal(size=system.pattern.n_free + 3)
    np.testing.assert_array_equal(two.apply(v), one.apply(v))


@pytest.mark.parametrize("model", [footing, lambda: replace(wet("nodal"), followers=np.zeros((0, 4)))])
def test_contact_stands_in_its_block_and_nowhere_else(model):
    """With a film, too: a tangent less its contact is that of the soil alone."""
    system = System(model())
    block = system.track_contact_block()
    border = 1.0e-6 * np.arange(1.0, system.model.n_border + 1.0)
    tangent = copied(moved(system, border))
    less = tangent.matrix.copy()
    less.data[block.positions] -= tangent.contact
    scale = np.abs(less).max()
    system._film = lambda *_: 0.0
    system.stations.area[...] = 0.0
    alone = moved(system, border).matrix
    assert np.abs(less - alone).max() < 1.0e-9 * scale
    assert np.abs(tangent.contact).max() > 0.1 * scale
    outside = np.setdiff1d(np.arange(system.pattern.n_free), block.equations)
    assert not np.any(tangent.columns[outside])
    assert not np.any(tangent.rows[:, outside])


def test_nodes_that_follow_the_border_leave_no_block():
    assert contact_block(mixed(), System(mixed()).pattern) is None


def test_equations_that_are_kept_are_solved_for_by_the_caller():
    system = System(elastic_footing())
    matrix = moved(system, np.zeros(3)).matrix
    kept = np.arange(3, 30, 4)
    rest = np.setdiff1d(np.arange(matrix.shape[0]), kept)
    a = matrix.toarray()
    schur = a[np.ix_(kept, kept)] - a[np.ix_(kept, rest)] @ np.linalg.solve(
        a[np.ix_(rest, rest)], a[np.ix_(rest, kept)]
    )
    rhs = np.random.default_rng(2).normal(size=(matrix.shape[0], 2))
    for symmetric in (False, True):
        backend = make_backend("pardiso", matrix.shape[0], symmetric)
        backend.keep(kept)
        if symmetric:
            matrix = (matrix + matrix.T).tocsr() / 2
            matrix.sort_indices()
        backend.factorise(matrix)
        tolerance = 1e-3 if symmetric else 1e-9
        np.testing.assert_allclose(backend.schur, schur, atol=tolerance * np.abs(schur).max())
        x = backend.solve_with(lambda r, s=backend.schur: np.linalg.solve(s, r), rhs)
        np.testing.assert_allclose(matrix @ x, rhs, atol=1e-9)
        backend.close()


@pytest.mark.parametrize("equilibrated_too", [False, True])
def test_condition_of_a_whole_tangent_is_that_of_the_dense_matrix(equilibrated_too):
    """Of K itself, and of D K D; by power iterations, from below."""
    system = System(elastic_footing())
    tangent = copied(moved(system, np.zeros(3)))
    factors = TangentFactors(make_backend("pardiso", system.pattern.n_free, single=True))
    factors.make(factors.origin_of(tangent), tangent.matrix)
    d, dense = factors.origin.scale, tangent.matrix.toarray()
    values = np.linalg.eigvalsh(d[:, None] * dense * d if equilibrated_too else dense)
    found = factors.condition_estimate(tangent.matrix, equilibrated_too)
    assert 0.3 * values[-1] / values[0] < found <= 1.001 * values[-1] / values[0]
