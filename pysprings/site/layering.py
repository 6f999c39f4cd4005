# SPDX-License-Identifier: MIT
"""Boundaries of layers of a cone penetration test: the partition of least misfit, with a price for each layer.

In a layer I_c is constant and ln(q_net/s'_v0^0.5) linear in depth. Its misfit is the integral over depth of the squared
deviations over `SCATTER` squared; a further layer must lower the sum by `PRICE` metres. The best partition is found
exactly, by dynamic programming over cells.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SCATTER = (0.25, 0.35)  # usual deviations of I_c and of ln(q_net/s'^0.5) within one layer
PRICE = 3.0  # m
THINNEST = 0.5  # m
SURFACE = 10.0e3  # Pa, added to s'_v0: resistances at mudline are finite
CELLS, CELL = 400, 0.1  # at most, and height of a cell at least [m]


def boundaries(depth: Array, index: Array, net: Array, effective: Array, most: int) -> list[float]:
    """Return the depths (m) between layers of rows (n,), from I_c, q_net and s'_v0 [Pa].

    Rows without an index, or with q_net below 0, do not count.

    ``most`` is the largest number of layers: the price of a layer grows until it is kept.
    """
    edges, values = _cells(depth, index, net / np.sqrt(effective + SURFACE))
    if len(values) < 4:
        return []
    misfit, price = _misfits(edges, values), PRICE
    while True:
        cuts = _partition(misfit, price, edges)
        if len(cuts) < most:
            return [float(edges[k]) for k in cuts]
        price *= 1.3


def _cells(depth: Array, index: Array, net: Array) -> tuple[Array, Array]:
    """Return the edges (m + 1,) of cells that hold values, and the medians (m, 2) of I_c and ln ``net`` in them."""
    height = max(CELL, float(depth[-1] - depth[0]) / CELLS)
    at = np.floor((depth - depth[0]) / height + 1e-9).astype(int)
    good = np.isfinite(index) & (net > 0.0)
    edges, values = [float(depth[0])], []
    for cell in np.unique(at[good]):
        rows = good & (at == cell)
        values.append([float(np.median(index[rows])), float(np.median(np.log(net[rows])))])
        edges.append(min(float(depth[0] + (cell + 1) * height), float(depth[-1])))
    return np.array(edges), np.array(values)


def _misfits(edges: Array, values: Array) -> Array:
    """Return the misfit (m, m + 1) in m of one layer from the top of cell i to the top of cell j."""
    weight, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1]) - edges[0]
    index, cone = values.T
    terms = [np.ones_like(index), middle, middle**2, index, index**2, cone, cone**2, cone * middle]
    sums = [np.concatenate([[0.0], np.cumsum(weight * term)]) for term in terms]
    w, z, zz, a, aa, b, bb, bz = (each[None, :] - each[:-1, None] for each in sums)
    w = np.where(w > 0.0, w, np.nan)
    constant = aa - a * a / w
    spread, common = zz - z * z / w, bz - b * z / w
    slope = np.where(spread > 1e-9, common / np.maximum(spread, 1e-9), 0.0)
    linear = bb - b * b / w - slope * common
    out = np.maximum(constant, 0.0) / SCATTER[0] ** 2 + np.maximum(linear, 0.0) / SCATTER[1] ** 2
    thin = edges[None, :] - edges[:-1, None] < THINNEST - 1e-9
    return np.where(thin | ~np.isfinite(out), np.inf, out)


def _partition(misfit: Array, price: float, edges: Array) -> list[int]:
    """Return the cells at whose top a layer begins, without the first."""
    cells = misfit.shape[0]
    best, origin = np.full(cells + 1, np.inf), np.zeros(cells + 1, dtype=int)
    best[0] = -price
    for end in range(1, cells + 1):
        sums = best[:end] + misfit[:end, end] + price
        origin[end] = int(np.argmin(sums))
        best[end] = sums[origin[end]]
    cuts, at = [], cells
    while np.isfinite(best[at]) and origin[at] > 0:
        at = int(origin[at])
        cuts.append(at)
    return cuts[::-1]
