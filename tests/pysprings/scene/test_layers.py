# SPDX-License-Identifier: MIT
"""Layers of the soil: values by depth, geostatic stress, text and numbers of a scene, refusals with their places."""

import pickle
import re

import numpy as np
import pytest
from scipy.integrate import quad

from pysprings.model.fourier import build
from pysprings.scene.defaults import implausible, remarks
from pysprings.scene.load import parse_scene
from pysprings.scene.sections import PAPER
from pysprings.scene.template import template_text
from pysprings.studies.sweep.study_file import read_study
from tests.support import tiny

LAYERS = """\
[soil]
K0 = 1.1
surcharge = "5 kPa"
[[soil.layer]]
top = "0 m"
name = "loose"
young_modulus = { reference = "80 MPa", reference_stress = "100 kPa", exponent = 0.5 }
friction_angle_final = { top = "28 deg", bottom = "32 deg" }
effective_unit_weight = { top = "8 kN/m^3", bottom = "10 kN/m^3" }
[[soil.layer]]
top = "2 m"
name = "dense"
law = "van-eekelen"
young_modulus = { top = "80 MPa", gradient = "5 MPa/m" }
effective_unit_weight = "11 kN/m^3"
[[soil.layer]]
top = "6 m"
young_modulus = { reference = "90 MPa", reference_depth = "5 m", depth_offset = "1 m", exponent = 1.0 }
[domain]
radius = "24 m"
depth = "12 m"
"""


def weight(depth: float) -> float:
    """Unit weight of the layers, N/m3."""
    return 8e3 + 1e3 * depth if depth < 2 else 11e3 if depth < 6 else 10.56e3


def test_values_follow_their_layers():
    ground = tiny.parsed(LAYERS).ground
    depth = np.array([1.0, 3.0, 8.0])
    stress = np.array([5e3 + quad(weight, 0, z, points=[2, 6])[0] for z in depth])
    assert ground.vertical_stress(depth) == pytest.approx(stress, rel=1e-9)
    mean = stress[0] * 3.2 / 3.0
    wanted = [80e6 * (mean / 100e3) ** 0.5, 85e6, 90e6 * 9.0 / 5.0]
    assert ground.value("young_modulus", depth) == pytest.approx(wanted, rel=1e-12)
    assert np.degrees(ground.value("friction_angle_final", depth)) == pytest.approx([30.0, 30.0, 30.0])
    assert [each.law for each in ground.strata] == ["drucker-prager", "van-eekelen", "drucker-prager"]
    assert ground.lines == (2.0, 6.0)


def test_a_boundary_belongs_to_the_layer_above_and_stress_passes_it_smoothly():
    ground = tiny.parsed(LAYERS).ground
    assert ground.number(np.array([0.0, 2.0, 2.001, 6.0, 12.0])).tolist() == [0, 0, 1, 1, 2]
    above, below = ground.vertical_stress(np.array([2.0, 2.0 + 1e-7]))
    assert below - above == pytest.approx(11e3 * 1e-7, rel=1e-3)


def test_a_soil_without_layers_is_one():
    scene = tiny.sand(domain=PAPER)
    ground, depth = scene.ground, np.linspace(0.0, 12.0, 7)
    assert ground.lines == ()
    wanted = scene.soil.surcharge + scene.soil.effective_unit_weight * depth
    assert np.array_equal(ground.vertical_stress(depth), wanted)  # bit by bit: scenes of before give the same results


def test_layers_come_through_text_numbers_and_pickles():
    scene = tiny.parsed(LAYERS)
    for twin in (tiny.parsed(scene.to_toml()), pickle.loads(pickle.dumps(scene)), scene.replace(title=scene.title)):
        assert twin == scene
        assert twin.sha256 == scene.sha256
    assert scene.sha256 != tiny.parsed(LAYERS.replace("5 MPa/m", "6 MPa/m")).sha256


