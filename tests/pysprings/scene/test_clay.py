# SPDX-License-Identifier: MIT
"""Undrained clay in a scene: values by depth, what is refused, text and numbers of a scene, adhesion factors."""

import re

import numpy as np
import pytest

from fe_engine.soil import anisotropic, iwan_clay
from pysprings.model.forecast.estimate import profile
from pysprings.model.soil_laws import soil_materials
from pysprings.scene.defaults import defaulted, implausible
from pysprings.scene.interface import api_factor
from tests.support import tiny

CLAY = """\
[soil]
yield_surface = "tresca"
undrained_shear_strength = { top = "5 kPa", gradient = "2 kPa/m" }
rigidity_ratio = 200
effective_unit_weight = "6 kN/m^3"
surcharge = "0 kPa"
[interface]
adhesion_factor = 0.65
opening = { outside = "vented", inside = "sealed", lid = "sealed", tip = "bonded" }
[domain]
radius = "24 m"
depth = "12 m"
"""
SAND_OVER_CLAY = """\
[soil]
K0 = 0.6
friction_angle_initial = "auto"
[interface]
adhesion_factor = "api"
[[soil.layer]]
top = "0 m"
name = "sand"
young_modulus = "60 MPa"
[[soil.layer]]
top = "2 m"
name = "clay"
law = "von-mises"
drainage = "total-stress"
undrained_shear_strength = { top = "40 kPa", bottom = "60 kPa" }
shear_modulus = { reference = "5 MPa", reference_depth = "2 m", exponent = 1 }
strain_at_half_strength = 0.01
[domain]
radius = "24 m"
depth = "12 m"
"""


def test_strength_and_stiffness_follow_the_depth():
    ground, depth = tiny.parsed(CLAY).ground, np.array([0.0, 3.0, 12.0])
    assert ground.strength(depth) == pytest.approx(5e3 + 2e3 * depth)
    wanted = 2.0 * 1.495 * 200.0 * (5e3 + 2e3 * depth)
    assert ground.value("young_modulus", depth) == pytest.approx(wanted, rel=1e-12)
    assert not ground.is_uniform


@pytest.mark.parametrize(
    ("given", "young"),
    [
        ("rigidity_ratio = 100", 2.0 * 1.495 * 100.0 * 9e3),
        ('shear_modulus = "2 MPa"', 2.0 * 1.495 * 2e6),
        ('young_modulus = "7 MPa"', 7e6),
        ('shear_modulus = { top = "1 MPa", gradient = "1 MPa/m" }', 2.0 * 1.495 * 3e6),
    ],
)
def test_one_of_three_keys_gives_the_stiffness(given, young):
    ground = tiny.parsed(CLAY.replace("rigidity_ratio = 200", given)).ground
    assert float(ground.value("young_modulus", np.array(2.0))) == pytest.approx(young, rel=1e-12)


def test_clay_holds_its_volume_unless_a_ratio_is_given():
    scene = tiny.parsed(SAND_OVER_CLAY)
    ground = scene.ground
    assert ground.value("poisson_ratio", np.array([1.0, 3.0])).tolist() == [0.3, 0.495]
    one = tiny.parsed(SAND_OVER_CLAY.replace("[soil]", "[soil]\npoisson_ratio = 0.4"))
    assert one.ground.value("poisson_ratio", np.array([1.0, 3.0])).tolist() == [0.4, 0.4]


@pytest.mark.parametrize("text", [CLAY, SAND_OVER_CLAY])
def test_scenes_of_clay_come_through_text_and_numbers(text):
    scene = tiny.parsed(text)
    for twin in (tiny.parsed(scene.to_toml()), scene.replace(title=scene.title), tiny.sand(**scene.model_dump())):
        assert twin == scene
        assert twin.sha256 == scene.sha256


def test_every_new_key_counts_in_the_number_of_a_scene():
    numbers = {tiny.parsed(CLAY).sha256}
    for old, new in (
        ("2 kPa/m", "3 kPa/m"), ("200", "201"), ("0.65", "0.6"), ('lid = "sealed"', 'lid = "bonded"'),
        ("tresca", "von-mises"), ("rigidity", "strain_at_half_strength = 0.01\nrigidity"),
    ):  # fmt: skip
        assert old in CLAY
        numbers.add(tiny.parsed(CLAY.replace(old, new, 1)).sha256)
    assert len(numbers) == 7


