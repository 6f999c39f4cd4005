# SPDX-License-Identifier: MIT
"""The exit codes of the contract, each by the installed command in a process of its own.

130 by a real Ctrl-C is in test_folder.py.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pysprings.springs import save_springs
from tests.pysprings import synthetic, tiny

ROOT = Path(__file__).parents[2]
# the command with a run that ends otherwise (and without what takes so long to load)
REPLACED = """
import os, signal, sys, types
def end(*_, **__):
    {end}
sys.modules["pysprings.folder"] = types.ModuleType("pysprings.folder")
sys.modules["pysprings.folder"].run_to_folder = end
from pysprings.cli import main
main()
"""


def pysprings(*args: object, end: str = "", cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command; ``end`` is a statement that stands for the computation."""
    how = ["-c", REPLACED.format(end=end)] if end else ["-m", "pysprings"]
    command = [sys.executable, *how, *(str(arg) for arg in args)]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=env, timeout=120)


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    return tiny.write(tiny.scene(), tmp_path / "caisson.toml")


def test_0_ok(tmp_path: Path) -> None:
    file = save_springs(synthetic.make_springs(), tmp_path / "springs.nc")
    done = pysprings("predict", file, "--H", "1 MN", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("end", "code", "words"),
    [
        ("raise ZeroDivisionError('oops')", 1, "fatal: bug: ZeroDivisionError: oops"),
        ("from fe_engine.errors import NotConverged; raise NotConverged('no way')", 3, "fatal: not converged: no way"),
        ("raise MemoryError", 4, "fatal: resources: out of memory"),
        ("raise OSError(28, 'No space left on device', 'x')", 4, "fatal: resources: x: No space left on device"),
        ("os.kill(os.getpid(), signal.SIGINT); signal.pause()", 130, "interrupted"),
        ("os.kill(os.getpid(), signal.SIGTERM); signal.pause()", 130, "interrupted"),
    ],
    ids=["bug", "not converged", "memory", "disk", "Ctrl-C", "SIGTERM"],
)
def test_ends_of_a_run(tmp_path: Path, scene_file: Path, end: str, code: int, words: str) -> None:
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
