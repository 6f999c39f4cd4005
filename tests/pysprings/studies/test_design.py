# SPDX-License-Identifier: MIT
"""Load cases on the springs of a fan: each answer is that of `predict`; what is beyond them is blank and marked."""

import json
import math
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

import pysprings
from pysprings.cli import design as cli
from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.core.text import number
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import predict
from pysprings.macro.vertical_answer import largest_vertical
from pysprings.results.exporters import export
from pysprings.results.folder import run_to_folder
from pysprings.results.plots.load_cases import load_cases
from pysprings.results.report import load_cases as text
from pysprings.results.tables import open_table
from pysprings.springs.checks import save_springs
from pysprings.studies import design as files
from pysprings.studies.design import answer_cases
from tests.support import fans, tiny
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import TORSION
from tests.support.vertical import REST, down_curve, fan_with_vertical, vertical_springs

LINES = (
    "name,limit state,H [kN],arm [m],tilt [deg]",
    "calm,SLS,500,2,",
    "storm,ULS,900,6,0.001",
    "huge,ULS,1e6,2,",
    "mirror,SLS,-500,2,",
)


@pytest.fixture(scope="module")
def springs():
    return fan_springs(potential)


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    file = tmp_path / "cases.csv"
    file.write_text("\n".join(LINES) + "\n", encoding="utf-8")
    return file


def test_answers_are_those_of_predict(springs, cases: Path) -> None:
    table = answer_cases(springs, read_load_cases(cases), tilt=0.01).set_index("name")
    for name, H, arm in (("calm", 5e5, 2.0), ("storm", 9e5, 6.0)):
        state = predict(springs, H=H, arm=arm)
        for column, variable in (("u_m", "u"), ("rotation_rad", "rotation"), ("w_m", "w")):
            assert table[column][name] == pytest.approx(float(state[variable]), rel=1e-9, abs=1e-15)
        assert table["tangent_u_u_N_per_m"][name] == pytest.approx(float(state["stiffness"][0, 0]), rel=1e-9)
        assert table["tangent_rotation_u_N"][name] == pytest.approx(float(state["stiffness"][2, 0]), rel=1e-9)
    assert table["secant_H_u_N_per_m"]["calm"] == pytest.approx(5e5 / table["u_m"]["calm"])
    assert table["u_m"]["mirror"] == pytest.approx(-table["u_m"]["calm"])
    assert table["tilt_used"]["calm"] == pytest.approx(abs(table["rotation_rad"]["calm"]) / 0.01)
    assert table["tilt_used"]["storm"] == pytest.approx(abs(table["rotation_rad"]["storm"]) / np.radians(0.001))
    assert list(table["verdict"]) == ["ok", "tilt exceeded", table["verdict"]["huge"], "ok"]


def test_secants_of_a_load_that_is_zero_are_blank(springs, tmp_path: Path) -> None:
    """They were 0, a foundation without stiffness."""
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],M [MN m]\nbent,0,3\npushed,500,0\n", encoding="utf-8")
    table = answer_cases(springs, read_load_cases(file))
    secants = {"secant_H_u_N_per_m": [np.nan, 5e5 / table["u_m"][1]]}
    secants |= {"secant_M_rotation_Nm": [3e6 / table["rotation_rad"][0], np.nan]}
    assert all(list(table[name]) == pytest.approx(own, nan_ok=True) for name, own in secants.items())


def test_a_tilt_within_the_band_of_an_atlas_is_not_ok(cases: Path) -> None:
    """Deviations stand beside the motions; 1.96 of them beyond what is tolerated make a mark, fewer do not."""
    atlas = pysprings.open_atlas("clay")
    springs = atlas.springs(atlas.scene(D=9.0, L=6.0))
    load = 0.9 * predict(springs, H=1e5, arm=10.0).attrs["capacity_H_N"]
    state = predict(springs, H=load, arm=10.0)
    turn, own = (math.degrees(float(state[name])) for name in ("rotation", "rotation_deviation"))
    lines = [f"{k},,{factor * load},10,{turn + k * own}" for k, factor in ((1.9, 1e-3), (2.0, 1e-3), (3.0, 1.0))]
    cases.write_text("\n".join([LINES[0], *lines]) + "\n", encoding="utf-8")
    table = answer_cases(springs, read_load_cases(cases))
    assert table.loc[2, ["u_m", "u_deviation_m", "rotation_deviation_rad"]].isna().all()  # a thousand times the load
    assert list(table["u_deviation_m"][:2]) == pytest.approx([float(state["u_deviation"])] * 2)
    assert list(table["rotation_deviation_rad"][:2]) == pytest.approx([math.radians(own)] * 2)
    assert list(table["verdict"][:2]) == ["supported in part", "ok"]
    assert table["marks"][0] == f"tilt with 1.96 deviations {number(turn + 1.96 * own, 3)} deg: not tolerated"
    assert "deviation of rotation [deg]" in text.table_of(table, brief=True).columns


