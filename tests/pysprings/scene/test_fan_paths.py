# SPDX-License-Identifier: MIT
"""Paths that `[springs]` makes: rays and rays that turn back under each vertical load and rate."""

from itertools import product

import numpy as np
import pytest

from pysprings import Scene
from pysprings.core.errors import UserInputError
from pysprings.core.path_kinds import MEMORY
from pysprings.full_model.accuracy.two_mesh import coarser
from pysprings.model.stages import space_points
from tests.support import tiny

REACH = 0.02


def test_vertical_paths_have_each_rate() -> None:
    scene = tiny.sand(springs={"reach": REACH, "rates": (1e-5, 1e-3)}, drainage={"mode": "coupled"})
    found = {path.name: (path.rate, path.vertical_displacement) for path in scene.load_paths if path.kind == "vertical"}
    half = 0.5 * REACH
    assert found == {
        "down": (1e-5, half), "up": (1e-5, -half), "down_rate_1": (1e-3, half), "up_rate_1": (1e-3, -half),
    }  # fmt: skip


def test_rays_turn_back_under_each_vertical_load_and_rate() -> None:
    """Three under each, with the motion of those of the scene's load, at the rate all along their way."""
    rates, loads = (1e-5, 1e-3), (3e6, 5e6)
    scene = tiny.sand(
        springs={"reach": REACH, "memory": True, "vertical_loads": loads, "rates": rates}, drainage={"mode": "coupled"}
    )
    turning = {path.name: path for path in scene.load_paths if path.role == MEMORY}
    assert len(turning) == 3 * 3 * 2
    for angle, (number, load), (pace, rate) in product(("0", "30", "50"), enumerate((None, *loads)), enumerate(rates)):
        name = f"ray_{angle}_reversed" + (f"_load_{number}" if number else "") + (f"_rate_{pace}" if pace else "")
        path, plain = turning[name], turning[f"ray_{angle}_reversed"]
        assert path.vertical_load == load
        assert [then.value for then in path.then] == [then.value for then in plain.then]
        assert path.duration == pytest.approx(0.12 * REACH / rate)
        assert path.then[0].time == pytest.approx(0.24 * REACH / rate)


def test_rays_turn_back_while_the_vertical_load_changes_where_there_are_several() -> None:
    """To the largest load, half of it, and back, at the three angles; not with rates, and not under one load."""
    several = tiny.sand(springs={"reach": REACH, "memory": True, "vertical_loads": (3e6, 5e6)})
    paths = [path for path in several.load_paths if any(then.load is not None for then in path.then)]
    assert [path.name for path in paths] == ["ray_0_loads", "ray_30_loads", "ray_50_loads"]
    for path in paths:
        assert path.role == MEMORY and path.vertical_load is None
        assert [then.load for then in path.then] == [5e6, None, 2.5e6, None, 5e6, None]
        ends = [then.value for then in path.then if then.load is None]
        assert ends == pytest.approx([sign * float(path.lateral_displacement or 0.0) for sign in (-1, 1, -1)])
    for loads, expected in (((1e6, 5e6), [5e6, None, 4.5e6] * 2), ((1e6, 3e6), [1e6, None, 2.5e6] * 2)):
        springs = {"reach": REACH, "memory": True, "vertical_loads": loads}
        known = tiny.sand(caisson={"vertical_load": 4e6}, springs=springs)
        ray = next(path for path in known.load_paths if path.name == "ray_0_loads")
        assert [then.load for then in ray.then if then.load is not None] == [expected[0], expected[2], expected[0]]
    one = tiny.sand(springs={"reach": REACH, "memory": True})
    coupled = several.model_dump() | {"drainage": {"mode": "coupled"}}
    coupled["springs"] = coupled["springs"] | {"rates": (1e-5,)}
    for scene in (one, Scene.model_validate(coupled)):
        assert not any(then.load for path in scene.load_paths for then in path.then)


def test_directions_add_a_circle_a_bow_a_twist_and_a_walk_that_leave_the_plane() -> None:
    """Not among the planar paths; the walk goes with `held_back`, all with `reach`."""
    springs = {"reach": REACH, "memory": True, "directions": True}
    scene = tiny.sand(springs=springs)
    circle, bow, twist, walk = (path for path in scene.all_paths if path.in_space)
    assert (circle.kind, circle.radius, circle.role) == ("circle", 0.25 * REACH, MEMORY)
    ends = [twist.twist, *(then.value for then in twist.then)]
    wall = 0.5 * scene.caisson.outer_diameter
    assert [wall * float(end or 0.0) / REACH for end in ends] == pytest.approx([0.12, -0.12, 0.4, -0.4, 1.0])
    assert [(path.kind, path.role) for path in (bow, walk)] == [("pull", MEMORY), ("pull", "held-back")]
    (held, corners), (_, far) = space_points(bow), space_points(walk)
    x, y = 0.45 * REACH * np.array([0.75**0.5, 0.5])  # corners at 30 degrees; rotations are free
    assert held == ("u_x", "u_y")
    assert corners == pytest.approx(np.array([[x, y], [x, -y], [-x, y], [-x, -y], [0.0, 0.0]]))
    assert np.linalg.norm(far, axis=1).max() == pytest.approx(0.3125**0.5 * REACH)
    legs = np.diff(far, axis=0, prepend=0.0)
    assert (legs[1] @ legs[2] < 0.0) and (legs[0] @ legs[2] < 0.0) and (legs[3] @ legs[4] < 0.0)  # it turns back
    assert not any(path.in_space for path in scene.load_paths)
    assert coarser(scene).all_paths == scene.all_paths  # their errors are estimated
    few = tiny.sand(springs=springs | {"held_back": False})
    assert [path.name for path in few.all_paths if path.in_space] == ["circle", "bow", "twist"]
    assert tiny.sand(springs={"memory": True, "directions": True}).all_paths == tiny.sand(springs={}).all_paths


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ({"springs": {"reach": REACH, "directions": True}}, "springs.directions: .* memory = true is needed"),
        ({"drainage": {"mode": "undrained"}}, 'springs.directions: its paths leave the plane .*mode = "drained"'),
        ({"mesh": {"discretisation": "hex8"}}, "springs.directions: its paths leave the plane .* bricks"),
    ],
)
def test_directions_are_refused_where_the_model_or_the_springs_have_none(
    sections: dict[str, dict[str, object]], words: str
) -> None:
    springs = {"springs": {"reach": REACH, "memory": True, "directions": True}}
    with pytest.raises((UserInputError, ValueError), match=words):
        tiny.sand(**springs | sections)
