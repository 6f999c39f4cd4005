# SPDX-License-Identifier: MIT
"""The rings at the edge of the tip: which ones they are, and springs on slices that do not depend on the mesh there.

Contact stress at the corner of a stiff body is singular. The force of the skirt above a depth converges with the mesh;
p in the last slice does not: it grows as the slice gets thinner. Distributed springs for another mesh or program keep
the resultant of the edge, not its p.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import refused
from pysprings.springs.path import paths_of
from pysprings.springs.springs import memory_groups

EDGE = 0.1  # of the skirt length, above the tip
ZONE = 0.2  # of the skirt length: the slice at the tip that programs get
SLIVER = 0.05  # of the skirt length: a thinner slice above the zone joins the next


def edge_rings(path: xr.Dataset) -> Marks:
    """Return which depths are edge rings, (depth,): the middle of the slice lies in the last tenth of the skirt.

    The last ring is one always, the first never.
    """
    bounds = path.variables["depth_bounds"].values
    length = bounds[-1, 1]
    edge = bounds.mean(axis=1) > (1.0 - EDGE) * length
    edge[-1], edge[0] = True, False
    return np.asarray(edge)


def reslice(springs: xr.DataTree, bounds: ArrayLike | None = None) -> xr.DataTree:
    """Return springs on other slices of the skirt, for programs that take p, m and t by depth.

    p is constant in each slice of the mesh; a new one has the mean of what it covers, and m takes the moment of p about
    its middle. A slice that stays keeps its ring. So sum p dz, sum t dz and sum (m - p z) dz are kept: H, V and M of
    every state. Tip and lid stay as they are; a path that would cavitate ends there. The elements of a memory set and
    the paths out of one plane, from which a part of them is made, are left out: they belong to the old slices.

    Parameters
    ----------
    springs
        Springs with slices (`extract_springs`, `open_springs`).
    bounds
        Depths [m] between slices, from 0 to the skirt length. By default those of the mesh, with the last fifth of the
        skirt as one slice (`tip_zone`).

    Raises
    ------
    UserInputError
        The bounds do not increase from 0 to the skirt length.
    """
    tree = springs.copy(deep=True)
    for name in [*memory_groups(tree), *(name for name in ("space",) if name in tree.children)]:
        del tree[name]
    for name, path in paths_of(tree).items():
        edges = None if bounds is None else _checked(bounds, path.recorded)
        tree.children["paths"].children[name].dataset = on_slices(path.known, edges)
    return tree


def tip_zone(path: xr.Dataset) -> Array:
    """Return the depths between slices [m] of the mesh, with the last fifth of the skirt as one slice.

    A slice that the zone cuts to less than a twentieth of the skirt joins the one above it.
    """
    given = path.variables["depth_bounds"].values
    length = float(given[-1, 1])
    top = (1.0 - ZONE) * length
    kept = [depth for depth in given[1:, 0] if depth <= top - SLIVER * length]
    return np.array([0.0, *kept, top, length])


def _checked(bounds: ArrayLike, path: xr.Dataset) -> Array:
    edges, length = np.asarray(bounds, dtype=float), float(path.variables["depth_bounds"].values[-1, 1])
    ends = edges.ndim == 1 and edges.size > 1 and np.allclose(edges[[0, -1]], [0.0, length], atol=1e-9 * length)
    if not (ends and (np.diff(edges) > 0.0).all()):
        raise refused("bounds", f"slices must increase from 0 to the skirt length, {length:g} m")
    return edges


def shares(old: Array, edges: Array) -> Array:
    """Return which part of each slice between edges (n + 1,) [m] the slices with bounds (k, 2) [m] are, (n, k)."""
    low, high = np.maximum(edges[:-1, None], old[:, 0]), np.minimum(edges[1:, None], old[:, 1])
    return np.asarray(np.maximum(high - low, 0.0) / np.diff(edges)[:, None])


def distributed_like(own: Array, slices: Array, values: Array, bounds: Array) -> Array:
    """Return values (k, ...) of slices with bounds (k, 2) [m] in the slices (n, 2) of a finer mesh, (n, ...).

    In each of the k slices they vary as the values ``own`` (n, ...) of that mesh do. Their sums over depth remain.
    """
    old, new = (np.append(each[:, 0], each[-1, 1]) for each in (bounds, slices))
    change = values - np.tensordot(shares(slices, old), own, axes=1)
    return np.asarray(own + np.tensordot(shares(bounds, new), change, axes=1))


def on_slices(path: xr.Dataset, edges: Array | None = None) -> xr.Dataset:
    """Return a path whose slices lie between these depths [m]; by default those of `tip_zone`."""
    edges = tip_zone(path) if edges is None else edges
    old, rings = path.variables["depth_bounds"].values, path["depth"].values
    low, high = np.maximum(edges[:-1, None], old[:, 0]), np.minimum(edges[1:, None], old[:, 1])
    covered = shares(old, edges)
    share = xr.DataArray(covered, dims=("slice", "depth"))
    whole = (covered > 0.0) & np.isclose(old[:, 0], edges[:-1, None]) & np.isclose(old[:, 1], edges[1:, None])
    at = np.where(whole.any(axis=1), rings[whole.argmax(axis=1)], 0.5 * (edges[1:] + edges[:-1]))
    # where the force of a covered part acts: as far from its middle as the ring is from that of its slice
    arms = 0.5 * (low + high) + rings - old.mean(axis=1) - at[:, None]
    arm = xr.DataArray(np.where(whole, 0.0, arms), dims=("slice", "depth"))
    bare = path.drop_vars("depth")
    values = {name: share.dot(bare[name], dim="depth") for name in ("p", "p_component", "m", "t") if name in bare}
    by_side = bare["p_component"].sum("component") if "p_component" in bare else bare["p"]
    values["m"] = values["m"] - (share * arm).dot(by_side, dim="depth")
    y = bare["y"].transpose("depth", ...)
    moved = np.stack([on_line(rings, y.values.reshape(rings.size, -1), z) for z in at])
    values["y"] = xr.DataArray(moved.reshape(-1, *y.shape[1:]), dims=("slice", *y.dims[1:]))
    new = path.drop_dims("depth")
    for name, each in values.items():
        kept = each.rename(slice="depth").transpose(*path[name].dims)
        new[name] = (kept.dims, kept.values, path[name].attrs)
    bounds = np.column_stack([edges[:-1], edges[1:]])
    new = new.assign_coords(depth=("depth", at, path["depth"].attrs))
    return new.assign(depth_bounds=(path["depth_bounds"].dims, bounds, path["depth_bounds"].attrs))


def on_line(x: Array, y: Array, at: float) -> Array:
    """Return y (n,) of values (depth, n) at a depth, on the straight line through the two rings beside it."""
    k = int(np.clip(np.searchsorted(x, at), 1, max(x.size - 1, 1)))
    if x.size == 1:
        return y[0]
    return np.asarray(y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1]))
