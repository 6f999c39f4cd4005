# SPDX-License-Identifier: MIT
"""Elements in space: planes and directions, energy, tangents; calibrated on a circle beside an outside law."""

import itertools
import json
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.core.variables import TORSION
from pysprings.macro.answer import MacroWarning
from pysprings.macro.comparison import compare
from pysprings.macro.comparison_text import SPACE_NOTE, to_text
from pysprings.macro.fan import build_fan
from pysprings.macro.predict import sequence
from pysprings.macro.space import compare_in_space, sequence_in_space
from pysprings.memory import build
from pysprings.memory.build import build_memory
from pysprings.memory.calibration import MOST_NUMBERS, way_of
from pysprings.memory.elements import PLASTIC, PLATES, REVERSIBLE, SPACE, SPACE_STATES, STATES, advance, tangents
from pysprings.memory.offered import AZIMUTHS, Offered, in_space, numbers_in_space, numbers_of, offered
from pysprings.memory.shares import samples
from pysprings.memory.space import calibrate_in_space, torsion_elements, way_out
from pysprings.memory.space_model import SpaceSprings, SpaceStepper
from pysprings.results.tables.sequence import read_sequence
from pysprings.springs.checks import RESULT, extract_springs, open_springs, save_springs
from pysprings.springs.path import SPACE_TURNS
from pysprings.springs.springs import Springs
from tests.support import space_paths
from tests.support.commands import command
from tests.support.space_paths import RADIUS, elbow
from tests.support.space_springs import calibrated, elements, planar
from tests.support.winkler import REACH, mixed

LENGTH = space_paths.LENGTH


def walk(rows, motions):
    """Loads (n, m) and tangents of elements along motions (n, m), from rest."""
    motions = np.ascontiguousarray(motions, dtype=float)
    m = motions.shape[1]
    loads, found = np.zeros(motions.shape), np.zeros((len(motions), m, m))
    tangents(np.ascontiguousarray(rows), motions, 0.01 * REACH, loads, found)
    return loads, found


def random_way(seed, n=40, size=0.05):
    return np.cumsum(np.random.default_rng(seed).normal(size=(n, SPACE)), axis=0) * size * REACH


