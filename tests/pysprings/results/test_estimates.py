# SPDX-License-Identifier: MIT
"""Runs of several estimates: folders, files side by side, load cases over them, exports, and what is refused."""

import json
import shutil
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

from pysprings.full_model.run_record import RunRecord, Status
from pysprings.results.estimates import write_together
from pysprings.results.report.load_cases import closing
from pysprings.results.two_runs import Run
from pysprings.studies.design import governing
from tests.support import synthetic, tiny
from tests.support.commands import Result, command
from tests.support.measured import measured_result

NAMES = ["low", "best", "high"]


def text(ranged: bool = True) -> str:
    """An elastic soil, whose loads are in proportion to its modulus; the penalty goes with it."""
    soil = {"yield_surface": "elastic", "young_modulus": 100e6}
    pull = {**tiny.PULL, "lateral_displacement": 1e-5}
    turn = {"name": "turn", "kind": "rotation", "rotation": 1e-6, "role": "held-back"}  # the skirt moves backwards
    plain = tiny.scene(soil=soil, interface={"friction_coefficient": 5.0}, paths=(pull, turn)).to_toml()
    modulus = '{ low = "80 MPa", best = "100 MPa", high = "150 MPa" }' if ranged else '"100 MPa"'
    head, tail = plain.split("[soil]", 1)
    return head + "[soil]" + tail.replace('young_modulus = "100 MPa"', f"young_modulus = {modulus}", 1)


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    place = tmp_path_factory.mktemp("ran")
    (place / "a.toml").write_text(text())
    options = [word for name in ("high", "low", "best") for word in ("--estimate", name)]
    return place / "out", command("run", place / "a.toml", "--out", place / "out", *options)


def test_a_folder_for_each_estimate_and_files_of_all(ran: tuple[Path, Result]) -> None:
    folder, done = ran
    assert done.code == 0, done.err
    for name in NAMES:
        record = json.loads((folder / name / "run.json").read_text())
        assert record["status"] == "complete" and f"({name} estimate)" in record["scene_toml"]
    assert {
        "estimates.csv",
        "py.csv",
        "load_displacement.csv",
        "py_side_by_side.csv",
        "springs.xlsx",
        "report.html",
    } < {each.name for each in folder.iterdir()}
    assert (folder / "figures" / "pull.png").exists()
    page = (folder / "report.html").read_text()
    assert all(f'href="{name}/report.html"' in page for name in NAMES) and "data:image/png" in page
    (folder.parent / "cases.csv").write_text("case,H [kN],arm [m]\na,20,0\n")
    design = command("design", folder, folder.parent / "cases.csv")
    for text in record["remarks"]:  # on the scene: they stood in the folder of each estimate alone
        assert text in page and f"note: {text}" in done.err and f"note: {text}" in design.out + design.err, text
    assert "(low estimate)" not in page and page.count("complete; mesh error: ") == len(NAMES)


def test_springs_in_the_folder_of_another_estimate_are_refused(ran: tuple[Path, Result], tmp_path: Path) -> None:
    """Their own title names the estimate; a folder of any other name takes them."""
    for name in ("low", "high", "other"):
        shutil.copytree(ran[0] / name if name != "other" else ran[0] / "low", tmp_path / name)
    shutil.copy(ran[0] / "low" / "springs.nc", tmp_path / "high" / "springs.nc")
    asked = ("--H", "5 kN", "--arm", "0 m")
    (tmp_path / "cases.csv").write_text("case,H [kN],arm [m]\na,20,0\n")
    words = "high: springs.nc is that of the low estimate: "
    for refused in (
        command("predict", tmp_path / "high", *asked), command("design", tmp_path, tmp_path / "cases.csv"),
        command("export", tmp_path, "--to", "xlsx"),
    ):  # fmt: skip
        assert refused.code == 2 and words in refused.err
    for name in ("low", "other"):
        assert (done := command("predict", tmp_path / name, *asked)).code == 0, done.err


