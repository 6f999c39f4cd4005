# SPDX-License-Identifier: MIT
"""A study from its first case to its dataset: what has run stays, and edits of cases.csv count."""

import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import psutil
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.core.words import ESTIMATES
from pysprings.full_model.accuracy import own_estimate
from pysprings.full_model.compute import compute, run
from pysprings.scene.load import load_scene
from pysprings.springs.checks import open_springs, save_springs
from pysprings.springs.path import SpringPath, paths_of
from pysprings.springs.springs import Springs
from pysprings.studies.sweep import dataset, study, worker
from pysprings.studies.sweep.dataset import DEPTHS, SHARES, draw, measure, remap, table_of, write_table
from pysprings.studies.sweep.plan import AGAIN, DONE, SKIP, State, write_cases
from pysprings.studies.sweep.study_file import read_study
from tests.support import tiny
from tests.support.commands import command
from tests.support.place import ROOT
from tests.support.vertical import vertical_springs

TEXT = """
title = "two by two"
scene = "base.toml"
[[axis]]
key = "soil.young_modulus"
values = ["100 MPa", "200 MPa"]
[[axis]]
key = "interface.friction_coefficient"
name = "mu"
values = [0.3, 0.5]
"""


def make(folder, text=TEXT):
    tiny.write(tiny.scene(), folder / "base.toml")
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return read_study(folder / "study.toml")


def rows(out):
    with (out / "cases.csv").open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def run_here(planned):
    """Run the open cases of a study in this process, as its workers do."""
    (planned.out / worker.SIGN).write_text("sign", encoding="utf-8")
    for case in planned.plan.cases:
        if planned.states[case.number].status == "waiting":
            scene = planned.plan.scene_of(case).to_toml()
            keep_all = planned.plan.keep == "all"
            task = worker.Task(case.number, scene, str(planned.out), planned.hashes[case.number], "sign", keep_all)
            study._take(planned, worker.run_case(task))
    planned.write(force=True)


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    planned = study.planned(make(folder), folder / "out")
    run_here(planned)
    dataset.write_study(planned)
    return planned


def test_every_case_is_a_row_and_a_folder_named_by_its_scene(ended):
    found = rows(ended.out)
    assert [row["status"] for row in found] == ["complete"] * 4
    assert [row["young_modulus [MPa]"] for row in found] == ["100", "100", "200", "200"]
    for case, row in zip(ended.plan.cases, found, strict=True):
        assert ended.plan.scene_of(case).sha256.startswith(row["hash"])
        assert sorted(file.name for file in (ended.out / "cases" / row["hash"]).iterdir()) == [
            "case.json", "run.json", "springs.nc",
        ]  # fmt: skip


def test_what_has_ended_is_not_run_again(ended):
    again = study.planned(ended.plan, ended.out)
    assert [state.status for state in again.states.values()] == [DONE] * 4
    before = {file: file.stat().st_mtime_ns for file in ended.out.glob("cases/*/run.json")}
    run_here(again)
    assert before == {file: file.stat().st_mtime_ns for file in ended.out.glob("cases/*/run.json")}
    assert again.ran == 0


def test_a_study_that_keeps_all_files_makes_those_that_are_missing(tmp_path):
    one = 'scene = "base.toml"\n[[axis]]\nkey = "soil.young_modulus"\nvalues = ["100 MPa"]\n'
    for keep, there in (("springs", False), ("all", True)):
        planned = study.planned(make(tmp_path, f'keep = "{keep}"\n{one}'), tmp_path / "out")
        run_here(planned)
        assert (planned.folder(1) / "full_model.nc").exists() == there and planned.ran == 1
    assert study.planned(planned.plan, planned.out).states[1].status == DONE


