# SPDX-License-Identifier: MIT
"""What a scene costs before it is run: counts from its own mesh, memory, disk and time from fitted laws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pysprings.build import build_model
from pysprings.omissions import left_out, symmetric_factors
from pysprings.penalty import penalty_of
from pysprings.resources import (
    gigabytes,
    memory_available,
    memory_bytes,
    refuse_what_cannot_fit,
    size_of,
    steps_bytes,
)
from pysprings.run_time import seconds
from pysprings.small_strain import scene_warnings

if TYPE_CHECKING:
    from pysprings.scene import Scene


def describe(scene: Scene) -> dict[str, Any]:
    """Return counts and quality of the mesh, unknowns, memory and disk (GB), time (s), what is left out, warnings.

    Raises ResourceError, before anything is built, where the run cannot fit in the memory of this machine.
    """
    refuse_what_cannot_fit(scene)
    built = build_model(scene)
    mesh, quality = built.model.mesh, built.quality
    unknowns = int(3 * mesh.n_nodes - built.model.fixed.sum()) + built.model.n_border
    if built.model.water is not None:
        unknowns += int((~built.model.water.fixed).sum())
    steps = steps_bytes(scene, size_of(scene))[1]
    symmetric = symmetric_factors(scene)
    memory = memory_bytes(unknowns, built.model.water is not None, symmetric) + steps
    return {
        "mesh": {
            "nodes": mesh.n_nodes,
            "elements": mesh.n_elements,
            "steel_elements": 0 if built.steel is None else len(built.steel.hexes),
            "interface_stations": len(built.model.initial_pressure),
            "smallest_scaled_Jacobian": quality.min_jacobian,
            "largest_aspect_ratio": quality.max_aspect,
        },
        "unknowns": unknowns,
        "contact": _contact(scene),
        "vertical_load_N": 2.0 * (built.balanced_load + built.extra_load),
        "memory_GB": memory / 1e9,
        "disk_GB": steps / 1e9,
        "time_s": seconds(scene, unknowns, symmetric=symmetric),
        "left_out": [omission.record() for omission in left_out(scene)],
        "warnings": [*_memory_warning(memory), *scene_warnings(scene), *penalty_of(scene).remarks],
    }


def _contact(scene: Scene) -> dict[str, Any]:
    """Penalty stiffness that the model uses, and what it costs."""
    penalty = penalty_of(scene)
    return {
        "normal_stiffness_N_per_m3": penalty.normal,
        "shear_stiffness_N_per_m3": penalty.shear,
        "largest_initial_penetration_m": penalty.penetration,
        "loss_of_elastic_stiffness_percent": 100.0 * penalty.stiffness_loss,
    }


def _memory_warning(memory: float) -> list[str]:
    """Say when other programs leave too little memory now."""
    free = memory_available()
    if memory <= free:
        return []
    return [f"the run needs about {gigabytes(memory)} of memory; {gigabytes(free)} are free now"]
