# SPDX-License-Identifier: MIT
"""A study in words: the tables for a terminal and for a document."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pysprings.core.text import markdown_table
from pysprings.full_model.accuracy.measures import MEASURES
from pysprings.full_model.accuracy.presets import FOURIER, TARGETS, cheapest_within
from pysprings.studies.accuracy.rows import FULL, MACRO, StudyResult, records

if TYPE_CHECKING:
    import pandas as pd

_COSTS = {
    "name": ("setting", "s"),
    "unknowns": ("unknowns", ",.0f"),
    "increments": ("increments", ".0f"),
    "factorisations": ("factorisations", ".0f"),
    "wall_s": ("wall [s]", ".3g"),
    "cpu_s": ("CPU [s]", ".3g"),
    "units": ("wall [units]", ".3g"),
    "memory_MB": ("memory [MB]", ".0f"),
}
_MACRO_COSTS = {"name": ("springs from", "s"), "wall_s": ("50 points [ms]", ".3g"), "units": ("[units]", ".2g")}
_MACRO_ERRORS = ("load_max", "load_area", "rotation_max")


def columns(model: str) -> dict[str, tuple[str, str]]:
    """Return column -> (head, format) of the table of a model, FULL or MACRO."""
    costs = _COSTS if model == FULL else _MACRO_COSTS
    measured = tuple(MEASURES) if model == FULL else _MACRO_ERRORS
    headings = costs | {f"{name}_pct": (f"{MEASURES[name].head} [%]", ".2g") for name in measured}
    return headings | ({"from_mesh_pct": ("alone [%]", ".2g")} if model == FULL else {}) | {"mark": ("", "s")}


def cells(table: pd.DataFrame, model: str) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of the settings of a model as text."""
    shown = columns(model)
    part = table[table["model"] == model]
    rows = [[_cell(_value(row, name, model), form) for name, (_, form) in shown.items()] for row in records(part)]
    return [head for head, _ in shown.values()], rows


def reference_lines(outcome: StudyResult) -> Iterator[str]:
    """Yield one line a path and quantity: how the reference was made, and its uncertainty."""
    for path, references in outcome.references.items():
        for name, reference in references.items():
            doubts = [
                f"{measure.head} {doubt:.2g} %"
                for key, measure in MEASURES.items()
                if measure.quantity == name and math.isfinite(doubt := outcome.uncertainty[path][key])
            ]
            yield f"{path}, {name}: {reference.note}" + (f"; uncertain by {', '.join(doubts)}" if doubts else "")
    for path, apart in outcome.apart.items():
        parts = [f"{MEASURES[key].head} {value:.2g} %" for key, value in apart.items() if math.isfinite(value)]
        yield f"{path}: the limit of bricks is apart by {', '.join(parts)}"


def cell_size_of(outcome: StudyResult) -> str:
    """Return the size of cells from which the reference is extrapolated."""
    series = any(each.name in outcome.series and each.discretisation == FOURIER for each in outcome.settings)
    return "(unknowns/(N + 1))^(-1/2)" if series else "unknowns^(-1/3)"


def target_lines(table: pd.DataFrame) -> Iterator[str]:
    """Yield the cheapest setting within each target, by processor time."""
    full = records(table[(table["model"] == FULL) & (table["status"] == "complete")])
    for target, limit in TARGETS.items():
        row = cheapest_within(limit, full)
        if row is None:
            yield f"load and p-y (root mean square) within {target}: no setting"
            continue
        units = f", {row['units']:.3g} units" if row["units"] else ""
        time = f"{row['wall_s']:.3g} s wall, {row['cpu_s']:.3g} s CPU{units}"
        yield f"load and p-y (root mean square) within {target}: {row['name']}, {time}"


NOTES = (
    "wall and CPU: the whole run with its files, springs and checks, caches of compiled code warm, no pictures; "
    "unit: one factorisation and solve of the run's own last tangent.",
    "Errors at equal displacement beside the reference, worst path. Load max: largest difference over the largest "
    "load; load area: area between the curves over that below; p-y: over the largest p, root mean square and largest "
    "over 8 slices of the skirt; rotation: largest difference over the largest (M of a translation, H of a rotation); "
    "stiffness: at rest; pressure: peak contact pressure down to 0.9 of the skirt.",
    "alone: what the setting changes by itself: largest load difference from the same mesh with the scene's own "
    "settings. *: on the Pareto front of load max or p-y rms over wall time.",
)


def to_markdown(outcome: StudyResult, head: Mapping[str, Any], picture: str) -> str:
    """Return the study as a document; ``head`` names scene, command and version."""
    lines = ["# Error against time", "", *(f"- {name}: {value}" for name, value in head.items()), ""]
    lines += [f"![Error against time]({picture})", "", "## Full model", "", *_table(outcome, FULL)]
    lines += ["", *(text for note in NOTES for text in (note, "")), "## Reference", ""]
    lines += [f"Meshes {', '.join(outcome.series)}; h = {cell_size_of(outcome)}.", ""]
    lines += [f"- {line}" for line in reference_lines(outcome)]
    lines += ["", "## Cheapest settings", "", *(f"- {line}" for line in target_lines(outcome.table))]
    lines += ["", "## Macro-model", "", *_table(outcome, MACRO), ""]
    lines += [
        "Springs of each mesh, with all its depth slices and with fewer; the time is that of a curve of 50 points."
    ]
    stopped = [f"- {row['name']}: {row['why']}" for row in records(outcome.table) if row["why"]]
    return "\n".join(lines + (["", "## Stopped", "", *stopped] if stopped else [])) + "\n"


def _table(outcome: StudyResult, model: str) -> list[str]:
    heads, rows = cells(outcome.table, model)
    return markdown_table(heads, rows, numbers=True).splitlines()


def _value(row: Mapping[str, Any], name: str, model: str) -> Any:
    if name == "mark":
        return ("*" if row["pareto"] else "") + ("" if row["status"] == "complete" else " stopped")
    if name == "wall_s" and model == MACRO:
        return 1e3 * row[name]
    return row[name]


def _cell(value: Any, form: str) -> str:
    return "-" if value is None else format(value, form)