def test_water_of_a_layer_is_that_of_its_law():
    assert tiny.parsed(CLAY).layer_drainage == "total-stress"
    assert tiny.parsed(SAND_OVER_CLAY).layer_drainage == "drained, total-stress"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("rigidity", 'friction_angle_final = "30 deg"\nrigidity', r"^4:24: soil.friction_angle_final: is not used by"),
        ('yield_surface = "tresca"', "", r"soil.undrained_shear_strength: is not used by law"),
        ("rigidity_ratio = 200", "", r"^2:17: soil.rigidity_ratio: missing; law \"tresca\" needs it, or shear_modulus"),
        ("rigidity", 'shear_modulus = "2 MPa"\nrigidity', r"^5:18: soil.rigidity_ratio: give one of shear_modulus"),
        ("2 kPa/m", "-2 kPa/m", r"^3:28: soil.undrained_shear_strength: -\S+ kPa at a depth of \S+ m"),
        ('{ top = "5 kPa", gradient = "2 kPa/m" }', '"0 kPa"', r"^3:28: soil.undrained_shear_strength: 0: a soil"),
        ("adhesion_factor = 0.65", "", r"^7:1: interface.adhesion_factor: missing; undrained clay beside the caisson"),
        ("0.65", '"apii"', r'adhesion_factor: expected a number or "api", got "apii" \(did you mean \'api\'\?\)'),
        ("0.65", "{ outside = 2, inside = 0.5, lid = 1 }", r"adhesion_factor: tip: missing .*; outside: 2 is not in"),
        ('lid = "sealed"', 'lid = "open"', r'interface.opening: lid: expected one of "vented", "sealed", "bonded"'),
        ("rigidity", "strain_at_half_strength = 0.002\nrigidity", r"strain_at_half_strength: 0.002 must be at"),
        ("rigidity", "K0 = 0.1\nrigidity", r"soil.K0: K0 0.1 with .* puts an initial shear stress of \S+ kPa into a"),
        ('"6 kN/m^3"', '"0 kN/m^3"\n', None),
    ],
)  # fmt: skip
def test_clay_that_cannot_be_is_refused_with_its_place(old, new, message):
    assert old in CLAY
    text = CLAY.replace(old, new, 1)
    if message is None:
        assert tiny.parsed(text)
        text, message = text.replace("0.65", '"api"'), r'adhesion_factor: "api" needs a vertical effective stress'
    found = tiny.messages(text)
    assert any(re.search(message, each) for each in found), found


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"total-stress"', '"drained"', r'^14:12: soil.layer\[1\].drainage: must be "total-stress"'),
        ('name = "sand"', 'drainage = "coupled"', r'soil.layer\[0\].drainage: must be "drained": drainage.mode is'),
        ('name = "sand"', 'drainage = "drained"\n[drainage]\nmode = "undrained"\n',
         r'drainage.mode: must be "drained": no layer has a pore pressure'),
        ('name = "clay"', 'friction_angle_final = "30 deg"', r"soil.layer\[1\].friction_angle_final: is not used"),
        ('name = "sand"', "rigidity_ratio = 100", r"soil.layer\[0\].rigidity_ratio: is not used by"),
        ("K0 = 0.6", 'K0 = 0.6\nundrained_shear_strength = { top = "1 kPa", gradient = "1 kPa/m" }',
         r"soil.undrained_shear_strength: a table by depth stands in a layer where there are layers"),
        ('law = "von-mises"\n', "", r"soil.layer\[1\].undrained_shear_strength: is not used"),
    ],
)  # fmt: skip
def test_sand_over_clay_that_cannot_be_is_refused(old, new, message):
    assert old in SAND_OVER_CLAY
    found = tiny.messages(SAND_OVER_CLAY.replace(old, new, 1))
    assert any(re.search(message, each) for each in found), found


def test_water_may_stand_beside_clay_and_in_some_layers_of_sand():
    wet = tiny.parsed(SAND_OVER_CLAY + '[drainage]\nmode = "undrained"\n')
    assert wet.layer_drainage == "total-stress, undrained"
    depth = np.array([1.0, 2.0, 2.1])
    assert list(wet.ground.holds_water(depth, "undrained")) == [True, True, False]
    assert not wet.ground.holds_water(depth, "drained").any()
    text = SAND_OVER_CLAY.replace('name = "sand"', 'drainage = "drained"')
    text = text.replace('[[soil.layer]]\ntop = "2 m"', '[[soil.layer]]\ntop = "1 m"\n[[soil.layer]]\ntop = "2 m"')
    mixed = tiny.parsed(text + '[drainage]\nmode = "undrained"\n')
    assert list(mixed.ground.holds_water(depth, "undrained")) == [False, True, False]
    assert mixed.layer_drainage == "drained, total-stress, undrained"
    (message,) = tiny.messages(text.replace('drainage = "drained"', 'drainage = "total-stress"'))
    assert 'soil.layer[0].drainage: must be "drained"' in message


