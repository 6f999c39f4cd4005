# SPDX-License-Identifier: MIT
"""The rings at the edge of the tip: which ones they are, and springs without their peak.

Contact stress at the corner of a stiff body is singular. The force of the skirt above a depth converges with the mesh;
p in the last slice does not: it grows as the slice gets thinner. Distributed springs for another mesh or program keep
the resultant of the edge, not its p.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.path_kinds import MEMORY
from pysprings.springs.dataset import path_dataset, path_names
from pysprings.springs.sums import slice_heights

EDGE = 0.1  # of the skirt length, above the tip


def edge_rings(path: xr.Dataset) -> NDArray[np.bool_]:
    """Return which depths are edge rings, (depth,): the middle of the slice lies in the last tenth of the skirt.

    The last ring is one always, the first never.
    """
    bounds = path.variables["depth_bounds"].values
    length = bounds[-1, 1]
    edge = bounds.mean(axis=1) > (1.0 - EDGE) * length
    edge[-1], edge[0] = True, False
    return np.asarray(edge)


def lump_edge(springs: xr.DataTree) -> xr.DataTree:
    """Return springs whose edge rings have p, m and t of the ring above them; what they lose acts on the tip.

    H, V and M of every state are kept: H_tip takes sum (p - p') dz, V_tip sum (t - t') dz, and M_tip
    sum ((z - L)(p - p') + m - m') dz. The elements of a memory set are left out: they belong to the old springs.
    """
    tree = springs.copy(deep=True)
    if MEMORY in tree.children:
        del tree[MEMORY]
    for name in path_names(tree):
        tree.children["paths"].children[name].dataset = _lumped(path_dataset(tree, name))
    tree.attrs["tip_edge"] = "lumped"
    return tree


def _lumped(path: xr.Dataset) -> xr.Dataset:
    edge = edge_rings(path)
    if not edge.any():
        return path
    above, dz = int(np.flatnonzero(~edge)[-1]), slice_heights(path)[edge]
    arm = path["depth"].values[edge] - float(path["depth_bounds"].values[-1, 1])
    change: dict[str, NDArray[np.float64]] = {}
    for name in ("p", "m", "t"):
        values = path[name].transpose("depth", ...)
        held = values.values.copy()
        held[edge] = held[above]
        lost = values.copy(data=values.values - held).sum([dim for dim in values.dims if dim not in ("depth", "step")])
        change[name] = lost.transpose("depth", "step").values[edge]
        path = path.assign({name: values.copy(data=held).transpose(*path[name].dims)})
    more = {"H_tip": dz @ change["p"], "V_tip": dz @ change["t"], "M_tip": (dz * arm) @ change["p"] + dz @ change["m"]}
    return path.assign({name: path[name] + values for name, values in more.items()}).map(
        lambda each: each.assign_attrs(path[each.name].attrs), keep_attrs=True
    )
