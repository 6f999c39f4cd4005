# SPDX-License-Identifier: MIT
"""What a scene leaves out: refused, or listed with its value; and what is unlikely in what it gives."""

import json

import numpy as np
import pytest

from pysprings.model.forecast.omissions import left_out
from pysprings.scene.defaults import RANGES, defaulted, defaulted_text, remarks
from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.sections import plain_field
from pysprings.scene.soils.clay import TABLES
from tests.support import tiny
from tests.support.commands import command

SAND = (
    '[soil]\nyoung_modulus = "80 MPa"\nfriction_angle_final = "35 deg"\neffective_unit_weight = "9.5 kN/m^3"\n'
    "K0 = 0.5\n"
)
CLAY = '[soil]\nyield_surface = "tresca"\n[interface]\nadhesion_factor = 0.65\n'
OF_CLAY = 'undrained_shear_strength = "20 kPa"\nrigidity_ratio = 200\neffective_unit_weight = "6 kN/m^3"\n'
COUPLED = '[drainage]\nmode = "coupled"\n[springs]\nreach = "1 mm"\nrates = ["1 mm/s"]\n'


def missing(text: str) -> dict[str, str]:
    return {str(each.key): each.message for each in tiny.problems(parse_scene, text)}


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("[caisson]\n", {"young_modulus", "friction_angle_final", "effective_unit_weight", "K0"}),
        (CLAY, {"rigidity_ratio", "undrained_shear_strength", "effective_unit_weight"}),
        ('[soil]\nyield_surface = "elastic"\n', {"young_modulus", "effective_unit_weight"}),
        (SAND + COUPLED, {"hydraulic_conductivity"}),
    ],
)  # fmt: skip
def test_stiffness_strength_weight_and_K0_have_no_default(text: str, keys: set[str]) -> None:
    """Each missing key is named, with a wrong value beside them, and not what a misspelt key meant."""
    found = missing(text)
    assert {*found} == {f"soil.{key}" for key in keys}
    assert all(text.startswith("missing; ") for text in found.values())
    assert {*missing(text + '[domain]\nradius = "1 mm"\n')} == {*found, "domain.radius"}
    misspelt = missing(text.replace("[soil]", "[soil]\neffective_unit_wieght = 1", 1)) if "[soil]" in text else {}
    assert "soil.effective_unit_weight" not in misspelt


def test_missing_keys_name_their_layers() -> None:
    layers = "".join(f'[[soil.layer]]\ntop = "{top} m"\nname = "{name}"\n' for top, name in ((0, "SAND"), (3, "CLAY")))
    found = missing(SAND.replace('young_modulus = "80 MPa"\n', "") + layers)
    assert found == {
        "soil.layer[0].young_modulus": "missing in layer 'SAND', 'CLAY'; law \"drucker-prager\" needs it, or "
        'shear_modulus; such as young_modulus = "200 MPa"'
    }


@pytest.mark.parametrize("opening", ["sealed", "vented"])
def test_the_depth_of_the_sea_is_listed_where_suction_holds_the_caisson(opening: str) -> None:
    """Suction of a sealed surface ends at vapour pressure: without a depth that of a sea of 0 m, which counts."""
    scene = parse_scene(CLAY.replace("[interface]", f'{OF_CLAY}[interface]\nopening = "{opening}"'))
    values = {row["key"]: row["value"] for row in defaulted(scene)}
    unused = " ".join(each.what for each in left_out(scene))
    if opening == "sealed":
        assert values["drainage.water_depth"] == 0.0 and values["drainage.water_unit_weight"] == 9.81
        assert "water_depth" not in unused
    else:
        assert not {key for key in values if "water" in key}
        assert "drainage.water_depth" in unused


def test_what_no_flow_in_time_needs_is_left_out_of_an_undrained_scene() -> None:
    """The film conducts in a closed interface without time: both its keys decide where its pressure spreads."""
    scene = parse_scene(SAND + '[drainage]\nmode = "undrained"\n')
    given = {row["key"] for row in defaulted(scene)}
    assert {"interface.residual_aperture", "interface.transversal_conductivity"} <= given
    assert "domain.side_drainage" not in given
    assert any("hydraulic_conductivity, domain.side_drainage" in each.what for each in left_out(scene))


