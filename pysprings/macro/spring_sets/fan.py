# SPDX-License-Identifier: MIT
"""The set "fan": all reactions by displacement and rotation, interpolated between calibration paths."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    import xarray as xr

FIRST_STEPS = "a table has no initial stiffness: the fan starts with that of the first recorded steps"


def _build(springs: xr.DataTree, _path: str | None) -> Built:
    from pysprings.macro.fan import build_fan
    from pysprings.springs.dataset import get_path

    table = build_fan(springs)
    estimated = springs.dataset["stiffness_initial"].shape != (3, 3) or "first_steps" in springs.attrs
    return Built(table, get_path(springs, table.path[0]), table.path, (FIRST_STEPS,) if estimated else ())


def _ready(springs: xr.DataTree) -> bool:
    from pysprings.macro.fan import has_fan

    return has_fan(springs)


def _reproduces(springs: xr.DataTree, path: xr.Dataset) -> bool:
    from pysprings.macro.fan import fan_paths

    return path.attrs["path"] in fan_paths(springs)


SPRING_SET = SpringSet(
    name="fan",
    label="fan of all calibration paths",
    description="all reactions, between calibration paths of several directions",
    build=_build,
    ready=_ready,
    reproduces=_reproduces,
    several="a fan comes from all calibration paths",
)
