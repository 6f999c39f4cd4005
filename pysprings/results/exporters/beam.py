# SPDX-License-Identifier: MIT
"""One set of curves for beam programs: p(y) of the pure translation, m(rotation) of the pure rotation, tip and lid.

The families are those of the PISA project (Byrne et al. 2020) for a rigid caisson, at the depths that are asked for.
Force and moment of p about the lid, and the sum of m, are those of the recorded states on any depths. Each curve grows
with its displacement: what falls or pulls along is cut to the largest curve below it that does not, and the family is
scaled down where its sum would be above the recorded one. The table states the error of a rigid beam on its straight
lines on the paths held back, and that of a beam on p(y) alone.

What p(y) of one path cannot follow, springs at virtual depths do: p(y) in strata of a rigid pile twice as long as the
skirt and one m(rotation) at mudline, fitted to the fan (`uniaxial_sets.on_a_pile`).
"""

import itertools
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core import variables
from pysprings.core.arguments import check_arrays
from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.path_kinds import HELD_BACK
from pysprings.core.storage import replacing
from pysprings.core.text import commented
from pysprings.core.units import QuantityError, read
from pysprings.macro.curve_table import Row, stack
from pysprings.macro.model import MacroModel
from pysprings.results.exporters.base import Exported, Options, Source, Target, read_options, write_text_file
from pysprings.results.exporters.csv import csv_text
from pysprings.results.exporters.formats import BEAM, POINTS
from pysprings.results.exporters.header import header, springs_at
from pysprings.results.exporters.uniaxial_curve import table
from pysprings.results.exporters.uniaxial_sets import (
    FEWEST,
    OPPOSED,
    STRATA,
    Uniaxial,
    errors_by_role,
    lateral,
    on_a_pile,
    with_tables,
)
from pysprings.results.sheets import HEAD, PLAIN_CELLS
from pysprings.springs.springs import Springs
from pysprings.springs.sums import action, with_moment
from pysprings.springs.tip_zone import shares, tip_zone

COLUMNS = (
    *("family", "depth_m", "y_m", "p_N_per_m", "rotation_rad", "m_Nm_per_m", "H_N", "M_Nm"),
    *("depth_top_m", "depth_bottom_m"),
)
# spring -> family, displacement and reaction of the table
PLACES = {
    "p": ("py", "y_m", "p_N_per_m"), "m": ("m", "rotation_rad", "m_Nm_per_m"),
    "H_tip": ("tip", "y_m", "H_N"), "M_tip": ("tip", "rotation_rad", "M_Nm"),
    "H_lid": ("lid", "y_m", "H_N"), "M_lid": ("lid", "rotation_rad", "M_Nm"),
}  # fmt: skip
FAMILIES = ("py", "m", "tip", "lid")
LEAST_CHANGE = 1e-3  # of the largest reaction of a curve: smaller corrections are not listed
MOST_DEPTHS = 10  # that are listed
BETWEEN = "straight lines between the points; curves are odd, and end with their range: beyond it nothing was computed"
LONGER = "--pile: p(y) of a rigid pile twice as long as the skirt, fitted to the fan, with its own error"
FRAME = "depth down from mudline; y and H along the load; rotation and M positive where the caisson leans towards it"
UNITS = "m, rad, N, N m; p and m per metre of depth: times the height of the slice they are a force and a moment"


def depths_of(text: str, length: float) -> Array:
    """Return depths (n,) [m] of a list such as "0.5, 1.5, 2.5 m"; a number without a unit has that of the next one.

    Raises UserInputError, all faults at once, for fewer than two depths, depths outside the skirt, or not in order.
    """
    parts = [part.strip() for part in text.split(",")]
    for k in range(len(parts) - 2, -1, -1):
        if re.fullmatch(r"[-+.\deE]+", parts[k]) and (found := re.fullmatch(r"[-+.\deE]+ *(\D+)", parts[k + 1])):
            parts[k] += f" {found[1]}"
    values, problems = [], []
    for part in parts:
        try:
            depth = float(read(part, "m", "0.5 m"))
        except QuantityError as error:
            problems.append(Problem(key="--depths", message=str(error)))
            continue
        if not 0.0 <= depth <= length:
            problems.append(Problem(key="--depths", message=f"{depth:g} m is not on the skirt, 0 to {length:g} m"))
        values.append(depth)
    if not problems and (len(values) < 2 or (np.diff(values) <= 0.0).any()):
        problems.append(Problem(key="--depths", message="give two depths or more, each below the one before"))
    if problems:
        raise UserInputError(problems)
    return np.array(values)


