# SPDX-License-Identifier: MIT
"""Adds to a result the estimate of its own discretisation error: runs the coarser mesh and sets both side by side.

It comes after the result, which is kept however this ends. A Fourier series is run on the coarser mesh with N and, a
few paths of it, with N + 2 harmonics. Where both differ, all paths are run with N + 2, and the difference is added to
the result's reactions; what that leaves may ask for more harmonics, and the scene runs again. Its paths are
extrapolated from both meshes, vertical ones in sand from elements halved at the tip (see `extrapolation`).
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import xarray as xr

from fe_engine.clock import Clock
from pysprings.core.errors import RunIncomplete, UserInputError, reason_of
from pysprings.core.progress import Progress
from pysprings.core.words import StopReason
from pysprings.full_model.accuracy import two_mesh
from pysprings.full_model.accuracy.extrapolation import Beside, extrapolated, has_equal_motion, share_of
from pysprings.full_model.accuracy.presets import FOURIER
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.record import Meter
from pysprings.full_model.run_record import Computed
from pysprings.model.fourier_mesh import COHESIVE, FRICTIONAL, ground_of_sections
from pysprings.scene.model import Scene
from pysprings.scene.sections import MOST_HALVINGS, Path
from pysprings.springs.path import paths_of, space_paths_of
from pysprings.springs.path_ends import MESH_ERROR

# Collapse loads of clay fall more slowly with the cells than those of sand (data/evidence/sections.csv).
ORDERS = {FRICTIONAL: 2.0, COHESIVE: 1.7}
# Below it extrapolation left up to three times the error of the own mesh (data/evidence/extrapolation-below-coarse.csv)
FINE_ENOUGH = 1.0  # refinement of a preset
TOO_COARSE = f"reactions of one mesh: below refinement {FINE_ENOUGH:g} extrapolation from two may triple their error"
LEAST_RATIO = 1.6  # of the cells: closer meshes would multiply what is not of the mesh, such as tolerances and steps

Compute = Callable[..., Computed]
PHASE = "error estimate"  # also its name among the parts of a run that were not made
# %: what N harmonics may leave of load and p(y); above half of it the difference of N and N + 2 is added. The section's
# own error is far larger on the coarser presets (docs/evidence/accuracy.md).
ENOUGH = {"coarse": 2.0, "medium": 1.0}
ENOUGH_ELSE = 0.5
MOST = 9  # harmonics that are tried
# Wall time of the runs beside over that of the run itself, and what they have always [s]
LONGEST, AT_LEAST = 5.0, 300.0
# Share of the run itself of all time, and of each run beside it of the time that is left
SHARE, NEXT = 0.6, 0.6
TOO_LONG = f"it took more than {LONGEST:g} times the run itself, and 5 minutes"


@dataclass
class Companions:
    """Runs on the coarser mesh by number of harmonics (None: bricks), or why there are none; what they cost.

    trees, richer : whole runs, and runs with two harmonics more.
    halved : that of `vertical_paths` with smaller elements beside the tip, of one harmonic.
    harmonics : the number that was chosen.
    stopped : by path why it stopped on the coarser mesh.
    again : True where the reason passes, and another attempt may succeed.
    checkpoints : of the run that they stand beside.
    done : share of all work that is done, for the progress.
    until : when they are given up [s], of `time.monotonic`; late : whether that is over.
    """

    trees: dict[int | None, xr.DataTree] = field(default_factory=dict)
    richer: dict[int | None, xr.DataTree] = field(default_factory=dict)
    halved: dict[int | None, xr.DataTree] = field(default_factory=dict)
    harmonics: int | None = None
    why_not: str = ""
    stopped: dict[str, str] = field(default_factory=dict)
    again: bool = False
    clock: Clock = field(default_factory=Clock)
    checkpoints: Checkpoints | None = None
    done: float = SHARE
    until: float = math.inf

    def count_elsewhere(self, seconds: float) -> None:
        """Add CPU seconds of worker processes, and of earlier parts of a run that goes on."""
        self.clock.cpu[PHASE] = self.clock.cpu.get(PHASE, 0.0) + max(seconds, 0.0)

    def failed(self, error: BaseException) -> None:
        """Note the error that ended the companions or what was made of them."""
        self.again = not isinstance(error, RunIncomplete | UserInputError)
        interrupted = isinstance(error, KeyboardInterrupt)
        self.why_not = (
            self.stopped_by(str(StopReason.INTERRUPTED))
            if interrupted
            else f"the run on the coarser mesh failed: {reason_of(error)}"
        )

    def stopped_by(self, reason: str) -> str:
        """Return the reason of a stop, or that it was for its time."""
        return TOO_LONG if self.late else reason

    @property
    def late(self) -> bool:
        return time.monotonic() > self.until


def estimates_by_default(scene: Scene) -> bool:
    """Return whether runs of a scene estimate their error by default: a series costs little."""
    return scene.discretisation == FOURIER


def companions_of(
    scene: Scene,
    compute: Compute,
    progress: Progress | None = None,
    chosen: int | None = None,
    checkpoints: Checkpoints | None = None,
    until: float = math.inf,
) -> Companions:
    """Run a scene on its coarser mesh; of a Fourier series, choose the number of harmonics that it needs.

    ``compute`` runs a scene (`full_model.compute`), and goes on from ``checkpoints`` beside those of the scene's own
    run. A run that goes on keeps the number that was ``chosen`` when it began. They are given up at a time ``until``
    [s] of `time.monotonic`. Nothing is raised: without a run the companions have the reason.
    """
    companions = Companions(checkpoints=checkpoints, until=until)
    with companions.clock.phase(PHASE):
        try:
            coarse = two_mesh.coarser(scene)
            if coarse is scene:
                companions.why_not = "there is no coarser mesh than this one"
            elif scene.discretisation == FOURIER:
                run = partial(_run, companions, compute, progress)
                _choose(scene, coarse, companions, run, chosen)
                if paths := vertical_paths(scene):
                    mesh = {"harmonics": 1, "halvings": scene.mesh.halvings + 1}
                    beside = two_mesh.with_paths(scene, paths, mesh=mesh, output=two_mesh.NO_OUTPUT)
                    run(beside, 1, companions.halved)
            else:
                _run(companions, compute, progress, coarse, None, companions.trees)
        except (Exception, KeyboardInterrupt) as error:
            companions.failed(error)
    return companions


def _choose(
    scene: Scene, coarse: Scene, companions: Companions,
    run: Callable[[Scene, int, dict[int | None, xr.DataTree]], bool], chosen: int | None,
) -> None:  # fmt: skip
    """Raise the harmonics on the coarser mesh until two more of them change little."""
    from pysprings.model.fourier import section_counts_of

    n, few = chosen or section_counts_of(scene).harmonics, two_mesh.few(coarse)
    most = ENOUGH.get(scene.mesh.preset, ENOUGH_ELSE)
    while n in companions.trees or run(coarse.replace(mesh={"harmonics": n}), n, companions.trees):
        companions.harmonics = n
        richer = {"mesh": {"harmonics": n + 2}}
        if not run(few.replace(**richer), n + 2, companions.richer):
            return
        enough = max(_changes(companions, n), default=0.0) <= two_mesh.LEFT * most
        known = _names(companions.richer[n + 2]) | {path.name for path in vertical_paths(scene)}
        rest = tuple(path for path in coarse.all_paths if path.name not in known and not enough)
        if rest and not run(two_mesh.with_paths(coarse, rest, **richer), n + 2, companions.richer):
            return
        enough = enough or max(_changes(companions, n, two_mesh.LEFT), default=0.0) <= most
        if enough or chosen or scene.mesh.harmonics is not None or n + 2 > MOST:
            return
        n += 2
        companions.trees[n] = companions.richer[n]


def vertical_paths(scene: Scene) -> tuple[Path, ...]:
    """Return the paths that push or pull a caisson in sand vertically, where their elements can be halved once more."""
    judged = ground_of_sections(scene) == FRICTIONAL and scene.mesh.halvings < MOST_HALVINGS
    return tuple(path for path in scene.all_paths if judged and path.kind == "vertical")


def _names(tree: xr.DataTree) -> set[str]:
    return {*paths_of(tree), *space_paths_of(tree)}


def _changes(companions: Companions, n: int, left: float = 1.0) -> list[float]:
    """Return what two harmonics more than n change [%], the share ``left`` of it where adding it to a path helps."""
    richer = companions.richer[n + 2]
    helps = {name for name, path in paths_of(richer).items() if has_equal_motion(path)}
    return [
        each[name] * (left if path in helps else 1.0)
        for path, each in two_mesh.differences(richer, companions.trees[n]).items()
        for name in two_mesh.DECISIVE
        if math.isfinite(each.get(name, math.nan))
    ]


def _run(
    companions: Companions, compute: Compute, progress: Progress | None,
    scene: Scene, key: int | None, into: dict[int | None, xr.DataTree],
) -> bool:  # fmt: skip
    """Run a scene on another mesh than its own and keep its result; return whether there is one."""
    beside = "coarser mesh" if key is None else f"coarser mesh, {key} harmonics"
    beside = "elements halved at the tip" if into is companions.halved else beside

    def report(at: str, share: float, text: str) -> None:
        if companions.late:
            raise KeyboardInterrupt  # as Ctrl-C: checkpoints have what it did
        if progress is not None:
            progress(f"{beside}, {at}", share, text)

    saved = companions.checkpoints
    name = f"{key or 'bricks'}" + ("" if into is companions.trees else "rest" if key in into else "few")
    kept = {} if saved is None else {"checkpoints": saved.companion(name), "resume": None}
    before = time.process_time()
    begun, companions.done = companions.done, companions.done + NEXT * (1.0 - companions.done)
    coarse = compute(scene, progress=report, span=(begun, companions.done), **kept)
    companions.count_elsewhere(coarse.record.cpu_s - (time.process_time() - before))
    if coarse.record.stopped_by is not None:
        companions.why_not, companions.again = companions.stopped_by(str(coarse.record.stopped_by)), True
        return False
    companions.stopped |= {
        name: str(path.reason or path.status) for name, path in coarse.record.paths.items() if path.reason is not None
    }
    into[key] = _joined(into[key], coarse.tree) if key in into else coarse.tree
    return True


def _joined(tree: xr.DataTree, more: xr.DataTree) -> xr.DataTree:
    """Return a result with the paths of another run of its mesh."""
    joined = tree.copy(deep=False)
    for group in ("paths", "space"):
        for name, path in more.children[group].children.items() if group in more.children else ():
            joined[f"{group}/{name}"] = path.copy(deep=False)
    return joined


def with_estimate(
    scene: Scene, result: Computed, companions: Companions, again: Callable[[int, Computed], Computed]
) -> Computed:
    """Return a result with its estimate and extrapolated paths, or that of ``again`` where N is too small.

    ``again`` runs the scene with more harmonics, and keeps the estimated result until that has ended. Where that run
    does not come as far, the first result stays, and its record has the reason.
    """
    estimated = add_estimate(scene, result, companions)
    more, had = companions.harmonics, result.record.mesh.harmonics
    if more is None or had is None or more <= had or companions.again:
        return estimated
    name, before = f"run with {more} harmonics", result.record
    try:
        richer = again(more, estimated)
    except Exception as error:
        before.not_made[name] = reason_of(error)
        return estimated
    if richer.interrupted:
        before.not_made[name] = str(richer.record.stopped_by)
        return estimated
    if before.complete and not richer.record.complete:
        why = "; ".join(richer.record.failures)
        before.warnings.append(f"the {name}, which the coarser mesh asks for, stopped: {why}")
        return estimated
    record = richer.record
    record.phases[f"run with {had} harmonics"] = {"wall_s": before.wall_s, "cpu_s": before.cpu_s}
    record.wall_s, record.cpu_s = record.wall_s + before.wall_s, record.cpu_s + before.cpu_s
    return add_estimate(scene, richer, companions)


def add_estimate(scene: Scene, result: Computed, companions: Companions) -> Computed:
    """Return a result of ``scene`` (the one that ran) with its estimate, cost, and extrapolated paths.

    Nothing is raised; without an estimate the record has the reason, and the paths are those of its mesh.
    """
    meter, record = Meter(), result.record
    with meter.clock.phase(PHASE):
        try:
            result = _estimated(scene, result, companions)
        except (Exception, KeyboardInterrupt) as error:
            companions.failed(error)
            record.error_estimate = two_mesh.missing(companions.why_not)
    if companions.again:
        record.not_made[PHASE] = companions.why_not
    meter.include(companions.clock)
    companions.clock = Clock()
    meter.charge(record)
    return result


def _estimated(scene: Scene, result: Computed, companions: Companions) -> Computed:
    n, record = result.record.mesh.harmonics, result.record
    alone = n is not None and companions.again and n + 2 not in companions.richer  # without the share of the harmonics
    if n not in companions.trees or alone:
        record.error_estimate = two_mesh.missing(
            companions.why_not or "no run on the coarser mesh has its number of harmonics"
        )
        return result
    coarse, made = companions.trees[n], result
    ratio = two_mesh.cell_ratio(scene, two_mesh.coarser(scene))
    given: dict[str, Any] = {"ratio": ratio, "richer": None if n is None else companions.richer.get(n + 2)}
    if ratio is not None and ratio > LEAST_RATIO and scene.mesh.refinement < FINE_ENOUGH:
        record.remarks.append(TOO_COARSE)
    elif ratio is not None and ratio > LEAST_RATIO:
        richer = given["richer"]
        vertical = {path.name for path in vertical_paths(scene)}  # axisymmetric
        whole = richer is not None and _names(coarse) - vertical <= _names(richer)  # a fan is corrected as a whole
        halved = companions.halved.get(1)
        made, given["extrapolated"] = _extrapolated(
            scene, result, Beside(coarse, richer if whole else None, halved), ratio
        )
        changes = {} if halved is None else two_mesh.differences(result.tree, halved)
        given["near"] = {name: each for name, each in changes.items() if name in given["extrapolated"]["halved"]}
    estimate = two_mesh.estimate(result.tree, coarse, **given)
    covered = given.get("extrapolated", {}).get("paths", ())
    stopped = {name: why for name, why in companions.stopped.items() if name not in covered}
    if stopped and estimate["estimate_pct"]:
        all_paths = {**paths_of(coarse), **space_paths_of(coarse)}
        estimate |= {"companion_stopped": stopped, "companion_paths": len(all_paths)}
    record.error_estimate = estimate
    by_path = estimate.get("by_path", {})
    for name in paths_of(made.tree) if made is not result else ():
        if name in by_path:
            made.tree[f"paths/{name}"].attrs[MESH_ERROR] = by_path[name].get("load_pct", float("nan"))
    return made


def _extrapolated(scene: Scene, result: Computed, beside: Beside, ratio: float) -> tuple[Computed, dict[str, Any]]:
    """Return a result with extrapolated paths, and how they were extrapolated, as run.json has it."""
    order, richer = ORDERS[ground_of_sections(scene)], beside.richer
    share = share_of(ratio, order)
    found = extrapolated(result.tree, beside, share)
    tree, not_alike, record = found.tree, found.not_alike, result.record
    paths = paths_of(tree)
    names = [name for name in paths if name not in not_alike]
    if names:
        sizes = " and ".join(f"{each.attrs['n_unknowns']:,}" for each in (tree, beside.coarse))
        record.remarks.append(f"reactions extrapolated from meshes of {sizes} unknowns (order {order:g})")
    corrected = [] if richer is None else [n for n in names if n not in {*found.without, *found.halved}]
    if found.halved:
        record.remarks.append(f"reactions of {', '.join(found.halved)} extrapolated from elements halved at the tip")
    if corrected and richer is not None:
        record.remarks.append(f"reactions with what {richer.attrs['harmonics']} harmonics change on the coarser mesh")
    record.remarks += [f"path {name} is without it: {why}" for name, why in found.without.items()]
    record.remarks += [f"path {name} has the reactions of one mesh: {why}" for name, why in not_alike.items()]
    tree.attrs["remarks"] = "; ".join(record.remarks)
    for name in names:
        record.paths[name] = record.paths[name].ending_at(paths[name].dataset)
    how: dict[str, Any] = {
        "order": order,
        "share": round(share, 4),
        "paths": names,
        "halved": found.halved,
        "one_mesh": not_alike,
        "left": two_mesh.left_in(scene),
        "least": {} if scene.ground.total_stress else two_mesh.LEAST_IN_SAND,
    }
    if corrected:
        how["harmonics_added"] = corrected
    return replace(result, tree=tree), how
