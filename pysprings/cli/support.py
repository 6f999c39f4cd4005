# SPDX-License-Identifier: MIT
"""Streams, refusals and quantities of commands."""

import io
import os
import re
import shlex
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperCommand

from pysprings.core.columns import Table
from pysprings.core.errors import Problem, UserInputError, printable, refused
from pysprings.core.progress import PlainLines, Progress, reporter
from pysprings.core.text import json_text, plain_table, suggestion
from pysprings.core.version import __version__

WRONG: list[Problem] = []  # faults of options that read quantities, of the command line that is parsed
OPTIONS: ContextVar[frozenset[str]] = ContextVar("options", default=frozenset())  # of the command, with their dashes
LOG: ContextVar[Path | None] = ContextVar("log", default=None)  # of `pysprings run --log`


def to_stderr(text: str) -> None:
    """Print a message on stderr, and in the log; characters that control a terminal are written out."""
    shown = "\n".join(map(printable, text.split("\n")))
    print(shown, file=sys.stderr, flush=True)
    _to_log(shown)


def write_log(file: Path | None) -> None:
    """Begin a log in a file, behind what it has; None: there is no log."""
    if file is None:
        return
    if file.is_dir():
        refuse("--log", "is a folder, not a file", file)
    try:
        _append(file, f"pysprings {__version__}: {shlex.join(sys.argv[1:])}")
    except OSError as error:
        refuse("--log", f"cannot be written ({error.strerror})", file)
    LOG.set(file)


def logged(progress: Progress) -> Progress:
    """Return a progress function that writes plain lines to the log, too, where there is one."""
    if LOG.get() is None:
        return progress
    lines = PlainLines(_Log())

    def both(path: str, fraction: float, message: str) -> None:
        progress(path, fraction, message)
        lines(path, fraction, message)

    return both


class _Log(io.StringIO):
    """A stream whose text goes to the log."""

    def write(self, text: str) -> int:
        if text.strip():
            _to_log(text.rstrip("\n"))
        return len(text)


def _to_log(text: str) -> None:
    file = LOG.get()
    if file is not None:
        _append(file, text)


def _append(file: Path, text: str) -> None:
    now = datetime.now(UTC).isoformat(timespec="seconds")
    with file.open("a", encoding="utf-8", newline="\n") as stream:
        stream.write("".join(f"{now} {line}\n" for line in text.split("\n")))


def print_json(data: Any) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json_text(data, indent=2))


def print_table(table: Table, most: Sequence[int] = ()) -> None:
    """Print a table in plain text; `most` are the largest widths of the first columns."""
    cells = [[printable(cell) for cell in row] for row in table.rows]
    print(plain_table([printable(head) for head in table.columns], cells, table.left, most))


def refuse(key: str | None, message: str, file: str | os.PathLike[str] | None = None) -> NoReturn:
    """Raise the error for one problem with an option or a file."""
    raise refused(key, message, file)


def quantities(given: Mapping[str, tuple[str | None, str, str]]) -> dict[str, float | None]:
    """Return SI values (None for options not given) of {option: (text or None, SI unit, example)}."""
    from pysprings.core.units import QuantityError, fault, quoted, read, slip

    values: dict[str, float | None] = {}
    problems = []
    for option, (text, si_unit, example) in given.items():
        try:
            values[option] = value = None if text is None else read(text, si_unit, example)
        except QuantityError as error:
            problems.append(Problem(key=option, message=str(error)))
            continue
        if text and value is not None and (wrong := fault(value, si_unit) or slip(text, value, si_unit)):
            problems.append(Problem(key=option, message=f"{quoted(text)} {wrong}"))
    if problems:
        raise UserInputError(problems)
    return values


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt in the block for SIGTERM and for a terminal that closes, as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    kinds = [kind for name in names if signal.getsignal(kind := getattr(signal, name)) == signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():  # only the main thread may set handlers
        kinds = []
    for kind in kinds:
        signal.signal(kind, interrupt)
    try:
        yield
    finally:
        for kind in kinds:
            signal.signal(kind, signal.SIG_DFL)


@contextmanager
def kept_in(folder: Path, quiet: bool = False) -> Iterator[Progress]:
    """Give the progress of runs below a folder; an interrupt of the block names it: what has run is kept there."""
    try:
        with interruptible(), reporter(None if quiet else sys.stderr) as progress:
            yield progress
    except KeyboardInterrupt:
        to_stderr(f"what has run is kept in {folder}; the same command goes on")
        raise


def print_files(folder: Path, meanings: Mapping[str, str]) -> None:
    """Print the files that a folder holds, with their meaning by name."""
    for name, meaning in meanings.items():
        if (folder / name).exists():
            print(f"{folder / name}: {meaning}")


class Once(TyperCommand):
    """A command that refuses an option of one value that is given twice."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; end with the code of user input where an option stands twice or is no quantity."""
        given = [text.partition("=")[0] for text in (args[: args.index("--")] if "--" in args else args)]
        WRONG.clear()
        OPTIONS.set(frozenset(name for param in self.params for name in param.opts if name.startswith("--")))
        for param in self.params:
            names = [name for name in param.opts if name.startswith("-")]
            single = not getattr(param, "multiple", False) and not getattr(param, "is_flag", False)
            if not WRONG and single and sum(given.count(name) for name in names) > 1:
                WRONG.append(Problem(key=names[0], message="is given twice: one value is needed"))
        try:
            left = [] if WRONG else super().parse_args(ctx, args)
        except typer.BadParameter as wrong:  # 'x' is not one of 'a', 'b'
            wrong.message = wrong.message.removeprefix("Value error, ")
            word, *known = re.findall(r"'([^']*)'", wrong.message) or [""]
            wrong.message += suggestion(word, known)
            raise
        if WRONG:
            error = UserInputError(WRONG)
            to_stderr(str(error))
            raise typer.Exit(error.exit_code)
        return left
