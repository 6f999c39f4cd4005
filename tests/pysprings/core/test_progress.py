# SPDX-License-Identifier: MIT
"""Progress: few plain lines in a log, a bar on a terminal."""

import io

from pysprings.core.errors import Problem
from pysprings.core.progress import PlainLines, Total, reporter
from pysprings.core.text import plain_table


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_plain_lines_are_at_most_one_in_ten_seconds() -> None:
    stream, time = io.StringIO(), [100.0]
    lines = Total(PlainLines(stream, clock=lambda: time[0]), {"pull": 1.0, "turn": 3.0}, clock=lambda: time[0])
    lines("model", 0.0, "mesh")
    for step in range(200):
        time[0] += 0.3
        lines("pull" if step < 100 else "turn", step % 100 / 100, f"step {step % 100}")
    written = stream.getvalue().splitlines()
    assert written[0] == "model   0 % mesh"
    assert written[1] == "pull  33 % path 1 of 2, 8 % of all, about 2 min left; step 33"
    assert written[-1].startswith("turn  ") and "path 2 of 2" in written[-1]
    assert len(written) == 6


def test_messages_keep_their_remedy_and_tables_their_width() -> None:
    remedy = "--extrapolate (extrapolate=True) answers beyond"
    line = str(Problem(key="k", message=f"{'x' * 5000} {'so many words ' * 300} {remedy}"))
    assert line.endswith(remedy) and len(line) < 1000
    wide = plain_table(["a", "b"], [["word " * 100, "12,570"]], most=(20, 20))
    assert max(map(len, wide.splitlines())) <= 42 and "12,570" in wide


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


def test_one_total_goes_through_a_run_and_what_stands_beside_it() -> None:
    """A run of two paths to 60 % of all, a run beside it to 84 %; one path alone is a part of it, too."""
    said: list[str] = []
    for weights, span in (({"a": 1.0, "b": 3.0}, (0.0, 0.6)), ({"a": 1.0}, (0.6, 0.84))):
        total = Total(lambda _path, _share, text: said.append(text), weights, lambda: 0.0, span)
        for path in weights:
            total(path, 1.0, "end")
    assert [text.split(" % of all")[0] for text in said] == ["path 1 of 2, 15", "path 2 of 2, 60", "path 1 of 1, 84"]