def rows_of(springs: Springs, depths: Array | None) -> tuple[list[Row], dict[float, list[float]], list[str]]:
    """Return the rows of all curves, top and bottom of the slice of each depth [m], and what was corrected.

    Slices end half way between the depths; without depths they are those of all tables, the last fifth as one.
    """
    if springs.pure_paths is None:
        raise refused("springs", "curves for beam programs need a pure translation and a pure rotation: run a fan")
    slid, turned = (springs.paths[name] for name in springs.pure_paths)
    edges = tip_zone(slid.recorded) if depths is None else np.array([0.0, *_middles(depths), springs.length])
    z = _middles(edges) if depths is None else depths
    bounds = np.column_stack([edges[:-1], edges[1:]])
    force = {name: _change(slid[name])[None] for name in ("H_tip", "H_lid")}
    moment = {name: _change(turned[name])[None] for name in ("M_tip", "M_lid")}
    share, p = shares(slid["depth_bounds"], edges), _change(slid.p)
    moment_of_p = (slid.depth * slid.heights) @ p
    _refuse_beside(moment_of_p, slid.heights @ p, z)
    p = with_moment(share @ p, moment_of_p, z, np.diff(edges))
    forces, lost = _family(springs, slid.u, {"p": p} | force, z, bounds)
    moments, more = _family(springs, turned.rotation, {"m": share @ _change(turned.m)} | moment, z, bounds)
    return [*forces, *moments], dict(zip(z.tolist(), bounds.tolist(), strict=True)), [*lost, *more]


def _refuse_beside(moment: Array, force: Array, z: Array) -> None:
    """Refuse depths (k,) [m] on one side of where p acts, of this moment [N m] and force [N] (steps,).

    No curves there that grow have both.
    """
    large = np.abs(force) > 0.01 * np.abs(force).max()
    centre = moment[large] / force[large]
    for each in centre[(centre < z[0]) | (centre > z[-1])][:1]:
        raise refused(
            "--depths",
            f"p of the translation acts at {each:.3g} m, which is not between {z[0]:.3g} and "
            f"{z[-1]:.3g} m: no curves there have its force and its moment",
        )


def _middles(x: Array) -> Array:
    return 0.5 * (x[1:] + x[:-1])


def _change(values: Array) -> Array:
    """Return the change of values (..., steps) from the state at rest."""
    return values - values[..., :1]


def _family(
    springs: Springs, q: Array, curves: dict[str, Array], z: Array, bounds: Array
) -> tuple[list[Row], list[str]]:
    """Return the rows of forces, or of moments, on the safe side, over one displacement (steps,); what that changes."""
    length, q = springs.length, _change(q)
    places = [(name, depth, height) for name, r in curves.items() for depth, height in (
        zip(z, np.diff(bounds, axis=1)[:, 0], strict=True) if len(r) > 1 else [(length if "tip" in name else 0.0, 0.0)]
    )]  # fmt: skip
    given = np.sign(q[-1]) * np.concatenate(list(curves.values()))
    weight = np.array([height or 1.0 for _, _, height in places])
    r = on_safe_side(given, weight)
    turns = places[0][0] == "m"
    rows = [
        Row(name, depth, "rotation" if turns else "y", (0.0, 1.0) if turns else (1.0, -depth),
            action(name, depth, height, length), np.abs(q), values)
        for (name, depth, height), values in zip(places, r, strict=True)
    ]  # fmt: skip
    changed = np.abs(r - given).max(axis=1) > LEAST_CHANGE * np.abs(given).max(axis=1)
    if not changed.any():
        return rows, []
    there = _in_words([place[:2] for place, each in zip(places, changed, strict=True) if each])
    lost = abs(_largest(weight @ (r - given), weight @ given))
    lever = weight * [depth for _, depth, _ in places]
    text = f"moments of the rotation lower by {lost:.2g} %" if turns else (
        f"forces of the translation lower by {lost:.2g} %, their moment about the lid changed by "
        f"{_largest(lever @ (r - given), lever @ given):+.2g} %"
    )  # fmt: skip
    return rows, [f"corrected on the safe side, sum of the {text} of the largest at most: {there}"]


def _in_words(places: Sequence[tuple[str, float]]) -> str:
    """Return curves by name and depth [m]; of many depths the first and the last."""
    texts = []
    for name, own in itertools.groupby(places, lambda place: place[0]):
        depths = [depth for _, depth in own]
        if len(depths) > MOST_DEPTHS:
            texts.append(f"{name} at {len(depths)} depths from {depths[0]:.3g} to {depths[-1]:.3g} m")
        else:
            texts += [f"{name} at {depth:.3g} m" for depth in depths]
    return ", ".join(texts)


def _largest(change: Array, whole: Array) -> float:
    """Return the largest change (steps,) with its sign, in % of the largest of what it changes."""
    return 100.0 * float(change[np.abs(change).argmax()]) / float(np.abs(whole).max())