def turned(way, angle):
    """Motions or loads (n, 5) turned about the axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.hstack([c * way[:, :2] - s * way[:, 2:4], s * way[:, :2] + c * way[:, 2:4], way[:, 4:]])


def test_elements_of_one_plane_are_those_with_one_direction() -> None:
    """Round ones, and all with the direction x, carry along x what planar ones do, and nothing across."""
    rows, way = mixed(), random_way(3)[:, :2]
    plane, whole = walk(rows, way)
    single = np.hstack([rows, np.broadcast_to([1.0, 0.0, 0.0], (len(rows), 3))])
    single[np.isin(rows[:, 0], (PLASTIC, REVERSIBLE)), 10] = 0.0
    loads, found = walk(single, np.hstack([way, np.zeros((len(way), 3))]))
    np.testing.assert_allclose(loads[:, :2], plane, rtol=1e-12, atol=1e-12 * np.abs(plane).max())
    np.testing.assert_allclose(found[:, :2, :2], whole, rtol=1e-9, atol=1e-9 * np.abs(whole).max())
    assert not loads[:, 2:].any()


def test_a_way_that_is_turned_has_a_turned_answer() -> None:
    """Exactly by the angle between the planes of spread elements; round elements alone by any angle."""
    way = random_way(5)
    for rows, angle in ((elements(), np.pi / AZIMUTHS), (in_space(mixed(), np.zeros(len(mixed()), bool)), 0.3)):
        one, other = walk(rows, way)[0], walk(rows, turned(way, angle))[0]
        np.testing.assert_allclose(turned(one, angle), other, atol=1e-9 * np.abs(one).max())


def test_the_tangent_is_that_of_differences() -> None:
    rows, state, q = elements(), np.zeros((len(elements()), SPACE_STATES)), np.zeros(SPACE)
    F, K = np.zeros(SPACE), np.zeros((SPACE, SPACE))
    for aim in random_way(7, 10):
        advance(rows, q, aim, state, F, K)
        q = aim

    def after(change):
        F, K = np.zeros(SPACE), np.zeros((SPACE, SPACE))
        advance(rows, q, q + change, state.copy(), F, K)
        return F, K

    step = np.array([1.0, -0.4, 0.7, 0.2, 0.3]) * 1e-3 * REACH
    found = np.stack([(after(step + d)[0] - after(step - d)[0]) / 2e-9 for d in 1e-9 * np.eye(SPACE)], axis=1)
    np.testing.assert_allclose(after(step)[1], found, atol=1e-5 * np.abs(found).max())


def test_closed_loops_in_five_motions_gain_no_work() -> None:
    """1,000 of them from rest, of all sizes; the work of a loop beside what goes to and fro in it."""
    random, worst = np.random.default_rng(11), np.inf
    for number in range(1000):
        corners = random.normal(size=(random.integers(2, 5), SPACE)) * REACH * 10.0 ** random.uniform(-3.0, 0.0)
        ends = np.concatenate([np.zeros((1, SPACE)), corners, np.zeros((1, SPACE))])
        share = np.linspace(0.0, 1.0, 31)[1:, None]
        way = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(ends)])
        loads = np.concatenate([np.zeros((1, SPACE)), walk(elements(number % 4 + 1), way)[0]])
        works = 0.5 * (loads[1:] + loads[:-1]) * np.diff(way, axis=0, prepend=0.0)
        worst = min(worst, works.sum() / np.abs(works).sum())
    assert worst > -1e-3  # the trapezoidal rule of loops in the elastic range


def test_a_circle_calibrates_springs_that_meet_an_elbow_of_another_law() -> None:
    """Held back, with leaning, at its motions and under its loads; the torsion meets its own path."""
    rows = compare_in_space(calibrated()).set_index("path")
    assert list(rows.index) == ["circle", "twist", "elbow"]
    for name in ("circle", "elbow"):
        assert rows.loc[name, ["H_error_max_pct", "M_error_max_pct", "p_error_max_pct"]].max() < 6.0
    assert rows.loc["elbow", ["u_error_max_pct", "rotation_error_max_pct"]].max() < 8.0
    assert rows.loc["twist", "T_error_max_pct"] < 2.0 and rows.loc["elbow", "T_error_max_pct"] < 1e-6
    assert np.isnan(rows.loc["twist", "H_error_max_pct"])
    frame = compare(calibrated(), "memory")
    text, elbow_ = to_text(frame), frame.set_index("path").loc["elbow"]
    assert SPACE_NOTE in text and f"{elbow_['p_error_max_pct']:.2f}" in text.split("held-back paths")[1]
    assert elbow_["H_error_max_pct"] == rows.loc["elbow", "H_error_max_pct"] and elbow_["states"] == 58
    assert f"{1e3 * elbow_['w_error_max_m']:.2f}" in text.split("held-back paths")[1]
    assert "elbow" not in compare(calibrated(), "fan")["path"].values


def test_p_by_depth_is_that_of_the_other_law_out_of_the_plane() -> None:
    """On the elbow that is held back, as vectors, over the largest p; turned with the motion."""
    turns = elbow(0.3 * space_paths.REACH, 0.6 * space_paths.REACH, 0.1 / LENGTH)[1:]
    known = space_paths.by_depth(turns).transpose(1, 0, 2)
    answer = sequence_in_space(calibrated(), turns, control="state")
    found = np.stack([answer["p_x"], answer["p_y"]])
    size = np.linalg.norm(known, axis=0).max()
    assert np.linalg.norm(found - known, axis=0).max() < 0.06 * size
    assert answer["depth"].values.tolist() == space_paths.DEPTH.tolist()
    across = turns[:, [1, 0, 3, 2, 4]] * [-1.0, 1.0, -1.0, 1.0, 1.0]  # a quarter turn
    other = sequence_in_space(calibrated(), across, control="state")
    np.testing.assert_allclose(other["p_y"], found[0], atol=1e-6 * size)


def test_elements_in_space_are_those_of_their_offer() -> None:
    rows = mixed(8)
    spread = np.isin(rows[:, 0], PLATES)
    found = Offered.of_space(elements())
    assert found.spread.sum() < len(found.rows)
    again = Offered.of_space(in_space(rows, spread))
    np.testing.assert_allclose(again.rows, np.concatenate([rows[~spread], rows[spread]]), rtol=1e-12)


def test_a_pull_in_any_direction_has_the_same_answer() -> None:
    """Within 2 % for any angle, also between the planes of spread elements."""
    rows, worst = SpaceSprings.of(calibrated()).elements.rows, 0.0
    for ratio in np.radians([-45.0, 0.0, 30.0, 60.0]):
        size = 0.5 * REACH * np.concatenate([np.linspace(0.02, 1.0, 25), np.linspace(0.9, -1.0, 20)])
        way = np.zeros((size.size, SPACE))
        way[:, 0], way[:, 1] = size * np.cos(ratio), size * np.sin(ratio)
        straight = walk(rows, way)[0]
        for angle in np.radians([7.5, 15.0, 22.5, 37.0, 45.0, 90.0]):
            found = turned(walk(rows, turned(way, angle))[0], -angle)
            worst = max(worst, np.abs(found - straight).max() / np.linalg.norm(straight, axis=1).max())
    assert worst < 0.02


def test_the_planar_elements_are_those_without_paths_out_of_the_plane() -> None:
    tree = space_paths.springs()
    del tree["space"]
    springs = Springs.of(tree)
    alone = planar(build_fan(springs), springs)
    np.testing.assert_array_equal(build_memory(Springs.of(calibrated())).elements.rows, alone.rows)


def test_the_state_stays_within_the_numbers_of_other_programs() -> None:
    rows = mixed(60)
    choice = offered(rows)
    assert numbers_of(choice.rows, choice.spread).max() == STATES * AZIMUTHS
    found = SpaceSprings.of(calibrated()).elements.rows
    assert 100 < numbers_in_space(found) <= MOST_NUMBERS


def test_elements_in_space_are_kept_in_the_file_and_belong_to_its_paths(tmp_path, monkeypatch) -> None:
    save_springs(calibrated(), tmp_path / "springs.nc")
    read = open_springs(tmp_path / "springs.nc")
    monkeypatch.setattr(build, "calibrate", None)
    targets = np.array([[1e5, 2e5, 1e5, -2e5, 0.0], [2e5, 1e5, 1e5, -2e5, 0.0]])
    answers = [sequence_in_space(tree, targets) for tree in (calibrated(), read)]
    np.testing.assert_array_equal(answers[0]["u_y"], answers[1]["u_y"])
    monkeypatch.undo()
    other = calibrated().copy(deep=True)
    other["space/circle"]["H_x"] *= 1.1
    assert build.has_elements(Springs.of(calibrated())) and not build.has_elements(Springs.of(other))


def test_loads_and_motions_answer_each_other_step_by_step() -> None:
    model, stepper = SpaceSprings.of(calibrated()), SpaceStepper(SpaceSprings.of(calibrated()))
    turns = elbow(0.2 * REACH, 0.3 * REACH, 0.2 / LENGTH)[1::4]
    turns[:, 4] = np.linspace(0.0, 0.1 * REACH / RADIUS, len(turns))
    found, pushes, message = model.solve("state", turns)
    assert message == "" and found == pytest.approx(turns)
    back, _, _ = model.solve("load", pushes)
    np.testing.assert_allclose(back, turns, atol=2e-3 * REACH)
    for turn, push in zip(turns, pushes, strict=True):
        np.testing.assert_allclose(stepper.advance(motion=turn), push, rtol=1e-9, atol=1e-6)
        stepper.advance(motion=turn)  # from the same committed state
        stepper.commit()
    np.testing.assert_allclose(stepper.load, pushes[-1], rtol=1e-9)
    np.testing.assert_allclose(stepper.advance(load=stepper.load), stepper.motion, atol=1e-12)
    aim, change = stepper.motion * 1.01, 1e-9 * np.array([1.0, -0.3, 0.2, 0.1, 0.2])
    ends = [stepper.advance(motion=aim + sign * change) for sign in (1.0, -1.0)]
    stepper.advance(motion=aim)
    np.testing.assert_allclose(ends[0] - ends[1], stepper.tangent @ (2.0 * change), rtol=1e-4)
    np.testing.assert_allclose(model.tangents(turns)[0], model.tangents(turns[:1])[0])
    with pytest.raises(UserInputError, match="give a motion or a load"):
        stepper.advance()
    with pytest.raises(BeyondSprings, match="do not carry the load"):
        stepper.advance(load=np.array([1e10, 0.0, 0.0, 0.0, 0.0]))


def test_p_under_a_few_loads_is_that_of_the_way_between_them() -> None:
    """Under loads in proportion a motion is not straight, and p of a step is that of many."""
    full = SpaceSprings.of(calibrated()).solve("state", np.array([[0.5 * REACH, 0.0, 0.0, 0.1 * REACH / LENGTH, 0.0]]))
    H, M = full[1][0, 0], full[1][0, 3]
    loads = np.array([[H, M], [-0.9 * H, 0.3 * M], [0.8 * H, 0.9 * M]])
    many = np.stack([np.interp(np.arange(1, 121) / 40, np.arange(4), [0.0, *each]) for each in loads.T], axis=1)
    way = {n: np.insert(np.zeros((len(each), 3)), [0, 2], each, axis=1) for n, each in ((3, loads), (120, many))}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        pairs = [[sequence(calibrated(), each, springs_kind="memory", extrapolate=True)["p"] for each in (loads, many)]]
        pairs += [[sequence_in_space(calibrated(), way[n], extrapolate=True)["p_x"] for n in (3, 120)]]
    for once, often in pairs:
        error = np.abs(once.values - often.values[:, 39::40]).max() / np.abs(often.values).max()
        assert error < 0.004, error


def test_a_load_along_y_leans_towards_y_in_the_axes_of_the_field() -> None:
    """H_y alone: u_y > 0, and rot_x < 0 where the caisson leans towards +y; M_x = -H_y h raises both."""
    free = sequence_in_space(calibrated(), [[0.0, 2e5, 0.0, 0.0, 0.0]])
    high = sequence_in_space(calibrated(), [[0.0, 2e5, -8e5, 0.0, 0.0]])
    along = sequence_in_space(calibrated(), [[2e5, 0.0, 0.0, 8e5, 0.0]])
    assert 0.0 < float(free["u_y"][0]) < float(high["u_y"][0])
    assert float(high["rot_x"][0]) < min(0.0, float(free["rot_x"][0]))
    assert float(along["rot_y"][0]) == pytest.approx(-float(high["rot_x"][0]), rel=0.02)
    assert float(along["u_x"][0]) == pytest.approx(float(high["u_y"][0]), rel=0.02)


@pytest.mark.usefixtures("few_offered")
def test_what_the_springs_do_not_cover_is_marked_or_refused() -> None:
    far = [[1.5 * space_paths.REACH, 0.0, 0.0, 0.0, 0.0]]
    with pytest.raises(BeyondSprings, match=r"beyond the range .* 1.5 times"):
        sequence_in_space(calibrated(), far, control="state")
    with pytest.warns(MacroWarning, match="beyond the range"):
        assert sequence_in_space(calibrated(), far, control="state", extrapolate=True)["extrapolated"][0] == 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        back = sequence_in_space(calibrated(), [*far, [0.0] * 5], control="state", extrapolate=True)
        short = sequence_in_space(calibrated(), 0.99 * np.array([far[0], [0.0] * 5]) / 1.5, control="state")
    assert back["extrapolated"].values.tolist() == [1, 1] and short["unchecked"].values.tolist() == [1, 1]
    both = [[2e5, 0.0, 0.0, 0.0, 3e5]]
    with pytest.warns(MacroWarning, match="share no friction"):
        answer = sequence_in_space(calibrated(), both)
    assert answer["torsion_apart"][0] == 1 and float(answer["rot_z"][0]) > 0.0
    with pytest.warns(MacroWarning, match="1 of 1 states are under another V than 2 MN"):
        assert sequence_in_space(calibrated(), [[2e5, 0, 0, 0, 0]], V=1e6)["off_load"][0] == 1
    with pytest.raises(UserInputError, match="'fan' answers loads in one plane only"):
        sequence_in_space(calibrated(), both, springs_kind="fan")
    with pytest.raises(UserInputError, match=r"no complete path that leaves the plane.*directions = true"):
        tree = calibrated().copy(deep=True)
        del tree["space"]
        sequence_in_space(tree, both)
    with pytest.raises(UserInputError, match="no complete path that leaves the plane"):
        tree = calibrated().copy(deep=True)
        tree["space/circle"].attrs["status"] = tree["space/twist"].attrs["status"] = "partial"
        sequence_in_space(tree, both)
    with pytest.raises(UserInputError, match="they carry no torsion"):
        sequence_in_space(calibrated(twisted=False), both)
    assert compare_in_space(calibrated(twisted=False))["T_error_max_pct"].isna().all()


def test_steps_at_another_rate_are_marked_and_what_comes_after_another_vertical_load() -> None:
    """A rest has no rate; rates are those of the motion of the ray, here 1 mm/s over (u_x, u_y)."""
    springs = replace(SpaceSprings.of(calibrated()), rate=1e-3)
    way = np.array([[3e-4, 4e-4, 0, 0, 0], [6e-4, 8e-4, 0, 0, 0], [6e-4, 8e-4, 0, 0, 0], [3e-4, 4e-4, 0, 0, 0]])
    answer = springs.answer("state", way, np.array([2e6, 3e6, 2e6, 2e6]), np.array([0.5, 100.0, 200.0, 200.01]))
    assert answer["off_rate"].values.tolist() == [0, 1, 0, 1] and answer["off_load"].values.tolist() == [0, 1, 1, 1]
    assert "2 of 4 steps are at another rate than that of the springs" in answer.attrs["warnings"]
    assert any("the springs are those of 1 mm/s" in each for each in answer.attrs["remarks"])
    assert "off_rate" not in replace(springs, rate=None).answer("state", way, None, np.arange(1.0, 5.0))
    known = calibrated().attrs
    kept = ("title", "pysprings_version", "scene_sha256", "drainage", "skirt_length_m")  # where the springs are from
    assert {name: answer.attrs.get(name) for name in kept} == {name: known.get(name) for name in kept}
    assert answer.attrs["skirt_length_m"] > 0.0


def test_beyond_a_limit_load_of_the_full_model_there_is_no_answer_in_any_direction() -> None:
    """It holds at its V and for H and M in its ratio, in the plane of H; the springs go on beyond."""
    tree = calibrated().copy(deep=True)
    name, ray = next((name, node) for name, node in tree["paths"].children.items() if not node["rotation"].any())
    H, M = (0.5 * float(ray[each][-1]) for each in "HM")
    ray.attrs |= {"end": "limit load", "end_reason": "limit load", "end_H_N": H, "end_M_Nm": M}
    c, s = np.cos(0.7), np.sin(0.7)
    load = np.array([[c * H, s * H, -s * M, c * M, 0.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        assert sequence_in_space(tree, 0.99 * load).sizes["step"] == 1
        for V in (None, 2e6):
            with pytest.raises(BeyondSprings, match=f"beyond what the full model carried: path '{name}' met a limit"):
                sequence_in_space(tree, np.vstack([1.01 * load, 0.0 * load]), V=V, extrapolate=True)
        assert sequence_in_space(tree, 1.01 * load, V=1e6)["off_load"][0] == 1


def test_a_damaged_path_out_of_the_plane_is_refused(tmp_path) -> None:
    for name, change, words in (
        ("H_x", lambda path: path["H_x"].values.__setitem__(3, np.nan), "space/circle/H_x: not finite"),
        ("role", lambda path: path.attrs.update(role="calibration"), "space/circle/role: attribute must be one of"),
        ("T", lambda path: path.__delitem__("T"), "space/circle/T: missing variable"),
        ("kind", lambda path: path.attrs.update(kind="round"), "space/circle/kind: attribute must be one of"),
        ("depth", lambda path: path.assign_coords(depth=path["depth"] + 0.1), "space/circle/depth: is not that of"),
        ("start", lambda path: path["converged"].values.__setitem__(0, 0), "space/circle/converged: needs the initial"),
        ("one", lambda path: path["converged"].values.__setitem__(slice(1, None), 0), "space/circle/converged: needs"),
        ("p_y", lambda path: path["p_y"].values.__setitem__((2, 0, 5), np.inf), "space/circle/p_y: not finite"),
    ):
        tree = space_paths.springs().copy(deep=True)
        path = tree["space/circle"].to_dataset(inherit=False).copy(deep=True)
        path = change(path) or path
        groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree} | {"/space/circle": path}
        with pytest.raises(UserInputError, match=words):
            save_springs(type(tree).from_dict(groups, name=tree.name), tmp_path / f"{name}.nc")


def test_paths_of_another_vertical_load_or_partial_ones_do_not_calibrate(monkeypatch: pytest.MonkeyPatch) -> None:
    """A circle under another V than that of the rays is left out; the refusal comes before any fit."""
    monkeypatch.delattr(build, "calibrate")
    tree = calibrated().copy(deep=True)
    assert [path.name for path in Springs.of(tree).turning] == ["circle", "twist"]
    tree["space/circle"]["V"].values[:] *= 1.5
    assert [path.name for path in Springs.of(tree).turning] == ["twist"]
    with pytest.raises(UserInputError, match="no complete path that leaves the plane"):
        sequence_in_space(tree, [[1e5, 0.0, 0.0, 0.0, 0.0]])


def test_elements_of_torsion_have_the_stiffness_of_the_full_model_at_rest() -> None:
    """T/R over R rot_z: K_T/R^2, also where that is half of what the twist begins with."""
    springs, reach = Springs.of(space_paths.springs()), REACH
    (twist,) = (way_out(path, RADIUS, reach) for path in springs.turning if path.kind == "twist")
    for known, within in ((space_paths.TORSION, 0.03), (0.5 * space_paths.TORSION, 0.03)):
        springs.attrs[TORSION] = known
        stiff = replace(twist, weights=1e-6 * twist.weights)  # what the twist says does not count
        rows, _ = torsion_elements([stiff], springs, reach)
        assert rows[:, 4].sum() == pytest.approx(known / RADIUS**2, rel=within)
    assert np.all(rows[:, 12] == 1.0) and not rows[:, 10:12].any()


def test_all_ways_count_as_they_are_and_turned_by_half_of_the_angle_between_planes(monkeypatch) -> None:
    tree, found = space_paths.springs(), []
    springs = Springs.of(tree)
    table = build_fan(springs)
    plane, ways = planar(table, springs), samples(springs, table)

    def kept(_choice, known, *_args):
        found.extend(known)
        raise StopIteration

    monkeypatch.setattr("pysprings.memory.space.fitted", kept)
    with pytest.raises(StopIteration):
        calibrate_in_space(springs, plane, ways, table, np.eye(2))
    assert len(found) == 2 * len(ways) + 2  # and the circle
    half = 0.5 * np.pi / AZIMUTHS
    for (motions, loads, _), (way, push, _) in zip(found[: len(ways)], found[len(ways) : -2], strict=True):
        for one, other in ((motions, way), (loads, push)):
            np.testing.assert_allclose(other[:, :2], np.cos(half) * one)
            np.testing.assert_allclose(other[:, 2:4], np.sin(half) * one)
    (circle, loads, _), (turned, push, _) = found[-2:]
    for one, other in ((circle, turned), (loads, push)):
        found_there = other[:, :2] + 1j * other[:, 2:4]
        np.testing.assert_allclose(found_there, np.exp(1j * half) * (one[:, :2] + 1j * one[:, 2:4]))
    np.testing.assert_array_equal(turned[:, 4], circle[:, 4])


def test_a_twist_uses_the_range_of_the_twist() -> None:
    model = SpaceSprings.of(calibrated())
    reach, far = model.reach, float(Springs.of(calibrated()).space["twist"]["rot_z"].max())
    turns = np.array([[0.0, 0, 0, 0, 0.5 * far], [0.1 * reach, 0, 0, 0, -1.5 * far], [0.8 * reach, 0, 0, 0, 0.1 * far]])
    np.testing.assert_allclose(model.range_used(turns), [0.5, 1.5, 0.8], rtol=1e-6)
    with pytest.raises(BeyondSprings, match=r"beyond the range .* 1.5 times"):
        sequence_in_space(calibrated(), turns[1:2], control="state")


def test_w_is_that_of_the_rays_in_any_direction() -> None:
    """Along the rays and those that turn back it is the law's within 10 % of the largest, turned within 8 %."""
    springs = Springs.of(calibrated()).at()
    space = SpaceSprings.of(springs)
    for path in springs.paths.values():
        w, found = path["w"] - path["w"][0], []
        for c, s in ((1.0, 0.0), (0.6, 0.8)):
            u, lean = path.u, path.rotation
            moved = space.heave(np.stack([c * u, s * u, -s * lean, c * lean, 0.0 * u], axis=1))
            found.append(moved - float(space.origin["w"][0]))
        assert np.abs(found[0] - w).max() < 0.1 * 1.6e-3 and np.abs(found[1] - found[0]).max() < 0.08 * 1.6e-3
    circle = springs.space["circle"]  # recorded with w at rest: rays alone lift it by 0.9 mm
    turns = np.stack([circle[name] for name in SPACE_TURNS], axis=1)
    assert abs(space.heave(turns)[-1] - float(space.origin["w"][0])) < 0.05 * 1.6e-3


