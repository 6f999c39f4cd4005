# SPDX-License-Identifier: MIT
"""`run`: folders, what is printed, partial and interrupted runs. Exit codes by process are in test_exit_codes.py."""

import json
from pathlib import Path
from typing import Any

import pytest

import pysprings.results.folder
from fe_engine.errors import MeshError
from pysprings.cli import results
from pysprings.core import storage
from pysprings.core.errors import RunIncomplete
from pysprings.macro.comparison import compare
from pysprings.scene.load import load_scene
from pysprings.springs.checks import open_springs
from tests.support import tiny
from tests.support.commands import Result, command
from tests.support.files import contents, read_record


@pytest.fixture
def scene_file() -> Path:
    return tiny.write(tiny.scene(), Path("caisson.toml"))


# --- a run ---


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """Folder and output of a run."""
    folder = tmp_path_factory.mktemp("ran")
    file = tiny.write(tiny.scene(), folder / "caisson.toml")
    return folder / "out", command("run", file, "--out", folder / "out", "--json")


def test_json_holds_record_files_and_comparison(ran: tuple[Path, Result]) -> None:
    folder, done = ran
    assert done.code == 0
    data = json.loads(done.out)
    assert data["run"] == read_record(folder)
    assert data["run"]["status"] == "complete"
    assert data["files"] == sorted(contents(folder))
    table = compare(open_springs(folder / "springs.nc"))
    rows = data["compare"]["rows"]
    assert [(row["path"], row["springs"]) for row in rows] == list(zip(table["path"], table["springs"], strict=True))
    assert [row["eta_large"] for row in rows] == pytest.approx(table["eta_large"].tolist(), rel=1e-9)


def test_progress_goes_to_stderr(ran: tuple[Path, Result]) -> None:
    lines = [line for line in ran[1].err.splitlines() if not line.startswith("note: compiling")]  # the first run may
    assert lines[0].startswith("model   0 %")  # the next line comes after ten seconds


def test_an_ended_run_is_printed_again(ran: tuple[Path, Result]) -> None:
    folder, _ = ran
    before = contents(folder)
    done = command("run", folder.parent / "caisson.toml", "--out", folder, "--resume", "--verbose")
    assert done.code == 0
    assert done.err == f"the run in {folder} has ended (complete): nothing is left to do\n"
    record = read_record(folder)
    lines = [line.split() for line in done.out.splitlines()]
    assert lines[0] == f"results in {folder} (complete)".split()
    assert [str(folder / "springs.nc")] in [line[:1] for line in lines]
    pull = record["paths"]["pull"]
    assert ["pull", "complete", str(pull["increments"]), str(pull["iterations"])] in [line[:4] for line in lines]
    assert ["total", f"{record['wall_s']:.2f}", f"{record['cpu_s']:.2f}"] in lines
    assert contents(folder) == before


# --- the text, on a record of our own (`test_results.py` has its parts line by line) ---

RECORD = {
    "mesh": {"nodes": 1848, "unknowns": 4631}, "solver": {"linear": "pardiso", "factorisations": 190},
    "paths": {"pull": {"status": "complete", "increments": 39, "iterations": 149, "iterations_in_cut_backs": 51}},
    "phases": {"mesh": {"wall_s": 0.399, "cpu_s": 0.275}}, "wall_s": 85.283, "peak_memory_bytes": 447963136,
}  # fmt: skip


def write_folder(folder: Path) -> Path:
    """A folder with this record, a picture, and no springs."""
    files = ["figures/pull_py.png", "figures/pull_py.svg"]
    storage.write_text(json.dumps(RECORD | {"status": "complete", "files": files}), folder / "run.json")
    for name in files:
        storage.write_text("", folder / name)
    return folder


def test_text(capsys: pytest.CaptureFixture[str]) -> None:
    """Files, paths, phases and cost in this order; without --verbose the cost in a line."""
    folder = write_folder(Path("out"))
    results.print_results(folder, verbose=True)
    lines = capsys.readouterr().out.splitlines()
    files = ["results in out (complete)", "  out/run.json         status, solver, cost"]
    assert lines[:4] == [*files, "  out/figures/pull_py  picture (png, svg)", ""]
    assert lines[4:6] == ["Convergence:", lines[5]] and lines[5].startswith("path  status    increments")
    assert any(line.startswith("phase  wall [s]") for line in lines[6:])
    cost = "85.28 s wall, 1,848 nodes, 4,631 unknowns; 200 Newton iterations, those in cut-backs included; "
    assert lines[-1] == f"{cost}190 factorisations (pardiso); peak memory 448 MB"
    results.print_results(folder)
    short = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert short == [files[0], "  out/run.json  status, solver, cost", "  out/figures   pictures: 1", "", lines[-1]]


