# SPDX-License-Identifier: MIT
"""Newton steps with factors of earlier tangents: the same answers, and factors that can be made again."""

from dataclasses import replace

import numpy as np
import pytest

from fe_engine.errors import LinearSolverError
from fe_engine.linear import recycled
from fe_engine.linear.backends import available_backends
from fe_engine.linear.recycled import control_of
from fe_engine.settings import Recycling
from fe_engine.solve import globalisation
from fe_engine.solve.globalisation import EXACT
from fe_engine.solve.newton import Loading
from fe_engine.state import State
from tests.support.models import EARLIER, OWN, footing, run, stage, start, wet

PULL = stage({0: 6.0e-5}, arm=0.3, first_fraction=0.1, max_fraction=0.2)
SCALE = np.array([1.0, 1.0, 4.0])
LOOSE = (0.01, 0.1)  # shares of the residual that systems of large models leave
LASTING = Recycling(start=0, comfortable=1.0e9)  # factors are renewed where they fail, not before


@pytest.fixture(params=available_backends())
def linear(request):
    return request.param


def forces(out):
    return np.array([step.multipliers[0] for step in out.steps])


def test_the_same_path_as_with_factors_of_its_own(linear):
    """Both meet the tolerance, and differ by what it leaves."""
    new, own = (run(footing(), PULL, linear=linear, tolerance=1.0e-9, recycling=each) for each in (EARLIER, OWN))
    assert new.driver.newton.recycled.n_systems > 0
    assert new.driver.newton.solver.n_factorisations < own.driver.newton.solver.n_factorisations / 2
    np.testing.assert_allclose(forces(new), forces(own), rtol=1.0e-7)
    for mine, other in zip(new.steps, own.steps, strict=True):
        np.testing.assert_allclose(mine.increment.border, other.increment.border, atol=1.0e-10)


def test_the_stiffness_at_rest_is_exact_in_single_precision_too(linear):
    new, own = (start(footing(), linear, recycling=each).driver.newton for each in (EARLIER, OWN))
    np.testing.assert_allclose(
        new.border_stiffness(State(footing())), own.border_stiffness(State(footing())), rtol=1.0e-8, atol=1.0
    )


def test_the_stiffness_of_a_stiff_contact_is_refined_until_it_is_symmetric(linear):
    """Beside a penalty of 1e15 N/m3 a residual of 1e-10 leaves 3.5e-9 of the stiffness, which is 1e7 times less."""
    model = footing(contact=(1.0e15, 1.0e15, 0.5))
    k = start(model, linear, recycling=EARLIER).driver.newton.border_stiffness(State(model))
    size = np.sqrt(np.outer(np.diagonal(k), np.diagonal(k)))
    np.testing.assert_allclose((k - k.T) / size, 0.0, atol=1.0e-9)


def test_factors_of_the_same_tangent_are_made_once(linear):
    """The stiffness at rest and the first increment share them; those of another tangent are made."""
    newton = start(footing(), linear, recycling=EARLIER).driver.newton
    once = newton.border_stiffness(State(footing()))
    newton.forget()
    np.testing.assert_array_equal(newton.border_stiffness(State(footing())), once)
    assert newton.solver.n_factorisations == 1
    newton.recycled.close()
    np.testing.assert_array_equal(newton.border_stiffness(State(footing())), once)
    assert newton.solver.n_factorisations == 2


def test_given_forces_are_balanced_with_earlier_factors_too(linear):
    force = stage({}, force=(4.5e3, 5.0e3, -5.0e2), first_fraction=0.1, max_fraction=0.2)
    new, own = (run(footing(), force, linear=linear, tolerance=1.0e-9, recycling=each) for each in (EARLIER, OWN))
    assert new.driver.newton.solver.n_factorisations < own.driver.newton.solver.n_factorisations / 2
    for mine, other in zip(new.steps, own.steps, strict=True):
        np.testing.assert_allclose(mine.increment.border, other.increment.border, rtol=1.0e-6, atol=1.0e-12)


