# SPDX-License-Identifier: MIT
"""Sets of elements together: at a vertical load or a rate that lies between those with rays that turn back.

Each set follows the whole motion and carries a share of its loads,

    F = sum_i s_i F_i(q),   s_i >= 0,   sum_i s_i = 1,

linear in V, as a fan is interpolated (`pysprings.springs.dead_loads`, `pysprings.springs.rates`). With constant shares
this is a set of elements in parallel like each of them: no closed way gives work. Where V changes the shares do, and V
works on w; heave and settlement then add up, each part of the motion by the shares under which it is made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.memory.calibration import ElementSet, elastic_motions
from pysprings.macro.memory.elements import PLATES
from pysprings.macro.memory.shares import Shares, elastic_of, stiffnesses, ways_of
from pysprings.springs.alike import same_load

Array = NDArray[np.float64]


def mixed(parts: Sequence[tuple[ElementSet, float]]) -> ElementSet:
    """Return one set that carries the loads and reactions of sets, each times its share."""
    parts = [(each, share) for each, share in parts if share > 0.0]
    if len(parts) == 1:
        return parts[0][0]
    sets = [each for each, _ in parts]
    errors = {name: error for each in sets for name, error in each.errors.items()}
    rows = np.concatenate([_scaled(each.rows, share) for each, share in parts])
    reach, way = (min(getattr(each, name) for each in sets) for name in ("reach", "way"))
    return ElementSet(rows, reach, _shares(parts), max(each.residual for each in sets), errors, way)


def _scaled(rows: Array, share: float) -> Array:
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
    return Shares(first.odd, np.asarray(rest), np.asarray(S), np.hstack(elastic), even, np.concatenate(growth))


@dataclass(frozen=True)
class LoadedSets:
    """Sets of elements by vertical load.

    Attributes
    ----------
    loads : (k,) vertical loads [N], increasing.
    make : return each set.
    """

    loads: Array
    make: tuple[Callable[[], ElementSet], ...]

    @cached_property
    def sets(self) -> tuple[ElementSet, ...]:
        """All sets."""
        return tuple(make() for make in self.make)

    @cached_property
    def rows(self) -> Array:
        """Elements (n, COLUMNS) of all sets."""
        return np.concatenate([each.rows for each in self.sets])

    @cached_property
    def of(self) -> NDArray[np.int64]:
        """The set (n,) of each element."""
        return np.repeat(np.arange(len(self.sets)), [len(each.rows) for each in self.sets])

    @property
    def largest(self) -> float:
        """Largest step of a motion [m]."""
        return min(each.largest for each in self.sets)

    def nearest(self, V: float) -> float:
        """Return a vertical load [N] of the sets, or between them: the nearest to V."""
        near = float(np.clip(V, self.loads[0], self.loads[-1]))
        own = [float(load) for load in self.loads if same_load(load, near)]
        return own[0] if own else near

    def shares(self, V: Array) -> Array:
        """Return the share (n, k) of each set under vertical loads (n,) [N]; beyond all loads that of the nearest."""
        return np.stack([np.interp(V, self.loads, row) for row in np.eye(len(self.loads))], axis=1)

    def at(self, V: float) -> ElementSet:
        """Return the elements under a constant vertical load [N]; only sets that have a share are made."""
        shares = self.shares(np.array([V]))[0]
        return mixed([(make(), float(share)) for make, share in zip(self.make, shares, strict=True) if share > 0.0])

    def covers(self, V: Array) -> NDArray[np.bool_]:
        """Return which vertical loads (n,) [N] are those of sets, or between them."""
        own = np.array([[same_load(value, load) for load in self.loads] for value in V]).any(axis=1)
        inside: NDArray[np.bool_] = own | ((self.loads[0] <= V) & (self.loads[-1] >= V))
        return inside

    def reactions(self, motions: Array, V: Array, down: int, rest: float) -> Array:
        """Return all reactions (rows, n) along motions (n, 2) [m] from rest, under vertical loads V (n,) [N].

        down is the row of w, which is `rest` [m] at rest: it adds up what each step brings under its V. That V itself
        moves the caisson is not in it.
        """
        each = []
        for one in self.sets:
            e, p = elastic_motions(one.rows, motions, self.largest)
            each.append(one.shares.reactions(one.rows, e, p))
        found, shares = np.stack(each), self.shares(V)
        out: Array = np.einsum("nk,krn->rn", shares, found)
        start = np.array([one.shares.rest[down] for one in self.sets])
        moved = np.diff(found[:, down], axis=1, prepend=start[:, None])
        middle = 0.5 * (shares + np.concatenate([shares[:1], shares[:-1]]))
        out[down] = rest + np.cumsum((middle.T * moved).sum(axis=0))
        return out

    def reactions_of(self, states: Array, motion: Array) -> Array:
        """Return the reactions (k, rows) of each set, in states (n, STATES) at a motion (2,) [m]."""
        found = []
        for k, one in enumerate(self.sets):
            own = states[self.of == k]
            e = elastic_of(one.rows, own, motion)
            found.append(one.shares.reactions(one.rows, e[None], ways_of(one.rows, own)[None])[:, 0])
        return np.stack(found)

