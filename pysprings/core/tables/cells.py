# SPDX-License-Identifier: MIT
"""Cells of tables as numbers: decimal points, or the decimal commas of a European table; what is in doubt is refused.

A number that can be read in two ways is no number: "1.5" beside decimal commas, and "1,250" or "1.250" where every
separator of the table has three digits behind it and may mean thousands.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from pysprings.core.units import quoted

Cell = Any  # str, float, int, bool, None (blank), or Unread

BLANK = ("", "-", "–", "—", "--", "nan", "n/a", "none", "null")  # words of a cell that is left out, in lower case
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+", re.ASCII)
_NOT_FINITE = ("inf", "-inf", "+inf", "infinity", "-infinity")
_MINUS = str.maketrans({"−": "-", "\u00a0": " "})
_ERRORS = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!", "#WERT!", "#BEZUG!", "#NV")


class Unread(str):
    """A cell of a workbook that holds no plain value; `why` is the reason. As a text it is what the sheet shows."""

    __slots__ = ("why",)
    why: str

    def __new__(cls, text: str, why: str) -> Unread:
        """Return the text with the reason."""
        cell = super().__new__(cls, text)
        cell.why = why
        return cell


class Percent(float):
    """A number of a cell that a workbook shows in percent: 0.35, shown as 35 %."""


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
