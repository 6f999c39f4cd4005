# SPDX-License-Identifier: MIT
"""Layers from tables: groundhog's columns in CSV and Excel, other separators, and what is refused."""

import re

import numpy as np
import openpyxl
import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.units import read, si_of
from pysprings.scene.defaults import remarks
from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.profile_table import read_layers
from tests.support import tiny

SITE = """\
Depth from [m],Depth to [m],Soil type,Effective unit weight [kN/m3],Friction angle from [deg],Friction angle to [deg],\
Young modulus [MPa],Poisson ratio [-],law
0,2,Loose sand,9,29,31,40,0.25,
2,12,Dense sand,10.5,36,38,120,0.3,van-eekelen
"""
SCENE = '[domain]\nradius = "24 m"\ndepth = "12 m"\n[soil]\nK0 = 1.0\nprofile = "site.csv"\n'


def write(folder, table=SITE, name="site.csv"):
    (folder / name).write_text(table)
    file = folder / "scene.toml"
    file.write_text(SCENE.replace("site.csv", name))
    return file


def check(scene):
    ground, depth = scene.ground, np.array([1.0, 7.0])
    assert [each.name for each in ground.strata] == ["Loose sand", "Dense sand"]
    assert [each.law for each in ground.strata] == ["drucker-prager", "van-eekelen"]
    assert ground.value("young_modulus", depth) == pytest.approx([40e6, 120e6])
    assert ground.value("effective_unit_weight", depth) == pytest.approx([9e3, 10.5e3])
    assert np.degrees(ground.value("friction_angle_final", depth)) == pytest.approx([30.0, 37.0])


def test_a_table_with_groundhogs_columns_becomes_layers(tmp_path):
    scene = load_scene(write(tmp_path))
    check(scene)
    assert "profile" not in scene.source_text  # what a result keeps needs no other file
    assert parse_scene(scene.source_text) == scene


@pytest.mark.parametrize(("end", "near"), [("12", False), ("11", True)])
def test_a_table_that_ends_less_than_a_diameter_below_the_tip_is_remarked_on(tmp_path, end, near):
    """The paper's caisson: D 7.8 m, tip at 4 m."""
    scene = load_scene(write(tmp_path, SITE.replace("2,12,", f"2,{end},")))
    text = f"layer 'Dense sand': its values are known to {end} m and hold on below: the skirt tip stands at 4 m"
    for each in (scene, parse_scene(scene.source_text)):
        assert any(remark.startswith(text) for remark in remarks(each)) == near


def test_a_table_of_a_german_spreadsheet_is_the_same(tmp_path):
    german = "\n".join(re.sub(r"(\d)\.(\d)", r"\1,\2", line.replace(",", ";")) for line in SITE.splitlines())
    assert load_scene(write(tmp_path, german)) == load_scene(write(tmp_path))


