# SPDX-License-Identifier: MIT
"""Faults of a table, collected with file and line, and the numbers of a column."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.magnitudes import fault, unit_of_column
from pysprings.core.spreadsheets import Doubtful
from pysprings.core.units import quoted


@dataclass
class Faults:
    """All faults found so far; `stop` raises them."""

    problems: list[Problem] = field(default_factory=list)
    _seen: set[tuple[Any, ...]] = field(default_factory=set)

    def add(self, place: tuple[str, int | None], key: str | None, message: str) -> None:
        """Note one problem at (file, line); the first one of a cell counts."""
        if (*place, key) not in self._seen:
            self._seen.add((*place, key))
            self.problems.append(Problem(file=place[0], line=place[1], key=key, message=message))

    def at(self, row: Any, key: str | None, message: str) -> None:
        """Note one problem in a row of a table (a named tuple with file and line)."""
        self.add((str(row.file), int(row.line)), key, message)

    def stop(self) -> None:
        """Raise UserInputError when there is any problem."""
        if not self.problems:
            return
        problems = sorted(self.problems, key=lambda each: (each.file or "", each.line or 0))
        raise UserInputError(problems)


def numbers(
    place: str, name: str, given: list[Any], lines: np.ndarray, faults: Faults, factor: float = 1.0
) -> np.ndarray:
    """Return the numbers of a column, times the factor to SI.

    NaN where a cell is blank, no number, or out of every physical range.
    """
    unit = unit_of_column(name)
    out = np.full(len(given), np.nan)
    for k, cell in enumerate(given):
        if cell is None or (isinstance(cell, str) and not cell.strip()):
            continue
        if isinstance(cell, Doubtful):
            faults.add((place, int(lines[k])), name, f"{quoted(cell)} {cell.why}")
            continue
        try:
            value = float(cell) * factor
        except (TypeError, ValueError):
            faults.add((place, int(lines[k])), name, f"{quoted(cell)} is not a number")
            continue
        if wrong := fault(value, unit):
            faults.add((place, int(lines[k])), name, f"{quoted(cell)} {wrong}")
            continue
        out[k] = value
    return out
