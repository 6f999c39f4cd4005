# SPDX-License-Identifier: MIT
"""Scene -> full model -> raw result with provenance, convergence record and cost."""

import os
import time
import warnings
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path as FilePath

import xarray as xr

from fe_engine.errors import FEError
from fe_engine.state import State
from pysprings.core.errors import out_of_memory
from pysprings.core.process import blas_on_one_thread
from pysprings.core.progress import Progress, Total
from pysprings.core.words import StopReason
from pysprings.core.workers import Workers
from pysprings.core.written import exclusive, is_unfinished, new_folder, refuse_links
from pysprings.full_model.accuracy.own_estimate import (
    AT_LEAST,
    LONGEST,
    SHARE,
    companions_of,
    estimates_by_default,
    with_estimate,
)
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.paths import path_costs, run_paths
from pysprings.full_model.record import Meter
from pysprings.full_model.result_tree import record_of, tree_of
from pysprings.full_model.run_record import Computed
from pysprings.full_model.work import factorise_and_solve_seconds, prepare
from pysprings.model.forecast.resources import jobs_for, refuse_what_cannot_fit
from pysprings.scene.model import Scene


@dataclass(frozen=True)
class RunOptions:
    """How a scene is run.

    mesh, linear : preset and linear solver instead of the scene's.
    progress : called as ``progress(path, fraction, message)``.
    checkpoints : where checkpoints are left. They stay when the paths have ended: the caller removes them after saving.
    resume : go on from the checkpoints; None where there are any of this very run.
    time_unit : also measure one factorisation and solve of the last tangent (`SolverFigures.unit_s`).
    harmonics : of a Fourier series whose scene has none.
    estimate_error : also run the scene on a coarser mesh and estimate the error; None: of Fourier series.
    jobs : processes for the paths; None: as many as there are cores, where they pay.
    workers : processes that are there already.
    span : shares of all work at which this run begins and ends, for its progress.
    """

    mesh: str | None = None
    linear: str | None = None
    progress: Progress | None = None
    checkpoints: Checkpoints | None = None
    resume: bool | None = False
    time_unit: bool = False
    harmonics: int | None = None
    estimate_error: bool | None = None
    jobs: int | None = 1
    workers: Workers | None = None
    span: tuple[float, float] = (0.0, 1.0)


class Sink:
    """What takes the results of a run as they come; this one leaves them alone.

    Nothing that follows a result, an interrupt neither, costs one that it was given.
    """

    def keep(self, computed: Computed) -> None:
        """Take a result that is whole, before what follows it is begun; the record names what is not made yet."""

    def finish(self, computed: Computed) -> None:
        """Take the result as it is at the end."""


def run(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None, estimate_error: bool | None = None, jobs: int | None = 1,
) -> xr.DataTree:  # fmt: skip
    """Run the full model along all paths of a scene.

    Parameters
    ----------
    scene : what to run.
    mesh, linear : preset and linear solver instead of the scene's; the result records the scene that ran.
    progress : called as ``progress(path, fraction, message)``.
    checkpoint : folder for checkpoints. Where one holds those of this very run, stopped, it goes on from them; they are
        removed when it has ended.
    estimate_error : run the scene on a coarser mesh, too, and put an estimate of the discretisation error into the
        record (`pysprings.full_model.accuracy.two_mesh`). None: of Fourier series, whose number of harmonics is chosen
        with it where the scene has none.
    jobs : number of worker processes for the paths; 1: none, None: as many as there are cores, where they pay. The
        result is the same. A script that asks for workers needs ``if __name__ == "__main__":`` before its work, since
        they import it.

    Returns
    -------
    DataTree with one group per path (see `pysprings.core.variables`). ``attrs["status"]`` is "complete", or "partial"
    when a path did not converge to its end (with a warning), or "interrupted"; what converged is kept. A path under a
    given load that ends at its limit load is complete: its own status is "limit load", the record has the loads. Water
    that would cavitate at the scene's water depth is warned of.
    """
    folder = None if checkpoint is None else FilePath(checkpoint)
    resume = folder is not None and is_unfinished(folder)
    options = RunOptions(mesh, linear, progress, None, resume, estimate_error=estimate_error, jobs=jobs)
    result = run_into(folder, scene, options, Sink())
    for text in [*result.record.failures, *result.record.warnings]:
        warnings.warn(text, stacklevel=2)
    if StopReason.INTERRUPTED in result.record.not_made.values():
        raise KeyboardInterrupt
    return result.recorded()


