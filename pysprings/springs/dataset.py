# SPDX-License-Identifier: MIT
"""The tree of a spring file or result: its schema and its load paths.

A spring set is an `xarray.DataTree`: the root has the caisson and where the springs come from, and one group
`/paths/<name>` per load path has the reactions of the soil by depth, side and component along that path
(`pysprings.core.variables` lists every variable). The forces are monotonic backbones, not cyclic laws. `Springs`
(`pysprings.springs.springs`) is the same set with typed attributes.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from pysprings.core.errors import refused
from pysprings.core.path_kinds import driven

SCHEMA = "pysprings-springs-3"
OTHER_SIGNS = "its moments and rotations have other signs; make it again with `pysprings run`"  # of earlier versions
STATES = ("complete", "limit load", "partial", "interrupted")
FEWEST_STATES = 2  # a curve needs the initial state and one more


def path_names(tree: xr.DataTree, role: str | None = None) -> list[str]:
    """List the load paths of a tree, in order; only those of a role when it is given."""
    if "paths" not in tree.children:
        return []
    nodes = tree["paths"].children
    return [name for name, node in nodes.items() if role is None or node.attrs.get("role") == role]


def path_dataset(tree: xr.DataTree, name: str) -> xr.Dataset:
    """Return one path of a result or spring tree, all its steps."""
    return tree.children["paths"].children[name].to_dataset(inherit=False)


def get_path(tree: xr.DataTree, name: str | None = None) -> xr.Dataset:
    """Return the converged steps of one path; without a name the first lateral calibration path (or the first)."""
    names = path_names(tree)
    if name is None:
        lateral = [each for each in names if not is_vertical(tree, each)]
        calibration = path_names(tree, "calibration")
        name = next(iter([each for each in lateral if each in calibration] or lateral or names), None)
    if name is None or name not in names:
        raise refused("path", f"no path '{name}'; the springs have: {', '.join(names) or 'none'}")
    dataset = path_dataset(tree, name)
    good = np.flatnonzero(dataset["converged"].values == 1)
    usable = dataset if good.size == dataset.sizes["step"] else dataset.isel(step=good)
    return usable.assign_attrs(path=name)


def is_vertical(tree: xr.DataTree, name: str) -> bool:
    """Return whether a path moves the caisson vertically only."""
    return driven(tree.children["paths"].children[name].attrs) == "w"


def path_load(path: xr.Dataset) -> float:
    """Return the vertical load [N] at the start of a path; 0 where a table does not have it."""
    return float(path["V"].values[0]) if "V" in path else 0.0
