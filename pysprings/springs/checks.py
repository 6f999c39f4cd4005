# SPDX-License-Identifier: MIT
"""Spring sets of results, their files, and what they must hold: every fault of an incomplete one, with its place.

A spring set is an `xarray.DataTree`: the root has the caisson and where the springs come from, and one group
`/paths/<name>` per load path has the reactions of the soil by depth, side and component along that path
(`pysprings.core.variables` lists every variable). The forces are monotonic backbones, not cyclic laws. `Springs`
(`pysprings.springs.springs`) is the same set with typed attributes.
"""

import os
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.path_kinds import LOADS, MOTIONS, PAIRS, PARTS, PATH_KINDS, ROLES
from pysprings.core.storage import read_tree, write_tree
from pysprings.core.text import MOST_LETTERS
from pysprings.core.units import LARGEST, SMALLEST_AT_ALL, quoted
from pysprings.core.written import is_device
from pysprings.springs.path import RecordedPath, SpacePath, paths_of, pure_of, rays_of, space_paths_of
from pysprings.springs.path_ends import MARGIN, end_faults, is_number, text_of
from pysprings.springs.sums import BALANCED, balance_faults, by_depth

SCHEMA = "pysprings-springs-4"
RESULT = "pysprings-full-model-2"  # of a full-model result; 1 had no name
STATES = ("complete", "limit load", "partial", "interrupted")
FEWEST_STATES = 2  # a curve needs the initial state and one more
_ROOT_NUMBERS = ("outer_diameter_m", "skirt_length_m", "skirt_thickness_m", "vertical_load_N")
_CONTROL = ("Cc", "Zl", "Zp")  # Unicode categories: control characters, line and paragraph separators
_ROOT_TEXTS = ("drainage", "pysprings_version", "scene_sha256")


def validate_springs(tree: xr.DataTree, file: str | os.PathLike[str] | None = None, balanced: bool = True) -> None:
    """Raise UserInputError, with one problem per fault, unless the tree is a complete spring set.

    balanced: also where the reactions of a path do not sum to its loads (merged slices lose a part of the moment).
    """
    check_schema(tree, file)
    problems = [*_text_faults(tree), *_root_faults(tree), *variables.tree_problems(tree, "springs")] or list(
        _type_faults(tree)
    )
    paths = [] if problems else list(paths_of(tree).values())
    problems = problems or [fault for path in paths for fault in _path_faults(tree, path)]
    depth = paths[0].depth if paths else np.zeros(0)
    problems = problems or [fault for path in space_paths_of(tree).values() for fault in _space_faults(path, depth)]
    problems = problems or [
        (f"paths/{path.name}/{key}", text) for path in paths if balanced for key, text in balance_faults(path.recorded)
    ]
    if problems:
        name = None if file is None else str(file)
        raise UserInputError([Problem(file=name, key=key, message=message) for key, message in problems])


def check_schema(tree: xr.DataTree, file: str | os.PathLike[str] | None = None) -> None:
    """Raise UserInputError unless the tree is a spring set of this version: signs and units of others differ."""
    schema = tree.attrs.get("schema")
    if text_of(schema) != SCHEMA:
        raise refused("schema", _foreign(tree, schema), file)


def _text_faults(tree: xr.DataTree) -> Iterator[tuple[str, str]]:
    """Yield texts that are not on one line, but for scenes: files for other programs would take the rest for input."""
    for node in tree.subtree:
        place = node.path.strip("/")
        owners = [(place, node.attrs), *((f"{place}/{name}", data.attrs) for name, data in node.variables.items())]
        for owner, attrs in owners:
            for key, value in attrs.items():
                if not str(key).startswith("scene_toml") and not _is_on_one_line(str(key), value):
                    yield f"{owner}/{quoted(str(key))}".strip("/"), "a text with a line end or a control character"


def _is_on_one_line(*texts: object) -> bool:
    parts = (str(part) for text in texts for part in (text if isinstance(text, list | tuple | np.ndarray) else (text,)))
    return not any(unicodedata.category(c) in _CONTROL for part in parts for c in part)


def _foreign(tree: xr.DataTree, schema: object) -> str:
    text, earlier = str(schema)[:40], (f"{SCHEMA[:-1]}{number}" for number in range(1, int(SCHEMA[-1])))
    if "section" in tree.children or (schema is None and "scene_toml" in tree.attrs):
        return "a full-model result, not a spring file (extract its springs first)"
    if schema is not None:
        again = " (make it again with `pysprings run`)" if text in earlier else ""
        return f"springs of another version: '{text}' instead of '{SCHEMA}'{again}"
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
    if "paths" not in tree.children or not tree.children["paths"].children:
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
    groups = ("space", "space_path", space_paths_of(tree)), ("paths", "springs_path", paths_of(tree))
    for group, described, paths in groups:
        for name, path in paths.items():
            if wrong := name_fault(name):
                yield f"{group}/{quoted(name)}", wrong
            problems = number_faults(path.recorded, described)
            yield from ((f"{group}/{name}/{key}", text) for key, text in problems)


