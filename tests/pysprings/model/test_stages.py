# SPDX-License-Identifier: MIT
"""Paths -> stages: what is imposed in (u, w, rotation), by which forces, for half a caisson."""

from typing import Any

import numpy as np
import pytest

from fe_engine.model import Stage
from fe_engine.solve.stepping import fewest_increments
from pysprings.model.stages import dead_load_stage, imposed_end, path_stages
from tests.support import tiny

D, L = 7.8, 4.0


def stage(
    kind: str, extra_load: float = 0.0, solver: dict[str, Any] | None = None, soil: dict[str, Any] | None = None,
    **path: Any,
) -> Stage:  # fmt: skip
    scene = tiny.sand(paths=[{"name": "a", "kind": kind, **path}], solver=solver or {}, soil=soil or {})
    return path_stages(scene, scene.paths[0], extra_load)[0]


def test_a_pull_imposes_u_by_a_force_at_its_height() -> None:
    found = stage("pull", lateral_displacement=0.02, arm=8.0)
    np.testing.assert_array_equal(found.control, [[1, 0, 0]])
    np.testing.assert_array_equal(found.target, [0.02])
    np.testing.assert_array_equal(found.load, np.transpose([[1, 0, 8.0]]))  # M = H*arm
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
    np.testing.assert_array_equal(found.force, [1.5e6, 100.0, 1.5e6 * 5.0])


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
    scene = tiny.sand(
        paths=[
            {"name": "a", "kind": "pull", "lateral_displacement": 0.02},
            {"name": "b", "kind": "translation", "lateral_displacement": 0.03, "rotation": 1.0e-3},
            {"name": "c", "kind": "rotation", "rotation": 2.0e-3},
            {"name": "d", "kind": "load", "lateral_force": 4.0e6},
        ]
    )
    assert [imposed_end(path) for path in scene.paths] == [0.02, 0.03, 2e-3, 4e6]


def test_soil_without_stress_and_strength_has_a_first_step() -> None:
    nothing = {"yield_surface": "elastic", "effective_unit_weight": 0.0, "surcharge": 0.0}
    bare = stage("pull", lateral_displacement=2e-3, soil=nothing)
    assert bare.first_fraction * 2e-3 == pytest.approx(2.5e-6 * D)
    assert fewest_increments(bare) < 1000


def test_the_first_step_is_the_same_displacement_however_long_the_path() -> None:
    first = [stage("pull", lateral_displacement=u).first_fraction * abs(u) for u in (2e-3, -0.02, 0.2)]
    np.testing.assert_allclose(first, first[0])
    assert first[0] < 1e-5 * D
    turn = stage("rotation", rotation=1e-2)
    assert turn.first_fraction * 1e-2 * L == pytest.approx(first[0])
    ray = stage("translation", lateral_displacement=1e-8, rotation=-1e-2)  # the tip moves, the lid hardly
    assert (ray.first_fraction, ray.max_fraction) == pytest.approx((turn.first_fraction, turn.max_fraction))
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


def test_the_soil_relaxes_in_an_imposed_motion_of_the_scenes_length() -> None:
    """Over the motion of each stage; loads and rests have none."""
    solver, tip = {"viscous_displacement": 1e-6}, 2e-3 * L

    def lag(**path: Any) -> list[float]:
        scene = tiny.sand(paths=[{"name": "a"} | path], solver=solver)
        return [each.lag for each in path_stages(scene, scene.paths[0], 0.0)]

    pull = {"kind": "pull", "lateral_displacement": 5e-3, "role": "held-back"}
    assert lag(**pull, then=["-5 mm"]) == pytest.approx([1e-6 / 5e-3, 1e-6 / 10e-3])
    ray = {"kind": "translation", "lateral_displacement": 5e-3, "rotation": -2e-3}
    assert lag(**ray) == pytest.approx([1e-6 / np.hypot(5e-3, tip)])
    assert lag(kind="rotation", rotation=2e-3) == pytest.approx([1e-6 / tip])
    swipe = ray | {"kind": "swipe", "role": "held-back"}
    assert lag(**swipe) == pytest.approx([1e-6 / 5e-3, 1e-6 / tip])
    probe = {"kind": "probe", "lateral_displacement": 0.3, "load_angle": 1.5, "role": "held-back"}
    assert lag(**probe) == pytest.approx([1e-6 / 0.3])
    assert lag(kind="load", lateral_force=1e6, role="held-back") == [0.0]
    assert stage("load", lateral_force=1e6).lag == 0.0


