# SPDX-License-Identifier: MIT
"""The paper's report.html: claims, figures in the paper's arrangement, sensitivities, what was run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.columns import Table
from pysprings.core.storage import write_text
from pysprings.core.text import number
from pysprings.results.report.inputs import input_tables, mesh_table
from pysprings.results.report.page import Picture, page_html, picture_uri
from pysprings.results.report.validity import energy_table, water_table
from validation.paper import idealisations
from validation.paper.cases import END, SHOWN
from validation.paper.measures import load
from validation.paper.sensitivity import CRITERIA
from validation.paper.text import DRAINED_COLUMNS, NOTE, WATER_COLUMNS, conclusion, split

if TYPE_CHECKING:
    import pandas as pd

    from validation.paper.figures import Drawing
    from validation.paper.runs import Run


def write(
    out: Path, mesh: str, runs: Mapping[str, Run], drawn: Sequence[tuple[Drawing, Path]], claims: pd.DataFrame,
    idealised: pd.DataFrame, sensitivity: pd.DataFrame | None,
) -> Path:  # fmt: skip
    """Write report.html into the folder of a study; return its path."""
    first = next(iter(runs.values()), None)
    attrs: Mapping[Any, Any] = first.result.attrs if first else {}
    text = page_html(
        "paper.html.j2",
        Path(__file__).parent,
        mesh=mesh,
        stopped=[run.remark for run in runs.values() if not run.complete],
        runs=run_table(runs),
        balances=[table for table in _balances(runs) if table is not None],
        inputs=input_tables(str(attrs.get("scene_toml", ""))),
        mesh_table=mesh_table(attrs, first.record.mesh if first else None),
        claims=claims.to_dict(orient="records"),
        counts={str(name): int(n) for name, n in claims["verdict"].value_counts().items()},
        idealised=Table("", *idealisations.rows_for_people(idealised), idealisations.NOTE, wide=True),
        drawings=[_picture(drawing, file) for drawing, file in drawn],
        sensitivity=_sensitivity(sensitivity),
    )
    return write_text(text, out / "report.html")


def run_table(runs: Mapping[str, Run]) -> Table:
    """List the runs: how each ended, its loads, cost and scene."""
    rows = [
        (
            name,
            run.case.words,
            str(run.record.status),
            number(1e-3 * load(run.path, SHOWN)),
            number(1e-3 * load(run.path, END)),
            number(sum(path.iterations for path in run.record.paths.values())),
            number(run.record.wall_s),
            run.record.version,
            run.record.scene_sha256[:12],
        )
        for name, run in runs.items()
    ]
    columns = ("run", "", "status", f"H at {1e3 * SHOWN:g} mm [kN]", f"H at {1e3 * END:g} mm [kN]", "iterations",
               "wall time [s]", "version", "scene, sha256")  # fmt: skip
    return Table("", columns, rows, "Each run has its own report in runs/NAME/report.html.", wide=True)


def _balances(runs: Mapping[str, Run]) -> list[Table | None]:
    paths = {name: path for name, run in runs.items() for path in run.record.paths.values()}
    return [energy_table(paths), water_table(paths)]


def _picture(drawing: Drawing, file: Path) -> Picture:
    vector = file.with_suffix(".svg")
    best = vector if vector.exists() else file
    return Picture(drawing.caption, picture_uri(best.read_bytes(), best.suffix), drawing.tall)


def _sensitivity(table: pd.DataFrame | None) -> dict[str, Any] | None:
    if table is None:
        return None
    drained, water = split(table)
    tables = [
        Table.of(columns, rows, title, wide=True)
        for title, columns, rows in (("Drained", DRAINED_COLUMNS, drained), ("0.05 mm/s", WATER_COLUMNS, water))
        if rows
    ]
    mesh = str(table["mesh"].iloc[0]) if "mesh" in table else ""
    return {"conclusion": conclusion(table), "criteria": CRITERIA, "note": NOTE, "tables": tables, "mesh": mesh}