def _resists(stiffness: np.ndarray) -> bool:
    """Return whether a stiffness (3, 3) resists every motion (u, w, rotation): positive definite."""
    diagonal = np.diag(stiffness)
    if not (diagonal > 0.0).all():
        return False
    scale = 1.0 / np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * scale * scale[:, None]).min() > 0.0)


def _path_faults(tree: xr.DataTree, path: RecordedPath) -> Iterator[tuple[str, str]]:
    dataset, place = path.recorded, f"paths/{path.name}"
    for key, allowed in (("kind", tuple(PATH_KINDS)), ("role", ROLES), ("status", STATES)):
        if text_of(dataset.attrs.get(key)) not in allowed:
            yield f"{place}/{key}", f"attribute must be one of {', '.join(allowed)}"
    if not is_number(dataset.attrs.get("arm_m")):
        yield f"{place}/arm_m", "missing attribute, or not a number"
    yield from ((f"{place}/{key}", text) for key, text in end_faults(dataset.attrs))
    for key in ("rate_m_per_s", "arm_from_m", PARTS, PAIRS):
        if not is_number(dataset.attrs.get(key, 1.0)):
            yield f"{place}/{key}", "not a number"
    for key, labels in (("side", variables.SIDES), ("component", variables.COMPONENTS)):
        if tuple(dataset[key].values) != labels:
            yield f"{place}/{key}", f"labels must be {', '.join(labels)}"
    yield from ((f"{place}/{key}", text) for key, text in _depth_faults(dataset, tree.attrs["skirt_length_m"]))
    rigid = tree.attrs.get("caisson_behaviour") != "elastic"
    yield from ((f"{place}/{key}", text) for key, text in _step_faults(dataset, rigid))


def _space_faults(path: SpacePath, depth: np.ndarray) -> Iterator[tuple[str, str]]:
    """Yield what is wrong with a path that leaves the plane of one load; depth: that of paths in one plane."""
    place, attrs = f"space/{path.name}", path.attrs
    for key, allowed in (("kind", tuple(PATH_KINDS)), ("role", ROLES[1:])):
        if text_of(attrs.get(key)) not in allowed:
            yield f"{place}/{key}", f"attribute must be one of {', '.join(allowed)}"
    good = path.recorded["converged"].values == 1
    if good.sum() < FEWEST_STATES or not good[0]:
        yield f"{place}/converged", "needs the initial state and at least one converged step"
        return
    if not np.array_equal(path.depth, depth):
        yield f"{place}/depth", "is not that of the paths in one plane"
    for name in (*MOTIONS, *LOADS, "p_x", "p_y"):
        if not np.isfinite(path[name]).all():
            yield f"{place}/{name}", "not finite at a converged step"


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
    p, parts = (by_depth(dataset, name)[:, steps] for name in ("p", "p_component"))
    if np.abs(parts - p).max(initial=0.0) > BALANCED * np.abs(p).max(initial=0.0):
        yield "p", "is not the sum of p_component over sides and components"
    u, rotation, depth = (dataset.variables[name].values for name in ("u", "rotation", "depth"))
    y = dataset.variables["y"].transpose("depth", "step").values[:, steps]
    if not y.size or not all(np.isfinite(values).all() for values in (u[steps], rotation[steps], depth, y)):
        return  # reported already
    if not rigid:
        return
    expected = u[steps] - rotation[steps] * depth[:, None]
    if np.abs(y - expected).max() > 1e-6 * np.abs(y).max():
        yield "y", "is not u - rotation*depth (depth down; rotation is positive where the caisson leans towards +x)"


