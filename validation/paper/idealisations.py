# SPDX-License-Identifier: MIT
"""What our idealisations cost: rigid against elastic steel, Drucker-Prager's cone against Van Eekelen's surface."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.paper import measures as m
from validation.paper.cases import DEPTHS, END, SHOWN

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# run -> head of its column; each is set beside the drained run (rigid caisson, Drucker-Prager)
BESIDE = {"elastic-steel": "elastic steel", "van-eekelen": "Van Eekelen"}
_EARLY = 0.1e-3  # m
NOTE = (
    "Drained, friction 0.5; differences to the rigid caisson in sand with Drucker-Prager's cone. The paper's caisson "
    "is elastic steel; its yield surface is one of the two. Ovalisation: change of diameter, along and "
    "across the load, at the depth where it is largest."
)


def compare(paths: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return quantity, unit, its value in the drained run, and for each other run its value and difference in %."""
    import pandas as pd

    figures = {name: _figures(paths[name]) for name in ("drained", *BESIDE) if name in paths}
    rows = []
    for quantity, unit in next(iter(figures.values()), {}):
        base = figures.get("drained", {}).get((quantity, unit), math.nan)
        row: dict[str, Any] = {"quantity": quantity, "unit": unit, "drained": base}
        for name in BESIDE:
            row[name] = figures.get(name, {}).get((quantity, unit), math.nan)
            row[f"{name}_difference_percent"] = 100.0 * (row[name] / base - 1.0) if base else math.nan
        rows.append(row)
    columns = ["quantity", "unit", "drained", *(c for name in BESIDE for c in (name, f"{name}_difference_percent"))]
    return pd.DataFrame(rows, columns=columns)


def _figures(path: xr.Dataset) -> dict[tuple[str, str], float]:
    """Read what is compared from a run, by its words and unit."""
    out = {(f"H/u at {1e3 * _EARLY:g} mm", "MN/m"): 1e-6 * m.load(path, _EARLY) / _EARLY}
    for u in (SHOWN, END):
        at = f"at {1e3 * u:g} mm"
        out[f"H {at}", "kN"] = 1e-3 * m.load(path, u)
        out[f"rotation {at}", "mrad"] = 1e3 * float(m.at(path, "rotation", u))
        for z in DEPTHS:
            out[f"p {at}, depth {z:g} m", "kN/m"] = 1e-3 * m.p_at(path, z, u)
        for z in DEPTHS[::3]:
            out[f"y {at}, depth {z:g} m", "mm"] = 1e3 * m.y_at(path, z, u)
        for z in DEPTHS[::3]:
            out[f"front p'_N over initial {at}, depth {z:g} m", "1"] = float(m.stress_ratio(path, u, m.FRONT, [z])[0])
        for axis in "xy":
            out[f"ovalisation along {axis} {at}", "mm"] = 1e3 * _ovalisation(path, f"diameter_change_{axis}", u)
    return out


def _ovalisation(path: xr.Dataset, name: str, u: float) -> float:
    """Return the change of diameter [m] at the depth where it is largest; 0 of a rigid caisson."""
    if name not in path:
        return 0.0
    values = m.at(path, name, u)
    return float(values[np.argmax(np.abs(values))]) if np.isfinite(values).all() else math.nan


def rows_for_people(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return heads and cells of the table; '-' where a case has not run or a value has no meaning."""
    heads = ["", "unit", "rigid, Drucker-Prager"]
    for words in BESIDE.values():
        heads += [words, "difference"]
    cells = []
    for row in table.to_dict(orient="records"):
        line = [str(row["quantity"]), str(row["unit"]), _text(row["drained"])]
        for name in BESIDE:
            change = row[f"{name}_difference_percent"]
            line += [_text(row[name]), f"{change:+.1f} %" if math.isfinite(change) else "-"]
        cells.append(line)
    return heads, cells


def _text(value: float) -> str:
    return f"{value:,.4g}" if math.isfinite(value) else "-"
