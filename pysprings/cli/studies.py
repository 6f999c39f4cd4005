# SPDX-License-Identifier: MIT
"""`pysprings accuracy` and `stability`: many runs with their progress, what they show, and its files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.options import DrawnFigures, Format, Jobs, Json, Mesh, NoFigures, SceneFile, formats_of, option
from pysprings.cli.support import interruptible, kept_in, print_files, print_json, print_table, quantities, to_stderr
from pysprings.core.columns import records
from pysprings.core.errors import RunIncomplete, following

if TYPE_CHECKING:
    import pandas as pd

    from pysprings.scene.model import Scene
    from pysprings.studies.accuracy.rows import StudyResult
    from pysprings.studies.stability import Outcome


def accuracy(
    scene: SceneFile,
    out: Annotated[Path | None, option("--out", "result folder [default: out/accuracy-SCENE]", "DIR")] = None,
    quick: Annotated[bool, option("--quick", "small meshes and few settings")] = False,
    mesh: Annotated[
        list[str] | None, option("--mesh", "a mesh of the series, or medium:0.7; repeated, three at best", "PRESET")
    ] = None,
    force: Annotated[bool, option("--force", "repeat every run")] = False,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    as_json: Json = False,
) -> None:
    """Measure error against run time over meshes and settings. Table, picture, Pareto front.

    Runs that have ended in DIR are not run again; interrupted ones go on.
    """
    from pysprings.full_model.accuracy import presets
    from pysprings.scene.load import load_scene
    from pysprings.studies.accuracy import rows, runs, study

    folder = out or Path("out") / f"accuracy-{scene.stem}"
    formats, read = formats_of(figures, no_figures, figure_format), load_scene(scene)
    refuse_no_folder(folder)
    chosen = presets.settings(mesh or [], quick, *_linear_solvers(read), fourier=presets.carries_series(read))
    with kept_in(folder) as progress:
        outcome = study.study(read, folder, chosen, progress, force, runs.run_in_child, formats)
    if as_json:
        print_json({"folder": str(folder), **study.to_json(read, outcome)})
    else:
        _print_accuracy(folder, outcome)
    # a variation that stops is a result of the study; without a mesh of the series there is no reference
    meshes_stopped = [
        f"{row['name']}: {row['why']}"
        for row in records(outcome.table)
        if row["model"] == rows.FULL and row["series"] and row["why"]
    ]
    if meshes_stopped:
        raise RunIncomplete("; ".join(meshes_stopped), folder)


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


def _print_accuracy(out: Path, outcome: StudyResult) -> None:
    from pysprings.studies.accuracy import rows, study

    for model in (rows.FULL, rows.MACRO):
        table = study.table_of(outcome.table, model)
        if table.rows:
            print_table(table)
            print()
    print(f"reference: meshes {', '.join(outcome.series)}; h = {study.cell_size_of(outcome)}")
    for line in [*study.reference_lines(outcome), *study.target_lines(outcome.table), "", *study.NOTES, ""]:
        print(line)
    print_files(out, study.FILES)


def stability(
    case: Annotated[list[str] | None, option("--case", "a case or a group of cases; may be repeated", "NAME")] = None,
    mesh: Mesh = None,
    refinement: Annotated[float, option("--refinement", "factor on the preset's numbers of cells")] = 1.0,
    reach: Annotated[
        str, option("--reach", "displacement of the cases that set none of their own", "LENGTH")
    ] = "20 mm",
    out: Annotated[Path | None, option("--out", "folder for the table and its picture", "DIR")] = None,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Run the stiff and extreme cases: outcome, steps, residuals.

    Ends with exit code 3 where a case stops without a named reason.
    """
    from pysprings.core.workers import cores
    from pysprings.studies import stability as catalogue

    far = quantities({"--reach": (reach, "m", "20 mm")})["--reach"]
    assert far is not None
    formats, preset = formats_of(figures, no_figures, figure_format), mesh or "coarse"
    cases, ended = catalogue.cases_named(case or []), list[catalogue.Outcome]()

    def report(outcome: Outcome) -> None:
        ended.append(outcome)
        text = catalogue.line(asdict(outcome))
        if as_json:
            to_stderr(text)
        else:
            print(text, flush=True)

    if not as_json:
        print(catalogue.heading(), flush=True)
    try:
        with interruptible():
            table = catalogue.run_cases(cases, preset, refinement, report, far, jobs or cores())
    except KeyboardInterrupt:
        if out is not None and ended:
            _write_stability(catalogue.table_of(ended), out, formats)
            to_stderr(f"the cases that have ended are in {out}")
        raise
    total = catalogue.summary(table)
    if out is not None:
        _write_stability(table, out, formats)
    if as_json:
        document = {"mesh": preset, "refinement": refinement, "reach_m": far, "summary": total}
        print_json(document | {"cases": records(table)})
    else:
        print(f"\n{catalogue.closing(total)}")
    if unexplained := int(total[catalogue.UNEXPLAINED]):
        raise RunIncomplete(f"{unexplained} cases ended without a named reason")


def _write_stability(table: pd.DataFrame, out: Path, formats: Sequence[str]) -> None:
    """Write stability.csv, stability.md and stability.png or stability.svg."""
    from pysprings.core.storage import write_text
    from pysprings.results.plots.files import redraw
    from pysprings.studies import stability as catalogue

    write_text(table.to_csv(index=False, lineterminator="\n"), out / "stability.csv")
    write_text(catalogue.to_markdown(table), out / "stability.md")
    with following("the picture was"):
        redraw(lambda: catalogue.catalogue(table), out / "stability", formats)
