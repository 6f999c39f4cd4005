# SPDX-License-Identifier: MIT
"""What residuals and corrections say of the next step, from histories made up for it."""

import pytest

from fe_engine.solve.globalisation import Course, bounds


def course(merits, sizes=(), scale=1.0):
    """Return a course of these residuals (relative: over ``scale``), and what it said of the last."""
    made, go_on = Course(), True
    for i, merit in enumerate(merits):
        go_on = made.add(merit, merit / scale)
        made.sizes += sizes[i : i + 1]
    return made, go_on


def test_the_first_step_serves_whatever_comes_of_it_and_later_ones_where_the_residual_does_not_grow():
    first, _ = course([1.0])
    later, _ = course([1.0, 0.1])
    assert first.accepts(5.0)
    assert later.accepts(0.1)
    assert not later.accepts(0.11)
    assert not later.accepts(float("nan"))


def test_a_residual_as_large_as_the_forces_is_not_worth_another_solve():
    made, _ = course([1.0])
    assert made.may_converge(0.1)
    assert not made.may_converge(0.5)
    assert not made.may_converge(float("inf"))


def test_corrections_that_shrink_go_on_though_the_residual_grows():
    _, go_on = course([1e-2, 2e-2, 4e-2, 8e-2, 0.16, 0.32, 0.64], [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4])
    assert go_on


def test_corrections_that_do_not_shrink_end_an_increment_far_from_the_solution():
    merits, sizes = [0.5, 0.4, 0.3, 0.2, 0.1, 0.05], [1.0, 1.1, 1.2, 1.1, 1.0, 1.0]
    assert course(merits[:5], sizes)[1]
    assert not course(merits, sizes)[1]


def test_close_to_the_solution_they_ask_for_half_steps_that_end_where_the_equations_are_linear():
    made, go_on = course([4e-4, 5e-4, 4e-4, 5e-4, 4e-4, 5e-4], [1.0] * 6)
    assert go_on
    assert made.half
    assert made.add(4.9e-4, 4.9e-4)
    assert made.half
    assert made.add(2.45e-4, 2.45e-4)  # half of it
    assert not made.half
    made.sizes += [1.0]
    assert all(made.add(1e-4, 1e-4) and not made.sizes.append(1.0) for _ in range(3))  # the watch begins anew


@pytest.mark.parametrize(("factor", "last"), [(1.0, 4), (0.8, 8)])
def test_half_steps_end_where_they_gain_nothing(factor, last):
    """0.8 a step is a gain of 0.64 in two, so that they go on; then four without."""
    made, merit, given = course([5e-4] * 6, [1.0] * 6)[0], 5e-4, 0
    while made.add(merit := merit * (factor if given < 4 else 1.0), merit):
        given += 1
        assert given < 20
    assert given + 1 == last


def test_systems_are_solved_as_far_as_the_residual_is_likely_to_fall():
    """Choice 2 of Eisenstat & Walker (1996), 0.9 (r_k / r_(k-1))^2."""
    made, _ = course([1.0])
    assert made.share(1.0, ahead=False) == 0.03
    assert made.share(0.3, ahead=True) == pytest.approx(0.081)
    made.add(0.2, 0.2)
    assert made.share(0.2, ahead=False) == pytest.approx(0.036)
    assert [made.share(error, ahead=True) for error in (0.01, 0.4)] == [0.01, 0.1]  # within bounds


def test_systems_of_an_increment_without_a_guess_are_solved_further():
    made = Course(far=True)
    made.add(1.0, 1.0)
    assert made.share(1.0, ahead=False) == made.share(1.0, ahead=True) == 1e-4


def test_small_models_solve_exactly():
    assert bounds(52_099) == bounds(300_000) == (0.01, 0.1)
    assert bounds(25_000) == pytest.approx((0.005, 0.05))
    assert bounds(9_999) == bounds(50) == (1e-8, 1e-8)
    made = Course(bounds=bounds(50))
    made.add(1.0, 1.0)
    assert made.share(1.0, ahead=False) == made.share(0.5, ahead=True) == 1e-8