FACTORS = "compression_factor = 1.3\nextension_factor = 0.7\n"
ANISOTROPIC = CLAY.replace('"tresca"', '"von-mises"').replace("rigidity_ratio", FACTORS + "rigidity_ratio")


def test_factors_of_su_choose_the_law_and_are_printed_by_depth():
    scene = tiny.parsed(ANISOTROPIC)
    assert tiny.parsed(scene.to_toml()) == scene
    (material, *_), _ = soil_materials(scene, np.array([[1.0, 3.0]]))
    assert material.law is anisotropic.LAW
    strengths = material.parameters[0, :, anisotropic.COMPRESSION :]
    assert strengths == pytest.approx(np.outer([7e3, 11e3], [1.3, 1.0, 0.7]))
    bottom = profile(scene)[1]
    names = ("compression", "direct_shear", "extension")
    assert [bottom[f"su_{name}_Pa"] for name in names] == pytest.approx([29e3 * f for f in (1.3, 1.0, 0.7)])
    assert tiny.parsed(CLAY).sha256 != scene.sha256
    assert "su_compression_Pa" not in profile(tiny.parsed(CLAY))[0]
    assert [row["value"] for row in defaulted(scene) if row["key"].endswith("_factor")] == [1.0]  # of direct shear


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"von-mises"', '"tresca"', r'compression_factor: is not used by law "tresca"'),
        ("rigidity", "strain_at_half_strength = 0.02\nrigidity", r"compression_factor: cannot be used with strain_at"),
        ("1.3", "0.2", r"compression_factor: compression and extension \(0.2 \+ 0.7\) must be more than direct shear"),
        ("1.3", "9", r"compression_factor: 9 is not in \[0.1, 5\]"),
        ("rigidity", "K0 = 3\nrigidity", r"soil.K0: K0 3 with .* puts an initial shear stress of -\S+ kPa into a soil"),
    ],
)  # fmt: skip
def test_factors_of_su_that_cannot_be_are_refused(old, new, message):
    found = tiny.messages(ANISOTROPIC.replace(old, new, 1))
    assert any(re.search(message, each) for each in found), found


REDUCED = CLAY.replace('"tresca"', '"iwan-clay"').replace(
    "rigidity", "shear_modulus_reduction = [[1e-4, 0.9], [1e-3, 0.5], [1e-2, 0.1]]\nrigidity", 1
)


def test_a_table_of_the_secant_modulus_is_the_backbone_of_a_layer():
    """tau = G gamma G/G_0 at the points of the table, at every depth; a layer has its own, or that of [soil]."""
    scene = tiny.parsed(REDUCED)
    assert tiny.parsed(scene.to_toml()) == scene != tiny.parsed(CLAY.replace('"tresca"', '"iwan-clay"'))
    (material, *_), _ = soil_materials(scene, np.array([[1.0, 3.0]]))
    own = iwan_clay.pack_table(2.0 * 1.495 * 200.0 * np.array([7e3, 11e3]), 0.495, np.array([7e3, 11e3]), *np.array(
        [(1e-4, 0.9), (1e-3, 0.5), (1e-2, 0.1)]).T)  # fmt: skip
    np.testing.assert_allclose(material.parameters[0], own, rtol=1e-12)
    layered = REDUCED + '[[soil.layer]]\ntop = "0 m"\nundrained_shear_strength = "50 kPa"\n'
    layered = layered.replace('{ top = "5 kPa", gradient = "2 kPa/m" }', '"50 kPa"')
    given = layered + "shear_modulus_reduction = [[1e-4, 0.8], [1e-2, 0.1]]\n"
    rows = [soil_materials(tiny.parsed(text), np.array([[1.0]]))[0][0].parameters for text in (layered, given)]
    assert not np.allclose(rows[0], rows[1])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("iwan-clay", "von-mises", 'is not used by law "von-mises": it is that of "iwan-clay"'),
        ("rigidity", "strain_at_half_strength = 0.02\nrigidity", "cannot be used with strain_at_half_strength"),
        ("0.1]]", "0.6]]", r"row 3: G/G_0 must not be more than in the row before \(0.5\)"),
        ("0.1]]", "0.04]]", "row 3: the stress, G times strain, must be more than in the row before"),
        ("0.9]", "0.5]", r"row 1: the stress must rise less steeply after it than before \(slopes 0.5, 0.5 G_0"),
        ("[1e-3, 0.5]", "[1e-5, 0.5]", "row 2: the strain must be more than that of the row before"),
        ("0.9]", "1.9]", r"row 1: G/G_0 1.9 is not in \(0, 1\]"),
        ("[1e-3, 0.5], [1e-2, 0.1]", "", r"expected 2 to 10 pairs \[shear strain, G/G_0\] such as"),
        ("0.5], [1e-2, 0.1]", '"half"]', "expected 2 to 10 pairs"),
        ("200", "2000", r"gives \S+ kPa at a shear strain of 0.01, more than su"),
    ],
)  # fmt: skip
def test_tables_of_the_secant_modulus_that_cannot_be_are_refused(old, new, message):
    found = tiny.messages(REDUCED.replace(old, new, 1))
    assert any(re.search("shear_modulus_reduction: .*" + message, each) for each in found), found


