# SPDX-License-Identifier: MIT
"""A table of independent curves, one for each depth: p(y), and m, tip and lid terms if given."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.tables.faults import Faults
from pysprings.macro.curve_table import MAX_NEGATIVE
from pysprings.macro.user_curves import Curve, CurveSet, CurveSprings
from pysprings.results.tables.places import net_rows, place_of, slices

Array = NDArray[np.float64]

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
            sets[str(name) or "table"] = CurveSet(depth, bounds, _on_depths(curves, depth, parts, faults), note)
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