def monotone(values: Array) -> Array:
    """Return the largest curves (n, k) below curves that start at 0 that nowhere fall, at least 0."""
    return np.maximum(np.minimum.accumulate(values[:, ::-1], axis=1)[:, ::-1], 0.0)


def on_safe_side(given: Array, weight: Array) -> Array:
    """Return curves (n, k) of one displacement that grow, whose sum by weight (n,) is at most the one before."""
    grown = monotone(given)
    before, now = monotone((weight @ given)[None])[0], weight @ grown
    return monotone(grown * np.minimum(before / np.where(now > 0.0, now, 1.0), 1.0))


def beam_tables(source: Source, options: Options) -> tuple[list[str], pd.DataFrame]:
    """Return the lines above the table, and the table (`COLUMNS`, SI)."""
    if int(options["points"]) < FEWEST:
        raise refused("--option points", f"{options['points']} is not from {FEWEST} to any number")
    springs, load = springs_at(source, options)
    depths = depths_of(options["depths"], springs.length) if options["depths"] else None
    if options["pile"] == "yes":
        return _on_a_pile(source, springs, load, options)
    found, bounds, corrected = rows_of(springs, depths)
    rows = stack([row for row in found if row.r.any()])
    heights = {depth: bottom - top for depth, (top, bottom) in bounds.items()}
    model = MacroModel.from_springs(springs, "pisa").on_rows(rows)
    made = Uniaxial(model, rows, 2, tuple(lateral(rows, heights)), ())
    tables = [table(each, 2 * int(options["points"]) - 1) for each in made.springs]
    alone, beside = [each for each in tables if each.spring.name == "p"], springs.reference
    errors = [
        *errors_by_role(springs, with_tables(made, alone), f"p(y) alone, without m, tip and lid, beside {beside}"),
        *errors_by_role(springs, with_tables(made, tables), f"all curves of this table beside {beside}"),
    ]
    lines = [line for line in errors if HELD_BACK in line] or errors
    head = [*lines, *[LONGER] * springs.has_fan, *corrected, BETWEEN, *_header(source, springs)]
    points = [(each.spring.name, each.spring.depth, *each.within()) for each in tables]
    points += [(row.name, row.depth, row.q[[0, -1]], row.r[[0, -1]]) for row in found if not row.r.any()]
    return head, _frame(points, bounds)


def _header(source: Source, springs: Springs) -> list[str]:
    return header(source, "curves for beam programs", FRAME, UNITS, at=springs)


def _on_a_pile(
    source: Source, springs: Springs, load: float | None, options: Options
) -> tuple[list[str], pd.DataFrame]:
    """Return the lines above the table, and the table, of a rigid pile that stands for the foundation."""
    if options["depths"]:
        raise refused("--depths", "the strata of a pile that stands for the foundation have depths of their own")
    made, length = on_a_pile(springs, load)
    tables = [table(each, 2 * int(options["points"]) - 1) for each in made.springs if each.odd]
    errors = errors_by_role(springs, with_tables(made, tables), f"all curves of this table beside {springs.reference}")
    pile = f"the pile stands for the whole foundation: rigid, {length:g} m long below mudline; m acts at its head"
    errors = [line for line in errors if HELD_BACK in line] or errors
    head = [*errors, pile, OPPOSED, BETWEEN, *_header(source, springs)]
    half, names = 0.5 * length / STRATA, {"lateral": "p", "rotation": "M_lid"}
    points = [(names[each.spring.direction], each.spring.depth, *each.within()) for each in tables]
    middles = (2.0 * half * (np.arange(STRATA) + 0.5)).tolist()
    turn, reach = (max((q[-1] for name, _, q, _ in points if name == each), default=1.0) for each in ("M_lid", "p"))
    empty = [("p", z) for z in {*middles} - {point[1] for point in points}] + [("m", z) for z in middles]
    empty += [("H_tip", length), ("M_tip", length), ("H_lid", 0.0)]
    points += [(name, z, np.array([0.0, turn if name[0] in "mM" else reach]), np.zeros(2)) for name, z in empty]
    points.sort(key=lambda curve: curve[1])
    bounds = {depth: [depth - half, depth + half] for _, depth, _, _ in points}
    return head, _frame(points, bounds)