def run_into(folder: FilePath | None, scene: Scene, options: RunOptions, sink: Sink) -> Computed:
    """Run a scene, estimate the error of its mesh, and hand the results to a sink: the one entry of all runs.

    The checkpoints are in ``folder`` until everything is made; one run at a time holds it.
    """
    ran = scene_to_run(scene, options.mesh, options.linear)
    with ExitStack() as held:
        if folder is not None:
            held.enter_context(new_folder(folder))
            held.enter_context(exclusive(folder, ran.sha256))
            refuse_links(folder)
            options = replace(options, checkpoints=Checkpoints(folder))
        if (jobs := jobs_for(ran, options.jobs)) > 1:
            options = replace(options, workers=held.enter_context(Workers(jobs)))
        result = _run_and_estimate(ran, scene, options, sink)
        sink.finish(result)
        if options.checkpoints is not None and not result.unfinished:
            options.checkpoints.remove()
    return result


def _run_and_estimate(ran: Scene, scene: Scene, options: RunOptions, sink: Sink) -> Computed:
    """Run a scene, then estimate the error of its mesh; run it again where its series needs more harmonics."""
    saved = options.checkpoints
    chosen = saved.harmonics if saved is not None and options.resume else options.harmonics
    estimated = estimates_by_default(ran) if options.estimate_error is None else options.estimate_error
    options = replace(options, span=(0.0, SHARE) if estimated else options.span)
    result = compute(scene, replace(options, harmonics=chosen))
    if result.interrupted or not estimated:
        return result
    sink.keep(result)

    def again(harmonics: int, estimated: Computed) -> Computed:
        sink.keep(estimated)
        return compute(scene, replace(options, harmonics=harmonics, resume=False))

    beside = partial(compute, workers=options.workers)
    until = time.monotonic() + max(LONGEST * result.record.wall_s, AT_LEAST)
    return with_estimate(ran, result, companions_of(ran, beside, options.progress, chosen, saved, until), again)


def compute(scene: Scene, options: RunOptions | None = None, **given: object) -> Computed:
    """Run the paths of a scene, without estimate and warnings; `RunOptions` has the arguments, here or by name."""
    options = options or RunOptions(**given)  # type: ignore[arg-type]
    began = datetime.now(UTC).isoformat(timespec="seconds")
    meter, cpu = Meter(), time.process_time()
    with blas_on_one_thread():
        ran = scene_to_run(scene, options.mesh, options.linear, options.harmonics)
        refuse_what_cannot_fit(ran)
        if options.workers is not None:
            options.workers.prepare()
        progress = options.progress or (lambda *_: None)
        weights = path_costs(ran)
        work = prepare(ran, meter.clock, Total(progress, weights, span=options.span))
        work.checkpoints, work.cpu_began = options.checkpoints, cpu
        loaded = work.take_up(options.resume, began)
        try:
            run_paths(work, loaded, options.workers)
        except KeyboardInterrupt:
            work.stopped = StopReason.INTERRUPTED
        except MemoryError as error:
            work.stopped = StopReason.OUT_OF_MEMORY
            work.failures.append(out_of_memory(error))
        if work.condition is None:
            work.condition = work.newton.condition_estimate()
        record = record_of(work, loaded)
        meter.charge(record)
        if options.time_unit and not work.stopped:
            record.solver.peak_before_unit_bytes = record.peak_memory_bytes
            with suppress(FEError, MemoryError):  # the run is worth more than its unit
                state = work.state or State(work.built.model)
                record.solver.unit_s = factorise_and_solve_seconds(work.newton, state)
        work.newton.close()
        tree = tree_of(work, record)
    if ran is not scene:
        tree.attrs["scene_toml_given"] = scene.source_text
    return Computed(tree, record)


def scene_to_run(
    scene: Scene, mesh: str | None = None, linear: str | None = None, harmonics: int | None = None
) -> Scene:
    """Return the scene with another mesh preset or linear solver, or with harmonics where it has none.

    The scene itself where nothing changes.
    """
    changed = scene
    if mesh is not None and mesh != scene.mesh.preset:
        changed = changed.replace(mesh={"preset": mesh})
    if linear is not None and linear != scene.solver.linear:
        changed = changed.replace(solver={"linear": linear})
    if harmonics is not None and scene.mesh.harmonics is None:
        changed = changed.replace(mesh={"harmonics": harmonics})
    return changed
