# SPDX-License-Identifier: MIT
"""Elements with a memory: closed forms, energy, tangents, sequences; springs made of them beside an outside law."""

import json
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.macro.answer import PredictionNotConverged, trace
from pysprings.macro.batch import predict_batch
from pysprings.macro.cycles import Followed, cycles, errors, follow_path, reaction_errors, sequences
from pysprings.macro.fan import FanTable, build_fan
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.predict import MacroWarning, predict, sequence
from pysprings.macro.stiffness import stiffness
from pysprings.memory import build
from pysprings.memory.build import build_memory, with_memory
from pysprings.memory.calibration import MOST_NUMBERS, ElementSet, calibrate, nonnegative, numbers_of
from pysprings.memory.elements import FRICTIONAL, GAP, PLASTIC, REVERSIBLE, STATES, advance
from pysprings.memory.model import MemorySprings
from pysprings.memory.shares import at_rest, samples
from pysprings.memory.stepper import MemoryStepper
from pysprings.results.exporters import export
from pysprings.springs.checks import open_springs, save_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.commands import command
from tests.support.fans import LENGTH, fan_springs, linear
from tests.support.space_springs import few
from tests.support.winkler import REACH, element, elements_of, mixed


def walk(rows, motions):
    """Loads (n, 2) and tangents of elements along motions (n, 2), from rest."""
    rows = np.array(rows, dtype=float)
    state, F, K, before = np.zeros((len(rows), STATES)), np.zeros(2), np.zeros((2, 2)), np.zeros(2)
    loads, tangents = [], []
    for motion in np.asarray(motions, dtype=float):
        advance(rows, before, motion, state, F, K)
        loads.append(F.copy())
        tangents.append(K.copy())
        before = motion
    return np.array(loads), np.array(tangents), state


@cache
def model(seed=1) -> MemorySprings:
    """A model of mixed elements on the layout of a linear fan."""
    table = build_fan(Springs.of(fan_springs(linear)))
    return winkler.remembering(elements_of(mixed(seed=seed), table), table)


def test_a_perfectly_plastic_element_has_loops_of_a_parallelogram() -> None:
    """F = K d at most; the work of a cycle of +-U is 4 K d (U - d)."""
    d, U, K = 1e-3, 5e-3, 1e8
    way = np.concatenate([np.linspace(a, b, 200) for a, b in ((0, U), (U, -U), (-U, U))])
    loads, _, _ = walk([element(d=d)], np.stack([way, 0 * way], axis=1))
    assert np.abs(loads[:, 0]).max() == pytest.approx(K * d, rel=1e-12)
    cycle = slice(199, None)
    work = np.trapezoid(loads[cycle, 0], way[cycle])
    assert work == pytest.approx(4 * K * d * (U - d), rel=0.01)


@pytest.mark.parametrize("gain", [2.0, 20.0])
def test_hardening_follows_its_law_at_every_size_of_step(gain: float) -> None:
    """u = r(p) + p on a straight way, r = d (1 + a p/(p + h)): the load at u, whatever the steps."""
    d, h, U = 1e-3, 4e-3, 0.03
    p = np.linspace(0.0, U, 100_001)
    exact = np.interp(U, d * (1 + gain * p / (p + h)) + p, p)
    for steps in (1, 7):
        loads, _, state = walk([element(d=d, gain=gain, over=h)], np.linspace(0, [0.6 * U, 0.8 * U], steps + 1)[1:])
        assert state[0, 2] == pytest.approx(exact, rel=1e-6)
        assert np.hypot(*loads[-1]) == pytest.approx(1e8 * (U - exact), rel=1e-6)


def test_a_gap_opens_where_its_walls_have_yielded() -> None:
    """To 5 mm with walls that yield at 1 mm: back at 4 mm the load is 0, and so it is until the other wall at 0."""
    rows = [element(GAP, (0.0, 0.0, 0.0), (1.0, 0.0, 1e8), 1e-3)]
    loads, _, _ = walk(rows, [[x, 0.0] for x in (5e-3, 4e-3, 2e-3, 0.0, -0.5e-3, 4.5e-3)])
    np.testing.assert_allclose(loads[:, 0], [1e5, 0.0, 0.0, 0.0, -0.5e5, 0.5e5], atol=1e-6)


def test_walls_that_press_at_rest_carry_together_until_the_gap_opens() -> None:
    """Pressed by d/2, where they yield at d: both carry up to d/2; there the rear one lets go and the front one yields.

    Back from 2 d the front wall has come 1.5 d: it lets go at d, and the rear one is met at d/2.
    """
    d, K = 1e-3, 1e8
    rows = [element(GAP, (0.5 * d, 0.0, 0.0), (1.0, 0.0, K), d)]
    way = np.array([0.2, 0.5, 2.0, 1.5, 1.0, 0.5, 0.0, -1.0, 0.0])
    loads, tangents, state = walk(rows, np.stack([way * d, 0.0 * way], axis=1))
    np.testing.assert_allclose(loads[:, 0] / (K * d), [0.4, 1.0, 1.0, 0.5, 0.0, 0.0, -0.5, -1.0, 0.0], atol=1e-9)
    assert tangents[0, 0, 0] == pytest.approx(2.0 * K)
    np.testing.assert_allclose(state[0] / d, [1.5, -0.5, 2.0], rtol=1e-9)


