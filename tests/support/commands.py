# SPDX-License-Identifier: MIT
"""Run the command line in this process, and Python in a fresh one."""

import os
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

from typer.testing import CliRunner

from pysprings.cli import app
from tests.support.place import ROOT


@dataclass(frozen=True)
class Result:
    """Exit code and streams of a command."""

    code: int
    out: str
    err: str


def command(*args: object, **options: Any) -> Result:
    """Run `pysprings` with these arguments; raise an exception that the tool does not turn into an exit code."""
    done = CliRunner().invoke(app.application(), [str(arg) for arg in args], prog_name="pysprings", **options)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert "Traceback" not in done.stderr or "--debug" in args
    return Result(done.exit_code, done.stdout, done.stderr)


def environment(**more: str) -> dict[str, str]:
    """Return the environment in which a fresh interpreter finds the source tree, and runs on one thread."""
    return {"NUMBA_NUM_THREADS": "1", **os.environ, "PYTHONPATH": str(ROOT), **more}


def run_python(*args: object, limit: float = 60.0, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a fresh interpreter on the source tree, for at most ``limit`` seconds."""
    line = [sys.executable, *(str(arg) for arg in args)]
    given = {"env": environment(), "capture_output": True, "text": True, "timeout": limit, **options}
    return subprocess.run(line, **given)
