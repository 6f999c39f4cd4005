# SPDX-License-Identifier: MIT
"""Standard streams that are closed (`>&-`, cron, a program without a window): what goes there is thrown away."""

from __future__ import annotations

import os
import sys

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
