# SPDX-License-Identifier: MIT
"""Rows of a table file, each cell checked with its line, and independent curves of them.

Curves are p(y) of each depth, and m, tip and lid terms if given. Rows of tables belong to slices from mudline to the
tip; net rows stand among the parts.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Column, Faults, Sheet, Table, tables_of
from pysprings.core.tables.headings import TEXT
from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.macro.curve_table import MAX_NEGATIVE, Curve, CurveSet, CurveSprings
from pysprings.results.exporters.tables import ENDS, PAIRS, PY_COLUMNS, parse
from pysprings.springs.checks import name_fault

NEEDED = ("depth_m", "y_m", "p_N_per_m")
FAMILIES = ("py", "mtheta", "base", "lid", "tz")
OF_BEAM = {"m": "mtheta", "tip": "base"}  # words of `springs --for beam`, whose curves are straight lines
TEXTS = ("path", "family", "side", "component")
COLUMNS = tuple(Column(name, TEXT) if name in TEXTS else Column.named(name) for name in PY_COLUMNS)
# Sheets that are not read: words and pictures.
OTHER_SHEETS = ("about", "charts", "load-displacement", "stiffness 6x6")
SHEETS = {"py": "py", "p-y": "py", "mtheta": "mtheta", "m-theta": "mtheta", "base": "base", "tip": "base", "lid": "lid"}


def read_rows(path: str | os.PathLike[str], faults: Faults) -> pd.DataFrame:
    """Return the rows of a table: every column of `PY_COLUMNS`, numbers as numbers (NaN: blank), and `file`, `line`.

    Refuses missing, repeated and unknown columns and units that do not fit; notes cells that are not finite numbers and
    unknown families, for the checks that follow to add theirs.
    """
    path = Path(path)
    frames = [
        _typed(table, SHEETS.get(_name(sheet)) if sheet.name else None)
        for sheet, table in tables_of(path, COLUMNS, faults, _is_read, unfold)
    ]
    if not frames:
        faults.add((str(path), None), None, f"no sheet with a table; expected the columns {', '.join(NEEDED)}")
    if not all(len(frame.columns) for frame in frames) or any(each.line is None for each in faults.problems):
        faults.stop()  # the columns: nothing can be checked below them
    rows = pd.concat(frames, ignore_index=True)
    if not (rows["family"] == "py").any():
        faults.add((str(path), None), None, "no rows of p-y curves (family py)")
        faults.stop()
    return rows


def _name(sheet: Sheet) -> str:
    return sheet.name.strip().lower()


def _is_read(sheet: Sheet) -> bool:
    """Return whether a sheet holds springs; refuse the workbook that a run writes for people."""
    if sheet.name and [cells[0] for _, cells in sheet.lines[:2]] == ["depth [m]", "slice [m]"]:
        message = "is the workbook for people that `pysprings run` writes; give the springs.nc or py.csv beside it"
        raise UserInputError([Problem(file=sheet.place.rpartition("[")[0], message=message)])
    return not sheet.name or bool(sheet.lines and _name(sheet) not in OTHER_SHEETS)


def _typed(table: Table, family: str | None) -> pd.DataFrame:
    """Return one sheet's rows with the right types; note the faults of its columns and numbers."""
    headings = any(each.file == table.place and each.line == table.head_line for each in table.faults.problems)
    for name in NEEDED if family in (None, "py") and not headings else ():
        if name not in table:
            table.fault(None, name, f"missing column (needed: {', '.join(NEEDED)})")
            headings = True
    if headings:
        return pd.DataFrame()
    data: dict[str, Any] = {"file": table.place, "line": table.lines}
    data |= {name: table.texts(name) if name in TEXTS else table.numbers(name) for name in PY_COLUMNS}
    frame = pd.DataFrame(data)
    _check_names(frame, table.faults)
    words = frame["family"].where(frame["family"] != "", family or "py")
    frame["straight"] = words.isin(OF_BEAM)
    frame["family"] = words.replace(OF_BEAM)
    known = frame["family"].isin(FAMILIES)
    for other in frame[~known].itertuples(index=False):
        hint = suggestion(str(other.family), FAMILIES)
        table.faults.at(other, "family", f"{quoted(other.family)} is not one of {', '.join(FAMILIES)}{hint}")
    return frame[known]