def test_loads_side_by_side_are_in_proportion_to_the_stiffness(ran: tuple[Path, Result]) -> None:
    table = pd.read_csv(ran[0] / "estimates.csv")
    assert list(table.columns) == ["part", "quantity", *NAMES]
    assert (table["low"] / table["best"]).to_numpy() == pytest.approx(np.full(len(table), 0.8), rel=0.01)
    assert (table["high"] / table["best"]).to_numpy() == pytest.approx(np.full(len(table), 1.5), rel=0.01)
    curves = pd.read_csv(ran[0] / "py_side_by_side.csv")
    moved = curves[curves["y_m"].abs() > 1e-6]
    ratio = moved["p_high_N_per_m"] / moved["p_best_N_per_m"]
    assert len(moved) > 10 and ratio.to_numpy() == pytest.approx(np.full(len(moved), 1.5), rel=0.01)
    book = openpyxl.load_workbook(ran[0] / "springs.xlsx")
    assert [cell.value for cell in book["loads"][1]] == ["part", "quantity", *NAMES]


def test_curves_side_by_side_are_those_of_each_estimate_with_their_sign(ran: tuple[Path, Result]) -> None:
    """On the slices of all tables; y and p below the point of rotation are negative, as in py.csv."""
    curves = pd.read_csv(ran[0] / "py_side_by_side.csv")
    for name in NAMES:
        whole = pd.read_csv(ran[0] / name / "py.csv")
        own = whole[(whole["family"] == "py") & (whole["side"] == "net") & (whole["component"] == "total")]
        assert sorted(curves["depth_m"].unique()) == pytest.approx(sorted(own["depth_m"].unique()))
        for (path, depth), curve in curves.groupby(["path", "depth_m"]):
            given = own[(own["path"] == path) & np.isclose(own["depth_m"], depth)].sort_values("y_m")
            p = np.interp(curve["y_m"], given["y_m"], given["p_N_per_m"])
            np.testing.assert_allclose(curve[f"p_{name}_N_per_m"], p, rtol=1e-5, atol=1e-6 * np.abs(p).max())
    assert curves["y_m"].min() < -1e-6 and curves["y_m"].max() > 1e-6
    assert set(curves["path"]) == {"pull", "turn"}


def test_loads_at_equal_motion_do_not_depend_on_the_steps_of_a_run(tmp_path: Path) -> None:
    """The same soil in few and in many steps: straight lines between those of the first are 1.4 % low.

    Paths at several vertical loads, or rates, state them.
    """
    runs = {}
    for name, steps in (("low", 12), ("best", 200)):
        given = (synthetic.Path("pull", arm=8.0, steps=steps), synthetic.Path("pull_load_1", arm=8.0, steps=steps))
        result = measured_result(paths=given).copy(deep=True)
        result["paths/pull_load_1/V"][:] = 4e6
        result.attrs["title"] = f"Storm ({name} estimate) (cyclic: drammen.csv, N {steps}, tau_a/su 0)"
        runs[name] = Run(name, result, RunRecord(Status.COMPLETE))
        for table in ("load_displacement.csv", "py.csv"):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / table).write_text("u_m\n0\n")
    _, loads = write_together(tmp_path, runs)
    page = (tmp_path / "report.html").read_text()
    assert {"path pull, V 2000 kN", "path pull_load_1, V 4000 kN"} < set(loads["part"])
    assert "Storm" in page and "estimate)" not in page and "N 12" not in page  # that of one of them
    assert (loads["low"] / loads["best"]).to_numpy() == pytest.approx(np.ones(len(loads)), abs=0.005)
    py = pd.read_csv(tmp_path / "py_side_by_side.csv")
    V = py.groupby("path")[["V_low_N", "V_best_N"]].agg(["min", "max"])
    assert (V.loc["pull"] == 2e6).all() and (V.loc["pull_load_1"] == 4e6).all()
    apart = (py["p_low_N_per_m"] - py["p_best_N_per_m"]).abs().max()
    assert apart < 0.005 * py["p_best_N_per_m"].abs().max()


def test_tables_of_the_runs_are_joined_with_their_estimate(ran: tuple[Path, Result]) -> None:
    for name in ("py.csv", "load_displacement.csv"):
        joined = pd.read_csv(ran[0] / name)
        assert joined["estimate"].drop_duplicates().tolist() == NAMES
        for estimate, part in joined.groupby("estimate"):
            own = pd.read_csv(ran[0] / str(estimate) / name)
            assert part.drop(columns="estimate").reset_index(drop=True).equals(own)


