# SPDX-License-Identifier: MIT
"""Equation numbers and sparsity pattern against a brute-force list of couplings."""

import numpy as np
import pytest

from fe_engine.assembly.pattern import FIXED, make_pattern
from fe_engine.errors import ModelError
from tests.support.models import mixed, replace


def test_every_dof_is_fixed_follows_or_is_free():
    model = mixed()
    pattern = make_pattern(model)
    follows = np.zeros_like(model.fixed)
    for node, component, border, weight in model.followers:
        place = int(node), int(component)
        follows[place] = True
        assert pattern.equation[place] == -2 - border
        assert pattern.weight[place] == weight
    assert np.all(pattern.equation[model.fixed & ~follows] == FIXED)
    free = pattern.equation[~model.fixed & ~follows]
    np.testing.assert_array_equal(free, np.arange(pattern.n_free))


def test_rank_counts_the_free_dofs_of_the_node_before_this_one():
    pattern = make_pattern(mixed())
    assert len(pattern.equation) == mixed().mesh.n_nodes
    for equations, ranks in zip(pattern.equation, pattern.rank, strict=True):
        assert [r for e, r in zip(equations, ranks, strict=True) if e >= 0] == list(range((equations >= 0).sum()))


@pytest.mark.parametrize("rule", ["nodal", "gauss", "pairs"])
def test_pattern_holds_the_couplings_and_nothing_else(rule):
    model = mixed(rule)
    pattern = make_pattern(model)
    coupled = np.zeros((pattern.n_free, pattern.n_free), dtype=bool)
    for nodes in (*model.mesh.hexes, *model.stations.nodes):
        equations = pattern.equation[nodes].ravel()
        equations = equations[equations >= 0]
        coupled[np.ix_(equations, equations)] = True
    assert coupled.any()
    for row in range(pattern.n_free):
        columns = pattern.indices[pattern.indptr[row] : pattern.indptr[row + 1]]
        np.testing.assert_array_equal(columns, np.flatnonzero(coupled[row]))


@pytest.mark.parametrize("rule", ["gauss", "pairs"])
def test_offsets_lead_to_the_right_column(rule):
    model = mixed(rule)
    p = make_pattern(model)
    tried = 0
    groups = ((model.mesh.hexes, p.element_offset), (model.stations.nodes, p.station_offset))
    for group, offset in groups:
        for k, nodes in enumerate(group):
            for a, b in np.ndindex(len(nodes), len(nodes)):
                for i, j in np.ndindex(3, 3):
                    row, column = p.equation[nodes[a], i], p.equation[nodes[b], j]
                    if row >= 0 and column >= 0:
                        assert p.indices[p.indptr[row] + offset[k, a, b] + p.rank[nodes[b], j]] == column
                        tried += 1
    assert tried > 1000


def test_pairs_couple_nodes_without_a_common_element():
    """The stations of a deformable side 2 fill entries of their own."""
    without = make_pattern(replace(mixed("pairs"), stations=None, initial_pressure=np.zeros(0)))
    assert len(make_pattern(mixed("pairs")).indices) > len(without.indices)
    assert without.station_offset.shape[0] == 0


@pytest.mark.parametrize("border", [-1, 4])
def test_following_a_border_dof_that_does_not_exist_is_refused(border):
    model = replace(mixed(), followers=np.array([(3, 0, border, 1.0)]))
    with pytest.raises(ModelError, match=f"node 3 follows border dof {border}"):
        make_pattern(model)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("material", np.zeros(5, dtype=np.int64)),
        ("initial_stress", np.zeros((12, 8, 5))),
        ("fixed", np.zeros((36, 2), dtype=bool)),
        ("border_scale", np.ones(3)),
        ("initial_pressure", np.zeros(3)),
    ],
)
def test_a_model_with_parts_that_do_not_fit_is_refused(name, value):
    with pytest.raises(ModelError, match=f"{name} has shape"):
        replace(mixed(), **{name: value}).check()