def test_an_excel_workbook_is_the_same(tmp_path):
    book = openpyxl.Workbook()
    for row in SITE.splitlines():
        cells = [float(cell) if re.fullmatch(r"[\d.]+", cell) else cell for cell in row.split(",")]
        book.active.append(cells)
    book.save(tmp_path / "site.xlsx")
    file = write(tmp_path)
    csv_scene = load_scene(file)
    file.write_text(SCENE.replace("site.csv", "site.xlsx"))
    assert load_scene(file) == csv_scene


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2,12,Dense", "3,12,Dense", r"site.csv:2: Depth to \[m\]: the layers leave a gap: .* at 2 m, .* at 3 m"),
        ("0,2,Loose", "0,4,Loose", r"site.csv:2: Depth to \[m\]: the layers overlap"),
        ("[kN/m3]", "[kPa]", r"1: .Effective unit weight \[kPa\].: wrong unit .kPa.: expected a force per vol"),
        ("Poisson ratio [-]", "Poisson ratio [kPa]", r"ratio \[kPa\].: wrong unit .kPa.: exp.*Poisson ratio \[-\]."),
        ("Young modulus [MPa]", "Young modulus", r"site.csv:1: .Young modulus.: no unit: write .Young modulus \[MPa\]"),
        ("Young modulus [MPa]", "phi [deg]", r":1: Friction angle from \[deg\]: another column gives friction_angle"),
        ("Depth from [m]", "Depth from [kN]", r"site.csv:1: .Depth from \[kN\].: wrong unit .kN.: expected a length"),
        ("Young modulus", "Yung modulus", r"site.csv:1: .Yung modulus \[MPa\].: unknown column \(did you mean"),
        ("120,0.3", "12o,0.3", r'site.csv:3: Young modulus \[MPa\]: "12o" is not a number'),
        ("van-eekelen", "mohr", r'site.csv:3: law: "mohr" is not one of'),
        ("Depth from [m]", "Deep [m]", r"no column .Depth from"),
        ("0,2,Loose", "-1,2,Loose", r"site.csv:2: Depth from \[m\]: .* is not in \[0, 1e4\] m"),
        ("2,12,Dense", "2,12000,Dense", r"site.csv:3: Depth to \[m\]: 12000 m below mudline: is the unit of"),
    ],
)  # fmt: skip
def test_wrong_tables_are_refused_with_file_and_line(tmp_path, old, new, message):
    assert old in SITE
    found = [str(problem) for problem in tiny.problems(load_scene, write(tmp_path, SITE.replace(old, new, 1)))]
    assert any(re.search(message, each) for each in found), found


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("top [mm],bottom [mm],phi [deg]\n0,5,30\n5,40,32\n", ":3: bottom [mm]: the table ends 0.04 m below mudline:"),
        ("depth [mm],phi [deg]\n0,30\n40,32\n", ":3: depth [mm]: the table ends 0.04 m below mudline: is the unit of"),
        ("top [m],su [kPa],G [Pa]\n0,20,6000\n", ":2: G [Pa]: 6 kPa is below su, 20 kPa: is its unit right?"),
        ("top [m],su from [kPa],su to [kPa],E to [kPa],E from [MPa]\n0,20,30,25,9\n", ":2: E to [kPa]: 25 kPa is"),
        ("top [m],su [kPa],G [kPa],eps50,gamma' [kN/m3]\n0,20,100,0.01,8\n", "0.1 of su 20 kPa and G 100 kPa:"),
    ],
)  # fmt: skip
def test_units_that_no_ground_has_are_named_at_their_cell(tmp_path, table, message):
    found = tiny.problems(load_scene, write(tmp_path, table))
    assert any(message in str(problem) for problem in found), found


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("top [m],K0\n", "site.csv: holds no layers: expected a heading and a row a layer"),
        ("top [m],phi [deg]\n" + "".join(f"{k},30\n" for k in range(101)), "holds 101 layers, at most 100: join some"),
        ("E [MPa]\n0.5\n", 'site.csv:1: no column "Depth from [m]" (or "top [m]", or "depth [m]" of points)'),
        ("x" * 50_000_001, "site.csv: is too large for a table (50 MB, at most 50)"),
    ],
    ids=["a heading alone", "too many rows", "no depths", "too large"],
)  # fmt: skip
def test_tables_that_are_no_profile_are_refused(tmp_path, table, message):
    found = tiny.problems(load_scene, write(tmp_path, table))
    assert any(str(problem).endswith(message) for problem in found), found


def test_a_hundred_layers_are_accepted(tmp_path):
    rows = "".join(f"{0.05 * k:g},{200 + k},30,9\n" for k in range(100))
    table = "top [m],young modulus [MPa],phi [deg],gamma' [kN/m3]\n" + rows
    assert len(load_scene(write(tmp_path, table)).soil.layers) == 100


def test_a_missing_table_and_two_descriptions_are_refused(tmp_path):
    file = write(tmp_path)
    (tmp_path / "site.csv").unlink()
    with pytest.raises(UserInputError, match=r"site.csv.*no such file"):
        load_scene(file)
    with pytest.raises(UserInputError, match=r"soil.profile: give soil.profile or \[\[soil.layer\]\], not both"):
        tiny.parsed(SCENE + '[[soil.layer]]\ntop = "0 m"\n')
    with pytest.raises(UserInputError, match=r"--set: soil\.profile: names a table that is read with the file"):
        load_scene(write(tmp_path), ["soil.profile=other.csv"])


