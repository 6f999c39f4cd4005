# SPDX-License-Identifier: MIT
"""What a reader of table files declares (light)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pysprings.core.errors import Problem, UserInputError

MOST_BYTES = 50_000_000  # of a file, of a workbook when unpacked

Line = tuple[int, list[Any]]  # number of the line, as editors count, and its cells


class Sheet(NamedTuple):
    """Lines of one table that are not blank; `name` is blank where a file holds one table."""

    name: str
    lines: list[Line]


@dataclass(frozen=True, slots=True)
class TableReader:
    """A file format of tables.

    Attributes
    ----------
    name
        Name of the format.
    suffixes
        Endings of its files, with the dot, in lower case.
    sheets
        Path of a file that exists -> its tables; raises UserInputError for a file that is broken or too large.
    """

    name: str
    suffixes: tuple[str, ...]
    sheets: Callable[[Path], Iterator[Sheet]]


def refuse_large(path: Path, size: int, words: str = "") -> None:
    """Raise UserInputError for more than `MOST_BYTES`."""
    if size > MOST_BYTES:
        raise too_large(path, f"{size / 1e6:,.0f} MB{words}, at most {MOST_BYTES / 1e6:.0f}")


def too_large(path: Path, message: str) -> UserInputError:
    """Return the error for a table beyond a limit."""
    return UserInputError([Problem(file=str(path), message=f"is too large for a table ({message})")])
