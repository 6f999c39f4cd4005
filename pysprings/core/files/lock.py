# SPDX-License-Identifier: MIT
"""One run at a time writes into a result folder (light: imports nothing heavy before a lock is asked for).

The lock is the operating system's, on a file in the folder: it dies with its process, however that ends. A second file
names its holder, for the message of the next run.
"""

import json
import os
import platform
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from pysprings.core.errors import ResourceError, printable

LOCK, HOLDER = ".pysprings.lock", ".pysprings.lock.json"
_held: set[tuple[Path, int]] = set()  # folder and thread


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Create a folder (and those above it) where it is not there; remove what is new again where it stays empty."""
    new = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        with suppress(OSError):  # not empty: that is how it should be
            for each in new:
                each.rmdir()


@contextmanager
def exclusive(folder: Path) -> Iterator[None]:
    """Hold the lock of an existing folder; the thread that holds it may take it again.

    Raises ResourceError: another run holds it, or the folder cannot be written to.
    """
    mine = folder.resolve(), threading.get_ident()
    if mine in _held:
        yield
        return
    from filelock import FileLock, Timeout

    lock = FileLock(folder / LOCK, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise ResourceError(f"{folder}: {_holder(folder)}; wait for its end, or choose another folder") from None
    _held.add(mine)
    try:
        holder = {"pid": os.getpid(), "host": platform.node(), "since": datetime.now(UTC).isoformat(timespec="seconds")}
        (folder / HOLDER).unlink(missing_ok=True)  # a link of this name leads elsewhere
        (folder / HOLDER).write_text(json.dumps(holder), encoding="utf-8", newline="\n")
        yield
    finally:
        _held.discard(mine)
        with suppress(OSError):  # they may stay: the next run takes them over
            (folder / HOLDER).unlink(missing_ok=True)
            if os.name != "nt":  # removed while it is held: a process that has opened this file opens a new one
                (folder / LOCK).unlink(missing_ok=True)
        lock.release()
        if os.name == "nt":  # where an open file cannot be removed
            with suppress(OSError):
                (folder / LOCK).unlink(missing_ok=True)


def _holder(folder: Path) -> str:
    """Return a sentence on the process that writes into a folder."""
    try:
        holder = json.loads((folder / HOLDER).read_text(encoding="utf-8"))
        return printable(f"another run (process {holder['pid']} on {holder['host']}) writes into this folder")
    except (OSError, ValueError, LookupError, TypeError):
        return "another run writes into this folder"
