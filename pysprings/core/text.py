# SPDX-License-Identifier: MIT
"""Numbers, tables and JSON as text: one form for terminal, report and documents."""

import difflib
import json
import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from typing import Any

MOST_LETTERS = 60  # of the name of a path or a load case
# a number with a unit, such as "-5 kN m^-1": nothing that calls, joins or calculates
_QUANTITY = re.compile(r"[+-]?\.?\d[\d.,]*(e[+-]?\d+)?\s*[^\W\d_]*[\w /^·²³%-]*", re.IGNORECASE)


def number(value: Any, digits: int = 4) -> str:
    """Return a number for reading: ``digits`` figures, thousands apart; "-" where it is missing or not finite."""
    value = value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return _real(value, digits)
    if isinstance(value, list | tuple):
        return ", ".join(number(item, digits) for item in value)
    return str(value)


def _real(value: float, digits: int) -> str:
    if not math.isfinite(value):
        return "-"
    if 1.0e4 <= abs(value) < 1.0e15:
        return f"{value:,.0f}"
    return f"{value + 0.0:.{digits}g}"  # + 0.0 turns -0.0 into 0.0


def with_prefix(value: float, unit: str, digits: int = 4) -> str:
    """Return a value in SI, some figures, with the prefix k, M or G of its unit: M from 0.1 to 10,000, none below 1.

    >>> with_prefix(8.249e10, "N m/rad"), with_prefix(-7.921e9, "N/rad"), with_prefix(5.0e4, "N/m"), with_prefix(0, "N")
    ('82.49 GN m/rad', '-7921 MN/rad', '50 kN/m', '0 N')
    """
    size = abs(value)
    steps = (("G", 1e9, 1e10), ("M", 1e6, 1e5), ("k", 1e3, 1.0), ("", 1.0, -1.0))
    letter, scale = next((letter, scale) for letter, scale, least in steps if not size < least)
    return f"{_real(float(value) / scale, digits)} {letter}{unit}"


def shared(notes: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the notes of runs, each once, behind the names of those that have it where others do not."""
    names = {note: [name for name in notes if note in notes[name]] for own in notes.values() for note in own}
    return [f"{', '.join(of)}: {note}" if of != [*notes] else note for note, of in names.items()]


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return ` (did you mean 'x'?)` when a known word is near, else nothing."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6)
    return f" (did you mean '{near[0]}'?)" if near else ""


def one_line(text: str) -> str:
    """Return a text on one line: line ends and all that is not printable become blanks; no backslash ends it."""
    return "".join(c if c.isprintable() else " " for c in str(text)).rstrip(" \\")


def is_formula(text: str) -> bool:
    """Return whether a spreadsheet takes a text for a formula: by its first character; quantities are none."""
    bare = text.strip()
    return len(bare) > 1 and bare.startswith(tuple("=+-@")) and not _QUANTITY.fullmatch(bare)


def commented(mark: str, lines: Iterable[str], width: int = 400) -> list[str]:
    """Return lines behind the comment mark of a program, whatever text they hold; long ones go on behind the mark, too.

    All text of a scene or a spring file enters the files for other programs through this function alone: a line end in
    it would be a command there, a backslash at its end would take the next line into the comment (Tcl, C), and programs
    cut long lines into several (CalculiX at 1,320 letters).
    """
    parts = (part for line in map(one_line, lines) for part in _pieces(line, width))
    return [f"{mark} {one_line(part)}" for part in parts]


def _pieces(line: str, width: int) -> list[str]:
    return [line] if len(line) <= width else textwrap.wrap(line, width, subsequent_indent="  ")


def percent(value: float) -> str:
    """Return a size in percent, two figures below a hundred."""
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def plain_table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool] = (True,), most: Sequence[int] = ()
) -> str:
    """Return a table for a terminal: a rule below the heads, columns set to the right but for those in ``left``.

    ``most`` are the largest widths of the first columns: longer texts go on in a line below.
    """
    grid = [_broken(row, most) for row in (heads, *rows)]
    widths = [max(len(line) for cell in column for line in cell) for column in zip(*grid, strict=True)]
    sides = [str.ljust if side else str.rjust for side in (*left, *[False] * (len(heads) - len(left)))]

    def joined(cells: Iterable[str]) -> str:
        return "  ".join(side(cell, w) for side, cell, w in zip(sides, cells, widths, strict=True)).rstrip()

    texts = [[joined(line) for line in zip_longest(*row, fillvalue="")] for row in grid]
    return "\n".join(
        [*texts[0], "  ".join("-" * width for width in widths), *(line for row in texts[1:] for line in row)]
    )


def _broken(row: Sequence[str], most: Sequence[int]) -> list[list[str]]:
    """Return the lines of each cell, broken where they are wider than allowed."""
    widths = [*most, *[10_000] * (len(row) - len(most))]
    return [
        textwrap.wrap(cell, width) or [""] if len(cell) > width else [cell]
        for cell, width in zip(row, widths, strict=True)
    ]


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[str]], numbers: bool = False) -> str:
    """Return a table in Markdown; with ``numbers``, all columns but the first are set to the right."""
    rules = ["---", *["--:" if numbers else "---"] * (len(heads) - 1)]
    safe = [[text.replace("|", "\\|").replace("\n", " ") for text in row] for row in rows]
    lines = [heads, rules, *safe]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def json_text(data: Any, indent: int | None = None) -> str:
    """Return data as strict JSON in ASCII: NumPy's values as numbers and lists, numbers that are not finite as null."""
    from pydantic_core import from_json, to_json

    return json.dumps(from_json(to_json(data, inf_nan_mode="null", fallback=_plain)), indent=indent, allow_nan=False)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)
