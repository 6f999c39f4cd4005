# SPDX-License-Identifier: MIT
"""The table of a study: a row a setting of the full model, then a row a macro-model; costs and errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.accuracy import measures
from pysprings.accuracy.curves import LOAD, OTHER, Curve, Grid, Sample, common_grid, curves_of, sampled
from pysprings.accuracy.richardson import Reference, cell_size
from pysprings.accuracy.settings import MESH, Setting
from pysprings.accuracy_study import macro
from pysprings.accuracy_study.runs import Ended
from pysprings.pareto import front
from pysprings.storage import read_tree

FULL, MACRO = "full", "macro"
REFERENCE = "reference"  # column: the error is that of the reference itself


@dataclass(frozen=True)
class Found:
    """What a study has found: the table, and the reference by path and quantity with its uncertainty by measure [%].

    ``series`` names the meshes of the reference, the finest last; ``settings`` are those that were run.
    """

    table: pd.DataFrame
    references: Mapping[str, Mapping[str, Reference]]
    uncertainty: Mapping[str, Mapping[str, float]]
    series: Sequence[str]
    settings: Sequence[Setting]


def assess(runs: Sequence[Ended]) -> Found:
    """Return errors and costs of the runs that reached their end, and costs of the others.

    The reference is extrapolated from the complete runs of the series. The finest of them is its own reference in what
    could not be extrapolated: the uncertainty stands in the place of its error, and the column `reference` names it.
    """
    complete = [each for each in runs if each.complete]
    results = {each.setting.name: read_tree(each.folder / "full_model.nc") for each in complete}
    curves = {name: curves_of(result) for name, result in results.items()}
    series = sorted((each for each in complete if each.setting.series), key=_unknowns)
    names = [each.setting.name for each in series]
    paths = _paths(curves, names)
    by_path: dict[str, dict[str, Sample]] = {}
    references: dict[str, dict[str, Reference]] = {}
    doubts: dict[str, dict[str, float]] = {}
    grids: dict[str, Grid] = {}
    for path in paths:
        grids[path] = common_grid([own[path] for own in curves.values()])
        by_path[path] = {name: sampled(own[path], grids[path]) for name, own in curves.items()}
        references[path] = measures.reference_of(
            [by_path[path][name] for name in names], [cell_size(_unknowns(each)) for each in series]
        )
        doubts[path] = measures.uncertainty(references[path])
    rows = []
    for each in runs:
        row = _costs(each)
        if each.complete and paths:
            found = [
                _errors(
                    by_path[path][each.setting.name], references[path], doubts[path], names[-1] == each.setting.name
                )
                for path in paths
            ]
            row |= _columns(measures.worst(found))
            row[REFERENCE] = _own_reference(references) if names[-1] == each.setting.name else ""
        rows.append(row)
    for each in [one for one in complete if one.setting.group == MESH and paths]:
        rows += _macro_rows(each, grids, references, doubts, names[-1] == each.setting.name)
    table = pd.DataFrame(rows)
    for name in measures.MEASURES:
        if f"{name}_pct" not in table:  # nothing to compare
            table[f"{name}_pct"] = np.nan
    table["pareto"] = False
    if paths:
        for model in (FULL, MACRO):
            part = table[(table["model"] == model) & (table["status"] == "complete")]
            for measure in ("load_max", "py_rms"):
                kept = part.index[front(part["wall_s"].tolist(), part[f"{measure}_pct"].tolist())]
                table.loc[kept, "pareto"] = True
    table = _change_alone(table, curves, complete)
    return Found(table, references, doubts, names, [each.setting for each in runs])


def _change_alone(
    table: pd.DataFrame, curves: Mapping[str, Mapping[str, Curve]], complete: Sequence[Ended]
) -> pd.DataFrame:
    """Add `from_mesh_pct`: largest load difference from the run on the same mesh with the scene's own settings [%]."""
    plain = {(e.setting.mesh, e.setting.refinement): e.setting.name for e in complete if e.setting.group == MESH}
    found = {}
    for each in complete:
        base = plain.get((each.setting.mesh, each.setting.refinement))
        if each.setting.group != MESH and base is not None:
            mine = curves[each.setting.name]
            found[each.setting.name] = max(_difference(mine[p], c) for p, c in curves[base].items() if p in mine)
    return table.assign(from_mesh_pct=[found.get(str(name), np.nan) for name in table["name"]])


