# SPDX-License-Identifier: MIT
"""Driving the rigid body: motions, sequences, limits; tangent stiffness 3x3 and 6x6; the command that asks for them."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import xarray as xr

from pysprings import open_table
from pysprings.core import variables
from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.macro.batch import predict_batch
from pysprings.macro.predict import (
    MacroModel,
    MacroWarning,
    PredictionNotConverged,
    impose,
    model_of,
    predict,
    sequence,
)
from pysprings.macro.stiffness import stiffness, stiffness_six
from pysprings.results.tables.sequence import read_sequence
from pysprings.springs.checks import open_springs, save_springs
from tests.support import loaded, synthetic, written
from tests.support.closed_forms import bilinear_springs, linear_springs, linear_stiffness
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import make_springs
from tests.support.vertical import vertical_springs


def test_motions_and_loads_are_one_curve(bent):
    """The load of an imposed rotation brings that rotation back, and so do its displacement and both together."""
    turned = impose(bent, rotation=5e-4, arm=3.0)
    assert float(turned["M"]) == pytest.approx(3.0 * float(turned["H"]), rel=1e-9)
    for again in (
        predict(bent, H=float(turned["H"]), arm=3.0),
        impose(bent, u=float(turned["u"]), arm=3.0),
        impose(bent, u=float(turned["u"]), rotation=5e-4),
    ):
        for name in ("u", "rotation", "H", "M"):
            assert float(again[name]) == pytest.approx(float(turned[name]), rel=1e-7)
    moment = predict(bent, M=1e6)
    assert float(moment["H"]) == pytest.approx(0.0, abs=1e-3)
    assert float(moment["rotation"]) > 0.0 < float(moment["u"])


def test_a_sequence_goes_back_on_the_same_curve(bent):
    """Nonlinear elastic: the answer to a load does not depend on what came before, and says so."""
    loads = np.array([[4e5, -4e5], [8e5, -8e5], [4e5, -4e5], [0.0, 0.0], [-8e5, 8e5], [3e5, 5e5]])
    with pytest.warns(MacroWarning):
        answer = sequence(bent, loads)
    assert "without hysteresis" in " ".join(answer.attrs["remarks"])
    for step, (H, M) in enumerate(loads):
        alone = predict(bent, H=H, M=M) if H else answer.isel(step=3)
        for name in ("u", "rotation", "w"):
            assert float(answer[name][step]) == pytest.approx(float(alone[name]), rel=1e-7, abs=1e-12)
    assert float(answer["u"][3]) == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(UserInputError, match=r"targets: must have the shape \(n, 2\)"):
        sequence(bent, np.zeros(3))
    with pytest.raises(UserInputError, match="V: give one number, or one a row"):
        sequence(bent, loads, V=[2e6, 2e6])
    with pytest.raises(UserInputError, match="targets: not a finite number"):
        sequence(bent, np.array([[np.nan, 0.0]]))


@pytest.mark.parametrize(
    ("control", "targets", "off_path", "turned_back"),
    [
        ("load", [[1e5, -1e5], [4e5, -4e5], [4e5, -4e5], [8e5, -8e5]], [0, 0, 0, 0], [0, 0, 0, 0]),
        ("load", [[8e5, -8e5], [0.0, 0.0], [-8e5, 8e5], [0.0, 0.0]], [0, 0, 0, 0], [0, 1, 1, 1]),
        ("load", [[-4e5, 4e5], [-8e5, 8e5]], [0, 0], [0, 0]),
        ("load", [[4e5, 0.0], [4e5, -4e5], [8e5, 0.0]], [0, 1, 1], [0, 0, 0]),
        ("state", [[2e-3, 0.0], [5e-3, 0.0], [5e-3, -5e-5], [5e-3, -5e-4]], [0, 0, 1, 1], [0, 0, 0, 0]),
        ("displacement", [[1e-3, 9.0], [3e-3, 9.0], [2e-3, 9.0], [4e-3, 9.0]], [0, 0, 0, 0], [0, 0, 1, 1]),
        ("rotation", [[-1e-4, 0.0], [-2e-4, 0.0], [1e-4, 0.0]], [0, 0, 0], [0, 0, 1]),
    ],
)
def test_states_after_a_turn_are_marked_and_refused(bent, control, targets, off_path, turned_back):
    """Marks stay: soil that has yielded does not forget it where the sequence comes back to its line."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer = sequence(bent, np.array(targets), control=control, arm=1.0 if control == "displacement" else 0.0)
    assert answer["off_path"].values.tolist() == off_path
    assert answer["turned_back"].values.tolist() == turned_back
    assert list(variables.problems(answer, "prediction")) == []
    said = " ".join(str(each.message) for each in caught)
    assert ("left its first direction" in said) is (1 in off_path)
    assert ("turned back" in said) is (1 in turned_back)
    if 1 in off_path + turned_back:
        with pytest.raises(UserInputError, match=r"strict: .* come after the sequence"):
            sequence(bent, np.array(targets), control=control, strict=True)
    else:
        sequence(bent, np.array(targets), control=control, strict=True)


