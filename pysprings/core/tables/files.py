# SPDX-License-Identifier: MIT
"""Table files -> sheets of cells: CSV text (UTF-8, UTF-16, Windows-1252) and Excel workbooks; others are refused.

Cells become numbers with decimal points, or with the decimal commas of a European table. What is in doubt is refused: a
number that can be read in two ways is no number, "1.5" beside decimal commas, and "1,250" or "1.250" where every
separator of the table has three digits behind it and may mean thousands.
"""

import csv
import io
import os
import re
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import date, time, timedelta
from pathlib import Path
from typing import Any, NamedTuple, Self

from pysprings.core.errors import UserInputError, refused
from pysprings.core.units import quoted

Cell = Any  # str, float, int, bool, None (blank), or Unread

BLANK = ("", "-", "–", "—", "--", "nan", "n/a", "none", "null")  # words of a cell that is left out, in lower case
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+", re.ASCII)
_SCALED = re.compile(r"[0#?],+(?=[^0#?,]|$)")  # a format that shows a share: 1234.5 is 1.2 in "0.0,"
_LITERAL = re.compile(r'"([^"]*)"|\\(.)')  # texts of a format: MN of 0.0 "MN"
_NOT_FINITE = ("inf", "-inf", "+inf", "infinity", "-infinity")
_MINUS = str.maketrans({"−": "-", "\u00a0": " "})
_ERRORS = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!", "#WERT!", "#BEZUG!", "#NV")


class Unread(str):
    """A cell of a workbook that holds no plain value; `why` is the reason. As a text it is what the sheet shows."""

    __slots__ = ("why",)
    why: str

    def __new__(cls, text: str, why: str) -> Self:
        """Return the text with the reason."""
        cell = super().__new__(cls, text)
        cell.why = why
        return cell


class Shown(float):
    """A number of a cell of a workbook, and the unit that its format shows: "%" of 0.35 that is shown as 35 %."""

    unit: str

    def __new__(cls, value: float, unit: str) -> Self:
        """Return the number with the unit."""
        cell = super().__new__(cls, value)
        cell.unit = unit
        return cell


def in_percent(cell: Cell) -> bool:
    """Return whether a workbook shows a cell in percent."""
    return isinstance(cell, Shown) and cell.unit == "%"


class Style(NamedTuple):
    """How a table writes numbers: ``commas`` for decimals, ``thousands`` where each of its separators may mean them."""

    commas: bool = False
    thousands: bool = False


class NotANumber(ValueError):
    """A cell that is no number; the message is for the user."""


def text_of(cell: Cell) -> str:
    """Return a cell as a text on one line; blank for one of the words of `BLANK`."""
    text = "" if cell is None else str(cell)
    text = " ".join(text.translate(_MINUS).split())
    return "" if text.lower() in BLANK else text


def is_blank(cell: Cell) -> bool:
    """Return whether a cell holds nothing, or a word for nothing."""
    return not text_of(cell)


def style_of(cells: Iterable[Cell], decimals: bool) -> Style:
    """Return the style of texts; with ``decimals`` commas may be decimal ones (no comma separates the cells)."""
    if not decimals:
        return Style()
    texts = [text_of(cell) for cell in cells if isinstance(cell, str)]
    commas = [text for text in texts if _COMMA.fullmatch(text)]
    points = [] if commas else [text for text in texts if _POINT.fullmatch(text)]
    return Style(bool(commas), bool(commas or points) and all(_THOUSANDS.fullmatch(text) for text in commas + points))


