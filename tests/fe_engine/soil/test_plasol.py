# SPDX-License-Identifier: MIT
"""PLASOL at one point: regimes, return paths, tangents, invariances, and a sweep over extreme parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import plasol
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.law import Point
from tests.support.models import DEGREE, rotation_matrix, taylor_slope, to_matrix, to_voigt
from tests.support.soil_points import (
    OPENING,
    OTHER,
    POISSON,
    PRESSURE,
    PUSH,
    SIZES,
    START,
    SYMMETRY,
    YOUNG,
    Answer,
    dissipation,
    elastic,
    invariants,
    make,
    soils,
    strains,
    update_by,
)
from tests.support.soil_points import trial_excess as excess_of


def update(p, strain, stress=START, kappa=0.0, update=plasol.update) -> Answer:
    return update_by(update, p, strain, stress, kappa)


def cone(phi):
    """m(phi) as physics books write it."""
    return 2.0 * np.sin(phi) / (np.sqrt(3.0) * (3.0 - np.sin(phi)))


def trial_excess(p, strain, stress, kappa):
    return excess_of(plasol.yield_function, p, strain, stress, kappa)


CONES = {
    "no dilation": make(),
    "dilation below friction": make(psi=4.0),
    "dilation is friction": make(phi_i=30.0, psi=30.0),
    "cohesion": make(cohesion=2.0e4),
    "cohesion and dilation": make(cohesion=2.0e4, psi=10.0, phi_i=12.0),
    "contraction": make(psi=-5.0),
    "von Mises": make(phi_i=0.0, phi_f=0.0, cohesion=2.0e4),
}
APEXES = {
    "cohesionless": make(psi=5.0),
    "cohesion": make(phi_i=30.0, cohesion=2.0e4),
    "cohesion and hardening": make(cohesion=4.0e3, psi=4.0),
}


# --- regimes ----------------------------------------------------------------------------------------------


def test_small_strain_is_elastic():
    answer = update(make(), 0.01 * PUSH)
    assert (answer.status, answer.regime, answer.kappa) == (OK, REGIME_ELASTIC, 0.0)
    np.testing.assert_allclose(answer.stress, START + 0.01 * elastic_matrix(YOUNG, POISSON) @ PUSH, rtol=1e-13)
    np.testing.assert_allclose(answer.tangent, elastic_matrix(YOUNG, POISSON), rtol=1e-14)


@pytest.mark.parametrize("p", CONES.values(), ids=CONES)
def test_shear_returns_to_the_cone(p):
    answer = update(p, PUSH)
    excess, size = trial_excess(p, PUSH, START, 0.0)
    assert (answer.status, answer.regime) == (OK, REGIME_CONE)
    assert excess > 1.0e-3 * size
    assert abs(plasol.yield_function(p, answer.stress, answer.kappa)) <= 1.0e-13 * size


@pytest.mark.parametrize("p", APEXES.values(), ids=APEXES)
def test_apex_keeps_exactly_the_residual_fraction_of_the_trial(p):
    """f after = APEX_STIFFNESS x (trial f at the new hardening), and the apex itself is at I = k/m."""
    answer = update(p, OPENING)
    excess, size = trial_excess(p, OPENING, START, answer.kappa)
    assert (answer.status, answer.regime) == (OK, REGIME_APEX)
    left = plasol.yield_function(p, answer.stress, answer.kappa)
    assert left == pytest.approx(plasol.APEX_STIFFNESS * excess, abs=1.0e-14 * size)
    phi = p[plasol.PHI_I] + (p[plasol.PHI_F] - p[plasol.PHI_I]) * answer.kappa / (p[plasol.B_PHI] + answer.kappa)
    trial = START + elastic(p) @ OPENING
    apex = p[plasol.COHESION] / np.tan(phi) * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    expected = apex + plasol.APEX_STIFFNESS * (trial - apex)
    np.testing.assert_allclose(answer.stress, expected, atol=1.0e-14 * size)


def test_unloading_after_yield_is_elastic_and_remembers():
    p = make()
    yielded = update(p, PUSH)
    back = update(p, -0.02 * PUSH, yielded.stress, yielded.kappa)
    assert (back.regime, back.kappa) == (REGIME_ELASTIC, yielded.kappa)
    np.testing.assert_allclose(back.stress - yielded.stress, -0.02 * elastic(p) @ PUSH, rtol=1e-10)
    again = update(p, 0.04 * PUSH, back.stress, back.kappa)
    assert again.regime == REGIME_CONE
    assert again.kappa > yielded.kappa


def test_closing_after_the_apex_gives_pressure_back():
    p = make()
    opened = update(p, OPENING)
    closed = update(p, -2.0 * np.abs(OPENING), opened.stress, opened.kappa)
    assert closed.stress[:3].sum() < -PRESSURE


@pytest.mark.parametrize(
    ("strain", "regime"),
    [
        (np.array([-1.0, -1.0, -1.0, 0.0, 0.0, 0.0]), REGIME_ELASTIC),
        (np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), REGIME_APEX),
        (np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), REGIME_CONE),
    ],
    ids=["compressed", "stretched", "sheared"],
)
@pytest.mark.parametrize("cohesion", [0.0, 1.0e3])
def test_isotropic_start(strain, regime, cohesion):
    answer = update(make(cohesion=cohesion), 1.0e-3 * strain)
    assert answer.regime == regime
    assert np.all(np.isfinite(answer.tangent))
    assert (answer.kappa > 0.0) == (regime == REGIME_CONE)


# --- outside answers --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kappa", "ratio", "axial"),
    [
        (0.0005, 0.2899, 0.000645),
        (0.0025, 0.5995, 0.002800),
        (0.005, 0.8600, 0.005430),
        (0.02, 1.4639, 0.020732),
        (0.10, 1.8603, 0.100930),
    ],
)
def test_triaxial_compression_in_one_step(kappa, ratio, axial):
    """Closed form: q = M s3/(1 - M/3), axial strain q/E + kappa; the table is that form rounded."""
    phi = (5.0 + 25.0 * kappa / (0.005 + kappa)) * DEGREE
    slope = 6.0 * np.sin(phi) / (3.0 - np.sin(phi))
    q = slope * PRESSURE / (1.0 - slope / 3.0)
    assert q / PRESSURE == pytest.approx(ratio, abs=5.1e-5)
    assert q / YOUNG + kappa == pytest.approx(axial, abs=5.1e-7)
    volumetric = q * (1.0 - 2.0 * POISSON) / YOUNG
    lateral = 0.5 * (q / YOUNG + kappa - volumetric)
    answer = update(make(), np.array([lateral, lateral, -q / YOUNG - kappa, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(answer.stress[:3], [-PRESSURE, -PRESSURE, -PRESSURE - q], rtol=1e-9)
    assert answer.kappa == pytest.approx(kappa, rel=1e-9)


def test_dilation_in_triaxial_compression():
    """Plastic volume change over kappa is M_psi (positive: dilation)."""
    psi = 10.0
    answer = update(p := make(phi_i=30.0, psi=psi), strain := 1.0e-3 * np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]))
    plastic = strain - np.linalg.solve(elastic(p), answer.stress - START)
    slope = 6.0 * np.sin(psi * DEGREE) / (3.0 - np.sin(psi * DEGREE))
    assert plastic[:3].sum() / answer.kappa == pytest.approx(slope, rel=1e-9)


def test_without_friction_it_is_von_mises():
    cohesion = 2.0e4
    answer = update(make(phi_i=0.0, phi_f=0.0, cohesion=cohesion), 5.0 * PUSH)
    assert invariants(answer.stress)[1] == pytest.approx(2.0 * cohesion / np.sqrt(3.0), rel=1e-12)


def test_zero_initial_friction_is_the_limit_of_small_friction():
    at_zero, near_zero = update(make(phi_i=0.0), PUSH), update(make(phi_i=1.0e-7), PUSH)
    assert at_zero.regime == REGIME_CONE
    np.testing.assert_allclose(at_zero.stress, near_zero.stress, rtol=1e-6)
    np.testing.assert_allclose(at_zero.tangent, near_zero.tangent, rtol=1e-5, atol=1e-6 * YOUNG)


def test_without_hardening_its_parameter_does_not_matter():
    fast, slow = (update(make(phi_i=25.0, phi_f=25.0, b_phi=b), PUSH) for b in (1.0e-6, 1.0))
    np.testing.assert_array_equal(fast.stress, slow.stress)
    np.testing.assert_array_equal(fast.tangent, slow.tangent)
    assert invariants(fast.stress)[1] == pytest.approx(-cone(25.0 * DEGREE) * invariants(fast.stress)[0], rel=1e-12)


# --- tangents ---------------------------------------------------------------------------------------------


def slope_of(p, strain, stress=START, kappa=0.0):
    answer = update(p, strain, stress, kappa)
    for size in SIZES:
        assert update(p, strain + size * OTHER, stress, kappa).regime == answer.regime
    return taylor_slope(lambda e: update(p, e, stress, kappa).stress, answer.tangent, strain, OTHER, SIZES)


@pytest.mark.parametrize("p", CONES.values(), ids=CONES)
def test_tangent_on_the_cone(p):
    assert slope_of(p, PUSH) == pytest.approx(2.0, abs=0.1)


def test_tangent_on_the_cone_after_earlier_yield():
    p = make(psi=3.0, cohesion=5.0e3)
    yielded = update(p, OTHER)
    assert slope_of(p, PUSH, yielded.stress, yielded.kappa) == pytest.approx(2.0, abs=0.1)


def test_tangent_at_the_apex_that_moves_with_hardening():
    assert slope_of(APEXES["cohesion and hardening"], OPENING) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("p", "strain"),
    [(make(), 0.01 * PUSH), (APEXES["cohesionless"], OPENING), (APEXES["cohesion"], 4.0 * OPENING)],
    ids=["elastic", "apex without cohesion", "apex without hardening"],
)
def test_tangent_where_the_law_is_linear(p, strain):
    answer = update(p, strain)
    moved = update(p, strain + 0.01 * OTHER)
    assert moved.regime == answer.regime
    np.testing.assert_allclose(
        moved.stress - answer.stress, 0.01 * answer.tangent @ OTHER, atol=1e-11 * np.abs(answer.stress).max()
    )


@pytest.mark.parametrize(("changes", "symmetric"), SYMMETRY)
def test_tangent_is_symmetric_only_for_the_associated_law(changes, symmetric):
    tangent = update(make(**changes), PUSH).tangent
    skew = np.abs(tangent - tangent.T).max() / np.abs(tangent).max()
    assert (skew < 1.0e-13) == symmetric
    assert symmetric or skew > 1.0e-3


def test_stress_does_not_depend_on_asking_for_the_tangent():
    stress, history, untouched = np.zeros(6), np.zeros(1), np.full((6, 6), 7.0)
    for strain in (0.01 * PUSH, PUSH, OPENING):
        plasol.update(make(), strain, Point(START, np.zeros(1)), Point(stress, history), untouched, False)
        np.testing.assert_array_equal(stress, update(make(), strain).stress)
    assert np.all(untouched == 7.0)


# --- invariances ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("strain", [0.01 * PUSH, PUSH, OPENING], ids=["elastic", "cone", "apex"])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, -0.5)])
def test_rotated_strain_gives_the_rotated_stress(strain, axis):
    p, turn = make(psi=3.0, cohesion=1.0e3), rotation_matrix(axis, 0.7)
    first = update(p, 0.3 * OTHER)
    straight = update(p, strain, first.stress, first.kappa)

    def rotate(voigt, shear=1.0):
        return to_voigt(turn @ to_matrix(voigt, 1.0 / shear) @ turn.T, shear)

    rotated = update(p, rotate(strain, 2.0), rotate(first.stress), first.kappa)
    assert rotated.regime == straight.regime
    assert rotated.kappa == pytest.approx(straight.kappa, rel=1e-12)
    np.testing.assert_allclose(rotated.stress, rotate(straight.stress), atol=1e-10 * PRESSURE)


def test_units_scale():
    """Stress in kPa instead of Pa gives the same strains."""
    pa, kpa = make(cohesion=2.0e4), make(cohesion=20.0, young=YOUNG / 1000.0)
    np.testing.assert_allclose(update(pa, PUSH).stress, 1000.0 * update(kpa, PUSH, START / 1000.0).stress, rtol=1e-12)


def test_twice_the_same_and_old_state_only_read():
    p, strain, stress, history = make(psi=3.0), PUSH.copy(), START.copy(), np.array([1.0e-3])
    first, second = (update(p, strain, stress, history[0]) for _ in range(2))
    np.testing.assert_array_equal(first.stress, second.stress)
    np.testing.assert_array_equal(first.tangent, second.tangent)
    np.testing.assert_array_equal(strain, PUSH)
    np.testing.assert_array_equal(stress, START)


# --- status -----------------------------------------------------------------------------------------------


def test_a_local_iteration_cut_short_says_so(monkeypatch):
    monkeypatch.setattr(plasol, "_MAX_ITERATIONS", 1)
    monkeypatch.setattr(plasol, "_multiplier", plasol._multiplier.py_func)
    assert update(make(), PUSH, update=plasol.update.py_func).status == LAW_NOT_CONVERGED


def test_a_strain_that_is_no_number_never_becomes_a_finite_stress():
    answer = update(make(), np.full(6, np.nan))
    assert answer.status != OK or np.all(np.isnan(answer.stress))


# --- sweep ------------------------------------------------------------------------------------------------


@settings(max_examples=500, deadline=None, derandomize=True, database=None)
@given(p=soils(), strain_1=strains(), strain_2=strains(), pressure=st.sampled_from([0.0, 1.0, 1.0e4, 1.0e6]))
def test_no_parameters_and_no_strain_break_the_law(p, strain_1, strain_2, pressure):
    stress, kappa = pressure / PRESSURE * START, 0.0
    for strain in (strain_1, strain_2):
        answer = update(p, strain, stress, kappa)
        excess, size = trial_excess(p, strain, stress, answer.kappa)
        assert answer.status == OK
        assert np.all(np.isfinite(answer.stress))
        assert np.all(np.isfinite(answer.tangent))
        assert answer.kappa >= kappa
        left = plasol.APEX_STIFFNESS * excess if answer.regime == REGIME_APEX else 0.0
        assert plasol.yield_function(p, answer.stress, answer.kappa) <= left + 1.0e-13 * size
        if 0.0 <= p[plasol.M_PSI] <= plasol.cone_slope(p[plasol.PHI_I]):
            rounding = 1.0e-15 * size * (size / p[plasol.SHEAR] + size / p[plasol.BULK] + np.abs(strain).max())
            assert dissipation(p, strain, stress, answer) >= -10.0 * rounding
        stress, kappa = answer.stress, answer.kappa
