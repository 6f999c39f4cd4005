# SPDX-License-Identifier: MIT
"""The whole study in a folder: runs, table, document, picture; and the presets that the package ships."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core import version
from pysprings.core.columns import records
from pysprings.core.errors import Problem, UserInputError, following
from pysprings.core.files.lock import exclusive, new_folder
from pysprings.core.files.storage import remove_leftovers, write_text
from pysprings.core.files.written import own_folder
from pysprings.core.text import json_text
from pysprings.full_model.accuracy.measures import MEASURES
from pysprings.full_model.accuracy.presets import JUDGED, SCHEMA, TARGETS, Setting
from pysprings.studies.accuracy import rows, runs, text
from pysprings.studies.accuracy.rows import StudyResult
from pysprings.studies.accuracy.runs import Run, run_in_child
from pysprings.studies.stored_runs import RUNS

if TYPE_CHECKING:
    from pysprings.core.progress import Progress
    from pysprings.scene.load import Scene

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
    run: Run = run_in_child, formats: Sequence[str] = ("png",),
) -> StudyResult:  # fmt: skip
    """Run what has not ended yet, assess it and write everything; return what was found.

    force : have every run made again. run : how one is run (in a process of its own). formats : those of the picture,
    "png" and "svg"; none: no picture.
    """
    with new_folder(out), exclusive(out):
        remove_leftovers(out, own_folder(out, RUNS))
        if force:
            runs.forget_all(settings, out)
        ended = runs.run_all(scene, settings, out, report, run)
        outcome = rows.assess(ended)
        _write(out, scene, outcome, formats)
    return outcome


def to_json(scene: Scene, outcome: StudyResult) -> dict[str, Any]:
    """Return everything that was found, in SI and percent; numbers that are not there are null."""
    return {
        "schema": SCHEMA,
        **_origin(scene),
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


def presets(scene: Scene, outcome: StudyResult) -> dict[str, Any]:
    """Return what `--target-error` needs: the complete settings with error and cost, and the orders.

    The smallest order of all paths gives the largest estimate.
    """
    table = outcome.table
    names = [f"{name}_pct" for name in JUDGED]
    usable = table[(table["model"] == rows.FULL) & (table["status"] == "complete")].dropna(subset=names)
    if usable.empty:
        raise UserInputError([Problem(key="--write-presets", message="no run of the study has an error to offer")])
    solvers = {each.name: dict(each.solver) for each in outcome.settings}
    columns = [
        "name",
        "discretisation",
        "harmonics",
        "mesh",
        "refinement",
        "unknowns",
        "wall_s",
        "cpu_s",
        "units",
        *names,
    ]
    lines = [row | {"solver": solvers[row["name"]]} for row in records(usable[columns])]
    return {"schema": SCHEMA, "origin": _origin(scene), "orders": outcome.orders, "settings": lines}


def write_presets(scene: Scene, outcome: StudyResult, file: Path) -> Path:
    """Write the presets as JSON; return the path."""
    return write_text(json_text(presets(scene, outcome), indent=1) + "\n", file)


def _origin(scene: Scene) -> dict[str, Any]:
    return {
        "command": "pysprings accuracy",
        "scene": scene.title,
        "scene_sha256": scene.sha256,
        "version": version.__version__,
        "date": datetime.now(UTC).date().isoformat(),
        "machine": _machine(),
    }


def _machine() -> str:
    """Return a description of the machine that measured the seconds."""
    return f"{platform.machine()}, {sys.platform}, {os.cpu_count()} processors, Python {platform.python_version()}"


def _write(out: Path, scene: Scene, outcome: StudyResult, formats: Sequence[str]) -> None:
    from pysprings.results.plots.files import redraw
    from pysprings.studies.accuracy.picture import error_against_time

    write_text(outcome.table.to_csv(index=False, lineterminator="\n"), out / "accuracy.csv")
    write_text(json_text(to_json(scene, outcome), indent=1) + "\n", out / "accuracy.json")
    head = {
        "scene": scene.title,
        "sha256": scene.sha256,
        "made by": f"`pysprings accuracy`, version {version.__version__}",
        "seconds on": _machine(),
    }
    picture = f"accuracy.{formats[0]}" if formats else ""
    write_text(text.to_markdown(outcome, head, picture), out / "accuracy.md")
    with following("the picture was"):
        redraw(lambda: error_against_time(outcome.table, scene.title, TARGETS.values()), out / "accuracy", formats)
