# SPDX-License-Identifier: MIT
"""The result folder of a run: all files that `pysprings run` writes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import UserInputError
from pysprings.core.files.layout import WRITING, is_unfinished
from pysprings.core.files.lock import exclusive, new_folder
from pysprings.core.files.storage import remove_leftovers, write_text, write_tree
from pysprings.core.files.written import LIST, note, noted, own_folder
from pysprings.core.progress import Progress
from pysprings.core.text import json_text
from pysprings.full_model.accuracy.own_estimate import (
    Companions,
    add_estimate,
    companions_of,
    estimates_by_default,
    was_interrupted,
)
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.compute import compute, scene_to_run
from pysprings.full_model.record import Meter
from pysprings.full_model.result_tree import raise_if_incomplete
from pysprings.full_model.run_record import Computed, RunRecord
from pysprings.macro.memory.build import with_memory
from pysprings.model.forecast.resources import refuse_full_disk
from pysprings.results.exporters import EXPORTERS, Source, Target, export
from pysprings.results.exporters.csv import write_frame, write_load_displacement
from pysprings.results.layout import FIGURES, PARAVIEW, own_folders, refuse_linked_folders, remove_results
from pysprings.results.report.page import write_report
from pysprings.results.summary import summary
from pysprings.springs.dataset import get_path, path_names
from pysprings.springs.extract import extract_springs
from pysprings.springs.file import save_springs
from pysprings.springs.sums import balance

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.load import Scene


@dataclass(frozen=True)
class Writing:
    """What decides the files of a run beside its scene.

    Attributes
    ----------
    target_error : goes into run.json.
    figures : False draws no pictures, whatever the scene says.
    springs_alone : True writes springs.nc and run.json and no other file.
    """

    target_error: Mapping[str, Any] | None = None
    figures: bool = True
    springs_alone: bool = False


def run_to_folder(
    scene: Scene, out: str | os.PathLike[str], mesh: str | None = None, progress: Progress | None = None,
    resume: bool = False, estimate_error: bool | None = None, time_unit: bool = False,
    writing: Writing | None = None,
) -> Path:  # fmt: skip
    """Run a scene and write full model, springs, tables, comparison, pictures, report and run.json; return the folder.

    Results of an earlier run in the folder are removed once the new ones are there to be written; a scene that is
    refused does not change them. A run that stops early writes what converged, marked as partial, and then
    raises RunIncomplete (or KeyboardInterrupt, or ResourceError). One run at a time holds the folder. Checkpoints are
    in it until everything is written; ``resume`` goes on from them. ``estimate_error`` is that of `full_model.run`,
    ``time_unit`` that of `full_model.compute`; ``writing`` is what else decides the files.
    """
    folder, ran = Path(out), scene_to_run(scene, mesh)
    refuse_full_disk(ran, folder)
    with new_folder(folder), exclusive(folder):
        refuse_linked_folders(folder)
        checkpoints = Checkpoints(folder)
        estimated = estimates_by_default(ran) if estimate_error is None else estimate_error
        chosen = checkpoints.harmonics if resume else None
        beside = companions_of(ran, compute, progress, chosen) if estimated else Companions()
        result = compute(
            scene, mesh, progress, checkpoints=checkpoints, resume=resume, time_unit=time_unit,
            harmonics=beside.harmonics,
        )  # fmt: skip
        if estimated and not result.interrupted:
            add_estimate(ran, result, compute, progress, beside)
        more = writing or Writing()
        result.record.target_error = None if more.target_error is None else dict(more.target_error)
        if more.springs_alone:
            _write_springs(folder, result)
        else:
            _write_all(folder, scene, result, more.figures and scene.output.figures)
        if not result.interrupted:
            checkpoints.remove()
        raise_if_incomplete(result, folder)
        if was_interrupted(result.record):
            raise KeyboardInterrupt
    return folder


def run_or_go_on(
    scene: Scene, folder: Path, progress: Progress | None = None, time_unit: bool = False,
    writing: Writing | None = None,
) -> Path:  # fmt: skip
    """Run a scene into a folder, or resume the interrupted run there; the error is not estimated.

    The run starts anew where the checkpoints belong to another scene, mesh or version, or are damaged. A folder that is
    a link is refused.
    """
    own_folder(folder.parent, folder.name)
    resume = is_unfinished(folder)
    again = partial(run_to_folder, scene, folder, None, progress, estimate_error=False, time_unit=time_unit,
                    writing=writing)  # fmt: skip
    try:
        return again(resume=resume)
    except UserInputError:
        if not resume:
            raise
        return again()


def _write_springs(folder: Path, computed: Computed) -> None:
    """Write the springs and the record of a result alone, in the place of the files of an earlier run."""
    record, springs = computed.record, _springs(computed.recorded())
    remove_results(folder)
    remove_leftovers(folder, *(folder / name for name in own_folders()))
    if springs is not None:
        record.balance = {name: balance(get_path(springs, name)) for name in path_names(springs)}
        save_springs(springs, folder / "springs.nc")
    record.files = noted(folder)
    _write_record(folder, record.as_dict())


def _write_all(folder: Path, scene: Scene, computed: Computed, drawn: bool) -> None:
    """Write every file of a result, in the place of those of an earlier run; run.json has its status at the end."""
    meter, record, result = Meter(), computed.record, computed.recorded()
    remove_results(folder)
    remove_leftovers(folder, *(folder / name for name in own_folders()))
    written = partial(note, folder)
    with meter.clock.phase("output: files"):
        write_tree(result, folder / "full_model.nc")
        _write_record(folder, record.as_dict() | {"status": WRITING})
        springs = _springs(result)
        source = Source(springs, result)
        _write_tables(folder, source, springs is not None, record)
        if "volume" in result.children:
            export(source, "paraview", Target(folder / PARAVIEW, written))
    with meter.clock.phase("output: pictures"):
        figures = _draw(folder, source, springs, written) if drawn else []
    meter.charge(record)  # the report shows the cost of everything but itself
    with meter.clock.phase("output: report"):
        compared = None if springs is None else source.comparison
        write_report(folder, result, springs, compared, run=record, figures=figures)
    meter.charge(record)
    record.files = noted(folder)
    _write_record(folder, record.as_dict())
    (folder / LIST).unlink(missing_ok=True)


def _springs(result: xr.DataTree) -> xr.DataTree | None:
    """Return the springs of a result; None when too little converged."""
    try:
        return with_memory(extract_springs(result))
    except UserInputError:
        if result.attrs["status"] == "complete":
            raise
        return None


def _write_tables(folder: Path, source: Source, has_springs: bool, record: RunRecord) -> None:
    """Write the loads of every path, and the files of the springs."""
    if path_names(source.result):
        write_load_displacement(source.result, folder / "load_displacement.csv")
    if has_springs:
        springs = source.springs
        record.balance = {name: balance(get_path(springs, name)) for name in path_names(springs)}
        source.summary = record.summary = summary(source.result, record, source.comparison, springs)
        for exporter in EXPORTERS:
            if exporter.of_every_run:
                export(source, exporter.name, folder / exporter.file)
        write_frame(source.comparison, folder / "compare.csv")


def _draw(folder: Path, source: Source, springs: xr.DataTree | None, written: Callable[[Path], object]) -> list[Path]:
    from pysprings.results import plots

    predicted = source.predictions if springs is not None else {}
    return plots.save_all(source.result, springs, folder / FIGURES, predicted, written)


def _write_record(folder: Path, record: dict[str, Any]) -> None:
    write_text(json_text(record, indent=2) + "\n", folder / "run.json")
