# SPDX-License-Identifier: MIT
"""`pysprings stability`: runs the catalogue, prints it line by line, writes table and picture."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from pysprings.cli.support import interruptible, print_json, to_stderr
from pysprings.core.columns import records
from pysprings.core.errors import following
from pysprings.core.storage import write_text
from pysprings.core.workers import cores
from pysprings.studies import stability


def run(
    names: list[str], mesh: str, refinement: float, reach: float, out: Path | None, formats: Sequence[str],
    as_json: bool, jobs: int | None = None,
) -> int:  # fmt: skip
    """Run the cases of these names (all: none given) as far as ``reach`` (m); return how many ended unexplained."""
    cases = stability.cases_named(names)

    ended: list[stability.Outcome] = []

    def report(outcome: stability.Outcome) -> None:
        ended.append(outcome)
        text = stability.line(asdict(outcome))
        if as_json:
            to_stderr(text)
        else:
            print(text, flush=True)

    if not as_json:
        print(stability.heading(), flush=True)
    try:
        with interruptible():
            table = stability.run_cases(cases, mesh, refinement, report, reach, jobs or cores())
    except KeyboardInterrupt:
        if out is not None and ended:
            _write(stability.table_of(ended), out, formats)
            to_stderr(f"the cases that have ended are in {out}")
        raise
    total = stability.summary(table)
    if out is not None:
        _write(table, out, formats)
    if as_json:
        rows = records(table)
        print_json({"mesh": mesh, "refinement": refinement, "reach_m": reach, "summary": total, "cases": rows})
    else:
        print(f"\n{stability.closing(total)}")
    return int(total[stability.UNEXPLAINED])


def _write(table: pd.DataFrame, out: Path, formats: Sequence[str]) -> None:
    """Write stability.csv, stability.md and stability.png or stability.svg."""
    from pysprings.results.plots.files import redraw

    write_text(table.to_csv(index=False, lineterminator="\n"), out / "stability.csv")
    write_text(stability.to_markdown(table), out / "stability.md")
    with following("the picture was"):
        redraw(lambda: stability.catalogue(table), out / "stability", formats)
