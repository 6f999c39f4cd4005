# SPDX-License-Identifier: MIT
"""The capacity in one direction, from the load-displacement curve of a probe of the full model; the runs of a study.

Each run has a folder of its own: ended runs stay, interrupted ones are resumed.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from pysprings.core.arrays import Array
from pysprings.core.errors import RunIncomplete
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.core.progress import Progress
from pysprings.core.storage import read_tree
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, run_tasks
from pysprings.full_model.accuracy.own_estimate import PHASE, estimates_by_default
from pysprings.full_model.diagnosis import DisplacementLimit
from pysprings.full_model.run_record import RunRecord
from pysprings.model.forecast.resources import jobs_for, size_of
from pysprings.model.forecast.run_time import seconds
from pysprings.results.exporters.tables import IN_SPACE
from pysprings.scene.model import Scene
from pysprings.springs.path_ends import FEWEST, steps_before_cavitation
from pysprings.studies.capacity.plan import PROBE, Direction, Group, Request
from pysprings.studies.stored_runs import Whole, has_ended, record_of, run_folder, why_stopped


@dataclass(frozen=True, eq=False)
class Capacity:
    """What a study has shown.

    scene, request : what was asked for.
    table : a row a direction, vertical load and strength (SI).
    cases : utilisation of the load cases; None without cases.
    remarks : sentences on runs that stopped, and on springs that are missing.
    """

    scene: Scene
    request: Request
    table: pd.DataFrame
    cases: pd.DataFrame | None
    remarks: tuple[str, ...]


PEAK = 1e-3  # share by which the largest load is above the last one, at the least
# What fails is seen over this share of the conjugate displacement at least. The last steps of a probe that localisation
# stops are smaller by orders of magnitude, and their load is flat or falls without a failure.
SEEN = 0.01
PLATEAU = 0.02  # growth of the load over that of the conjugate displacement, both relative, below which it is a plateau


class Criterion(StrEnum):
    """What makes a load the capacity."""

    PEAK = "peak"
    PLATEAU = "plateau"
    MOTION = "displacement limit"
    NONE = "stopped before failure"


@dataclass(frozen=True)
class Point:
    """The largest load of a probe of the full model and its state (SI).

    direction : of the load (`Request.all_directions`).
    size : of the load [N] in the direction, R.
    H, V, M, T, u, w, rotation, twist : at the largest load, in the plane of H.
    rest_load : V [N] at the start; the vertical load of a probe is met to the tolerance of the solver.
    criterion : what makes it the capacity; where it is `Criterion.NONE`, the capacity is larger.
    growth : relative growth of the load over that of the conjugate displacement over the last steps, `SEEN` of
        it at least; 1 in a linear response.
    moved : share of the limit of motion at the largest load.
    why : reason of a probe that stopped.
    mesh_error : estimate of the error of the load that the mesh makes [%]; NaN without one.
    """

    direction: Direction
    size: float
    rest_load: float
    H: float
    V: float
    M: float
    T: float
    u: float
    w: float
    rotation: float
    twist: float
    criterion: Criterion
    growth: float
    moved: float
    why: str = ""
    mesh_error: float = np.nan

    @property
    def is_capacity(self) -> bool:
        """True where the probe came to failure."""
        return self.criterion is not Criterion.NONE


SPACE = {column: (*MOTIONS, *LOADS).index(name) for column, name in IN_SPACE.items() if name in (*MOTIONS, *LOADS)}
CAVITATES = "the water would cavitate beyond this load"
_MET = 1e-6  # the limit is met to rounding where it is imposed
# Columns of a probe without torsion, and where they stand among (u_x, u_y, w, rot_x, rot_y, rot_z, H_x ... T)
PLANE = {"u_m": 0, "w_m": 2, "rotation_rad": 4, "H_N": 6, "V_N": 8, "M_Nm": 10}


def point_of(folder: Path, record: RunRecord | None, scene: Scene, direction: Direction) -> Point | None:
    """Return the capacity of a probe that ended in a folder, before its water would cavitate; None without a step."""
    file = folder / "load_displacement.csv"
    if record is None or not file.exists():
        return None
    frame = pd.read_csv(file)
    frame = frame[frame["converged"] == 1]
    if len(frame) < 2:
        return None
    why, (ends, error) = "; ".join(record.failures), (record.paths.get(PROBE), record.error_estimate or {})
    at_limit = ends is not None and ends.reason is StopReason.DISPLACEMENT_LIMIT
    if scene.drainage.water_depth is not None and (count := _steps_before_cavitation(folder)) < len(frame):
        frame, why, at_limit = frame.iloc[: max(count, FEWEST)], CAVITATES, False
    states = np.zeros((len(frame), 12))
    for name, column in (PLANE if "u_m" in frame else SPACE).items():
        states[:, column] = frame[name]
    known = error.get("by_path", {}).get(PROBE, {}).get("load_pct", np.nan)
    return assess(states, scene, direction, why, at_limit, float(known))


def _steps_before_cavitation(folder: Path) -> int:
    """Return the number of converged steps of a probe before its water would cavitate."""
    tree = read_tree(folder / "full_model.nc")
    path = next(tree[group][PROBE] for group in ("paths", "space") if group in tree.children).to_dataset()
    return steps_before_cavitation(path.isel(step=path["converged"].values == 1))


def along_load(direction: Direction, diameter: float) -> Array:
    """Return (H, M, T) (3,) of a load of size 1 in a direction, with the diameter [m]."""
    a, b = direction
    return np.array([np.cos(b) * np.cos(a), diameter * np.cos(b) * np.sin(a), diameter * np.sin(b)])


def assess(
    states: Array, scene: Scene, direction: Direction, why: str = "", at_limit: bool = False,
    mesh_error: float = np.nan,
) -> Point:  # fmt: skip
    """Return the capacity from states (n, 12) = (u_x ... rot_z, H_x ... T) in SI, the initial one first.

    H acts along x. A load with torsion moves the caisson across, too, which counts in the limit of motion.
    ``at_limit``: the run ended at that limit, from which extrapolated motions may be off. A fall within the error of
    the mesh (%) is no peak.
    """
    limit, rest = DisplacementLimit.of(scene, float(states[0, 2])), float(states[0, 8])
    moved = np.array([limit.share(state[:6]) for state in states])
    diameter = scene.caisson.outer_diameter
    along = along_load(direction, diameter)
    over = np.flatnonzero(moved >= 1.0 - _MET)
    ended = bool(over.size) or at_limit
    if over.size:  # the state at the limit itself, between the last two
        last = int(over[0])
        share = (1.0 - moved[last - 1]) / (moved[last] - moved[last - 1])
        edge = states[last - 1] + share * (states[last] - states[last - 1])
        states = np.vstack([states[:last], edge])
        moved = np.append(moved[:last], 1.0)
    path, sizes = states[:, [0, 4, 5]] @ along, [1.0, diameter, diameter]
    load = states[:, [6, 10, 11]] / sizes @ along_load(direction, 1.0)
    before = int(np.flatnonzero(path <= (1.0 - SEEN) * path[-1])[-1])
    growth = float((load[-1] - load[before]) / (path[-1] - path[before]) * path[-1] / load[-1])
    best = int(np.argmax(load))
    if load[best] > (1.0 + np.fmax(PEAK, 0.01 * mesh_error)) * load[-1] and path[best] <= (1.0 - SEEN) * path[-1]:
        criterion = Criterion.PEAK
    elif growth < PLATEAU:
        criterion = Criterion.PLATEAU
    else:
        criterion = Criterion.MOTION if ended else Criterion.NONE
    u, w, rotation, twist, H, V, M, T = states[best, [0, 2, 4, 5, 6, 8, 10, 11]].tolist()
    share, why = float(moved[best]), "" if ended else why
    return Point(
        direction, float(load[best]), rest, H, V, M, T, u, w, rotation, twist, criterion, growth, share, why,
        mesh_error,
    )  # fmt: skip


SMALL_STEPS = {"max_step_fraction": 0.01, "first_step_fraction": None}


@dataclass(frozen=True)
class Planned:
    """A run of the study: its name, scene, group; the direction of a probe, None for rays; whether it has an estimate.

    That is one of the error of its mesh, from a coarser one: series are extrapolated with it.
    """

    name: str
    scene: Scene
    group: Group
    direction: Direction | None
    estimated: bool

    def has_ended(self, out: Path) -> bool:
        """Return whether a folder below ``out`` holds this run, with its estimate where it has one."""
        folder = run_folder(out, self.name)
        if not has_ended(folder, self.scene):
            return False
        record = record_of(folder, self.scene)
        made = record is not None and record.error_estimate is not None and PHASE not in record.not_made
        return made or not self.estimated

    def with_small_steps(self) -> Planned:
        """Return the run with steps of 1 % of the path at most."""
        return replace(self, name=f"{self.name}-small-steps", scene=self.scene.replace(solver=SMALL_STEPS))


@dataclass(frozen=True)
class Ended:
    """A run as it ended: its folder, and why it did not reach its end, if so."""

    planned: Planned
    folder: Path
    why: str

    @cached_property
    def point(self) -> Point | None:
        """Capacity of a probe; None of rays, or where nothing converged."""
        if self.planned.direction is None:
            return None
        record = record_of(self.folder, self.planned.scene)
        return point_of(self.folder, record, self.planned.scene, self.planned.direction)

    @property
    def failed(self) -> bool:
        """Whether a probe did not come to failure."""
        return self.planned.direction is not None and (self.point is None or not self.point.is_capacity)

    @property
    def overloaded(self) -> bool:
        """Whether a probe stopped under its vertical load, before the push: no direction has a capacity there."""
        record = record_of(self.folder, self.planned.scene)
        path = None if record is None else record.paths.get(PROBE)
        if path is None or not self.failed:
            return False
        return path.reason is StopReason.DEAD_LOAD or path.increments == (path.increments_of_dead_load or -1)


def planned(groups: Iterable[Group], request: Request) -> list[Planned]:
    """Return the runs of a study in their order."""
    runs = []
    for group in groups:
        own = estimates_by_default(group.scene) if request.estimate is None else request.estimate
        for each in request.all_directions:
            runs.append(Planned(group.probe_name(each), group.probe(each), group, each, own))
        if request.rays:
            runs.append(Planned(f"{group.name}-rays", group.rays(), group, None, own))
    return runs


def run_all(runs: Sequence[Planned], out: Path, report: Progress, jobs: int | None = 1) -> list[Ended]:
    """Run what has not ended below a folder. KeyboardInterrupt passes through: the same call goes on.

    A probe that stops before failure is run once more with small steps, and the further one counts. Where a vertical
    load is not carried, the other runs of its group are left out. ``jobs`` are worker processes (None: the cores).
    """
    weights = {each.name: seconds(each.scene, size_of(each.scene).unknowns) for each in runs}
    whole = Whole(weights, report)
    missing = {each.name for each in runs if not each.has_ended(out)}
    ended: dict[str, Ended] = {}

    def done(task: Task, answer: Ended | Exception) -> None:
        if isinstance(answer, Exception):
            raise answer
        ended[task.name] = answer
        whole.ended(task.name, task.name in missing)

    firsts = {each.group.name: each for each in reversed(runs)}  # one of each group shows whether its load is carried
    for batch in (list(firsts.values()), [each for each in runs if each is not firsts[each.group.name]]):
        overloaded = {each.planned.group.name for each in ended.values() if each.overloaded}
        carried = [each for each in batch if each.group.name not in overloaded]
        tasks = []
        for each in carried:
            shown = whole.of(each.name, [path.name for path in each.scene.load_paths])
            tasks.append(Task(each.name, carry_out, (each, out), weights[each.name], shown))
        run_tasks(tasks, jobs_for(runs[0].scene, jobs, [task.cost for task in tasks]), done)
    return [ended[each.name] for each in runs if each.name in ended]


def carry_out(planned: Planned, out: Path, progress: Progress) -> Ended:
    """Run one, and once more with small steps where it stops before failure; return the one that went further."""
    done = _run(planned, out, progress)
    if not done.failed or (done.point is not None and done.point.why == CAVITATES):  # smaller steps change nothing
        return done
    small = _run(
        planned.with_small_steps(),
        out,
        lambda _, fraction, text: progress("small steps", fraction, f"small steps, {text}"),
    )
    if done.point is None or (small.point is not None and small.point.moved > done.point.moved):
        return small
    return done


def _run(each: Planned, out: Path, progress: Progress) -> Ended:
    """Run one scene into its folder, unless it has ended there."""
    from pysprings.results.folder import run_or_go_on

    folder = run_folder(out, each.name)
    if not each.has_ended(out):
        with warnings.catch_warnings(action="ignore"), suppress(RunIncomplete):  # its record has them
            run_or_go_on(each.scene, folder, progress, estimate_error=each.estimated)
    return Ended(each, folder, why_stopped(record_of(folder, each.scene)))
