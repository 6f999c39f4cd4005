# SPDX-License-Identifier: MIT
"""The table of variables: every variable of the trees stands in it, with units that a units library reads."""

import cf_xarray.units
import pytest
import xarray as xr

from pysprings.core import variables
from tests.support.synthetic import make_result, make_springs


@pytest.mark.parametrize("group", list(variables.GROUPS))
def test_every_entry_has_words_and_udunits(group):
    assert variables.GROUPS[group]
    for name, variable in variables.GROUPS[group].items():
        assert variable.name == name
        assert variable.long_name
        assert variable.dims
        cf_xarray.units.units.parse_units(variable.units)  # raises on a unit it does not know


def test_trees_agree_with_the_table():
    assert variables.tree_problems(make_result(), "result") == []
    assert variables.tree_problems(make_springs(), "springs") == []


def test_depth_is_a_cf_vertical_coordinate():
    depth = make_springs()["paths/pull/depth"]
    expected = {"standard_name": "depth", "positive": "down", "axis": "Z", "bounds": "depth_bounds", "units": "m"}
    assert expected.items() <= depth.attrs.items()


def _without_units(data: xr.Dataset) -> xr.Dataset:
    del data["H"].attrs["units"]
    return data


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_without_units, "paths/pull/H: no units (expected 'N')"),
        (lambda d: d.drop_vars("t"), "paths/pull/t: missing variable"),
        (lambda d: d.assign(y=d["y"].transpose("step", "depth")), "paths/pull/y: dimensions (step, depth)"),
        (lambda d: d.assign(new=("step", d["u"].values)), "paths/pull/new: unknown variable"),
        (lambda d: d.assign(u=d["u"].assign_attrs(units="mm")), "paths/pull/u: units 'mm' instead of 'm'"),
    ],
)
def test_a_fault_is_named(spoil, words):
    tree = make_springs()
    tree["paths/pull"].dataset = spoil(tree["paths/pull"].to_dataset(inherit=False).copy(deep=True))
    found = [f"{key}: {message}" for key, message in variables.tree_problems(tree, "springs")]
    assert len(found) == 1 and found[0].startswith(words)
