# SPDX-License-Identifier: MIT
"""Fourier systems: residual and tangent against a plain loop, consistency, linear steps, balance."""

import numpy as np
import pytest

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.balance.energy import EnergyBalance
from fe_engine.contact import coulomb
from fe_engine.contact.law import Slide
from fe_engine.conventions import REGIME_ELASTIC
from fe_engine.elements import fourier as elements
from fe_engine.errors import LawError, LinearSolverError, ModelError
from fe_engine.linear.preconditioner import Control
from fe_engine.material import Material
from fe_engine.soil import elastic
from fe_engine.soil.law import Point
from fe_engine.solve.fourier_near import NearProduct
from fe_engine.solve.fourier_stage import FourierStage, Preconditioner, Room
from fe_engine.solve.stage import Balance
from fe_engine.state import State
from tests.support.fourier_models import disc, moved, on_plate, random_move, run, start
from tests.support.models import replace, stage, taylor_slope

SOFT = (1.0e8, 5.0e7, 0.02)


def coefficients(model):
    """Matrix (n 3 K, n 3 K): all coefficients from the free ones, the rows of held ones being zero."""
    shape, axis = model.displacement_shape, model.mesh.nodes[:, 0] == 0.0
    number, matrix = np.arange(np.prod(shape)).reshape(shape), np.eye(int(np.prod(shape)))
    for n, i, k in np.ndindex(*shape):
        free = not model.fixed[n, i] and (model.whole or not (i == 1 and k == 0))
        if axis[n]:
            free &= (i, model.numbers[k]) in ((2, 0), (0, 1))
        if not free:
            matrix[number[n, i, k]] = 0.0
    for n in np.flatnonzero(axis):
        for k in np.flatnonzero(model.numbers == 1):
            matrix[number[n, 1, k]] = -matrix[number[n, 0, k]]
    return matrix


def waves_at(model, theta):
    """What multiplies u_r, u_theta, u_z of each slot at an azimuth; a whole circle has torsion and the sine family."""
    n = model.harmonics
    waves = [[np.cos(k * theta), np.sin(k * theta), np.cos(k * theta)] for k in range(n + 1)]
    if model.whole:
        waves[0][1] = 1.0
        waves += [[np.sin(k * theta), -np.cos(k * theta), np.sin(k * theta)] for k in range(1, n + 1)]
    return list(zip(model.numbers, waves, strict=True))


def plain_loop(model, state):
    """Residual and tangent, dense: every point and station in turn, in the axes of the point."""
    old, new, nb = state.committed, state.trial, model.n_border
    circle = 2.0 * np.pi if model.whole else np.pi
    n, reduce = int(np.prod(model.displacement_shape)), coefficients(model)
    number = np.arange(n).reshape(model.displacement_shape)
    gradient, volume = elements.geometry(model.mesh.nodes, model.mesh.quads)
    force, stiffness = np.zeros(n + nb), np.zeros((n + nb, n + nb))
    shift = (new.displacement - old.displacement).ravel()
    for e, quad in enumerate(model.mesh.quads):
        material = model.materials[model.material[e]]
        for point in range(4 * model.azimuths):
            g, j = divmod(point, model.azimuths)
            theta = (j + 0.5) * circle / model.azimuths
            b = np.zeros((6, n))
            for slot, (k, (c, s, _)) in enumerate(waves_at(model, theta)):
                of_k = elements.strain_operator(gradient[e, g], k)
                b[:, number[quad, :, slot].ravel()] = np.array([c, c, c, s, s, c])[:, None] * of_k
            stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
            weight = circle / model.azimuths * volume[e, g]
            before, after = Point(old.stress[e, point], old.history[e, point]), Point(stress, history)
            material.law.update(material.parameters, b @ shift, before, after, tangent, True)
            force[:n] += weight * b.T @ (stress - model.initial_stress[e, point])
            stiffness[:n, :n] += weight * b.T @ tangent @ b
    s = model.stations
    for i in range(len(s)):
        theta, jump = s.azimuth[i], np.zeros((3, n + nb))
        radial, around = np.array([np.cos(theta), np.sin(theta), 0.0]), np.array([-np.sin(theta), np.cos(theta), 0.0])
        for k, (_, (c, d, e)) in enumerate(waves_at(model, theta)):
            local = np.stack([c * radial, d * around, e * np.array([0.0, 0.0, 1.0])], axis=1)
            for node, weight in zip(s.nodes[i], s.weight[i], strict=True):
                jump[:, number[node, :, k]] = weight * s.frame[i] @ local
        jump[:, n:] = -s.frame[i] @ s.body[i]
        w, w_old = (jump @ np.concatenate([f.displacement.ravel(), f.border]) for f in (new, old))
        p, p0 = model.contact[i], model.initial_pressure[i]
        guess, traction, tangent = np.zeros(3), np.zeros(3), np.zeros((3, 3))
        slide = Slide(w, w_old, old.traction[i], p0)
        coulomb.update(p, slide, guess)
        coulomb.linearise(p, slide, guess, traction, tangent)
        force += s.area[i] * jump.T @ (traction + np.array([p0, 0.0, 0.0]))
        stiffness += s.area[i] * jump.T @ tangent @ jump
    if model.linear is not None:
        for k, e in np.ndindex(len(model.numbers), len(model.linear.quads)):
            at = number[model.linear.quads[e], :, k].ravel()
            force[at] += model.linear.stiffness[k, e] @ new.displacement.ravel()[at]
            stiffness[np.ix_(at, at)] += model.linear.stiffness[k, e]
    whole = np.zeros((n + nb, n + nb))
    whole[:n, :n], whole[n:, n:] = reduce, np.eye(nb)
    return whole.T @ force, whole.T @ stiffness @ whole


