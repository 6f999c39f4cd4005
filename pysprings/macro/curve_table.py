# SPDX-License-Identifier: MIT
"""From a spring dataset to interpolation tables: every spring of a rigid caisson as one row of the same form.

A spring j reads one displacement q_j = a_j . (u, rotation) and answers with one reaction r_j(q_j), which acts
on the body as b_j * r_j in (H, M). For p at depth z with slice height dz: a = (1, -z), b = (dz, -z dz); for m:
a = (0, 1), b = (0, dz); tip force: a = (1, -L), b = (1, -L); base and lid moments: a = (0, 1), b = (0, 1); lid
force: a = b = (1, 0). The sums over all rows are the loads on the body. Solving and reporting are
elsewhere. `CurveSprings` are curves of their own, as in a user's table, without a recorded path of a full model.

Each curve is a single-valued odd function of its displacement: f(-q) = -f(q). Curves are PCHIP through the
recorded steps (Fritsch & Butland 1984): recorded points are hit exactly, no overshoot between them,
continuous slope. Beyond the last point the curve goes on with its last slope where it still hardens, else it
stays flat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.errors import refused
from pysprings.core.path_kinds import driven
from pysprings.core.text import suggestion
from pysprings.springs.path import SpringPath
from pysprings.springs.sums import action

# A displacement must cover this share of the largest one on the path to carry a curve: less is noise near the
# point of rotation, where p/y runs to infinity.
MIN_RANGE = 0.10
CORNER = 1e-7  # share of a segment over which straight lines are joined
# Smallest growth between two steps, as a share of the range, that still counts as monotonic.
MIN_GROWTH = 1e-7
# A reaction may pull along with its displacement (a negative spring) up to this share of its largest value.
MAX_NEGATIVE = 0.02

Slice = tuple[float, float]  # depth and height [m] of what a reaction acts on; tip and lid have no height


@dataclass(frozen=True, slots=True)
class SpringTable:
    """Springs as rows. n rows, k knots at most; see the module's words for a and b.

    name, depth : list of str, (n,) float
        Family (p, m, H_tip, M_tip, H_lid, M_lid) and depth [m] of each row.
    carrier : list of str
        Displacement the row reads: its own ("y" or "rotation"), or the one that replaces an unusable one.
    a, b : (n, 2) float
        Displacement read from (u, rotation), and action on (H, M), of each row.
    q, r, slope : (n, k) float
        Knots (0 first, increasing; inf beyond `count`), reactions and slopes dr/dq for q >= 0.
    count : (n,) int
        Number of knots of each row.
    natural, cut : (n,) bool
        natural: the row reads its own displacement. cut: only the first, monotonic part of its curve is kept.
    """

    name: list[str]
    depth: Array
    carrier: list[str]
    a: Array
    b: Array
    q: Array
    r: Array
    slope: Array
    count: Integers
    natural: Marks
    cut: Marks

    @property
    def range(self) -> Array:
        """Largest calibrated displacement of each row [m or rad]."""
        return self.q[np.arange(len(self.count)), self.count - 1]

    def read(self, states: Array) -> Array:
        """Return the displacements (rows, n) that the rows read at states (n, 2), each by itself, bit for bit."""
        u, rotation = np.asarray(states).T
        return self.a[:, :1] * u + self.a[:, 1:] * rotation

    @property
    def solver_arrays(self) -> tuple[Array, Array, Array, Array, Array, Integers]:
        """The rows as the solver reads them."""
        return self.a, self.b, self.q, self.r, self.slope, self.count

    @property
    def load_scale(self) -> Array:
        """Size of H [N] and M [N m] that the springs can build up, for tolerances."""
        peak = np.abs(self.r).max(axis=1)  # 0 beyond the knots
        return np.maximum((np.abs(self.b) * peak[:, None]).sum(axis=0), 1e-300)


def build_table(path: SpringPath, companions: bool) -> SpringTable:
    """Return the table of one path's springs from its converged steps, up to where it turns back.

    With `companions` p(y), m(rotation), tip and lid terms (the set "full"); without, net p(y) alone ("py").

    A spring must be a function of its displacement, and must resist it. On a pull with free head, y near the
    tip may stay small, turn back or change sign, and the soil there, moved by its neighbours, may push along
    with y. A negative spring gives the macro-model a second equilibrium beside the right one (seen for load
    heights near L). So a curve is usable where its displacement grows from step to step, reaches 10 % of the
    largest displacement, and meets resistance. Elsewhere the row is marked (`natural`, `carrier`, `cut`):

    - full set: the reaction is read from u, or else from the rotation, so that the sums on the calibration
      path stay those of the full model;
    - p-y set: the first usable part is kept and held flat beyond, or the curve is left out.
    """
    recorded = _Recorded.of(path)
    rows = [_lateral_row(recorded, k, companions) for k in range(recorded.z.size)]
    if companions:
        rows += [_moment_row(recorded, k) for k in range(recorded.z.size)] + _end_rows(recorded)
    return stack([row for row in rows if row is not None])


def build_pisa(translation: SpringPath, rotation: SpringPath) -> SpringTable:
    """Return uncoupled families after PISA (Byrne et al. 2020), adapted to a bucket, from two paths.

    Lateral reactions p(y), H_tip(y_tip), H_lid(u) come from a translation without rotation, moments m(rotation),
    M_tip(rotation), M_lid(rotation) from a rotation about the lid centre; neither depends on the other's motion.
    """
    slid, turned = _Recorded.of(translation), _Recorded.of(rotation)
    rows = [_lateral_row(slid, k, companions=True) for k in range(slid.z.size)] + _end_rows(slid)[::2]
    rows += [_moment_row(turned, k) for k in range(turned.z.size)] + _end_rows(turned)[1::2]
    return stack([row for row in rows if row is not None])


@dataclass(frozen=True, slots=True)
class _Recorded:
    """Arrays of the path, as changes from its first step."""

    z: Array
    dz: Array
    length: float
    u: Array
    rotation: Array
    p: Array
    m: Array
    ends: dict[str, Array]

    @classmethod
    def of(cls, path: SpringPath) -> _Recorded:
        if path.turns_back:
            path = _to_its_turn(path)

        def change(values: Array) -> Array:
            return values - values[..., :1]

        m = path.m if "m" in path else 0.0 * path.p  # p-y curves from a table may stand alone
        ends = {name: change(path[name]) for name in ("H_tip", "M_tip", "H_lid", "M_lid") if name in path}
        length = float(path["depth_bounds"][-1, 1])
        moves = change(path.u), change(path.rotation)
        return cls(path.depth, path.heights, length, *moves, change(path.p), change(m), ends)

    def slice(self, k: int) -> Slice:
        """Return the depth and height [m] of a slice by number."""
        return float(self.z[k]), float(self.dz[k])

    @property
    def reach(self) -> float:
        """Largest displacement of the skirt on the path [m]."""
        return float(np.abs([self.u, self.u - self.rotation * self.length]).max())

    def carriers(self, name: str, depth: float) -> dict[str, tuple[tuple[float, float], Array, float]]:
        """Return the displacements a row may read: name -> (a, history, size that counts as full range).

        Skirt and tip move back where the caisson leans: a force resists -rotation, and a moment -y or -u.
        """
        reach = self.reach
        turned, moved = (1.0, -1.0) if name.startswith(("m", "M")) else (-1.0, 1.0)
        return {
            "y": ((moved, -moved * depth), moved * (self.u - self.rotation * depth), reach),
            "rotation": ((0.0, turned), turned * self.rotation, reach / self.length),
            "u": ((moved, 0.0), moved * self.u, reach),
        }


def _to_its_turn(path: SpringPath) -> SpringPath:
    """Return a path up to where it first turns back, or rests, and what is free creeps on.

    To the largest motion before |(u, rotation L)| falls, or that which is driven stands still.
    """
    size = np.hypot(path.u - path.u[0], path.turn - path.turn[0])
    way = np.abs(path[driven(path.attrs)] - path[driven(path.attrs)][0])
    falls = np.flatnonzero((np.diff(size) < 0.0) | (np.diff(way) <= MIN_GROWTH * way.max()))
    n = int(np.argmax(size[: falls[0] + 1])) + 1 if falls.size else size.size
    return SpringPath(path.name, path.dataset.isel(step=slice(n)), path.length)


@dataclass(frozen=True, slots=True)
class Row:
    """One spring before it is stacked: see `SpringTable`; q starts at 0, its size grows, r belongs to q."""

    name: str
    depth: float
    carrier: str
    a: tuple[float, float]
    b: tuple[float, float]
    q: Array
    r: Array
    natural: bool = True
    cut: bool = False


def leading(q: Array, r: Array, size: float, resists: bool = True) -> int:
    """Count leading points where |q| grows, keeps its sign and meets resistance; 0 for a small range."""
    good = (np.diff(np.abs(q)) > MIN_GROWTH * size) & (np.sign(q[1:]) == np.sign(q[1]))
    if resists:
        good &= np.sign(q[1:]) * r[1:] >= -MAX_NEGATIVE * np.abs(r).max()
    n = q.size if good.all() else int(np.argmin(good)) + 1
    return n if n > 1 and abs(q[n - 1]) >= MIN_RANGE * size else 0


def _carried(rec: _Recorded, name: str, place: Slice, r: Array, order: tuple[str, ...]) -> Row | None:
    """Return row of reaction r, read from the first displacement in the given order that is usable over the whole path.

    Where r resists none of them, growth alone must do; its own displacement, the first, comes last then.
    """
    depth, b = place[0], action(name, *place, rec.length)
    options = rec.carriers(name, depth)
    for resists, carriers in ((True, order), (False, order[1:] + order[:1])):
        for carrier in carriers:
            a, q, size = options[carrier]
            if leading(q, r, size, resists) == q.size:
                return Row(name, depth, carrier, a, b, q, r, natural=carrier == order[0])
    return _cut(rec, name, place, r, order[0])


def _cut(rec: _Recorded, name: str, place: Slice, r: Array, carrier: str) -> Row | None:
    """Return the row of the first usable part of a curve (at best all of it); None without one."""
    depth, b = place[0], action(name, *place, rec.length)
    a, q, size = rec.carriers(name, depth)[carrier]
    n = leading(q, r, size)
    return Row(name, depth, carrier, a, b, q[:n], r[:n], cut=n < q.size) if n else None


def _lateral_row(rec: _Recorded, k: int, companions: bool) -> Row | None:
    place, r = rec.slice(k), rec.p[k]
    if companions:
        return _carried(rec, "p", place, r, ("y", "u", "rotation"))
    return _cut(rec, "p", place, r, "y")


def _moment_row(rec: _Recorded, k: int) -> Row | None:
    return _carried(rec, "m", rec.slice(k), rec.m[k], ("rotation", "y", "u"))


def _end_rows(rec: _Recorded) -> list[Row | None]:
    """Return the rows of the tip (its displacement and rotation) and of the lid; forces and moments in turn."""
    tip, lid, ends = (rec.length, 0.0), (0.0, 0.0), rec.ends
    return [
        _carried(rec, "H_tip", tip, ends["H_tip"], ("y", "u", "rotation")),
        _carried(rec, "M_tip", tip, ends["M_tip"], ("rotation", "u")),
        _carried(rec, "H_lid", lid, ends["H_lid"], ("u", "rotation")),
        _carried(rec, "M_lid", lid, ends["M_lid"], ("rotation", "u")),
    ]


def stack(rows: list[Row], straight: bool = False) -> SpringTable:
    """Return rows as one table, each curve turned to positive displacements, with its slopes, or on straight lines."""
    curves = [(np.abs(row.q), np.where(row.q < 0, -row.r, row.r)) for row in rows]
    lines = [straight_lines(*each) for each in curves] if straight else []
    count = np.array([each[0].size for each in lines or curves], dtype=np.int64)
    q = np.full((len(rows), int(count.max(initial=2))), np.inf)
    r, slope = np.zeros_like(q), np.zeros_like(q)
    for j, (x, y, *_) in enumerate(lines or curves):
        q[j, : count[j]], r[j, : count[j]] = x, y
    for j, (_, _, own) in enumerate(lines):
        slope[j, : count[j]] = own
    for n in np.unique(count) if not straight else ():
        same = np.flatnonzero(count == n)
        slope[same, :n] = pchip_slopes(q[same, :n], r[same, :n])
    return SpringTable(
        name=[row.name for row in rows],
        depth=np.array([row.depth for row in rows]),
        carrier=[row.carrier for row in rows],
        a=np.array([row.a for row in rows]).reshape(-1, 2),
        b=np.array([row.b for row in rows]).reshape(-1, 2),
        q=q,
        r=r,
        slope=slope,
        count=count,
        natural=np.array([row.natural for row in rows], dtype=bool),
        cut=np.array([row.cut for row in rows], dtype=bool),
    )


def straight_lines(q: Array, r: Array) -> tuple[Array, Array, Array]:
    """Return knots, reactions and slopes of straight lines through points (k,), corners rounded (`CORNER`)."""
    slopes = np.diff(r) / np.diff(q)
    gap = CORNER * np.minimum(np.diff(q)[:-1], np.diff(q)[1:])
    inner = np.stack([q[1:-1] - gap, q[1:-1] + gap], axis=1).ravel()
    reactions = np.stack([r[1:-1] - gap * slopes[:-1], r[1:-1] + gap * slopes[1:]], axis=1).ravel()
    ends = [np.concatenate([x[:1], y, x[-1:]]) for x, y in ((q, inner), (r, reactions))]
    return ends[0], ends[1], np.repeat(slopes, 2)


def pchip_slopes(q: Array, r: Array) -> Array:
    """Return slopes dr/dq (..., k) at the knots of shape-preserving cubics (Fritsch & Butland 1984).

    Inside: weighted harmonic mean of the neighbouring secants, 0 at a turning point. Ends: three-point
    formula; where that has the sign against a curve that goes on (steps that grow while it bends), no curvature there.
    Where |r| falls at the last knot, the slope there is 0: the curve is held flat beyond it.
    """
    h = np.diff(q)
    secant = np.diff(r) / h
    if h.shape[-1] == 1:
        return np.repeat(secant, 2, axis=-1)
    slopes = np.zeros_like(r)
    h0, h1, s0, s1 = h[..., :-1], h[..., 1:], secant[..., :-1], secant[..., 1:]
    same = s0 * s1 > 0.0
    w1, w2 = 2.0 * h1 + h0, h1 + 2.0 * h0
    mean = w1 / np.where(same, s0, 1.0) + w2 / np.where(same, s1, 1.0)
    slopes[..., 1:-1] = np.where(same, (w1 + w2) / np.where(same, mean, 1.0), 0.0)
    for end, next_ in ((0, 1), (-1, -2)):
        slopes[..., end] = _end_slope(
            h[..., end], h[..., next_], secant[..., end], secant[..., next_], slopes[..., next_]
        )
    slopes[..., -1] = np.where(slopes[..., -1] * r[..., -1] < 0.0, 0.0, slopes[..., -1])
    return slopes


def _end_slope(h0: Array, h1: Array, s0: Array, s1: Array, inner: Array) -> Array:
    """Return the three-point slope at an end, limited so that the curve stays monotonic; inner: slope one knot on."""
    slope = ((2.0 * h0 + h1) * s0 - h0 * s1) / (h0 + h1)
    slope = np.where((s0 * s1 < 0.0) & (np.abs(slope) > 3.0 * np.abs(s0)), 3.0 * s0, slope)
    return np.where(slope * s0 <= 0.0, 0.5 * (3.0 * s0 - inner), slope)


# What each companion family of a table holds.
FAMILIES = {"mtheta": ("m",), "base": ("H_tip", "M_tip"), "lid": ("H_lid", "M_lid")}


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve: spring (p, m, H_tip, M_tip, H_lid, M_lid), depth [m], displacements q (0 first) and reactions r."""

    name: str
    depth: float
    q: Array
    r: Array


