# SPDX-License-Identifier: MIT
"""Scene -> full model -> raw result with provenance, convergence record and cost."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.compiled import engine_digest
from fe_engine.errors import FEError, LinearSolverError
from fe_engine.state import State
from pysprings.core import version
from pysprings.core.errors import ResourceError, RunIncomplete, out_of_memory, refused
from pysprings.core.files.lock import exclusive, new_folder
from pysprings.core.files.written import is_unfinished, refuse_links
from pysprings.core.path_kinds import PAIRS, PARTS
from pysprings.core.process import blas_on_one_thread
from pysprings.core.progress import Progress, counted
from pysprings.core.words import StopReason
from pysprings.full_model.accuracy.own_estimate import (
    companions_of,
    estimates_by_default,
    with_estimate,
)
from pysprings.full_model.cavitation import warning as cavitation_warning
from pysprings.full_model.checkpoint import Checkpoints, Loaded, Saved, scene_identity
from pysprings.full_model.discretise import make_engine
from pysprings.full_model.path_run import PathRun
from pysprings.full_model.record import (
    Meter,
    convergence_dataset,
    cut_back,
    energy_summary,
    summarise,
)
from pysprings.full_model.result_tree import differences, environment_of, record_of, tree_of
from pysprings.full_model.run_record import Computed, LimitLoad, Status
from pysprings.full_model.work import Work, factorise_and_solve_seconds
from pysprings.model.forecast.domain_effect import domain_effect
from pysprings.model.forecast.resources import refuse_what_cannot_fit
from pysprings.model.fourier import build
from pysprings.model.penalty import penalty_of
from pysprings.model.stages import fast_paths, large_motion, viscous_displacement
from pysprings.model.water import undrained_time
from pysprings.springs.path_ends import end_attrs

if TYPE_CHECKING:
    from pysprings.scene.load import Path, Scene

_ROUNDING = 1e-5  # share of the stiffness by which a linear solver may leave it unsymmetric


def run(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None, estimate_error: bool | None = None,
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

    Returns
    -------
    DataTree with one group per path (see `pysprings.core.variables`). ``attrs["status"]`` is "complete", or "partial"
    when a path did not converge to its end (with a warning), or "interrupted"; what converged is kept. A path under a
    given load that ends at its limit load is complete: its own status is "limit load", the record has the loads. Water
    that would cavitate at the scene's water depth is warned of.
    """
    options = RunOptions(mesh, linear, progress)
    if checkpoint is None:
        result = run_and_estimate(scene, options, estimate_error)
    else:
        folder = FilePath(checkpoint)
        with new_folder(folder), exclusive(folder):
            refuse_links(folder)
            options = replace(options, checkpoints=Checkpoints(folder), resume=is_unfinished(folder))
            result = run_and_estimate(scene, options, estimate_error)
            if not result.unfinished:
                Checkpoints(folder).remove()
    for text in [*result.record.failures, *result.record.warnings]:
        warnings.warn(text, stacklevel=2)
    if StopReason.INTERRUPTED in result.record.not_made.values():
        raise KeyboardInterrupt
    return result.recorded()


@dataclass(frozen=True)
class RunOptions:
    """How a scene is run.

    Attributes
    ----------
    mesh, linear : preset and linear solver instead of the scene's.
    progress : called as ``progress(path, fraction, message)``.
    checkpoints : where checkpoints are left. They stay when the paths have ended: the caller removes them after saving.
    resume : go on from the checkpoints.
    harmonics : of a Fourier series whose scene has none.
    time_unit : also measure one factorisation and solve of the last tangent (`SolverFigures.unit_s`).
    """

    mesh: str | None = None
    linear: str | None = None
    progress: Progress | None = None
    checkpoints: Checkpoints | None = None
    resume: bool = False
    time_unit: bool = False
    harmonics: int | None = None


def compute(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None,
    checkpoints: Checkpoints | None = None, resume: bool = False, time_unit: bool = False, harmonics: int | None = None,
) -> Computed:  # fmt: skip
    """Do the work of `run`, without warnings; see `RunOptions` for the arguments."""
    return _compute(scene, RunOptions(mesh, linear, progress, checkpoints, resume, time_unit, harmonics))


