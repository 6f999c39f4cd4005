# SPDX-License-Identifier: MIT
"""The whole reproduction in a folder: runs, figures, claims, sensitivities, report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.storage import remove_leftovers, write_text
from pysprings.core.written import exclusive, new_folder, own_folder
from pysprings.results.exporters.csv import write_frame
from pysprings.studies.stored_runs import RUNS
from validation.paper import claims, figures, idealisations, page, runs, sensitivity, text
from validation.paper.cases import CASES, VARIANTS, Case, Variant

if TYPE_CHECKING:
    import pandas as pd

    from pysprings.core.progress import Progress

FILES = {
    "report.html": "report with claims, figures and sensitivities: open it in a browser",
    "claims.csv": "the paper's claims beside our figures",
    "claims.md": "the same as Markdown",
    "idealisations.csv": "rigid against elastic steel, Drucker-Prager against Van Eekelen",
    "sensitivity.csv": "readings of what the paper leaves open",
    "sensitivity.md": "the same as Markdown",
    figures.FOLDER: "figures in the paper's arrangement",
    RUNS: "the runs, each with its own report",
}


def study(
    out: Path, mesh: str, report: Progress, sensitivity_mesh: str | None = None,
    cases: Sequence[Case] = CASES, variants: Sequence[Variant] = VARIANTS, force: bool = False,
) -> list[str]:  # fmt: skip
    """Run the cases that have not ended yet and write all files; return the reasons of runs that stopped early.

    sensitivity_mesh : also run the sensitivities, on this mesh preset. What an earlier call has left of them is shown
    again where they are not requested. force : forget what has run, and begin anew.
    """
    with new_folder(out), exclusive(out):
        remove_leftovers(out, *(own_folder(out, name) for name in (RUNS, figures.FOLDER, sensitivity.FOLDER)))
        if force:
            runs.forget(out, cases)
            sensitivity.forget(out)
        stopped = runs.run_all(out, mesh, report, cases)
        if sensitivity_mesh is not None:
            for table in sensitivity.run_variants(out, sensitivity_mesh, report, variants):
                write_frame(table, out / "sensitivity.csv")  # after each: an interrupted study has a table, too
                write_text(text.sensitivity_markdown(table), out / "sensitivity.md")
        write_results(out, mesh, cases, report)
    return stopped


def write_results(out: Path, mesh: str, cases: Sequence[Case] = CASES, report: Progress = lambda *_: None) -> None:
    """Write figures, claims and report from the runs below a folder."""
    ended = runs.load_runs(out, mesh, cases)
    report("figures", 0.0, "")
    drawn = figures.write_all(ended, out)
    paths = {name: run.path for name, run in ended.items()}
    table = claims.assess(paths)
    write_frame(table, out / "claims.csv")
    write_text(text.claims_markdown(table), out / "claims.md")
    idealised = idealisations.compare(paths)
    write_frame(idealised, out / "idealisations.csv")
    page.write(out, mesh, ended, drawn, table, idealised, read_sensitivity(out))
    report("figures", 1.0, f"{len(drawn)} figures")


def read_claims(out: Path) -> pd.DataFrame:
    """Read claims.csv of a study."""
    import pandas as pd

    return pd.read_csv(out / "claims.csv", keep_default_na=False)


def read_sensitivity(out: Path) -> pd.DataFrame | None:
    """Read sensitivity.csv of a study; None where it has none."""
    import pandas as pd

    file = out / "sensitivity.csv"
    return pd.read_csv(file) if file.exists() else None
