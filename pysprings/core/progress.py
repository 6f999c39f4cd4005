# SPDX-License-Identifier: MIT
"""Progress of long work: a bar on a terminal, plain lines elsewhere (logs, pipes)."""

import time
from collections.abc import Callable, Iterator, Mapping
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
    """Give a function that draws a bar for each path on its way, with its times; its message has those of all."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, Progress as Bars, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = TextColumn("{task.fields[path]}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %")
    times = TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(elapsed_when_finished=False)
    with Bars(*columns, *times, TextColumn("{task.description}"), console=Console(file=stream)) as bars:
        tasks: dict[str, int] = {}

        def progress(path: str, fraction: float, message: str) -> None:
            if path not in tasks:
                tasks[path] = bars.add_task("", total=1.0, path=escape(path))
            done = {"completed": fraction, "description": escape(message), "visible": fraction < 1.0}
            bars.update(tasks[path], **done)  # type: ignore[arg-type]

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


class Total:
    """Puts the place of a path among all, the share of all that is done, and the time that is left into the message.

    ``weights`` are the costs of the paths, in any unit. Other names (of the model, of what follows the paths) are
    passed on as they are. ``span``: shares of all work at which these paths begin and end, where more goes with them.
    """

    def __init__(
        self, progress: Progress, weights: Mapping[str, float], clock: Callable[[], float] = time.monotonic,
        span: tuple[float, float] = (0.0, 1.0),
    ) -> None:  # fmt: skip
        self.progress, self.weights, self.clock, self.span = progress, weights, clock, span
        self.done = dict.fromkeys(weights, 0.0)
        self.places = {name: number + 1 for number, name in enumerate(weights)}
        self.began: tuple[float, float] | None = None  # when, and the share that was done before

    def __call__(self, path: str, fraction: float, message: str) -> None:
        """Report; see `Progress`."""
        if path in self.done and (len(self.done) > 1 or self.span != (0.0, 1.0)):
            self.done[path], (first, last) = fraction, self.span
            whole = sum(self.done[name] * weight for name, weight in self.weights.items()) / sum(self.weights.values())
            whole = first + (last - first) * whole
            self.began = self.began or (self.clock(), whole)
            left = self._left(whole)
            message = f"path {self.places[path]} of {len(self.done)}, {100 * whole:.0f} % of all{left}; {message}"
        self.progress(path, fraction, message)

    def _left(self, whole: float) -> str:
        assert self.began is not None
        passed, share = self.clock() - self.began[0], whole - self.began[1]
        if passed < _TOO_SOON or share < _TOO_LITTLE or whole >= 1.0:
            return ""
        return f", about {duration(passed / share * (1.0 - whole))} left"


_TOO_SOON, _TOO_LITTLE = 2.0, 0.02  # s and share of all, before which the time left is a guess


def duration(seconds: float) -> str:
    """Return a time for people.

    >>> duration(50.0), duration(400.0), duration(9000.0)
    ('50 s', '7 min', '2 h 30 min')
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
