# SPDX-License-Identifier: MIT
"""Which functions each test file calls, and what it costs: one run of the quick tests of the packages.

Compiled functions and other processes are not seen, and what files share is called by the first of them alone;
`mutation_map` has what the imports say of them. As a plugin of pytest (``-p benchmarks.mutation_calls``) it writes the
functions that each file of a session has called to the file that the environment variable MUTATION_CALLS names.
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
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

from pysprings.core.files.storage import write_text

VARIABLE = "MUTATION_CALLS"
FOLDERS = ("tests/pysprings", "tests/fe_engine")
# test file -> {"digest": of the file, "seconds": of the processor, "functions": ["file.py:Class.function", ...]}
Calls = dict[str, dict[str, Any]]
_SEEN: dict[str, set[CodeType]] = {}
_SECONDS: dict[str, float] = {}
_NOW: list[set[CodeType]] = [set()]  # the functions of the file that runs


def _note(frame: FrameType, _event: str, _arg: object) -> None:
    """Trace function that is called for each call of a Python function, and follows none."""
    _NOW[0].add(frame.f_code)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Trace a test, and count its time; write what is known when its file changes."""
    if VARIABLE not in os.environ:
        return (yield)
    name = item.nodeid.partition("::")[0]
    if name not in _SEEN:
        _write()
    _NOW[0], began = _SEEN.setdefault(name, set()), time.process_time()
    threading.settrace(_note)
    sys.settrace(_note)
    try:
        return (yield)
    finally:
        sys.settrace(None)
        _SECONDS[name] = _SECONDS.get(name, 0.0) + time.process_time() - began


def pytest_unconfigure() -> None:
    """Write what was called."""
    if VARIABLE in os.environ:
        _write()


def _write() -> None:
    """Write what the tests have called so far, by file."""
    root = Path.cwd()
    found = {
        name: {"seconds": round(_SECONDS[name], 1), "functions": sorted(called(codes, root))}
        for name, codes in _SEEN.items()
    }
    Path(os.environ[VARIABLE]).write_text(json.dumps(found), encoding="utf-8")


def called(codes: Iterable[CodeType], root: Path) -> set[str]:
    """Return "path:Class.function" of the functions below a root, for nested ones the way to them."""
    found = set()
    for code in codes:
        file = Path(code.co_filename)
        if file.is_relative_to(root):
            name = re.sub(r"\.?<\w+>", "", code.co_qualname)
            found.add(f"{file.relative_to(root).as_posix()}:{name}")
    return found


def kept_calls(file: Path) -> Calls:
    """Return what an earlier call of `record` has kept; nothing where there is no file."""
    found: Calls = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return found


def record(root: Path, file: Path, run: Callable[..., Any] = subprocess.run) -> Calls:
    """Run the test files of the packages; keep in ``file`` what each calls, and run only what is not kept."""
    known = kept_calls(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    digests = {
        test.relative_to(root).as_posix(): hashlib.sha256(test.read_bytes()).hexdigest()[:16]
        for folder in FOLDERS
        for test in sorted((root / folder).rglob("test_*.py"))
    }
    known = {name: entry for name, entry in known.items() if entry["digest"] == digests.get(name)}
    if missing := [name for name in digests if name not in known]:
        part = file.with_suffix(".part")
        options = ["-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", "-p", "benchmarks.mutation_calls"]
        env = {**os.environ, VARIABLE: str(part), "PYTHONPATH": str(root)}
        run([sys.executable, "-m", "pytest", *options, *missing], cwd=root, env=env, capture_output=True, check=False)
        found: Calls = json.loads(part.read_text(encoding="utf-8")) if part.is_file() else {}
        known |= {name: {"digest": digests[name], **entry} for name, entry in found.items()}
        part.unlink(missing_ok=True)
        write_text(json.dumps(known) + "\n", file)
    return known


def test_files(calls: Calls, place: str) -> list[str]:
    """Return the test files that call a function ("path:Class.function"), the cheapest first."""
    found = [(entry["seconds"], name) for name, entry in calls.items() if place in entry["functions"]]
    return [name for _, name in sorted(found)]
