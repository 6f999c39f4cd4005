# SPDX-License-Identifier: MIT
"""Sets of paths at several rates or dead loads, and the paths between two sets.

The rate of a path is that of its state, v = rho/t at its end, with rho = |(u, rotation*L)| and L the skirt length: for
a path that keeps its direction this is constant. Paths within half a decade of each other are one set. Between two sets
every reaction is interpolated at the same state, linearly in log v,

    r(rho, v) = (1 - s) r_a(rho) + s r_b(rho),   s = log(v/v_a)/log(v_b/v_a),

so that the sums of reactions stay the loads, and the water stays a component of its own. (Pulls are compared at the
same u, and their rotation is interpolated too.) Consolidation under a ramp passes from drained to undrained over about
two decades of v; sets a decade apart follow it. Beyond the slowest and the fastest set nothing is extrapolated.
Vertical paths are sets of their own, by the rate of w.

A dead load presses lid and tip on the soil: it changes contact and friction, and with them every lateral reaction. The
vertical load of a path is V at its start. Lateral calibration paths of the same V are one set; the main set has the
vertical load of the scene. Between two sets every reaction is interpolated at the same state, linearly in V: s = (V -
V_a)/(V_b - V_a). Beyond the lightest and the heaviest set the nearest one answers, and the answer is marked.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import same_load
from pysprings.springs.path import TOGETHER, SpringPath, is_rate, same_way
from pysprings.springs.path_ends import KEYS, MESH_ERROR, earlier_end
from pysprings.springs.sums import secant_slopes

Agree = Callable[[SpringPath, SpringPath], bool]


@dataclass(frozen=True, slots=True)
class RateSet:
    """Calibration paths at one rate [m/s]: the geometric mean of theirs."""

    rate: float
    paths: tuple[str, ...]


class Between(NamedTuple):
    """Two sets that springs are interpolated between: their rates [m/s] or vertical loads [N], share of the second."""

    first: float
    second: float
    share: float


def rate_sets(paths: Iterable[SpringPath]) -> tuple[RateSet, ...]:
    """Return the sets of calibration paths, lateral or vertical ones, by rate, slowest first; none without a time."""
    timed = sorted((path.rate, path.name) for path in paths if path.rate is not None)
    groups: list[list[tuple[float, str]]] = []
    for rate, name in timed:
        if groups and rate < TOGETHER * groups[-1][-1][0]:
            groups[-1].append((rate, name))
        else:
            groups.append([(rate, name)])
    return tuple(RateSet(float(np.exp(np.mean([np.log(r) for r, _ in g]))), tuple(n for _, n in g)) for g in groups)


def at_rate(
    paths: Mapping[str, SpringPath], sets: Sequence[RateSet], rate: float
) -> tuple[dict[str, SpringPath], Between | None]:
    """Return the paths of sets at a rate [m/s], and what they lie between.

    They are those of the set at that rate (None), or between the two sets around it.

    Raises UserInputError: the rate is outside the range of the sets, or the two sets around it have no path in common.
    """
    for each in sets:
        if is_rate(rate, each.rate):
            return {name: paths[name] for name in each.paths}, None
    if not sets[0].rate < rate < sets[-1].rate:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in sets)
        raise refused("rate", f"{1e3 * rate:.4g} mm/s is outside the rates of the springs ({have} mm/s, of rho)")
    above = next(k for k, each in enumerate(sets) if each.rate > rate)
    slow, fast = sets[above - 1], sets[above]
    share = float(np.log(rate / slow.rate) / np.log(fast.rate / slow.rate))
    matches = pairs([paths[name] for name in slow.paths], [paths[name] for name in fast.paths], one_load)
    if not matches:
        between = f"{1e3 * slow.rate:.4g} and {1e3 * fast.rate:.4g} mm/s"
        raise refused("rate", f"the paths at {between} go in different directions: nothing to interpolate between")
    return {a.name: blend(a, b, share) for a, b in matches}, Between(slow.rate, fast.rate, share)


def blend(slow: SpringPath, fast: SpringPath, share: float) -> SpringPath:
    """Return (1 - share) slow + share fast at the states of the slow path that the fast one reaches too.

    On paths that keep their direction u, rotation and y are those of the slow path; on pulls u, on vertical paths w is.
    """
    unchanged = {"w" if slow.is_vertical else "u", "converged"} | ({"rotation", "y"} if slow.is_straight else set())
    way, other_way, whole = _way(slow), _way(fast), slow.dataset
    reached = np.flatnonzero(way <= other_way[-1] * (1.0 + 1e-9))
    out, way = whole if reached.size == way.size else whole.isel(step=reached), way[reached]
    data: dict[Hashable, NDArray[Any]] = {}
    for name in out.data_vars:
        values = out.variables[name]  # variables, not arrays with coordinates: a table of loads blends thousands
        data[name] = values.values
        if "step" in values.dims and name not in unchanged:
            other = fast.dataset.variables[name].transpose(*values.dims).values
            moved = _interpolated(way, other_way, other, values.dims.index("step"))
            data[name] = (1.0 - share) * values.values + share * moved
            if name == "time":  # the rate, too, between both in its logarithm
                data[name] = values.values ** (1.0 - share) * moved**share
    out = out.copy(data=data)
    out.attrs = {key: value for key, value in slow.attrs.items() if key not in KEYS}
    out.attrs |= earlier_end(out, whole, fast.dataset, fast.name)
    errors = [float(each.attrs.get(MESH_ERROR, np.nan)) for each in (slow, fast)]
    out.attrs |= {MESH_ERROR: float(np.fmax(errors[0], errors[1]))} if np.isfinite(errors).any() else {}
    return SpringPath(slow.name, out, slow.length)


def _interpolated(x: Array, known: Array, values: Array, axis: int) -> Array:
    """Return values at known points (k,) along an axis, at x (n,): cubic as a ray of a fan is, flat beyond."""
    grows = np.diff(np.maximum.accumulate(known), prepend=-np.inf) > 0.0
    given = np.moveaxis(values, axis, -1)[..., grows]
    points, rows = known[grows], given.reshape(-1, int(grows.sum()))
    slopes = secant_slopes(points, rows, (rows[:, 1] - rows[:, 0]) / points[1])
    k = np.clip(np.searchsorted(points, x, side="right") - 1, 0, points.size - 2)
    h = points[k + 1] - points[k]
    s = np.clip((x - points[k]) / h, 0.0, 1.0)
    step, first, last = (rows[:, k + 1] - rows[:, k]) / h, slopes[:, k], slopes[:, k + 1]
    moved = rows[:, k] + h * s * (first + s * (3.0 * step - 2.0 * first - last + s * (first + last - 2.0 * step)))
    return np.moveaxis(moved.reshape(*given.shape[:-1], x.size), -1, axis)


def _way(path: SpringPath) -> Array:
    """Return the distance (n,) that each step has come [m]: rho, |u| where the rotation is free, or that of w."""
    if path.is_vertical:
        return np.abs(path.w - path.w[0])
    return np.hypot(path.u, path.turn) if path.is_straight else np.abs(path.u)


def pairs(
    first: Sequence[SpringPath], second: Sequence[SpringPath], agree: Agree
) -> list[tuple[SpringPath, SpringPath]]:
    """Return the paths of two sets that go the same way and agree in something else, each once."""
    matches, free = [], list(second)
    for path in first:
        for other in free:
            if same_way(path, other) and agree(path, other):
                matches.append((path, other))
                free.remove(other)
                break
    return matches


def one_load(a: SpringPath, b: SpringPath) -> bool:
    """Return whether two paths have one vertical load."""
    return same_load(a.load, b.load)


def one_rate(a: SpringPath, b: SpringPath) -> bool:
    """Return whether two paths have one rate, or both none."""
    slow, fast = a.rate, b.rate
    return (slow is None) is (fast is None) and (not slow or not fast or 1.0 / TOGETHER < slow / fast < TOGETHER)


# Sets are interpolated where they have this many directions in common
FEWEST_PAIRS = 2
Paths = Mapping[str, SpringPath]


@dataclass(frozen=True, slots=True)
class LoadSet:
    """Lateral calibration paths at one vertical load [N]."""

    V: float
    paths: tuple[str, ...]


def load_sets(paths: Iterable[SpringPath]) -> tuple[LoadSet, ...]:
    """Return the sets of lateral calibration paths by vertical load, lightest first."""
    groups: list[tuple[float, list[str]]] = []
    for path in paths:
        own = [names for other, names in groups if same_load(path.load, other)]
        if own:
            own[0].append(path.name)
        else:
            groups.append((path.load, [path.name]))
    return tuple(LoadSet(V, tuple(names)) for V, names in sorted(groups, key=lambda group: group[0]))


def nearest(sets: Sequence[LoadSet], V: float) -> LoadSet:
    """Return the set whose vertical load is nearest to V [N]."""
    return min(sets, key=lambda each: abs(each.V - V))


def at_load(
    paths: Paths, sets: Sequence[LoadSet], main: LoadSet, V: float
) -> tuple[dict[str, SpringPath], Between | None]:
    """Return the lateral paths at a vertical load V [N], and what they lie between.

    They are those of the set at that load (None), between the two sets around it, or those of the nearest set (None).
    Only sets count that have the directions of the main one.
    """
    enough = min(FEWEST_PAIRS, len(main.paths))
    alike = [each for each in sets if each is main or len(_pairs(paths, main, each)) >= enough]
    near = nearest(alike, V)
    if same_load(near.V, V) or not alike[0].V < V < alike[-1].V:
        return {name: paths[name] for name in near.paths}, None
    above = next(k for k, each in enumerate(alike) if V < each.V)
    light, heavy = alike[above - 1], alike[above]
    share = (V - light.V) / (heavy.V - light.V)
    return {a.name: blend(a, b, share) for a, b in _pairs(paths, light, heavy)}, Between(light.V, heavy.V, share)


def _pairs(paths: Paths, first: LoadSet, second: LoadSet) -> list[tuple[SpringPath, SpringPath]]:
    return pairs([paths[name] for name in first.paths], [paths[name] for name in second.paths], one_rate)