def test_the_error_of_w_on_held_back_paths_is_stated_with_every_answer() -> None:
    """The larger one of that at the motions and that under the loads, of the largest w of the path."""
    tree = calibrated().copy(deep=True)
    model, path = SpaceSprings.of(tree), Springs.of(tree).space["elbow"]
    rest, turns = np.zeros((1, 5)), path.turns()
    moved = np.vstack([rest, model.solve("load", path.pushes()[1:])[0]])
    held, loaded = (model.heave(each) - model.heave(rest) for each in (turns, moved))
    for w in (1.1 * held, 0.9 * loaded):
        tree["space/elbow"].dataset = tree["space/elbow"].to_dataset(inherit=False).assign(w=("step", w + 3e-4))
        worst = max(np.abs(each - (w - w[0])).max() for each in (held, loaded))
        (row,) = (each for each in compare_in_space(tree).to_dict("records") if each["path"] == "elbow")
        assert abs(row["w_error_max_m"]) == pytest.approx(worst, rel=1e-6)
        said = f"w {1e3 * worst:.2g} of {1e3 * np.abs(w - w[0]).max():.2g} mm"
        for V in (None, 2.1e6):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                answer = sequence_in_space(tree, [[2e5, 0, 0, 0, 0]], V=V)
            assert said in answer.attrs["remarks"][-1]


