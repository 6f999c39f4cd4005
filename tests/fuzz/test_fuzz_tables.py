# SPDX-License-Identifier: MIT
"""Tables of springs and sequences, damaged, through `pysprings predict`: an answer, or refusals with their lines."""

from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from tests.fuzz.judge import run
from tests.fuzz.mutate import QUICK, budget
from tests.fuzz.tables import MINIMAL, MOTIONS, SEQUENCE, csv_files, record, workbooks

CSV, BOOKS, SEQUENCES = "tables (CSV)", "tables (Excel)", "sequences (CSV)"
QUESTIONS = [
    ["--H", "100 kN", "--arm", "2 m"],
    ["--u-max", "5 mm", "--points", "5"],
    ["--u", "1 mm", "--rotation", "0.1 mrad"],
    ["--u", "1 m", "--stiffness"],
    ["--H", "-1e6 MN"],
    ["--H", "100 kN", "--springs", "py"],
    ["--H", "100 kN", "--springs", "full", "--strict"],
    ["--H", "100 kN", "--springs", "fan"],
    ["--H", "100 kN", "--skirt-length", "3 m"],
    ["--M", "-1 MN m"],
]
questions = st.sampled_from(QUESTIONS)


def predict(kind: str, folder: Path, name: str, data: bytes, asked: list[str]) -> None:
    file = folder / name
    file.write_bytes(data)
    run(kind, folder, "predict", file, *asked, "--json")


def follow(folder: Path, data: bytes, springs: str) -> None:
    (folder / "springs.csv").write_text(springs)
    (folder / "way.csv").write_bytes(data)
    run(SEQUENCES, folder, "predict", folder / "springs.csv", "--sequence", folder / "way.csv", "--json")


@budget(QUICK)
@given(data=csv_files(), asked=questions)
def test_csv_tables(tmp_path: Path, data: bytes, asked: list[str]) -> None:
    predict(CSV, tmp_path, "t.csv", data, asked)


@pytest.mark.long
@budget(1000)
@given(data=csv_files(), asked=questions)
def test_many_csv_tables(tmp_path: Path, data: bytes, asked: list[str]) -> None:
    predict(CSV, tmp_path, "t.csv", data, asked)


@budget(QUICK)
@given(data=workbooks(), asked=questions)
def test_workbooks(tmp_path: Path, data: bytes, asked: list[str]) -> None:
    predict(BOOKS, tmp_path, "t.xlsx", data, asked)


@pytest.mark.long
@budget(600)
@given(data=workbooks(), asked=questions)
def test_many_workbooks(tmp_path: Path, data: bytes, asked: list[str]) -> None:
    predict(BOOKS, tmp_path, "t.xlsx", data, asked)


@budget(QUICK)
@given(data=csv_files([SEQUENCE, MOTIONS]), full=st.booleans())
def test_sequences(tmp_path: Path, data: bytes, full: bool) -> None:
    follow(tmp_path, data, record() if full else MINIMAL)


@pytest.mark.long
@budget(500)
@given(data=csv_files([SEQUENCE, MOTIONS]), full=st.booleans())
def test_many_sequences(tmp_path: Path, data: bytes, full: bool) -> None:
    follow(tmp_path, data, record() if full else MINIMAL)
