# SPDX-License-Identifier: MIT
"""Layers with low, best and high values, proposed from a cone penetration test, points by depth, or layers.

In each layer every correlation gives a line by depth, or a mean; low, best and high are the least, the middle and the
greatest of them. That is the range of the mean of a layer, not the scatter of single rows. Measured values, and those
of a table of layers, take the place of correlations.
"""

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.text import suggestion
from pysprings.core.words import ESTIMATES
from pysprings.scene.by_depth import WEAKER
from pysprings.scene.defaults import beyond_common
from pysprings.scene.profile_table import WATER
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS, STIFFNESSES
from pysprings.scene.soils.clay import FACTORS, VonMises, small_strain_modulus
from pysprings.site.correlations import (
    CONE_FACTORS,
    CRITICAL,
    FOUR_SANDS,
    KARLSRUHE,
    LEAST_OCR,
    MOST_OCR,
    SAND,
    Correlation,
    Rows,
    clay,
    dilation,
    overconsolidation,
    small_strains,
)
from pysprings.site.files import Bed, Points, Site
from pysprings.site.sounding import (
    LEAST_STRESS,
    SAND_TO,
    TRANSITION,
    Sounding,
    behaviour_index,
    boundaries,
    stresses,
    unit_weight,
    zone_name,
)

# by depth; the others are means of a layer
LINEAR = ("undrained_shear_strength", "shear_modulus", "young_modulus", "cohesion")
_HALF, _OCR, _WEIGHT = "strain_at_half_strength", "overconsolidation_ratio", "effective_unit_weight"
WITH_STRAIN = ("degradation_strain", _HALF)  # for stiffnesses of small strains alone
FLOORS = {"shear_modulus": 0.2}  # least share by which low and high are off: correlations that agree are no proof
# of points, not used: stiffnesses of the strains of the load, and values that differ by decades
_NOT_OF_POINTS = {*STIFFNESSES, _OCR, "hydraulic_conductivity"} - {"shear_modulus"}
MARKED = 0.1  # share of rows outside the range of a correlation from which it is marked
ROUNDING = 1.0e-9  # of the largest value of a line: less is 0
LEAST_SHARE = 0.02  # of the largest value of a line, where points have no ratio to it
MOST_NAMED = 60  # characters of a name
_FORMULA = "=+-@ "  # a spreadsheet would read what begins so as a formula
STATIONS = 20  # depths of a layer at which OCR follows from su
FEWEST_POINTS = 3  # in a layer, for a range
LONGEST, MOST_GAPS, ROUND = 0.5, 3, 0.01  # m without rows that is not stated; how many are named; m of a last layer
_WORDS = {"sand": r"sands?|gravels?|zand|grind|kies", "clay": r"clays?|silts?|peat|mud|till|klei|veen|ton|schluff"}
_CAPITALS = re.compile(r"\b[A-Z]{3,}\b")  # of the principal soil in descriptions


@dataclass(frozen=True)
class Value:
    """A value of a layer: low, best, high (3,) at top and bottom (2,) in SI, where from, what is outside its range.

    ``measured`` : a file gives it, no correlation.
    """

    lines: Array
    sources: tuple[str, ...]
    outside: tuple[str, ...] = ()
    measured: bool = False


@dataclass
class Unit:
    """A proposed layer: ends [m], name, "sand" or "clay", median I_c, rows of the test, law, values by key.

    ``remark`` : of the layer in a file, which stays with it.  ``unknown`` : lengths without rows, sand in clay.
    """

    top: float
    bottom: float
    name: str
    kind: str
    index: float = np.nan
    rows: int = 0
    law: str = ""
    values: dict[str, Value] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    remark: str = ""
    unknown: str = ""

    @property
    def written(self) -> dict[str, Value]:
        """Values that its law uses; where the law gives the stiffness, that of a file alone."""
        by_law = {"shear_modulus", "degradation_strain"} if SOIL_LAWS[self.law].gives_stiffness else set()
        unused = self.unused
        return {
            key: value for key, value in self.values.items()
            if key not in unused and (value.measured or key not in by_law)
        }  # fmt: skip

    @property
    def unused(self) -> dict[str, str]:
        """Why its law does not use values, by key."""
        law = SOIL_LAWS[self.law]
        why = dict.fromkeys({*LAW_KEYS} - {*law.keys, *law.unused}, f"law {self.law} does not use it")
        first, *others = [key for key in law.stiffnesses if key in self.values] or [""]
        why |= dict.fromkeys(others, f"{first} gives the stiffness")
        if "plasticity_index" in others:
            why[_OCR] = why["plasticity_index"]
        if isinstance(law, VonMises) and not law.hardens and {*FACTORS} & self.values.keys():
            why[_HALF] = f"law {self.law} with factors of su is elastic up to su; iwan-clay takes both"
        return why


