# SPDX-License-Identifier: MIT
"""Full-model result -> spring set: interface reactions by depth, and the check that they balance the load."""

import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import refused
from pysprings.core.variables import TORSION
from pysprings.springs.checks import FEWEST_STATES, RESULT, SCHEMA, validate_springs
from pysprings.springs.path import paths_of
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
    tree = xr.DataTree.from_dict(groups, name="springs")
    validate_springs(tree)
    return tree
