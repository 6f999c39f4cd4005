# SPDX-License-Identifier: MIT
"""Stages in increments: stops, growth, cut-back, load control and its end."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fe_engine.errors import NotConverged
from fe_engine.soil import elastic
from fe_engine.solve.step_size import LIMITS, StepSize
from fe_engine.solve.stepping import Driver, _next, fewest_increments
from fe_engine.state import State
from tests.support.models import footing, run, soil, stage, start

FAILED = ("pull", 0.1, NotConverged("no balance"))  # an attempt that was given up
CAPACITY = 0.5 * 2.0e4 * 0.5  # N: mu times pressure times area
KINDS = {
    "pull": stage({0: 5.0e-4}, arm=0.3, stops=(0.33, 0.7, 1.0)),
    "translation": stage({0: 5.0e-4, 2: 0.0}, stops=(0.33, 0.7)),
    "load": stage({}, force=(0.8 * CAPACITY, 0.0, -100.0), stops=(0.33, 0.7)),
}


# --- landing on stops -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["pull", "translation", "load"])
def test_stages_run_to_their_end_and_land_on_every_stop(kind):
    each = KINDS[kind]
    out = run(footing(), each)
    fractions = [step.fraction for step in out.steps]
    assert {0.33, 0.7, 1.0} <= set(fractions)
    assert fractions == sorted(set(fractions))
    assert fractions[0] == each.first_fraction
    assert np.max(np.diff(fractions)) <= each.max_fraction * (1.0 + 1e-12)
    assert out.driver.n_steps == len(out.steps)
    np.testing.assert_allclose(each.control @ out.state.committed.border, each.target, rtol=1e-12, atol=1e-15)


def test_committed_controls_are_the_fraction_at_every_step():
    out, seen = start(footing()), []
    out.driver.run(KINDS["translation"], lambda step: seen.append((step.fraction, out.state.committed.border.copy())))
    assert seen and seen[-1][0] == 1.0
    for fraction, border in seen:
        assert border[0] == pytest.approx(fraction * 5.0e-4, rel=1e-12)
        assert abs(border[2]) < 1e-15


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(stops=st.lists(st.floats(1e-3, 0.999), max_size=4), sizes=st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=4))
def test_steps_never_pass_a_stop_and_leave_no_sliver(stops, sizes):
    done, ends = 0.0, []
    while done < 1.0:
        size = sizes[len(ends) % len(sizes)]
        end = _next(done, size, tuple(stops))
        stop = min(s for s in (*stops, 1.0) if s > done + 1e-12)
        assert done < end <= stop
        assert end - done <= size * (1.0 + 1e-8)
        assert end == stop or stop - end >= 0.4999 * min(size, stop - done)
        done = end
        ends.append(end)
    assert set(stops) <= {*ends, 1.0} or min(np.diff(sorted({*stops, 0.0, 1.0}))) <= 1e-12
    assert ends[-1] == 1.0


def test_a_stop_a_rounding_error_before_the_end():
    out = run(footing(), stage({0: 1.0e-5, 2: 0.0}, stops=(1.0 - 1.0e-15,), first_fraction=1.0))
    assert out.steps[-1].fraction == pytest.approx(1.0)


@pytest.mark.parametrize("stops", [(1.0,), (0.125, 1.0), (0.1, 0.5, 1.0)])
def test_the_fewest_increments_are_those_of_steps_that_all_converge_at_once(stops):
    """Exactly so where nothing but the end is landed on; else from below."""
    for first, largest in [(1e-4, 0.02), (1e-3, 0.05), (0.0078, 0.3), (0.05, 0.05), (0.3, 0.5), (1.0, 1.0)]:
        done, size, number = 0.0, first, 0
        while done < 1.0:
            end = _next(done, size, stops)
            done, size, number = end, StepSize(size).after_success(end - done, 3, largest).size, number + 1
        fewest = fewest_increments(stage({}, stops=stops, first_fraction=first, max_fraction=largest))
        assert fewest == number if len(stops) == 1 else len(stops) <= fewest <= number


def test_every_step_says_what_limited_it():
    out = run(footing(), KINDS["pull"])
    limits = [step.limit for step in out.steps]
    assert limits[0] == "first step"
    assert set(limits) <= set(LIMITS)
    at_stops = [step.limit for step in out.steps if step.fraction in (0.33, 0.7)]
    assert set(at_stops) <= {"stop", "cut-back"}
    for step, limit in zip(out.steps, limits, strict=True):
        assert (limit == "cut-back") or step.cut_backs == 0


def test_time_runs_with_the_fraction():
    timed = stage({0: 5.0e-4}, arm=0.3, duration=40.0)
    out = run(footing(), timed, KINDS["load"])
    assert sum(step.time_step for step in out.steps) == pytest.approx(40.0)


def test_a_linear_model_needs_one_iteration_and_then_none():
    """Extrapolation of the last increment is exact, so only the first one is solved for."""
    out = run(footing(soil(elastic.LAW), contact=(1.0e10, 1.0e10, 100.0)), stage({0: 1.0e-6}, arm=0.1))
    assert [step.increment.iterations for step in out.steps] == [1] + [0] * (len(out.steps) - 1)


@pytest.mark.parametrize("continues", [False, True])
def test_a_stage_that_continues_extrapolates_the_one_before(continues):
    ends = [stage({0: size}, arm=0.1, first_fraction=0.5, max_fraction=0.5) for size in (1.0e-6, 2.0e-6)]
    model = footing(soil(elastic.LAW), contact=(1.0e10, 1.0e10, 100.0))
    out = run(model, ends[0], replace(ends[1], continues=continues))
    assert [step.increment.iterations for step in out.steps] == [1, 0, 0 if continues else 1, 0]


# --- cut-back ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hurried():
    """A stage in one step with too few iterations for it."""
    each = stage({0: 0.0, 2: -5.0e-4}, first_fraction=1.0, max_fraction=1.0, stops=(0.9,))
    return run(footing(), each, max_iterations=4)


def test_cut_back_gets_there_in_smaller_steps(hurried):
    driver = hurried.driver
    assert len(driver.given_up) > 0
    assert sum(step.cut_backs for step in hurried.steps) == len(driver.given_up)
    assert [step.fraction for step in hurried.steps][-2:] == [0.9, 1.0] or 0.9 in [s.fraction for s in hurried.steps]
    assert hurried.state.committed.border[2] == pytest.approx(-5.0e-4, rel=1e-12)


def test_what_a_failed_attempt_raises_ends_a_stage_but_not_before_its_first_increment():
    """Before it attempts fail for other reasons than what the stage has come to; after it none converges here."""
    out, called = start(footing(), max_iterations=4), []

    def failed():
        called.append(len(out.steps))
        raise NotConverged("flat")

    def on_step(step):
        out.steps.append(step)
        newton.settings = replace(newton.settings, max_iterations=0)

    newton, out.driver.failed = out.driver.newton, failed
    with pytest.raises(NotConverged, match="flat"):
        out.driver.run(stage({0: 0.0, 2: -5.0e-4}, first_fraction=1.0, max_fraction=1.0), on_step)
    assert called == [1] and out.steps[0].cut_backs > 0


def test_cut_back_ends_near_the_patient_answer(hurried):
    patient = run(footing(), stage({0: 0.0, 2: -5.0e-4}, first_fraction=0.02, max_fraction=0.05))
    assert len(patient.driver.given_up) == 0
    np.testing.assert_allclose(hurried.steps[-1].multipliers, patient.steps[-1].multipliers, rtol=0.05)


def test_record_tells_failed_attempts_from_good_ones(hurried):
    record = hurried.driver.record
    failed = [row for row in record if not row["converged"]]
    assert len({(row["step"], row["load_fraction"]) for row in failed}) == len(hurried.driver.given_up)
    for number, step in enumerate(hurried.steps, start=1):
        rows = [row for row in record if row["step"] == number and row["converged"]]
        assert [row["iteration"] for row in rows] == list(range(step.increment.iterations + 1))
        assert {row["load_fraction"] for row in rows} == {step.fraction}
        tried = {row["load_fraction"] for row in failed if row["step"] == number}
        assert all(fraction > step.fraction for fraction in tried)


def test_an_impossible_stage_gives_up_with_the_last_history():
    out = start(footing(), max_iterations=0)
    with pytest.raises(NotConverged, match="no convergence in 0 iterations") as caught:
        out.driver.run(stage({0: 1.0e-3}, first_fraction=0.1), out.steps.append)
    assert (out.driver.n_steps, out.steps) == (0, [])
    assert len(out.driver.given_up) == len(out.driver.record) == 20
    assert caught.value.history[-1].items() <= out.driver.record[-1].items()


# --- several stages, loads --------------------------------------------------------------------------------


def test_back_and_forth_slides_both_ways():
    there, back = stage({0: 2.0e-3, 2: 0.0}), stage({0: 0.0, 2: 0.0}, first_fraction=0.002)
    out = run(footing(), there, back)
    forces = np.array([step.multipliers[0] for step in out.steps])
    turn = [step.fraction for step in out.steps].index(1.0)
    assert forces[turn] == pytest.approx(CAPACITY, rel=1e-6)
    assert forces[-1] == pytest.approx(-CAPACITY, rel=1e-6)
    assert 0.0 < forces[turn + 1] < CAPACITY
    assert out.state.committed.border[0] == pytest.approx(0.0, abs=1e-15)


def test_known_forces_hold_while_another_dof_is_moved():
    """A dead load first; the pull then keeps it, and slides at mu times initial plus dead load."""
    dead = stage({}, force=(0.0, 4.0e3, 0.0))
    out = run(footing(), dead, stage({0: 5.0e-3, 2: 0.0}, force=(0.0, 4.0e3, 0.0)), tolerance=1e-9)
    assert out.steps[-1].increment.residual.border[1] == pytest.approx(4.0e3, rel=1e-8)
    assert out.steps[-1].multipliers[0] == pytest.approx(CAPACITY + 0.5 * 4.0e3, rel=1e-6)


def test_load_control_answers_as_displacement_control():
    pulled = run(footing(), stage({0: 5.0e-5}, arm=0.2))
    force = pulled.steps[-1].multipliers[0]
    loaded = run(footing(), stage({}, force=(force, 0.0, -0.2 * force)))
    np.testing.assert_allclose(loaded.state.committed.border, pulled.state.committed.border, rtol=0.02)


def test_load_beyond_the_capacity_ends_in_not_converged():
    """The steps shrink towards the sliding load; what converged before it stays."""
    out = start(footing())
    with pytest.raises(NotConverged) as caught:
        out.driver.run(stage({}, force=(1.3 * CAPACITY, 0.0, 0.0)), out.steps.append)
    assert out.steps[-1].fraction * 1.3 == pytest.approx(1.0, rel=1e-3)
    assert caught.value.history
    assert len(out.driver.given_up) < 60
    reached = out.steps[-1].increment.residual.border[0]
    assert reached == pytest.approx(1.3 * CAPACITY * out.steps[-1].fraction, rel=1e-5)


def test_the_soil_is_viscous_once_an_attempt_has_been_given_up():
    """Not before: then every bit is that of a run without viscosity; overstress adds to the load."""
    plain, unneeded, viscous = (start(footing()) for _ in range(3))
    viscous.driver.given_up.append(FAILED)
    for out, lag in ((plain, 0.0), (unneeded, 0.1), (viscous, 0.1)):
        out.driver.run(replace(KINDS["pull"], lag=lag), out.steps.append)
    loads = [[step.multipliers[0] for step in out.steps] for out in (plain, unneeded, viscous)]
    assert loads[0] == loads[1]
    assert loads[2][3] > 1.05 * loads[0][3]  # on the way to the sliding load


# --- going on from a saved position -------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "lag"), [("pull", 0.0), ("pull", 0.1), ("load", 0.0)])
def test_a_new_driver_goes_on_from_any_step_bit_by_bit(kind, lag):
    """Two stages; a driver that starts anew after each step ends in the same bits as one that never stopped."""
    stages = [replace(KINDS[kind], lag=lag), stage({0: 1.0e-4}, arm=0.3)]
    straight, out = start(footing()), start(footing())
    straight.driver.given_up.append(FAILED)
    for each in stages:
        straight.driver.run(each, straight.steps.append)
    for number, each in enumerate(stages):
        position = None
        while position is None or position.done < 1.0:
            driver = Driver(out.driver.newton, out.state, [], [FAILED], n_steps=len(out.steps), force=out.driver.force)
            with pytest.raises(_Stopped):
                driver.run(each, lambda step: _stop_after(out.steps, step), position)
            position = driver.position
        assert position.done == 1.0 and len(out.steps) >= 3 * (number + 1)
        out.driver.run(each, out.steps.append, position)  # nothing is left to do but to close the stage
    np.testing.assert_array_equal(out.state.committed.stress, straight.state.committed.stress)
    np.testing.assert_array_equal(out.state.committed.border, straight.state.committed.border)
    assert [(s.stage, s.fraction, s.limit) for s in out.steps] == [
        (s.stage, s.fraction, s.limit) for s in straight.steps
    ]


class _Stopped(Exception):
    """Stands for anything that ends a run."""


def _stop_after(steps, step):
    steps.append(step)
    raise _Stopped


# --- stiffness of an increment ---------------------------------------------------------------------------------


def test_the_stiffness_of_an_increment_is_the_work_of_the_force_over_the_motion():
    """Of an elastic footing: f.q over |s q|^2 of q = K^-1 f, between the extreme eigenvalues of K/(s s)."""
    scale = np.array([1.0, 1.0, 4.0])
    model = replace(footing(soil(elastic.LAW)), border_scale=scale)
    k, f = start(model).driver.newton.border_stiffness(State(model)), np.array([1.0, 2.0, -0.5])
    out = run(model, stage({}, force=tuple(f), first_fraction=0.5, max_fraction=0.5))
    q = np.linalg.solve(k, f)
    assert out.driver.stiffness == pytest.approx(f @ q / np.sum((scale * q) ** 2), rel=1.0e-4)
    least, most = np.linalg.eigvalsh(0.5 * (k + k.T) / np.outer(scale, scale))[[0, -1]]
    assert least < out.driver.stiffness < most


def test_where_no_force_is_given_there_is_no_such_stiffness():
    assert run(footing(), stage({0: 1.0e-6})).driver.stiffness is None


def test_an_increment_that_is_refused_is_tried_again_in_a_smaller_one():
    """Up to half of the stage; beyond, every attempt is given up and recorded, and the reason ends the stage."""
    pull = KINDS["pull"]
    half = 0.5 * abs(run(footing(), pull).state.committed.border[0])
    out = start(footing())
    out.driver.refusal = lambda border: "too far" if abs(border[0]) > half * (1.0 + 1e-9) else ""
    with pytest.raises(NotConverged, match=r"^too far; last residuals") as stopped:
        out.driver.run(pull, out.steps.append)
    assert stopped.value.refused
    assert out.steps[-1].fraction == pytest.approx(0.5, abs=1e-5)
    assert {error.reason for _, _, error in out.driver.given_up} == {"too far"}
    assert sum(not row["converged"] for row in out.driver.record) >= len(out.driver.given_up) > 0
