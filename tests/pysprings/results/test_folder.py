# SPDX-License-Identifier: MIT
"""From a scene file to the folder of a run: contract files, balances, what stays of an earlier run, early ends."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import pysprings.results.folder
from fe_engine.errors import LinearSolverError
from fe_engine.solve import step_size
from pysprings.core.errors import RunIncomplete, UserInputError
from pysprings.core.progress import Progress
from pysprings.core.text import with_prefix
from pysprings.full_model import work
from pysprings.macro.comparison import Comparison, compare
from pysprings.macro.predict import predict
from pysprings.model import build
from pysprings.results import plots
from pysprings.results.exporters.csv import read_comparison, write_frame
from pysprings.results.folder import run_to_folder
from pysprings.results.layout import run_files
from pysprings.scene.load import load_scene
from pysprings.scene.template import template_names, template_text
from pysprings.springs.checks import open_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from tests.support import tiny
from tests.support.commands import command, environment
from tests.support.files import contents, fail_comparison, read_record, read_report
from tests.support.place import SCENES

# the public contract, word by word
LOAD_DISPLACEMENT = (
    "path,step,time_s,u_m,w_m,rotation_rad,H_N,V_N,M_Nm,H_outer_N,H_inner_N,H_lid_N,H_tip_N,F_pw_N,F_in_N,F_out_N,"
    "converged"
)
PY = "path,family,depth_m,depth_top_m,depth_bottom_m,side,component,step,y_m,p_N_per_m"


# --- a run that goes well ---


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """Folder and printed words of `pysprings run` on a scene file."""
    place = tmp_path_factory.mktemp("run")
    file = tiny.write(tiny.scene(), place / "caisson.toml")
    return place / "out", command("run", file, "--out", place / "out", "--verbose")


@pytest.fixture(scope="module")
def folder(run: tuple[Path, Any]) -> Path:
    return run[0]


def test_every_file_of_the_contract_is_there(run: tuple[Path, Any]) -> None:
    folder, done = run
    assert done.code == 0, done.err
    assert set(contents(folder)) == set(run_files())


def test_tables_have_the_columns_of_the_contract(folder: Path) -> None:
    assert (folder / "load_displacement.csv").read_text().splitlines()[0] == LOAD_DISPLACEMENT
    assert (folder / "py.csv").read_text().splitlines()[0].startswith(PY)
    table = pd.read_csv(folder / "py.csv")
    assert set(table["family"]) == {"py", "mtheta", "base", "lid"}
    assert set(table["side"].dropna()) == {"outside", "inside", "net"}
    assert set(table["component"].dropna()) == {"normal", "shear", "water", "total"}
    book = openpyxl.load_workbook(folder / "springs.xlsx", read_only=True)
    assert {"About", "p-y"} <= set(book.sheetnames)


def test_the_tables_alone_balance_force_and_moment(folder: Path) -> None:
    """Sum of p dz + tip + lid = H, and the moments of -p, m, tip and lid = M, to 1e-6."""
    py, load = pd.read_csv(folder / "py.csv"), pd.read_csv(folder / "load_displacement.csv")
    length = 4.0
    assert len(load) > 2
    for _, total in load.iterrows():
        now = py[py["step"] == total["step"]]
        p = now[(now["family"] == "py") & (now["side"] == "net") & (now["component"] == "total")]
        m = now[(now["family"] == "mtheta") & (now["side"] == "net")]
        tip, lid = (now[now["family"] == family].iloc[0] for family in ("base", "lid"))
        dz, mdz = (part["depth_bottom_m"] - part["depth_top_m"] for part in (p, m))
        assert dz.sum() == pytest.approx(length)
        lateral = p["p_N_per_m"] @ dz + tip["H_N"] + lid["H_N"]
        vertical = m["t_N_per_m"] @ mdz + tip["V_N"] + lid["V_N"]
        moments = [-(p["p_N_per_m"] * p["depth_m"]) @ dz, m["m_Nm_per_m"] @ mdz]
        moments += [-length * tip["H_N"], tip["M_Nm"], lid["M_Nm"]]
        size = max(load["H_N"].abs().max(), 1.0)
        assert lateral == pytest.approx(total["H_N"], abs=1e-6 * size)
        assert vertical == pytest.approx(total["V_N"], rel=1e-6)
        assert sum(moments) == pytest.approx(total["M_Nm"], abs=1e-6 * length * size)


def test_both_netcdf_files_open_everywhere(folder: Path) -> None:
    with xr.open_datatree(folder / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        path = tree["paths/pull"]
        for name in ("p", "y", "gap", "normal_effective_stress", "shear_lateral", "pore_pressure"):
            assert path[name].attrs["units"]
        assert path["gap"].dims == ("step", "side", "azimuth", "depth")
        assert tree.attrs["scene_toml"].startswith("# the user's own words\n")
    with xr.open_dataset(folder / "springs.nc", group="paths/pull", engine="netcdf4") as data:
        assert "p" in data


def test_a_prediction_needs_the_spring_file_alone(folder: Path) -> None:
    springs = open_springs(folder / "springs.nc")
    load = pd.read_csv(folder / "load_displacement.csv").iloc[-1]
    end = predict(springs, H=float(load["H_N"]), arm=0.0)
    assert float(end["u"]) == pytest.approx(load["u_m"], rel=0.02)
    assert float(end["rotation"]) == pytest.approx(load["rotation_rad"], rel=0.02)


def test_the_macro_model_is_within_2_percent_on_its_own_path(folder: Path) -> None:
    frame = pd.read_csv(folder / "compare.csv").set_index("springs")
    assert frame.loc["full", ["H_error_max_pct", "rotation_error_max_pct"]].abs().max() < 2.0
    assert np.isfinite(frame.loc["py", "H_error_max_pct"])


def test_the_comparison_is_read_back_as_it_was_written(folder: Path) -> None:
    frame, springs = read_comparison(folder / "compare.csv"), open_springs(folder / "springs.nc")
    pd.testing.assert_frame_equal(frame, compare(springs), rtol=1e-9)
    names = frame.assign(path="1", springs_from="NA")  # texts that look like numbers, or like nothing
    write_frame(names, folder.parent / "names.csv")
    again = read_comparison(folder.parent / "names.csv")
    assert set(again["path"]) == {"1"} and set(again["springs_from"]) == {"NA"}


def test_run_json_has_status_provenance_cost_and_balance(folder: Path) -> None:
    record = read_record(folder)
    scene = tiny.scene()
    assert (record["status"], record["scene_sha256"]) == ("complete", scene.sha256)
    assert tiny.parsed(record["scene_toml"]) == scene
    assert max(record["balance"]["pull"].values()) < 1e-6
    assert {"output: files", "output: report", "assembly", "other"} <= set(record["phases"])
    for key in ("wall_s", "cpu_s"):
        assert sum(phase[key] for phase in record["phases"].values()) == pytest.approx(record[key], abs=0.02)


def test_the_end_of_the_run_prints_its_cost(run: tuple[Path, Any]) -> None:
    """In a line; by phase, with the contact of the paths, with --verbose."""
    folder, done = run
    record, short = read_record(folder), done.out.splitlines()
    assert any(f"{record['solver']['factorisations']} factorisations" in line for line in short)
    again = command("run", folder.parent / "caisson.toml", "--out", folder, "--resume", "--verbose")
    lines = again.out.splitlines()
    for words in ("mesh", "assembly", "factorisation", "solve", "output: files", "other", "total"):
        assert any(line.startswith(words) for line in lines)
    assert any(f"{record['solver']['factorisations']} factorisations" in line for line in lines)
    assert any("peak memory" in line for line in lines)
    assert "Contact from station to station:" in lines
    assert "eta small" in done.out


def test_the_report_shows_checks_and_what_was_left_out(folder: Path) -> None:
    page = read_report(folder)
    for words in ("Statuscomplete", "Equilibrium check", "Contact from station to station", "output: files"):
        assert words in page.text
    assert "all pictures" in page.text and "output.figures = false" in page.text
    assert page.pictures == ["Axes and signs of the caisson"]


# --- folders with something in them ---


@pytest.fixture
def blank_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of one kind instead of all, and empty: drawing takes most of the time."""

    def figures(*_: object) -> list[tuple[str, Figure]]:
        return [("pull_py", Figure(figsize=(1, 1)))]

    monkeypatch.setattr(plots.files, "figures", figures)