def test_what_the_error_of_the_mesh_turns_is_not_ok(cases: Path) -> None:
    """Cases are met as they are, and not at loads larger by the stated error: by tilt, and by a limit load."""
    springs = fan_springs(potential)
    plain, more = (predict(springs, H=H, arm=2.0) for H in (5e5, 5.25e5))
    turns = [math.degrees(float(state["rotation"])) for state in (plain, more)]
    tilts = [0.5 * sum(turns), 1.01 * turns[1]]
    lines = [*(f"{tilt},,500,2,{tilt}" for tilt in tilts), "near,,485,0,", "far,,470,0,"]
    cases.write_text("\n".join([LINES[0], *lines]) + "\n", encoding="utf-8")
    springs["paths/ray_0"].attrs |= {"end": "limit load", "end_H_N": 5e5, "end_M_Nm": 0.0}
    assert (answer_cases(springs, read_load_cases(cases))["verdict"] == "ok").all()  # no error is stated
    for path in springs["paths"].children.values():
        path.attrs["mesh_error_pct"] = 5.0
    table = answer_cases(springs, read_load_cases(cases))
    assert list(table["mesh_error_pct"]) == [5.0] * 4
    words = "at loads 5 % larger, the error of the mesh"
    assert list(table["marks"]) == [
        f"{words}: tilt {number(turns[1], 3)} deg, not tolerated", "", f"{words}: overloaded", ""
    ]  # fmt: skip
    assert list(table["verdict"]) == ["supported in part", "ok", "supported in part", "ok"]


def test_a_pull_alone_that_the_error_of_the_mesh_overloads_is_not_ok(tmp_path) -> None:
    springs = vertical_springs(ends=(1e-2, -0.5))
    limit = float(springs["paths/up"]["V"][-1])
    springs["paths/up"].attrs |= {"end": "limit load", "mesh_error_pct": 5.0 * limit / (limit - REST)}  # of the change
    (tmp_path / "v.csv").write_text(f"V [kN]\n{0.94e-3 * limit}\n{0.97e-3 * limit}\n", encoding="utf-8")
    table = answer_cases(springs, read_load_cases(tmp_path / "v.csv"))
    assert list(table["marks"]) == ["", "at loads 5 % larger, the error of the mesh: overloaded"]


def test_the_tilt_of_the_scene_counts_where_nothing_else_gives_one(springs, cases: Path) -> None:
    """A row's own tolerance comes first, then that of the question, then [design] tilt of the run."""
    text = tiny.scene(design={"tilt": np.radians(0.0015)}).to_toml()
    tree = springs.copy(deep=False)
    tree.attrs = tree.attrs | {"scene_toml": text}
    table = answer_cases(tree, read_load_cases(cases)).set_index("name")
    np.testing.assert_allclose(table["tilt_limit_deg"], [0.0015, 0.001, 0.0015, 0.0015])
    assert table["verdict"]["calm"] == table["verdict"]["mirror"] == "tilt exceeded"
    given = answer_cases(tree, read_load_cases(cases), tilt=0.01).set_index("name")
    assert given["verdict"]["calm"] == "ok"


def test_what_is_beyond_the_springs_has_no_motion(springs, cases: Path) -> None:
    table = answer_cases(springs, read_load_cases(cases)).set_index("name")
    huge = table.loc["huge"]
    assert huge["answered"] == 0 and huge["verdict"] in ("no answer", "overloaded") and huge["marks"]
    motions = [name for name in table if name.startswith(("u_m", "w_m", "rotation", "tilt", "secant", "tangent"))]
    assert len(motions) >= 10
    assert huge[motions].isna().all()
    assert huge["V_N"] == table["V_N"]["calm"] == REST and huge["utilisation"] > 1.0
    assert huge["H_capacity_N"] == pytest.approx(1e9 / huge["utilisation"])


