# SPDX-License-Identifier: MIT
"""A table as a workbook for people: one look, rows written one by one, however many there are."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pysprings.core.errors import refused
from pysprings.core.storage import replacing

# xlsxwriter: a text stays a text (a name may begin with =, or be an address)
PLAIN_CELLS = {"strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
HEAD = {"bold": True, "bg_color": "#DDE6EE", "border": 1, "text_wrap": True, "valign": "top"}
MARKED = {"bg_color": "#fbe3d3"}  # rows that ask for attention
MOST_ROWS = 1_048_575  # of a sheet below its headings


def write_sheet(
    path: Path, heads: Sequence[str], rows: Iterable[tuple[Sequence[Any], bool]], about: Mapping[str, str]
) -> Path:
    """Write one table as a workbook, whole or not at all; return its path.

    heads : Headings with units.
    rows : Values of each row (texts, numbers; None and NaN are blank), and whether the row is marked.
    about : Lines of a second sheet, by name; no sheet where there are none.

    Raises UserInputError: more rows than a sheet holds.
    """
    import xlsxwriter

    with (
        replacing(path) as temporary,
        xlsxwriter.Workbook(str(temporary), {**PLAIN_CELLS, "constant_memory": True}) as book,
    ):
        head, marked = book.add_format(HEAD), book.add_format(MARKED)
        sheet = book.add_worksheet("cases")
        sheet.set_row(0, 45)
        sheet.set_column(0, len(heads) - 1, 14)
        sheet.freeze_panes(1, 1)
        sheet.write_row(0, 0, heads, head)
        count = 0
        for count, (values, wrong) in enumerate(rows, start=1):
            if count > MOST_ROWS:
                raise refused(None, f"a sheet holds {MOST_ROWS:,} cases; write .csv", path)
            cells = [None if isinstance(each, float) and not math.isfinite(each) else each for each in values]
            sheet.write_row(count, 0, cells, marked if wrong else None)
        sheet.autofilter(0, 0, count, len(heads) - 1)
        if about:
            notes = book.add_worksheet("about")
            notes.set_column(0, 0, 18)
            for row, (name, words) in enumerate(about.items()):
                notes.write_string(row, 0, name, head)
                notes.write_string(row, 1, words)
    return path
