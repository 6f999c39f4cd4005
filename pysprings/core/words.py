# SPDX-License-Identifier: MIT
"""Words that scene file, command line, studies and records share; why a run or a path ended before its aim (light)."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

AUTO = "auto"  # of a value that the program chooses
FROM_CASES = "from cases"  # of the further vertical loads of springs: those of [design] cases
MOST_DRAWN = 6  # paths of a run that are all drawn

MeshPreset = Literal["coarse", "medium", "paper", "fine"]
Discretisation = Literal["hex8", "fourier"]
Use = Literal["beam"]  # of `pysprings springs --for`
ElementTest = Literal["triaxial", "triaxial-extension", "dss", "oedometer"]
# largest error of a run in its load and p-y curves: see `pysprings.full_model.accuracy.presets`
TargetError = Literal["5%", "2%", "1%", "0.5%"]
Figures = Literal["none", "report", "all"]  # pictures of a run: none, those that its report shows, all
FigureFormat = Literal["png", "svg", "png,svg"]
Estimate = Literal["low", "best", "high"]  # which end of the ranges of a scene counts
ESTIMATES: tuple[Estimate, ...] = ("low", "best", "high")
OF_ESTIMATE = "({} estimate)"  # in the title of a scene whose estimate is chosen, and of all that is made of it

# kinds of the largest known load of an answer that is no capacity: more is not known; nothing is
RANGE_END, NOT_KNOWN = "end of the range", "not known"


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


TILTS = (0.25, 0.5)  # deg: usual tolerances of a wind turbine, over its life and after installation with it
SOLVED = 1e-5  # share of the largest load that the tolerance of the solver leaves of zero


def sudden(drainage: object) -> str:
    """Return what to add to an initial stiffness in ground of this drainage: where water flows it has not yet moved."""
    return " (of a load so sudden that no water moves)" if "coupled" in str(drainage).split(", ") else ""
