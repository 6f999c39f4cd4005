# SPDX-License-Identifier: MIT
"""The result folder of a run: all files that `pysprings run` writes."""

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import xarray as xr

from pysprings.core.errors import RunIncomplete, TargetMissed, UserInputError, reason_of
from pysprings.core.progress import Progress
from pysprings.core.storage import remove_leftovers, write_attribute, write_text, write_tree
from pysprings.core.text import json_text
from pysprings.core.words import Figures, StopReason
from pysprings.core.written import LIST, WRITING, note, noted, own_folder
from pysprings.full_model.accuracy import target
from pysprings.full_model.accuracy.own_estimate import PHASE
from pysprings.full_model.compute import RunOptions, Sink, run_into, scene_to_run
from pysprings.full_model.record import Meter
from pysprings.full_model.result_tree import raise_if_incomplete
from pysprings.full_model.run_record import ATTRIBUTE, Computed, RunRecord
from pysprings.macro.spring_sets import with_stored
from pysprings.model.forecast.resources import refuse_full_disk
from pysprings.results import plots
from pysprings.results.exporters import EXPORTERS, Source, Target, export
from pysprings.results.exporters.csv import write_frame
from pysprings.results.exporters.tables import load_displacement
from pysprings.results.layout import FIGURES, PARAVIEW, own_folders, refuse_linked_folders, remove_results
from pysprings.results.report.page import write_report
from pysprings.results.summary import summary
from pysprings.scene.model import Scene
from pysprings.springs.checks import extract_springs, save_springs
from pysprings.springs.path import paths_of
from pysprings.springs.sums import balance

T = TypeVar("T")
NOT_YET = "not made yet"


@dataclass(frozen=True)
class Writing:
    """What decides the files of a run beside its scene.

    target_error : target, scene and earlier runs (`accuracy.target.judged`); its error is judged at the end.
    figures : pictures that are drawn, whatever the scene says; None: those that it asks for.
    formats : formats of the pictures: "png", "svg".
    springs_alone : True writes springs.nc and run.json and no other file.
    """

    target_error: tuple[str, Scene, Sequence[Mapping[str, Any]]] | None = None
    figures: Figures | None = None
    formats: tuple[str, ...] = ("png",)
    springs_alone: bool = False


def run_to_folder(
    scene: Scene, out: str | os.PathLike[str], mesh: str | None = None, progress: Progress | None = None,
    resume: bool | None = False, estimate_error: bool | None = None, time_unit: bool = False,
    writing: Writing | None = None, jobs: int | None = 1,
) -> Path:  # fmt: skip
    """Run a scene and write full model, springs, tables, comparison, pictures, report and run.json; return the folder.

    Results of an earlier run in the folder are removed once the new ones are there to be written; a scene that is
    refused does not change them. A run that stops early writes what converged, marked as partial, and then
    raises RunIncomplete (or KeyboardInterrupt, or ResourceError). The error estimate, pictures and report follow the
    results: where they fail the record names them (`not_made`). One run at a time holds the folder, which has
    checkpoints until everything is made. `full_model.compute.RunOptions` has the arguments; ``writing`` is what else
    decides the files.
    """
    folder, more = Path(out), writing or Writing()
    refuse_full_disk(scene_to_run(scene, mesh), folder)
    refuse_linked_folders(folder)
    options = RunOptions(mesh, None, progress, None, resume, time_unit, None, estimate_error, jobs)
    result = run_into(folder, scene, options, _Files(folder, more, more.figures or scene.output.pictures, progress))
    raise_if_incomplete(result, folder)
    return folder


def run_to_target(
    scene: Scene, out: str | os.PathLike[str], word: str, budget: float | None = None,
    resume: bool | None = False, writing: Writing | None = None, **given: Any,
) -> Path:  # fmt: skip
    """Run a scene on finer and finer meshes until its own estimate is within a target; return the folder.

    The scene is on the mesh to begin with (`accuracy.target.start`). The folder has the results of the last run that
    ended. Runs that would exceed the budget [s] of wall time are not begun: the record names the target as missed. A
    resumed run goes on from the last one that ended; its budget begins anew.
    """
    folder, began = Path(out), time.monotonic()
    noted = _noted(folder) if resume else {}
    earlier = [run for run in noted.get("runs", []) if target.JUDGED.keys() <= run.keys()]
    whole = len(earlier) == len(noted.get("runs", []))  # the last run has its estimate
    after = target.finer(scene, noted)[0] if whole and noted.get("missed") else None
    if after is None:
        scene, earlier = target.as_ran(scene, noted), earlier[:-1] if whole else earlier
    else:
        scene, resume = after, None
    while True:
        before = time.monotonic()
        judged = replace(writing or Writing(), target_error=(word, scene, earlier))
        try:
            return run_to_folder(scene, folder, resume=resume, estimate_error=True, writing=judged, **given)
        except RunIncomplete:
            noted = _noted(folder)
            if not noted.get("missed") or len(noted["runs"]) == len(earlier):
                raise
        earlier, (after, why) = noted["runs"], target.finer(scene, noted)
        needed = 0.0 if after is None else target.cost(time.monotonic() - before, scene, after)
        left = math.inf if budget is None else budget - (time.monotonic() - began)
        if needed > left:
            after, why = None, f"a finer mesh takes about {needed:.0f} s, of the budget {max(left, 0.0):.0f} s are left"
        if after is None:
            _conclude(folder, f"{noted['missed']}; {why}")
        scene, resume = after, False