def test_load_cases_show_the_largest_over_the_estimates(ran: tuple[Path, Result], tmp_path: Path) -> None:
    cases = tmp_path / "cases.csv"
    cases.write_text("case,H [kN],arm [m]\na,20,0\n")
    options = ("--springs", "py", "--extrapolate", "--json")
    both = json.loads(command("design", ran[0], cases, *options).out)
    low = json.loads(command("design", ran[0] / "low", cases, *options).out)["cases"][0]
    (row,) = both["cases"]
    assert row["u_m"] == low["u_m"] and "low (u" in row["estimate"]
    assert [each["estimate"] for each in both["estimates"]] == NAMES
    assert both["about"]["note"].startswith("estimates: low complete, best complete, high complete")
    assert "--report: needs the folder of a run" in command("design", ran[0], cases, "--report").err
    for name in NAMES:
        (tmp_path / "stopped" / name).mkdir(parents=True)
        shutil.copy(ran[0] / name / "springs.nc", tmp_path / "stopped" / name)
    (tmp_path / "stopped" / NAMES[-1] / "springs.nc").unlink()  # as a run that was interrupted leaves it
    assert f"estimate {NAMES[-1]} has no springs.nc" in command("design", tmp_path / "stopped", cases, *options).err


def test_files_of_the_answers_state_and_draw_what_governs(ran: tuple[Path, Result], tmp_path: Path) -> None:
    """A case that the high estimate alone answers has no answer: of one case there is one, whatever the rows."""
    cases, files = tmp_path / "cases.csv", [tmp_path / f"a.{end}" for end in ("xlsx", "html", "svg", "csv")]

    def answered(H: float, V: object = "") -> pd.DataFrame:
        cases.write_text(f"case,H [N],arm [m],V [N]\na,{H:.6f},0,{V}\n")
        outs = [word for file in files for word in ("--out", file)]
        assert command("design", ran[0], cases, "--springs", "py", *outs).code == 0
        return pd.read_csv(files[-1]).set_index("estimate")

    small = answered(1.0)
    most, V = small["H_capacity_N"], small["V_N"]["high"]
    large = 0.5 * (most["best"] + most["high"])
    assert answered(large, V)["answered"].to_dict() == {"low": 0, "best": 0, "high": 1}
    about = {row[0]: row[1] for row in openpyxl.load_workbook(files[0])["about"].iter_rows(values_only=True)}
    assert about["result"].startswith("1 case: 1 no answer; largest utilisation")
    assert about["result"] in files[1].read_text().replace("&#39;", "'")
    drawn = files[2].read_text()
    assert "load case, no answer" in drawn and "load case, ok" not in drawn and "supported" not in drawn
    assert answered(large).index.tolist() == NAMES  # drawn without a V that is known


def test_estimates_of_different_scenes_are_refused(ran: tuple[Path, Result], tmp_path: Path) -> None:
    """--force of one of three leaves two of the scene as it was; what a run writes does not count."""
    (tmp_path / "cases.csv").write_text("case,H [kN],arm [m]\na,20,0\n")
    folder, options = tmp_path / "out", ("--estimate", "low", "--force", "--no-figures", "--no-estimate-error")
    shutil.copytree(ran[0], folder)
    for before, after, code in (("# section = true", "section = false", 0), ("150 MPa", "160 MPa", 2)):
        assert before in text()
        (tmp_path / "a.toml").write_text(text().replace(before, after))
        assert command("run", tmp_path / "a.toml", "--out", folder / "low", *options).code == 0
        asked = command("design", folder, tmp_path / "cases.csv", "--springs", "py", "--extrapolate")
        assert asked.code == code and ("those of different scenes (low ran 2" in asked.err) == bool(code), asked.err
    assert command("export", folder, "--to", "csv", "--out", tmp_path / "files").code == 2


def test_motions_are_unknown_where_one_estimate_has_no_answer() -> None:
    """The largest utilisation is that of any estimate; the worst verdict counts."""
    common = {"name": "a", "w_m": 0.0, "tilt_used": 0.1, "utilisation_V": 0.2, "marks": ""}
    none = {"u_m": np.nan, "rotation_rad": np.nan, "answered": 0, "verdict": "no answer"}
    some = {"u_m": 0.01, "rotation_rad": 1e-3, "answered": 1, "verdict": "ok"}
    rows = {"low": {**common, **none, "utilisation": 1.2}, "high": {**common, **some, "utilisation": 0.6}}
    answers, worst = governing({name: pd.DataFrame([row]) for name, row in rows.items()})
    assert answers["estimate"].tolist() == ["low", "high"]
    assert np.isnan(worst["u_m"][0]) and worst["utilisation"][0] == 1.2 and worst["verdict"][0] == "no answer"
    assert worst["estimate"][0].startswith("low (utilisation")
    rows["high"] |= {"tilt_used": 1.34, "verdict": "tilt exceeded"}
    fine = {**common, **some, "name": "b", "utilisation": 0.6}
    _, worst = governing({name: pd.DataFrame([row, fine]) for name, row in rows.items()})
    assert worst["verdict"].tolist() == ["tilt exceeded", "ok"] and worst["marks"][0] == "high: tilt used 1.34"
    assert "largest tilt used 0.1 in 'b', of cases that every estimate answers" in closing(worst)
    fine["utilisation_V"], rows["low"]["utilisation_V"] = 0.1, 0.4  # V used does not need the lateral answer
    _, worst = governing({name: pd.DataFrame([row, fine]) for name, row in rows.items()})
    assert "largest V used 0.4 in 'a'" in closing(worst)


