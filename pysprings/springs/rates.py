# SPDX-License-Identifier: MIT
"""Springs at a rate: sets of paths at several rates, and what lies between them.

The rate of a path is that of its state, v = rho/t at its end, with rho = |(u, rotation*L)| and L the skirt length: for
a path that keeps its direction this is constant. Paths within half a decade of each other are one set. Between two sets
every reaction is interpolated at the same state, linearly in log v,

    r(rho, v) = (1 - s) r_a(rho) + s r_b(rho),   s = log(v/v_a)/log(v_b/v_a),

so that the sums of reactions stay the loads, and the water stays a component of its own. (Pulls are compared at the
same u, and their rotation is interpolated too.) Consolidation under a ramp passes from drained to undrained over about
two decades of v; sets a decade apart follow it. Beyond the slowest and the fastest set nothing is extrapolated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.path_kinds import is_straight
from pysprings.springs.alike import same_load
from pysprings.springs.checks import validate_springs
from pysprings.springs.dataset import get_path, is_vertical, path_load, path_names
from pysprings.springs.path_ends import KEYS, earlier_end

# Paths whose rates differ by less than this factor belong together
TOGETHER = 10.0**0.5
# Rates this close to a set's are that set's
CLOSE = 1.05
# Paths within this angle [rad] go in the same direction
_SAME_DIRECTION = np.radians(1.0)


@dataclass(frozen=True, slots=True)
class RateSet:
    """Calibration paths at one rate [m/s]: the geometric mean of theirs."""

    rate: float
    paths: tuple[str, ...]


def path_rate(path: xr.Dataset, length: float) -> float | None:
    """Return the rate rho/t of a path at its end [m/s]; None where it has no time."""
    if "time" not in path or not float(path["time"][-1]) > 0.0:
        return None
    rho = float(np.hypot(path["u"][-1], float(path["rotation"][-1]) * length))
    return rho / float(path["time"][-1]) if rho > 0.0 else None


def rate_sets(springs: xr.DataTree) -> list[RateSet]:
    """Return the sets of calibration paths by rate, slowest first; none where no path has a time."""
    length = float(springs.attrs["skirt_length_m"])
    names = [name for name in path_names(springs, "calibration") if not is_vertical(springs, name)]
    found = [(path_rate(get_path(springs, name), length), name) for name in names]
    timed = sorted((rate, name) for rate, name in found if rate is not None)
    groups: list[list[tuple[float, str]]] = []
    for rate, name in timed:
        if groups and rate < TOGETHER * groups[-1][-1][0]:
            groups[-1].append((rate, name))
        else:
            groups.append([(rate, name)])
    return [RateSet(float(np.exp(np.mean([np.log(r) for r, _ in g]))), tuple(n for _, n in g)) for g in groups]


def for_path(springs: xr.DataTree, path: xr.Dataset) -> xr.DataTree:
    """Return the springs that answer a path of the same run: at its rate, where calibration knows several.

    A calibration path is answered by its own set; a path beyond the slowest or fastest set by that one.
    """
    sets = rate_sets(springs) if springs.attrs.get("drainage") == "coupled" else []
    if len(sets) < 2:
        return springs
    own = [each for each in sets if path.attrs.get("path") in each.paths]
    rate = path_rate(path, float(springs.attrs["skirt_length_m"])) or sets[0].rate
    return at_rate(springs, own[0].rate if own else min(max(rate, sets[0].rate), sets[-1].rate))


def at_rate(springs: xr.DataTree, rate: float) -> xr.DataTree:
    """Return springs at a rate [m/s]: those of the set at that rate, or between the two sets around it.

    Raises
    ------
    UserInputError
        The springs are drained or have no times, the rate is outside the range of the sets, or the two sets around
        it have no path in common.
    """
    sets = rate_sets(springs)
    if springs.attrs.get("drainage") != "coupled" or not sets:
        raise _refused(f"the springs are {springs.attrs.get('drainage')}: they do not depend on a rate")
    for each in sets:
        if max(rate / each.rate, each.rate / rate) <= CLOSE:
            return _tree(springs, {name: get_path(springs, name) for name in each.paths}, rate)
    if not sets[0].rate < rate < sets[-1].rate:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in sets)
        raise _refused(f"{1e3 * rate:.4g} mm/s is outside the rates of the springs ({have} mm/s, of rho)")
    above = next(k for k, each in enumerate(sets) if each.rate > rate)
    slow, fast = sets[above - 1], sets[above]
    share = float(np.log(rate / slow.rate) / np.log(fast.rate / slow.rate))
    length = float(springs.attrs["skirt_length_m"])
    found = pairs(springs, slow.paths, fast.paths, length)
    if not found:
        between = f"{1e3 * slow.rate:.4g} and {1e3 * fast.rate:.4g} mm/s"
        raise _refused(f"the paths at {between} go in different directions: nothing to interpolate between")
    blended = {a: blend(get_path(springs, a), get_path(springs, b), share, length) for a, b in found}
    return _tree(springs, blended, rate)


def blend(slow: xr.Dataset, fast: xr.Dataset, share: float, length: float) -> xr.Dataset:
    """Return (1 - share) slow + share fast at the states of the slow path that the fast one reaches too.

    On paths that keep their direction u, rotation and y are those of the slow path; on pulls u is.
    """
    way, kept = _way(slow, length), {"u", "converged"}
    if _is_straight(slow):
        kept |= {"rotation", "y"}
    other_way = _way(fast, length)
    out = slow.isel(step=np.flatnonzero(way <= other_way[-1] * (1.0 + 1e-9)))
    way = _way(out, length)
    for name, values in out.data_vars.items():
        if "step" not in values.dims or name in kept:
            continue
        axis = values.dims.index("step")
        other = fast[name].transpose(*values.dims).values
        moved = np.apply_along_axis(lambda column: np.interp(way, other_way, column), axis, other)
        out[name] = values.copy(data=(1.0 - share) * values.values + share * moved)
    out.attrs = {key: value for key, value in slow.attrs.items() if key not in KEYS} | earlier_end(out, slow, fast)
    return out


def _is_straight(path: xr.Dataset) -> bool:
    """Tell whether a path keeps its direction: by its kind, or as a table has been found to do."""
    return is_straight(path.attrs)


def _way(path: xr.Dataset, length: float) -> np.ndarray:
    """How far each step of a path has come [m]: rho, or |u| where the rotation is free."""
    u = path["u"].values
    return np.hypot(u, path["rotation"].values * length) if _is_straight(path) else np.abs(u)


def pairs(
    springs: xr.DataTree, first: tuple[str, ...], second: tuple[str, ...], length: float, by_load: bool = False
) -> list[tuple[str, str]]:
    """Return the paths of two sets that go the same way, each once.

    They differ in their rate and have one vertical load; by_load: they differ in that and have one rate.
    """
    agree = _one_rate if by_load else _one_load
    found, free = [], list(second)
    for name in first:
        path = get_path(springs, name)
        for other in free:
            partner = get_path(springs, other)
            if _go_together(path, partner, length) and agree(path, partner, length):
                found.append((name, other))
                free.remove(other)
                break
    return found


def _one_load(a: xr.Dataset, b: xr.Dataset, _length: float) -> bool:
    return same_load(path_load(a), path_load(b))


def _one_rate(a: xr.Dataset, b: xr.Dataset, length: float) -> bool:
    slow, fast = path_rate(a, length), path_rate(b, length)
    return (slow is None) is (fast is None) and (not slow or not fast or 1.0 / TOGETHER < slow / fast < TOGETHER)


def _go_together(a: xr.Dataset, b: xr.Dataset, length: float) -> bool:
    arms = [float(path.attrs["arm_m"]) for path in (a, b)]
    if a.attrs["kind"] != b.attrs["kind"] or not np.array_equal(arms[:1], arms[1:], equal_nan=True):
        return False
    if not (_is_straight(a) and _is_straight(b)):
        return bool(np.sign(a["u"][-1]) == np.sign(b["u"][-1]))
    ways = (np.arctan2(float(path["rotation"][-1]) * length, float(path["u"][-1])) for path in (a, b))
    return abs(next(ways) - next(ways)) < _SAME_DIRECTION


def _tree(springs: xr.DataTree, paths: dict[str, xr.Dataset], rate: float) -> xr.DataTree:
    root = springs.to_dataset(inherit=False)
    root.attrs = {**springs.attrs, "rate_m_per_s": rate}
    groups: dict[str, xr.Dataset] = {"/": root}
    down = {name: get_path(springs, name) for name in path_names(springs, "calibration") if is_vertical(springs, name)}
    for name, path in (paths | down).items():  # vertical springs have the rate of their own path
        kept = path.copy()
        kept.attrs = {key: value for key, value in path.attrs.items() if key != "path"}
        groups[f"/paths/{name}"] = kept
    tree = xr.DataTree.from_dict(groups, name="springs")
    validate_springs(tree, balanced=False)  # as balanced as what it is made of
    return tree


def _refused(message: str) -> UserInputError:
    return UserInputError([Problem(key="rate", message=message)])