def number(cell: Cell, style: Style) -> float | None:
    """Return the number of a cell; None for a blank one. Raises NotANumber."""
    if isinstance(cell, bool):
        raise NotANumber(f"{quoted(cell)} is not a number")
    if isinstance(cell, int | float):
        return float(cell)
    if isinstance(cell, Unread):
        raise NotANumber(cell.why)
    if type(cell) is str and style == Style() and _NUMBER.fullmatch(cell):
        return float(cell)
    text = text_of(cell)
    if not text:
        return None
    comma, point = _COMMA.fullmatch(text), _POINT.fullmatch(text)
    if style.thousands and _THOUSANDS.fullmatch(text):
        whole, decimal = re.sub(r"[.,]", "", text), text.replace(",", ".")
        both = f"may be {float(decimal):g} or {whole}" if decimal.count(".") == 1 else f"may be {whole}"
        raise NotANumber(f"{quoted(text)} {both}: write one digit more or less, or no separator")
    if point and style.commas:
        raise NotANumber(f"{quoted(text)} has a decimal point beside decimal commas in the same table")
    plain = text.replace(",", ".") if comma and style.commas else text
    if _NUMBER.fullmatch(plain):
        return float(plain)
    raise NotANumber(f"{quoted(text)} {_why_not(text, bool(comma))}")


def _why_not(text: str, comma: bool) -> str:
    if text.upper() in _ERRORS:
        return "is an error of the spreadsheet: mend its formula"
    if text.lower() in _NOT_FINITE:
        return "is not a finite number"
    if comma:
        return "is not a number: a decimal comma needs semicolons between the cells"
    if re.fullmatch(r"[+-]?\d{1,3}(?:[ '_,.]\d{3})+(?:[.,]\d+)?", text):
        return "is not a number: write it without separators of thousands"
    if text.startswith("="):
        return "is not a number: it is a formula; write its value"
    return "is not a number"


ENDINGS = (".csv", ".xlsx", ".xlsm", ".tsv", ".txt")
FOREIGN = (".xls", ".xlsb", ".ods", ".numbers")  # refused with what to do
MOST_BYTES = 50_000_000  # of a file, of a workbook when unpacked
MOST_LINES = 300_000  # of a CSV file: ten seconds of checks
MOST_ROWS, MOST_CELLS = 200_000, 5_000_000  # of a sheet of a workbook, blanks up to its last cell counted
MOST_WORDS = 200  # characters of a message of a library
SEPARATORS = (";", "\t", ",")

Line = tuple[int, list[Cell]]  # number of the line, as editors count, and its cells


@dataclass
class Sheet:
    """Lines of one table that are not blank, and what a workbook does to them.

    ``name`` is blank in a CSV file, ``separator`` in a workbook. ``merged`` are (row, column, row, column) of the
    corners of merged cells, ``hidden_lines`` and ``hidden_columns`` count from 1.
    """

    place: str
    name: str
    lines: list[Line]
    separator: str = ""
    hidden: bool = False
    merged: list[tuple[int, int, int, int]] = field(default_factory=list)
    hidden_lines: frozenset[int] = frozenset()
    hidden_columns: frozenset[int] = frozenset()


