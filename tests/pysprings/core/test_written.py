# SPDX-License-Identifier: MIT
"""Lists of written files: what they name is found again, and nothing that lies elsewhere."""

import json
from pathlib import Path

import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.written import LIST, listed, note, noted, own_folder


def test_what_was_noted_is_found_again_by_folder(tmp_path: Path) -> None:
    for name in ("figures/b.png", "paraview/a.vtu", "figures/a.png", "figures/b.png"):
        note(tmp_path, tmp_path / name)
    assert noted(tmp_path) == ["figures/a.png", "figures/b.png", "paraview/a.vtu"]
    assert listed(tmp_path, ("figures",)) == [tmp_path / "figures/a.png", tmp_path / "figures/b.png"]
    assert listed(tmp_path, ("paraview", "figures"))[-1] == tmp_path / "paraview/a.vtu"
    assert listed(tmp_path, ("other",)) == []


def test_both_lists_count(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(json.dumps({"files": ["figures/old.png"]}))
    note(tmp_path, tmp_path / "figures" / "new.png")
    assert [path.name for path in listed(tmp_path, ("figures",))] == ["new.png", "old.png"]


def test_an_entry_that_leads_elsewhere_is_left_out(tmp_path: Path) -> None:
    forged = [
        "figures/..", "figures/.", "figures/../x.png", "figures/a/b.png", "/figures/a.png", "../figures/a.png", "a.png",
        "figures", "figures/", "figures\\a.png", "Figures/a.png", 7, None, "figures/mine.png",
    ]  # fmt: skip
    (tmp_path / "run.json").write_text(json.dumps({"files": forged}))
    assert listed(tmp_path, ("figures", "..", "", "Figures")) == [tmp_path / "figures" / "mine.png"]


def test_lists_that_cannot_be_read_are_empty(tmp_path: Path) -> None:
    assert noted(tmp_path) == listed(tmp_path, ("figures",)) == []
    (tmp_path / LIST).write_bytes(b"\xff\xfe\n")
    (tmp_path / "run.json").write_text("[")
    assert noted(tmp_path) == listed(tmp_path, ("figures",)) == []


def test_a_folder_of_a_run_is_not_a_file_and_no_link(tmp_path: Path) -> None:
    assert own_folder(tmp_path, "new") == tmp_path / "new"
    (tmp_path / "there").mkdir()
    assert own_folder(tmp_path, "there") == tmp_path / "there"
    (tmp_path / "file").touch()
    with pytest.raises(UserInputError, match=r"file: is a file; a run has a folder of this name$"):
        own_folder(tmp_path, "file")
    (tmp_path / "link").symlink_to(tmp_path / "there")
    with pytest.raises(UserInputError, match=f"link: is a link to {tmp_path / 'there'}: nothing is written or removed"):
        own_folder(tmp_path, "link")