def test_factors_made_again_from_their_origin_go_on_bit_by_bit(linear):
    out, again = (start(footing(), linear, recycling=LASTING) for _ in range(2))
    out.driver.run(PULL, out.steps.append)
    half = len(out.steps) // 2
    first = start(footing(), linear, recycling=LASTING)

    class Enough(Exception):
        pass

    def stop(step):
        first.steps.append(step)
        if len(first.steps) == half:
            raise Enough

    with pytest.raises(Enough):
        first.driver.run(PULL, stop)
    for name in ("displacement", "border", "stress", "history", "traction"):
        getattr(again.state.committed, name)[...] = getattr(first.state.committed, name)
    again.driver.newton.restore(first.driver.newton.origin)
    again.driver.force = first.driver.force
    again.driver.run(PULL, again.steps.append, first.driver.position)
    np.testing.assert_array_equal(forces(again), forces(out)[half:])


def test_factors_that_serve_no_more_are_renewed(linear):
    """GMRES that may take three iterations alone does not get there with old factors."""
    long = run(footing(), PULL, linear=linear, recycling=LASTING)
    short = run(footing(), PULL, linear=linear, recycling=replace(LASTING, longest=4))
    assert short.driver.newton.solver.n_factorisations > long.driver.newton.solver.n_factorisations
    np.testing.assert_allclose(forces(short), forces(long), rtol=1.0e-4)


def test_where_single_precision_does_not_do_double_precision_does(linear):
    out = run(footing(), PULL, linear=linear, recycling=replace(EARLIER, longest=1))
    np.testing.assert_allclose(forces(out), forces(run(footing(), PULL, linear=linear, recycling=OWN)), rtol=1e-12)


def test_factors_that_overflow_are_not_used(linear, monkeypatch):
    """Of a tangent that is singular in single precision they may be infinite."""
    exact = run(footing(), PULL, linear=linear, tolerance=1.0e-9)
    out = start(footing(), linear, tolerance=1.0e-9, recycling=EARLIER)
    monkeypatch.setattr(type(out.driver.newton.recycled._factors), "apply", lambda self, v: np.full(len(v), np.nan))
    steps = []
    out.driver.run(PULL, steps.append)
    assert steps[-1].multipliers[0] == pytest.approx(forces(exact)[-1], rel=1e-7)


def test_controlled_motions_are_met_and_the_others_are_free():
    """Pull at 2 m above the reference, half of it left to do: u is met, its force takes up a moment with it."""
    load = np.array([[1.0], [0.0], [-2.0]])
    found = control_of(np.array([[1.0, 0.0, 0.0]]), load, np.array([3.0e-3]), SCALE)
    np.testing.assert_allclose(found.imposed, [3.0e-3, 0.0, 0.0])
    np.testing.assert_allclose(found.motions[0], 0.0, atol=1e-15)
    assert np.linalg.matrix_rank(found.motions) == 2
    np.testing.assert_allclose(found.forces.T @ load, 0.0, atol=1e-15)


def test_all_motions_imposed_leave_none_free():
    found = control_of(np.eye(3), np.eye(3), np.array([1.0, 2.0, 3.0]), SCALE)
    np.testing.assert_allclose(found.imposed, [1.0, 2.0, 3.0])
    assert found.motions.shape == found.forces.shape == (3, 0)


def test_water_is_solved_for_with_earlier_factors_too(linear):
    """Rows of volumes are smaller than those of forces by any factor: the factors are those of the scaled matrix."""
    nb = wet().n_border
    loading = Loading(np.eye(nb), 1.0e-6 * np.arange(1.0, nb + 1.0), np.eye(nb), np.zeros(nb), 10.0)
    ends = []
    for each in (EARLIER, OWN):
        out = start(wet(), linear, tolerance=1.0e-10, recycling=each)
        newton = out.driver.newton
        newton.solver.equilibrate = True
        increment = newton.solve(out.state, loading, np.zeros(newton.system.pattern.n_free), np.zeros(nb))
        ends.append(increment.residual.border)
    np.testing.assert_allclose(ends[0], ends[1], rtol=1.0e-6, atol=1.0e-6 * np.abs(ends[1]).max())


def test_systems_are_solved_no_further_than_contact_lets_the_residual_fall(linear, monkeypatch):
    """Fewer solves than with systems that are all solved as far as they may be, for the same path."""
    tight = {"linear": linear, "tolerance": 1.0e-9, "recycling": EARLIER, "shares": LOOSE}
    loose = run(footing(), PULL, **tight)
    monkeypatch.setattr(globalisation.Course, "share", lambda *_: 0.0)
    exact = run(footing(), PULL, **tight)
    assert loose.driver.newton.solver.n_solves < exact.driver.newton.solver.n_solves
    np.testing.assert_allclose(forces(loose), forces(exact), rtol=1.0e-7)


