# SPDX-License-Identifier: MIT
"""Tables of a study for spreadsheets: a row a case, axes, stiffness, largest loads, cost."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.errors import refused
from pysprings.core.files.storage import replacing
from pysprings.core.text import PLAIN_CELLS
from pysprings.studies.sweep.dataset import scalars

if TYPE_CHECKING:
    import xarray as xr

CSV, XLSX = "study.csv", "study.xlsx"
SUFFIXES = (".csv", ".xlsx")
_MOST_ROWS = 1_048_575  # of a sheet


def heads_and_rows(data: xr.Dataset) -> tuple[list[str], Iterator[list[Any]]]:
    """Return headings with units, and the rows one after the other (numbers, texts, None)."""
    dims = data["case_number"].dims
    axes = str(data.attrs["axes"]).split(", ")
    columns = [*(data[name] for name in axes), data["status"], *scalars(data).values()]
    names = [*axes, "status", *scalars(data)]
    heads = [f"{name} [{unit}]" if (unit := _unit(each)) else name for name, each in zip(names, columns, strict=True)]
    shape = tuple(data.sizes[dim] for dim in dims)
    loaded = [each.broadcast_like(data["case_number"]).transpose(*dims).values.reshape(-1) for each in columns]
    numbers = data["case_number"].values.reshape(-1)

    def rows() -> Iterator[list[Any]]:
        for k in range(int(np.prod(shape))):
            yield [int(numbers[k]), *(_plain(each[k]) for each in loaded)]

    return ["id", *heads], rows()


def _unit(variable: xr.DataArray) -> str:
    unit = str(variable.attrs.get("units", ""))
    return "" if unit in ("1", "") else unit


def _plain(value: Any) -> Any:
    if isinstance(value, str):
        return value
    number = float(value)
    return number if np.isfinite(number) else None


def write_table(data: xr.Dataset, file: Path) -> Path:
    """Write the table of a study as .csv or .xlsx, whole or not at all."""
    if file.suffix not in SUFFIXES:
        raise refused("--table", f"ends in {' or '.join(SUFFIXES)}", file)
    heads, rows = heads_and_rows(data)
    with replacing(file) as temporary:
        if file.suffix == ".csv":
            _write_csv(temporary, heads, rows)
        else:
            _write_xlsx(temporary, heads, rows)
    return file


def _write_csv(file: Path, heads: list[str], rows: Iterator[list[Any]]) -> None:
    import csv

    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(heads)
        for row in rows:
            writer.writerow(
                ["" if each is None else f"{each:.10g}" if isinstance(each, float) else each for each in row]
            )


def _write_xlsx(file: Path, heads: list[str], rows: Iterator[list[Any]]) -> None:
    import xlsxwriter

    book = xlsxwriter.Workbook(str(file), {**PLAIN_CELLS, "constant_memory": True})
    sheet = book.add_worksheet("cases")
    bold = book.add_format({"bold": True, "text_wrap": True, "valign": "top"})
    sheet.freeze_panes(1, 1)
    sheet.set_column(0, len(heads) - 1, 14)
    sheet.write_row(0, 0, heads, bold)
    for k, row in enumerate(rows):
        if k >= _MOST_ROWS:
            raise refused(None, f"a sheet holds {_MOST_ROWS:,} cases; write .csv", file)
        sheet.write_row(k + 1, 0, row)
    book.close()
