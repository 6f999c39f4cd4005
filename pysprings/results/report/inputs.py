# SPDX-License-Identifier: MIT
"""What a table of the report declares and reads; tables of what a run was given: keys of the scene, and the mesh."""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import pandas as pd
import xarray as xr

from pysprings.core.columns import Table
from pysprings.core.errors import UserInputError
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.core.text import number
from pysprings.full_model.run_record import MeshFigures, PathFigures, RunRecord
from pysprings.scene.defaults import value_text
from pysprings.springs.path import paths_of

# Parts of the page in their order; "path" is repeated for each path.
Section = Literal[
    "cases", "springs", "capacity", "tilt", "comparison", "inputs", "limits", "mesh", "checks", "path", "cost"
]


@dataclass(frozen=True)
class ReportData:
    """Data of a run for the tables of its report.

    result, springs : Full model; spring set, None where too little converged.
    comparison : Errors of the macro-model by path and spring set; None without springs.
    run : Record of the run; None without one.
    cases : Answers to load cases in SI, a row a case; None without any.
    path : Name of the path, for tables of the section "path".
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
    def paths(self) -> dict[str, xr.Dataset]:
        """All steps of the paths by name, extrapolated where they are."""
        return {name: path.recorded for name, path in paths_of(self.result).items()}


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A kind of table of the report: name, section, and a function data -> tables (none where there is nothing)."""

    name: str
    section: Section
    build: Callable[[ReportData], Sequence[Table | None]]


def input_tables(scene_toml: str) -> list[Table]:
    """Return one table for each section of a scene: key, value with its unit, defaults included.

    A scene that this version does not accept is shown as it is; text that is no TOML gives no table.
    """
    if not scene_toml:
        return []
    return [
        Table(title, ("key", "value"), [(key, _value(value)) for key, value in pairs], head=False)
        for title, pairs in _sections(scene_toml)
        if pairs
    ]


_LONG = re.compile(r"(?<![\w.+-])-?\d+\.\d{7,}(?:e[+-]?\d+)?(?![\w.])")  # as of an angle in another unit


def _value(value: Any) -> str:
    """Return a value of the scene as text, numbers of many digits with six; a value by depth as its parts."""
    if isinstance(value, str):
        return _LONG.sub(lambda found: number(float(found.group()), 6), value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {number(part, 6)}" for key, part in value.items())
    return number(value, 6)


def _sections(scene_toml: str) -> Iterable[tuple[str, list[tuple[str, Any]]]]:
    """Return (title, keys and values) of the sections of a scene."""
    from pysprings.scene.load import parse_scene
    from pysprings.scene.toml import sections

    try:
        return sections(parse_scene(scene_toml))
    except UserInputError:
        return _plain_sections(scene_toml)


def _plain_sections(scene_toml: str) -> list[tuple[str, list[tuple[str, Any]]]]:
    """Return the sections of TOML text without defaults."""
    try:
        scene = tomllib.loads(scene_toml)
    except tomllib.TOMLDecodeError:
        return []
    sections = [("scene", [(key, value) for key, value in scene.items() if not isinstance(value, dict | list)])]
    for key, value in scene.items():
        if isinstance(value, dict):
            sections.append((key, list(value.items())))
        elif isinstance(value, list):
            tables = [item for item in value if isinstance(item, dict)]
            sections += [(f"{key} {k}", list(item.items())) for k, item in enumerate(tables, 1)]
    return sections


def mesh_table(attrs: Mapping[Any, Any], mesh: MeshFigures | None = None) -> Table:
    """Return the table of mesh counts, quality and solver from the attrs of a result and the record of its mesh."""
    names = {
        "mesh_preset": "preset",
        "n_nodes": "nodes",
        "n_elements": "eight-node elements",
        "n_unknowns": "unknowns",
        "interface_stations": "interface stations",
        "min_scaled_jacobian": "smallest scaled Jacobian",
        "max_aspect": "largest aspect ratio",
        "solver": "linear solver",
    }
    known = {**(mesh.as_dict() if mesh else {}), **attrs}
    rows = [(text, number(known[key])) for key, text in names.items() if key in known]
    return Table("", ("", ""), rows, head=False)


def omission_table(left_out: Any) -> Table | None:
    """Return the table of what a scene leaves out, why, and what that saves; None where nothing is recorded."""
    from pysprings.model.forecast.omissions import saved_text  # load cases are answered without the engine

    items = [item for item in left_out if isinstance(item, Mapping)] if isinstance(left_out, list | tuple) else []
    rows = [(str(item.get("what", "")), str(item.get("why", "")), saved_text(item.get("saved"))) for item in items]
    return Table("What this scene leaves out", ("what", "why", "what it saves"), rows) if rows else None


def defaults_table(run: RunRecord | None) -> Table | None:
    """Return the table of what a scene does not give, with the values in its place; None where nothing is recorded."""
    rows = [(str(row["key"]), value_text(row)) for row in (run.defaulted if run else [])]
    remarks = f"Remarks on the scene: {'; '.join(run.remarks)}." if run and run.remarks else ""
    title = "Defaults, which the scene does not give" if rows else ""
    return Table(title, ("key", "value"), rows, remarks, head=bool(rows)) if rows or remarks else None


# Sections that decide the computation, not the case: they stand in the appendix
_NUMERICAL = ("mesh", "solver", "output", "springs")
# Keys that a scene with drained ground alone does not use
_WATER = {"hydraulic_conductivity", "transversal_conductivity", "residual_aperture", "side_drainage"}
_STEEL = {"young_modulus", "poisson_ratio"}


def used_tables(scene_toml: str, numerical: bool) -> list[Table]:
    """Return the inputs that a scene uses: those of its case, or those of its computation (`numerical`)."""
    given = {table.title: {row[0]: row[1] for row in table.rows} for table in input_tables(scene_toml)}
    drained = given.get("drainage", {}).get("mode") == "drained"
    rigid = given.get("caisson", {}).get("behaviour") == "rigid"
    kinds = [PATH_KINDS.get(rows.get("kind", "")) for rows in given.values()]
    forces = any(kind.limited for kind in kinds if kind)
    tables = []
    for table in input_tables(scene_toml):
        if (table.title in _NUMERICAL) != numerical or table.title == "scene":
            continue
        unused = set() if not drained else set(_WATER)
        unused |= {row[0] for row in table.rows if row[0] != "mode"} if drained and table.title == "drainage" else set()
        unused |= _STEEL if rigid and table.title == "caisson" else set()
        unused |= {row[0] for row in table.rows} if table.title == "limit" and not forces else set()
        rows = [row for row in table.rows if row[0] not in unused]
        tables += [replace(table, rows=rows)] if rows else []
    return tables
