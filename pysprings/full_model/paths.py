# SPDX-License-Identifier: MIT
"""The load paths of a run: one after the other in this process, or in worker processes; the result is the same.

A path on its way (`PathRun`): its state, the stages that drive it, the rows it gathers, its checkpoints.
"""

import math
import time
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from pathlib import Path as FilePath
from traceback import extract_tb

import numpy as np
import xarray as xr

from fe_engine.balance.energy import Energy, EnergyBalance
from fe_engine.balance.water import WaterBalance
from fe_engine.clock import Clock
from fe_engine.errors import NotConverged
from fe_engine.model import Stage
from fe_engine.solve.stepping import Driver, Position, Step
from fe_engine.state import FIELDS, State, initial_fields
from pysprings.core.errors import PyspringsError, out_of_memory, reason_of
from pysprings.core.path_kinds import MOTIONS, PAIRS, PARTS, PATH_KINDS
from pysprings.core.process import blas_on_one_thread
from pysprings.core.progress import Progress
from pysprings.core.variables import DOFS
from pysprings.core.words import Diagnosis, StopReason
from pysprings.core.workers import Task, WorkerDied, Workers
from pysprings.full_model import checkpoint
from pysprings.full_model.cavitation import warning as cavitation_warning
from pysprings.full_model.checkpoint import Checkpoints, Cost, Gathered, Loaded, Saved, Standing
from pysprings.full_model.diagnosis import DisplacementLimit, diagnose, during_dead_load, too_far
from pysprings.full_model.record import DEAD_LOAD, convergence_dataset, cut_back, energy_summary, summarise
from pysprings.full_model.run_record import COMPLETE, Ending, LimitLoad, Status
from pysprings.full_model.work import Work, make_collector, prepare
from pysprings.model.forecast.resources import size_of
from pysprings.model.forecast.run_time import path_seconds
from pysprings.model.stages import dead_load_stage, large_motion, path_stages, viscous_displacement
from pysprings.model.water import undrained_time
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path
from pysprings.springs.path_ends import end_attrs

# A vertical path has come to its limit load where an increment fails and dV/dw is less than this share of that at rest.
# Beyond, contact under the lid opens and closes from step to step, and V changes by 1 % at the most.
FLAT = 0.01
_STILL = 1.0e-12  # m: a motion of rounding