def test_w_beyond_the_longest_way_is_marked() -> None:
    model = SpaceSprings.of(calibrated())
    there = np.array([[0.5 * model.reach, 0, 0, 0, 0], [0, 0.5 * model.reach, 0, 0, 0]])
    assert not model.answer("state", there).attrs["warnings"]
    (text,) = model.answer("state", np.tile(there, (200, 1))).attrs["warnings"]
    assert "times the longest way of the calibration: heave" in text
    twist = 0.5 * model.elements.twist / model.elements.radius * np.array([[0, 0, 0, 0, 1.0], [0, 0, 0, 0, -1.0]])
    assert not model.answer("state", np.tile(twist, (400, 1))).attrs["warnings"]  # a twist leaves w as it is


def test_a_sequence_in_six_columns_is_answered_by_the_command(tmp_path) -> None:
    """In SI as JSON, as a table for people, with the marks; `compare` lists the paths out of the plane."""
    file, table = tmp_path / "springs.nc", tmp_path / "loads.csv"
    save_springs(calibrated(), file)
    table.write_text("H_x [kN],H_y [kN],M_x [kN m],T [kN m]\n0,0,0,0\n100,50,-200,0\n100,-50,200,100\n")
    warnings.simplefilter("ignore", MacroWarning)
    done = command("predict", file, "--sequence", table, "--json")
    assert done.code == 0, done.err
    rows = json.loads(done.out)["states"]
    loads = np.array([[0, 0, 0, 0, 0], [1e5, 5e4, -2e5, 0, 0], [1e5, -5e4, 2e5, 0, 1e5]])
    with pytest.warns(MacroWarning):
        known = sequence_in_space(calibrated(), loads)
    assert [row["u_y"] for row in rows] == pytest.approx(known["u_y"].values.tolist())
    assert [row["torsion_apart"] for row in rows] == [0, 0, 1]
    text = command("predict", file, "--sequence", table, "--springs", "memory")
    assert "rot_z [mrad]" in text.out and "torsion_apart" in text.out and "w out of one plane is that" in text.err
    assert " w [mm] " in text.out and [row["w"] for row in rows] == pytest.approx(known["w"].values.tolist())
    assert command("predict", file, "--sequence", table, "--out", tmp_path / "a.csv").code == 0
    assert "rot_z_rad,H_x_N" in (tmp_path / "a.csv").read_text()
    for option, words in ((["--springs", "fan"], "one plane only"), (["--stiffness"], "is that of one plane"),
                          (["--path", "pull"], "by springs of several paths")):  # fmt: skip
        refused = command("predict", file, "--sequence", table, *option)
        assert refused.code == 2 and words in refused.err
    shown = command("compare", file, "--springs", "memory")
    assert "paths out of one plane" in shown.out and "elbow" in shown.out
    found = json.loads(command("compare", file, "--json").out)["rows"]
    assert [row["path"] for row in found if row["springs_from"] == "paths out of one plane"] == [
        "circle",
        "twist",
        "elbow",
    ]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("H_x_N,u_y_m\n1,2\n", "expected either loads or motions: some of H_x_N"),
        ("H_x_N,H_N\n1,2\n", "H_N: of one plane, beside columns of six degrees of freedom"),
        ("u_x_m,w_m\n1,2\n", "w_m: w follows from the vertical load"),
        ("H_N,w_m\n1,0\n", "w_m: one column too many"),
        ("H_x_N,M_x_Nm\n1,\n", "M_x_Nm: blank"),
        ("Fx_N,Fz_N,V_N\n1,-2,2\n", "Fz_N: gives what .V_N. gives, too"),
    ],
)
def test_columns_that_do_not_go_together_are_refused(tmp_path, lines, words) -> None:
    (tmp_path / "s.csv").write_text(lines)
    with pytest.raises(UserInputError, match=words):
        read_sequence(tmp_path / "s.csv")
    (tmp_path / "t.csv").write_text("u_y [mm],rot_z [mrad],w_m,V [kN],time [s]\n1,2,0,5,1\n2,2,0,5,2\n")
    read = read_sequence(tmp_path / "t.csv")
    assert read.in_space and read.control == "state" and read.V.tolist() == [5e3, 5e3]
    np.testing.assert_allclose(read.targets, [[0, 1e-3, 0, 0, 2e-3], [0, 2e-3, 0, 0, 2e-3]])