OPENPILE = """\
name,top,bottom,weight,Su,law
Soft clay,0.0,-6.0,16.0,"[5.0, 17.0]",tresca
Stiff clay,-6.0,-12.0,19.81,"[60.0, 80.0]",tresca
"""
CLAY = """\
[domain]
radius = "24 m"
depth = "12 m"
[soil]
rigidity_ratio = 200
profile = "site.csv"
[interface]
adhesion_factor = 0.65
"""


def test_openpiles_columns_become_layers(tmp_path):
    """Elevations that fall, total unit weight, a pair of strengths, no units in the headings."""
    file = write(tmp_path, OPENPILE)
    file.write_text(CLAY)
    ground, depth = load_scene(file).ground, np.array([3.0, 9.0])
    assert [each.name for each in ground.strata] == ["Soft clay", "Stiff clay"]
    assert ground.lines == (6.0,)
    assert ground.strength(depth) == pytest.approx([11e3, 70e3])
    assert ground.value("effective_unit_weight", depth) == pytest.approx([6.19e3, 10e3])


def test_elevations_count_from_the_first_top(tmp_path):
    """That is said: points at z -2, -5, -10 m below a mudline at 0 would stand 2 m too high."""
    file = write(tmp_path, OPENPILE.replace("-12.0", "-42").replace("-6.0", "-36").replace(",0.0,", ",-30,"))
    file.write_text(CLAY)
    with pytest.warns(UserWarning, match=r"elevations: the first one, -30 m, is taken as mudline"):
        assert load_scene(file).ground.lines == (6.0,)


def test_remarks_of_points_are_named_as_left_out(tmp_path):
    with pytest.warns(UserWarning, match="remarks of points are not used"):
        layers(tmp_path, "depth [m],Su [kPa],gamma' [kN/m3],G [MPa],Remark\n0,10,8,5,crust\n10,30,8,15,\n")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[5.0, 17.0]", "[5.0]", r'Su: "\[5.0\]" is not a number'),
        ("[5.0, 17.0]", "[5.0, -17.0]", r"Su: bottom: .* is not in \[0, 1e5\] kPa"),
        (",16.0,", ",8.0,", r"weight: .* is not in \[0, 100\] kN/m\^3"),
        ("weight", "weight [kg/m3]", r"weight \[kg/m3\].: .* expected a force per volume"),
        ("Su", "Su [kPa]", r".top.: no unit: write .top \[m\]"),
    ],
)
def test_wrong_openpile_tables_are_refused(tmp_path, old, new, message):
    assert old in OPENPILE
    file = write(tmp_path, OPENPILE.replace(old, new, 1))
    file.write_text(CLAY)
    found = tiny.problems(load_scene, file)
    assert any(re.search(message, str(problem)) for problem in found), found


def test_a_wrong_unit_in_a_heading_is_one_problem_for_all_rows(tmp_path):
    file = write(tmp_path, SITE.replace("[MPa]", "[m]").replace("[kN/m3]", "[kN]"))
    assert [each.line for each in tiny.problems(load_scene, file)] == [1, 1]


def test_problems_of_table_and_scene_come_at_once(tmp_path):
    table = "top [m],bottom [m],su [kPa],phi [deg],E [m]\n0,3,20,30,50\n2,9,20,,x\n"
    file = write(tmp_path, table)
    file.write_text(SCENE.replace('"24 m"', "24"))
    found = [str(problem) for problem in tiny.problems(load_scene, file)]
    words = (
        "domain.radius: expected a quantity", "wrong unit \"m\": expected a pressure", "site.csv:2: su [kPa]: stands",
        "site.csv:2: bottom [m]: the layers overlap", 'site.csv:3: E [m]: "x" is not a number',
    )  # fmt: skip
    assert len(found) == len(words)
    assert all(any(each in message for message in found) for each in words), found


