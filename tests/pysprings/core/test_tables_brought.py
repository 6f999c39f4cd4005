# SPDX-License-Identifier: MIT
"""Tables as people bring them, in each of the five readers: read with the same numbers, or refused with their place."""

import io
import re
import warnings
import zipfile
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.results.tables import open_table
from pysprings.results.tables.sequence import read_sequence
from pysprings.scene.profile_table import read_layers
from pysprings.studies.sweep.plan import read_table

Rows = list[list[Any]]


def _cases(path: Path) -> list[Any]:
    cases = read_load_cases(path)
    return [cases.name, cases.loads.tolist(), cases.V.tolist(), cases.tilt.tolist()]


def _study(file: Path) -> object:
    axes, cases = read_table(file)
    return [(axis.name, axis.keys) for axis in axes], cases  # an axis of a table has no ends: NaN is no equal of itself


def _sequence(path: Path) -> list[Any]:
    read = read_sequence(path)
    return [read.targets.tolist(), np.asarray(read.time).tolist()]


def _springs(path: Path) -> list[Any]:
    read = open_table(path).sets["table"]
    return [read.depth.tolist(), [(each.q.tolist(), each.r.tolist()) for each in read.curves]]


READERS: dict[str, tuple[Callable[[Path], Any], Rows]] = {
    "layers": (read_layers, [
        ["Depth from [m]", "Depth to [m]", "Soil type", "Effective unit weight [kN/m3]", "phi [deg]", "E [MPa]"],
        [0, 2.5, "Sand", 9.5, 32.5, 40], [2.5, 30, "Sand", 10, 36, 62.75],
    ]),
    "cases": (_cases, [
        ["name", "H [kN]", "M [kN m]", "V [kN]", "tilt [deg]"],
        ["storm", 1200.5, -42000, 9000, 0.25], ["calm", 300, -2500.5, 8000, 0.5],
    ]),
    "springs": (_springs, [
        ["depth [m]", "y [mm]", "p [kN/m]"], [0.5, 1.5, 50], [0.5, 5, 100], [2.5, 1.5, 60.5], [2.5, 5, 120],
    ]),
    "sequence": (_sequence, [["time [s]", "H [kN]", "M [kN m]"], [0, 0, 0], [10, 100.5, -500], [20.5, -100, 500]]),
    "study": (_study, [
        ["id", "caisson.skirt_length [m]", "soil.young_modulus [MPa]"], [1, 4.5, 80], [2, 6, 120.5],
    ]),
}  # fmt: skip


def lines(rows: Rows, separator: str = ",") -> str:
    """The rows as text; decimal commas beside other separators."""
    commas = separator != ","
    texts = [[str(c).replace(".", ",") if commas and isinstance(c, float) else str(c) for c in row] for row in rows]
    return "\n".join(separator.join(row) for row in texts) + "\n"


def book(rows: Rows, change: Callable[[Any, Any], None] = lambda book, sheet: None) -> openpyxl.Workbook:
    made = openpyxl.Workbook()
    for row in rows:
        made.active.append(row)
    change(made, made.active)
    return made


def headed(rows: Rows, change: Callable[[str], str]) -> Rows:
    return [[change(text) for text in rows[0]], *rows[1:]]


def split(rows: Rows) -> Rows:
    """Names in the first row of the heading, units in the second."""
    units = [(re.search(r"\[(.*)\]", text) or ["", ""])[1] for text in rows[0]]
    return [[re.sub(r"\s*\[.*\]", "", text) for text in rows[0]], units, *rows[1:]]


def with_title(made: Any, sheet: Any) -> None:
    made.create_sheet("Title", 0).append(["Project: caissons, revision 3"])


def as_texts(made: Any, sheet: Any) -> None:
    for row in sheet.iter_rows(min_row=2):
        for cell in row:
            cell.value = str(cell.value).replace(".", ",") if isinstance(cell.value, float) else cell.value


