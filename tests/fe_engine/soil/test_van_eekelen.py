# SPDX-License-Identifier: MIT
"""Van Eekelen's surface at one point beside `test_frictional_laws`: outside answers, meridians, small steps."""

import itertools

import numpy as np
import pytest

from fe_engine.conventions import OK, REGIME_APEX, REGIME_CONE
from fe_engine.soil import formulas, lode, plasol, van_eekelen
from fe_engine.soil.dispatch import update_soil
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.law import Point
from fe_engine.soil.laws import SOIL_LAWS
from tests.support.models import DEGREE, to_matrix
from tests.support.soil_points import (
    COMPRESSION,
    MERIDIANS,
    OPENING,
    POISSON,
    PRESSURE,
    PUSH,
    START,
    YOUNG,
    Answer,
    invariants,
    make,
    slope_of,
    update_by,
)

N = -0.229


def update(p, strain, stress=START, kappa=0.0, update=van_eekelen.update) -> Answer:
    return update_by(update, p, strain, stress, kappa)


def surface(phi):
    """m of compression and of extension and the constants a, b, as Barnichon writes them."""
    compression = 2.0 * np.sin(phi) / (np.sqrt(3.0) * (3.0 - np.sin(phi)))
    extension = 2.0 * np.sin(phi) / (np.sqrt(3.0) * (3.0 + np.sin(phi)))
    ratio = (compression / extension) ** (1.0 / N)
    b = (ratio - 1.0) / (ratio + 1.0)
    return compression, extension, compression / (1.0 + b) ** N, b


def written(stress, phi, cohesion, offset=None):
    """II + a (1 + b sin 3beta)^n (I - offset), the offset 3 c/tan(phi) of the yield surface unless it is given."""
    first, second = invariants(stress)
    deviator = to_matrix(stress) - first / 3.0 * np.eye(3)
    sine = -1.5 * np.sqrt(3.0) * np.linalg.det(deviator) / second**3
    _, _, a, b = surface(phi)
    shift = 3.0 * cohesion / np.tan(phi) if offset is None else offset
    return second + a * (1.0 + b * np.clip(sine, -1.0, 1.0)) ** N * (first - shift)


# --- the surface ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angle", "a", "b"),
    [(5.0, 0.033499, -0.126223), (20.0, 0.128912, -0.462133), (30.0, 0.184379, -0.625905), (40.0, 0.231306, -0.739951)],
)
def test_constants_are_the_tabulated_ones(angle, a, b):
    found = lode.shape(angle * DEGREE)
    assert found == pytest.approx(b, abs=5.1e-7)
    assert plasol.cone_slope(angle * DEGREE) / (1.0 + found) ** N == pytest.approx(a, abs=5.1e-7)


@pytest.mark.parametrize("angle", [1.0, 10.0, 30.0, 46.0])
def test_both_meridians_have_the_friction_angle(angle):
    """Mohr-Coulomb: s1/s3 = (1 + sin phi)/(1 - sin phi) in compression and in extension."""
    p, ratio = make(phi_i=angle, phi_f=angle), (1.0 + np.sin(angle * DEGREE)) / (1.0 - np.sin(angle * DEGREE))
    for principal in ([1.0, 1.0, ratio], [1.0, ratio, ratio]):
        stress = -PRESSURE * np.array([*principal, 0.0, 0.0, 0.0])
        assert van_eekelen.yield_function(p, stress, 0.0) == pytest.approx(0.0, abs=1e-10 * PRESSURE)


@pytest.mark.parametrize("kappa", [0.0, 1.0e-3])
@pytest.mark.parametrize("cohesion", [0.0, 5.0e3])
def test_yield_function_is_the_written_one(cohesion, kappa):
    p, rng = make(cohesion=cohesion), np.random.default_rng(2)
    phi = (5.0 + 25.0 * kappa / (0.005 + kappa)) * DEGREE
    for _ in range(50):
        stress = START + 5.0e4 * rng.standard_normal(6)
        assert van_eekelen.yield_function(p, stress, kappa) == pytest.approx(written(stress, phi, cohesion), abs=1e-6)


@pytest.mark.parametrize(("angle", "convex"), [(10.0, True), (40.0, True), (46.5, True), (47.0, False)])
def test_the_surface_is_convex_to_its_greatest_angle(angle, convex):
    """A curve r(theta) is convex where r^2 + 2 r'^2 - r r'' >= 0."""
    theta, step = np.linspace(0.0, np.pi / 3.0, 2001), 1.0e-4
    at = [lode.section(lode.shape(angle * DEGREE), c) for c in np.cos(3.0 * theta)]
    plus, minus = (
        [lode.section(lode.shape(angle * DEGREE), c) for c in np.cos(3.0 * (theta + d))] for d in (step, -step)
    )
    r, r1, r2 = np.array(at), np.subtract(plus, minus) / (2 * step), (np.add(plus, minus) - 2 * np.array(at)) / step**2
    assert (np.min(r * r + 2.0 * r1 * r1 - r * r2) > -1e-4) == convex
    assert (angle * DEGREE <= formulas.MAX_FRICTION + 1e-12) == convex


