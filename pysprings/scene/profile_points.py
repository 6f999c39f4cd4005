# SPDX-License-Identifier: MIT
"""Points by depth -> layers that are linear between them; points on a straight line make one layer."""

import itertools
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pysprings.core.tables import Table, TableNote
from pysprings.scene.ranges import is_range

Array = NDArray[np.float64]

SAME = 1.0e-6  # m: depths closer than that are the same
_STRAIGHT = 1.0e-9  # share of a value by which a point may be off the straight line through its neighbours


def between(table: Table, points: list[dict[str, Any]], depth: Array) -> tuple[list[dict[str, Any]], Any]:
    """Return the layers between points, linear, and their ends; the first value holds up to mudline."""
    for k in np.flatnonzero(np.diff(depth) < 0.0).tolist():
        table.fault(k + 1, "depth", "is above the point before: depths of points grow")
    layers: list[dict[str, Any]] = []
    spans: list[tuple[float, float]] = []
    for k, (above, below) in enumerate(itertools.pairwise(points)):
        if depth[k + 1] - depth[k] <= SAME:
            continue
        layer = {name: value for name, value in above.items() if name in ("name", "law")}
        for name in dict.fromkeys([*above, *below]):
            if (name in above) != (name in below) and name not in ("name", "law"):
                where = k + 1 if name in above else k
                table.fault(where, name, "blank, and not at the next point: write two points at a layer boundary")
            elif name not in ("name", "law"):
                layer[name] = _line(above[name], below[name])
        if layers and spans[-1][1] == depth[k] and _is_straight(layers[-1], layer, spans[-1], float(depth[k + 1])):
            for one, other in zip(_values(layers[-1]).values(), _values(layer).values(), strict=True):
                if isinstance(other, dict):
                    one["bottom"] = other["bottom"]
            spans[-1] = (spans[-1][0], float(depth[k + 1]))
        else:
            layers.append(layer)
            spans.append((float(depth[k]), float(depth[k + 1])))
    table.faults.stop()
    if not layers:
        table.fault(None, "depth", "needs two points at least")
        table.faults.stop()
    if spans[0][0] > 0.0:
        what = f"{table.place}: the values of the first point, at {spans[0][0]:g} m, hold up to mudline"
        warnings.warn(what, TableNote, stacklevel=2)
        first = {name: points[0].get(name, value) for name, value in layers[0].items()}
        layers.insert(0, first)
        spans.insert(0, (0.0, spans[0][0]))
    return layers, tuple(np.array(spans).T)


def _line(above: Any, below: Any) -> Any:
    """Return what is linear between two values, or between those of each estimate of a range."""
    if is_range(above) and is_range(below):
        return {each: _line(above.get(each), below.get(each)) for each in above}
    return above if above == below else {"top": above, "bottom": below}


def _values(layer: dict[str, Any]) -> dict[tuple[str, str], Any]:
    """Return the values of a layer by key and estimate, which is blank where there is no range."""
    ranges = {name: value if is_range(value) else {"": value} for name, value in layer.items()}
    return {(name, estimate): value for name, inner in ranges.items() for estimate, value in inner.items()}


def _is_straight(one: dict[str, Any], other: dict[str, Any], span: tuple[float, float], end: float) -> bool:
    """Return whether a layer goes on in the line of the one above it."""
    above, below = _values(one), _values(other)
    if above.keys() != below.keys():
        return False
    for name, value in above.items():
        next_value = below[name]
        if isinstance(value, dict) != isinstance(next_value, dict):
            return False
        if not isinstance(value, dict):
            if value != next_value:
                return False
            continue
        top, middle, bottom = (_size(each) for each in (value["top"], value["bottom"], next_value["bottom"]))
        line = top + (bottom - top) * (span[1] - span[0]) / (end - span[0])
        if _size(next_value["top"]) != middle or abs(line - middle) > _STRAIGHT * max(abs(top), abs(bottom)):
            return False
    return True


def _size(value: float | str) -> float:
    return float(value.split()[0]) if isinstance(value, str) else value