def _difference(curve: Curve, base: Curve) -> float:
    grid = common_grid([curve, base])
    return measures.errors(sampled(curve, grid), sampled(base, grid))["load_max"]


def _paths(curves: Mapping[str, Mapping[str, Curve]], series: Sequence[str]) -> list[str]:
    """Paths that every complete run has."""
    if not series:
        return []
    return [path for path in curves[series[-1]] if all(path in own for own in curves.values())]


def _unknowns(each: Ended) -> int:
    return int(each.record["mesh"]["unknowns"])


def _errors(
    sample: Sample, reference: Mapping[str, Reference], doubt: Mapping[str, float], finest: bool
) -> dict[str, float]:
    """Errors [%] by measure; of the finest mesh, where it is the reference, the uncertainty at the least."""
    found = measures.errors(sample, {name: each.values for name, each in reference.items()})
    if finest:
        for name, (quantity, _) in measures.MEASURES.items():
            if quantity in reference and not reference[quantity].extrapolated:
                found[name] = max(found[name], doubt[name])
    return found


def _own_reference(references: Mapping[str, Mapping[str, Reference]]) -> str:
    """Quantities, by name, of which the finest mesh is its own reference on any path."""
    own = {name for each in references.values() for name, one in each.items() if not one.extrapolated}
    return ", ".join(sorted(own))


def _columns(found: Mapping[str, float]) -> dict[str, float]:
    return {f"{name}_pct": value for name, value in found.items()}


def _costs(each: Ended) -> dict[str, Any]:
    record, setting = each.record, each.setting
    solver, mesh = record.get("solver", {}), record.get("mesh", {})
    paths = record.get("paths", {}).values()
    unit, wall = solver.get("unit_s"), record.get("wall_s")
    peak = solver.get("peak_before_unit_bytes", record.get("peak_memory_bytes", 0))
    return {
        "model": FULL, "name": setting.name, "group": setting.group, "mesh": setting.mesh,
        "refinement": setting.refinement, "series": setting.series, "slices": None,
        "status": "complete" if each.complete else "stopped", "why": each.why,
        "unknowns": mesh.get("unknowns"), "linear": solver.get("linear"),
        "increments": sum(path["increments"] for path in paths),
        "iterations": sum(path["iterations"] + path["iterations_in_cut_backs"] for path in paths),
        "factorisations": solver.get("factorisations"),
        "wall_s": wall, "cpu_s": record.get("cpu_s"), "unit_s": unit, "units": wall / unit if unit and wall else None,
        "memory_MB": peak / 1e6 or None, REFERENCE: "",
    }  # fmt: skip


def _macro_rows(
    each: Ended, grids: Mapping[str, Grid], references: Mapping[str, Mapping[str, Reference]],
    doubts: Mapping[str, Mapping[str, float]], finest: bool,
) -> list[dict[str, Any]]:  # fmt: skip
    """Rows of the macro-models whose springs come from a run, by number of depth slices."""
    springs: xr.DataTree = read_tree(each.folder / "springs.nc")
    unit, rows = each.record["solver"].get("unit_s"), []
    for answer in macro.answers(springs):
        asked, found = [path for path in answer.asked if path in grids], []
        for path in asked:
            curve, grid = answer.paths.get(path), Grid(grids[path].x, np.full_like(grids[path].y, np.nan))
            if curve is not None and curve.x[-1] >= grid.x[-1] * (1.0 - 1e-9):  # else it did not get as far
                kept = {name: ref for name, ref in references[path].items() if name in (LOAD, OTHER)}
                found.append(_errors(sampled(curve, grid), kept, doubts[path], finest))
        complete = 0 < len(found) == len(asked)
        rows.append({
            "model": MACRO, "name": f"{each.setting.name}, {answer.springs}, {answer.slices} slices",
            "group": "macro-model", "mesh": each.setting.mesh, "refinement": each.setting.refinement,
            "series": each.setting.series, "slices": answer.slices, "status": "complete" if complete else "stopped",
            "why": "" if complete else "the springs do not carry all paths to their ends",
            "unknowns": each.record["mesh"]["unknowns"], "wall_s": answer.seconds, "cpu_s": answer.seconds,
            "unit_s": unit, "units": answer.seconds / unit if unit else None,
            REFERENCE: _own_reference(references) if finest else "",
            **(_columns(measures.worst(found)) if complete else {}),
        })  # fmt: skip
    return rows