def _check_names(frame: pd.DataFrame, faults: Faults) -> None:
    """Note names of paths that other files and programs would misread."""
    wrong = {name: name_fault(name) for name in frame["path"].unique() if name}
    for row in frame[frame["path"].map(lambda name: bool(wrong.get(name)))].itertuples(index=False):
        faults.at(row, "path", f"{quoted(row.path)}: {wrong[str(row.path)]}")


Lines = list[tuple[int, list[Any]]]

Place = tuple[str, str, str]  # depth, top and bottom of the slice, as they stand in the heading

_FAMILIES = ("py", "mtheta")  # of PAIRS
_OF_LATERAL = ("y_m", "p_N_per_m", "m_Nm_per_m")  # blank on a vertical path


def unfold(head: list[str], lines: Lines) -> tuple[list[str], Lines]:
    """Return heading and lines of the long format, other tables as they are; other columns stay for the checks."""
    if not any((heading := parse(name)) is not None and heading[0] in PAIRS[0] for name in head):
        return head, lines
    by_depth: dict[Place, dict[str, int]] = {}  # depth and slice -> quantity -> column
    for column, text in enumerate(head):
        if (heading := parse(text)) is not None and any(heading[0] in pair for pair in PAIRS):
            by_depth.setdefault(heading[1], {})[heading[0]] = column
    ends = {wide: head.index(wide) for columns in ENDS.values() for wide in columns.values() if wide in head}
    used = {column for own in by_depth.values() for column in own.values()} | set(ends.values())
    others = [column for column in range(len(head)) if column not in used]
    quantities = [name for pair in PAIRS for name in pair]
    long = ["family", "depth_m", "depth_top_m", "depth_bottom_m", *quantities, *ENDS["base"]]
    return [*long, *(head[column] for column in others)], [
        (line, family + [row[column] if column < len(row) else None for column in others] + row[len(head) :])
        for line, row in lines
        for family in [*_depth_rows(row, by_depth, quantities), *_end_rows(row, by_depth, ends, quantities)]
    ]


def _depth_rows(row: list[Any], by_depth: dict[Place, dict[str, int]], quantities: list[str]) -> list[list[Any]]:
    """Return rows of the families by depth of one wide row: y and p, then m and t; t alone on a vertical path."""
    filled = []
    lateral = [column for own in by_depth.values() for name, column in own.items() if name in _OF_LATERAL]
    if all(_cell(row, column) in (None, "") for column in lateral):
        ends: list[Any] = [None] * len(ENDS["base"])
        t = [[None] * 3 + [_cell(row, own.get("t_N_per_m"))] for own in by_depth.values()]
        return [["tz", *place, *cells, *ends] for place, cells in zip(by_depth, t, strict=True)]
    for family, pair in zip(_FAMILIES, PAIRS, strict=True):
        for place, columns in by_depth.items():
            if not any(name in columns for name in pair):
                continue
            cells = [_cell(row, columns.get(name)) if name in pair else None for name in quantities]
            filled.append([family, *place, *cells, *[None] * len(ENDS["base"])])
    return filled


def _end_rows(
    row: list[Any], by_depth: dict[Place, dict[str, int]], ends: dict[str, int], quantities: list[str]
) -> list[list[Any]]:
    """Return rows of tip (at the bottom of the deepest slice) and lid (depth 0) of one wide row."""
    bottom = max((place[2] for place in by_depth), key=_size)
    filled: list[list[Any]] = []
    for family, columns in ENDS.items():
        if any(wide in ends for wide in columns.values()):
            at = bottom if family == "base" else "0"
            forces = [_cell(row, ends.get(wide)) for wide in columns.values()]
            filled.append([family, at, at, at, *[None] * len(quantities), *forces])
    return filled


def _cell(row: list[Any], column: int | None) -> Any:
    return row[column] if column is not None and column < len(row) else None


def _size(text: str) -> float:
    try:
        return float(text)
    except ValueError:  # the checks of the cells note it
        return float("-inf")


# Slices may miss each other by this share of the skirt length: numbers in tables are rounded.
ROUNDING = 1e-6

_NET = {"side": ("", "net"), "component": ("", "total")}


def place_of(rows: pd.DataFrame) -> tuple[str, int | None]:
    """Return (file, line) of the first of some rows."""
    return str(rows["file"].iloc[0]), int(rows["line"].iloc[0])


