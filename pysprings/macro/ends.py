# SPDX-License-Identifier: MIT
"""States and loads beyond a limit load of the full model: the macro-model has no answer there.

A load in the direction of one that a path of the full model could not exceed (at the same vertical load) is not
carried, and beyond the range of springs whose path met a limit load there is no equilibrium. A vertical load that the
springs were not made for is answered from an elastic stiffness only where it differs from theirs by no more than
theirs: without vertical springs from 0 to twice the load of the paths.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import RANGE_SLACK, FanTable
from pysprings.springs.path import SAME_DIRECTION, same_load
from pysprings.springs.path_ends import LIMIT_LOAD, PathEnd

if TYPE_CHECKING:
    from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]


def past_ends(
    model: MacroModel, states: Array, used: Array, loads: Array, V: Array | None, aim: Array | None = None
) -> tuple[Marks, list[str]]:
    """Return which states (n, 2) = (u, rotation) are beyond a limit load, and a sentence on each such path.

    used (n,) is the range that the lateral springs use, loads (n, 2) = (H, M), V (n,) [N] the vertical load, aim
    (H, M) the load behind the last state that the springs did not carry (None: all were).
    """
    n, marks, ends = len(states), np.zeros(len(states), dtype=bool), dict[str, PathEnd]()
    if aim is not None:
        loads, V = np.vstack([loads, aim]), np.append(V, V[-1:]) if V is not None and V.size else None
    for end, beyond in (*_ranges(model, states, used), *_capacities(model, loads, V)):
        if beyond.any():
            marks |= beyond[:n]
            ends[end.path] = end
    return marks, [f"the answer is beyond what the full model carried: {end}" for end in ends.values()]


def _ranges(model: MacroModel, states: Array, used: Array) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield the limit loads of paths that the springs come from, and the states beyond the range of each."""
    over = used > 1.0 + RANGE_SLACK
    failed = [end for name in model.sources if (end := model.ends[name]).how == LIMIT_LOAD]
    if not failed or not over.any():
        return
    table = model.table
    if not isinstance(table, FanTable):
        yield from ((end, over) for end in failed)
        return
    rho, places = table.polar(states)[0], table.rows(states)[1]
    sector = table.support(states, places)[1]
    low, high, place = places[:, 0].astype(int), places[:, 1].astype(int), places[:, 2]
    for end in failed:
        ray = table.path.index(end.path)
        beside = (low == ray) & ((sector > 0.0) | (place < 0.5)) | (high == ray) & ((sector > 0.0) | (place >= 0.5))
        yield end, beside & (rho > table.range[ray] * (1.0 + RANGE_SLACK))


def _capacities(model: MacroModel, loads: Array, V: Array | None) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield limit loads of paths, and the loads beyond each, in its direction (or the opposite) and at its V."""
    plane = loads / [1.0, model.length]
    size = np.hypot(*plane.T)
    directions = plane / np.where(size > 0.0, size, 1.0)[:, None]
    for end, along in limit_loads_along(model, directions, V):
        yield end, along & (size > np.hypot(end.H, end.M / model.length) * (1.0 + RANGE_SLACK))


def limit_loads_along(model: MacroModel, directions: Array, V: Array | None) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield limit loads of paths, the smallest last, and which directions (n, 2) in (H, M/L) are theirs, or opposite.

    V (n,) [N] is that of the directions; None: all are at the V of every path.
    """
    sizes = {name: float(np.hypot(e.H, e.M / model.length)) for name, e in model.ends.items() if e.how == LIMIT_LOAD}
    for name, size in sorted(sizes.items(), key=lambda pair: -pair[1]):
        end = model.ends[name]
        limit = np.array([end.H, end.M / model.length])
        if size > 0.0:
            (d0, d1), (H, M) = directions.T, limit / size  # sums by hand: a product of matrices rounds by its size
            along, across = np.abs(d0 * H + d1 * M), np.abs(d1 * H - d0 * M)
            same = (along > 0.0) & (across <= np.sin(SAME_DIRECTION) * np.hypot(along, across))
            yield end, same if V is None else same & _same(V, end.V)


def past_elastic(model: MacroModel, V: Array, elastic: Marks) -> tuple[Marks, list[str]]:
    """Return which vertical loads V (n,) [N] are beyond an elastic stiffness, of those it answers, and a sentence."""
    low, high = model.elastic_loads
    marks = elastic & ((low > V) | (high < V)) & ~_same(V, low) & ~_same(V, high)
    if not marks.any():
        return marks, []
    worst = V[marks][np.argmax(np.abs(V[marks]))]
    return marks, [
        f"V = {worst:.7g} N: without vertical springs in this direction V is known from {low:.7g} to {high:.7g} N "
        "(a change no larger than the vertical load of the paths): add a path of kind 'vertical'"
    ]


def _same(values: Array, other: float) -> Marks:
    return np.array([same_load(value, other) for value in values], dtype=bool)