def test_a_total_unit_weight_beside_an_effective_one_is_not_used(tmp_path):
    table = (
        "top [m],Effective unit weight [kN/m3],Total unit weight [kN/m3],young modulus [MPa],phi [deg]\n0,9,25,40,30\n"
    )
    assert load_scene(write(tmp_path, table)).soil.layers[0].effective_unit_weight == pytest.approx(9e3)


def test_rows_with_su_alone_are_clay_and_eps50_is_an_axial_strain(tmp_path):
    """Columns of openpile without a law: su, G0 and eps50 beside a row of sand."""
    table = "name,top,bottom,weight,Su,G0,eps50,phi\nclay,0,-6,16,20,4000,0.01,\nsand,-6,-12,19,,30000,,35\n"
    file = write(tmp_path, table)
    file.write_text(CLAY.replace("rigidity_ratio = 200\n", "K0 = 1.0\n"))
    clay, sand = load_scene(file).ground.strata
    assert (clay.law, sand.law) == ("tresca", "drucker-prager")
    assert clay.values["strain_at_half_strength"] == pytest.approx(0.015)
    assert sand.shear_modulus(np.array(8.0)) == pytest.approx(30e6)
    file.with_name("site.csv").write_text(table.replace("0.01", '"[0.01, 0.02]"'))
    pair = load_scene(file).ground.strata[0]
    assert pair.value("strain_at_half_strength", np.array([0.0, 6.0])) == pytest.approx([0.015, 0.03])
    file.write_text(file.read_text().replace("[soil]", '[soil]\nyield_surface = "von-mises"'))
    file.with_name("site.csv").write_text(table.rsplit("sand", 1)[0])
    assert load_scene(file).ground.strata[0].law == "von-mises"


LAYER = {"name": "S", "effective_unit_weight": "9 kN/m^3", "friction_angle_final": "30 deg", "young_modulus": "40 MPa"}


