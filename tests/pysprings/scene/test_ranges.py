# SPDX-License-Identifier: MIT
"""Values with low, best and high: the estimate picks one of them in scenes and tables; wrong ranges are refused."""

import json
import re

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.profile_table import read_layers
from pysprings.scene.template import scene_schema
from tests.support.commands import command

SCENE = """\
[soil]
K0 = 0.5
effective_unit_weight = "9 kN/m^3"
friction_angle_final = { low = "33 deg", best = "36 deg", high = "39 deg" }
young_modulus = "80 MPa"
[[path]]
name = "pull"
kind = "pull"
lateral_displacement = "1 mm"
"""
LAYER = """\
[[soil.layer]]
top = "0 m"
shear_modulus = { low = { top = "20 MPa", bottom = "30 MPa", to = "10 m" }, best = "40 MPa", high = "60 MPa" }
"""


@pytest.mark.parametrize(("estimate", "phi"), [(None, 36.0), ("low", 33.0), ("best", 36.0), ("high", 39.0)])
def test_the_estimate_picks_the_value_of_a_range(estimate: str | None, phi: float) -> None:
    changes = [] if estimate is None else [f'soil.estimate="{estimate}"']
    scene = parse_scene(SCENE, changes=changes)
    assert np.degrees(scene.soil.friction_angle_final) == pytest.approx(phi)
    assert scene.estimate == (estimate or "best") == scene.replace(title="x").estimate
    assert parse_scene(scene.source_text) == scene
    assert parse_scene(scene.to_toml()) == scene


def test_commands_name_the_estimate_whose_values_count(tmp_path) -> None:
    """That is the best one where nothing chooses; nothing is named of a scene without ranges."""
    file, words = tmp_path / "a.toml", "of values with a range the {} ones count"
    file.write_text(SCENE)
    lab = ("element", file, "--stress", "50 kPa", "--strain", "0.001", "--no-figures", "--out", tmp_path / "lab")
    for name, more in (("best", ()), ("low", ("--set", 'soil.estimate="low"'))):
        for asked in (("check", file), lab):
            assert words.format(name) in command(*asked, *more).out
            assert json.loads(command(*asked, *more, "--json").out)["estimate"] == name
    assert "ones count" not in command("check", file, "--set", 'soil.friction_angle_final="36 deg"').out


def test_scenes_of_two_estimates_have_different_sums() -> None:
    sums = {parse_scene(SCENE, changes=[f'soil.estimate="{each}"']).sha256 for each in ("low", "best", "high")}
    assert len(sums) == 3
    plain = SCENE.replace('{ low = "33 deg", best = "36 deg", high = "39 deg" }', '"36 deg"')
    assert parse_scene(SCENE).sha256 == parse_scene(plain).sha256 and parse_scene(plain).estimate is None


def test_a_range_may_hold_values_by_depth() -> None:
    text = SCENE.replace('young_modulus = "80 MPa"\n', "").replace("[[path]]", f"{LAYER}[[path]]")
    at = np.array([5.0])
    assert parse_scene(text, changes=['soil.estimate="low"']).ground.value("shear_modulus", at) == pytest.approx(25e6)
    assert parse_scene(text).ground.value("shear_modulus", at) == pytest.approx(40e6)


def test_all_three_values_of_a_range_are_checked() -> None:
    with pytest.raises(UserInputError) as error:
        parse_scene(SCENE.replace('"39 deg"', '"390 deg"').replace('low = "33 deg"', 'low = "33 kPa"'), "a.toml")
    text = str(error.value)
    assert "a.toml:4:24: soil.friction_angle_final" in text
    assert '(estimate "low")' in text and '(estimate "high")' in text


def test_a_range_without_one_of_the_three_is_refused_with_its_place() -> None:
    with pytest.raises(UserInputError, match=r"a\.toml:4:24: soil\.friction_angle_final: .*got low, best"):
        parse_scene(SCENE.replace(', high = "39 deg"', ""), "a.toml")


def test_an_estimate_of_a_scene_without_ranges_is_refused() -> None:
    plain = SCENE.replace('{ low = "33 deg", best = "36 deg", high = "39 deg" }', '"36 deg"')
    with pytest.raises(UserInputError, match=r"a\.toml:2:12: soil\.estimate: no value of the scene has a range"):
        parse_scene(plain.replace("[soil]", '[soil]\nestimate = "low"'), "a.toml")


