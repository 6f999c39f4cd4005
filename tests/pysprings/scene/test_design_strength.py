# SPDX-License-Identifier: MIT
"""Partial factors on strength: tan phi, cohesion, su and the friction of the interface; stiffness stays."""

import math

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.scene.design_strength import StrengthFactors, with_design_strength
from pysprings.scene.template import template_text
from tests.support import tiny

_DEG = math.pi / 180.0


def test_sand() -> None:
    scene = tiny.sand(soil={"cohesion": 5e3, "dilation_angle": 28 * _DEG})
    design = with_design_strength(scene, StrengthFactors(tan_phi=1.25, c=1.4))
    assert math.tan(design.soil.friction_angle_final) == pytest.approx(math.tan(30 * _DEG) / 1.25, rel=1e-14)
    assert design.soil.cohesion == pytest.approx(5e3 / 1.4)
    assert design.soil.friction_angle_initial == pytest.approx(5 * _DEG)  # first yield is below the design angle
    assert design.soil.dilation_angle == design.soil.friction_angle_final  # 28 deg would exceed it
    assert design.interface.friction_coefficient == pytest.approx(0.5 / 1.25)
    assert design.soil.young_modulus == scene.soil.young_modulus
    assert "tan phi/1.25, c/1.4, su/1" in design.title


def test_clay_by_depth_keeps_its_stiffness() -> None:
    scene = tiny.parsed(template_text("soft-clay"))
    design = with_design_strength(scene, StrengthFactors.read(["su=1.4"]))
    before, after = scene.soil.undrained_shear_strength, design.soil.undrained_shear_strength
    assert (after.top, after.gradient) == pytest.approx((before.top / 1.4, before.gradient / 1.4))
    assert design.soil.rigidity_ratio * after.top == pytest.approx(scene.soil.rigidity_ratio * before.top)
    assert design.interface.friction_coefficient == scene.interface.friction_coefficient


def test_layers() -> None:
    scene = tiny.parsed(template_text("layered-sand"))
    design = with_design_strength(scene, StrengthFactors(tan_phi=1.25))
    assert len(scene.soil.layers) == len(design.soil.layers) > 1
    for before, after in zip(scene.soil.layers, design.soil.layers, strict=True):
        if before.friction_angle_final is None:
            assert after.friction_angle_final is None
            continue
        ends = [(before.friction_angle_final, after.friction_angle_final)]
        if not isinstance(before.friction_angle_final, float):
            ends = [(before.friction_angle_final.top, after.friction_angle_final.top)]
        for old, new in ends:
            assert math.tan(new) == pytest.approx(math.tan(old) / 1.25)


def test_angles_that_grow_with_depth() -> None:
    """A gradient is factored at both ends of the ground; the design angle between them is linear."""
    gradient = {"top": 30 * _DEG, "gradient": 0.5 * _DEG}
    scene = tiny.sand(soil={"layers": [{"top": 0.0, "friction_angle_final": gradient}]}, domain={"depth": 12.0})
    angle = with_design_strength(scene, StrengthFactors(tan_phi=1.25)).soil.layers[0].friction_angle_final
    assert math.tan(angle.top) == pytest.approx(math.tan(30 * _DEG) / 1.25)
    assert math.tan(angle.bottom) == pytest.approx(math.tan(36 * _DEG) / 1.25)
    assert angle.to == 12.0


def test_the_initial_stress_stays_that_of_the_friction_angle_before() -> None:
    layers = [{"top": 0.0, "friction_angle_final": 0.6}, {"top": 2.0, "K0": 0.9}]
    for soil, expected in (
        ({"friction_angle_final": 0.6}, [1.0 - np.sin(0.6)]),
        ({"layers": layers}, [1.0 - np.sin(0.6), 0.9]),
    ):
        scene = tiny.sand(soil=soil | {"K0": "auto"})
        reduced = with_design_strength(scene, StrengthFactors(tan_phi=1.25))
        for depth, k0 in zip([1.0, 3.0], expected, strict=False):
            assert reduced.ground.value("K0", np.array(depth)) == pytest.approx(k0)
        angles = (float(each.ground.value("friction_angle_final", np.array(1.0))) for each in (scene, reduced))
        assert np.divide(*np.tan([*angles])) == pytest.approx(1.25)


def test_factors_are_read() -> None:
    assert StrengthFactors.read([]) == StrengthFactors()
    assert StrengthFactors.read(["1.25"]) == StrengthFactors(1.25, 1.25, 1.25)
    for texts in (["1.25", "su=1.4"], ["su=1.4", "1.25"]):
        assert StrengthFactors.read(texts) == StrengthFactors(1.25, 1.25, 1.4), "the order does not count"
    with pytest.raises(UserInputError) as caught:
        StrengthFactors.read(["su=1.4", "1.25", "su=1.2", "1.3"])
    assert [problem.message.partition(": ")[2] for problem in caught.value.problems] == [
        "a second factor of su", "a second factor of all"
    ]  # fmt: skip
    with pytest.raises(UserInputError) as caught:
        StrengthFactors.read(["0.8", "phi=1.2", "su=x", "6"])
    assert len(caught.value.problems) == 4
    assert str(caught.value.problems[0]) == (
        '--factor: "0.8": expected a number from 1 to 5 such as 1.25, or one of tan_phi, c, su with it such as su=1.4'
    )
