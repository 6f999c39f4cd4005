# SPDX-License-Identifier: MIT
"""The table of the stiff and extreme cases for a terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from pysprings.core.text import markdown_table

if TYPE_CHECKING:
    import pandas as pd

# column of the table -> head, format
_COLUMNS = {
    "case": ("case", "s"),
    "outcome": ("outcome", "s"),
    "u_mm": ("u [mm]", ".2f"),
    "H_kN": ("H [kN]", ",.0f"),
    "increments": ("increments", "d"),
    "cut_backs": ("cut", "d"),
    "median_iterations": ("median", ".0f"),
    "max_iterations": ("most", ".0f"),
    "worst_residual": ("residual", ".0e"),
    "energy_imbalance": ("energy", ".0e"),
    "water_imbalance": ("water", ".0e"),
    "condition": ("condition", ".0e"),
    "wall_s": ("wall [s]", ".0f"),
}


def heading() -> str:
    """Return the two head lines."""
    heads = [_pad(name, head) for name, (head, _) in _COLUMNS.items()]
    return "  ".join(heads).rstrip() + "\n" + "  ".join("-" * len(head) for head in heads)


def line(row: dict[str, Any]) -> str:
    """Return one case, with its warning or reason below, if any."""
    text = "  ".join(_pad(name, _cell(row[name], form)) for name, (_, form) in _COLUMNS.items()).rstrip()
    return f"{text}\n    {row['detail']}" if row["detail"] else text


def closing(summary: dict[str, Any]) -> str:
    """Return the counts, and two measures of the difficulty of the cases."""
    counts = ", ".join(
        f"{summary[name]} {name}" for name in ("converged", "warned", "stopped", "refused", "unexplained")
    )
    if not summary["increments"]:
        return counts
    share = 100.0 * summary["cut_backs_over_increments"]
    return (
        f"{counts}\nover the cases that reached their end: median of iterations {summary['median_iterations']:.0f}, "
        f"{summary['cut_backs']} steps cut in {summary['increments']} increments ({share:.0f} %), "
        f"energy imbalance at most {summary['worst_energy_imbalance']:.0e}"
    )


def to_markdown(table: pd.DataFrame) -> str:
    """Return the table for a document, one line a case."""
    heads = [*(head for head, _ in _COLUMNS.values()), "warning or reason"]
    rows = [
        [*(_cell(row[str(name)], form) for name, (_, form) in _COLUMNS.items()), str(row["detail"])]
        for row in table.to_dict(orient="records")
    ]
    return markdown_table(heads, rows)


def _cell(value: Any, form: str) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    return format(int(value) if form == "d" else value, form)


def _pad(name: str, text: str) -> str:
    if name == "case":
        return text.ljust(22)
    if name == "outcome":
        return text.ljust(11)
    return text.rjust(max(9, len(_COLUMNS[name][0])))
