# SPDX-License-Identifier: MIT
"""The turbine on a bucket, without OpenFAST: changes of its input files, and the frequency of a free vibration."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.openfast_turbine import copied, edit, frequency, table, without_added_mass
from pysprings.core.errors import UserInputError

DECK = """------ head
   60   TMax        - run time (s)
"a b.dat"    EDFile   - file (quoted string)
0 Twice - one
1 Twice - the other
   1   NReact   - number of rows
 ID x SSI
 (-) (-) (-)
  7  1  ""
  1   NLast - none of TMax
"""


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    file = tmp_path / "deck.fst"
    file.write_text(DECK)
    return file


def test_values_of_keywords_alone_change(deck: Path) -> None:
    text = edit(deck, {"TMax": 10, "EDFile": '"c.dat"'})
    assert text == DECK.replace("   60   TMax", "10   TMax").replace('"a b.dat"', '"c.dat"')


def test_keywords_that_are_missing_or_stand_there_twice_are_refused_at_once(deck: Path) -> None:
    with pytest.raises(UserInputError) as caught:
        edit(deck, {"TMax": 10, "CompSoil": 1, "Twice": 2, "time": 3})
    assert [(each.key, each.message.split(",")[0]) for each in caught.value.problems] == [
        ("CompSoil", "stands there 0 times"),
        ("Twice", "stands there 2 times"),
        ("time", "stands there 0 times"),
    ]


def test_a_table_has_other_rows_and_their_number(deck: Path) -> None:
    text, rows = table(DECK, "NReact", ["7 0", "8 0"])
    assert rows == ['  7  1  ""\n']
    assert text == DECK.replace("   1   NReact", "   2   NReact").replace('  7  1  ""', "7 0\n8 0")
    with pytest.raises(UserInputError, match="NCmass"):
        table(DECK, "NCmass", [])


def test_a_folder_without_the_case_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserInputError, match="5MW_OC3Mnpl"):
        copied(tmp_path, tmp_path / "out")


def test_frequency_of_a_vibration_about_a_mean() -> None:
    time = np.arange(0.0, 60.0, 0.05)
    assert frequency(time, 0.3 + np.exp(-0.01 * time) * np.sin(2 * np.pi * 0.27 * time)) == pytest.approx(
        0.27, rel=1e-3
    )


def test_the_added_mass_goes_and_the_wave_force_of_a_fixed_pile_stays(tmp_path: Path) -> None:
    file = tmp_path / "hydro.dat"
    head = "SimplCd SimplCdMG SimplCa SimplCaMG SimplCp SimplCpMG SimplAxCa SimplAxCaMG"
    file.write_text(f"----\n {head}\n (-) (-)\n 0.9 0.8 1.0 0.7 1.0 1.1 0.5 0.4\n----\n")
    assert without_added_mass(file).splitlines()[3] == "0.9 0.8 0.0 0.0 2.0 1.8 0.0 0.0"
