# SPDX-License-Identifier: MIT
"""Sets of elements together: at a vertical load or a rate between those with rays that turn back, and under changing V.

Each set follows the whole motion and carries a share of its loads,

    F = sum_i s_i F_i(q),   s_i >= 0,   sum_i s_i = 1,

as a fan is interpolated: linear in V, or in the logarithm of the rate (`pysprings.springs.path_sets`). This is a set of
elements in parallel like each of them: no closed way gives work.

A V that changes yields the soil, too, and takes away a part of what the elements carry laterally: while V changes by
dV, what they carry is multiplied by

    exp(-|dV|/V_virgin)  where V is larger than ever before (virgin loading),   exp(-|dV|/V_reload)  else.

Under a motion that is held the load relaxes by that; under a load that is held the caisson moves on. V_virgin and
V_reload are fitted to rays on which V changes. Reversible elements, which keep nothing, do not relax. At a constant V
nothing of this acts, and no closed way gives work; what the work of V does to a way on which V changes is not counted.

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
from pysprings.core.loads import same_load
from pysprings.macro.solver import Drive
from pysprings.macro.ways import RANGE_SLACK
from pysprings.memory.calibration import ElementSet
from pysprings.memory.elements import PLATES, STATES, advance, follow, relax
from pysprings.memory.shares import Shares, elastic_of, stiffnesses, ways_of
from pysprings.memory.water import Water

PARTS = 60  # steps in which V passes the range of the loads; a part of it has that times the root of its share
SWUNG = 2.0  # ranges of the loads that V covers on the rays on which it changes: to the end, half back, and there again
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


def scaled(rows: Array, share: float) -> Array:
    """Return elements (n, COLUMNS) that carry a share of what these do."""
    out, plate = rows.copy(), np.isin(rows[:, 0], PLATES)
    out[plate, 6] *= share
    out[~plate, 4:7] *= share
    return out


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


class Step(NamedTuple):
    """A step of V: elements at its end (n, COLUMNS), share that they keep of what they carry, part of the whole way."""

    rows: Array
    kept: float
    part: float


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
        return np.array([low <= load <= high or same_load(load, low) or same_load(load, high) for load in V])

    @property
    def swing(self) -> float:
        """Changes of V [N], added up, up to which it is known what they take away."""
        return SWUNG * float(self.loads[-1] - self.loads[0]) * (1.0 + RANGE_SLACK)

    def rows_at(self, V: float) -> Array:
        """Return the elements of all sets (n, COLUMNS) with the stiffness of their shares at V [N]."""
        shares = shares_at(np.array([V]), self.loads)[0]
        return np.concatenate([scaled(each.rows, share) for each, share in zip(self.sets, shares, strict=True)])

    def follow(self, drive: Drive, aims: Array, V: Array) -> tuple[Array, Array, tuple[float, float]]:
        """Follow aims (n, 2) of the equations of `drive` under V (n,) [N] from rest at the first V.

        Returns motions (k, 2) = (u, rotation L) [m], loads (k, 2) = (H, M/L) [N], and the right side where it ended.
        """
        motions, loads = np.zeros(aims.shape), np.zeros(aims.shape)
        q, last, states = np.zeros(2), np.zeros(2), np.zeros((len(self.rows), STATES))
        for k, steps in enumerate(self._steps(V)):
            q, load, at = self.step(drive, q, states, np.stack([last, aims[k]]), steps)
            if load is None:
                return motions[:k], loads[:k], at
            motions[k], loads[k], last = q, load, aims[k]
        return motions, loads, (float(last[0]), float(last[1]))

    def step(
        self, drive: Drive, q: Array, states: Array, way: Array, steps: Sequence[Step]
    ) -> tuple[Array, Array | None, tuple[float, float]]:
        """Go from a right side of the equations of `drive` to another, way (2, 2), from states at a motion q (2,) [m].

        Returns motion [m] and load [N] (None: not reached), and the right side where it ended; changes the states.
        """
        found, carried, last = np.zeros((2, 2)), np.zeros((2, 2)), way[0]
        for rows, kept, part in steps:
            relax(self.rows, states, q, kept)
            aims = np.stack([last, way[0] + part * (way[1] - way[0])])
            n, at = follow(rows, drive, self.largest, q, states, aims, found, carried)
            if n < len(aims):
                return q, None, (at[0], at[1])
            q, last = found[1].copy(), aims[1]
        return q, carried[1], (float(last[0]), float(last[1]))

    def loads_along(self, motions: Array, V: Array) -> Array:
        """Return the loads (n, 2) = (H, M/L) [N] along motions (n, 2) [m] from rest under V (n,) [N]."""
        return np.array([F.copy() for _, _, F, _ in self._along(motions, V)])

    def tangents(self, motions: Array, V: Array) -> Array:
        """Return the tangents (n, 2, 2) [N/m] along motions (n, 2) [m] from rest under V (n,) [N]."""
        return np.array([K.copy() for _, _, _, K in self._along(motions, V)])

    def reactions(self, motions: Array, V: Array) -> Array:
        """Return all reactions (rows, n) along motions (n, 2) [m] from rest under V (n,) [N]."""
        way = [self.elastic(states, q) for q, states, _, _ in self._along(motions, V)]
        rows = self.by_set(*(np.stack(parts) for parts in zip(*way, strict=True)))
        changes = np.diff(rows, axis=2, prepend=0.0).transpose(1, 2, 0) * shares_at(V, self.loads)
        found: Array = np.where(self.odd[:, None], self.mixed(rows, V), changes.sum(axis=2).cumsum(axis=1))
        return found

    def _along(self, motions: Array, V: Array) -> Iterator[tuple[Array, Array, Array, Array]]:
        """Yield motion (2,), states, loads (2,), tangent (2, 2) at motions (n, 2) under V (n,), in the same arrays."""
        q, states, F, K = np.zeros(2), np.zeros((len(self.rows), STATES)), np.zeros(2), np.zeros((2, 2))
        for motion, steps in zip(motions, self._steps(V), strict=True):
            start = q
            for rows, kept, part in steps:
                relax(self.rows, states, q, kept)
                way = start + part * (motion - start) - q
                n = max(1, int(np.ceil(np.hypot(*way) / self.largest)))
                for _ in range(n):
                    before, q = q, q + way / n
                    advance(rows, before, q, states, F, K)
            yield q, states, F, K

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
        found: Array = np.einsum("krn,nk->rn", rows, shares_at(V, self.loads))
        return found

    def steps(self, start: float, end: float, top: float) -> list[Step]:
        """Return the steps from a V [N] to another one; top: largest V so far."""
        if start == end:
            return [Step(self.rows_at(end), 1.0, 1.0)]
        n = int(np.ceil(np.sqrt(abs(end - start) / (self.loads[-1] - self.loads[0])) * PARTS))
        loads = np.linspace(start, end, n + 1)
        fresh = np.diff(np.maximum(np.maximum.accumulate(loads), top))
        kept = np.exp(-fresh / self.virgin - (np.abs(np.diff(loads)) - fresh) / self.reloading)
        parts = np.arange(1, n + 1) / n
        return [Step(self.rows_at(V), own, part) for V, own, part in zip(loads[1:], kept, parts, strict=True)]

    def _steps(self, V: Array) -> Iterator[list[Step]]:
        """Yield the steps to each state under V (n,) [N]."""
        before, top, steps = float(V[0]), float(V[0]), self.steps(V[0], V[0], V[0])
        for load in V.tolist():
            steps = self.steps(before, load, top) if load != before else [Step(steps[-1].rows, 1.0, 1.0)]
            before, top = load, max(top, load)
            yield steps


def fitted(loads: Array, sets: Sequence[ElementSet], paths: Sequence[tuple[Array, Array, Array]]) -> ChangingLoad:
    """Return the elements of sets, with V_virgin and V_reload with which they follow paths on which V changes best.

    paths: motions (n, 2) = (u, rotation L) [m], loads (n, 2) = (H, M/L) [N] and V (n,) [N] of each. Where no V is
    larger than ever before, V_virgin is V_reload.
    """
    from scipy.optimize import minimize  # a prediction by a fan does without SciPy

    span = float(loads[-1] - loads[0])

    def made(logs: Array) -> ChangingLoad:
        virgin, reloading = span * np.exp(np.minimum(logs, np.log(WIDEST)))
        return ChangingLoad(loads, tuple(sets), float(virgin), float(reloading))

    def missing(logs: Array) -> float:
        springs, found = made(logs), 0.0
        for motions, known, V in paths:
            found += float(((springs.loads_along(motions, V) - known) ** 2).sum() / (known**2).sum())
        return found

    corners = np.log(FIRST) + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"xatol": 0.02, "fatol": 1e-4, "initial_simplex": corners}
    answer = minimize(missing, corners[0], method="Nelder-Mead", options=options)
    grows = any(bool((V[1:] > np.maximum.accumulate(V)[:-1]).any()) for _, _, V in paths)
    return made(answer.x if grows else answer.x[[1, 1]])