def test_small_strain_stiffness_follows_from_plasticity_and_overconsolidation():
    """Andersen (2015): 100 kPa (s'_v0/100 kPa)^0.9 (30 + 75/(I_p/100 + 0.03)) OCR^0.5."""
    plastic = "plasticity_index = 27\noverconsolidation_ratio = 4"
    scene = tiny.parsed(CLAY.replace("rigidity_ratio = 200", plastic))
    assert tiny.parsed(scene.to_toml()) == scene
    bottom = profile(scene)[1]
    stress = bottom["vertical_effective_stress_Pa"]
    assert bottom["shear_modulus_Pa"] == pytest.approx(100e3 * (stress / 100e3) ** 0.9 * 280.0 * 2.0)
    (message,) = tiny.messages(CLAY.replace("rigidity_ratio", "overconsolidation_ratio = 2\nrigidity_ratio"))
    assert "soil.overconsolidation_ratio: needs a plasticity_index" in message
    (message,) = tiny.messages(CLAY.replace("rigidity_ratio", "plasticity_index = 20\nrigidity_ratio"))
    assert "give one of rigidity_ratio, plasticity_index" in message
    (message,) = tiny.messages(SAND_OVER_CLAY.replace('name = "sand"', "plasticity_index = 20"))[:1]
    assert "soil.layer[0].plasticity_index" in message


def test_all_problems_of_clay_come_at_once():
    text = SAND_OVER_CLAY.replace('"total-stress"', '"drained"').replace(
        'young_modulus = "60 MPa"', "rigidity_ratio = 100"
    )
    text = text.replace('name = "clay"', 'cohesion = "5 kPa"').replace('adhesion_factor = "api"', "")
    keys = [re.search(r": (\S+): ", each)[1] for each in tiny.messages(text)]
    assert keys == [
        "interface.adhesion_factor", "soil.layer[0].rigidity_ratio", "soil.layer[1].cohesion", "soil.layer[1].drainage",
    ]  # fmt: skip


def test_adhesion_in_sand_refers_to_its_cohesion():
    text = '[interface]\nadhesion_factor = 0.8\n[soil]\ncohesion = "5 kPa"\n'
    assert tiny.parsed(text)
    (message,) = tiny.messages(text.replace('cohesion = "5 kPa"', ""))
    assert "refers to undrained_shear_strength or cohesion" in message
    assert any("has neither" in each for each in tiny.messages(text.replace("0.8", '"api"')))


def test_the_api_factor_has_its_published_values():
    """API RP 2GEO (2011), section 8.1.3: alpha = 0.5 psi^-0.5 for psi <= 1, 0.5 psi^-0.25 beyond, at most 1."""
    strength = np.array([25.0, 50.0, 100.0, 400.0, 10.0, 0.0, 5.0])
    stress = np.array([100.0, 100.0, 100.0, 25.0, 100.0, 10.0, 0.0])
    wanted = [1.0, 0.5**0.5, 0.5, 0.25, 1.0, 1.0, 0.0]
    assert api_factor(strength, stress) == pytest.approx(wanted)