def test_the_dataset_has_a_dimension_an_axis_and_the_numbers_of_each_run(ended):
    with dataset.open_study(ended.out) as data:
        assert data["K_H"].dims == ("young_modulus", "mu") and data["young_modulus"].attrs["units"] == "MPa"
        assert data["stiffness_initial"].attrs["units"] == "1"  # its long name has those of its entries
        assert data["p"].dims == ("young_modulus", "mu", "path", "depth_share", "share")
        case = data.sel(young_modulus=200.0, mu=0.3)
        assert int(case["case_number"]) == 3
        springs = Springs.of(open_springs(ended.folder(3) / "springs.nc"))
        path = springs.paths["pull"]
        assert float(case["K_H"]) == springs.stiffness[0, 0]
        assert float(case["H"].sel(path="pull")[-1]) == pytest.approx(path["H"][-1], rel=1e-6)
        assert float(case["H_largest"].sel(path="pull")) == pytest.approx(path["H"].max(), rel=1e-6)
        assert float(case["reached"].sel(path="pull")) == 1.0
        assert np.isfinite(case["cpu_s"]) and float(case["balance_error"]) < 1e-9


def test_no_axis_can_have_a_name_of_the_dataset(ended):
    with dataset.open_study(ended.out) as data:
        assert {*data.variables, *data.dims} - {"young_modulus", "mu"} == {*dataset.NAMES} - {"case"}


def test_a_case_of_a_series_has_the_springs_of_a_run(tmp_path, monkeypatch):
    """Extrapolated from two meshes; a case whose estimate failed has the reason, and no share of its paths."""
    monkeypatch.setattr(own_estimate, "FINE_ENOUGH", 0.0)
    planned = study.planned(make(tmp_path), tmp_path / "out")
    mesh = {"discretisation": "fourier", "refinement": 0.5, "harmonics": 2}
    scene = tiny.sand(mesh=mesh, paths=({"name": "pull", "kind": "pull", "lateral_displacement": 4e-3},))
    (planned.out / worker.SIGN).write_text("sign", encoding="utf-8")
    answer = worker.run_case(worker.Task(1, scene.to_toml(), str(planned.out), scene.sha256[:16], "sign"))
    folder = planned.out / worker.FOLDER / scene.sha256[:16]
    H = Springs.of(open_springs(folder / "springs.nc")).paths["pull"]["H"][-1]
    assert (answer.ended.status, answer.ended.reason) == (DONE, "")
    assert H == paths_of(run(scene))["pull"]["H"][-1] != paths_of(compute(scene).tree)["pull"]["H"][-1]
    measured = measure(folder, scene, ("pull",))
    assert measured.numbers["extrapolated"] == 1.0 and 0.0 < measured.by_path["mesh_error_pct"][0] < 100.0
    assert worker.read_ended(folder) == answer.ended
    clay = load_scene(ROOT / "data" / "studies" / "clay-scene.toml")  # no mesh of it is coarser than this one
    coarsest = clay.replace(mesh={"refinement": 0.4, "harmonics": 2}, springs={"rays": (0.0,), "reach": 1e-3})
    alone = worker.run_case(worker.Task(2, coarsest.to_toml(), str(planned.out), coarsest.sha256[:16], "sign"))
    assert alone.ended.status == DONE and alone.ended.reason.startswith("no estimate of the discretisation error: ")
    worker.write_ended(folder, replace(answer.ended, version="0.1.0"))  # before studies were extrapolated
    assert worker.read_ended(folder) is None


def test_paths_of_some_cases_alone_are_in_the_dataset(tmp_path):
    axis = '[[axis]]\nkey = "springs.vertical"\nvalues = [false, true]\n'
    make(tmp_path)
    fan = {"reach": 0.5e-3, "rays": (0.0,), "held_back": False}
    tiny.write(tiny.scene(springs=fan, paths=()), tmp_path / "base.toml")
    (tmp_path / "study.toml").write_text(f'scene = "base.toml"\n{axis}', encoding="utf-8")
    planned = study.planned(read_study(tmp_path / "study.toml"), tmp_path / "out")
    run_here(planned)
    dataset.write_study(planned)
    with dataset.open_study(planned.out) as data:
        down = data["V_largest"].sel(path="down")
        assert list(data["path"].values) == ["ray_0", "down", "up"]
        own = Springs.of(open_springs(planned.folder(2) / "springs.nc")).paths["down"]
        assert np.isnan(down[0]) and float(down[1]) == pytest.approx(own["V"].max(), rel=1e-6)


