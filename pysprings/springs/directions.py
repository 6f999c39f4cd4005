# SPDX-License-Identifier: MIT
"""Directions of paths in the plane (u, rotation*L), L the skirt length: straight paths, rays, paths of one direction.

A ray is a path from the origin that keeps its direction. A path and its mirror image (a motion towards -x) are one ray,
so its angle is in (-pi/2, pi/2].
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pysprings.springs.path import SAME_DIRECTION, STRAIGHT, SpringPath

Array = NDArray[np.float64]

_ORIGIN = 1e-9  # share of the end below which the first state is the origin


def keeps_direction(u: Array, turn: Array) -> bool:
    """Return whether states (n,) = (u, turn) [m] keep the direction of the last one; a start at the origin has none."""
    rho = np.hypot(u, turn)
    first = 1 if rho[0] <= _ORIGIN * rho[-1] else 0  # the origin is met to rounding only
    return not (np.abs(u * turn[-1] - turn * u[-1]) > STRAIGHT * rho * rho[-1])[first:].any()


def ray_of(path: SpringPath) -> tuple[float, float] | None:
    """Return angle [rad] in (-pi/2, pi/2] and size [m] of a straight path from the origin; None for any other."""
    u, v = path.u, path.turn
    rho = np.hypot(u, v)
    if rho[0] > _ORIGIN * rho[-1] or not (np.diff(rho) > 0.0).all() or not keeps_direction(u, v):
        return None
    angle = float(np.arctan2(v[-1], u[-1]))
    # an imposed displacement of 0 is met to rounding only: pure rotation is +pi/2, whatever the sign of u
    if abs(abs(angle) - 0.5 * np.pi) < 1e-9:
        return 0.5 * np.pi, float(rho[-1])
    return (angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi, float(rho[-1])


def rays(paths: Iterable[SpringPath]) -> dict[str, float]:
    """Return the paths that are rays by increasing angle [rad]; of rays in one direction the longest alone."""
    candidates = [(ray[1], ray[0], path.name) for path in paths if (ray := ray_of(path)) is not None]
    distinct: list[tuple[float, str]] = []
    for _, angle, name in sorted(candidates, key=lambda each: -each[0]):
        if all(min(abs(angle - other), np.pi - abs(angle - other)) > SAME_DIRECTION for other, _ in distinct):
            distinct.append((angle, name))
    return {name: angle for angle, name in sorted(distinct)}


def pure(angles: Mapping[str, float]) -> tuple[str, str] | None:
    """Return the rays that are a pure translation and a pure rotation; None where one of them is missing."""
    translation = [name for name, angle in angles.items() if abs(angle) < SAME_DIRECTION]
    rotation = [name for name, angle in angles.items() if abs(angle) > 0.5 * np.pi - SAME_DIRECTION]
    return (translation[0], rotation[0]) if translation and rotation else None


def same_way(a: SpringPath, b: SpringPath) -> bool:
    """Return whether two paths are of one kind and load height and go in one direction."""
    arms = np.array([a.arm, b.arm])
    if a.kind != b.kind or not np.array_equal(arms[:1], arms[1:], equal_nan=True):
        return False
    if not (a.is_straight and b.is_straight):
        return bool(np.sign(a.u[-1]) == np.sign(b.u[-1]))
    ways = [np.arctan2(path.turn[-1], path.u[-1]) for path in (a, b)]
    return bool(abs(ways[0] - ways[1]) < SAME_DIRECTION)
