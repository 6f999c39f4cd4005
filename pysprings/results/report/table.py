# SPDX-License-Identifier: MIT
"""A table of the report, what a kind of table declares, and the data that it reads."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pysprings.full_model.run_record import PathFigures, RunRecord

# Parts of the page in their order; "path" is repeated for each path.
Section = Literal[
    "cases", "springs", "capacity", "tilt", "comparison", "inputs", "limits", "mesh", "checks", "path", "cost"
]
# a number, with the letter of a quantity before it and its unit behind it; "-" and blank: there is none
_NUMBER = re.compile(r"([A-Z] )?[-+]?[\d,]*\.?\d+(e[-+]?\d+)?( [A-Za-z%/]+)*|-|")


@dataclass(frozen=True)
class Table:
    """A table of the report.

    Attributes
    ----------
    title
        Caption; blank for none.
    columns
        Headings with units.
    rows
        Cells by row, as text.
    note
        Remark below the table.
    head
        Show the headings.
    wide
        The table scrolls where the page is narrow, and has small type in print.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    head: bool = True
    wide: bool = False

    @cached_property
    def numeric(self) -> list[bool]:
        """Whether each column holds numbers alone, which are set to the right; none in a table without headings."""
        columns = [[str(row[k]) for row in self.rows] for k in range(len(self.columns))]
        return [
            self.head and any(cell.strip("-") for cell in cells) and all(_NUMBER.fullmatch(cell) for cell in cells)
            for cells in columns
        ]


@dataclass(frozen=True)
class ReportData:
    """Data of a run for the tables of its report.

    Attributes
    ----------
    result, springs
        Full model; spring set, None where too little converged.
    comparison
        Errors of the macro-model by path and spring set; None without springs.
    run
        Record of the run; None without one.
    cases
        Answers to load cases in SI, a row a case; None without any.
    path
        Name of the path, for tables of the section "path".
    """

    result: xr.DataTree
    springs: xr.DataTree | None = None
    comparison: pd.DataFrame | None = None
    run: RunRecord | None = None
    cases: pd.DataFrame | None = None
    path: str = ""

    @property
    def figures(self) -> Mapping[str, PathFigures]:
        """Figures of the paths by name; none without a record."""
        return {} if self.run is None else self.run.paths

    @property
    def paths(self) -> dict[str, Any]:
        """Groups of the paths by name."""
        return dict(self.result["paths"].children) if "paths" in self.result.children else {}


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A kind of table of the report: name, section, and a function data -> tables (none where there is nothing)."""

    name: str
    section: Section
    build: Callable[[ReportData], Sequence[Table | None]]
