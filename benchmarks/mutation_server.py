# SPDX-License-Identifier: MIT
"""Runs pytest in forks of a process that has loaded the libraries, so that no call loads them anew.

As a program it reads one request a line from stdin, JSON with ``folder``, ``arguments`` of pytest, ``settings`` of the
environment and ``seconds``, and answers with one line: exit code (None after a timeout) and the printed text. The
packages under test are not loaded before the fork.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

# third-party libraries that most tests load
LOADED = (
    "pytest", "hypothesis", "numba", "scipy.optimize", "scipy.interpolate", "scipy.sparse.linalg", "scipy.spatial",
    "xarray", "pandas", "netCDF4", "matplotlib.figure", "matplotlib.backends.backend_agg", "pydantic", "pint", "typer",
    "typer.testing", "rich.console", "jinja2", "openpyxl", "xlsxwriter",
)  # fmt: skip


class Server:
    """The process that forks; one for each worker."""

    def __init__(self, threads: int = 1) -> None:
        many = {f"{name}_NUM_THREADS": str(threads) for name in ("OMP", "MKL", "NUMBA")}
        self._process = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, **many},
        )  # fmt: skip

    def run(
        self, folder: Path, arguments: Sequence[str], settings: Mapping[str, str], seconds: float
    ) -> tuple[int | None, str]:
        """Run pytest in a folder; return its exit code (None after a timeout) and what it printed."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None and stdout is not None
        request = {"folder": str(folder), "arguments": [*arguments], "settings": {**settings}, "seconds": seconds}
        stdin.write(json.dumps(request) + "\n")
        stdin.flush()
        code, text = json.loads(stdout.readline())
        return code, text

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def _serve() -> None:
    """Answer requests until stdin is closed."""
    for name in LOADED:
        import_module(name)
    for line in sys.stdin:
        print(json.dumps(_forked(json.loads(line))), flush=True)


def _forked(request: Mapping[str, Any]) -> tuple[int | None, str]:
    with tempfile.TemporaryFile() as out:
        child = os.fork()
        if not child:
            _run(request, out.fileno())
        code = _wait(child, request["seconds"])
        out.seek(0)
        return code, out.read().decode(errors="replace")


def _wait(child: int, seconds: float) -> int | None:
    """Return the exit code of a child; end it, and all that it has started, after so many seconds."""

    def late(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    except TimeoutError:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _run(request: Mapping[str, Any], out: int) -> None:
    """Run pytest in the child, as a program in that folder would; does not return."""
    import numba
    import pytest

    os.setsid()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    sys.dont_write_bytecode = True  # a source may change twice within a second
    for stream in (1, 2):
        os.dup2(out, stream)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.chdir(request["folder"])
    os.environ.update(request["settings"])
    numba.core.config.reload_config()
    sys.path[:] = [request["folder"], *[place for place in sys.path if place != str(Path(__file__).parent)]]
    code = 3
    try:
        code = int(pytest.main(list(request["arguments"])))
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    _serve()
