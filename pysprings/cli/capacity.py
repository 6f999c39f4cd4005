# SPDX-License-Identifier: MIT
"""`pysprings capacity`: the full model pushed to failure in directions of H and M, the macro-model beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pysprings.cli.options import (
    Changes,
    DrawnFigures,
    EstimateError,
    Format,
    Jobs,
    Json,
    Mesh,
    NoFigures,
    SceneFile,
    Series,
    formats_of,
    option,
)
from pysprings.cli.support import kept_in, print_files, print_json, print_table, quantities, refuse, to_stderr

if TYPE_CHECKING:
    from pysprings.scene.model import Scene
    from pysprings.studies.capacity.plan import Request
    from pysprings.studies.capacity.points import Capacity


def capacity(
    scene: SceneFile,
    vertical: Annotated[
        list[str] | None, option("--V", 'vertical load, e.g. "3 MN", or balanced; may be repeated', "FORCE")
    ] = None,
    directions: Annotated[int, option("--directions", "directions of H and M", "N")] = 8,
    torsion: Annotated[
        list[str] | None,
        option(
            "--torsion",
            'also loads at this angle out of the plane of H and M, e.g. "45 deg" (90: T alone); repeated',
            "ANGLE",
        ),
    ] = None,
    out: Annotated[Path | None, option("--out", "result folder [default: out/capacity-SCENE]", "DIR")] = None,
    factor: Annotated[
        list[str] | None,
        option("--factor", "also with design strength: 1.25 on tan phi, c and su, or su=1.4; repeated", "FACTOR"),
    ] = None,
    cases: Annotated[
        Path | None, option("--cases", "load cases to draw, with their utilisation; or design.cases", "FILE")
    ] = None,
    springs: Annotated[
        Path | None, option("--springs", "springs beside it, instead of rays of their own", "RESULT")
    ] = None,
    macro: Annotated[bool, option("--macro/--no-macro", "set the macro-model beside it")] = True,
    mesh: Mesh = None,
    discretisation: Series = None,
    estimate: EstimateError = None,
    changes: Changes = None,
    force: Annotated[bool, option("--force", "repeat every run")] = False,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Push the full model to failure in directions of H, M (and T).

    At given V; nothing is fitted. Runs that have ended in DIR are not run again; interrupted ones go on.
    Series where the scene allows.
    """
    from pysprings.cli.folders import refuse_no_folder
    from pysprings.cli.inputs import springs_or_table
    from pysprings.core.tables.load_cases import read_load_cases
    from pysprings.scene.load import load_scene
    from pysprings.studies.capacity import study

    if springs is not None and not macro:
        refuse("--springs", "are those of the macro-model, which --no-macro leaves out: give one of them")
    if springs is not None and factor:
        refuse("--springs", "are of one strength, and --factor asks for two: give one of them")
    folder = out or Path("out") / f"capacity-{scene.stem}"
    refuse_no_folder(folder)
    read = load_scene(scene, changes or ())
    request = _request(read, vertical or [], directions, macro and springs is None, factor or [], torsion or [])
    request = replace(request, estimate=estimate)
    chosen, given = study.scene_of(read, mesh, discretisation), None
    if file := cases or read.design.cases:
        every, radius = read_load_cases(file), 0.5 * read.caisson.outer_diameter
        request = study.with_torsion(chosen, request, every)
        given = every.bounded(radius, bool(request.torsion) or every.twisted(radius))
    if springs is not None and not springs.exists():
        refuse("--springs", "no such file or folder", springs)
    model = None if springs is None else springs_or_table(springs, None)
    formats = formats_of(figures, no_figures, figure_format)
    with kept_in(folder) as progress:
        outcome = study.study(chosen, folder, request, progress, model, given, force, formats, jobs)
    if as_json:
        print_json({"folder": str(folder), **study.to_json(outcome)})
    else:
        _print(folder, outcome)
    for text in outcome.remarks:
        to_stderr(f"warning: {text}")


def _request(
    scene: Scene, loads: list[str], directions: int, rays: bool, factors: list[str], torsion: list[str]
) -> Request:
    """Return what is asked for; refuse what is no vertical load, number of directions, factor or angle."""
    from pysprings.scene.design_strength import StrengthFactors
    from pysprings.studies.capacity.plan import Request

    word = "balanced"
    texts = [text for text in loads if text.strip() != word]
    values = quantities({f"--V {text}": (text, "N", "3 MN") for text in texts})
    asked = [word if text.strip() == word else values[f"--V {text}"] for text in loads]
    known = [each for each in asked if each is not None] or [scene.caisson.vertical_load]
    angles = quantities({f"--torsion {text}": (text, "rad", "45 deg") for text in torsion})
    turned = tuple(each for each in angles.values() if each is not None)
    return Request(tuple(known), directions, rays, StrengthFactors.read(factors), turned)


def _print(folder: Path, outcome: Capacity) -> None:
    from pysprings.studies.capacity import picture, study

    print_table(picture.table_of(outcome))
    print(f"\n{picture.criteria(outcome)}")
    if outcome.cases is not None:
        print()
        print_table(picture.table_of_cases(outcome.cases))
    if closing := picture.closing(outcome.table):
        print(f"\n{closing}")
    print()
    print_files(folder, study.FILES)