def product(system, tangent, free, border):
    """The tangent times increments, from its parts."""
    p, m = system.pattern, len(system.pattern.interface)
    elastic = elastic_product(system, free)
    contact = system.contact_matrix(tangent) @ np.concatenate([p.jump(free), border])
    out = elastic + system.plastic_product(tangent, free)
    p.add_jump_forces(contact[:m], out)
    return np.concatenate([out, contact[m:]])


def elastic_product(system, free):
    """Elastic forces of increments: those of the same model with an elastic law."""
    calm = replace(system.model, materials=_elastic_soils(system.model))
    state, rest = State(calm), FourierSystem(calm)
    rest.apply(state, free, np.zeros(calm.n_border))
    force = rest._soil(state, False)
    if rest.linear is not None:
        rest.linear.add_force(state.trial.displacement, force)
    return rest.pattern.folded(force)


def _elastic_soils(model):
    return [Material(elastic.LAW, np.stack(m.law.moduli(m.parameters))) for m in model.materials]


@pytest.mark.parametrize(("harmonics", "seed", "whole", "body"), [
    *((*each, False, body) for body in (lambda model: model, on_plate) for each in ((0, 3), (1, 2), (2, 0))),
    *((*each, True, lambda model: model) for each in ((0, 2), (1, 1), (2, 4))), (2, 4, True, on_plate),
])  # fmt: skip
def test_residual_and_tangent_equal_the_plain_loop(harmonics, seed, whole, body):
    model = body(disc(harmonics, contact=SOFT, skew=True, whole=whole))
    system, state, rng = moved(model, seed)
    judged, linear, tangent = system.linearise(state, True)
    force, stiffness = plain_loop(model, state)
    assert min(judged.n_plastic, judged.n_slip) > 0
    size = np.abs(force).max()
    for found in (judged, linear):
        np.testing.assert_allclose(np.concatenate([found.free, found.border]), force, rtol=1e-9, atol=1e-12 * size)
    for _ in range(3):
        free, border = random_move(system, rng)
        wanted = stiffness @ np.concatenate([free, border])
        found = product(system, tangent, free, border)
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize(("seed", "relaxed", "whole", "body"), [
    (0, 1.0, False, lambda model: model), (1, 1.0, False, on_plate), (1, 0.3, False, lambda model: model),
    (1, 1.0, True, lambda model: model), (1, 1.0, True, on_plate),
])  # fmt: skip
def test_the_tangent_is_consistent(seed, relaxed, whole, body):
    model = body(disc(2, contact=SOFT, skew=True, whole=whole))
    system, state, rng = moved(model, seed)
    system.relax(relaxed)
    size = system.pattern.n_free

    def force(x):
        system.apply(state, x[:size], x[size:])
        found = system.residual(state)
        return np.concatenate([found.free, found.border])

    x = np.concatenate(random_move(system, rng))
    force(x)
    _, _, tangent = system.linearise(state, True)
    step = np.concatenate(random_move(system, rng))
    slope = product(system, tangent, step[:size], step[size:])
    # a slope that is applied: taylor_slope multiplies it with the step
    order = taylor_slope(force, np.outer(slope, step) / (step @ step), x, step, 10.0 ** -np.arange(3.0, 5.5, 0.5))
    assert order > 1.9


