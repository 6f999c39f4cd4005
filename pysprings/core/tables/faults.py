# SPDX-License-Identifier: MIT
"""Faults of a table, collected with file and line."""

from dataclasses import dataclass, field
from typing import Any

from pysprings.core.errors import Problem, UserInputError


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