def test_sand_without_a_surcharge_runs_and_is_remarked_on() -> None:
    """The stress at mudline is 0, not that of a metre of soil; every value by default is in the list."""
    scene = parse_scene(SAND)
    assert float(scene.ground.vertical_stress(np.array(2.0))) == pytest.approx(19e3)
    (remark,) = remarks(scene)
    assert remark.startswith("layer 'soil' has no strength at mudline: soil.surcharge is 0")
    rows = {row["key"]: (row["value"], row["unit"]) for row in defaulted(scene, {"caisson.vertical_load": 1.5e6})}
    assert rows["soil.surcharge"] == (0.0, "kPa") and rows["caisson.outer_diameter"] == (7.8, "m")
    assert rows["soil.friction_angle_initial"][0] == pytest.approx(19.47, abs=0.01)  # holds K0
    assert rows["caisson.vertical_load"] == (1.5, "MN") and rows["domain.radius"] == (312.0, "m")
    assert "hydraulic_conductivity" not in str(rows) and "caisson.young_modulus" not in rows
    assert remarks(parse_scene(SAND + 'surcharge = "5 kPa"\n')) == []
    sealed = parse_scene(SAND + 'surcharge = "5 kPa"\n[interface]\nopening = "sealed"\n')  # pulled out as a vented one
    assert remarks(sealed) == ["interface.opening: sealed is vented here, since drained soil holds no suction"]
    assert remarks(sealed.replace(interface={"opening": "bonded"})) == []
    scene = parse_scene('[caisson]\nbehaviour = "elastic"\n' + SAND + 'surcharge = "5 kPa"\n')
    (bends,), (bricks,) = remarks(scene), remarks(scene.replace(mesh={"discretisation": "hex8"}))
    assert "lid bends as a plate of 0.4 m without stiffeners" in bends and bricks.startswith(f"{bends}; bricks hold")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SAND + '[springs]\nmemory = true\nvertical_loads = ["1 MN"]\n', "vertical_loads, memory: no effect"),
        (SAND + '[springs]\nreach = "1 mm"\nrates = ["1 mm/s", "9 mm/s"]\n', "computed 2 times, all the same"),
        (CLAY.replace("[soil]\n", f"[soil]\n{OF_CLAY}") + "friction_coefficient = 0.4\n", "coefficient has no effect"),
    ],
)  # fmt: skip
def test_keys_without_effect_are_named(text: str, words: str) -> None:
    assert sum(words in each for each in remarks(parse_scene(text))) == 1


def test_values_by_default_come_through_texts_copies_and_changes() -> None:
    scene = parse_scene(SAND + "[interface]\nfriction_coefficient = 0.5\n")
    known = defaulted(scene)
    assert "interface.friction_coefficient" not in {row["key"] for row in known}
    for twin in (parse_scene(scene.to_toml()), scene.replace(title="other"), scene.model_copy()):
        assert defaulted(twin) == known
    assert '\n# lid_thickness = "0.4 m"\n' in scene.to_toml()


def test_values_by_default_of_layers_stand_apart_where_they_differ() -> None:
    scene = parse_scene(
        SAND + '[[soil.layer]]\ntop = "0 m"\n[[soil.layer]]\ntop = "2 m"\nlaw = "tresca"\n'
        'undrained_shear_strength = "300 kPa"\n[interface]\nadhesion_factor = 0.5\n'
    )
    rows = {row["key"]: row["value"] for row in defaulted(scene)}
    assert (rows["soil.layer[0].poisson_ratio"], rows["soil.layer[1].poisson_ratio"]) == (0.3, 0.495)
    assert rows["soil.yield_surface"] == "drucker-prager"


def test_su_of_zero_under_a_surcharge_names_the_surcharge() -> None:
    clay = CLAY.replace("[interface]", 'rigidity_ratio = 200\neffective_unit_weight = "7 kN/m^3"\nK0 = 0.6\n'
                        'undrained_shear_strength = { top = "0 kPa", gradient = "2 kPa/m" }\n[interface]')  # fmt: skip
    assert any("no strength at mudline: su is 0 there" in each for each in remarks(parse_scene(clay)))
    found = missing(clay.replace("[soil]", '[soil]\nsurcharge = "10 kPa"'))
    assert found["soil.surcharge"].startswith("K0 0.6 with a vertical effective stress of 10 kPa (surcharge 10 kPa)")


