# SPDX-License-Identifier: MIT
"""OpenSees as a process: a program of these tests, or words, with a task in JSON in and an answer in JSON out."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

NOT_THERE = 77  # exit code of programs that find no openseespy which loads


def environment() -> dict[str, str]:
    """Environment in which the libraries of openseespy's wheel find each other; skips the test without them."""
    own = importlib.util.find_spec("openseespylinux")
    if importlib.util.find_spec("openseespy") is None or own is None or own.origin is None:
        pytest.skip("openseespy is not installed")
    libraries = os.pathsep.join(filter(None, (str(Path(own.origin).parent / "lib"), os.environ.get("LD_LIBRARY_PATH"))))
    return {**os.environ, "LD_LIBRARY_PATH": libraries}


def answer_of(program: Path | str, task: Any, line: int = -1) -> Any:
    """Return what a program (a file or its text) prints as a line of JSON; skips the test without OpenSees."""
    command = [sys.executable, *([str(program)] if isinstance(program, Path) else ["-c", program])]
    done = subprocess.run(
        command, input=json.dumps(task), capture_output=True, text=True, timeout=120, check=False, env=environment()
    )
    if done.returncode == NOT_THERE:
        pytest.skip(f"openseespy does not load: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[line])