def quoted(rows: Rows) -> Rows:
    return [[f'"{cell}"' if isinstance(cell, str) else cell for cell in row] for row in rows]


def in_thousands(made: Any, sheet: Any) -> None:
    sheet.cell(2, sheet.max_column).number_format = '#,##0.00, "M"'


def with_units(made: Any, sheet: Any) -> None:
    """Every cell shows the unit of its heading, as 5 kN does."""
    for head, *cells in sheet.iter_cols():
        if unit := re.search(r"\[([a-zA-Z].*)\]", str(head.value)):
            for cell in cells:
                cell.number_format = f'0.0# "{unit[1]}"'


def with_unit(made: Any, sheet: Any) -> None:
    sheet.cell(2, sheet.max_column).number_format = '#,##0.00" GJ";-0.0'


def coloured(made: Any, sheet: Any) -> None:
    sheet.cell(2, sheet.max_column + 3).fill = openpyxl.styles.PatternFill("solid", "ffff00")


SAME: dict[str, Callable[[Rows], Any]] = {
    "commas": lines,
    "semicolons, decimal commas": lambda rows: lines(rows, ";"),
    "semicolons, quoted texts": lambda rows: lines(quoted(rows), ";"),
    "tabs, decimal commas": lambda rows: lines(rows, "\t"),
    "sep=": lambda rows: "sep=;\n" + lines(rows, ";"),
    "utf-8 with a mark": lambda rows: lines(rows).encode("utf-8-sig"),
    "utf-16": lambda rows: lines(rows).encode("utf-16"),
    "cp1252": lambda rows: ("Lastfälle für Gründung\n" + lines(rows)).encode("cp1252"),
    "carriage returns": lambda rows: lines(rows).replace("\n", "\r"),
    "windows": lambda rows: lines(rows).replace("\n", "\r\n"),
    "titles": lambda rows: "Project; revision 3, final\n\n" + lines(rows),
    "comments": lambda rows: "# made by hand\n" + lines(rows) + "# end\n",
    "trailing commas": lambda rows: lines([[*row, "", ""] for row in rows]),
    "index": lambda rows: lines([["", *rows[0]], *([k, *row] for k, row in enumerate(rows[1:]))]),
    "blank lines": lambda rows: lines(rows).replace("\n", "\n\n"),
    "quotes": lambda rows: lines(headed(rows, lambda text: '"' + text.replace(" [", "\n[") + '"')),
    "workbook": book,
    "workbook, units shown": lambda rows: book(rows, with_units),
    "workbook with prefixes": lambda rows: prefixed(book(rows)),
    "title page": lambda rows: book(rows, with_title),
    "numbers as texts": lambda rows: book(rows, as_texts),
    "coloured empty cells": lambda rows: book(rows, coloured),
    "index in a workbook": lambda rows: book([[None, *rows[0]], *([k, *row] for k, row in enumerate(rows[1:]))]),
    "parentheses": lambda rows: lines(headed(rows, lambda text: text.replace("[", "(").replace("]", ")"))),
    "units below": lambda rows: lines(split(rows)),
    "units below, workbook": lambda rows: book(split(rows)),
}


def victim(value: Any) -> Callable[[Rows], Any]:
    """Put a value into the last cell of the first row."""
    return lambda rows: [rows[0], [*rows[1][:-1], value], *rows[2:]]


def in_book(value: Any) -> Callable[[Rows], Any]:
    return lambda rows: book(victim(value)(rows))


def merged(made: Any, sheet: Any) -> None:
    sheet.merge_cells(start_row=2, end_row=3, start_column=sheet.max_column, end_column=sheet.max_column)


def hidden_row(made: Any, sheet: Any) -> None:
    sheet.row_dimensions[3].hidden = True


def hidden_column(made: Any, sheet: Any) -> None:
    sheet.column_dimensions["B"].hidden = True


def hidden_sheet(made: Any, sheet: Any) -> None:
    made.create_sheet("visible")
    made.active = 1
    sheet.sheet_state = "hidden"


