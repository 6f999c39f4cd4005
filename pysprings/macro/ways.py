# SPDX-License-Identifier: MIT
"""Ways through loads or motions: how they are driven, and where they leave what springs are calibrated on.

Calibration paths keep the ratio of rotation to u, or of M to H, and grow. A sequence that turns aside or back meets
soil that has yielded; the springs have no memory of that. From such a state on every answer is marked. Beyond their
range springs have no answer: `range_limit` finds the largest load within it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import refused
from pysprings.core.loads import loads_in_words, same_loads
from pysprings.core.units import quoted
from pysprings.macro.solver import Drive
from pysprings.springs.path import SAME_DIRECTION

if TYPE_CHECKING:
    from pysprings.macro.response import Level, Response

Control = Literal["displacement", "rotation", "load", "state"]


def equations(control: Control, targets: Array, arm: float, size: Array) -> tuple[Drive, Array]:
    """Return the equations of a control and their right sides c (n, 2): see `pysprings.macro.solver`.

    size (2,) is that of H [N] and M [N m], for tolerances; arm [m] the height of the load. Raises UserInputError for
    another control.
    """
    if control not in get_args(Control):
        raise refused("control", f"expected one of {', '.join(get_args(Control))}, not {quoted(str(control))}")
    zero, one = np.zeros((2, 2)), np.eye(2)
    if control == "load":
        return Drive(zero, one, size), targets
    motion = np.maximum(np.abs(targets).max(axis=0), 1e-12)
    if control == "state":
        return Drive(one, zero, motion), targets
    row = 0 if control == "displacement" else 1
    G, C = zero.copy(), np.array([[0.0, 0.0], [-arm, 1.0]])
    G[0, row] = 1.0
    aims = np.stack([targets[:, 0], np.zeros(len(targets))], axis=1)
    return Drive(G, C, np.array([motion[0], size[1] + abs(arm) * size[0]])), aims


# Targets below this share of the largest one have no direction, and steps back below it are none.
ROUNDING = 1e-9
RANGE_SLACK = 1e-6  # share by which a spring may exceed its range before it counts as extrapolated (rounding)
MOTION_UNITS = {"u": "m", "rotation": "rad"}
# What the columns of targets hold, as far as they are read
COLUMNS = {"load": ("H", "M"), "state": ("u", "rotation"), "displacement": ("u",), "rotation": ("rotation",)}


def ending(control: Control, reached: tuple[float, float], target: Array, states: Array, loads: Array) -> str:
    """Return words for where a way ended: what was held, what was aimed at next, the last state."""
    got, aim = (
        loads_in_words(*each)
        if control == "load"
        else ", ".join(
            f"{name} = {x:.6g} {MOTION_UNITS[name]}" for name, x in zip(COLUMNS[control], each, strict=False)
        )
        for each in (reached, target)
    )
    last = "no step was reached"
    if len(states):
        u, rotation = states[-1]
        last = f"last step: u = {u:.6g} m, rotation = {rotation:.6g} rad, {loads_in_words(*loads[-1])}"
    return f"macro-model: no equilibrium beyond {got} on the way to {aim}; {last}"


BISECTIONS = 40

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


def turns(control: Control, targets: Array, length: float, V: Level, rest: float) -> Turns:
    """Return where targets (n, 2) of a control turn aside or back, on their way from the origin.

    The direction is that of (H, M/length) or (u, rotation*length); of one motion its sign. A vertical load by row,
    V (n,) [N], that comes back towards the one at rest [N] turns back, too.
    """
    plane = targets / [1.0, length] if control == "load" else targets * [1.0, length]
    if control in ("displacement", "rotation"):
        plane = np.stack([targets[:, 0], np.zeros(len(targets))], axis=1)
    aside, back = _leaves(plane)
    if isinstance(V, np.ndarray):
        change = np.where(same_loads(V, rest), 0.0, V - rest)
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


@dataclass(frozen=True, slots=True)
class Limit:
    """Last state within the range of the springs: u [m], rotation [rad], and its loads H [N], M [N m]."""

    u: float
    rotation: float
    H: float
    M: float

    def attributes(self) -> dict[str, float]:
        """Return the limit as attributes of an answer."""
        return {"limit_H_N": self.H, "limit_M_Nm": self.M, "limit_u_m": self.u, "limit_rotation_rad": self.rotation}

    def __str__(self) -> str:
        return (
            f"within their range they carry {loads_in_words(self.H, self.M)} "
            f"(at u = {self.u:.4g} m, rotation = {self.rotation:.4g} rad)"
        )


@dataclass(frozen=True, slots=True)
class Along:
    """What of a way is to be marked.

    aim : load (H, M) that was not carried where the way ended before it.
    turned : marks of states after a turn of the way.
    limit : returns the largest load within the range of the springs, given the number of the first state beyond it.
    notes : further sentences on the way.
    """

    aim: Array | None = None
    turned: Turns | None = None
    limit: Callable[[int], Limit] | None = None
    notes: tuple[str, ...] = ()


def range_limit(response: Response, control: Control, targets: Array, arm: float, states: Array) -> Limit:
    """Return where the way to the last of some targets (n, 2) leaves the range, by bisection of its last piece.

    states (n-1, 2) are those of the targets before it, all of them within the range.
    """
    origin = np.zeros((1, 2))
    before, state = np.concatenate([origin, targets[:-1]])[-1], np.concatenate([origin, states])[-1]
    last, load = state, response.loads_at(*state)[0]
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        aim = before + middle * (targets[-1] - before)
        reached, loads, message = response.go_on(control, aim[None], arm, (state, before))
        if not message and response.range_used(reached)[0] <= 1.0 + RANGE_SLACK:
            low, last, load = middle, reached[0], loads[0]
        else:
            high = middle
    return Limit(float(last[0]), float(last[1]), float(load[0]), float(load[1]))