def test_the_stiffness_at_rest_is_the_tangent_of_the_first_motion() -> None:
    """Elements without friction, gaps with and without pressure; walls without it carry on one side of a motion."""
    rows = mixed()
    rows = rows[rows[:, 0] != FRICTIONAL]
    assert {bool(pressed) for pressed in rows[rows[:, 0] == GAP, 1]} == {True, False}
    tangents = walk(rows, [[1e-12, 2e-12]])[1]
    np.testing.assert_allclose(at_rest(rows).sum(axis=0), tangents[0], rtol=1e-9)


def test_a_frictional_plate_is_held_by_what_it_is_pressed_and_slides_beyond() -> None:
    """Walls along u that yield at d, friction mu along the rotation: Coulomb's bound mu K N, none in the open gap."""
    d, K, mu = 1e-3, 1e8, 0.5
    rows = [element(FRICTIONAL, (0.0, 1.0, mu), (1.0, 0.0, K), d)]
    way = [
        (0.0, 0.3), (0.8, 0.3), (0.8, 0.5), (0.8, 1.5), (0.8, 1.2), (0.2, 1.2), (2.0, 1.2), (1.6, 1.3), (0.5, 0.0),
        (-0.4, -2.0),
    ]  # fmt: skip
    loads, tangents, state = walk(rows, np.array(way) * d)
    pressed = [0.0, 0.8, 0.8, 0.8, 0.8, 0.2, 1.0, 0.6, 0.0, -0.4]
    held = [0.0, 0.0, 0.2, 0.4, 0.1, 0.1, 0.1, 0.2, 0.0, -0.2]
    np.testing.assert_allclose(loads / (K * d), np.stack([pressed, held], axis=1), atol=1e-9)
    np.testing.assert_allclose(tangents[2] / K, [[1.0, 0.0], [0.0, 1.0]], atol=1e-9)
    np.testing.assert_allclose(tangents[3] / K, [[1.0, 0.0], [mu, 0.0]], atol=1e-9)
    np.testing.assert_allclose(tangents[9] / K, [[1.0, 0.0], [mu, 0.0]], atol=1e-9)
    np.testing.assert_allclose(at_rest(np.array(rows))[0] / K, [[1.0, 0.0], [0.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(state[0, :2] / d, [1.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("seed", [4, 8, 13, 26])
def test_loads_find_the_next_equilibrium_where_none_is_beside_the_last(seed: int) -> None:
    """A soft spring carries any load; slender elements whose force is not along their gauge let it jump on the way."""
    random, rows = np.random.default_rng(seed), []
    for _ in range(3):
        angle, m = random.uniform(0, np.pi), random.normal(size=2)
        c, s = np.cos(angle), np.sin(angle)
        gauge = c * c + 0.01 * s * s, 0.99 * c * s, s * s + 0.01 * c * c
        rows.append(element(PLASTIC, gauge, 1e8 * np.array([m[0] ** 2, m[0] * m[1], m[1] ** 2]), 0.02 * REACH))
    carry_loads(rows, random)


@pytest.mark.parametrize("seed", [9, 11, 105])
def test_loads_go_on_by_many_jumps_where_friction_leaves_no_equilibrium(seed: int) -> None:
    """Strong plates whose friction stands at any angle to their walls, beside a soft spring."""
    random, rows = np.random.default_rng(seed), []
    for _ in range(3):
        a, b = random.uniform(0, np.pi, 2)
        rows.append(element(FRICTIONAL, (np.cos(b), np.sin(b), 1.0), (np.cos(a), np.sin(a), 1e8), 0.02 * REACH))
    carry_loads(rows, random)


def carry_loads(rows, random):
    """Check that elements beside a soft spring answer a random sequence of loads, with these loads."""
    own = replace(model(), elements=elements_of(np.array([element(d=1e3, B=(6e6, 0.0, 6e6)), *rows]), model().table))
    targets = random.normal(size=(12, 2)) * [1.2e5, 1.2e5 * LENGTH]
    _, loads, end = own.solve("load", targets)
    assert not end
    np.testing.assert_allclose(loads, targets, atol=1e-6 * np.abs(targets).max(axis=0).min())


def test_a_reversible_element_goes_back_on_its_curve() -> None:
    """K G q up to the gauge d, K d q/|q| in a round gauge beyond; it keeps nothing, and a closed way has no work."""
    d, K = 1e-3, 1e8
    out = np.linspace(0.0, 1.0, 40)[1:, None] * [3e-3, -4e-3]
    loads, _, state = walk([element(REVERSIBLE, d=d)], np.concatenate([out, out[::-1], -out]))
    size = np.hypot(*out.T)
    np.testing.assert_allclose(loads[:39], K * np.minimum(1.0, d / size)[:, None] * out, rtol=1e-12)
    np.testing.assert_allclose(loads[39:78], loads[:39][::-1], rtol=1e-12)
    np.testing.assert_allclose(loads[78:], -loads[:39], rtol=1e-12)
    assert not state.any()
    turn = np.linspace(0.0, 2.0 * np.pi, 2001)
    way = np.stack([4e-3 * np.cos(turn), 2e-3 * np.sin(turn)], axis=1)
    slender = element(REVERSIBLE, (0.7, 0.4, 0.3), (0.7 * K, 0.4 * K, 0.3 * K), d)
    loads, _, _ = walk([slender], way)
    work = 0.5 * (loads[1:] + loads[:-1]) * np.diff(way, axis=0)
    assert abs(work.sum()) < 1e-4 * np.abs(work).sum()


def test_pulls_of_the_fan_are_ways_of_the_calibration() -> None:
    """The load stands at its height at every point, within the reach; loads above and below mudline are among them."""
    springs = Springs.of(winkler.springs())
    table = build_fan(springs)
    pulls = [way for way in samples(springs, table) if way.name.startswith("pull")]
    assert len(pulls) >= 8
    for way in pulls:
        H, M = way.loads(table).T
        np.testing.assert_allclose(M / H, float(way.name.split()[2]), rtol=1e-6, atol=1e-6)
        used = table.support(way.motions / [1.0, table.length])[0]
        assert used.max() <= 1.0 + 1e-6
    assert {way.name for way in pulls} >= {"pull at -0.5 L", "pull at 2 L"}


def test_small_cycles_stop_to_settle_the_caisson_and_larger_ones_go_on() -> None:
    """A way p of an element of size d counts as p/(1 + p/(s d)): at most s d; without a limit it adds up."""
    d, table = 1e-3, model().table
    rows = np.array([element(d=d), element(d=5 * d)])
    plain = elements_of(rows, table).shares
    odd = ~table.even
    even = np.zeros(((~odd).sum(), 4))
    w = list(table.name[~odd]).index("w")
    even[w, :2] = 1.0
    small, large = ([sign * size * d for _ in range(200) for sign in (1.0, -1.0)] for size in (4.0, 8.0))
    way = np.stack([[*small, *large], np.zeros(800)], axis=1)
    at = list(table.name).index("w")
    found = {}
    for growth in (3.0, np.inf):
        elements = replace(elements_of(rows, table), shares=replace(plain, even=even, growth=growth))
        found[growth] = replace(model(), elements=elements).reactions(way / model().to_motion)[at] - plain.rest[at]
    assert found[3.0][399] == pytest.approx(3 * d, rel=0.01)
    assert found[3.0][-1] == pytest.approx(3 * d + 15 * d, rel=0.02)
    assert found[np.inf][399] == pytest.approx(3 * d + 399 * 6 * d, rel=1e-9)


def test_tangents_are_those_of_the_loads() -> None:
    """A small change of the last step: the remainder is quadratic, at 40 random sequences."""
    random, rows = np.random.default_rng(2), mixed()
    for _ in range(40):
        way = np.cumsum(random.normal(size=(5, 2)) * 2e-3, axis=0)
        direction = random.normal(size=2)
        _, tangents, _ = walk(rows, way)
        h = 1e-9
        ends = [walk(rows, [*way[:-1], way[-1] + sign * h * direction])[0][-1] for sign in (1, -1)]
        np.testing.assert_allclose((ends[0] - ends[1]) / (2 * h), tangents[-1] @ direction, rtol=1e-4, atol=1e3)


@pytest.mark.parametrize("seed", [1, 2])
def test_closed_loops_never_give_work(seed: int) -> None:
    """100 random loops from rest and back to it, in steps of a thousandth of the reach."""
    random, rows = np.random.default_rng(seed), mixed(seed=seed)
    works = []
    for _ in range(50):
        corners = np.concatenate([np.zeros((1, 2)), random.uniform(-1, 1, (6, 2)) * REACH, np.zeros((1, 2))])
        way = np.concatenate([np.linspace(a, b, 60)[1:] for a, b in pairwise(corners)])
        loads = np.concatenate([np.zeros((1, 2)), walk(rows, way)[0]])
        steps = np.diff(way, axis=0, prepend=np.zeros((1, 2)))
        works.append((0.5 * (loads[1:] + loads[:-1]) * steps).sum())
    assert len(works) == 50 and min(works) > 0.0


@pytest.mark.slow
def test_every_sequence_of_loads_has_an_answer_that_meets_them() -> None:
    """Elements with a part that never yields carry every load."""
    random, springs = np.random.default_rng(5), model()
    answered = 0
    for _ in range(60):
        loads = random.uniform(-1, 1, (12, 2)) * [3e5, 1e6]
        states, found, message = springs.solve("load", loads)
        assert message == "" and np.isfinite(states).all()
        np.testing.assert_allclose(found, loads, atol=1e-6 * np.abs(springs.table.load_scale).max())
        answered += 1
    assert answered == 60


def test_a_load_at_a_height_is_followed_by_u() -> None:
    springs, arm = model(), 5.0
    states, loads, message = springs.solve("displacement", np.array([[2e-3, 0], [-1e-3, 0], [3e-3, 0]]), arm)
    assert message == ""
    np.testing.assert_allclose(states[:, 0], [2e-3, -1e-3, 3e-3], rtol=1e-9)
    np.testing.assert_allclose(loads[:, 1], arm * loads[:, 0], rtol=1e-5)


def test_a_first_load_that_the_elements_do_not_carry_is_refused() -> None:
    """No state is reached, and the answer has none."""
    springs = winkler.with_invented_memory(np.array([element(d=1e-3)]))
    with pytest.raises(PredictionNotConverged, match="no step was reached"):
        sequence(springs, np.array([[1e12, 0.0]]), springs_kind="memory", extrapolate=True)


def test_more_than_the_elements_carry_is_named() -> None:
    table = model().table
    rows = np.array([element(d=1e-3)])
    few, elastic = (
        winkler.remembering(ElementSet(each, REACH, model().elements.shares, 0.0, {}, REACH), table)
        for each in (rows, np.array([element(d=1e9)]))
    )
    states, _, message = few.solve("load", np.array([[5e4, 0.0], [5e5, 0.0]]))
    assert len(states) == 1 and "no equilibrium beyond H = " in message
    states, _, message = elastic.solve("load", 1e8 * REACH * np.array([[19.0, 0.0], [21.0, 0.0], [1e6, 0.0]]))
    assert states[:, 0] == pytest.approx([19.0 * REACH]) and "followed to 20 times their reach" in message
    stepper = MemoryStepper(few)
    with pytest.raises(BeyondSprings, match="carry no more than H = "):
        stepper.advance(load=(5e5, 0.0))
    np.testing.assert_allclose(stepper.advance(load=(5e4, 0.0)), [5e-4, 0.0], atol=1e-12)


def test_steps_are_tried_from_the_committed_state_until_one_is_kept() -> None:
    springs = model()
    loads = np.array([[2e5, -4e5], [-1e5, 3e5], [3e5, 0.0]])
    states, _, _ = springs.solve("load", loads)
    stepper = MemoryStepper(springs)
    for load, state in zip(loads, states, strict=True):
        stepper.advance(motion=(7e-3, 1e-3))  # tried, and forgotten
        np.testing.assert_allclose(stepper.advance(load=tuple(load)), state, atol=1e-10)
        stepper.commit()
    np.testing.assert_allclose(stepper.load, loads[-1], atol=1.0)
    aim, change = stepper.motion + [1e-4, -2e-5], np.array([1e-9, 3e-10])
    ends = [stepper.advance(motion=tuple(aim + sign * change)) for sign in (1.0, -1.0)]
    stepper.advance(motion=tuple(aim))
    np.testing.assert_allclose(ends[0] - ends[1], stepper.tangent @ (2.0 * change), rtol=1e-4)
    with pytest.raises(UserInputError, match="give a motion or a load"):
        stepper.advance()


def test_what_comes_after_a_state_beyond_the_range_is_marked_with_memory_alone() -> None:
    """Elements remember the excursion, a fan does not."""
    springs = winkler.with_invented_memory()
    reach = MacroModel.from_springs(springs, "memory").table.range.min()
    states = reach * np.array([[0.5, 0.0], [1.5, 0.0], [0.2, 0.0], [0.0, 0.0]])
    marked = {
        kind: trace(MacroModel.from_springs(springs, kind), "state", states)["extrapolated"].values.tolist()
        for kind in ("memory", "fan")
    }
    assert marked == {"memory": [0, 1, 1, 1], "fan": [0, 1, 0, 0]}


def test_a_step_is_marked_where_the_springs_do_not_cover_it() -> None:
    reach, length = model().table.range.min(), model().table.length
    stepper = MemoryStepper(replace(model(), V=2e6, rate=1e-3))
    assert stepper.marks.names == () and stepper.marks.off_load is None
    stepper.advance(motion=(0.5 * reach, 0.0), V=2e6, duration=500.0 * reach)
    assert stepper.marks.names == () and stepper.marks.range_used == pytest.approx(0.5)
    stepper.advance(motion=(0.0, 1.1 * reach / length), V=1e6, duration=1e4 * reach)
    assert stepper.marks.names == ("extrapolated", "off_load", "off_rate")
    for sign in (1, -1) * 20:
        stepper.advance(motion=(0.5 * sign * reach, 0.0))
        stepper.commit()
    assert stepper.marks.names == ("heave_extrapolated",)
    assert stepper.marks.way_used == pytest.approx(39.5 * reach / stepper.model.elements.way)
    with pytest.raises(UserInputError, match="duration: 0 s must be more than 0 s"):
        stepper.advance(motion=(0.0, 0.0), duration=0.0)


def test_a_step_has_the_reactions_of_its_state() -> None:
    """Those of the whole way up to it, of plastic and of gap elements; shares of any size."""
    random, table = np.random.default_rng(3), model().table
    rows, odd = mixed(), ~table.even
    shares = replace(
        model().elements.shares, loads=random.normal(size=(odd.sum(), 2)),
        elastic=random.normal(size=(odd.sum(), 2 * len(rows))), even=random.normal(size=((~odd).sum(), 2 * len(rows))),
    )  # fmt: skip
    springs = replace(model(), elements=replace(model().elements, rows=rows, shares=shares))
    way = np.cumsum(random.normal(size=(60, 2)), axis=0) * 0.002 * REACH / springs.to_motion
    stepper = MemoryStepper(springs)
    for state in way:
        stepper.advance(motion=tuple(state))
        found = stepper.reactions
        stepper.commit()
    np.testing.assert_allclose(found, springs.reactions(way)[:, -1], rtol=1e-9, atol=1e-9 * np.abs(found).max())
    assert np.ptp(found[table.even]) > 0.0 and np.ptp(found[odd]) > 0.0


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
@pytest.mark.parametrize("kind", ["fan", "full"])
def test_steps_of_springs_without_memory_at_another_rate_are_marked(kind: str) -> None:
    """Of springs at 0.01 mm/s: 0.1 mm in 10 s and in 1 s; those that do not depend on a rate have no mark."""
    springs, motions = winkler.at_two_rates((1e-5, 1e-3)), np.array([[1e-4, 0.0], [2e-4, 0.0]])
    asked: dict[str, Any] = {"control": "state", "time": np.array([10.0, 11.0]), "springs_kind": kind}
    assert sequence(springs.at(rate=1e-5), motions, **asked)["off_rate"].values.tolist() == [0, 1]
    assert "off_rate" not in sequence(Springs.of(winkler.with_invented_memory()), motions, **asked)


def test_steps_of_a_sequence_at_another_rate_are_marked() -> None:
    """A rest has no rate; times alone change no number."""
    springs = replace(model(), rate=1e-3)
    whole = replace(
        MacroModel.from_springs(Springs.of(winkler.with_invented_memory()), "memory"), response=springs, rate=1e-3
    )
    motions, time = np.array([[1e-3, 0.0], [2e-3, 0.0], [2e-3, 0.0]]), np.array([1.0, 101.0, 102.0])
    plain = sequence(whole, motions, control="state", extrapolate=True)
    with pytest.warns(MacroWarning, match=r"1 of 3 steps are at another rate than that of the springs"):
        answer = sequence(whole, motions, control="state", time=time, extrapolate=True)
    np.testing.assert_array_equal(answer["off_rate"], [0, 1, 0])
    np.testing.assert_array_equal(answer["time"], time)
    np.testing.assert_array_equal(answer["H"], plain["H"])
    assert "off_rate" not in plain
    with pytest.raises(UserInputError, match="give one number a row of targets"):
        sequence(whole, motions, control="state", time=time[::-1])


def test_a_fan_without_rays_that_turn_back_has_no_memory() -> None:
    springs = fan_springs(linear)
    assert "memory" not in spring_sets(springs)
    with pytest.raises(UserInputError, match=r"no ray that turns back .* memory = true"):
        predict(springs, H=1e5, springs_kind="memory")


@pytest.fixture
def made(monkeypatch) -> list[int]:
    """Numbers of the calibrations, whose elements are invented."""
    made: list[int] = []

    def invented(_ways: object, table: FanTable, _stiffness: object, others: object) -> ElementSet:
        made.append(len(made))
        return elements_of(mixed(seed=len(made)), table)

    monkeypatch.setattr(build, "calibrate", invented)
    return made


def test_springs_have_a_memory_at_each_rate_of_rays_that_turn_back(tmp_path, made) -> None:
    """Both are stored, and answer at their own rate, from a file too, without a calibration anew."""
    save_springs(with_memory(winkler.at_two_rates((1e-5, 1e-3)).tree), tmp_path / "springs.nc")
    springs = Springs.of(open_springs(tmp_path / "springs.nc"))
    assert list(springs.memory) == ["memory", "memory_rate_1"]
    for number, rate in enumerate((1e-5, 1e-3), 1):
        found = build_memory(springs.at(rate=rate))
        assert found.rate == pytest.approx(rate)
        np.testing.assert_array_equal(found.elements.rows, mixed(seed=number))
    assert len(made) == 2


def test_a_file_without_elements_of_its_paths_is_calibrated_at_each_question_until_they_are_stored(tmp_path, made):
    """The answer has a remark; `pysprings springs FILE --out NEW.nc` writes them, and those that belong to it stay."""
    bare = save_springs(winkler.springs(), tmp_path / "bare.nc")
    remarks = [MacroModel.from_springs(open_springs(bare), "memory").remarks for _ in range(2)]
    assert len(made) == 2 and all(any("calibrated for this answer" in each for each in own) for own in remarks)
    export(open_springs(bare), "nc", tmp_path / "whole.nc")
    assert len(made) == 3
    export(open_springs(tmp_path / "whole.nc"), "nc", tmp_path / "again.nc")
    whole = MacroModel.from_springs(open_springs(tmp_path / "again.nc"), "memory")
    assert len(made) == 3 and not any("calibrated" in each for each in whole.remarks)
    assert isinstance(whole.response, MemorySprings)
    np.testing.assert_array_equal(whole.response.elements.rows, mixed(seed=3))


def test_springs_at_several_rates_have_a_memory_at_that_of_their_rays_that_turn_back() -> None:
    """Coupled rays at two rates, turning ones at the slow one: any other rate is refused."""
    springs = winkler.at_two_rates((1e-5,))
    slow = springs.at(rate=1e-5)
    assert [path.name for path in slow.remembering] == ["turning_0_0", "turning_50_0"]
    assert "memory" in spring_sets(slow)
    for rate in (1e-4, 1e-3):
        assert "memory" not in spring_sets(springs.at(rate=rate))
        with pytest.raises(UserInputError, match="no ray that turns back at this vertical load and rate"):
            build_memory(springs.at(rate=rate))


@cache
def outside() -> Springs:
    """Springs of Masing springs by depth, with two rays that turn back, and loops that are held back."""
    return Springs.of(with_memory(winkler.springs(loops=((30.0, 4e-3), (-20.0, 2e-3)))))


@pytest.mark.slow
def test_springs_with_memory_follow_loops_of_an_outside_law() -> None:
    """Of a Masing caisson, between and below the rays that turn back; measured 4 to 6 %, the fan 50 %."""
    found = {(one.path.name, one.springs): errors(one) for one in sequences(outside())}
    held = [name for name, path in outside().paths.items() if path.role == "held-back"]
    assert len(held) == 2
    for name in held:
        row, fan, path = found[name, "memory"], found[name, "fan"], outside().paths[name]
        moment = row["M_error_pct"] * np.abs(path["M"]).max() / path.length / np.abs(path["H"]).max()
        assert max(row["H_error_pct"], moment) < 12.0 < 40.0 < fan["H_error_pct"]
        assert abs(row["work_error_pct"]) < 8.0 and fan["work_error_pct"] < -50.0


@pytest.mark.slow
def test_reactions_sum_to_the_loads_of_every_state() -> None:
    memory = build_memory(outside())
    states = np.stack([outside().paths["loop_30"].u, outside().paths["loop_30"].rotation], axis=1)
    rows = memory.reactions(states)
    _, loads, _ = memory.solve("state", states[1:])
    np.testing.assert_allclose((rows.T @ memory.table.b)[1:], loads, rtol=1e-9, atol=1.0)
    (p,) = (outside().paths["loop_30"].p,)
    own = rows[memory.table.name == "p"]
    assert np.abs(own - p).max() < 0.2 * np.abs(p).max()


@pytest.mark.slow
def test_stored_elements_answer_as_those_that_were_calibrated(tmp_path) -> None:
    path = save_springs(outside().tree, tmp_path / "springs.nc")
    read = Springs.of(open_springs(path))
    np.testing.assert_array_equal(build_memory(read).elements.rows, build_memory(outside()).elements.rows)
    targets = np.array([[2e5, -4e5], [-1e5, 2e5], [0.0, 0.0]])
    answers = [sequence(each, targets, springs_kind="memory", extrapolate=True) for each in (read, outside())]
    np.testing.assert_array_equal(answers[0]["u"], answers[1]["u"])
    assert abs(float(answers[0]["u"][-1])) > 1e-6 and not answers[0]["turned_back"].any()


@pytest.mark.slow
def test_of_too_many_elements_those_that_carry_most_are_fitted_again() -> None:
    """The state of the elements in two planes is no larger than given; half of it costs little. Few are offered."""
    springs = outside()
    table, scale = build_fan(springs), np.array([1.0, springs.length])
    stiff = springs.lateral_stiffness / scale / scale[:, None]
    most, found = MOST_NUMBERS, []
    for _ in range(2):
        found.append(calibrate(samples(springs, table), table, stiff, few(REACH), most))
        assert numbers_of(found[-1].rows) <= most
        most = numbers_of(found[-1].rows) // 2
    assert found[0].residual <= found[1].residual < 2.0 * found[0].residual + 0.01


@pytest.mark.slow
def test_a_cycle_has_its_stiffness_work_and_damping() -> None:
    """The full model's own columns: a Masing loop of amplitude U under the load F dissipates what its area is."""
    path = outside().paths["loop_minus_20"]
    table = cycles(follow_path(path, MacroModel.from_springs(outside(), "memory")))
    assert list(table["branch"]) == [1, 2, 3]
    last = table.iloc[-1]
    loads, u, rotation = path["H"], path.u, path.rotation
    start = int(np.argmax(u[:40]))
    area = np.trapezoid(loads[start:], u[start:]) + np.trapezoid(path["M"][start:], rotation[start:])
    assert last["cycle_full_J"] == pytest.approx(area, rel=1e-9)
    assert last["secant_full"] == pytest.approx((loads[-1] - loads.min()) / (u[-1] - u.min()), rel=1e-9)
    moment, turn = path["M"], path.rotation
    size = (loads[-1] - loads[58]) * (u[-1] - u[58]) + (moment[-1] - moment[58]) * (turn[-1] - turn[58])
    assert last["damping_full"] == pytest.approx(2.0 * area / (np.pi * size), rel=1e-9)
    assert last["damping_macro"] == pytest.approx(last["damping_full"], rel=0.15)


@pytest.mark.slow
def test_calibrated_springs_have_no_loop_with_negative_work_and_an_answer_to_every_sequence() -> None:
    memory, random = build_memory(outside()), np.random.default_rng(7)
    reach = memory.elements.reach
    for _ in range(1000):
        corners = np.concatenate([np.zeros((1, 2)), random.uniform(-1, 1, (5, 2)) * reach, np.zeros((1, 2))])
        way = np.concatenate([np.linspace(a, b, 30)[1:] for a, b in pairwise(corners)])
        loads = np.concatenate([np.zeros((1, 2)), memory.solve("state", way / memory.to_motion)[1] / memory.to_motion])
        steps = np.diff(way, axis=0, prepend=np.zeros((1, 2)))
        assert (0.5 * (loads[1:] + loads[:-1]) * steps).sum() > 0.0
    largest = np.abs(memory.solve("state", np.array([[0.5 * reach, 0.0], [0.0, 0.5 * reach / 4.0]]))[1]).min(axis=0)
    for _ in range(1000):
        assert memory.solve("load", random.uniform(-0.7, 0.7, (10, 2)) * largest)[2] == ""


def test_the_damping_of_a_parallelogram_is_that_of_its_area() -> None:
    """A perfectly plastic spring, yield at d, cycles of +-U: 2/pi (1 - d/U)."""
    path = Springs.of(winkler.springs()).paths["turning_0"]
    given = Followed(path, "memory", "state", (_loop(), _loads(_loop())), (_loop(), _loads(_loop())), "")
    found = cycles(given)
    assert list(found["branch"]) == [1, 2, 3]
    assert found["damping_full"].iloc[-1] == pytest.approx(2.0 / np.pi * (1.0 - 0.2), rel=0.01)
    assert errors(given)["H_error_pct"] == 0.0


def test_elastic_springs_have_no_damping() -> None:
    """Cycles that grow: those that do not close have no ratio, though the work of two branches is large."""
    path = Springs.of(winkler.springs()).paths["turning_0"]
    ends = (0.0, 1.0, -1.0, 2.0, -2.0, 2.0, -2.0, 0.0)
    u = 1e-3 * np.concatenate([[0.0], *(np.linspace(a, b, 200)[1:] for a, b in pairwise(ends))])
    states, loads = (np.stack([each, 0.0 * u], axis=1) for each in (u, 1e9 * u / (1.0 + 400.0 * np.abs(u))))
    found = cycles(Followed(path, "fan", "state", (states, loads), (states, loads), ""))
    assert found["damping_full"].notna().tolist() == [False, False, False, False, True, True, False]
    assert found["cycle_full_J"].isna().tolist() == found["damping_full"].isna().tolist()
    assert found["damping_full"].abs().max() < 1e-6


def test_a_change_of_the_vertical_load_is_no_turn() -> None:
    """While V changes the lateral motion stays, but for rounding: the branches are those without these states."""
    path = Springs.of(winkler.springs()).paths["turning_0"]
    plain = _loop()
    rounded = plain[499] + 1e-17 * np.array([[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0]])
    motions = np.concatenate([plain[:500], rounded, plain[500:]])
    V = np.concatenate([np.full(500, 2e6), [2.1e6, 2.2e6, 2.3e6], np.full(len(plain) - 500, 2.3e6)])
    both = motions, _loads(motions)
    found = cycles(Followed(path, "memory", "state", both, both, "", V=V))
    assert found["x_end_full"].tolist() == pytest.approx([5e-3, -5e-3, 5e-3])


def _loop() -> np.ndarray:
    way = np.concatenate([np.linspace(a, b, 500)[1:] for a, b in ((0, 5e-3), (5e-3, -5e-3), (-5e-3, 5e-3))])
    return np.stack([np.append(0.0, way), np.zeros(way.size + 1)], axis=1)


def _loads(motions: np.ndarray) -> np.ndarray:
    return walk([element(d=1e-3)], motions)[0]


@pytest.mark.slow
def test_sequences_are_compared_by_cycle(tmp_path) -> None:
    path = save_springs(winkler.with_invented_memory(), tmp_path / "springs.nc")
    done = command("compare", str(path), "--cycles", "--json")
    assert done.code == 0
    found = json.loads(done.out)
    assert {(row["path"], row["springs"]) for row in found["errors"]} == {
        (name, springs) for name in ("turning_0", "turning_50") for springs in ("fan", "memory")
    }
    assert len(found["branches"]) == 4 * 3
    for row in found["reactions"]:
        depths = [d for d in found["depths"] if (d["path"], d["springs"]) == (row["path"], row["springs"])]
        assert len(depths) == winkler.RINGS and max(d["p_error_pct"] for d in depths) == row["p_error_pct"] > 0.0
    full = [row["work_full_J"] for row in found["branches"] if row["path"] == "turning_0"]
    assert full[:3] == full[3:] and min(full) > 0.0
    text = command("compare", str(path), "--cycles", "--springs", "memory").out
    assert "damping full" in text and "fan" not in text
    refused = command("compare", str(path), "--cycles", "--slices")
    assert refused.code == 2 and "--cycles" in refused.err


def test_a_long_way_is_marked_where_heave_is_extrapolated() -> None:
    springs = Springs.of(winkler.with_invented_memory())
    targets = np.array([[1e-3 * sign, 0.0] for sign in (1, -1) * 60])
    with pytest.warns(MacroWarning, match="times the longest way of the calibration: heave, settlement and vertical"):
        sequence(springs, targets, control="state", springs_kind="memory", extrapolate=True)


def test_springs_with_memory_have_the_tangent_of_a_state_that_is_asked_for(tmp_path) -> None:
    """It was refused with words on the secant, which the plane across alone needs."""
    path = str(save_springs(winkler.with_invented_memory(), tmp_path / "springs.nc"))
    asked = ("predict", path, "--u", "1 mm", "--rotation", "0.1 mrad", "--springs", "memory", "--extrapolate", "--json")
    found = json.loads(command(*asked, "--stiffness").out)["stiffness"]["matrices"][0]
    stepper = MemoryStepper.of(open_springs(path))
    for share in np.linspace(0.0, 1.0, 26)[1:]:
        stepper.advance(motion=(1e-3 * share, 1e-4 * share))
        tangent = stepper.tangent
        stepper.commit()
    lateral = np.ix_([0, len(found) - 1], [0, len(found) - 1])
    np.testing.assert_allclose(np.array(found)[lateral], tangent, rtol=1e-6)
    assert "no secant stiffness" in command(*asked, "--secant").err


def test_springs_with_memory_refuse_what_has_no_history() -> None:
    springs = Springs.of(winkler.with_invented_memory())
    with pytest.raises(UserInputError, match="answer sequences, not independent cases"):
        predict_batch(springs, H=np.array([1e4]), springs_kind="memory")
    with pytest.raises(UserInputError, match="no secant stiffness"):
        stiffness(springs, H=1e4, secant=True, springs_kind="memory", extrapolate=True)


def test_w_has_no_error_on_a_path_whose_vertical_load_changes() -> None:
    """What V moves is not in the lateral springs: w and vertical reactions are left out there, p is not."""
    tree = winkler.with_invented_memory()
    model, found = MacroModel.from_springs(Springs.of(tree), "memory"), []
    for change in (0.0, 1e6):
        path = tree["paths/turning_0"].to_dataset(inherit=False).copy(deep=True)
        grows = np.linspace(0.0, 1.0, path.sizes["step"])
        path["w"], path["V"] = path["w"] + 1e-3 * grows, path["V"] + change * (grows > 0.5)
        found.append(reaction_errors(follow_path(SpringPath("path", path, LENGTH), model)))
    plain, changed = found
    assert np.isfinite([plain["w_error_pct"], changed["p_error_pct"]]).all()
    assert np.isnan([changed["w_error_pct"], changed["t_error_pct"], changed["V_tip_error_pct"]]).all()


@pytest.mark.parametrize("shape", [(60, 900), (700, 300)])
def test_the_fit_by_few_columns_at_a_time_is_that_by_all(shape: tuple[int, int]) -> None:
    """Beside Lawson and Hanson on all columns; columns alike, as elements of near sizes are, and one of zeros."""
    random = np.random.default_rng(2)
    A = np.abs(random.standard_normal((shape[0], 12))) @ np.abs(random.standard_normal((12, shape[1])))
    A += 0.02 * random.standard_normal(shape)
    A[:, 5] = 0.0
    b = A @ np.maximum(random.standard_normal(shape[1]), 0.0) + random.standard_normal(shape[0])
    expected, left = nnls(A, b)
    found, share = nonnegative(A.copy(), b)
    assert share == pytest.approx(left / np.linalg.norm(b), rel=1e-9) and (found >= 0.0).all()
    np.testing.assert_allclose(A @ found, A @ expected, atol=1e-8 * np.abs(b).max())
    assert nonnegative(-np.abs(A), np.abs(b))[0].max() == 0.0  # nothing helps
