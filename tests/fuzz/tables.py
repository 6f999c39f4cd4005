# SPDX-License-Identifier: MIT
"""Hostile tables: CSV files and Excel workbooks of springs, sequences of loads; cells, columns, archives."""

import io
import zipfile
from collections.abc import Sequence
from functools import cache
from typing import Any

from hypothesis import strategies as st

from pysprings.results.exporters import text
from tests.fuzz.mutate import NUMBERS, RAW, TEXTS, Data, Op, damage, ops
from tests.support import synthetic

Rows = list[list[str]]

MINIMAL = "depth_m,y_m,p_N_per_m\n0.5,0.001,200e3\n0.5,0.01,400e3\n2.0,0.001,300e3\n2.0,0.01,700e3\n"
COMPANIONS = (
    "family,depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m,rotation_rad,m_Nm_per_m,H_N,M_Nm\n"
    "py,0.5,0,1,0.001,2e5,,,,\npy,0.5,0,1,0.01,4e5,,,,\npy,2,1,3,0.001,3e5,,,,\npy,2,1,3,0.01,7e5,,,,\n"
    "mtheta,0.5,,,,,0.001,1e5,,\nmtheta,0.5,,,,,0.01,2e5,,\nmtheta,2,,,,,0.001,1e5,,\nmtheta,2,,,,,0.01,2e5,,\n"
    "base,,,,0.01,,,,1e5,\nbase,,,,,,0.01,,,2e6\nlid,,,,0.01,,,,1e5,\nlid,,,,,,0.01,,,2e6\n"
)
SEQUENCE = "H_N,arm_m,V_N\n1e5,2,2e6\n2e5,2,2e6\n-1e5,2,2e6\n"
MOTIONS = "u_m,rotation_rad\n1e-3,0\n1e-3,1e-4\n0,0\n"

CELL_OPS = (
    "number", "number", "number", "text", "blank", "copy", "negate", "power", "drop row", "twice", "swap",
    "move column", "rename", "drop column", "add column", "more cells", "many",
)  # fmt: skip
GENTLE_OPS = ("scale", "scale", "scale", "blow", "negate", "drop row", "swap", "move column", "copy")
HEADINGS = [
    "y_mm", "y", "p_kN_per_m", "depth_m", "", " ", "path", "family", "side", "step", "converged", "rotation_deg", "z",
    "Depth_M", "depth_top_m", "=1+1", "\ufeffdepth_m", "x" * 3000, "y_m\n", '"', "component",
]  # fmt: skip
WORDS = ["py", "mtheta", "base", "lid", "net", "total", "outside", "normal", "table", "a/b", "..", ".", "/", "0", "1"]


@cache
def record() -> str:
    """What `pysprings springs` writes of two rays and a pull."""
    caisson = synthetic.Caisson(rings=3, sectors=8)
    paths = (
        synthetic.Path("slide", "translation", steps=3),
        synthetic.Path("turn", "rotation", size=1e-3, steps=3),
        synthetic.Path("pull", steps=3),
    )
    return text(synthetic.make_springs(paths, caisson), "csv")


def spoil(rows: Rows, todo: Sequence[Op]) -> Rows:
    """Return rows (the first one is the heading) with cells, rows and columns damaged."""
    for what, where, how in todo:
        if len(rows) < 2 or not rows[0]:
            return rows
        _spoil(rows, what, where, how)
    return rows


def _spoil(rows: Rows, what: str, where: int, how: int) -> None:
    line = 1 + where % (len(rows) - 1)
    row = rows[line]
    column = where // 1000 % max(len(row), 1)
    if what in ("number", "text", "blank", "negate", "scale", "power", "blow", "copy") and row:
        cell = row[column]
        other = rows[1 + how % (len(rows) - 1)]
        row[column] = {
            "number": NUMBERS[how % len(NUMBERS)],
            "text": [*TEXTS, *WORDS][how % (len(TEXTS) + len(WORDS))],
            "blank": "",
            "negate": cell[1:] if cell.startswith("-") else f"-{cell}",
            "power": f"{cell}e{how % 600 - 300}",
            "scale": _scaled(cell, 0.5 + how % 1000 / 1000.0),
            "blow": _scaled(cell, 10.0 ** (how % 20 - 10)),
            "copy": other[column] if column < len(other) else "",
        }[what]
    elif what == "drop row":
        del rows[line]
    elif what == "twice":
        rows.insert(line, list(row))
    elif what == "swap":
        other_line = 1 + how % (len(rows) - 1)
        rows[line], rows[other_line] = rows[other_line], rows[line]
    elif what == "more cells":
        row += ["1"] * (how % 5)
    elif what == "many":
        rows[line:line] = [list(row) for _ in range(how % 2000)]
    else:
        _spoil_column(rows, what, where % len(rows[0]), how)


