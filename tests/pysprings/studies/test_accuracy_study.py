# SPDX-License-Identifier: MIT
"""`pysprings accuracy`: runs that are kept, table and files, on invented soil with a known order; a real one."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pysprings
from pysprings import Scene
from pysprings.core.errors import ResourceError, RunIncomplete, UserInputError
from pysprings.core.storage import read_tree, write_text, write_tree
from pysprings.full_model.accuracy.measures import cell_size
from pysprings.full_model.accuracy.presets import settings
from pysprings.full_model.compute import run
from pysprings.model.forecast.resources import size_of
from pysprings.springs.checks import RESULT
from pysprings.springs.path import paths_of
from pysprings.studies.accuracy import rows, runs, study
from pysprings.studies.accuracy.rows import error_against_time
from pysprings.studies.stored_runs import RUNS, Whole, forget, run_folder
from tests.support import tiny
from tests.support.commands import command
from tests.support.files import read_record
from tests.support.synthetic import Path as Pull, make_result, make_springs

MESHES = ["coarse:0.75", "coarse", "coarse:1.35"]
ORDER, SLOPE = 2.0, 60.0


def elastic(**sections: Any) -> Scene:
    return tiny.scene(soil={"yield_surface": "elastic"}, mesh={"refinement": 0.6}, **sections)


def invented(scene: Scene, folder: Path, progress: Any) -> None:
    """Leave what a run leaves, from soil whose reactions are wrong by SLOPE h^ORDER; costs grow with the unknowns."""
    unknowns = size_of(scene).unknowns
    harmonics = scene.mesh.harmonics
    slope = SLOPE if harmonics is None else 2.0
    factor = 1.0 + slope * cell_size(unknowns, harmonics) ** ORDER
    path = Pull(arm=4.0, size=1e-3, steps=12 if scene.solver.max_step_fraction == 0.3 else 9)
    result, springs = make_result((path,)), make_springs((path,))
    result["stiffness_initial"] = springs["stiffness_initial"]
    result.attrs |= {"skirt_length_m": springs.attrs["skirt_length_m"], "n_unknowns": unknowns}
    for tree in (result, springs):
        tree["stiffness_initial"] = tree["stiffness_initial"] * factor
        group = tree["paths/pull"]
        for name in {*group.data_vars} & REACTIONS:
            group[name] = (group[name] * factor).assign_attrs(group[name].attrs)
    write_tree(result, folder / "full_model.nc")
    write_tree(springs, folder / "springs.nc")
    record = {
        "schema": RESULT, "status": "complete", "version": pysprings.__version__, "scene_sha256": scene.sha256,
        "mesh": {"unknowns": unknowns, "harmonics": harmonics},
        "solver": {"linear": "none", "factorisations": 20, "unit_s": 0.01},
        "paths": {"pull": {"increments": 9, "iterations": 18, "iterations_in_cut_backs": 0}},
        "wall_s": 1e-3 * unknowns, "cpu_s": 2e-3 * unknowns, "peak_memory_bytes": 4e8,
    }  # fmt: skip
    write_text(json.dumps(record), folder / "run.json")
    progress("pull", 1.0, "done")


REACTIONS = {"H", "M", "p", "p_component", "m", "t", "H_tip", "M_tip", "H_lid", "M_lid", "normal_effective_stress"}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Any:
    out = tmp_path_factory.mktemp("study") / "out"
    wanted = settings(MESHES, quick=True)
    noted: list[tuple[str, float, str]] = []
    found = study.study(elastic(), out, wanted, lambda *each: noted.append(each), run=invented)
    return SimpleNamespace(out=out, found=found, noted=noted, settings=wanted)


def kept(done: Any, out: Path, but: tuple[str, ...] = ()) -> None:
    """Have the runs of the study, but for some, stand in another folder, too."""
    (out / RUNS).mkdir()
    for each in done.settings:
        if each.name not in but:
            (out / RUNS / each.name).symlink_to(done.out / RUNS / each.name)


def full(found: rows.StudyResult) -> pd.DataFrame:
    return found.table[found.table["model"] == rows.FULL].set_index("name")


@pytest.mark.slow
def test_every_setting_has_cost_and_error(done: Any) -> None:
    table = full(done.found)
    assert list(table.index) == [each.name for each in done.settings]
    assert (table["status"] == "complete").all()
    np.testing.assert_allclose(table["units"], 0.1 * table["unknowns"].astype(float))  # wall / unit
    assert (table["memory_MB"] == 400.0).all()
    true = 100.0 * SLOPE * np.array([cell_size(n) ** ORDER for n in table["unknowns"]])
    for column in ("load_max_pct", "load_area_pct", "py_max_pct", "stiffness_pct", "pressure_max_pct"):
        np.testing.assert_allclose(table[column], true, rtol=2e-2, err_msg=column)
    assert table.loc["coarse-1.35", "unknowns"] > table.loc["coarse", "unknowns"] > table.loc["coarse-0.75", "unknowns"]
    assert table.loc["coarse-1.35", "load_max_pct"] < table.loc["coarse-0.75", "load_max_pct"]


@pytest.mark.slow
def test_what_a_setting_changes_by_itself(done: Any, tmp_path: Path) -> None:
    """The invented soil knows nothing of tolerances, and little of steps; with 3 % more load it is 3 %."""
    table = full(done.found)
    assert table.loc["coarse-tolerance-1e-3", "from_mesh_pct"] == 0.0
    assert 0.0 < table.loc["coarse-steps-0.3", "from_mesh_pct"] < 0.1
    assert np.isnan(table.loc["coarse", "from_mesh_pct"])

    def looser(scene: Scene, folder: Path, progress: Any) -> None:
        invented(scene, folder, progress)
        tree = read_tree(folder / "full_model.nc")
        tree["paths/pull"]["H"] *= 1.03
        write_tree(tree, folder / "full_model.nc")

    kept(done, tmp_path, but=("coarse-tolerance-1e-3",))
    found = rows.assess(runs.run_all(elastic(), done.settings, tmp_path, lambda *_: None, looser))
    assert full(found).loc["coarse-tolerance-1e-3", "from_mesh_pct"] == pytest.approx(3.0)


@pytest.mark.slow
def test_one_mesh_says_nothing_of_its_error(done: Any, tmp_path: Path) -> None:
    """It would be its own reference, and exact: no error, no target; what a setting changes is noted."""
    kept(done, tmp_path)
    found = rows.assess(runs.run_all(elastic(), settings(["coarse"], quick=True), tmp_path, lambda *_: None, invented))
    assert found.table[["load_max_pct", "py_rms_pct"]].isna().all(axis=None)
    assert full(found)["from_mesh_pct"].notna().sum() == 2
    assert not found.table["pareto"].any()
    assert "pull, load: one mesh: nothing to compare it with" in list(study.reference_lines(found))
    assert all(line.endswith("no setting") for line in study.target_lines(found.table))


@pytest.mark.slow
def test_reference_is_told_by_quantity(done: Any) -> None:
    assert list(done.found.series) == ["coarse-0.75", "coarse", "coarse-1.35"]
    lines = list(study.reference_lines(done.found))
    assert [line.split(":")[0] for line in lines] == [
        f"pull, {name}" for name in ("load", "rotation", "pressure", "py", "stiffness")
    ]
    references = done.found.references["pull"]
    assert references["load"].order == pytest.approx(ORDER)
    assert references["py"].order == pytest.approx(ORDER)
    assert references["rotation"].order is None  # the same on all meshes
    finest = full(done.found).loc["coarse-1.35"]
    assert finest["reference"] == "rotation"
    assert finest["load_max_pct"] == pytest.approx(done.found.uncertainty["pull"]["load_max"])


@pytest.mark.slow
def test_series_are_the_reference_and_bricks_beside_them(tmp_path: Path) -> None:
    """Invented soil: both discretisations tend to the same limit; each has an order of its own."""
    meshes = [*MESHES, "fourier-coarse:0.5@2", "fourier-coarse@2", "fourier-coarse:2@2"]
    reports: list[tuple[str, float, str]] = []
    chosen = settings(meshes, quick=True)
    ended = runs.run_all(elastic(), chosen, tmp_path, lambda *each: reports.append(each), invented)
    assert {name for name, *_ in reports if name.startswith("warm-up")} == {"warm-up-hex8", "warm-up-fourier"}
    found = rows.assess(ended)
    assert found.kind == "fourier"
    assert list(found.series) == ["fourier-coarse-0.5-N2", "fourier-coarse-N2", "fourier-coarse-2-N2"]
    for kind in ("hex8", "fourier"):
        assert found.limits[kind]["pull"]["load"].order == pytest.approx(ORDER, rel=1e-3)
    assert found.apart["pull"]["load_max"] < 0.01
    assert full(found).loc["coarse-0.75", "load_max_pct"] > 1.0
    assert "pull: the limit of bricks is apart by" in "\n".join(study.reference_lines(found))
    assert study.cell_size_of(found) == "(unknowns/(N + 1))^(-1/2)"


@pytest.mark.slow
def test_macro_models_by_mesh_and_slices(done: Any) -> None:
    table = done.found.table[done.found.table["model"] == rows.MACRO]
    assert {"coarse-0.75", "coarse", "coarse-1.35"} == {name.split(",")[0] for name in table["name"]}
    own = table[table["name"].str.startswith("coarse, full")].sort_values("slices")
    # with all slices, springs answer as the model does that they come from
    assert own.iloc[-1]["load_max_pct"] == pytest.approx(full(done.found).loc["coarse", "load_max_pct"], rel=1e-2)
    assert own.iloc[-1]["units"] == pytest.approx(own.iloc[-1]["wall_s"] / own.iloc[-1]["unit_s"])
    assert own.iloc[0]["rotation_max_pct"] > own.iloc[-1]["rotation_max_pct"]


@pytest.mark.slow
def test_files(done: Any) -> None:
    for name in study.FILES.keys() - {"accuracy.svg"}:  # where --figure-format asks for it
        assert (done.out / name).exists(), name
    table = pd.read_csv(done.out / "accuracy.csv")
    np.testing.assert_allclose(table["load_max_pct"], done.found.table["load_max_pct"].astype(float))
    document = (done.out / "accuracy.md").read_text(encoding="utf-8")
    assert "## Cheapest settings" in document and "| coarse-1.35 |" in document
    whole = json.loads((done.out / "accuracy.json").read_text(encoding="utf-8"))
    assert whole["scene_sha256"] == elastic().sha256
    quantities = {"load", "rotation", "pressure", "py", "stiffness"}
    assert set(whole["reference"]["pull"]) == quantities | {"uncertainty_pct", "limit_of_bricks_pct"}
    assert len(whole["rows"]) == len(table)


@pytest.mark.slow
def test_progress_of_all_runs_grows_to_the_end(done: Any) -> None:
    shares = [share for name, share, _ in done.noted if name == "all runs"]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert done.noted[:2] == [("warm-up-hex8", 0.0, "compiled code"), ("warm-up-hex8", 1.0, "")]
    names = [each.name for each in done.settings]
    assert [each for each in done.noted[2:] if each[0] != "all runs"] == [(name, 1.0, "done") for name in names]
    unknowns = [size_of(each.scene(runs.study_scene(elastic()))).unknowns for each in done.settings]
    assert len(shares) == 2 * len(names) and len(set(unknowns)) == 3


def test_progress_of_a_run_with_two_paths() -> None:
    noted: list[tuple[str, float, str]] = []
    whole = Whole({"a": 1.0, "b": 3.0}, lambda *each: noted.append(each), paths=("pull", "push"))
    progress = whole.of("a")
    for path, share in (("mesh", 0.9), ("pull", 0.5), ("push", 0.5)):
        progress(path, share, "")
    assert [share for name, share, _ in noted if name == "a"] == pytest.approx([0.0, 0.25, 0.75])
    assert [share for name, share, _ in noted if name == "all runs"] == pytest.approx([0.0625, 0.1875])


@pytest.mark.slow
def test_nothing_runs_twice_and_what_is_forgotten_runs_again(done: Any) -> None:
    ran: list[str] = []

    def watch(scene: Scene, folder: Path, progress: Any) -> None:
        ran.append(folder.name)
        invented(scene, folder, progress)

    study.study(elastic(), done.out, done.settings, lambda *_: None, run=watch)
    assert ran == []
    forget(run_folder(done.out, done.settings[0].name))
    study.study(elastic(), done.out, done.settings, lambda *_: None, run=watch)
    assert ran == ["coarse-0.75"]  # the warm-up is kept, too


@pytest.mark.slow
def test_a_run_that_does_not_fit_is_a_row(done: Any, tmp_path: Path) -> None:
    def fails(scene: Scene, folder: Path, progress: Any) -> None:
        if folder.name == "coarse-1.35":
            raise ResourceError("the model needs 9 TB")
        if folder.name == "coarse-tolerance-1e-3":
            invented(scene, folder, progress)
            noted = {"status": "partial", "failures": ["path 'pull' stopped"]}
            write_text(json.dumps(read_record(folder) | noted), folder / "run.json")
            raise RunIncomplete("path 'pull' stopped")

    kept(done, tmp_path, but=("coarse-1.35", "coarse-tolerance-1e-3"))
    other = {"status": "partial", "version": "0", "scene_sha256": elastic().sha256, "mesh": {"unknowns": 7}}
    write_text(json.dumps(other), tmp_path / RUNS / "coarse-1.35" / "run.json")  # of a run that is not this one
    ended = runs.run_all(elastic(), done.settings, tmp_path, lambda *_: None, fails)
    again = runs.run_all(elastic(), done.settings, tmp_path, lambda *_: None, fails)
    assert [each.why for each in again] == [each.why for each in ended]
    found = rows.assess(ended)
    table = full(found)
    assert list(found.series) == ["coarse-0.75", "coarse"]
    assert table.loc["coarse-1.35", "why"] == "resources: the model needs 9 TB"
    assert np.isnan(table.loc["coarse-1.35", "unknowns"])
    assert table.loc["coarse-tolerance-1e-3", "why"] == "not converged: path 'pull' stopped"
    assert np.isnan(table.loc["coarse-1.35", "load_max_pct"])
    assert table.loc["coarse", "load_max_pct"] > 0.0  # of two meshes: the difference
    assert "## Stopped" in study.to_markdown(found, {}, "x.png")
    assert "9 TB" in study.to_markdown(found, {}, "x.png")


def test_estimate_in_python_covers_the_difference_to_a_finer_mesh() -> None:
    own = run(elastic(), estimate_error=True)
    fine = run(elastic().replace(mesh={"refinement": 0.9}))
    record = json.loads(own.attrs["run_json"])["error_estimate"]
    load = [float(paths_of(tree)["pull"].dataset["H"][-1]) for tree in (own, fine)]
    assert record["estimate_pct"]["load_max"] > 100.0 * abs(load[0] / load[1] - 1.0) > 0.0
    assert "unit_s" not in json.loads(own.attrs["run_json"])["solver"]


@pytest.mark.slow
def test_the_command(done: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "run_in_child", invented)
    file = tiny.write(elastic(), tmp_path / "scene.toml")
    given = ["accuracy", str(file), "--quick", "--out", str(done.out)]
    given += [part for mesh in MESHES for part in ("--mesh", mesh)]
    shown = command(*given)
    assert shown.code == 0, shown.err
    assert "reference: meshes coarse-0.75, coarse, coarse-1.35; h = unknowns^(-1/3)" in shown.out
    assert f"{done.out / 'accuracy.md'}: tables" in shown.out
    answer = command(*given, "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["series"] == ["coarse-0.75", "coarse", "coarse-1.35"]
    assert command("accuracy", str(file), "--mesh", "huge").code == 2


@pytest.mark.slow
def test_a_process_of_its_own_hands_on_progress_and_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")  # of the process: the other worker has the other core
    noted: list[str] = []
    with pytest.raises(RunIncomplete, match="path 'pull' stopped"):
        runs.run_in_child(tiny.stuck_scene(), tmp_path / "out", lambda path, *_: noted.append(path))
    assert "model" in noted
    assert read_record(tmp_path / "out")["solver"]["unit_s"] > 0.0
    (tmp_path / "link").symlink_to(tmp_path / "out")
    with pytest.raises(UserInputError, match="link"):
        runs.run_in_child(tiny.stuck_scene(), tmp_path / "link", lambda *_: None)


@pytest.mark.slow
def test_picture_shows_every_group_and_the_reference_hollow(done: Any) -> None:
    figure = error_against_time(done.found.table, "tiny $x$")
    load, py, macro = figure.axes
    assert load.get_xscale() == load.get_yscale() == py.get_xscale() == macro.get_yscale() == "log"
    labels = {label.get_text() for label in figure.legends[0].get_texts()}
    assert {"bricks", "steps", "tolerance", "macro-model", "Pareto front, bricks"} <= labels
    assert "Fourier series" not in labels
    drawn = sum(len(each.get_offsets()) for each in load.collections)
    assert drawn == len(done.settings)
    assert hollow(load) == hollow(py) == 0  # both are extrapolated; the rotation is not
    table = done.found.table.assign(reference=done.found.table["reference"].replace("rotation", "load, rotation"))
    load, py, _ = error_against_time(table, "its own reference").axes
    assert (hollow(load), hollow(py)) == (1, 0)
    empty = error_against_time(done.found.table.iloc[:0], "nothing")
    assert len(empty.axes) == 3


def hollow(axes: Any) -> int:
    """Marks with a white middle."""
    return sum(int((face == 1.0).all()) for each in axes.collections for face in each.get_facecolors())


@pytest.mark.slow
def test_a_real_study_of_elastic_soil(tmp_path: Path) -> None:
    """Every run in a process of its own; the load of elastic soil falls with the mesh, whatever the steps."""
    file, out = tiny.write(elastic(), tmp_path / "scene.toml"), tmp_path / "out"
    given = ["accuracy", str(file), "--quick", "--out", str(out)]
    given += [part for mesh in MESHES for part in ("--mesh", mesh)]
    answer = command(*given)
    assert answer.code == 0, answer.err
    table = pd.read_csv(out / "accuracy.csv").query("model == 'full'").set_index("name")
    assert (table[["wall_s", "cpu_s", "unit_s", "units", "memory_MB"]] > 0.0).all(axis=None)
    assert table.loc["coarse-1.35", "load_max_pct"] < table.loc["coarse-0.75", "load_max_pct"]
    assert table.loc["coarse-steps-0.3", "from_mesh_pct"] < 0.1 * table.loc["coarse", "load_max_pct"]
    assert table.loc["coarse-tolerance-1e-3", "from_mesh_pct"] < 0.01 * table.loc["coarse", "load_max_pct"]


@pytest.mark.slow
def test_a_study_whose_runs_all_stop_says_so(tmp_path: Path) -> None:
    """A limit load on every mesh: there are costs and reasons, no errors, and the documents are written."""

    def stops(_scene: Scene, _folder: Path, _progress: Any) -> None:
        raise RunIncomplete("path 'pull' stopped: limit load")

    found = study.study(elastic(), tmp_path / "out", settings(MESHES, quick=True), lambda *_: None, run=stops)
    assert set(full(found)["status"]) == {"stopped"}
    assert all(line.endswith("no setting") for line in study.target_lines(found.table))
    assert "limit load" in (tmp_path / "out" / "accuracy.md").read_text(encoding="utf-8")
    assert (tmp_path / "out" / "accuracy.png").exists()
