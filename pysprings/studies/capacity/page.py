# SPDX-License-Identifier: MIT
"""The page of a capacity study."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core import version
from pysprings.core.files.storage import write_text
from pysprings.results.axes import axes_svg
from pysprings.results.report.inputs import input_tables
from pysprings.results.report.page import Picture, environment, picture_uri
from pysprings.results.report.table import Table
from pysprings.studies.capacity import text

if TYPE_CHECKING:
    from pysprings.studies.capacity.outcome import Capacity


def write(out: Path, outcome: Capacity) -> Path:
    """Write report.html into the folder of a study; return its path."""
    drawn = [file for file in (out / "capacity.svg", out / "capacity.png") if file.exists()][:1]
    cases = outcome.cases
    html = (
        environment()
        .get_template("capacity.html.j2")
        .render(
            version=version.__version__,
            title=outcome.scene.title,
            factors=str(outcome.request.factors),
            sketch=picture_uri(axes_svg().encode(), ".svg"),
            closing=text.closing(outcome.table) if len(outcome.table) else "",
            remarks=outcome.remarks,
            criteria=text.criteria(outcome),
            pictures_drawn=[
                Picture("Envelopes of H and M", picture_uri(file.read_bytes(), file.suffix), False) for file in drawn
            ],
            capacity=Table("", *text.cells(outcome.table), text.DIRECTIONS, wide=True),
            cases=None if cases is None else Table("", text.CASE_HEADS, text.case_cells(cases), wide=True),
            inputs=input_tables(outcome.scene.to_toml()),
        )
    )
    return write_text(html, out / "report.html")