def test_scenes_without_layers_keep_their_number():
    """Folders of runs are named by it."""
    scene = tiny.paper()
    assert scene.title == "Suction caisson"  # of a scene without one: no ground, and no drainage, that it may not have
    assert (
        scene.replace(title="Suction caisson in sand, drained").sha256
        == "8d352a2c5c40eed6ee7e9a7843533bf8b9d2cb5f7101cbd5c63ac320abb558b5"
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"2 m"', '"0 m"', r"^11:7: soil.layer\[1\].top: 0 m must be below the top of the layer before \(0 m\)"),
        ('"6 m"', '"12 m"', r"^17:7: soil.layer\[2\].top: 12 m is not above the bottom of the domain \(12 m\)"),
        ('top = "0 m"', 'top = "1 m"', r"soil.layer\[0\].top: 1 m: the first layer begins at mudline"),
        ('top = "0 m"\n', "", r"soil.layer\[0\].top: missing; every \[\[soil.layer\]\] needs it"),
        ("5 MPa/m", "-50 MPa/m", r"^14:17: soil.layer\[1\].young_modulus: \S+ MPa at a depth of \S+ m is not in"),
        ("5 MPa/m", "5 MPa", r'young_modulus: gradient: "5 MPa" is a pressure or stress; expected a force per volume'),
        (
            "exponent = 0.5",
            "power = 0.5",
            r"young_modulus: a value by depth has the keys .*, got reference, reference_s",
        ),
        ("exponent = 1.0", "exponent = 9", r"young_modulus: exponent: 9 is not in \[0, 2\]"),
        ('law = "van-eekelen"', 'law = "tresque"', r'^13:7: soil.layer\[1\].law: "tresque" is not one of'),
        ('name = "dense"', 'nam = "dense"', r"^12:1: soil.layer\[1\].nam: unknown key \(did you mean 'name'\?\)"),
        ("K0 = 1.1", "K0 = 0.5", r"^2:6: soil.K0: layer 'loose': 0.5 puts the initial stress outside"),
    ],
)
def test_wrong_layers_are_refused_with_their_place(old, new, message):
    assert old in LAYERS
    found = tiny.messages(LAYERS.replace(old, new, 1))
    assert any(re.search(message, each) for each in found), found


def test_all_problems_of_layers_come_at_once():
    text = LAYERS.replace("11 kN/m^3", "11").replace('"5 MPa/m"', "5").replace('name = "loose"', 'nme = "loose"')
    assert len(tiny.messages(text)) == 3


_ELASTIC = "young_modulus = '80 MPa', K0 = 1.0, effective_unit_weight = '9 kN/m^3'"


@pytest.mark.parametrize(
    "old, new", [('top = "3 m" ', 'top = "3 kN"'), ('top = "3 m" ', ""), ('law = "tresca"', 'law = "tresque"')]
)
def test_a_layer_that_cannot_be_read_is_the_only_fault(old, new):
    """The others are not read as ground of another law, nor the ground as one without layers."""
    text = template_text("sand-over-clay").replace(old, new)
    (found,) = tiny.problems(parse_scene, text)
    assert str(found.key).startswith("soil.layer[1].")
    clay = '[soil]\nyield_surface = "tresque"\nundrained_shear_strength = "9 kPa"\n[interface]\nadhesion_factor = 1\n'
    assert [each.key for each in tiny.problems(parse_scene, clay)] == ["soil.yield_surface"]


