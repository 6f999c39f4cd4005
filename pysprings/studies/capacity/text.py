# SPDX-License-Identifier: MIT
"""The tables of a capacity study for a terminal and for its page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd

from pysprings.core.text import number

if TYPE_CHECKING:
    from pysprings.studies.capacity.points import Capacity

HEADS = (
    "strength", "V [MN]", "direction [deg]", "H [MN]", "M [MN m]", "criterion", "u [mm]", "rotation [deg]",
    "macro-model H [MN]", "M [MN m]", "criterion", "difference [%]",
)  # fmt: skip
FULL = 8  # columns of the full model
NOISE = 1e-4  # share of the load
CASE_HEADS = ("case", "limit state", "strength", "H [MN]", "M [MN m]", "V [MN]", "utilisation", "")
CRITERIA = (
    "Capacity is the largest load along its direction. peak: the load falls behind it; plateau: 1 % more displacement "
    "adds less than 0.02 % to the load at the end; displacement limit: the load at the limit of motion ({motion}), "
    "where it still grows; stopped before failure: the run ended earlier, the capacity is larger."
)
DIRECTIONS = "direction: angle in the plane of H and M/D; M is about the lid centre at mudline, M = H arm."


def criteria(outcome: Capacity) -> str:
    """Return what makes a load the capacity."""
    limit = outcome.scene.limit
    share = f"{100.0 * limit.displacement_over_diameter:g} % of the diameter"
    return CRITERIA.format(motion=f"{share} or {math.degrees(limit.rotation):g} deg")


def cells(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of the capacities; without the columns of a macro-model where there is none."""
    shown = len(HEADS) if (table["criterion_macro"] != "").any() else FULL
    return list(HEADS[:shown]), [_cells(row)[:shown] for row in table.to_dict("records")]


def _cells(row: dict[Any, Any]) -> list[str]:
    noise = NOISE * abs(row["size_N"])
    return [
        str(row["strength"]), _mega(row["V_N"]), number(row["direction_deg"]), _mega(row["H_N"], noise),
        _mega(row["M_Nm"], noise), str(row["criterion"]), number(1e3 * row["u_m"]),
        number(math.degrees(row["rotation_rad"]), 3), _mega(row["H_macro_N"], noise), _mega(row["M_macro_Nm"], noise),
        str(row["criterion_macro"]) or "-", _signed(row["difference_pct"]),
    ]  # fmt: skip


def case_cells(cases: pd.DataFrame) -> list[list[str]]:
    """Return the load cases as cells below `CASE_HEADS`."""
    return [
        [
            str(row["name"]), str(row["limit_state"]), str(row["strength"]), _mega(row["H_N"]), _mega(row["M_Nm"]),
            _mega(row["V_N"]), number(row["utilisation"], 3), _remark(row),
        ]
        for row in cases.to_dict("records")
    ]  # fmt: skip


def closing(table: pd.DataFrame) -> str:
    """Return a sentence on the difference of the models; empty where none is known."""
    known = table["difference_pct"].dropna()
    if not len(known):
        return ""
    return (
        f"macro-model against full model in {len(known)} of {len(table)} directions: "
        f"{known.min():+.1f} to {known.max():+.1f} %"
    )


def _remark(row: dict[Any, Any]) -> str:
    texts: Sequence[str] = [
        "no envelope at this V" if row["off_load"] else "", "upper bound" if row["upper_bound"] else "", row["remarks"],
    ]  # fmt: skip
    return ", ".join(filter(None, texts))


def _mega(value: float, noise: float = 1.0) -> str:
    """Return a load in mega-units; 0 where it is what the tolerance of the solver has left of zero."""
    return number(0.0 if abs(value) <= noise else 1e-6 * value)


def _signed(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:+.1f}"
