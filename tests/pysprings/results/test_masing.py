# SPDX-License-Identifier: MIT
"""Masing's rule of exported springs: what OpenSees does, and its error on paths that turn back."""

import re
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.results.exporters.uniaxial_sets import errors_on_reversals, masing, masing_loads, tables, uniaxial
from pysprings.springs.springs import Springs
from tests.support.in_opensees import answer_of
from tests.support.vertical import fan_with_vertical

MULTILINEAR = """
import json, sys
import openseespy.opensees as ops
points, path = json.load(sys.stdin)
ops.uniaxialMaterial("MultiLinear", 1, *points)
ops.testUniaxialMaterial(1)
out = []
for x in path:
    ops.setStrain(x)
    out.append(ops.getStress())
print(json.dumps(out))
"""


def test_masing_is_what_multilinear_does_in_opensees() -> None:
    """A cycle of growing size, in steps that end between the points of the curve."""
    q = np.array([0.0, 1e-3, 2e-3, 4e-3, 9e-3])
    f = np.array([0.0, 4e5, 6e5, 8e5, 9e5])
    turns = [0.0, 2.5e-3, -1.7e-3, 3.1e-3, -3.6e-3, 1e-3]
    path = np.concatenate([np.linspace(a, b, 40)[1:] for a, b in pairwise(turns)])
    points = [value for pair in zip(q[1:], f[1:], strict=True) for value in pair]
    np.testing.assert_allclose(masing(q, f, path), answer_of(MULTILINEAR, [points, path.tolist()], 0), atol=1e-6)


def test_the_label_of_hysteresis_has_its_error_on_paths_that_turn_back() -> None:
    """Springs that go back on their curve: Masing's rule is off by the loop, and elastic tables are not."""
    fan = fan_with_vertical()
    springs = fan.copy(deep=True)
    path = springs["paths/ray_0"].to_dataset(inherit=False)
    steps = [*range(path.sizes["step"]), *range(path.sizes["step"] - 2, 0, -1)]
    path = path.isel(step=steps).assign_coords(step=np.arange(len(steps)))
    path.attrs |= {"role": "held-back", "then_parts": 1}
    springs["paths/back"] = xr.DataTree(path)
    pressed = path.assign(V=path["V"] * np.linspace(1.0, 3.0, len(steps)))  # V is no error of the rule
    springs["paths/pressed"] = xr.DataTree(pressed.assign_attrs(heave="free"))
    made = uniaxial(Springs.of(fan))
    given = tables(made, 401)
    assert "not known" in errors_on_reversals(Springs.of(fan), made, given)[0]
    assert Springs.of(springs).paths["back"].turns_back
    (line,) = errors_on_reversals(Springs.of(springs), made, given)
    H = float(re.findall(r"H by (\d+) %", line)[0])
    u, rotation = path["u"].values, path["rotation"].values
    exact = path["H"].values
    assert 100.0 * np.abs(masing_loads(made, given, u, rotation)[0] - exact).max() / exact.max() == pytest.approx(
        H, abs=0.5
    )
    assert H > 30.0