def test_a_run_follows_each_path_with_the_macro_model_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, blank_pictures: None
) -> None:
    """Table, workbook, pictures, report and terminal share one comparison."""
    followed: list[str] = []
    along = Comparison.along

    def counted(self: Comparison, path: SpringPath) -> dict[str, xr.Dataset]:
        followed.append(path.name)
        return along(self, path)

    monkeypatch.setattr(Comparison, "along", counted)
    file = tiny.write(tiny.scene(output={"figures": True}), tmp_path / "caisson.toml")
    done = command("run", file, "--out", tmp_path / "out")
    assert done.code == 0 and "eta small" in done.out
    assert followed == ["pull"]


def test_what_spring_sets_store_is_made_once_after_the_estimate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, blank_pictures: None
) -> None:
    """It takes up to minutes; the file has springs before. An interrupt of it leaves them, and --resume makes it."""
    seen: list[bool] = []
    named: list[str] = []

    def stored(tree: xr.DataTree, progress: Progress) -> xr.DataTree:
        progress("elements", 0.0, "")
        seen.append((tmp_path / "springs.nc").exists())
        if len(seen) == 1:
            raise KeyboardInterrupt
        return xr.DataTree.from_dict({"/": tree.to_dataset(inherit=False).assign_attrs(kept="yes")} | {
            each.path: each.to_dataset(inherit=False) for each in tree.subtree if each.path != "/"
        })  # fmt: skip

    monkeypatch.setattr(pysprings.results.folder, "with_stored", stored)
    with pytest.raises(KeyboardInterrupt):
        run_to_folder(tiny.scene(), tmp_path, progress=lambda *said: named.append(said[0]), estimate_error=True)
    assert "kept" not in open_springs(tmp_path / "springs.nc").attrs and seen == [True] and "elements" in named
    assert read_record(tmp_path)["not_made"]["elements of springs.nc"] == "interrupted"
    run_to_folder(tiny.scene(), tmp_path, progress=lambda *said: None, estimate_error=True, resume=True)
    assert open_springs(tmp_path / "springs.nc").attrs["kept"] == "yes" and seen == [True, True]