def test_a_sequence_has_the_columns_of_load_cases(tmp_path) -> None:
    (tmp_path / "s.csv").write_text("Fx [kN],Fy [kN],Fz [kN],Mx [kNm],My [kNm],Mz [kNm]\n1,2,-6,3,4,5\n-1,0,-7,0,0,0\n")
    read = read_sequence(tmp_path / "s.csv")
    assert read.in_space and read.control == "load" and read.V.tolist() == [6e3, 7e3]
    np.testing.assert_allclose(read.targets, [[1e3, 2e3, 3e3, 4e3, 5e3], [-1e3, 0, 0, 0, 0]])


def test_rows_in_one_plane_have_the_difference_from_its_springs() -> None:
    """Springs in space that are a tenth softer; the same sequence through the columns of one plane has other loads."""
    groups = {node.path: node.to_dataset(inherit=False) for node in calibrated().subtree}
    softer = groups["/memory"]["space_rows"].copy(deep=True)
    softer[:, 4:7] *= 0.9
    tree = xr.DataTree.from_dict(groups | {"/memory": groups["/memory"].assign(space_rows=softer)}, name="springs")
    motions = np.array([[6e-4, 8e-4, -8e-5, 6e-5, 0.0], [-6e-4, -8e-4, 0.0, 0.0, 0.0], [3e-4, 4e-4, 0.0, 0.0, 0.0]])
    across = motions + np.array([0.0, 0.0, 1e-5, 0.0, 0.0])
    for rows, words in ((motions, "differ by 10 %"), (across, "held-back paths")):
        assert words in sequence_in_space(tree, rows, control="state").attrs["remarks"][-1]
    assert "held-back paths" in sequence_in_space(calibrated(), motions, control="state").attrs["remarks"][-1]


