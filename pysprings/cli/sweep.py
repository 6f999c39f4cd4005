# SPDX-License-Identifier: MIT
"""`pysprings sweep`: many scenes, a folder each, one dataset of all."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pysprings.cli.options import Format, Json, argument, option
from pysprings.cli.support import kept_in, print_json, print_table, refuse, to_stderr
from pysprings.core.columns import Table
from pysprings.core.errors import RunIncomplete

if TYPE_CHECKING:
    from pysprings.studies.sweep.study import Study


def sweep(
    study: Annotated[Path, argument("STUDY", "study file (TOML): base scene and axes")],
    out: Annotated[Path | None, option("--out", "result folder [default: out/sweep-STUDY]", "DIR")] = None,
    scheduler: Annotated[
        str | None,
        option("--scheduler", "Dask scheduler (tcp://...), or its scheduler file; not this machine", "ADDRESS"),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", metavar="N", min=1, help="processes on this machine [default: its cores]")
    ] = None,
    plan_only: Annotated[bool, option("--plan", "check the cases and write cases.csv; run nothing")] = False,
    again: Annotated[bool, option("--again", "make cases.csv anew from a changed study; what has run stays")] = False,
    table: Annotated[
        list[Path] | None, option("--table", "also a table: .csv or .xlsx; may be repeated", "FILE")
    ] = None,
    picture: Annotated[
        list[str] | None, option("--picture", "draw a quantity of study.nc, e.g. K_H; may be repeated", "NAME")
    ] = None,
    over: Annotated[
        str | None, option("--over", "axes of the pictures [default: the first two]", "AXIS[,AXIS]")
    ] = None,
    figure_format: Format = "png",
    quiet: Annotated[bool, option("--quiet", "errors and warnings alone")] = False,
    as_json: Json = False,
) -> None:
    """Run a scene over axes of its values. A folder a case; cases.csv and study.nc have all of them.

    Cases that have ended in DIR are not run again; interrupted ones go on. Failed and stopped cases are rows with a
    reason, and end the command with exit code 3.
    """
    from pysprings.cli.folders import refuse_no_folder, refuse_read
    from pysprings.studies.sweep import dataset, study as studies
    from pysprings.studies.sweep.plan import CASES
    from pysprings.studies.sweep.study_file import read_study
    from pysprings.studies.sweep.worker import Place

    if scheduler is not None and jobs is not None:
        refuse("--jobs", "the scheduler has workers of its own: give one of the two")
    if over is not None and not picture:
        refuse("--over", "names the axes of pictures: give --picture, too")
    folder = out or Path("out") / f"sweep-{study.stem}"
    for each in table or []:
        dataset.suffix_of(each)
        refuse_read("--table", each, study, folder / CASES)
    refuse_no_folder(folder)
    plan = read_study(study)
    known = [axis.name for axis in plan.axes]
    if missing := sorted({*_axes(over)} - {*known}):
        refuse("--over", f"no axis '{missing[0]}'; there are: {', '.join(known)}")
    dataset.check_pictures(plan, picture or [], _axes(over))
    say = (lambda _: None) if quiet else to_stderr
    if plan_only:
        ended = studies.planned(plan, folder, again)
    else:
        with kept_in(folder, quiet) as progress:
            ended = studies.sweep(plan, folder, Place(scheduler, jobs), progress, say, again)
    written = _outputs(ended, table or [], picture or [], over, figure_format)
    if as_json:
        counts = Counter(state.status for state in ended.states.values())
        print_json({"folder": str(folder), "cases": len(ended.plan.cases), "ran": ended.ran, "status": dict(counts)})
    elif not quiet:
        _print(ended, folder, written)
    _end(ended, plan_only)


def _axes(over: str | None) -> list[str]:
    return [axis.strip() for axis in over.split(",")] if over else []


def _outputs(
    study: Study, tables: list[Path], pictures: list[str], over: str | None, figure_format: str
) -> dict[Path, str]:  # fmt: skip
    """Write dataset, tables and pictures; return the files with their meaning."""
    from pysprings.studies.sweep import dataset

    written = {study.out / "cases.csv": "the cases: values, status, reason, seconds, hash"}
    file = dataset.write_study(study)
    if file is None:
        return written
    written[file] = "all cases as one dataset (pysprings.open_study, xarray)"
    with dataset.open_study(file) as data:
        for each in (study.out / dataset.CSV, *tables):
            written[dataset.write_table(data, each)] = "a row a case, for spreadsheets"
        for name in pictures:
            from pysprings.results.plots.files import save

            stem = study.out / name.replace(":", "-")
            figure = dataset.draw(data, name, _axes(over))
            written |= dict.fromkeys(save(figure, stem, figure_format.split(",")), name)
    return written


def _print(study: Study, folder: Path, written: dict[Path, str]) -> None:
    counts = Counter(state.status for state in study.states.values())
    print_table(Table("", ["status", "cases"], [[name, f"{number:,}"] for name, number in counts.items()]))
    odd = [(case, study.states[case.number]) for case in study.plan.cases if study.states[case.number].reason]
    if odd:
        print()
        rows = [[case.id, state.status, state.reason[:100]] for case, state in odd[:20]]
        print_table(Table("", ["case", "status", "reason"], rows, left=[True, True, True]))
        if len(odd) > 20:
            print(f"and {len(odd) - 20:,} more in {folder / 'cases.csv'}")
    for text in study.remarks[:20]:
        print(f"note: {text}")
    if len(study.remarks) > 20:
        print(f"and {len(study.remarks) - 20:,} more values beyond their common range")
    print()
    for file, meaning in written.items():
        print(f"{file}: {meaning}")


def _end(study: Study, plan_only: bool) -> None:
    """Raise RunIncomplete where cases have no springs."""
    bad = [state for state in study.states.values() if state.status in ("failed", "stopped")]
    if bad and not plan_only:
        raise RunIncomplete(f"{len(bad)} of {len(study.plan.cases)} cases ended without springs", study.out)
