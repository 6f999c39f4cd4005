# SPDX-License-Identifier: MIT
"""Texts of a spring file that would be commands in the files for other programs, run in these programs."""

import csv
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.core.storage import write_tree
from pysprings.core.text import commented, is_formula, one_line
from pysprings.results.exporters import EXPORTERS, export
from pysprings.springs.checks import open_springs, save_springs
from tests.support import vertical
from tests.support.openfast import drive

MARK = "PWNED"
LINE_ENDS = ("\n", "\r\n", "\r", "\x0b", "\x0c", "\x85", "\u2028", "\u2029", "\x00")
BODY = f"open('{MARK}','w') [open {MARK} w] exec(open {MARK}) *BOUNDARY {MARK} \"\"\" ''' */ int {MARK}; END \\"
# texts that decide what the file is; another value is refused
FIXED = {"schema", "kind", "role", "status", "Conventions", "drainage", "caisson_behaviour", "scene_toml"}
MARKS = {"beam": "#", "openfast": "!", "subdyn": "!", "opensees": "#", "calculix": "**", "sacs": "*"}


def hostile(end: str) -> xr.DataTree:
    """A spring set with a hostile text in every field that takes one, root, paths and variables."""
    springs = vertical.fan_with_vertical().copy(deep=True)
    for node in springs.subtree:
        for attrs in (node.attrs, *(data.attrs for data in node.variables.values())):
            attrs |= {
                key: f"x{end}{BODY}" for key, value in attrs.items() if isinstance(value, str) and key not in FIXED
            }
    springs.attrs |= {"title": f"x{end}{BODY}", "defaulted": f"x{end}{BODY}", "remarks": f"x{end}{BODY}"}
    return springs


def test_a_text_is_one_line_behind_its_mark() -> None:
    for end in LINE_ENDS:
        (line,) = commented("#", [f"a{end}b\\"])
        assert line.startswith("# a") and line.endswith("b") and len(line.splitlines()) == 1
    assert one_line("a  b") == "a  b"  # columns stay
    long = commented("**", ["A" * 1317 + "*BOUNDARY " + "x\\ " * 600 + "end"])  # CalculiX cuts a line at 1,320 letters
    assert len(long) > 4 and all(line.startswith("** ") and len(line) < 410 and line[-1] != "\\" for line in long)


@pytest.mark.parametrize("end", LINE_ENDS[:-1], ids=ascii)
def test_a_spring_file_with_a_text_on_two_lines_is_refused(tmp_path: Path, end: str) -> None:
    springs = vertical.fan_with_vertical().copy(deep=True)
    file = save_springs(springs, tmp_path / "s.nc")
    for place, key in (("/", "title"), ("/paths/ray_0", "note"), ("/", "history")):
        changed = springs.copy(deep=True)
        changed[place].attrs[key] = f"x{end}{BODY}"
        with pytest.raises(UserInputError, match=f"{key}.*line end or a control character"):
            save_springs(changed, tmp_path / "t.nc")
        write_tree(changed, file)
        with pytest.raises(UserInputError, match=f"{key}.*line end or a control character"):
            open_springs(file)


def lines_of(folder: Path, mark: str) -> Iterator[str]:
    """Yield the lines with the payload that do not stand behind the mark of their program."""
    for file in sorted(folder.iterdir()):
        lines = file.read_text(encoding="utf-8").splitlines()
        yield from (line for line in lines if MARK in line and not line.lstrip().startswith(mark))


@pytest.mark.parametrize("name", sorted(MARKS))
def test_hostile_texts_stay_comments(tmp_path: Path, name: str) -> None:
    for k, end in enumerate(("\n", "\u2028", "\r")):
        done = export(hostile(end), name, tmp_path / str(k))
        assert done.files
        assert any(MARK in file.read_text(encoding="utf-8") for file in done.files)  # it reached the comments
        assert not list(lines_of(tmp_path / str(k), MARKS[name]))


def test_every_exporter_of_text_is_tested() -> None:
    tables = {"csv", "wide", "json", "xlsx", "nc", "paraview"}  # numbers, or formats that escape
    assert {each.name for each in EXPORTERS} == tables | set(MARKS)


def test_hostile_texts_do_nothing_in_the_programs(tmp_path: Path) -> None:
    """Python, Tcl, CalculiX and SoilDyn's driver, where they are, read the files, and nothing of the texts acts."""
    springs = hostile("\n")
    springs.attrs["title"] += "A" * 1317 + "*BOUNDARY " * 500
    for name in ("opensees", "calculix", "openfast"):
        export(springs, name, tmp_path, **({} if name == "openfast" else {"points": 20}))
    subprocess.run([sys.executable, "-c", "import caisson_opensees"], cwd=tmp_path, check=True)
    tcl = "import tkinter; tkinter.Tcl().call('source', 'caisson_opensees.tcl')"
    done = subprocess.run([sys.executable, "-c", tcl], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 or "tkinter" in done.stderr, done.stderr
    if shutil.which("ccx"):
        done = subprocess.run(["ccx", "example_calculix"], cwd=tmp_path, capture_output=True, text=True, timeout=280)
        assert "Job finished" in done.stdout, done.stdout[-1000:]
    assert not [file for file in tmp_path.iterdir() if MARK in file.name]
    assert drive(tmp_path, np.zeros((3, 6))).code == 0
    assert not [file for file in tmp_path.iterdir() if MARK in file.name]


def test_tables_hold_texts_and_no_formulas(tmp_path: Path) -> None:
    """Workbook and CSV of springs whose texts would be formulas, links and calls of programs in a spreadsheet."""
    springs = vertical.fan_with_vertical().copy(deep=True)
    springs.attrs |= {"title": "=cmd|' /C calc'!A0", "source": "http://x.y", "history": "@SUM(1)", "drainage": "+1+1"}
    export(springs, "xlsx", tmp_path / "s.xlsx")
    for sheet in openpyxl.load_workbook(tmp_path / "s.xlsx"):
        for row in sheet.iter_rows():
            assert not [cell.coordinate for cell in row if cell.data_type == "f" or cell.hyperlink]
    for name in ("csv", "wide"):
        export(springs, name, tmp_path / "s.csv")
        cells = [
            cell for row in csv.reader((tmp_path / "s.csv").read_text(encoding="utf-8").splitlines()) for cell in row
        ]
        assert len(cells) > 100 and not list(filter(is_formula, cells))


@pytest.mark.parametrize("text", ["=1+1", "@x", "+cmd|x", "-x", " =1", "-1+cmd|' /C calc'!A0", "+1-2*A1", "-2(A1)"])
def test_what_a_spreadsheet_takes_for_a_formula(text: str) -> None:
    assert is_formula(text)
    assert not any(map(is_formula, ("-5 kN", "+.5", "clay", "-", "-1e-3 m", "-5 kN m^-1", "-0.5 %", "+3,5 deg")))