# --- folders ---


def test_a_folder_with_results_needs_force(scene_file: Path) -> None:
    folder = Path("results")
    folder.mkdir()
    (folder / "run.json").write_text("precious")
    done = command("run", scene_file, "--out", folder)
    assert (done.code, done.out) == (2, "")
    assert done.err == (
        "fatal: user input: results: --out: holds results already (run.json); "
        "choose another folder, or --force to replace\n"
    )
    assert contents(folder) == {"run.json": b"precious"}
    assert command("run", scene_file, "--out", folder, "--force").code == 0
    assert read_record(folder)["status"] == "complete"


def test_a_folder_may_hold_other_files() -> None:
    tiny.write(tiny.scene(), Path("scene.toml"))
    assert command("run", "scene.toml", "--out", ".").code == 0
    assert load_scene("scene.toml") == tiny.scene()


def test_a_refused_scene_leaves_results_alone() -> None:
    Path("bad.toml").write_text("[soil]\nK0 = -1\n")
    Path("results").mkdir()
    Path("results/run.json").write_text("precious")
    assert command("run", "bad.toml", "--out", "results", "--force").code == 2
    assert contents(Path("results")) == {"run.json": b"precious"}
    assert command("run", "bad.toml").code == 2
    assert not Path("out").exists()


def test_a_file_or_a_place_that_cannot_be_written_is_refused(scene_file: Path) -> None:
    done = command("run", scene_file, "--out", scene_file)
    assert (done.code, done.err) == (2, "fatal: user input: caisson.toml: --out: is a file, not a folder\n")
    done = command("run", scene_file, "--out", scene_file / "x")
    words = "caisson.toml/x: --out: cannot be created (Not a directory)"
    assert (done.code, done.err) == (2, f"fatal: user input: {words}\n")


# --- runs that end early ---


def test_a_partial_run_has_no_comparison_of_an_earlier_one() -> None:
    assert command("run", tiny.write(tiny.scene(), Path("good.toml")), "--out", "out").code == 0
    stuck = tiny.write(tiny.stuck_scene(), Path("stuck.toml"))
    done = command("run", stuck, "--out", "out", "--force", "--json")
    assert done.code == 3
    data = json.loads(done.out)
    assert (data["run"]["status"], data["compare"]) == ("partial", None)
    assert "springs.nc" not in data["files"]
    (line,) = [line for line in done.err.splitlines() if line.startswith("fatal: ")]
    assert line == f"fatal: not converged: {'; '.join(data['run']['failures'])}"
    assert done.err.endswith("\nwhat converged is kept in out\n")


def ends(monkeypatch: pytest.MonkeyPatch, error: BaseException, record: dict[str, Any] | None) -> None:
    """Have runs end with an error, after they have written a record (None: they write none)."""

    def run_to_folder(scene: Any, out: Path, **_: Any) -> Path:
        if record is not None:
            storage.write_text(json.dumps(record), out / "run.json")
        raise error

    monkeypatch.setattr(pysprings.results.folder, "run_to_folder", run_to_folder)


def test_an_interrupted_run_is_printed(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    ends(monkeypatch, KeyboardInterrupt(), RECORD | {"status": "interrupted"})
    done = command("run", scene_file)
    assert done.code == 130
    assert done.out.startswith("results in out/caisson (interrupted)\n")
    assert done.err == "interrupted\n"


def test_an_old_record_is_not_taken_for_a_new_one(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    write_folder(Path("out"))
    ends(monkeypatch, RunIncomplete("pull: stopped at 3 mm"), None)
    done = command("run", scene_file, "--out", "out", "--force")
    assert (done.code, done.out) == (3, "")
    assert done.err == "fatal: not converged: pull: stopped at 3 mm\n"


def test_a_mesh_that_is_refused_leaves_no_new_folder(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    ends(monkeypatch, MeshError("inverted element 7"), None)
    Path("mine").mkdir()
    for folder in ("new/folder", "mine"):
        assert command("run", scene_file, "--out", folder).code == 2
    assert not Path("new").exists()
    assert Path("mine").exists()
