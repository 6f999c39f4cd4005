# SPDX-License-Identifier: MIT
"""Full-model result -> spring set: interface reactions by depth, and the check that they balance the load."""

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import refused
from pysprings.core.variables import TORSION
from pysprings.springs.checks import FEWEST_STATES, RESULT, SCHEMA, validate_springs
from pysprings.springs.path import SpacePath, paths_of, pure_of, rays_of, space_paths_of
from pysprings.springs.path_ends import MARGIN

_ROOT_ATTRS = (
    "Conventions", "title", "source", "history", "references", "pysprings_version", "scene_sha256", "scene_toml",
    "solver", "mesh_preset", "n_nodes", "n_elements", "status", "drainage", "outer_diameter_m", "skirt_length_m",
    "skirt_thickness_m", "vertical_load_N", "caisson_behaviour", "limit_displacement_over_diameter",
    "limit_rotation_rad", TORSION, "defaulted", "remarks",
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