def test_a_value_of_the_soil_that_no_layer_takes_has_no_effect(tmp_path):
    """In a file it is remarked on; as a changed value, or an axis of a study, it is refused: the answer would be that
    without it."""
    text = template_text("sand-over-clay")
    beside = text.replace(
        "[soil]\n", '[soil]\nK0 = 0.7\nyield_surface = "elastic"\nhydraulic_conductivity = "1e-5 m/s"\n'
    )
    assert [each for each in remarks(parse_scene(beside)) if "no effect" in each] == [
        "soil.yield_surface has no effect: every layer has its own", "soil.K0 has no effect: every layer has its own",
    ]  # fmt: skip
    assert remarks(parse_scene(text)) == []
    for key, value in (("K0", "0.7"), ("rigidity_ratio", "200"), ("law", "elastic"), ("shear_modulus", "9 MPa")):
        own, key = key, "yield_surface" if key == "law" else key
        (found,) = tiny.problems(parse_scene, text, None, [f"soil.{key}={value}"])
        assert (found.key, found.message.partition("; ")[2]) == (
            f"soil.{key}", f"change that of a layer, soil.layer.NAME.{own}",
        )  # fmt: skip
    assert parse_scene(text, None, ["soil.layer.clay.K0=0.7"]).soil.layers[1].K0 == 0.7
    whole = f"soil={{surcharge = '9 kPa', layer = [{{top = '0 m', law = 'elastic', {_ELASTIC}}}]}}"
    assert parse_scene("", None, [whole, "interface.friction_coefficient=0.3"]).soil.surcharge == 9e3
    (tmp_path / "base.toml").write_text(text, encoding="utf-8")
    axis = '[[axis]]\nkey = "soil.friction_angle_final"\nvalues = ["33 deg", "36 deg"]\n'
    (tmp_path / "study.toml").write_text(f'scene = "base.toml"\n{axis}', encoding="utf-8")
    (found,) = tiny.problems(read_study(tmp_path / "study.toml").checked)
    assert (found.line, found.key) == (4, "soil.friction_angle_final")


def test_an_order_that_is_wrong_hides_no_value_that_turns_negative_and_no_foreign_key():
    text = LAYERS.replace('top = "6 m"', 'top = "1 m"\nundrained_shear_strength = "20 kPa"')
    text = text.replace('{ reference = "90 MPa", reference_depth = "5 m", depth_offset = "1 m", exponent = 1.0 }',
                        '{ top = "20 MPa", gradient = "-4 MPa/m" }')  # fmt: skip
    found = tiny.messages(text)
    words = ("must be below the top of the layer before", "is not used by law", "at a depth of")
    assert len(found) == 3
    assert all(any(each in message for message in found) for each in words), found


ENDS = """\
[soil]
surcharge = "5 kPa"
[[soil.layer]]
top = "0 m"
K0 = { top = 0.6, bottom = 0.9 }
poisson_ratio = { top = 0.2, bottom = 0.3, to = "1 m" }
hardening_parameter = { top = 0.004, bottom = 0.006 }
friction_angle_initial = "auto"
[[soil.layer]]
top = "2 m"
law = "tresca"
undrained_shear_strength = "40 kPa"
plasticity_index = { top = 20, bottom = 40 }
overconsolidation_ratio = { top = 9, bottom = 4 }
strain_at_half_strength = { top = 0.02, bottom = 0.03 }
[interface]
adhesion_factor = 0.65
[domain]
radius = "24 m"
depth = "12 m"
"""


