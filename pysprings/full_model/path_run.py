# SPDX-License-Identifier: MIT
"""One path of the full model on its way: its state, what drives it, what it has gathered, and how it is saved."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.balance.energy import EnergyBalance
from fe_engine.balance.water import WaterBalance
from fe_engine.clock import Clock
from fe_engine.errors import NotConverged
from fe_engine.linear.preconditioner import Origin
from fe_engine.model import Stage
from fe_engine.solve.newton import Newton
from fe_engine.solve.step_size import StepSize
from fe_engine.solve.stepping import Driver, Position, Step
from fe_engine.state import FIELDS, State, initial_fields
from pysprings.core.progress import Progress
from pysprings.core.stop_reasons import Diagnosis, StopReason
from pysprings.full_model.cavitation import Margin
from pysprings.full_model.checkpoint import Checkpoints, Saved
from pysprings.full_model.diagnosis import diagnose, too_far
from pysprings.full_model.discretise import make_collector
from pysprings.full_model.displacement_limit import DisplacementLimit
from pysprings.full_model.record import DEAD_LOAD
from pysprings.model.build import Built
from pysprings.model.fourier import BuiltFourier
from pysprings.model.stages import dead_load_stage, path_stages
from pysprings.model.water import undrained_time

if TYPE_CHECKING:
    from pysprings.scene.load import Path, Scene

_FIELD, _ROW, _LAST, _FACTORS = "field/", "row/", "last/", "factors/"  # names of arrays in a checkpoint


@dataclass
class Work:
    """What the paths of one run share, and what has been computed so far."""

    scene: Scene
    built: Built | BuiltFourier
    system: System | FourierSystem
    newton: Newton
    clock: Clock
    progress: Progress
    checkpoints: Checkpoints | None = None
    paths: dict[str, xr.Dataset] = field(default_factory=dict)
    summaries: dict[str, dict[str, Any]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    stopped: str = ""  # why the run ended before its paths did
    condition: float | None = None  # estimate of the last matrix's
    stiffness: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))  # of half the caisson, at the initial state
    resumed: list[dict[str, str]] = field(default_factory=list)
    state: State | None = None  # of the path that ran last

    def cost(self) -> dict[str, Any]:
        """What the run has cost so far, as a checkpoint keeps it."""
        assert self.checkpoints is not None
        solver = self.newton.solver
        return {
            "phases": {"wall": self.clock.wall, "cpu": self.clock.cpu},
            "solver": [solver.n_factorisations, solver.n_solves, solver.worst_residual],
            "condition": self.condition,
            "checkpoints": [self.checkpoints.written, self.checkpoints.spent],
            "resumed": self.resumed,
        } | self.checkpoints.elapsed()

    def go_on_from(self, cost: dict[str, Any]) -> None:
        """Count on from the cost of the parts of a run before this one."""
        assert self.checkpoints is not None
        solver = self.newton.solver
        for name, before in cost["phases"].items():
            mine: dict[str, float] = getattr(self.clock, name)
            for phase, seconds in before.items():
                mine[phase] = mine.get(phase, 0.0) + seconds
        solver.n_factorisations += cost["solver"][0]
        solver.n_solves += cost["solver"][1]
        solver.worst_residual = max(solver.worst_residual, cost["solver"][2])
        self.checkpoints.go_on_from(cost["wall_s"], cost["cpu_s"], *cost["checkpoints"])
        self.condition, self.resumed = cost["condition"], cost["resumed"]


@dataclass(frozen=True)
class _Standing:
    """Where a path stood after a step: copies of what changes, and how long each list was."""

    fields: dict[str, np.ndarray]
    meta: dict[str, Any]
    position: Position
    force: np.ndarray | None
    factors: Origin | None
    rows: int
    record: int
    given_up: int
    limits: int


class PathRun:
    """Runs one path from the initial state, or from where a checkpoint left it."""

    def __init__(self, work: Work, path: Path) -> None:
        scene, model = work.scene, work.built.model
        self.work, self.path = work, path
        self.state = State(model)
        work.newton.forget()  # whichever paths ran before
        self.driver = Driver(work.newton, self.state)
        self.water = None
        if isinstance(work.system, System) and model.water is not None:
            self.water = WaterBalance(work.system, initial_fields(model))
        self.energy = EnergyBalance(work.system)
        self.collector = make_collector(scene, work.built, work.system, self.water, _sea(scene))
        self.extra = work.built.extra_load_of(scene.vertical_load_of(path))
        self.n_dead, self.stage, self.time = int(self.extra != 0.0), 0, 0.0
        self.n_stages = self.n_dead + len(self._path_stages(0.0))
        self.limits: list[str] = []
        self.reach: DisplacementLimit | None = None  # of a path under a given load
        # until it has ended
        self.status, self.failure, self.why = "interrupted", "", "interrupted"
        self.reason: StopReason | None = StopReason.INTERRUPTED
        self._position: Position | None = None  # where to go on in the stage
        self._standing: _Standing | None = None  # after the last step, unless it is in a checkpoint

    def run(self) -> None:
        """Run to the end, or up to where a step does not converge; `status` and `failure` say which.

        KeyboardInterrupt and MemoryError pass through, once the last converged step is in a checkpoint.
        """
        try:
            self._run_stages()
            self.status, self.why, self.reason = "complete", "", None
        except NotConverged as error:
            self.status, (self.why, self.reason) = "partial", self._why(error)
            self.failure = self._failure(self.why)
            if not self.collector.rows:  # the dead load itself: the state that it reached is kept, marked
                self._collect(converged=False)
        except (KeyboardInterrupt, MemoryError):
            with suppress(MemoryError):  # no room to pack it: the checkpoint before it stays
                self._save_standing()
            raise

    def _run_stages(self) -> None:
        if self.stage < self.n_dead:
            self._run_stage(dead_load_stage(self.extra))
        if not self.collector.rows:
            self._collect()
        rest = float(self.collector.rows[0]["w"])
        stages = self._path_stages(rest)
        if self.path.kind == "load":
            caisson = self.work.scene.caisson
            self.reach = DisplacementLimit(caisson.outer_diameter, caisson.skirt_length, rest)
            self.driver.refusal = self.reach.refusal
        while self.stage < self.n_stages:
            self._run_stage(stages[self.stage - self.n_dead])

    def _run_stage(self, stage: Stage) -> None:
        self.driver.run(stage, self._on_step, self._position)
        self._position = None
        self.stage += 1

    def _path_stages(self, rest: float) -> list[Stage]:
        """Stages after the dead load, which has moved the caisson by ``rest`` (m, down)."""
        scene = self.work.scene
        fast = undrained_time(scene, self.work.built.model.mesh)
        return path_stages(scene, self.path, self.extra, fast, rest=rest)

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
        """Stop a path under a given load where the caisson leaves."""
        border = self.state.committed.border
        if self.reach is not None and self.reach.share(border) > 1.0:
            raise _MovedTooFar(too_far(self.driver, self.work.stiffness, self.reach.text(border)))

    def _why(self, error: NotConverged) -> tuple[str, StopReason]:
        """Why the path stopped, and where in the model, in one line that begins with the reason; the reason."""
        if isinstance(error, _MovedTooFar):
            return str(error.diagnosis), error.diagnosis.reason
        if error.refused:
            return str(error), StopReason.DISPLACEMENT_LIMIT
        forced = self.driver.aim[0] == DEAD_LOAD or self.path.kind == "load"
        found = diagnose(self.driver, forced, self.work.stiffness)
        return f"{found} ({error})", found.reason

    def _failure(self, why: str) -> str:
        """One line: which path stopped, on its way to which part of the load, and why."""
        stage, target = self.driver.aim
        of = " of its dead load" if stage == DEAD_LOAD else ""
        return f"path '{self.path.name}' stopped on its way to {100 * target:.4g} %{of}: {why}"

    # --- saving ---

    def _checkpoint(self) -> None:
        """Remember where the path stands, and write it where that is due."""
        checkpoints = self.work.checkpoints
        if checkpoints is None:
            return
        with checkpoints.charged(), self.work.clock.phase("checkpoint"):
            self._standing = self._stands()
        if checkpoints.is_due():
            self._save_standing()

    def _stands(self) -> _Standing:
        driver, found, position = self.driver, self.collector.cavitation, self.driver.position
        assert position is not None
        meta = {
            "stage": self.stage, "time": self.time, "n_steps": driver.n_steps,
            "cavitation": None if found is None else [found[0], asdict(found[1])],
            "water": None if self.water is None else self.water.totals,
            "stiffness": driver.stiffness, "energy": self.energy.totals,
        }  # fmt: skip
        fields = {name: getattr(self.state.committed, name).copy() for name in FIELDS}
        counts = len(self.collector.rows), len(driver.record), len(driver.given_up), len(self.limits)
        return _Standing(fields, meta, position, driver.force, self.work.newton.origin, *counts)

    def _save_standing(self) -> None:
        """Write the last step that is not in a checkpoint yet."""
        standing, checkpoints = self._standing, self.work.checkpoints
        if checkpoints is None or standing is None:
            return
        with self.work.clock.phase("checkpoint"):
            at = standing.position
            meta = standing.meta | {"start": at.start, "done": at.done, "next": asdict(at.next)}
            arrays = {_FIELD + name: value for name, value in standing.fields.items()}
            if standing.force is not None:
                meta["force"] = standing.force
            if at.last is not None:
                meta["last_size"] = at.last[0]
                arrays |= {_LAST + "free": at.last[1], _LAST + "border": at.last[2]}
            if standing.factors is not None:
                arrays |= {_FACTORS + name: value for name, value in vars(standing.factors).items()}
            gathered = self._gathered(standing.rows, standing.record, standing.given_up, standing.limits)
            checkpoints.save_state(Saved(gathered.meta | meta, gathered.arrays | arrays))
        self._standing = None

    def save_end(self, number: int) -> None:
        """Write a path that has ended, as the one of that number."""
        if self.work.checkpoints is None:
            return
        found = self.collector.cavitation
        meta = {
            "cavitation": None if found is None else [found[0], asdict(found[1])], "energy": self.energy.totals,
            "n_steps": self.driver.n_steps,
        }  # fmt: skip
        with self.work.clock.phase("checkpoint"):
            gathered = self._gathered(None, None, None, None)
            self.work.checkpoints.save_path(number, Saved(gathered.meta | meta, gathered.arrays))

    def _gathered(self, rows: int | None, record: int | None, given_up: int | None, limits: int | None) -> Saved:
        """The first so many rows, iterations, failed attempts and limits; None for all."""
        kept, driver = self.collector.rows[:rows], self.driver
        failed = [(stage, fraction, _recorded(error)) for stage, fraction, error in driver.given_up[:given_up]]
        meta = {
            "path": self.path.name, "status": self.status, "failure": self.failure,
            "why": self.why, "reason": self.reason,
            "cost": self.work.cost(), "n_rows": len(kept), "record": driver.record[:record], "given_up": failed,
            "limits": self.limits[:limits],
        }  # fmt: skip
        names = kept[0] if kept else {}
        return Saved(meta, {_ROW + name: np.array([row[name] for row in kept]) for name in names})

    # --- going on ---

    def restore(self, saved: Saved) -> None:
        """Take up what a checkpoint holds: a path that has ended, or where one stood."""
        meta, driver = saved.meta, self.driver
        columns = {name.removeprefix(_ROW): a for name, a in saved.arrays.items() if name.startswith(_ROW)}
        self.collector.rows = [{name: a[k] for name, a in columns.items()} for k in range(meta["n_rows"])]
        if meta["cavitation"] is not None:
            u, margin = meta["cavitation"]
            self.collector.cavitation = u, Margin(margin["margin"], margin["pressure"], tuple(margin["place"]))
        driver.record, self.limits = meta["record"], meta["limits"]
        driver.given_up = [(stage, fraction, NotConverged(**error)) for stage, fraction, error in meta["given_up"]]
        driver.n_steps = meta["n_steps"]
        self.status, self.failure, self.why = meta["status"], meta["failure"], meta["why"]
        self.reason = None if meta["reason"] is None else StopReason(meta["reason"])
        if "stage" in meta:
            self._restore_standing(saved)
        self.energy.go_on_from(self.state.committed, *meta["energy"])

    def _restore_standing(self, saved: Saved) -> None:
        meta, arrays, driver = saved.meta, saved.arrays, self.driver
        for name in FIELDS:
            getattr(self.state.committed, name)[...] = arrays[_FIELD + name]
        self.stage, self.time = meta["stage"], meta["time"]
        driver.stiffness = meta["stiffness"]
        driver.force = np.array(meta["force"]) if "force" in meta else None
        if self.water is not None:
            self.water.totals = tuple(meta["water"])
        position = Position(np.array(meta["start"]), meta["done"], StepSize(**meta["next"]))
        if "last_size" in meta:
            last = meta["last_size"], arrays[_LAST + "free"], arrays[_LAST + "border"]
            position = replace(position, last=last)
        self._position = position
        factors = {name.removeprefix(_FACTORS): a for name, a in arrays.items() if name.startswith(_FACTORS)}
        if factors:
            self.work.newton.restore(Origin(**factors))


class _MovedTooFar(NotConverged):
    """The caisson has moved beyond the limit under a given load."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        super().__init__(str(diagnosis))
        self.diagnosis = diagnosis


def _recorded(error: NotConverged) -> dict[str, Any]:
    """A failed attempt as the record and checkpoints keep it."""
    return {"reason": error.reason, "place": error.place, "history": error.history}


def _sea(scene: Scene) -> tuple[float, float] | None:
    """Unit weight (N/m3) and depth (m) of the sea, where suction is checked against cavitation."""
    drainage = scene.drainage
    return None if drainage.water_depth is None else (drainage.water_unit_weight, drainage.water_depth)
