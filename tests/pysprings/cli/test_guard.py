# SPDX-License-Identifier: MIT
"""Errors of commands: one line on stderr, the exit code, the traceback on request."""

import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from fe_engine.errors import MeshError, NotConverged
from pysprings.cli.guard import DEBUG, guarded
from pysprings.core.errors import Problem, ResourceError, RunIncomplete, TargetMissed, UserInputError
from pysprings.springs.checks import save_springs
from tests.support import synthetic
from tests.support.commands import environment


def failing(error: BaseException) -> Callable[[], None]:
    def fail() -> None:
        raise error

    return guarded(fail)


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (UserInputError([Problem(key="--H", message="missing")]), 2, "fatal: user input: --H: missing\n"),
        (
            RunIncomplete("pull: stopped at 3 mm", "out/caisson"),
            3,
            "fatal: not converged: pull: stopped at 3 mm\nwhat converged is kept in out/caisson\n",
        ),
        (
            TargetMissed("--target-error 2%: the run's own estimate is 3 %", "out"),
            3,
            "fatal: target missed: --target-error 2%: the run's own estimate is 3 %\nthe results are kept in out\n",
        ),
        (NotConverged("no balance", "node 3"), 3, "fatal: not converged: no balance (node 3)\n"),
        (
            ModuleNotFoundError("No module named 'numba'", name="numba"),
            4,
            "fatal: resources: this needs the package numba, which is not installed\n",
        ),
        (MeshError("inverted element 7"), 2, "fatal: user input: mesh: inverted element 7\n"),
        (ResourceError("pardiso is not installed"), 4, "fatal: resources: pardiso is not installed\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (MemoryError(), 4, "fatal: resources: out of memory; try a smaller mesh (`pysprings check` estimates)\n"),
        (OSError(28, "No space left on device", "x.nc"), 4, "fatal: resources: x.nc: No space left on device\n"),
        (
            ZeroDivisionError("a\nb"),
            1,
            "fatal: bug: ZeroDivisionError: a\\nb\nplease report it; `pysprings --debug ...` shows where\n",
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
def test_errors(capsys: pytest.CaptureFixture[str], error: BaseException, code: int, message: str) -> None:
    with pytest.raises(typer.Exit) as end:
        failing(error)()
    assert end.value.exit_code == code
    assert capsys.readouterr() == ("", message)


def test_debug_shows_the_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    token = DEBUG.set(True)
    try:
        with pytest.raises(typer.Exit):
            failing(ZeroDivisionError("oops"))()
    finally:
        DEBUG.reset(token)
    err = capsys.readouterr().err
    assert "Traceback" in err
    assert err.endswith("fatal: bug: ZeroDivisionError: oops\nplease report it\n")


def test_warnings_are_one_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    def warn() -> None:
        warnings.warn("30,000 unknowns with SuperLU", stacklevel=1)

    with warnings.catch_warnings():
        warnings.simplefilter("always")
        guarded(warn)()
    assert capsys.readouterr() == ("", "warning: 30,000 unknowns with SuperLU\n")


@pytest.mark.slow
def test_reader_that_stops_early_is_no_error(tmp_path: Path) -> None:
    springs_file = save_springs(synthetic.make_springs(), tmp_path / "springs.nc")
    command = f"'{sys.executable}' -m pysprings springs '{springs_file}' | head -n 1; echo ${{PIPESTATUS[0]}}"
    env = environment()
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=env, timeout=60, check=True)
    assert done.stdout.splitlines()[1] == "0"
    assert done.stderr == ""
