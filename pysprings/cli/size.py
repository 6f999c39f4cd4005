# SPDX-License-Identifier: MIT
"""`pysprings size`: the least steel that meets load cases."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pysprings.cli.atlas import SHIPPED_ATLASES
from pysprings.cli.options import Changes, DrawnFigures, Format, Json, NoFigures, argument, formats_of, option
from pysprings.cli.support import print_json, print_table, quantities, refuse
from pysprings.core.columns import Column, Table
from pysprings.core.errors import following

if TYPE_CHECKING:
    import pandas as pd

    from pysprings.studies.sizing import Candidate, Search


def size(
    cases: Annotated[Path, argument("CASES", "load cases (CSV, Excel), units in the headings")],
    atlas: Annotated[str, option("--atlas", f"what answers: {SHIPPED_ATLASES}", "NAME|FILE")],
    tilt: Annotated[
        str, option("--tilt", "tolerated rotation of cases that have none of their own", "ANGLE")
    ] = "0.25 deg",
    utilisation: Annotated[
        float, typer.Option("--utilisation", help="largest share of the largest known load", min=0.01, max=1.0)
    ] = 0.8,
    changes: Changes = None,
    least: Annotated[str, option("--D-min", "least outer diameter", "LENGTH")] = "3 m",
    most: Annotated[str, option("--D-max", "largest outer diameter", "LENGTH")] = "20 m",
    confirm: Annotated[
        bool, option("--confirm", "confirm by full models; correct and search again where they ask for it")
    ] = False,
    out: Annotated[Path | None, option("--out", "folder for the table and picture of candidates", "DIR")] = None,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    as_json: Json = False,
) -> None:
    """Find the caisson of the least steel that meets load cases.

    The atlas answers, at the V of each case; its rotation counts with 1.96 standard deviations. The thickness of the
    skirt is the share of the diameter that the atlas has. With --confirm the full model pulls the result to every
    load case, on the mesh of the atlas extrapolated, and states its own estimate of what that leaves in the rotation.
    """
    from pysprings.core.tables.load_cases import read_load_cases
    from pysprings.scene.changes import read_changes
    from pysprings.studies.atlas.model import open_atlas
    from pysprings.studies.sizing import Search, Wanted, bounds_of, least_confirmed, remarks_on, table_of

    given = quantities(
        {"--tilt": (tilt, "rad", "0.25 deg"), "--D-min": (least, "m", "3 m"), "--D-max": (most, "m", "20 m")}
    )
    low, high, angle = (float(given[key] or 0.0) for key in ("--D-min", "--D-max", "--tilt"))
    if not 0.0 < low < high:
        refuse("--D-min", "must be above zero and below --D-max")
    if angle <= 0.0:
        refuse("--tilt", "a tolerance must be positive")
    model = open_atlas(atlas)
    wanted = Wanted(
        read_load_cases(cases), angle, utilisation, tuple(read_changes(changes or [])), (low, high),
        bounds_of(model, (0.0, 10.0)),
    )  # fmt: skip
    search = Search(model, wanted)
    best, checked = least_confirmed(search) if confirm else (search.least(), None)
    files = _files(search, best, out, formats_of(figures, no_figures, figure_format)) if out else []
    if as_json:
        document = {"best": table_of([best]).to_dict("records")[0], "candidates": len(search.tried)}
        document |= {"remarks": remarks_on(search, best, confirm), "correction": search.correction}
        print_json(document | {"full_model": [] if checked is None else checked.to_dict("records")})
        return
    _print(search, best, checked)
    for file in files:
        print(file)


def _files(search: Search, best: Candidate, out: Path, formats: Sequence[str]) -> list[Path]:
    from pysprings.results.exporters.csv import write_frame
    from pysprings.results.plots.files import redraw
    from pysprings.studies.sizing import candidates, table_of

    table = table_of(search.tried)
    files = [write_frame(table, out / "candidates.csv")]
    with following("the picture was"):
        files += redraw(lambda: candidates(table, table_of([best]).iloc[0]), out / "candidates", formats)
    return files


def _print(search: Search, best: Candidate, checked: pd.DataFrame | None) -> None:
    from pysprings.studies.sizing import remarks_on

    print_table(Table.of(_LEAST, [vars(best)]))
    print(f"{len(search.tried)} caissons tried on {search.atlas.source}; correction {search.correction:.4g}")
    for text in remarks_on(search, best, checked is not None):
        print(f"note: {text}")
    if checked is None:
        print("not confirmed: --confirm runs the full model")
        return
    print("\nFull model:")
    print_table(Table.of(_CONFIRMED, checked.to_dict("records")))


_LEAST = (
    Column("D [m]", "D", ".3f"), Column("L [m]", "L", ".3f"), Column("steel [t]", "mass", ".4g", 1e-3),
    Column("use", "use", ".3f"), Column("governs", "governs", words=True),
)  # fmt: skip
_CONFIRMED = (
    Column("name", "name", words=True),
    *(Column(name, name, ".3g") for name in (
        "tilt_used", "u_error_pct", "u_deviation_pct", "rotation_error_pct", "rotation_deviation_pct",
        "rotation_mesh_error_pct",
    )),
    Column("inside", "inside"),
)  # fmt: skip
