# SPDX-License-Identifier: MIT
"""Adds to a result the estimate of its own discretisation error: runs the coarser mesh and sets both side by side.

It comes after the result, which is kept however this ends. A Fourier series is run on the coarser mesh with N and with
N + 2 harmonics, N growing by two until both agree: where that asks for more than the result has, the scene runs again.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from fe_engine.clock import Clock
from pysprings.core.errors import RunIncomplete, UserInputError, reason_of
from pysprings.core.words import StopReason
from pysprings.full_model.accuracy import presets, two_mesh
from pysprings.full_model.accuracy.presets import FOURIER
from pysprings.full_model.record import Meter
from pysprings.full_model.run_record import Computed
from pysprings.springs.path import paths_of

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.core.progress import Progress
    from pysprings.full_model.checkpoint import Checkpoints
    from pysprings.scene.load import Scene

Compute = Callable[..., Computed]
PHASE = "error estimate"  # also its name among the parts of a run that were not made
# %: difference of load and p(y) between N and N + 2 harmonics below which N are enough. The section's own error is far
# larger on the coarser presets (docs/evidence/accuracy.md).
ENOUGH = {"coarse": 2.0, "medium": 1.0}
ENOUGH_ELSE = 0.5
MOST = 9  # harmonics that are tried


@dataclass
class Companions:
    """Runs on the coarser mesh by number of harmonics (None: bricks), or why there are none; what they cost.

    Attributes
    ----------
    harmonics : the number that was chosen.
    stopped : by path why it stopped on the coarser mesh.
    again : True where the reason passes, and another attempt may succeed.
    checkpoints : of the run that they stand beside.
    """

    trees: dict[int | None, xr.DataTree] = field(default_factory=dict)
    harmonics: int | None = None
    why_not: str = ""
    stopped: dict[str, str] = field(default_factory=dict)
    again: bool = False
    clock: Clock = field(default_factory=Clock)
    checkpoints: Checkpoints | None = None

    def count_elsewhere(self, seconds: float) -> None:
        """Add CPU seconds of worker processes, and of earlier parts of a run that goes on."""
        self.clock.cpu[PHASE] = self.clock.cpu.get(PHASE, 0.0) + max(seconds, 0.0)

    def failed(self, error: BaseException) -> None:
        """Note the error that ended the companions or what was made of them."""
        self.again = not isinstance(error, RunIncomplete | UserInputError)
        interrupted = isinstance(error, KeyboardInterrupt)
        self.why_not = (
            str(StopReason.INTERRUPTED) if interrupted else f"the run on the coarser mesh failed: {reason_of(error)}"
        )


def estimates_by_default(scene: Scene) -> bool:
    """Return whether runs of a scene estimate their error by default: a series costs little.

    Paths that leave a plane have no estimate.
    """
    return scene.discretisation == FOURIER and bool(scene.load_paths)


def companions_of(
    scene: Scene,
    compute: Compute,
    progress: Progress | None = None,
    chosen: int | None = None,
    checkpoints: Checkpoints | None = None,
) -> Companions:
    """Run a scene on its coarser mesh; of a Fourier series, choose the number of harmonics that it needs.

    ``compute`` runs a scene (`full_model.compute`), and goes on from ``checkpoints`` beside those of the scene's own
    run. A run that goes on keeps the number that was ``chosen`` when it began. Nothing is raised: without a run the
    companions have the reason.
    """
    companions = Companions(checkpoints=checkpoints)
    with companions.clock.phase(PHASE):
        try:
            coarse = two_mesh.coarser(scene) if scene.load_paths else scene
            if not scene.load_paths:
                companions.why_not = "no path stays in one plane"
            elif coarse is scene:
                companions.why_not = "there is no coarser mesh than this one"
            elif scene.discretisation == FOURIER:
                _choose(scene, coarse, companions, lambda each, n: _run(each, n, companions, compute, progress), chosen)
            else:
                _run(coarse, None, companions, compute, progress)
        except (Exception, KeyboardInterrupt) as error:
            companions.failed(error)
    return companions


def _choose(
    scene: Scene, coarse: Scene, companions: Companions, run: Callable[[Scene, int], bool], chosen: int | None
) -> None:
    """Raise the harmonics on the coarser mesh until two more of them change little."""
    from pysprings.model.fourier import section_counts_of

    n = chosen or section_counts_of(scene).harmonics
    while run(coarse.replace(mesh={"harmonics": n}), n):
        companions.harmonics = n
        if not run(coarse.replace(mesh={"harmonics": n + 2}), n + 2):
            return
        change = two_mesh.difference(companions.trees[n + 2], companions.trees[n]) or {}
        most = ENOUGH.get(scene.mesh.preset, ENOUGH_ELSE)
        enough = not any(change.get(name, 0.0) > most for name in two_mesh.DECISIVE)  # NaN: not on these paths
        if enough or chosen or scene.mesh.harmonics is not None or n + 2 > MOST:
            return
        n += 2


def _run(scene: Scene, key: int | None, companions: Companions, compute: Compute, progress: Progress | None) -> bool:
    """Run a scene on the coarser mesh and keep its result; return whether there is one."""
    if key in companions.trees:
        return True
    beside = "" if key is None else f", {key} harmonics"
    report = (
        None if progress is None else (lambda at, share, text: progress(f"coarser mesh{beside}, {at}", share, text))
    )
    saved = companions.checkpoints
    kept = {} if saved is None else {"checkpoints": saved.companion(str(key or "bricks")), "resume": None}
    before = time.process_time()
    coarse = compute(scene, progress=report, **kept)
    companions.count_elsewhere(coarse.record.cpu_s - (time.process_time() - before))
    if coarse.record.stopped_by is not None:
        companions.why_not, companions.again = str(coarse.record.stopped_by), True
        return False
    companions.stopped |= {
        name: str(path.reason or path.status) for name, path in coarse.record.paths.items() if path.reason is not None
    }
    companions.trees[key] = coarse.tree
    return True


def with_estimate(scene: Scene, result: Computed, companions: Companions, again: Callable[[int], Computed]) -> Computed:
    """Put the estimate into the record of a result; return it, or that of ``again`` where N is too small.

    ``again`` runs the scene with more harmonics. Where that run does not come as far, the first result stays, and its
    record has the reason.
    """
    add_estimate(scene, result, companions)
    more, had = companions.harmonics, result.record.mesh.harmonics
    if more is None or had is None or more <= had or companions.again:
        return result
    name, before = f"run with {more} harmonics", result.record
    try:
        richer = again(more)
    except Exception as error:
        before.not_made[name] = reason_of(error)
        return result
    if richer.interrupted:
        before.not_made[name] = str(richer.record.stopped_by)
        return result
    if before.complete and not richer.record.complete:
        why = "; ".join(richer.record.failures)
        before.warnings.append(f"the {name}, which the coarser mesh asks for, stopped: {why}")
        return result
    record = richer.record
    record.phases[f"run with {had} harmonics"] = {"wall_s": before.wall_s, "cpu_s": before.cpu_s}
    record.wall_s, record.cpu_s = record.wall_s + before.wall_s, record.cpu_s + before.cpu_s
    add_estimate(scene, richer, companions)
    return richer


def add_estimate(scene: Scene, result: Computed, companions: Companions) -> None:
    """Put the estimate and its cost into the record of a result of ``scene`` (the one that ran).

    The result stays as it is, and nothing is raised; without an estimate the record has the reason.
    """
    meter, record = Meter(), result.record
    with meter.clock.phase(PHASE):
        try:
            record.error_estimate = _estimate(scene, result, companions)
        except (Exception, KeyboardInterrupt) as error:
            companions.failed(error)
            record.error_estimate = two_mesh.missing(companions.why_not)
    if companions.again:
        record.not_made[PHASE] = companions.why_not
    meter.include(companions.clock)
    companions.clock = Clock()
    meter.charge(record)


def _estimate(scene: Scene, result: Computed, companions: Companions) -> dict[str, Any]:
    n = result.record.mesh.harmonics
    if n not in companions.trees:
        return two_mesh.missing(companions.why_not or "no run on the coarser mesh has its number of harmonics")
    orders = presets.orders(scene.discretisation)
    richer = None if n is None else companions.trees.get(n + 2)
    ratio = two_mesh.cell_ratio(scene, two_mesh.coarser(scene))
    estimate = two_mesh.estimate(result.tree, companions.trees[n], orders, richer, ratio)
    if companions.stopped and estimate["estimate_pct"]:
        estimate |= {"companion_stopped": companions.stopped, "companion_paths": len(paths_of(companions.trees[n]))}
    return estimate
