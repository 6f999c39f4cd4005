# SPDX-License-Identifier: MIT
"""Size of the next increment: growth, cut-back, and the memory of sizes that failed."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest

from fe_engine.solve.step_size import GROWTH, StepSize


def walk(size: StepSize, limit: float, number: int) -> tuple[int, int]:
    """Increments and failures where every attempt beyond ``limit`` fails and all others are easy."""
    failures = 0
    for _ in range(number):
        again = False
        while size.size > limit:
            size, failures, again = size.after_failure(size.size, again), failures + 1, True
        size = size.after_success(size.size, 5, 1.0)
    return number, failures


@pytest.mark.parametrize(("iterations", "expected"), [(3, 0.03), (6, 0.03), (8, 0.02), (11, 0.014)])
def test_it_follows_the_iterations(iterations, expected):
    after = StepSize(0.02).after_success(0.02, iterations, 1.0)
    assert after.size == pytest.approx(expected)
    assert after.limit == ("growth" if expected > 0.02 else "iterations")
    largest = StepSize(0.02).after_success(0.02, iterations, 0.01)
    assert (largest.size, largest.limit) == (0.01, "largest step")


@pytest.mark.parametrize(("iterations", "held"), [(5, 9), (2, 3)])
def test_a_failure_halves_it_and_holds_it_there_shorter_where_newton_needs_next_to_nothing(iterations, held):
    size, sizes = StepSize(0.02, "growth").after_failure(0.02, again=False), []
    assert (size.size, size.limit) == (0.01, "cut-back")
    for _ in range(held + 1):
        sizes.append(size.size)
        size = size.after_success(size.size, iterations, 1.0)
    assert sizes == pytest.approx([0.01] * held + [0.015])


def test_a_long_increment_shrinks_it_while_it_waits_too():
    size = StepSize(0.02).after_failure(0.02, again=False).after_success(0.01, 11, 1.0)
    assert size.size == pytest.approx(0.007)


def test_a_stop_on_the_way_does_not_shrink_the_size_that_is_held():
    size = StepSize(0.02).after_failure(0.02, again=False).after_success(0.001, 3, 1.0)
    assert size.size == pytest.approx(0.01)


def test_failures_become_rare_where_growing_back_fails_each_time():
    """One failure in eleven increments, holding eight; one in nineteen at the last."""
    few, many = walk(StepSize(0.03), 0.02, 20)[1], walk(StepSize(0.03), 0.02, 400)[1]
    assert few <= 2
    assert many <= 400 / 15


def test_what_has_failed_is_forgotten_where_it_succeeds():
    size = StepSize(0.02).after_failure(0.02, again=False)
    size = size.after_failure(0.02, again=False)  # waits longer now
    waited = size.wait
    size = size.after_success(0.025, 3, 1.0)
    assert size.failed == float("inf") and size.wait == 0
    assert size.after_failure(0.025, again=False).wait < waited


def test_it_ends_where_it_is_too_small_to_go_on():
    size = StepSize(1.0e-6)
    assert not size.exhausted
    for _ in range(4):
        size = size.after_failure(size.size, again=True)
    assert size.exhausted


def test_it_goes_through_a_checkpoint():
    size = StepSize(0.02).after_failure(0.02, again=False)
    assert StepSize(**json.loads(json.dumps(asdict(size)))) == size
    assert StepSize(**json.loads(json.dumps(asdict(StepSize(0.1))))) == StepSize(0.1)


@pytest.mark.parametrize("first", [0.0003, 0.03])
def test_shares_of_a_duration_are_few_and_near_those_asked_for(first):
    size, taken, duration, largest = StepSize(first), [], 40.0, 0.05
    assert size.on_grid(duration, largest) is size
    size = size.after_success(first, 3, largest)
    for number in range(60):
        asked = size.size
        size = size.on_grid(duration, largest)
        assert size.size <= largest
        assert math.sqrt(1.0 / GROWTH) <= size.size / asked <= math.sqrt(GROWTH)
        taken.append(size.size)
        fails = number in (20, 40)
        size = (
            size.after_failure(size.size, again=False) if fails else size.after_success(size.size, number % 8, largest)
        )
    powers = np.log(np.unique(taken)[:-1] * duration) / np.log(GROWTH)
    assert max(taken) == largest
    np.testing.assert_allclose(powers, powers.round(), atol=1e-9)
    assert len(powers) == len(np.unique(powers.round()))  # the same numbers, not nearly
