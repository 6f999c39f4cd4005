# SPDX-License-Identifier: MIT
"""`pysprings accuracy` and `stability`: run the studies with their progress, print what they show, write it."""

import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd
from pydantic import ValidationError

from fe_engine.linear.backends import available_backends
from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.support import interruptible, print_json, print_table, to_stderr
from pysprings.core.columns import records
from pysprings.core.errors import RunIncomplete, following
from pysprings.core.progress import reporter
from pysprings.core.storage import write_text
from pysprings.core.workers import cores
from pysprings.full_model.accuracy import presets
from pysprings.results.plots.files import redraw
from pysprings.scene.model import Scene
from pysprings.studies import stability
from pysprings.studies.accuracy import rows, runs, study


def run_accuracy(
    scene: Scene, out: Path, meshes: Sequence[str], quick: bool, force: bool, formats: Sequence[str], as_json: bool
) -> None:
    """Run or go on; raise RunIncomplete at the end where a run has not reached its end."""
    refuse_no_folder(out)
    chosen = presets.settings(meshes, quick, *_linear_solvers(scene), fourier=presets.carries_series(scene))
    try:
        with interruptible(), reporter(sys.stderr) as progress:
            outcome = study.study(scene, out, chosen, progress, force, runs.run_in_child, formats)
    except KeyboardInterrupt:
        to_stderr(f"what has run is kept in {out}; the same command goes on")
        raise
    if as_json:
        print_json({"folder": str(out), **study.to_json(scene, outcome)})
    else:
        _print_accuracy(out, outcome)
    # a variation that stops is a result of the study; without a mesh of the series there is no reference
    meshes_stopped = [
        f"{row['name']}: {row['why']}"
        for row in records(outcome.table)
        if row["model"] == rows.FULL and row["series"] and row["why"]
    ]
    if meshes_stopped:
        raise RunIncomplete("; ".join(meshes_stopped), out)


def _linear_solvers(scene: Scene) -> tuple[list[str], str]:
    """Return the linear solvers that a scene may name and that work here, and the one that the scene uses."""
    solvers = []
    for name in available_backends():
        try:
            scene.replace(solver={"linear": name})
        except ValidationError:
            continue
        solvers.append(name)
    return solvers, solvers[0] if scene.solver.linear == "auto" else scene.solver.linear


def _print_accuracy(out: Path, outcome: rows.StudyResult) -> None:
    for model in (rows.FULL, rows.MACRO):
        table = study.table_of(outcome.table, model)
        if table.rows:
            print_table(table)
            print()
    print(f"reference: meshes {', '.join(outcome.series)}; h = {study.cell_size_of(outcome)}")
    for line in [*study.reference_lines(outcome), *study.target_lines(outcome.table)]:
        print(line)
    print()
    for note in study.NOTES:
        print(note)
    print()
    for name, meaning in study.FILES.items():
        if (out / name).exists():
            print(f"{out / name}: {meaning}")


def run_stability(
    names: list[str], mesh: str, refinement: float, reach: float, out: Path | None, formats: Sequence[str],
    as_json: bool, jobs: int | None = None,
) -> int:  # fmt: skip
    """Run the cases of these names (all: none given) as far as ``reach`` (m); return how many ended unexplained."""
    cases = stability.cases_named(names)

    ended: list[stability.Outcome] = []

    def report(outcome: stability.Outcome) -> None:
        ended.append(outcome)
        text = stability.line(asdict(outcome))
        if as_json:
            to_stderr(text)
        else:
            print(text, flush=True)

    if not as_json:
        print(stability.heading(), flush=True)
    try:
        with interruptible():
            table = stability.run_cases(cases, mesh, refinement, report, reach, jobs or cores())
    except KeyboardInterrupt:
        if out is not None and ended:
            _write_stability(stability.table_of(ended), out, formats)
            to_stderr(f"the cases that have ended are in {out}")
        raise
    total = stability.summary(table)
    if out is not None:
        _write_stability(table, out, formats)
    if as_json:
        cases_shown = records(table)
        print_json({"mesh": mesh, "refinement": refinement, "reach_m": reach, "summary": total, "cases": cases_shown})
    else:
        print(f"\n{stability.closing(total)}")
    return int(total[stability.UNEXPLAINED])


def _write_stability(table: pd.DataFrame, out: Path, formats: Sequence[str]) -> None:
    """Write stability.csv, stability.md and stability.png or stability.svg."""
    write_text(table.to_csv(index=False, lineterminator="\n"), out / "stability.csv")
    write_text(stability.to_markdown(table), out / "stability.md")
    with following("the picture was"):
        redraw(lambda: stability.catalogue(table), out / "stability", formats)