class PathRun:
    """Runs one path from the initial state, or from where a checkpoint left it."""

    def __init__(self, work: Work, path: Path) -> None:
        self.work, self.path, self.on = work, path, work.model_of(path)
        scene, model = work.scene, self.on.built.model
        self.state = State(model)
        self.on.newton.forget()  # whichever paths ran before
        self.driver = Driver(self.on.newton, self.state)
        self.water = None
        if model.water is not None:
            self.water = WaterBalance(self.on.system, initial_fields(model))
        self.energy = EnergyBalance(self.on.system)
        water = scene.drainage  # whose suction is checked against cavitation where the depth of the sea is known
        sea = None if water.water_depth is None else (water.water_unit_weight, water.water_depth)
        self.collector = make_collector(scene, self.on, self.water, sea)
        self.extra = self.on.built.extra_load_of(scene.vertical_load_of(path))
        self.n_dead, self.stage, self.time = int(self.extra != 0.0), 0, 0.0
        self.n_stages = self.n_dead + len(self._path_stages(0.0))
        self.limits: list[str] = []
        self.reach: DisplacementLimit | None = None  # of a path that leads to failure
        self.ending = Ending()
        self._position: Position | None = None  # where to go on in the stage
        self._last: tuple[Standing, Gathered] | None = None  # after the last step, unless it is in a checkpoint
        self._number = [each.name for each in scene.all_paths].index(path.name)
        self._saved_at, self._before = time.monotonic(), work.cost()

    def run(self) -> None:
        """Run to the end, or up to where a step does not converge: see `ending`.

        KeyboardInterrupt and MemoryError pass through, once the last converged step is in a checkpoint.
        """
        try:
            self._run_stages()
            self.ending = COMPLETE
        except NotConverged as error:
            why, reason = self._why(error)
            self.ending = (
                Ending(Status.LIMIT_LOAD, reason, why)
                if reason.is_limit
                else Ending(Status.PARTIAL, reason, why, self._failure(why))
            )
            if not self.collector.rows:  # the dead load itself: the state that it reached is kept, marked
                self._collect(converged=False)
        except PyspringsError:
            raise
        except (KeyboardInterrupt, MemoryError):
            with suppress(MemoryError):  # no room to pack it: the checkpoint before it stays
                self._save_last()
            raise
        except Exception as error:  # it costs no other path
            last = extract_tb(error.__traceback__)[-1]
            where = f"{FilePath(last.filename).name}, line {last.lineno}"
            why = f"{StopReason.ERROR}: {reason_of(error)} ({where}); please report it"
            self.ending = Ending(Status.PARTIAL, StopReason.ERROR, why, self._failure(why))

    def _run_stages(self) -> None:
        if self.stage < self.n_dead:
            self._under_dead_load()
        if not self.collector.rows:
            self._collect()
        rest = float(self.collector.rows[0]["w"])
        stages = self._path_stages(rest)
        kind = PATH_KINDS[self.path.kind]
        if kind.drives == "w":
            self.driver.failed = self._end_where_flat
        if kind.limited:
            self.reach = DisplacementLimit.of(self.work.scene, rest)
            self.driver.refusal = self.reach.refusal
        while self.stage < self.n_stages:
            self._run_stage(stages[self.stage - self.n_dead])

    def _under_dead_load(self) -> None:
        """Apply the dead load, or take up what another path with the same load has left on this model."""
        known, key = self.work.under_dead_load, (self.path.in_space, self.extra)
        if self._position is None and key in known:
            cost = self._take_up(deepcopy(known[key]))
            self.work.add(cost.of_solver)  # as if this path had run it, in whichever process
        self._run_stage(dead_load_stage(self.extra, MOTIONS if self.path.in_space else DOFS))
        if key not in known:
            known[key] = replace(self._standing(), stage=0).saved(self.gathered())

    def _run_stage(self, stage: Stage) -> None:
        self.driver.run(stage, self._on_step, self._position)
        self._position = None
        self.stage += 1

    def _path_stages(self, rest: float) -> list[Stage]:
        """Return the stages after the dead load, which has moved the caisson by ``rest`` (m, down)."""
        scene = self.work.scene
        built = self.on.built
        fast = undrained_time(scene, built.model.mesh)
        return path_stages(scene, self.path, self.extra, fast, rest=rest, balanced=built.balanced_load)

    def _on_step(self, step: Step) -> None:
        with self.work.clock.phase("output"):
            self.energy.advance(self.state.committed, step.increment.residual.border)
        if self.water is not None:
            self.water.advance(self.state.committed, step.time_step)
        self.limits.append(step.limit)
        at = self.stage - self.n_dead
        if at >= 0:
            self.time += step.time_step
            self._collect()
            self._refuse_flight()
        self._checkpoint()
        if at < 0:
            self.work.progress(self.path.name, 0.0, DEAD_LOAD)
            return
        message = f"step {len(self.collector.rows) - 1}, {step.increment.iterations} iterations"
        self.work.progress(self.path.name, (at + step.fraction) / (self.n_stages - self.n_dead), message)

    def _collect(self, converged: bool = True) -> None:
        with self.work.clock.phase("output"):
            self.collector.add(self.state.committed, self.time, converged)

    def _refuse_flight(self) -> None:
        """Stop a path that leads to failure where the caisson leaves."""
        border = self.state.committed.border
        if self.reach is not None and self.reach.share(border) > 1.0:
            raise _Ended(too_far(self.driver, self.on.stiffness, self.reach.text(border)))

    def _end_where_flat(self) -> None:
        """Stop a vertical path whose last increment has moved it and hardly changed V; in a rest nothing moves."""
        before, now = self.collector.rows[-2:]
        moved, rest = float(now["w"] - before["w"]), 2.0 * float(self.work.stiffness[1, 1])
        left = float(now["V"] - before["V"]) / (moved * rest) if abs(moved) > _STILL else 1.0
        if left < FLAT:
            detail = f"dV/dw has fallen to {100.0 * max(left, 0.0):.2g} % of that at rest"
            raise _Ended(Diagnosis(StopReason.LIMIT_LOAD, detail))

    def _why(self, error: NotConverged) -> tuple[str, StopReason]:
        """Return why and where the path stopped, in one line that begins with the reason, and the reason."""
        if isinstance(error, _Ended):
            return str(error.diagnosis), error.diagnosis.reason
        if error.refused:
            return str(error), StopReason.DISPLACEMENT_LIMIT
        cause = diagnose(self.driver, self._forced(), self.on.stiffness)
        if self.stage < self.n_dead:
            cause = during_dead_load(cause, self.driver.position)
        elif cause.reason.is_limit and len(self.collector.rows) < 2:
            cause = Diagnosis(StopReason.UNEXPLAINED, f"no increment of the path converged; {cause.detail}")
        return f"{cause} ({error})", cause.reason

    def _forced(self) -> bool:
        """Return whether a given force changes in the present stage."""
        part = self.stage - self.n_stages + len(self.path.then)
        changes_load = part >= 0 and self.path.then[part].load is not None
        return changes_load or self.driver.aim[0] == DEAD_LOAD or PATH_KINDS[self.path.kind].force

    def _failure(self, why: str) -> str:
        """Return one line: which path stopped, on its way to which part of the load, and why."""
        stage, target = self.driver.aim
        if stage == DEAD_LOAD:
            return f"path '{self.path.name}' stopped during its {why}"
        return f"path '{self.path.name}' stopped on its way to {100 * target:.4g} %: {why}"

    # --- saving ---

    def _checkpoint(self) -> None:
        """Store the state of the path, and write a checkpoint if one is due."""
        checkpoints = self.work.checkpoints
        if checkpoints is None:
            return
        with checkpoints.charged(), self.work.clock.phase("checkpoint"):
            self._last = self._standing(), self.gathered()
        if time.monotonic() - self._saved_at >= checkpoint.EVERY:
            self._save_last()

    def _standing(self) -> Standing:
        driver, fields = self.driver, self.state.committed
        assert driver.position is not None
        return Standing(
            self.stage, self.time, {name: getattr(fields, name).copy() for name in FIELDS}, driver.position,
            driver.force, driver.stiffness, self.on.newton.origin, None if self.water is None else self.water.totals,
        )  # fmt: skip

    def gathered(self) -> Gathered:
        """Return what the path has gathered until now, with what that has cost."""
        driver = self.driver
        return Gathered(
            self.path.name, self.ending, list(self.collector.rows), list(driver.record), list(driver.given_up),
            list(self.limits), self.collector.cavitation, self.energy.totals, driver.n_steps,
            self.work.cost().since(self._before),
        )  # fmt: skip

    def _save_last(self) -> None:
        """Write the last step, unless it is in a checkpoint."""
        if self._last is not None:
            standing, gathered = self._last
            self._save(standing.saved(gathered))

    def save_end(self) -> None:
        """Write the path, which has ended."""
        if self.work.checkpoints is not None:
            self._save(self.gathered().saved())

    def _save(self, saved: Saved) -> None:
        checkpoints = self.work.checkpoints
        assert checkpoints is not None
        with self.work.clock.phase("checkpoint"):
            checkpoints.save_path(self._number, saved)
        self._last, self._saved_at = None, time.monotonic()

    # --- going on ---

    def restore(self, saved: Saved) -> None:
        """Take up what a checkpoint holds: a path that has ended, or where one stood; count what it has cost."""
        self.work.add(self._take_up(saved))

    def _take_up(self, saved: Saved) -> Cost:
        """Go on from what a checkpoint holds; return what that has cost."""
        driver, gathered, standing = self.driver, Gathered.of(saved), Standing.of(saved)
        self.collector.rows, self.collector.cavitation = gathered.rows, gathered.cavitation
        self.ending, self.limits = gathered.ending, gathered.limits
        driver.record, driver.given_up, driver.n_steps = gathered.record, gathered.given_up, gathered.n_steps
        if standing is not None:
            self._restore(standing)
        self.energy.go_on_from(self.state.committed, *gathered.energy)
        return gathered.cost

    def _restore(self, standing: Standing) -> None:
        for name in FIELDS:
            getattr(self.state.committed, name)[...] = standing.fields[name]
        self.stage, self.time, self._position = standing.stage, standing.time, standing.position
        self.driver.position = standing.position
        self.driver.stiffness, self.driver.force = standing.stiffness, standing.force
        if self.water is not None:
            self.water.totals = standing.water
        if standing.factors is not None:
            self.on.newton.restore(standing.factors)