@dataclass(frozen=True, slots=True)
class CurveSet:
    """Curves of one name: depths (n,) and slices (n, 2) of p [m], all curves, a sentence on what was assumed.

    straight: curves are straight lines between their points, not smooth.
    """

    depth: Array
    bounds: Array
    curves: list[Curve]
    note: str = ""
    straight: bool = False

    @property
    def length(self) -> float:
        """Skirt length [m]: the bottom of the lowest slice."""
        return float(self.bounds[-1, 1])

    def missing(self) -> list[str]:
        """Return the companion families that the full set needs and the table does not have."""
        there = {curve.name for curve in self.curves}
        return [family for family, names in FAMILIES.items() if not set(names) <= there]

    def table(self, companions: bool) -> SpringTable:
        """Return the rows of all curves, or those of p alone."""
        heights = dict(zip(self.depth, self.bounds[:, 1] - self.bounds[:, 0], strict=True))
        used = [curve for curve in self.curves if companions or curve.name == "p"]
        return stack([self._row(curve, heights.get(curve.depth, 0.0)) for curve in used], self.straight)

    def _row(self, curve: Curve, dz: float) -> Row:
        at = self.length if curve.name.endswith("tip") else 0.0 if curve.name.endswith("lid") else curve.depth
        turns = curve.name == "m" or curve.name.startswith("M_")
        carrier = "rotation" if turns else "u" if curve.name == "H_lid" else "y"
        b = action(curve.name, at, dz, self.length)
        return Row(curve.name, at, carrier, (0.0, 1.0) if turns else (1.0, -at), b, curve.q, curve.r)


@dataclass(frozen=True, slots=True)
class CurveSprings:
    """Sets of curves by name (the column `path` of a table), and the file they come from."""

    source: str
    sets: dict[str, CurveSet]

    def pick(self, name: str | None) -> tuple[str, CurveSet]:
        """Return the set of a name, or the first one."""
        chosen = next(iter(self.sets)) if name is None else name
        if chosen not in self.sets:
            raise refused(
                "path",
                f"no path '{chosen}'{suggestion(chosen, self.sets)}; the table has: {', '.join(self.sets)}",
                self.source,
            )
        return chosen, self.sets[chosen]

    def origin(self, name: str) -> SpringPath:
        """Return depths and slices of a set as a path without states: nothing was recorded."""
        chosen = self.sets[name]
        data = {"depth_bounds": (("depth", "bound"), chosen.bounds)}
        return SpringPath(name, xr.Dataset(data, {"depth": chosen.depth}, {"kind": "table"}), chosen.length)
