# SPDX-License-Identifier: MIT
"""Springs with memory between two vertical loads or rates with rays that turn back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.macro.memory.build import build_memory
from pysprings.macro.memory.elements import FRICTIONAL
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.predict import MacroWarning, sequence
from pysprings.macro.sets import spring_sets
from pysprings.springs.springs import Springs
from tests.support import loaded, winkler
from tests.support.fans import LENGTH
from tests.support.loaded import HEAVY
from tests.support.vertical import REST, down_curve

WAY = 1e-3 * np.array([[1.0, 0.2], [3.0, -0.4], [-1.0, 0.1], [-2.0, 0.3], [2.0, 0.0], [0.0, 0.0]]) / [1.0, LENGTH]


def memory(V: float) -> MemoryModel:
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
    V = 0.9 * REST
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
    assert "memory" in spring_sets(lone)


def test_between_two_rates_loads_are_those_of_both_linear_in_the_logarithm_of_the_rate() -> None:
    """At 1e-4 m/s halfway between 1e-5 and 1e-3 m/s; steps at 1e-5 m/s are off that rate."""
    tree = winkler.at_two_rates((1e-5, 1e-3)).tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    for name, rate, seed in (("memory", 1e-5, 1), ("memory_rate_1", 1e-3, 2)):
        groups[f"/{name}"] = loaded.invented(Springs.of(tree).at(rate=rate), seed)
    stored = Springs.of(xr.DataTree.from_dict(groups, name="springs"))
    slow, between, fast = (build_memory(stored.at(rate=rate)) for rate in (1e-5, 1e-4, 1e-3))
    loads = [model.solve("state", WAY)[1] for model in (slow, fast)]
    np.testing.assert_allclose(between.solve("state", WAY)[1], 0.5 * (loads[0] + loads[1]), rtol=1e-9)
    assert np.abs(loads[0] - loads[1]).max() > 1e4
    assert between.rate == pytest.approx(1e-4) and "memory" in spring_sets(stored.at(rate=1e-4))
    time = np.arange(1.0, len(WAY) + 1.0) * float(np.hypot(*WAY[0] * [1.0, LENGTH])) / 1e-5
    assert between.off_rates(WAY[:1], time[:1]).all() and not slow.off_rates(WAY[:1], time[:1]).any()
