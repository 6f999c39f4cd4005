# SPDX-License-Identifier: MIT
"""`pysprings run`: full model, springs, prediction with the springs, tables and pictures."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pysprings.cli.compiling import compile_first
from pysprings.cli.folders import (
    chosen,
    record_stamp,
    refuse_no_folder,
    refuse_other_run,
    refuse_without_ranges,
    result_folder,
    show_together,
)
from pysprings.cli.options import (
    Changes,
    EstimateError,
    Estimates,
    Format,
    Jobs,
    Json,
    Mesh,
    NoFigures,
    SceneFile,
    Series,
    Target,
    drawn,
    option,
    quantity,
)
from pysprings.cli.scene import load, on_mesh
from pysprings.cli.support import interruptible, logged, print_json, refuse, to_stderr, write_log
from pysprings.core.errors import ResourceError, RunIncomplete, TargetMissed
from pysprings.core.words import FigureFormat, Figures
from pysprings.core.written import is_unfinished

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Stopped = RunIncomplete | ResourceError | KeyboardInterrupt | None


@dataclass(frozen=True)
class RunOptions:
    """Options of a run: mesh preset or target error, discretisation, error estimate, resumption, values, pictures."""

    mesh: str | None = None
    discretisation: str | None = None
    target: str | None = None
    budget: float | None = None
    estimate: bool | None = None
    resume: bool = False
    changes: tuple[str, ...] = ()
    figures: Figures | None = None
    format: FigureFormat = "png"
    quiet: bool = False
    jobs: int | None = None
    estimates: tuple[str, ...] = ()

    def command(self, scene: Path, folder: Path) -> str:
        """Return the command that resumes the run."""
        given = {
            "--mesh": self.mesh, "--target-error": self.target,
            "--budget": None if self.budget is None else f"'{self.budget:g} s'",
            "--discretisation": self.discretisation,
            "--figures": self.figures, "--figure-format": self.format if self.format != "png" else None,
        }  # fmt: skip
        options = "".join(f" {flag} {value}" for flag, value in given.items() if value)
        if self.estimate is not None:
            options += " --estimate-error" if self.estimate else " --no-estimate-error"
        options += "".join(f" --estimate {each}" for each in self.estimates)
        options += "".join(f" --set {shlex.quote(change)}" for change in self.changes)
        options += "" if self.jobs is None else f" --jobs {self.jobs}"
        return f"pysprings run {shlex.quote(str(scene))} --out {shlex.quote(str(folder))}{options} --resume"


def run(
    scene: SceneFile,
    out: Annotated[Path | None, option("--out", "result folder [default: out/SCENE]", "DIR")] = None,
    mesh: Mesh = None,
    discretisation: Series = None,
    target: Target = None,
    budget: Annotated[
        float | None, quantity("--budget", "s", "10 min", "time that the runs to a target error may take in all")
    ] = None,
    estimate: EstimateError = None,
    estimates: Estimates = None,
    resume: Annotated[bool, option("--resume", "go on with the interrupted run in the folder")] = False,
    force: Annotated[bool, option("--force", "replace results that the folder holds")] = False,
    changes: Changes = None,
    figures: Annotated[
        Figures | None,
        option("--figures", "pictures: none, those that the report shows, or all [default: as the scene]"),
    ] = None,
    no_figures: NoFigures = False,
    figure_format: Format = "png",
    jobs: Jobs = None,
    verbose: Annotated[bool, option("--verbose", "also iterations, balances and cost by phase at the end")] = False,
    quiet: Annotated[bool, option("--quiet", "errors and warnings alone")] = False,
    log: Annotated[Path | None, option("--log", "also write progress and messages to a file", "FILE")] = None,
    as_json: Json = False,
) -> None:
    """Run the full model; write springs, tables and pictures."""
    from pysprings.cli.results import print_results, results

    if verbose and quiet:
        refuse("--quiet", "give either this or --verbose")
    if budget is not None and target is None:
        refuse("--budget", "bounds the time of --target-error: give both")
    write_log(log)
    options = RunOptions(
        mesh, discretisation, target, budget, estimate, resume, tuple(changes or ()), drawn(figures, no_figures),
        figure_format, quiet, jobs, chosen(estimates),
    )  # fmt: skip
    folder = out or Path("out") / scene.stem
    if len(options.estimates) > 1:
        run_estimates(scene, folder, options, force, as_json)
        return
    stopped = _one(scene, folder, options, force)
    if as_json:
        print_json(results(folder))
    elif not quiet:
        print_results(folder, verbose)
    if isinstance(stopped, KeyboardInterrupt) and is_unfinished(folder):
        to_stderr(f"go on with: {options.command(scene, folder)}")
    if stopped is not None:
        raise stopped


def _one(scene: Path, folder: Path, options: RunOptions, force: bool) -> Stopped:
    """Run the scene of a file, or go on with it, with one estimate at most; return the error that ended it early."""
    own = [f"soil.estimate={each}" for each in options.estimates]
    if own:
        refuse_without_ranges(scene)
    loaded = load(scene, options.discretisation, [*options.changes, *own])
    loaded = loaded if options.target is None else target_start(loaded, options.target, options.mesh)
    ran = on_mesh(loaded, options.mesh)
    with result_folder(folder, ran, force, options.resume) as resume:
        if resume and not is_unfinished(folder) and not _budget_was_spent(folder, ran, options.target):
            return _ended_run(folder, ran, options.target)
        if options.resume and not resume and not options.quiet:
            to_stderr("note: the run here was killed before its first checkpoint: it begins from the start")
        return run_one(loaded, folder, replace(options, resume=resume))


def run_estimates(scene: Path, folder: Path, options: RunOptions, force: bool, as_json: bool) -> None:
    """Run a scene with several estimates, a folder each; write what shows them side by side."""
    refuse_without_ranges(scene)
    refuse_no_folder(folder)
    if (folder / "run.json").exists():
        refuse("--out", "holds one run: choose another folder for several estimates", folder)
    stopped = []
    for each in options.estimates:
        if not options.quiet:
            to_stderr(f"estimate {each}: {folder / each}")
        own = replace(options, estimates=(each,), resume=options.resume and (folder / each).exists())
        stopped.append(_one(scene, folder / each, own, force))
        if isinstance(stopped[-1], KeyboardInterrupt):
            to_stderr(f"go on with: {options.command(scene, folder)}")
            raise stopped[-1]
    show_together(folder, options.estimates, as_json, options.quiet)
    for error in filter(None, stopped):
        raise error


def target_start(scene: Scene, word: str, mesh: str | None) -> Scene:
    """Return the scene on the mesh from which runs to a target error begin."""
    from pysprings.full_model.accuracy import target

    if mesh is not None:
        refuse("--target-error", "chooses the mesh itself: give it or --mesh")
    return target.start(scene, word)


def run_one(scene: Scene, folder: Path, options: RunOptions) -> Stopped:
    """Run a scene; return the error that ended it early if results were written nevertheless."""
    from pysprings.core.progress import reporter
    from pysprings.results import folder as files

    before = record_stamp(folder)
    with interruptible():
        compile_first(on_mesh(scene, options.mesh), options.quiet, options.jobs)
    try:
        with interruptible(), reporter(None if options.quiet else sys.stderr) as progress:
            given: dict[str, Any] = {
                "progress": logged(progress), "resume": options.resume, "jobs": options.jobs,
                "writing": files.Writing(None, options.figures, tuple(options.format.split(","))),
            }  # fmt: skip
            if options.target is None:
                files.run_to_folder(scene, folder, mesh=options.mesh, estimate_error=options.estimate, **given)
            else:
                files.run_to_target(scene, folder, options.target, options.budget, **given)
    except (RunIncomplete, ResourceError, KeyboardInterrupt) as error:
        if record_stamp(folder) in (None, before):
            raise
        return error
    except Exception:
        if record_stamp(folder) not in (None, before):
            to_stderr(
                f"note: the results that were made are kept in {folder} (`not_made` of run.json names the others)"
            )
        raise
    return None


def _budget_was_spent(folder: Path, scene: Scene, target: str | None) -> bool:
    """Return whether the runs of a scene to a target ended before a finer mesh for their budget alone."""
    from pysprings.cli.results import read_record
    from pysprings.full_model.accuracy.target import as_ran, finer

    record = read_record(folder)
    noted = record.target_error or {}
    if target is None or target != noted.get("target") or not (record.complete and noted["missed"]):
        return False
    refuse_other_run(folder, record, as_ran(scene, noted))
    return finer(scene, noted)[0] is not None


def _ended_run(folder: Path, scene: Scene, target: str | None) -> Stopped:
    """Report how the run in a folder has ended; change nothing."""
    from pysprings.cli.results import read_record
    from pysprings.full_model.accuracy.target import as_ran

    record = read_record(folder)
    had = (record.target_error or {}).get("target")
    if target != had:
        refuse("--resume", f"the run here was made {f'with --target-error {had}' if had else 'without --target-error'}")
    refuse_other_run(folder, record, as_ran(scene, record.target_error))
    to_stderr(f"the run in {folder} has ended ({record.status}): nothing is left to do")
    if not record.complete:
        return RunIncomplete("; ".join(record.failures), folder) if record.failures else None
    missed = (record.target_error or {}).get("missed")
    return TargetMissed(missed, folder) if missed else None