def test_a_case_without_an_answer_at_another_v_has_no_utilisation(tmp_path: Path) -> None:
    """Springs of 2 MN without vertical paths, and with one downwards: a pull had the utilisation at 2 MN."""
    file = tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m],V [MN]\nown,100,2,2\npull,100,2,-1\nboth,1e5,2,3\nover,1e5,2,2\n")
    for tree, own in ((fan_springs(potential), 0), (vertical_springs(ends=(1e-2,)), 1)):
        table = answer_cases(tree, read_load_cases(file)).set_index("name")
        assert table["answered"].tolist() == [1, 0, 0, 0] and list(table["verdict"][1:3]) == ["no answer"] * 2
        blank = table[["utilisation", "H_capacity_N", "M_capacity_Nm"]].isna()
        assert blank.all(axis=1).tolist() == blank.any(axis=1).tolist() == [False, True, True, False]
        assert (
            list(table["capacity_kind"][1:3]) == ["not known"] * 2 and np.isfinite(table["utilisation_V"]["own"]) == own
        )


def test_a_case_between_and_beyond_the_vertical_loads_of_the_springs_is_marked_with_a_bound(tmp_path: Path) -> None:
    """2 and 6 MN: 2.1 has springs, 4 lies between, 8 beyond; each side's answer is that of `predict` there.

    Beyond, the load at equal motion is at least its chord in V from the springs at 6 MN to the end of the path down:
    the bound is the answer to the load over that share.
    """
    tree, file = vertical_springs(heavier=(6e6,)), tmp_path / "cases.csv"
    rows = "".join(f"at {V},100,2,{V}\n" for V in (2.1, 4, 8))
    file.write_text(f"name,H [kN],arm [m],V [MN]\n{rows}", encoding="utf-8")
    table = answer_cases(tree, read_load_cases(file), extrapolate=True).set_index("name")
    assert table["V_springs_N"].tolist() == pytest.approx([2e6, 6e6, 6e6])  # 4 is 1/3 below 6, 1/2 above 2
    between = [text for text in table.attrs["notes"] if "V is between the springs" in text]
    assert [text.partition(":")[0] for text in between] == ["at some V"]  # not those of 2.1 and 8 MN
    with pytest.warns(UserWarning):  # two rays are 90 degrees apart
        sides = [1e3 * float(predict(tree, H=1e5, arm=2.0, V=V)["u"]) for V in (2e6, 6e6)]
        notes = ["; ".join(predict(tree, H=1e5, arm=2.0, V=V).attrs["remarks"]) for V in (2.1e6, 4e6)]
    assert ["V is between the springs at 2 and 6 MN" in text for text in notes] == [False, True]
    words = f"at V 2 and 6 MN: u {sides[0]:.3g} and {sides[1]:.3g} mm, rotation "
    assert "at V" not in table["marks"]["at 2.1"]
    assert f"V between the springs, interpolated; {words}" in table["marks"]["at 4"]
    end = REST + float(down_curve(np.array(1e-2)))
    share = (8e6 - end) / (6e6 - end)
    assert 0.1 < share < 0.95
    with pytest.warns(UserWarning):
        most = predict(tree, H=1e5 / share, arm=2.0, V=6e6)
    beyond = table.loc["at 8"]
    for column, name in (("u_bound_m", "u"), ("rotation_bound_rad", "rotation")):
        assert float(most[name]) <= beyond[column] < 1.2 * float(most[name])  # the motion may turn
    assert beyond["utilisation_bound"] == pytest.approx(float(most["utilisation"]), rel=1e-6)
    words = f"loads at equal motion at least {100 * share:.0f} % of those of the springs; bound: u "
    assert words in beyond["marks"] and table["u_bound_m"].notna().tolist() == [False, False, True]
    assert set(table["verdict"]) == {"supported in part"}
    limited = table.reset_index().assign(tilt_limit_deg=0.1)
    used = np.degrees(beyond["rotation_bound_rad"]) / 0.1
    assert f"largest bound of the tilt used {used:.3g} in 'at 8'" in text.closing(limited)
    assert "of the tilt" not in text.closing(table.reset_index())  # without a tolerance
    governs = f"largest bound of the utilisation {beyond['utilisation_bound']:.3g} in 'at 8'"
    assert governs in text.closing(table.reset_index())