def twice(made: Any, sheet: Any) -> None:
    made.copy_worksheet(sheet)


def written_by_others(made: openpyxl.Workbook, pattern: str, by: str | Callable[[re.Match[str]], str]) -> bytes:
    """The workbook with another text for a pattern in its sheets."""
    with io.BytesIO() as first, io.BytesIO() as second:
        made.save(first)
        with zipfile.ZipFile(first) as old, zipfile.ZipFile(second, "w") as new:
            for name in old.namelist():
                text = old.read(name)
                new.writestr(name, re.sub(pattern, by, text.decode()) if "worksheets/sheet" in name else text)
        return second.getvalue()


def prefixed(made: openpyxl.Workbook) -> bytes:
    """With a prefix before every tag, as Open XML SDK and ClosedXML write them."""
    return written_by_others(
        made, r"<(/?)(?=[a-zA-Z])|xmlns(?==)", lambda m: f"<{m[1]}x:" if m[1] is not None else "xmlns:x"
    )


REFUSED: dict[str, tuple[Callable[[Rows], Any], str]] = {
    "formula": (in_book("=10*2"), r'\[Sheet\]:2: .*: cell [A-F]2 holds the formula "=10\*2" without a stored value'),
    "formula of a program": (lambda rows: written_by_others(in_book("=10*2")(rows), "<v ?/>", "<v>0</v>"),
                             r'holds the formula "=10\*2" without a stored value'),
    "error": (in_book("#REF!"), r"cell [A-F]2 holds the error #REF!"),
    "error in text": (lambda rows: lines(victim("#DIV/0!")(rows)), r"2: .*is an error of the spreadsheet"),
    "date": (in_book(datetime(2026, 5, 1)), r"cell [A-F]2 holds the date 2026-05-01"),
    "shown in thousands": (lambda rows: book(rows, in_thousands), r"cell [A-F]2 holds .* and shows it over a thousand"),
    "shown in another unit": (lambda rows: book(rows, with_unit), r':2: .* GJ" is what the cell shows'),
    "merged": (lambda rows: book(rows, merged), r"the cells [A-F]2:[A-F]3 are merged"),
    "hidden row": (lambda rows: book(rows, hidden_row), r":3: the row is hidden"),
    "hidden column": (lambda rows: book(rows, hidden_column), r":1: .*the column is hidden"),
    "formula, prefixes": (lambda rows: prefixed(in_book("=10*2")(rows)), r"the formula .* without a stored value"),
    "merged, prefixes": (lambda rows: prefixed(book(rows, merged)), r"the cells [A-F]2:[A-F]3 are merged"),
    "hidden row, prefixes": (lambda rows: prefixed(book(rows, hidden_row)), r":3: the row is hidden"),
    "hidden column, prefixes": (lambda rows: prefixed(book(rows, hidden_column)), r":1: .*the column is hidden"),
    "no height": (lambda rows: written_by_others(book(rows), r'<row r="3"', '<row r="3" ht="0" customHeight="1"'),
                  r":3: the row is hidden"),
    "no width": (lambda rows: written_by_others(
        book(rows), "<sheetData>", '<cols><col min="2" max="2" width="0" customWidth="1"/></cols><sheetData>'),
                 r":1: .*the column is hidden"),
    "hidden sheet": (lambda rows: book(rows, hidden_sheet), r"hidden|no sheet with a table"),
    "heading twice": (lambda rows: lines([[*row, row[-1]] for row in rows]), r":1: .*column stands 2 times"),
    "no heading": (lambda rows: lines([[*rows[0], ""], *([*row, 7.5] for row in rows[1:])]), r"values and no heading"),
    "thousands": (lambda rows: lines(victim("1.250")(rows), ";"), r"2: .*decimal point beside decimal commas"),
    "thousands in doubt": (lambda rows: lines([[c if isinstance(c, str) else "1,250" for c in r] for r in rows], ";"),
                           r"may be 1\.25 or 1250"),
    "spaces": (lambda rows: lines(victim("1 250")(rows)), r"2: .*without separators of thousands"),
    "underscores": (lambda rows: lines(victim("1_250")(rows)), r"2: .*without separators of thousands"),
    "decimal comma": (lambda rows: lines(victim('"1,5"')(rows)), r"2: .*a decimal comma needs semicolons"),
    "infinite": (lambda rows: lines(victim("inf")(rows)), r"2: .*is not a finite number"),
    "more cells": (lambda rows: lines([rows[0], [*rows[1], 5], *rows[2:]]), r":2: .*(more cells|no heading)"),
    "a row that is switched off": (lambda rows: lines(rows).replace("\n", "\n#", 2), r"begins with #"),
    "open quote": (lambda rows: lines(rows) + '"', r"not a CSV file"),
    "old Excel": (lambda rows: b"\xd0\xcf\x11\xe0" + bytes(600), r"old Excel format.*save it as"),
    "zeros": (lambda rows: lines(rows).encode("utf-16-le"), r"not a CSV file"),
    "empty": (lambda rows: "", r"."),
}  # fmt: skip


