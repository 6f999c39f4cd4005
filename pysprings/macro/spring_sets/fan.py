# SPDX-License-Identifier: MIT
"""The set "fan": all reactions by displacement and rotation, interpolated between calibration paths."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    from pysprings.springs.path import SpringPath
    from pysprings.springs.springs import Springs

FIRST_STEPS = "a table has no initial stiffness: the fan starts with that of the first recorded steps"


def _build(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.fan import build_fan

    table = build_fan(springs)
    estimated = springs.stiffness is None or springs.first_steps
    return Built(table, springs.paths[table.path[0]], table.path, (FIRST_STEPS,) if estimated else ())


def _ready(springs: Springs) -> bool:
    from pysprings.macro.fan import has_fan

    return has_fan(springs)


def _reproduces(springs: Springs, path: SpringPath) -> bool:
    return path.name in springs.rays


SPRING_SET = SpringSet(
    name="fan",
    label="fan of all calibration paths",
    description="all reactions, between calibration paths of several directions",
    build=_build,
    ready=_ready,
    reproduces=_reproduces,
    several="a fan comes from all calibration paths",
)
