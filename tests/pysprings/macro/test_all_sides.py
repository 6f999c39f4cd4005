# SPDX-License-Identifier: MIT
"""Loads out of one plane, and torsion, on springs in space: rows of `predict_batch`, `predict`, `design`."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import fsolve

from pysprings.core.errors import BeyondSprings
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.core.words import NOT_KNOWN
from pysprings.macro.answer import MacroWarning
from pysprings.macro.batch import APART, MOST_APART, SIDEWAYS, predict_batch
from pysprings.macro.comparison import compare
from pysprings.macro.comparison_text import SPACE_NOTE, to_text
from pysprings.macro.space import SpaceAnswers, sequence_in_space
from pysprings.memory.space_model import SpaceSprings
from pysprings.results.exporters.csv import read_comparison, write_frame
from pysprings.results.exporters.xlsx import about_lines
from pysprings.results.report.load_cases import table_of
from pysprings.results.report.validity import compare_table
from pysprings.springs.checks import save_springs
from pysprings.springs.path import SPACE_LOADS, SPACE_TURNS
from pysprings.springs.springs import Springs
from pysprings.springs.tip_zone import reslice
from pysprings.studies.design import GOVERNS, answer_cases
from tests.support import space_paths
from tests.support.commands import command
from tests.support.space_springs import calibrated
from tests.support.vertical import REST, down_curve, vertical_path

# H_x, H_y [N], M_x, M_y, T [N m]: in a plane twice, with a moment across, with T, T alone
LOADS = 1e5 * np.array(
    [[2.0, 0, 0, 4, 0], [1.2, 1.6, -3.2, 2.4, 0], [2, 0, -3, 4, 0], [2, 0, 0, 4, 2], [0, 0, 0, 0, 3]]
)
pytestmark = pytest.mark.usefixtures("few_offered")
PUSHES = ("H_x", "H_y", "M_x", "M_y", "T")


def turned(loads, angle):
    """Loads, or motions, (n, 5) turned about the axis."""
    c, s = np.cos(angle), np.sin(angle)
    out = np.array(loads)
    for x, y in ((0, 1), (2, 3)):
        out[:, x], out[:, y] = c * loads[:, x] - s * loads[:, y], s * loads[:, x] + c * loads[:, y]
    return out


def batch(springs, loads, **given):
    return predict_batch(springs, **dict(zip(PUSHES, np.transpose(loads), strict=True)), **given)


def turns(found):
    return np.stack([found[name].values for name in SPACE_TURNS], axis=1)


def flat() -> xr.DataTree:
    """The same springs without a set in space."""
    tree = calibrated().copy(deep=True)
    del tree["space"]
    return tree


def test_rows_in_one_plane_stay_those_of_the_planar_springs_bit_for_bit() -> None:
    found, plane = batch(calibrated(), LOADS), batch(flat(), LOADS)
    assert found["in_space"].values.tolist() == [0, 0, 1, 1, 1] and "in_space" not in plane
    for name, each in plane.items():
        np.testing.assert_array_equal(found[name].values[:2], each.values[:2], err_msg=str(name))
    assert plane["answered"].values.tolist() == [1, 1, 0, 1, 1] and found["answered"].values.all()
    assert found["linear_twist"].values.tolist() == [0] * 5 and plane["linear_twist"].values.tolist() == [0, 0, 0, 1, 1]
    assert not any("least twist" in text for text in found.attrs["remarks"])
    without = predict_batch(calibrated(), H=LOADS[:1, 0], M=LOADS[:1, 3])
    assert found["u"].values[0] == without["u"].values[0]  # T = 0


@pytest.mark.parametrize("angle", np.radians([11.0, 37.0, 90.0, 200.0]))
def test_rows_turned_by_an_angle_have_the_turned_answer(angle) -> None:
    one, other = batch(calibrated(), LOADS[2:]), batch(calibrated(), turned(LOADS[2:], angle))
    size = np.linalg.norm(turns(one) * [1, 1, 4, 4, 4], axis=1).max()
    assert np.abs((turned(turns(one), angle) - turns(other)) * [1, 1, 4, 4, 4]).max() < 0.02 * size
    np.testing.assert_allclose(one["rotation"], other["rotation"], rtol=0.02, atol=1e-12)


def test_a_row_just_off_the_plane_differs_by_what_is_stated() -> None:
    """At the plane the answers differ by `plane_difference_pct`, and by nothing else."""
    near = LOADS[0] + [0.0, 0.0, 1.0, 0.0, 0.0]
    found = batch(calibrated(), [LOADS[0], near])
    assert found["in_space"].values.tolist() == [0, 1]
    scale = np.array([1.0, 1.0, space_paths.LENGTH, space_paths.LENGTH])
    plane, beside = scale * turns(found)[:, :4]
    apart = 100.0 * np.linalg.norm(beside - plane) / np.linalg.norm(plane)
    assert apart == pytest.approx(float(found["plane_difference_pct"].values[1]), abs=0.01)
    assert apart < 6.0 and np.isnan(found["plane_difference_pct"].values[0])


def test_a_row_off_the_plane_is_that_of_another_law() -> None:
    """Winkler springs of another code under a load that grows in proportion, solved step by step: within 8 %."""
    load, scale = 2.5 * LOADS[2], np.array([1e-3, 1e-3, 1e-4, 1e-4])
    way = np.zeros((1, 5))
    for share in np.linspace(0.0, 1.0, 13)[1:]:

        def missing(x, share=share, way=way):
            state = np.concatenate([way, [[*(x * scale), 0.0]]])
            return (space_paths.pushes(state)[-1, :4] - share * load[:4]) / 1e5

        way = np.concatenate([way, [[*(fsolve(missing, way[-1, :4] / scale) * scale), 0.0]]])
        assert np.abs(missing(way[-1, :4] / scale)).max() < 1e-3
    size, lean = np.array([1.0, 1.0, space_paths.LENGTH, space_paths.LENGTH]), way[-1, :4]
    found = turns(batch(calibrated(), [load]))[0, :4]
    assert np.linalg.norm((found - lean) * size) < 0.08 * np.linalg.norm(lean * size)
    assert abs(lean[1] * size[1]) > 0.05 * np.linalg.norm(lean * size)  # the moment across moves it across


def test_what_the_springs_do_not_cover_has_no_answer_or_a_mark() -> None:
    loads = np.array([LOADS[2], 6.0 * LOADS[2], 1e3 * LOADS[2], LOADS[3], LOADS[4]])
    found = batch(calibrated(), loads, V=np.array([2e6, 2e6, 2e6, 3e6, 1e9]))
    assert found["answered"].values.tolist() == [1, 0, 0, 1, 0]
    why = found["why_not"].values
    assert why[1] == SIDEWAYS and "equilibrium" in why[2] and why[4].startswith("V beyond")
    blank = ("u", "w", "rotation", *SPACE_TURNS)
    assert all(np.isnan(found[name].values[[1, 2, 4]]).all() for name in blank)
    assert [found[name].values[3] for name in ("off_load", "torsion_apart", "extrapolated")] == [1, 1, 0]
    wide = batch(calibrated(), loads[1:2], extrapolate=True)
    assert wide["answered"].values[0] == wide["extrapolated"].values[0] == 1 and wide["range_used"].values[0] > 1.0
    reach, twist = SpaceAnswers.of(calibrated()).checked
    assert twist == 0.0 and batch(calibrated(), LOADS[4:])["unchecked"].values[0] == 1  # T alone
    sizes = np.arange(1.0, 6.0, 0.5)
    some = batch(calibrated(), sizes[:, None] * LOADS[2])
    inside = some["answered"].values == 1
    np.testing.assert_array_equal(some["unchecked"].values[inside], (some["range_used"].values > reach)[inside])
    assert 0 < some["unchecked"].values[inside].sum() < inside.sum()


def test_a_twist_that_is_held_back_checks_torsion_alone() -> None:
    held = calibrated()["space/twist"].to_dataset(inherit=False).assign_attrs(role="held-back")
    groups = {node.path: node.to_dataset(inherit=False) for node in calibrated().subtree} | {"/space/check": held}
    tree = xr.DataTree.from_dict(groups, name="springs")
    found = batch(tree, LOADS[4:])
    assert found["unchecked"].values.tolist() == [0] and "check T " in found.attrs["space_errors"]
    assert SpaceAnswers.of(tree).checked[1] == pytest.approx(1.0)


def test_springs_without_a_twist_answer_torsion_as_before() -> None:
    tree = calibrated(twisted=False)
    found, plane = batch(tree, LOADS), batch(flat(), LOADS)
    assert found["in_space"].values.tolist() == [0, 0, 1, 0, 0]
    np.testing.assert_array_equal(found["rot_z"].values[3:], plane["rot_z"].values[3:])
    both = batch(tree, [LOADS[2] + LOADS[4]])
    assert both["answered"].values.tolist() == [0] and "across the plane of H" in both["why_not"].values[0]


def test_a_path_that_no_springs_answer_is_named() -> None:
    """A circle that calibrates nothing is missing in the table of a comparison, and said to be."""
    tree = flat()
    tree["space/circle"] = calibrated()["space/circle"].copy(deep=True)
    tree["space/circle"].attrs["role"] = "held-back"
    frame = compare(tree)
    assert "circle" not in set(frame["path"]) and "twist" not in frame.attrs["unanswered"]
    assert "path circle: not compared, no springs here answer it" in to_text(frame)
    assert "not compared" not in to_text(compare(calibrated()))


def test_other_sets_and_paths_answer_one_plane() -> None:
    for choice in ({"springs_kind": "fan"}, {"springs_kind": "full", "path": "ray_0"}):
        assert "in_space" not in batch(calibrated(), LOADS, **choice)


def test_the_command_answers_a_load_out_of_one_plane(tmp_path: Path) -> None:
    file = tmp_path / "springs.nc"
    save_springs(calibrated(), file)
    warnings.simplefilter("ignore", MacroWarning)
    loads = [f"--{name}={value:g} N" if name[0] == "H" else f"--{name}={value:g} N m"
             for name, value in zip(("Hx", "Hy", "Mx", "My"), LOADS[2], strict=False)]  # fmt: skip
    done = command("predict", file, *loads, "--json")
    assert done.code == 0, done.err
    document = json.loads(done.out)
    (state,), known = document["states"], batch(calibrated(), LOADS[2:3])
    assert [state[name] for name in SPACE_TURNS] == pytest.approx(turns(known)[0].tolist(), rel=1e-2, abs=1e-9)
    assert any("elbow H" in text for text in document["attributes"]["remarks"])
    shown = command("predict", file, *loads, "--T", "200 kN m")
    assert "torsion_apart" in shown.out
    for option, code, words in (("--strict", 2, "strict"), ("--stiffness", 2, "is that of one plane"),
                                ("--V=1 GN", 2, "V = 1000 MN: without vertical springs")):  # fmt: skip
        done = command("predict", file, *loads, "--T", "200 kN m", option)
        assert done.code == code and words in done.err
    far = command("predict", file, "--Hx=2 MN", "--Mx=-2 MN m")
    assert far.code == 2 and "beyond the range" in far.err
    marked = command("predict", file, "--Hx=2 MN", "--Mx=-2 MN m", "--extrapolate")
    assert marked.code != 0 or "extrapolated" in marked.out


def test_design_answers_rows_out_of_one_plane(tmp_path: Path) -> None:
    """With six motions, marks of their own, a bound beside them; rows in one plane are those of the planar springs."""
    file = tmp_path / "loads.csv"
    file.write_text(
        "load case,Fx [kN],Fy [kN],Fz [kN],Mx [kNm],My [kNm],Mz [kNm]\nplane,200,0,-2000,0,400,0\n"
        "across,200,0,-2000,-300,400,0\ntwisted,200,0,-2000,0,400,200\nfar,1200,0,-2000,-1800,2400,0\n"
        "other V,200,0,-3000,-300,400,0\n"
    )  # fmt: skip
    cases = read_load_cases(file)
    table, plane = (answer_cases(tree, cases, np.radians(0.5)).set_index("name") for tree in (calibrated(), flat()))
    assert {name: table.loc["plane", name] for name in plane} == pytest.approx(dict(plane.loc["plane"]), nan_ok=True)
    known = batch(calibrated(), LOADS[2:4], V=2e6)
    for row, name in enumerate(("across", "twisted")):
        columns = ["u_x_m", "u_y_m", "rot_x_rad", "rot_y_rad"]
        assert table.loc[name, columns].tolist() == turns(known)[row, :4].tolist()
        assert table.loc[name, "w_m"] == known["w"].values[row] != 0.0
        assert table.loc[name, "u_bound_m"] > table.loc[name, "u_m"] and "elbow H" in table.loc[name, "remarks"]
        assert np.isnan(table.loc[name, ["secant_H_u_N_per_m", "tangent_u_u_N_per_m"]].astype(float)).all()
    assert table.loc["twisted", "twist_rad"] == known["rot_z"].values[1]
    assert "the twist by a factor" in table.loc["twisted", "marks"] and "left out" not in table.loc["twisted", "marks"]
    apart = float(known["plane_difference_pct"].values[0])
    assert table.loc["across", "marks"] == (APART.format(apart) if apart > MOST_APART else "")
    assert (table.loc["far", "marks"], table.loc["far", "verdict"]) == (SIDEWAYS, "no answer")
    assert table.loc["other V", "marks"].startswith("V not covered") and table.loc["other V", "verdict"] != "ok"
    assert "left out" not in table.loc["other V", "marks"] and "no vertical path" in table.loc["other V", "marks"]


def test_a_load_off_the_plane_has_no_utilisation_of_its_part_in_the_plane(tmp_path: Path) -> None:
    """A small H and a large moment across: H alone uses next to nothing. What H and M alone exceed is exceeded."""
    file = tmp_path / "loads.csv"
    heads = "load case,Fx [kN],Fy [kN],Fz [kN],Mx [kNm],My [kNm],Mz [kNm]"
    file.write_text(f"{heads}\nsmall H,5,0,-2000,-400,0,0\nall in plane,5,0,-2000,0,400,0\nfar,1e5,0,-2000,-9,2e5,0\n"
                    "against,900,0,-2000,-9,-3000,0\ntwist,0,0,-2000,0,0,300\n")  # fmt: skip
    found = answer_cases(calibrated(), read_load_cases(file)).set_index("name")
    part, whole = found.loc["small H"], found.loc["all in plane"]
    assert part["answered"] == 1 and part["capacity_kind"] == NOT_KNOWN
    assert part[["utilisation", "H_capacity_N", "M_capacity_Nm"]].isna().all()
    assert part["utilisation_bound"] == pytest.approx(whole["utilisation"]) and part["u_m"] > 0.5 * whole["u_m"]
    assert found.loc["far", "utilisation"] > 1.0 and found.loc["far", "verdict"] != "ok"
    against, twist = found.loc["against"], found.loc["twist"]
    assert against["answered"] == 1 and against["utilisation_bound"] > 1.0 and "bound: utilisation" in against["marks"]
    assert twist["answered"] == 1 and np.isnan(twist["utilisation_bound"]) and GOVERNS in twist["marks"]
    assert "bound: " not in part["marks"]
    shown = table_of(found.reset_index(), brief=True)
    row = dict(zip(shown.columns, shown.rows[0], strict=True))
    assert float(row["across [kN m]"]) == -400.0 and row["utilisation"] == "-"
    assert float(row["utilisation bound"]) == pytest.approx(part["utilisation_bound"], rel=1e-2)


def test_w_out_of_one_plane_is_that_of_a_sequence_and_of_v_beside() -> None:
    """As in the plane: w of the lateral motion, and that of the vertical springs from their V to another one."""
    tree = calibrated().copy(deep=True)
    for end in (1e-4, -1e-2):
        base = tree["paths/ray_0"].to_dataset(inherit=False)
        tree[f"paths/{'down' if end > 0.0 else 'up'}"] = xr.DataTree(vertical_path(base, end))
    V = REST + float(down_curve(np.array([6e-5]))[0])
    found = batch(tree, np.tile(LOADS[2], (4, 1)), V=np.array([REST, REST, V, 9e6]))
    own = SpaceSprings.of(tree)
    np.testing.assert_allclose(found["w"][:2], float(own.answer("load", LOADS[2:3])["w"][0]), rtol=1e-9)
    assert float(found["w"][2] - found["w"][1]) == pytest.approx(6e-5, rel=1e-2)
    assert found["off_load"].values.tolist()[:3] == [0, 0, 1] and found["answered"].values.tolist() == [1, 1, 1, 0]
    near = REST + 0.7 * float(down_curve(np.array([1e-4]))[0])  # less than 10 % of the largest of the path above
    assert near < 1.2 * REST
    assert batch(tree, LOADS[2:3], V=near)["off_load"].values.tolist() == [1]
    with pytest.warns(MacroWarning):
        steps = sequence_in_space(tree, np.tile(LOADS[2], (2, 1)), V=np.array([V, REST]))
    assert float(steps["w"][1] - found["w"][1]) == pytest.approx(6e-5 - (V - REST) / own.K, rel=0.1)  # what stays
    with pytest.raises(BeyondSprings, match="is beyond the vertical springs"):
        sequence_in_space(tree, LOADS[2:3], V=2.38e6 + 1e6)
    for name in ("t", "V", "V_tip", "V_lid"):  # pull-out: no w carries more
        values = tree["paths/up"][name].values
        values[..., -6:] = values[..., -6:-5]
    pulled = batch(tree, LOADS[2:3], V=-2e6, extrapolate=True)
    assert pulled["why_not"].values.tolist() == ["no equilibrium"] and np.isnan(pulled["w"].values).all()


def test_the_set_in_space_is_built_for_rows_aside_alone(monkeypatch) -> None:
    monkeypatch.setattr("pysprings.macro.batch.answers_in_space", None)
    assert "in_space" not in batch(calibrated(), LOADS[:2])
    assert Springs.of(calibrated()).space and SPACE_LOADS == PUSHES


def test_predict_builds_the_set_in_space_once(tmp_path: Path, monkeypatch) -> None:
    file, built = tmp_path / "springs.nc", []
    save_springs(calibrated(), file)
    build = SpaceAnswers.of
    monkeypatch.setattr(SpaceAnswers, "of", lambda *given: built.append(given) or build(*given))
    warnings.simplefilter("ignore", MacroWarning)
    done = command("predict", file, "--Hx=200 kN", "--My=400 kN m", "--T=200 kN m")
    assert done.code == 0, done.err
    assert len(built) == 1


def test_report_and_workbook_have_the_errors_out_of_one_plane(tmp_path: Path) -> None:
    """On other slices there are no springs in space: the paths out of one plane belong to those of the mesh."""
    frame, tree = compare(calibrated()), calibrated()
    elbow = frame.set_index("path").loc["elbow"]
    file = tmp_path / "compare.csv"
    write_frame(frame, file)
    shown = compare_table(read_comparison(file))
    assert shown is not None and SPACE_NOTE in shown.note
    (row,) = [row for row in shown.rows if row[0] == "elbow"]
    assert list(row[1:3]) == ["held-back", "memory"] and f"{elbow['p_error_max_pct']:.2f}" in row
    words = [text for _, name, text in about_lines(tree, frame, {}) if name == "elbow, memory"]
    assert words[0].startswith(f"largest error against the full model: load {elbow['H_error_max_pct']:+.2f} %")
    assert (
        f"T/R over the largest load {elbow['T_error_max_pct']:+.2f} % (springs from paths out of one plane" in words[0]
    )
    assert "nan" not in words[0]
    assert "space" in tree.children and "space" not in reslice(tree, [0.0, 1.5, space_paths.LENGTH]).children
