# SPDX-License-Identifier: MIT
"""What the program says to misuses: none is answered with a wrong number and without a word. The page of the docs."""

import os
import re
import shlex
import warnings
from pathlib import Path

import pytest

from tests.support.commands import Result, command
from tests.support.misuses import CHAPTERS, LOST, MISUSES, REFUSED, WARNED, Misuse, write_files
from tests.support.place import ROOT
from tests.support.stored import RENEW

PAGE = ROOT / "docs" / "reference" / "misuses.md"
HEAD = """# Misuses

What the program says to loads, springs, files and scenes that do not fit: exit code 2 is a refusal, 3 no equilibrium;
with exit code 0 there is an answer, which is flagged. The springs are invented ones;
`tests/pysprings/cli/test_misuses.py` runs each line and renews this page.
"""
MOST = 260  # letters of a message on the page


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Result]:
    """What the program says to each misuse."""
    folder, before = tmp_path_factory.mktemp("misuses"), Path.cwd()
    write_files(folder)
    os.chdir(folder)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            return {each.command: command(*shlex.split(each.command)) for each in MISUSES}
    finally:
        os.chdir(before)


def test_there_are_enough() -> None:
    assert len({each.command for each in MISUSES}) == len(MISUSES) >= 40


@pytest.mark.slow
@pytest.mark.parametrize("misuse", MISUSES, ids=lambda each: each.command)
def test_none_is_answered_without_a_word(misuse: Misuse, said: dict[str, Result]) -> None:
    done = said[misuse.command]
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


@pytest.mark.slow
def test_the_page_has_what_the_program_says(said: dict[str, Result]) -> None:
    lines = [HEAD]
    for chapter, misuses in CHAPTERS.items():
        lines += [f"## {chapter}\n", "| misuse | command | exit code | message |", "| --- | --- | --: | --- |"]
        lines += [f"| {each.what} | `{each.command}` | {each.code} | {_words(each, said)} |" for each in misuses]
        lines.append("")
    text = "\n".join(lines).rstrip() + "\n"
    if os.environ.get(RENEW):
        PAGE.write_text(text, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == text


def _words(misuse: Misuse, said: dict[str, Result]) -> str:
    """Return the first message that is meant, for a table."""
    texts = said[misuse.command].err.splitlines()
    text = next((line for line in texts if re.search(misuse.says, line)), texts[0])
    text = re.sub(r"^(fatal: (user input|not converged): |warning: |note: )", "", text)
    text = text if len(text) <= MOST else f"{text[: MOST - 3]}..."
    return text.replace("|", "\\|").replace("`", "'").replace("<", "&lt;")


assert WARNED == 0
