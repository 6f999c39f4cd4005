# SPDX-License-Identifier: MIT
"""Where a sequence of loads or motions leaves what springs are calibrated on: one direction, and never back.

Calibration paths keep the ratio of rotation to u, or of M to H, and grow. A sequence that turns aside or back meets
soil that has yielded; the springs have no memory of that. From such a state on every answer is marked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.control import Control
from pysprings.springs.alike import SAME_DIRECTION, same_load

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]

# Targets below this share of the largest one have no direction, and steps back below it are none (rounding).
ROUNDING = 1e-9

_TURNED = "after the sequence turned back: the springs go back on the same curve, the soil does not"


@dataclass(frozen=True, slots=True)
class Turns:
    """Marks by state (n,): after the sequence has left its first direction (aside), after it has turned back (back)."""

    aside: Marks
    back: Marks

    def notes(self) -> list[str]:
        """Return the sentences on the marked states; none where nothing is marked."""
        degrees = f"{np.degrees(SAME_DIRECTION):g} degree"
        words = (
            (self.aside, f"after the sequence left its first direction (by more than {degrees}): "
             "springs hold for loads, or motions, that grow in proportion"),
            (self.back, _TURNED),
        )  # fmt: skip
        return [
            f"{mark.sum()} of {mark.size} states (from state {int(np.argmax(mark)) + 1} on) come {text}"
            for mark, text in words
            if mark.any()
        ]


def turns(control: Control, targets: Array, length: float, V: float | Array | None, rest: float) -> Turns:
    """Return where targets (n, 2) of a control turn aside or back, on their way from the origin.

    The direction is that of (H, M/length) or (u, rotation*length); of one motion its sign. A vertical load by row,
    V (n,) [N], that comes back towards the one at rest [N] turns back, too.
    """
    plane = targets / [1.0, length] if control == "load" else targets * [1.0, length]
    if control in ("displacement", "rotation"):
        plane = np.stack([targets[:, 0], np.zeros(len(targets))], axis=1)
    aside, back = _leaves(plane)
    if isinstance(V, np.ndarray):
        change = np.array([0.0 if same_load(value, rest) else value - rest for value in V])
        back |= _leaves(np.stack([change, np.zeros_like(change)], axis=1))[1]
    return Turns(aside, back)


def _leaves(plane: Array) -> tuple[Marks, Marks]:
    """Return marks from the first point (n, 2) on that is off the first direction, or nearer than one before."""
    size = np.hypot(*plane.T)
    largest = float(size.max(initial=0.0))
    moved = np.flatnonzero(size > ROUNDING * largest)
    if not moved.size:
        return np.zeros(size.size, dtype=bool), np.zeros(size.size, dtype=bool)
    direction = plane[moved[0]] / size[moved[0]]
    along, across = plane @ direction, np.abs(plane @ [-direction[1], direction[0]])
    aside = across > np.sin(SAME_DIRECTION) * size + ROUNDING * largest
    back = along < np.maximum.accumulate(along) - ROUNDING * largest
    return np.logical_or.accumulate(aside), np.logical_or.accumulate(back)
