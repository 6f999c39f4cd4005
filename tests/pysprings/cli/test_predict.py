# SPDX-License-Identifier: MIT
"""`predict` on synthetic springs: options, units, refusals, marks."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from pysprings.cli.predictions import print_prediction
from pysprings.macro import predict
from pysprings.springs.checks import open_springs, save_springs
from tests.support import synthetic
from tests.support.commands import command
from tests.support.fans import RHO, fan_springs


def states(*args: object) -> list[dict[str, float]]:
    """States that a prediction prints as JSON."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", predict.MacroWarning)
        done = command("predict", *args, "--json")
    assert done.code == 0, done.err
    found: list[dict[str, float]] = json.loads(done.out)["states"]
    return found


@pytest.mark.parametrize(
    ("args", "question"),
    [
        (["--H", "200 kN", "--arm", "8 m"], {"H": 2e5, "arm": 8.0}),
        (["--H", "-0.2 MN", "--M", "300 kN m", "--springs", "py"], {"H": -2e5, "M": 3e5, "springs_kind": "py"}),
        (["--H", "100 kN", "--V", "500 kN", "--path", "pull"], {"H": 1e5, "V": 5e5, "path": "pull"}),
    ],
)
def test_a_load_is_passed_on_in_si(springs_file: Path, args: list[str], question: dict[str, object]) -> None:
    (state,) = states(springs_file, *args)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", predict.MacroWarning)
        answer = predict.predict(open_springs(springs_file), **question)
    for name in ("u", "w", "rotation", "H", "V", "M"):
        assert state[name] == pytest.approx(float(answer[name]), rel=1e-12, abs=1e-15)


def test_motions_are_passed_on_in_si(springs_file: Path) -> None:
    curve = states(springs_file.parent, "--u-max", "4 mm", "--arm", "-2 m", "--points", "5", "--extrapolate")
    assert [row["u"] for row in curve] == pytest.approx([0, 1e-3, 2e-3, 3e-3, 4e-3])
    assert curve[-1]["M"] == pytest.approx(-2.0 * curve[-1]["H"])
    (both,) = states(springs_file, "--u", "1 mm", "--rotation", "0.2 mrad")
    assert (both["u"], both["rotation"]) == pytest.approx((1e-3, 2e-4))
    units = json.loads(command("predict", springs_file, "--H", "100 kN", "--json").out)["units"]
    assert (units["u"], units["rotation"], units["M"]) == ("m", "radian", "N m")


def test_a_table_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    import xarray as xr

    values = {"u": [0.0, 1e-3], "w": [0.0, -1e-5], "rotation": [0.0, -1e-4], "H": [0.0, 2e6], "V": [1e6, 1e6]}
    values |= {"M": [1e-4, -16e6], "extrapolated": [0, 1]}
    print_prediction(xr.Dataset({name: ("step", np.array(value)) for name, value in values.items()}))
    assert capsys.readouterr().out == (
        "u [mm]  w [mm]  rotation [deg]  H [kN]  V [kN]  M [kN m]  marks\n"
        "------  ------  --------------  ------  ------  --------  ------------\n"
        "     0       0               0       0    1000         0\n"
        "     1   -0.01      -0.0057296    2000    1000   -16,000  extrapolated\n"
    )


@pytest.mark.parametrize(
    ("args", "messages"),
    [
        ([], ['--H: missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve']),
        (["--H", "2"], ['--H: expected a quantity with unit such as "2 MN", got "2"']),
        (
            ["--H", "2 MPa", "--arm", "3"],
            [
                '--H: "2 MPa" is a pressure or stress; expected a force such as "2 MN"',
                '--arm: expected a quantity with unit such as "8 m", got "3"',
            ],
        ),
        (
            ["--H", "5 mN", "--M", "-20 mN m"],
            ['--H: "5 mN" is 0.005 N: m is milli, M is mega', '--M: "-20 mN m" is -0.02 N m: m is milli, M is mega'],
        ),
        (["--H", "2 MN", "--M", "3 MN"], ['--M: "3 MN" is a force; expected a moment such as "3 MN m"']),
        (
            ["--H", "2 MN", "--u-max", "5 mm"],
            ["--u-max: give either --H or --u-max: the load is an answer of the curve"],
        ),
        (["--H", "2 MN", "--arm", "1 m", "--M", "1 MN m"], ["--M: give either --arm or --M, not both (M = H*arm)"]),
        (["--u-max", "5 mm", "--M", "1 MN m"], ["--M: a curve needs the height of the load: give --arm instead"]),
        (["--u", "1 mm", "--H", "1 MN"], ["--u: give either this or --H: a load is the answer to a motion"]),
        (
            ["--u", "1 mm", "--rotation", "1 mrad", "--M", "1 MN m"],
            ["--rotation: give either this or --M: a load is the answer to a motion"],
        ),
        (["--u", "1 mm", "--u-max", "2 mm"], ["--u: give either this or --u-max: a load is the answer to a motion"]),
        (
            ["--u", "1 mm", "--rotation", "1 mrad", "--arm", "1 m"],
            ["--arm: with --u and --rotation both loads are answers: leave --arm out"],
        ),
        (["--arm", "1 m"], ['--H: missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve']),
        (
            ["--V", "1 MN", "--arm", "1 m"],
            ['--H: missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve'],
        ),
        (["--rate", "-1 mm/s", "--H", "1 MN"], ["--rate: -1 mm/s is not positive"]),
        (["--rate", "0 mm/s", "--H", "1 MN"], ["--rate: 0 mm/s is not positive"]),
        (
            ["--sequence", "x.csv", "--H", "1 MN", "--u", "1 mm"],
            ["--H: give either this or --sequence: the file holds loads, motions and their height"],
        ),
        (["--H", "1 MN", "--path", "nope"], ["--path: no path 'nope'; the springs have: pull"]),
    ],
)
def test_predict_refuses(springs_file: Path, args: list[str], messages: list[str]) -> None:
    done = command("predict", springs_file, *args)
    assert (done.code, done.out) == (2, "")
    assert done.err == "".join(f"fatal: user input: {message}\n" for message in messages)