def run_and_estimate(
    scene: Scene,
    options: RunOptions,
    estimate_error: bool | None = None,
    keep: Callable[[Computed], object] | None = None,
) -> Computed:
    """Run a scene, then estimate the error of its mesh; run it again where its series needs more harmonics.

    ``keep`` is called with a result that is whole before what follows it is begun: nothing that follows, an interrupt
    neither, costs that result. The record names what was not made.
    """
    keep = keep or (lambda _: None)
    ran, saved = scene_to_run(scene, options.mesh, options.linear), options.checkpoints
    chosen = saved.harmonics if saved is not None and options.resume else options.harmonics
    result = _compute(scene, replace(options, harmonics=chosen))
    if result.interrupted or not (estimates_by_default(ran) if estimate_error is None else estimate_error):
        return result
    keep(result)

    def again(harmonics: int) -> Computed:
        keep(result)
        return _compute(scene, replace(options, harmonics=harmonics, resume=False))

    return with_estimate(ran, result, companions_of(ran, compute, options.progress, chosen), again)


def _compute(scene: Scene, options: RunOptions) -> Computed:
    with blas_on_one_thread():
        return _computed(scene, options)


def _silent(*_: object) -> None:
    """Report no progress."""


def _computed(scene: Scene, options: RunOptions) -> Computed:
    started, meter = datetime.now(UTC).isoformat(timespec="seconds"), Meter()
    ran = scene_to_run(scene, options.mesh, options.linear, options.harmonics)
    refuse_what_cannot_fit(ran)
    work = _prepare(ran, meter.clock, counted(options.progress or _silent, [path.name for path in ran.load_paths]))
    work.checkpoints = options.checkpoints
    loaded = _take_up(work, started, options.resume)
    try:
        _run_paths(work, loaded)
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
            record.solver.unit_s = factorise_and_solve_seconds(work.newton, work.state or State(work.built.model))
    work.newton.close()
    tree = tree_of(work, record)
    if ran is not scene:
        tree.attrs["scene_toml_given"] = scene.source_text
    return Computed(tree, record)


def _take_up(work: Work, started: str, resume: bool) -> Loaded:
    """Return what is known before the first path: the initial stiffness, and what checkpoints hold."""
    checkpoints, loaded = work.checkpoints, Loaded()
    if checkpoints is not None:
        checkpoints.identity, checkpoints.environment = _identity(work), environment_of(work.newton.solver.backend)
        loaded = checkpoints.load() if resume else loaded
        work.warnings += differences(loaded.environments, checkpoints.environment)
    if loaded.newest is not None:
        work.go_on_from(loaded.newest.meta["cost"])
        work.resumed.append({"at_utc": started, "from": loaded.place})
        work.warnings += [f"checkpoint {text}; what it held is computed again" for text in loaded.damaged]
    if loaded.shared is None:
        about = {"started_utc": started, "harmonics": work.scene.mesh.harmonics}
        loaded.shared = Saved(about, {"stiffness": _initial_stiffness(work)})
        if checkpoints is not None:
            with work.clock.phase("checkpoint"):
                checkpoints.begin(loaded.shared, anew=not resume)
    work.stiffness = loaded.shared.arrays["stiffness"]
    return loaded


def _identity(work: Work) -> dict[str, str]:
    """Return the properties, by name, that must be the same for an interrupted run to go on."""
    return {
        "mesh": work.scene.mesh.preset,
        "linear solver": work.newton.solver.backend.name,
        "version of pysprings": version.__version__,
        "engine": f"sha256 {engine_digest()}",
        "scene": scene_identity(work.scene.sha256),
    }


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


def _prepare(scene: Scene, clock: Clock, progress: Progress) -> Work:
    progress("model", 0.0, "mesh")
    with clock.phase("mesh"):
        try:
            built = build(scene)
        except FEError as error:
            raise refused("mesh", str(error)) from error
    with clock.phase("set-up"):
        try:
            engine = make_engine(scene, built, clock)
        except LinearSolverError as error:
            raise ResourceError(str(error)) from error
    unknowns = engine.system.pattern.n_unknowns + built.model.n_border
    progress("model", 1.0, f"{built.model.mesh.n_nodes} nodes, {unknowns} unknowns")
    remarks = [*domain_effect(scene).remarks, *penalty_of(scene).remarks, *fast_paths(scene, built.model.mesh)]
    return Work(scene, built, engine.system, engine.newton, clock, progress, warnings=remarks)


