# SPDX-License-Identifier: MIT
"""A cone penetration test: its rows below mudline, stresses, net resistance, soil behaviour type index.

Boundaries of layers are the partition of least misfit, with a price for each layer. In a layer I_c is constant and
ln(q_net/s'_v0^0.5) linear in depth. Its misfit is the integral over depth of the squared deviations over `SCATTER`
squared; a further layer must lower the sum by `PRICE` metres. The best partition is found exactly, by dynamic
programming over cells.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.tables import TableNote
from pysprings.scene.profile_table import WATER

PA = 1.0e5  # Pa, atmospheric pressure of the normalisations
AREA_RATIO = 0.8  # of a cone whose file gives none
LEAST_STRESS = 1.0e3  # Pa, below which normalisations use it
# beyond these a unit is wrong: m, m, Pa, Pa, share
LEAST_DEPTH, MOST_DEPTH, MOST_CONE, LEAST_CONE, MOST_FRICTION, LEAST_FRICTION = 0.5, 500.0, 200.0e6, 20.0e3, 0.3, 5.0e-4
MOST_PRESSURE, LEAST_PRESSURE = 2.0, 0.02  # of u_2 over q_c in the median, over the hydrostatic pressure
# of the median of a test: Pa, Pa, Pa/m of q_c over depth, which is that of the ground above at the least
HALF_CONE, HALF_SLEEVE, LEAST_RATE = 60.0e6, 1.0e6, 8.0e3
CHANNELS = ("depth", "qc", "qt", "fs", "Rf", "u2")
# by channel: name, the largest size that a test has (SI), unit of messages and its factor
_SIZES = {
    "depth": ("a depth", MOST_DEPTH, "m", 1.0), "qc": ("a cone resistance", MOST_CONE, "MPa", 1e-6),
    "qt": ("a cone resistance", MOST_CONE, "MPa", 1e-6), "fs": ("a sleeve friction", 5.0e6, "MPa", 1e-6),
    "Rf": ("a friction ratio", 5.0, "%", 100.0), "u2": ("a pore pressure u2", 10.0e6, "MPa", 1e-6),
}  # fmt: skip
SUBMERGED = 2.0  # m, of the first row below mudline, or below what was drilled, where depths are negative
ABOVE = 0.5  # m, of the first row above mudline, where depths are negative
MANY = 0.1  # share of rows with a u_2 of 0 that is remarked on
ANOTHER_LEVEL = "elevations of another level? depths count from mudline, 0 m, down"
FALLING = 0.9  # share of rows that fall where depths are elevations
OF_WATER = 50.0e3  # Pa, of u_2 above the hydrostatic pressure below mudline, where it counts from the sea
OF_SAND = (5.0e6, 0.01)  # q_c and R_f of sand, where u_2 is the pressure of the water at rest, or less
SHORTEST, OVERLAP = 0.1, 1.3  # share of rows that fall, and length of runs over the depth, of several tests in one


@dataclass(frozen=True)
class Sounding:
    """A cone penetration test.

    place : file.  name : of location or test.  depth (n,) : below mudline [m], growing.  cone, sleeve, pressure (n,) :
    q_c, f_s, u_2 [Pa], NaN where not measured.  corrected (n,) : q_t [Pa] of the file, NaN where it gives none.
    area_ratio : net area ratio of the cone.  notes : what was left out or assumed.
    """

    place: str
    name: str
    depth: Array
    cone: Array
    sleeve: Array
    pressure: Array
    corrected: Array
    area_ratio: float | None = None
    notes: tuple[str, ...] = ()

    def down_to(self, depth: float) -> Sounding:
        """Return the rows down to a depth (m)."""
        own = self.depth <= depth
        if own.sum() < 3:
            raise refused(None, f"holds {int(own.sum())} rows down to {depth:g} m", self.place)
        rows = ("depth", "cone", "sleeve", "pressure", "corrected")
        return replace(self, **{name: getattr(self, name)[own] for name in rows})

    @property
    def total_cone(self) -> Array:
        """q_t (n,) = q_c + u_2 (1 - a) [Pa]; the one of the file where it gives that; q_c without pore pressure."""
        ratio = AREA_RATIO if self.area_ratio is None else self.area_ratio
        own = self.cone + np.nan_to_num(self.pressure) * (1.0 - ratio)
        return np.maximum(np.where(np.isfinite(self.corrected), self.corrected, own), LEAST_STRESS)


def sounding(
    place: str, name: str, given: Mapping[str, Array], area_ratio: float | None = None, drilled: float = 0.0,
    remarks: Sequence[str] = (),
) -> Sounding:  # fmt: skip
    """Return the test of channels in SI, by `CHANNELS`; NaN where there is no value.

    Depths that fall from row to row are elevations below mudline, as older files have them. Rows without depth or cone
    resistance, and those above the pre-drilled depth ``drilled`` (m), are left out with a note. A channel "area
    ratio" holds it by row. ``remarks`` are notes of the reader.

    Raises UserInputError: fewer than three rows are left.
    """
    length = len(given["depth"])
    channel, notes = {name: given.get(name, np.full(length, np.nan)) for name in CHANNELS}, list(remarks)
    if np.isfinite(channel["fs"]).any():
        channel["Rf"] = np.full(length, np.nan)  # follows from it
    for each in CHANNELS:
        channel[each], found = _without_voids(place, name, each, channel[each])
        notes += found
    depth, upward = _downward(place, name, channel["depth"], drilled)
    notes += upward
    cone = np.where(np.isfinite(channel["qc"]), channel["qc"], channel["qt"])
    good = np.isfinite(depth) & np.isfinite(cone) & (depth >= max(drilled, 0.0)) & (cone > 0.0)
    if drilled > 0.0:
        notes.append(f"rows above the pre-drilled depth of {drilled:g} m are left out")
    elif above := int((depth < 0.0).sum()):
        notes.append(f"{above} rows above mudline are left out")
    if good.sum() < 3:
        below = f" below the pre-drilled depth of {drilled:g} m" if drilled > 0.0 else ""
        message = f"{name}: {int(good.sum())} rows with depth and cone resistance{below}: a CPT needs three at least"
        raise refused(None, message, place)
    notes += _order(place, name, depth[good])
    if count := int((cone < 0.0).sum()):
        least = f"{1e-3 * np.nanmin(cone):.3g} kPa"
        notes.append(f"{count} cone resistances are negative, down to {least}: is the zero of the cone right?")
    sleeve = np.where(np.isfinite(channel["fs"]), channel["fs"], channel["Rf"] * cone)
    if np.isfinite(sleeve[good]).any() and (count := int((~(sleeve[good] > 0.0)).sum())):
        notes.append(f"{count} rows without positive sleeve friction have no I_c")
    sleeve = np.where(sleeve > 0.0, sleeve, np.nan)
    _refuse_units(place, name, depth[good], cone[good], sleeve[good], channel["u2"][good])
    if missing := int((~good & (np.nan_to_num(depth, nan=drilled) >= drilled)).sum()):
        notes.append(f"{missing} of {length} rows without depth or positive cone resistance are left out")
    order = np.flatnonzero(good)[np.argsort(depth[good], kind="stable")]
    pressure, found = _pressure(depth[order], channel["u2"][order])
    notes += [*found, *_from_the_sea(depth[order], cone[order], sleeve[order], pressure)]
    by_row = given.get("area ratio", np.full(length, np.nan))[order]
    by_row = cone[order] + pressure * (1.0 - np.where((by_row >= 0.1) & (by_row <= 1.0), by_row, np.nan))
    corrected = np.where(np.isfinite(channel["qt"][order]), channel["qt"][order], by_row)
    area_ratio, found = _area_ratio(area_ratio, pressure, corrected)
    return Sounding(
        place, name, depth[order], cone[order], sleeve[order], pressure, corrected, area_ratio, (*notes, *found)
    )


def _area_ratio(ratio: float | None, pressure: Array, corrected: Array) -> tuple[float | None, list[str]]:
    """Return the area ratio that counts, and notes on it, from u2 and q_t (n,) that are given."""
    notes = []
    if ratio is not None and not 0.1 <= ratio <= 1.0:
        notes.append(f"the area ratio {ratio:g} of the file is no share of 0.1 to 1: it does not count")
        ratio = None
    if not np.isfinite(pressure).any() and not np.isfinite(corrected).any():
        notes.append("no pore pressure u2: q_t = q_c, which is too small in soft clay")
    elif ratio is None and not np.isfinite(corrected).any():
        notes.append(f"no area ratio of the cone: {AREA_RATIO:g} is assumed (--area-ratio)")
    return ratio, notes


def usable(tests: Iterable[Callable[[], Sounding]]) -> list[Sounding]:
    """Return the tests of a file; one that is refused does not hold up the others, with a warning.

    Raises UserInputError: all are refused.
    """
    found, wrong = list[Sounding](), list[Problem]()
    for make in tests:
        try:
            found.append(make())
        except UserInputError as error:
            wrong += error.problems
    if wrong and not found:
        raise UserInputError(wrong)
    for problem in wrong:
        warnings.warn(f"left out: {problem}", TableNote, stacklevel=2)
    return found


def _pressure(depth: Array, pressure: Array) -> tuple[Array, list[str]]:
    """Return u2 (n,) Pa with its gaps filled between neighbours, and notes on it."""
    known, notes = np.isfinite(pressure), []
    if known.any() and not known.all():
        pressure = np.interp(depth, depth[known], pressure[known], left=np.nan, right=np.nan)
        notes.append(f"{int((~known).sum())} rows without u2: between its neighbours, beyond them q_t = q_c")
    if (count := int((pressure == 0.0).sum())) > MANY * len(depth) and (pressure != 0.0).any():
        notes.append(f"{count} rows have a u2 of exactly 0: not measured?")
    if known.any() and np.nanmax(np.abs(pressure)) < LEAST_PRESSURE * WATER * depth.max():
        share = f"{LEAST_PRESSURE:.0%} of the hydrostatic pressure"
        notes.append(f"u2 is below {share} everywhere: not measured, or its unit?")
    return pressure, notes


def _from_the_sea(depth: Array, cone: Array, sleeve: Array, pressure: Array) -> list[str]:
    """Return a note on pressures u_2 (Pa) that are above the hydrostatic one in sand, or above q_c at mudline."""
    over, top = pressure - WATER * depth, depth <= 1.0
    sand = (cone > OF_SAND[0]) & (sleeve < OF_SAND[1] * cone) & np.isfinite(over)
    own = sand if sand.any() else top & np.isfinite(over)
    level = _median(over[own], 0.0)
    if level <= OF_WATER or (not sand.any() and _median((over - cone)[own], 0.0) <= 0.0):
        return []
    where = "in sand" if sand.any() else "at mudline"
    text = f"u2 is {1e-3 * level:.0f} kPa above the hydrostatic pressure of depths below mudline {where}"
    return [f"{text}: does it count from the water surface? q_c and u2 are 0 at mudline"]


def _without_voids(place: str, test: str, name: str, values: Array) -> tuple[Array, list[str]]:
    """Return a channel with NaN for numbers that stand for no value, and a note on each of them.

    That is a number beyond the size that a test has, or of nines (-9999, 999.25), with more than twice the size of all
    others of its sign. Raises UserInputError: other numbers beyond that size.
    """
    (what, most, unit, factor), out, notes = _SIZES[name], values.copy(), []
    while len(known := np.unique(out[np.isfinite(out)])) > 1:
        code = next((each for each in known[[-1, 0]] if _is_void(float(each), known, most)), None)
        if code is None:
            break
        count = int((out == code).sum())
        notes.append(f"{count} values of {what.removeprefix('a ')} are {code * factor:.6g} {unit}: taken as missing")
        out[out == code] = np.nan
    largest = float(np.nanmax(np.abs(out), initial=0.0))
    if largest > most and name == "Rf":  # where the cone resistance is next to nothing
        notes.append(f"{int((np.abs(out) > most).sum())} values of friction ratio beyond {most:.0%} are left out")
        out[np.abs(out) > most] = np.nan
    elif largest > most:
        value = f"{what} of {largest * factor:.4g} {unit}, beyond {most * factor:g} {unit}"
        raise refused(None, f"{test} has {value}: is the unit right?", place)
    return out, notes


def _is_void(code: float, known: Array, most: float) -> bool:
    """Return whether the largest or the least of the ``known`` numbers stands for no value."""
    nines = re.sub(r"\D", "", f"{abs(code):e}").startswith("999")
    rest = float(np.abs(known[(known != code) & (known * code > 0.0)]).max(initial=0.0))
    return (abs(code) > most or nines) and abs(code) > 2.0 * rest


def _downward(place: str, name: str, depth: Array, drilled: float) -> tuple[Array, list[str]]:
    """Return depths that grow downwards, and a note where they did not.

    Raises UserInputError: elevations above another level than mudline.
    """
    finite = depth[np.isfinite(depth)]
    negative = finite.size > 0 and np.median(finite) < 0.0
    if negative and (finite.max() > ABOVE or -finite.max() > drilled + SUBMERGED):
        raise refused(None, f"{name}: depths are negative and {_elevations(finite)}", place)
    if not negative and are_elevations(finite):
        raise refused(None, f"{name}: depths fall from row to row and {_elevations(finite)}", place)
    return (-depth, ["depths are negative: taken as depths below mudline"]) if negative else (depth, [])


def are_elevations(depth: Array) -> bool:
    """Return whether depths (n,) fall from row to row, as elevations do."""
    steps = np.diff(depth)
    return bool(len(steps) > 1 and (steps < 0.0).mean() > FALLING)


def _elevations(depth: Array) -> str:
    return f"begin at {depth.max():g} m: {ANOTHER_LEVEL}"


def _order(place: str, name: str, depth: Array) -> list[str]:
    """Return a note on rows that are not in the order of their depth. Raises UserInputError: two tests in one."""
    falls = np.flatnonzero(np.diff(depth) < 0.0)
    if not len(falls):
        return []
    runs = np.split(depth, falls + 1)
    if len(falls) <= max(1.0, SHORTEST * len(depth)) and sum(map(np.ptp, runs)) > OVERLAP * np.ptp(depth):
        above, below = depth[falls[0]], depth[falls[0] + 1]
        what = f"{name}: the depth falls from {above:g} to {below:g} m from one row to the next"
        message = f"{what}: several tests in one? name them in a column Location, or give each a file"
        raise refused(None, message, place)
    return ["rows are not in the order of their depth: sorted"]


def _refuse_units(place: str, test: str, depth: Array, cone: Array, sleeve: Array, pressure: Array) -> None:
    """Refuse depths, resistances, frictions and pressures that no test has: their units are wrong."""
    half, half_sleeve, rate = (_median(each, 0.0) for each in (cone, sleeve, cone / np.maximum(depth, 1.0)))
    friction, most = _median(sleeve / cone, 0.01), float(cone.max())
    share = _median(pressure / cone, 0.0)
    for wrong, what in (
        (half > HALF_CONE, f"a cone resistance above {1e-6 * half:.3g} MPa in half of its rows"),
        (half_sleeve > HALF_SLEEVE, f"a sleeve friction above {1e-6 * half_sleeve:.3g} MPa in half of its rows"),
        (most < LEAST_CONE, f"no cone resistance above {1e-3 * most:.3g} kPa"),
        (rate < LEAST_RATE, f"a cone resistance below {1e-3 * rate:.3g} kPa per m of depth in half of its rows"),
        (friction > MOST_FRICTION, f"a sleeve friction of {100.0 * friction:.3g} % of the cone resistance"),
        (friction < LEAST_FRICTION, f"a sleeve friction of only {100.0 * friction:.3g} % of the cone resistance"),
        (share > MOST_PRESSURE, f"a pore pressure u2 of {share:.3g} times the cone resistance"),
    ):
        if wrong:
            raise refused(None, f"{test} has {what}: is the unit right?", place)
    if (end := float(depth.max())) < LEAST_DEPTH:
        message = f"{test} ends at a depth of {end:.3g} m, less than {LEAST_DEPTH:g} m: is the unit right?"
        raise refused(None, message, place)


def _median(values: Array, default: float) -> float:
    """Return the median of what is known."""
    known = np.isfinite(values)
    return float(np.median(values[known])) if known.any() else default


def unit_weight(cone: Array, sleeve: Array) -> Array:
    """Return the total unit weight (n,) in N/m3 from q_t and f_s in Pa.

    Robertson and Cabal (2010): gamma/gamma_w = 0.27 log R_f + 0.36 log(q_t/p_a) + 1.236, R_f = f_s/q_t in %, grains of
    2.65. Held between 11 and 23 kN/m3.
    """
    friction = np.maximum(100.0 * sleeve / cone, 0.1)
    return np.clip(WATER * (0.27 * np.log10(friction) + 0.36 * np.log10(cone / PA) + 1.236), 11.0e3, 23.0e3)


def stresses(depth: Array, weight: Array) -> tuple[Array, Array]:
    """Return s_v0 and s'_v0 (n,) in Pa above hydrostatic water pressure at mudline, from total unit weights (N/m3).

    The water stands at mudline or above it: total stresses count from the pressure there. The weight of the first row
    holds up to mudline.
    """
    steps = np.diff(depth, prepend=0.0)
    means = np.concatenate([weight[:1], 0.5 * (weight[1:] + weight[:-1])])
    total = np.cumsum(steps * means)
    return total, np.maximum(total - WATER * depth, 0.0)


def behaviour_index(net: Array, sleeve: Array, effective: Array) -> Array:
    """Return I_c (n,) from q_t - s_v0, f_s and s'_v0 in Pa; NaN where one is missing or not positive.

    Robertson (2009): I_c = ((3.47 - log Q_tn)^2 + (log F_r + 1.22)^2)^0.5, Q_tn = q_net/p_a (p_a/s'_v0)^n with
    (p_a/s'_v0)^n at most 1.7, F_r = f_s/q_net in %, n = 0.381 I_c + 0.05 s'_v0/p_a - 0.15, at most 1.
    """
    good = (net > 0.0) & (sleeve > 0.0)
    stress = np.maximum(effective, LEAST_STRESS) / PA
    friction = np.log10(np.where(good, 100.0 * sleeve / np.where(good, net, 1.0), 1.0)) + 1.22
    index = np.full(net.shape, 2.5)
    for _ in range(40):
        exponent = np.clip(0.381 * index + 0.05 * stress - 0.15, 0.0, 1.0)
        factor = np.minimum(stress**-exponent, 1.7)
        index = np.hypot(3.47 - np.log10(np.where(good, net / PA * factor, 1.0)), friction)
    return np.where(good, index, np.nan)


# Robertson (2009), zones of the index: upper end, name
ZONES = (
    (1.31, "gravelly sand to dense sand"), (2.05, "sand to silty sand"), (2.60, "silty sand to sandy silt"),
    (2.95, "clayey silt to silty clay"), (3.60, "clay to silty clay"), (np.inf, "organic clay or peat"),
)  # fmt: skip
SAND_TO = 2.60  # largest index of soil that drains while the cone passes
TRANSITION = (2.5, 2.7)  # partially drained


def zone_name(index: float) -> str:
    """Return the name of the soil behaviour type of an index."""
    return next(name for end, name in ZONES if index < end)


SCATTER = (0.25, 0.35)  # usual deviations of I_c and of ln(q_net/s'^0.5) within one layer
PRICE = 3.0  # m
THINNEST = 0.5  # m
SURFACE = 10.0e3  # Pa, added to s'_v0: resistances at mudline are finite
CELLS, CELL = 400, 0.1  # at most, and height of a cell at least [m]


def boundaries(depth: Array, index: Array, net: Array, effective: Array, most: int) -> list[float]:
    """Return the depths (m) between layers of rows (n,), from I_c, q_net and s'_v0 [Pa].

    Rows without an index, or with q_net below 0, do not count.

    ``most`` is the largest number of layers: the price of a layer grows until it is kept.
    """
    edges, values = _cells(depth, index, net / np.sqrt(effective + SURFACE))
    if len(values) < 4:
        return []
    misfit, price = _misfits(edges, values), PRICE
    while True:
        cuts = _partition(misfit, price, edges)
        if len(cuts) < most:
            return [float(edges[k]) for k in cuts]
        price *= 1.3


def _cells(depth: Array, index: Array, net: Array) -> tuple[Array, Array]:
    """Return edges (m + 1,) of cells with values, half of a gap in each, and medians (m, 2) of I_c and ln ``net``."""
    height = max(CELL, float(depth[-1] - depth[0]) / CELLS)
    at = np.floor((depth - depth[0]) / height + 1e-9).astype(int)
    good = np.isfinite(index) & (net > 0.0)
    edges, values = [float(depth[0])], []
    cells = np.unique(at[good])
    for cell, below in zip(cells, np.append(cells[1:], cells[-1:] + 1), strict=True):
        rows = good & (at == cell)
        values.append([float(np.median(index[rows])), float(np.median(np.log(net[rows])))])
        edges.append(min(float(depth[0] + 0.5 * (cell + 1 + below) * height), float(depth[-1])))
    return np.array(edges), np.array(values)


def _misfits(edges: Array, values: Array) -> Array:
    """Return the misfit (m, m + 1) in m of one layer from the top of cell i to the top of cell j."""
    weight, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1]) - edges[0]
    index, cone = values.T
    terms = [np.ones_like(index), middle, middle**2, index, index**2, cone, cone**2, cone * middle]
    sums = [np.concatenate([[0.0], np.cumsum(weight * term)]) for term in terms]
    w, z, zz, a, aa, b, bb, bz = (each[None, :] - each[:-1, None] for each in sums)
    w = np.where(w > 0.0, w, np.nan)
    constant = aa - a * a / w
    spread, common = zz - z * z / w, bz - b * z / w
    slope = np.where(spread > 1e-9, common / np.maximum(spread, 1e-9), 0.0)
    linear = bb - b * b / w - slope * common
    out = np.maximum(constant, 0.0) / SCATTER[0] ** 2 + np.maximum(linear, 0.0) / SCATTER[1] ** 2
    thin = edges[None, :] - edges[:-1, None] < THINNEST - 1e-9
    return np.where(thin | ~np.isfinite(out), np.inf, out)


def _partition(misfit: Array, price: float, edges: Array) -> list[int]:
    """Return the cells at whose top a layer begins, without the first."""
    cells = misfit.shape[0]
    best, origin = np.full(cells + 1, np.inf), np.zeros(cells + 1, dtype=int)
    best[0] = -price
    for end in range(1, cells + 1):
        sums = best[:end] + misfit[:end, end] + price
        origin[end] = int(np.argmin(sums))
        best[end] = sums[origin[end]]
    cuts, at = [], cells
    while np.isfinite(best[at]) and origin[at] > 0:
        at = int(origin[at])
        cuts.append(at)
    return cuts[::-1]
