# SPDX-License-Identifier: MIT
"""Scenes of two short paths, which runs that stop or share their work go through, and what makes two runs the same."""

import xarray as xr

import pysprings
from tests.support import tiny
from tests.support.files import record_of

SECOND = {**tiny.PULL, "name": "second", "kind": "translation"}


def drained() -> pysprings.Scene:
    """A dead load before each of two paths, five steps each."""
    few = {"first_step_fraction": 0.2}
    return tiny.scene(caisson={"vertical_load": 1.5e6}, paths=(tiny.PULL, SECOND), solver=few)


def coupled() -> pysprings.Scene:
    """A dead load, a pull, a rest, and another path."""
    first = {**tiny.PULL, "rate": 1e-4, "role": "held-back", "then": ("rest 2 hour",)}
    paths = (first, {**SECOND, "rate": 1e-3})
    shallow, few = {"water_depth": 0.0}, {"first_step_fraction": 0.2}
    return tiny.wet(drainage=shallow).replace(caisson={"vertical_load": 1.5e6}, paths=paths, solver=few)


def assert_same(result: xr.DataTree, other: xr.DataTree) -> None:
    """Every number of the result and of its record, but for cost and dates."""
    assert result.groups == other.groups
    for group in other.groups:
        xr.testing.assert_identical(*(plain(tree[group]) for tree in (result, other)))
    ours, theirs = record_of(result), record_of(other)
    for key in ("status", "failures", "warnings", "paths", "solver", "mesh"):
        assert ours[key] == theirs[key], key


def plain(node: xr.DataTree) -> xr.Dataset:
    dataset = node.to_dataset(inherit=False)
    return dataset.assign_attrs({key: "" for key in ("run_json", "history") if key in dataset.attrs})