def _initial_stiffness(work: Work) -> np.ndarray:
    """Return the tangent stiffness (3, 3) of half the caisson at the initial state; undrained where there is water."""
    work.system.time_step, work.system.sealed = undrained_time(work.scene, work.built.model.mesh), True
    try:
        return symmetric_but_for_rounding(work.newton.border_stiffness(State(work.built.model)))
    except FEError as error:
        raise RunIncomplete(f"the stiffness of the initial state cannot be computed: {error}") from error
    finally:
        work.system.sealed = False


def symmetric_but_for_rounding(stiffness: np.ndarray) -> np.ndarray:
    """Return the symmetric part of a stiffness (3, 3) that differs from it by rounding alone; others as they are.

    At rest contact sticks and the soil is elastic: what is not symmetric is what the linear solver leaves.
    """
    mean: np.ndarray = 0.5 * (stiffness + stiffness.T)
    size = np.sqrt(np.abs(np.diag(mean)))
    rounding = bool((np.abs(stiffness - mean) <= _ROUNDING * np.outer(size, size)).all())
    return mean if rounding else stiffness


def _run_paths(work: Work, loaded: Loaded) -> None:
    """Run every path that has not ended; the one on its way goes on from where it stood."""
    paths = work.scene.load_paths
    for number, path in enumerate(paths):
        run = PathRun(work, path)
        ended, state = loaded.paths.get(path.name), loaded.state
        if ended is not None:
            run.restore(ended)
            _keep(work, run)
            continue
        if state is not None and state.meta["path"] == path.name:
            run.restore(state)
        work.state = run.state
        try:
            run.run()
        finally:
            if run.collector.rows:
                _keep(work, run)
        work.condition = work.newton.condition_estimate() if number == len(paths) - 1 else None
        run.save_end(number)


def _parts(path: Path) -> dict[str, int]:
    """Return attributes on the parts of a path after its first one; none where there are none."""
    pairs = {PAIRS: 1} if any(then.second is not None for then in path.then) else {}
    return {PARTS: len(path.then)} | pairs if path.then else {}


def _keep(work: Work, run: PathRun) -> None:
    """Add a path, whole or as far as it went, to the result."""
    path, driver, name = run.path, run.driver, run.path.name
    with work.clock.phase("output"):
        dataset = run.collector.dataset()
        dataset.attrs = {
            "kind": path.kind, "arm_m": path.arm, "role": path.role, "status": str(run.ending.status),
            "heave": path.heave,
        } | end_attrs(run.ending.reason, run.ending.why, dataset)  # fmt: skip
        if path.rate is not None:
            dataset.attrs["rate_m_per_s"] = path.rate
        if path.arm_from is not None:
            dataset.attrs["arm_from_m"] = path.arm_from
        if driver.given_up and (viscous := viscous_displacement(work.scene, path)) is not None:
            dataset.attrs["viscous_displacement_m"] = viscous
        dataset.attrs |= _parts(path)
        if path.load_angle is not None:
            dataset.attrs["load_angle_rad"] = path.load_angle
        work.paths[f"/paths/{name}"] = dataset
        work.paths[f"/paths/{name}/convergence"] = convergence_dataset(driver.record)
        figures = summarise(driver.record, [cut_back(*attempt) for attempt in driver.given_up], dataset, run.limits)
        at_limit = run.ending.status is Status.LIMIT_LOAD
        work.figures[name] = replace(
            figures, status=run.ending.status, reason=run.ending.reason, energy=energy_summary(run.energy.now()),
            limit_load=LimitLoad.at(figures.end, run.ending.why) if at_limit else None,
        )  # fmt: skip
        work.failures += [run.ending.failure] if run.ending.failure else []
        u, w, turn = (float(np.abs(dataset[key].values).max()) for key in ("u", "w", "rotation"))
        if large := large_motion(name, max(u, w), turn, work.scene.caisson.skirt_length):
            work.warnings.append(large)
        if run.collector.cavitation is not None:
            length, margin = work.scene.caisson.skirt_length, run.collector.cavitation
            work.warnings.append(cavitation_warning(name, dataset, length, margin))
