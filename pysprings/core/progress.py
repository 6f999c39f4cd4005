# SPDX-License-Identifier: MIT
"""Progress of long work: a bar on a terminal, plain lines elsewhere (logs, pipes)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TextIO

Progress = Callable[[str, float, str], None]
"""Called with the name of the path (or phase), the fraction done of it in [0, 1], and a short message."""

LINE_AFTER = 10.0  # s between two plain lines


@contextmanager
def reporter(stream: TextIO | None) -> Iterator[Progress]:
    """Give the progress function that suits a stream; None: one that reports nothing."""
    if stream is None:
        yield lambda *_: None
    elif stream.isatty():
        with _bars(stream) as progress:
            yield progress
    else:
        yield PlainLines(stream)


@contextmanager
def _bars(stream: TextIO) -> Iterator[Progress]:
    """Give a function that draws one bar per path, with the time that has passed and the time that is left."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    columns = TextColumn("{task.fields[path]}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %")
    times = TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(elapsed_when_finished=False)
    with Bars(*columns, *times, TextColumn("{task.description}"), console=Console(file=stream)) as bars:
        tasks: dict[str, int] = {}

        def progress(path: str, fraction: float, message: str) -> None:
            if path not in tasks:
                tasks[path] = bars.add_task("", total=1.0, path=escape(path))
            bars.update(tasks[path], completed=fraction, description=escape(message))  # type: ignore[arg-type]

        yield progress


class PlainLines:
    """Writes a line at first, and then where something moved on and LINE_AFTER seconds have passed."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self.stream = stream
        self.clock = clock
        self.written_at = -LINE_AFTER + clock()

    def __call__(self, path: str, fraction: float, message: str) -> None:
        """Report; see `Progress`."""
        if self.clock() - self.written_at >= LINE_AFTER:
            print(f"{path} {100 * fraction:3.0f} % {message}".rstrip(), file=self.stream, flush=True)
            self.written_at = self.clock()


def counted(progress: Progress, names: Sequence[str]) -> Progress:
    """Return a progress function that puts the place of a path among ``names``, and the share of all, into the message.

    Other names (of the model, of what follows the paths) are passed on as they are.
    """
    place = {name: number for number, name in enumerate(names)}

    def report(path: str, fraction: float, message: str) -> None:
        if path in place and len(place) > 1:
            total = 100.0 * (place[path] + fraction) / len(place)
            message = f"path {place[path] + 1} of {len(place)}, {total:.0f} % of all; {message}"
        progress(path, fraction, message)

    return report


def duration(seconds: float) -> str:
    """Return a time for people.

    >>> duration(50.0), duration(400.0), duration(9000.0)
    ('50 s', '7 min', '2 h 30 min')
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