def test_a_v_beyond_springs_at_one_v_has_a_bound_where_a_vertical_path_leads_beyond_it(tmp_path: Path) -> None:
    file = tmp_path / "cases.csv"
    rows = "less,100,2,1\nmore,100,2,3\nthere,100,2,2\nlifted,100,2,-1\nout,100,2,-4\n"  # the path ends at -0.8 MN
    file.write_text(f"name,H [kN],arm [m],V [MN]\n{rows}", encoding="utf-8")
    table = answer_cases(vertical_springs(ends=(-1e-2,)), read_load_cases(file), extrapolate=True).set_index("name")
    pull = REST + float(down_curve(np.array(-1e-2)))
    share = (1e6 - pull) / (REST - pull)
    assert f"at least {100 * share:.0f} % of those" in table["marks"]["less"]
    assert table["utilisation_bound"]["less"] == pytest.approx(table["utilisation"]["less"] / share, rel=1e-6)
    for name in ("more", "lifted", "out"):
        assert table["marks"][name].endswith("no bound: no vertical path leads beyond V")
        assert np.isnan(table["u_bound_m"][name]) and np.isnan(table["utilisation_bound"][name])
    assert "bound" not in table["marks"]["there"]


def test_the_bound_of_motions_holds_whatever_v_leaves_and_wherever_the_load_acts(tmp_path: Path) -> None:
    """Linear springs K at V_s; at V they are share K + (1 - share) B, B that of one mode of motion alone, of any size.

    Loads of all directions of (H, M/L), those under which u or the rotation at V_s is zero among them. u and rotation
    are within the bound, and come to it within 1 %.
    """
    tree, file, L = fan_with_vertical(fans.linear), tmp_path / "cases.csv", fans.LENGTH
    K = tree["stiffness_initial"].values[np.ix_([0, 2], [0, 2])]
    angles = np.radians([*range(-90, 90, 15), *(np.degrees(np.arctan2(K[1, j] / L, K[0, j])) for j in (0, 1))])
    loads = 1e5 * np.stack([np.cos(angles), L * np.sin(angles)], axis=1)
    rows = "".join(f"{k},{H},{M},1\n" for k, (H, M) in enumerate(loads))
    file.write_text(f"name,H [N],M [N m],V [MN]\n{rows}", encoding="utf-8")
    table = answer_cases(tree, read_load_cases(file))
    pull = REST + float(down_curve(np.array(-1e-2)))
    share, most = (1e6 - pull) / (REST - pull), np.zeros((len(loads), 2))
    for mode in np.linspace(0.0, np.pi, 721):
        n = np.array([np.cos(mode), L * np.sin(mode)])
        for size in (0.0, 1e9, 1e13):
            moved = np.linalg.solve(share * K + (1.0 - share) * size * np.outer(n, n), loads.T).T
            most = np.maximum(most, np.abs(moved))
    bounds = table[["u_bound_m", "rotation_bound_rad"]].to_numpy()
    assert (most <= 1.0005 * bounds).all() and (most > 0.99 * bounds).all()


def test_a_bound_beyond_the_calibrated_range_says_so_or_has_no_motion(tmp_path: Path) -> None:
    """V of 6 and 15 MN under 400 kN: the load over its share is within the springs at 2 MN, and beyond them."""
    tree, file = vertical_springs(), tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m],V [MN]\nnear,400,2,6\nfar,400,2,15\n", encoding="utf-8")
    for extrapolate in (False, True):
        table = answer_cases(tree, read_load_cases(file), extrapolate=extrapolate).set_index("name")
        words = {name: text.partition("; bound: ")[2] for name, text in table["marks"].items()}
        assert words["near"].startswith("u ") and not words["near"].endswith(")")
        assert table["utilisation_bound"]["far"] > 1.0 and np.isfinite(table["u_bound_m"]["far"]) == extrapolate
        assert (
            words["far"].endswith("(beyond the calibrated range)" if extrapolate else "") and "nan" not in words["far"]
        )


