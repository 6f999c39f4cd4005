# SPDX-License-Identifier: MIT
"""Pore water of soil and interface against a plain loop; its tangent; what holds for every mesh."""

import numpy as np
import pytest

from fe_engine.assembly.scatter import Forces
from fe_engine.assembly.system import System
from fe_engine.balance.water import WaterBalance
from fe_engine.contact.flow import transmissivity
from fe_engine.elements import biot, hex8
from fe_engine.errors import ModelError
from fe_engine.model import Model, Stage
from fe_engine.state import State, initial_fields
from tests.support.models import EARLIER, mixed, replace, stage, start, taylor_slope, wet

MOVE, DT = 6.0e-5, 0.7
RULES = ("nodal", "gauss", "pairs")


def moved(model: Model, seed: int = 0, size: float = MOVE) -> tuple[System, State, np.ndarray]:
    """System, state after a committed random move and a trial move, and that trial move."""
    system, state, rng = System(model), State(model), np.random.default_rng(seed)
    system.time_step = DT
    n = system.pattern.n_free
    for _ in range(2):
        state.commit()
        move = size * rng.normal(size=n + model.n_border)
        system.apply(state, move[:n], move[n:])
        system.residual(state)
    return system, state, move


# --- the plain loop ---------------------------------------------------------------------------------------


def element_terms(model: Model, e: int):
    """Mean gradient of the nodes, nodal volumes, and the 8 x 8 matrices of seepage and storage of one element."""
    corners, water = model.mesh.nodes[model.mesh.hexes[e]], model.water
    points = []
    for xi in hex8.GAUSS:
        jacobian = hex8.shape_gradient(xi).T @ corners
        points.append((hex8.shape(xi), hex8.shape_gradient(xi) @ np.linalg.inv(jacobian).T, np.linalg.det(jacobian)))
    volume = sum(v for _, _, v in points)
    mean = sum(v * g for _, g, v in points) / volume
    nodal = sum(v * n for n, _, v in points)
    seepage = water.mobility * sum(v * g @ g.T for _, g, v in points)
    storage = sum(v * water.storage * np.outer(n, n) for n, _, v in points)
    storage += sum(v * water.stabilisation * np.outer(n - nodal / volume, n - nodal / volume) for n, _, v in points)
    return mean, nodal, seepage, storage


def global_motion(model: Model, fields) -> np.ndarray:
    """Displacements (n, 3) in global axes."""
    u = fields.displacement.copy()
    for node, frame in model.frames.items():
        u[node] = frame.T @ u[node]
    return u


def gaps(model: Model, fields) -> np.ndarray:
    s, out = model.stations, []
    for k in range(len(s)):
        x = s.weight[k] @ fields.displacement[s.nodes[k]] - s.body[k] @ fields.border
        kn = np.broadcast_to(model.contact, (len(s), 3))[k, 0]
        out.append(max(s.frame[k, 0] @ x - model.initial_pressure[k] / kn, 0.0))
    return np.array(out)