# --- regimes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [make(psi=5.0), make(cohesion=2.0e4, phi_i=30.0)], ids=["cohesionless", "cohesion"])
def test_apex_is_that_of_the_cone(p):
    ours, cone = update(p, OPENING), update(p, OPENING, update=plasol.update)
    assert (ours.status, ours.regime) == (OK, REGIME_APEX)
    np.testing.assert_array_equal(ours.stress, cone.stress)
    np.testing.assert_array_equal(ours.tangent, cone.tangent)


def test_surface_and_apex_meet_without_a_jump():
    """Along a path of strains that opens more and more the stress is continuous where the regime changes."""
    p = make(psi=10.0, cohesion=5.0e3)
    path = [PUSH + share * 2.0e-3 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) for share in np.linspace(0.0, 1.0, 4001)]
    answers = [update(p, strain) for strain in path]
    regimes = [answer.regime for answer in answers]
    assert {REGIME_CONE, REGIME_APEX} <= set(regimes)
    jumps = [np.abs(b.stress - a.stress).max() for a, b in itertools.pairwise(answers)]
    assert max(jumps) < 4.0 * np.median(jumps[: regimes.index(REGIME_APEX)])


# --- outside answers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("psi", [0.0, 10.0, 30.0])
@pytest.mark.parametrize("strain", [COMPRESSION, 4.0 * COMPRESSION])
def test_in_compression_it_is_the_cone(psi, strain):
    p = make(psi=psi)
    ours, cone = update(p, strain), update(p, strain, update=plasol.update)
    np.testing.assert_allclose(ours.stress, cone.stress, rtol=1e-12)
    assert ours.kappa == pytest.approx(cone.kappa, rel=1e-11)


