# SPDX-License-Identifier: MIT
"""Penalty stiffness: "auto" is the paper's value for its soil, its cost that of an independent solution, its limit."""

import pytest

from fe_engine.contact.coulomb import KN
from pysprings.model.build import build_model
from pysprings.model.contact import AUTO, STIFFEST, penalty_of
from pysprings.scene.model import Scene
from tests.support import tiny


def scene(normal: float | str = "auto", shear: float | str = "auto", **soil: float) -> Scene:
    return tiny.sand(interface={"normal_stiffness": normal, "shear_stiffness": shear}, soil=soil)


def test_auto_is_the_papers_value_for_the_papers_soil_and_follows_the_soil() -> None:
    penalty = penalty_of(scene())
    assert penalty.normal == penalty.shear == pytest.approx(1e10, rel=1e-12)
    assert penalty_of(scene(young_modulus=20e6)).normal == pytest.approx(1e9, rel=1e-12)
    assert penalty.remarks == ()


@pytest.mark.parametrize(("stiffness", "lost"), [(1e10, 1 - 2858 / 2872), (1e9, 1 - 2753 / 2872)])
def test_the_loss_of_stiffness_is_that_of_an_independent_solution(stiffness: float, lost: float) -> None:
    """K_free in MN/m of the paper's geometry, bonded and with springs: 2872, 2858, 2753 (elastic, independent)."""
    assert penalty_of(scene(stiffness, stiffness)).stiffness_loss == pytest.approx(lost, rel=0.15)


def test_the_softer_of_both_decides_what_is_lost() -> None:
    assert penalty_of(scene(1e10, 1e8)).stiffness_loss == penalty_of(scene(1e8, 1e8)).stiffness_loss


def test_penetration_is_that_of_the_tip() -> None:
    assert penalty_of(scene(1e9)).penetration == pytest.approx((10.56e3 + 4 * 10.56e3) / 1e9)


def test_a_penalty_beyond_the_limit_is_replaced_and_said() -> None:
    asked = scene(1e14, 1e8)
    penalty = penalty_of(asked)
    assert penalty.normal == pytest.approx(STIFFEST / AUTO * 1e10)
    assert penalty.shear == 1e8
    assert len(penalty.remarks) == 1
    assert penalty.remarks[0].startswith(
        "interface.normal_stiffness: 100,000 GN/m3 is too stiff to solve with; 100 GN/m3"
    )
    assert (build_model(asked).model.contact[:, KN] == penalty.normal).all()
