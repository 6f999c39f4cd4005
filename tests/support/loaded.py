# SPDX-License-Identifier: MIT
"""Springs with memory under two vertical loads, with invented elements."""

from dataclasses import replace
from functools import cache

import numpy as np
import xarray as xr

from pysprings.macro.model import MacroModel
from pysprings.memory.build import memory_dataset
from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.vertical import REST, pressed, vertical_path
from tests.support.winkler import elements_of, mixed

HEAVY = 2.0 * REST


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
