# SPDX-License-Identifier: MIT
"""Watch a piece of work: files that it writes, programs that it starts, and whether it comes back."""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


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
        self.seen: list[str] = []

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
            self.seen.append(f"{event} {args!r:.200}")
            return
        for path in args[:2] if event == "os.rename" else args[:1]:
            place = os.path.abspath(os.fsdecode(path)) if isinstance(path, str | bytes | os.PathLike) else ""
            inside = f"{place}{os.sep}".startswith((self.allowed + os.sep, "/dev/", *_LOOPS)) or "__pycache__" in place
            there_already = event == "os.mkdir" and os.path.isdir(place)
            if place and not inside and not there_already:
                self.seen.append(f"{event} {place}")


_EVENTS = {
    "open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.truncate", "shutil.move",
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "pickle.find_class",
}  # fmt: skip
# Numba keeps what it has compiled as pickles, in a folder of its own.
_LOOPS = [os.path.abspath(place) + os.sep for place in [os.environ.get("NUMBA_CACHE_DIR")] if place]
_NUMBA_CACHE = {"numba", "llvmlite", "copyreg", "builtins", "numpy", "fe_engine", "pysprings"}
_WATCH = _Watch()
sys.addaudithook(_WATCH)


@contextmanager
def watched(folder: Path) -> Iterator[None]:
    """Fail when anything is written outside a folder, or another program is started, inside the block."""
    _WATCH.allowed, _WATCH.seen = str(folder.resolve()), []
    try:
        yield
    finally:
        _WATCH.allowed = None
    assert not _WATCH.seen, _WATCH.seen
