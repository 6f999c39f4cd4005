# SPDX-License-Identifier: MIT
"""Readers of tables as plug-ins: one from outside the package, through Python and the command line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.predict import predict
from pysprings.results.tables import TABLE_READERS, Sheet, TableReader, endings, is_table, open_table
from tests.support import synthetic, written
from tests.support.commands import command


def sheets(path: Path) -> Iterator[Sheet]:
    """Lines of a file whose cells are separated by semicolons."""
    lines = path.read_text(encoding="utf-8").splitlines()
    yield Sheet("", [(number, line.split(";")) for number, line in enumerate(lines, start=1) if line])


TOY = TableReader("semicolons", (".ssv",), sheets)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The table of a run with semicolons."""
    table, _ = written.tables(tmp_path, synthetic.make_springs())
    text = table.read_text(encoding="utf-8")
    assert ";" not in text and '"' not in text
    file = tmp_path / "py.ssv"
    file.write_text(text.replace(",", ";"), encoding="utf-8")
    return file


def test_a_reader_from_outside(file: Path) -> None:
    assert not is_table(file)
    springs = synthetic.make_springs()
    with TABLE_READERS.added(TOY):
        assert is_table(file) and endings() == [".csv", ".xlsx", ".ssv"]
        state = predict(open_table(file), H=2e5)
        done = command("predict", file, "--H", "200 kN", "--json")
    assert done.code == 0
    (row,) = json.loads(done.out)["states"]
    expected = float(predict(springs, H=2e5)["u"])
    assert row["u"] == float(state["u"]) == pytest.approx(expected, rel=1e-6)


def test_its_faults_have_lines(file: Path) -> None:
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[4] = lines[4].replace("py;", "pz;", 1)
    file.write_text("\n".join(lines), encoding="utf-8")
    with TABLE_READERS.added(TOY), pytest.raises(UserInputError, match=rf"{file.name}:5: family: \"pz\" is not one of"):
        open_table(file)
