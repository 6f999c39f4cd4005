# SPDX-License-Identifier: MIT
"""`pysprings element`: files, fits to data whose keys are known, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pysprings.scene.load import load_scene
from pysprings.studies.element import LabTest, Request, bounds_of, element_picture, known_keys, residuals, run
from tests.support.commands import Result, command

SCENE = """
[caisson]
outer_diameter = "8 m"
skirt_length = "6 m"
[[soil.layer]]
top = "0 m"
name = "sand"
law = "van-eekelen"
friction_angle_final = "36 deg"
dilation_angle = "6 deg"
young_modulus = { reference = "40 MPa", reference_stress = "100 kPa", exponent = 0.5, follows = "stress" }
effective_unit_weight = "10 kN/m^3"
K0 = 0.5
degradation_strain = 2e-4
[[soil.layer]]
top = "6 m"
name = "clay"
law = "tresca"
undrained_shear_strength = "40 kPa"
rigidity_ratio = 200
effective_unit_weight = "8 kN/m^3"
[interface]
adhesion_factor = 0.65
"""

MEASURED_BY = {"triaxial": ("axial_strain", "q_Pa"), "dss": ("shear_strain", "shear_stress_Pa")}
HEAD = "stress [kPa],axial strain [%],q [kPa]\n"
ROWS = "100,0,0\n100,0.5,120\n100,1,200\n100,2,290\n100,5,340\n"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "c.toml"
    file.write_text(SCENE)
    return file


def test_a_stiffness_that_does_not_follow_the_stress_is_named(scene: Path, tmp_path: Path) -> None:
    """Of sand with a constant modulus; not of one that follows, nor of clay in total stress."""
    run = (
        "element",
        str(scene),
        "--stress",
        "50 kPa",
        "--strain",
        "0.001",
        "--no-figures",
        "--out",
        str(tmp_path / "o"),
    )
    note = "G does not follow the stress in a test"
    assert note in command(*run, "--layer", "sand", "--set", 'soil.layer.sand.young_modulus="40 MPa"').out
    assert "stress at the end: shear stress\n" in command(*run, "--layer", "sand", "--test", "dss").out
    assert note not in command(*run, "--layer", "sand").out and note not in command(*run, "--layer", "clay").out


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")  # of columns that follow from others
def test_the_command_writes_a_table_that_it_reads_as_data(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = ("element", str(scene), "--layer", "sand", "--stress", "50 kPa", "--stress", "200 kPa")
    about = json.loads(command(*arguments, "--out", str(out), "--json").out)
    assert [row["stress_Pa"] for row in about["tests"]] == [50e3, 200e3] and about["fit"] is None
    assert {Path(file).name for file in about["files"]} == {"element.csv", "element.png"}
    frame = pd.read_csv(out / "element.csv")
    assert frame.groupby("test").size().tolist() == [180, 180]
    again = ("element", str(scene), "--layer", "sand", "--data", str(out / "element.csv"), "--no-figures")
    text = command(*again, "--out", str(tmp_path / "again")).out
    assert "away from data" in text and not (tmp_path / "again" / "element.png").exists()
    found = json.loads(command(*again, "--out", str(tmp_path / "again"), "--json").out)["tests"]
    assert max(row["away"] for row in found) < 2e-3  # the same curve at other strains: rows end with the data


def test_a_fit_finds_the_keys_behind_its_data(scene: Path, tmp_path: Path) -> None:
    """The data are those of the law itself with 33 and 10 degrees; their columns are in other units."""
    out = tmp_path / "out"
    truth = (
        "--set", 'soil.layer.sand.friction_angle_final="33 deg"', "--set", 'soil.layer.sand.dilation_angle="10 deg"',
    )  # fmt: skip
    command("element", str(scene), "--layer", "sand", "--stress", "100 kPa", *truth, "--out", str(out), "--no-figures")
    frame = pd.read_csv(out / "element.csv")
    data = pd.DataFrame({
        "axial strain [%]": 100.0 * frame["axial_strain"], "q [MPa]": 1e-6 * frame["q_Pa"],
        "volumetric strain [%]": 100.0 * frame["volumetric_strain"],
    })  # fmt: skip
    data.to_csv(tmp_path / "lab.csv", index=False)
    found = json.loads(command(
        "element", str(scene), "--layer", "sand", "--stress", "100 kPa", "--data", str(tmp_path / "lab.csv"),
        "--fit", "friction_angle_final,dilation_angle", "--out", str(out), "--json",
    ).out)["fit"]  # fmt: skip
    assert [each["value"] for each in found["keys"]] == pytest.approx([33.0, 10.0], rel=2e-3)
    assert found["away_after"] < 1e-3 < found["away_before"] and found["converged"]
    assert np.shape(found["correlation"]) == (2, 2) and found["correlation"][0][0] == pytest.approx(1.0)
    assert not any(each["at_bound"] for each in found["keys"])


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")  # of columns that follow from others
def test_a_fit_finds_a_key_that_starts_from_0(scene: Path, tmp_path: Path) -> None:
    """Cohesion of the data 12 kPa, of the scene 0: the scale of a step is that of the unit, not of the value."""
    about, lab = ("element", str(scene), "--layer", "sand", "--stress", "100 kPa"), str(tmp_path / "o" / "element.csv")
    command(*about, "--set", 'soil.layer.sand.cohesion="12 kPa"', "--out", str(tmp_path / "o"), "--no-figures")
    options = ("--data", lab, "--fit", "cohesion", "--no-figures", "--out", str(tmp_path / "p"), "--json")
    (found,) = json.loads(command(*about, *options).out)["fit"]["keys"]
    assert found["value"] == pytest.approx(12.0, rel=2e-3) and not found["at_bound"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "--layer: the scene has several layers: give one of 'sand', 'clay'"),
        (("--layer", "silt"), "--layer: \"silt\" is no layer of the scene"),
        (("--layer", "sand", "--stress", "5"), '--stress: expected a quantity with unit such as "100 kPa"'),
        (("--layer", "sand", "--stress", "-5 kPa"), "must be positive"),
        (("--layer", "sand", "--stress", "50 kPa", "--stress", "0.05 MPa"), '"0.05 MPa" stands there twice'),
        (("--layer", "sand", "--depth", "9 m"), "--depth: 9 m is not in the layer, 0 to 6 m"),
        (("--layer", "sand", "--test", "oedometer", "--drainage", "undrained"), "an oedometer test drains"),
        (("--layer", "sand", "--fit", "cohesion"), "--fit: needs --data"),
        (("--layer", "sand", "--strain", "2"), "--strain: 2 is not in (0, 1]"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(scene: Path, options: tuple[str, ...], message: str) -> None:
    found = command("element", str(scene), *options)
    assert found.code == 2 and message in found.err and len(found.err.strip().splitlines()) == 1


def test_of_two_layers_of_one_name_the_depth_decides(scene: Path, tmp_path: Path) -> None:
    """As `pysprings ground` names them by their soil: 'sand' from 0 and from 9 m."""
    text = SCENE.split("[interface]")[0].rpartition("[[soil.layer]]")[0]
    again = text[text.index("[[soil.layer]]") :].replace("0 m", "9 m").replace("36 deg", "40 deg")
    scene.write_text(SCENE.replace("[interface]", again + "[interface]"))
    run = ("element", str(scene), "--layer", "sand", "--strain", "0.001", "--no-figures", "--out", str(tmp_path))
    refused = command(*run)
    assert refused.code == 2 and '2 layers have the name "sand", 0 to 6 m, 9 to' in refused.err
    for depth in ("1 m", "10 m"):
        assert f"at {depth} below mudline" in command(*run, "--depth", depth).out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("axial strain [%],p [kPa]\n1,2\n", "no column 'q [kPa]'"),
        ("axial strain [%],q [kPa]\n1,2\n", "no column 'stress [kPa]'"),
        ("stress [kPa],axial strain [%],q [kPa]\n100,0,2\n100,1,3\n", "fewer than 3 rows"),
        ("stress [kPa],axial strain [%],q [kPa]\n0,0,2\n0,1,3\n0,2,4\n", "must be positive"),
        ("stress [kPa],axial strain [%],q [kPa]\n100,0,2\n100,,3\n100,2,4\n", "needs a number"),
        (HEAD.replace(" [%]", "") + ROWS, "lab.csv:1: axial strain: has no unit: write 'axial strain [%]'"),
        (HEAD.replace("[%]", "[kPa]") + ROWS, "wrong unit \"kPa\": expected 'axial strain [-]' or"),
        (HEAD.replace("axial strain [%]", "eps1") + ROWS, "lab.csv:1: eps1: has no unit: write 'eps1 [%]'"),
        (HEAD.replace("%", "-") + ROWS, "lab.csv:6: axial strain [-]: a strain of 500 %, beyond 100 %: is the unit"),
        (HEAD.replace("q [kPa]", "q [MPa]") + ROWS, "lab.csv:6: q [MPa]: 3.4e+05 kPa is 3.4e+03 times the consolid"),
        (HEAD.replace("s [kPa]", "s [MPa]") + ROWS, "lab.csv:6: q [kPa]: 340 kPa is 0.0034 times the consolidation"),
        (
            HEAD.replace("\n", ",epsv [%]\n") + "100,0,0,0\n100,-1,90,0.2\n100,-5,250,3\n",
            "lab.csv:4: axial strain [%]: -5 %: axial and volumetric strain are positive in compression",
        ),
        (HEAD + ROWS + "100,10,-9999\n", "lab.csv:7: q [kPa]: -9999 kPa: this stress is positive in compression"),
        (
            HEAD + ROWS + "100,0,0\n100,2,150\n",
            "lab.csv:7: axial strain [%]: the strain falls to 0 %: two tests need a",
        ),
    ],
)
def test_data_that_are_no_test_are_refused(scene: Path, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "lab.csv").write_text(text)
    found = command("element", str(scene), "--layer", "sand", "--data", str(tmp_path / "lab.csv"))
    assert found.code == 2 and message in found.err
    assert ("wrong unit" in found.err) + ("has no unit" in found.err) < 2  # one fault, one advice


def test_keys_to_be_fitted_are_numbers_of_the_law_with_their_bounds(scene: Path, tmp_path: Path) -> None:
    sand, clay, *_ = load_scene(scene).ground.strata
    assert "young_modulus" in known_keys(sand) and "undrained_shear_strength" not in known_keys(sand)
    assert "undrained_shear_strength" in known_keys(clay)
    assert bounds_of("friction_angle_final", 0.5) == pytest.approx((0.5e-3, np.radians(60.0)))
    assert bounds_of("dilation_angle", 0.0) == pytest.approx((np.radians(-30.0), np.radians(60.0)))
    (tmp_path / "lab.csv").write_text("stress [kPa],axial strain [%],q [kPa]\n100,0,2\n100,1,30\n100,2,40\n")
    data = ("--data", str(tmp_path / "lab.csv"), "--fit", "frict_angle_final")
    found = command("element", str(scene), "--layer", "sand", *data)
    assert "is no number of the layer that its law uses (did you mean 'friction_angle_final'?)" in found.err


def test_a_fit_needs_more_values_than_keys_and_states_what_the_law_does_not_reach(scene: Path, tmp_path: Path) -> None:
    def fitted(rows: str, keys: str, *more: str) -> Result:
        (tmp_path / "lab.csv").write_text(HEAD + rows)
        data = ("--data", str(tmp_path / "lab.csv"), "--fit", keys, "--no-figures", "--out", str(tmp_path / "o"), *more)
        return command("element", str(scene), "--layer", "sand", *data)

    two = "friction_angle_final,dilation_angle"
    few = fitted("100,0,0\n100,1,220\n100,5,340\n", two)
    assert few.code == 2 and "--fit: 2 keys need more measured values beyond a strain of 0 than 2" in few.err
    near = "100,0,0\n100,1,90\n100,2,150\n100,5,240\n"
    far = "the law does not reach the data: more than 20% away"
    reached, beyond = (fitted(rows, "friction_angle_final") for rows in (near, near.replace("0\n", "00\n")))
    assert far in beyond.out and far not in reached.out
    assert 'values of layer "sand" at 3 m below mudline (--depth)' in reached.out
    by_depth = 'soil.layer.sand.friction_angle_final={ top = "34 deg", bottom = "36 deg" }'
    assert '"friction_angle_final" is by depth in this layer' in fitted(near, two, "--set", by_depth).err


def test_a_fitted_value_that_is_none_has_a_mark(scene: Path, tmp_path: Path) -> None:
    """At its bound where the law refuses what is beyond, too; no error of a key that changes nothing in the data."""
    weak = "100,0,0\n100,1,70\n100,2,75\n100,5,80\n"  # 16.6 degrees
    about = ("element", str(scene), "--layer", "sand", "--set", 'soil.layer.sand.friction_angle_initial="20 deg"',
             "--set", "soil.layer.sand.K0=0.6", "--data", str(tmp_path / "lab.csv"), "--no-figures",
             "--out", str(tmp_path / "o"), "--fit")  # fmt: skip
    (tmp_path / "lab.csv").write_text(HEAD + weak)
    (key,) = json.loads(command(*about, "friction_angle_final", "--json").out)["fit"]["keys"]
    assert key["value"] == pytest.approx(20.0, rel=5e-3) and key["at_bound"]
    own = (*about[:4], "--stress", "100 kPa", "--out", str(tmp_path / "lab"), "--no-figures")
    command(*own)
    data = pd.read_csv(tmp_path / "lab/element.csv")
    data["volumetric_strain"] = -3.0 * data["axial_strain"]  # a dilation above the friction angle, which no law takes
    data[["stress_Pa", "axial_strain", "q_Pa", "volumetric_strain"]].to_csv(tmp_path / "lab.csv", index=False)
    (key,) = json.loads(command(*about, "dilation_angle", "--json").out)["fit"]["keys"]
    assert key["at_bound"] and 0.01 < key["error"] < 5.0  # of a search across the bound 0.0004 deg
    small = "100,0,0\n100,0.001,0.9\n100,0.002,1.8\n100,0.003,2.6\n"  # before yield
    (tmp_path / "lab.csv").write_text(HEAD + small)
    fit = json.loads(command(*about, "young_modulus,friction_angle_final", "--json").out)["fit"]
    assert [key["error"] is None for key in fit["keys"]] == [False, True]
    assert fit["correlation"] == [[pytest.approx(1.0), None], [None, None]]
    text = command(*about, "young_modulus,friction_angle_final").out
    assert text.count("these data do not determine it") == 1 and "nan" not in text


@pytest.mark.parametrize("more", [(), ("--set", "soil.layer.clay.strain_at_half_strength=0.01")])
def test_a_stress_outside_the_strength_is_refused(scene: Path, tmp_path: Path, more: tuple[str, ...]) -> None:
    """At K0 0.6 and 201 kPa the shear stress before the test is su; a law that mobilises su stays below it."""
    run = ("element", str(scene), "--layer", "clay", "--set", "soil.layer.clay.K0=0.6", *more, "--strain", "0.01",
           "--set", 'soil.layer.clay.effective_unit_weight="4 kN/m^3"', "--test", "dss", "--no-figures",
           "--out", str(tmp_path / "o"))  # fmt: skip
    assert command(*run, "--stress", "199 kPa").code == 0
    assert command(*run, "--stress", "200 kPa").code == (2 if more else 0)
    found = command(*run, "--stress", "201 kPa")
    assert found.code == 2 and "consolidated under 201 kPa" in found.err and "strength 40 kPa" in found.err


def test_a_curve_is_no_shorter_than_its_data(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "lab.csv").write_text(HEAD + ROWS)
    run = ("element", str(scene), "--layer", "sand", "--data", str(tmp_path / "lab.csv"), "--no-figures")
    found = command(*run, "--out", str(tmp_path / "o"), "--strain", "0.02")
    assert found.code == 2 and "--strain: 0.02 is less than the last strain of --data, 0.05" in found.err


def test_a_curve_that_ends_early_is_away_from_the_data_beyond(scene: Path) -> None:
    sand = load_scene(scene).ground.strata[0]
    curve = run(Request(sand, "triaxial", 3.0, stresses=(100e3,), strain=0.05)).curves[0]
    columns = {"axial_strain": np.array([0.0, 0.04, 0.1]), "q_Pa": np.full(3, 1e5)}
    (away,) = residuals(LabTest("a", 100e3, columns), curve, "triaxial", "drained")
    assert abs(away[2]) == pytest.approx(1.0 / np.sqrt(3.0))


@pytest.mark.parametrize(("test", "more"), [("triaxial", "u [kPa]"), ("dss", "vertical effective stress [kPa]")])
@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_a_law_in_total_stress_has_no_pore_pressure_and_is_not_judged_by_one(
    scene: Path, tmp_path: Path, test: str, more: str, drainage: str
) -> None:
    run = ("element", str(scene), "--layer", "clay", "--test", test, "--drainage", drainage, "--out", str(tmp_path))
    strain, stress = ("shear strain [%]", "tau [kPa]") if test == "dss" else ("axial strain [%]", "q [kPa]")
    text = f"stress [kPa],{strain},{stress},{more},volumetric strain [%]\n"
    (tmp_path / "lab.csv").write_text(text + "100,0,0,0,0\n100,1,70,40,2\n100,5,80,60,4\n")
    (row,) = json.loads(command(*run, "--no-figures", "--json", "--data", str(tmp_path / "lab.csv")).out)["tests"]
    frame = pd.read_csv(tmp_path / "element.csv")
    assert "pore_pressure_Pa" not in row and frame[["pore_pressure_Pa", "mobilised_angle_rad"]].isna().all(axis=None)
    found = np.interp([0.0, 0.01, 0.05], *(frame[each] for each in MEASURED_BY[test]))
    away = (found / 1e3 - [0.0, 70.0, 80.0]) / 80.0
    assert row["away"] == pytest.approx(np.sqrt(np.mean(away**2)), rel=1e-6)


@pytest.mark.parametrize(
    ("layer", "test", "label"),
    [
        ("sand", "triaxial", "mean effective stress p' [kPa]"), ("clay", "triaxial", "mean total stress p [kPa]"),
        ("sand", "oedometer", "axial effective stress [kPa]"), ("clay", "oedometer", "axial total stress [kPa]"),
    ],
)  # fmt: skip
def test_stresses_of_a_law_in_total_stress_are_named_so(scene: Path, layer: str, test: str, label: str) -> None:
    stratum = next(each for each in load_scene(scene).ground.strata if each.name == layer)
    outcome = run(Request(stratum, test, 7.0, strain=1e-3))
    axes = element_picture(outcome.curves, outcome.names, (), test, "").axes
    assert label in {text for each in axes for text in (each.get_xlabel(), each.get_ylabel())}
    assert test == "triaxial" or outcome.stress == label.removesuffix(" [kPa]")
