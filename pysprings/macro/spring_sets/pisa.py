# SPDX-License-Identifier: MIT
"""The set "pisa": uncoupled families, lateral ones from a pure translation and moments from a pure rotation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.core.errors import refused
from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    from pysprings.springs.springs import Springs


def _build(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.curve_table import build_pisa

    if springs.pure_paths is None:
        raise refused("springs", "the set 'pisa' needs a pure translation and a pure rotation to calibrate it")
    translation, rotation = (springs.paths[name] for name in springs.pure_paths)
    return Built(build_pisa(translation, rotation), translation, springs.pure_paths)


def _ready(springs: Springs) -> bool:
    return springs.pure_paths is not None


SPRING_SET = SpringSet(
    name="pisa",
    label="uncoupled families (PISA)",
    description="p-y from a pure translation, moments from a pure rotation",
    build=_build,
    ready=_ready,
    reproduces=lambda _springs, _path: False,  # its families come from different paths
    several="the set 'pisa' comes from several calibration paths",
)