TABLE = "depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m\n" + "".join(
    f"{z},{z - 1},{z + 1},{y},{1e8 * y}\n" for z in (1.0, 3.0) for y in (0.0, 1e-3, 2e-3)
)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--rate", "1 mm/s"], "--rate: a table has no rates"),
        (["--path", "other"], "py.csv: path: no path 'other'; the table has: table"),
        (
            ["--springs", "fan"],
            "springs: the set 'fan' needs the companions of p: mtheta, base, lid missing "
            "(give zeros if there are none, or ask for the springs 'py')",
        ),
    ],
)
def test_what_a_table_does_not_have_is_refused(args: list[str], message: str) -> None:
    Path("py.csv").write_text(TABLE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", predict.MacroWarning)
        assert command("predict", "py.csv", "--H", "1 kN", "--arm", "1 m").code == 0
        done = command("predict", "py.csv", "--H", "1 kN", "--arm", "1 m", *args)
    assert (done.code, done.out, done.err) == (2, "", f"fatal: user input: {message}\n")


def test_a_skirt_length_is_for_tables(springs_file: Path) -> None:
    done = command("predict", springs_file, "--H", "1 kN", "--skirt-length", "4 m")
    assert (done.code, done.out) == (2, "")
    assert done.err.endswith("--skirt-length: is for tables (.csv, .xlsx); a spring file has it\n")


def test_predict_strict_refuses_what_the_springs_do_not_cover(springs_file: Path) -> None:
    done = command("predict", springs_file, "--H", "9e9 N", "--strict")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("fatal: user input: springs: beyond the range of path 'pull'")
    assert "--extrapolate" in done.err
    assert len(done.err.splitlines()) == 1
    assert command("predict", springs_file, "--u-max", "2 mm", "--strict").code == 0


def test_fan_is_the_default_where_there_is_one(springs_file: Path) -> None:
    rays = (synthetic.Path("push", "translation"), synthetic.Path("turn", "rotation", 1e-3))
    fan = save_springs(synthetic.make_springs(rays), Path("fan/springs.nc"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # two rays are 90 degrees apart
        data = json.loads(command("predict", fan, "--H", "1 MN", "--json").out)
        assert data["attributes"]["springs"] == "fan"
        one = json.loads(command("predict", fan, "--H", "1 MN", "--springs", "full", "--json").out)
        assert one["attributes"]["path"] == "push"
    strict = command("predict", fan, "--H", "1 MN", "--strict")
    assert (strict.code, strict.out) == (2, "")
    assert "between calibration paths 90 degrees apart" in strict.err
    assert len(strict.err.splitlines()) == 1
    rows = json.loads(command("compare", fan, "--springs", "fan", "--json").out)["rows"]
    assert [(row["path"], row["springs"]) for row in rows] == [("push", "fan"), ("turn", "fan")]
    none = command("predict", springs_file, "--H", "1 MN", "--springs", "fan")
    assert (none.code, len(none.err.splitlines())) == (2, 1)
    assert "a fan needs at least 2 calibration paths" in none.err
    there = command("compare", springs_file, "--springs", "fan")
    assert (there.code, there.err) == (2, "fatal: user input: --springs: no springs 'fan' here; there are: py, full\n")


def test_predict_beyond_the_springs_warns(springs_file: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        done = command("predict", springs_file, "--H", "9e9 N", "--extrapolate")
    assert done.code == 0
    assert done.err.startswith("warning: beyond ")
    assert "beyond the range of path 'pull'" in done.err


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("M", "remarked"), [("30 kN m", False), ("-30 kN m", True)])
def test_a_moment_against_the_force_has_a_remark(springs_file: Path, M: str, remarked: bool) -> None:
    done = command("predict", springs_file, "--H", "10 kN", "--M", M, "--extrapolate")
    assert done.code == 0 and ("note: M turns against H, as of a load 3 m below mudline" in done.err) is remarked


def test_messages_name_the_option_that_was_typed(springs_file: Path) -> None:
    """Not the argument of Python; an argument without dashes stays as it is."""
    for arguments, words in (
        (("predict", springs_file, "--H", "1 MN", "--springs", "fam"), "--springs: 'fam' is not one of"),
        (("predict", springs_file, "--H", "1 MN", "--springs", "full", "--path", "nix"), "--path: no path 'nix'"),
        (("predict", springs_file, "--H", "1 MN", "--strict", "--extrapolate"), "--strict: refuses what"),
        (("predict", springs_file, "--H", "900 MN"), "springs: "),
        (("compare", springs_file, "--springs", "fam"), "--springs: no springs 'fam' here"),
    ):
        done = command(*arguments)
        assert done.code == 2 and done.err.startswith(f"fatal: user input: {words}"), done.err


@pytest.mark.parametrize("arm", [6.0, -9.0, -14.0, -16.0])
def test_the_load_of_a_tilt_is_found_at_every_height(tmp_path: Path, arm: float) -> None:
    """Also so far below mudline that the lid moves against the force, and back where the upper soil yields."""
    tree = fan_springs(lambda z, y, turn: (3e2 * np.tanh(1e6 * y), 2e9 * turn), rho=1e-2 * RHO)
    save_springs(tree, tmp_path / "springs.nc")
    (state,) = states(tmp_path / "springs.nc", "--tilt", "1e-6 rad", f"--arm={arm} m")
    assert state["H"] > 0.0 and abs(state["rotation"]) == pytest.approx(1e-6)
    assert state["M"] == pytest.approx(arm * state["H"])
    (again,) = states(tmp_path / "springs.nc", "--H", f"{state['H']} N", f"--arm={arm} m")
    assert again["rotation"] == pytest.approx(state["rotation"], rel=1e-6)


def test_v_of_a_sequence_is_given_once(springs_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "sequence.csv"
    file.write_text("H_N,M_Nm,V_N\n1e4,0,5e5\n")
    done = command("predict", springs_file, "--sequence", file, "--V", "400 kN")
    assert done.code == 2 and "--V: the file has a column of V" in done.err


def test_every_quantity_of_a_written_answer_has_its_unit(springs_file: Path, tmp_path: Path) -> None:
    table, out = tmp_path / "sequence.csv", tmp_path / "answer.csv"
    table.write_text("u [mm],arm [m],time [min]\n0.2,0,1\n0.4,0,2\n")
    done = command("predict", springs_file, "--sequence", table, "--out", out, "--json")
    assert json.loads(done.out)["states"][-1]["u"] == pytest.approx(4e-4), done.err  # and the file
    lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
    read = dict(zip(lines[0].split(","), lines[-1].split(","), strict=True))
    assert (float(read["u_m"]), float(read["time_s"])) == (4e-4, 120.0)


@pytest.mark.parametrize(
    ("rows", "holds"),
    [
        ("2,0,0\n2,5,100\n", False),
        ("1,0,0\n1,5,100\n3,0,0\n3,5,100\n", True),
        ("1,0,0\n1,5,0\n1,9,1\n3,0,0\n3,5,0\n3,9,1\n", False),
    ],
)
def test_a_table_that_holds_nothing_at_rest_is_named(tmp_path, rows, holds):
    """One spring leaves a turn free, under a load at its own depth, too; torsion is not known of any table."""
    (file := tmp_path / "own.csv").write_text("depth [m],y [mm],p [kN/m]\n" + rows)
    asked = "predict", file, "--skirt-length", "4 m"
    done = command(*asked, "--H", "10 kN", "--arm=-2 m")
    assert (done.code == 0) is holds and ("at rest a motion meets no resistance" in done.err) is not holds
    assert "--T: T is left out: torsion is not known" in command(*asked, "--Hx", "9 kN", "--T", "1 N m", "--strict").err


def test_what_a_command_reads_is_not_written_over(springs_file: Path, tmp_path: Path) -> None:
    springs, table, ramp = springs_file, tmp_path / "cases.csv", tmp_path / "ramp.csv"
    table.write_text("name,H [kN],M [kN m]\na,10,20\n", encoding="utf-8")
    ramp.write_text("H_N,arm_m\n1e4,2\n", encoding="utf-8")
    beside = tmp_path / "." / "cases.csv"
    for args, file in (
        (("predict", springs, "--H", "10 kN", "--out", springs), springs),
        (("predict", springs.parent, "--H", "10 kN", "--out", springs), springs),
        (("predict", springs, "--sequence", ramp, "--out", ramp), ramp),
        (("design", springs, table, "--out", tmp_path / "new.csv", "--out", beside), table),
        (("springs", springs, "--format", "json", "--out", springs), springs),
        (("ground", table, "--out", table, "--force"), table),
        (("sweep", tmp_path / "study.toml", "--out", tmp_path, "--table", table), table),
        (("atlas", springs, "--family", "clay", "--out", springs), springs),
    ):
        before = file.read_bytes()
        done = command(*args)
        assert (done.code, file.read_bytes() == before) == (2, True)
        assert "is read by this command, and would be lost: name another file" in done.err
    assert not (tmp_path / "new.csv").exists()
