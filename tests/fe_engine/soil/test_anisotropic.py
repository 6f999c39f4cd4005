# SPDX-License-Identifier: MIT
"""Anisotropic strength of clay: element tests in all modes, von Mises as its equal case, return and tangent."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.optimize import minimize

from fe_engine.conventions import REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import anisotropic, mobilised, von_mises
from fe_engine.soil.elastic import elastic_matrix, moduli
from fe_engine.soil.law import Point
from tests.support.models import rotation_matrix, taylor_slope, to_matrix, to_voigt
from tests.support.soil_points import OTHER, PUSH, SIZES, START, stepped

YOUNG, POISSON = 1.2e7, 0.49
BULK, SHEAR = moduli(YOUNG, POISSON)
COMPRESSION, DIRECT, EXTENSION = 2.8e4, 2.0e4, 1.4e4
SHIFT = 0.5 * (COMPRESSION - EXTENSION)
RADIUS = np.sqrt(0.25 * (COMPRESSION + EXTENSION) ** 2 - 0.25 * DIRECT**2)
LARGE = 30.0 * DIRECT / SHEAR
PLANE = np.array([0.5, 0.0, -0.5, 0.0, 0.0, 0.0])
TRIAXIAL = np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]) / 1.5


def make(*strengths):
    return anisotropic.pack(YOUNG, POISSON, *(strengths or (COMPRESSION, DIRECT, EXTENSION)))


def step(p, strain, stress=START):
    return stepped(anisotropic.update, p, strain, Point(stress, np.zeros(1)))


def at_failure(p, direction, stress=START):
    """Stress after a large strain in increments."""
    for _ in range(60):
        stress = step(p, LARGE / 20.0 * direction, stress)[0].stress
    return stress


@pytest.mark.parametrize("start", [START, START * np.array([0.9, 0.9, 1.0, 0.0, 0.0, 0.0])])
def test_strengths_of_the_three_modes_are_those_given(start):
    up, down = at_failure(make(), PLANE, start), at_failure(make(), -PLANE, start)
    assert 0.5 * (up[0] - up[2]) == pytest.approx(COMPRESSION, rel=1e-8)
    assert 0.5 * (down[2] - down[0]) == pytest.approx(EXTENSION, rel=1e-8)
    for component in (4, 5):
        assert at_failure(make(), np.eye(6)[component], start)[component] == pytest.approx(DIRECT, rel=1e-8)
        assert at_failure(make(), -np.eye(6)[component], start)[component] == pytest.approx(-DIRECT, rel=1e-8)


def test_triaxial_strengths_and_shear_in_the_horizontal_plane():
    up, down = at_failure(make(), TRIAXIAL), at_failure(make(), -TRIAXIAL)
    assert 0.5 * (up[0] - up[2]) == pytest.approx(RADIUS + SHIFT, rel=1e-8)
    assert 0.5 * (down[2] - down[0]) == pytest.approx(RADIUS - SHIFT, rel=1e-8)
    assert at_failure(make(), np.eye(6)[3])[3] == pytest.approx(DIRECT, rel=1e-8)


def test_equal_strengths_are_von_mises():
    p, plain = make(DIRECT, DIRECT, DIRECT), mobilised.pack(YOUNG, POISSON, DIRECT)
    for strain in (PUSH, 20.0 * OTHER, 0.05 * PUSH):
        ours, tangent, regime = step(p, strain)
        new, theirs, other = stepped(von_mises.update, plain, strain, Point(START, np.zeros(1)))
        assert regime == other
        np.testing.assert_allclose(ours.stress, new.stress, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(tangent, theirs, rtol=1e-10, atol=1e-6 * SHEAR)
        assert ours.history[0] == pytest.approx(new.history[0], rel=1e-10)


def test_a_turn_about_the_vertical_turns_the_answer():
    turn = rotation_matrix((0.0, 0.0, 1.0), 0.7)
    strain = to_matrix(PUSH * np.array([1, 1, 1, 0.5, 0.5, 0.5]))
    turned = step(make(), to_voigt(turn @ strain @ turn.T, shear=2.0))[0].stress
    stress = to_matrix(step(make(), PUSH)[0].stress)
    np.testing.assert_allclose(to_matrix(turned), turn @ stress @ turn.T, rtol=1e-9, atol=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_the_return_is_the_closest_point_in_elastic_energy(seed):
    rng = np.random.default_rng(seed)
    p, strain = make(), 5.0 * DIRECT / SHEAR * rng.normal(size=6)
    stiffness = elastic_matrix(YOUNG, POISSON)
    trial, compliance = START + stiffness @ strain, np.linalg.inv(stiffness)
    ours = step(p, strain)[0].stress
    unit = 1.0e4
    least = minimize(
        lambda s: (s - trial / unit) @ compliance @ (s - trial / unit) * unit**2,
        ours / unit + 0.1 * rng.normal(size=6),
        constraints={"type": "ineq", "fun": lambda s: -anisotropic.yield_function(p, s * unit, 0.0)},
        method="SLSQP", options={"ftol": 1e-14, "maxiter": 500},
    )  # fmt: skip
    assert least.x * unit == pytest.approx(ours, rel=1e-4, abs=0.01 * DIRECT)


@pytest.mark.parametrize("strain", [PUSH, -PUSH, 30.0 * OTHER, PLANE * 0.02, -TRIAXIAL * 0.02])
def test_tangent_is_the_symmetric_derivative(strain):
    tangent = step(make(), strain)[1]
    assert taylor_slope(lambda e: step(make(), e)[0].stress, tangent, strain, OTHER, SIZES) > 1.85
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-9 * SHEAR)


@settings(max_examples=200, deadline=None)
@given(
    shares=st.tuples(st.floats(0.6, 3.0), st.floats(0.45, 3.0)),
    size=st.floats(-6.0, 1.0),
    direction=st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6),
)
def test_every_return_lies_on_the_surface(shares, size, direction):
    p = make(shares[0] * DIRECT, DIRECT, shares[1] * DIRECT)
    strain = 10.0**size * np.array(direction)
    if anisotropic.yield_function(p, START, 0.0) > 0.0:  # an isotropic stress is outside
        return
    answer, tangent, regime = step(p, strain)
    f = anisotropic.yield_function(p, answer.stress, 0.0)
    assert f <= 1e-9
    if regime == REGIME_CONE:
        assert abs(f) < 1e-7
        assert np.linalg.eigvalsh(0.5 * (tangent + tangent.T)).min() > -1e-6 * SHEAR
    else:
        assert regime == REGIME_ELASTIC