@dataclass(frozen=True)
class Proposal:
    """Layers from mudline down, the test and its rows, points beside them, what was assumed, N_kt of su."""

    units: list[Unit]
    sounding: Sounding | None
    rows: Rows
    depth: Array
    points: Points | None
    notes: list[str]
    cone_factors: tuple[float, float, float] = CONE_FACTORS


@dataclass(frozen=True)
class Options:
    """Choices of a person.

    test : by name.  area_ratio : of the cone.  cone_factors : N_kt for su high, best, low.  most : layers at most.
    depth : to which a test counts [m].
    """

    test: str | None = None
    area_ratio: float | None = None
    cone_factors: tuple[float, float, float] = CONE_FACTORS
    most: int = 10
    depth: float = np.inf


def propose(site: Site, options: Options) -> Proposal:
    """Return layers and values for what the files hold.

    Raises UserInputError: several tests and none chosen; no layers where the test has no sleeve friction; nothing that
    gives a value.
    """
    chosen, site = _chosen(site.soundings, options), site.down_to(options.depth)
    if chosen is not None:
        (rows, odd), depth = _rows(chosen, site.beds, site.points), chosen.depth
        units = _units(chosen, rows, site.beds, options.most)
        notes = [*chosen.notes, *odd, "stresses count from mudline down, with water above it"]
    else:
        units, notes = _units_of_tables(site), []
        depth, rows = _ends_as_rows(units, site)
    of = np.repeat(np.arange(len(units)), 2) if chosen is None else layers_of(units, depth)
    of_points = layers_of(units, site.points.depth if site.points else np.empty(0))
    for k, unit in enumerate(units):
        _fill(unit, rows, depth, of == k, site, of_points == k, options)
    notes += [*site.notes, *_below(depth if chosen else np.empty(0), "rows of the test", units)]
    notes += _below(site.points.depth if site.points else np.empty(0), "points", units)
    if not any(set(unit.values) & {"friction_angle_final", "undrained_shear_strength", *STIFFNESSES} for unit in units):
        places = [each.place for each in (*site.beds, site.points) if each]
        message = "gives neither strength nor stiffness nor relative density: add columns su, phi, Dr, Gmax or E"
        raise refused(None, message, places[0])
    notes = [*notes, *_cone_factor(rows, depth, units, site)]
    return Proposal(units, chosen, rows, depth, site.points, notes, options.cone_factors)


def _below(depth: Array, what: str, units: Sequence[Unit]) -> list[str]:
    """Return a sentence on rows or points below the last layer."""
    count = int((depth > units[-1].bottom + ROUND).sum())
    return [f"{count} {what} below the last layer are not used"] if count else []


def _chosen(soundings: Sequence[Sounding], options: Options) -> Sounding | None:
    """Return the test that is chosen; None where there is none."""
    found = [each for each in soundings if options.test in (None, each.name)]
    names = ", ".join(known := [each.name for each in soundings])
    if options.test is not None and not found:
        raise refused(
            "--test", f"no test '{options.test}'{suggestion(options.test, known)}; there are: {names or 'none'}"
        )
    if len(found) > 1:
        raise refused("--test", f"choose one of the {len(found)} tests: {names}")
    if not found:
        return None
    chosen = found[0].down_to(options.depth)
    if options.area_ratio is None:
        return chosen
    notes = tuple(each for each in chosen.notes if "--area-ratio" not in each)
    if count := int(np.isfinite(chosen.corrected).sum()):
        notes += (f"--area-ratio does not count in {count} of {len(chosen.depth)} rows: the file gives their q_t",)
    return replace(chosen, area_ratio=options.area_ratio, notes=notes)