def test_a_vertical_load_that_comes_back_is_marked():
    tree = vertical_springs()
    with pytest.warns(MacroWarning, match=r"2 of 4 states \(from state 3 on\) come after the sequence turned back"):
        answer = sequence(tree, np.zeros((4, 2)), V=np.array([2.5e6, 3e6, 2.2e6, 4e6]))
    assert answer["turned_back"].values.tolist() == [0, 0, 1, 1]


@pytest.mark.slow
def test_the_command_shows_the_marks(fan_file, tmp_path):
    """The template's swipe: u held, the rotation turned back. In the table, in JSON, in a warning; strict refuses."""
    file = write(tmp_path / "s.csv", "u_m,rotation_rad", "0.0025,0", "0.005,0", "0.005,-0.001", "0.001,-0.001")
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        table = command("predict", fan_file, "--sequence", file)
        data = json.loads(command("predict", fan_file, "--sequence", file, "--json").out)
    assert table.code == 0
    ends = [line.split("  ")[-1] for line in table.out.splitlines()]
    assert (ends[0], ends[4:]) == ("marks", ["off_path", "off_path, turned_back"])
    assert "from state 3 on) come after the sequence left its first direction" in table.err
    assert [state["off_path"] for state in data["states"]] == [0, 0, 1, 1]
    assert [state["turned_back"] for state in data["states"]] == [0, 0, 0, 1]
    assert "turned back" in " ".join(data["attributes"]["warnings"])
    refused = command("predict", fan_file, "--sequence", file, "--strict")
    assert (refused.code, refused.out) == (2, "")
    straight = write(tmp_path / "t.csv", "H_N,arm_m", "2e5,2", "4e5,2")
    done = command("predict", fan_file, "--sequence", straight, "--strict")
    assert done.code == 0
    assert "marks" not in done.out


def test_vertical_load_by_row():
    springs = make_springs()
    with pytest.warns(MacroWarning, match=r"V = 2.7 MN is not that of path 'pull'"):
        answer = sequence(springs, np.array([[1e5, 0.0], [1e5, 0.0]]), V=np.array([2.0e6, 2.7e6]))
    assert float(answer["w"][1] - answer["w"][0]) == pytest.approx(0.7e6 / 3.5e9)
    np.testing.assert_allclose(answer["V"], [2.0e6, 2.7e6])


