# SPDX-License-Identifier: MIT
"""The tables of a capacity study for a terminal and for its page."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from pysprings.core.columns import Column, Row, Table

if TYPE_CHECKING:
    import pandas as pd

    from pysprings.studies.capacity.points import Capacity

NOISE = 1e-4  # share of the load: what the tolerance of the solver leaves of zero


def _mega(source: str) -> Callable[[Row], float]:
    """Return the reading of a load in mega-units; what the tolerance of the solver has left of zero is 0."""

    def value(row: Row) -> float:
        noise = NOISE * abs(row["size_N"]) if "size_N" in row and source != "V_N" else 1.0
        return 0.0 if abs(row[source]) <= noise else float(1e-6 * row[source])

    return value


FULL = (
    Column("strength", "strength", words=True),
    Column("V [MN]", _mega("V_N")),
    Column("direction [deg]", "direction_deg"),
    Column("H [MN]", _mega("H_N")),
    Column("M [MN m]", _mega("M_Nm")),
    Column("criterion", "criterion", words=True),
    Column("u [mm]", "u_m", factor=1e3),
    Column("rotation [deg]", "rotation_rad", 3, math.degrees(1.0)),
)
MACRO = (
    Column("macro-model H [MN]", _mega("H_macro_N")),
    Column("M [MN m]", _mega("M_macro_Nm")),
    Column("criterion", lambda row: row["criterion_macro"] or "-", words=True),
    Column("difference [%]", "difference_pct", "+.1f"),
)


def _remark(row: Row) -> str:
    texts = ("no envelope at this V" * bool(row["off_load"]), "upper bound" * bool(row["upper_bound"]), row["remarks"])
    return ", ".join(filter(None, texts))


CASES = (
    Column("case", "name", words=True),
    Column("limit state", "limit_state", words=True),
    Column("strength", "strength", words=True),
    Column("H [MN]", _mega("H_N")),
    Column("M [MN m]", _mega("M_Nm")),
    Column("V [MN]", _mega("V_N")),
    Column("utilisation", "utilisation", 3),
    Column("", _remark, words=True),
)
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


def table_of(outcome: Capacity) -> Table:
    """Return the capacities as a table; without the columns of a macro-model where there is none."""
    rows = outcome.table.to_dict("records")
    both = any(row["criterion_macro"] for row in rows)
    return Table.of(FULL + MACRO if both else FULL, rows, note=DIRECTIONS, wide=True)


def table_of_cases(cases: pd.DataFrame) -> Table:
    """Return the load cases as a table."""
    return Table.of(CASES, cases.to_dict("records"), wide=True)


def closing(table: pd.DataFrame) -> str:
    """Return a sentence on the difference of the models; empty where none is known."""
    known = table["difference_pct"].dropna()
    if not len(known):
        return ""
    return (
        f"macro-model against full model in {len(known)} of {len(table)} directions: "
        f"{known.min():+.1f} to {known.max():+.1f} %"
    )