def test_a_scene_has_the_values_of_one_estimate_and_names_it() -> None:
    """In Python there is no key that would name another estimate than that of the values."""
    scene = parse_scene(SCENE, changes=['soil.estimate="high"'])
    assert scene.title.endswith(" (high estimate)") and "estimate =" not in scene.to_toml()
    assert "estimate" not in parse_scene(SCENE).title
    with pytest.raises(ValueError, match="estimate"):
        scene.replace(soil={"estimate": "low"})


def test_an_unknown_estimate_is_refused() -> None:
    with pytest.raises(UserInputError, match=r'soil\.estimate: "lowest" is not one of'):
        parse_scene(SCENE.replace("[soil]", '[soil]\nestimate = "lowest"'), "a.toml")


TABLE = """\
Depth from [m],Depth to [m],Soil type,Effective unit weight [kN/m3],phi low [deg],phi best [deg],phi high [deg],\
G low from [MPa],G low to [MPa],G best from [MPa],G best to [MPa],G high [MPa]
0,4,Sand,9,32,35,38,10,20,20,40,60
4,20,Sand,10,34,37,40,30,60,40,80,90
"""


def _with_table(folder, table: str):
    (folder / "site.csv").write_text(table)
    file = folder / "scene.toml"
    lines = SCENE.splitlines()
    file.write_text("\n".join([lines[0], lines[1], 'profile = "site.csv"', *lines[5:]]) + "\n")
    return file


@pytest.mark.parametrize("high", ["high", "HE", "UE"])
@pytest.mark.parametrize(("estimate", "phi", "G"), [("low", 32, 15e6), ("best", 35, 30e6), ("high", 38, 60e6)])
def test_a_table_has_columns_of_a_range(tmp_path, estimate: str, phi: float, G: float, high: str) -> None:
    """Or those of its lower, best and higher or upper estimate, as LE, BE, HE or UE."""
    table = TABLE if high == "high" else TABLE.replace("low", "LE").replace("best", "BE").replace("high", high)
    scene = load_scene(_with_table(tmp_path, table), [f'soil.estimate="{estimate}"'])
    assert np.degrees(scene.ground.value("friction_angle_final", np.array([2.0]))) == pytest.approx(phi)
    assert scene.ground.value("shear_modulus", np.array([2.0])) == pytest.approx(G)


def test_points_by_depth_may_have_ranges(tmp_path) -> None:
    table = "depth [m],Effective unit weight [kN/m3],phi [deg],G low [MPa],G best [MPa],G high [MPa]\n"
    scene = load_scene(_with_table(tmp_path, table + "0,9,35,10,20,30\n5,9,35,20,30,60\n10,9,35,30,40,90\n"))
    assert len(scene.soil.layers) == 1
    assert scene.ground.value("shear_modulus", np.array([7.5])) == pytest.approx(35e6)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (",phi high [deg]", "", "needs a column 'friction_angle_final high' beside it"),
        ("phi low [deg]", "phi [deg]", "needs a column 'friction_angle_final low' beside it"),
        ("G low to [MPa]", "G low [MPa]", "another column gives shear_modulus low, too"),
        ("0,4,Sand,9,32,35", "0,4,Sand,9,,35", "site.csv:2: phi low [deg]: a value of the range is blank"),
        ("0,4,Sand,9,32,35", "0,4,Sand,9,-32,35", "site.csv:2: phi low [deg]: "),
    ],
)
def test_a_wrong_range_of_a_table_is_refused_with_its_line(tmp_path, old: str, new: str, message: str) -> None:
    table = TABLE.replace(old, new, 1)
    if old == ",phi high [deg]":
        table = table.replace(",35,38", ",35").replace(",37,40", ",37")
    with pytest.raises(UserInputError) as error:
        load_scene(_with_table(tmp_path, table))
    assert message in str(error.value)


def test_the_schema_of_an_editor_accepts_ranges(tmp_path) -> None:
    from pysprings.scene.template import _with_ranges

    soil = _with_ranges(scene_schema())["properties"]["soil"]["properties"]
    for table in (soil, soil["layer"]["items"]["properties"]):
        assert [each.get("required") for each in table["K0"]["anyOf"]] == [None, ["low", "best", "high"]]
    assert "anyOf" not in soil["yield_surface"]


