# SPDX-License-Identifier: MIT
"""A run touches its own files only, and an unfinished folder is not taken for a finished one."""

import json
import os
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

import pysprings
from pysprings.core.errors import UserInputError
from pysprings.core.written import CHECKPOINT, is_unfinished
from pysprings.full_model.accuracy import two_mesh
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.compute import compute
from pysprings.results import plots
from pysprings.results.exporters import export
from pysprings.results.folder import NOT_YET, run_or_go_on, run_to_folder
from pysprings.results.layout import FIGURES, PARAVIEW, run_files
from pysprings.studies import stored_runs
from pysprings.studies.accuracy import runs as accuracy_runs
from tests.support import tiny
from tests.support.commands import command
from tests.support.files import contents, fail_comparison, read_record
from validation.paper import sensitivity, study

needs_links = pytest.mark.skipif(os.name == "nt", reason="links need a right there")


class Killed(BaseException):
    """Stands for a process that ends at once: nothing in the tool catches it."""


def stop_after(calls: int, error: type[BaseException]) -> Any:
    """Progress that raises at its n-th call about a path."""
    left = [calls]

    def progress(path: str, _fraction: float, _message: str) -> None:
        left[0] -= path != "model"
        if left[0] == 0:
            raise error

    return progress


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A folder of somebody, with names that a run might take for its own."""
    place = tmp_path / "elsewhere"
    place.mkdir()
    for name in (
        "a.npz",
        "start.npz",
        "coarser-3-path-000.npz",
        "pull_py.png",
        "pull.pvd",
        "pull_0000.vtu",
        "x-0123456789abcdef.json",
    ):
        (place / name).write_text("somebody's")
    return place


@pytest.fixture
def one_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots.files, "figures", lambda *_: [("pull_py", Figure(figsize=(1, 1)))])


# --- links ---


@needs_links
@pytest.mark.parametrize("name", [CHECKPOINT, FIGURES, PARAVIEW])
@pytest.mark.parametrize("options", [(), ("--force",), ("--resume",)])
def test_a_link_in_place_of_a_folder_of_the_run_is_refused(
    tmp_path: Path, elsewhere: Path, scene_file: Path, name: str, options: tuple[str, ...]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / name).symlink_to(elsewhere)
    before = contents(tmp_path)
    done = command("run", scene_file, "--out", out, *options)
    assert done.code == 2
    assert done.err.startswith(
        f"fatal: user input: {out / name}: is a link to {elsewhere}: nothing is written or removed"
    )
    assert contents(tmp_path) == before


@needs_links
@pytest.mark.parametrize("name", [CHECKPOINT, FIGURES, PARAVIEW])
def test_python_calls_refuse_it_too(tmp_path: Path, elsewhere: Path, name: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / name).symlink_to(elsewhere)
    before = contents(elsewhere)
    with pytest.raises(UserInputError, match="is a link to"):
        run_to_folder(tiny.scene(), out)
    if name == CHECKPOINT:
        calls = (
            lambda: pysprings.run(tiny.scene(), checkpoint=out),
            Checkpoints(out).remove,
            Checkpoints(out).load,
            lambda: stored_runs.forget(out),
        )
        for call in calls:
            with pytest.raises(UserInputError, match="is a link to"):
                call()
    assert contents(elsewhere) == before


@needs_links
def test_studies_refuse_links_in_their_folders(tmp_path: Path, elsewhere: Path) -> None:
    before = contents(elsewhere)
    for name in ("runs", "figures", "sensitivity"):
        out = tmp_path / name
        out.mkdir()
        (out / name).symlink_to(elsewhere)
        with pytest.raises(UserInputError, match="is a link to"):
            study.study(out, "coarse", lambda *_: None, cases=[], variants=[], force=True)
    for call in (stored_runs.forget, lambda folder: run_or_go_on(tiny.scene(), folder)):
        with pytest.raises(UserInputError, match="is a link to"):
            call(tmp_path / "runs" / "runs")
    with pytest.raises(UserInputError, match="is a link to"):
        sensitivity.forget(tmp_path / "sensitivity")
    with pytest.raises(UserInputError, match="is a link to"):
        accuracy_runs.run_all(tiny.scene(), accuracy_settings(), tmp_path / "runs", lambda *_: None, no_run)
    assert contents(elsewhere) == before


def accuracy_settings() -> Any:
    from pysprings.full_model.accuracy.presets import settings

    return settings(["coarse"], True, ["superlu"], "superlu")


def no_run(*_: Any) -> None:
    raise AssertionError("nothing runs behind a link")


@needs_links
def test_a_link_of_the_name_of_the_lock_is_not_written_through(tmp_path: Path, elsewhere: Path) -> None:
    from pysprings.core.written import exclusive

    (tmp_path / ".pysprings.lock.json").symlink_to(elsewhere / "a.npz")
    with exclusive(tmp_path):
        pass
    assert (elsewhere / "a.npz").read_text() == "somebody's"


@needs_links
def test_a_result_folder_that_is_a_link_serves_and_one_to_nothing_is_named(tmp_path: Path, scene_file: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "real")
    assert command("run", scene_file, "--out", tmp_path / "out").code == 0
    assert set(contents(tmp_path / "real")) == set(run_files())
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    done = command("run", scene_file, "--out", tmp_path / "gone")
    assert done.code == 2
    words = f"--out: is a link to {tmp_path / 'nowhere'}, which is not there"
    assert done.err == f"fatal: user input: {tmp_path / 'gone'}: {words}\n"


# --- what a run removes ---


@pytest.mark.slow
def test_a_run_removes_what_it_wrote_and_nothing_else(tmp_path: Path, one_picture: None) -> None:
    """Pictures of the run before by the list in run.json; others of such names, and somebody's arrays, stay."""
    out, mine = tmp_path, [f"{CHECKPOINT}/a.npz", f"{FIGURES}/old_gap_last.png", f"{PARAVIEW}/old.pvd"]
    for name in mine:
        (out / name).parent.mkdir(exist_ok=True)
        (out / name).write_text("mine")
    run_to_folder(tiny.scene(output={"figures": True, "paraview": True}), out)
    first = set(contents(out))
    pictures = {f"{FIGURES}/pull_py.png"}
    record = json.loads((out / "run.json").read_text())
    assert first == {*run_files(), *mine, *record["files"]}
    assert pictures | {f"{PARAVIEW}/pull.pvd", f"{PARAVIEW}/pull_0000.vtu"} <= set(record["files"])
    assert not is_unfinished(out)
    run_to_folder(tiny.scene(), out)
    assert set(contents(out)) == {*run_files(), *mine}
    assert all((out / name).read_text() == "mine" for name in mine)


