# SPDX-License-Identifier: MIT
"""Elements in parallel at one point: backbone, Masing's rules, damping, energy, pressure, tangents, and a sweep."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fe_engine.conventions import REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import iwan_clay, iwan_sand, overlay, von_mises
from fe_engine.soil.elastic import elastic_matrix, moduli
from fe_engine.soil.law import Point
from pysprings.scene.soils.clay import MOST_POINTS
from tests.support.models import taylor_slope
from tests.support.soil_points import SIZES, START, stepped

YOUNG, POISSON, SU = 1.2e7, 0.49, 2.0e4
SHEAR = moduli(YOUNG, POISSON)[1]
YIELD = SU / SHEAR  # strain at which the hyperbola has half of its strength
SIMPLE = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
GENERAL = np.array([0.5, -0.2, -0.35, 0.25, -0.15, 0.4])
OTHER = np.array([0.15, 0.25, -0.3, -0.45, 0.2, 0.35])
CLAY = iwan_clay.pack(YOUNG, POISSON, SU, YIELD)
SAND_PRESSURE = 1.0e5
SAND = {"young": 1e8, "poisson": 0.3, "phi_i": 0.1, "phi_f": 0.6, "b_phi": 0.002, "cohesion": 0.0}
# more stress than the hyperbola has, between the points where the elements meet it
MORE = 0.025


class Soil:
    """A point that is driven by strains."""

    def __init__(self, p, stress=START):
        self.p, self.stress, self.history = p, np.array(stress), np.zeros(len(overlay.HISTORY))

    def trial(self, strain):
        return stepped(overlay.update, self.p, strain, Point(self.stress, self.history))

    def go(self, strain, steps=1):
        """Return the shear stress after each of equal steps."""
        out = []
        for _ in range(steps):
            new, _, _ = self.trial(np.asarray(strain) / steps)
            self.stress, self.history = new.stress, new.history
            out.append(new.stress[3])
        return np.array(out)


def hyperbola(gamma):
    return SHEAR * gamma / (1.0 + np.abs(gamma) / YIELD)


def sand(pressure=SAND_PRESSURE, **changes):
    return iwan_sand.pack(**SAND | changes, pressure=pressure)


def second(stress):
    deviator = stress[:3] - stress[:3].mean()
    return np.sqrt(0.5 * np.sum(deviator**2) + np.sum(stress[3:] ** 2))


# --- backbone ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [CLAY, iwan_clay.pack(YOUNG, POISSON, SU, 20 * YIELD), sand(), sand(cohesion=5e3)])
def test_shares_are_positive_and_sum_to_one(p):
    w, rho = p[overlay.FIRST : overlay.RADIUS], p[overlay.RADIUS :]
    assert len(w) == len(rho) == overlay.ELEMENTS
    assert np.all(w >= 0.0) and np.all(rho >= 0.0)
    assert [w.sum(), rho.sum()] == pytest.approx([1.0, 1.0], rel=1e-12)


def test_shares_may_differ_from_point_to_point():
    strength = np.array([[1e4, 2e4], [3e4, 4e4]])
    many = iwan_clay.pack(YOUNG, POISSON, strength, strength / SHEAR)
    assert many.shape == (2, 2, len(overlay.PARAMETERS))
    np.testing.assert_allclose(many[0, 1], CLAY, rtol=1e-12)


def test_the_backbone_has_points_and_tangents_of_the_hyperbola():
    x = overlay.mobilised_shares(overlay.ELEMENTS - 1)
    for share in x:
        new, tangent, _ = Soil(CLAY).trial(share / (1.0 - share) * YIELD * (1.0 + 1e-12) * SIMPLE)
        assert new.stress[3] == pytest.approx(share * SU, rel=1e-9)
        assert tangent[3, 3] == pytest.approx((1.0 - share) ** 2 * SHEAR, rel=1e-9)


def test_secant_modulus_follows_the_hyperbola_at_all_strains():
    gamma = YIELD * np.geomspace(1e-3, 1e3, 60)
    secant = np.array([Soil(CLAY).go(g * SIMPLE)[0] for g in gamma]) / gamma / SHEAR
    ratio = secant * (1.0 + gamma / YIELD)
    assert np.all(ratio > 1.0 - 1e-12) and ratio.max() < 1.0 + MORE


def test_one_step_or_many_in_one_direction_are_the_same():
    assert Soil(CLAY).go(7.0 * YIELD * GENERAL, 9)[-1] == pytest.approx(Soil(CLAY).go(7.0 * YIELD * GENERAL)[-1])


def test_without_hardening_it_is_von_mises():
    p, other = iwan_clay.pack(YOUNG, POISSON, SU), von_mises.LAW.pack(YOUNG, POISSON, SU)
    for size in (0.3, 0.9, 5.0):
        new, tangent, _ = Soil(p).trial(size * YIELD * GENERAL)
        theirs, slopes, _ = stepped(von_mises.update, other, size * YIELD * GENERAL, Point(START, np.zeros(1)))
        np.testing.assert_allclose(new.stress, theirs.stress, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(tangent, slopes, rtol=1e-10, atol=1e-6 * SHEAR)
        assert new.history[overlay.KAPPA] == pytest.approx(theirs.history[0], rel=1e-9, abs=1e-15)


# A published form: half at 0.2 %, and what is left of it at large strains
TABLE = np.array([(1e-5, 0.99), (1e-4, 0.93), (5e-4, 0.75), (1e-3, 0.6), (2e-3, 0.45), (5e-3, 0.25), (2e-2, 0.08)])
TABLED = iwan_clay.pack_table(YOUNG, POISSON, SU, *TABLE.T)


def polygon():
    """Corners of the backbone of the table: the elastic line, its points but the first, and the strength."""
    gamma, tau = TABLE[:, 0], SHEAR * TABLE[:, 0] * TABLE[:, 1]
    slope = np.diff(tau) / np.diff(gamma)
    first = (tau[0] - slope[0] * gamma[0]) / (SHEAR - slope[0])
    last = gamma[-1] + (SU - tau[-1]) / slope[-1]
    return np.array([0.0, first, *gamma[1:], last]), np.array([0.0, SHEAR * first, *tau[1:], SU])


def test_a_table_of_the_secant_modulus_is_followed_at_its_points_up_to_the_strength():
    p = TABLED
    assert [p[overlay.FIRST : overlay.RADIUS].sum(), p[overlay.RADIUS :].sum()] == pytest.approx([1.0, 1.0])
    assert p[overlay.FIRST :].min() >= 0.0
    found = [Soil(p).go(gamma * SIMPLE, 3)[-1] / gamma / SHEAR for gamma in TABLE[:, 0]]
    np.testing.assert_allclose(found, TABLE[:, 1], rtol=1e-9)
    corners, stresses = polygon()
    assert Soil(p).go(corners[-1] * SIMPLE)[-1] == pytest.approx(Soil(p).go(2.0 * corners[-1] * SIMPLE)[-1])
    assert stresses[-1] == SU
    many = iwan_clay.pack_table(YOUNG, POISSON, SU * np.array([[1.0, 1.1]]), *TABLE.T)
    assert many.shape == (1, 2, len(overlay.PARAMETERS))
    np.testing.assert_allclose(many[0, 0], p, rtol=1e-12)
    assert iwan_clay.MOST_POINTS == MOST_POINTS
    ten = np.geomspace(1e-5, 1e-2, MOST_POINTS)
    full = iwan_clay.pack_table(YOUNG, POISSON, SU, ten, 1.0 / (1.0 + ten / YIELD))
    assert (full[overlay.FIRST : overlay.RADIUS] > 0.0).all()


@pytest.mark.parametrize("amplitude", [5e-4, 2e-3, 1.3e-2])
def test_the_damping_of_a_table_is_that_of_masings_rules(amplitude):
    """(2/pi)(2 A/(tau gamma) - 1), A the area below the polygon up to the amplitude; steps end at its corners."""
    corners, stresses = polygon()
    inside = corners[corners < amplitude]
    gamma = np.append(inside, amplitude)
    tau = np.interp(gamma, corners, stresses)
    area = np.trapezoid(tau, gamma)
    expected = 2.0 / np.pi * (2.0 * area / (tau[-1] * amplitude) - 1.0)
    soil, work = Soil(TABLED), 0.0
    soil.go(amplitude * SIMPLE)
    for sign in (-1.0, 1.0):
        for step in np.diff(2.0 * gamma):
            before = soil.stress[3]
            work += 0.5 * (before + soil.go(sign * step * SIMPLE)[-1]) * sign * step
    assert soil.stress[3] == pytest.approx(tau[-1], rel=1e-9)
    assert work / (2.0 * np.pi * tau[-1] * amplitude) == pytest.approx(expected, rel=1e-9)
    assert 0.02 < expected < 0.6


# --- Masing -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 8.0])
def test_unloading_and_reloading_follow_the_backbone_twice_as_large(amplitude):
    soil, top = Soil(CLAY), amplitude * YIELD
    start = soil.go(top * SIMPLE, 5)[-1]
    for sign in (-1.0, 1.0):
        branch = soil.go(2.0 * sign * top * SIMPLE, 20)
        own = np.array([Soil(CLAY).go(0.5 * step * SIMPLE)[0] for step in 2.0 * top * np.arange(1, 21) / 20])
        np.testing.assert_allclose(branch, -sign * start + 2.0 * sign * own, rtol=1e-9, atol=1e-9 * SU)


def test_a_larger_load_goes_on_with_the_curve_that_it_left():
    soil, fresh = Soil(CLAY), Soil(CLAY)
    for leg in (2.0, -1.0, 0.4, -0.4, 1.0):  # a small loop within a larger one, back to 2
        soil.go(leg * YIELD * SIMPLE, 3)
    fresh.go(2.0 * YIELD * SIMPLE, 3)
    np.testing.assert_allclose(soil.stress, fresh.stress, rtol=1e-9)
    assert soil.go(YIELD * SIMPLE)[-1] == pytest.approx(fresh.go(YIELD * SIMPLE)[-1], rel=1e-9)


@pytest.mark.parametrize("amplitude", [0.1, 0.3, 1.0, 3.0, 10.0, 30.0])
def test_damping_ratio_is_that_of_the_masing_loop_of_a_hyperbola(amplitude):
    """D = (4/pi)(1 + 1/a)(1 - ln(1 + a)/a) - 2/pi with a = gamma/gamma_r (Ishihara 1996, section 3.2)."""
    soil, top = Soil(CLAY), amplitude * YIELD
    soil.go(top * SIMPLE, 20)
    peak, work, before = soil.stress[3], 0.0, soil.stress[3]
    for sign in (-1.0, 1.0):
        branch = soil.go(2.0 * sign * top * SIMPLE, 400)
        work += np.sum(0.5 * (np.concatenate([[before], branch[:-1]]) + branch)) * 2.0 * sign * top / 400
        before = branch[-1]
    damping = work / (2.0 * np.pi * peak * top)
    a = amplitude
    closed = 4.0 / np.pi * (1.0 + 1.0 / a) * (1.0 - np.log1p(a) / a) - 2.0 / np.pi
    assert damping == pytest.approx(closed, abs=0.012)


@pytest.mark.parametrize("p", [CLAY, sand()], ids=["clay", "sand"])
def test_closed_loops_of_strain_give_no_energy(p):
    rng = np.random.default_rng(8)
    bulk, shear = p[overlay.BULK], p[overlay.SHEAR]
    young = 9.0 * bulk * shear / (3.0 * bulk + shear)
    stiffness = elastic_matrix(young, 0.5 * young / shear - 1.0)
    for _ in range(20):
        legs = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]) * 3e-4 * rng.standard_normal((5, 6))
        legs[:, :3] -= legs[:, :3].mean(axis=1, keepdims=True)
        soil, work = Soil(p), 0.0
        for leg in [*legs, -legs.sum(axis=0)]:
            for _ in range(8):
                before = soil.stress
                soil.go(leg / 8.0)
                work += 0.5 * (before + soil.stress) @ leg / 8.0
        end = soil.stress - START
        assert work >= 0.5 * end @ np.linalg.solve(stiffness, end) - 1e-9


# --- pressure ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.02, 0.2, 1.0, 5.0])
def test_first_loading_of_sand_at_its_pressure_follows_the_hyperbola_of_strength(share):
    p = sand()
    strength = p[overlay.STRENGTH] + 3.0 * p[overlay.SLOPE] * SAND_PRESSURE
    first = 3.0 * 2.0 * np.sin(0.1) / (np.sqrt(3.0) * (3.0 - np.sin(0.1))) * SAND_PRESSURE
    plastic = share * SAND["b_phi"]
    tau = first + (strength - first) * share / (1.0 + share)
    gamma = tau / p[overlay.SHEAR] + np.sqrt(3.0) * plastic
    assert Soil(p).go(gamma * SIMPLE)[-1] == pytest.approx(tau, rel=0.02)


def test_sand_at_last_has_the_friction_angle_in_triaxial_compression():
    soil = Soil(sand())
    for _ in range(400):  # constant mean stress
        soil.go(1e-3 * np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]))
    small, large = -soil.stress[0], -soil.stress[2]
    assert (large - small) / (large + small) == pytest.approx(np.sin(0.6), rel=1e-3)


def test_stress_and_strain_grow_with_the_pressure():
    p = sand()
    one, two = Soil(p), Soil(p, 3.0 * START)
    np.testing.assert_allclose(two.go(3e-3 * GENERAL, 4), 3.0 * one.go(1e-3 * GENERAL, 4), rtol=1e-9)


def test_pressure_alone_leaves_the_deviator_and_decompression_reduces_it():
    soil, bulk = Soil(sand()), sand()[overlay.BULK]
    soil.go(2e-3 * SIMPLE)
    tau = soil.stress[3]
    squeeze = -2e4 / bulk / 3.0 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    assert soil.go(squeeze)[-1] == pytest.approx(tau, rel=1e-12)
    soil.go(-4.0 * squeeze)
    assert soil.stress[3] < tau
    limit = soil.p[overlay.STRENGTH] - soil.p[overlay.SLOPE] * soil.stress[:3].sum()
    assert second(soil.stress) <= limit


def test_opening_leaves_next_to_no_stress_and_closing_builds_it_up_again():
    soil = Soil(sand())
    soil.go(1e-3 * SIMPLE)
    new, _, regime = soil.trial(0.01 * np.array([1.0, 1.0, 1.0, 0.3, 0.0, 0.0]))
    assert regime == REGIME_APEX
    assert np.abs(new.stress).max() < 1e-3 * SAND_PRESSURE
    soil.stress, soil.history = new.stress, new.history
    soil.go(-0.001 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    assert -soil.stress[0] == pytest.approx(0.003 * soil.p[overlay.BULK], rel=0.01)


@pytest.mark.parametrize("p", [CLAY, sand()], ids=["clay", "sand"])
def test_an_initial_shear_is_in_equilibrium_and_stiff_in_all_directions(p):
    at_rest = START * np.array([0.9, 0.9, 1.1, 1.0, 1.0, 1.0])
    new, _, regime = Soil(p, at_rest).trial(np.zeros(6))
    assert regime == REGIME_ELASTIC
    np.testing.assert_allclose(new.stress, at_rest, rtol=1e-14)
    for sign in (-1.0, 1.0):
        new, _, regime = Soil(p, at_rest).trial(sign * 1e-7 * np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]))
        assert regime == REGIME_ELASTIC
    soil = Soil(p, at_rest)
    soil.go(5e-3 * SIMPLE, 5)
    soil.go(-5e-3 * SIMPLE, 5)
    assert second(soil.stress) <= p[overlay.STRENGTH] - p[overlay.SLOPE] * soil.stress[:3].sum() + 1e-6


# --- tangents ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [CLAY, sand(), sand(cohesion=2e3)], ids=["clay", "sand", "cohesive"])
@pytest.mark.parametrize("turned", [False, True])
def test_tangent_is_the_derivative(p, turned):
    """At first loading, and after a reversal, where some elements yield and others do not."""
    soil = Soil(p)
    if turned:
        soil.go(8e-3 * GENERAL, 3)
    strain = (-3e-3 if turned else 4e-3) * GENERAL
    _, tangent, regime = soil.trial(strain)
    assert regime == REGIME_CONE

    def stress(e):
        return soil.trial(e)[0].stress

    assert taylor_slope(stress, tangent, strain, 1e-4 * OTHER, SIZES) == pytest.approx(2.0, abs=0.1)


def test_tangents_of_clay_are_symmetric_and_not_negative():
    soil = Soil(CLAY)
    rng = np.random.default_rng(3)
    for _ in range(50):
        strain = 3.0 * YIELD * rng.standard_normal(6)
        tangent = soil.trial(strain)[1]
        np.testing.assert_allclose(tangent, tangent.T, atol=1e-9 * SHEAR)
        assert np.linalg.eigvalsh(tangent).min() > -1e-9 * SHEAR
        soil.go(strain)


# --- sweep ------------------------------------------------------------------------------------------------


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(
    phi=st.tuples(st.floats(0.0, 0.8), st.sampled_from([0.0, 1e-6, 0.5, 1.0])),
    cohesion=st.sampled_from([0.0, 1.0, 1e3, 1e6]),
    b_phi=st.sampled_from([1e-6, 1e-3, 1.0]),
    pressure=st.sampled_from([1.0, 1e4, 1e6]),
    strains=st.lists(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), min_size=3, max_size=3),
    size=st.floats(-8.0, -1.0),
)
def test_no_parameters_and_no_strain_break_the_law(phi, cohesion, b_phi, pressure, strains, size):
    last, share = max(phi[0], 1e-3), phi[1]
    p = sand(pressure, phi_i=share * last, phi_f=last, cohesion=cohesion, b_phi=b_phi)
    assert np.all(np.isfinite(p)) and np.all(p[overlay.FIRST :] >= -1e-12)
    soil = Soil(p)
    for strain in strains:
        new, tangent, _ = soil.trial(10.0**size * np.array(strain))
        assert np.all(np.isfinite(new.stress)) and np.all(np.isfinite(tangent))
        limit = p[overlay.STRENGTH] - p[overlay.SLOPE] * new.stress[:3].sum()
        rounding = 1e-12 * (np.abs(new.stress).max() + SAND["young"] * 10.0**size) + 2e-5 * SAND["young"] * 10.0**size
        assert second(new.stress) <= max(limit, 0.0) + rounding
        assert new.history[overlay.KAPPA] >= soil.history[overlay.KAPPA]
        soil.stress, soil.history = new.stress, new.history
