# SPDX-License-Identifier: MIT
"""Vertical springs: t(z), tip and lid over the vertical displacement w, from paths of kind "vertical".

Downwards and upwards differ (lid and tip bear, or lift off), so each direction has its own curves, which start at the
state at rest, (w0, V0). Along them every reaction is a function of w alone, V = sum t dz + V_tip + V_lid. Interpolation
is that of a ray of a fan (`secant_slopes`): cubic, through the recorded points, linear in the data, with the
initial stiffness of the full model at rest in both directions.

How they go with the lateral springs: additively in w. Under a vertical load V that is not the V' of the lateral paths,

    w = w_lateral(u, rotation; V') + w_vertical(V) - w_vertical(V'),

and H and M stay those at V'. Beside springs with memory w_vertical is that of the history of V
(`VerticalTable.history`), beside all others a function of V. The first is exact where the caisson does not move
laterally, or where V = V'; what the second is worth away from V' is measured by `pysprings compare` on held-back paths
with a `vertical_load` of their own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.core.arrays import Array, Marks
from pysprings.core.loads import close_loads, same_load, same_loads
from pysprings.core.text import with_prefix
from pysprings.macro.fan import initial_slopes
from pysprings.macro.solver import row_values, spring_row
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from pysprings.springs.sums import secant_slopes

BISECTIONS = 60
# A curve whose last step is less than this share of its initial stiffness carries no more: V has reached its capacity
FLAT = 1e-3
# of loads at equal motion by the chord towards the end; a parabola V (1 - V/V_e), as of sand, loses half of it, 10 %
LOST_NEAR = 0.2


@dataclass(frozen=True, slots=True)
class Branch:
    """Reactions in one direction over x = |w - w0|: rows (t by depth, V_tip, V_lid, V), k knots.

    path : name of the path it comes from.
    sign : 1 downwards, -1 upwards.
    x : (k,) knots [m], 0 first.
    r, slope : (rows, k) reactions [N/m, N] and dr/dx.
    rate : that of w [m/s]; None where the path has no time.
    """

    path: str
    sign: float
    x: Array
    r: Array
    slope: Array
    rate: float | None = None

    @property
    def end(self) -> tuple[float, float]:
        """Largest x [m] and its V [N]."""
        return float(self.x[-1]), float(self.r[-1, -1])

    @property
    def largest(self) -> float:
        """Largest V [N] in its direction."""
        return self.sign * float((self.sign * self.r[-1]).max())

    @property
    def last(self) -> Array:
        """Slopes dr/dx (rows,) of the last step, with which the curves go on beyond the end."""
        return (self.r[:, -1] - self.r[:, -2]) / (self.x[-1] - self.x[-2])

    @property
    def is_flat(self) -> bool:
        """Whether V has stopped growing at the end."""
        return bool(self.sign * self.last[-1] < FLAT * abs(self.slope[-1, 0]))

    def at(self, x: Array, rows: Sequence[int] | slice = slice(None)) -> Array:
        """Return reactions (rows, n) at x (n,) [m]; the last step goes on beyond the end."""
        r, inside = self.r[rows], np.minimum(x, self.x[-1])
        knots, q = (np.tile(each, (len(r), 1)) for each in (self.x, inside))
        found: Array = row_values(knots, r, self.slope[rows], np.full(len(r), self.x.size), q)
        return found + self.last[rows, None] * (x - inside)

    def tangent(self, x: Array) -> Array:
        """Return dV/dx (n,) [N/m] at x (n,) [m]."""
        curve, end = (self.x, self.r[-1], self.slope[-1], self.x.size), self.x[-1]
        return np.array([self.last[-1] if each > end else spring_row(*curve, each)[1] for each in x])

    def find(self, V: Array) -> Array:
        """Return the first x (n,) [m] that carries each V [N], along the last step beyond the end; NaN: none does."""
        most, V = np.maximum.accumulate(self.sign * self.r[-1]), self.sign * V
        knot = np.searchsorted(most, V)  # the first that carries V
        to = np.minimum(knot, self.x.size - 1)
        low, high = self.x[np.maximum(to - 1, 0)], self.x[to]
        curve = self.x[None], self.r[-1:], self.slope[-1:], np.array([self.x.size])
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            carried = self.sign * row_values(*curve, middle[None])[0] >= V
            low, high = np.where(carried, low, middle), np.where(carried, middle, high)
        x = np.where(most[to] == V, self.x[to], 0.5 * (low + high))
        last = np.nan if self.is_flat else self.sign * self.last[-1]
        return np.where(knot > to, self.x[-1] + (V - self.sign * self.r[-1, -1]) / last, x)


@dataclass(frozen=True, slots=True)
class VerticalTable:
    """Vertical springs of a caisson.

    rest : w0 [m] and V0 [N] of the state at rest, where both directions start.
    depth, b : (rows,) depth [m] of each row, and its action on V: t with its slice, V_tip and V_lid with 1, V with 0.
    name : (rows,) t, V_tip, V_lid, V.
    stiffness : dV/dw at rest [N/m].
    branches : the directions that are known, downwards first.
    """

    rest: tuple[float, float]
    name: NDArray[np.str_]
    depth: Array
    b: Array
    stiffness: float
    branches: tuple[Branch, ...]

    @property
    def path(self) -> str:
        """Names of the paths they come from."""
        return ", ".join(branch.path for branch in self.branches)

    def branch(self, change: float) -> Branch | None:
        """Return the branch for a change of w or V from rest; None where that direction is not known."""
        sign = 1.0 if change >= 0.0 else -1.0
        return next((each for each in self.branches if each.sign == sign), None)

    def sides(self, change: Array) -> Iterator[tuple[Branch, Marks]]:
        """Yield the branches, each with which changes (n,) of w or V from rest are on its side."""
        for branch in self.branches:
            yield branch, (change >= 0.0) == (branch.sign > 0.0)

    def displacements(self, V: Array) -> Array:
        """Return w [m] under V (n,) [N], the tangent dV/dw [N/m] there, and the calibrated range used, (3, n).

        The range used is above 1 beyond the recorded displacement, inf in a direction that is not known (the answer is
        elastic then), NaN where no w carries V (w is that of the end of the curve then).
        """
        w0, V0 = self.rest
        elastic = w0 + (V - V0) / self.stiffness
        out = np.stack([elastic, np.full(V.size, self.stiffness), np.where(same_loads(V, V0), 0.0, np.inf)])
        for branch, own in self.sides(V - V0):
            x, end = branch.find(V[own]), branch.x[-1]
            slope = branch.sign * branch.tangent(np.nan_to_num(x))
            w = w0 + branch.sign * np.nan_to_num(x, nan=end)
            out[:, own] = np.stack([w, np.where(np.isnan(x), 0.0, slope), x / end])
        return out

    def displacement(self, V: float) -> float:
        """Return w [m] under one V [N], see `displacements`."""
        return float(self.displacements(np.array([V]))[0, 0])

    def lacking(self, w: float, V: float) -> float:
        """Return what w [m] of lateral springs at rest under V [N] lacks to that of these springs.

        0 at their own rest, and in a direction that is not known.
        """
        if same_load(V, self.rest[1]) or self.branch(V - self.rest[1]) is None:
            return 0.0
        return self.displacement(V) - w

    def history(self, V: Array) -> Array:
        """Return w [m], the tangent dV/dw [N/m] and the ranges used, (4, n), under V (n,) [N] one after the other.

        Within the largest and the smallest V so far, that at rest among them, the soil unloads and reloads with the
        stiffness at rest; beyond, it goes on along the curves. What each direction has taken more than that stays:

            w = w0 + (V - V0)/K + P(max V) + P(min V),   P(V) = w_curve(V) - w0 - (V - V0)/K,

        each direction from its own curve, whatever the other one has taken (an assumption). The ranges used are the
        largest so far, NaN from a V on that no w carries, and that of V alone.
        """
        (w0, V0), K = self.rest, self.stiffness
        largest, smallest = np.maximum.accumulate(np.fmax(V, V0)), np.minimum.accumulate(np.fmin(V, V0))
        own, high, low = (self.displacements(each) for each in (V, largest, smallest))
        stays = [each[0] - w0 - (x - V0) / K for each, x in ((high, largest), (low, smallest))]
        new = (largest == V) | (smallest == V)
        # an elastic direction keeps nothing
        known = [np.where(np.isinf(each[2]), 0.0, each[2]) for each in (high, low)]
        used = np.maximum(np.maximum(*known), own[2])
        return np.stack([w0 + (V - V0) / K + stays[0] + stays[1], np.where(new, own[1], K), used, own[2]])

    def reactions(self, w: Array) -> Array:
        """Return all rows (rows, n) at vertical displacements w (n,) [m]; elastic, V alone, in an unknown direction."""
        out, change = np.full((self.b.size, w.size), np.nan), w - self.rest[0]
        out[-1] = self.rest[1] + self.stiffness * change
        for branch, own in self.sides(change):
            out[:, own] = branch.at(np.abs(change[own]))
        return out

    def used(self, w: Array) -> Array:
        """Return the calibrated range used at w (n,) [m]; inf in a direction that is not known."""
        change = w - self.rest[0]
        used = np.where(change == 0.0, 0.0, np.inf)
        for branch, own in self.sides(change):
            used[own] = np.abs(change[own]) / branch.x[-1]
        return used

    def limits(self) -> str:
        """Return words for the V [N] that the known directions carry within their calibrated range."""
        ends = sorted([self.rest[1], *(branch.end[1] for branch in self.branches)])
        return f"V from {with_prefix(ends[0], 'N')} to {with_prefix(ends[-1], 'N')}"


def share_left(table: VerticalTable | None, V: Array, own: Array) -> Array:
    """Return the share (n,) of lateral loads at equal motion that V (n,) [N] leaves at least of those at V `own` (n,).

    1 where both are one; where the load at equal motion is concave in V, and is not negative at the largest V_e of the
    vertical path on the side of V, it is at least (V - V_e)/(V_own - V_e). NaN where no path leads there. Not above 0
    where V is beyond that end.
    """
    ends = {} if table is None else {branch.sign: branch.largest for branch in table.branches}
    end = np.array([ends.get(float(sign), np.nan) for sign in np.sign(V - own)]).reshape(V.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(same_loads(V, own), 1.0, (V - end) / (own - end))


def covered(table: VerticalTable | None, V: Array, own: Array) -> Marks:
    """Return for which V (n,) [N] the lateral springs at V `own` (n,) hold: within 10 %, and not near its capacity."""
    return close_loads(V, own) & ~(share_left(table, V, own) < 1.0 - LOST_NEAR)


def build_vertical(springs: Springs) -> VerticalTable | None:
    """Return the vertical springs of a spring set, None where it has no vertical calibration path.

    Of several paths in one direction the longest is used, of those that start at the vertical load of the scene where
    there are any.
    """
    paths = springs.vertical
    if not paths:
        return None
    first = min(paths, key=lambda path: abs(path.load - springs.rest_load))
    stiffness = springs.stiffness
    known = None if stiffness is None else float(stiffness[1, 1])
    longest: dict[float, SpringPath] = {}
    alike = [path for path in paths if same_load(path.load, first.load)]
    for path in sorted(alike, key=lambda path: abs(_travel(path)[-1])):
        longest[float(np.sign(_travel(path)[-1]))] = path
    branches = [_branch(longest[sign], sign, known) for sign in (1.0, -1.0) if sign in longest]
    depth, dz = first.depth, first.heights
    return VerticalTable(
        rest=(float(first.w[0]), first.load),
        name=np.array(["t"] * depth.size + ["V_tip", "V_lid", "V"]),
        depth=np.concatenate([depth, [dz.sum(), 0.0, 0.0]]),
        b=np.concatenate([dz, [1.0, 1.0, 0.0]]),
        stiffness=known if known is not None else float(branches[0].sign * branches[0].slope[-1, 0]),
        branches=tuple(branches),
    )


def _travel(path: SpringPath) -> Array:
    """Change of w [m] by step, up to where it turns back."""
    w = path.w - float(path.w[0])
    grows = np.diff(np.abs(w)) > 0.0
    n = w.size if grows.all() else int(np.argmin(grows)) + 1
    return w[:n]


def _branch(path: SpringPath, sign: float, stiffness: float | None) -> Branch:
    x = np.abs(_travel(path))
    rows = np.concatenate([path.by_depth("t"), [path["V_tip"], path["V_lid"]]])[:, : x.size]
    b = np.concatenate([path.heights, [1.0, 1.0]])[:, None]
    secant = (rows[:, 1] - rows[:, 0]) / x[1]
    first = secant if stiffness is None else initial_slopes(secant, b, np.array([sign * stiffness]))
    slope = secant_slopes(x, rows, first)
    return Branch(path.name, sign, x, np.vstack([rows, b.T @ rows]), np.vstack([slope, b.T @ slope]), path.rate)
