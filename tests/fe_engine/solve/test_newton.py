# SPDX-License-Identifier: MIT
"""Newton on a small footing: equilibrium, controls, order of convergence, and what a failure tells."""

import numpy as np
import pytest

from fe_engine.contact import coulomb
from fe_engine.errors import LawError, LinearSolverError, NotConverged
from fe_engine.linear.backends import available_backends
from fe_engine.solve.newton import Loading
from fe_engine.state import State
from tests.support.models import CONTACT, EARLIER, OWN, footing, replace, run, stage, start, taylor_slope

VERTICAL = 2.0e4 * 0.5  # N: initial pressure times the area of the footing
STEPS = {"first_fraction": 0.05, "max_fraction": 0.2}
STAGES = {
    "pull": stage({0: 1.0e-3}, arm=0.3, **STEPS),
    "translation": stage({0: 1.0e-3, 2: 0.0}, **STEPS),
    "rotation": stage({0: 0.0, 2: -1.0e-3}, **STEPS),
    "heave fixed": stage({0: 1.0e-3, 1: 0.0}, arm=0.3, **STEPS),
}


@pytest.fixture(scope="module", params=STAGES)
def done(request):
    """A finished run, with its stage."""
    return run(footing(), STAGES[request.param], tolerance=1.0e-11), STAGES[request.param]


def imposed(border):
    """Loading that imposes all three dofs of the body."""
    return Loading(np.eye(3), np.asarray(border, dtype=float), np.eye(3), np.zeros(3))


def at_rest(out):
    return np.zeros(out.driver.newton.system.pattern.n_free), np.zeros(3)


# --- equilibrium and controls -----------------------------------------------------------------------------


def test_multipliers_balance_the_controlled_rows():
    """Pull at 2 m above the reference: the force H brings the moment -2 H along."""
    loading = Loading(
        np.array([[1.0, 0.0, 0.0]]), np.ones(1), np.array([[1.0], [0.0], [-2.0]]), np.array([0.0, 7.0, 0.0])
    )
    np.testing.assert_allclose(loading.multipliers(np.array([5.0, 9.0, 1.0])), [5.0])
    np.testing.assert_allclose(loading.unbalanced(np.array([5.0, 9.0, 1.0])), [0.0, 2.0, 11.0])


def test_without_controls_everything_is_unbalanced():
    loading = Loading(np.zeros((0, 3)), np.zeros(0), np.zeros((3, 0)), np.array([1.0, 0.0, 0.0]))
    assert loading.multipliers(np.ones(3)).shape == (0,)
    np.testing.assert_array_equal(loading.unbalanced(np.ones(3)), [0.0, 1.0, 1.0])


def test_controls_are_met_exactly_at_every_step(done):
    out, each = done
    np.testing.assert_allclose(each.control @ out.state.committed.border, each.target, rtol=1e-12, atol=1e-15)


def test_reactions_balance_the_loads_and_leave_nothing_free(done):
    out, each = done
    last = out.steps[-1]
    np.testing.assert_allclose(last.increment.residual.border, each.load @ last.multipliers, atol=1e-7)
    assert np.abs(last.increment.residual.free).max() < 1.0e-6
    assert last.increment.record[-1]["residual"] <= 1.0e-11


def test_reactions_are_the_station_forces(done):
    out, _ = done
    stations, state = out.driver.newton.system.model.stations, out.state.committed
    change = state.traction + np.array([20.0e3, 0.0, 0.0])
    force = -stations.area[:, None] * np.einsum("si,sij->sj", change, stations.frame)
    expected = np.einsum("sij,si->j", stations.body, force)
    np.testing.assert_allclose(out.steps[-1].increment.residual.border, expected, atol=1e-8)


@pytest.mark.parametrize("mu", [0.1, 0.5, 1.0])
def test_the_footing_slides_at_mu_times_its_load(mu):
    model = footing(contact=(*CONTACT[:2], mu), material=None)
    out = run(model, stage({0: 1.0e-2, 2: 0.0}, first_fraction=0.01, max_fraction=0.5), tolerance=1.0e-10)
    assert out.steps[-1].multipliers[0] == pytest.approx(mu * VERTICAL, rel=1e-8)


