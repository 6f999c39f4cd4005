# SPDX-License-Identifier: MIT
"""Fast assembly against a plain loop, entry by entry; global tangent; repeatability."""

import numba
import numpy as np
import pytest

from fe_engine.assembly import kernels, kernels_stations
from fe_engine.assembly.system import System
from fe_engine.contact import coulomb
from fe_engine.contact.law import Slide
from fe_engine.elements import hex8
from fe_engine.errors import LawError, ModelError
from fe_engine.model import Model
from fe_engine.soil import elastic
from fe_engine.soil.law import Point
from fe_engine.state import FIELDS, State
from tests.support.models import box, footing, mixed, replace, soil, start, taylor_slope

# size of the random moves: cracks the contacts (gap at 1e-4 m) and shears the sand
MOVE = 6.0e-5


def moved(model, seed=0, commits=1):
    """System and state after committed random moves and one trial move."""
    system, state, rng = System(model), State(model), np.random.default_rng(seed)
    for step in range(commits + 1):
        system.apply(state, *random_move(system, rng))
        system.residual(state)
        if step < commits:
            state.commit()
    return system, state, rng


def random_move(system, rng, size=MOVE):
    return size * rng.normal(size=system.pattern.n_free), size * rng.normal(size=system.model.n_border)


# --- the plain loop ---------------------------------------------------------------------------------------


def constraint(model):
    """Matrix (3 n + nb, n_free + nb): all dofs in global axes from the free and border ones."""
    n, nb = 3 * model.mesh.n_nodes, model.n_border
    follows = {(int(node), int(i)): (int(j), share) for node, i, j, share in model.followers}
    free = [d for d in range(n) if divmod(d, 3) not in follows and not model.fixed[divmod(d, 3)]]
    reduce, turn = np.zeros((n + nb, len(free) + nb)), np.eye(n + nb)
    reduce[free, np.arange(len(free))] = 1.0
    reduce[n:, len(free) :] = np.eye(nb)
    for (node, i), (j, share) in follows.items():
        reduce[3 * node + i, len(free) + j] = share
    for node, frame in model.frames.items():
        turn[3 * node : 3 * node + 3, 3 * node : 3 * node + 3] = frame.T
    return turn @ reduce, turn[:n, :n]


def strain_operators(corners):
    """B-bar (6, 24) and volume of the eight Gauss points of one element."""
    one, operators, volumes = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), [], []
    for xi in hex8.GAUSS:
        jacobian = hex8.shape_gradient(xi).T @ corners
        gradient, b = hex8.shape_gradient(xi) @ np.linalg.inv(jacobian).T, np.zeros((6, 24))
        for row, parts in enumerate(
            [[(0, 0)], [(1, 1)], [(2, 2)], [(0, 1), (1, 0)], [(1, 2), (2, 1)], [(2, 0), (0, 2)]]
        ):
            for component, along in parts:
                b[row, component::3] = gradient[:, along]
        operators.append(b)
        volumes.append(np.linalg.det(jacobian))
    mean = sum(v * one @ b for v, b in zip(volumes, operators, strict=True)) / sum(volumes)
    return [b + np.outer(one, mean - one @ b) / 3.0 for b in operators], volumes


def plain_loop(model, state, guesses=None):
    """Residual and tangent, dense: every element, Gauss point and station in turn.

    ``guesses`` (ns, 3) are the traction iterates of the friction law; None: the law's own tractions.
    """
    old, new, nb, nodes = state.committed, state.trial, model.n_border, model.mesh.nodes
    reduce, turn = constraint(model)
    n = nodes.size
    shift = turn @ (new.displacement - old.displacement).ravel()
    force, stiffness = np.zeros(n + nb), np.zeros((n + nb, n + nb))
    for e, corners in enumerate(model.mesh.hexes):
        dofs = (3 * corners[:, None] + np.arange(3)).ravel()
        material = model.materials[model.material[e]]
        for g, (b, volume) in enumerate(zip(*strain_operators(nodes[corners]), strict=True)):
            stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
            before, after = Point(old.stress[e, g], old.history[e, g]), Point(stress, history)
            material.law.update(material.parameters, b @ shift[dofs], before, after, tangent, True)
            force[dofs] += volume * b.T @ (stress - model.initial_stress[e, g])
            stiffness[np.ix_(dofs, dofs)] += volume * b.T @ tangent @ b
    s = model.stations
    for k in range(len(s)):
        jump = np.zeros((3, n + nb))
        for node, weight in zip(s.nodes[k], s.weight[k], strict=True):
            jump[:, 3 * node : 3 * node + 3] += weight * s.frame[k]
        jump[:, n:] = -s.frame[k] @ s.body[k]
        w, w_old = (jump @ np.concatenate([turn @ f.displacement.ravel(), f.border]) for f in (new, old))
        p, p0 = model.contact[k], model.initial_pressure[k]
        guess, traction, tangent = np.zeros(3), np.zeros(3), np.zeros((3, 3))
        slide = Slide(w, w_old, old.traction[k], p0)
        coulomb.update(p, slide, guess)
        guess = guess if guesses is None else guesses[k]
        coulomb.linearise(p, slide, guess, traction, tangent)
        force += s.area[k] * jump.T @ (traction + np.array([p0, 0.0, 0.0]))
        stiffness += s.area[k] * jump.T @ tangent @ jump
    return reduce.T @ force, reduce.T @ stiffness @ reduce