def test_a_v_within_a_tenth_of_the_springs_is_marked_where_it_nears_its_own_capacity(tmp_path: Path) -> None:
    """Springs at 2, 6 and 14 MN, the path down ends at 15.3: at 15 a quarter of the load is left, beyond no bound."""
    tree, file = vertical_springs(heavier=(6e6, 14e6)), tmp_path / "cases.csv"
    rows = "".join(f"at {V},100,2,{V}\n" for V in (2.1, 6.3, 14.001, 14.05, 15, 15.35))
    file.write_text(f"name,H [kN],arm [m],V [MN]\n{rows}", encoding="utf-8")
    table = answer_cases(tree, read_load_cases(file), extrapolate=True).set_index("name")
    end = REST + float(down_curve(np.array(1e-2)))
    share = (15e6 - end) / (14e6 - end)
    assert table["u_bound_m"].notna().tolist() == [False] * 4 + [True, False] and 0.2 < share < 0.3
    assert f"at least {100 * share:.0f} % of those of the springs; bound: u " in table["marks"]["at 15"]
    assert table["utilisation_bound"]["at 15"] == pytest.approx(table["utilisation"]["at 15"] / share, rel=1e-6)
    assert table["marks"]["at 15.35"].endswith("no bound: no vertical path leads beyond V")
    assert not table["marks"].iloc[:4].str.contains("bound").any()


def test_a_side_without_an_answer_is_named_and_v_alone_needs_no_lateral_springs(tmp_path: Path) -> None:
    """Reactions grow with V: 0.9 of the largest H under 5 MN is beyond the springs at 2 MN."""
    tree, file = vertical_springs(heavier=(6e6,)), tmp_path / "cases.csv"
    H = 1.0
    for _ in range(2):
        file.write_text(f"name,H [N],arm [m],V [MN]\nstorm,{H},2,5\nstill,0,,4\n", encoding="utf-8")
        table = answer_cases(tree, read_load_cases(file)).set_index("name")
        H = 0.9 * table["H_capacity_N"]["storm"]
    marks = table["marks"]["storm"]
    assert "interpolated; at V 6 MN: u " in marks and marks.endswith("; beyond the springs at 2 MN")
    assert (table["verdict"]["still"], table["marks"]["still"]) == ("ok", "")


def test_without_a_table_and_without_a_run_that_names_one_design_is_refused(springs, tmp_path: Path) -> None:
    done = command("design", save_springs(springs, tmp_path / "springs.nc"))
    assert done.code == 2
    assert "CASES: name a table of load cases: there is no run here whose scene has [design] cases" in done.err


