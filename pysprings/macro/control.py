# SPDX-License-Identifier: MIT
"""Ways to drive the rigid body: the equations of each for `pysprings.macro.solver`, and words for where it ended."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.solver import Drive

Array = NDArray[np.float64]
Control = Literal["displacement", "rotation", "load", "state"]


def equations(control: Control, targets: Array, arm: float, size: Array) -> tuple[Drive, Array]:
    """Return the equations of a control and their right sides c (n, 2): see `pysprings.macro.solver`.

    size (2,) is that of H [N] and M [N m], for tolerances; arm [m] the height of the load.
    """
    zero, one = np.zeros((2, 2)), np.eye(2)
    if control == "load":
        return Drive(zero, one, size), targets
    motion = np.maximum(np.abs(targets).max(axis=0), 1e-12)
    if control == "state":
        return Drive(one, zero, motion), targets
    row = 0 if control == "displacement" else 1
    G, C = zero.copy(), np.array([[0.0, 0.0], [arm, 1.0]])
    G[0, row] = 1.0
    aims = np.stack([targets[:, 0], np.zeros(len(targets))], axis=1)
    return Drive(G, C, np.array([motion[0], size[1] + abs(arm) * size[0]])), aims


def ending(control: Control, reached: tuple[float, float], target: Array, states: Array, loads: Array) -> str:
    """Return words for where a way ended: what was held, what was aimed at next, the last state."""
    words = {
        "displacement": ("u = {:.6g} m",),
        "rotation": ("rotation = {:.6g} rad",),
        "load": ("H = {:.6g} N", "M = {:.6g} N m"),
        "state": ("u = {:.6g} m", "rotation = {:.6g} rad"),
    }[control]
    got, aim = (", ".join(w.format(x) for w, x in zip(words, values, strict=False)) for values in (reached, target))
    last = "no step was reached"
    if len(states):
        (u, rotation), (H, M) = states[-1], loads[-1]
        last = f"last step: u = {u:.6g} m, rotation = {rotation:.6g} rad, H = {H:.6g} N, M = {M:.6g} N m"
    return f"macro-model: no equilibrium beyond {got} on the way to {aim}; {last}"
