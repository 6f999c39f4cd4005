# SPDX-License-Identifier: MIT
"""The numbers of the tutorials and of the first-run page are those that the commands print, to two digits."""

import re
import shutil
from pathlib import Path

import pytest

from tests.support.commands import command
from tools.tutorials import PAGES, STORED, blocks

NUMBER = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?(?![\w]*\.(?:md|toml|csv))", re.I)
SMALL = 12  # counts and steps of a page
# numbers of a page that no command prints, with their reason
GIVEN = {
    "first-run": {200.0},
    "site": {2.6},  # I_c between sand and clay
    "sand": {200.0, 35.0, 30.0},  # D/200; friction angle and depth of the ground
    "clay": {200.0, 48.0},  # G/su and radius of the template
    "partially-drained": {400.0, 40.0, 30.0, 2957.0},  # seconds at its rates; metres of water; K_H of first-run
}


def values(text: str) -> list[float]:
    """Return the numbers of a text, those with commas between thousands too."""
    return [float(each.replace(",", "")) for each in NUMBER.findall(text) if each.replace(",", "") not in ("-", "")]


def alike(a: float, b: float) -> bool:
    """Return whether two numbers are the same to two digits, whatever their signs."""
    return abs(abs(a) - abs(b)) <= 0.05 * abs(b)


def words(line: str) -> str:
    return " ".join(NUMBER.sub("#", line).split())


@pytest.mark.parametrize("name", PAGES)
def test_blocks_of_a_page_are_lines_that_its_commands_print(name: str) -> None:
    stored = (STORED / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    shown = [line for block in blocks(PAGES[name], "text") for line in block.splitlines() if line.strip(" -")]
    assert shown or name == "partially-drained"
    for line in shown:
        head = words(line.split("...")[0])
        found = [other for other in stored if words(other).startswith(head)]
        assert found, f"no command of the page prints: {line}"
        mine = values(line.split("...")[0])
        assert any(all(map(alike, mine, values(other))) for other in found), f"{line}\nis printed as\n{found[0]}"


def is_rounded(text: str, known: list[float]) -> bool:
    """Return whether a number of the words is a known one, rounded to its digits."""
    text = text.replace(",", "")
    half = 0.501 * 10.0 ** -len(text.partition(".")[2])
    return any(abs(abs(float(text)) - abs(each)) <= half for each in known)


@pytest.mark.parametrize("name", PAGES)
def test_numbers_in_the_words_of_a_page_are_printed_by_its_commands(name: str) -> None:
    page = PAGES[name].read_text(encoding="utf-8")
    prose = re.sub(r"^```.*?^```", "", page, flags=re.M | re.S)
    prose = re.sub(r"\]\([^)]*\)|`[^`]*`|^#.*$", " ", prose, flags=re.M)
    code = " ".join(re.findall(r"^```.*?^```", page, flags=re.M | re.S)) + " ".join(re.findall(r"`[^`]*`", page))
    printed, _, loads = (STORED / f"{name}.txt").read_text(encoding="utf-8").partition("load_displacement.csv\n")
    printed = re.sub(r"^\$ .*--u-max.*?(?=^\$ )", "", printed, flags=re.M | re.S)  # fifty rows of a curve
    known = values(printed) + values(code) + [*GIVEN.get(name, ())]
    known += [scale * each for each in values(loads) for scale in (1e-6, 1e-3, 1e3)]
    shown = [text for text in NUMBER.findall(prose) if "." in text or abs(float(text.replace(",", ""))) > SMALL]
    assert not [text for text in shown if not is_rounded(text, known)], f"{name}: no command of the page prints these"


def test_the_stored_proposal_of_the_ground_is_todays(tmp_path, monkeypatch) -> None:
    """A row at 5 m had moved from the sand to the clay: D_r 0.588 was stored where the command printed 0.599."""
    monkeypatch.chdir(shutil.copytree(STORED, tmp_path / "site"))
    done = command("ground", "site-cpt.gef", "site-lab.csv", "--depth", "24 m", "--out", "site.csv", "--no-figures")
    assert done.out and done.out in Path("site.txt").read_text(encoding="utf-8")


def test_every_page_has_what_its_commands_print() -> None:
    assert {file.stem for file in Path(STORED).glob("*.txt")} == set(PAGES) and len(PAGES) > 4