def test_a_study_that_forgets_a_run_has_its_pictures_removed_by_the_next(tmp_path: Path, one_picture: None) -> None:
    run_to_folder(tiny.scene(output={"figures": True}), tmp_path)
    stored_runs.forget(tmp_path)
    assert (tmp_path / FIGURES / "pull_py.png").exists()
    run_to_folder(tiny.scene(), tmp_path)
    assert set(contents(tmp_path)) == set(run_files())


def test_paraview_files_of_a_longer_run_go_by_their_list(tmp_path: Path) -> None:
    result = compute(tiny.scene(output={"paraview": True})).recorded()
    export(result, "paraview", tmp_path)
    listing = tmp_path / "pull.pvd"
    lines = listing.read_text()
    listing.write_text(
        lines.replace("</Collection>", '<DataSet file="pull_0777.vtu"/><DataSet file="../b_0001.vtu"/></Collection>')
    )
    for name in ("pull_0777.vtu", "pull_0888.vtu"):
        (tmp_path / name).write_text("x")
    export(result, "paraview", tmp_path)
    assert not (tmp_path / "pull_0777.vtu").exists()
    assert (tmp_path / "pull_0888.vtu").read_text() == "x"
    assert listing.read_text() == lines


def test_a_study_forgets_the_figures_of_its_variants_only(tmp_path: Path, elsewhere: Path) -> None:
    elsewhere.rename(tmp_path / sensitivity.FOLDER)
    (tmp_path / sensitivity.FOLDER / "notes.json").write_text("mine")
    sensitivity.forget(tmp_path)
    left = set(contents(tmp_path / sensitivity.FOLDER))
    assert "notes.json" in left
    assert "x-0123456789abcdef.json" not in left


# --- folders of unfinished runs ---


ASKED = [
    ("predict", "DIR", "--H", "100 kN"), ("compare", "DIR"), ("springs", "DIR"), ("export", "DIR", "--to", "json"),
]  # fmt: skip


def asked(words: tuple[str, ...], folder: Path) -> Any:
    return command(*(folder if word == "DIR" else word for word in words))


def test_a_killed_writer_is_not_believed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    """Killed while the tables are written: no command takes what is there for a whole result."""
    out = tmp_path / "out"
    with monkeypatch.context() as patch, pytest.raises(Killed):
        fail_comparison(patch, Killed())
        run_to_folder(tiny.scene(), out)
    assert read_record(out)["status"] == "writing" and (out / "springs.nc").exists()
    before = contents(out)
    for words in ASKED:
        done = asked(words, out)
        assert done.code == 2, words
        assert done.out == ""
        assert f"{out}: holds a run that has not ended (killed, or still running)" in done.err
        assert "--resume" in done.err
    named = command("predict", out / "springs.nc", "--H", "100 kN")
    assert named.code == 0
    assert f"warning: {out}: holds a run that has not ended" in named.err
    assert contents(out) == before
    assert command("run", tiny.write(tiny.scene(), scene_file), "--out", out, "--resume").code == 0
    assert set(contents(out)) == set(run_files())


