# SPDX-License-Identifier: MIT
"""What a spring set of the macro-model declares (light: loads nothing)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pysprings.macro.curve_table import SpringTable
    from pysprings.macro.fan import FanTable
    from pysprings.macro.memory.model import MemoryModel
    from pysprings.springs.path import SpringPath
    from pysprings.springs.springs import Springs


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
