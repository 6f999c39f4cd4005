# SPDX-License-Identifier: MIT
"""What a new run clears away, and what it must not touch."""

import json
from pathlib import Path

import pytest

from pysprings.results.layout import picture_kind, pictures_in, remove_results, results_in, run_files
from pysprings.results.plots.draw import PICTURES

OURS = ["mesh.png", "pull_py.svg", "a_b_gap_2.5mm.png", "a-1_stress_outside_last.png"]
UNLISTED = ["pull_py.png"]  # a name as ours have, and no run has written it
FOREIGN = ["scene.toml", "figures/../scene.toml", "/etc/x", "figures/sub/x", "other/x", 3, None]  # a list may hold
THEIRS = ["photo.png", "py.png", "mesh_2.png", "pull_py.pdf", "pull_gap_first.png", "notes.txt"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "figures").mkdir()
    for name in (*run_files(), "scene.toml", *(f"figures/{name}" for name in [*OURS, *UNLISTED, *THEIRS])):
        (tmp_path / name).write_text("old")
    record = {"files": [f"figures/{name}" for name in OURS] + FOREIGN}
    (tmp_path / "run.json").write_text(json.dumps(record))
    return tmp_path


def test_pictures_are_told_by_their_names(folder: Path) -> None:
    assert [path.name for path in pictures_in(folder)] == sorted([*OURS, *UNLISTED])


def test_results_go_and_everything_else_stays(folder: Path) -> None:
    assert results_in(folder) == list(run_files())
    remove_results(folder)
    left = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert left == {"scene.toml", *(f"figures/{name}" for name in [*UNLISTED, *THEIRS])}


def test_a_folder_without_results_is_left_alone(folder: Path) -> None:
    """Pictures of that name are not ours where no run has been."""
    for name in run_files():
        (folder / name).unlink()
    remove_results(folder)
    assert len(pictures_in(folder)) == len([*OURS, *UNLISTED])
    remove_results(folder / "nowhere")


@pytest.mark.parametrize("kind", [each.name for each in PICTURES if each.scope != "run"])
@pytest.mark.parametrize("path", ["pull", "a_b", "gap", "pull_py"])
def test_names_are_split_in_kind_and_state(path: str, kind: str) -> None:
    assert picture_kind(f"{path}_{kind}", path) == (kind, "")
    assert picture_kind(f"{path}_{kind}_last", path) == (kind, "last")
    assert picture_kind(f"{path}_{kind}_2.5mm", path) == (kind, "2.5mm")
    assert picture_kind(f"{path}_{kind}", "") is None
    assert picture_kind(f"{path}_{kind}", "other") is None


def test_a_path_does_not_take_the_pictures_of_one_whose_name_goes_on() -> None:
    assert picture_kind("pull_py_py", "pull") is None
    assert picture_kind("pull_gap_newton", "pull") is None
    assert picture_kind("mesh", "") == ("mesh", "")
