# SPDX-License-Identifier: MIT
"""Every row by itself: no order, split, repetition or neighbour of a table changes an answer or a mark by one bit."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pysprings.macro.batch import answer_loads, predict_batch
from pysprings.macro.predict import predict
from pysprings.springs.springs import Springs
from tests.support.fans import fan_springs, potential
from tests.support.vertical import REST, fan_with_vertical, vertical_springs

LOADS = np.array([0.5, 1.0, 1.004, 1.3, 2.0, 3.1, 4.0, 4.2, -0.3]) * REST


@cache
def springs(name: str) -> tuple[Springs, dict]:
    """Return springs under several vertical loads, under one, without vertical paths, and of one path."""
    made = {
        "loads": lambda: vertical_springs(heavier=(2 * REST, 4 * REST)),
        "fan": fan_with_vertical,
        "bare": lambda: fan_springs(potential, held_back=(2.0,)),
        "path": lambda: fan_springs(potential, held_back=(2.0,)),
    }
    return Springs.of(made[name]()), {"path": "pull_2", "springs_kind": "full"} if name == "path" else {}


def table(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return loads (n, 2) and vertical loads (n,) as a user mixes them: blank V, V close to each other, directions."""
    H = random.choice([0.0, 2e4, -3e5, 1e6, 5e6], n) * random.choice([1.0, 1.0 + 1e-10, 1.2], n)
    M = H * random.choice([-2.0, -40.0, 3.0, 0.0], n) + random.choice([0.0, 0.0, 1e6], n)
    V = random.choice(LOADS, n) * random.choice([1.0, 1.0 + 1e-12, 0.995, 1.0005], n)
    return np.stack([H, M], axis=1), np.where(random.random(n) < 0.2, np.nan, V)


@pytest.mark.parametrize("kind", ["loads", "fan", "bare", "path"])
def test_no_answer_depends_on_its_neighbours(kind: str) -> None:
    """150 random tables of each set of springs: a part of 40 rows in any order, some twice, is answered as alone."""
    given, choice = springs(kind)
    random = np.random.default_rng(11)
    loads, V = table(random, n=40)
    for extrapolate in (False, True):
        each = [answer_loads(given, loads[[k]], V[[k]], extrapolate, **choice) for k in range(len(V))]
        alone = {name: np.concatenate([answer[name].values for answer in each]) for name in each[0].data_vars}
        for _ in range(75):
            rows = random.integers(0, len(V), random.integers(2, 7))
            answer = answer_loads(given, loads[rows], V[rows], extrapolate, **choice)
            assert set(answer.data_vars) == set(alone)
            for name, values in alone.items():
                np.testing.assert_array_equal(answer[name].values, values[rows], err_msg=str(name))


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_v_without_springs_is_marked_in_every_order(order: tuple[int, ...]) -> None:
    """Of springs at one V a case at another V is supported in part, whatever stands in the middle of the table."""
    V = np.array([REST, 1.5 * REST, 0.1 * REST])[list(order)]
    batch = predict_batch(springs("fan")[0], H=1e5, arm=2.0, V=V)
    np.testing.assert_array_equal(batch["off_load"], (V != REST).astype(int))


@pytest.mark.filterwarnings("ignore::pysprings.macro.refusal.MacroWarning")
def test_every_v_has_its_own_springs() -> None:
    """V that differ by less than 1 % are answered as `predict` answers each of them."""
    given = springs("loads")[0]
    V = np.array([2.6, 2.61, 2.62]) * 1e6
    batch = predict_batch(given, H=3e5, arm=2.0, V=V)
    alone = [float(predict(given, H=3e5, arm=2.0, V=float(each))["u"]) for each in V]
    np.testing.assert_allclose(batch["u"], alone, rtol=1e-9)
    assert len(set(batch["u"].values)) == 3
    assert not batch["off_load"].any()
