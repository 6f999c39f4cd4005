# SPDX-License-Identifier: MIT
"""A run's own estimate of its discretisation error, from the same scene on a coarser mesh.

The largest difference of the two, over all paths, divided by r^p - 1 (r: ratio of the cell sizes, p: order that the
shipped study has found) is the distance from what both tend to, as in Richardson's extrapolation; SAFETY times that is
the estimate. The coarser mesh has 0.7 times the cells in each direction: of all factors near 3/4 it is one with which
every preset loses sectors, too (their number is a multiple of 4), so that no direction keeps its error.

`python -m benchmarks.error_estimates` sets estimates beside truths on scenes that no setting was made with.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import LOAD, PY, curves_of, samples
from pysprings.full_model.accuracy.richardson import cell_size
from pysprings.full_model.accuracy.settings import COARSEST_FACTOR

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

FACTOR = 0.7
# Without a study's order: that of stresses in linear elements, which the singularity at the tip does not let pass.
USUAL_ORDER = 1.0
# Roache (1994) takes 3 for an order that two meshes cannot confirm; see benchmarks/error_estimates.py for ours.
SAFETY = 3.0
SMALLEST_RATIO = 1.05  # of cell sizes: closer meshes give no estimate of their error

# measure -> quantity whose order it takes
ESTIMATED = {"load_max": LOAD, "py_rms": PY}


def coarser(scene: Scene) -> Scene:
    """Return the scene on the coarser mesh, without pictures and fields."""
    from pysprings.model.build import counts_of

    azimuth = scene.mesh.azimuth
    changed: dict[str, Any] = {"refinement": max(FACTOR * scene.mesh.refinement, COARSEST_FACTOR)}
    if azimuth is not None:
        changed["azimuth"] = max(8, 4 * round(FACTOR * azimuth / 4))
    output = {"interface_fields": False, "section": False, "figures": False, "paraview": False}
    coarse = scene.replace(mesh=changed, output=output)
    same = counts_of(coarse) == counts_of(scene)
    return scene if same else coarse


def estimate(fine: xr.DataTree, coarse: xr.DataTree, orders: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the estimate from a result and that of the coarser mesh, as run.json keeps it (percent).

    ``orders`` are those of the quantities LOAD and PY; where a study has none, USUAL_ORDER.
    """
    unknowns = [int(tree.attrs["n_unknowns"]) for tree in (fine, coarse)]
    ratio = cell_size(unknowns[1]) / cell_size(unknowns[0])
    if ratio < SMALLEST_RATIO:
        return missing(f"no mesh with fewer cells: {unknowns[1]} unknowns beside {unknowns[0]}")
    by_path = samples({"fine": curves_of(fine), "coarse": curves_of(coarse)})
    if not by_path:
        return missing("the runs have no path in common")
    difference = measures.worst([measures.errors(each["coarse"], each["fine"]) for each in by_path.values()])
    result: dict[str, Any] = {
        "method": "two meshes", "refinement_factor": FACTOR, "unknowns": unknowns, "cell_ratio": round(ratio, 4),
        "safety": SAFETY, "order": {}, "difference_pct": {}, "estimate_pct": {},
    }  # fmt: skip
    for name, quantity in ESTIMATED.items():
        order = orders.get(quantity) or USUAL_ORDER
        result["order"][name] = order
        if np.isfinite(difference[name]):
            result["difference_pct"][name] = difference[name]
            result["estimate_pct"][name] = SAFETY * difference[name] / (ratio**order - 1.0)
    return result if result["estimate_pct"] else missing("the difference of both meshes has no finite value")


def missing(why: str) -> dict[str, Any]:
    """Return what stands in the place of an estimate that cannot be made."""
    return {"method": "two meshes", "estimate_pct": {}, "why_not": why}


def words(estimated: Mapping[str, Any]) -> str:
    """Return an estimate in words, one line."""
    if not estimated["estimate_pct"]:
        return f"no estimate of the discretisation error: {estimated['why_not']}"
    parts = [f"{measures.MEASURES[name].head} {value:.2g} %" for name, value in estimated["estimate_pct"].items()]
    return (
        f"estimated discretisation error: {', '.join(parts)} (two meshes, {estimated['unknowns'][1]:,} and "
        f"{estimated['unknowns'][0]:,} unknowns; safety factor {estimated['safety']:g} included)"
    )
