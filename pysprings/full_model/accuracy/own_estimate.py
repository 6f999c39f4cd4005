# SPDX-License-Identifier: MIT
"""Adds to a result the estimate of its own discretisation error: runs the coarser mesh and sets both side by side.

A Fourier series is run on the coarser mesh before: with N and with N + 2 harmonics, until both agree. The scene then
runs with that N, unless it sets its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from fe_engine.clock import Clock
from pysprings.core.errors import PyspringsError
from pysprings.core.stop_reasons import StopReason
from pysprings.full_model.accuracy import presets, two_mesh
from pysprings.full_model.accuracy.settings import FOURIER
from pysprings.full_model.record import Meter
from pysprings.full_model.run_record import Computed, RunRecord, Status

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.core.progress import Progress
    from pysprings.scene.load import Scene

Compute = Callable[..., Computed]
PHASE = "error estimate"
# %: difference of load and p(y) between N and N + 2 harmonics below which N are enough. The section's own error is far
# larger on the coarser presets (docs/evidence/accuracy.md).
ENOUGH = {"coarse": 2.0, "medium": 1.0}
ENOUGH_ELSE = 0.5
MOST = 9  # harmonics that are tried


@dataclass
class Companions:
    """Runs on the coarser mesh by number of harmonics (None: bricks), or why there are none; what they cost.

    ``harmonics`` is the number that was chosen.
    """

    trees: dict[int | None, xr.DataTree] = field(default_factory=dict)
    harmonics: int | None = None
    why_not: str = ""
    ended: str = ""
    clock: Clock = field(default_factory=Clock)


def estimates_by_default(scene: Scene) -> bool:
    """Return whether runs of a scene estimate their error by default: a series costs little."""
    return scene.discretisation == FOURIER


def companions_of(
    scene: Scene, compute: Compute, progress: Progress | None = None, chosen: int | None = None
) -> Companions:
    """Run a Fourier scene on its coarser mesh, and choose the number of harmonics with which the scene itself is run.

    Bricks have none here: their coarser mesh is run after them (`add_estimate`). A run that goes on keeps the number
    that was ``chosen`` when it began.

    Raises
    ------
    KeyboardInterrupt
        One of the runs was interrupted.
    """
    companions = Companions()
    if scene.discretisation == FOURIER:
        with companions.clock.phase(PHASE):
            _choose(scene, companions, compute, progress, chosen)
    return companions


def _choose(
    scene: Scene, companions: Companions, compute: Compute, progress: Progress | None, chosen: int | None
) -> None:
    """Raise the harmonics on the coarser mesh until two more of them change little."""
    from pysprings.model.fourier import section_counts_of

    coarse = _coarser(scene, companions)
    if coarse is None:
        return
    n = chosen or section_counts_of(scene).harmonics
    while _run(coarse.replace(mesh={"harmonics": n}), n, companions, compute, progress):
        companions.harmonics = n
        if not _run(coarse.replace(mesh={"harmonics": n + 2}), n + 2, companions, compute, progress):
            return
        change = two_mesh.difference(companions.trees[n + 2], companions.trees[n]) or {}
        most = ENOUGH.get(scene.mesh.preset, ENOUGH_ELSE)
        enough = not any(change.get(name, 0.0) > most for name in two_mesh.DECISIVE)  # NaN: not on these paths
        if enough or chosen or scene.mesh.harmonics is not None or n + 2 > MOST:
            return
        n += 2


def _coarser(scene: Scene, companions: Companions) -> Scene | None:
    """Return the scene on its coarser mesh; None, with the reason, where there is none."""
    coarse = two_mesh.coarser(scene)
    if coarse is not scene:
        return coarse
    companions.why_not = "there is no coarser mesh than this one"
    return None


def _run(scene: Scene, key: int | None, companions: Companions, compute: Compute, progress: Progress | None) -> bool:
    """Run a scene on the coarser mesh and keep its result; return whether there is one."""
    if key in companions.trees:
        return True
    beside = "" if key is None else f", {key} harmonics"
    report = (
        None if progress is None else (lambda at, share, text: progress(f"coarser mesh{beside}, {at}", share, text))
    )
    try:
        coarse = compute(scene, progress=report)
    except PyspringsError as error:
        companions.why_not = f"the run on the coarser mesh failed: {error}"
        return False
    if coarse.record.stopped_by is StopReason.INTERRUPTED and key is not None:
        raise KeyboardInterrupt
    if coarse.record.stopped_by is not None:
        companions.why_not = str(coarse.record.stopped_by)
        return False
    if not coarse.record.reached:
        limit = coarse.record.complete
        companions.ended = str(Status.LIMIT_LOAD if limit else coarse.record.status)
    companions.trees[key] = coarse.tree
    return True


def add_estimate(
    scene: Scene, result: Computed, compute: Compute, progress: Progress | None = None, beside: Companions | None = None
) -> None:
    """Put the estimate and its cost into the record of a result of ``scene`` (the one that ran).

    ``compute`` runs a scene (`full_model.compute`); ``beside`` are the runs of `companions_of`. The result stays as it
    is however the coarser run ends; without an estimate the record has the reason.
    """
    meter, record = Meter(), result.record
    companions = beside or Companions()
    with meter.clock.phase(PHASE):
        if not companions.trees and not companions.why_not and (coarse := _coarser(scene, companions)) is not None:
            _run(coarse, None, companions, compute, progress)
        record.error_estimate = _estimate(scene, result, companions)
    meter.include(companions.clock)
    meter.charge(record)


def was_interrupted(record: RunRecord) -> bool:
    """Return whether the estimate of a run was interrupted."""
    return (record.error_estimate or {}).get("why_not") == StopReason.INTERRUPTED


def _estimate(scene: Scene, result: Computed, companions: Companions) -> dict[str, Any]:
    n = companions.harmonics
    if n not in companions.trees:
        return two_mesh.missing(companions.why_not)
    orders = presets.orders(scene.discretisation)
    richer = None if n is None else companions.trees.get(n + 2)
    ratio = two_mesh.cell_ratio(scene, two_mesh.coarser(scene))
    estimate = two_mesh.estimate(result.tree, companions.trees[n], orders, richer, ratio)
    if companions.ended:
        estimate["coarser_run"] = companions.ended
    return estimate
