# SPDX-License-Identifier: MIT
"""The spring set of a caisson: what a spring file must hold, reading, writing, and the sums everybody needs.

A spring set is an `xarray.DataTree`: the root has the caisson and where the springs come from, and one group
`/paths/<name>` per load path has the reactions of the soil by depth, side and component along that path
(`pysprings.core.variables` lists every variable). The forces are monotonic backbones, not cyclic laws.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.files.storage import read_tree, refusal, write_tree
from pysprings.core.path_kinds import PATH_KINDS, VERTICAL
from pysprings.core.units import quoted
from pysprings.springs.numbers import is_number, name_fault, number_faults, text_of
from pysprings.springs.path_ends import end_faults

SCHEMA = "pysprings-springs-2"
ROLES = ("calibration", "held-back")
STATES = ("complete", "partial", "interrupted")
FEWEST_STATES = 2  # a curve needs the initial state and one more
SAME_LOAD = 1e-3  # vertical loads that differ by less than this share are one
NO_LOAD = 1.0  # or by this [N]
# Reactions sum to the load within this share of the largest of them. Files of a run: 1e-15; single precision: 1e-7.
BALANCED = 1e-6

_ROOT_NUMBERS = ("outer_diameter_m", "skirt_length_m", "skirt_thickness_m", "vertical_load_N")
_ROOT_TEXTS = ("drainage", "pysprings_version", "scene_sha256")


def open_springs(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read and validate a spring file.

    Raises
    ------
    UserInputError
        The file is missing, broken, of another kind or version, or lacks something; every fault is listed.
    """
    tree = read_tree(path)
    validate_springs(tree, file=path)
    return tree


