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


def space_stages(scene: Scene, path: Path, dead: float, balanced: float, first: float) -> list[Stage]:
    """Return the stages of a path that starts at w = 0, one after the other.

    Parameters
    ----------
    dead, balanced : vertical load (N) beyond the one that balances the initial contact stresses, and that one.
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
        points = np.hstack([points, np.zeros((len(points), 1))])
    control, load = np.array(rows).reshape(-1, 6), np.array(patterns).reshape(-1, 6).T
    lengths, stages, before = lengths_of(scene, control), [], np.zeros(points.shape[1])
    for number, (point, time) in enumerate(zip(points, _times(path, len(points)), strict=True)):
        name = path.name if number == 0 else f"{path.name}, then {number}"
        stage = Stage(name, control, point, load, force, duration=time)
        if path.kind == "circle" and number:  # a side
            stage = replace(stage, first_fraction=0.5, max_fraction=1.0, continues=number > 1)
        else:
            stage = _stepped(scene, stage, float(np.linalg.norm((point - before) * lengths)), first)
        stages.append(stage)
        before = point
    stops = {abs(value / points[0, 0]) for value in path.report_at} | {1.0}
    return [replace(stages[0], stops=tuple(sorted(stops))), *stages[1:]]


def _times(path: Path, parts: int) -> list[float]:
    """Return the time (s) of each part of a path, 0 where none is given; those of a circle share its own."""
    if path.kind == "circle":
        return [(path.duration or 0.0) / parts] * parts
    return [path.duration or 0.0, *(then.time or 0.0 for then in path.then)]


def _stepped(scene: Scene, stage: Stage, travel: float, first: float) -> Stage:
    """Return a stage with its steps, the first one of ``first`` (m)."""
    start = scene.solver.first_step_fraction or (min(1.0, first / travel) if travel else 0.01)
    return replace(stage, first_fraction=start, max_fraction=max(start, scene.solver.max_step_fraction or 0.05))


def lengths_of(scene: Scene, control: np.ndarray) -> np.ndarray:
    """Return the lengths (nc,) that turn what rows of a control (nc, nb) impose into displacements of lid, tip or wall.

    They are 1 of displacements; skirt length of rotations; radius (m) of a twist.
    """
    length, radius = scene.caisson.skirt_length, 0.5 * scene.caisson.outer_diameter
    shifts, sizes = {3: (2, [1.0, 1.0, length]), 6: (3, [1.0, 1.0, 1.0, length, length, radius])}[control.shape[1]]
    return np.where((control[:, :shifts] == 0.0).all(axis=1), control @ sizes, 1.0)


def space_motion(path: Path, radius: float) -> tuple[float, float]:
    """Return the largest displacement (m) and rotation (rad) that a path imposes; a twist at the wall (radius, m)."""
    held, points = space_points(path)
    if not held or PATH_KINDS[path.kind].force:
        return 0.0, 0.0
    by_name = {name: np.abs(points[:, k]) for k, name in enumerate(held)}
    moved = np.hypot(by_name.get("u_x", np.zeros(1)), by_name.get("u_y", np.zeros(1))).max()
    turned = np.hypot(by_name.get("rot_x", np.zeros(1)), by_name.get("rot_y", np.zeros(1))).max()
    return float(max(moved, radius * by_name.get("rot_z", np.zeros(1)).max())), float(turned)
