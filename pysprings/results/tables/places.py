# SPDX-License-Identifier: MIT
"""Where the rows of a table belong: net rows among the parts, slices from mudline to the tip."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.tables.faults import Faults

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
    _check(first, depth, given, skirt_length, faults)
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


def _check(first: pd.DataFrame, depth: Array, bounds: Array, skirt_length: float | None, faults: Faults) -> None:
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
