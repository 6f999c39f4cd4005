# SPDX-License-Identifier: MIT
"""The result folder of a run: everything that `pysprings run` leaves behind."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.comparison import compare, curves
from pysprings.errors import UserInputError
from pysprings.exporters import csv_tables, excel
from pysprings.extract import extract_springs
from pysprings.full_model import Progress, raise_if_incomplete, run
from pysprings.springs import balance, get_path, path_names, save_springs
from pysprings.storage import write_text, write_tree

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene import Scene


def run_to_folder(
    scene: Scene, out: str | os.PathLike[str], mesh: str | None = None, progress: Progress | None = None
) -> Path:
    """Run a scene and write full model, springs, tables, comparison, pictures, report and run.json; return the folder.

    A run that stops early writes what converged, marked as partial, and then raises RunIncomplete (or
    KeyboardInterrupt).
    """
    folder = Path(out)
    result = run(scene, mesh=mesh, progress=progress)
    folder.mkdir(parents=True, exist_ok=True)
    start, cpu = time.perf_counter(), time.process_time()
    write_tree(result, folder / "full_model.nc")
    record: dict[str, Any] = json.loads(result.attrs["run_json"])
    _write_record(folder, record)
    springs = _springs(result)
    if springs is not None:
        record["balance"] = {name: balance(get_path(springs, name)) for name in path_names(springs)}
        _write_springs(folder, result, springs)
    if scene.output.figures:
        _draw(folder, result, springs)
    wall = time.perf_counter() - start
    record["phases"]["files and figures"] = {
        "wall_s": round(wall, 3), "cpu_s": round(time.process_time() - cpu, 3),
    }  # fmt: skip
    record["wall_s"] = round(record["wall_s"] + wall, 3)
    _write_record(folder, record)
    _report(folder, result, springs, record)
    raise_if_incomplete(result, folder)
    return folder


def _springs(result: xr.DataTree) -> xr.DataTree | None:
    """The springs of a result, or None when too little converged."""
    try:
        return extract_springs(result)
    except UserInputError:
        if result.attrs["status"] == "complete":
            raise
        return None


def _write_springs(folder: Path, result: xr.DataTree, springs: xr.DataTree) -> None:
    save_springs(springs, folder / "springs.nc")
    csv_tables(folder, springs, result, compare(springs))
    excel(folder / "springs.xlsx", springs)


def _draw(folder: Path, result: xr.DataTree, springs: xr.DataTree | None) -> None:
    from pysprings import plots

    predicted = {name: curves(springs, name) for name in path_names(springs)} if springs is not None else {}
    plots.save_all(result, springs, folder / "figures", predicted)


def _report(folder: Path, result: xr.DataTree, springs: xr.DataTree | None, record: dict[str, Any]) -> None:
    from pysprings.report import write_report

    write_report(folder, result, springs, run=record)


def _write_record(folder: Path, record: dict[str, Any]) -> None:
    write_text(json.dumps(record, indent=2) + "\n", folder / "run.json")