@pytest.mark.parametrize("name", available_backends())
def test_every_backend_gives_the_same_answer(name):
    one, two = (run(footing(), STAGES["pull"], linear=each, tolerance=1.0e-11) for each in ("superlu", name))
    np.testing.assert_allclose(two.state.committed.border, one.state.committed.border, rtol=1e-8)
    np.testing.assert_allclose(two.steps[-1].multipliers, one.steps[-1].multipliers, rtol=1e-9)


def test_nothing_to_do_takes_no_iteration():
    out = start(footing())
    increment = out.driver.newton.solve(out.state, imposed(np.zeros(3)), *at_rest(out))
    assert increment.iterations == 0
    assert not np.any(increment.residual.border)


# --- tangents and order -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", STAGES)
def test_last_iterations_are_quadratic(name):
    """Order log(e3/e2)/log(e2/e1) of the last iterations that rounding has not reached, over three series of steps."""
    orders = []
    runs = (run(footing(), replace(STAGES[name], first_fraction=f), tolerance=1.0e-11) for f in (0.04, 0.05, 0.1))
    for step in (step for out in runs for step in out.steps):
        rows = [row for row in step.increment.record if row["residual"] > 1.0e-12][-3:]
        # in a regime of its own: nothing opens, slips or yields any more
        settled = len({(row["n_open"], row["n_slip"], row["n_plastic"], row["n_apex"]) for row in rows[-2:]}) == 1
        last = np.log([row["residual"] for row in rows])
        if settled and len(rows) == 3 and last[0] < np.log(0.1) and last[1] < last[0]:
            orders.append((last[2] - last[1]) / (last[1] - last[0]))
    assert len(orders) >= 6
    assert np.median(orders) > 1.8
    assert min(orders) > 1.5


def test_initial_border_stiffness_is_the_slope_of_tiny_moves():
    out = start(footing(), tolerance=1.0e-10)
    newton = out.driver.newton
    stiffness = newton.border_stiffness(out.state)
    for i, size in enumerate(1.0e-9 * np.eye(3)):
        out.state.reset_trial()
        force = newton.solve(out.state, imposed(size), *at_rest(out)).residual.border
        np.testing.assert_allclose(stiffness[:, i], force / 1.0e-9, atol=1e-6 * stiffness.max())
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-9 * stiffness.max())


def test_border_stiffness_leaves_the_state_alone():
    out = run(footing(), STAGES["pull"])
    before = out.state.committed.stress.tobytes()
    first = out.driver.newton.border_stiffness(out.state)
    np.testing.assert_array_equal(out.driver.newton.border_stiffness(out.state), first)
    assert out.state.committed.stress.tobytes() == before


def test_condensed_tangent_in_a_yielding_slipping_state():
    """Reactions of the body as a function of its imposed motion, from one committed state."""
    out = start(footing(), tolerance=1.0e-13, max_iterations=40)
    newton, state, at = out.driver.newton, out.state, np.array([8.0e-5, 2.0e-5, -1.0e-5])
    guess = newton.solve(state, imposed(at), *at_rest(out)).free

    def reactions(border):
        return newton.solve(state, imposed(border), guess, border).residual.border

    first = newton.solve(state, imposed(at), *at_rest(out))
    assert min(first.residual.n_plastic, first.residual.n_slip) > 0
    _, _, tangent = newton.system.linearise(state, True)
    newton.solver.factorise(tangent.matrix)
    stiffness = tangent.corner - tangent.rows @ newton.solver.solve(tangent.columns)
    assert taylor_slope(reactions, stiffness, at, at, np.geomspace(1e-2, 1e-3, 4)) == pytest.approx(2.0, abs=0.1)


# --- failures ---------------------------------------------------------------------------------------------


def failure(out, target=(2.0e-3, 0.0, 0.0), guess=None):
    with pytest.raises(NotConverged) as caught:
        out.driver.newton.solve(out.state, imposed(target), *(guess or at_rest(out)))
    return caught.value


