# SPDX-License-Identifier: MIT
"""`pysprings atlas`: an emulator over a study, with its errors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pysprings.cli.options import Json
from pysprings.cli.support import print_json, print_table, refuse
from pysprings.core.columns import Column, Table


def atlas(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="study.nc, or the folder of `pysprings sweep`")],
    family: Annotated[str, typer.Option("--family", metavar="NAME", help="ground: clay, clay-gap or sand")],
    held_back: Annotated[
        Path | None,
        typer.Option("--held-back", metavar="STUDY", help="study of pulls that the atlas is checked on"),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="file \\[default: FAMILY.nc]")] = None,
    at: Annotated[
        str | None, typer.Option("--at", metavar="U/D[,U/D]", help="where pulls are compared \\[default: 0.001,0.01]")
    ] = None,
    table: Annotated[
        Path | None, typer.Option("--table", metavar="FILE", help="write the comparison, a row a quantity: .csv")
    ] = None,
    as_json: Json = False,
) -> None:
    """Make an atlas of a study: springs of any caisson between its cases, with a predicted standard deviation.

    Errors of cases that are left out one by one, and of held-back pulls, are printed and stored in the file.
    """
    from pysprings.studies.atlas import build, check
    from pysprings.studies.atlas.model import family_of, write_atlas

    target = out or Path(f"{family}.nc")
    if target.suffix != ".nc" or target.is_dir():
        refuse("--out", "name a file that ends in .nc", target)
    if table is not None and (table.suffix != ".csv" or held_back is None):
        refuse("--table", "is the comparison with --held-back: name a file that ends in .csv", table)
    made, left, compared = build.atlas_of(study, family_of(family), held_back, _shares(at))
    frames, file = {"Cases left out": build.left_summary(left)}, write_atlas(made, target)
    if table is not None and compared is not None:
        from pysprings.results.exporters.csv import write_frame

        write_frame(compared, table)
    if compared is not None:
        frames["Cases held back"] = check.summary(compared)
    if as_json:
        print_json(
            {"atlas": str(target), "about": dict(made.about)} | {k: f.to_dict("records") for k, f in frames.items()}
        )
        return
    for name, frame in frames.items():
        print(f"{name}:")
        print_table(Table.of([Column(str(name), str(name), 3) for name in frame], frame.to_dict("records")))
        print()
    print(f"{file} ({file.stat().st_size / 1e6:.2f} MB)")
    print(f"pysprings predict --atlas {target} --D ... --L ...")


def _shares(text: str | None) -> tuple[float, ...]:
    from pysprings.studies.atlas.check import AT

    if text is None:
        return AT
    try:
        shares = tuple(float(part) for part in text.split(","))
    except ValueError:
        shares = ()
    if not shares or any(not 0.0 < share < 0.2 for share in shares):
        refuse("--at", f"'{text}' is no list of displacements over the diameter, such as 0.001,0.01")
    return shares