def net_rows(rows: pd.DataFrame, faults: Faults) -> pd.DataFrame:
    """Return the rows of both sides and all components together (side net, component total, or blank)."""
    chosen = rows
    for column, labels in _NET.items():
        chosen = chosen[chosen[column].isin(labels)]
    if chosen.empty and len(rows):
        message = "only parts are given: side 'net' and component 'total' (or blanks) are needed"
        faults.add(place_of(rows), "side", message)
    return chosen


def slices(rows: pd.DataFrame, skirt_length: float | None, faults: Faults) -> tuple[Array, Array, str]:
    """Return depths (n,), tops and bottoms (n, 2) of the slices [m], and a sentence on assumptions.

    Slices touch and begin at mudline. Without depth_top_m and depth_bottom_m they end half way between the depths;
    the last ends at the skirt length, or as far below its depth as it begins above.
    """
    blank = rows[rows["depth_m"].isna()]
    for row in blank.itertuples(index=False):
        faults.at(row, "depth_m", "blank")
    first = rows[rows["depth_m"].notna()].drop_duplicates("depth_m").sort_values("depth_m")
    depth = first["depth_m"].to_numpy(dtype=float)
    given = first[["depth_top_m", "depth_bottom_m"]].to_numpy(dtype=float)
    for row in first[first["depth_m"] < 0.0].itertuples(index=False):
        faults.at(row, "depth_m", f"{row.depth_m:g} is above mudline (depth counts downwards)")
    if len(blank) or not depth.size or depth[0] < 0.0:
        return depth, given, ""
    if np.isnan(given).all():
        return _assumed(first, depth, skirt_length, faults)
    _same_slices(rows, faults)
    _check_slices(first, depth, given, skirt_length, faults)
    return depth, given, ""


def _assumed(first: pd.DataFrame, depth: Array, skirt_length: float | None, faults: Faults) -> tuple[Array, Array, str]:
    middle = 0.5 * (depth[1:] + depth[:-1])
    above = middle[-1] if middle.size else 0.0
    bottom = skirt_length if skirt_length is not None else 2.0 * depth[-1] - above
    if bottom <= above or bottom < depth[-1]:
        text = f"{depth[-1]:g} m is below the skirt length of {bottom:g} m"
        faults.add(place_of(first.tail(1)), "depth_m", text)
    edges = np.concatenate([[0.0], middle, [bottom]])
    length = "the skirt length" if skirt_length is not None else "assumed skirt length"
    note = f"slices end half way between the depths of the table, the last one at {bottom:g} m ({length})"
    return depth, np.stack([edges[:-1], edges[1:]], axis=1), note


def _same_slices(rows: pd.DataFrame, faults: Faults) -> None:
    """Note rows whose slice differs from that of the first row of their depth."""
    for column in ("depth_top_m", "depth_bottom_m"):
        own = rows.groupby("depth_m")[column].transform("first")
        for row, first in zip(rows[rows[column] != own].itertuples(index=False), own[rows[column] != own], strict=True):
            faults.at(row, column, f"{getattr(row, column):g} at a depth whose slice had {first:g}")


def _check_slices(first: pd.DataFrame, depth: Array, bounds: Array, skirt_length: float | None, faults: Faults) -> None:
    above, size = 0.0, float(np.nanmax(bounds))
    for row, z, (top, bottom) in zip(first.itertuples(index=False), depth, bounds, strict=True):
        if not top <= z <= bottom or bottom <= top:
            faults.at(row, "depth_top_m", f"depth {z:g} m is not in its slice {top:g} to {bottom:g} m")
        gap = top - above
        if abs(gap) > ROUNDING * size:
            kind, words = ("gap", "below") if gap > 0 else ("overlap", "with")
            what = f"the slice that ends at {above:g} m" if above else "mudline"
            faults.at(row, "depth_top_m", f"{kind} of {abs(gap):g} m {words} {what}: slices must touch, from 0 on")
        above = bottom
    if skirt_length is not None and abs(above - skirt_length) > ROUNDING * size:
        text = f"slices end at {above:g} m, not at the skirt length {skirt_length:g} m"
        faults.add(place_of(first.tail(1)), "depth_bottom_m", text)


_COLUMNS = {  # family -> (spring, displacement, reaction)
    "py": (("p", "y_m", "p_N_per_m"),),
    "mtheta": (("m", "rotation_rad", "m_Nm_per_m"),),
    "base": (("H_tip", "y_m", "H_N"), ("M_tip", "rotation_rad", "M_Nm")),
    "lid": (("H_lid", "y_m", "H_N"), ("M_lid", "rotation_rad", "M_Nm")),
}