def test_the_table_of_the_run_is_named_and_several_estimates_have_no_lines_of_one(
    springs, cases: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("low", "best"):
        (tmp_path / name).mkdir()
        save_springs(springs, tmp_path / name / "springs.nc")
    monkeypatch.setattr(cli, "cases_of", lambda _: cases)
    drawn = []
    monkeypatch.setattr(files, "write", lambda *given: drawn.append(given[3]))
    for folder in (tmp_path, tmp_path / "low"):
        done = command("design", folder, "--out", tmp_path / "a.png")
        assert done.out.startswith(f"load cases: {cases} as it is now ([design] cases of the run)\n\ncase")
    assert drawn[0] is None and drawn[1] is not None
    assert "as it is now" not in command("design", tmp_path / "low", cases).out


def test_the_picture_has_cases_springs_and_largest_loads(tmp_path: Path) -> None:
    tree, file = vertical_springs(heavier=(6e6,)), tmp_path / "cases.csv"
    rows = "low,100,2,2\nhigh,50,2,6\nbetween,100,2,4\nlifted,100,2,-1\n"  # -1 MN is more than the springs hold
    file.write_text(f"name,H [kN],arm [m],V [MN]\n{rows}", encoding="utf-8")
    table = answer_cases(tree, read_load_cases(file))
    (axes,) = load_cases(table, tree).axes
    drawn = {str(line.get_label()): np.column_stack(line.get_data()) for line in axes.lines}
    cases = np.concatenate([xy for label, xy in drawn.items() if label.startswith("load case")])
    np.testing.assert_allclose(cases[cases[:, 0].argsort()], [[-1.0, 0.1], [2.0, 0.1], [4.0, 0.1], [6.0, 0.05]])
    known = 1e-6 * table.set_index("name")["H_capacity_N"]
    assert np.isnan(known["lifted"])
    far = drawn.pop("largest H of springs that are not of this V")
    near = np.concatenate([xy for label, xy in drawn.items() if label.startswith("largest H")])
    np.testing.assert_allclose(near[near[:, 0].argsort()], [[2.0, known["low"]], [6.0, known["high"]]])
    np.testing.assert_allclose(far, [[4.0, known["between"]]])
    bands = sorted((each.get_x(), each.get_x() + each.get_width()) for each in axes.patches)
    np.testing.assert_allclose(bands, [[1.8, 2.0 / 0.9], [5.4, 6.0 / 0.9]])
    assert axes.texts[0].get_text() == "load at 2 m"
    assert sorted(text.get_text() for text in axes.texts[1:]) == ["between", "high", "lifted", "low"]
    (alone,) = load_cases(table, None).axes  # of several estimates: no lines of one of them
    assert not any(str(line.get_ydata()[-1]) == "1" for line in alone.lines)
    upright = sorted(float(line.get_xdata()[0]) for line in axes.lines if str(line.get_ydata()[-1]) == "1")
    model = MacroModel.from_springs(tree)
    ends = [1e-6 * largest_vertical(model, sign)[0] for sign in (1.0, -1.0)]
    assert upright == pytest.approx(sorted([2.0, 6.0, *(end for end in ends if np.isfinite(end))]))
    for ending in (".png", ".svg"):
        assert files.write(tmp_path / f"a{ending}", table, {}, tree).stat().st_size > 5000


def test_files(springs, cases: Path, tmp_path: Path) -> None:
    table = answer_cases(springs, read_load_cases(cases))
    about = {"springs": "run", "load cases": "<cases>"}
    written = pd.read_csv(files.write(tmp_path / "a.csv", table, about, springs))
    np.testing.assert_allclose(written["u_m"], table["u_m"], rtol=1e-9)
    sheet = openpyxl.load_workbook(files.write(tmp_path / "a.xlsx", table, about, springs))["cases"]
    heads = [cell.value for cell in sheet[1]]
    column = heads.index("u [mm]") + 1
    assert sheet.cell(2, column).value == pytest.approx(1e3 * table["u_m"][0])
    assert sheet.cell(4, column).value is None  # the case without an answer
    page = files.write(tmp_path / "a.html", table, about, springs).read_text()
    assert "&lt;cases&gt;" in page and text.closing(table) in page.replace("&#39;", "'")
    with pytest.raises(UserInputError, match=r"--out: ends in none of \.csv, \.xlsx, \.html"):
        files.write(tmp_path / "a.txt", table, about, springs)


def test_rows_aside_of_one_plane_are_answered_and_marked(springs, tmp_path: Path) -> None:
    """Their own plane is answered, a bound stands beside it, the verdict is never ok."""
    file = tmp_path / "cases.csv"
    lines = ("name,H [kN],arm [m],M [kN m],M direction [deg],Mz [kN m]", "plain,300,6,,,", "across,300,,{0},30,",
             "twist,300,6,,,90", "twist alone,0,,0,,90", "below,300,,{1},,", "turned,300,6,,,900")  # fmt: skip
    signed = 1800.0
    file.write_text("\n".join(lines).format(signed, -signed) + "\n", encoding="utf-8")
    table = answer_cases(springs, read_load_cases(file)).set_index("name")
    assert list(table["verdict"]) == ["ok", *["supported in part"] * 3, "ok", "supported in part"]
    assert table["remarks"]["below"] == "M turns against H, as of a load 6 m below mudline"
    assert (table["remarks"].drop("below") == "").all() and table["marks"]["plain"] == ""
    assert table["marks"]["across"].startswith("no moment across the plane of H (900 kN m left out); bound: u ")
    assert table["marks"]["twist"].startswith("no torsion (90 kN m left out); bound: u ")
    assert table["twist_rad"].dropna().to_dict() == pytest.approx(
        {"twist": 9e4 / TORSION, "twist alone": 9e4 / TORSION, "turned": 9e5 / TORSION}
    )
    assert table["marks"]["twist"].endswith(f"twist {1e3 * 9e4 / TORSION:.3g} mrad at least (stiffness at rest)")
    # the moment turned into the plane of H is that of the plain row; T/R grows H
    assert table["u_bound_m"]["across"] == pytest.approx(table["u_m"]["plain"], rel=1e-9)
    assert table["u_m"]["across"] < table["u_bound_m"]["across"] < table["u_bound_m"]["twist"]
    # T over R says nothing where T is what fails
    assert (
        table["u_bound_m"].dropna().index.tolist()
        == ["across", "twist"]
        == table["utilisation_bound"].dropna().index.tolist()
    )
    for name in ("twist alone", "turned"):
        assert "; no bound: torsion governs" in table["marks"][name] and "bound: u" not in table["marks"][name]


def test_a_torsion_on_springs_of_a_table_has_no_bound(springs, tmp_path: Path) -> None:
    """The radius of the caisson is not known: T over it cannot be added."""
    export(springs, "beam", tmp_path)
    (table,), file = list(tmp_path.glob("*.csv")), tmp_path / "cases.csv"
    file.write_text("name,H [kN],arm [m],T [kN m]\na,100,2,3\n", encoding="utf-8")
    row = answer_cases(open_table(table), read_load_cases(file)).iloc[0]
    assert row["marks"] == "no torsion (3 kN m left out); no bound: the radius, on which torsion acts, is not known"
    assert row[["u_bound_m", "rotation_bound_rad", "utilisation_bound"]].isna().all() and row["verdict"] != "ok"


@pytest.mark.slow
def test_the_command(springs, cases: Path, tmp_path: Path) -> None:
    file = save_springs(springs, tmp_path / "springs.nc")
    done = command(
        "design", file, cases, "--tilt", "0.5 deg", "--out", tmp_path / "a.csv", "--out", tmp_path / "a.html"
    )
    assert done.code == 0, done.err
    lines = done.out.splitlines()
    assert lines[0].split()[:3] == ["case", "limit", "state"]
    assert [line.split()[0] for line in lines[2:6]] == ["calm", "storm", "huge", "mirror"]
    assert lines[7].startswith("4 cases: 2 ok, 1 tilt exceeded")
    assert (tmp_path / "a.csv").exists() and (tmp_path / "a.html").exists()
    data = json.loads(command("design", file, cases, "--json").out)
    assert [row["name"] for row in data["cases"]] == ["calm", "storm", "huge", "mirror"]
    assert data["cases"][2]["u_m"] is None
    strict = command("design", file, cases, "--strict")
    assert strict.code == 2 and "--strict: 4 cases:" in strict.err
    wrong = command("design", file, cases, "--tilt", "-1 deg", "--out", tmp_path / "a.csv")
    assert wrong.code == 2 and "--tilt: a tolerance must be positive" in wrong.err


def test_the_report_of_a_run_shows_the_answers(tmp_path: Path, cases: Path) -> None:
    """design.csv goes into the folder, the report has its rows; springs alone have no report."""
    folder = tmp_path / "run"
    run_to_folder(tiny.scene(output={"figures": False}), folder)
    before = (folder / "report.html").read_text(encoding="utf-8")
    done = command("design", str(folder), str(cases), "--report")
    assert done.code == 0, done.err
    after = (folder / "report.html").read_text(encoding="utf-8")
    assert "Load cases" not in before and all(f">{name}<" in after for name in ("calm", "storm", "huge"))
    assert list(pd.read_csv(folder / "design.csv")["name"]) == ["calm", "storm", "huge", "mirror"]
    alone = json.loads(command("design", str(folder), str(cases), "--springs", "py", "--json").out)["about"]
    assert alone["note"].startswith("p-y springs alone") and alone["springs"].startswith("not checked")
    refused = command("design", str(folder / "springs.nc"), str(cases), "--report")
    assert refused.code == 2 and "--report" in refused.err
    mine = folder / "design.csv"
    mine.write_bytes(cases.read_bytes())
    lost = command("design", str(folder), str(mine), "--report")
    assert lost.code == 2 and "--report: is read by this command" in lost.err
    assert mine.read_bytes() == cases.read_bytes()
