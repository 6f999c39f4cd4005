# SPDX-License-Identifier: MIT
"""The way of the macro-model through loads or motions, as a dataset by step with its marks."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.macro.answer import Way, answer_dataset
from pysprings.macro.history import Control, turns
from pysprings.macro.limit import Limit, range_limit
from pysprings.macro.model import MacroModel

Array = NDArray[np.float64]


def trace(
    model: MacroModel,
    control: Control,
    targets: Array,
    arm: float = 0.0,
    V: float | Array | None = None,
    time: Array | None = None,
) -> xr.Dataset:
    """Return the answer of `MacroModel.solve` as a dataset by step, marked where the springs do not support it.

    A way that ends early holds the steps reached; `status` is then "partial" and `message` has the place.
    V [N] is one number, or one a target; time [s] one a target, from rest at 0 s.
    """
    targets = np.asarray(targets, dtype=float)
    states, loads, message = model.solve(control, targets, arm, V=V)
    down = V[: len(states)] if isinstance(V, np.ndarray) else V

    if model.memory is not None:  # turns are what it is made for
        at = None if time is None else time[: len(states)]
        answer = answer_dataset(model, Way(states, loads, control, down, float(arm), message, time=at))
        return answer.assign_attrs(warnings=[*answer.attrs["warnings"], *model.memory.notes(states)])

    def limit(first: int) -> Limit:
        return range_limit(model, control, targets[: first + 1], arm, states[:first])

    aim = targets[len(states)] if control == "load" and len(states) < len(targets) else None
    turned = turns(control, targets[: len(states)], model.length, down, model.rest_load)
    return answer_dataset(model, Way(states, loads, control, down, float(arm), message, aim, turned, limit))


def timed(model: MacroModel, answer: xr.Dataset, time: Array) -> xr.Dataset:
    """Return an answer with the time (n,) [s] of its states; springs with memory mark steps at another rate.

    The way begins at rest at 0 s. An answer that ends early has the times of the states reached.
    """
    known, n = variables.GROUPS["prediction"], answer.sizes["step"]
    found = answer.assign(time=("step", time[:n], known["time"].attributes()))
    memory = model.memory
    if memory is None or memory.rate is None:
        return found
    states = np.stack([answer["u"].values, answer["rotation"].values], axis=1)
    off = memory.off_rates(states, time[:n])
    found = found.assign(off_rate=("step", off.astype(np.int8), known["off_rate"].attributes()))
    if not off.any():
        return found
    text = f"{off.sum()} of {n} steps are at another rate than that of the elements"
    return found.assign_attrs(warnings=[*answer.attrs["warnings"], text])