def _rows(test: Sounding, beds: Sequence[Bed], points: Points | None) -> tuple[Rows, list[str]]:
    """Return what correlations read, and a note where it has a unit weight of other depths.

    Unit weights are those of the layers that give one, elsewhere between points that do, else of Robertson and Cabal
    (2010).
    """
    depth, sleeve = test.depth, test.sleeve
    weight = np.full(depth.shape, np.nan)
    if points is not None and (measured := points.values.get(_WEIGHT)) is not None:
        order = np.argsort(points.depth)
        order = order[np.isfinite(measured[order])]
        if len(order) >= FEWEST_POINTS:
            weight = np.interp(depth, points.depth[order], measured[order] + WATER, left=np.nan, right=np.nan)
    of = layers_of(beds, depth)
    for k, bed in enumerate(beds):
        if _WEIGHT not in bed.values:
            continue
        own = of == k
        ends = [value + WATER for value in bed.values[_WEIGHT]]
        weight[own] = np.interp(depth[own], [bed.top, bed.bottom], ends)
    if (good := np.isfinite(sleeve)).any():
        whole = unit_weight(test.total_cone, np.interp(depth, depth[good], sleeve[good]))
        weight = np.where(np.isfinite(weight), weight, whole)
    if not (known := np.isfinite(weight)).any():
        raise _no_sleeve(test, "Total unit weight [kN/m3] and Soil type")
    count = int((~known & (depth <= max((bed.bottom for bed in beds), default=0.0))).sum())
    text = f"{count} rows without sleeve friction in layers without unit weight: stresses with that of their neighbours"
    total, effective = stresses(depth, np.interp(depth, depth[known], weight[known]))
    cone = test.total_cone
    index = behaviour_index(cone - total, sleeve, effective)
    return Rows(cone, sleeve, total, effective, weight, index, np.full(depth.shape, np.nan)), [text] * (count > 0)


def _no_sleeve(test: Sounding, what: str) -> Exception:
    text = f"the test has no sleeve friction: give the layers of a borehole as a second file, with {what}"
    return refused(None, text, test.place)


def _units(test: Sounding, rows: Rows, beds: Sequence[Bed], most: int) -> list[Unit]:
    """Return the layers of a test: those of a table, or proposed ones, without values."""
    if beds:
        own = layers_of(beds, test.depth)
        return [_unit(bed, rows.index[own == k]) for k, bed in enumerate(beds)]
    if np.isfinite(rows.index).mean() < 0.3:
        raise _no_sleeve(test, "Soil type")
    cuts = boundaries(test.depth, rows.index, rows.net, rows.effective, most)
    ends = [0.0, *(round(each, 1) for each in cuts), round(float(test.depth[-1]), 2)]
    units, of = [], np.digitize(test.depth, ends[1:-1])
    for k, (top, bottom) in enumerate(itertools.pairwise(ends)):
        own = rows.index[of == k]
        index = float(np.nanmedian(own)) if np.isfinite(own).any() else SAND_TO
        units.append(Unit(top, bottom, zone_name(index), "sand" if index <= SAND_TO else "clay"))
    return units


def _gaps(unit: Unit, depth: Array) -> str:
    """Return in words where a layer has no rows over more than `LONGEST`; blank where there is no such length."""
    levels = np.concatenate([[unit.top], depth, [unit.bottom]])
    parts = [f"{a:.4g} to {b:.4g} m" for a, b in itertools.pairwise(levels.tolist()) if b - a > LONGEST]
    more = f" and {len(parts) - MOST_GAPS} more" if len(parts) > MOST_GAPS else ""
    return f"nothing measured from {', '.join(parts[:MOST_GAPS])}{more}" if parts else ""


def _unit(bed: Bed, index: Array) -> Unit:
    """Return a layer of a table, without values."""
    name = bed.name.lstrip(_FORMULA) or "layer"
    short = name if len(name) <= MOST_NAMED else f"{name[: MOST_NAMED - 3]}..."
    kind, remark = _kind(bed, index)
    return Unit(bed.top, bed.bottom, short, kind, remarks=[remark] if remark else [])