def dense(residual, tangent):
    """The fast residual and tangent as one vector and one matrix."""
    matrix = np.block([[tangent.matrix.toarray(), tangent.columns], [tangent.rows, tangent.corner]])
    return np.concatenate([residual.free, residual.border]), matrix


def assert_entries(got, wanted):
    np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-13 * np.abs(wanted).max())


@pytest.mark.parametrize("rule", ["nodal", "gauss", "pairs"])
def test_assembly_equals_the_plain_loop_entry_by_entry(rule):
    model = mixed(rule)
    system, state, _ = moved(model)
    judged, linear, tangent = system.linearise(state, True)
    force, stiffness = plain_loop(model, state)
    assert min(judged.n_plastic, judged.n_apex) > 0
    assert {0, 1, 2} == set(system.contact_state)
    got, matrix = dense(linear, tangent)
    assert_entries(got, force)
    assert_entries(matrix, stiffness)
    assert_entries(np.concatenate([judged.free, judged.border]), force)


def test_a_second_linearisation_goes_on_from_the_first_ones_tractions():
    """The traction iterate is the last linear model at the new jump; a station seen open starts afresh."""
    model = mixed()
    system, state, rng = moved(model)
    system.linearise(state, True)
    jump, traction, tangent = (each.copy() for each in system._iterate)
    system.apply(state, *random_move(system, rng))
    judged, linear, second = system.linearise(state, False)
    now = kernels_stations.station_jumps(system.stations, state.trial.displacement, state.trial.border)
    guesses = traction + np.einsum("sij,sj->si", tangent, now - jump)
    fresh = traction[:, 0] == 0.0
    guesses[fresh] = state.trial.traction[fresh]
    assert fresh.any()
    force, stiffness = plain_loop(model, state, guesses)
    got, matrix = dense(linear, second)
    assert_entries(got, force)
    assert_entries(matrix, stiffness)
    assert_entries(np.concatenate([judged.free, judged.border]), plain_loop(model, state)[0])
    assert np.abs(got - plain_loop(model, state)[0]).max() > 1.0


def test_station_on_a_node_with_axes_of_its_own_is_refused():
    with pytest.raises(ModelError, match="axes of its own"):
        System(mixed(skew_stations=True))


@pytest.mark.slow
def test_more_elements_than_a_batch():
    """Elastic, so the residual is the tangent times the displacement; 4,335 elements are two batches."""
    mesh = box((17, 17, 15), (1.0, 1.0, 1.0), distort=0.05)
    assert mesh.n_elements > kernels.BATCH
    model = Model(
        mesh, [soil(elastic.LAW)], np.zeros(mesh.n_elements, dtype=np.int64), np.zeros((mesh.n_elements, 8, 6)),
        np.zeros((mesh.n_nodes, 3), dtype=bool),
    )  # fmt: skip
    system, state = System(model), State(model)
    move, none = random_move(system, np.random.default_rng(0))
    system.apply(state, move, none)
    alone = system.residual(state).free
    judged, _, tangent = system.linearise(state, True)
    np.testing.assert_array_equal(alone, judged.free)
    np.testing.assert_allclose(tangent.matrix @ move, alone, atol=1e-11 * np.abs(alone).max())


# --- tangent ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rule", "relaxed"), [("nodal", 1.0), ("gauss", 1.0), ("pairs", 1.0), ("nodal", 0.3)])
def test_global_tangent_with_every_regime_at_once(rule, relaxed):
    system, state, rng = moved(mixed(rule))
    system.relax(relaxed)
    judged, linear, tangent = system.linearise(state, True)
    elastic = system.regime.size - judged.n_plastic - judged.n_apex
    stick = len(system.contact_state) - judged.n_slip - judged.n_open
    assert min(elastic, judged.n_plastic, judged.n_apex, judged.n_slip, judged.n_open, stick) > 0
    _, matrix = dense(linear, tangent)
    n = system.pattern.n_free
    regimes = system.regime.copy(), system.contact_state.copy()
    at = inverse(system, state)

    def residual(x):
        system.apply(state, x[:n], x[n:])
        out = system.residual(state)
        np.testing.assert_array_equal(system.regime, regimes[0])
        np.testing.assert_array_equal(system.contact_state, regimes[1])
        return np.concatenate([out.free, out.border])

    step = np.concatenate(random_move(system, rng))
    assert taylor_slope(residual, matrix, at, step, np.geomspace(3e-3, 1e-4, 5)) == pytest.approx(2.0, abs=0.1)


