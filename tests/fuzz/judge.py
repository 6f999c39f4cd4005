# SPDX-License-Identifier: MIT
"""What hostile input may do: give a finite answer, or be refused in clear lines; everything else fails. Counts both."""

from __future__ import annotations

import io
import json
import math
import os
import re
import signal
import sys
import threading
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import typer

from pysprings.cli import app
from pysprings.macro.predict import MacroWarning

EXIT_CODES = {0: "accepted", 2: "user input", 3: "not converged", 4: "resources"}
SECONDS = 20.0  # nothing of this size may take as long, on a busy machine either
LONGEST_LINE = 1000
LINES = ("fatal: ", "warning: ", "note: ", "with M = ", "with H = ", "please report")
BEFORE_A_MESSAGE = re.compile(r"^(?:\S*?:)?(?:\d+:)*(?:\d+:)? ?")


@dataclass
class Tally:
    """How many inputs of a kind were tried, and what became of them."""

    tried: int = 0
    ends: Counter[str] = field(default_factory=Counter)
    refusals: Counter[str] = field(default_factory=Counter)


TALLIES: dict[str, Tally] = {}


class Hang(BaseException):
    """A command that does not come back."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise Hang after so many seconds, where the platform has the signal."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(*_: Any) -> None:
        raise Hang(f"no answer within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


class _Watch:
    """An audit hook (which cannot be taken out again): what is written, and where, while a command runs."""

    def __init__(self) -> None:
        self.allowed: str | None = None
        self.found: list[str] = []

    def __call__(self, event: str, args: tuple[Any, ...]) -> None:
        if self.allowed is None or event not in _EVENTS:
            return
        if event == "open":
            path, mode, flags = args
            writes = mode is not None and set(mode) & set("wax+")
            creates = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            if isinstance(path, int) or not (writes or creates):
                return
            args = (path,)
        if event == "pickle.find_class" and str(args[0]).split(".")[0] in _NUMBA_CACHE:
            return
        if event in ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "pickle.find_class"):
            self.found.append(f"{event} {args!r:.200}")
            return
        for path in args[:2] if event == "os.rename" else args[:1]:
            place = os.path.abspath(os.fsdecode(path)) if isinstance(path, str | bytes | os.PathLike) else ""
            inside = f"{place}{os.sep}".startswith((self.allowed + os.sep, "/dev/")) or "__pycache__" in place
            there_already = event == "os.mkdir" and os.path.isdir(place)
            if place and not inside and not there_already:
                self.found.append(f"{event} {place}")


_EVENTS = {
    "open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.truncate", "shutil.move",
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "pickle.find_class",
}  # fmt: skip
# Numba keeps what it has compiled as pickles, in a folder of its own.
_NUMBA_CACHE = {"numba", "llvmlite", "copyreg", "builtins", "numpy", "fe_engine", "pysprings"}
_WATCH = _Watch()
sys.addaudithook(_WATCH)


@contextmanager
def watched(folder: Path) -> Iterator[None]:
    """Fail when anything is written outside a folder, or another program is started, inside the block."""
    _WATCH.allowed, _WATCH.found = str(folder.resolve()), []
    try:
        yield
    finally:
        _WATCH.allowed = None
    assert not _WATCH.found, _WATCH.found


@dataclass
class Outcome:
    """Exit code and streams of a command."""

    code: int
    out: str
    err: str


def run(kind: str, folder: Path, *args: object) -> Outcome:
    """Run a command on hostile input; assert that it ends well or is refused clearly; count it."""
    with warnings.catch_warnings(), watched(folder), time_limit(SECONDS):
        warnings.simplefilter("error")
        warnings.simplefilter("always", MacroWarning)
        warnings.filterwarnings("always", message=".*written by another program")
        outcome = _invoked([str(arg) for arg in args])
    assert outcome.code in EXIT_CODES, (args, outcome.err)
    _clear(outcome)
    if outcome.code == 0 and "--json" in args and args[0] in ("predict", "check"):
        _finite(json.loads(outcome.out))
    count(kind, outcome)
    return outcome


@cache
def _command() -> Any:
    """The command line, put together once."""
    return typer.main.get_command(app.app)


def _invoked(args: list[str]) -> Outcome:
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            _command().main(args, prog_name="pysprings")
            code: Any = 0
        except SystemExit as end:
            code = end.code or 0
    return Outcome(code, out.getvalue(), err.getvalue())


def _clear(outcome: Outcome) -> None:
    """Assert that messages are printable lines, one a problem, none too long, and that refusals have one."""
    lines = outcome.err.splitlines()
    for line in lines:
        assert line.isprintable(), line
        assert len(line) <= LONGEST_LINE, line
        assert "Traceback" not in line, outcome.err
    assert outcome.err.count("\n") == len(lines), "line breaks inside a line"
    if outcome.code:
        assert any(line.startswith("fatal: ") for line in lines), outcome.err
    assert "bug" not in outcome.err.split(":")[1:2], outcome.err


def _finite(data: Any, place: str = "") -> None:
    """Assert that an answer has no number that is missing; `attributes` and limits may."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key not in ("attributes", "path_distance"):
                _finite(value, f"{place}.{key}")
    elif isinstance(data, list):
        for value in data:
            _finite(value, place)
    else:
        assert data is not None and (not isinstance(data, float) or math.isfinite(data)), f"{place} is {data}"


def count(kind: str, outcome: Outcome) -> None:
    """Add an outcome to the tally of its kind."""
    tally = TALLIES.setdefault(kind, Tally())
    tally.tried += 1
    tally.ends[EXIT_CODES[outcome.code]] += 1
    for line in {_sort(line) for line in outcome.err.splitlines() if line.startswith("fatal: ")}:
        tally.refusals[line] += 1


def _sort(line: str) -> str:
    """Reduce a message to its words: no file, place, quotation or number."""
    text = re.sub(r"^fatal: [a-z ]+: ", "", line)
    text = re.sub(r"\"(?:[^\"\\]|\\.)*\"|'[^']*'", "~", text)
    text = text.rsplit(": ", 1)[-1] if text.count(": ") else text
    return re.sub(r"[-+]?[0-9][0-9.,e+]*", "#", text)[:50].strip()


def report(write: Any) -> None:
    """Write all tallies."""
    for kind, tally in sorted(TALLIES.items()):
        ends = ", ".join(f"{number} {end}" for end, number in tally.ends.most_common())
        write(f"{kind}: {tally.tried} tried: {ends}")
        for words, number in tally.refusals.most_common(8):
            write(f"    {number:5d}  {words}")