def layers(folder, text, **soil):
    (folder / "site.csv").write_text(text, encoding="utf-8")
    return read_layers(folder / "site.csv", soil)


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")
@pytest.mark.parametrize(
    ("table", "given"),
    [
        ("z from [m],z to [m],Soil unit,gamma' [kN/m3],phi' [deg],E' [MPa]\n0,9,S,9,30,40\n", {}),
        ("top_m,bottom_m,name,effective_unit_weight_kN_m3,phi_deg,E_MPa\n0,9,S,9,30,40\n", {}),
        ("Depth from (ft),Depth to (ft),name,Total unit weight (pcf),φ (°),E (ksf)\n0,30,S,119.7422,30,835.4174\n",
         {"effective_unit_weight": 9e3, "young_modulus": 40e6}),
        ("top [m],name,Bulk unit weight [kN/m3],phi [deg],Vs [m/s],Dr [%],remarks\n0,S,18.81,30,100,70,loose\n",
         {"effective_unit_weight": 9e3, "shear_modulus": 18.81 / 9.81 * 1e3 * 100.0**2, "young_modulus": None}),
        ("top [m],name,gamma' [kN/m3],phi [deg],Gmax [kPa],sigma v\n0,S,9,30,30000,\n",
         "sigma v"),
        (",top [m],name,gamma' [kN/m3],phi [deg],E [MPa],\n0,0,S,9,30,40,\n1,5,S,9,30,40,\n", {}),
        ("top [m],name,Unit weight [kN/m3],phi [deg],E [MPa]\n0,S,9,30,40\n", "total or effective"),
        ("top [m],name,phi [deg],Vs [m/s]\n0,S,30,200\n", "needs the total unit weight beside it"),
        ("top [m],name,gamma' [kN/m3]\n0,S,9\n", "no column gives stiffness or strength"),
        ("top [m],phi [deg],E [MPa]\n5,30,40\n0,30,40\n", "is not below the layer above it"),
        ("top [m],bottom [m],su from [kPa],su to [kPa],E [MPa]\n0,9,5,,40\n", "blank beside the value at the other"),
        ("top [m],bottom [m],su from [kPa],E [MPa]\n0,9,5,40\n", "needs a column"),
        ("z [m],qc [MPa],fs [MPa]\n0.1,0.9,0.004\n", "is a CPT"),
        ("#GEFID= 1, 1, 0\n#EOH=\n0.1;0.9;0.004;\n", "is a CPT"),
        ('"GROUP","SCPT"\n"HEADING","LOCA_ID"\n', "is a CPT"),
        ("Sample,Depth [m],Type,Su peak [kPa]\n3W,2.2,UU,31\n", "laboratory tests"),
    ],
)  # fmt: skip
def test_headings_of_the_field(tmp_path, table, given):
    if not isinstance(given, dict):
        with pytest.raises(UserInputError, match=given):
            layers(tmp_path, table)
        return
    first = layers(tmp_path, table)[0]
    expected = {**LAYER, **given}
    for key, value in expected.items():
        if value is None:
            assert key not in first
        elif isinstance(value, float):
            assert read(first[key], si_of(first[key].split(" ", 1)[1])) == pytest.approx(value, rel=1e-5), key
        else:
            assert first[key] == value


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")
def test_points_by_depth_are_linear_between(tmp_path):
    """Two points at one depth are a boundary; a point on the line, or 400 of them, change nothing."""
    rows = ["0,clay,8,5,30", "4,clay,8,13,30", "4,clay,9,20,60", "10,clay,9,20,60"]
    head = "depth [m],name,gamma' [kN/m3],su [kPa],E [MPa]\n"
    plain = layers(tmp_path, head + "\n".join(rows))
    assert [layer["top"] for layer in plain] == ["0 m", "4 m"]
    assert plain[0]["undrained_shear_strength"] == {"top": "5 kPa", "bottom": "13 kPa"}
    assert (plain[1]["undrained_shear_strength"], plain[0]["law"]) == ("20 kPa", "tresca")
    more = [rows[0], *(f"{z / 100:g},clay,8,{5 + z / 50:g},30" for z in range(1, 400)), *rows[1:]]
    assert layers(tmp_path, head + "\n".join(more)) == plain
    deeper = layers(tmp_path, head + "\n".join(rows).replace("0,clay", "1,clay", 1))
    assert [layer["top"] for layer in deeper] == ["0 m", "1 m", "4 m"]
    for row, message in (("2,clay,8,,30", "blank, and not at the next point"), ("-1,clay,8,5,30", "is not in")):
        with pytest.raises(UserInputError, match=message):
            layers(tmp_path, head + "\n".join([row, *rows[1:]]))
    with pytest.raises(UserInputError, match="is above the point before"):
        layers(tmp_path, head + "\n".join([*rows, "7,clay,9,30,60"]))


def test_names_of_tables_serve_the_scene(tmp_path):
    with pytest.raises(UserInputError, match=r"soil.phi: unknown key \(did you mean 'friction_angle_final'\?\)"):
        parse_scene('[soil]\nphi = "30 deg"\n')


def _table(tmp_path, rows: str, heads: str):
    (tmp_path / "site.csv").write_text(
        f"Depth from [m],Depth to [m],Soil type,Total unit weight [kN/m3],{heads}\n{rows}"
    )
    return tmp_path / "site.csv"


def test_relative_density_makes_a_row_without_other_strength_sand(tmp_path):
    layers = read_layers(_table(tmp_path, "0,4,A,19.81,70,\n4,20,B,18.81,,60\n", "Dr [%],su [kPa]"))
    assert [(each["law"], each.get("relative_density")) for each in layers] == [("sand", 0.7), ("tresca", None)]


@pytest.mark.parametrize(
    ("density", "heading", "words"),
    [
        ("0.7", "Relative density [-]", "not used: relative density of A"),
        ("medium dense", "Relative density", r'not used: "Relative density" \(words\)'),
    ],
)
def test_relative_density_beside_a_friction_angle_or_in_words_is_not_used(tmp_path, density, heading, words):
    file = _table(tmp_path, f"0,20,A,19.81,{density},36,40\n", f"{heading},phi [deg],E [MPa]")
    with pytest.warns(UserWarning, match=words):
        (layer,) = read_layers(file)
    assert "relative_density" not in layer and "law" not in layer
