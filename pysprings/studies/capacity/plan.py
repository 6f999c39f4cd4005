# SPDX-License-Identifier: MIT
"""The runs of a capacity study: probes in directions of the load, and rays for the springs, by V and strength.

Each run has a folder of its own: ended runs stay, interrupted ones are resumed.

Directions are angles in the plane of H and M/D. Springs and full model are odd in a lateral load, so that half of the
plane is enough: from 90 degrees (a moment as by a load above mudline) over 0 (a force at mudline) towards -90.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import RunIncomplete, refused
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, run_tasks
from pysprings.model.forecast.resources import jobs_for, size_of
from pysprings.model.forecast.run_time import seconds
from pysprings.scene.design_strength import StrengthFactors, with_design_strength
from pysprings.scene.model import Scene
from pysprings.studies.capacity.points import Point, point_of
from pysprings.studies.stored_runs import Whole, forget, has_ended, record_of, run_folder, why_stopped

if TYPE_CHECKING:
    from pysprings.core.progress import Progress

CHARACTERISTIC, DESIGN = "characteristic", "design"
FEWEST, MOST = 2, 72
PROBE = "probe"
# Angles of the rays [deg] in the plane of (u, rotation * skirt length). Under a free head the caisson turns about a
# point in the skirt or below it (25 to 80 degrees); there a small change of the motion turns the load by much.
RAYS = (-55.0, -25.0, 0.0, 25.0, 36.0, 44.0, 50.0, 56.0, 62.0, 70.0, 80.0, 90.0)
# Rays reach further than the limit of motion in their direction, so that the states between two rays are in range
_SPARE = 1.02
# Directions that are compared when reaching for the limit between two rays
_BETWEEN = 33
_OUTPUT = {"interface_fields": False, "section": False, "figures": False, "paraview": False}


@dataclass(frozen=True)
class Request:
    """What is asked for: vertical loads [N] or "balanced", number of directions, rays or none, factors on strength."""

    loads: tuple[float | str, ...]
    directions: int = 8
    rays: bool = True
    factors: StrengthFactors = field(default_factory=StrengthFactors)

    def __post_init__(self) -> None:
        if not FEWEST <= self.directions <= MOST:
            raise refused("--directions", f"{self.directions} is not in [{FEWEST}, {MOST}]")


@dataclass(frozen=True)
class Group:
    """Runs at one vertical load (N, or "balanced") and one strength."""

    strength: str
    load: float | str
    scene: Scene

    @property
    def name(self) -> str:
        """Name of the group in folders."""
        load = self.load if isinstance(self.load, str) else f"V{1e-3 * self.load:.6g}kN"
        return f"{self.strength}-{load}"

    def probe_name(self, angle: float) -> str:
        """Return the name of the run in a direction [rad]."""
        return f"{self.name}-{math.degrees(angle):+.4g}deg"

    def probe(self, angle: float) -> Scene:
        """Return the scene that pushes the caisson to failure in a direction [rad]."""
        diameter = self.scene.caisson.outer_diameter
        shift, turn = motion_limit(self.scene)
        reach = shift * abs(math.cos(angle)) + turn * diameter * abs(math.sin(angle))
        path = {"name": PROBE, "kind": PROBE, "load_angle": angle, "lateral_displacement": reach, "role": "held-back"}
        return self._with_paths([path])

    @property
    def rays_name(self) -> str:
        """Name of the run that makes the springs."""
        return f"{self.name}-rays"

    def rays(self) -> Scene:
        """Return the scene with the rays that the springs are made from."""
        length = self.scene.caisson.skirt_length
        degrees = [RAYS[-1] - 180.0, *RAYS, RAYS[0] + 180.0]
        paths = []
        for before, degree, behind in zip(degrees, degrees[1:], degrees[2:], strict=False):
            angle = math.radians(degree)
            rho = self._reach_of_ray(math.radians(before), math.radians(behind))
            u, turn = rho * math.cos(angle), rho * math.sin(angle) / length
            name = f"ray_{'minus_' if degree < 0.0 else ''}{abs(degree):g}"
            if abs(degree) == 90.0:
                paths.append({"name": name, "kind": "rotation", "rotation": turn})
            else:
                moved = {"name": name, "kind": "translation", "lateral_displacement": u}
                paths.append(moved | ({"rotation": turn} if degree else {}))
        return self._with_paths(paths)

    def _reach_of_ray(self, low: float, high: float) -> float:
        """Return rho [m] of a ray, such that no state at the limit of motion between its neighbours is further."""
        return _SPARE * max(self._limit(low + (high - low) * k / (_BETWEEN - 1)) for k in range(_BETWEEN))

    def _limit(self, angle: float) -> float:
        """Return rho [m] at the limit of motion in a direction of (u, rotation * skirt length)."""
        shift, turn = motion_limit(self.scene)
        u, v = math.cos(angle), math.sin(angle)
        lateral = max(abs(u), abs(u - v)) / shift
        return 1.0 / max(lateral, abs(v) / (turn * self.scene.caisson.skirt_length))

    def _with_paths(self, paths: Sequence[dict[str, Any]]) -> Scene:
        loaded = [path | {"vertical_load": self.load} for path in paths]
        return self.scene.replace(paths=loaded, output=_OUTPUT)


def motion_limit(scene: Scene) -> tuple[float, float]:
    """Return the displacement [m] and the rotation [rad] that end a path to failure."""
    limit = scene.limit
    return limit.displacement_over_diameter * scene.caisson.outer_diameter, limit.rotation


def angles(count: int) -> list[float]:
    """Return directions [rad] of half the plane, 90 degrees last."""
    return [math.pi * (k / count - 0.5) for k in range(1, count + 1)]


def groups(scene: Scene, request: Request) -> Iterator[Group]:
    """Yield the groups of a study: every vertical load with the strength of the scene, then with design strength."""
    strengths = [(CHARACTERISTIC, scene)]
    if request.factors != StrengthFactors():
        strengths.append((DESIGN, with_design_strength(scene, request.factors)))
    seen = set()
    for strength, each in strengths:
        for load in request.loads:
            group = Group(strength, load, each)
            if group.name not in seen:
                seen.add(group.name)
                yield group


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