def test_numbers_beside_the_largest_are_those_of_its_estimate() -> None:
    """H/u is the secant, H over its capacity the utilisation; no utilisation where one estimate has no capacity."""
    same = {"name": "a", "H_N": 1e6, "w_m": 0.0, "rotation_rad": 1e-3, "tilt_used": 0.1, "marks": "", "answered": 1}
    same |= {"verdict": "ok", "tilt_deg": 0.1, "mesh_error_pct": 1.0}
    best = same | {"u_m": 0.01, "secant_H_u_N_per_m": 1e8, "utilisation": 0.8, "H_capacity_N": 1.25e6}
    low = same | {
        "u_m": 0.02,
        "secant_H_u_N_per_m": 5e7,
        "utilisation": 0.5,
        "H_capacity_N": 2e6,
        "mesh_error_pct": 4.0,
    }
    best |= {"capacity_kind": "limit load", "utilisation_V": 0.1, "capacity_V_N": 1e6}
    low |= {"capacity_kind": "end of the range", "utilisation_V": 0.2, "capacity_V_N": 5e5}
    _, worst = governing({"best": pd.DataFrame([best]), "low": pd.DataFrame([low])})
    (row,) = worst.to_dict("records")
    assert (row["u_m"], row["secant_H_u_N_per_m"], row["mesh_error_pct"]) == (0.02, 5e7, 4.0)
    assert (row["utilisation"], row["H_capacity_N"], row["capacity_kind"]) == (0.8, 1.25e6, "limit load")
    assert (row["utilisation_V"], row["capacity_V_N"]) == (0.2, 5e5)
    low |= {"utilisation": np.nan, "H_capacity_N": np.nan, "capacity_kind": "not known"}
    (row,) = governing({"best": pd.DataFrame([best]), "low": pd.DataFrame([low])})[1].to_dict("records")
    assert np.isnan(row["utilisation"]) and np.isnan(row["H_capacity_N"]) and row["capacity_kind"] == "not known"
    assert "(utilisation" not in row["estimate"]
    low |= {"mesh_error_pct": np.nan}
    for order in (["best", "low"], ["low", "best"]):
        own = {name: pd.DataFrame([{"best": best, "low": low}[name]]) for name in order}
        assert np.isnan(governing(own)[1]["mesh_error_pct"][0])


def test_loads_of_a_caisson_of_a_group_are_those_of_its_utilisation() -> None:
    """Each estimate shares the loads in its own way; the worst verdict may be that of another one."""
    row = {"name": "a, B", "u_m": 1.0, "w_m": 0.0, "rotation_rad": 1.0, "tilt_used": 0.1, "marks": "", "answered": 1}
    low = row | {"H_N": 507e3, "M_Nm": -439e3, "V_N": 2.22e6, "utilisation": 0.12, "utilisation_V": 0.2}
    low |= {"verdict": "ok"}
    high = row | {"H_N": 500e3, "M_Nm": -216e3, "V_N": 2.24e6, "utilisation": 0.05, "utilisation_V": 0.3}
    high |= {"verdict": "supported in part"}
    _, worst = governing({"low": pd.DataFrame([low]), "high": pd.DataFrame([high])})
    assert (worst["H_N"][0], worst["M_Nm"][0], worst["V_N"][0]) == (507e3, -439e3, 2.24e6)
    assert (worst["verdict"][0], worst["utilisation"][0]) == ("supported in part", 0.12)


