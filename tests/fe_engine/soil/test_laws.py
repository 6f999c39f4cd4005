# SPDX-License-Identifier: MIT
"""What every registered soil law must meet at one point, whatever its surface."""

import numpy as np
import pytest

from fe_engine.conventions import REGIME_ELASTIC
from fe_engine.soil.elastic import elastic_tangent
from fe_engine.soil.law import PLASTIC_STRAIN, Point, SoilLaw
from fe_engine.soil.laws import SOIL_LAWS
from tests.support.models import rotation_matrix, soil, taylor_slope, to_matrix, to_voigt
from tests.support.soil_points import OTHER, PUSH, SIZES, START, Stepped, stepped

LAWS = [pytest.param(law, id=law.name) for law in SOIL_LAWS]


def step(law: SoilLaw, strain: np.ndarray, stress: np.ndarray = START) -> Stepped:
    """One update from a stress and no history."""
    return stepped(law.update, soil(law).parameters, strain, Point(stress, np.zeros(len(law.history))))


@pytest.mark.parametrize("law", LAWS)
def test_parameters_and_moduli_fit_their_names(law):
    p = soil(law).parameters
    assert p.shape == (len(law.parameters),)
    bulk, shear = law.moduli(p)
    assert bulk > 0.0 < shear


@pytest.mark.parametrize("law", LAWS)
def test_tangent_is_the_derivative_of_the_stress(law):
    tangent = step(law, PUSH).tangent
    assert taylor_slope(lambda strain: step(law, strain).new.stress, tangent, PUSH, OTHER, SIZES) > 1.85


@pytest.mark.parametrize("law", LAWS)
def test_rotated_strain_gives_rotated_stress(law):
    """From an isotropic stress no axis is preferred, or the vertical alone."""
    turn = rotation_matrix((0.3, -0.5, 0.8) if law.isotropic else (0.0, 0.0, 1.0), 0.7)
    strain = to_matrix(PUSH * np.array([1, 1, 1, 0.5, 0.5, 0.5]))
    turned = to_voigt(turn @ strain @ turn.T, shear=2.0)
    stress = to_matrix(step(law, PUSH).new.stress)
    np.testing.assert_allclose(to_matrix(step(law, turned).new.stress), turn @ stress @ turn.T, rtol=1e-9, atol=1e-4)


@pytest.mark.parametrize("law", LAWS)
def test_a_regime_that_is_elastic_has_the_tangent_of_the_moduli(law):
    strain = 1e-9 * PUSH
    new, tangent, regime = step(law, strain)
    bulk, shear = law.moduli(soil(law).parameters)
    if regime == REGIME_ELASTIC:
        assert tangent[3, 3] == pytest.approx(shear, rel=1e-12)
        assert tangent[:3, :3].sum() / 9.0 == pytest.approx(bulk, rel=1e-12)
        assert all(value == 0.0 for name, value in zip(law.history, new.history, strict=True) if name == PLASTIC_STRAIN)
    else:
        assert law.yields


@pytest.mark.parametrize("law", [each for each in LAWS if each.values[0].yields])
def test_a_law_that_yields_does_so_and_dissipates(law):
    new, _, regime = step(law, PUSH)
    assert regime != REGIME_ELASTIC
    p = soil(law).parameters
    bulk, shear = law.moduli(p)
    stiffness = np.empty((6, 6))
    elastic_tangent(bulk, shear, 1.0, stiffness)
    plastic = PUSH - np.linalg.solve(stiffness, new.stress - START)
    assert float(new.stress @ plastic) > 0.0


def test_a_symmetric_law_has_symmetric_tangents():
    laws = [law for law in SOIL_LAWS if law.symmetric]
    assert laws
    for law in laws:
        tangent = step(law, PUSH).tangent
        np.testing.assert_allclose(tangent, tangent.T, rtol=1e-12)
