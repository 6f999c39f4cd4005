# SPDX-License-Identifier: MIT
"""Levels that pass through lines: ends, lines, sizes; meshes of layered ground in both discretisations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pysprings.model.forecast.resources import size_of
from pysprings.model.fourier import build
from pysprings.model.mesh import graded_both, through
from tests.support import tiny

LEVELS = graded_both(4.0, 11, 0.24, 0.24)


@given(st.lists(st.floats(-1.0, 6.0), max_size=20))
def test_levels_stand_on_every_line_inside_and_rise(lines):
    found = through(LEVELS, lines)
    assert found[0] == LEVELS[0]
    assert found[-1] == LEVELS[-1]
    assert np.all(np.diff(found) > 0.0)
    inside = [line for line in lines if 1e-6 < line < 4.0 - 1e-6]
    assert all(np.min(np.abs(found - line)) < 1e-8 for line in inside)


def test_levels_without_lines_between_them_stay_as_they_are():
    assert through(LEVELS, [0.0, 4.0, 7.0, float(LEVELS[3])]) is LEVELS


def test_cells_keep_about_their_size():
    found = through(LEVELS, [1.9])
    assert abs(len(found) - len(LEVELS)) <= 1
    sizes, at = np.diff(found), 0.5 * (found[1:] + found[:-1])
    before = np.interp(at, 0.5 * (LEVELS[1:] + LEVELS[:-1]), np.diff(LEVELS))
    assert np.all(sizes / before == pytest.approx(1.0, abs=0.6))


@pytest.mark.parametrize("discretisation", ["hex8", "fourier"])
def test_meshes_stand_on_the_boundaries_of_layers(discretisation):
    tops = (0.0, 0.33, 0.8, 1.31, 2.0)
    layers = [{"top": top} for top in tops]
    scene = tiny.scene(mesh={"discretisation": discretisation}, soil={"layers": layers})
    model = build(scene).model
    depth = model.mesh.nodes[:, -1]
    assert all(np.min(np.abs(depth - top)) < 1e-9 for top in tops)
    assert size_of(scene).nodes == model.mesh.n_nodes
    assert size_of(scene).elements == model.mesh.n_elements