def is_table(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is a table, by its ending."""
    return Path(path).suffix.lower() in (*ENDINGS, *FOREIGN)


def sheets_of(path: Path) -> list[Sheet]:
    """Return the sheets of a table file; a CSV file as it reads with each separator that its first lines hold.

    Raises UserInputError: no file, no table, or one beyond the limits of size.
    """
    try:
        if path.is_dir():
            raise refused(None, "is a folder", path)
        _refuse_large(path, path.stat().st_size)
        raw = path.read_bytes()
    except FileNotFoundError:
        raise refused(None, "no such file", path) from None
    except OSError as error:
        raise refused(None, f"cannot be read: {error.strerror}", path) from None
    if raw[:4] == b"PK\x03\x04" and b"opendocument" not in raw[:100]:
        return _workbook(path, raw)
    save_as = "save it as .xlsx or .csv"
    if raw[:4] == b"\xd0\xcf\x11\xe0" or path.suffix.lower() in (".xls", ".xlsb"):
        raise refused(None, f"is a workbook of the old Excel format, or one with a password: {save_as}", path)
    if raw[:2] == b"PK" or path.suffix.lower() in (".ods", ".numbers"):
        raise refused(None, f"is a spreadsheet of another program: {save_as}", path)
    if path.suffix.lower() in (".xlsx", ".xlsm"):
        raise refused(None, "not an Excel workbook (File is not a zip file)", path)
    return list(_texts(path, _decoded(path, raw)))


def _decoded(path: Path, raw: bytes) -> str:
    if (count := raw.count(b"\n")) > MOST_LINES:
        words = f"{count:,} lines, at most {MOST_LINES:,}; springs.nc of a run has no such limit"
        raise refused(None, f"is too large for a table ({words})", path)
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        names: tuple[str, ...] = ("utf-16",)
    else:
        names = () if b"\0" in raw else ("utf-8-sig", "cp1252")
    for name in names:
        try:
            return raw.decode(name)
        except UnicodeDecodeError:
            continue
    raise refused(None, "not a CSV file in UTF-8, UTF-16 or Windows-1252: save it as CSV UTF-8", path)


def _texts(path: Path, text: str) -> Iterator[Sheet]:
    """Yield the sheet of a text with each separator that its first lines hold; "sep=;" of Excel chooses it."""
    first = text.lstrip().split("\n", 1)[0].strip()
    named = re.fullmatch(r"sep=(.)", first)
    head = "\n".join(text.splitlines()[:40])
    chosen = [named[1]] if named else [each for each in SEPARATORS if each in head] or [","]
    faults = []
    for separator in chosen:
        try:
            with io.StringIO(text, newline="") as stream:
                reader = csv.reader(stream, delimiter=separator, strict=True)
                lines = [(reader.line_num, list(row)) for row in reader if any(cell.strip() for cell in row)]
        except csv.Error as error:  # commas do not separate "a";1,5
            faults.append(error)
            continue
        yield Sheet(str(path), "", lines[bool(named) :], separator)
    if len(faults) == len(chosen):
        raise refused(None, f"not a CSV file ({faults[-1]})", path)


def _workbook(path: Path, raw: bytes) -> list[Sheet]:
    import openpyxl

    try:
        with io.BytesIO(raw) as stream, zipfile.ZipFile(stream) as archive:
            _refuse_large(path, sum(part.file_size for part in archive.infolist()), " when unpacked")
            book, formulas = (openpyxl.load_workbook(stream, read_only=True, data_only=each) for each in (True, False))
            try:
                return [_sheet(path, archive, *pair) for pair in zip(book.worksheets, formulas.worksheets, strict=True)]
            finally:
                book.close()
                formulas.close()
    except UserInputError:
        raise
    except Exception as error:  # a broken archive raises many types
        why = str(error) or type(error).__name__
        raise refused(None, f"not an Excel workbook ({why[:MOST_WORDS]})", path) from None


def _sheet(path: Path, archive: zipfile.ZipFile, values: Any, formulas: Any) -> Sheet:
    """Return a sheet of a workbook; a formula without a stored value is a cell that is refused where it is used.

    A 0 is none in a workbook that is to be calculated when it is opened: XlsxWriter stores it for every formula.
    """
    from openpyxl.utils import range_boundaries

    xml = re.sub(
        rb"<(/?)[A-Za-z_][\w.-]*:(?=[A-Za-z])", rb"<\1", archive.read(values._worksheet_path)
    )  # <x:row> is <row>
    lines = list(_rows(path, values))
    if b"<f" in xml:
        by_line, none = dict(lines), (None, 0) if _to_calculate(archive) else (None,)
        for row in formulas.iter_rows():
            for cell in row:
                if cell.data_type == "f" and _at(by_line.get(cell.row, []), cell.column - 1) in none:
                    text = cell.value if isinstance(cell.value, str) else "array formula"
                    cells = by_line.setdefault(cell.row, [])
                    cells += [None] * (cell.column - len(cells))
                    why = f"cell {cell.coordinate} holds the formula {quoted(text)} without a stored value: open and "
                    cells[cell.column - 1] = Unread(text, f"{why}save the file in Excel, or write the number")
        lines = sorted(by_line.items())
    merged = []
    for ref in re.findall(rb'<mergeCell [^>]*?ref="([A-Z0-9:]+)"', xml):
        left, top, right, bottom = (int(each or 0) for each in range_boundaries(ref.decode()))
        merged.append((top, left, bottom, right))
    rows = {int(found[1]) for tag in _hidden(xml, b"row", b"ht") if (found := re.search(rb'\br="(\d+)"', tag))}
    columns = [
        (int(low), int(high))
        for tag in _hidden(xml, b"col", b"width")
        for low, high in [(re.search(rb'min="(\d+)"', tag)[1], re.search(rb'max="(\d+)"', tag)[1])]  # type: ignore[index]
    ]
    return Sheet(
        f"{path}[{values.title}]", values.title, lines, "", values.sheet_state != "visible", merged,
        frozenset(rows), frozenset(k for a, b in columns for k in range(a, b + 1)),
    )  # fmt: skip


def _to_calculate(archive: zipfile.ZipFile) -> bool:
    """Return whether a workbook is to be calculated when it is opened (openpyxl takes True where nothing stands)."""
    parts = [archive.read(name) for name in archive.namelist() if name.endswith("/workbook.xml")]
    return any(re.search(rb'<(?:\w+:)?calcPr [^>]*fullCalcOnLoad="(?:1|true)"', part) for part in parts)


def _hidden(xml: bytes, tag: bytes, size: bytes) -> list[bytes]:
    """Return the tags of rows or columns that a sheet does not show: hidden, or of no height or width."""
    tags: list[bytes] = re.findall(rb"<%b [^>]*>" % tag, xml)
    wanted = re.compile(rb'\s(?:hidden="(?:1|true)"|%b="0(?:\.0*)?")' % size)
    return [each for each in tags if wanted.search(each)]


def _rows(path: Path, sheet: Any) -> Iterator[Line]:
    """Yield the lines of a sheet that are not blank."""
    for line, cells in enumerate(sheet.iter_rows(), start=1):
        if line > MOST_ROWS or line * len(cells) > MOST_CELLS:
            wide = f"{MOST_CELLS:,} cells up to its last column, {len(cells):,}: delete what is beside"
            most = f"{MOST_ROWS:,} lines" if line > MOST_ROWS else wide
            raise refused(None, f"is too large for a table (sheet {quoted(sheet.title)} has more than {most})", path)
        values = [_value(cell) for cell in cells]
        if any(value is not None for value in values):
            yield line, values


def _value(cell: Any) -> Cell:
    value = cell.value
    if isinstance(value, float | int) and not isinstance(value, bool):
        if _SCALED.search(re.sub(r'"[^"]*"', "", cell.number_format)):
            why = f"cell {cell.coordinate} holds {value:g} and shows it over a thousand (format {cell.number_format}): "
            return Unread(str(value), f"{why}give it the format General, and the value in the unit of the heading")
        words = "".join(map("".join, _LITERAL.findall(cell.number_format.partition(";")[0]))).strip()
        unit = "%" if "%" in cell.number_format else words
        return Shown(value, unit) if unit else value
    if isinstance(value, date | time | timedelta):
        why = f"cell {cell.coordinate} holds the date {value}: spreadsheets make dates of numbers such as 1.5; "
        return Unread(str(value), f"{why}write the number, in the format General")
    if isinstance(value, str) and value in _ERRORS:
        return Unread(value, f"cell {cell.coordinate} holds the error {value}: mend its formula")
    return value


def _at(cells: list[Cell], column: int) -> Cell:
    return cells[column] if column < len(cells) else None


def _refuse_large(path: Path, size: int, words: str = "") -> None:
    if size > MOST_BYTES:
        raise refused(
            None, f"is too large for a table ({size / 1e6:,.0f} MB{words}, at most {MOST_BYTES / 1e6:.0f})", path
        )