def test_springs_of_the_common_grid_sum_to_the_load(ended):
    with dataset.open_study(ended.out) as data:
        case = data.sel(young_modulus=100.0, mu=0.5, path="pull")
        length = ended.plan.scene_of(ended.plan.cases[1]).caisson.skirt_length
        height, depth = length / DEPTHS, case["depth_share"] * length
        H = height * case["p"].sum("depth_share") + case["H_tip"] + case["H_lid"]
        M = (height * (case["m"] - case["p"] * depth).sum("depth_share") - length * case["H_tip"]
             + case["M_tip"] + case["M_lid"])  # fmt: skip
        assert np.abs(H - case["H"]).max() < 1e-5 * case["H"].max()
        assert np.abs(M - case["M"]).max() < 1e-5 * length * case["H"].max()
        assert case.sizes["share"] == len(SHARES)


def test_the_largest_load_of_a_path_that_ends_between_two_shares_is_that_of_its_last_state(ended, tmp_path):
    """The grid leaves out up to a quarter of the way to a limit load, which is the capacity."""
    tree = open_springs(ended.folder(1) / "springs.nc")
    path = tree["paths/pull"].to_dataset(inherit=False)
    path = path.isel(step=slice(int(np.argmax(path["u"].values >= 0.9 * float(path["u"][-1])))))
    tree["paths/pull"].dataset = path.assign_attrs(end="limit load")
    save_springs(tree, tmp_path / "springs.nc")
    found = measure(tmp_path, ended.plan.scene_of(ended.plan.cases[0]), ("pull",))
    assert 0.6 < found.by_path["reached"][0] < 0.7 and found.by_path["limit_load"][0] == 1.0
    assert np.nanmax(found.along["H"]) < 0.97 * float(path["H"][-1])
    assert {name: found.by_path[f"{name}_largest"][0] for name in "HM"} == {name: path[name].max() for name in "HM"}
    assert np.isnan(found.by_path["mesh_error_pct"][0])


def test_a_probe_has_come_to_its_aim_by_the_displacement_that_is_imposed():
    """Along a load at 45 degrees u cos + rotation D sin; a probe that stopped half-way had reached 1."""
    u = np.linspace(0.0, 1e-3, 5)
    attrs = {"kind": "probe", "load_angle_rad": np.pi / 4, "load_lever_m": 8.0 * np.sin(np.pi / 4)}
    data = xr.Dataset({"u": ("step", u), "rotation": ("step", u / 8.0), "converged": ("step", np.ones(5))}, attrs=attrs)
    (asked,) = tiny.scene(paths=({"name": "p", "kind": "probe", "role": "held-back", "load_angle": np.pi / 4,
                                  "lateral_displacement": 4e-3 * np.sin(np.pi / 4)},)).load_paths  # fmt: skip
    np.testing.assert_allclose(dataset.shares_of(SpringPath("p", data, 4.0), asked), 500.0 * u)


def test_the_largest_load_of_a_vertical_path_is_v(tmp_path):
    """Not what the solver leaves of H and M; upwards the largest pull, not V at rest."""
    tree = vertical_springs()
    save_springs(tree, tmp_path / "springs.nc")
    paths = tuple(
        {"name": name, "kind": "vertical", "vertical_displacement": w} for name, w in (("up", -1e-2), ("down", 1e-2))
    )
    found = measure(tmp_path, tiny.scene(paths=paths), ("up", "down")).by_path
    assert found["V_largest"].tolist() == [float(tree[f"paths/{name}"]["V"][-1]) for name in ("up", "down")]
    assert found["V_largest"][0] < 0.0 and np.isnan([found["H_largest"], found["M_largest"]]).all()


@pytest.mark.parametrize("aim", [0.02, -0.02])
def test_a_vertical_path_starts_at_its_settlement_under_the_dead_load(aim):
    """w of springs is that of the full model, 3 mm at rest; the aim is the way from there."""
    share = np.linspace(0.0, 1.0, 5)
    data = xr.Dataset(
        {"w": ("step", 3e-3 + aim * share), "converged": ("step", np.ones(5))}, attrs={"kind": "vertical"}
    )
    (asked,) = tiny.scene(paths=({"name": "p", "kind": "vertical", "vertical_displacement": aim},)).load_paths
    np.testing.assert_allclose(dataset.shares_of(SpringPath("p", data, 4.0), asked), share, atol=1e-12)