def test_imposed_motions_in_sand_have_a_small_viscosity_by_themselves() -> None:
    """3e-8 of the diameter (vertical 1e-7), unless the scene has one; none in clay."""

    def lag(role: str = "memory", viscous: float | None = None, **soil: Any) -> list[float]:
        path = {"name": "a", "kind": "translation", "lateral_displacement": 5e-3, "role": role}
        path |= {"then": ["-5 mm"]} if role == "memory" else {}
        interface = {"adhesion_factor": 0.5} if "undrained_shear_strength" in soil else {}
        solver = {"viscous_displacement": viscous}
        scene = tiny.sand(paths=[path], soil=soil, interface=interface, solver=solver)
        return [each.lag for each in path_stages(scene, scene.paths[0], 0.0)]

    small = 3e-8 * 7.8
    assert lag() == pytest.approx([small / 5e-3, small / 10e-3])
    assert lag(viscous=1e-7) == pytest.approx([1e-7 / 5e-3, 1e-7 / 10e-3])
    assert lag(role="calibration") == pytest.approx([small / 5e-3])
    up = tiny.sand(paths=[{"name": "up", "kind": "vertical", "vertical_displacement": -5e-3}])
    assert path_stages(up, up.paths[0], 0.0)[0].lag == pytest.approx(1e-7 * 7.8 / 5e-3)
    assert lag(degradation_strain=1e-4) == lag()
    clay = {"yield_surface": "von-mises", "undrained_shear_strength": 50e3, "rigidity_ratio": 200.0}
    assert lag(**clay) == [0.0, 0.0]


def test_a_swipe_turns_where_it_has_slid_to() -> None:
    path = {"name": "a", "kind": "swipe", "lateral_displacement": 5e-3, "rotation": -2e-3, "rate": 1e-3,
            "role": "held-back"}  # fmt: skip
    scene = tiny.sand(paths=[path])
    slide, turn = path_stages(scene, scene.paths[0], 0.0)
    np.testing.assert_array_equal(slide.target, [5e-3, 0.0])
    np.testing.assert_array_equal(turn.target, [5e-3, -2e-3])
    np.testing.assert_array_equal(turn.control, slide.control)
    assert (slide.duration, turn.duration) == pytest.approx((5.0, 2e-3 * L / 1e-3))
    assert turn.first_fraction == pytest.approx(2.5e-6 * D / (2e-3 * L))


def test_a_probe_imposes_the_displacement_conjugate_to_its_load() -> None:
    """H = R cos, M = R D sin: work R (u cos + rotation D sin), R the multiplier of the pattern of half a caisson."""
    angle = -0.5
    probe = stage("probe", lateral_displacement=0.3, load_angle=angle, role="held-back")
    along = [np.cos(angle), 0.0, D * np.sin(angle)]
    np.testing.assert_allclose(probe.control, [along])
    np.testing.assert_allclose(probe.load[:, 0], along)
    np.testing.assert_allclose(probe.target, [0.3])
    assert not probe.force.any()


def test_a_load_that_climbs_grows_its_moment_under_a_constant_force() -> None:
    path = {"name": "a", "kind": "load", "lateral_force": 2e6, "arm_from": 1.0, "arm": 8.0, "role": "held-back"}
    scene = tiny.sand(paths=[path])
    grow, climb = path_stages(scene, scene.paths[0], 1e5)
    np.testing.assert_allclose(grow.force, [1e6, 1e5, 1e6])
    np.testing.assert_allclose(climb.force, [1e6, 1e5, 8e6])
    assert len(climb.target) == 0


def test_loads_go_on_to_pairs_of_force_and_moment() -> None:
    """Half of H and M; a rest holds both; a single force goes back to the height of the path."""
    path = {"name": "a", "kind": "load", "lateral_force": 2e6, "arm": 5.0, "role": "held-back",
            "then": ["2 MN, 4 MN*m", "rest 1 s", "-1 MN"]}  # fmt: skip
    scene = tiny.sand(paths=[path])
    forces = [stage.force for stage in path_stages(scene, scene.paths[0], 1e5)]
    np.testing.assert_allclose(forces, [[1e6, 1e5, 5e6], [1e6, 1e5, 2e6], [1e6, 1e5, 2e6], [-5e5, 1e5, -2.5e6]])


def test_a_load_goes_on_after_its_climb() -> None:
    path = {"name": "a", "kind": "load", "lateral_force": 2e6, "arm_from": 0.0, "arm": 8.0, "role": "held-back",
            "then": ["2 MN, 4 MN*m"]}  # fmt: skip
    scene = tiny.sand(paths=[path])
    assert [stage.force[2] for stage in path_stages(scene, scene.paths[0], 0.0)] == [0.0, 8e6, 2e6]


def test_a_swipe_goes_on_with_pairs_of_motions() -> None:
    path = {"name": "a", "kind": "swipe", "lateral_displacement": 5e-3, "rotation": -2e-3, "role": "held-back",
            "then": ["0 mm, 1 mrad", "rest 1 s", "1 mm, 1 mrad"]}  # fmt: skip
    scene = tiny.sand(paths=[path])
    found = path_stages(scene, scene.paths[0], 0.0, rest=0.0)
    np.testing.assert_allclose(
        [s.target for s in found], [[5e-3, 0], [5e-3, -2e-3], [0, 1e-3], [0, 1e-3], [1e-3, 1e-3]]
    )
    assert found[2].first_fraction == pytest.approx(2.5e-6 * D / (5e-3 + 3e-3 * L))


