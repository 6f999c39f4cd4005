# SPDX-License-Identifier: MIT
"""What the program says to misuses: none is answered with a wrong number and without a word."""

import re
import shlex
import warnings
from pathlib import Path

import pytest

from tests.support.commands import command
from tests.support.misuses import LOST, MISUSES, REFUSED, Misuse, write_files


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of the misuses."""
    made = tmp_path_factory.mktemp("misuses")
    write_files(made)
    return made


def test_there_are_enough() -> None:
    assert len({each.command for each in MISUSES}) == len(MISUSES) >= 40


@pytest.mark.slow
@pytest.mark.parametrize("misuse", MISUSES, ids=lambda each: f"{each.what}: {each.command}")
def test_none_is_answered_without_a_word(misuse: Misuse, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        done = command(*shlex.split(misuse.command))
    assert (done.code, bool(re.search(misuse.says, done.err))) == (misuse.code, True), done.err
    lines = done.err.splitlines()
    if misuse.code in (REFUSED, LOST):
        assert done.out == ""
        assert all(line.startswith("fatal: ") for line in lines if not line.startswith("warning: "))
        assert lines[-1].startswith("fatal: ")
    elif misuse.command.startswith("predict") and "py" not in misuse.command.split():
        rows = done.out.split("\n\n")[0].splitlines()
        marked = [line for line in rows if re.search(r"extrapolated|off_path|off_load|turned_back", line)]
        assert any(line.startswith("warning: ") for line in lines)
        assert marked or "softens" in done.err
