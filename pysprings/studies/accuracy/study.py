# SPDX-License-Identifier: MIT
"""The whole study in a folder: runs, table, document, picture, tables for people."""

import math
import os
import platform
import sys
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from pysprings.core import version
from pysprings.core.columns import Column, Table, records
from pysprings.core.errors import following
from pysprings.core.progress import Progress
from pysprings.core.storage import remove_leftovers, write_text
from pysprings.core.text import json_text, percent
from pysprings.core.written import exclusive, new_folder, own_folder
from pysprings.full_model.accuracy.measures import MEASURES
from pysprings.full_model.accuracy.presets import FOURIER, SCHEMA, Setting, cheapest_within
from pysprings.full_model.accuracy.target import TARGETS
from pysprings.results.plots.files import redraw
from pysprings.scene.model import Scene
from pysprings.studies.accuracy import runs
from pysprings.studies.accuracy.rows import FULL, MACRO, StudyResult, assess, error_against_time
from pysprings.studies.stored_runs import RUNS, forget, run_folder

_COSTS = (
    Column("setting", "name", words=True),
    Column("unknowns", "unknowns", ",.0f"),
    Column("increments", "increments", ".0f"),
    Column("factorisations", "factorisations", ".0f"),
    Column("wall [s]", "wall_s", ".3g"),
    Column("CPU [s]", "cpu_s", ".3g"),
    Column("wall [units]", "units", ".3g"),
    Column("memory [MB]", "memory_MB", ".0f"),
)
_MACRO_COSTS = (
    Column("springs from", "name", words=True), Column("50 points [ms]", "wall_s", ".3g", 1e3),
    Column("[units]", "units", ".2g"),
)  # fmt: skip
_MACRO_ERRORS = ("load_max", "load_area", "rotation_max")


def _mark(row: Mapping[str, Any]) -> str:
    return ("*" if row["pareto"] else "") + ("" if row["status"] == "complete" else " stopped")


def columns(model: str) -> tuple[Column, ...]:
    """Return the columns of the table of a model, FULL or MACRO."""
    errors = (
        Column(f"{MEASURES[name].head} [%]", f"{name}_pct", ".2g")
        for name in (MEASURES if model == FULL else _MACRO_ERRORS)
    )
    alone = (Column("alone [%]", "from_mesh_pct", ".2g"),) if model == FULL else ()
    return (*(_COSTS if model == FULL else _MACRO_COSTS), *errors, *alone, Column("", _mark))


def table_of(table: pd.DataFrame, model: str) -> Table:
    """Return the settings of a model as a table for people."""
    return Table.of(columns(model), records(table[table["model"] == model]))


def reference_lines(outcome: StudyResult) -> Iterator[str]:
    """Yield one line a path and quantity: how the reference was made, and its uncertainty."""
    for path, references in outcome.references.items():
        for name, reference in references.items():
            doubts = [
                f"{measure.head} {percent(doubt)}"
                for key, measure in MEASURES.items()
                if measure.quantity == name and math.isfinite(doubt := outcome.uncertainty[path][key])
            ]
            yield f"{path}, {name}: {reference.note}" + (f"; uncertain by {', '.join(doubts)}" if doubts else "")
    for path, apart in outcome.apart.items():
        parts = [f"{MEASURES[key].head} {percent(value)}" for key, value in apart.items() if math.isfinite(value)]
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
    "Errors at equal displacement beside the reference, worst path; its own uncertainty comes on top. "
    "Load max: largest difference over the largest "
    "load; load area: area between the curves over that below; p-y: over the largest p, root mean square and largest "
    "over 8 slices of the skirt; rotation: largest difference over the largest (M of a translation, H of a rotation); "
    "stiffness: at rest; pressure: peak contact pressure down to 0.9 of the skirt.",
    "alone: what the setting changes by itself: largest load difference from the same mesh with the scene's own "
    "settings; series have a tolerance of 1e-3 where none is named, whatever the scene has. "
    "*: on the Pareto front of load max or p-y rms over wall time.",
)


def to_markdown(outcome: StudyResult, head: Mapping[str, Any], picture: str) -> str:
    """Return the study as a document; ``head`` names scene, command and version, ``picture`` its file (or none)."""
    lines = ["# Error against time", "", *(f"- {name}: {value}" for name, value in head.items()), ""]
    lines += [f"![Error against time]({picture})", ""] if picture else []
    lines += ["## Full model", "", *_table(outcome, FULL)]
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
    return table_of(outcome.table, model).markdown(numbers=True).splitlines()


CELL_SIZE = "unknowns^(-1/3); Fourier: (unknowns/(N + 1))^(-1/2)"
FILES = {
    "accuracy.md": "tables, reference and orders: the document",
    "accuracy.csv": "the table, a row a setting",
    "accuracy.json": "everything as JSON",
    "accuracy.png": "error against time",
    "accuracy.svg": "the same",
    RUNS: "the runs, each with its own report",
}


def study(
    scene: Scene, out: Path, settings: Sequence[Setting], report: Progress, force: bool = False,
    run: runs.Run = runs.run_in_child, formats: Sequence[str] = ("png",),
) -> StudyResult:  # fmt: skip
    """Run what has not ended yet, assess it and write everything; return what was found.

    force : have every run made again. run : how one is run (in a process of its own). formats : those of the picture,
    "png" and "svg"; none: no picture.
    """
    with new_folder(out), exclusive(out):
        remove_leftovers(out, own_folder(out, RUNS))
        if force:
            for setting in settings:
                forget(run_folder(out, setting.name))
        ended = runs.run_all(scene, settings, out, report, run)
        outcome = assess(ended)
        _write(out, scene, outcome, formats)
    return outcome


def to_json(scene: Scene, outcome: StudyResult) -> dict[str, Any]:
    """Return everything that was found, in SI and percent; numbers that are not there are null."""
    return {
        "schema": SCHEMA,
        "command": "pysprings accuracy",
        "scene": scene.title,
        "scene_sha256": scene.sha256,
        "version": version.__version__,
        "date": datetime.now(UTC).date().isoformat(),
        "machine": _machine(),
        "series": list(outcome.series),
        "cell_size": CELL_SIZE,
        "measures": {name: measure.words for name, measure in MEASURES.items()},
        "reference": {
            path: {
                name: {"order": each.order, "note": each.note}
                for name, each in references.items()
            } | {"uncertainty_pct": dict(outcome.uncertainty[path]),
                 "limit_of_bricks_pct": dict(outcome.apart.get(path, {}))}
            for path, references in outcome.references.items()
        },
        "rows": records(outcome.table),
    }  # fmt: skip


def _machine() -> str:
    """Return a description of the machine that measured the seconds."""
    return f"{platform.machine()}, {sys.platform}, {os.cpu_count()} processors, Python {platform.python_version()}"


def _write(out: Path, scene: Scene, outcome: StudyResult, formats: Sequence[str]) -> None:
    write_text(outcome.table.to_csv(index=False, lineterminator="\n"), out / "accuracy.csv")
    write_text(json_text(to_json(scene, outcome), indent=1) + "\n", out / "accuracy.json")
    head = {
        "scene": scene.title,
        "sha256": scene.sha256,
        "made by": f"`pysprings accuracy`, version {version.__version__}",
        "seconds on": _machine(),
    }
    picture = f"accuracy.{formats[0]}" if formats else ""
    write_text(to_markdown(outcome, head, picture), out / "accuracy.md")
    with following("the picture was"):
        redraw(lambda: error_against_time(outcome.table, scene.title, TARGETS.values()), out / "accuracy", formats)