def read(folder: Path, kind: str, content: Any) -> Any:
    file = folder / ("t.xlsx" if isinstance(content, openpyxl.Workbook) else "t.csv")
    if isinstance(content, openpyxl.Workbook):
        content.save(file)
    else:
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return READERS[kind][0](file)


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("form", SAME)
def test_the_same_numbers_in_every_form(tmp_path: Path, kind: str, form: str) -> None:
    rows = READERS[kind][1]
    assert read(tmp_path, kind, SAME[form](rows)) == read(tmp_path, kind, lines(rows))


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("fault", REFUSED)
def test_what_is_in_doubt_is_refused_with_its_place(tmp_path: Path, kind: str, fault: str) -> None:
    make, message = REFUSED[fault]
    with pytest.raises(UserInputError) as refused:
        read(tmp_path, kind, make(READERS[kind][1]))
    assert re.search(message, str(refused.value)), str(refused.value)


def test_a_zero_that_a_spreadsheet_program_has_computed_is_read(tmp_path: Path) -> None:
    made = book([["H [kN]", "M [kN m]"], [5, "=A2-5"]])
    made.calculation = openpyxl.workbook.properties.CalcProperties(fullCalcOnLoad=None)
    file = tmp_path / "t.xlsx"
    file.write_bytes(written_by_others(made, "<v ?/>", "<v>0</v>"))
    assert read_load_cases(file).loads.tolist() == [[5e3, 0.0]]


@pytest.mark.parametrize("kind", [kind for kind in READERS if kind != "springs"])
def test_two_sheets_of_one_kind_are_refused(tmp_path: Path, kind: str) -> None:
    with pytest.raises(UserInputError, match=r"the sheets .* each hold .*: keep one of them"):
        read(tmp_path, kind, book(READERS[kind][1], twice))


@pytest.mark.parametrize("word", ["", "-", "nan", "n/a"])
@pytest.mark.parametrize(
    ("kind", "column"),
    [(kind, k) for kind, (_, rows) in READERS.items() for k, cell in enumerate(rows[1]) if not isinstance(cell, str)],
)
def test_a_blank_is_never_a_number(tmp_path: Path, kind: str, column: int, word: str) -> None:
    """It is refused, or the value is not given: layers take that of [soil], cases the V asked for."""
    rows = [list(row) for row in READERS[kind][1]]
    rows[2][column] = word
    free = {"layers": ("Effective", "phi", "E ", "Depth to"), "cases": ("V ", "tilt", "H "), "study": ("id",)}
    try:
        found = str(read(tmp_path, kind, lines(rows)))
    except UserInputError as error:
        assert re.search("blank|missing|no number of a case", str(error)), str(error)
        return
    assert rows[0][column].startswith(free.get(kind, ())), found