def test_force_leaves_nothing_of_an_earlier_run(tmp_path: Path, blank_pictures: None) -> None:
    out, old = tmp_path / "out", ["figures/old_gap_last.png", "figures/pull_newton.svg", "compare.csv", "report.html"]
    mine = ["notes.txt", "figures/photo.png"]
    (out / "figures").mkdir(parents=True)
    for name in [*old, *mine]:
        (out / name).write_text("old")
    (out / "run.json").write_text(json.dumps({"status": "complete", "files": old[:2]}))
    file = tiny.write(tiny.scene(output={"figures": True}), tmp_path / "caisson.toml")
    assert command("run", file, "--out", out).code == 2
    assert command("run", file, "--out", out, "--force").code == 0
    left = contents(out)
    assert set(left) == {*run_files(), *mine, "figures/pull_py.png"}
    assert all((left[name] == b"old") == (name in mine) for name in left)
    assert read_report(out).pictures == ["p-y curves by depth, path pull", "Axes and signs of the caisson"]


def test_a_run_without_springs_leaves_no_springs_of_the_run_before(tmp_path: Path) -> None:
    run_to_folder(tiny.scene(), tmp_path)
    with pytest.raises(RunIncomplete):
        run_to_folder(tiny.stuck_scene(), tmp_path)
    assert set(contents(tmp_path)) == {"full_model.nc", "load_displacement.csv", "report.html", "run.json"}
    assert "Macro-model against full model" not in read_report(tmp_path).text


