# SPDX-License-Identifier: MIT
"""Which functions each test file calls, and what it costs: one run of every test file in a process of its own.

Compiled functions and other processes are not seen; `mutation_map` has what the imports say of them. As a plugin of
pytest (``-p benchmarks.mutation_calls``) it writes the functions that a session has called to the file that the
environment variable MUTATION_CALLS names.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from pysprings.core.files.storage import write_text

VARIABLE = "MUTATION_CALLS"
# test file -> {"digest": of the file, "seconds": of the processor, "functions": ["file.py:Class.function", ...]}
Calls = dict[str, dict[str, Any]]
_SEEN: set[CodeType] = set()


def _note(frame: FrameType, _event: str, _arg: object) -> None:
    """Trace function that is called for each call of a Python function, and follows none."""
    _SEEN.add(frame.f_code)


def pytest_configure() -> None:
    """Begin to trace."""
    if VARIABLE in os.environ:
        threading.settrace(_note)
        sys.settrace(_note)


def pytest_unconfigure() -> None:
    """Write what was called."""
    if VARIABLE in os.environ:
        sys.settrace(None)
        Path(os.environ[VARIABLE]).write_text(json.dumps(sorted(called(_SEEN, Path.cwd()))), encoding="utf-8")


def called(codes: Iterable[CodeType], root: Path) -> set[str]:
    """Return "path:Class.function" of the functions below a root, for nested ones the way to them."""
    found = set()
    for code in codes:
        file = Path(code.co_filename)
        if file.is_relative_to(root):
            name = re.sub(r"\.?<\w+>", "", code.co_qualname)
            found.add(f"{file.relative_to(root).as_posix()}:{name}")
    return found


def record(root: Path, file: Path, run: Callable[..., Any] = subprocess.run) -> Calls:
    """Run every test file below ``root/tests``; keep in ``file`` what each calls, and run only what is not kept."""
    known: Calls = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    file.parent.mkdir(parents=True, exist_ok=True)
    for test in sorted((root / "tests").rglob("test_*.py")):
        name, digest = test.relative_to(root).as_posix(), hashlib.sha256(test.read_bytes()).hexdigest()[:16]
        if known.get(name, {}).get("digest") != digest:
            part, began = file.with_suffix(".part"), time.process_time() + os.times().children_user
            options = ["-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", "-p", "benchmarks.mutation_calls"]
            env = {**os.environ, VARIABLE: str(part), "PYTHONPATH": str(root)}
            run([sys.executable, "-m", "pytest", *options, name], cwd=root, env=env, capture_output=True, check=False)
            seconds = time.process_time() + os.times().children_user - began
            if part.is_file():
                functions = json.loads(part.read_text(encoding="utf-8"))
                known[name] = {"digest": digest, "seconds": round(seconds, 1), "functions": functions}
                part.unlink()
                write_text(json.dumps(known) + "\n", file)
    return known


def test_files(calls: Calls, place: str) -> list[str]:
    """Return the test files that call a function ("path:Class.function"), the cheapest first."""
    found = [(entry["seconds"], name) for name, entry in calls.items() if place in entry["functions"]]
    return [name for _, name in sorted(found)]
