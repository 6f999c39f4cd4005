# SPDX-License-Identifier: MIT
"""What a kind of table of the report declares, and the data that it reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from pysprings.core.columns import Table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pysprings.full_model.run_record import PathFigures, RunRecord

# Parts of the page in their order; "path" is repeated for each path.
Section = Literal[
    "cases", "springs", "capacity", "tilt", "comparison", "inputs", "limits", "mesh", "checks", "path", "cost"
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