@pytest.mark.parametrize("where", ["scene", "mesh", "solver"])
def test_what_is_refused_leaves_the_folder_untouched(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    text = tiny.scene().to_toml()
    if where == "scene":
        text = text.replace("[soil]", "[soil]\nnonsense = 1")
    if where == "mesh":

        def fail(*_: object) -> None:
            raise ValueError("no root")

        monkeypatch.setattr(build, "make_mesh", fail)
    if where == "solver":

        def missing(*_: object, **_options: object) -> None:
            raise LinearSolverError("no library")

        monkeypatch.setattr(work, "LinearSolver", missing)
    file = tmp_path / "caisson.toml"
    file.write_text(text, encoding="utf-8")
    before = contents(folder)
    done = command("run", file, "--out", folder, "--force")
    assert done.code == (4 if where == "solver" else 2)
    assert done.err.splitlines()[-1].startswith("fatal: ")
    assert done.out == ""
    assert contents(folder) == before


def test_less_output_makes_a_whole_folder_that_says_so(tmp_path: Path) -> None:
    run_to_folder(tiny.scene(output={"interface_fields": False, "section": False}), tmp_path)
    assert set(contents(tmp_path)) == set(run_files())
    words = read_report(tmp_path).text
    assert "output.interface_fields = false" in words and "output.section = false" in words
    assert "not measured: interface fields were not kept" in words


# --- runs that end early ---


def test_a_limit_load_is_a_result_in_every_file(tmp_path: Path) -> None:
    """Exit code 0; loads, motion and criterion in the summary, run.json, report, workbook and comparison."""
    file, out = tiny.write(tiny.overloaded_scene(), tmp_path / "storm.toml"), tmp_path / "out"
    done = command("run", file, "--out", out)
    assert (done.code, "fatal" in done.err) == (0, False)
    assert done.out.startswith(f"results in {out} (complete)\n")
    record = read_record(out)
    limit = record["paths"]["storm"]["limit_load"]
    (line,) = [line for line in done.out.splitlines() if line.startswith("limit load of path storm: ")]
    shown = f"H = {1e-3 * limit['H_N']:.5g} kN, M = 0 kN m"  # but for rounding
    assert shown in line
    assert f"u = {1e3 * limit['u_m']:.4g} mm" in line and limit["criterion"] in line
    words = read_report(out).text
    assert shown in words and limit["criterion"] in words
    assert "This run is not complete" not in words
    table = pd.read_csv(out / "compare.csv", comment="#")
    assert set(table["path_end"]) == {"limit load"}
    assert table["end_H_N"].iloc[0] == pytest.approx(limit["H_N"], rel=1e-6)
    compared = command("compare", out)
    met = f"met a limit load of the full model at H = {with_prefix(limit['H_N'], 'N')}"
    assert f"path storm {met}" in compared.out
    about = openpyxl.load_workbook(out / "springs.xlsx")["About"]
    texts = " ".join(str(cell.value) for row in about.iter_rows() for cell in row if cell.value)
    assert met in texts


def test_a_run_that_cannot_converge_ends_with_3(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_size, "SMALLEST", 0.02)  # no endless halving
    hasty = {"max_iterations": 2, "tolerance": 1e-8, "max_step_fraction": 0.3}
    path = {**tiny.PULL, "name": "storm"}
    file = tiny.write(tiny.scene(solver=hasty, paths=(path,)), tmp_path / "storm.toml")
    done = command("run", file, "--out", tmp_path / "out")
    assert done.code == 3
    assert done.out.startswith(f"results in {tmp_path / 'out'} (partial)\n")
    assert done.err.count("path 'storm' stopped on its way to") == 1
    assert done.err.endswith(f"\nwhat converged is kept in {tmp_path / 'out'}\n")
    assert set(contents(tmp_path / "out")) == set(run_files())
    record = read_record(tmp_path / "out")
    assert record["status"] == record["paths"]["storm"]["status"] == "partial"
    table = pd.read_csv(tmp_path / "out" / "load_displacement.csv")
    assert len(table) > 1 and (table["converged"] == 1).all()
    words = read_report(tmp_path / "out").text
    assert "This run is not complete (status: partial)" in words
    assert record["failures"][0] in words
    assert command("compare", tmp_path / "out").code == 0


def test_a_run_that_does_not_start_keeps_its_record(tmp_path: Path) -> None:
    file = tiny.write(tiny.stuck_scene(), tmp_path / "stuck.toml")
    done = command("run", file, "--out", tmp_path / "out")
    assert done.code == 3
    message = done.err.splitlines()[-2]
    for words in ("fatal: not converged: path 'pull' stopped on its way to", "no convergence in 2 iterations", "node "):
        assert words in message
    assert "Attempts given up (cut-backs):" in done.out
    record = read_record(tmp_path / "out")
    assert record["paths"]["pull"]["cut_backs_at"][0]["place"].startswith("node ")
    with xr.open_dataset(tmp_path / "out" / "full_model.nc", group="paths/pull/convergence") as data:
        assert data.sizes["iteration"] == 3 * record["paths"]["pull"]["cut_backs"]
    assert "Attempts given up (cut-backs)" in read_report(tmp_path / "out").text


def test_a_run_whose_springs_answer_on_no_path_keeps_its_results(tmp_path: Path) -> None:
    """One vertical path, held back: there are no vertical springs to compare."""
    path = {"name": "up", "kind": "vertical", "vertical_displacement": -1e-4, "role": "held-back"}
    file, out = tiny.write(tiny.scene(paths=(path,)), tmp_path / "caisson.toml"), tmp_path / "out"
    for done in (
        command("run", file, "--out", out),
        command("compare", out),
        command("run", file, "--out", out, "--force", "--json"),
    ):
        assert done.code == 0, done.err
    assert "nothing to compare" in command("compare", out).out
    assert set(contents(out)) == set(run_files())


def test_a_file_that_fails_costs_no_other_and_ends_the_run_with_its_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, out = tiny.write(tiny.scene(), tmp_path / "caisson.toml"), tmp_path / "out"
    with monkeypatch.context() as patch:
        fail_comparison(patch, KeyError("a bug"))
        done = command("run", file, "--out", out)
    assert done.code == 1 and "bug: KeyError: 'a bug'" in done.err and f"are kept in {out}" in done.err
    assert set(run_files()) - {"compare.csv"} <= set(contents(out))
    assert read_record(out)["not_made"] == {"compare.csv": "KeyError: 'a bug'"}
    assert command("predict", out, "--H", "10 kN").code == 0
    assert command("run", file, "--out", out, "--resume").code == 0
    assert set(contents(out)) == set(run_files()) and read_record(out)["not_made"] == {}


def test_an_interrupt_of_a_table_ends_all_that_follows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fail_comparison(monkeypatch, KeyboardInterrupt())
    assert command("run", tiny.write(tiny.scene(), tmp_path / "caisson.toml"), "--out", tmp_path / "out").code == 130
    missing = read_record(tmp_path / "out")["not_made"]
    assert {"compare.csv", "summary", "report"} <= set(missing) and set(missing.values()) == {"interrupted"}


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are different there")
def test_ctrl_c_keeps_the_converged_steps(tmp_path: Path) -> None:
    path = {**tiny.PULL, "lateral_displacement": 50e-3}
    slow = tiny.scene(solver={"first_step_fraction": 1e-3, "max_step_fraction": 1e-3}, paths=(path,))
    file = tiny.write(slow, tmp_path / "caisson.toml")
    # a shell that puts its jobs in the background has them ignore the signal; a terminal does not
    start = (
        "import runpy, signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "runpy.run_module('pysprings', run_name='__main__', alter_sys=True)"
    )
    args = [sys.executable, "-c", start, "run", str(file), "--out", str(tmp_path / "out")]
    env = environment()
    with subprocess.Popen(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env) as run:
        for _ in range(1200):  # paths begin once the folder of checkpoints stands
            if (tmp_path / "out" / "checkpoint").is_dir() or run.poll() is not None:
                break
            time.sleep(0.05)
        time.sleep(2.0)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=60)
    assert run.returncode == 130, err
    assert err.endswith("interrupted\n")
    assert "(interrupted)" in out.splitlines()[0]
    assert read_record(tmp_path / "out")["status"] == "interrupted"
    assert len(pd.read_csv(tmp_path / "out" / "load_displacement.csv")) >= 2


