# SPDX-License-Identifier: MIT
"""PLASOL at one point beside `test_frictional_laws`: apex, triaxial paths, limits, linear parts, units."""

import numpy as np
import pytest

from fe_engine.conventions import OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import plasol
from tests.support.models import DEGREE
from tests.support.soil_points import (
    OPENING,
    OTHER,
    POISSON,
    PRESSURE,
    PUSH,
    START,
    YOUNG,
    Answer,
    elastic,
    invariants,
    make,
    slope_of,
    trial_excess as excess_of,
    update_by,
)


def update(p, strain, stress=START, kappa=0.0, update=plasol.update) -> Answer:
    return update_by(update, p, strain, stress, kappa)


def cone(phi):
    """m(phi) as physics books write it."""
    return 2.0 * np.sin(phi) / (np.sqrt(3.0) * (3.0 - np.sin(phi)))


def trial_excess(p, strain, stress, kappa):
    return excess_of(plasol.yield_function, p, strain, stress, kappa)


APEXES = {
    "cohesionless": make(psi=5.0),
    "cohesion": make(phi_i=30.0, cohesion=2.0e4),
    "cohesion and hardening": make(cohesion=4.0e3, psi=4.0),
}


# --- regimes ----------------------------------------------------------------------------------------------


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


def test_tangent_at_the_apex_that_moves_with_hardening():
    assert slope_of(update, APEXES["cohesion and hardening"], OPENING) == pytest.approx(2.0, abs=0.1)


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


# --- invariances ------------------------------------------------------------------------------------------


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