SLIPS = [
    ('young_modulus = "80 MPa"', 'young_modulus = "80 GPa"', "shear_modulus", "1000 times too large"),
    ("K0 = 0.5", 'K0 = 0.5\ncohesion = "1 MPa"', "cohesion", "1000 times too large"),
    ('"9.5 kN/m^3"', '"95 kN/m^3"', "effective_unit_weight", "10 times too large"),
    ("[caisson]", '[caisson]\nvertical_load = "6000 MN"', "caisson.vertical_load", "1000 times too large"),
    ("[caisson]", '[caisson]\nvertical_load = "6 kN"', "caisson.vertical_load", "1000 times too small"),
    ("[caisson]", "[interface]\nfriction_coefficient = 5", "interface.friction_coefficient", "10 times too large"),
    ("[caisson]", '[caisson]\nskirt_thickness = "450 mm"', "caisson.skirt_thickness", "10 times too large"),
    ("[caisson]", '[springs]\nreach = "9 um"', "springs.reach", "1000 times too small"),
    ("[caisson]", '[drainage]\nwater_depth = "19000 m"', "drainage.water_depth", "1000 times too large"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "words"), SLIPS)
def test_a_slip_by_a_factor_is_named_with_what_was_meant(old: str, new: str, key: str, words: str) -> None:
    """By a scene, whose check has the same remark, and by a row of a profile."""
    text = SAND + 'surcharge = "5 kPa"\n[caisson]\n'
    assert remarks(parse_scene(text)) == []
    found = remarks(parse_scene(text.replace(old, new, 1)))
    assert found and all(key in each for each in found)
    assert words in found[0] and "outside the common range" in found[0]


def test_a_dead_load_that_pulls_is_named_with_the_sign_of_V() -> None:
    """Of a table with z up the weight is -2 MN; as an uplift it leaves sand without stress."""
    (found,) = remarks(parse_scene(SAND + 'surcharge = "5 kPa"\n[caisson]\nvertical_load = "-2 MN"\n'))
    assert found == "caisson.vertical_load: -2 MN pulls the caisson up: V is positive down"


def test_every_number_of_the_ground_and_the_caisson_has_a_range() -> None:
    """Keys without one are words, shares of others, or settings of the computation."""
    free = {"young_modulus", "shear_modulus", "rigidity_ratio", "overconsolidation_ratio", "degradation_limit",
            "friction_angle_initial", "surcharge"}  # fmt: skip
    scene = tiny.sand()
    keys = {*type(scene.soil).model_fields} - free - {"yield_surface", "layers", *TABLES}
    assert [key for key in keys if plain_field(key).common is None] == []
    numbers = {f"caisson.{key}" for key in type(scene.caisson).model_fields} - {"caisson.behaviour"}
    assert numbers <= {*RANGES}


def test_rows_of_a_profile_are_refused_and_remarked_on_as_layers_are(tmp_path) -> None:
    (tmp_path / "c.toml").write_text('[soil]\nK0 = 0.5\nprofile = "site.csv"\n')
    rows = "Depth from [m],Soil type,Effective unit weight [kN/m3],E [MPa]\n0,SAND,9,80\n3,CLAY,8,\n"
    (tmp_path / "site.csv").write_text(rows)
    found = {each.key: each.message.partition(";")[0] for each in tiny.problems(load_scene, tmp_path / "c.toml")}
    assert found == {
        "soil.layer[1].young_modulus": "missing in layer 'CLAY'",
        "soil.layer[0].friction_angle_final": "missing in layer 'SAND', 'CLAY'",
    }
    (tmp_path / "site.csv").write_text("Depth from [m],Effective unit weight [kN/m3],phi [deg],E [MPa]\n0,95,35,80\n")
    assert any("10 times too large" in each for each in remarks(load_scene(tmp_path / "c.toml")))


def test_check_lists_defaults_and_the_run_keeps_them(tmp_path) -> None:
    (tmp_path / "c.toml").write_text(SAND + '[domain]\nradius = "24 m"\ndepth = "12 m"\n[mesh]\nrefinement = 0.4\n')
    about = json.loads(command("check", str(tmp_path / "c.toml"), "--json").out)
    rows = {row["key"]: row for row in about["defaulted"]}
    assert rows["caisson.vertical_load"]["value"] == pytest.approx(1e-6 * about["vertical_load_N"])
    assert rows["interface.normal_stiffness"]["unit"] == "N/m^3"
    assert any("no strength at mudline" in each for each in about["warnings"])
    text = command("check", str(tmp_path / "c.toml")).out
    assert "defaults, which this scene does not give:" in text and "soil.surcharge" in text
    result = tiny.result()
    assert "soil.cohesion 0 kPa" in result.attrs["defaulted"]
    assert json.loads(result.attrs["run_json"])["defaulted"]
    assert defaulted_text([{"key": "soil.K0", "value": 1.0, "unit": "1"}]) == "soil.K0 1"
