# SPDX-License-Identifier: MIT
"""Vertical loads at which springs are made: the fewest that every value is close to."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from pysprings.core.loads import close_loads, fewest_loads, nearest, same_loads


@pytest.mark.parametrize(
    ("values", "rest", "found"),
    [
        ([2.0, 2.1, 1.85], 2.0, []),  # close to that at rest
        ([3.0, 3.2], 2.0, [3.0]),  # a group has a value of its own: that nearest to the middle
        ([3.0, 3.5], 2.0, [np.sqrt(3.0 * 3.5)]),  # 3.5 is 14 % above 3: the middle is 7.4 % from each
        ([3.0, 3.2, 3.5], 2.0, [3.2]),
        ([3.0, 3.8], 2.0, [3.0, 3.8]),  # 21 % apart: one load cannot be within 10 % of both
        ([-1.0, 5.0, -1.05], 2.0, [-1.0, 5.0]),
        ([0.0, 5.0], 2.0, [0.0, 5.0]),
    ],
)
def test_groups_by_hand(values, rest, found) -> None:
    """In MN, where less than 1 N is no load."""
    loads = fewest_loads([1e6 * value for value in values], 1e6 * rest)
    assert loads == pytest.approx([1e6 * value for value in found])


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-5e6, 5e6), min_size=1, max_size=7))
def test_every_value_is_close_to_a_load_and_no_fewer_loads_do(values: list[float]) -> None:
    """No choice of one load fewer, at the ends of what is close to each value, is close to all of them."""
    far = np.array([value for value in values if not close_loads(value, 2e6)])
    loads = np.array(fewest_loads(values, 2e6))
    assert all(close_loads(value, loads).any() for value in far)
    if not 1 < loads.size < 5:
        return
    ends = np.maximum.reduce([far / 0.9, far * 0.9, far + 1.0])  # the largest load close to each
    inside = 1.0 - 1e-8 * np.sign(ends)
    for fewer in itertools.combinations(ends * inside, loads.size - 1):
        assert not all(close_loads(value, np.array(fewer)).any() for value in far)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-5e6, 5e6), min_size=1, max_size=7), st.floats(-5e6, 5e6))
@example([1.0e6, 1.23e6], 0.895e6)  # 1.109 MN is close to 1 MN, 0.895 MN is less far in newtons and is not
def test_the_nearest_load_is_close_to_every_value(values: list[float], rest: float) -> None:
    loads = np.array([rest, *fewest_loads(values, rest)])
    assert close_loads(np.array(values), loads[nearest(np.array(values), loads)]).all()


def test_beyond_all_loads_the_nearest_one_is_that_at_the_end() -> None:
    """A pull of 3 beside springs at 4.5 and 9.4: by the measure of `close_loads` alone the farther one is nearer."""
    loads = np.array([9.4e6, 4.5e6, -2e6])
    values = np.array([-30e6, -3e6, -1.9e6, 4.4e6, 6e6, 7e6, 9e6, 30e6])
    assert nearest(values, loads).tolist() == [2, 2, 2, 1, 1, 0, 0, 0]
    assert nearest(np.array([-3e6, 3e6]), loads[:2]).tolist() == [1, 1]
    assert nearest(np.array([-3e6, 3e6]), loads[:1]).tolist() == [0, 0]
    assert same_loads(np.array([0.4, 2.0, 1.0005e6]), np.array([-0.4, -0.4, 1e6])).tolist() == [True, False, True]
