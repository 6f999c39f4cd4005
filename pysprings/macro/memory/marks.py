# SPDX-License-Identifier: MIT
"""Marks of one state of springs with a memory: what of it their paths do not cover."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from pysprings.macro.fan import RANGE_SLACK, WIDEST, FanTable
from pysprings.springs.path import TOGETHER, same_load


@dataclass(frozen=True, slots=True)
class StepMarks:
    """What of a state the springs do not cover; the words are those of a prediction.

    Attributes
    ----------
    range_used : size of the motion over that of the rays beside it.
    extrapolated : True beyond the rays.
    off_path : True between rays too far apart.
    off_load : True where V is not that of the elements. off_rate : True where the motion is faster or slower than
        their rate by half a decade. None where V, or the time of the step, is not given, or the springs have no rate.
    way_used : motions added up over the longest way of the calibration; heave is extrapolated beyond 1.
    """

    range_used: float
    extrapolated: bool
    off_path: bool
    off_load: bool | None
    off_rate: bool | None
    way_used: float

    @property
    def heave_extrapolated(self) -> bool:
        """True where the motions add up to more than the ways of the calibration."""
        return self.way_used > 1.0 + RANGE_SLACK

    @property
    def names(self) -> tuple[str, ...]:
        """The marks that are set."""
        found = tuple(name for name, value in asdict(self).items() if value is True)
        return (*found, "heave_extrapolated") if self.heave_extrapolated else found


def lateral_marks(table: FanTable, state: tuple[float, float]) -> tuple[float, bool]:
    """Return range used by a state (u [m], rotation [rad]), and whether it is between rays too far apart."""
    states = np.array([state], dtype=float)
    used, sector, _ = table.support(states, table.rows(states)[1])
    return float(used[0]), bool(sector[0] > WIDEST + RANGE_SLACK and states.any())


def off_load(own: float, V: float | None) -> bool | None:
    """Return whether V [N] is another than that of the elements; None where one of them is not known."""
    return None if V is None or not np.isfinite(own) else not same_load(own, V)


def off_rate(own: float | None, moved: float, duration: float | None) -> bool | None:
    """Return whether a motion [m] in a time [s] has another rate than the elements; None where that is not known.

    A rest has no rate: it is not marked.
    """
    if own is None or duration is None:
        return None
    return moved > 0.0 and not 1.0 / TOGETHER < moved / duration / own < TOGETHER
