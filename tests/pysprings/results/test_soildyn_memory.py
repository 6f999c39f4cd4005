# SPDX-License-Identifier: MIT
"""Springs with memory in the SoilDyn library beside `predict`: along sequences that turn back, in any direction."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.macro.answer import trace
from pysprings.macro.model import MacroModel
from pysprings.memory.build import build_memory
from pysprings.memory.elements import FRICTIONAL, GAP, PLATES, REVERSIBLE
from pysprings.memory.model import error_between_planes
from pysprings.memory.shares import at_rest
from pysprings.results.exporters import export
from pysprings.results.exporters.soildyn.library import spring_text
from pysprings.springs.springs import Springs
from tests.support import loaded, winkler
from tests.support.foundation import FORCE, Point, PointOn, needs_compiler
from tests.support.vertical import REST, fan_with_vertical

pytestmark = needs_compiler


def model_of(springs: xr.DataTree) -> MacroModel:
    return MacroModel.from_springs(springs, "memory")


def sequence(seed: int = 3, n: int = 60) -> np.ndarray:
    """Motions (n, 2) = (u, rotation) that turn back often, in steps of all sizes, within the reach."""
    random = np.random.default_rng(seed)
    corners = 0.5 * winkler.REACH * random.uniform(-1.0, 1.0, (n // 6, 2)) / [1.0, winkler.LENGTH]
    way = np.concatenate([np.zeros((1, 2)), corners])
    return np.concatenate([a + np.sort(random.random(6))[:, None] * (b - a) for a, b in pairwise(way)])


def motion(state: np.ndarray, direction: float, w: float = 0.0) -> np.ndarray:
    """Motion (6,) in the frame of OpenFAST of (u, rotation) in the plane at an angle from x."""
    c, s = np.cos(direction), np.sin(direction)
    return np.array([state[0] * c, state[0] * s, -w, -state[1] * s, state[1] * c, 0.0])


def in_plane(force: np.ndarray, direction: float) -> tuple[float, float, float, float]:
    """H and M in the plane of motion, and force and moment across it."""
    c, s = np.cos(direction), np.sin(direction)
    across = force[1] * c - force[0] * s, force[3] * c + force[4] * s
    return force[0] * c + force[1] * s, force[4] * c - force[3] * s, *across


@pytest.mark.parametrize("direction", [0.0, 0.5 * np.pi, np.pi, 0.7, 2.3])
def test_forces_follow_a_sequence_as_predict_does(point_on: PointOn, direction: float) -> None:
    """Gap and frictional elements are exact in the planes of x and y, plastic ones in every plane."""
    rows = winkler.mixed()
    both = np.isclose(np.sin(2.0 * direction), 0.0)
    rows = rows if both else rows[~np.isin(rows[:, 0], PLATES)]
    springs = winkler.with_invented_memory(rows)
    point = point_on(model_of(springs))
    states = sequence()
    answer = trace(model_of(springs), "state", states)
    assert answer.sizes["step"] == len(states)
    expected = np.stack([answer["H"].values, answer["M"].values], axis=1)
    assert np.abs(expected).max() > 1e5
    for state, loads in zip(states, expected, strict=True):
        H, M, *across = in_plane(point.forces(motion(state, direction)), direction)
        np.testing.assert_allclose([H, M], loads, rtol=1e-6, atol=1e-6 * np.abs(expected).max(axis=0).min())
        np.testing.assert_allclose(across, 0.0, atol=1e-8 * np.abs(expected).max())


def test_the_settlement_of_the_elements_carries_no_load(point_on: PointOn) -> None:
    """At the w that `predict` gives, V is the load at rest and that of the elements."""
    springs = winkler.with_invented_memory(settling=True)
    point = point_on(model_of(springs))
    model = model_of(springs)
    states = sequence(5)
    answer = trace(model, "state", states)
    w, V = answer["w"].values, answer["V"].values
    largest = np.abs(w).max()
    assert largest > 1e-4
    assert model.stiffness_initial is not None
    near = (
        2e-3 * largest * model.stiffness_initial[1, 1]
    )  # `predict` divides long steps of loads and of w in other ways
    for state, down, load in zip(states, w, V, strict=True):
        assert -point.forces(motion(state, 0.0, down))[2] == pytest.approx(load, abs=near)


def test_elements_at_another_vertical_load_are_those_of_predict(point_on: PointOn) -> None:
    """H and M, and V at the w that `predict` gives, of springs at the second of two loads."""
    model = MacroModel.from_springs(loaded.springs(), "memory", V=loaded.HEAVY)
    point, states = point_on(model), sequence(5)
    answer = trace(model, "state", states)
    H, M, w = (answer[name].values for name in ("H", "M", "w"))
    assert np.ptp(w) > 1e-5 and w[0] > 1e-4
    for k, state in enumerate(states):
        force = point.forces(motion(state, 0.0, w[k]))
        np.testing.assert_allclose(in_plane(force, 0.0)[:2], [H[k], M[k]], rtol=1e-6, atol=1.0)
        assert -force[2] == pytest.approx(loaded.HEAVY, rel=1e-3)


def test_elements_of_two_vertical_loads_together_are_refused() -> None:
    model = MacroModel.from_springs(loaded.springs(), "memory", V=1.5 * REST)
    with pytest.raises(UserInputError, match="SoilDyn keeps a state for those of one: give the V or rate of one"):
        spring_text([], model, 1e9, True, False)


def test_a_repeated_step_leaves_no_trace_and_points_are_independent(point_on: PointOn, library: Path) -> None:
    springs = winkler.with_invented_memory()
    first = point_on(model_of(springs))
    points = [first, *(Point(library, "./caisson.txt") for _ in range(3))]
    ways = [sequence(seed) for seed in (1, 2, 3, 4)]
    alone = []
    for way in ways:
        single = Point(library, "./caisson.txt")
        alone.append([single.forces(motion(state, 0.0)) for state in way])
    for k in range(len(ways[0])):
        for point, way, expected in zip(points, ways, alone, strict=True):
            kept = point.state.copy()
            point.forces(motion(1.7 * way[k], 1.0))  # rejected
            point.state[:] = kept
            np.testing.assert_array_equal(point.forces(motion(way[k], 0.0)), expected[k])


def test_stiffness_is_that_of_the_forces_and_the_one_at_rest_is_symmetric(point_on: PointOn) -> None:
    springs = winkler.with_invented_memory()
    point = point_on(model_of(springs))
    K = point.stiffness(np.zeros(6))
    np.testing.assert_allclose(K, K.T)
    assert np.linalg.eigvalsh(K[:2, :2]).min() > 0.0
    assert (K[0, 0], K[0, 4], K[3, 3]) == (K[1, 1], -K[1, 3], K[4, 4])
    assert K[0, 0] == pytest.approx(at_rest(winkler.mixed()).sum(axis=0)[0, 0], rel=1e-9)
    for state in sequence(9, 12):
        point.forces(motion(state, 0.4))
    kept, aim = point.state.copy(), motion(sequence(9, 12)[3], 1.1)
    D = point.stiffness(aim)
    step = 1e-7
    for j in range(6):
        pair = []
        for sign in (1.0, -1.0):
            point.state[:] = kept
            pair.append(point.forces(aim + sign * step * np.eye(6)[j]))
        slope = (pair[0] - pair[1]) / (2.0 * step)
        np.testing.assert_allclose(D[:, j], slope, rtol=0.05, atol=1e-3 * np.abs(D).max())


def test_turned_motions_of_plastic_elements_give_turned_forces(point_on: PointOn, library: Path) -> None:
    """Out of one plane: a way around, and the same way turned by an angle; no work is won on it."""
    rows = winkler.mixed()
    springs = winkler.with_invented_memory(rows[~np.isin(rows[:, 0], PLATES)])
    point = point_on(model_of(springs))
    other, angle = Point(library, "./caisson.txt"), 0.8
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turns = np.linspace(0.0, 6.0 * np.pi, 120)
    circle = 8e-3 * np.stack([np.cos(turns) - 1.0, np.sin(turns)])
    work, before = 0.0, np.zeros(2)
    for x, y in circle.T:
        force = point.forces(np.array([x, y, 0.0, 0.0, 0.0, 0.0]))
        turned = other.forces(np.array([*(R @ [x, y]), 0.0, 0.0, 0.0, 0.0]))
        np.testing.assert_allclose(turned[:2], R @ force[:2], rtol=1e-8, atol=1e-6)
        work += force[:2] @ (np.array([x, y]) - before)
        before = np.array([x, y])
    assert work > 0.0


def test_a_way_beyond_that_of_the_calibration_warns(point_on: PointOn, capfd: pytest.CaptureFixture[str]) -> None:
    point = point_on(model_of(winkler.with_invented_memory()))
    for k in range(20):
        assert point.ask(FORCE, motion(np.array([0.4 * winkler.REACH * (-1) ** k, 0.0]), 0.0)) == 0
    assert capfd.readouterr().out.count("settlement is extrapolated") == 1


def test_more_elements_than_a_state_has_are_refused() -> None:
    many = winkler.with_invented_memory(np.tile(winkler.mixed(), (6, 1)))
    with pytest.raises(UserInputError, match="SoilDyn keeps 1200 of a state"):
        spring_text([], model_of(many), 1e9, True, False)


def test_the_export_states_what_the_planes_change(tmp_path: Path) -> None:
    done = export(winkler.with_invented_memory(), "openfast", tmp_path, springs="memory")
    (line,) = [remark for remark in done.remarks if "at 45 degrees" in remark]
    text = (tmp_path / "caisson.txt").read_text()
    assert any("one gauge of the motion in both planes" in remark for remark in done.remarks)
    assert line in text and "not cyclic" not in text and "\nelements 97\n" in text


def test_a_fan_names_springs_with_memory_where_there_are_some(tmp_path: Path) -> None:
    for springs, there in ((winkler.with_invented_memory(), True), (fan_with_vertical(), False)):
        remarks = export(springs, "openfast", tmp_path).remarks
        assert any("no memory of earlier loads" in each for each in remarks)
        assert any("`springs=memory`" in each for each in remarks) == there


@pytest.mark.parametrize(("kind", "first"), [(GAP, (0.0, 0.0, 0.0)), (FRICTIONAL, (0.0, 1.0, 0.5))])
def test_between_the_planes_two_plates_carry_more_by_the_root_of_two(kind: int, first: tuple[float, ...]) -> None:
    """Walls along u, yielded in both planes, beside a much softer spring; w follows the ways of the walls."""
    rows = [winkler.element(d=1e3, B=(1e3, 0.0, 1e3)), winkler.element(kind, first, (1.0, 0.0, 1e8), 1e-3)]
    model = build_memory(Springs.of(winkler.with_invented_memory(np.array(rows))))
    elements = replace(model.elements, shares=replace(model.elements.shares, growth=np.inf))
    H, M, w = error_between_planes(elements, np.array([0.0, 1.0, 0.0, 0.0]))
    assert pytest.approx(np.sqrt(2.0) - 1.0, rel=0.01) == H
    assert pytest.approx((kind == FRICTIONAL) * 0.5 * H, rel=0.02) == M
    x, d = 0.5 * elements.reach, 1e-3
    assert pytest.approx(2.0 * (np.sqrt(0.5) * x - d) / (x - d) - 1.0, rel=1e-6) == w


def test_more_numbers_than_a_point_has_are_refused_before_the_library_reads_them() -> None:
    """An element takes seventeen: 1,200 reversible ones, which keep no state, fill the 20,000 of a point."""
    few, many = (np.array([winkler.element(REVERSIBLE)] * n) for n in (1000, 1200))
    model = model_of(winkler.with_invented_memory(few))
    lines = spring_text([], model, 1e9, True, False).splitlines()
    assert len(lines[-2].split()) == 17
    with pytest.raises(UserInputError, match="numbers: SoilDyn keeps 20000 for a point"):
        spring_text([], model_of(winkler.with_invented_memory(many)), 1e9, True, False)