def test_lateral_loads_out_of_the_plane_are_extrapolated_as_those_of_a_translation() -> None:
    """By a tenth, where the reactions of all rays are; T and motions stay, and all without an extrapolation."""
    tree = space_paths.springs()
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    rays = [name for name in groups if name.startswith("/paths/")]
    groups["/"] = groups["/"].assign_attrs(schema=RESULT)
    for name in rays:
        groups[name]["time"] = "step", np.arange(float(groups[name].sizes["step"])), {"units": "s", "long_name": "time"}
    as_recorded = extract_springs(xr.DataTree.from_dict(groups, name=tree.name))["space/circle"]
    np.testing.assert_array_equal(as_recorded["H_y"], tree["space/circle"]["H_y"])
    reactions = ["p", "p_component", "m", "H", "M", "H_tip", "M_tip", "H_lid", "M_lid"]
    groups |= {f"{name}/extrapolated": 1.1 * groups[name][reactions] for name in rays}
    found = extract_springs(xr.DataTree.from_dict(groups, name=tree.name))["space/circle"]
    for name, factor in {
        "H_x": 1.1,
        "H_y": 1.1,
        "M_x": 1.1,
        "M_y": 1.1,
        "p_x": 1.1,
        "p_y": 1.1,
        "T": 1.0,
        "u_x": 1.0,
        "V": 1.0,
    }.items():
        np.testing.assert_allclose(found[name], factor * tree["space/circle"][name], rtol=1e-9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"control": "motion"}, "control: expected 'load' or 'state'"),
        ({"control": "state", "V": [1.0, 2.0]}, "V: give one number, or one a row"),
        ({"control": "state", "time": [1.0, 0.5, 2.0]}, "time: .* growing from 0 s"),
    ],
)
def test_sequences_in_space_that_are_refused(given: dict[str, Any], words: str) -> None:
    rows = 1e-3 * np.array([[1.0, 0, 0, 0, 0], [2.0, 0, 0, 0, 0], [3.0, 0, 0, 0, 0]])
    with pytest.raises(UserInputError, match=words):
        sequence_in_space(calibrated(), rows, **given)


