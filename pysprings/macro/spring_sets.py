# SPDX-License-Identifier: MIT
"""Spring sets of the macro-model (light: what builds them is imported when it is asked for).

Other packages call `SPRING_SETS.register`, or declare an entry point in the group `pysprings.spring_sets`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pysprings.core.errors import refused
from pysprings.core.registry import Registry

if TYPE_CHECKING:
    from pysprings.macro.curve_table import SpringTable
    from pysprings.macro.fan import FanTable
    from pysprings.macro.memory.model import MemoryModel
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
CALIBRATED = (
    "the file has no elements that belong to its paths: they were calibrated for this answer. `pysprings springs FILE "
    "--out NEW.nc` writes a file that has them"
)


@dataclass(frozen=True, slots=True)
class Built:
    """Springs of a set as a table, the path that gives depths and the state at rest, and the paths they come from.

    memory : elements that remember, in place of the table along a sequence.
    """

    table: SpringTable | FanTable
    origin: SpringPath
    sources: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    memory: MemoryModel | None = None


def _always(_springs: Springs) -> bool:
    return True


def _calibrates(_springs: Springs, path: SpringPath) -> bool:
    return path.calibrates


@dataclass(frozen=True, slots=True)
class SpringSet:
    """A choice of springs for the rigid caisson.

    Attributes
    ----------
    name
        Word of `--springs`.
    label, description
        Title in pictures and tables; clause for help texts.
    build
        (springs at one rate and vertical load, path or None) -> `Built`; raises UserInputError for springs that cannot
        give the set.
    ready
        Whether springs can give the set.
    reproduces
        (springs, path of the full model): whether the set meets the recorded states of the path by construction.
    companions
        The set needs distributed moments, tip and lid terms.
    curves
        Independent curves of a table can give the set.
    several
        Sentence for a set that is made from several calibration paths together; blank for a set of one path.
    remark
        Sentence that goes with every answer.
    """

    name: str
    label: str
    description: str
    build: Callable[[Springs, str | None], Built]
    ready: Callable[[Springs], bool] = _always
    reproduces: Callable[[Springs, SpringPath], bool] = _calibrates
    companions: bool = True
    curves: bool = False
    several: str = ""
    remark: str = ""


def _build_py(springs: Springs, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table

    origin = springs.path(path)
    return Built(build_table(origin, companions=False), origin, (origin.name,))


PY = SpringSet(
    name="py",
    label="p-y springs only",
    description="p-y alone",
    build=_build_py,
    companions=False,
    curves=True,
    remark=ALONE,
)


def _build_pisa(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.curve_table import build_pisa

    if springs.pure_paths is None:
        raise refused("springs", "the set 'pisa' needs a pure translation and a pure rotation to calibrate it")
    translation, rotation = (springs.paths[name] for name in springs.pure_paths)
    return Built(build_pisa(translation, rotation), translation, springs.pure_paths)


def _ready_pisa(springs: Springs) -> bool:
    return springs.pure_paths is not None


PISA = SpringSet(
    name="pisa",
    label="uncoupled families (PISA)",
    description="p-y from a pure translation, moments from a pure rotation",
    build=_build_pisa,
    ready=_ready_pisa,
    reproduces=lambda _springs, _path: False,  # its families come from different paths
    several="the set 'pisa' comes from several calibration paths",
)


def _build_full(springs: Springs, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table

    origin = springs.path(path)
    return Built(build_table(origin, companions=True), origin, (origin.name,))


FULL = SpringSet(
    name="full",
    label="full spring set of one path",
    description="all reactions of one path",
    build=_build_full,
    curves=True,
)


def _build_fan(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.fan import build_fan

    table = build_fan(springs)
    estimated = springs.stiffness is None or springs.first_steps
    return Built(table, springs.paths[table.path[0]], table.path, (FIRST_STEPS,) if estimated else ())


def _ready_fan(springs: Springs) -> bool:
    from pysprings.macro.fan import has_fan

    return has_fan(springs)


def _reproduces_fan(springs: Springs, path: SpringPath) -> bool:
    return path.name in springs.rays


FAN = SpringSet(
    name="fan",
    label="fan of all calibration paths",
    description="all reactions, between calibration paths of several directions",
    build=_build_fan,
    ready=_ready_fan,
    reproduces=_reproduces_fan,
    several="a fan comes from all calibration paths",
)


def _build_memory(springs: Springs, _path: str | None) -> Built:
    from pysprings.macro.memory.build import build_memory, has_elements

    model = build_memory(springs)
    turning = springs.remembering or [path for path in springs.paths.values() if path.remembers]  # of another load
    names = (*model.table.path, *(path.name for path in turning))
    remarks = () if has_elements(springs) else (CALIBRATED,)
    return Built(model.table, springs.paths[model.table.path[0]], names, remarks, model)


def _ready_memory(springs: Springs) -> bool:
    from pysprings.macro.memory.build import has_memory

    return has_memory(springs)


MEMORY = SpringSet(
    name="memory",
    label="springs with memory",
    description="elements that remember reversals, from a fan and rays that turn back",
    build=_build_memory,
    ready=_ready_memory,
    reproduces=lambda _springs, _path: False,  # a fit
    several="springs with memory come from all calibration paths",
    remark=CYCLES,
)

SPRING_SETS: Registry[SpringSet] = Registry("spring set", (PY, PISA, FULL, FAN, MEMORY), group="pysprings.spring_sets")