@pytest.mark.parametrize(("kappa", "ratio", "axial"), [(0.0025, 0.5995, 0.0028), (0.02, 1.4639, 0.020732)])
def test_triaxial_compression_in_one_step(kappa, ratio, axial):
    """The table of the cone, which is the compression meridian."""
    q = ratio * PRESSURE
    lateral = 0.5 * (axial - q * (1.0 - 2.0 * POISSON) / YOUNG)
    answer = update(make(), np.array([lateral, lateral, -axial, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(answer.stress[:3], [-PRESSURE, -PRESSURE, -PRESSURE - q], rtol=2e-4)
    assert answer.kappa == pytest.approx(kappa, rel=1e-3)


def test_triaxial_extension_reaches_two_thirds():
    """Unloaded along an axis at constant radial stress: q = 0.667 s_r at 30 degrees."""
    q, axial = 2.0 / 3.0 * PRESSURE, 2.0e-3
    lateral = 0.5 * (q * (1.0 - 2.0 * POISSON) / YOUNG - axial)
    stress = update(make(phi_i=30.0), np.array([lateral, lateral, axial, 0.0, 0.0, 0.0])).stress
    np.testing.assert_allclose(stress[:3], [-PRESSURE, -PRESSURE, -PRESSURE + q], rtol=1e-9)


@pytest.mark.parametrize("strain", MERIDIANS.values(), ids=MERIDIANS)
def test_without_dilation_the_lode_angle_stays(strain):
    stress = update(make(), strain + 0.3 * PUSH).stress
    trial = START + elastic_matrix(YOUNG, POISSON) @ (strain + 0.3 * PUSH)
    ours, start = (s - s[:3].mean() * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) for s in (stress, trial))
    np.testing.assert_allclose(ours / np.linalg.norm(ours), start / np.linalg.norm(start), atol=1e-13)


def test_with_dilation_the_stress_turns_towards_compression():
    def cos3(stress):
        first, second = invariants(stress)
        return -1.5 * np.sqrt(3.0) * np.linalg.det(to_matrix(stress) - first / 3.0 * np.eye(3)) / second**3

    trial = START + elastic_matrix(YOUNG, POISSON) @ PUSH
    assert cos3(update(make(psi=20.0), PUSH).stress) > cos3(trial) + 0.05


def test_without_friction_it_is_von_mises():
    p = make(phi_i=0.0, phi_f=0.0, cohesion=2.0e4)
    np.testing.assert_allclose(update(p, 5.0 * PUSH).stress, update(p, 5.0 * PUSH, update=plasol.update).stress)


def gradient(f, stress):
    """Slope (6,) of a function of stress by central differences; engineering strains are conjugate to it."""
    steps = 1.0e-5 * PRESSURE * np.eye(6)
    return np.array([(f(stress + d) - f(stress - d)) / (2.0e-5 * PRESSURE) for d in steps])


def rate(p_angles, cohesion, stress, kappa, strain):
    """Rates of stress and kappa on the surface from written f and g: the elastoplastic equations themselves."""
    phi_i, phi_f, psi = p_angles
    phi = phi_i + (phi_f - phi_i) * kappa / (0.005 + kappa)
    stiffness = elastic_matrix(YOUNG, POISSON)
    n = gradient(lambda s: written(s, phi, cohesion), stress)
    _, _, a, b = surface(psi)
    first, second = invariants(stress)
    sine = -1.5 * np.sqrt(3.0) * np.linalg.det(to_matrix(stress) - first / 3.0 * np.eye(3)) / second**3
    offset = first + second / (a * (1.0 + b * sine) ** N)  # g = 0 at the stress
    r = gradient(lambda s: written(s, psi, 0.0, offset), stress)
    deviator = r - r[:3].mean() * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    growth = np.sqrt(2.0 / 3.0 * (np.sum(deviator[:3] ** 2) + 0.5 * np.sum(deviator[3:] ** 2)))
    step = 1.0e-6
    hardened = [
        written(stress, phi_i + (phi_f - phi_i) * k / (0.005 + k), cohesion) for k in (kappa + step, kappa - step)
    ]
    softening = (hardened[0] - hardened[1]) / (2.0 * step) * growth
    assert n @ stiffness @ strain > 0.0, "unloads: these are the equations of yield"
    dl = n @ stiffness @ strain / (n @ stiffness @ r - softening)
    return stiffness @ (strain - dl * r), dl * growth


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("phi_f", "psi", "cohesion"), [(30.0, 10.0, 0.0), (40.0, 25.0, 5.0e3), (30.0, -4.0, 0.0)])
def test_fine_steps_tend_to_the_elastoplastic_equations(seed, phi_f, psi, cohesion):
    """Random strain paths of two legs; backward Euler is of first order in the number of steps."""
    rng = np.random.default_rng(seed)
    # a soil that contracts is pressed together too: it would lose all its stress at constant volume
    mean = np.append(np.full(3, 0.2 if psi < 0.0 else 0.0), np.zeros(3))
    draws = [d - np.append(np.full(3, d[:3].mean()), np.zeros(3)) for d in rng.standard_normal((2, 6))]
    legs = [2e-3 * (draws[0] - mean), 2e-3 * (draws[0] + 0.5 * draws[1] - mean)]
    p, angles = make(phi_f=phi_f, psi=psi, cohesion=cohesion), np.radians([5.0, phi_f, psi])
    first = update(p, legs[0])
    stress, kappa, n = first.stress, first.kappa, 400
    for _ in range(n):  # the midpoint rule on the equations of the second leg
        half = [0.5 * d / n for d in rate(angles, cohesion, stress, kappa, legs[1])]
        whole = rate(angles, cohesion, stress + half[0], kappa + half[1], legs[1])
        stress, kappa = stress + whole[0] / n, kappa + whole[1] / n
    errors = []
    for n in (50, 100, 200):
        at, e = first.stress, first.kappa
        for _ in range(n):
            answer = update(p, legs[1] / n, at, e)
            at, e = answer.stress, answer.kappa
        errors.append(np.abs(at - stress).max() / np.abs(stress).max())
    assert errors[-1] < 0.01
    assert errors[0] / errors[-1] == pytest.approx(4.0, rel=0.3)


# --- tangents ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("meridian", ["compression", "extension"])
@pytest.mark.parametrize("off", [1.0e-4, 1.0e-7, 1.0e-10, 1.0e-13])
def test_tangent_beside_a_meridian(meridian, off):
    """The surface is smooth there, though the direction of theta turns with any change of stress."""
    strain = MERIDIANS[meridian] + off * PUSH
    assert slope_of(update, make(psi=12.0, cohesion=3.0e3), strain) == pytest.approx(2.0, abs=0.1)
    on, beside = (update(make(psi=12.0), e).tangent for e in (MERIDIANS[meridian], strain))
    assert np.abs(on - beside).max() < 20.0 * off * np.abs(on).max() + 1e-9 * YOUNG


# --- invariances ------------------------------------------------------------------------------------------


def test_the_chain_of_laws_calls_it():
    stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
    code, before, after = SOIL_LAWS.code(van_eekelen.LAW), Point(START, np.zeros(1)), Point(stress, history)
    update_soil(code, make(psi=5.0), PUSH, before, after, tangent, True)
    answer = update(make(psi=5.0), PUSH)
    np.testing.assert_array_equal(stress, answer.stress)
    np.testing.assert_array_equal(tangent, answer.tangent)