def test_an_interrupt_before_the_first_step_saves_nothing(tmp_path: Path) -> None:
    def progress(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_to_folder(tiny.scene(), tmp_path / "out", progress=progress)
    assert not (tmp_path / "out").exists()


# --- scenes that come with the project ---


@pytest.mark.parametrize("file", SCENES, ids=lambda file: file.stem)
def test_scenes_in_data_are_valid(file: Path) -> None:
    assert load_scene(file).paths or file.stem.startswith("capacity")  # whose probes `capacity` makes


@pytest.mark.parametrize("name", template_names())
def test_templates_are_valid(name: str) -> None:
    assert tiny.parsed(template_text(name)).load_paths


# what takes a minute each: an estimate of many runs, springs with memory beside those of `space-clay-gap`
NO_ESTIMATE, NO_MEMORY = {"dunkirk-pile", "fan"}, {"space-dense-sand", "space-sand", "space-soft-clay"}


@pytest.mark.slow
@pytest.mark.usefixtures("few_offered")
@pytest.mark.parametrize("name", [*(file.stem for file in SCENES), *template_names()])
def test_scenes_run_on_a_small_mesh_for_a_short_way(name: str, tmp_path: Path) -> None:
    """A twentieth of each path in two steps: every option of the scene is used. Few elements are offered to springs."""
    scene = _scene(name)
    small = {
        "mesh": {"refinement": 0.4},
        "output": {"figures": False},
        "paths": [_short(path) for path in scene.load_paths if path.role != "memory" or name not in NO_MEMORY],
    }
    small["solver"] = {"first_step_fraction": 0.5, "max_step_fraction": 0.5}
    run_to_folder(scene.replace(**small), tmp_path, estimate_error=False if name in NO_ESTIMATE else None)
    assert read_record(tmp_path)["status"] == "complete"
    assert set(contents(tmp_path)) == set(run_files())
    if scene.springs.memory and name not in NO_MEMORY:
        assert Springs.of(open_springs(tmp_path / "springs.nc")).memory is not None
        compared = command("compare", tmp_path, "--cycles", "--springs", "memory")
        assert compared.code == 0 and "_reversed " in compared.out, compared.err


def _scene(name: str) -> Any:
    files = {file.stem: file for file in SCENES}
    return load_scene(files[name]) if name in files else tiny.parsed(template_text(name))


def _short(path: Any) -> dict[str, Any]:
    imposed = {"lateral_displacement", "rotation", "lateral_force", "vertical_displacement"}
    values = path.model_dump(exclude_none=True) | {"report_at": ()}
    return {key: 0.05 * value if key in imposed else value for key, value in values.items()}


BRIEF = {"elastic-check", "service-load"}  # others take minutes and gigabytes, or are in full_model/test_clay.py


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in BRIEF else pytest.mark.long)
        for name in (*(file.stem for file in SCENES), *template_names())
    ],
)
def test_scenes_run_as_they_are(name: str, tmp_path: Path) -> None:
    run_to_folder(_scene(name), tmp_path, estimate_error=False)
    record = read_record(tmp_path)
    assert record["status"] == "complete"
    assert max(max(missing.values()) for missing in record["balance"].values()) < 1e-6
    frame = pd.read_csv(tmp_path / "compare.csv")
    own = frame[(frame["springs"] == "full") & (frame["role"] == "calibration")]
    errors = own[["H_error_max_pct", "rotation_error_max_pct", "M_error_max_pct"]].abs()
    assert errors.max(axis=None, skipna=True) < 2.0


def test_a_user_input_error_is_one_problem_a_line(tmp_path: Path) -> None:
    with pytest.raises(UserInputError) as error:
        load_scene(tmp_path / "nothing.toml")
    assert str(error.value) == f"fatal: user input: {tmp_path / 'nothing.toml'}: no such file"
