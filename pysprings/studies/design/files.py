# SPDX-License-Identifier: MIT
"""Files of answers to load cases: CSV in SI, a workbook and a page for people, by the ending of the name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core import version
from pysprings.core.errors import refused
from pysprings.core.files.storage import replacing, write_text
from pysprings.core.text import PLAIN_CELLS
from pysprings.results.exporters.csv import write_frame
from pysprings.results.layout import LOAD_CASES
from pysprings.results.report import load_cases as text

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
    import xlsxwriter

    columns = text.columns_of(table, brief=False)
    with (
        replacing(file) as temporary,
        xlsxwriter.Workbook(temporary, PLAIN_CELLS) as book,
    ):
        head = book.add_format({"bold": True, "text_wrap": True, "bottom": 1, "valign": "top"})
        wrong = book.add_format({"bg_color": "#fbe3d3"})
        sheet = book.add_worksheet("cases")
        for col, column in enumerate(columns):
            sheet.write_string(0, col, column.head, head)
        for row, values in enumerate(table.to_dict("records"), start=1):
            form = None if values["verdict"] == text.OK else wrong
            for col, column in enumerate(columns):
                _write_cell(sheet, row, col, column.value(values), form)
        sheet.set_row(0, 45)
        sheet.set_column(0, len(columns) - 1, 13)
        sheet.freeze_panes(1, 1)
        sheet.autofilter(0, 0, len(table), len(columns) - 1)
        notes = book.add_worksheet("about")
        for row, (name, words) in enumerate({**about, "result": text.closing(table), "columns": text.NOTE}.items()):
            notes.write_string(row, 0, name, head)
            notes.write_string(row, 1, words)
        notes.set_column(0, 0, 18)
    return file


def _write_cell(sheet: Any, row: int, col: int, value: Any, form: Any) -> None:
    if value is None:
        sheet.write_blank(row, col, None, form)
    elif isinstance(value, str):
        sheet.write_string(row, col, value, form)
    else:
        sheet.write_number(row, col, value, form)


def _page(file: Path, table: pd.DataFrame, about: Mapping[str, str]) -> Path:
    from pysprings.results.axes import axes_svg
    from pysprings.results.report.page import environment, picture_uri

    html = (
        environment()
        .get_template("design.html.j2")
        .render(
            version=version.__version__,
            about=about,
            closing=text.closing(table),
            cases=replace(text.table_of(table), title=""),
            sketch=picture_uri(axes_svg().encode(), ".svg"),
        )
    )
    return write_text(html, file)