def test_bounds_are_the_largest_over_the_estimates() -> None:
    row = {"name": "a", "u_m": 1.0, "w_m": 0.0, "rotation_rad": 1.0, "tilt_used": 0.1, "utilisation": 0.5}
    row |= {"utilisation_V": 0.2, "marks": "", "answered": 1, "verdict": "supported in part", "tilt_deg": 1.0}
    low, high = (
        {"u_bound_m": u, "rotation_bound_rad": 3.0 - u, "utilisation_bound": r} for u, r in ((1, 0.8), (2, np.nan))
    )
    _, worst = governing({"low": pd.DataFrame([row | low]), "high": pd.DataFrame([row | high])})
    assert (worst["u_bound_m"][0], worst["rotation_bound_rad"][0]) == (2.0, 2.0)
    assert np.isnan(worst["utilisation_bound"][0])


def test_exports_are_in_the_folders_of_the_estimates_and_name_them(ran: tuple[Path, Result], tmp_path: Path) -> None:
    done = command("export", ran[0], "--to", "csv", "--out", tmp_path)
    assert done.code == 0, done.err
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(NAMES)


def test_commands_of_one_run_ask_for_one_estimate(ran: tuple[Path, Result]) -> None:
    done = command("predict", ran[0], "--H", "1 kN", "--arm", "0 m")
    assert done.code == 2 and "holds the estimates low, best, high: name the folder of one of them" in done.err


def test_one_estimate_is_a_run_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text())
    done = command("run", tmp_path / "a.toml", "--out", tmp_path / "one", "--estimate", "low", "--json")
    assert done.code == 0 and json.loads(done.out)["run"]["status"] == "complete"


@pytest.mark.parametrize(
    ("ranged", "options", "message"),
    [
        (False, ("low",), "--estimate: no value of the scene has a range"),
        (False, ("low", "high"), "--estimate: no value of the scene has a range"),
        (True, ("lowest",), "--estimate: 'lowest' is none of low, best, high"),
    ],
)
def test_what_is_no_estimate_is_refused(tmp_path: Path, ranged: bool, options: tuple[str, ...], message: str) -> None:
    (tmp_path / "a.toml").write_text(text(ranged))
    words = [word for each in options for word in ("--estimate", each)]
    done = command("run", tmp_path / "a.toml", "--out", tmp_path / "out", *words)
    assert done.code == 2 and message in done.err


def test_faults_of_a_table_of_layers_stand_before_that_of_ranges(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('[soil]\nprofile = "gone.csv"\n')
    done = command("run", tmp_path / "a.toml", "--out", tmp_path / "out", "--estimate", "low")
    assert done.code == 2 and "gone.csv" in done.err and "--estimate" not in done.err


def test_a_folder_of_one_run_takes_no_estimates(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text())
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "run.json").write_text("{}")
    done = command("run", tmp_path / "a.toml", "--out", tmp_path / "out", "--estimate", "low", "--estimate", "best")
    assert done.code == 2 and "holds one run: choose another folder" in done.err


def test_resume_makes_what_is_missing(ran: tuple[Path, Result], tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text())
    options = ("--out", tmp_path / "out", "--no-figures", "--no-estimate-error")
    assert (
        command("run", tmp_path / "a.toml", "--estimate", "low", "--out", tmp_path / "out" / "low", *options[2:]).code
        == 0
    )
    again = command("run", tmp_path / "a.toml", "--estimate", "low", "--estimate", "high", *options, "--resume")
    assert again.code == 0, again.err
    assert "has ended (complete): nothing is left to do" in again.err
    assert list(pd.read_csv(tmp_path / "out" / "estimates.csv").columns) == ["part", "quantity", "low", "high"]


def test_an_estimate_that_stops_leaves_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The exit code is that of the run that stopped; the others are there, and side by side."""
    from pysprings.cli import run as module
    from pysprings.core.errors import RunIncomplete

    (tmp_path / "a.toml").write_text(text())
    whole = module.run_one

    def stops(scene, folder, *rest):
        stopped = whole(scene, folder, *rest)
        return RunIncomplete("invented", folder) if folder.name == "low" else stopped

    monkeypatch.setattr(module, "run_one", stops)
    words = [word for each in NAMES for word in ("--estimate", each)]
    done = command("run", tmp_path / "a.toml", "--out", tmp_path / "out", "--no-figures", *words)
    assert done.code == 3 and "invented" in done.err
    assert (tmp_path / "out" / "high" / "springs.nc").exists() and (tmp_path / "out" / "estimates.csv").exists()
