# SPDX-License-Identifier: MIT
"""Wall and CPU seconds by phase."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def seconds() -> tuple[float, float]:
    """Return wall and CPU seconds (all threads of this process), each since some moment."""
    return time.perf_counter(), time.process_time()


class Clock:
    """Adds up wall and CPU seconds (all threads) of named phases."""

    def __init__(self, now: Callable[[], tuple[float, float]] = seconds) -> None:
        self.now = now
        self.wall: dict[str, float] = {}
        self.cpu: dict[str, float] = {}

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Count the block to a phase."""
        before = self.now()
        try:
            yield
        finally:
            now = self.now()
            self.wall[name] = self.wall.get(name, 0.0) + now[0] - before[0]
            self.cpu[name] = self.cpu.get(name, 0.0) + now[1] - before[1]