def test_a_table_and_a_picture_of_the_dataset(ended, tmp_path):
    import openpyxl

    with dataset.open_study(ended.out) as data:
        with write_table(data, tmp_path / "all.csv").open(encoding="utf-8") as stream:
            found = list(csv.DictReader(stream))
        book = openpyxl.load_workbook(write_table(data, tmp_path / "all.xlsx"))
        assert len(found) == 4 and float(found[2]["K_H [N/m]"]) == pytest.approx(float(data["K_H"][1, 0]), rel=1e-9)
        assert [row[0].value for row in book["cases"].iter_rows(min_row=2)] == [1, 2, 3, 4]
        drawn = draw(data, "K_H", ["young_modulus", "mu"]).axes[0].collections[0].get_array()
        assert np.array_equal(np.ravel(drawn), data["K_H"].values.T.ravel())
        plot = draw(data, "H_largest:pull", ["mu"]).axes[0]
        assert plot.lines[0].get_ydata() == pytest.approx(data["H_largest"].sel(path="pull")[1].values)
        assert plot.get_ylabel() == "H_largest:pull [N]\nno limit load in 4 of 4 cases: the end of the path"
        plot = draw(data.assign(limit_load=data["limit_load"] + 1.0), "H_largest:pull", ["mu"]).axes[0]
        assert plot.get_ylabel() == "H_largest:pull [N]"  # capacities
        with pytest.raises(UserInputError, match="no quantity 'K_h'"):
            draw(data, "K_h")


def test_a_picture_has_its_axes_in_order(ended):
    """Values that a study lists in another order are drawn from the least to the largest."""
    with dataset.open_study(ended.out) as data:
        mixed = data.load().isel(young_modulus=[1, 0])
        drawn, other = (draw(each, "K_H", ["young_modulus", "mu"]).axes[0].collections[0] for each in (mixed, data))
        np.testing.assert_array_equal(drawn.get_array(), other.get_array())
        np.testing.assert_array_equal(drawn.get_coordinates(), other.get_coordinates())


def test_a_picture_has_decades_by_ratio_and_shows_no_rounding(ended):
    """Of values from 1e-8 to 1e-4 on a linear axis only the last two were seen; K_H of coupled ground is one number."""
    with dataset.open_study(ended.out) as data:
        wide = data.load().assign_coords(mu=[1e-8, 1e-4])
        alike = wide.assign(K_H=1e9 + 1e-3 * wide["mu"] + 0.0 * wide["K_H"])
        plot = draw(alike, "K_H", ["young_modulus", "mu"]).axes[0]
        cells = plot.collections[0]
        np.testing.assert_allclose(cells.get_coordinates()[:, 0, 1], [1e-10, 1e-6, 1e-2])
        assert plot.get_yscale() == "log" and plot.get_xscale() == "linear"
        assert cells.get_clim() == pytest.approx((0.999e9, 1.001e9))
        assert draw(data, "K_H", ["mu", "young_modulus"]).axes[0].collections[0].get_clim()[1] == data["K_H"].max()
        assert draw(wide, "K_H", ["mu"]).axes[0].get_xscale() == "log"


def test_a_study_without_springs_leaves_no_dataset_of_an_earlier_one(ended, tmp_path):
    for file in (dataset.FILE, dataset.CSV):
        (tmp_path / file).touch()
    failed = {number: State("failed", "no springs") for number in ended.states}
    assert dataset.write_study(study.Study(ended.plan, tmp_path, ended.hashes, failed)) is None
    assert list(tmp_path.iterdir()) == []


def test_pictures_of_all_that_a_dataset_has_are_accepted_before_its_cases_run(ended):
    with dataset.open_study(ended.out) as data:
        dataset.check_pictures(ended.plan, list(dataset.scalars(data)))


def test_what_cannot_be_written_is_refused_before_a_case_runs(tmp_path):
    make(tmp_path)
    for options, words in (
        (("--table", "all.nc"), "ends in .csv or .xlsx"), (("--over", "mu"), "give --picture, too"),
        (("--picture", "K_H", "--over", "mu,nu"), "no axis 'nu'; there are: young_modulus, mu"),
        (("--picture", "K_H", "--over", "mu,mu,mu"), "--over: expected one axis or two of: young_modulus, mu"),
        (("--picture", "K_H", "--picture", "H_largest:pul"), "no quantity 'H_largest:pul' (did you mean 'H_largest:pu"),
    ):  # fmt: skip
        refused = command("sweep", tmp_path / "study.toml", "--out", tmp_path / "out", *options)
        assert refused.code == 2 and words in refused.err and not (tmp_path / "out").exists()


