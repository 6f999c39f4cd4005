# SPDX-License-Identifier: MIT
"""The process: standard streams that are closed (`>&-`, cron, a program without a window), threads, interrupts."""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

_STREAMS = (("stdin", 0, "r"), ("stdout", 1, "w"), ("stderr", 2, "w"))


def open_missing_streams() -> None:
    """Open the null device for each standard stream that is missing, and have all take any character.

    The stream's number is taken, too: libraries in C write to it, and a file that is opened later would get it.
    """
    for name, number, mode in _STREAMS:
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(_null_device(number), mode, encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _null_device(number: int) -> int:
    """Open the null device under a number, or under another where that is in use; return which."""
    opened = os.open(os.devnull, os.O_RDWR)
    if opened == number:
        return opened
    try:
        os.fstat(number)
    except OSError:
        os.dup2(opened, number)
        os.close(opened)
        return number
    return opened


def blas_on_one_thread() -> AbstractContextManager[object]:
    """Return the context in which NumPy's OpenBLAS has one thread.

    Its threads wait by spinning after every product of vectors; beside those of Pardiso and Numba on two cores they
    took half the time of a linear solve. Pardiso's own BLAS keeps its threads.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(internal_api="openblas").limit(limits=1)


@contextmanager
def interrupts() -> Iterator[list[int]]:
    """Collect the signals that would raise KeyboardInterrupt in the block, of the main thread."""
    asked: list[int] = []
    kinds = []
    if threading.current_thread() is threading.main_thread():
        names = [name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
        kinds = [kind for name in names if callable(signal.getsignal(kind := getattr(signal, name)))]
    before = {kind: signal.signal(kind, lambda number, _: asked.append(number)) for kind in kinds}
    try:
        yield asked
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold an interrupt back until the block has ended.

    One that comes while xarray takes its locks leaves them taken: closing the file then waits for ever.
    """
    with interrupts() as asked:
        yield
    if asked:
        raise KeyboardInterrupt