def test_largest_load_within_the_range_is_named():
    """A uniform p to 5e5 N/m over 4 m at 3 mm: 2 MN with its resultant at half depth, and no more."""
    springs = bilinear_springs()
    with pytest.warns(MacroWarning, match=r"beyond the range.*within their range they carry H = 2 MN with M = -4 MN m"):
        answer = predict(springs, H=3e6, M=-6e6, extrapolate=True)
    assert answer.attrs["limit_H_N"] == pytest.approx(2e6, rel=1e-5)
    assert answer.attrs["limit_M_Nm"] == pytest.approx(-4e6, rel=1e-5)
    assert answer.attrs["limit_u_m"] == pytest.approx(3e-3, rel=1e-5)
    for care in ({}, {"strict": True}):
        with pytest.raises(BeyondSprings, match=r"springs: beyond the range .*they carry H = 2 MN.*--extrapolate"):
            predict(springs, H=3e6, M=-6e6, **care)
    with pytest.raises(UserInputError, match="strict: refuses what extrapolate asks for"):
        predict(springs, H=3e6, M=-6e6, strict=True, extrapolate=True)
    assert "limit_H_N" not in predict(springs, H=1.9e6, M=-3.8e6).attrs


def test_the_limit_of_a_fan_is_where_its_range_ends(bent):
    with pytest.warns(MacroWarning, match="within their range they carry"):
        answer = predict(bent, H=5e6, arm=2.0, extrapolate=True)
    inside = predict(bent, H=answer.attrs["limit_H_N"], arm=2.0, strict=True)
    assert float(inside["range_used"]) == pytest.approx(1.0, rel=1e-5)


def test_capacity_of_flat_springs(tmp_path):
    """Perfectly plastic p = 1e5 N/m over 4 m: 400 kN at half depth can be carried; 500 kN cannot, by any motion."""
    rows = [f"{z},{y},{p}" for z in (0.5, 1.5, 2.5, 3.5) for y, p in ((1e-3, 1e5), (2e-3, 1e5), (1e-2, 1e5))]
    (tmp_path / "py.csv").write_text("\n".join(["depth_m,y_m,p_N_per_m", *rows]) + "\n")
    table = open_table(tmp_path / "py.csv", skirt_length=4.0)
    assert float(predict(table, H=3.9e5, arm=-2.0)["u"]) < 1e-3
    with pytest.raises(PredictionNotConverged, match=r"no equilibrium beyond H = (0.4|0.3999?|400|399.*) [Mk]N"):
        predict(table, H=5e5, arm=-2.0)
    batch = predict_batch(table, H=np.array([3.9e5, 5e5]), arm=-2.0)
    assert batch["converged"].values.tolist() == [1, 0]
    assert batch["why_not"].values.tolist() == ["", "no equilibrium"]
    assert np.isnan(batch["u"].values).tolist() == [False, True]
    assert float(batch["capacity_H"][1]) == pytest.approx(4e5, rel=1e-6)
    assert batch["capacity_kind"].values.tolist() == ["limit load of the springs"] * 2
    assert batch["utilisation"].values == pytest.approx([0.975, 1.25], rel=1e-6)


def test_stiffness_is_the_slope_of_the_prediction(bent):
    """3x3 at rest, at a load and at a motion: a small change of load over it gives the change of motion."""
    at_rest = model_of(linear_springs()).tangent_stiffness()
    np.testing.assert_allclose(at_rest[::2, ::2], linear_stiffness("full"), rtol=1e-12)
    k = stiffness(bent, H=6e5, arm=2.0)
    assert k.dims == ("dof", "dof_conjugate")
    a, b = (predict(bent, H=6e5 + d, M=1.2e6 - 3.0 * d) for d in (-10.0, 10.0))
    change = [float(b[name] - a[name]) for name in ("u", "rotation")]
    np.testing.assert_allclose(k.values[::2, ::2] @ change, [20.0, -60.0], rtol=1e-5)
    state = predict(bent, H=6e5, arm=2.0)
    moved = stiffness(bent, u=float(state["u"]), rotation=float(state["rotation"]))
    np.testing.assert_allclose(moved, k, rtol=1e-7)
    assert float(k.sel(dof="w", dof_conjugate="w")) == 3.5e9
    with pytest.raises(UserInputError, match="u: give a displacement"):
        impose(bent)
    with pytest.raises(UserInputError, match="H: give a load or a moment"):
        predict(bent)
    with pytest.raises(UserInputError, match="springs_kind: a model has its springs already"):
        predict(bent, H=1e5, springs_kind="py")


