# SPDX-License-Identifier: MIT
"""`pysprings compare`: the prediction with the springs beside the full model; `pysprings diff`: two runs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.inputs import refuse_unfinished, springs_of
from pysprings.cli.options import Format, Json, OneSpringSet, Result, argument, option
from pysprings.cli.support import print_json, print_table, refuse
from pysprings.core.columns import Table

if TYPE_CHECKING:
    from pysprings.results.two_runs import Run


def compare(
    result: Result,
    spring_set: OneSpringSet = None,
    slices: Annotated[bool, option("--slices", "error and cost by number of depth slices instead")] = False,
    cycles: Annotated[
        bool, option("--cycles", "paths that turn back instead: errors, and peaks, work and damping by cycle")
    ] = False,
    as_json: Json = False,
) -> None:
    """Set the springs beside the full model: eta and errors by path."""
    tree = springs_of(result)
    if slices and cycles:
        refuse("--cycles", "give either this or --slices")
    if cycles:
        from pysprings.macro import cycles as by_cycle

        found = by_cycle.compare_cycles(tree, spring_set)
        if as_json:
            print_json(by_cycle.to_dict(found))
        else:
            print(by_cycle.to_text(found), end="")
        return
    from pysprings.macro import comparison

    if slices:
        table = comparison.slice_convergence(tree, springs_kind=spring_set)
        if as_json:
            print_json({"rows": table.to_dict(orient="records")})
        else:
            print(comparison.convergence_text(table), end="")
        return
    from pysprings.macro.comparison_text import to_dict, to_text

    frame = comparison.compare(tree, spring_set)
    if as_json:
        print_json(to_dict(frame))
    else:
        print(to_text(frame), end="")


WIDTHS = (16, 26, 20, 20, 10)  # of the table: a terminal of 100 characters


def diff(
    first: Annotated[Path, argument("RUN", "folder of a run")],
    second: Annotated[Path, argument("RUN", "folder of another run")],
    out: Annotated[Path | None, option("--out", "also draw both over each other, a picture a path", "DIR")] = None,
    figure_format: Format = "png",
    as_json: Json = False,
) -> None:
    """Set two runs beside each other: stiffness, loads, limits. Scenes are compared, loads at equal motion."""
    from pysprings.results.two_runs import common_paths, differences

    if out is not None:
        refuse_no_folder(out)
    runs = open_run(first, str(first)), open_run(second, str(second))
    rows = differences(*runs)
    pictures = [] if out is None else _draw(*runs, common_paths(*runs), out, figure_format)
    if as_json:
        files = [str(file) for file in pictures]
        print_json({"runs": [str(first), str(second)], "rows": [asdict(row) for row in rows], "pictures": files})
        return
    change = ["" if row.change is None else f"{row.change + 0.0:+.2f}" for row in rows]
    cells = [(*row.cells, each) for row, each in zip(rows, change, strict=True)]
    heads = ("", "quantity", str(first), str(second), "change [%]")
    print_table(Table("", heads, cells, left=(True, True, True, True)), WIDTHS)
    for file in pictures:
        print(file)


def open_run(folder: Path, name: str) -> Run:
    """Open the result and record of the folder of a run; refuse any other folder."""
    from pysprings.full_model.run_record import RunRecord
    from pysprings.results.layout import open_result
    from pysprings.results.two_runs import Run

    record = RunRecord.read(folder) if folder.is_dir() else None
    if record is None or not (folder / "full_model.nc").exists():
        refuse(None, "is not the folder of a run (run.json and full_model.nc are needed)", folder)
    refuse_unfinished(folder)
    return Run(name, open_result(folder), record)


def _draw(first: Run, second: Run, names: list[str], out: Path, figure_format: str) -> list[Path]:
    from pysprings.results.plots.comparison import overlay
    from pysprings.results.plots.files import save
    from pysprings.springs.path import paths_of

    out.mkdir(parents=True, exist_ok=True)
    runs = {each.name: paths_of(each.result) for each in (first, second)}
    drawn = ((name, overlay({run: paths[name].dataset for run, paths in runs.items()}, name)) for name in names)
    return [file for name, figure in drawn for file in save(figure, out / name, figure_format.split(","))]
