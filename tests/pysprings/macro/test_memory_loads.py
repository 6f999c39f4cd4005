# SPDX-License-Identifier: MIT
"""Springs with memory between two vertical loads or rates with rays that turn back, and under a V that changes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr

from pysprings.macro.memory.build import build_memory, memory_dataset
from pysprings.macro.memory.elements import FRICTIONAL
from pysprings.macro.memory.model import MemoryModel, MemoryStepper
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, sequence
from pysprings.macro.sets import spring_sets
from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.fans import LENGTH
from tests.support.vertical import K, REST, down_curve, pressed, vertical_path
from tests.support.winkler import elements_of, mixed

HEAVY = 2.0 * REST
WAY = 1e-3 * np.array([[1.0, 0.2], [3.0, -0.4], [-1.0, 0.1], [-2.0, 0.3], [2.0, 0.0], [0.0, 0.0]]) / [1.0, LENGTH]


@cache
def springs(turning: tuple[float, ...] = (REST, HEAVY)) -> Springs:
    """Springs of a Winkler caisson under two vertical loads, with invented elements at those with rays that turn back.

    The heavy one carries twice the load on all its paths.
    """
    tree = winkler.springs()
    groups = {"/": tree.to_dataset(inherit=False).assign_attrs(vertical_load_N=REST)}
    for node in tree["paths"].children.values():
        path = node.to_dataset(inherit=False)
        for V in (REST, HEAVY):
            if node.attrs["role"] == "calibration" or V in turning:
                groups[f"/paths/{node.name}_{V / REST:g}"] = pressed(path, V)
    for name, end in (("down", 1e-2), ("up", -1e-2)):
        groups[f"/paths/{name}"] = vertical_path(groups[f"/paths/ray_0_{1}"], end)
    bare = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    for number, V in enumerate(turning):
        groups[f"/memory_load_{number}" if number else "/memory"] = invented(bare.at(V=V), number + 1)
    return Springs.of(xr.DataTree.from_dict(groups, name="springs"))


def invented(at: Springs, seed: int) -> xr.Dataset:
    """Elements that stand for calibrated ones, with reactions and w of their own."""
    table, random = MacroModel.from_springs(at, "fan").table, np.random.default_rng(seed)
    elements = elements_of(mixed(n=6, seed=seed), table)
    shares = elements.shares
    even = random.uniform(-0.05, 0.05, shares.even.shape)
    names = table.name[~shares.odd]
    even[names == "V"] = 0.0
    own = replace(
        shares, loads=random.uniform(-1.0, 1.0, shares.loads.shape), even=even, growth=10.0 * seed,
        elastic=1e8 * random.uniform(-1.0, 1.0, shares.elastic.shape),
    )  # fmt: skip
    return memory_dataset(at, replace(elements, shares=own))


def memory(V: float) -> MemoryModel:
    return build_memory(springs().at(V=V))


def single(V: float) -> MemoryModel:
    """The model at one of the two vertical loads, without the other."""
    return replace(memory(V), loaded=None)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_between_two_vertical_loads_loads_and_reactions_are_those_of_both_by_their_shares(share: float) -> None:
    """Along an imposed motion, linear in V; w counts from where the vertical springs stand under V."""
    V = REST + share * (HEAVY - REST)
    between, light, heavy = memory(V), single(REST), single(HEAVY)
    loads = [model.solve("state", WAY)[1] for model in (light, heavy)]
    expected = (1.0 - share) * loads[0] + share * loads[1]
    np.testing.assert_allclose(between.solve("state", WAY)[1], expected, rtol=1e-12)
    assert np.abs(loads[0] - loads[1]).max() > 1e4
    rows = [model.reactions(WAY) for model in (light, heavy)]
    np.testing.assert_allclose(between.reactions(WAY), (1.0 - share) * rows[0] + share * rows[1], rtol=1e-9, atol=1e-9)
    tangents = [model.tangents(WAY) for model in (light, heavy)]
    np.testing.assert_allclose(between.tangents(WAY), (1.0 - share) * tangents[0] + share * tangents[1], rtol=1e-9)


def test_the_elements_of_both_loads_under_a_constant_load_are_one_set() -> None:
    """Under V by step, all the same, the answer is that of the elements at V; w and marks, too."""
    V = 1.3 * REST
    model = MacroModel.from_springs(springs(), "memory", V=V)
    plain = sequence(model, WAY, control="state", V=V, extrapolate=True)
    by_step = sequence(model, WAY, control="state", V=np.full(len(WAY), V), extrapolate=True)
    for name in ("H", "M", "w", "V", "p", "stiffness", "off_load"):
        np.testing.assert_allclose(by_step[name].values, plain[name].values, rtol=1e-9, atol=1e-9, err_msg=name)
    assert not plain["off_load"].any() and plain["V"].values == pytest.approx(V)


def test_w_between_two_vertical_loads_counts_from_the_settlement_under_the_load() -> None:
    V = 1.5 * REST
    first = 1e-9 * WAY[:1]
    answer = sequence(springs(), first, control="state", V=V, springs_kind="memory", extrapolate=True)
    w = float(answer["w"][0])
    assert down_curve(np.array(w)) == pytest.approx(V - REST, rel=1e-4)


def test_a_vertical_load_that_changes_changes_what_the_elements_carry() -> None:
    """H and M are those of both by their shares under the present V, each along the whole motion."""
    V = REST * np.array([1.0, 1.5, 2.0, 1.2, 1.2, 1.0])
    with pytest.warns(MacroWarning, match="after V turned back"):
        answer = sequence(springs(), WAY, control="state", V=V, springs_kind="memory", extrapolate=True)
    share = V / REST - 1.0
    loads = [single(load).solve("state", WAY)[1] for load in (REST, HEAVY)]
    expected = (1.0 - share[:, None]) * loads[0] + share[:, None] * loads[1]
    np.testing.assert_allclose(np.stack([answer["H"], answer["M"]], axis=1), expected, rtol=1e-9)
    assert not answer["off_load"].any()


def test_w_adds_up_what_each_step_brings_under_its_vertical_load() -> None:
    """And V itself moves it on the curve of the vertical springs: back at the first V nothing of that is left."""
    V = REST * np.array([1.0, 1.5, 2.0, 1.2, 1.2, 1.0])
    with pytest.warns(MacroWarning):
        answer = sequence(springs(), WAY, control="state", V=V, springs_kind="memory", extrapolate=True)
    w = np.stack([model.reactions(WAY)[model.down] - model.rest[0] for model in (single(REST), single(HEAVY))])
    steps, share = np.diff(w, axis=1, prepend=0.0), V / REST - 1.0
    middle = 0.5 * (share + np.append(share[0], share[:-1]))
    moved = np.cumsum((1.0 - middle) * steps[0] + middle * steps[1])
    change = V - REST
    settled = change / (K - change / 5e-3)  # the inverse of the curve
    np.testing.assert_allclose(answer["w"], moved + settled, atol=1e-7)
    assert np.abs(steps[1] - steps[0]).max() > 1e-5


def test_loads_that_are_given_are_carried_while_the_vertical_load_changes() -> None:
    """The motion that is found carries the loads, and the same motion imposed gives them back."""
    V = REST * np.array([1.0, 1.9, 1.1, 1.5])
    loads = np.array([[2e5, -3e5], [2e5, -3e5], [-1e5, 2e5], [1e5, 0.0]])
    model = MacroModel.from_springs(springs(), "memory", V=REST)
    with pytest.warns(MacroWarning):
        answer = sequence(model, loads, V=V, extrapolate=True)
    np.testing.assert_allclose(np.stack([answer["H"], answer["M"]], axis=1), loads, rtol=1e-6, atol=1.0)
    assert abs(float(answer["u"][1] - answer["u"][0])) > 0.05 * abs(float(answer["u"][0]))


def test_steps_one_by_one_are_those_of_a_sequence_while_the_vertical_load_changes() -> None:
    way = np.linspace(0.0, 1.0, 21)[1:, None] * WAY[0] * [1.0, 2.0]
    way, V = np.concatenate([way, way[::-1][1:]]), REST * (1.5 - 0.5 * np.cos(np.arange(39)))
    model = memory(REST)
    stepper, rows = MemoryStepper(model), model.reactions(way, V)
    _, loads, _ = model.solve("state", way, V=V)
    for k, (u, rotation) in enumerate(way):
        stepper.advance(motion=(u, rotation), V=2.0 * REST)  # a trial that is not kept
        np.testing.assert_allclose(stepper.advance(motion=(u, rotation), V=V[k]), loads[k], rtol=1e-9)
        np.testing.assert_allclose(stepper.reactions, rows[:, k], rtol=1e-9, atol=1e-9)
        assert stepper.marks.off_load is False
        stepper.commit()
    assert stepper.V == V[-1]
    stepper.advance(motion=(1e-3, 0.0), V=3.0 * REST)
    assert stepper.marks.off_load


def test_the_tangent_is_that_under_the_vertical_load_of_the_step() -> None:
    stepper, h = MemoryStepper(memory(REST)), 1e-9
    stepper.advance(motion=(1e-3, 1e-4), V=1.7 * REST)
    tangent, slopes = stepper.tangent, []
    for u, rotation in ((1.0, 0.0), (0.0, 1.0)):
        ends = [
            stepper.advance(motion=(1e-3 + s * h * u, 1e-4 + s * h * rotation), V=1.7 * REST) for s in (0.5, -0.5)
        ]
        slopes.append((ends[0] - ends[1]) / h)
    np.testing.assert_allclose(tangent, np.array(slopes).T, rtol=1e-4)


def test_no_closed_way_between_two_vertical_loads_gives_work() -> None:
    """200 random loops of mixed elements, friction among them."""
    model, random = memory(1.4 * REST), np.random.default_rng(3)
    assert (model.elements.rows[:, 0] == FRICTIONAL).any()
    for _ in range(200):
        corners = random.normal(scale=4e-3, size=(random.integers(2, 6), 2)) / [1.0, LENGTH]
        corners = np.concatenate([np.zeros((1, 2)), corners, np.zeros((1, 2))])
        way = np.concatenate([np.linspace(a, b, 60)[1:] for a, b in zip(corners[:-1], corners[1:], strict=True)])
        _, loads, _ = model.solve("state", way)
        steps = np.diff(way, axis=0, prepend=0.0)
        middle = 0.5 * (loads + np.concatenate([np.zeros((1, 2)), loads[:-1]]))
        assert (middle * steps).sum() > -1e-3 * np.abs(middle * steps).sum()


def test_a_vertical_load_beyond_those_of_the_rays_is_that_of_the_nearest_and_marked() -> None:
    V = 0.9 * REST
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        answer = sequence(springs(), WAY, control="state", V=V, springs_kind="memory", extrapolate=True)
    np.testing.assert_allclose(answer["H"], single(REST).solve("state", WAY)[1][:, 0], rtol=1e-12)
    assert answer["off_load"].values[:-1].all()


def test_rays_that_turn_back_at_one_of_two_loads_answer_there() -> None:
    """At the other load there are elements at the first one, and a mark."""
    lone = springs((REST,))
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        answer = sequence(lone, WAY, control="state", V=HEAVY, springs_kind="memory", extrapolate=True)
    np.testing.assert_allclose(answer["H"], single(REST).solve("state", WAY)[1][:, 0], rtol=1e-12)
    assert "memory" in spring_sets(lone)
