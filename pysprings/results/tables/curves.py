# SPDX-License-Identifier: MIT
"""A table of independent curves, one for each depth: p(y), and m, tip and lid terms if given.

Rows of tables belong to slices from mudline to the tip; net rows stand among the parts.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.tables.table import Faults
from pysprings.macro.curve_table import MAX_NEGATIVE
from pysprings.macro.user_curves import Curve, CurveSet, CurveSprings

Array = NDArray[np.float64]

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
        file, line = str(first["file"].iloc[-1]), int(first["line"].iloc[-1])
        faults.add((file, line), "depth_m", f"{depth[-1]:g} m is below the skirt length of {bottom:g} m")
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
        place = (str(first["file"].iloc[-1]), int(first["line"].iloc[-1]))
        faults.add(place, "depth_bottom_m", f"slices end at {above:g} m, not at the skirt length {skirt_length:g} m")


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
            found = _on_depths(curves, depth, parts, faults)
            sets[str(name) or "table"] = CurveSet(depth, bounds, found, note, bool(own["straight"].any()))
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


def _on_depths(curves: list[Curve], depth: Array, parts: dict[str, pd.DataFrame], faults: Faults) -> list[Curve]:
    """Return the curves; note moments at depths where there is no p."""
    for curve in curves:
        if curve.name == "m" and curve.depth not in depth:
            rows = parts["mtheta"]
            place = place_of(rows[rows["depth_m"] == curve.depth])
            faults.add(place, "depth_m", f"{curve.depth:g} m has a distributed moment and no p-y curve")
    return curves