def test_too_few_iterations_tell_history_and_place():
    error = failure(start(footing(), max_iterations=2))
    assert error.reason == "no convergence in 2 iterations"
    assert [row["iteration"] for row in error.history] == [0, 1, 2]
    assert {"residual", "correction", "damping", "n_open", "n_slip", "n_plastic", "n_apex"} <= set(error.history[0])
    assert error.place.startswith("node ")
    assert "at x=" in error.place
    assert error.place in str(error)
    assert f"{error.history[-1]['residual']:.1e}" in str(error)


def test_place_is_where_the_residual_is_largest():
    out = start(footing(), max_iterations=1)
    error, system = failure(out), out.driver.newton.system
    out.driver.newton.settings = replace(out.driver.newton.settings, max_iterations=0)
    assert error.place in [system.place_of_equation(e) for e in range(system.pattern.n_free)]


def test_a_residual_that_is_no_number_stops_at_once():
    out = start(footing())
    free, border = at_rest(out)
    error = failure(out, guess=(np.full_like(free, np.nan), border))
    assert error.reason == "residual is not finite"
    assert len(error.history) == 1


def test_iterations_without_progress_stop_early(monkeypatch):
    out = start(footing(), max_iterations=50)
    solver = out.driver.newton.solver
    monkeypatch.setattr(solver, "solve", np.zeros_like)
    error = failure(out)
    assert error.reason == "the residual stalls"
    assert len(error.history) < 10


def test_half_steps_lead_out_of_a_cycle_close_to_the_solution(monkeypatch):
    """A direction twice as long as Newton's jumps across the solution for ever; half of it is the solution."""
    out = start(footing(), tolerance=1.0e-9)
    newton = out.driver.newton
    step = newton.stage.step

    monkeypatch.setattr(newton.stage, "step", lambda *given: tuple(2.0 * part for part in step(*given)))
    increment = newton.solve(out.state, imposed([1.0e-5, 0.0, 0.0]), *at_rest(out))
    damped = [row["damping"] for row in increment.record]
    assert damped.count(0.5) >= 1
    assert increment.record[-1]["residual"] <= 1.0e-9


def jumps(newton, monkeypatch, at, longer=1.0):
    """Residuals a hundred times as large at the evaluation of that number; the correction from there ``longer``."""
    linearise, step, models = newton.system.linearise, newton.stage.step, []

    def evaluate(state, fresh):
        judged, linear, tangent = linearise(state, fresh)
        models.append(linear)
        far = len(models) == at + 1
        return (replace(judged, free=100.0 * judged.free) if far else judged), linear, tangent

    def lengthened(linear, *given):
        far = len(models) > at and linear is models[at]
        return tuple((longer if far else 1.0) * part for part in step(linear, *given))

    monkeypatch.setattr(newton.system, "linearise", evaluate)
    monkeypatch.setattr(newton.stage, "step", lengthened)


def test_a_step_whose_residual_jumps_is_taken_where_the_next_correction_is_smaller(monkeypatch):
    """As friction makes it jump; looking ahead costs no more factorisations than going on."""
    plain, jumped = start(footing()), start(footing())
    loading = imposed([5.0e-5, 0.0, 0.0])
    straight = plain.driver.newton.solve(plain.state, loading, *at_rest(plain))
    jumps(jumped.driver.newton, monkeypatch, at=3)
    increment = jumped.driver.newton.solve(jumped.state, loading, *at_rest(jumped))
    assert [row["damping"] for row in increment.record] == [1.0] * len(increment.record)
    assert increment.record[3]["residual"] > increment.record[2]["residual"]
    assert increment.iterations == straight.iterations
    assert jumped.driver.newton.solver.n_factorisations == plain.driver.newton.solver.n_factorisations


def test_a_step_whose_residual_jumps_is_shortened_where_the_next_correction_is_larger(monkeypatch):
    out = start(footing())
    jumps(out.driver.newton, monkeypatch, at=3, longer=1.0e3)
    increment = out.driver.newton.solve(out.state, imposed([5.0e-5, 0.0, 0.0]), *at_rest(out))
    assert increment.record[2]["damping"] == 0.5
    assert increment.record[-1]["residual"] <= out.driver.newton.settings.tolerance