def _scaled(cell: str, factor: float) -> str:
    try:
        return repr(float(cell) * factor)
    except ValueError:
        return cell


def _spoil_column(rows: Rows, what: str, column: int, how: int) -> None:
    if what == "rename":
        rows[0][column] = HEADINGS[how % len(HEADINGS)]
        return
    if what == "add column":
        for k, row in enumerate(rows):
            row.append([*HEADINGS, *WORDS][how % (len(HEADINGS) + len(WORDS))] if k == 0 else str(how % 7))
        return
    for row in rows:
        if column < len(row):
            cell = row.pop(column)
            if what == "move column":
                row.insert(how % (len(row) + 1), cell)


def _parsed(text: str) -> Rows:
    return [line.split(",") for line in text.splitlines()]


@st.composite
def _rows(draw: st.DrawFn, bases: Sequence[str]) -> Rows:
    todo = draw(ops(GENTLE_OPS, 3)) if draw(st.booleans()) else draw(ops(CELL_OPS, 3))
    return spoil(_parsed(draw(st.sampled_from(bases))), todo)


@st.composite
def csv_files(draw: st.DrawFn, bases: Sequence[str] | None = None) -> Data:
    """Draw a CSV file that was a good one."""
    rows = draw(_rows(bases or [MINIMAL, COMPANIONS, record()]))
    end, mark = draw(st.sampled_from([*6 * [("\n", ",")], ("\r\n", ","), ("\r", ","), ("\n", ";"), ("\n", "\t")]))
    text = end.join(mark.join(row) for row in rows)
    codec = draw(st.sampled_from([*9 * ["utf-8"], "utf-8-sig", "utf-16", "latin-1"]))
    data = text.encode(codec, "replace")
    return damage(data, draw(ops(RAW, 3))) if draw(st.integers(0, 7)) == 0 else Data(data)


SHEETS = [*12 * ["p-y"], "py", "mtheta", "base", "About", "charts", "=1+1", "Sheet 1", "x" * 31, "lid", "é"]


@st.composite
def workbooks(draw: st.DrawFn) -> Data:
    """Draw an Excel workbook: one or two sheets of damaged tables, and damage to the archive itself."""
    import openpyxl

    book = openpyxl.Workbook()
    book.remove(book.active)
    for name in draw(st.lists(st.sampled_from(SHEETS), min_size=1, max_size=2, unique=True)):
        sheet = book.create_sheet(name)
        for row in draw(_rows([MINIMAL, COMPANIONS])):
            sheet.append([_cell(text, draw) for text in row])
        if draw(st.integers(0, 5)) == 0:
            sheet.merge_cells(start_row=1, start_column=1, end_row=2, end_column=2)
        elif draw(st.integers(0, 9)) == 0:
            value = draw(st.sampled_from(["x", 1e308, True]))
            sheet.cell(row=2, column=draw(st.sampled_from([1, 50, 16384])), value=value)
        if draw(st.integers(0, 19)) == 0:
            sheet.cell(row=draw(st.sampled_from([1000, 300_000, 1_048_576])), column=1, value="far")
    stream = io.BytesIO()
    book.save(stream)
    return Data(_archive(stream.getvalue(), draw))


def _cell(text: str, draw: st.DrawFn) -> Any:
    """Return a cell as a number where it is one, else as text that a workbook can hold."""
    try:
        return float(text) if len(text) < 30 and text.isascii() and "_" not in text else text[:100]
    except ValueError:
        return "".join(c for c in text[:3000] if c.isprintable()) or None


def _archive(data: bytes, draw: st.DrawFn) -> bytes:
    """Return a workbook's bytes, damaged as bytes, as an archive, or inside one of its parts."""
    how = draw(st.sampled_from(["", "", "", "", "", "", "bytes", "part", "part", "lost", "bomb", "text"]))
    if how == "text":
        return MINIMAL.encode()
    if how == "bytes":
        return damage(data, draw(ops(RAW, 4)))
    if not how:
        return data
    old = zipfile.ZipFile(io.BytesIO(data))
    stream, chosen = io.BytesIO(), draw(st.sampled_from(old.namelist()))
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            part = old.read(name)
            if name == chosen and how == "lost":
                continue
            if name == chosen and how == "part":
                part = damage(part, draw(ops(RAW, 4)))
            if name == chosen and how == "bomb":
                part = part.replace(b"<sheetData>", b"<sheetData>" + b" " * 60_000_000)
            new.writestr(name, part)
    return stream.getvalue()
