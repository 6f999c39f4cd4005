# SPDX-License-Identifier: MIT
"""Streams, refusals and quantities of commands."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

from pysprings.core.errors import Problem, UserInputError, printable, refused
from pysprings.core.text import json_text, plain_table


def to_stderr(text: str) -> None:
    """Print a message on stderr; characters that control a terminal are written out."""
    print("\n".join(map(printable, text.split("\n"))), file=sys.stderr, flush=True)


def print_json(data: Any) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json_text(data, indent=2))


def print_table(headers: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool] = (True,)) -> None:
    """Print a table in plain text; columns are set to the right, but for those marked in `left` (the first one)."""
    cells = [[printable(cell) for cell in row] for row in rows]
    print(plain_table([printable(head) for head in headers], cells, left))


def refuse(key: str | None, message: str, file: str | os.PathLike[str] | None = None) -> NoReturn:
    """Raise the error for one problem with an option or a file."""
    raise refused(key, message, file)


def quantities(given: Mapping[str, tuple[str | None, str, str]]) -> dict[str, float | None]:
    """Return SI values (None for options not given) of {option: (text or None, SI unit, example)}."""
    from pysprings.core.magnitudes import fault, slip
    from pysprings.core.units import QuantityError, quoted, read

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