def test_check_prints_strength_and_adhesion_by_depth():
    top, bottom = profile(tiny.parsed(CLAY))
    assert (top["undrained_shear_strength_Pa"], bottom["undrained_shear_strength_Pa"]) == pytest.approx((5e3, 29e3))
    assert bottom["shear_modulus_Pa"] == pytest.approx(200 * 29e3)
    assert top["adhesion_factor_outside"] == 0.65
    assert "friction_angle_deg" not in top
    sand = profile(tiny.paper())[0]
    assert "adhesion_factor_outside" not in sand
    over_clay = '[[soil.layer]]\ntop = "0 m"\nlaw = "drucker-prager"\n[[soil.layer]]\ntop = "0.5 m"\nlaw = "tresca"\n'
    head = '[interface]\nadhesion_factor = 0.5\n[soil]\nundrained_shear_strength = "9 kPa"\n'
    both = profile(tiny.parsed(head + over_clay))  # sand without cohesion has none
    assert [row.get("adhesion_factor_inside") for row in both[:3]] == [None, None, 0.5]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("= 200", "= 5000", "G/su at 0.667 m: 5e+03 is outside"),
        ("rigidity", "poisson_ratio = 0.4\nrigidity", "poisson_ratio below 0.48"),
        ("2 kPa/m", "0.1 kPa/m", "su over the vertical effective stress at"),
        ("rigidity_ratio = 200", "plasticity_index = 30", "holds up to su without strain_at_half_strength"),
        ("0.65", "0.05", "adhesion factor inside at 0.667 m: 0.05 is outside"),
        ("5 kPa", "5 MPa", "5e+03 kPa is outside the common range 0.5 to 300 kPa: 1000 times too large? 5 kPa"),
    ],
)
def test_unusual_clay_is_named(old, new, words):
    assert not [text for text in implausible(tiny.parsed(CLAY)) if words in text]
    assert old in CLAY
    assert [text for text in implausible(tiny.parsed(CLAY.replace(old, new, 1))) if words in text]
    assert implausible(tiny.sand()) == []
    gmax = CLAY.replace("rigidity_ratio = 200", "plasticity_index = 30")  # falls along a hyperbola
    falling = gmax.replace('"tresca"', '"iwan-clay"'), gmax.replace("[int", "strain_at_half_strength = 0.02\n[int", 1)
    assert not [text for each in falling for text in implausible(tiny.parsed(each)) if "holds up to su" in text]


@pytest.mark.parametrize(
    ("law", "keys", "why"),
    [
        (
            "drucker-prager",
            {"undrained_shear_strength": 5e4, "rigidity_ratio": 200.0, "strain_at_half_strength": 0.01},
            'it is that of "tresca", "von-mises", "iwan-clay"',
        ),
        (
            "tresca",
            {
                "friction_angle_initial": 0.1, "friction_angle_final": 0.5, "hardening_parameter": 0.01,
                "dilation_angle": 0.1, "cohesion": 1e3,
            },
            "its strength is undrained_shear_strength",
        ),
        ("tresca", {"compression_factor": 1.2}, 'it is that of "von-mises", "iwan-clay"'),
    ],
)  # fmt: skip
def test_keys_of_other_laws_are_named_in_the_order_of_the_reference(law, keys, why):
    backwards = dict(reversed(keys.items()))
    with pytest.raises(ValueError, match="is not used by law") as refused:
        tiny.sand(soil={"yield_surface": law, **backwards})
    text = str(refused.value)
    messages = [f'soil.{key}: is not used by law "{law}": {why}' for key in keys]
    assert [text.count(message) for message in messages] == [1] * len(keys)
    assert [text.index(message) for message in messages] == sorted(text.index(message) for message in messages)


def test_kinematic_clay_without_a_strain_has_the_hyperbola_of_its_stiffness():
    """Half of su is then mobilised at su/G."""
    base = {"yield_surface": "iwan-clay", "undrained_shear_strength": 2e4, "rigidity_ratio": 100.0}
    found = []
    for soil in (base, base | {"strain_at_half_strength": 0.01}):
        materials, _ = soil_materials(tiny.sand(soil=soil, interface={"adhesion_factor": 1.0}), np.array([[1.0, 1.0]]))
        found.append(materials[0].parameters.reshape(-1, materials[0].parameters.shape[-1])[0])
    np.testing.assert_allclose(*found, rtol=1e-12, atol=1e-15)


def test_kinematic_sand_refuses_dilation_and_takes_any_first_yield():
    sand = {"yield_surface": "iwan-sand", "K0": 0.5, "friction_angle_initial": 0.02}
    materials, _ = soil_materials(tiny.sand(soil=sand), np.array([[1.0, 3.0], [2.0, 5.0]]))
    assert materials[0].parameters.shape[:2] == (2, 2)
    with pytest.raises(ValueError, match="dilation_angle: 3 deg would change the volume in every cycle"):
        tiny.sand(soil=sand | {"dilation_angle": np.radians(3.0)})
    with pytest.raises(ValueError, match="outside the yield surface"):
        tiny.sand(soil=sand | {"K0": 0.1})
