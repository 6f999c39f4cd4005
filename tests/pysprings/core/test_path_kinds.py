# SPDX-License-Identifier: MIT
"""Kinds of load path: rays keep their direction, paths from a table have no kind of their own."""

import pytest

from pysprings.core.path_kinds import PATH_KINDS, bends, is_straight, kind_of


@pytest.mark.parametrize(
    ("attrs", "straight"),
    [
        ({"kind": "translation"}, True),
        ({"kind": "rotation"}, True),
        ({"kind": "pull"}, False),
        ({"kind": "table"}, False),
        ({"kind": "table", "straight": 1}, True),
    ],
)
def test_paths_that_keep_their_direction(attrs: dict[object, object], straight: bool) -> None:
    assert is_straight(attrs) is straight


def test_a_load_that_climbs_answers_as_a_swipe() -> None:
    climbing = {"kind": "load", "arm_from_m": 2.0}
    assert bends(climbing) and kind_of(climbing) is PATH_KINDS["swipe"]
    assert not bends({"kind": "load"}) and kind_of({"kind": "load"}).free_head