def save_springs(tree: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Validate a spring set and write it as NetCDF, atomically; return its path."""
    validate_springs(tree)
    return write_tree(tree, path)


def validate_springs(tree: xr.DataTree, file: str | os.PathLike[str] | None = None, balanced: bool = True) -> None:
    """Raise UserInputError, with one problem per fault, unless the tree is a complete spring set.

    balanced: also where the reactions of a path do not sum to its loads (merged slices lose a part of the moment).
    """
    schema = tree.attrs.get("schema")
    if text_of(schema) != SCHEMA:
        raise refusal(file, "schema", _foreign(tree, schema))
    found = [*_root_faults(tree), *variables.tree_problems(tree, "springs")] or list(_type_faults(tree))
    found = found or [fault for name in path_names(tree) for fault in _path_faults(tree, name)]
    found = found or [
        (f"paths/{name}/{key}", text)
        for name in path_names(tree)
        if balanced
        for key, text in _balance_faults(path_dataset(tree, name))
    ]
    if found:
        name = None if file is None else str(file)
        raise UserInputError([Problem(file=name, key=key, message=message) for key, message in found])


def _foreign(tree: xr.DataTree, schema: object) -> str:
    if schema is not None:
        return f"springs of another version: '{str(schema)[:40]}' instead of '{SCHEMA}'"
    if "section" in tree.children or "scene_toml" in tree.attrs:
        return "a full-model result, not a spring file (extract its springs first)"
    return f"not a spring file (no attribute 'schema' = '{SCHEMA}')"


def _root_faults(tree: xr.DataTree) -> Iterator[tuple[str, str]]:
    for name in _ROOT_NUMBERS:
        value: Any = tree.attrs.get(name)
        if not is_number(value):
            yield name, "missing attribute, or not a number"
        elif value <= 0.0 and name != "vertical_load_N":
            yield name, f"{value:g} is not positive"
    for name in _ROOT_TEXTS:
        if not isinstance(tree.attrs.get(name), str):
            yield name, "missing attribute"
    if not path_names(tree):
        yield "paths", "no path in the file"


def _type_faults(tree: xr.DataTree) -> Iterator[tuple[str, str]]:
    """Yield what no file of ours has: variables without numbers, numbers without sense, names of paths."""
    root = list(number_faults(tree.to_dataset(inherit=False), "springs_root"))
    if tree.dataset["stiffness_initial"].shape != (len(variables.DOFS), len(variables.DOFS)):
        root.append(("stiffness_initial", f"must be {len(variables.DOFS)} by {len(variables.DOFS)}"))
    yield from root
    if not root and not np.isfinite(tree.dataset["stiffness_initial"].values).all():
        yield "stiffness_initial", "not finite"
    elif not root and not _resists(tree.dataset["stiffness_initial"].values):
        yield "stiffness_initial", "does not resist every motion of the caisson (not positive definite)"
    for key in ("dof", "dof_conjugate"):
        if tuple(tree.dataset[key].values) != variables.DOFS:
            yield key, f"labels must be {', '.join(variables.DOFS)}"
    for name in path_names(tree):
        if wrong := name_fault(name):
            yield f"paths/{quoted(name)}", wrong
        found = number_faults(path_dataset(tree, name), "springs_path")
        yield from ((f"paths/{name}/{key}", text) for key, text in found)


def _resists(stiffness: np.ndarray) -> bool:
    """Tell whether a stiffness (3, 3) resists u, w, rotation and all that they make up."""
    diagonal = np.diag(stiffness)
    if not (diagonal > 0.0).all():
        return False
    scale = 1.0 / np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * scale * scale[:, None]).min() > 0.0)


def _path_faults(tree: xr.DataTree, name: str) -> Iterator[tuple[str, str]]:
    dataset = path_dataset(tree, name)
    place = f"paths/{name}"
    for key, allowed in (("kind", tuple(PATH_KINDS)), ("role", ROLES), ("status", STATES)):
        if text_of(dataset.attrs.get(key)) not in allowed:
            yield f"{place}/{key}", f"attribute must be one of {', '.join(allowed)}"
    if not is_number(dataset.attrs.get("arm_m")):
        yield f"{place}/arm_m", "missing attribute, or not a number"
    yield from ((f"{place}/{key}", text) for key, text in end_faults(dataset.attrs))
    for key in ("rate_m_per_s", "arm_from_m"):
        if not is_number(dataset.attrs.get(key, 1.0)):
            yield f"{place}/{key}", "not a number"
    for key, labels in (("side", variables.SIDES), ("component", variables.COMPONENTS)):
        if tuple(dataset[key].values) != labels:
            yield f"{place}/{key}", f"labels must be {', '.join(labels)}"
    yield from ((f"{place}/{key}", text) for key, text in _depth_faults(dataset, tree.attrs["skirt_length_m"]))
    rigid = tree.attrs.get("caisson_behaviour") != "elastic"
    yield from ((f"{place}/{key}", text) for key, text in _step_faults(dataset, rigid))


def _depth_faults(dataset: xr.Dataset, length: float) -> Iterator[tuple[str, str]]:
    depth, bounds = dataset["depth"].values, dataset["depth_bounds"].values
    if (
        not depth.size
        or bounds.shape != (depth.size, 2)
        or not (np.isfinite(depth).all() and np.isfinite(bounds).all())
    ):
        yield "depth_bounds", "must hold a finite top and bottom for each depth"
        return
    if (np.diff(depth) <= 0).any():
        yield "depth", "must increase"
    if (depth < bounds[:, 0]).any() or (depth > bounds[:, 1]).any() or (bounds[:, 1] <= bounds[:, 0]).any():
        yield "depth_bounds", "each depth must lie between its top and its bottom"
    edges = np.concatenate([[0.0], bounds[:, 1]]), np.concatenate([bounds[:, 0], [length]])
    if np.abs(edges[0] - edges[1]).max() > 1e-6 * length:
        yield "depth_bounds", f"the slices must cover 0 to {length:g} m without gaps or overlaps"


def _step_faults(dataset: xr.Dataset, rigid: bool) -> Iterator[tuple[str, str]]:
    good = dataset["converged"].values == 1
    if good.sum() < FEWEST_STATES or not good[0]:
        yield "converged", "needs the initial state and at least one converged step"
        return
    steps = np.flatnonzero(good)
    for name in dataset.data_vars:
        data = dataset.variables[name]  # not data arrays: dozens of paths are checked in a moment
        if "step" in data.dims and not np.isfinite(data.isel(step=steps).values).all():
            yield str(name), "not finite at a converged step"
    u, rotation, depth = (dataset.variables[name].values for name in ("u", "rotation", "depth"))
    y = dataset.variables["y"].transpose("depth", "step").values[:, steps]
    if not y.size or not all(np.isfinite(values).all() for values in (u[steps], rotation[steps], depth, y)):
        return  # said already
    if not rigid:
        return
    expected = u[steps] + rotation[steps] * depth[:, None]
    if np.abs(y - expected).max() > 1e-6 * np.abs(y).max():
        yield "y", "is not u + rotation*depth (depth down, right-hand rotation about +y)"


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
        raise refusal(None, "path", f"no path '{name}'; the springs have: {', '.join(names) or 'none'}")
    dataset = path_dataset(tree, name)
    good = np.flatnonzero(dataset["converged"].values == 1)
    kept = dataset if good.size == dataset.sizes["step"] else dataset.isel(step=good)
    return kept.assign_attrs(path=name)


def is_vertical(tree: xr.DataTree, name: str) -> bool:
    """Tell whether a path moves the caisson vertically only."""
    return bool(tree.children["paths"].children[name].attrs.get("kind") == VERTICAL)


def path_load(path: xr.Dataset) -> float:
    """Return the vertical load [N] at the start of a path; 0 where a table does not know it."""
    return float(path["V"].values[0]) if "V" in path else 0.0


def same_load(a: float, b: float) -> bool:
    """Tell whether two vertical loads [N] are one: solver tolerances are between them."""
    return abs(a - b) <= max(SAME_LOAD * max(abs(a), abs(b)), NO_LOAD)


def slice_heights(dataset: xr.Dataset) -> np.ndarray:
    """Return the height of the slice of each depth [m], the weights of an integral over depth."""
    bounds = dataset["depth_bounds"].values
    return bounds[:, 1] - bounds[:, 0]


def net_p(dataset: xr.Dataset) -> xr.DataArray:
    """Return p of both sides and all components together [N/m], (depth, step)."""
    return dataset["p"].sum(("side", "component"), keep_attrs=True).transpose("depth", "step")


def net_m(dataset: xr.Dataset) -> xr.DataArray:
    """Return the distributed moment of both sides [N m/m], (depth, step)."""
    return dataset["m"].sum("side", keep_attrs=True).transpose("depth", "step")


def balance(dataset: xr.Dataset) -> dict[str, float]:
    """Return what is missing between summed reactions and loads H, V, M, relative to their largest part.

    A load that symmetry makes zero (H and M on a vertical path) counts beside a thousandth of the largest force.
    H = sum p dz + H_tip + H_lid;  V = sum t dz + V_tip + V_lid;
    M = sum (p z + m) dz + L H_tip + M_tip + M_lid.  Zero where the springs hold all reactions of the caisson.
    """
    sums = _sums(dataset)
    return {
        name: float(np.abs(total - dataset.variables[name].values).max()) / size if size else 0.0
        for name, (total, size) in sums.items()
    }


def _sums(dataset: xr.Dataset) -> dict[str, tuple[np.ndarray, float]]:
    """Sums of the reactions by step for H, V [N] and M [N m], each with what its error counts beside: see `balance`."""
    dz, z = slice_heights(dataset), dataset["depth"].values
    p, m, t = (
        net_p(dataset).values,
        net_m(dataset).values,
        dataset["t"].sum("side").transpose("depth", "step").values,
    )
    value = {name: dataset[name].values for name in ("H_tip", "H_lid", "V_tip", "V_lid", "M_tip", "M_lid")}
    length = float(dataset["depth_bounds"].values[-1, 1])
    parts = {
        "H": (dz @ p, value["H_tip"], value["H_lid"]),
        "V": (dz @ t, value["V_tip"], value["V_lid"]),
        "M": ((dz * z) @ p, dz @ m, length * value["H_tip"], value["M_tip"], value["M_lid"]),
    }
    least = 1.0e-3 * max(_largest(parts["H"]), _largest(parts["V"]))
    least_of = {"H": least, "V": least, "M": least * length}
    return {name: (np.sum(terms, axis=0), max(_largest(terms), least_of[name])) for name, terms in parts.items()}


def _balance_faults(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield (load, message) for loads that the reactions do not sum to, with the worst step."""
    good = np.flatnonzero(dataset.variables["converged"].values == 1)
    path = dataset.isel(step=good)
    for name, (total, size) in _sums(path).items():
        load = path.variables[name].values
        worst = int(np.argmax(np.abs(total - load)))
        if abs(total[worst] - load[worst]) > BALANCED * size:
            units = "N m" if name == "M" else "N"
            yield (
                name,
                f"step {good[worst]}: the reactions sum to {total[worst]:.6g} {units}, the load is {load[worst]:.6g} "
                f"{units} (they may differ by {BALANCED:g} of the largest reaction of the path)",
            )


def _largest(terms: tuple[np.ndarray, ...]) -> float:
    return max(float(np.abs(term).max()) for term in terms)
