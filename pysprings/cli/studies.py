# SPDX-License-Identifier: MIT
"""`pysprings accuracy` and `stability`: many runs, and what they show."""

from pathlib import Path
from typing import Annotated

from pysprings.cli.options import DrawnFigures, Format, Jobs, Json, Mesh, NoFigures, SceneFile, formats_of, option
from pysprings.cli.support import quantities
from pysprings.core.errors import RunIncomplete


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
    from pysprings.cli.study_runs import run_accuracy
    from pysprings.scene.load import load_scene

    folder = out or Path("out") / f"accuracy-{scene.stem}"
    formats = formats_of(figures, no_figures, figure_format)
    run_accuracy(load_scene(scene), folder, mesh or [], quick, force, formats, as_json)


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
    from pysprings.cli.study_runs import run_stability

    far = quantities({"--reach": (reach, "m", "20 mm")})["--reach"]
    assert far is not None
    formats = formats_of(figures, no_figures, figure_format)
    unexplained = run_stability(case or [], mesh or "coarse", refinement, far, out, formats, as_json, jobs)
    if unexplained:
        raise RunIncomplete(f"{unexplained} cases ended without a named reason")