def _frame(curves: Sequence[tuple[str, float, Array, Array]], bounds: Mapping[float, list[float]]) -> pd.DataFrame:
    """Return the table of curves (spring, depth, displacements, reactions), one row a point, each from the origin."""
    parts = []
    for name, depth, q, f in curves:
        family, moves, reacts = PLACES[name]
        top, bottom = bounds[depth] if name in ("p", "m") else (depth, depth)
        data = {"family": family, "depth_m": depth, "depth_top_m": top, "depth_bottom_m": bottom}
        parts.append(pd.DataFrame(data | {moves: q[q >= 0.0], reacts: f[q >= 0.0] / (bottom - top or 1.0)}))
    frame = pd.concat([part.reindex(columns=COLUMNS) for part in parts], ignore_index=True)
    return frame.sort_values("family", kind="stable", key=lambda names: names.map(FAMILIES.index))


def text(source: Source, options: Options) -> str:
    """Return the table as CSV text below its lines."""
    head, frame = beam_tables(source, options)
    return "\n".join([*commented("#", head), csv_text(frame)])


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write beam.csv into a folder; the table as CSV or workbook where the target names such a file."""
    if not target.path.suffix:
        return Exported([target.write("beam.csv", text(source, options))])
    if target.path.suffix.lower() != ".xlsx":
        return write_text_file(text)(source, target, options)
    import xlsxwriter

    head, frame = beam_tables(source, options)
    lines = commented("#", head)
    with replacing(target.path) as place, xlsxwriter.Workbook(str(place), PLAIN_CELLS) as book:
        sheet, bold = book.add_worksheet("beam"), book.add_format(HEAD)
        sheet.set_column(0, len(COLUMNS) - 1, 14)
        for k, line in enumerate(lines):
            sheet.write_string(k, 0, line)
        sheet.write_row(len(lines), 0, COLUMNS, bold)
        for k, row in enumerate(frame.itertuples(index=False), start=len(lines) + 1):
            sheet.write_row(k, 0, [None if value != value else value for value in row])
    return Exported([target.path])


def beam(springs: Springs | xr.DataTree, depths: Sequence[float] | None = None, **options: Any) -> xr.Dataset:
    """Return one set of curves for beam programs, the table of `pysprings springs --for beam` as arrays in SI.

    Parameters
    ----------
    springs : a fan, with a pure translation and a pure rotation.
    depths : of the curves [m], two or more on the skirt, downwards; None: those of all tables.
    options : points of a curve (80), V [N] and rate [m/s] of springs at several; pile="yes": p(y) in strata of a rigid
        pile twice as long as the skirt, and `rotation_lid`, `M_lid`; they follow the fan.

    Returns
    -------
    Dataset with `y` [m] and `p` [N/m] (depth, point), `rotation` [rad] and `m` [N m/m] (depth, point), and of tip and
    lid `y_tip`, `H_tip` [N], `rotation_tip`, `M_tip` [N m] ... (point): p is positive against y, m against rotation,
    curves are straight lines between their points and odd, NaN behind the last one. `depth_top` and `depth_bottom` [m]
    bound the slices. ``attrs["remarks"]`` are the lines above the table, its errors first.

    Raises UserInputError: depths or options that do not fit, springs without both paths.
    """
    check_arrays(depths=depths)
    if depths is not None and (np.ndim(depths) != 1 or not len(depths)):
        raise refused("depths", f"give two depths or more, in one row, not the shape {np.shape(depths)}")
    tree = springs.tree if isinstance(springs, Springs) else springs
    given = "" if depths is None else ", ".join(f"{depth:.12g} m" for depth in depths)
    head, frame = beam_tables(Source(tree), read_options(BEAM, {"depths": given} | options))
    size = int(options.get("points", POINTS))
    data: dict[str, Any] = {}
    for name, (family, moves, reacts) in PLACES.items():
        place = name.partition("_")[2]
        own = frame[frame["family"] == family].dropna(subset=[moves, reacts])
        parts = [part for _, part in own.groupby("depth_m")]
        for column, quantity in ((moves, moves.partition("_")[0] + (f"_{place}" if place else "")), (reacts, name)):
            rows = [np.pad(part[column], (0, size - len(part)), constant_values=np.nan) for part in parts]
            data[quantity] = ("point", rows[0]) if place else (("depth", "point"), np.array(rows))
    slices = frame[frame["family"] == "py"].drop_duplicates("depth_m").sort_values("depth_m")
    coords = {name: ("depth", slices[f"{name}_m"].to_numpy()) for name in ("depth", "depth_top", "depth_bottom")}
    found = variables.attach(xr.Dataset(data, coords, {"remarks": head}), "springs_path")
    known = variables.GROUPS["springs_path"]
    for each in found.variables:  # of tip and lid, top and bottom of slices
        unit = known[each if each in known else str(each).partition("_")[0]].attributes()["units"]
        found[each].attrs = found[each].attrs or {"units": unit}
    for each in ("bounds", "comment"):  # of the slices of a path, which these curves do not have
        del found["depth"].attrs[each]
    return found
