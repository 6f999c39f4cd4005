# SPDX-License-Identifier: MIT
"""The exit codes of the contract, each by the installed command in a process of its own.

130 by a real Ctrl-C is in test_folder.py.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from fe_engine.errors import SettingError
from fe_engine.settings import MOST_THREADS, refuse_bad_settings
from pysprings.springs.checks import save_springs
from tests.support import synthetic
from tests.support.commands import environment

# the command with a run that ends otherwise (and without what takes so long to load)
REPLACED = """
import os, signal, sys, types
def end(*_, **__):
    {end}
sys.modules["pysprings.results.folder"] = types.ModuleType("pysprings.results.folder")
folder = sys.modules["pysprings.results.folder"]
folder.run_to_folder, folder.Writing = end, (lambda *_, **__: None)
from pysprings.cli.app import main
main()
"""


def pysprings(
    *args: object, end: str = "", cwd: Path, env: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the command; ``end`` is a statement that stands for the computation."""
    how = ["-c", REPLACED.format(end=end)] if end else ["-m", "pysprings"]
    line = [sys.executable, *how, *(str(arg) for arg in args)]
    return subprocess.run(line, capture_output=True, text=True, cwd=cwd, env=environment(**(env or {})), timeout=120)


@pytest.mark.parametrize(
    ("end", "code", "words"),
    [
        ("raise ZeroDivisionError('oops')", 1, "fatal: bug: ZeroDivisionError: oops"),
        ("raise OSError(28, 'No space left on device', 'x')", 4, "fatal: resources: x: No space left on device"),
        ("os.kill(os.getpid(), signal.SIGINT); signal.pause()", 130, "interrupted"),
        ("os.kill(os.getpid(), signal.SIGTERM); signal.pause()", 130, "interrupted"),
    ],
    ids=["bug", "disk", "Ctrl-C", "SIGTERM"],
)
def test_ends_of_a_run(tmp_path: Path, scene_file: Path, end: str, code: int, words: str) -> None:
    """In a process of its own; `test_guard.py` has every kind of error."""
    if "signal" in end and os.name == "nt":
        pytest.skip("signals are different there")
    # a shell that puts its jobs in the background has them ignore Ctrl-C
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        done = pysprings("run", scene_file, "--out", "out", end=end, cwd=tmp_path)
    finally:
        signal.signal(signal.SIGINT, before)
    assert done.returncode == code, done.stderr
    assert done.stderr.splitlines()[0].startswith(words)
    assert done.stdout == "" and "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_2_user_input(tmp_path: Path) -> None:
    done = pysprings("run", "nothing.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (2, "fatal: user input: nothing.toml: no such file\n")


@pytest.mark.parametrize("text", ["0", "abc"])
def test_2_a_number_of_threads_that_is_none(tmp_path: Path, scene_file: Path, text: str) -> None:
    """Issue: a bug message, or a traceback of Numba."""
    done = pysprings("check", scene_file, cwd=tmp_path, env={"NUMBA_NUM_THREADS": text})
    message = f"NUMBA_NUM_THREADS: {text!r} is not a number of threads: a whole number, 1 to {MOST_THREADS}"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"fatal: user input: {message}\n")


def test_numbers_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    for text in ("1", " 8 ", str(MOST_THREADS)):
        monkeypatch.setenv("NUMBA_NUM_THREADS", text)
        refuse_bad_settings()
    for text in ("", "0", "-1", "2.5", "two", str(MOST_THREADS + 1)):
        monkeypatch.setenv("NUMBA_NUM_THREADS", text)
        with pytest.raises(SettingError, match="is not a number of threads"):
            refuse_bad_settings()


def test_0_ok_and_one_prediction_needs_no_threads(tmp_path: Path) -> None:
    file = save_springs(synthetic.make_springs(), tmp_path / "springs.nc")
    done = pysprings("predict", file, "--H", "1 MN", cwd=tmp_path, env={"NUMBA_NUM_THREADS": "abc"})
    assert (done.returncode, done.stderr) == (0, "")
    many = pysprings("predict", file, "--u-max", "1 mm", "--points=20", cwd=tmp_path, env={"NUMBA_NUM_THREADS": "abc"})
    assert many.returncode == 2 and "NUMBA_NUM_THREADS" in many.stderr


# --- closed standard streams ---


def without(closed: str, *args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command by a shell that closes a stream, say ``>&-``."""
    if os.name == "nt":
        pytest.skip("needs a POSIX shell")
    python = [sys.executable, "-m", "pysprings", *(str(arg) for arg in args)]
    env = environment()
    line = ["sh", "-c", f'exec "$@" {closed}', "sh", *python]
    return subprocess.run(line, capture_output=True, text=True, cwd=cwd, env=env, timeout=120)


@pytest.mark.slow
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_is_no_bug(tmp_path: Path, closed: str) -> None:
    done = without(closed, "init", "a.toml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.toml").exists()
    assert done.stdout.startswith("a.toml") == (">&-" not in closed.split())
    assert done.stderr.startswith("next: ") == ("2>&-" not in closed)


@pytest.mark.slow
def test_a_run_with_closed_streams_computes_all(tmp_path: Path, scene_file: Path) -> None:
    done = without(">&- 2>&-", "run", scene_file, "--out", "out", cwd=tmp_path)
    assert done.returncode == 0
    assert (tmp_path / "out" / "springs.nc").exists()


@pytest.mark.slow
def test_warnings_do_not_go_among_the_data(tmp_path: Path) -> None:
    """Issue: with stderr closed they went to stdout, in front of the JSON."""
    file = save_springs(synthetic.make_springs(), tmp_path / "springs.nc")
    args = ("predict", file, "--H", "100 MN", "--extrapolate", "--json")
    whole, shut = (without(closed, *args, cwd=tmp_path) for closed in ("", "2>&-"))
    assert (whole.returncode, shut.returncode) == (0, 0)
    assert "warning: " in whole.stderr and shut.stderr == ""
    assert json.loads(shut.stdout) == json.loads(whole.stdout)


def test_a_file_does_not_get_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    if os.name == "nt":
        pytest.skip("needs a POSIX shell")
    code = (
        "import os, sys; from pysprings.core.process import open_missing_streams; open_missing_streams()\n"
        "file = open('file', 'w'); os.write(1, b'x'); os.write(2, b'x'); print('y'); print('y', file=sys.stderr)"
    )
    line = ["sh", "-c", 'exec "$@" >&- 2>&-', "sh", sys.executable, "-c", code]
    env = environment()
    assert subprocess.run(line, cwd=tmp_path, env=env, timeout=60).returncode == 0
    assert (tmp_path / "file").read_text() == ""
