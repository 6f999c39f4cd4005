# SPDX-License-Identifier: MIT
"""Errors of the tool, each with the exit code of the command line (light: imports nothing heavy).

Exit codes: 0 ok; 1 a bug; 2 user input; 3 not converged; 4 resources; 130 interrupted.
"""

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pysprings.core.words import StopReason

EXIT_BUG = 1
EXIT_USER_INPUT = 2
EXIT_NOT_CONVERGED = 3
EXIT_RESOURCES = 4
EXIT_INTERRUPTED = 130


def printable(text: object) -> str:
    """Return text on one line: line breaks, escape sequences and invisible characters are written out."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in str(text))


MOST_PROBLEMS = 20  # lines of a message: a broken file may have thousands
MOST_LETTERS = 900  # of a message: what it quotes may be a whole file
LONGEST_WORD = 120


def shortened(text: str) -> str:
    """Return a message with long words cut, and where that is not enough its middle: its remedy stands at its end."""
    text = re.sub(rf"\S{{{LONGEST_WORD},}}", lambda found: f"{found[0][: LONGEST_WORD - 3]}...", text)
    half = MOST_LETTERS // 2 - 3
    return text if len(text) <= MOST_LETTERS else f"{text[:half]} ... {text[-half:]}"


@dataclass(frozen=True)
class Problem:
    """One thing wrong with what the user gave; `str()` is `file:line:col: key: message` (known parts only).

    line and col count from 1, in characters.
    """

    file: str | None = None
    line: int | None = None
    col: int | None = None
    key: str | None = None
    message: str = ""

    def __str__(self) -> str:
        place = [str(part) for part in (self.file, self.line, self.col) if part is not None]
        parts = [":".join(place), shortened(self.key or ""), shortened(self.message)]
        return printable(": ".join(part for part in parts if part))


class PyspringsError(Exception):
    """Base of the tool's own errors."""

    exit_code = EXIT_BUG


class UserInputError(PyspringsError):
    """The user's input is refused; `problems` lists everything that is wrong with it.

    `str()` has one line per problem: `fatal: user input: file:line:col: key: message`; the first lines of many.
    """

    exit_code = EXIT_USER_INPUT

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: Sequence[Problem] = tuple(problems)
        super().__init__(self.problems)

    @property
    def lines(self) -> list[str]:
        """One line per problem, the first ones of many."""
        lines = [str(problem) for problem in self.problems[:MOST_PROBLEMS]]
        if (left := len(self.problems) - MOST_PROBLEMS) > 0:
            lines.append(f"and {left:,} more problems")
        return lines

    def __str__(self) -> str:
        return "\n".join(f"fatal: user input: {line}" for line in self.lines)


def refused(key: str | None, message: str, file: str | os.PathLike[str] | None = None) -> UserInputError:
    """Return the error for one problem with an argument, an option, a file, or a key of it."""
    return UserInputError([Problem(None if file is None else str(file), key=key, message=message)])


class BeyondSprings(UserInputError):
    """A prediction was asked for where the springs hold no answer; the message has what they carry, and from where."""


class ResourceError(PyspringsError):
    """Memory, disk or a library is not there; the message names it and what would help."""

    exit_code = EXIT_RESOURCES


class RunIncomplete(PyspringsError):
    """A run that stopped before its end; what converged is saved and marked in `folder` (None: not saved).

    `reasons` are those of the paths that stopped, where they are known.
    """

    exit_code = EXIT_NOT_CONVERGED
    words = "not converged", "what converged is"

    def __init__(
        self, message: str, folder: str | os.PathLike[str] | None = None, reasons: Iterable[StopReason] = ()
    ) -> None:
        super().__init__(message)
        self.folder = None if folder is None else Path(folder)
        self.reasons = tuple(reasons)


class TargetMissed(RunIncomplete):
    """A run that converged, and whose own estimate of its error is above the target or not known."""

    words = "target missed", "the results are"


def reason_of(error: BaseException) -> str:
    """Return an error as one line; with its kind, where it is none of this program."""
    if isinstance(error, UserInputError):
        return printable("; ".join(error.lines))
    return printable(f"{'' if isinstance(error, PyspringsError) else f'{type(error).__name__}: '}{error}")


@contextmanager
def following(what: str) -> Iterator[None]:
    """Turn an error of the block, which shows results that are written, into a warning that names what is missing."""
    try:
        yield
    except Exception as error:
        warnings.warn(
            f"{what} not made ({reason_of(error)}); the results are kept, the same command goes on", stacklevel=3
        )


def out_of_memory(error: MemoryError) -> str:
    """Return one line for memory that was refused, with the figures where the error has them."""
    return f"out of memory: {printable(error)}" if str(error) else "out of memory"