def layers_of(layers: Sequence[Unit] | Sequence[Bed], depth: Array) -> Integers:
    """Return the number of the layer of each depth (n,) in m, that below at a boundary; -1 where there is none."""
    tops, bottoms = (np.array([getattr(each, name) for each in layers]) for name in ("top", "bottom"))
    numbers = np.searchsorted(tops, depth, side="right") - 1
    return np.where(depth <= np.append(bottoms, -np.inf)[numbers], numbers, -1)  # that of -1 is the last, -inf


def _kind(bed: Bed, index: Array) -> tuple[str, str]:
    """Return "sand" or "clay" from the name of a layer, from its values, or from I_c, with a remark on the last one.

    Raises UserInputError: all leave it open.
    """
    remark = ""
    for text in (" ".join(_CAPITALS.findall(bed.name)), bed.name):
        kinds = [kind for kind, words in _WORDS.items() if re.search(rf"\b({words})\b", text.lower())]
        if len(kinds) == 1:
            break
    if len(kinds) != 1:
        sandy = not {"relative_density", "friction_angle_final"}.isdisjoint(bed.values)
        kinds = ["clay"] * ("undrained_shear_strength" in bed.values) + ["sand"] * sandy
    if len(kinds) != 1 and np.isfinite(index).any():
        kinds = ["sand" if np.nanmedian(index) <= SAND_TO else "clay"]
        remark = f"taken as {kinds[0]} by its I_c: the soil type names neither sand nor clay, or both"
    if len(kinds) != 1:
        message = f"'{bed.name}': sand or clay? write one of the two as the soil type of a layer"
        raise UserInputError([Problem(bed.place, bed.line, message=message)])
    return kinds[0], remark


def _units_of_tables(site: Site) -> list[Unit]:
    """Return the layers of a table, or one layer around points, without values."""
    none = np.array([np.nan])
    if site.beds:
        return [_unit(bed, none) for bed in site.beds]
    if site.points is None:
        raise refused("--depth", "the files hold nothing above it")
    keys = dict.fromkeys(site.points.values, (0.0, 0.0))
    bottom = float(site.points.depth.max())
    kind, _ = _kind(Bed(site.points.place, None, 0.0, bottom, "points without layers", keys), none)
    return [Unit(0.0, bottom, kind, kind)]


def _ends_as_rows(units: Sequence[Unit], site: Site) -> tuple[Array, Rows]:
    """Return the ends of layers as rows without cone resistance: stresses from the unit weights that are given."""
    depth = np.array([z for unit in units for z in (unit.top, unit.bottom)])
    beds = {(bed.top, bed.bottom): bed.values for bed in site.beds}
    none = (np.nan, np.nan)
    weights = [v for unit in units for v in beds.get((unit.top, unit.bottom), {}).get("effective_unit_weight", none)]
    measured = site.points.values.get("effective_unit_weight") if site.points else None
    mean = np.nan if measured is None else float(np.nanmean(measured))
    weight = np.where(np.isfinite(weights), weights, mean) + WATER
    total, effective = stresses(depth, weight)
    nothing = np.full(depth.shape, np.nan)
    return depth, Rows(nothing, nothing, total, effective, weight, nothing, nothing)


