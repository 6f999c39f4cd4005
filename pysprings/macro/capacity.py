# SPDX-License-Identifier: MIT
"""The largest load that is known along the direction of a load: a limit load, or the end of what springs cover.

From the origin the loads H and M grow in proportion. The way is followed over the motion along the load,
s = (H u + M rotation)/|(H, M/L)|, so that it passes a peak of the load. It ends at the first of

- the calibrated range of the springs,
- the largest motion under a load, a share of the diameter or a rotation (`[limit]` of the scene),
- the last state with an equilibrium.

The largest load up to there is the capacity of the springs in this direction where it is a peak, where the motion is
the largest, or where the load has stopped growing: the stiffness along the way is gone (`GONE` of that at rest, as in
the full model), and the load grows by less than `FLAT` of the relative growth of the motion. In
sand 2 % of the stiffness at rest are left at half of the capacity (growth 0.2 to 0.4), in clay at 95 % of it (growth
below 0.1). Else the load is what is known, and the capacity is larger. A limit load of the full model in this direction
and at this vertical load comes first: beyond it the macro-model has no answer, nor beyond the range of springs whose
path met a limit load (`past_ends`). Where V is beyond the largest known vertical load, no H and M are known.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array, Integers, Marks, Texts
from pysprings.core.loads import close_loads, fewest_loads, nearest, same_loads
from pysprings.core.text import with_prefix
from pysprings.core.units import MOST_MOVED, MOST_TURNED
from pysprings.core.words import NOT_KNOWN, RANGE_END, SOLVED
from pysprings.macro.model import MacroModel
from pysprings.macro.response import Level
from pysprings.macro.solver import follow_ways
from pysprings.macro.vertical import covered, share_left
from pysprings.macro.vertical_answer import SLACK, Carrier, vertical_use
from pysprings.macro.ways import RANGE_SLACK
from pysprings.springs.path import SAME_DIRECTION
from pysprings.springs.path_ends import LIMIT_LOAD, STOPPED, PathEnd

GONE, FLAT = 0.02, 0.1
STEPS = 24
BISECTIONS = 24
LONGER = 3  # times a way is made four times as long where it stays within the range
ROUNDING = 1e-9  # share by which a load falls from its peak
ONE_WAY = 1e-12  # angles are rounded to it [rad]: loads in proportion have one way

FULL_LIMIT, SPRING_LIMIT = "limit load of the full model", "limit load of the springs"
LARGEST_MOTION = "largest motion"
NOT_AT_V = "of the springs, not at this V"  # that was asked for


@dataclass(frozen=True, slots=True)
class Capacities:
    """Largest known loads along n loads: H [N], M [N m], kind, words on where it comes from; share of it that is used.

    H, M and utilisation are NaN for a load of zero, and where the kind is `NOT_KNOWN`.
    """

    H: Array
    M: Array
    utilisation: Array
    kind: Texts
    source: Texts

    def attributes(self) -> dict[str, Any]:
        """Return the capacity along the last of the loads as attributes of an answer; none of no load, or of zero."""
        if not self.kind[-1:].any():
            return {}
        return {
            "capacity_H_N": float(self.H[-1]), "capacity_M_Nm": float(self.M[-1]),
            "capacity_kind": str(self.kind[-1]), "capacity_from": str(self.source[-1]),
        }  # fmt: skip


def capacities(model: MacroModel, loads: Array, V: Level = None) -> Capacities:
    """Return the largest known loads along loads (n, 2) = (H [N], M [N m]), at vertical loads V, one or (n,) [N].

    Where springs follow a V that changes they are those of the springs at each V, or within 10 % of it.
    """
    if model.whole is None or V is None or not model.response.follows(V):
        return _at_one_load(model, loads, V)
    down, own = np.broadcast_to(V, len(loads)), model.origin.load
    known = np.array([own, *fewest_loads(down, own)])
    place, parts, order = nearest(down, known), [], []
    for k in np.unique(place):
        rows, at = np.flatnonzero(place == k), model.under(float(known[k]))
        parts.append(_at_one_load(at, loads[rows], down[rows]))
        order.append(rows)
    back = np.argsort(np.concatenate(order))
    return Capacities(
        *(np.concatenate([getattr(part, each.name) for part in parts])[back] for each in fields(Capacities))
    )


def _at_one_load(model: MacroModel, loads: Array, V: Level) -> Capacities:
    """Return the largest known loads of springs at one vertical load: see `capacities`."""
    plane = loads / [1.0, model.length]
    size = np.hypot(*plane.T)
    loaded = np.flatnonzero(size > 0.0)
    out = Capacities(*np.full((3, len(loads)), np.nan), *np.full((2, len(loads)), "", dtype=object))
    if not loaded.size:
        return out
    down = None if V is None else np.broadcast_to(V, size.shape)[loaded]
    directions = plane[loaded] / size[loaded, None]
    angles, place = np.unique(_angles(directions), return_inverse=True)
    ends = _ends(model, np.stack([np.cos(angles), np.sin(angles)], axis=1))
    largest, out.kind[loaded], out.source[loaded] = (each[place] for each in ends)
    own = np.full(len(place), model.origin.load)
    for each, rows in limit_loads_along(model, directions, down):
        largest[rows] = np.hypot(each.H, each.M / model.length)
        own[rows] = each.V
        out.kind[loaded[rows]], out.source[loaded[rows]] = FULL_LIMIT, f"path '{each.path}' {each.words}"
    none = largest <= 0.0  # no load is known that far
    if down is not None:
        beyond = vertical_use(model, down)["utilisation_V"] > 1.0 + SLACK
        left = _left(model, down, own)
        largest *= np.nan_to_num(left, nan=1.0)
        for k in np.flatnonzero(left != 1.0):
            least = "may leave less: no path leads to it"
            words = f"leaves at least {100.0 * left[k]:.1f} %" if left[k] < 1.0 else least
            out.source[loaded[k]] += f"; at V of the springs, of which this V {words}"
        for k in np.flatnonzero(~covered(model.vertical, down, own) & ~same_loads(down, own)):
            out.source[loaded[k]] += f"; at V = {with_prefix(own[k], 'N')} {NOT_AT_V}"
        out.source[loaded[beyond]], none = "V is beyond the largest known vertical load", none | beyond
    largest[none], out.kind[loaded[none]] = np.nan, NOT_KNOWN
    out.H[loaded], out.M[loaded] = (directions * largest[:, None] * [1.0, model.length]).T
    out.utilisation[loaded] = size[loaded] / largest
    return out


def _left(model: MacroModel, V: Array, own: Array) -> Array:
    """Return the share (n,) of the largest loads at V `own` (n,) [N] that is known to be left at V (n,) [N] near it.

    1 at the same V, where the springs do not hold, which is marked, and where w is held; NaN where no path leads to V.
    """
    if not model.origin.free_to_heave:
        return np.ones(len(V))
    left = share_left(model.vertical, V, own)
    return np.where(covered(model.vertical, V, own), np.minimum(left, 1.0), 1.0)


def with_capacity(model: MacroModel, answer: xr.Dataset) -> xr.Dataset:
    """Return an answer (dimension step) with `utilisation`, and with the capacity along its last load as attributes."""
    loads = np.stack([answer["H"].values, answer["M"].values], axis=1)
    size = np.hypot(*(loads / [1.0, model.length]).T)
    loads[size <= SOLVED * size.max(initial=0.0)] = 0.0  # what the solver leaves of no load has no direction
    largest = capacities(model, loads, answer["V"].values if "V" in answer else None)
    answer = with_bound(model, answer, loads, largest.utilisation)
    share = np.where(largest.kind == "", 0.0, largest.utilisation)
    added = answer.assign(variables.described({"utilisation": share}, "prediction"))
    return added.assign_attrs(largest.attributes())


def with_bound(model: MacroModel, answer: xr.Dataset, loads: Array, utilisation: Array) -> xr.Dataset:
    """Return an answer to loads (n, 2); on springs of an atlas of clay its motion has wider deviations near collapse.

    A load that is a few per cent wrong there moves it by a multiple. `unbounded` marks where the motion has no bound.
    """
    states = np.stack([answer["u"].values, answer["rotation"].values], axis=1)
    factor = model.response.widening(states, loads, utilisation) if answer.attrs["control"] == "load" else None
    if factor is None:
        return answer
    factor = factor if model.attrs.get("drainage") == "total-stress" else np.ones(len(factor))
    motions = {name: answer[name] * factor for name in ("u_deviation", "rotation_deviation")}
    return answer.assign(motions | variables.described({"unbounded": np.isinf(factor).astype(np.int8)}, "prediction"))


def _angles(directions: Array) -> Array:
    """Return the angles of directions (n, 2), rounded: the way along a direction is that of its own rounded angle."""
    return np.round(np.arctan2(directions[:, 1], directions[:, 0]) / ONE_WAY) * ONE_WAY


@dataclass(frozen=True, slots=True)
class _Ways:
    """Ways along n unit directions d (n, 2) in (H, M/L), over s [m]: their equations for the solver."""

    model: MacroModel
    d: Array
    G: Array
    C: Array
    scale: Array

    @classmethod
    def along(cls, model: MacroModel, d: Array, reach: Array) -> Self:
        n, length, load = len(d), model.length, model.table.load_scale
        G, C = np.zeros((n, 2, 2)), np.zeros((n, 2, 2))
        G[:, 0, 0], G[:, 0, 1] = d[:, 0], d[:, 1] * length
        C[:, 1, 0], C[:, 1, 1] = -d[:, 1], d[:, 0] / length
        across = np.abs(d[:, 1]) * load[0] + np.abs(d[:, 0]) * load[1] / length
        return cls(model, d, G, C, np.stack([reach, across], axis=1))

    def follow(self, starts: Array, s: Array) -> tuple[Array, Array, Integers]:
        """Return states and loads (n, k, 2) at s (n, k) from states at the first s, and how many were reached (n,)."""
        aims = np.stack([s, np.zeros_like(s)], axis=-1)
        states, loads, reached = np.zeros(aims.shape), np.zeros(aims.shape), np.zeros(len(s), dtype=np.int64)
        with np.errstate(all="ignore"):
            follow_ways(self.model.response.arrays, self.G, self.C, self.scale, starts, aims, states, loads, reached)
        return states, loads, reached

    def along_load(self, loads: Array) -> Array:
        """Return the size [N] of loads (n, k, 2) along the directions."""
        return (loads / [1.0, self.model.length] * self.d[:, None, :]).sum(axis=-1)


def _ends(model: MacroModel, d: Array) -> tuple[Array, Texts, Texts]:
    """Return the largest loads (n,) [N] along directions (n, 2) in (H, M/L), their kinds, words on their origin."""
    reach = np.full(len(d), model.response.farthest())
    for _ in range(LONGER + 1):
        ways = _Ways.along(model, d, reach)
        s = reach[:, None] * np.linspace(0.0, 1.0, STEPS + 1) ** 1.5
        states, loads, reached = ways.follow(np.zeros((len(d), 2)), s)
        used = _used(model, states)
        used[np.arange(STEPS + 1) >= reached[:, None]] = np.inf
        inside = used[:, -1] <= 1.0 + RANGE_SLACK
        if not inside.any():
            break
        reach = np.where(inside, 4.0 * reach, reach)  # each way by itself
    outside = used > 1.0 + RANGE_SLACK
    beyond = np.where(outside.any(axis=1), np.maximum(outside.argmax(axis=1), 1), STEPS)
    rows = np.arange(len(d))
    low, high, state = s[rows, beyond - 1], s[rows, beyond], states[rows, beyond - 1]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        way, _, reached = ways.follow(state, np.stack([low, middle], axis=1))
        inside = (reached == 2) & (_used(model, way[:, 1:])[:, 0] <= 1.0 + RANGE_SLACK)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        state = np.where(inside[:, None], way[:, 1], state)
    last = np.array([model.reactions(*each)[0] for each in state])[:, None]
    size = ways.along_load(np.concatenate([loads, last], axis=1))
    size[:, :-1][np.arange(STEPS + 1) >= beyond[:, None]] = -np.inf
    return _named(ways, state, size)


def _named(ways: _Ways, state: Array, size: Array) -> tuple[Array, Texts, Texts]:
    """Return `_ends` of ways: last states (n, 2), and sizes of the load on the way (n, k), the last one at the end."""
    peak, end = size.max(axis=1), size[:, -1]
    moved = _moved(ways.model, state)
    left, growth = _stiffness_left(ways, state, end)
    kind, source = np.empty(len(end), dtype=object), np.empty(len(end), dtype=object)
    for i, (u, rotation) in enumerate(state):
        at = f"at u = {u:.4g} m, rotation = {rotation:.4g} rad"
        names = ways.model.response.paths_at(state[i : i + 1])[0]
        from_ = _origin(names)
        if peak[i] > end[i] * (1.0 + ROUNDING):
            kind[i], source[i] = SPRING_LIMIT, f"the load falls before the springs of {from_} end"
        elif moved[i] > 1.0 - 1e-3:
            kind[i] = LARGEST_MOTION
            share, turn = _largest(ways.model)
            source[i] = f"{100 * share:g} % of the diameter or {np.degrees(turn):g} deg {at}; {from_}"
        elif left[i] < GONE and growth[i] < FLAT:
            kind[i] = SPRING_LIMIT
            source[i] = f"{100.0 * max(left[i], 0.0):.2g} % of the initial stiffness is left {at}; {from_}"
        else:
            kind[i] = RANGE_END
            source[i] = f"{from_}, {at}; {100.0 * left[i]:.2g} % of the initial stiffness is left: more is not known"
            stops = [each for name in names if (each := ways.model.ends.get(name)) and each.how == STOPPED]
            source[i] += "".join(f"; path '{each.path}' stopped: {each.reason}" for each in stops)
    return peak, kind, source


def _used(model: MacroModel, states: Array) -> Array:
    """Return how much of the range, or of the largest motion, states (n, k, 2) use; 1 is all."""
    flat = states.reshape(-1, 2)
    return np.fmax(model.response.range_used(flat), _moved(model, flat)).reshape(states.shape[:2])


def _moved(model: MacroModel, states: Array) -> Array:
    """Return the share of the largest motion of states (n, 2); of the rotation alone where no diameter is known."""
    u, rotation = states.T
    diameter = float(model.attrs.get("outer_diameter_m", np.inf))
    share, turn = _largest(model)
    shift = np.fmax(np.abs(u), np.abs(u - rotation * model.length)) / (share * diameter)
    return np.fmax(shift, np.abs(rotation) / turn)


def _largest(model: MacroModel) -> tuple[float, float]:
    """Return the largest displacement over the diameter and the largest rotation (rad): `[limit]` of the scene."""
    share = model.attrs.get("limit_displacement_over_diameter", MOST_MOVED)
    return float(share), float(model.attrs.get("limit_rotation_rad", MOST_TURNED))


def _stiffness_left(ways: _Ways, state: Array, size: Array) -> tuple[Array, Array]:
    """Return the stiffness along the ways at their last states (n, 2), over that at rest, and over the secant there.

    size (n,) [N] is the load along the way. The second is the relative growth of the load over that of the motion.
    """
    scale = np.array([1.0, ways.model.length])
    d0, d1 = ways.d.T
    flexibility = []
    for states in (np.zeros_like(state), state):
        K = np.array([ways.model.reactions(*each)[1] for each in states]) / np.outer(scale, scale)
        work = K[:, 1, 1] * d0**2 - (K[:, 0, 1] + K[:, 1, 0]) * d0 * d1 + K[:, 0, 0] * d1**2  # d . K^-1 d * det K
        flexibility.append(np.stack([work, K[:, 0, 0] * K[:, 1, 1] - K[:, 0, 1] * K[:, 1, 0]]))
    (first, det_first), (last, det_last) = flexibility
    motion = (ways.d * state * scale).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        left: Array = np.nan_to_num(first * det_last / (det_first * last), nan=0.0)
        growth: Array = np.nan_to_num(det_last / last * motion / size, nan=0.0)
    return left, growth


def _origin(names: Sequence[str]) -> str:
    """Return words for the paths that the springs at a state come from."""
    return ("paths " if len(names) > 1 else "path ") + " and ".join(f"'{name}'" for name in names)


def past_ends(
    model: MacroModel, states: Array, used: Array, loads: Array, V: Array | None, aim: Array | None = None
) -> tuple[Marks, list[str]]:
    """Return which states (n, 2) = (u, rotation) are beyond a limit load, and a sentence on each such path.

    used (n,) is the range that the lateral springs use, loads (n, 2) = (H, M), V (n,) [N] the vertical load, aim
    (H, M) the load behind the last state that the springs did not carry (None: all were).
    """
    n = len(states)
    if aim is not None:
        loads, V = np.vstack([loads, aim]), np.append(V, V[-1:]) if V is not None and V.size else None
    marks, texts = past_limits(model, loads, V, _ranges(model, states, used))
    return marks[:n], texts


def past_limits(
    model: Carrier, loads: Array, V: Array | None, more: Iterable[tuple[PathEnd, Marks]] = ()
) -> tuple[Marks, list[str]]:
    """Return which loads (n, 2) = (H, M) at V (n,) [N] are beyond a limit load, and a sentence on each such path.

    more : further ends of paths, and the states beyond each, the first ones of the loads.
    """
    marks, ends = np.zeros(len(loads), dtype=bool), dict[str, str]()
    down = {} if model.vertical is None else {branch.path: branch.largest for branch in model.vertical.branches}
    for end, beyond in (*more, *_capacities(model, loads, V), *_vertical_ends(model, V)):
        if beyond.any():
            marks[: len(beyond)] |= beyond
            at = f", at V = {with_prefix(down[end.path], 'N')}" if end.path in down else ""
            ends[end.path] = f"{end}{at}"
    return marks, [f"the answer is beyond what the full model carried: {words}" for words in ends.values()]


def _ranges(model: MacroModel, states: Array, used: Array) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield the limit loads of paths that the springs come from, and the states beyond the range of each."""
    over = used > 1.0 + RANGE_SLACK
    failed = [end for name in model.response.sources if (end := model.ends[name]).how == LIMIT_LOAD]
    if not failed or not over.any():
        return
    yield from model.response.beyond(failed, states, over)


def _vertical_ends(model: Carrier, V: Array | None) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield the limit loads of vertical paths, and the vertical loads (n,) [N] beyond each."""
    if V is None or model.vertical is None:
        return
    for branch in model.vertical.branches:
        if (end := model.ends[branch.path]).how == LIMIT_LOAD:
            over: Marks = branch.sign * (V - branch.largest) > RANGE_SLACK * abs(branch.largest)
            yield end, over


def _capacities(model: Carrier, loads: Array, V: Array | None) -> Iterator[tuple[PathEnd, Marks]]:
    """Yield limit loads of paths, and the loads beyond each, in its direction (or the opposite) and at its V."""
    plane = loads / [1.0, model.length]
    size = np.hypot(*plane.T)
    directions = plane / np.where(size > 0.0, size, 1.0)[:, None]
    for end, along in limit_loads_along(model, directions, V):
        yield end, along & (size > np.hypot(end.H, end.M / model.length) * (1.0 + RANGE_SLACK))


def limit_loads_along(model: Carrier, directions: Array, V: Array | None) -> Iterator[tuple[PathEnd, Marks]]:
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
            yield end, same if V is None else same & close_loads(V, end.V)