def test_six_by_six_does_not_know_the_direction_of_the_load(bent):
    """Turning the axes about the vertical leaves it as it is; the in-plane block is the 3x3 one."""
    six = stiffness_six(bent).values
    for angle in (0.5 * np.pi, 0.7):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.kron(np.eye(2), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        np.testing.assert_allclose(turn @ six @ turn.T, six, rtol=1e-9, atol=1e-6 * six.max())
    k = bent.tangent_stiffness().values
    np.testing.assert_allclose(six[np.ix_([0, 2, 4], [0, 2, 4])], k)
    symmetric = stiffness_six(bent, symmetric=True).values
    np.testing.assert_array_equal(symmetric, symmetric.T)
    assert (np.linalg.eigvalsh(six) > 0.0).all()
    assert six[5].tolist() == [0.0] * 5 + [synthetic.TORSION]
    assert "full model at rest" in stiffness_six(bent).attrs["torsion"]
    unknown = replace(bent, attrs={})
    assert (stiffness_six(unknown).values[5] == 0.0).all()
    assert "torsion (rot_z) is not known" in stiffness_six(unknown).attrs["torsion"]


@pytest.fixture(scope="module")
def one_path():
    """Springs of one pull, whose first step is softer than the initial stiffness that the file holds."""
    return make_springs()


def test_one_initial_stiffness_everywhere(one_path, tmp_path):
    """Spring file, Python (springs, model, any set), command and workbook: one value, the full model's."""
    full = one_path["stiffness_initial"].values
    file = save_springs(one_path, tmp_path / "springs.nc")
    own = model_of(one_path).tangent_stiffness().values
    assert abs(own[0, 0] / full[0, 0] - 1.0) > 0.01  # the springs' tangent at rest is another number
    block = np.ix_([0, 2, 4], [0, 2, 4])
    expected = full
    said = json.loads(command("predict", file, "--H", "100 kN", "--stiffness", "--json").out)
    written.workbook(tmp_path / "springs.xlsx", one_path)
    cells = openpyxl.load_workbook(tmp_path / "springs.xlsx")["stiffness 6x6"]["B3:G8"]
    found = [
        stiffness_six(open_springs(file)).values,
        stiffness_six(one_path).values,
        *(stiffness_six(MacroModel.from_springs(one_path, kind)).values for kind in ("full", "py")),
        np.array(said["stiffness_6x6"]["matrix"]),
        1e3 * np.array([[cell.value for cell in row] for row in cells]),
    ]
    for six in found:
        np.testing.assert_allclose(six[block], expected, rtol=1e-12, atol=1e-9 * full.max())
    assert said["stiffness_6x6"]["long_name"].startswith("initial stiffness of the full model")
    printed = command("predict", file, "--H", "100 kN", "--stiffness").out
    assert "initial stiffness of the full model at the lid centre, 6x6" in printed
    assert f"{full[0, 0] * 1e-6:.5g}" in printed.split("initial stiffness of the full model")[1]


def test_a_table_has_the_stiffness_of_its_first_steps_and_says_so(tmp_path):
    file, _ = written.tables(tmp_path, vertical_springs())
    six = stiffness_six(open_table(file))
    assert six.attrs["long_name"].startswith("stiffness of the first recorded steps of the table")
    printed = command("predict", file, "--V", "2.1 MN", "--stiffness").out
    assert "stiffness of the first recorded steps of the table at the lid centre, 6x6" in printed
    assert "initial stiffness" not in printed


def test_batch_is_predict_case_by_case(bent):
    rng = np.random.default_rng(1)
    H, arm = rng.uniform(-9e5, 9e5, 40), rng.uniform(-1.0, 30.0, 40)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        batch = predict_batch(bent, H=H, arm=arm, extrapolate=True)
        one = [predict(bent, H=h, arm=a, extrapolate=True) for h, a in zip(H, arm, strict=True)]
    assert batch["u"].dims == ("case",)
    for name in ("u", "rotation", "w", "H", "M", "V"):
        expected = np.array([float(answer[name]) for answer in one])
        np.testing.assert_allclose(batch[name], expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
    assert batch["extrapolated"].values.tolist() == [int(answer["extrapolated"]) for answer in one]
    assert batch["converged"].values.all()
    inside = predict_batch(bent, H=H, arm=arm)
    assert (inside["answered"].values == 1 - batch["extrapolated"].values).all()
    assert 0 < inside["answered"].values.sum() < H.size
    for k in np.flatnonzero(inside["answered"].values):
        for name in ("u", "utilisation", "stiffness"):
            np.testing.assert_allclose(inside[name][k], one[k][name], rtol=1e-7)
        assert float(inside["capacity_H"][k]) == pytest.approx(one[k].attrs["capacity_H_N"], rel=1e-7)
    assert np.isnan(inside["u"].values[inside["answered"].values == 0]).all()
    np.testing.assert_allclose(predict_batch(bent, H=1e5, M=np.array([0.0, 1e5]))["M"], [0.0, 1e5], atol=1e-3)


def write(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("lines", "control", "targets", "arm", "V"),
    [
        (("H_N,M_Nm,V_N", "1,2,3", "4,5,6"), "load", [[1, 2], [4, 5]], 0.0, [3, 6]),
        (("H_N,arm_m", "1,2", "3,4"), "load", [[1, 2], [3, 12]], 0.0, None),
        (("H_N", "1"), "load", [[1, 0]], 0.0, None),
        (("M_Nm", "1"), "load", [[0, 1]], 0.0, None),
        (("u_m,rotation_rad", "1,2"), "state", [[1, 2]], 0.0, None),
        (("u_m,arm_m", "1,8", "2,8"), "displacement", [[1, 0], [2, 0]], 8.0, None),
        (("u_m,arm_m", "0,0", "2,8"), "displacement", [[0, 0], [2, 0]], 8.0, None),
        (("rotation_rad", "1"), "rotation", [[1, 0]], 0.0, None),
        (("H [kN];arm_m;V [t]", "1,5;2;0"), "load", [[1500, 3000]], 0.0, [0.0]),
        (("H (MN);M [kN m]", "-1;2,25"), "load", [[-1e6, 2250]], 0.0, None),
    ],
)
def test_sequence_files(tmp_path, lines, control, targets, arm, V):
    read = read_sequence(write(tmp_path / "s.csv", *lines))
    assert (read.control, read.targets.tolist(), read.arm) == (control, targets, arm)
    assert (None if read.V is None else read.V.tolist()) == V
    assert read.time is None


def test_a_sequence_has_times(tmp_path):
    for head in ("time [min]", "t [min]"):  # T is the torsion
        assert read_sequence(write(tmp_path / "s.csv", f"H_N,{head}", "1,0.5", "2,2")).time.tolist() == [30.0, 120.0]


def test_a_row_at_rest_at_0_s_has_its_vertical_load(tmp_path):
    """It was left out with its V: springs at the V of the next row answered, without a mark."""
    rows, springs = ("0,0,2e6", "2e5,1e6,3.5e6", "-1e5,0,3.5e6"), loaded.springs()
    timed = (f"{10 * k},{row}" for k, row in enumerate(rows))
    answers = []
    for lines in (("H_N,M_Nm,V_N", *rows), ("time_s,H_N,M_Nm,V_N", *timed)):
        read = read_sequence(write(tmp_path / "s.csv", *lines))
        with pytest.warns(MacroWarning, match="2 of 3 states are under another V"):
            answers.append(sequence(springs, read.targets, V=read.V, time=read.time, springs_kind="memory"))
    xr.testing.assert_allclose(answers[0], answers[1].drop_vars("time"))


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (("u_kN", "1"), '1: "u_kN": wrong unit "kN": expected a length such as \'u [mm]\''),
        (("u", "1"), "1: \"u\": no unit: write 'u [mm]'"),
        (("H_N,u_m", "1,1"), "1: None: expected either loads or motions"),
        (("V_N", "1"), "1: None: expected either loads or motions"),
        (("M_Nm,arm_m", "1,1"), "1: arm_m: one column too many"),
        (("u_m,arm_m", "1,1", "2,2"), "1: arm_m: a motion is followed at one load height"),
        (("H_N,M_Nm", "1,", "x,1"), "2: M_Nm: blank"),
        (("H_N",), "1: None: no rows"),
        (("H_N,H_N", "1,1"), '1: "H_N": column stands 2 times'),
        (("H_N,what", "1,1"), '1: "what": unknown column'),
        (("H_N,time_s", "1,1", "2,1"), "3: time_s: must be later than the row before"),
        (("H_N,time_s", "1,0"), "2: time_s: must be later than the row before, and than 0 s"),
    ],
)
def test_sequence_files_refused(tmp_path, lines, found):
    with pytest.raises(UserInputError) as caught:
        read_sequence(write(tmp_path / "s.csv", *lines))
    first = caught.value.problems[0]
    assert f"{first.line}: {first.key}: {first.message}".startswith(found)


