# SPDX-License-Identifier: MIT
"""Linear elasticity at one point, and the choice of the law by its code."""

import numpy as np
import pytest

from fe_engine.assembly import fourier_kernels
from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import elastic, plasol
from fe_engine.soil.dispatch import update_of, update_soil
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


TWO = tuple(sorted(SOIL_LAWS.code(law) for law in (elastic.LAW, plasol.LAW)))


@pytest.mark.parametrize("update", [update_soil, update_of(TWO)])
@pytest.mark.parametrize(("law", "regime"), [(elastic.LAW, REGIME_ELASTIC), (plasol.LAW, REGIME_CONE)])
def test_the_code_chooses_the_law(law, regime, update):
    """A strain that yields the sand stays elastic with the elastic code; with the update of two laws as with all."""
    p, strain = plasol.pack(*SAND), 1.0e-3 * np.array([1.0, -0.4, -0.7, 0.5, -0.3, 0.8])
    old = -1.0e5 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
    before, after = Point(old, np.zeros(1)), Point(stress, history)
    assert update(SOIL_LAWS.code(law), p, strain, before, after, tangent, True) == (OK, regime)
    matrix = elastic_matrix(*SAND[:2])
    assert np.allclose(stress, old + matrix @ strain) == (law is elastic.LAW)
    assert np.allclose(tangent, matrix) == (law is elastic.LAW)


def test_a_loop_of_two_laws_compiles_no_other():
    """It has a name of its own, by which Numba keeps it, and is made once."""
    loop = fourier_kernels.soil_forces_of(np.array([TWO[1], TWO[0], TWO[1]]))
    assert loop.py_func.__name__ == f"soil_forces_{TWO[0]}_{TWO[1]}" and loop is fourier_kernels.soil_forces_of(TWO)
    point = loop.py_func.__globals__["_point_forces"]
    update = point.py_func.__globals__["update_soil"]
    assert point is not fourier_kernels._point_forces and update is update_of(TWO)
    called = {name: each for name, each in update.py_func.__globals__.items() if name.startswith("choice_")}
    assert called == {f"choice_{SOIL_LAWS.code(law)}": law.update for law in (elastic.LAW, plasol.LAW)}