def _fill(
    unit: Unit, rows: Rows, depth: Array, own: Marks, site: Site, own_points: Marks, options: Options
) -> None:  # fmt: skip
    """Put values into a layer, of its own rows and points: given, measured and correlated ones; choose its law."""
    part = rows.part(own)
    unit.rows = int(np.isfinite(part.cone).sum())
    unit.index = float(np.nanmedian(part.index)) if np.isfinite(part.index).any() else np.nan
    if TRANSITION[0] < unit.index < TRANSITION[1]:
        unit.remarks.append(f"I_c {unit.index:.2f}: partially drained; neither drained sand nor undrained clay is sure")
    unit.unknown = _gaps(unit, depth[own & np.isfinite(rows.cone)]) if unit.rows else ""
    ends, correlations = np.array([unit.top, unit.bottom]), SAND if unit.kind == "sand" else clay(options.cone_factors)
    _given(unit, site.beds)
    if site.points is not None:
        _measured(unit, site.points, own_points, ends, {each.gives for each in correlations} if unit.rows else set())
    if own.any():
        counted = _without_sand(unit, own, rows.index)
        _correlated(unit, rows.part(counted), depth[counted], ends, correlations)
    phi = unit.values.get("friction_angle_final")
    by_density = "relative_density" in unit.values and not (phi and phi.measured)
    unit.law = unit.law or ("tresca" if unit.kind == "clay" else "sand" if by_density else "van-eekelen")
    _derived(unit)
    if {"plasticity_index", "undrained_shear_strength"} <= unit.written.keys():
        _consolidated(unit, part.effective, depth[own])
    _remark(unit)


def _without_sand(unit: Unit, own: Marks, index: Array) -> Marks:
    """Return which rows of a layer count: in clay none that is sand by its I_c, where more than half is none."""
    sandy = own & (index < TRANSITION[0])
    if unit.kind != "clay" or not (share := sandy.sum() / own.sum()) < 0.5:
        return own
    text = f"{share:.0%} of the rows are sand (I_c below {TRANSITION[0]:g}) and do not count" if share > MARKED else ""
    unit.unknown = "; ".join(filter(None, (unit.unknown, text)))
    return own & ~sandy


def _consolidated(unit: Unit, effective: Array, depth: Array) -> None:
    """Put the OCR of su over s'_v0 (n,) in Pa at depths (n,) in m beside I_p; an OCR of a file stays.

    G_max of an OCR that su does not have makes the clay too soft, elastic beyond gamma_50 at last: that has a remark.
    """
    if not (known := np.isfinite(effective)).any():
        unit.remarks += ["no unit weight, so no OCR of su/s'_v0: a scene takes 1"] * (_OCR not in unit.values)
        return
    ends, share = np.array([unit.top, unit.bottom]), (np.arange(STATIONS) + 0.5) / STATIONS
    shares = np.stack([1.0 - share, share])
    inside, strength = ends @ shares, unit.values["undrained_shear_strength"].lines @ shares
    stress = np.maximum(np.interp(inside, depth[known], effective[known]), LEAST_STRESS)
    ratios = overconsolidation(strength, stress)
    if _OCR not in unit.values:
        lines = [np.polyval(np.polyfit(inside, each, 1, w=1.0 / each), ends) for each in ratios]  # of relative errors
        unit.values[_OCR] = Value(np.clip(lines, LEAST_OCR, MOST_OCR), ("Jamiolkowski et al. 1985, from su/s'_v0",))
    if _HALF not in unit.written:
        return
    given, half = (unit.values[each].lines @ shares for each in (_OCR, _HALF))
    least = 0.5 * strength / small_strain_modulus(stress, unit.values["plasticity_index"].lines @ shares, given)
    k, at = np.unravel_index(np.argmax(least / half), least.shape)
    if least[k, at] > half[k, at]:
        unit.remarks.append(
            f"gamma_50 {ESTIMATES[k]}, {half[k, at]:.3g}, is below su/(2 G), {least[k, at]:.3g}, of G_max with OCR "
            f"{given[k, at]:.3g} at {inside[at]:.3g} m: a scene refuses it; su/s'_v0 is that of OCR {ratios[k, at]:.3g}"
        )


def _remark(unit: Unit) -> None:
    """Add what a file gives and the law does not use, and what is missing."""
    law, written, unused = SOIL_LAWS[unit.law], unit.written, unit.unused
    unit.remarks += [unit.unknown] if unit.unknown else []
    for key, value in unit.values.items():
        odd = dict.fromkeys(filter(None, (beyond_common(key, float(each)) for each in value.lines[1])))
        unit.remarks.extend(f"{key}: {text}" for text in odd if value.measured)
        if value.measured and key not in written:
            unit.remarks.append(f"{key} ({value.sources[0]}) is not written: {unused[key]}")
    if law.gives_stiffness and "shear_modulus" in written:
        unit.remarks.append("shear_modulus of a file stays as it is: G does not follow the stress")
    missing = [key for key in law.needs if key not in {*written, *law.defaults}]
    missing += ["shear_modulus"] * (not law.gives_stiffness and written.keys().isdisjoint(STIFFNESSES))
    if missing:
        unit.remarks.append(f"nothing gives {', '.join(missing)}: fill it in")


