# SPDX-License-Identifier: MIT
"""Spring sets of the macro-model (light: what builds them is imported when it is asked for).

Other packages call `SPRING_SETS.register`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING

from pysprings.core.errors import refused
from pysprings.core.registry import Registry

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.core.progress import Progress
    from pysprings.macro.response import Response
    from pysprings.macro.space import SpaceResponse
    from pysprings.springs.path import SpringPath
    from pysprings.springs.springs import Springs

ALONE = (
    "p-y springs alone: no distributed moment, tip and lid springs; on a caisson they carry a fraction of the load "
    "(`pysprings compare` measures it)"
)
FIRST_STEPS = "a table has no initial stiffness: the fan starts with that of the first recorded steps"
CYCLES = (
    "springs with memory follow the soil law of the full model from cycle to cycle; they hold for tens of cycles, and "
    "have no degradation by the number of cycles"
)


@dataclass(frozen=True, slots=True)
class SpringSet:
    """A choice of springs for the rigid caisson.

    name : Word of `--springs`.
    label, description : Title in pictures and tables; clause for help texts.
    build : (springs at one rate and vertical load, path or None) -> `Response`; raises UserInputError for springs that
        cannot give the set.
    ready : Whether springs can give the set.
    reproduces : (springs, path of the full model): whether the set meets the recorded states of the path by
        construction.
    companions : The set needs distributed moments, tip and lid terms.
    curves : Independent curves of a table can give the set.
    several : Sentence for a set that is made from several calibration paths together; blank for a set of one path.
    remark : Sentence that goes with every answer.
    with_stored : (springs, progress) -> springs with what the set keeps in their file, made where it is missing.
    in_space : Springs -> what answers loads from all sides; None for a set that holds in one plane only.
    """

    name: str
    label: str
    description: str
    build: Callable[[Springs, str | None], Response]
    ready: Callable[[Springs], bool] = lambda _springs: True
    reproduces: Callable[[Springs, SpringPath], bool] = lambda _springs, path: path.calibrates
    companions: bool = True
    curves: bool = False
    several: str = ""
    remark: str = ""
    with_stored: Callable[[xr.DataTree, Progress | None], xr.DataTree] | None = None
    in_space: Callable[[Springs], SpaceResponse] | None = None


def _rows(springs: Springs, path: str | None, companions: bool) -> Response:
    from pysprings.macro.curve_table import build_table
    from pysprings.macro.response import RowSprings

    origin = springs.path(path)
    if origin.is_vertical:
        raise refused("path", f"'{origin.name}' moves the caisson vertically alone: it has no lateral springs")
    return RowSprings(build_table(origin, companions), origin, (origin.name,))


PY = SpringSet(
    name="py",
    label="p-y springs only",
    description="p-y alone",
    build=lambda springs, path: _rows(springs, path, companions=False),
    companions=False,
    curves=True,
    remark=ALONE,
)


def _build_pisa(springs: Springs, _path: str | None) -> Response:
    from pysprings.macro.curve_table import build_pisa
    from pysprings.macro.response import RowSprings

    if springs.pure_paths is None:
        raise refused("springs", "the set 'pisa' needs a pure translation and a pure rotation to calibrate it")
    translation, rotation = (springs.paths[name] for name in springs.pure_paths)
    return RowSprings(build_pisa(translation, rotation), translation, springs.pure_paths)


PISA = SpringSet(
    name="pisa",
    label="uncoupled families (PISA)",
    description="p-y from a pure translation, moments from a pure rotation",
    build=_build_pisa,
    ready=lambda springs: springs.pure_paths is not None,
    reproduces=lambda _springs, _path: False,  # its families come from different paths
    several="the set 'pisa' comes from several calibration paths",
)


FULL = SpringSet(
    name="full",
    label="full spring set of one path",
    description="all reactions of one path",
    build=lambda springs, path: _rows(springs, path, companions=True),
    curves=True,
)


def _build_fan(springs: Springs, _path: str | None) -> Response:
    from pysprings.macro.fan import build_fan
    from pysprings.macro.fan_springs import FanSprings, build_spread

    table = build_fan(springs)
    remarks = (FIRST_STEPS,) if springs.stiffness is None or springs.first_steps else ()
    return FanSprings(table, springs.paths[table.path[0]], table.path, remarks, build_spread(springs, table))


FAN = SpringSet(
    name="fan",
    label="fan of all calibration paths",
    description="all reactions, between calibration paths of several directions",
    build=_build_fan,
    ready=lambda springs: springs.has_fan,
    reproduces=lambda springs, path: path.name in springs.rays,
    several="a fan comes from all calibration paths",
)


def _memory() -> ModuleType:
    from pysprings.memory import build

    return build


def _space() -> ModuleType:
    from pysprings.memory import space_model

    return space_model


MEMORY = SpringSet(
    name="memory",
    label="springs with memory",
    description="elements that remember reversals, from a fan and rays that turn back",
    build=lambda springs, _path: _memory().build_memory(springs),
    ready=lambda springs: _memory().has_memory(springs),
    reproduces=lambda _springs, _path: False,  # a fit
    several="springs with memory come from all calibration paths",
    remark=CYCLES,
    with_stored=lambda tree, progress: _memory().with_memory(tree, progress),
    in_space=lambda springs: _space().SpaceSprings.of(springs),
)

SPRING_SETS: Registry[SpringSet] = Registry("spring set", (PY, PISA, FULL, FAN, MEMORY))


def with_stored(tree: xr.DataTree, progress: Progress | None = None) -> xr.DataTree:
    """Return springs with all that spring sets keep in their file; as they are where they give no such set."""
    for each in SPRING_SETS:
        tree = tree if each.with_stored is None else each.with_stored(tree, progress)
    return tree
