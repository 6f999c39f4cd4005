# SPDX-License-Identifier: MIT
"""The runs of a capacity study, each in a folder of its own: ended runs stay, interrupted ones are resumed."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.errors import RunIncomplete
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, run_tasks
from pysprings.model.forecast.resources import jobs_for, size_of
from pysprings.model.forecast.run_time import seconds
from pysprings.studies.capacity.plan import PROBE, Group, Request, angles
from pysprings.studies.capacity.points import Point, point_of
from pysprings.studies.stored_runs import Whole, forget, has_ended, record_of, run_folder, why_stopped

if TYPE_CHECKING:
    from pysprings.core.progress import Progress
    from pysprings.scene.model import Scene

SMALL_STEPS = {"max_step_fraction": 0.01, "first_step_fraction": None}


@dataclass(frozen=True)
class Planned:
    """A run of the study: its name, scene, group; the direction [rad] of a probe, None for rays."""

    name: str
    scene: Scene
    group: Group
    angle: float | None

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
        if self.planned.angle is None:
            return None
        record = record_of(self.folder, self.planned.scene)
        return point_of(self.folder, record, self.planned.scene, self.planned.angle)

    @property
    def failed(self) -> bool:
        """Whether a probe did not come to failure."""
        return self.planned.angle is not None and (self.point is None or not self.point.is_capacity)

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
        runs += [Planned(group.probe_name(a), group.probe(a), group, a) for a in angles(request.directions)]
        if request.rays:
            runs.append(Planned(group.rays_name, group.rays(), group, None))
    return runs


def run_all(runs: Sequence[Planned], out: Path, report: Progress, jobs: int | None = 1) -> list[Ended]:
    """Run what has not ended below a folder. KeyboardInterrupt passes through: the same call goes on.

    A probe that stops before failure is run once more with small steps, and the further one counts. Where a vertical
    load is not carried, the other runs of its group are left out. ``jobs`` are worker processes (None: the cores).
    """
    weights = {each.name: seconds(each.scene, size_of(each.scene).unknowns) for each in runs}
    whole = Whole(weights, report)
    missing = {each.name for each in runs if not has_ended(run_folder(out, each.name), each.scene)}
    ended: dict[str, Ended] = {}

    def done(task: Task, answer: Ended | Exception) -> None:
        if isinstance(answer, Exception):
            raise answer
        ended[task.name] = answer
        whole.ended(task.name, task.name in missing)

    firsts = {each.group.name: each for each in reversed(runs)}  # one of each group shows whether its load is carried
    for batch in (list(firsts.values()), [each for each in runs if each is not firsts[each.group.name]]):
        carried = [each for each in batch if not _overloaded(each.group, ended.values())]
        tasks = [_task(each, out, weights[each.name], whole) for each in carried]
        run_tasks(tasks, jobs_for(runs[0].scene, jobs, [task.cost for task in tasks]), done)
    return [ended[each.name] for each in runs if each.name in ended]


def _overloaded(group: Group, ended: Iterable[Ended]) -> bool:
    return any(each.overloaded for each in ended if each.planned.group.name == group.name)


def _task(planned: Planned, out: Path, cost: float, whole: Whole) -> Task:
    paths = [path.name for path in planned.scene.load_paths]
    return Task(planned.name, carry_out, (planned, out), cost, whole.of(planned.name, paths))


def carry_out(planned: Planned, out: Path, progress: Progress) -> Ended:
    """Run one, and once more with small steps where it stops before failure."""
    done = _run(planned, out, progress)
    if not done.failed:
        return done
    small = _run(
        planned.with_small_steps(),
        out,
        lambda _, fraction, text: progress("small steps", fraction, f"small steps, {text}"),
    )
    return _further(done, small)


def _run(each: Planned, out: Path, progress: Progress) -> Ended:
    """Run one scene into its folder, unless it has ended there."""
    from pysprings.results.folder import run_or_go_on

    folder = run_folder(out, each.name)
    if not has_ended(folder, each.scene):
        with warnings.catch_warnings(), suppress(RunIncomplete):  # the record has the reason, and the warnings
            warnings.simplefilter("ignore")
            run_or_go_on(each.scene, folder, progress)
    return Ended(each, folder, why_stopped(record_of(folder, each.scene)))


def _further(first: Ended, second: Ended) -> Ended:
    """Return the probe that carried the larger load."""
    if first.point is None or (second.point is not None and second.point.moved > first.point.moved):
        return second
    return first


def forget_all(runs: Sequence[Planned], out: Path) -> None:
    """Mark every run to be repeated; results stay until there are new ones."""
    for each in runs:
        for name in (each.name, each.with_small_steps().name):
            if run_folder(out, name).exists():
                forget(run_folder(out, name))