def _given(unit: Unit, beds: Sequence[Bed]) -> None:
    for bed in beds:
        if (bed.top, bed.bottom) == (unit.top, unit.bottom):
            unit.law, unit.remark = bed.law, bed.remark.lstrip(_FORMULA)
            for key, line in bed.values.items():
                unit.values[key] = Value(np.tile(line, (3, 1)), ("given, without a range",), measured=True)


def _measured(unit: Unit, points: Points, inside: Marks, ends: Array, correlated: set[str]) -> None:
    """Put the line through the points inside into a layer, low and high at a tenth and nine tenths of ratios to it.

    Fewer points than `FEWEST_POINTS` count only for keys that are not ``correlated`` with a test beside them.
    """
    for key, values in points.values.items():
        own = inside & np.isfinite(values)
        count = int(own.sum())
        if not count:
            continue
        rivals = [each for each in (STIFFNESSES if key in STIFFNESSES else (key,)) if each in unit.values]
        if rivals or key in _NOT_OF_POINTS:
            given = "it" if key in rivals else ", ".join(rivals)
            why = f"the table of layers gives {given}" if rivals else "it counts in a table of layers alone"
            unit.remarks.append(f"{count} measured {key}: not used, {why}")
            continue
        if count < FEWEST_POINTS and key in correlated:
            unit.remarks.append(f"{count} measured {key}: too few for a line, drawn alone")
            continue
        best = _line(points.depth[own], values[own], ends, key)
        line = np.interp(points.depth[own], ends, best)
        some = np.abs(line) > LEAST_SHARE * np.abs(line).max()  # none where the line is 0
        ratios = values[own][some] / line[some] if some.any() else np.ones(1)
        low, high = np.percentile(ratios, [10.0, 90.0]) if count >= FEWEST_POINTS else np.ones(2)
        shares = min(low, 1.0), 1.0, max(high, 1.0)
        if count < FEWEST_POINTS:
            unit.remarks.append(f"{count} measured {key}: no range")
        lines = np.outer(shares[::-1] if key in WEAKER else shares, best)
        first, last = points.depth[own].min(), points.depth[own].max()
        unit.values[key] = Value(lines, (f"{count} measured values, {first:.4g} to {last:.4g} m",), measured=True)


def _correlated(unit: Unit, rows: Rows, depth: Array, ends: Array, correlations: Sequence[Correlation]) -> None:
    """Put the least, middle and greatest line of correlations into a layer, key by key.

    A correlation with most rows outside its range counts only where fewer than two are inside. A stiffness that is
    given as Young's modulus or G/su is that of the strains of the load, and stays alone.
    """
    given = set(unit.values) & {*STIFFNESSES}
    of_strains = given - {"shear_modulus", "plasticity_index"}  # whose G_max is that of small strains
    for key in dict.fromkeys(each.gives for each in correlations):
        if (given and key == "shear_modulus") or (of_strains and key in WITH_STRAIN):
            continue
        found: list[tuple[Array, Correlation, float, float]] = []
        for each in (each for each in correlations if each.gives == key and key not in unit.values):
            values = each.of(rows)
            if (good := np.isfinite(values)).any():
                line = _line(depth[good], values[good], ends, key)
                counts, inside = good | (rows.net <= 0.0), each.inside(rows) & good  # no q_net: outside
                stated = 1.0 - float((inside & each.free(rows))[counts].mean())
                found.append((line, each, 1.0 - float(inside[counts].mean()), stated))
        if key == "relative_density" and key in unit.values:
            rows = rows.with_density(np.interp(depth, ends, unit.values[key].lines[1]))
        if not found:
            continue
        few = [each for each in found if each[2] <= 0.5]
        counted = few if len(few) > 1 else found
        fewer = len(counted) < len(found)
        lines = np.array([line for line, *_ in counted])
        best, least = np.median(lines, axis=0), FLOORS.get(key, 0.0)
        low, high = (
            np.minimum(lines.min(axis=0), (1.0 - least) * best),
            np.maximum(lines.max(axis=0), (1.0 + least) * best),
        )
        three = np.array([low, best, high])
        outside = tuple(
            f"{each.name} ({each.range}) in {stated:.0%} of the rows" + ", left out" * (fewer and share > 0.5)
            for _, each, share, stated in found if stated > MARKED
        )  # fmt: skip
        names = tuple(each.name for _, each, *_ in counted)
        unit.values[key] = Value(three[::-1] if key in WEAKER else three, names, outside)
        if key == "relative_density":
            rows = rows.with_density(np.interp(depth, ends, three[1]))


