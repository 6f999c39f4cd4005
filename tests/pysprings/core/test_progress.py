# SPDX-License-Identifier: MIT
"""Progress: few plain lines in a log, a bar on a terminal."""

from __future__ import annotations

import io

from pysprings.core.progress import PlainLines, reporter


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_plain_lines_are_few() -> None:
    stream, time = io.StringIO(), [0.0]
    lines = PlainLines(stream, clock=lambda: time[0])
    for step in range(101):
        lines("pull", step / 100, f"step {step}")
    lines("turn", 0.0, "")
    written = stream.getvalue().splitlines()
    assert written[0] == "pull   0 % step 0"
    assert written[-2:] == ["pull 100 % step 100", "turn   0 %"]
    assert len(written) <= 12


def test_plain_lines_speak_after_a_while() -> None:
    stream, time = io.StringIO(), [0.0]
    lines = PlainLines(stream, clock=lambda: time[0])
    lines("pull", 0.0, "a")
    lines("pull", 0.001, "b")
    time[0] = 31.0
    lines("pull", 0.002, "c")
    lines("pull", 0.003, "d")
    assert stream.getvalue() == "pull   0 % a\npull   0 % c\n"


def test_reporter_suits_the_stream() -> None:
    plain = io.StringIO()
    with reporter(plain) as progress:
        progress("pull", 0.5, "half [way]")
    assert plain.getvalue() == "pull  50 % half [way]\n"
    terminal = Terminal()
    with reporter(terminal) as progress:
        progress("pull", 0.0, "start")
        progress("pull", 0.5, "half [way]")  # brackets are text, not markup
    assert "half [way]" in terminal.getvalue()
    assert "50 %" in terminal.getvalue()