def test_pure_numbers_are_linear_in_a_layer_too():
    scene = tiny.parsed(ENDS)
    assert tiny.parsed(scene.to_toml()) == scene
    ground, depth = scene.ground, np.array([0.5, 1.5, 7.0])
    sand, clay = ground.strata
    assert ground.value("K0", depth) == pytest.approx([0.675, 0.825, 1.0])
    assert ground.value("poisson_ratio", depth) == pytest.approx([0.25, 0.3, 0.495])
    assert sand.value("hardening_parameter", depth[:2]) == pytest.approx([0.0045, 0.0055])
    assert clay.value("strain_at_half_strength", depth[2:]) == pytest.approx([0.025])
    stress = float(ground.vertical_stress(depth)[2]) / 100e3
    wanted = 100e3 * stress**0.9 * (30.0 + 75.0 / 0.33) * np.sqrt(6.5)
    assert clay.shear_modulus(depth[2:]) == pytest.approx([wanted])
    least = tiny.parsed(ENDS.replace("{ top = 0.6, bottom = 0.9 }", "0.6"))
    assert sand.values["friction_angle_initial"] == least.ground.strata[0].values["friction_angle_initial"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("bottom = 0.9", "gradient = 0.1", r"^5:6: soil.layer\[0\].K0: a value by depth has the keys top, bottom; "),
        ("bottom = 0.9", 'bottom = "0.9"', r"K0: bottom: expected a number without unit"),
        ("bottom = 40 ", "bottom = 400 ", r"plasticity_index: bottom: 400 is not in \[0, 160\]"),
        ("bottom = 0.03", "bottom = 0.0001", r"strain_at_half_strength: layer 'layer': 0.0001 must be at least"),
    ],
)  # fmt: skip
def test_pure_numbers_by_depth_that_cannot_be_are_refused(old, new, message):
    assert old in ENDS
    found = tiny.messages(ENDS.replace(old, new, 1))
    assert any(re.search(message, each) for each in found), found


@pytest.mark.parametrize("surface", ["drucker-prager", "van-eekelen"])
@pytest.mark.parametrize("K0", [0.45, 1.0, 1.8])
def test_the_automatic_initial_friction_is_the_least_that_holds_the_initial_stress(surface, K0):
    soil = {"yield_surface": surface, "K0": K0, "friction_angle_initial": "auto"}
    scene = tiny.sand(soil=soil)
    angle = float(scene.ground.value("friction_angle_initial", np.array(0.0)))
    assert tiny.sand(soil={**soil, "friction_angle_initial": angle + 1e-6})
    if K0 == 1.0:
        assert angle < 1e-6
        return
    with pytest.raises(ValueError, match="outside the initial yield surface"):
        tiny.sand(soil={**soil, "friction_angle_initial": angle - 1e-4})
    assert tiny.parsed(scene.to_toml()) == scene


def at_rest(law: str = "drucker-prager", phi: str = '"30 deg"') -> str:
    """K0 of the friction angle in two layers; law and friction angle of the first one given."""
    return f'''\
[soil]
K0 = "auto"
[[soil.layer]]
top = "0 m"
name = "upper"
law = "{law}"
friction_angle_final = {phi}
[[soil.layer]]
top = "2 m"
friction_angle_final = "42 deg"
'''


@pytest.mark.parametrize("law", ["drucker-prager", "van-eekelen", "iwan-sand"])
def test_K0_of_the_friction_angle_needs_no_other_value(law):
    scene = tiny.parsed(at_rest(law))
    depth = np.array([1.0, 3.0])
    ground = scene.ground
    np.testing.assert_allclose(ground.value("K0", depth), 1.0 - np.sin(np.radians([30.0, 42.0])))
    first = np.degrees(ground.value("friction_angle_initial", depth))
    least = np.degrees(np.arcsin((1.0 - 0.5) / (1.0 + 0.5)))  # the cone fits triaxial compression
    assert first[0] == pytest.approx(5.0 if law == "iwan-sand" else least)  # its first yield need not hold the stress
    assert tiny.parsed(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (at_rest("elastic"), '"auto" is 1 - sin(phi), and law "elastic" has no friction angle: give a number'),
        (
            at_rest(phi='{ top = "30 deg", bottom = "34 deg" }'),
            '"auto" is 1 - sin(phi) of a layer with one friction angle',
        ),
        (at_rest().replace("[[", 'friction_angle_initial = "5 deg"\n[[', 1), "0.5 puts the initial stress outside the"),
    ],
)
def test_K0_of_no_friction_angle_is_refused(text, message):
    assert any(each.startswith(f"2:6: soil.K0: layer 'upper': {message}") for each in tiny.messages(text))