@pytest.mark.parametrize(("tolerance", "recycling"), [(1.0e-2, OWN), (3.0e-3, EARLIER)])
def test_the_border_is_held_ten_times_closer_to_balance(tolerance, recycling):
    """What the tolerance of all equations would leave there (0.29 and 0.11 of it) turns the body."""
    wanted, left = STAGES["heave fixed"], []
    out = run(footing(), wanted, tolerance=tolerance, recycling=recycling, shares=(0.01, 0.1))
    for step in out.steps:
        residual = step.increment.residual
        unbalanced = np.linalg.norm(residual.border - wanted.load @ step.multipliers)
        left.append(unbalanced / max(residual.contact_norm, np.linalg.norm(residual.border)))
    assert max(left) <= 0.1 * tolerance
    assert max(step.increment.record[-1]["residual"] for step in out.steps) > 0.5 * tolerance


def test_a_change_beneath_rounding_counts_beside_the_initial_forces(monkeypatch):
    """Rounding of 1e-13 of the initial forces, which no iteration can reduce, does not stop a move of 1e-18 m."""
    out = start(footing())
    system = out.driver.newton.system
    noise, linearise = 1.0e-13 * system.initial_contact_norm, system.linearise

    def noisy(state, fresh):
        judged, linear, tangent = linearise(state, fresh)
        return replace(judged, free=judged.free + noise), linear, tangent

    monkeypatch.setattr(system, "linearise", noisy)
    increment = out.driver.newton.solve(out.state, imposed([1.0e-18, 0.0, 0.0]), *at_rest(out))
    assert increment.iterations <= 1
    assert increment.record[-1]["residual"] <= 1.0e-6


@pytest.mark.parametrize("kind", [LawError, LinearSolverError])
def test_errors_of_the_parts_become_not_converged(monkeypatch, kind):
    out = start(footing())
    part, name = {
        LawError: (out.driver.newton.system, "linearise"),
        LinearSolverError: (out.driver.newton.solver, "solve"),
    }[kind]

    def fail(*_):
        raise kind("element 7 at x=1")

    monkeypatch.setattr(part, name, fail)
    assert failure(out).reason == "element 7 at x=1"


def test_a_law_that_fails_in_the_line_search_shortens_the_step(monkeypatch):
    out = start(footing())
    system, linearise, calls = out.driver.newton.system, out.driver.newton.system.linearise, []

    def fail_once(state, fresh):
        calls.append(1)
        if len(calls) == 3:  # start, first step, and the full second one
            raise LawError("too far")
        return linearise(state, fresh)

    monkeypatch.setattr(system, "linearise", fail_once)
    increment = out.driver.newton.solve(out.state, imposed([5.0e-5, 0.0, 0.0]), *at_rest(out))
    assert increment.record[1]["damping"] == 0.5


def test_a_border_dof_without_stiffness_is_named():
    model = footing()
    body = np.concatenate([model.stations.body, np.zeros((len(model.stations), 3, 1))], axis=2)
    loose = replace(model, n_border=4, border_scale=np.ones(4), stations=replace(model.stations, body=body))
    out = start(loose)
    loading = Loading(np.eye(4)[:1], np.array([1.0e-5]), np.eye(4)[:, :1], np.zeros(4))
    with pytest.raises(NotConverged, match="tangent stiffness of the border dofs is singular"):
        out.driver.newton.solve(State(loose), loading, at_rest(out)[0], np.zeros(4))


def test_a_smooth_footing_has_no_lateral_stiffness():
    model = footing()
    smooth = replace(model, contact=coulomb.pack(*CONTACT[:2], 0.0)[None])
    rough, slippery = (start(m).driver.newton.border_stiffness(State(m)) for m in (model, smooth))
    assert rough[0, 0] > 1.0e7
    np.testing.assert_allclose(slippery[0], 0.0, atol=1e-6 * rough[0, 0])
