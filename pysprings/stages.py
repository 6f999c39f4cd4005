# SPDX-License-Identifier: MIT
"""Load paths of a scene -> stages of the engine (for half a caisson)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fe_engine.model import Stage

if TYPE_CHECKING:
    from pysprings.scene import Path, Scene

# The first step is this fraction of the diameter (0.02 mm for 7.8 m): well inside first yield and first slip,
# where most points switch regime and nothing can be extrapolated yet.
_FIRST_STEP = 2.5e-6
_LARGEST_STEP = 0.05


def dead_load_stage(extra_load: float) -> Stage:
    """Vertical load (N, half caisson) beyond the one that balances the initial contact stresses."""
    return Stage(
        name="dead load",
        control=np.zeros((0, 3)),
        target=np.zeros(0),
        load=np.zeros((3, 0)),
        force=np.array([0.0, extra_load, 0.0]),
        first_fraction=0.1,
        max_fraction=0.25,
    )


def path_stage(scene: Scene, path: Path, extra_load: float) -> Stage:
    """The stage of a path: what is imposed at the lid centre, and by which forces."""
    rows, targets, patterns = _imposed(path)
    force = np.array([0.0, extra_load, 0.0])
    if path.kind == "load":
        force += 0.5 * _need(path.lateral_force) * np.array([1.0, 0.0, -path.arm])
    if path.heave == "fixed":
        rows.append([0.0, 1.0, 0.0])
        targets.append(0.0)
        patterns.append([0.0, 1.0, 0.0])
    first, largest = _step_fractions(scene, path)
    return Stage(
        name=path.name,
        control=np.array(rows).reshape(-1, 3),
        target=np.array(targets),
        load=np.array(patterns).reshape(-1, 3).T,
        force=force,
        stops=tuple(sorted({abs(value / imposed_end(path)) for value in path.report_at} | {1.0})),
        first_fraction=first,
        max_fraction=largest,
    )


def imposed_end(path: Path) -> float:
    """End value of the imposed quantity: lateral displacement (m), rotation (rad) or lateral force (N)."""
    return _need({"rotation": path.rotation, "load": path.lateral_force}.get(path.kind, path.lateral_displacement))


def _imposed(path: Path) -> tuple[list, list, list]:
    """Rows of the control, their end values and the force patterns, in (u, w, rotation)."""
    lateral, turn = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    if path.kind == "pull":
        return [lateral], [_need(path.lateral_displacement)], [[1.0, 0.0, -path.arm]]
    if path.kind == "translation":
        return [lateral, turn], [_need(path.lateral_displacement), path.rotation or 0.0], [lateral, turn]
    if path.kind == "rotation":
        return [lateral, turn], [0.0, _need(path.rotation)], [lateral, turn]
    return [], [], []


def _step_fractions(scene: Scene, path: Path) -> tuple[float, float]:
    """First and largest step as fractions of the path."""
    largest = scene.solver.max_step_fraction or _LARGEST_STEP
    first = scene.solver.first_step_fraction
    if first is None:
        scale = {"rotation": scene.caisson.skirt_length, "load": 0.0}.get(path.kind, 1.0)
        reach = abs(imposed_end(path)) * scale
        first = min(1.0, _FIRST_STEP * scene.caisson.outer_diameter / reach) if reach else 0.01
    return min(first, 1.0), max(first, largest)


def _need(value: float | None) -> float:
    """The scene's checks guarantee that the value is there."""
    assert value is not None
    return value