def test_a_refused_initial_state_names_an_angle_that_holds_it():
    text = '[soil]\nK0 = 0.5\nfriction_angle_initial = "5 deg"\n'
    (message,) = tiny.messages(text)
    angle = re.search(r'friction_angle_initial = "(\S+ deg)" or "auto" holds it', message)
    assert angle
    assert tiny.parsed(text.replace("5 deg", angle[1]))


def test_a_K0_that_the_final_friction_does_not_hold_is_refused_with_the_angle_that_it_needs():
    """The cone fits triaxial compression: sin(phi) = (1 - K0)/(1 + K0)."""
    text = '[soil]\nK0 = 0.2\nfriction_angle_initial = "auto"\nfriction_angle_final = "39 deg"\n'
    needed = np.degrees(np.arcsin((1.0 - 0.2) / (1.0 + 0.2)))
    (found,) = tiny.messages(text)
    assert f"soil.K0: 0.2 needs a friction angle of {needed:.2f} deg, more than friction_angle_final (39 deg)" in found


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"11 kN/m^3"', '"21 kN/m^3"', "layer 'dense': effective_unit_weight at 2.22 m: 21 kN/m^3 is outside"),
        (
            'bottom = "32 deg"',
            'bottom = "55 deg"',
            "layer 'loose': friction_angle_final at 1.89 m: 53.5 deg is outside",
        ),
    ],
)
def test_unusual_sand_is_named_once(old, new, words):
    assert implausible(tiny.parsed(LAYERS)) == []
    assert old in LAYERS
    (found,) = implausible(tiny.parsed(LAYERS.replace(old, new, 1)))
    assert words in found


def boundaries(*tops, caisson=None):
    """The paper's sand in layers from these depths on, in a domain of 12 m; the skirt is 4 m long."""
    layers = [{"top": top, "name": f"layer {n}"} for n, top in enumerate(tops)]
    return tiny.paper(soil={"layers": layers}, domain={"depth": 12.0}, caisson=caisson or {})


@pytest.mark.parametrize(
    ("tops", "kept", "words"),
    [
        ((0.0, 4.000001), [0.0, 4.0], "top at 4.000001 m is moved to 4 m (the skirt tip), less than 4 mm away"),
        ((0.0, 3.9961), [0.0, 4.0], "top at 3.9961 m is moved to 4 m (the skirt tip)"),
        ((0.0, 3.99), [0.0, 3.99], ""),
        ((0.0, 1e-6, 2.0), [0.0, 2.0], "layer 'layer 0' is thinner than 4 mm and not modelled"),
        ((0.0, 2.0, 2.000002, 6.0), [0.0, 2.0, 6.0], "layer 'layer 1' is thinner than 4 mm and not modelled"),
        ((0.0, 3.999999, 4.000001), [0.0, 4.0], "layer 'layer 1' is thinner than 4 mm and not modelled"),
        ((0.0, 11.999999), [0.0], "layer 'layer 1' is thinner than 4 mm and not modelled"),
    ],
)
def test_boundaries_near_the_tip_and_each_other_leave_no_slivers(tops, kept, words):
    """A boundary 1 um below the tip gave cells of 1 um, an aspect ratio of 1.8e8, and runs that stopped."""
    scene = boundaries(*tops)
    ground = scene.ground
    assert [each.top for each in ground.strata] == kept and ground.strata[-1].bottom == 12.0
    said = [text for text in remarks(scene) if "is moved" in text or "not modelled" in text]
    assert any(words in text for text in said) if words else said == []
    assert np.diff(np.unique(build(scene).model.mesh.nodes[:, 2].round(9))).min() > 1e-3


def test_the_least_thickness_of_a_layer_is_stated_in_few_digits():
    """6.5 m of skirt: not 6.500000000000001 mm."""
    said = remarks(boundaries(0.0, 1e-6, 2.0, caisson={"skirt_length": 6.5}))
    assert any("is thinner than 6.5 mm and not modelled" in text for text in said)