def plain_water(model: Model, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces (n, 3) in global axes, border forces, and volumes (n + nf,) that leave the nodes over the step."""
    old, new, mesh, film = state.committed, state.trial, model.mesh, model.water.film
    n = mesh.n_nodes
    force, border, leaves = np.zeros((n, 3)), np.zeros(model.n_border), np.zeros(n + film.n_nodes)
    step = global_motion(model, new) - global_motion(model, old)
    for e, nodes in enumerate(mesh.hexes):
        mean, nodal, seepage, storage = element_terms(model, e)
        p, change = new.pressure[nodes], new.pressure[nodes] - old.pressure[nodes]
        force[nodes] -= mean * (nodal @ p)
        leaves[nodes] += nodal * np.sum(mean * step[nodes]) + storage @ change + DT * seepage @ p
    s, gap_old, gap = model.stations, gaps(model, old), gaps(model, new)
    for k in range(len(s)):
        p3 = film.weight[k] @ new.pressure[n + film.nodes[k]]
        pushes = -s.area[k] * p3 * s.frame[k, 0]
        border -= s.body[k].T @ pushes
        for node, share in zip(s.nodes[k], s.weight[k], strict=True):
            force[node] += share * pushes
        flows_in = -(gap[k] - gap_old[k]) / DT
        for sign in (1.0, -1.0):
            side = np.maximum(sign * s.weight[k], 0.0)
            if side.any():
                transfer = film.transfer * (side @ new.pressure[s.nodes[k]] - p3)
                np.add.at(leaves, s.nodes[k], DT * s.area[k] * side * transfer)
                flows_in += transfer
        np.add.at(leaves, n + film.nodes[k], -DT * s.area[k] * film.weight[k] * flows_in)
    for f, nodes in enumerate(film.faces):
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        for g, point in enumerate(corners / np.sqrt(3.0)):
            shape = np.prod(1 + corners * point, axis=1) / 4
            h = film.residual_aperture + gap[film.corners[f]]
            gradient = film.gradient[f, g]
            mobility = shape @ h**3 / (12.0 * film.viscosity)
            flow = gradient @ gradient.T @ new.pressure[n + nodes]
            np.add.at(leaves, n + nodes, DT * film.area[f, g] * mobility * flow)
    return force, border, leaves


@pytest.mark.parametrize("rule", RULES)
def test_water_is_the_plain_loop(rule):
    model = wet(rule)
    system, state, _ = moved(model)
    free, border = np.zeros(system.pattern.n_free), np.zeros(model.n_border)
    add_water(system, state, free, border)
    force, expected_border, leaves = plain_water(model, state)
    for node, frame in model.frames.items():
        force[node] = frame @ force[node]
    expected = np.zeros(system.pattern.n_free)
    for node, equations in enumerate(system.pattern.equation):
        for i, equation in enumerate(equations):
            value = force[node, i] if i < 3 and node < len(force) else -model.water.scale * leaves[node]
            if equation >= 0:
                expected[equation] += value
            elif equation <= -2:
                expected_border[-2 - equation] += system.pattern.weight[node, i] * value
    assert np.any(gaps(model, state.trial) > 0.0) and np.any(gaps(model, state.trial) == 0.0)
    np.testing.assert_allclose(free, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(border, expected_border, rtol=1e-9)


@pytest.mark.parametrize("rule", RULES)
def test_tangent_of_the_water(rule):
    model = wet(rule)
    system, state, at = moved(model)
    n = system.pattern.n_free
    slope = dense(system.linearise(state, True)[2])

    def residual(x):
        system.apply(state, x[:n], x[n:])
        found = system.residual(state)
        return np.concatenate([found.free, found.border])

    for seed in range(3):
        step = 2e-3 * MOVE * np.random.default_rng(seed).normal(size=n + model.n_border)
        assert taylor_slope(residual, slope, at, step, np.array([1.0, 0.5, 0.25])) > 1.9


@pytest.mark.parametrize("rule", RULES)
def test_every_entry_of_the_waters_tangent(rule):
    """Central differences, column by column: a wrong entry cannot hide in a norm."""
    model = wet(rule)
    system, state, at = moved(model)
    n, size = system.pattern.n_free, 1e-4 * MOVE

    def water(x):
        system.apply(state, x[:n], x[n:])
        free, border = np.zeros(n), np.zeros(model.n_border)
        add_water(system, state, free, border)
        return np.concatenate([free, border])

    slope = dense(system.linearise(state, True)[2]) - tangent_without_water(system, state)
    for column in range(n + model.n_border):
        step = np.zeros(n + model.n_border)
        step[column] = size
        difference = (water(at + step) - water(at - step)) / (2.0 * size)
        scale = np.abs(slope[:, column]).max()
        np.testing.assert_allclose(slope[:, column], difference, atol=2e-6 * scale, rtol=2e-5)


def tangent_without_water(system: System, state: State) -> np.ndarray:
    """Dense tangent of soil and contact alone, on the same equations."""
    parts = system._pores, system._film
    system._pores = system._film = lambda *_: 0.0
    tangent = system.linearise(state, True)[2]
    system._pores, system._film = parts
    return dense(tangent)


def add_water(system: System, state: State, free: np.ndarray, border: np.ndarray) -> None:
    """Add forces and volumes of soil and film."""
    forces = Forces(free, border)
    system._pores(state, None, forces)
    system._film(state, None, forces)


def dense(tangent) -> np.ndarray:
    """The bordered tangent as one array."""
    return np.block([[tangent.matrix.toarray(), tangent.columns], [tangent.rows, tangent.corner]])


# --- laws -------------------------------------------------------------------------------------------------


def test_cubic_law_and_its_slope():
    conductance, slope = transmissivity(1e-5, 1e-4, 1e-3)
    assert conductance == pytest.approx(1.1e-4**3 / 12e-3, rel=1e-14)
    d = 1e-9
    ahead, behind = transmissivity(1e-5, 1e-4 + d, 1e-3)[0], transmissivity(1e-5, 1e-4 - d, 1e-3)[0]
    assert slope == pytest.approx((ahead - behind) / (2 * d), rel=1e-7)
    assert transmissivity(1e-5, 0.0, 1e-3) == (pytest.approx(1e-15 / 12e-3), 0.0)  # closed: residual, no slope


# --- what holds everywhere --------------------------------------------------------------------------------


def test_stabilisation_does_not_see_an_even_pressure_and_holds_an_uneven_one():
    model = wet()
    shapes = hex8.geometry(model.mesh.nodes, model.mesh.hexes)
    pores = biot.make_pores(shapes[0], shapes[1], shapes[2], 0.0, 0.0, 1.0)
    np.testing.assert_allclose(pores.storage.sum(axis=2), 0.0, atol=1e-15)
    assert np.all(np.linalg.eigvalsh(pores.storage)[:, 1] > 1e-4 * pores.volume.sum(axis=1))


def test_columns_with_the_projection_factor_have_no_positive_off_diagonal():
    bulk, shear = 1.7e8, 7.7e7
    modulus, tau = bulk + 4 * shear / 3, biot.projection_factor(bulk, shear)
    assert tau >= 0.5 / shear
    assert 1.0 / (4.0 * modulus) - tau / 12.0 <= 1e-12 / modulus
    soft = biot.projection_factor(1.0, 1.0)
    assert 1.0 / (4.0 * (7.0 / 3.0)) - soft / 12.0 == pytest.approx(0.0, abs=1e-12)  # the least that does


def test_drained_and_wet_models_share_their_forces():
    """Without pressures the wet model has the forces of the drained one, in the same places."""
    model = wet()
    model.water = replace(model.water, initial=np.zeros_like(model.water.initial))
    dry, rng = mixed(), np.random.default_rng(3)
    systems = System(model), System(dry)
    states = State(model), State(dry)
    move, border = MOVE * rng.normal(size=systems[1].pattern.n_free), MOVE * rng.normal(size=4)
    places = systems[0].pattern.equation[: dry.mesh.n_nodes, :3]
    wet_move = np.zeros(systems[0].pattern.n_free)
    wet_move[places[places >= 0]] = move
    systems[0].apply(states[0], wet_move, border)
    systems[1].apply(states[1], move, border)
    found, expected = systems[0].residual(states[0]), systems[1].residual(states[1])
    np.testing.assert_allclose(found.free[places[places >= 0]], expected.free, rtol=1e-12)
    np.testing.assert_allclose(found.border, expected.border, rtol=1e-12)
    assert expected.volume_norm == 0.0 < found.volume_norm


def test_a_film_without_stations_is_refused():
    model = replace(wet(), stations=None, initial_pressure=np.zeros(0))
    with pytest.raises(ModelError, match="stations"):
        model.check()


def test_the_wrong_number_of_pressures_is_refused():
    model = wet()
    model.water = replace(model.water, fixed=model.water.fixed[:-1])
    with pytest.raises(ModelError, match=r"water\.fixed"):
        model.check()


# --- a run ------------------------------------------------------------------------------------------------


def wet_push(drained: bool = True) -> Model:
    """The wet model without initial pressures, held drained on some nodes."""
    model = wet()
    fixed = model.water.fixed if drained else np.zeros_like(model.water.fixed)
    model.water = replace(model.water, initial=np.zeros_like(model.water.initial), fixed=fixed)
    model.fixed[[n for n in range(model.mesh.n_nodes) if model.mesh.nodes[n, 2] > 1.3]] = True
    return model


def lateral_push() -> Stage:
    """A lateral push of 0.1 mm in 10 s in five steps."""
    push = stage({0: 1e-4}, force=(0.0, 0.0, 0.0), first_fraction=0.2, max_fraction=0.2, duration=10.0)
    control = np.hstack([push.control, np.zeros((1, 1))])
    return replace(push, control=control, load=control.T, force=np.zeros(4))


def pushed(model: Model, tolerance: float = 1e-9):
    """The lateral push, with the balance of its water at the end."""
    push, run = lateral_push(), start(model, tolerance=tolerance)
    balance = WaterBalance(run.driver.newton.system, initial_fields(model))

    def follow(step):
        run.steps.append(step)
        balance.advance(run.state.committed, step.time_step)

    run.driver.run(push, follow)
    return run, balance.now(run.state.committed)


def test_the_balance_closes_term_by_term():
    run, balance = pushed(wet_push())
    assert run.steps[-1].time_step == pytest.approx(2.0)
    assert abs(balance.outflow) > 1e-3 * balance.moved > 0.0
    assert abs(balance.imbalance) < 1e-8 * balance.moved


def test_volumes_are_held_ten_times_closer_to_balance():
    """With factors of earlier tangents; the tolerance of all equations would leave 0.55 of it there."""
    tolerance, left = 3.0e-3, []
    run = start(wet_push(), tolerance=tolerance, recycling=EARLIER, shares=(0.1, 0.3))
    water, is_pressure = run.driver.newton.system.model.water, run.driver.newton.system.is_pressure

    def follow(step):
        residual = step.increment.residual
        left.append(np.linalg.norm(residual.free[is_pressure]) / (water.scale * residual.volume_norm))

    run.driver.run(lateral_push(), follow)
    assert len(left) == 5
    assert 0.0 < max(left) <= 0.1 * tolerance


def test_the_balance_shows_a_wrong_flow():
    """The terms do not come from the residual: a run with another permeability than the balance's leaves a hole."""
    model = wet_push()
    run, _ = pushed(model)
    other = replace(model, water=replace(model.water, mobility=2.0 * model.water.mobility))
    balance = WaterBalance(System(other), initial_fields(model))
    balance.advance(run.state.committed, 10.0)
    now = balance.now(run.state.committed)
    assert abs(now.imbalance) > 1e-3 * now.moved


def test_water_that_cannot_leave_stays():
    model = wet_push(drained=False)
    run, balance = pushed(model)
    assert balance.outflow == 0.0
    assert abs(balance.imbalance) < 1e-8 * (abs(balance.compressed) + balance.film)
    assert np.abs(run.state.committed.pressure).max() > 0.0


def test_a_stage_without_duration_is_refused():
    run = start(wet_push())
    with pytest.raises(ModelError, match="'test' has no duration"):
        run.driver.run(stage({0: 1e-4}), run.steps.append)


def test_gaps_of_the_kernel_are_those_of_the_law():
    model = wet()
    system, state, _ = moved(model)
    found = system.gaps(state.trial)
    np.testing.assert_allclose(found, gaps(model, state.trial), rtol=1e-12)