@pytest.fixture(scope="module")
def fan_file(tmp_path_factory):
    return save_springs(fan_springs(potential), tmp_path_factory.mktemp("fan") / "springs.nc")


def test_command_motions_sequence_and_stiffness(fan_file, tmp_path):
    file = write(tmp_path / "s.csv", "H_N,arm_m", "2e5,2", "4e5,2", "0,2")
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # it turns back
        done = command("predict", fan_file, "--sequence", file, "--stiffness")
    assert done.code == 0
    assert len(done.out.split("tangent stiffness of the springs at the state")[0].strip().splitlines()) == 5
    assert "step" in done.out.split("stiffness of the springs at the state")[1]
    assert "note: torsion (rot_z) is that of the full model at rest" in done.err
    assert "without hysteresis" in done.err
    data = json.loads(
        command("predict", fan_file, "--u", "1 mm", "--rotation", "0.1 mrad", "--stiffness", "--json").out
    )
    (state,) = data["states"]
    assert (state["u"], state["rotation"]) == pytest.approx((1e-3, 1e-4))
    assert np.array(data["stiffness"]["matrices"]).shape == (1, 3, 3)
    assert data["stiffness_6x6"]["dofs"] == ["u_x", "u_y", "w", "rot_x", "rot_y", "rot_z"]
    assert "torsion" in data["stiffness_6x6"]
    assert "stiffness" not in json.loads(command("predict", fan_file, "--M", "1 MN m", "--json").out)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--u", "1 mm", "--H", "1 MN"], "--u: give either this or --H: a load is the answer to a motion"),
        (
            ["--u", "1 mm", "--rotation", "1 mrad", "--arm", "1 m"],
            "--arm: with --u and --rotation both loads are answers",
        ),
        (["--arm", "1 m", "--M", "1 MN m"], "--M: give either --arm or --M"),
        (["--arm", "1 m"], "--H: missing"),
        (["--sequence", "x.csv", "--H", "1 MN"], "--H: give either this or --sequence"),
        (["--sequence", "x.csv"], "x.csv: no such file"),
    ],
)
def test_command_refuses(fan_file, args, message):
    done = command("predict", fan_file, *args)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"fatal: user input: {message}")


def test_command_names_the_capacity_and_strict_refuses(fan_file):
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        done = command("predict", fan_file, "--H", "9 MN", "--extrapolate")
    assert done.code == 0
    assert "within their range they carry H = " in done.err
    refused = command("predict", fan_file, "--H", "9 MN")
    assert (refused.code, refused.out, len(refused.err.splitlines())) == (2, "", 1)
    assert "within their range they carry H = " in refused.err
    assert "path 'ray_2' reached its aim" in refused.err
    assert command("predict", fan_file, "--H", "9 MN", "--strict").code == 2
