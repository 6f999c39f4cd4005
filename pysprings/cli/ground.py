# SPDX-License-Identifier: MIT
"""`pysprings ground`: from a CPT, points by depth or layers to the table that `soil.profile` reads."""

from pathlib import Path
from typing import Annotated

import typer

from pysprings.cli.folders import refuse_read
from pysprings.cli.options import DrawnFigures, Format, Json, NoFigures, argument, formats_of, option, quantity
from pysprings.cli.support import print_json, print_table, refuse, to_stderr


def ground(
    files: Annotated[
        list[Path],
        argument("FILE...", "CPT (GEF, AGS 4, BRO XML, CSV, Excel), points by depth, layers; several together"),
    ],
    out: Annotated[Path | None, option("--out", "table to write (.csv, .xlsx), its picture beside it", "TABLE")] = None,
    test: Annotated[str | None, option("--test", "the test, where the files hold several", "NAME")] = None,
    area_ratio: Annotated[
        float | None, typer.Option("--area-ratio", min=0.1, max=1.0, help="net area ratio of the cone")
    ] = None,
    nkt: Annotated[str | None, option("--nkt", "cone factors N_kt [default: 10,14,18]", "N,N,N")] = None,
    depth: Annotated[
        float | None, quantity("--depth", "m", "30 m", "depth to which a CPT counts [default: all]")
    ] = None,
    layers: Annotated[int, typer.Option("--layers", min=1, max=50, help="the most layers that are proposed")] = 10,
    force: Annotated[bool, option("--force", "replace an existing table")] = False,
    figures: DrawnFigures = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    as_json: Json = False,
) -> None:
    """Propose layers with their values from a CPT, points or layers.

    What it writes is a proposal: read it, edit it, and name it in `soil.profile` of a scene. Nothing of a CPT is
    computed inside a run.
    """
    from pysprings.site.files import read_site
    from pysprings.site.output import cells, document, faults_of, layer_table, remarks, value_table, write_table
    from pysprings.site.proposal import Options, propose

    if out is not None and out.suffix.lower() not in (".csv", ".xlsx"):
        refuse("--out", "ends in .csv or .xlsx", out)
    if out is not None and out.exists() and not force:
        refuse("--out", "exists already: choose another name, or --force to replace it", out)
    refuse_read("--out", out, *files)
    down_to = float("inf") if depth is None else depth
    proposal = propose(read_site(files), Options(test, area_ratio, _factors(nkt), layers, down_to))
    if as_json:
        print_json(document(proposal))
    else:
        print_table(layer_table(proposal))
        print()
        print_table(value_table(proposal))
        print("\n".join(["", "* outside the range of a correlation", *(f"- {text}" for text in remarks(proposal))]))
    if out is None:
        to_stderr("next: --out site.csv writes the table to edit, and the picture")
        return
    write_table(cells(proposal, [each.name for each in files]), out)
    if formats := formats_of(figures, no_figures, figure_format):
        from pysprings.results.plots.files import save
        from pysprings.site.picture import profile

        save(profile(proposal, ", ".join(each.name for each in files)), out.with_suffix(""), formats)
    for fault in faults_of(out):
        to_stderr(f"to fill in before a run: {fault}")
    to_stderr(f'{out}: read and edit it; in a scene: [soil] profile = "{out.name}"')


def _factors(text: str | None) -> tuple[float, float, float]:
    """Return three cone factors that grow: su high, best, low."""
    from pysprings.site.correlations import CONE_FACTORS

    if text is None:
        return CONE_FACTORS
    try:
        low, best, high = sorted(float(each) for each in text.split(","))
    except ValueError:
        refuse("--nkt", f"'{text}' is not three numbers such as 10,14,18")
    if not 5.0 <= low <= high <= 40.0:
        refuse("--nkt", f"'{text}': cone factors are between 5 and 40")
    return low, best, high
