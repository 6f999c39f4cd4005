# SPDX-License-Identifier: MIT
"""Claims and sensitivities as tables for people: Markdown, plain lines for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pysprings.core.columns import Column, Table
from pysprings.core.text import markdown_table
from validation.paper.cases import END, SHOWN
from validation.paper.sensitivity import CRITERIA

if TYPE_CHECKING:
    import pandas as pd


def _what(row: Mapping[str, Any]) -> str:
    """Return the description of a variant; with its outcome where it was refused or stopped."""
    return row["what"] if row["status"] == "complete" else f"{row['what']} ({row['status']}: {row['detail']})"


def _mark(head: str, key: str) -> Column:
    """Return a column of yes and no; '-' where nothing is known."""
    known = Column(head, key)

    def value(row: Mapping[str, Any]) -> Any:
        found = known.value(row)
        return found if found is None else "yes" if _true(row[key]) else "no"

    return Column(head, value)


DRAINED_COLUMNS = (
    Column("variant", "variant", words=True),
    Column("what", _what, words=True),
    Column("paper", "standing", words=True),
    Column("front 0.25 m", "front_0.25m_2.5mm", ".2f"),
    Column("1.25 m", "front_1.25m_2.5mm", ".2f"),
    Column("2.25 m", "front_2.25m_2.5mm", ".2f"),
    Column("3.25 m", "front_3.25m_2.5mm", ".2f"),
    Column("back 0.25 m", "back_0.25m_2.5mm", ".2f"),
    Column("3.25 m", "back_3.25m_2.5mm", ".2f"),
    Column("gap at 2.5 mm [mm]", "gap_2.5mm_mm", ".3f"),
    Column("at 20 mm [mm]", "gap_20mm_mm", ".2f"),
    Column("tangent 0.3/3 mm", "slope_ratio", ".1f"),
    Column("bend at [mm]", "bend_mm", ".1f"),
    Column("sharpness", "bend_sharpness", ".2f"),
    Column("mu 0 / mu at 2.5 mm", "smooth_2.5mm", ".2f"),
    Column("H at 2.5 mm [kN]", "H_2.5mm_kN", ",.0f"),
    Column("at 20 mm [kN]", "H_20mm_kN", ",.0f"),
    _mark("front", "is_front"),
    _mark("gap", "is_gap"),
    _mark("break", "is_break"),
    _mark("half", "is_half"),
    Column("of four", "of_four", "d"),
)
WATER_COLUMNS = (
    Column("variant", "variant", words=True),
    Column("what", _what, words=True),
    Column("paper", "standing", words=True),
    Column("H over drained, 1 mm", "over_drained_1mm", ".3f"),
    Column("2.5 mm", "over_drained_2.5mm", ".3f"),
    Column("10 mm", "over_drained_10mm", ".3f"),
    Column("20 mm", "over_drained_20mm", ".3f"),
    Column("front 1.25 m, 2.5 mm", "front_1.25m_2.5mm", ".2f"),
    Column("back 3.25 m, 2.5 mm", "back_3.25m_2.5mm", ".2f"),
    Column("20 mm", "back_3.25m_20mm", ".2f"),
    Column("F_pw at 20 mm [kN]", "F_pw_20mm_kN", ".1f"),
    Column("gap at 20 mm [mm]", "gap_20mm_mm", ".2f"),
    Column("H at 20 mm [kN]", "H_20mm_kN", ",.0f"),
)
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
            parts.append(Table.of(columns, rows).markdown())
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
