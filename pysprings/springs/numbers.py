# SPDX-License-Identifier: MIT
"""What a spring file from anywhere must be before its physics is checked: types, sizes and names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.files.written import is_device
from pysprings.core.magnitudes import LARGEST, SMALLEST_AT_ALL

LABELS = ("side", "component", "dof", "dof_conjugate")
_UNITS = {"radian": "rad", "N m-1": "N/m", "N m m-1": "N m/m"}  # UDUNITS text -> key of LARGEST

MOST_LETTERS = 60
_NOT_FIRST = "=+-@. "  # a spreadsheet would read a formula, a shell an option, a folder something else


def name_fault(name: str) -> str:
    """Return what is wrong with the name of a path in a file; empty where nothing is."""
    if not name.isprintable() or "/" in name:
        return "a path's name has no '/' and no invisible characters"
    if name.startswith(tuple(_NOT_FIRST)) or len(name) > MOST_LETTERS:
        return f"a path's name has at most {MOST_LETTERS} characters, the first of them none of = + - @ . and blank"
    if is_device(name) or name.endswith((".", " ")):
        return (
            "a path's name names files, too: Windows refuses this one (CON, NUL, COM1 ..., or '.' or blank at its end)"
        )
    return ""


def is_number(value: Any) -> bool:
    """Return whether an attribute is one finite number."""
    return isinstance(value, int | float | np.number) and bool(np.isfinite(value))


def text_of(value: Any) -> str:
    """Return an attribute that should be a text; empty where it is something else."""
    return value if isinstance(value, str) else ""


def number_faults(dataset: xr.Dataset, group: str) -> Iterator[tuple[str, str]]:
    """Yield (variable, message) for variables of a group of `variables.GROUPS` that are no numbers, or too large."""
    for key, data in dataset.variables.items():
        name = str(key)
        if name in LABELS:
            continue
        if data.dtype.kind not in "iufb":
            yield name, f"holds no numbers (type {data.dtype})"
            continue
        known = variables.GROUPS[group].get(name)
        units = known.units if known else "1"
        largest = LARGEST.get(_UNITS.get(units, units), np.inf)
        if group == "springs_root":  # a stiffness of mixed units
            largest = 1e30
        values = np.abs(data.values.astype(float))
        worst = float(values[np.isfinite(values)].max(initial=0.0))
        least = float(values[values > 0.0].min(initial=np.inf))
        if worst > largest:
            yield name, f"{worst:.3g} is beyond {largest:.0e} {units}"
        elif least < SMALLEST_AT_ALL:
            yield name, f"{least:.3g} is too small to be anything but 0"
