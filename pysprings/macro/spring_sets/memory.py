# SPDX-License-Identifier: MIT
"""The set "memory": elements in parallel that remember, from the rays of a fan and rays that turn back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    from pysprings.springs.springs import Springs

CYCLES = (
    "springs with memory follow the soil law of the full model from cycle to cycle; they hold for tens of cycles, and "
    "have no degradation by the number of cycles"
)
CALIBRATED = (
    "the file has no elements that belong to its paths: they were calibrated for this answer. `pysprings springs FILE "
    "--out NEW.nc` writes a file that has them"
)


def _build(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.memory.build import build_memory, has_elements

    model = build_memory(springs)
    turning = springs.remembering or [path for path in springs.paths.values() if path.remembers]  # of another load
    names = (*model.table.path, *(path.name for path in turning))
    remarks = () if has_elements(springs) else (CALIBRATED,)
    return Built(model.table, springs.paths[model.table.path[0]], names, remarks, model)


def _ready(springs: Springs) -> bool:
    from pysprings.macro.memory.build import has_memory

    return has_memory(springs)


SPRING_SET = SpringSet(
    name="memory",
    label="springs with memory",
    description="elements that remember reversals, from a fan and rays that turn back",
    build=_build,
    ready=_ready,
    reproduces=lambda _springs, _path: False,  # a fit
    several="springs with memory come from all calibration paths",
    remark=CYCLES,
)
