# SPDX-License-Identifier: MIT
"""Springs with a memory, asked along sequences from rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.fan import RANGE_SLACK, FanTable
from pysprings.macro.history import Control, ending, equations
from pysprings.macro.memory.calibration import ElementSet, way_of
from pysprings.macro.memory.changing import ChangingLoad
from pysprings.macro.memory.elements import STATES, follow, tangents
from pysprings.macro.memory.marks import off_rate
from pysprings.macro.memory.shares import elastic_motions
from pysprings.macro.solver import Drive
from pysprings.springs.path import same_load

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MemoryModel:
    """Elements with a memory, and the layout of the reactions of a caisson.

    Attributes
    ----------
    elements : calibrated elements.
    table : fan of the rays: names, depths and actions of the reactions, and the size of the loads.
    V : vertical load [N] of the rays that turn back, or between two of theirs; NaN where it is not known.
    rate : their rate [m/s, of rho], or between two; None where springs do not depend on one.
    sets : number of sets that the elements are from: more than one between two vertical loads or rates.
    changing : elements under a V that changes; None where the springs have no rays on which V changes.
    """

    elements: ElementSet
    table: FanTable
    V: float = np.nan
    rate: float | None = None
    sets: int = 1
    changing: ChangingLoad | None = None

    @cached_property
    def to_motion(self) -> Array:
        """Factors (2,) from (u, rotation) to (u, rotation*L) [m]."""
        return np.array([1.0, self.table.length])

    @cached_property
    def rest(self) -> tuple[float, float]:
        """w [m] and V [N] of the elements at rest."""
        return self._w_and_load(self.elements.shares.rest)

    def _w_and_load(self, rows: Array) -> tuple[float, float]:
        """Return w [m] and V [N] of all reactions (rows,)."""
        w, V = (float(rows[self.table.name == name][0]) for name in ("w", "V"))
        return w, V

    def under(self, V: float | Array | None) -> ChangingLoad | None:
        """Return the elements that follow vertical loads (n,) [N]; None where all are that of the elements, or none."""
        if self.changing is None or V is None:
            return None
        return None if all(same_load(self.V, each) for each in np.unique(V)) else self.changing

    def lacks(self, V: Array, other: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which states under V (n,) [N] the elements do not follow, where `other` (n,) are not at their V.

        They are those from the first one on that is not at their V, or, with rays on which V changes, beyond its range.
        """
        changing = self.under(V)
        beyond = other if changing is None else other & ~changing.covers(V)
        found: NDArray[np.bool_] = np.logical_or.accumulate(beyond)
        return found

    def rest_under(self, V: float | Array | None) -> tuple[float, float]:
        """Return w [m] and V [N] of the elements at rest, at the first of vertical loads (n,) [N] that they follow."""
        changing = self.under(V)
        if changing is None or V is None:
            return self.rest
        rows = np.stack([each.shares.rest for each in changing.sets])
        return self._w_and_load(changing.mixed(rows[:, :, None], np.ravel(V)[:1])[:, 0])

    def loads_text(self) -> str:
        """Return the vertical loads of the elements in words."""
        if self.changing is None:
            return f"that of the elements ({self.V:.7g} N)"
        low, high = self.changing.loads[[0, -1]]
        return f"those of the elements ({low:.7g} to {high:.7g} N)"

    def solve(
        self, control: Control, targets: Array, arm: float = 0.0, V: float | Array | None = None
    ) -> tuple[Array, Array, str]:
        """Follow targets (n, 2) from rest: states (k, 2) = (u, rotation), loads (k, 2) = (H, M), and where it ended.

        As `pysprings.macro.model.MacroModel.solve`, whose controls these are. V (n,) [N]: vertical load of each target;
        one number, or None, is that of the elements.
        """
        targets = np.asarray(targets, dtype=float)
        drive, aims = self.equations(control, targets, arm)
        changing = self.under(V)
        if changing is not None:
            found, carried, at = changing.follow(drive, aims, _each(V, aims))
            states, loads, n = found / self.to_motion, carried * self.to_motion, len(found)
            end = self._target(control, np.array(at))
            return states, loads, "" if n == len(aims) else ending(control, end, targets[n], states, loads)
        states = np.zeros((len(self.elements.rows), STATES))
        way = np.concatenate([np.zeros((1, 2)), aims])
        motions, loads = np.zeros(way.shape), np.zeros(way.shape)
        n, at0, at1 = follow(self.elements.rows, drive, self.elements.largest, np.zeros(2), states, way, motions, loads)
        found, carried = motions[1:n] / self.to_motion, loads[1:n] * self.to_motion
        at = self._target(control, np.array([at0, at1]))
        return found, carried, "" if n == len(way) else ending(control, at, targets[n - 1], found, carried)

    def equations(self, control: Control, targets: Array, arm: float) -> tuple[Drive, Array]:
        """Return the equations of a control in (u, rotation*L) and (H, M/L), and their right sides (n, 2)."""
        L = self.table.length
        (G, C, scale), aims = equations(control, targets, arm, self.table.load_scale)
        if control in ("load", "state"):
            aims = aims / self.to_motion if control == "load" else aims * self.to_motion
            factor = 1.0 / self.to_motion if control == "load" else self.to_motion
            size = float(np.max(scale * factor))
            return Drive(G, C, np.full(2, size)), np.ascontiguousarray(aims)
        G, C = G / [1.0, L], C * [1.0, L]
        return Drive(np.ascontiguousarray(G), np.ascontiguousarray(C), scale), np.ascontiguousarray(aims)

    def _target(self, control: Control, c: Array) -> tuple[float, float]:
        factor = {"load": self.to_motion, "state": 1.0 / self.to_motion}.get(control, np.ones(2))
        return float(c[0] * factor[0]), float(c[1] * factor[1])

    def notes(self, states: Array) -> list[str]:
        """Return a sentence where states (n, 2) = (u, rotation) come farther than the ways of the calibration."""
        come = way_of(states * self.to_motion) / self.elements.way
        text = (
            f"the motions add up to {come:.3g} times the way of the rays that turn back: heave, settlement and "
            "vertical reactions are extrapolated beyond"
        )
        return [text] if come > 1.0 + RANGE_SLACK else []

    def off_rates(self, states: Array, time: Array) -> NDArray[np.bool_]:
        """Return where steps to states (n, 2) = (u, rotation) at times (n,) [s], from rest at 0 s, are off the rate."""
        ways = np.hypot(*np.diff(states * self.to_motion, axis=0, prepend=0.0).T)
        steps = zip(ways, np.diff(time, prepend=0.0), strict=True)
        return np.array([bool(off_rate(self.rate, float(way), float(step))) for way, step in steps])

    def tangents(self, states: Array, V: float | Array | None = None) -> Array:
        """Return the tangents (n, 2, 2) to (u, rotation) along states (n, 2) = (u, rotation), from rest on.

        V (n,) [N]: as in `solve`.
        """
        motions, changing = np.ascontiguousarray(states * self.to_motion), self.under(V)
        loads, out = np.zeros(motions.shape), np.zeros((len(motions), 2, 2))
        if changing is None:
            tangents(self.elements.rows, motions, self.elements.largest, loads, out)
        else:
            out = changing.tangents(motions, _each(V, motions))
        scaled: Array = out * self.to_motion * self.to_motion[:, None]
        return scaled

    def reactions(self, states: Array, time: Array | None = None, V: float | Array | None = None) -> Array:
        """Return all reactions (rows, n) of a fan along states (n, 2) = (u, rotation), from rest on.

        time (n,) [s] of the states, from 0 s at rest; None: at the rate of the elements. The water's part of p alone
        depends on it, and that of springs without a rate does not. V (n,) [N]: as in `solve`.
        """
        changing = self.under(V)
        if changing is not None:
            found = changing.reactions(states * self.to_motion, _each(V, states))
            found[self.table.wet] = np.nan  # the water of a V that changes is not known
            return found
        motions, shares = states * self.to_motion, self.elements.shares
        e, p = elastic_motions(self.elements.rows, motions, self.elements.largest)
        found = shares.reactions(self.elements.rows, e, p)
        if self.table.wet.any():
            found[self.table.wet] = self._water(motions, self._times(states) if time is None or not self.rate else time)
        return found

    def _times(self, states: Array) -> Array:
        """Return the times (n,) [s] of states (n, 2) = (u, rotation) from rest at the rate of the elements, or 0."""
        ways = np.hypot(*np.diff(states * self.to_motion, axis=0, prepend=0.0).T).cumsum()
        found: Array = ways / self.rate if self.rate else np.zeros(len(ways))
        return found

    def _water(self, motions: Array, time: Array) -> Array | float:
        """Return p_water (rows, n) along motions (n, 2) [m], in steps of the largest size; NaN where not known."""
        water = self.elements.shares.water
        if water is None:
            return np.nan
        ways = np.hypot(*np.diff(motions, axis=0, prepend=0.0).T)
        ends = np.ceil(np.maximum(ways / self.elements.largest, 1.0)).cumsum()
        at, last = np.arange(1.0, ends[-1] + 1.0), np.concatenate([[0.0], ends])
        fine = np.stack([np.interp(at, last, np.concatenate([[0.0], column])) for column in motions.T], axis=1)
        e, _ = elastic_motions(self.elements.rows, fine, self.elements.largest)
        found = water.along(e, np.interp(at, last, np.concatenate([[0.0], time])), np.zeros(e.shape[1:]), water.rest)
        return found[:, ends.astype(int) - 1]


def _each(V: float | Array | None, states: Array) -> Array:
    """Return the vertical load (n,) [N] of each state."""
    return np.broadcast_to(np.asarray(V, dtype=float), len(states)).copy()
