# SPDX-License-Identifier: MIT
"""Size of the next increment, from how the last ones went.

An increment that took Newton few iterations lets the next one grow, a long one shrinks it, a failed attempt halves it.
Where attempts have failed, so many increments pass at the smaller size before it grows again, twice as many each time
that growing back has failed anew: a failed attempt costs several increments. Where Newton needs next to nothing, the
wait is shorter: many such increments cost more than an attempt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

GROWTH = 1.5  # factor on the step after an easy increment
_QUICK = 3  # iterations up to which an increment counts as several of those that wait for growth
_QUICKER = 4  # as how many it counts
_EASY = 6  # iterations up to which an increment is easy
_HARD = 10  # iterations above which the next step is smaller
_CUT = 0.5  # factor on the step after a failed attempt
SMALLEST = 1.0e-7  # fraction of a stage below which a step is given up
_HOLD = 8  # increments at the smaller size after a failed attempt
_LONGEST_HOLD = 16  # the same after repeated ones
# What can limit a step: it opens a stage; it may only grow by a factor; it is the largest allowed; it must land on a
# stop; Newton needed many iterations on the last one; an attempt at a larger one failed
LIMITS = ("first step", "growth", "largest step", "stop", "iterations", "cut-back")


@dataclass(frozen=True)
class StepSize:
    """Size of the next increment as a fraction of the stage, and what limits it (one of LIMITS).

    wait : increments until it may grow again.
    failed : size of the attempt that failed last, inf where none has since steps of that size succeeded.
    hold : increments to wait after the last failure.
    """

    size: float
    limit: str = "first step"
    wait: int = 0
    failed: float = math.inf
    hold: int = _HOLD

    @property
    def exhausted(self) -> bool:
        """Whether it is too small to go on with."""
        return self.size < SMALLEST

    def on_grid(self, duration: float, largest: float) -> StepSize:
        """Return the size whose share of a duration (s) is the nearest power of GROWTH; that of a first step stays.

        So does the largest one. Paths with water then share time steps, and what is factorised for each.
        """
        if self.limit == "first step" or self.size >= largest:
            return self
        power = round(math.log(self.size * duration, GROWTH))
        return replace(self, size=min(GROWTH**power / duration, largest))

    def after_failure(self, step: float, again: bool) -> StepSize:
        """Return the size to try after an attempt at ``step`` has failed, ``again`` for the same increment."""
        hold = self.hold
        if not again and math.isfinite(self.failed) and step <= GROWTH * self.failed:
            hold = min(2 * hold, _LONGEST_HOLD)
        return StepSize(_CUT * step, "cut-back", hold, step, hold)

    def after_success(self, step: float, iterations: int, largest: float) -> StepSize:
        """Return the next size after an increment of ``step`` that took so many iterations."""
        now = self if step < self.failed else replace(self, wait=0, failed=math.inf, hold=_HOLD)
        if iterations > _HARD:
            proposed, limit = 0.7 * step, "cut-back" if now.wait else "iterations"
        elif now.wait:
            proposed, limit = now.size, "cut-back"
        elif iterations > _EASY:
            proposed, limit = step, "iterations"
        else:
            proposed, limit = GROWTH * step, "growth"
        size, limit = (largest, "largest step") if proposed >= largest else (proposed, limit)
        return replace(now, size=size, limit=limit, wait=max(now.wait - (_QUICKER if iterations <= _QUICK else 1), 0))