def test_viscous_soil_goes_a_share_of_the_way_from_the_elastic_to_its_own_stress():
    model = disc(1, contact=SOFT, skew=True)
    system, state, _ = moved(model)
    system.residual(state)
    own, rest = state.trial.stress.copy(), FourierSystem(replace(model, materials=_elastic_soils(model)))
    history = state.trial.history.copy()
    rest.residual(state)
    trial = state.trial.stress.copy()
    system.relax(0.3)
    system.residual(state)
    yields = system.regime != REGIME_ELASTIC
    assert yields.any() and not yields.all()
    np.testing.assert_allclose(state.trial.stress, trial + 0.3 * (own - trial), rtol=1e-9, atol=1e-6)
    before = state.committed.history
    np.testing.assert_allclose(state.trial.history, before + 0.3 * (history - before), rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("body", [lambda model: model, on_plate])
def test_a_step_solves_the_bordered_system(body):
    model = body(disc(2, contact=SOFT, skew=True))
    system, state, _ = moved(model)
    _, linear, tangent = system.linearise(state, True)
    control, load, violation = np.array([[1.0, 0.0, 0.0]]), np.array([[1.0], [0.0], [-2.0]]), np.array([3e-5])
    balance = Balance(control, load, violation, linear.border, np.ones(3))
    stage_ = FourierStage(system)
    free, border = stage_.step(linear, tangent, balance, 1e-10, True)
    left = np.concatenate([linear.free, linear.border]) + product(system, tangent, free, border)
    assert stage_.n_iterations > 0
    assert border[0] == pytest.approx(3e-5, rel=1e-12)
    assert np.abs(left[:-3]).max() < 1e-7 * np.abs(linear.free).max()
    assert left[-2] == pytest.approx(0.0, abs=1e-7 * np.abs(linear.border).max())  # w: no force imposes it
    assert left[-1] == pytest.approx(-2.0 * left[-3], rel=1e-6)  # u and rotation: by one force at a height


@pytest.mark.parametrize("body", [lambda model: model, on_plate])
def test_what_starts_gmres_is_that_of_all_factors(body):
    """In single precision, of nodes of elements that yield alone; rhs has forces everywhere, and the border's."""
    system, state, rng = moved(body(disc(2, contact=SOFT, skew=True)))
    _, _, tangent = system.linearise(state, True)
    p = Preconditioner(system, tangent, Control(np.zeros(3), np.eye(3), np.eye(3)), Room({}), True)
    rhs, yielding = rng.standard_normal(p.size), system.yielding(tangent)
    rhs[: system.pattern.held.size][system.pattern.held.ravel()] = 0.0
    whole = system.plastic_product(tangent, p.solve(rhs)[: system.pattern.n_moving])
    near = NearProduct(system, tangent, yielding, p.rest, p.interface).behind(*p.halfway(rhs)[:2])
    known = whole[system.pattern.equation[yielding[1]].ravel()]
    np.testing.assert_allclose(near, known, atol=1e-4 * np.abs(known).max())


def test_elastic_soil_takes_no_iteration():
    out = run(disc(1, elastic.LAW), stage({0: 1e-4}, max_fraction=1.0, first_fraction=1.0))
    assert out.driver.newton.stage.n_iterations == 0
    assert out.driver.newton.stage.n_solves > 0


@pytest.mark.parametrize("body", [lambda model: model, on_plate])
def test_border_stiffness_is_the_slope_of_the_forces(body):
    """Small elastic motions of the border, solved by Newton, against the stiffness."""
    model = body(disc(1, elastic.LAW, contact=(1e9, 1e9, 50.0)))
    matrix = start(model).driver.newton.border_stiffness(State(model))
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * np.abs(matrix).max())
    for j in range(3):
        imposed = {i: 1e-7 * (i == j) for i in range(3)}
        out = run(model, stage(imposed, max_fraction=1.0, first_fraction=1.0), tolerance=1e-9)
        force = out.steps[-1].increment.residual.border
        np.testing.assert_allclose(force / 1e-7, matrix[:, j], atol=1e-6 * np.abs(matrix).max())