@pytest.mark.parametrize(
    ("path", "lateral"),
    [
        ({"kind": "pull", "lateral_displacement": 5e-3, "arm": 2.0}, "-5 mm"),
        ({"kind": "translation", "lateral_displacement": 5e-3, "rotation": 1e-3}, "-5 mm"),
        ({"kind": "rotation", "rotation": 1e-3}, "-1 mrad"),
        ({"kind": "swipe", "lateral_displacement": 5e-3, "rotation": -2e-3}, "0 mm, 1 mrad"),
        ({"kind": "load", "lateral_force": 2e6, "arm": 5.0}, "-2 MN"),
        ({"kind": "load", "lateral_force": 2e6, "arm_from": 0.0, "arm": 5.0}, "1 MN, -2 MN m"),
    ],
    ids=lambda value: value["kind"] if isinstance(value, dict) else "",
)
def test_a_part_changes_the_vertical_load_alone(path: dict[str, Any], lateral: str) -> None:
    """Half of it beyond the balanced one; the parts after it keep it, and go on as without it."""

    def stages(*then: str) -> list[Stage]:
        given = tiny.sand(paths=[{"name": "a", "role": "held-back", "then": then, **path}])
        return path_stages(given, given.paths[0], 1e5, balanced=3e5)

    plain, found = stages(lateral, "rest 1 s"), stages("V 3 MN", lateral, "V 0 MN in 10 s", "rest 1 s")
    first = len(found) - 4
    assert [stage.force[1] for stage in found] == [1e5] * first + [1.2e6, 1.2e6, -3e5, -3e5]
    for stage, before in ((found[first], found[first - 1]), (found[first + 2], found[first + 1])):
        np.testing.assert_array_equal(stage.target, before.target)
        np.testing.assert_array_equal(stage.force[[0, 2]], before.force[[0, 2]])
        np.testing.assert_array_equal(stage.control, before.control)
        assert (stage.first_fraction, stage.max_fraction) == (0.1, 0.25)
    assert [found[first].duration, found[first + 2].duration, found[first].name] == [0.0, 10.0, "a, then 1"]
    for stage, other in zip([found[first + 1], found[-1]], plain[-2:], strict=True):
        np.testing.assert_array_equal(stage.target, other.target)
        np.testing.assert_array_equal(stage.force[[0, 2]], other.force[[0, 2]])
        assert (stage.first_fraction, stage.duration) == (other.first_fraction, other.duration)


def test_a_vertical_load_takes_the_time_of_undrained_parts_and_no_relaxation() -> None:
    path = {"name": "a", "kind": "pull", "lateral_displacement": 5e-3, "role": "held-back", "then": ["V 3 MN", "0 mm"]}
    scene = tiny.sand(paths=[path], solver={"viscous_displacement": 1e-6}, drainage={"mode": "undrained"})
    found = path_stages(scene, scene.paths[0], 0.0, undrained_time=2.0)
    assert [stage.duration for stage in found] == [2.0, 2.0, 2.0]
    assert [stage.lag for stage in found] == pytest.approx([2e-4, 0.0, 2e-4])


@pytest.mark.parametrize("rate", [None, 1e-4])
def test_a_fan_with_memory_has_three_rays_that_turn_back(rate: float | None) -> None:
    rates = {} if rate is None else {"rates": (rate,)}
    scene = tiny.sand(springs={"reach": 20e-3, "memory": True, **rates})
    shift, middle, turned = (path for path in scene.load_paths if path.role == "memory")
    # back and forth, farther; the middle one twice
    sizes = 20e-3 * np.array([0.12, -0.12, 0.24, -0.24, 0.24, -0.24, 0.4, -0.4, 0.4])
    targets = [s.target.tolist() for s in path_stages(scene, shift, 0.0)]
    np.testing.assert_allclose(targets, [[u, 0.0] for u in sizes], rtol=1e-12)
    for path, angle in ((middle, 30.0), (turned, 50.0)):
        ends = [s.target for s in path_stages(scene, path, 0.0)]
        np.testing.assert_allclose([np.hypot(u, turn * L) for u, turn in ends], np.abs(sizes))
        np.testing.assert_allclose([np.degrees(np.arctan(turn * L / u)) for u, turn in ends], angle)
    times = [s.duration for s in path_stages(scene, turned, 0.0)]
    steps = np.abs(np.diff(sizes, prepend=0.0)) / 1e-4
    assert times == ([0.0] * 9 if rate is None else pytest.approx(steps))