def inverse(system, state):
    """Free and border increments of the trial: what apply was called with."""
    equation = system.pattern.equation
    change = state.trial.displacement - state.committed.displacement
    free = np.zeros(system.pattern.n_free)
    free[equation[equation >= 0]] = change[equation >= 0]
    return np.concatenate([free, state.trial.border - state.committed.border])


# --- repeatability ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", ["nodal", "gauss", "pairs"])
def test_nothing_moves_at_zero_displacement(rule):
    model = mixed(rule)
    system, state = System(model), State(model)
    judged, linear, _ = system.linearise(state, True)
    for out in (judged, linear, system.residual(state)):
        assert not np.any(out.free)
        assert not np.any(out.border)
        assert (out.contact_norm, out.n_plastic, out.n_apex, out.n_slip, out.n_open) == (0.0, 0, 0, 0, 0)
    np.testing.assert_array_equal(state.trial.stress, model.initial_stress)
    np.testing.assert_array_equal(state.trial.traction[:, 0], -model.initial_pressure)
    assert not np.any(state.trial.history)


def test_twice_the_same_and_the_committed_fields_only_read():
    system, state, _ = moved(mixed())
    before = {name: getattr(state.committed, name).tobytes() for name in FIELDS}
    first, again = system.residual(state), system.residual(state)
    judged, _, tangent = system.linearise(state, True)
    data = tangent.matrix.data.copy()
    _, _, second = system.linearise(state, True)
    for out in (again, judged):
        np.testing.assert_array_equal(out.free, first.free)
        np.testing.assert_array_equal(out.border, first.border)
    np.testing.assert_array_equal(second.matrix.data, data)
    assert before == {name: getattr(state.committed, name).tobytes() for name in FIELDS}


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")
def test_result_does_not_depend_on_the_number_of_threads():
    answers, before = [], numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            system, state, _ = moved(mixed())
            _, linear, tangent = system.linearise(state, True)
            answers.append([*dense(linear, tangent), state.trial.stress])
    finally:
        numba.set_num_threads(before)
    for one, two in zip(*answers, strict=True):
        np.testing.assert_array_equal(one, two)


def test_contact_norm_is_the_change_of_the_station_forces():
    model = mixed("gauss")
    _, state, _ = moved(model)
    system = System(model)
    change = state.trial.traction + model.initial_pressure[:, None] * [1.0, 0.0, 0.0]
    expected = np.linalg.norm(model.stations.area[:, None] * change)
    assert system.residual(state).contact_norm == pytest.approx(expected, rel=1e-12)


# --- messages ---------------------------------------------------------------------------------------------


def test_a_law_that_fails_names_its_element_and_place(monkeypatch):
    system = System(model := mixed())
    monkeypatch.setattr(system, "assemble", lambda *_: 5)
    x, y, z = model.mesh.nodes[model.mesh.hexes[5]].mean(axis=0)
    with pytest.raises(LawError, match=rf"soil law .* in element 5 at x={x:.3f}, y={y:.3f}, z={z:.3f} m"):
        system.residual(State(model))


def test_place_of_an_equation_names_its_node():
    system = System(model := mixed())
    node, component = 30, 0
    x, y, z = model.mesh.nodes[node]
    equation = system.pattern.equation[node, component]
    assert equation >= 0
    element = int(np.flatnonzero((system.hexes == 30).any(axis=1))[0])
    expected = f"node 30 of element {element}, direction x, at x={x:.3f}, y={y:.3f}, z={z:.3f} m"
    assert system.place_of_equation(equation) == expected


def test_system_refuses_a_model_that_does_not_fit():
    with pytest.raises(ModelError, match="fixed has shape"):
        System(replace(mixed(), fixed=np.zeros((3, 3), dtype=bool)))


@pytest.mark.slow
def test_traction_iterates_that_are_taken_back_leave_no_trace():
    """A line search that goes back linearises as if it had never been further."""
    out = start(footing())
    system = out.driver.newton.system
    moves = np.random.default_rng(3).normal(scale=2.0e-6, size=(2, system.pattern.n_free))

    for k in range(2):
        system.apply(out.state, moves[k], np.array([2.0e-6, 0.0, 0.0]))
        system.linearise(out.state, k == 0)
        if k == 0:
            kept = system.remember_iterates()
    moved = system.remember_iterates()
    assert not np.array_equal(moved[0], kept[0])
    system.take_back(kept)
    for mine, before in zip(system.remember_iterates(), kept, strict=True):
        np.testing.assert_array_equal(mine, before)
