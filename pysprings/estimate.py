# SPDX-License-Identifier: MIT
"""What a scene costs before it is run: counts from its own mesh, memory and time from fitted laws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pysprings.build import build_model, left_out
from pysprings.penalty import penalty_of

if TYPE_CHECKING:
    from pysprings.scene import Scene

# Fitted on the presets coarse, medium and paper (4,600 to 52,000 unknowns) with Pardiso on two cores:
# entries of the LU factors, and seconds of one factorisation and of the rest of an iteration.
_FACTOR_ENTRIES, _FACTOR_EXPONENT = 10.3, 1.44
_FACTOR_SECONDS, _FACTOR_SECONDS_EXPONENT = 3.3e-10, 2.0
_ITERATION_SECONDS = 1.0e-5
_BASE_BYTES, _BYTES_PER_UNKNOWN, _BYTES_PER_ENTRY = 0.37e9, 3.0e3, 9.0
# Increments of a path to large displacement, and linear solves per increment (cut-backs included)
_INCREMENTS, _SOLVES_PER_INCREMENT = 45, 5.0
_PICTURE_SECONDS = 10.0  # of one path


def describe(scene: Scene) -> dict[str, Any]:
    """Return mesh counts and quality, unknowns, estimated memory (GB) and time (s), and what is left out."""
    built = build_model(scene)
    mesh, quality = built.model.mesh, built.quality
    unknowns = int(3 * mesh.n_nodes - built.model.fixed.sum()) + built.model.n_border
    if built.model.water is not None:
        unknowns += int((~built.model.water.fixed).sum())
    return {
        "mesh": {
            "nodes": mesh.n_nodes,
            "elements": mesh.n_elements,
            "interface_stations": len(built.model.initial_pressure),
            "smallest_scaled_Jacobian": quality.min_jacobian,
            "largest_aspect_ratio": quality.max_aspect,
        },
        "unknowns": unknowns,
        "contact": _contact(scene),
        "vertical_load_N": 2.0 * (built.balanced_load + built.extra_load),
        "memory_GB": memory_bytes(unknowns) / 1e9,
        "time_s": seconds(scene, unknowns),
        "left_out": left_out(scene),
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


def memory_bytes(unknowns: int) -> float:
    """Estimated peak memory of a run, in bytes."""
    entries = _FACTOR_ENTRIES * unknowns**_FACTOR_EXPONENT
    return _BASE_BYTES + _BYTES_PER_UNKNOWN * unknowns + _BYTES_PER_ENTRY * entries


def seconds(scene: Scene, unknowns: int) -> float:
    """Estimated wall time of a run on two cores, in s: an order of magnitude, the steps are adaptive."""
    per_iteration = _FACTOR_SECONDS * unknowns**_FACTOR_SECONDS_EXPONENT + _ITERATION_SECONDS * unknowns
    solves = _INCREMENTS * (1.5 if scene.soil.yield_surface == "elastic" else _SOLVES_PER_INCREMENT)
    pictures = _PICTURE_SECONDS if scene.output.figures else 0.0
    return 5.0 + len(scene.paths) * (solves * per_iteration + pictures)