def build_curves(rows: pd.DataFrame, skirt_length: float | None, faults: Faults) -> CurveSprings:
    """Return the springs of a table of curves; refuse every fault with its line.

    Curves are given for one direction; the other is their odd reflection. A missing origin is added.
    """
    sets = dict[str, CurveSet]()
    for name, own in rows[rows["converged"] != 0].groupby("path", sort=False):
        parts = {str(family): net_rows(part, faults) for family, part in own.groupby("family", sort=False)}
        if "py" not in parts:
            faults.add(place_of(own), "family", f"path '{name}' has no p-y curves")
            continue
        depth, bounds, note = slices(parts["py"], skirt_length, faults)
        curves = [curve for family, part in parts.items() for curve in _curves(family, part, faults)]
        if not faults.problems:
            sets[str(name) or "table"] = CurveSet(depth, bounds, curves, note, bool(own["straight"].any()))
            for curve in curves:
                if curve.name == "m" and curve.depth not in depth:
                    place = place_of(parts["mtheta"][parts["mtheta"]["depth_m"] == curve.depth])
                    faults.add(place, "depth_m", f"{curve.depth:g} m has a distributed moment and no p-y curve")
    faults.stop()
    return CurveSprings(str(rows["file"].iloc[0]), sets)


def _curves(family: str, part: pd.DataFrame, faults: Faults) -> Iterator[Curve]:
    """Yield the curves of one family that are in order; note the faults of the others."""
    for depth, own in part.groupby("depth_m", dropna=False) if family in ("py", "mtheta") else [(0.0, part)]:
        ordered = own if own["step"].isna().any() else own.sort_values("step", kind="stable")
        for spring, moves, reacts in _COLUMNS[family]:
            filled = ordered[ordered[moves].notna() | ordered[reacts].notna()]
            before = len(faults.problems)
            _check(filled, moves, reacts, faults)
            if len(faults.problems) == before and len(filled):
                q, r = filled[moves].to_numpy(dtype=float), filled[reacts].to_numpy(dtype=float)
                q, r = (q, r) if q[0] == 0.0 else (np.append(0.0, q), np.append(0.0, r))
                yield Curve(spring, float(str(depth)), np.abs(q), np.where(q < 0.0, -r, r))
            elif len(faults.problems) == before and spring in ("p", "m"):
                faults.add(place_of(own), reacts, "blank")


def _check(rows: pd.DataFrame, moves: str, reacts: str, faults: Faults) -> None:
    """Note blanks, a displacement that does not grow, a load at the origin and a spring that pulls along."""
    last, sign = None, 0.0
    peak = float(rows[reacts].abs().max()) if len(rows) else 0.0
    for row in rows.itertuples(index=False):
        q, r = float(getattr(row, moves)), float(getattr(row, reacts))
        if np.isnan(q) or np.isnan(r):
            faults.at(row, moves if np.isnan(q) else reacts, "blank")
            last, sign = (last, sign) if np.isnan(q) else (q, sign or q)
            continue
        if q * sign < 0.0:
            message = f"{q:g} has another sign than before: give one direction, the other is its odd reflection"
            faults.at(row, moves, message)
        elif last is not None and abs(q) <= abs(last):
            faults.at(row, moves, _why_not_growing(row, q, last, float(rows[moves].iloc[0])))
        elif q == 0.0 and r != 0.0:
            faults.at(row, reacts, f"{r:g} at zero displacement: curves pass through the origin")
        elif q * r < 0.0 and abs(r) > MAX_NEGATIVE * peak:
            message = f"{r:g} pulls along with {moves} = {q:g}: reactions count positive against the displacement"
            faults.at(row, reacts, message)
        last, sign = q, sign or q
    if sign == 0.0 and len(rows) and last is not None:
        faults.add(place_of(rows), moves, "a curve needs a displacement other than 0")


def _why_not_growing(row: Any, q: float, last: float, first: float) -> str:
    if q == first != last and row.family == "py":
        return (
            f"{q:g} begins a second curve at {row.depth_m:g} m: at a layer boundary write the two "
            f"curves at depths of their own, a little above and below {row.depth_m:g} m"
        )
    word = "stands twice at its depth" if q == last else f"does not grow ({last:g} before)"
    return f"{q:g} {word}: a curve needs one value a displacement, in order"