@pytest.mark.parametrize(
    ("key", "low", "best", "high", "message"),
    [
        ("friction_angle_final", '"39 deg"', '"36 deg"', '"33 deg"', "the least friction_angle_final: swap"),
        ("friction_angle_final", '"33 deg"', '"0.7 rad"', '"39 deg"', "best, 0.7 rad, is not between low and high"),
        ("young_modulus", '"0.2GPa"', '"40 MPa"', '"20MPa"', "the least young_modulus: swap low and high"),
        ("dilation_angle", '"8 deg"', '"5 deg"', '"0 deg"', "the least dilation_angle: swap low and high"),
        ("hardening_parameter", "0.001", "0.002", "0.005", "the largest hardening_parameter: swap low and high"),
        ("K0", "0.7", "0.9", "0.5", "best, 0.9, is not between low and high"),
    ],
)  # fmt: skip
def test_ranges_that_are_the_wrong_way_round_are_refused(key, low, best, high, message) -> None:
    """K0 has no softer end: it may fall from low to high."""
    given = re.sub(rf"(?m)^{key} = .*\n", "", SCENE)
    given = given.replace("[soil]\n", f"[soil]\n{key} = {{ low = {low}, best = {best}, high = {high} }}\n", 1)
    with pytest.raises(UserInputError) as error:
        parse_scene(given, "a.toml")
    assert message in str(error.value)
    falling = SCENE.replace("K0 = 0.5", "K0 = { low = 0.7, best = 0.6, high = 0.5 }")
    assert parse_scene(falling, "a.toml").ground.strata[0].values["K0"] == 0.6


def test_a_range_by_depth_that_is_the_wrong_way_round_is_refused() -> None:
    with pytest.raises(UserInputError, match="the least shear_modulus: swap low and high"):
        parse_scene(SCENE + LAYER.replace('top = "20', 'top = "200').replace('best = "40', 'best = "140'), "a.toml")


@pytest.mark.parametrize(
    ("high", "words"),
    [('"30 kPa"', "cross in the layer: 40000, 50000, 30000 "), ('{ top = "12 kPa", gradient = "2.1 kPa/m" }', "")],
)
def test_estimates_that_cross_below_the_top_of_a_layer_are_refused(high, words) -> None:
    """su of 8 + 1.6 z, 10 + 2 z and 30 kPa changes its order at 10 and 13.75 m, in a domain of 20 m."""
    text = f"""
[soil]
yield_surface = "tresca"
rigidity_ratio = 300
effective_unit_weight = "8 kN/m^3"
[soil.undrained_shear_strength]
low = {{ top = "8 kPa", gradient = "1.6 kPa/m" }}
best = {{ top = "10 kPa", gradient = "2 kPa/m" }}
high = {high}
[domain]
radius = "40 m"
depth = "20 m"
[interface]
adhesion_factor = 0.65
"""
    if not words:
        assert parse_scene(text).ground.strata[0].values["undrained_shear_strength"].gradient == 2e3
        return
    with pytest.raises(UserInputError, match=words):
        parse_scene(text)


@pytest.mark.parametrize(("bottom", "crosses"), [(0.006, False), (0.002, True)])
def test_of_strains_the_low_estimate_is_the_largest_all_the_way_down(bottom: float, crosses: bool) -> None:
    text = f"""
[soil]
yield_surface = "iwan-clay"
rigidity_ratio = 300
undrained_shear_strength = "40 kPa"
effective_unit_weight = "8 kN/m^3"
strain_at_half_strength = {{ low = 0.012, best = {{ top = 0.008, bottom = {bottom} }}, high = 0.003 }}
[domain]
radius = "40 m"
depth = "20 m"
[interface]
adhesion_factor = 0.65
"""
    if crosses:
        with pytest.raises(UserInputError, match=r"strength: .*cross in the layer: 0.012, 0.002, 0.003 "):
            parse_scene(text)
    else:
        assert parse_scene(text).ground.strata[0].values["strain_at_half_strength"].bottom == bottom


def test_ranges_of_a_table_that_are_the_wrong_way_round_are_refused_with_their_line(tmp_path) -> None:
    head = "Depth from [m],Depth to [m],Effective unit weight [kN/m3],su [kPa],G [MPa],eps50 low [%],eps50 best [%],"
    (tmp_path / "a.csv").write_text(f"{head}eps50 high [%]\n0,9,8,20,6,0.5,1,2\n")
    with pytest.raises(UserInputError, match=r"a.csv:2: eps50 low \[%\]: low is that of the softer and weaker ground"):
        read_layers(tmp_path / "a.csv")