def test_exact_systems_are_all_solved_as_far_as_new_factors_can(linear, monkeypatch):
    step, wanted = recycled.Recycled.step, []
    monkeypatch.setattr(recycled.Recycled, "step", lambda self, *args: wanted.append(args[-1]) or step(self, *args))
    run(footing(), PULL, linear=linear, recycling=EARLIER, shares=(EXACT, EXACT))
    assert set(wanted) == {1.0e-8}
    wanted.clear()
    run(footing(), PULL, linear=linear, recycling=EARLIER, shares=LOOSE)
    assert max(wanted) > 1.0e-4


@pytest.mark.parametrize(("end", "stiffness"), [(2.0e-4, 1.0e12), (5.0e-4, 1.0e10)])
def test_a_large_step_without_a_guess_is_no_harder_than_with_exact_systems(linear, end, stiffness):
    """To 0.2 mm in one step; to 0.5 mm with a step that is cut, after which factors of a failed attempt are there."""
    once = stage({0: end}, arm=0.3, first_fraction=1.0, max_fraction=1.0)
    model = footing(contact=(stiffness, stiffness, 0.5))
    new, own = (
        run(model, once, linear=linear, tolerance=1.0e-9, recycling=each, shares=LOOSE) for each in (EARLIER, OWN)
    )
    assert len(new.driver.given_up) == len(own.driver.given_up)
    assert len(new.steps) == len(own.steps)


def test_factors_that_fail_leave_none_behind(linear):
    """What is half made is neither used nor saved."""
    newton = start(footing(), linear, recycling=EARLIER).driver.newton
    newton.border_stiffness(State(footing()))
    origin = replace(newton.origin, entries=2.0 * newton.origin.entries)  # the same would need no new factors

    def fail(_matrix):
        raise LinearSolverError("singular")

    newton.recycled._factors._backend.factorise = fail
    with pytest.raises(LinearSolverError):
        newton.recycled.restore(origin, newton.system.matrix_pattern)
    assert newton.origin is None


def test_volumes_of_water_are_held_ten_times_closer_to_balance():
    """A system solved loosely leaves a third of the tolerance in the volumes, which add up over the steps of a path."""
    nb = wet().n_border
    loading = Loading(np.eye(nb), 1.0e-5 * np.arange(1.0, nb + 1.0), np.eye(nb), np.zeros(nb), 10.0)

    def pushed(tolerance):
        """Iterations, and the part of the volumes exchanged that is left over."""
        out = start(wet("pairs"), tolerance=tolerance, recycling=EARLIER, shares=LOOSE)
        one, system = out.driver.newton, out.driver.newton.system
        one.solver.equilibrate = True
        found = one.solve(out.state, loading, np.zeros(system.pattern.n_free), np.zeros(nb))
        volumes = sum(float(value) ** 2 for value in found.residual.free[system.is_pressure]) ** 0.5
        return found.iterations, volumes / system.model.water.scale / found.residual.volume_norm

    first, left = pushed(1.0e-2)
    assert first == 1 and 1.0e-9 < left < 1.0e-4
    again, rest = pushed(3.0 * left)  # the first iterate meets this, but not a tenth of it
    assert again > first and rest <= 0.1 * 3.0 * left


def test_a_motion_imposed_anew_is_solved_for_tightly(linear, monkeypatch):
    """Penalties, not the forces that balance, make its right-hand side: a percent of them is more than those forces."""
    step, wanted = recycled.Recycled.step, {True: [], False: []}

    def noted(self, *args):
        wanted[np.abs(args[2].imposed).max() > 1.0e-12].append(args[-1])
        return step(self, *args)

    monkeypatch.setattr(recycled.Recycled, "step", noted)
    there = stage({0: 2.0e-4}, arm=0.3, first_fraction=0.25, max_fraction=0.5)
    back = stage({0: -2.0e-4}, arm=0.3, first_fraction=0.5, max_fraction=0.5)
    run(footing(), there, back, linear=linear, tolerance=1.0e-9, recycling=EARLIER, shares=LOOSE)
    assert len(wanted[True]) >= 2 and max(wanted[True]) <= 1.0e-6
    assert max(wanted[False]) > 1.0e-4
