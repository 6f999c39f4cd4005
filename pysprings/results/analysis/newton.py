# SPDX-License-Identifier: MIT
"""The Newton record of a path, split in attempts: pictures and report read it from here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pysprings.results.analysis.parts import converged

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray


_STOPPED = ("partial", "limit load")


@dataclass(frozen=True)
class Attempt:
    """One try at an increment: step, number, rows in the record, iterations taken, whether the step kept it.

    The first row (iteration 0) is the residual before the first iteration.
    """

    step: int
    number: int
    rows: NDArray[np.int64]
    iterations: int
    accepted: bool


def failed_steps(path: xr.Dataset, record: xr.Dataset) -> tuple[int, ...]:
    """Return the steps of a record that were never accepted: marked so, or the one behind the last step of a path."""
    failed = {int(k) for k in np.flatnonzero(~converged(path))}
    last = int(record["increment"].values[-1]) if record.sizes["iteration"] else 0
    if path.attrs.get("status") in _STOPPED and last >= path.sizes["step"]:
        failed.add(last)
    return tuple(sorted(failed))


def attempts(record: xr.Dataset, failed_steps: tuple[int, ...] = ()) -> list[Attempt]:
    """Split a Newton record in attempts, in their order.

    The last attempt at a step is the accepted one, the earlier ones were cut back; a step in `failed_steps`
    has no accepted attempt.
    """
    step, number = record["increment"].values, record["attempt"].values
    changes = np.flatnonzero((np.diff(step) != 0) | (np.diff(number) != 0)) + 1
    blocks = [rows for rows in np.split(np.arange(step.size), changes) if rows.size]
    tries = []
    for k, rows in enumerate(blocks):
        this = int(step[rows[0]])
        last = k + 1 == len(blocks) or int(step[blocks[k + 1][0]]) != this
        taken = int(record["iteration"].values[rows].max())
        tries.append(Attempt(this, int(number[rows[0]]), rows, taken, last and this not in failed_steps))
    return tries
