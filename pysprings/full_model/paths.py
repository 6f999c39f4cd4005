# SPDX-License-Identifier: MIT
"""The load paths of a run: one after the other in this process, or in worker processes; the result is the same."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from fe_engine.balance.energy import Energy
from fe_engine.clock import Clock
from pysprings.core.errors import out_of_memory
from pysprings.core.path_kinds import PAIRS, PARTS
from pysprings.core.process import blas_on_one_thread
from pysprings.core.progress import Progress
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, WorkerDied, Workers
from pysprings.full_model.cavitation import warning as cavitation_warning
from pysprings.full_model.checkpoint import Checkpoints, Gathered, Loaded, Saved
from pysprings.full_model.path_run import PathRun
from pysprings.full_model.record import convergence_dataset, cut_back, energy_summary, summarise
from pysprings.full_model.run_record import LimitLoad, Status
from pysprings.full_model.work import Work, make_collector, prepare
from pysprings.model.forecast.resources import size_of
from pysprings.model.forecast.run_time import path_seconds
from pysprings.model.stages import large_motion, viscous_displacement
from pysprings.springs.path_ends import end_attrs

if TYPE_CHECKING:
    from pysprings.scene.model import Scene
    from pysprings.scene.sections import Path


def run_paths(work: Work, loaded: Loaded, workers: Workers | None) -> None:
    """Run every path that has not ended, those on their way from where they stood, and add all of them to the work.

    What is there at an interrupt, or when memory is short, is added as well.
    """
    if workers is not None:
        with_workers(work, loaded, workers)
        return
    for path in work.scene.all_paths:
        saved = loaded.paths.get(path.name)
        if saved is not None and "stage" not in saved.meta:
            _take(work, path, saved)
            continue
        run = PathRun(work, path)
        if saved is not None:
            run.restore(saved)
        work.state = run.state
        try:
            _to_its_end(run)
        finally:
            if run.collector.rows:
                _keep(work, path, run.gathered())


def _to_its_end(run: PathRun) -> None:
    work, path = run.work, run.path
    run.run()
    work.condition = work.newton.condition_estimate() if path.name == work.scene.all_paths[-1].name else None
    run.save_end()


# --- in worker processes ---


def with_workers(work: Work, loaded: Loaded, workers: Workers) -> None:
    """Run paths in worker processes, the longest first."""
    scene = work.scene
    found = {name: saved for name, saved in loaded.paths.items() if "stage" not in saved.meta}
    tasks = [
        Task(name, path_in_worker, (scene, number, (work.stiffness, work.torsion), work.checkpoints), cost)
        for number, (name, cost) in enumerate(path_costs(scene).items())
        if name not in found
    ]

    def done(task: Task, answer: Saved | Exception) -> None:
        if isinstance(answer, Saved):
            found[task.name] = answer
            work.progress(task.name, 1.0, "")
            return
        if not isinstance(answer, MemoryError | WorkerDied):
            raise answer
        work.stopped = StopReason.OUT_OF_MEMORY
        work.failures.append(out_of_memory(answer) if isinstance(answer, MemoryError) else str(answer))

    try:
        workers.run(tasks, done, work.progress, work.warnings.append)
    finally:
        for path in scene.all_paths:
            if path.name in found:
                _take(work, path, found[path.name])


def path_costs(scene: Scene) -> dict[str, float]:
    """Return the likely time of each path, in s, by name."""
    times = path_seconds(scene, size_of(scene).unknowns)
    return {path.name: time for path, time in zip(scene.all_paths, times, strict=True)}


_counted = [0.0]  # CPU seconds of this process that a path has on its account


def path_in_worker(
    scene: Scene, number: int, rest: tuple[np.ndarray, float], checkpoints: Checkpoints | None, progress: Progress
) -> Saved:
    """Run one path, in a process of its own; return what it has gathered, whole or up to an interrupt."""
    with blas_on_one_thread():
        work = _work_of(scene.sha256, scene)
        path = scene.all_paths[number]
        work.progress, work.checkpoints = progress, checkpoints
        work.stiffness, work.torsion = rest
        work.cpu_elsewhere, work.cpu_began = 0.0, time.process_time()
        run = PathRun(work, path)
        work.cpu_began = _counted[0]  # the model, and the modules before the first path
        saved = None if checkpoints is None else checkpoints.path(number)
        if saved is not None:
            run.restore(saved)
        with suppress(KeyboardInterrupt):  # its last step is in the checkpoint, and in what follows
            _to_its_end(run)
        gathered = run.gathered()
        _counted[0] = time.process_time()
        return gathered.saved()


@lru_cache(maxsize=2)
def _work_of(_sha256: str, scene: Scene) -> Work:
    """Return mesh and engine, made once for all paths of a run that come to this process."""
    return prepare(scene, Clock(), lambda *_: None)


# --- what a path adds to the result ---


def _parts(path: Path) -> dict[str, int]:
    """Return attributes on the parts of a path after its first one; none where there are none."""
    pairs = {PAIRS: 1} if any(then.second is not None for then in path.then) else {}
    return {PARTS: len(path.then)} | pairs if path.then else {}


def largest_motion(path: xr.Dataset, radius: float) -> tuple[float, float]:
    """Return the largest displacement (m), that of the wall by a twist (radius, m) included, and rotation (rad)."""
    w = float(np.abs(path["w"].values).max())
    if "u_x" not in path:
        u, turn = (float(np.abs(path[key].values).max()) for key in ("u", "rotation"))
        return max(u, w), turn
    u, turn = (float(np.hypot(path[f"{key}_x"], path[f"{key}_y"]).max()) for key in ("u", "rot"))
    return max(u, w, radius * float(np.abs(path["rot_z"].values).max())), turn


def _take(work: Work, path: Path, saved: Saved) -> None:
    """Add a path that has ended, from its checkpoint or another process, to the result, and what it has cost."""
    gathered = Gathered.of(saved)
    work.add(gathered.cost)
    work.condition = gathered.cost.condition
    if gathered.rows:
        _keep(work, path, gathered)


def _keep(work: Work, path: Path, run: Gathered) -> None:
    """Add a path, whole or as far as it went, to the result."""
    name, on = path.name, work.model_of(path)
    with work.clock.phase("output"):
        collector = make_collector(work.scene, on)
        collector.rows = run.rows
        dataset, group = collector.dataset(), f"/{'space' if path.in_space else 'paths'}/{name}"
        dataset.attrs = {
            "kind": path.kind, "arm_m": path.arm, "role": path.role, "status": str(run.ending.status),
            "heave": path.heave,
        }  # fmt: skip
        if not path.in_space:
            dataset.attrs |= end_attrs(run.ending.reason, run.ending.why, dataset)
        if path.direction is not None:
            dataset.attrs["direction_rad"] = path.direction
        if path.rate is not None:
            dataset.attrs["rate_m_per_s"] = path.rate
        if path.arm_from is not None:
            dataset.attrs["arm_from_m"] = path.arm_from
        if run.given_up and (viscous := viscous_displacement(work.scene, path)) is not None:
            dataset.attrs["viscous_displacement_m"] = viscous
        dataset.attrs |= _parts(path)
        if path.load_angle is not None:
            dataset.attrs["load_angle_rad"] = path.load_angle
        if path.torsion_angle is not None:
            dataset.attrs["torsion_angle_rad"] = path.torsion_angle
        work.paths[group] = dataset
        work.paths[f"{group}/convergence"] = convergence_dataset(run.record)
        figures = summarise(run.record, [cut_back(*attempt) for attempt in run.given_up], dataset, run.limits)
        at_limit = run.ending.status is Status.LIMIT_LOAD
        work.figures[name] = replace(
            figures, status=run.ending.status, reason=run.ending.reason,
            energy=energy_summary(Energy(*map(float, run.energy[0])), on.built.part),
            limit_load=LimitLoad.at(figures.end, run.ending.why) if at_limit else None,
        )  # fmt: skip
        work.failures += [run.ending.failure] if run.ending.failure else []
        moved, turn = largest_motion(dataset, 0.5 * work.scene.caisson.outer_diameter)
        if large := large_motion(name, moved, turn, work.scene.caisson.skirt_length):
            work.warnings.append(large)
        if run.cavitation is not None:
            length = work.scene.caisson.skirt_length
            work.warnings.append(cavitation_warning(name, dataset, length, run.cavitation))
