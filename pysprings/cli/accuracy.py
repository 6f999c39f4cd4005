# SPDX-License-Identifier: MIT
"""`pysprings accuracy`: runs the study with its progress, prints error against time and the files."""

import sys
from collections.abc import Sequence
from pathlib import Path

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.support import interruptible, print_json, print_table, to_stderr
from pysprings.core.columns import records
from pysprings.core.errors import RunIncomplete
from pysprings.core.progress import reporter
from pysprings.full_model.accuracy import presets
from pysprings.full_model.accuracy.presets import settings
from pysprings.scene.model import Scene
from pysprings.studies.accuracy import rows, runs, study
from pysprings.studies.accuracy.rows import StudyResult


def run(
    scene: Scene, out: Path, meshes: Sequence[str], quick: bool, force: bool, formats: Sequence[str], as_json: bool
) -> None:
    """Run or go on; raise RunIncomplete at the end where a run has not reached its end."""
    refuse_no_folder(out)
    chosen = settings(meshes, quick, *_linear_solvers(scene), fourier=presets.carries_series(scene))
    try:
        with interruptible(), reporter(sys.stderr) as progress:
            outcome = study.study(scene, out, chosen, progress, force, runs.run_in_child, formats)
    except KeyboardInterrupt:
        to_stderr(f"what has run is kept in {out}; the same command goes on")
        raise
    if as_json:
        print_json({"folder": str(out), **study.to_json(scene, outcome)})
    else:
        _print(out, outcome)
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
    from pydantic import ValidationError

    from fe_engine.linear.backends import available_backends

    solvers = []
    for name in available_backends():
        try:
            scene.replace(solver={"linear": name})
        except ValidationError:
            continue
        solvers.append(name)
    return solvers, solvers[0] if scene.solver.linear == "auto" else scene.solver.linear


def _print(out: Path, outcome: StudyResult) -> None:
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