def test_torsion_of_a_rough_disc_is_that_of_the_half_space():
    """16/3 G R^3 (Reissner & Sagoci 1944), the closer the stiffer the interface."""
    inner = 1.0 - 0.5 ** np.arange(6.0)
    outer = 1.0 + np.concatenate([0.5 ** np.arange(5.0, 0.0, -1.0), 1.7 ** np.arange(8.0)])
    lines = np.concatenate([inner, [1.0], outer]), np.concatenate([[0.0], 1.7 ** np.arange(-7.0, 8.0)])
    found = []
    for penalty in (1e10, 1e11, 1e13):
        model = disc(0, elastic.LAW, contact=(penalty, penalty, 0.5), whole=True, lines=lines)
        found.append(start(model).driver.newton.border_stiffness(State(model))[5, 5])
    _, shear = model.materials[0].law.moduli(model.materials[0].parameters)
    closed = 16.0 / 3.0 * float(np.ravel(shear)[0])
    assert found[0] < found[1] < found[2]
    assert found[2] == pytest.approx(closed, rel=0.015)


def test_vertical_load_is_axisymmetric_whatever_the_number_of_harmonics():
    ends = []
    for harmonics in (0, 3):
        out = run(
            disc(harmonics), stage({0: 0.0, 1: 5e-4, 2: 0.0}, max_fraction=0.5, first_fraction=0.1), tolerance=1e-8
        )
        field = out.state.committed.displacement
        assert np.abs(field[..., 1:]).max(initial=0.0) < 1e-9 * np.abs(field).max()
        assert np.abs(field[:, 1, 0]).max() == 0.0
        ends.append(out.steps[-1].multipliers[1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


def test_converged_forces_balance_and_newton_is_fast():
    out = run(disc(2), stage({0: 2e-4}, force=(0.0, 5e3, 0.0), first_fraction=0.1, max_fraction=0.25))
    residual = out.steps[-1].increment.residual
    assert residual.n_plastic > 0
    assert residual.border[1] == pytest.approx(5e3, rel=1e-4)
    assert np.median([step.increment.iterations for step in out.steps]) <= 8


@pytest.mark.slow
@pytest.mark.parametrize("body", [lambda model: model, on_plate])
def test_energy_balances(body):
    model = body(disc(2))
    out = start(model, tolerance=1e-8)
    energy = EnergyBalance(out.driver.newton.system)

    def on(step):
        energy.advance(out.state.committed, step.increment.residual.border)

    out.driver.run(stage({0: 3e-4}, first_fraction=0.1, max_fraction=0.25), on)
    now = energy.now()
    assert now.plastic > 0.0 and now.friction > 0.0
    assert abs(now.imbalance) < 1e-6 * now.moved


def test_a_stiff_plate_is_the_rigid_disc_and_a_soft_one_is_not():
    stiffness = [start(each).driver.newton.border_stiffness(State(each)) for each in (
        disc(1, elastic.LAW), on_plate(disc(1, elastic.LAW), 1e17), on_plate(disc(1, elastic.LAW), 1e8),
    )]  # fmt: skip
    np.testing.assert_allclose(stiffness[1], stiffness[0], atol=1e-6 * np.abs(stiffness[0]).max())
    assert np.all(np.diag(stiffness[2]) < 0.99 * np.diag(stiffness[0]))


def test_linear_elements_that_nothing_holds_are_refused():
    model = on_plate(disc(1))
    loose = replace(model, fixed=np.where(np.arange(model.mesh.n_nodes)[:, None] < model.n_soil, model.fixed, False))
    with pytest.raises(LinearSolverError, match="linear elements are not held"):
        FourierSystem(loose)


def test_a_law_that_fails_is_named_with_its_place(monkeypatch):
    system = FourierSystem(model := disc(1))
    monkeypatch.setattr(system, "soil_forces", lambda *_: 3)
    r, z = model.mesh.nodes[model.mesh.quads[3]].mean(axis=0)
    with pytest.raises(LawError, match=rf"soil law .* in element 3 at r={r:.3f}, z={z:.3f} m"):
        system.residual(State(model))


def test_too_few_azimuths_are_refused():
    model = disc(2)
    with pytest.raises(ModelError, match="azimuths"):
        FourierSystem(replace(model, azimuths=2, initial_stress=model.initial_stress[:, :8]))


def test_the_place_of_an_equation_names_node_harmonic_and_direction():
    system = FourierSystem(disc(2))
    equation = int(system.pattern.equation[5, 2, 1])
    assert "node 5" in system.place_of_equation(equation)
    assert "harmonic 1, direction z" in system.place_of_equation(equation)
