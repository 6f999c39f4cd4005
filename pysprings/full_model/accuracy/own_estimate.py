# SPDX-License-Identifier: MIT
"""Adds to a result the estimate of its own discretisation error: runs the coarser mesh and sets both side by side."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import PyspringsError
from pysprings.core.stop_reasons import StopReason
from pysprings.full_model.accuracy import presets, two_mesh
from pysprings.full_model.record import Meter
from pysprings.full_model.run_record import Computed, RunRecord, Status

if TYPE_CHECKING:
    from pysprings.core.progress import Progress
    from pysprings.scene.load import Scene

Compute = Callable[..., Computed]


def add_estimate(scene: Scene, result: Computed, compute: Compute, progress: Progress | None = None) -> None:
    """Put the estimate and its cost into the record of a result of ``scene`` (the one that ran).

    ``compute`` runs a scene (`full_model.compute`). The result stays as it is however the coarser run ends; without an
    estimate the record has the reason.
    """
    meter, record = Meter(), result.record
    with meter.clock.phase("error estimate"):
        record.error_estimate = _estimate(scene, result, compute, progress)
    meter.charge(record)


def was_interrupted(record: RunRecord) -> bool:
    """Return whether the estimate of a run was interrupted."""
    return (record.error_estimate or {}).get("why_not") == StopReason.INTERRUPTED


def _estimate(scene: Scene, result: Computed, compute: Compute, progress: Progress | None) -> dict[str, Any]:
    coarser = two_mesh.coarser(scene)
    if coarser is scene:
        return two_mesh.missing("there is no coarser mesh than this one")
    report = None if progress is None else (lambda path, share, text: progress(f"coarser mesh, {path}", share, text))
    try:
        coarse = compute(coarser, progress=report)
    except PyspringsError as error:
        return two_mesh.missing(f"the run on the coarser mesh failed: {error}")
    if coarse.record.stopped_by is not None:
        return two_mesh.missing(coarse.record.stopped_by)
    estimate = two_mesh.estimate(result.tree, coarse.tree, presets.orders())
    if coarse.record.status is not Status.COMPLETE:
        estimate["coarser_run"] = str(coarse.record.status)
    return estimate