def _killed_drawing(out: Path) -> Any:
    yield "pull_py", Figure(figsize=(1, 1))
    assert json.loads((out / "run.json").read_text())["not_made"] == {"pictures": NOT_YET, "report": NOT_YET}
    (out / FIGURES / ".pull_gap_last.123.tmp.png").write_text("half")
    raise Killed


@pytest.mark.parametrize("error", [Killed, KeyboardInterrupt, IndexError("a bug"), OSError(28, "No space left")])
@pytest.mark.parametrize("part", ["pictures", "report", "error estimate"])
def test_what_follows_the_results_costs_none_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene_file: Path, part: str, error: Any
) -> None:
    """Killed, interrupted, or failed: every command answers from the results, and --resume makes what is missing."""
    out, scene = tmp_path / "out", tiny.scene(output={"figures": True})
    module, name = {
        "pictures": (plots.files, "figures"), "report": (pysprings.results.folder, "write_report"),
        "error estimate": (two_mesh, "estimate"),
    }[part]  # fmt: skip

    def fails(*_: object, **__: object) -> Any:
        raise error

    one = lambda *_: [("pull_newton", Figure(figsize=(1, 1)))]  # noqa: E731
    monkeypatch.setattr(plots.files, "figures", one)
    with monkeypatch.context() as patch:
        patch.setattr(
            module, name, (lambda *_: _killed_drawing(out)) if (part, error) == ("pictures", Killed) else fails
        )
        args = ("run", tiny.write(scene, scene_file), "--out", out, "--estimate-error")
        if error is Killed:
            with pytest.raises(Killed):
                run_to_folder(scene, out, estimate_error=True)
        else:
            assert (done := command(*args)).code == (130 if error is KeyboardInterrupt else 0), done.err
            assert f"not made: {part} (" in done.out and "\n  not made " in done.out
    record = json.loads((out / "run.json").read_text())
    assert record["status"] == "complete" and part in record["not_made"]
    for words in ASKED[:3]:
        answer = asked(words, out)
        assert answer.code == 0 and f"warning: {out}: not made: " in answer.err
    done = command(*args, "--resume")
    assert done.code == 0, done.err
    assert set(contents(out)) == {*run_files(), "figures/pull_newton.png"}  # not pull_py
    record = json.loads((out / "run.json").read_text())
    assert record["not_made"] == {} and "not made" not in record["summary"]
    assert record["error_estimate"]["by_path"]["pull"]["load_pct"] > 0.0
    answer = asked(ASKED[0], out)
    assert (answer.code, "not made" in answer.err) == (0, False)


def test_results_of_a_run_before_a_killed_one_are_not_answered_from(tmp_path: Path) -> None:
    run_to_folder(tiny.scene(), tmp_path)
    with pytest.raises(Killed):
        run_to_folder(tiny.scene(soil={"K0": 0.9}), tmp_path, progress=stop_after(3, Killed))
    assert json.loads((tmp_path / "run.json").read_text())["status"] == "complete"
    for words in ASKED:
        assert "holds a run that has not ended" in asked(words, tmp_path).err


def test_an_interrupted_run_is_answered_with_its_mark(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_to_folder(tiny.scene(), tmp_path, progress=stop_after(4, KeyboardInterrupt))
    for words in ASKED[:3]:
        done = asked(words, tmp_path)
        assert done.code == 0, done.err
        assert f"warning: {tmp_path}: the run was interrupted: what is here is what had converged" in done.err
    strict = command("predict", tmp_path, "--H", "10 kN", "--strict")
    assert strict.code == 2
    assert "--strict: the run was interrupted" in strict.err
    with pytest.raises(Killed):  # checkpoints of another scene beside what was interrupted
        run_to_folder(tiny.scene(soil={"K0": 0.9}), tmp_path, progress=stop_after(3, Killed))
    assert asked(ASKED[0], tmp_path).code == 2
    assert is_unfinished(tmp_path)


def test_a_writer_whose_checkpoints_are_gone_has_nothing_to_resume(tmp_path: Path, scene_file: Path) -> None:
    out = run_to_folder(tiny.scene(), tmp_path / "out")
    record = json.loads((out / "run.json").read_text())
    (out / "run.json").write_text(json.dumps(record | {"status": "writing"}))
    assert asked(ASKED[0], out).code == 2
    done = command("run", scene_file, "--out", out, "--resume")
    assert done.code == 2
    assert "its checkpoints are gone; --force begins anew" in done.err
