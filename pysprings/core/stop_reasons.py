# SPDX-License-Identifier: MIT
"""Why a run, or one of its paths, ended before its aim: the words of `run.json` and of spring files (light)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class StopReason(StrEnum):
    """A named reason. Those that `pysprings.full_model.diagnosis` finds are physical."""

    LIMIT_LOAD = "limit load"
    DEAD_LOAD = "dead load"
    DISPLACEMENT_LIMIT = "displacement limit"
    APEX = "apex"
    LOCALISATION = "localisation"
    FRICTION = "friction"
    UNEXPLAINED = "unexplained"
    ERROR = "error of the program"
    INTERRUPTED = "interrupted"
    OUT_OF_MEMORY = "out of memory"

    @property
    def is_limit(self) -> bool:
        """True where a path under a given load has reached its limit load, or a motion that counts as one."""
        return self in (StopReason.LIMIT_LOAD, StopReason.DISPLACEMENT_LIMIT)

    @property
    def explains(self) -> bool:
        """True for a named physical reason."""
        unexplained = (StopReason.UNEXPLAINED, StopReason.ERROR, StopReason.INTERRUPTED, StopReason.OUT_OF_MEMORY)
        return self not in unexplained


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """A reason with the figures that show it; `str()` is one line for people that begins with the reason."""

    reason: StopReason
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.reason}: {self.detail}" if self.detail else str(self.reason)
