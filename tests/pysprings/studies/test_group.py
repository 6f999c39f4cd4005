# SPDX-License-Identifier: MIT
"""Load cases of a group of caissons under one frame, beside solutions that share nothing with the iteration."""

from pathlib import Path

import numpy as np
import pytest

from pysprings import predict_batch
from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.core.text import number
from pysprings.springs.checks import save_springs
from pysprings.studies.group import Group, answer_group, read_group
from tests.support.commands import command
from tests.support.fans import fan_springs, linear, potential
from tests.support.vertical import K as K_VERTICAL, vertical_springs

SQUARE = Group(("A", "B", "C", "D"), np.array([[8.0, 8.0], [-8.0, 8.0], [-8.0, -8.0], [8.0, -8.0]]))
TRIANGLE = Group(("A", "B", "C"), np.array([[10.0, 0.0], [-5.0, 8.66], [-5.0, -8.66]]))


def cases_of(folder: Path, *rows: str):
    file = folder / "cases.csv"
    file.write_text("name,H [kN],M [kN m],V [kN],direction [deg],T [kN m]\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return read_load_cases(file)


@pytest.fixture(scope="module")
def elastic():
    return fan_springs(linear)


@pytest.fixture(scope="module")
def bending():
    return fan_springs(potential)


def rest_load(springs) -> float:
    return float(predict_batch(springs, H=0.0, M=0.0)["V"].values[0])


@pytest.mark.parametrize("joint", [np.inf, 3e9])
@pytest.mark.parametrize("direction", [0.0, 30.0])
def test_linear_springs_give_the_stiffness_matrix_of_the_frame(elastic, tmp_path, joint, direction) -> None:
    """(u, w, rotation) of the frame from sums of single stiffnesses, the joint in series with each rotation."""
    V = 4.0 * rest_load(elastic)
    cases = cases_of(tmp_path, f"a,400,1200,{1.01e-3 * V},{direction},0")
    found = answer_group(elastic, cases, Group(SQUARE.name, SQUARE.at, joint))
    K = elastic["stiffness_initial"].values
    softer = np.linalg.inv(K) + np.diag([0.0, 0.0, 1.0 / joint])
    K = np.linalg.inv(softer)
    whole = 4.0 * K
    whole[2, 2] += K[1, 1] * 4.0 * 8.0**2  # sum of x^2 of a square is the same in all directions
    q = np.linalg.solve(whole, [400e3, 0.01 * V, 1200e3])
    row = found.iloc[0]
    w0 = float(predict_batch(elastic, H=row["H_N"], M=row["M_Nm"])["w"].values[0])  # settlement under H and M alone
    moved = [float(row["group_u_m"]), float(row["group_w_m"]) - w0, float(row["group_rotation_rad"])]
    assert moved == pytest.approx(q.tolist(), rel=1e-4)
    assert found["group_roll_rad"].to_numpy() == pytest.approx(0.0, abs=1e-9)
    assert found["tilt_deg"].to_numpy() == pytest.approx(np.degrees(q[2]), rel=1e-4)


@pytest.mark.parametrize("direction", [0.0, 15.0, 180.0])
def test_caissons_move_as_the_frame_and_carry_the_case(tmp_path, direction) -> None:
    """Push and pull soften differently: each caisson, answered alone, moves as one rigid body with the others."""
    springs = vertical_springs(heavier=(4e6,))
    found = answer_group(springs, cases_of(tmp_path, f"storm,60,20000,6000,{direction},0"), TRIANGLE)
    assert (found["answered"] == 1).all()
    H, M, V = (found[name].to_numpy() for name in ("H_N", "M_Nm", "V_N"))
    alone = predict_batch(springs, H=H, M=M, V=V)
    softer = alone["stiffness"].values[:, 1, 1] / K_VERTICAL
    assert softer.min() < 0.7 and np.ptp(softer) > 0.2
    c, s = np.cos(np.radians(direction)), np.sin(np.radians(direction))
    x, y = TRIANGLE.at @ [c, s], TRIANGLE.at @ [-s, c]
    assert alone["u"].values == pytest.approx(found["group_u_m"].to_numpy(), rel=1e-4, abs=1e-9)
    assert alone["rotation"].values == pytest.approx(found["group_rotation_rad"].to_numpy(), rel=1e-4)
    plane = np.linalg.solve(np.stack([np.ones(3), x, -y], axis=1), alone["w"].values)  # through the three lids
    moved = [found[f"group_{name}"][0] for name in ("w_m", "rotation_rad", "roll_rad")]
    assert plane == pytest.approx(moved, rel=1e-4, abs=1e-8)
    assert (abs(moved[2]) > 1e-6) == (direction == 15.0)  # but for its axis of symmetry it rolls
    assert [H.sum(), V.sum(), M.sum() + x @ V, -y @ V] == pytest.approx([60e3, 6e6, 20e6, 0.0], rel=1e-5, abs=50.0)


def test_a_torsion_is_carried_across_the_arms(elastic, tmp_path) -> None:
    V = 4e-3 * rest_load(elastic)
    found = answer_group(elastic, cases_of(tmp_path, f"a,400,0,{V},0,3200"), SQUARE)
    way = np.radians(found["direction_deg"].to_numpy())
    force = found["H_N"].to_numpy()[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)
    assert force.sum(axis=0) == pytest.approx([400e3, 0.0], abs=1.0)
    turning = SQUARE.at[:, 0] * force[:, 1] - SQUARE.at[:, 1] * force[:, 0]
    assert turning.sum() == pytest.approx(3200e3, rel=1e-9)


def test_places_in_cm_leave_no_moment_across(elastic, tmp_path) -> None:
    """The arm of B is square to H: its share of the torsion acts along H."""
    cases = cases_of(tmp_path, f"a,400,4000,{4e-3 * rest_load(elastic)},30,1600")
    across = np.nan_to_num(answer_group(elastic, cases, TRIANGLE)["across_Nm"].to_numpy())
    assert across[1] == 0.0 and (np.abs(across[[0, 2]]) > 1e3).all()


def test_six_components_of_the_load_are_carried(tmp_path) -> None:
    """About the origin, whose centroid the caissons do not have: with a blank V, that of the springs at each."""
    springs, off = vertical_springs(heavier=(4e6,)), Group(TRIANGLE.name, TRIANGLE.at + [0.5, -0.3])
    (tmp_path / "cases.csv").write_text(
        "name,Fx [kN],Fy [kN],Mx [kN m],My [kN m],Mz [kN m]\na,50,20,-6000,9000,400\n", encoding="utf-8"
    )
    found = answer_group(springs, read_load_cases(tmp_path / "cases.csv"), off)
    way, H, M, V = (found[name].to_numpy() for name in ("direction_deg", "H_N", "M_Nm", "V_N"))
    c, s = np.cos(np.radians(way)), np.sin(np.radians(way))
    across = np.nan_to_num(found["across_Nm"].to_numpy())  # about the direction of H
    M_x, M_y = c * across - s * M, s * across + c * M
    x, y = off.at.T
    sums = [H @ c, H @ s, (M_x - y * V).sum(), (M_y + x * V).sum(), (x * H * s - y * H * c).sum(), V.sum()]
    still = rest_load(springs)
    whole = [50e3, 20e3, -6e6 - y.sum() * still, 9e6 + x.sum() * still, 400e3, 3 * still]
    assert sums == pytest.approx(whole, rel=1e-4, abs=200.0)


def test_the_tilt_that_counts_is_that_of_the_frame(elastic, tmp_path) -> None:
    """Soft joints: the caissons lean the other way by less than is tolerated, the frame by more."""
    case = cases_of(tmp_path, f"a,10,8000,{4e-3 * rest_load(elastic)},0,0")
    found = answer_group(elastic, case, Group(SQUARE.name, SQUARE.at, 1e6), tilt=5e-6)
    assert (found["rotation_rad"].abs() < 5e-6).all() and (found["group_rotation_rad"].abs() > 5e-6).all()
    assert set(found["verdict"]) == {"tilt exceeded"} and (found["tilt_used"] > 1.0).all()


def test_a_tilt_of_the_frame_that_the_error_of_the_mesh_turns_is_marked(tmp_path) -> None:
    """Soft joints: the caissons lean less than the frame, whose tilt grows with H and M as its springs are linear."""
    springs = fan_springs(linear)
    for path in springs["paths"].children.values():
        path.attrs["mesh_error_pct"] = 5.0
    V, group = 4e-3 * rest_load(springs), Group(SQUARE.name, SQUARE.at, 1e6)
    found = answer_group(springs, cases_of(tmp_path, f"a,10,8000,{V},0,0"), group)
    turn = found["group_tilt_deg"][0]
    words = f"at loads 5 % larger, the error of the mesh: tilt {number(1.05 * turn, 3)} deg, not tolerated"
    for tilt, marked in ((1.04 * turn, True), (1.06 * turn, False)):
        marks = answer_group(springs, cases_of(tmp_path, f"a,10,8000,{V},0,0"), group, np.radians(tilt))["marks"]
        assert (marks.str.endswith(words) == marked).all() and (marks.str.contains("mesh") == marked).all()


def test_a_force_beside_the_middle_of_the_caissons_is_carried_as_a_torsion(elastic, tmp_path) -> None:
    """H beside the middle by y without T is H at the middle with T = H y."""
    V, frames, rows = 4e-3 * rest_load(elastic), ((SQUARE.at, 0.0), (SQUARE.at + [0.0, 2.0], 2.0)), []
    for at, y in frames:  # of the middle
        (tmp_path / "cases.csv").write_text(
            f"name,Fx [kN],Fy [kN],Fz [kN],Mx [kN m],My [kN m],Mz [kN m]\na,400,0,{-V},{-y * V},0,{800 - 400 * y}\n",
            encoding="utf-8",
        )
        rows.append(answer_group(elastic, read_load_cases(tmp_path / "cases.csv"), Group(SQUARE.name, at)))
    for name in ("H_N", "direction_deg", "u_m"):
        assert rows[0][name].tolist() == pytest.approx(rows[1][name].tolist(), rel=1e-4), name


def test_a_case_beyond_the_springs_has_no_answer(bending, tmp_path) -> None:
    V = 3e-3 * rest_load(bending)
    found = answer_group(bending, cases_of(tmp_path, f"a,300,600,{V},0,0", f"b,90000,0,{V},0,0"), TRIANGLE)
    assert found["answered"].tolist() == [1, 1, 1, 0, 0, 0]
    beyond = found[3:]
    assert beyond[["u_m", "group_u_m", "tilt_used", "utilisation"]].isna().all(axis=None)
    assert beyond["marks"].str.contains(r"in equilibrium up to \d+ % of the case, then [ABC]: ").all()
    assert set(beyond["verdict"]) == {"no answer"} and beyond["V_N"].isna().all()
    assert not found["remarks"].str.contains("M turns against H").any()


def test_interaction_that_is_left_out_is_that_of_point_forces() -> None:
    """Two discs of 8 m, 24 m apart: D/(pi s), and 2 D/(pi s (2 - nu)), nu 0.5."""
    down, along = Group(("A", "B"), np.array([[0.0, 0.0], [24.0, 0.0]])).interaction(8.0)
    assert (down, along) == pytest.approx((1.0 / (3.0 * np.pi), 2.0 / (3.0 * np.pi * 1.5)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bucket,x [m]\nA,1\n", "no column y [m]"),
        ("bucket,x [m],y [m]\nA,1,2\nB,1,2\n", "two caissons at one place"),
        ("bucket,x [m],y [m]\nA,1,2\nB,,2\n", "a position has x and y"),
        ("bucket,x [m],y [m]\nA,1,2\nB,11,2\n", "3 caissons or more"),
        ("bucket,x [m],y [m]\nA,1,2\nB,11,2\nB,11,12\n", '"B" is the name of another caisson'),
        ("bucket,x [m],y [m]\nA,0,0\nB,11,1\nC,22,0\n", "stand on a line"),
    ],
)
def test_positions_that_are_refused(tmp_path, text, words) -> None:
    (tmp_path / "group.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UserInputError) as refused:
        read_group(tmp_path / "group.csv")
    assert words in str(refused.value)


def test_caissons_that_overlap_are_refused(elastic, tmp_path) -> None:
    near = Group(TRIANGLE.name, 0.1 * TRIANGLE.at)
    with pytest.raises(UserInputError, match="overlap"):
        answer_group(elastic, cases_of(tmp_path, "a,1,0,300,0,0"), near)


def test_the_command_has_a_row_a_caisson(bending, tmp_path) -> None:
    save_springs(bending, tmp_path / "springs.nc")
    cases_of(tmp_path, f"storm,300,900,{3e-3 * rest_load(bending)},0,0")
    (tmp_path / "group.csv").write_text("leg,x [m],y [m]\nA,10,0\nB,-5,8.66\nC,-5,-8.66\n", encoding="utf-8")
    words = ("design", tmp_path / "springs.nc", tmp_path / "cases.csv", "--group", tmp_path / "group.csv")
    done = command(*map(str, words), "--joint", "3 GN m/rad", "--tilt", "0.25 deg")
    assert done.code == 0, done.err
    assert all(f"storm, {leg}" in done.out for leg in "ABC")
    assert "3 caissons under a rigid frame, joints of 3000 MN m/rad" in done.out.replace("\n", " ")
    wrong = command("design", str(tmp_path / "springs.nc"), str(tmp_path / "cases.csv"), "--joint", "3 GN m/rad")
    assert wrong.code == 2 and "--joint: is the stiffness" in wrong.err
