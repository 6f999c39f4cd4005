# SPDX-License-Identifier: MIT
"""Linear elasticity at one point, and the choice of the law by its code."""

from __future__ import annotations

import numpy as np
import pytest

from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import elastic, plasol
from fe_engine.soil.dispatch import update_soil
from fe_engine.soil.elastic import add_elastic_stress, elastic_matrix, elastic_tangent, moduli
from fe_engine.soil.law import Point
from fe_engine.soil.laws import SOIL_LAWS
from tests.support.models import SAND

YOUNG, POISSON = 2.0e8, 0.3


def test_compliance_holds_the_engineering_constants():
    compliance = np.linalg.inv(elastic_matrix(YOUNG, POISSON))
    expected = np.diag([1.0] * 3 + [2.0 * (1.0 + POISSON)] * 3)
    expected[:3, :3] -= POISSON * (1.0 - np.eye(3))
    np.testing.assert_allclose(compliance, expected / YOUNG, atol=1e-14 / YOUNG)


def test_moduli():
    bulk, shear = moduli(YOUNG, POISSON)
    assert pytest.approx(9.0 * bulk * shear / (3.0 * bulk + shear)) == YOUNG
    assert pytest.approx((3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)) == POISSON


def test_stress_is_added_and_matches_the_matrix():
    strain = 1.0e-3 * np.array([1.0, -0.4, 0.2, 0.5, -0.3, 0.8])
    stress = np.arange(6.0)
    add_elastic_stress(*moduli(YOUNG, POISSON), strain, stress)
    np.testing.assert_allclose(stress, np.arange(6.0) + elastic_matrix(YOUNG, POISSON) @ strain, rtol=1e-13)


def test_factor_scales_the_tangent():
    tangent = np.full((6, 6), np.nan)
    elastic_tangent(*moduli(YOUNG, POISSON), 0.25, tangent)
    np.testing.assert_allclose(tangent, 0.25 * elastic_matrix(YOUNG, POISSON), rtol=1e-14)


@pytest.mark.parametrize(("law", "regime"), [(elastic.LAW, REGIME_ELASTIC), (plasol.LAW, REGIME_CONE)])
def test_the_code_chooses_the_law(law, regime):
    """A strain that yields the sand stays elastic with the elastic code."""
    p, strain = plasol.pack(*SAND), 1.0e-3 * np.array([1.0, -0.4, -0.7, 0.5, -0.3, 0.8])
    old = -1.0e5 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
    before, after = Point(old, np.zeros(1)), Point(stress, history)
    assert update_soil(SOIL_LAWS.code(law), p, strain, before, after, tangent, True) == (OK, regime)
    matrix = elastic_matrix(*SAND[:2])
    assert np.allclose(stress, old + matrix @ strain) == (law is elastic.LAW)
    assert np.allclose(tangent, matrix) == (law is elastic.LAW)
