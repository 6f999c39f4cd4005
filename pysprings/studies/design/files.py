# SPDX-License-Identifier: MIT
"""Files of answers to load cases: CSV in SI, a workbook and a page for people, by the ending of the name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.columns import filled
from pysprings.core.errors import refused
from pysprings.core.files.storage import write_text
from pysprings.results.exporters.csv import write_frame
from pysprings.results.layout import LOAD_CASES
from pysprings.results.report import load_cases as text
from pysprings.results.sheets import write_sheet

if TYPE_CHECKING:
    import pandas as pd

ENDINGS = (".csv", ".xlsx", ".html")


def check_ending(file: Path) -> None:
    """Refuse a name whose ending is none of `ENDINGS`, and a folder."""
    if file.suffix.lower() not in ENDINGS:
        raise refused("--out", f"ends in none of {', '.join(ENDINGS)}", file)
    if file.is_dir():
        raise refused("--out", "is a folder, not a file", file)


def write(file: Path, table: pd.DataFrame, about: Mapping[str, str]) -> Path:
    """Write answers (`answer_cases`) to a file; `about` are lines on what made them. Returns the path."""
    check_ending(file)
    if file.suffix.lower() == ".csv":
        return write_frame(table, file)
    return _workbook(file, table, about) if file.suffix.lower() == ".xlsx" else _page(file, table, about)


def check_run(folder: Path) -> None:
    """Refuse what is no folder of a run with a full model, whose report could be written."""
    if not (folder / "full_model.nc").exists():
        raise refused("--report", "needs the folder of a run, with its full_model.nc", folder)


def into_report(folder: Path, table: pd.DataFrame) -> Path:
    """Write answers into the folder of a run (design.csv) and its report anew; return the path of the report."""
    from pysprings.results.report.page import write_report

    check_run(folder)
    write_frame(table, folder / LOAD_CASES)
    return write_report(folder)


def _workbook(file: Path, table: pd.DataFrame, about: Mapping[str, str]) -> Path:
    rows = table.to_dict("records")
    columns = filled(text.COLUMNS, rows)
    cells = (([column.value(row) for column in columns], row["verdict"] != text.OK) for row in rows)
    notes = {**about, "result": text.closing(table), "columns": text.NOTE}
    return write_sheet(file, [column.head for column in columns], cells, notes)


def _page(file: Path, table: pd.DataFrame, about: Mapping[str, str]) -> Path:
    from pysprings.results.report.page import page_html

    cases = replace(text.table_of(table), title="")
    return write_text(page_html("design.html.j2", about=about, closing=text.closing(table), cases=cases), file)