def test_marks_of_a_stepper_are_those_of_a_sequence() -> None:
    """Within the reach, beyond it and between rays too far apart, with torsion, at another V and rate."""
    rays = np.array([[0.0, REACH], [0.25 * np.pi, REACH], [0.5 * np.pi, REACH]])
    space = replace(SpaceSprings.of(calibrated()), rate=0.1 * REACH, rays=rays)
    parts = np.array([[0.2, 0.0, 0.0, 0.05, 0.0], [0.9, 0.9, -0.4, 0.8, 0.0], [0.3, 0.0, 0.0, -0.3, 0.2]])
    turns = parts * [REACH, REACH, REACH / LENGTH, REACH / LENGTH, REACH / RADIUS]
    V = space.V + np.array([0.0, 0.0, 1e6])
    steps = SpaceStepper(space)
    for turn, down, duration in zip(turns, V, (2.0, 0.1, 10.0), strict=True):
        steps.advance(motion=turn, V=down, duration=duration)
        alone, marks = space.answer("state", turn[None], np.array([down])), steps.marks
        assert marks.range_used == pytest.approx(float(alone["range_used"][0]), rel=1e-12)
        assert [getattr(marks, name) for name in AT_ONCE] == [bool(alone[name][0]) for name in AT_ONCE]
        steps.commit()
    off = [space.answer("state", turns, time=np.cumsum([2.0, 0.1, 10.0]))["off_rate"].values.tolist(), marks.off_rate]
    assert off == [[0, 1, 0], False]
    assert steps.way == pytest.approx(way_of(space.motions_of(turns)[:, :4]), rel=1e-12)
    names = ("off_path", "off_load", "heave_extrapolated", "torsion_apart")
    assert (marks.names, marks.way_used) == (names, steps.way / space.elements.way)


