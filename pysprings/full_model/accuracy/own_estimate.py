# SPDX-License-Identifier: MIT
"""Adds to a result the estimate of its own discretisation error: runs the coarser mesh and sets both side by side."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import xarray as xr

from pysprings.core.errors import PyspringsError
from pysprings.full_model.accuracy import presets, two_mesh
from pysprings.full_model.record import Meter

if TYPE_CHECKING:
    from pysprings.core.progress import Progress
    from pysprings.scene.load import Scene

INTERRUPTED = "interrupted"
KEY = "error_estimate"  # in run.json
Compute = Callable[..., xr.DataTree]


def add_estimate(scene: Scene, result: xr.DataTree, compute: Compute, progress: Progress | None = None) -> None:
    """Put the estimate and its cost into the record of a result of ``scene`` (the one that ran).

    ``compute`` runs a scene (`full_model.compute`). Whatever becomes of the coarser run, the result stays what it
    is; the record says why there is no estimate.
    """
    meter, record = Meter(), json.loads(result.attrs["run_json"])
    with meter.clock.phase("error estimate"):
        record[KEY] = _estimate(scene, result, compute, progress)
    meter.charge(record)
    result.attrs["run_json"] = json.dumps(record)


def was_interrupted(result: xr.DataTree) -> bool:
    """Tell whether the estimate of a result was interrupted."""
    record = json.loads(result.attrs["run_json"])
    return bool(record.get(KEY, {}).get("why_not") == INTERRUPTED)


def _estimate(scene: Scene, result: xr.DataTree, compute: Compute, progress: Progress | None) -> dict[str, Any]:
    coarser = two_mesh.coarser(scene)
    if coarser is scene:
        return two_mesh.missing("there is no coarser mesh than this one")
    told = None if progress is None else (lambda path, share, text: progress(f"coarser mesh, {path}", share, text))
    try:
        coarse = compute(coarser, progress=told)
    except PyspringsError as error:
        return two_mesh.missing(f"the run on the coarser mesh failed: {error}")
    if stopped_by := json.loads(coarse.attrs["run_json"])["stopped_by"]:
        return two_mesh.missing(stopped_by)
    found = two_mesh.estimate(result, coarse, presets.orders())
    if coarse.attrs["status"] != "complete":
        found["coarser_run"] = coarse.attrs["status"]
    return found
