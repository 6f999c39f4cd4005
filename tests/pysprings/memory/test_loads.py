# SPDX-License-Identifier: MIT
"""Springs with memory between two vertical loads or rates with rays that turn back."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.predict import MacroWarning, sequence
from pysprings.memory import build
from pysprings.memory.build import build_memory, digest, with_memory
from pysprings.memory.elements import FRICTIONAL
from pysprings.memory.mixture import mixed
from pysprings.memory.model import MemorySprings
from pysprings.memory.stepper import MemoryStepper
from pysprings.springs.springs import Springs
from tests.support import loaded, winkler
from tests.support.fans import LENGTH
from tests.support.loaded import HEAVY
from tests.support.vertical import REST, down_curve, pressed
from tests.support.winkler import elements_of

WAY = 1e-3 * np.array([[1.0, 0.2], [3.0, -0.4], [-1.0, 0.1], [-2.0, 0.3], [2.0, 0.0], [0.0, 0.0]]) / [1.0, LENGTH]


def memory(V: float) -> MemorySprings:
    return build_memory(loaded.springs().at(V=V))


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_between_two_vertical_loads_loads_and_reactions_are_those_of_both_by_their_shares(share: float) -> None:
    """Along an imposed motion, linear in V; w counts from where the vertical springs stand under V."""
    V = REST + share * (HEAVY - REST)
    between, light, heavy = (memory(load) for load in (V, REST, HEAVY))
    loads = [model.solve("state", WAY)[1] for model in (light, heavy)]
    expected = (1.0 - share) * loads[0] + share * loads[1]
    np.testing.assert_allclose(between.solve("state", WAY)[1], expected, rtol=1e-12)
    assert np.abs(loads[0] - loads[1]).max() > 1e4
    stepped = MemoryStepper.of(loaded.springs(), V=V).advance(motion=tuple(WAY[0]))
    np.testing.assert_allclose(stepped, between.solve("state", WAY[:1])[1][0], rtol=1e-9)
    rows = [model.reactions(WAY) for model in (light, heavy)]
    np.testing.assert_allclose(between.reactions(WAY), (1.0 - share) * rows[0] + share * rows[1], rtol=1e-9, atol=1e-9)
    tangents = [model.tangents(WAY) for model in (light, heavy)]
    np.testing.assert_allclose(between.tangents(WAY), (1.0 - share) * tangents[0] + share * tangents[1], rtol=1e-9)


def test_w_between_two_vertical_loads_counts_from_the_settlement_under_the_load() -> None:
    V = 1.5 * REST
    first = 1e-9 * WAY[:1]
    answer = sequence(loaded.springs(), first, control="state", V=V, springs_kind="memory", extrapolate=True)
    w = float(answer["w"][0])
    assert down_curve(np.array(w)) == pytest.approx(V - REST, rel=1e-4)


def test_no_closed_way_between_two_vertical_loads_gives_work() -> None:
    """200 random loops of mixed elements, friction among them."""
    model, random = memory(1.4 * REST), np.random.default_rng(3)
    assert (model.elements.rows[:, 0] == FRICTIONAL).any()
    for _ in range(200):
        corners = random.normal(scale=4e-3, size=(random.integers(2, 6), 2)) / [1.0, LENGTH]
        corners = np.concatenate([np.zeros((1, 2)), corners, np.zeros((1, 2))])
        way = np.concatenate([np.linspace(a, b, 60)[1:] for a, b in pairwise(corners)])
        _, loads, _ = model.solve("state", way)
        steps = np.diff(way, axis=0, prepend=0.0)
        middle = 0.5 * (loads + np.concatenate([np.zeros((1, 2)), loads[:-1]]))
        assert (middle * steps).sum() > -1e-3 * np.abs(middle * steps).sum()


def test_a_vertical_load_beyond_those_of_the_rays_is_that_of_the_nearest_and_marked() -> None:
    V = 0.8 * REST
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        answer = sequence(loaded.springs(), WAY, control="state", V=V, springs_kind="memory", extrapolate=True)
    np.testing.assert_allclose(answer["H"], memory(REST).solve("state", WAY)[1][:, 0], rtol=1e-12)
    assert answer["off_load"].values[:-1].all()


def test_rays_that_turn_back_at_one_of_two_loads_answer_there() -> None:
    """At the other load there are elements at the first one, and a mark."""
    lone = loaded.springs((REST,))
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        answer = sequence(lone, WAY, control="state", V=HEAVY, springs_kind="memory", extrapolate=True)
    np.testing.assert_allclose(answer["H"], memory(REST).solve("state", WAY)[1][:, 0], rtol=1e-12)
    for V in (REST, 1.5 * REST, HEAVY):
        assert "memory" in spring_sets(lone.at(V=V))
    assert {"turning_0_1", "turning_50_1"} < set(MacroModel.from_springs(lone, "memory", V=HEAVY).response.sources)


@pytest.mark.filterwarnings("ignore:1 of 1 steps are at another rate")
def test_between_two_rates_loads_are_those_of_both_linear_in_the_logarithm_of_the_rate() -> None:
    """At 10^-4.5 m/s a quarter of the way from 1e-5 to 1e-3 m/s; steps at 1e-6 m/s are off that rate."""
    rate = 10.0**-4.5
    tree = winkler.at_two_rates((1e-5, 1e-3)).tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    for name, each, seed in (("memory", 1e-5, 1), ("memory_rate_1", 1e-3, 2)):
        groups[f"/{name}"] = loaded.invented(Springs.of(tree).at(rate=each), seed)
    stored = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    slow, between, fast = (build_memory(stored.at(rate=each)) for each in (1e-5, rate, 1e-3))
    loads = [model.solve("state", WAY)[1] for model in (slow, fast)]
    np.testing.assert_allclose(between.solve("state", WAY)[1], 0.75 * loads[0] + 0.25 * loads[1], rtol=1e-9)
    assert np.abs(loads[0] - loads[1]).max() > 1e4
    assert between.rate == pytest.approx(rate) and "memory" in spring_sets(stored.at(rate=rate))
    stepped = MemoryStepper.of(stored, rate=rate).advance(motion=tuple(WAY[0]))
    np.testing.assert_allclose(stepped, between.solve("state", WAY[:1])[1][0], rtol=1e-9)
    with pytest.raises(UserInputError, match="rate"):
        MemoryStepper.of(stored)
    time = np.arange(1.0, len(WAY) + 1.0) * float(np.hypot(*WAY[0] * [1.0, LENGTH])) / 1e-6
    for at, each, marked in ((rate, time, True), (1e-5, 0.1 * time, False)):
        answer = sequence(stored.at(rate=at), WAY[:1], control="state", springs_kind="memory", time=each[:1])
        assert answer["off_rate"].values.tolist() == [marked]


def test_what_lies_between_has_the_smaller_reach_and_way_of_both() -> None:
    """Steps and marks of heave go by the nearer limit."""
    one = memory(REST).elements
    other = replace(one, reach=0.5 * one.reach, way=3.0 * one.way)
    both = mixed([(one, 0.5), (other, 0.5)])
    assert (both.reach, both.way, len(both.rows)) == (0.5 * one.reach, one.way, 2 * len(one.rows))


def test_springs_between_two_vertical_loads_offer_their_memory() -> None:
    assert "memory" in spring_sets(loaded.springs().at(V=1.5 * REST))
    assert pytest.approx(1.5 * REST) == memory(1.5 * REST).V and memory(1.5 * REST).sets == 2
    assert pytest.approx(REST) == build_memory(loaded.springs((REST,)).at(V=HEAVY)).V


def test_w_under_a_load_without_rays_that_turn_back_is_that_of_the_vertical_springs() -> None:
    """The elements are those at REST, the fan lies between two loads: w counts once from the curve."""
    with pytest.warns(MacroWarning):
        answer = sequence(
            loaded.springs((REST,)), 1e-9 * WAY[:1], control="state", V=1.5 * REST, springs_kind="memory",
            extrapolate=True,
        )  # fmt: skip
    assert down_curve(np.array(float(answer["w"][0]))) == pytest.approx(0.5 * REST, rel=1e-4)


def test_a_lone_path_at_a_third_load_changes_no_elements() -> None:
    """The springs at its load lie between the others: their elements are not those of that load."""
    tree = loaded.springs().tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    groups["/paths/alone"] = pressed(groups["/paths/ray_0_1"], 1.5 * REST)
    more = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    for V in (REST, 1.5 * REST, HEAVY):
        found = build_memory(more.at(V=V))
        np.testing.assert_array_equal(found.elements.rows, memory(V).elements.rows)
        assert pytest.approx(V) == found.V


def test_springs_between_two_loads_without_those_that_they_come_from_have_no_memory() -> None:
    between = Springs.of(loaded.springs().at(V=1.5 * REST).tree)
    assert "memory" not in spring_sets(between)
    with pytest.raises(UserInputError, match="no ray that turns back"):
        build_memory(between)


def test_elements_at_rest_load_are_stored_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """One group a vertical load, in the order of the loads beside that at rest."""
    bare = {node.path: node.to_dataset(inherit=False) for node in loaded.springs().tree.subtree}
    bare = {path: data for path, data in bare.items() if not path.startswith("/memory")}
    heavy = bare["/"].assign_attrs(vertical_load_N=HEAVY)  # the heavier of both is that at rest
    monkeypatch.setattr(
        build, "calibrate", lambda _ways, table, _stiffness, others: elements_of(winkler.mixed(), table)
    )
    for root, rest in ((bare["/"], REST), (heavy, HEAVY)):
        said: list[str] = []
        tree = with_memory(xr.DataTree.from_dict(bare | {"/": root}), lambda *each, s=said: s.append(each[2]))
        assert said == ["elements of set 1 of 2", "", "elements of set 2 of 2", ""]
        stored = Springs.of(tree)
        assert list(stored.memory) == ["memory", "memory_load_1"]
        assert stored.memory["memory"].attrs["paths_sha256"] == digest(stored.at(V=rest))


def test_a_held_back_path_between_two_rates_is_answered_with_memory() -> None:
    tree = winkler.at_two_rates((1e-5, 1e-3)).tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    path = groups["/paths/turning_0_0"].copy(deep=True)
    path["time"] = path["time"] / 10.0
    groups["/paths/loop"] = path.assign_attrs(role="held-back")
    springs = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    assert "memory" in spring_sets(springs.answering(springs.paths["loop"]))


def test_between_two_rates_and_two_vertical_loads_there_are_four_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    """And springs with other paths are derived from none of them."""
    tree = winkler.at_two_rates((1e-5, 1e-3)).tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    heavy = {f"{name}_heavy": pressed(path, HEAVY) for name, path in groups.items() if name.startswith("/paths/")}
    springs = Springs.of(xr.DataTree.from_dict(groups | heavy, name="springs"))
    monkeypatch.setattr(
        build, "calibrate", lambda _ways, table, _stiffness, others: elements_of(winkler.mixed(), table)
    )
    at = springs.at(rate=1e-4, V=1.5 * REST)
    assert build_memory(at).sets == 4 and len(build_memory(at).elements.rows) == 4 * len(winkler.mixed())
    assert at.whole is not None and len(at.parts) == 2
    bare = at.with_paths(at.paths.values())
    assert bare.whole is None and not bare.parts


def test_loads_that_differ_by_the_tolerance_of_a_solver_are_one() -> None:
    tree = loaded.springs().tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    for name, path in groups.items():
        if name.startswith("/paths/turning"):
            groups[name] = path.assign(V=path["V"] * (1.0 + 1e-7))
    near = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    for V in (REST, HEAVY):
        found = build_memory(near.at(V=V))
        assert found.sets == 1
        np.testing.assert_array_equal(found.elements.rows, memory(V).elements.rows)


def test_elements_are_stored_once_and_older_ones_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lone path beyond both loads has the springs of the nearest one."""
    monkeypatch.setattr(
        build, "calibrate", lambda _ways, table, _stiffness, others: elements_of(winkler.mixed(), table)
    )
    tree = loaded.springs().tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    groups["/paths/alone"] = pressed(groups["/paths/ray_0_1"], 1.2 * HEAVY)
    groups["/memory_load_7"] = groups["/memory"]
    stored = Springs.of(with_memory(xr.DataTree.from_dict(groups, name="springs")))
    assert list(stored.memory) == ["memory", "memory_load_1"]


def test_the_rate_is_that_of_the_rays_that_turn_back() -> None:
    """Where the other rays have one rate, which is another."""
    tree = winkler.at_two_rates((1e-5,)).tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    fast = {name: data for name, data in groups.items() if not name.startswith("/paths/ray") or name.endswith("_1")}
    springs = Springs.of(xr.DataTree.from_dict(fast, name="springs"))
    fast["/memory"] = loaded.invented(springs.at(), 1)
    assert build_memory(Springs.of(xr.DataTree.from_dict(fast, name="springs")).at()).rate == pytest.approx(1e-5)


def test_what_a_solver_leaves_of_no_load_has_no_capacity() -> None:
    """The load goes back to zero, of which some part of 1 N is left, in any direction."""
    answer = sequence(loaded.springs(), np.array([[1e5, 1e5], [0.0, 0.0]]), springs_kind="memory")
    assert np.hypot(answer["H"][1], answer["M"][1] / LENGTH) > 0.0 and answer["utilisation"][1] == 0.0
    assert not {"capacity_H_N", "capacity_M_Nm", "capacity_kind", "capacity_from"} & set(answer.attrs)
