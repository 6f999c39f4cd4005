# SPDX-License-Identifier: MIT
"""The set "pisa": uncoupled families, lateral ones from a pure translation and moments from a pure rotation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.core.errors import Problem, UserInputError
from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    import xarray as xr


def _build(springs: xr.DataTree, _path: str | None) -> Built:
    from pysprings.macro.curve_table import build_pisa
    from pysprings.macro.fan import pure_paths
    from pysprings.springs.dataset import get_path

    pure = pure_paths(springs)
    if pure is None:
        message = "the set 'pisa' needs a pure translation and a pure rotation to calibrate it"
        raise UserInputError([Problem(key="springs", message=message)])
    translation, rotation = (get_path(springs, name) for name in pure)
    return Built(build_pisa(translation, rotation), translation, pure)


def _ready(springs: xr.DataTree) -> bool:
    from pysprings.macro.fan import pure_paths

    return pure_paths(springs) is not None


SPRING_SET = SpringSet(
    name="pisa",
    label="uncoupled families (PISA)",
    description="p-y from a pure translation, moments from a pure rotation",
    build=_build,
    ready=_ready,
    reproduces=lambda _springs, _path: False,  # its families come from different paths
    several="the set 'pisa' comes from several calibration paths",
)
