# SPDX-License-Identifier: MIT
"""Claims and sensitivities as tables for people: Markdown, plain lines for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pysprings.core.text import markdown_table
from validation.paper.cases import END, SHOWN
from validation.paper.sensitivity import CRITERIA

if TYPE_CHECKING:
    import pandas as pd

# column of the table of sensitivities -> head, format
DRAINED_COLUMNS = {
    "variant": ("variant", "s"), "what": ("what", "s"), "standing": ("paper", "s"),
    "front_0.25m_2.5mm": ("front 0.25 m", ".2f"), "front_1.25m_2.5mm": ("1.25 m", ".2f"),
    "front_2.25m_2.5mm": ("2.25 m", ".2f"), "front_3.25m_2.5mm": ("3.25 m", ".2f"),
    "back_0.25m_2.5mm": ("back 0.25 m", ".2f"), "back_3.25m_2.5mm": ("3.25 m", ".2f"),
    "gap_2.5mm_mm": ("gap at 2.5 mm [mm]", ".3f"), "gap_20mm_mm": ("at 20 mm [mm]", ".2f"),
    "slope_ratio": ("tangent 0.3/3 mm", ".1f"), "bend_mm": ("bend at [mm]", ".1f"),
    "bend_sharpness": ("sharpness", ".2f"), "smooth_2.5mm": ("mu 0 / mu at 2.5 mm", ".2f"),
    "H_2.5mm_kN": ("H at 2.5 mm [kN]", ",.0f"),
    "H_20mm_kN": ("at 20 mm [kN]", ",.0f"),
    "is_front": ("front", "mark"), "is_gap": ("gap", "mark"), "is_break": ("break", "mark"),
    "is_half": ("half", "mark"), "of_four": ("of four", "d"),
}  # fmt: skip
WATER_COLUMNS = {
    "variant": ("variant", "s"), "what": ("what", "s"), "standing": ("paper", "s"),
    "over_drained_1mm": ("H over drained, 1 mm", ".3f"), "over_drained_2.5mm": ("2.5 mm", ".3f"),
    "over_drained_10mm": ("10 mm", ".3f"), "over_drained_20mm": ("20 mm", ".3f"),
    "front_1.25m_2.5mm": ("front 1.25 m, 2.5 mm", ".2f"), "back_3.25m_2.5mm": ("back 3.25 m, 2.5 mm", ".2f"),
    "back_3.25m_20mm": ("20 mm", ".2f"), "F_pw_20mm_kN": ("F_pw at 20 mm [kN]", ".1f"),
    "gap_20mm_mm": ("gap at 20 mm [mm]", ".2f"), "H_20mm_kN": ("H at 20 mm [kN]", ",.0f"),
}  # fmt: skip
NOTE = (
    f"paper: open, where it is silent; stated, where the reading differs from what it states. front, back: p'_N over "
    f"initial outside at {1e3 * SHOWN:g} mm. gap: widest opening on the rear half of the skirt, outside. bend: the "
    f"sharpest bend of the load curve; sharpness: per cent by which the tangent falls per cent of u there. mu 0 / mu: "
    f"load without over load with friction. All to {1e3 * END:g} mm, the runs without friction to {1e3 * SHOWN:g} mm."
)


def split(table: pd.DataFrame) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the drained and the partially drained rows of a table of sensitivities."""
    rows = [{str(key): value for key, value in row.items()} for row in table.to_dict(orient="records")]
    return [r for r in rows if r["group"] != "water"], [r for r in rows if r["group"] == "water"]


def cell(value: Any, form: str) -> str:
    """Return a cell's text; '-' for unknown values."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    if form == "mark":
        return "yes" if value is True or value == 1.0 or value == "True" else "no"
    if form == "s":
        return str(value)
    text = format(int(value) if form == "d" else float(value) + 0.0, form)
    return text.removeprefix("-") if set(text) <= set("-0.,") else text


def cells(row: Mapping[str, Any], columns: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the cells of a row; the outcome of a variant that was refused or stopped stands beside its description."""
    shown = dict(row)
    if row["status"] != "complete":
        shown["what"] = f"{row['what']} ({row['status']}: {row['detail']})"
    return [cell(shown.get(name), form) for name, (_, form) in columns.items()]


def claims_markdown(table: pd.DataFrame) -> str:
    """Return the table of the claims."""
    rows = [
        [str(r["number"]), str(r["claim"]), str(r["figure"]), f"**{r['verdict']}**", str(r["reason"]),
         str(r["criterion"])]
        for r in table.to_dict(orient="records")
    ]  # fmt: skip
    return markdown_table(["", "the paper", "here", "verdict", "reason", "criterion"], rows)


def sensitivity_markdown(table: pd.DataFrame) -> str:
    """Return the tables of the sensitivities with their criteria and what they come to."""
    drained, water = split(table)
    parts = [f"{conclusion(table)}\n", f"{CRITERIA}\n", f"{NOTE}\n"]
    for rows, columns in ((drained, DRAINED_COLUMNS), (water, WATER_COLUMNS)):
        if rows:
            parts.append(markdown_table([head for head, _ in columns.values()], [cells(row, columns) for row in rows]))
    return "\n".join(parts)


def conclusion(table: pd.DataFrame) -> str:
    """Return one or two sentences: whether any reading gives all four figures, and which readings come nearest."""
    drained, _ = split(table)
    readings = int(table["variants"].iloc[0]) if "variants" in table else len(table)
    part = f" Only {len(table)} of {readings} readings have run so far." if len(table) < readings else ""
    return _conclusion(drained) + part


def _conclusion(drained: Sequence[Mapping[str, Any]]) -> str:
    names = {"is_front": "front stress", "is_gap": "gap", "is_break": "break of slope", "is_half": "halving"}
    known = [row for row in drained if row["status"] != "refused"]
    whole = [row for row in known if all(_true(row.get(key)) for key in names)]
    if whole:
        text = "All four of the paper's figures come out of: " + "; ".join(_named(row) for row in whole) + "."
        stated = all(row["standing"] == "stated" for row in whole)
        return text + (" None of these leaves the paper's stated values as they are." if stated else "")
    both = [row for row in known if _true(row.get("is_front")) and (_true(row.get("is_gap")) or _true(row["is_break"]))]
    text = "No reading tried here gives all four of the paper's figures (front stress, gap, break of slope, halving)."
    if not both:
        return f"{text} None gives the front stress together with the gap or the break."
    cases = "; ".join(f"{_named(row)} ({', '.join(w for k, w in names.items() if _true(row.get(k)))})" for row in both)
    return f"{text} With the front stress come a gap or a break in: {cases}."


def _named(row: Mapping[str, Any]) -> str:
    return f"{row['what']} [{row['standing']}]"


def _true(value: Any) -> bool:
    return value is True or value == 1.0 or value == "True"


def claim_lines(table: pd.DataFrame) -> list[str]:
    """Return the claims for a terminal: verdict and words, the figure below."""
    lines = []
    for row in table.to_dict(orient="records"):
        lines.append(f"{row['number']:>2}  {row['verdict']:<11}  {row['claim']}")
        lines.append(f"{'':17}{row['figure']}" + (f" -- {row['reason']}" if row["reason"] else ""))
    counts = table["verdict"].value_counts()
    lines.append("")
    lines.append(", ".join(f"{counts[name]} {name}" for name in counts.index))
    return lines