AT_ONCE = ("extrapolated", "off_path", "off_load", "torsion_apart")


def test_a_stepper_takes_no_torque_for_a_motion() -> None:
    """Without a twist among the paths its fifth equation is a motion."""
    stepper = SpaceStepper.of(Springs.of(calibrated(twisted=False)))
    for step in ({"load": [1e5, 0.0, 0.0, 0.0, 2e5]}, {"motion": [1e-3, 0.0, 0.0, 0.0, 1e-3]}):
        with pytest.raises(UserInputError, match="they carry no torsion"):
            stepper.advance(**step)
    with pytest.raises(UserInputError, match="must have the shape"):
        stepper.advance(load=[1e5, 0.0])


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_range_and_rays_beside_a_motion_are_those_of_its_direction(turned: float) -> None:
    """Rays at 0, 45 and 90 degrees: between 90 and 180, or -90 and 0, none is near, which is marked; in any plane."""
    rays = np.array([[0.0, 1e-3], [0.25 * np.pi, 4e-4], [0.5 * np.pi, 2e-3]])
    space = replace(SpaceSprings.of(calibrated()), rays=rays)
    angles = np.radians([10.0, 0.0, -10.0, -80.0, -90.0, 100.0, 170.0, 225.0, 80.0])
    u, lean = 1e-4 * np.cos(angles), 1e-4 * np.sin(angles) / space.length
    c, s = np.cos(turned), np.sin(turned)
    turns = np.stack([c * u, s * u, -s * lean, c * lean, np.full(u.size, 1e-5)], axis=1)
    sector, reach = space.beside(turns)
    assert np.degrees(sector).round(6).tolist() == [45, 0, 90, 90, 0, 90, 90, 0, 45]
    assert reach.tolist() == [4e-4, 1e-3, 1e-3, 1e-3, 2e-3, 1e-3, 1e-3, 4e-4, 4e-4]
    np.testing.assert_allclose(space.range_used(turns * [1.0, 1.0, 1.0, 1.0, 0.0]), 1e-4 / reach)
    found = space.answer("state", turns)
    assert found["off_path"].values.tolist() == [0, 0, 1, 1, 1, 1, 1, 1, 1]  # what comes after remembers it
    assert [
        text for text in found.attrs["warnings"] if "4 of 9 states are between calibration paths 90 degrees" in text
    ]
