# SPDX-License-Identifier: MIT
"""A stiffness that follows the stress or degrades: its keys, what is refused, the law and parameters of the engine."""

import re

import numpy as np
import pytest

from fe_engine.soil import following, plasol
from pysprings.model.forecast.estimate import profile
from pysprings.model.soil_laws import engine_laws, soil_materials
from tests.support import tiny

SAND = """\
[soil]
K0 = 0.5
friction_angle_initial = "auto"
surcharge = "5 kPa"
[[soil.layer]]
top = "0 m"
name = "sand"
young_modulus = { reference = "80 MPa", reference_stress = "100 kPa", exponent = 0.5, follows = "stress" }
degradation_strain = 2e-4
[[soil.layer]]
top = "3 m"
young_modulus = "200 MPa"
"""


def test_a_layer_that_follows_has_the_law_and_its_initial_stress() -> None:
    scene = tiny.parsed(SAND)
    assert [law.name for law in engine_laws(scene)[:2]] == ["following", "drucker-prager"]
    depth = np.array([[1.0, 2.0], [4.0, 5.0]])
    materials, number = soil_materials(scene, depth)
    assert list(number) == [0, 1]
    p = materials[0].parameters
    stress = 2.0 / 3.0 * (5e3 + 10.56e3 * depth[0])
    assert p[0, :, following.PRESSURE] == pytest.approx(stress)
    assert p[0, :, following.SHEAR] == pytest.approx(80e6 * (stress / 100e3) ** 0.5 / 2.6)
    assert p[0, 0, following.EXPONENT] == 0.5
    assert p[0, 0, following.DEGRADATION] == pytest.approx(0.385 / 2e-4)
    assert p[0, 0, following.LEAST] == 0.2
    assert materials[1].law is plasol.LAW
    row = profile(scene)[0]
    assert (row["stiffness_exponent"], row["degradation_strain"]) == (0.5, 2e-4)


def test_a_shear_modulus_follows_as_youngs_modulus_does() -> None:
    twin = tiny.parsed(SAND.replace('young_modulus = { reference = "80 MPa"', 'shear_modulus = { reference = "40 MPa"'))
    young = tiny.parsed(SAND.replace("80 MPa", "104 MPa"))  # 2.6 times G
    assert engine_laws(twin)[0].name == "following"
    depth = np.array([[1.0, 2.0]])
    rows = [soil_materials(scene, depth)[0][0].parameters for scene in (twin, young)]
    assert rows[0] == pytest.approx(rows[1], rel=1e-12)


def test_the_scene_reads_itself_again_and_frozen_ones_keep_their_number() -> None:
    scene = tiny.parsed(SAND)
    assert tiny.parsed(scene.to_toml()) == scene
    frozen = tiny.parsed(SAND.replace(', follows = "stress"', "").replace("degradation_strain = 2e-4\n", ""))
    assert frozen.sha256 != scene.sha256
    assert "follows" not in frozen.to_toml()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('follows = "stress"', 'follows = "strain"', r'follows: "strain" is not one of "stress"'),
        ("exponent = 0.5", "exponent = 1.0", r"exponent: 1 must be less than 1 where the stiffness follows the stress"),
        ('name = "sand"', 'law = "elastic"', r'young_modulus: follows: the stiffness of law "elastic" does not change'),
        ('young_modulus = "200 MPa"', "degradation_limit = 0.3", r"degradation_limit: needs a degradation_str"),
        ("2e-4", "0.5", r"degradation_strain: 0.5 is not in \[1e-6, 0.1\]"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(old: str, new: str, message: str) -> None:
    assert old in SAND
    found = tiny.messages(SAND.replace(old, new, 1))
    assert any(re.search(message, each) for each in found), found
