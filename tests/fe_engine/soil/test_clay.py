# SPDX-License-Identifier: MIT
"""Undrained clay at one point: strengths of element tests, mobilisation, corners of Tresca's surface, and a sweep."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.optimize import minimize

from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import mobilised, plasol, tresca, von_mises
from fe_engine.soil.elastic import elastic_matrix, moduli
from tests.support.models import rotation_matrix, taylor_slope, to_matrix, to_voigt
from tests.support.soil_points import SIZES, START, Answer, update_by

YOUNG, POISSON, SU = 1.2e7, 0.49, 2.0e4
SHEAR = moduli(YOUNG, POISSON)[1]
STIFFNESS = elastic_matrix(YOUNG, POISSON)
ONE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
YIELD = SU / SHEAR  # shear strain at which a perfectly plastic soil yields
# strains whose size is a shear strain of 1
COMPRESSION = np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]) / 1.5
PLANE = np.array([0.5, 0.0, -0.5, 0.0, 0.0, 0.0])
SIMPLE = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
TESTS = {"compression": COMPRESSION, "extension": -COMPRESSION, "plane strain": PLANE, "simple shear": SIMPLE}
GENERAL = np.array([0.5, -0.2, -0.35, 0.25, -0.15, 0.4])
OTHER = np.array([0.15, 0.25, -0.3, -0.45, 0.2, 0.35])
LAWS = [pytest.param(law, id=law.__name__.rpartition(".")[2]) for law in (tresca, von_mises)]
CURVES = {"perfectly plastic": 0.0, "hyperbola": YIELD, "soft": 10.0 * YIELD}


def update(law, p, strain, stress=START, kappa=0.0) -> Answer:
    return update_by(law.update, p, strain, stress, kappa)


def make(strain=0.0, mobilised_share=0.0, strength=SU):
    return mobilised.pack(YOUNG, POISSON, strength, strain, mobilised_share)


def largest_shear(stress):
    values = np.linalg.eigvalsh(to_matrix(stress))
    return 0.5 * (values[-1] - values[0])


# --- element tests ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TESTS)
def test_tresca_has_the_same_strength_in_every_test(name):
    answer = update(tresca, make(), 20.0 * YIELD * TESTS[name])
    assert answer.regime == REGIME_CONE
    assert largest_shear(answer.stress) == pytest.approx(SU, rel=1e-12)
    assert answer.stress[:3].sum() == pytest.approx(START[:3].sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "ratio"),
    [
        ("compression", np.sqrt(3.0) / 2.0),
        ("extension", np.sqrt(3.0) / 2.0),
        ("plane strain", 1.0),
        ("simple shear", 1.0),
    ],
)
def test_von_mises_is_weaker_in_triaxial_tests(name, ratio):
    answer = update(von_mises, make(), 20.0 * YIELD * TESTS[name])
    assert largest_shear(answer.stress) == pytest.approx(ratio * SU, rel=1e-12)


def test_von_mises_is_plasol_without_friction():
    """k = 2 c/sqrt(3): another code for the same surface."""
    sand = plasol.pack(YOUNG, POISSON, 0.0, 0.0, 1.0, 0.0, np.sqrt(3.0) / 2.0 * SU)
    for strain in (5.0 * YIELD * GENERAL, 30.0 * YIELD * OTHER):
        ours, theirs = update(von_mises, make(), strain), update(plasol, sand, strain)
        np.testing.assert_allclose(ours.stress, theirs.stress, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=1e-10, atol=1e-6 * SHEAR)
        assert ours.kappa == pytest.approx(theirs.kappa, rel=1e-12)


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("strain", [0.1, 1.0, 4.0, 50.0])
def test_simple_shear_follows_the_hyperbola(law, strain, steps):
    """tau = G gamma/(1 + G gamma/su), in one step as in many."""
    stress, kappa = START, 0.0
    for _ in range(steps):
        answer = update(law, make(YIELD), strain / steps * YIELD * SIMPLE, stress, kappa)
        stress, kappa = answer.stress, answer.kappa
    assert stress[3] == pytest.approx(SU * strain / (1.0 + strain), rel=1e-12)
    assert kappa * np.sqrt(3.0) == pytest.approx(strain * YIELD - stress[3] / SHEAR, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("half", [0.7, 1.0, 6.0])
def test_half_of_the_strength_is_mobilised_at_its_strain(law, half):
    scale = mobilised.scale_of(half * YIELD, SU, SHEAR)
    stress = update(law, make(scale), half * YIELD * SIMPLE).stress
    assert stress[3] == pytest.approx(0.5 * SU, rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_unloading_is_elastic_and_reloading_goes_on_with_the_curve(law):
    p, step = make(YIELD), 0.5 * YIELD * SIMPLE
    there = update(law, p, 3.0 * step)
    back = update(law, p, -step, there.stress, there.kappa)
    assert (back.regime, back.kappa) == (REGIME_ELASTIC, there.kappa)
    assert back.stress[3] == pytest.approx(there.stress[3] - 0.5 * SU, rel=1e-12)
    again = update(law, p, 2.0 * step, back.stress, back.kappa)
    direct = update(law, p, 4.0 * step)
    np.testing.assert_allclose(again.stress, direct.stress, rtol=1e-12, atol=1e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
def test_an_initial_state_that_has_mobilised_strength_is_in_equilibrium(law, scale):
    stress = START - 0.3 * SU * np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0])
    share = {tresca: 0.3, von_mises: 0.6 / np.sqrt(3.0)}[law]
    still = update(law, make(scale, share), np.zeros(6), stress)
    np.testing.assert_allclose(still.stress, stress, rtol=1e-14)
    assert still.kappa <= 1e-15
    pushed = update(law, make(scale, share), 50.0 * YIELD * COMPRESSION, stress)
    assert pushed.regime == REGIME_CONE
    assert largest_shear(pushed.stress) < largest_shear(update(law, make(), 50.0 * YIELD * COMPRESSION).stress) + 1e-6


# --- return -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_tresca_returns_to_the_closest_point(seed):
    """In the norm of the elastic energy, on a convex surface: a general minimiser finds it from principal stresses."""
    rng = np.random.default_rng(seed)
    strain = 10.0 ** rng.uniform(0.2, 1.5) * YIELD * rng.standard_normal(6)
    trial = np.sort(np.linalg.eigvalsh(to_matrix(START + STIFFNESS @ strain)))[::-1] / SU
    if seed % 3 == 0:  # close to a meridian, where the corners are
        trial[1] = trial[0] - 0.05 * (trial[0] - trial[2])
        turn = np.diag(trial) * SU
        strain = np.linalg.solve(STIFFNESS, to_voigt(turn) - START)
    mean, bulk = trial.mean(), moduli(YOUNG, POISSON)[0]

    def energy(s):
        away = s - trial
        return (np.sum((away - away.mean()) ** 2) / (4.0 * SHEAR) + away.mean() ** 2 / (2.0 * bulk)) * SHEAR

    order = (
        {"type": "ineq", "fun": lambda s, i=i, j=j: 2.0 - (s[i] - s[j])} for i in range(3) for j in range(3) if i != j
    )
    best = minimize(
        energy, np.full(3, mean), constraints=list(order), method="SLSQP", options={"ftol": 1e-15, "maxiter": 500}
    )
    found = np.sort(np.linalg.eigvalsh(to_matrix(update(tresca, make(), strain).stress)))[::-1] / SU
    np.testing.assert_allclose(found, best.x, atol=2e-6 * np.abs(trial).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
def test_plastic_flow_keeps_the_volume_and_dissipates(law, scale):
    rng = np.random.default_rng(5)
    for _ in range(50):
        strain = 5.0 * YIELD * rng.standard_normal(6)
        answer = update(law, make(scale), strain)
        plastic = strain - np.linalg.solve(STIFFNESS, answer.stress - START)
        assert abs(plastic[:3].sum()) < 1e-12
        work = (answer.stress - START[0] * ONE) @ plastic
        conjugate = np.sqrt(3.0) * answer.kappa
        shear = {
            tresca: largest_shear(answer.stress),
            von_mises: np.sqrt(0.5) * np.linalg.norm(deviator(answer.stress)),
        }
        assert work == pytest.approx(shear[law] * conjugate, rel=1e-9)


def deviator(stress):
    tensor = to_matrix(stress)
    return tensor - np.trace(tensor) / 3.0 * np.eye(3)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
def test_closed_loops_of_strain_give_no_energy(law, scale):
    """Work of the stress over loops of random strains that come back to where they began."""
    rng = np.random.default_rng(8)
    for _ in range(20):
        legs = YIELD * rng.standard_normal((5, 6))
        stress, kappa, work = START, 0.0, 0.0
        for leg in [*legs, -legs.sum(axis=0)]:
            for _ in range(4):
                answer = update(law, make(scale), leg / 4.0, stress, kappa)
                work += 0.5 * (stress + answer.stress) @ leg / 4.0
                stress, kappa = answer.stress, answer.kappa
        end = stress - START
        stored = 0.5 * end @ np.linalg.solve(STIFFNESS, end)
        assert work >= stored - 1e-9 * SU


# --- tangents ---------------------------------------------------------------------------------------------


def slope_of(law, p, strain, stress=START, kappa=0.0, along=OTHER):
    answer = update(law, p, strain, stress, kappa)
    size = np.abs(strain).max() / np.abs(along).max()
    for share in SIZES:
        assert update(law, p, strain + share * size * along, stress, kappa).regime == answer.regime
    return taylor_slope(
        lambda e: update(law, p, e, stress, kappa).stress, answer.tangent, strain, 0.1 * size * along, SIZES
    )


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("strain", [GENERAL, PLANE + 0.02 * OTHER, SIMPLE], ids=["general", "plane", "simple shear"])
def test_tangent_away_from_corners(law, scale, strain):
    assert slope_of(law, make(scale), 4.0 * YIELD * strain) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("meridian", ["compression", "extension"])
@pytest.mark.parametrize("off", [1.0e-2, 1.0e-4, 1.0e-8, 1.0e-12, 0.0])
@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_tangent_at_the_corners_of_tresca(scale, meridian, off, angle):
    """Trial values that meet or nearly meet, along axes and turned against them."""
    turn = rotation_matrix((1.0, 2.0, -0.5), angle)
    strain = to_voigt(turn @ to_matrix(4.0 * YIELD * (TESTS[meridian] + off * OTHER), 0.5) @ turn.T, 2.0)
    assert slope_of(tresca, make(scale), strain, along=0.01 * GENERAL) > 1.9


@pytest.mark.parametrize("law", LAWS)
def test_tangent_after_earlier_yield(law):
    p = make(YIELD)
    first = update(law, p, 2.0 * YIELD * OTHER)
    assert slope_of(law, p, 4.0 * YIELD * GENERAL, first.stress, first.kappa) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", CURVES.values(), ids=CURVES)
def test_tangents_are_symmetric(law, scale):
    for strain in (GENERAL, COMPRESSION + 1e-3 * OTHER, -COMPRESSION):
        tangent = update(law, make(scale), 6.0 * YIELD * strain).tangent
        np.testing.assert_allclose(tangent, tangent.T, atol=1e-9 * SHEAR)


# --- principal values -------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_principal_values_are_those_of_lapack(seed):
    rng = np.random.default_rng(seed)
    stress = rng.standard_normal(6)
    if seed == 0:
        stress = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    if seed == 1:
        stress = to_voigt(
            rotation_matrix((1.0, -1.0, 0.3), 1.1)
            @ np.diag([2.0, 2.0, -4.0 + 1e-13])
            @ rotation_matrix((1.0, -1.0, 0.3), 1.1).T
        )
    values, directions, back = np.empty(3), np.empty((3, 3)), np.empty(6)
    tresca.principal(stress, values, directions)
    np.testing.assert_allclose(values, np.linalg.eigvalsh(to_matrix(stress))[::-1], atol=1e-14)
    np.testing.assert_allclose(directions @ directions.T, np.eye(3), atol=1e-15)
    tresca.compose(values, directions, back)
    np.testing.assert_allclose(back, stress, atol=1e-14)


# --- sweep ------------------------------------------------------------------------------------------------


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(
    law=st.sampled_from([tresca, von_mises]),
    strength=st.sampled_from([1.0, 1.0e3, 2.0e4, 1.0e6]),
    rigidity=st.sampled_from([50.0, 500.0, 1.0e5]),
    poisson=st.sampled_from([0.3, 0.49, 0.4999]),
    scale=st.sampled_from([0.0, 1.0e-3, 1.0, 1.0e3]),
    strains=st.lists(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), min_size=2, max_size=2),
    size=st.floats(-8.0, -1.0),
)
def test_no_parameters_and_no_strain_break_the_law(law, strength, rigidity, poisson, scale, strains, size):
    shear = rigidity * strength
    p = mobilised.pack(2.0 * shear * (1.0 + poisson), poisson, strength, scale / rigidity)
    stress, kappa = START, 0.0
    for strain in strains:
        answer = update(law, p, 10.0**size * np.array(strain), stress, kappa)
        assert answer.status == OK
        assert np.all(np.isfinite(answer.stress)) and np.all(np.isfinite(answer.tangent))
        assert answer.kappa >= kappa
        rounding = 1e-13 * (np.abs(answer.stress).max() + shear)
        assert law.yield_function(p, answer.stress, answer.kappa) <= rounding + 1e-9 * strength
        stress, kappa = answer.stress, answer.kappa