def test_cases_that_stopped_early_are_crossed_in_a_picture(ended):
    with dataset.open_study(ended.out) as data:
        assert draw(data, "H_largest:pull", ["mu"]).axes[0].get_legend() is None
        words = data["status"].values.copy()
        words[1, 0] = "partial"
        short = data.load().assign(status=(data["status"].dims, words))
        for axes in (["mu"], ["mu", "young_modulus"]):
            (cross,) = (line for line in draw(short, "H_largest:pull", axes).axes[0].lines if line.get_marker() == "x")
            place = 200.0 if len(axes) > 1 else float(data["H_largest"].sel(path="pull")[1, 0])
            assert (*cross.get_xdata(), *cross.get_ydata()) == pytest.approx((0.3, place))
            assert cross.get_label() == "stopped early"


def test_axes_of_a_sample_are_coordinates_and_stand_in_a_table_once(ended, tmp_path):
    sampled = study.Study(replace(ended.plan, is_grid=False), tmp_path, ended.hashes, ended.states)
    (tmp_path / "cases").symlink_to(ended.out / "cases")
    dataset.write_study(sampled)
    with dataset.open_study(tmp_path) as data:
        assert data["K_H"].dims == ("case",) and set(data.coords) >= {"young_modulus", "mu"}
        table = table_of(data)
        assert table.columns.is_unique and table.iloc[:, 1].tolist() == [100.0, 100.0, 200.0, 200.0]
        assert draw(data, "K_H", ["mu"]).axes[0].lines[0].get_ydata() == pytest.approx(data["K_H"].values)


def test_a_tornado_has_a_bar_for_each_range_the_longest_on_top(ended, tmp_path):
    """The four runs stand for all best, one value low and high, and another one high: its low is missing, and named."""
    axes = tuple(replace(axis, words=dict.fromkeys(ESTIMATES, axis.values[0])) for axis in ended.plan.axes)
    words = [("low", "best"), ("best", "best"), ("high", "best"), ("best", "high")]
    cases = tuple(replace(case, values=each) for case, each in zip(ended.plan.cases, words, strict=True))
    plan = replace(ended.plan, axes=axes, cases=cases, is_grid=False)
    (tmp_path / "cases").symlink_to(ended.out / "cases")
    dataset.write_study(study.Study(plan, tmp_path, ended.hashes, ended.states))
    with dataset.open_study(tmp_path) as data:
        K = data["K_H"].values
        plot = draw(data, "K_H").axes[0]
        ends = [bar.get_x() + bar.get_width() for bar in plot.patches]
        assert [label.get_text() for label in plot.get_yticklabels()] == [
            "young_modulus", "mu (an end has no answer)",
        ]  # fmt: skip
        assert ends == pytest.approx([K[0], np.nan, K[2], K[3]], nan_ok=True)
        assert plot.lines[0].get_xdata()[0] == pytest.approx(K[1])
        stopped = data.assign(status=data["status"].where(data["case_number"] != 2, "stopped"))
        with pytest.raises(UserInputError, match="'K_H' has no answer with all ranges at best"):
            draw(stopped, "K_H")


def test_values_beyond_their_common_range_are_named_before_a_case_runs(tmp_path):
    """Once each, at the first case that has one: a unit that slipped is seen in the plan."""
    make(tmp_path, TEXT.replace('"200 MPa"', '"200 GPa"').replace("0.5]", "5.0]"))
    out = command("sweep", tmp_path / "study.toml", "--out", tmp_path / "out", "--plan").out
    notes = [line for line in out.splitlines() if line.startswith("note: ")]
    beyond = [line for line in notes if "outside the common range" in line]
    assert [line.split(":")[1:3] for line in beyond] == [
        [" case 00002", " interface.friction_coefficient"], [" case 00003", " layer 'soil'"],
    ]  # fmt: skip
    assert "1000 times too large?" in beyond[1]