class _Ended(NotConverged):
    """The path is at its end: beyond the limit of motions under a given load, or where V does not change any more."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        super().__init__(str(diagnosis))
        self.diagnosis = diagnosis


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
    saved = None if checkpoints is None else checkpoints.path(number)
    if saved is not None and "stage" not in saved.meta:
        return saved  # a worker died after it had saved the end
    with blas_on_one_thread():
        work = _work_of(scene.sha256, scene)
        path = scene.all_paths[number]
        work.progress, work.checkpoints = progress, checkpoints
        work.stiffness, work.torsion = rest
        work.cpu_elsewhere, work.cpu_began = 0.0, time.process_time()
        run = PathRun(work, path)
        work.cpu_began = _counted[0]  # the model, and the modules before the first path
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
        if path.load_angle is not None and not path.in_space:
            dataset.attrs["load_lever_m"] = work.scene.caisson.outer_diameter * math.sin(path.load_angle)
        optional = {
            "direction_rad": path.direction, "rate_m_per_s": path.rate, "arm_from_m": path.arm_from,
            "viscous_displacement_m": viscous_displacement(work.scene, path) if run.given_up else None,
            PARTS: len(path.then) or None, PAIRS: 1 if any(then.second is not None for then in path.then) else None,
            "load_angle_rad": path.load_angle, "torsion_angle_rad": path.torsion_angle,
        }  # fmt: skip
        dataset.attrs |= {key: value for key, value in optional.items() if value is not None}
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
