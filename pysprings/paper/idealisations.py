# SPDX-License-Identifier: MIT
"""What our idealisations cost: rigid against elastic steel, Drucker-Prager's cone against Van Eekelen's surface."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.paper import measures as m
from pysprings.paper.cases import DEPTHS, END, SHOWN

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# run -> head of its column; each is set beside the drained run (rigid caisson, Drucker-Prager)
BESIDE = {"elastic": "elastic steel", "van-eekelen": "Van Eekelen"}
_EARLY = 0.1e-3  # m
NOTE = (
    "Drained, friction 0.5; differences to the rigid caisson in sand with Drucker-Prager's cone. The paper's caisson "
    "is elastic steel; its yield surface is one of the two. Ovalisation: change of diameter, along and "
    "across the load, at the depth where it is largest."
)


def compare(paths: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return quantity, unit, its value in the drained run, and for each other run its value and difference in %."""
    import pandas as pd

    rows = []
    for quantity, unit, read in _quantities():
        row: dict[str, Any] = {"quantity": quantity, "unit": unit, "drained": _value(paths.get("drained"), read)}
        for name in BESIDE:
            row[name] = _value(paths.get(name), read)
            base = row["drained"]
            row[f"{name}_difference_percent"] = 100.0 * (row[name] / base - 1.0) if base else math.nan
        rows.append(row)
    return pd.DataFrame(rows)


def _value(path: xr.Dataset | None, read: Any) -> float:
    return math.nan if path is None else float(read(path))


def _quantities() -> list[tuple[str, str, Any]]:
    """List what is compared: words, unit, how it is read from a path."""
    out: list[tuple[str, str, Any]] = [
        (f"H/u at {1e3 * _EARLY:g} mm", "MN/m", lambda path: 1e-6 * m.load(path, _EARLY) / _EARLY)
    ]
    for u in (SHOWN, END):
        at = f"at {1e3 * u:g} mm"
        out.append((f"H {at}", "kN", lambda path, u=u: 1e-3 * m.load(path, u)))
        out.append((f"rotation {at}", "mrad", lambda path, u=u: 1e3 * float(m.at(path, "rotation", u))))
        out += [(f"p {at}, depth {z:g} m", "kN/m", lambda path, u=u, z=z: 1e-3 * m.p_at(path, z, u)) for z in DEPTHS]
        out += [(f"y {at}, depth {z:g} m", "mm", lambda path, u=u, z=z: 1e3 * _y_at(path, z, u)) for z in DEPTHS[::3]]
        out += [
            (f"front p'_N over initial {at}, depth {z:g} m", "1",
             lambda path, u=u, z=z: m.stress_ratio(path, u, m.FRONT, [z])[0]) for z in DEPTHS[::3]
        ]  # fmt: skip
        out += [
            (f"ovalisation {words} {at}", "mm", lambda path, u=u, name=name: 1e3 * _ovalisation(path, name, u))
            for words, name in (("along x", "diameter_change_x"), ("along y", "diameter_change_y"))
        ]
    return out


def _y_at(path: xr.Dataset, depth: float, u: float) -> float:
    if not m.reached(path, u):
        return math.nan
    return float(np.interp(u, path["u"].values, m.py_curve(path, depth)[0]))


def _ovalisation(path: xr.Dataset, name: str, u: float) -> float:
    """Change of diameter [m] at the depth where it is largest; 0 of a rigid caisson."""
    if name not in path:
        return 0.0
    values = m.at(path, name, u)
    return float(values[np.argmax(np.abs(values))]) if np.isfinite(values).all() else math.nan


def rows_for_people(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return heads and cells of the table; '-' for what has not run or has no meaning."""
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