def _noted(folder: Path) -> dict[str, Any]:
    """Return what run.json has on a target of a complete run; empty where there is none."""
    record = RunRecord.read(folder)
    return {} if record is None or not record.complete else dict(record.target_error or {})


def _conclude(folder: Path, missed: str) -> NoReturn:
    """Write into run.json how the target is missed, and raise it."""
    record = RunRecord.read(folder)
    assert record is not None
    _write_record(folder, record.as_dict() | {"target_error": {**(record.target_error or {}), "missed": missed}})
    raise TargetMissed(missed, folder)


def run_or_go_on(
    scene: Scene, folder: Path, progress: Progress | None = None, time_unit: bool = False,
    writing: Writing | None = None, estimate_error: bool | None = False,
) -> Path:  # fmt: skip
    """Run a scene into a folder, or resume the interrupted run there.

    The run starts anew where the checkpoints belong to another scene, mesh or version, or are damaged. A folder that is
    a link is refused.
    """
    own_folder(folder.parent, folder.name)
    return run_to_folder(scene, folder, None, progress, None, estimate_error, time_unit, writing)


class _Files(Sink):
    """The files of a run: those with its results first, then those that follow from them."""

    def __init__(self, folder: Path, writing: Writing, figures: Figures, progress: Progress | None) -> None:
        self.folder, self.writing, self.figures, self.progress = folder, writing, figures, progress
        self.kept: xr.DataTree | None = None  # result whose springs `source` has
        self.source = Source()
        self.has_springs = False
        self.errors: list[Exception] = []  # of results, not of what shows them
        self.stopped = False  # by an interrupt while results are written

    def keep(self, computed: Computed) -> None:
        """Write full model, loads and springs, in the place of those of an earlier run; the rest is not made yet."""
        record, meter = computed.record, Meter()
        self._judge(record)
        with meter.clock.phase("output: files before the estimate"):
            self._write_model(computed)
        meter.charge(record)
        still = [] if record.error_estimate else [PHASE]
        self._write_record(record, [*still, *([] if self.writing.springs_alone else ["tables"]), *self._shown])

    def finish(self, computed: Computed) -> None:
        """Write the results as they are at the end, pictures and report; what fails is named in the record."""
        record, meter = computed.record, Meter()
        if computed.interrupted and self.writing.target_error is not None and self.writing.target_error[2]:
            return  # the results of the mesh before stay; checkpoints have what ran
        self._judge(record)
        with meter.clock.phase("output: files"):
            self._write_results(computed)
        if not self.writing.springs_alone:
            self._write_record(record, self._shown)
            self._show(computed, meter)
        meter.charge(record)
        record.files = noted(self.folder)
        _write_record(self.folder, record.as_dict())
        (self.folder / LIST).unlink(missing_ok=True)
        if self.errors:
            raise self.errors[0]

    def _judge(self, record: RunRecord) -> None:
        """Note how the run stands to its target, if it has one."""
        if self.writing.target_error is not None:
            word, scene, earlier = self.writing.target_error
            record.target_error = target.judged(word, scene, record.error_estimate or {}, earlier)

    @property
    def _shown(self) -> list[str]:
        """Names of what shows the results."""
        return [] if self.writing.springs_alone else [*(["pictures"] if self.figures != "none" else []), "report"]

    def _write_record(self, record: RunRecord, still: Sequence[str]) -> None:
        """Write run.json while parts are still to be made."""
        missing = record.not_made | dict.fromkeys(still, NOT_YET)
        _write_record(self.folder, record.as_dict() | {"files": noted(self.folder), "not_made": missing})

    def _show(self, computed: Computed, meter: Meter) -> None:
        """Draw the pictures and write the report."""
        record, figures = computed.record, None
        if self.figures != "none":
            with meter.clock.phase("output: pictures"):
                figures = self._made(record, "pictures", self._draw, shows=True)
        meter.charge(record)  # the report shows the cost of everything but itself
        with meter.clock.phase("output: report"):
            self._made(record, "report", lambda: self._report(computed, figures or []), shows=True)

    def _draw(self) -> list[Path]:
        """Draw the pictures of the report, or all."""
        source, known = self.source, self.has_springs
        return plots.save_all(
            source.result, source.springs if known else None, self.folder / FIGURES,
            source.predictions if known else None, partial(note, self.folder), self.figures, self.writing.formats,
        )  # fmt: skip

    def _report(self, computed: Computed, figures: list[Path]) -> None:
        compared = "compare.csv" not in computed.record.not_made and self.has_springs
        springs, table = self.source.springs if self.has_springs else None, self.source.comparison if compared else None
        write_report(self.folder, computed.tree, springs, table, run=computed.record, figures=figures)

    def _write_model(self, computed: Computed) -> None:
        """Write full model, loads and springs where they are not there yet; the springs alone where that is asked."""
        if self.kept is computed.tree and not self.errors:
            return
        self.errors.clear()
        record, folder = computed.record, self.folder
        springs = self._made(record, "springs", lambda: _springs(computed.tree))
        remove_results(folder)  # of an earlier run
        remove_leftovers(folder, *(folder / name for name in own_folders()))
        source = self.source = Source(springs, computed.tree)
        self.kept, self.has_springs = computed.tree, springs is not None
        if not self.writing.springs_alone:
            write_tree(computed.recorded(), folder / "full_model.nc")
            _write_record(folder, record.as_dict() | {"status": WRITING})
            if {"paths", "space"} & set(source.result.children):
                write_frame(load_displacement(source.result), folder / "load_displacement.csv")
        if self.has_springs:
            self._made(record, "springs.nc", lambda: save_springs(source.springs, folder / "springs.nc"))
            record.balance = {name: balance(path.dataset) for name, path in paths_of(source.springs).items()}

    def _write_results(self, computed: Computed) -> None:
        """Write full model, springs, and the tables that are made of them."""
        self._write_model(computed)
        if self.has_springs:
            self._made(computed.record, "elements of springs.nc", self._store)
        if self.writing.springs_alone:
            return
        record, folder, source = computed.record, self.folder, self.source
        _write_record(folder, record.as_dict() | {"status": WRITING})
        if self.has_springs:
            self._made(record, "compare.csv", lambda: write_frame(source.comparison, folder / "compare.csv"))
        if self.has_springs or "space" in source.result.children:
            self._made(record, "summary", lambda: self._summarise(record))
        if self.has_springs:
            for each in (each for each in EXPORTERS if each.of_every_run and each.file != "springs.nc"):
                self._made(record, each.file, partial(export, source, each.name, folder / each.file))
        write_attribute(ATTRIBUTE, computed.recorded().attrs[ATTRIBUTE], folder / "full_model.nc")  # with the summary
        if "volume" in source.result.children:
            target = Target(folder / PARAVIEW, partial(note, folder))
            self._made(record, "paraview", lambda: export(source, "paraview", target))

    def _store(self) -> None:
        """Put into springs.nc what spring sets keep there: at the end, since it takes its time, of both meshes."""
        given, result = self.source.springs, self.source.result
        try:
            whole = with_stored(given, self.progress)
        except UserInputError:  # too little converged
            if result.attrs["status"] == "complete":
                raise
            return
        if whole is not given:
            self.source = Source(whole, result)
            save_springs(whole, self.folder / "springs.nc")

    def _summarise(self, record: RunRecord) -> None:
        source = self.source
        made = (source.comparison, source.springs) if self.has_springs else ()
        source.summary = record.summary = summary(source.result, record, *made)

    def _made(self, record: RunRecord, name: str, make: Callable[[], T], shows: bool = False) -> T | None:
        """Return what ``make`` returns; None where it fails, with the reason in the record, and after an interrupt.

        An interrupt of the estimate costs nothing but what ``shows`` the results, one of a table all that follows.
        `finish` raises the errors of results once all else is made.
        """
        try:
            if self.stopped or (shows and StopReason.INTERRUPTED in record.not_made.values()):
                raise KeyboardInterrupt
            return make()
        except KeyboardInterrupt:
            self.stopped = True
            record.not_made[name] = str(StopReason.INTERRUPTED)
        except Exception as error:
            record.not_made[name] = reason_of(error)
            self.errors += [] if shows else [error]
        record.summary = {**(record.summary or {}), "not made": record.left_to_make}
        return None


def _springs(result: xr.DataTree) -> xr.DataTree | None:
    """Return the springs of a result; None when too little converged."""
    try:
        return extract_springs(result)
    except UserInputError:
        if result.attrs["status"] == "complete" and paths_of(result):
            raise
        return None


def _write_record(folder: Path, record: dict[str, Any]) -> None:
    write_text(json_text(record, indent=2) + "\n", folder / "run.json")