def test_edits_of_cases_csv_count(ended, tmp_path):
    plan = make(tmp_path)
    out = tmp_path / "out"
    first = study.planned(plan, out)
    states = {1: State(SKIP), 2: State(AGAIN), 3: State("waiting"), 4: State("waiting")}
    write_cases(out, plan, states)
    text = (out / "cases.csv").read_text(encoding="utf-8").replace("00003,200,0.3", "00003,250,0.3")
    (out / "cases.csv").write_text(text + "5,300,0.4,,,,\n", encoding="utf-8")
    second = study.planned(plan, out)
    assert [second.states[n].status for n in (1, 2, 3, 4, 5)] == [SKIP, "waiting", "waiting", "waiting", "waiting"]
    assert second.plan.scene_of(second.plan.cases[2]).soil.young_modulus == 250e6
    assert second.hashes[4] == first.hashes[4] and second.hashes[3] != first.hashes[3]
    assert not second.plan.is_grid and len(second.plan.cases) == 5


def test_wrong_edits_are_refused_at_their_line(tmp_path):
    plan, out = make(tmp_path), tmp_path / "out"
    study.planned(plan, out)
    text = (out / "cases.csv").read_text(encoding="utf-8").replace("00002,100,0.5", "00001,100,0.5")
    (out / "cases.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UserInputError, match=r"cases.csv:3: id: case 00001 stands here twice"):
        study.planned(plan, out)


def test_a_changed_study_is_refused_unless_it_is_asked_for(tmp_path):
    out = tmp_path / "out"
    study.planned(make(tmp_path), out)
    changed = make(tmp_path, TEXT.replace("0.3, 0.5", "0.3, 0.5, 0.6"))
    with pytest.raises(UserInputError, match="has changed"):
        study.planned(changed, out)
    assert len(study.planned(changed, out, again=True).plan.cases) == 6


def test_a_table_of_the_user_is_not_replaced(tmp_path):
    """The table of cases may have the name of that of a study, in the folder that is given."""
    mine = tmp_path / "cases.csv"
    mine.write_text("soil.young_modulus [MPa]\n80\n", encoding="utf-8")
    plan = make(tmp_path, 'scene = "base.toml"\ncases = "cases.csv"\n')
    with pytest.raises(UserInputError, match=r"cases\.csv here is of no study"):
        study.planned(plan, tmp_path)
    assert mine.read_text(encoding="utf-8") == "soil.young_modulus [MPa]\n80\n"
    assert len(study.planned(plan, tmp_path, again=True).plan.cases) == 1


def test_a_folder_that_is_not_shared_is_carried_back(ended, tmp_path):
    case = ended.plan.cases[0]
    scene = ended.plan.scene_of(case).to_toml()
    task = worker.Task(1, scene, str(tmp_path / "elsewhere"), ended.hashes[1], "sign")
    answer = worker.run_case(task)
    assert answer.files is not None and answer.ended.status == DONE and not (tmp_path / "elsewhere").exists()
    worker.unpack(answer.files, tmp_path / "cases" / ended.hashes[1])
    carried = Springs.of(open_springs(tmp_path / "cases" / ended.hashes[1] / "springs.nc"))
    here = Springs.of(open_springs(ended.folder(1) / "springs.nc"))
    assert np.array_equal(carried.paths["pull"].p, here.paths["pull"].p)


def test_a_case_that_cannot_converge_is_a_row_with_its_reason(tmp_path):
    (tmp_path / worker.SIGN).write_text("sign", encoding="utf-8")
    task = worker.Task(1, tiny.stuck_scene().to_toml(), str(tmp_path), "stuck", "sign")
    ended = worker.run_case(task).ended
    assert ended.status == "failed" and "pull" in ended.reason and "\n" not in ended.reason
    assert worker.read_ended(tmp_path / "cases" / "stuck") == ended


def test_remapped_slices_share_the_whole_skirt():
    bounds = np.array([[0.0, 1.7], [1.7, 3.0]])
    weights = remap(bounds, 3.0)
    assert weights.sum(axis=0) == pytest.approx([1.7, 1.3]) and weights.sum(axis=1) == pytest.approx(3.0 / DEPTHS)


COMMAND = [sys.executable, "-m", "pysprings", "sweep", "study.toml", "--out", "out", "--jobs", "2"]


def kill_workers(process, started, until, period=1.0):
    """Kill a worker every period once a folder is there, until the study has ended or so many are dead."""
    killed = 0
    while process.poll() is None and killed < until:
        time.sleep(period)
        if not started.exists():
            continue
        try:
            found = [p for p in psutil.Process(process.pid).children(recursive=True)
                     if "spawn_main" in " ".join(p.cmdline())]  # fmt: skip
        except psutil.Error:
            continue
        if found:
            found[killed % len(found)].kill()
            killed += 1
    return killed


@pytest.mark.slow
def test_killed_workers_lose_no_case_and_repeat_none(ended, tmp_path):
    make(tmp_path)
    process = subprocess.Popen(COMMAND, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    killer = threading.Thread(target=kill_workers, args=(process, tmp_path / "out" / "cases", 3, 6.0))
    killer.start()
    _, messages = process.communicate()
    killer.join()
    assert process.returncode == 0, messages
    assert [row["status"] for row in rows(tmp_path / "out")] == ["complete"] * 4
    for case in ended.plan.cases:
        name = ended.hashes[case.number]
        left, right = (Springs.of(open_springs(out / "cases" / name / "springs.nc"))
                       for out in (ended.out, tmp_path / "out"))  # fmt: skip
        assert np.allclose(left.paths["pull"]["H"], right.paths["pull"]["H"], rtol=1e-12)


@pytest.mark.slow
def test_an_interrupted_study_goes_on(tmp_path):
    make(tmp_path)
    process = subprocess.Popen(COMMAND, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    while process.poll() is None and not list((tmp_path / "out").glob("cases/*/case.json")):
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=120)
    assert process.returncode in (0, 130), messages
    kept = {file: file.stat().st_mtime_ns for file in (tmp_path / "out").glob("cases/*/case.json")}
    open_rows = "waiting" in {row["status"] for row in rows(tmp_path / "out")}
    assert kept and (open_rows or process.returncode == 0)
    subprocess.run(COMMAND, cwd=tmp_path, check=True, capture_output=True)
    assert [row["status"] for row in rows(tmp_path / "out")] == ["complete"] * 4
    assert all(file.stat().st_mtime_ns == stamp for file, stamp in kept.items())


@contextmanager
def scheduler_and_worker(file):
    """Start a scheduler and a worker as processes; give both, kill both at the end."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    asked = ["--scheduler-file", str(file), "--no-dashboard"]
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", *asked, "--port", "0"]
    processes = [subprocess.Popen(scheduler, **quiet)]
    try:
        while not file.exists():
            time.sleep(0.1)
        worker_of = [sys.executable, "-m", "distributed.cli.dask_worker", *asked, "--nthreads", "1", "--no-nanny"]
        processes.append(subprocess.Popen(worker_of, **quiet))
        yield processes
    finally:
        for process in processes:
            process.kill()
            process.wait()
        file.unlink(missing_ok=True)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="processes of the scheduler")
def test_a_study_ends_when_its_scheduler_is_killed_and_goes_on_with_another_one(tmp_path):
    make(tmp_path)
    file = tmp_path / "scheduler.json"
    command = [*COMMAND[:-2], "--scheduler", str(file)]
    with scheduler_and_worker(file) as (scheduler, _):
        process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        while process.poll() is None and not list((tmp_path / "out").glob("cases/*/case.json")):
            time.sleep(0.05)
        scheduler.kill()
        _, messages = process.communicate(timeout=120)
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
    assert process.returncode == 4 and "Traceback" not in messages
    assert messages.splitlines()[-1].startswith("fatal: resources: the scheduler went away")
    kept = {ended: ended.stat().st_mtime_ns for ended in (tmp_path / "out").glob("cases/*/case.json")}
    assert 1 <= len(kept) < 4

    gone = subprocess.run([*command[:-1], address], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert gone.returncode == 4 and "no scheduler answers" in gone.stderr

    with scheduler_and_worker(file):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert [row["status"] for row in rows(tmp_path / "out")] == ["complete"] * 4
    assert all(ended.stat().st_mtime_ns == stamp for ended, stamp in kept.items())
