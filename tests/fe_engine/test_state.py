# SPDX-License-Identifier: MIT
"""Committed and trial fields: only a commit moves the committed ones, and a failure leaves every bit."""

import numpy as np
import pytest

from fe_engine.errors import NotConverged
from fe_engine.solve.newton import Loading
from fe_engine.state import FIELDS, State
from tests.support.models import footing, run, stage, start

PULL = stage({0: 2.0e-4}, arm=0.3)


def bits(fields):
    return {name: getattr(fields, name).tobytes() for name in FIELDS}


def fill(fields, value):
    for name in FIELDS:
        getattr(fields, name)[...] = value


@pytest.fixture
def loaded():
    """A run with yielded and slipped points behind it."""
    out = run(footing(), PULL)
    last = out.steps[-1].increment.residual
    assert min(last.n_plastic, last.n_slip) > 0
    return out


def test_initial_fields_are_the_initial_state():
    model = footing()
    state = State(model)
    for fields in (state.committed, state.trial):
        np.testing.assert_array_equal(fields.stress, model.initial_stress)
        np.testing.assert_array_equal(fields.traction[:, 0], -model.initial_pressure)
        assert not np.any(fields.traction[:, 1:])
        assert not any(np.any(getattr(fields, name)) for name in ("displacement", "border", "history"))


def test_the_model_is_never_written():
    model = footing()
    before = model.initial_stress.tobytes(), model.initial_pressure.tobytes(), model.mesh.nodes.tobytes()
    run(model, PULL)
    assert before == (model.initial_stress.tobytes(), model.initial_pressure.tobytes(), model.mesh.nodes.tobytes())


def test_commit_and_reset_copy_everything_and_share_nothing():
    state = State(footing())
    start_bits = bits(state.committed)
    fill(state.trial, 3.0)
    assert bits(state.committed) == start_bits
    state.reset_trial()
    assert bits(state.trial) == start_bits
    fill(state.trial, 4.0)
    state.commit()
    accepted = bits(state.trial)
    fill(state.trial, 5.0)
    assert bits(state.committed) == accepted


def test_a_failed_increment_leaves_every_committed_bit(loaded):
    newton, state = loaded.driver.newton, loaded.state
    newton.settings = type(newton.settings)(max_iterations=3)
    before = bits(state.committed)
    loading = Loading(np.eye(3), np.array([5.0e-3, 1.0e-3, 2.0e-3]), np.eye(3), np.zeros(3))
    with pytest.raises(NotConverged):
        newton.solve(state, loading, np.zeros(newton.system.pattern.n_free), np.zeros(3))
    assert bits(state.committed) == before
    assert bits(state.trial) != before


def test_a_failed_increment_does_not_change_the_next_answer(loaded):
    """With a failure in between, the next stage takes bit for bit the way it takes without."""
    onward = stage({0: 3.0e-4}, arm=0.3)
    untroubled = run(footing(), PULL, onward)
    test_a_failed_increment_leaves_every_committed_bit(loaded)
    loaded.driver.newton.settings = untroubled.driver.newton.settings
    loaded.driver.run(onward, loaded.steps.append)
    assert bits(loaded.state.committed) == bits(untroubled.state.committed)


def test_only_commits_move_the_committed_fields(monkeypatch):
    """Whatever Newton does between two commits, the committed bits stay."""
    out = start(footing(), max_iterations=4)
    commits, solve = [], out.driver.newton.solve
    commit = State.commit

    def counting(state):
        commit(state)
        commits.append(bits(state.committed))

    def watching(*args):
        before = bits(out.state.committed)
        assert before == (commits[-1] if commits else bits(State(footing()).committed))
        try:
            return solve(*args)
        finally:
            assert bits(out.state.committed) == before

    monkeypatch.setattr(State, "commit", counting)
    monkeypatch.setattr(out.driver.newton, "solve", watching)
    out.driver.run(stage({0: 0.0, 2: -5.0e-4}, first_fraction=0.5), out.steps.append)
    assert len(out.driver.given_up) > 0
    assert len(commits) == len(out.steps)


def test_the_same_run_twice_is_the_same_bit_for_bit(loaded):
    assert bits(run(footing(), PULL).state.committed) == bits(loaded.state.committed)


def test_going_on_from_stored_fields_equals_going_on(loaded):
    resumed = start(footing())
    resumed.state.committed.copy_from(loaded.state.committed)
    for out in (loaded, resumed):
        out.driver.run(stage({0: 3.0e-4}, arm=0.3), out.steps.append)
    assert bits(resumed.state.committed) == bits(loaded.state.committed)