def open_springs(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read and validate a spring file: ``springs.nc``, or the folder of a run that holds it.

    Raises
    ------
    UserInputError
        The file is missing, broken, of another kind or version, or lacks something; every fault is listed.
    """
    file = Path(path)
    file = file / "springs.nc" if file.is_dir() else file
    tree = read_tree(file)
    validate_springs(tree, file=file)
    return tree


def save_springs(tree: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Validate a spring set and write it as NetCDF, atomically; return its path."""
    validate_springs(tree)
    return write_tree(tree, path)


LABELS = ("side", "component", "dof", "dof_conjugate")
_UNITS = {"radian": "rad", "N m-1": "N/m", "N m m-1": "N m/m"}  # UDUNITS text -> key of LARGEST

_NOT_FIRST = "=+-@. "  # a spreadsheet would read a formula, a shell an option, a folder something else


def name_fault(name: str) -> str:
    """Return what is wrong with the name of a path in a file; empty where nothing is."""
    if not name.isprintable() or "/" in name:
        return "a path's name has no '/' and no invisible characters"
    if name.startswith(tuple(_NOT_FIRST)) or len(name) > MOST_LETTERS:
        return f"a path's name has at most {MOST_LETTERS} characters, the first of them none of = + - @ . and blank"
    if is_device(name) or name.endswith((".", " ")):
        return (
            "a path's name names files, too: Windows refuses this one (CON, NUL, COM1 ..., or '.' or blank at its end)"
        )
    return ""


def number_faults(dataset: xr.Dataset, group: str) -> Iterator[tuple[str, str]]:
    """Yield (variable, message) for variables of a group of `variables.GROUPS` that are no numbers, or too large."""
    for key, data in dataset.variables.items():
        name = str(key)
        if name in LABELS:
            continue
        if data.dtype.kind not in "iufb":
            yield name, f"holds no numbers (type {data.dtype})"
            continue
        known = variables.GROUPS[group].get(name)
        units = known.units if known else "1"
        largest = LARGEST.get(_UNITS.get(units, units), np.inf)
        if group == "springs_root":  # a stiffness of mixed units
            largest = 1e30
        values = np.abs(data.values.astype(float))
        worst = float(values[np.isfinite(values)].max(initial=0.0))
        least = float(values[values > 0.0].min(initial=np.inf))
        if worst > largest:
            yield name, f"{worst:.3g} is beyond {largest:.0e} {units}"
        elif least < SMALLEST_AT_ALL:
            yield name, f"{least:.3g} is too small to be anything but 0"


_ROOT_ATTRS = (
    "Conventions", "title", "source", "history", "references", "pysprings_version", "scene_sha256", "scene_toml",
    "solver", "mesh_preset", "n_nodes", "n_elements", "status", "drainage", "outer_diameter_m", "skirt_length_m",
    "skirt_thickness_m", "vertical_load_N", "caisson_behaviour", "limit_displacement_over_diameter",
    "limit_rotation_rad", variables.TORSION, "defaulted", "remarks",
)  # fmt: skip
_KEPT = (
    "depth_bounds", "p", "p_component", "m", "t", "y", "u", "w", "rotation", "H", "V", "M", "converged", "time",
    "H_tip", "V_tip", "M_tip", "H_lid", "V_lid", "M_lid",
)  # fmt: skip


def extract_springs(result: xr.DataTree) -> xr.DataTree:
    """Make the spring set of a result: p, m and t by depth, tip and lid resultants, for each path.

    The reactions are sums of the interface tractions over the ring of stations at each depth, divided by the
    height of its slice, so that p dz + tip + lid is the applied load exactly. Paths without a converged step after
    the initial state are left out; UserInputError when none remains.
    """
    paths = [path for path in paths_of(result).values() if path.n >= FEWEST_STATES]
    if not paths:
        raise refused("paths", "no path has a converged step: no springs can be made")
    if (schema := result.attrs.get("schema")) != RESULT:
        raise refused("schema", f"'{str(schema)[:40]}' instead of '{RESULT}': no full-model result of this version")
    root = result.to_dataset(inherit=False)[["stiffness_initial"]]
    root.attrs = {key: result.attrs[key] for key in _ROOT_ATTRS if key in result.attrs} | {"schema": SCHEMA}
    groups: dict[str, xr.Dataset] = {"/": root}
    for each in paths:
        path = each.recorded
        springs = path[[*_KEPT, *(name for name in (MARGIN,) if name in path)]]
        springs.attrs = path.attrs
        groups[f"/paths/{each.name}"] = variables.attach(springs, "springs_path")
    for space in space_paths_of(result).values():
        if space.n >= FEWEST_STATES:
            groups[f"/space/{space.name}"] = _without_mesh(result, space)
    tree = xr.DataTree.from_dict(groups, name="springs")
    validate_springs(tree)
    return tree


def _without_mesh(result: xr.DataTree, path: SpacePath) -> xr.Dataset:
    """Return a path that leaves the plane without fields, its lateral loads extrapolated as those of a translation.

    Only paths in one plane are extrapolated. Loads and p out of it are multiplied by what the extrapolation makes
    of the load (H, M/L) of the pure translation at the same displacement of the lid centre; as recorded without one.
    """
    found = path.recorded.drop_dims("azimuth", errors="ignore")
    own, better = (paths_of(result, of_mesh) for of_mesh in (True, False))
    pure = pure_of(rays_of(each for each in better.values() if each.calibrates))
    if pure is None or own[pure[0]].recorded.identical(better[pure[0]].recorded):
        return found
    moved = np.hypot(found["u_x"], found["u_y"])
    both = [each[pure[0]] for each in (own, better)]
    mesh, known = (np.hypot(each["H"], each["M"] / path.length)[1:] for each in both)  # not at rest
    factor = xr.DataArray(np.interp(moved, both[0].u[1:], known / mesh), dims="step")
    lateral = ("H_x", "H_y", "M_x", "M_y", "p_x", "p_y")
    changed = found.assign({name: (found[name] * factor).transpose(*found[name].dims) for name in lateral})
    return variables.attach(changed, "space_path")
