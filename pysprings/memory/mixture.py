# SPDX-License-Identifier: MIT
"""Sets of elements together: at a vertical load or a rate between those with rays that turn back, and under changing V.

Each set follows the whole motion and carries a share of its loads,

    F = sum_i s_i F_i(q),   s_i >= 0,   sum_i s_i = 1,

as a fan is interpolated: linear in V, or in the logarithm of the rate (`pysprings.springs.path_sets`). This is a set of
elements in parallel like each of them: no closed way gives work.

A V that changes yields the soil, too, and takes away a part of what elements that yield carry laterally: while V
changes by dV, an element that carries x times its limit keeps of that

    exp(-x^8 |dV|/V_virgin)  where V is larger than ever before (virgin loading),   exp(-x^8 |dV|/V_reload)  else.

Under a motion that is held the load relaxes by that; under a load that is held the caisson moves on. V_virgin and
V_reload are fitted to rays on which V changes. Reversible elements, which keep nothing, do not relax. Where V has been
before the soil has yielded, and nothing is taken again: the range of these V shrinks to V by exp(-s/(RENEWED reach)),
as new soil yields; s is the lateral way, less what is elastic with the stiffness at rest.

Shares follow V at once where the elements then carry less. Where they carry more, the soil has the strength but a
motion has to mobilise it: they approach those at V by exp(-s/(LAG reach)). Without both, V to and fro under a held load
moves the springs on without end, and a V that changes gives loads that no motion has called for.

At a constant V nothing of this acts, and no closed way gives work; what the work of V does to a way on which V changes
is not counted.

Lateral reactions at a V are those of the sets by their shares; vertical ones and w change by the changes of those of
the sets, each times its share at the time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.core.loads import same_loads
from pysprings.macro.solver import Drive
from pysprings.memory.calibration import ElementSet
from pysprings.memory.elements import SHORTEST, STATES, advance, follow, relax
from pysprings.memory.offered import scaled
from pysprings.memory.shares import Shares, elastic_of, stiffnesses, ways_of
from pysprings.memory.water import Water

PARTS = 60  # steps in which V passes the range of the loads; a part of it has that times the root of its share
LAG, RENEWED = 0.05, 0.1  # ways over the reach: strength at another V is mobilised, and what V took it can take again
CLOSE = 1e-6  # of the range of the loads: the strength is that at V
FIRST, WIDEST = (1.0, 4.0), 1e3  # V_virgin and V_reload where a fit starts, and their largest value, over that range


def mixed(parts: Sequence[tuple[ElementSet, float]]) -> ElementSet:
    """Return one set that carries the loads and reactions of sets, each times its share."""
    parts = [(each, share) for each, share in parts if share > 0.0]
    if len(parts) == 1:
        return parts[0][0]
    sets = [each for each, _ in parts]
    errors = {name: error for each in sets for name, error in each.errors.items()}
    rows = np.concatenate([scaled(each.rows, share) for each, share in parts])
    reach, way = (min(getattr(each, name) for each in sets) for name in ("reach", "way"))
    return ElementSet(rows, reach, _shares(parts), max(each.residual for each in sets), errors, way)


def shares_at(V: Array, loads: Array) -> Array:
    """Return the shares (n, k) at vertical loads V (n,) [N] of sets at loads (k,); beyond them that of the nearest."""
    return np.stack([np.interp(V, loads, row) for row in np.eye(len(loads))], axis=-1)


def _shares(parts: Sequence[tuple[ElementSet, float]]) -> Shares:
    """Return the shares of the reactions of sets together.

    R = sum s_i (S_i F_i + D_i e_i) with one S = sum s_i S_i for all: what is missing, s_i (S_i - S) F_i, goes into D.
    """
    S = sum(share * each.shares.loads for each, share in parts)
    elastic, ways, stored, growth = [], [], [], []
    for each, share in parts:
        own, n = each.shares, len(each.rows)
        missing = np.einsum("ra,kab->rkb", own.loads - S, stiffnesses(each.rows))
        elastic.append(share * (own.elastic + missing.reshape(len(missing), 2 * n)))
        ways.append(share * own.even[:, :n])
        stored.append(share * own.even[:, n:])
        growth.append(np.broadcast_to(own.growth, n))
    first = parts[0][0].shares
    rest = sum(share * each.shares.rest for each, share in parts)
    even = np.concatenate([*ways, *stored], axis=1)
    water = _water([(each.shares.water, share) for each, share in parts if each.shares.water])
    return Shares(first.odd, np.asarray(rest), np.asarray(S), np.hstack(elastic), even, np.concatenate(growth), water)


def _water(parts: Sequence[tuple[Water, float]]) -> Water | None:
    """Return the water of sets together, each with its own elements and times; None where they have none."""
    if not parts:
        return None
    factors = np.concatenate([share * each.factors for each, share in parts], axis=2)
    return Water(factors, np.concatenate([each.times for each, _ in parts], axis=1))


class Past(NamedTuple):
    """What elements keep of a V that changes, all in [N].

    V : now. top : the largest so far. low, high : V between them takes nothing again. mobilised : V of the shares.
    """

    V: float
    top: float
    low: float
    high: float
    mobilised: float

    @classmethod
    def at(cls, V: float) -> "Past":
        """Return that of a V that has not changed."""
        return cls(V, V, V, V, V)

    @property
    def still(self) -> bool:
        """Whether V has not changed."""
        return self.low == self.high == self.mobilised


@dataclass(frozen=True, eq=False)
class ChangingLoad:
    """Elements at several vertical loads, and how a V that changes takes away what they carry.

    loads : (k,) V [N], increasing. sets : elements at each. virgin, reloading : V_virgin and V_reload [N].
    """

    loads: Array
    sets: tuple[ElementSet, ...]
    virgin: float
    reloading: float

    @cached_property
    def rows(self) -> Array:
        """Elements of all sets (n, COLUMNS), each with its own stiffness."""
        return np.concatenate([each.rows for each in self.sets])

    @property
    def largest(self) -> float:
        """Largest step of a motion [m]."""
        return min(each.largest for each in self.sets)

    def covers(self, V: Array) -> Marks:
        """Return whether vertical loads (n,) [N] lie within those of the sets."""
        low, high = self.loads[[0, -1]]
        return ((low <= V) & (high >= V)) | same_loads(V, low) | same_loads(V, high)

    def rows_at(self, V: float) -> Array:
        """Return the elements of all sets (n, COLUMNS) with the stiffness of their shares at V [N]."""
        if V not in self._made:
            while len(self._made) > 1:
                self._made.pop(next(iter(self._made)))
            shares = shares_at(np.array([V]), self.loads)[0]
            self._made[V] = scaled(self.rows, np.repeat(shares, [len(each.rows) for each in self.sets]))
        return self._made[V]

    @cached_property
    def _made(self) -> dict[float, Array]:
        """The last two answers of `rows_at`."""
        return {}

    def follow(self, drive: Drive, aims: Array, V: Array) -> tuple[Array, Array, tuple[float, float]]:
        """Follow aims (n, 2) of the equations of `drive` under V (n,) [N] from rest at the first V.

        Returns motions (k, 2) = (u, rotation L) [m], loads (k, 2) = (H, M/L) [N], and the right side where it ended.
        """
        motions, loads, past = np.zeros(aims.shape), np.zeros(aims.shape), Past.at(float(V[0]))
        q, last, states = np.zeros(2), np.zeros(2), np.zeros((len(self.rows), STATES))
        for k, load in enumerate(V.tolist()):
            q, carried, at, past = self.step(drive, q, states, np.stack([last, aims[k]]), past, load)
            if carried is None:
                return motions[:k], loads[:k], at
            motions[k], loads[k], last = q, carried, aims[k]
        return motions, loads, (float(last[0]), float(last[1]))

    def step(
        self, drive: Drive, q: Array, states: Array, way: Array, past: Past, V: float
    ) -> tuple[Array, Array | None, tuple[float, float], Past]:
        """Go from a right side of the equations of `drive` to another, way (2, 2), from states at a motion q (2,) [m].

        Returns motion [m] and load [N] (None: not reached), the right side where it ended, and the past there; changes
        the states. Parts of the way are halved until the shares change little with the motion of one.
        """
        found, carried, last, start = np.zeros((2, 2)), np.zeros((2, 2)), way[0], past.V
        done, width = 0.0, 1.0 / self._parts(start, V)
        while done < 1.0:
            part = min(1.0, done + width) if done + 1.5 * width < 1.0 else 1.0
            trial, aims = states.copy(), np.stack([last, way[0] + part * (way[1] - way[0])])
            now = self._changed(past, V if part == 1.0 else start + part * (V - start), trial, q)
            before = carried[1] if now.still else self._carried(now.mobilised, trial, q)
            n, at = follow(self.rows_at(now.mobilised), drive, self.largest, q, trial, aims, found, carried)
            moved = float(np.hypot(*(found[1] - q))) if n == len(aims) else np.inf
            if now.mobilised != now.V and moved > 0.5 * self.largest and width > SHORTEST:
                width *= 0.5
            elif n == len(aims):
                past = self._moved(now, found[1] - q, carried[1] - before)
                states[:], q, last, done = trial, found[1].copy(), aims[1], part
            elif past.mobilised == now.mobilised != now.V:  # it moves until the strength at V is mobilised
                past = past._replace(mobilised=now.V)
            else:
                return q, None, (at[0], at[1]), past
        return q, carried[1], (float(last[0]), float(last[1])), past

    def changed(self, past: Past, V: float, states: Array, q: Array) -> Past:
        """Change V [N] at a held motion q (2,) [m]: returns the past there; takes from the states what that takes."""
        for load in np.linspace(past.V, V, self._parts(past.V, V) + 1)[1:].tolist():
            past = self._changed(past, load, states, q)
        return past

    def _parts(self, start: float, end: float) -> int:
        """Return in how many steps V [N] changes."""
        if start == end:
            return 1
        return int(np.ceil(np.sqrt(abs(end - start) / (self.loads[-1] - self.loads[0])) * PARTS))

    def _changed(self, past: Past, V: float, states: Array, q: Array) -> Past:
        """Change V [N] by one step, as `changed`."""
        if past.V == V:
            return past
        fresh = max(V - past.high, past.low - V, 0.0)
        relax(self.rows, states, q, fresh / (self.virgin if past.top < V else self.reloading))
        before, now = (self._carried(load, states, q) for load in (past.mobilised, V))
        weaker = now @ before <= before @ before
        low, high = min(past.low, V), max(past.high, V)
        return Past(V, max(past.top, V), low, high, V if weaker else past.mobilised)

    def _carried(self, V: float, states: Array, q: Array) -> Array:
        """Return what elements in states at a motion q (2,) [m] carry (2,) [N] with the shares at V [N]."""
        F = np.zeros(2)
        advance(self.rows_at(V), q, q, states.copy(), F, np.zeros((2, 2)))
        return F

    def _moved(self, past: Past, motion: Array, change: Array) -> Past:
        """Return the past after a motion (2,) [m] at its V, on which the load changes by `change` (2,) [N]."""
        if past.still:
            return past
        V, way = past.V, float(np.hypot(*(motion - self._flexibility @ change)))
        reach = min(each.reach for each in self.sets)
        lagging, closed = (np.exp(-way / (share * reach)) for share in (LAG, RENEWED))
        mobilised = V + lagging * (past.mobilised - V)
        near = abs(mobilised - V) <= CLOSE * (self.loads[-1] - self.loads[0])
        low, high = (float(V + closed * (load - V)) for load in (past.low, past.high))
        return Past(V, past.top, low, high, V if near else float(mobilised))

    @cached_property
    def _flexibility(self) -> Array:
        """Flexibility at rest (2, 2) [m/N], at the first of the loads."""
        return np.asarray(np.linalg.inv(stiffnesses(self.rows_at(float(self.loads[0]))).sum(axis=0)))

    def loads_along(self, motions: Array, V: Array) -> Array:
        """Return the loads (n, 2) = (H, M/L) [N] along motions (n, 2) [m] from rest under V (n,) [N]."""
        return np.array([F.copy() for _, _, F, _, _ in self._along(motions, V)])

    def tangents(self, motions: Array, V: Array) -> Array:
        """Return the tangents (n, 2, 2) [N/m] along motions (n, 2) [m] from rest under V (n,) [N]."""
        return np.array([K.copy() for _, _, _, K, _ in self._along(motions, V)])

    def reactions(self, motions: Array, V: Array) -> Array:
        """Return all reactions (rows, n) along motions (n, 2) [m] from rest under V (n,) [N]."""
        way = [(*self.elastic(states, q), past.mobilised) for q, states, _, _, past in self._along(motions, V)]
        e, p, mobilised = (np.stack(parts) for parts in zip(*way, strict=True))
        rows = self.by_set(e, p)
        changes = np.diff(rows, axis=2, prepend=0.0).transpose(1, 2, 0) * shares_at(mobilised, self.loads)
        return np.where(self.odd[:, None], self.mixed(rows, mobilised), changes.sum(axis=2).cumsum(axis=1))

    def _along(self, motions: Array, V: Array) -> Iterator[tuple[Array, Array, Array, Array, Past]]:
        """Yield motion, states, loads (2,), tangent (2, 2), past at motions (n, 2) under V (n,), in the same arrays."""
        q, states, F, K = np.zeros(2), np.zeros((len(self.rows), STATES)), np.zeros(2), np.zeros((2, 2))
        past = Past.at(float(V[0]))
        for motion, end in zip(motions, V.tolist(), strict=True):
            start, parts = q, self._parts(past.V, end)
            for part, at in enumerate(np.linspace(past.V, end, parts + 1)[1:].tolist(), 1):
                past = self._changed(past, at, states, q)
                way = start + part / parts * (motion - start) - q
                step = self.largest * (1.0 if past.mobilised == past.V else 0.5)
                n = max(1, int(np.ceil(np.hypot(*way) / step)))
                for _ in range(n):
                    load = F if past.still else self._carried(past.mobilised, states, q)
                    before, q = q, q + way / n
                    advance(self.rows_at(past.mobilised), before, q, states, F, K)
                    past = self._moved(past, way / n, F - load)
            yield q, states, F, K, past

    @property
    def odd(self) -> Marks:
        """Which reactions (rows,) change their sign with the motion."""
        return self.sets[0].shares.odd

    def elastic(self, states: Array, motion: Array) -> tuple[Array, Array]:
        """Return elastic motions (elements, 2) and ways (elements,) [m] in states of all elements at a motion (2,)."""
        return elastic_of(self.rows, states, motion), ways_of(self.rows, states)

    def by_set(self, e: Array, p: Array) -> Array:
        """Return the reactions (k, rows, n) of each set, from elastic motions (n, elements, 2) and ways of all."""
        ends = np.cumsum([0, *(len(each.rows) for each in self.sets)])
        parts = zip(self.sets, pairwise(ends), strict=True)
        return np.stack([one.shares.reactions(one.rows, e[:, a:b], p[:, a:b]) for one, (a, b) in parts])

    def mixed(self, rows: Array, V: Array) -> Array:
        """Return reactions (rows, n) of sets (k, rows, n) together at V (n,) [N]."""
        return np.einsum("krn,nk->rn", rows, shares_at(V, self.loads))


def fitted(loads: Array, sets: Sequence[ElementSet], paths: Sequence[tuple[Array, Array, Array]]) -> ChangingLoad:
    """Return the elements of sets, with V_virgin and V_reload with which they follow paths on which V changes best.

    paths: motions (n, 2) = (u, rotation L) [m], loads (n, 2) = (H, M/L) [N] and V (n,) [N] of each. Where no V is
    larger than ever before, V_virgin is V_reload.
    """
    from scipy.optimize import minimize  # a prediction by a fan does without SciPy

    span = float(loads[-1] - loads[0])

    def made(logs: Array) -> ChangingLoad:
        virgin, reloading = span * np.exp(np.minimum(logs[[0, -1]], np.log(WIDEST)))
        return ChangingLoad(loads, tuple(sets), float(virgin), float(reloading))

    def missing(logs: Array) -> float:
        springs, found = made(logs), 0.0
        for motions, known, V in paths:
            found += float(((springs.loads_along(motions, V) - known) ** 2).sum() / (known**2).sum())
        return found

    grows = any(bool((V[1:] > np.maximum.accumulate(V)[:-1]).any()) for _, _, V in paths)
    n = 2 if grows else 1
    corners = np.log(FIRST[:n]) + np.vstack([np.zeros(n), np.eye(n)])
    options = {"xatol": 0.02, "fatol": 1e-4, "initial_simplex": corners}
    return made(minimize(missing, corners[0], method="Nelder-Mead", options=options).x)