def _line(depth: Array, values: Array, ends: Array, key: str) -> Array:
    """Return the values (2,) at the ends of a layer: a line by least squares without its outliers, or the mean twice.

    A line needs values over half of the layer. Beyond the data it stays between half of the least and twice the
    greatest value that counts.
    """
    if key not in LINEAR or len(values) < FEWEST_POINTS or np.ptp(depth) < 0.5 * (ends[1] - ends[0]):
        return np.full(2, float(np.mean(values)))
    keep = np.full(depth.shape, True)
    for _ in range(2):
        slope, level = np.polyfit(depth[keep], values[keep], 1)
        off = np.abs(values - level - slope * depth)
        keep = off <= 2.0 * np.std(off[keep]) + np.mean(off[keep])
    line = np.clip(level + slope * ends, 0.5 * values[keep].min(), 2.0 * values[keep].max())
    return np.where(np.abs(line) > ROUNDING * np.abs(line).max(), line, 0.0)


def _derived(unit: Unit) -> None:
    """Put what follows from friction angles of sand into a layer: dilation, K0; a value of a file stays."""
    name, phi = "phi", unit.values.get("friction_angle_final")
    if unit.kind == "sand" and phi is not None:
        unit.values.setdefault("dilation_angle", Value(dilation(phi.lines), ("Bolton 1986, from phi",)))
    if unit.law == "sand" and "relative_density" in unit.values:
        density = unit.values["relative_density"].lines
        odd = not FOUR_SANDS[0] <= density[2].mean() <= FOUR_SANDS[1]
        outside = ("Brinkgreve et al. 2010 (D_r 0.4 to 0.8) in 100% of the rows",) if odd else ()
        sources = (f"low, best: {KARLSRUHE}", "high: Brinkgreve et al. 2010")
        for key, lines in small_strains(density).items():
            unit.values.setdefault(key, Value(lines, sources, outside))
    if unit.law == "sand":
        name, phi = "phi_crit", unit.values.get("critical_friction_angle", Value(np.full((3, 2), CRITICAL), ()))
    if unit.kind == "sand" and phi is not None:
        at_rest = np.full((3, 2), 1.0 - np.sin(phi.lines[1].mean()))
        unit.values.setdefault("K0", Value(at_rest, (f"1 - sin {name} (Jaky 1944), normally consolidated",)))


def _cone_factor(rows: Rows, depth: Array, units: Sequence[Unit], site: Site) -> list[str]:
    """Return a sentence on N_kt from measured su beside the net cone resistance of the test."""
    su = site.points.values.get("undrained_shear_strength") if site.points else None
    if su is None or site.points is None or not np.isfinite(rows.cone).any():
        return []
    factors = [
        float(np.interp(z, depth, rows.net) / each)
        for z, each, k in zip(site.points.depth, su, layers_of(units, site.points.depth), strict=True)
        if np.isfinite(each) and depth[0] <= z <= depth[-1] and k >= 0 and units[k].kind == "clay"
    ]  # fmt: skip
    if not factors:
        return []
    low, middle, high = np.percentile(factors, [10.0, 50.0, 90.0])
    spread = f"{low:.3g} to {high:.3g} in most of {len(factors)} tests" if len(factors) > 2 else f"{len(factors)} tests"
    return [f"measured su beside q_net: N_kt {middle:.3g} ({spread}); --nkt uses others than the usual ones"]
