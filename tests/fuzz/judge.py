# SPDX-License-Identifier: MIT
"""What hostile input may do: give a finite answer, or be refused in clear lines; everything else fails. Counts both."""

import io
import json
import math
import re
import warnings
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import typer

from pysprings.cli import app
from pysprings.macro.predict import MacroWarning
from tests.support.watch import time_limit, watched

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
        warnings.filterwarnings("always", message=".*by another program")
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
    return typer.main.get_command(app.application())


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
