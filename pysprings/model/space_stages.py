# SPDX-License-Identifier: MIT
"""Paths that leave the plane of one load -> stages of the engine, for the whole caisson in six degrees of freedom.

The order is that of `path_kinds.MOTIONS`: u_x, u_y, w, rot_x, rot_y, rot_z; w down, rotations right-handed with z up.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fe_engine.model import Stage
from pysprings.core.path_kinds import LOADS, MOTIONS, PATH_KINDS

if TYPE_CHECKING:
    from pysprings.scene.load import Path, Scene

# A circle is a polygon with so many sides: its radius is 0.1 % less in their middles
CHORDS = 72
_W = MOTIONS.index("w")
_HELD = ("u_x", "u_y", "rot_x", "rot_y", "rot_z")


def space_points(path: Path) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the motions that a path imposes, and their values (n, nc) [m, rad] at the ends of its parts.

    Under given loads there are none (n = 1).
    """
    if path.given(LOADS):
        return (), np.zeros((1, 0))
    if path.kind == "twist":
        return ("rot_z",), np.array([[path.twist], *([each.value] for each in path.then)])
    if path.kind == "motion":
        ends = path.given(MOTIONS)
        return _HELD, np.array([[ends.get(name, 0.0) for name in _HELD]])
    angle = path.direction or 0.0
    first = (path.radius if path.kind == "circle" else path.lateral_displacement) or 0.0
    at = [first * np.array([math.cos(angle), math.sin(angle)])]
    for then in path.then:
        at.append(
            at[-1] + (then.value or 0.0) * np.array([math.cos(then.towards or 0.0), math.sin(then.towards or 0.0)])
        )
    if path.kind == "circle":
        turned = angle + 2.0 * np.pi * np.arange(1, CHORDS + 1) / CHORDS
        at += list(first * np.stack([np.cos(turned), np.sin(turned)], axis=1))
    if path.kind == "pull":
        return _HELD[:2], np.array(at)
    return _HELD, np.hstack([np.array(at), np.zeros((len(at), 3))])


def space_stages(scene: Scene, path: Path, dead: float, rest: float, balanced: float, first: float) -> list[Stage]:
    """Return the stages of a path, one after the other.

    Parameters
    ----------
    dead, balanced : vertical load (N) beyond the one that balances the initial contact stresses, and that one.
    rest : w (m) under the dead load.
    first : size of the first step, m.
    """
    held, points = space_points(path)
    rows = [np.eye(6)[MOTIONS.index(name)] for name in held]
    patterns = [row.copy() for row in rows]
    if path.kind == "pull":  # H at the height of the arm: M_y = H_x h, M_x = -H_y h
        patterns[0][MOTIONS.index("rot_y")], patterns[1][MOTIONS.index("rot_x")] = path.arm, -path.arm
    force = np.zeros(6)
    force[_W] = dead
    for name, value in path.given(LOADS).items():
        force[LOADS.index(name)] = value - (balanced if name == "V" else 0.0)
    if path.heave == "fixed":
        rows, patterns = [*rows, np.eye(6)[_W]], [*patterns, np.eye(6)[_W]]
        points = np.hstack([points, np.full((len(points), 1), rest)])
    control, load = np.array(rows).reshape(-1, 6), np.array(patterns).reshape(-1, 6).T
    stages, before = [], np.zeros(points.shape[1])
    before[len(held) :] = rest
    for number, point in enumerate(points):
        name = path.name if number == 0 else f"{path.name}, then {number}"
        stage = Stage(name, control, point, load, force, duration=(path.duration or 0.0) / len(points))
        stages.append(_stepped(scene, stage, _travel(scene, control, point - before), first, path.kind == "circle"))
        before = point
    stops = {abs(value / points[0, 0]) for value in path.report_at} | {1.0}
    return [replace(stages[0], stops=tuple(sorted(stops))), *stages[1:]]


def _stepped(scene: Scene, stage: Stage, travel: float, first: float, circle: bool) -> Stage:
    """Return a stage with its steps; sides of a circle go on from each other."""
    if circle and " then " in stage.name:
        return replace(stage, first_fraction=0.5, max_fraction=1.0)
    start = scene.solver.first_step_fraction or (min(1.0, first / travel) if travel else 0.01)
    return replace(stage, first_fraction=start, max_fraction=max(start, scene.solver.max_step_fraction or 0.05))


def _travel(scene: Scene, control: np.ndarray, change: np.ndarray) -> float:
    """Return the length (m) of a change of the motions that rows of the control impose: at lid, tip or wall."""
    length, radius = scene.caisson.skirt_length, 0.5 * scene.caisson.outer_diameter
    scale = np.array([1.0, 1.0, 1.0, length, length, radius])
    return float(np.linalg.norm((control.T @ change) * scale))


def with_lag(scene: Scene, stages: list[Stage], relaxing: float | None) -> list[Stage]:
    """Return the stages with the relaxation time of soil that relaxes in an imposed motion of ``relaxing`` (m)."""
    out, before = [], np.zeros(len(stages[0].target))
    for stage in stages:
        moved = _travel(scene, stage.control, stage.target - before)
        out.append(replace(stage, lag=relaxing / moved) if relaxing is not None and moved else stage)
        before = stage.target
    return out


def space_motion(path: Path, radius: float) -> tuple[float, float]:
    """Return the largest displacement (m) and rotation (rad) that a path imposes; a twist at the wall (radius, m)."""
    held, points = space_points(path)
    if not held or PATH_KINDS[path.kind].force:
        return 0.0, 0.0
    by_name = {name: np.abs(points[:, k]) for k, name in enumerate(held)}
    moved = np.hypot(by_name.get("u_x", np.zeros(1)), by_name.get("u_y", np.zeros(1))).max()
    turned = np.hypot(by_name.get("rot_x", np.zeros(1)), by_name.get("rot_y", np.zeros(1))).max()
    return float(max(moved, radius * by_name.get("rot_z", np.zeros(1)).max())), float(turned)
