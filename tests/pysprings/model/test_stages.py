# SPDX-License-Identifier: MIT
"""Paths -> stages: what is imposed in (u, w, rotation), by which forces, for half a caisson."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fe_engine.model import Stage
from pysprings import Scene
from pysprings.model.stages import dead_load_stage, imposed_end, path_stages

D, L = 7.8, 4.0


def stage(
    kind: str, extra_load: float = 0.0, solver: dict[str, Any] | None = None, soil: dict[str, Any] | None = None,
    **path: Any,
) -> Stage:  # fmt: skip
    scene = Scene(paths=[{"name": "a", "kind": kind, **path}], solver=solver or {}, soil=soil or {})
    return path_stages(scene, scene.paths[0], extra_load)[0]


def test_a_pull_imposes_u_by_a_force_at_its_height() -> None:
    found = stage("pull", lateral_displacement=0.02, arm=8.0)
    np.testing.assert_array_equal(found.control, [[1, 0, 0]])
    np.testing.assert_array_equal(found.target, [0.02])
    np.testing.assert_array_equal(found.load, np.transpose([[1, 0, -8.0]]))  # M = -H*arm
    np.testing.assert_array_equal(found.force, [0, 0, 0])
    assert found.name == "a"


@pytest.mark.parametrize("rotation", [None, 1e-3])
def test_a_translation_imposes_u_and_rotation(rotation: float | None) -> None:
    found = stage("translation", lateral_displacement=0.02, rotation=rotation)
    np.testing.assert_array_equal(found.control, [[1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(found.target, [0.02, rotation or 0.0])
    np.testing.assert_array_equal(found.load, [[1, 0], [0, 0], [0, 1]])


def test_a_rotation_holds_the_lid_centre() -> None:
    found = stage("rotation", rotation=-2e-3)
    np.testing.assert_array_equal(found.control, [[1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(found.target, [0.0, -2e-3])


def test_a_load_is_half_of_the_whole_caissons() -> None:
    found = stage("load", lateral_force=3e6, arm=5.0, extra_load=100.0)
    assert found.control.shape == (0, 3) and found.load.shape == (3, 0)
    np.testing.assert_array_equal(found.force, [1.5e6, 100.0, -1.5e6 * 5.0])


@pytest.mark.parametrize("kind", ["pull", "translation"])
def test_fixed_heave_adds_a_control(kind: str) -> None:
    free, fixed = (stage(kind, lateral_displacement=0.02, heave=heave) for heave in ("free", "fixed"))
    np.testing.assert_array_equal(fixed.control, [*free.control, [0, 1, 0]])
    np.testing.assert_array_equal(fixed.target, [*free.target, 0.0])
    np.testing.assert_array_equal(fixed.load[:, -1], [0, 1, 0])


def test_the_dead_load_goes_first_and_stays() -> None:
    before = dead_load_stage(-2e5)
    np.testing.assert_array_equal(before.force, [0, -2e5, 0])
    assert before.control.shape == (0, 3)
    np.testing.assert_array_equal(stage("pull", lateral_displacement=0.02, extra_load=-2e5).force, before.force)


@pytest.mark.parametrize(
    ("kind", "path", "stops"),
    [
        ("pull", {"lateral_displacement": 0.02, "report_at": (0.0025, 0.01)}, (0.125, 0.5, 1.0)),
        ("pull", {"lateral_displacement": -0.02, "report_at": (-0.005, -0.02)}, (0.25, 1.0)),
        ("rotation", {"rotation": 1e-3, "report_at": (5e-4,)}, (0.5, 1.0)),
        ("load", {"lateral_force": 4e6, "report_at": (1e6,)}, (0.25, 1.0)),
        ("pull", {"lateral_displacement": 0.02}, (1.0,)),
    ],
)
def test_stops_are_fractions_of_what_is_imposed(kind: str, path: dict[str, Any], stops: tuple[float, ...]) -> None:
    assert stage(kind, **path).stops == pytest.approx(stops)


def test_what_is_imposed() -> None:
    scene = Scene(
        paths=[
            {"name": "a", "kind": "pull", "lateral_displacement": 0.02},
            {"name": "b", "kind": "translation", "lateral_displacement": 0.03, "rotation": 1.0e-3},
            {"name": "c", "kind": "rotation", "rotation": 2.0e-3},
            {"name": "d", "kind": "load", "lateral_force": 4.0e6},
        ]
    )
    assert [imposed_end(path) for path in scene.paths] == [0.02, 0.03, 2e-3, 4e6]


def test_the_first_step_is_the_same_displacement_however_long_the_path() -> None:
    first = [stage("pull", lateral_displacement=u).first_fraction * abs(u) for u in (2e-3, -0.02, 0.2)]
    np.testing.assert_allclose(first, first[0])
    assert first[0] < 1e-5 * D
    turn = stage("rotation", rotation=1e-2)
    assert turn.first_fraction * 1e-2 * L == pytest.approx(first[0])
    assert stage("pull", lateral_displacement=1e-6).first_fraction == 1.0


def test_a_soil_that_yields_early_begins_with_a_smaller_step() -> None:
    """1 % of the strain of the stress beside the tip; cohesion lets it be larger again."""
    pull = {"lateral_displacement": 0.02}
    sand, rock = stage("pull", **pull), stage("pull", **pull, soil={"young_modulus": 100e9})
    stress = 10.56e3 * (1.0 + L)
    assert rock.first_fraction * 0.02 == pytest.approx(0.01 * stress / 100e9 * D)
    assert rock.first_fraction < 0.01 * sand.first_fraction
    strong = stage("pull", **pull, soil={"young_modulus": 100e9, "cohesion": 10.0 * stress})
    assert strong.first_fraction == pytest.approx(11.0 * rock.first_fraction)


def test_the_scenes_step_sizes_win() -> None:
    solver = {"first_step_fraction": 0.02, "max_step_fraction": 0.3}
    found = stage("pull", lateral_displacement=0.02, solver=solver)
    assert (found.first_fraction, found.max_fraction) == (0.02, 0.3)
    only_first = stage("pull", lateral_displacement=0.02, solver={"first_step_fraction": 0.5})
    assert only_first.max_fraction >= only_first.first_fraction == 0.5


def test_a_swipe_turns_where_it_has_slid_to() -> None:
    path = {"name": "a", "kind": "swipe", "lateral_displacement": 5e-3, "rotation": -2e-3, "rate": 1e-3,
            "role": "held-back"}  # fmt: skip
    scene = Scene(paths=[path])
    slide, turn = path_stages(scene, scene.paths[0], 0.0)
    np.testing.assert_array_equal(slide.target, [5e-3, 0.0])
    np.testing.assert_array_equal(turn.target, [5e-3, -2e-3])
    np.testing.assert_array_equal(turn.control, slide.control)
    assert (slide.duration, turn.duration) == pytest.approx((5.0, 2e-3 * L / 1e-3))
    assert turn.first_fraction == pytest.approx(2.5e-6 * D / (2e-3 * L))


def test_a_load_that_climbs_grows_its_moment_under_a_constant_force() -> None:
    path = {"name": "a", "kind": "load", "lateral_force": 2e6, "arm_from": 1.0, "arm": 8.0, "role": "held-back"}
    scene = Scene(paths=[path])
    grow, climb = path_stages(scene, scene.paths[0], 1e5)
    np.testing.assert_allclose(grow.force, [1e6, 1e5, -1e6])
    np.testing.assert_allclose(climb.force, [1e6, 1e5, -8e6])
    assert len(climb.target) == 0
