# SPDX-License-Identifier: MIT
"""Stiffness that follows the stress and degrades: closed forms in compression and shear, tangents, energy of loops."""

import numpy as np
import pytest

from fe_engine.conventions import REGIME_APEX, REGIME_CONE, REGIME_STIFFNESS
from fe_engine.soil import following, plasol, van_eekelen
from fe_engine.soil.law import Point
from tests.support.models import DEGREE, taylor_slope
from tests.support.soil_points import OPENING, OTHER, POISSON, PRESSURE, PUSH, SIZES, START, YOUNG, stepped

BULK, SHEAR = YOUNG / (3.0 * (1.0 - 2.0 * POISSON)), YOUNG / (2.0 * (1.0 + POISSON))
STRAIN = 2.0e-4
SURFACES = {"cone": plasol.LAW, "van-eekelen": van_eekelen.LAW}
ISOTROPIC, SIMPLE = -np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) / 3.0, np.eye(6)[3]


def make(exponent=0.5, strain=None, cohesion=1e9, phi=30.0, surface="cone", least=0.2, psi=0.0):
    """Packed parameters; with the default cohesion nothing yields."""
    rows = SURFACES[surface].pack(YOUNG, POISSON, 5.0 * DEGREE, phi * DEGREE, 0.005, psi * DEGREE, cohesion)
    return following.pack(SURFACES[surface], rows, PRESSURE, exponent, strain, least)


def start(stress=START):
    return Point(stress.copy(), np.zeros(len(following.HISTORY)))


def step(p, strain, old):
    return stepped(following.update, p, strain, old)


def follow(p, strains, old=None):
    """States along increments of strain, the first included."""
    states = [old or start()]
    for strain in strains:
        states.append(step(p, strain, states[-1])[0])
    return states


def work(states, strains):
    """Work along increments, J/m3, with the mean stress of each."""
    pairs = zip(states[:-1], states[1:], strains, strict=True)
    return sum(float(0.5 * (a.stress + b.stress) @ e) for a, b, e in pairs)


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("exponent", [0.3, 0.5, 0.9])
@pytest.mark.parametrize("total", [5e-4, -1e-4])
def test_isotropic_compression_is_the_closed_form(steps, exponent, total):
    """dp = K_0 (p/p_0)^n de: p^(1 - n) grows in proportion to the strain, whatever the steps."""
    end = follow(make(exponent), [total / steps * ISOTROPIC] * steps)[-1]
    wanted = PRESSURE * (1.0 + (1.0 - exponent) * BULK / PRESSURE * total) ** (1.0 / (1.0 - exponent))
    assert -end.stress[:3] == pytest.approx([wanted] * 3, rel=1e-10)
    assert end.stress[3:] == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("steps", [1, 50])
@pytest.mark.parametrize("gamma", [0.5 * STRAIN, STRAIN, 3.0 * STRAIN])
def test_simple_shear_degrades_along_the_closed_form(steps, gamma):
    end = follow(make(0.0, STRAIN, least=1e-3), [gamma / steps * SIMPLE] * steps)[-1]
    assert end.stress[3] == pytest.approx(SHEAR * gamma / (1.0 + 0.385 * gamma / STRAIN), rel=1e-10)


def test_shear_stiffness_at_another_pressure_is_that_of_hardin():
    (_, end) = follow(make(0.5), [1e-9 * SIMPLE], start(4.0 * START))
    assert end.stress[3] == pytest.approx(2.0 * SHEAR * 1e-9, rel=1e-12)


def test_stiffness_does_not_fall_below_its_least_share():
    p = make(0.0, STRAIN, least=0.25)
    a, b = (follow(p, [gamma * SIMPLE] * 1)[-1] for gamma in (100 * STRAIN, 0.0))
    end = step(p, STRAIN * SIMPLE, a)[0]
    assert (end.stress[3] - a.stress[3]) / STRAIN == pytest.approx(0.25 * SHEAR, rel=1e-12)
    assert b.stress[3] == 0.0


def test_a_reversal_restores_the_stiffness():
    """In the increment after the one that turns."""
    states = follow(make(0.0, STRAIN), [STRAIN * SIMPLE, -1e-9 * SIMPLE, -1e-9 * SIMPLE])
    assert (states[1].stress[3] - states[2].stress[3]) / 1e-9 == pytest.approx(SHEAR / 1.385**2, rel=1e-5)
    assert (states[2].stress[3] - states[3].stress[3]) / 1e-9 == pytest.approx(SHEAR, rel=1e-4)
    turned = follow(make(0.0, STRAIN), [STRAIN * SIMPLE, 1e-9 * np.eye(6)[4]])[-1]  # across: no reversal
    assert turned.stress[4] / 1e-9 == pytest.approx(SHEAR / 1.385**2, rel=1e-5)


def test_loops_without_degradation_close_in_compression_and_in_shear():
    for direction in (1e-4 * ISOTROPIC, 1e-4 * SIMPLE):
        path = [direction] * 5 + [-direction] * 5
        states = follow(make(0.5), path)
        assert states[-1].stress == pytest.approx(START, rel=1e-10, abs=1e-6)
        assert abs(work(states, path)) < 1e-8 * abs(work(states[:6], path[:5]))


def test_a_loop_of_compression_and_shear_does_not_close():
    """Hypoelasticity (Zytynski et al. 1978): a rectangle of volume and shear gives or takes (G_1 - G_0) gamma^2/2."""
    squeeze, shear = 5e-5 * ISOTROPIC, 1e-4 * SIMPLE
    path = [squeeze] * 10 + [shear] * 10 + [-squeeze] * 10 + [-shear] * 10
    stiffer = 1.0 + 0.5 * BULK / PRESSURE * 5e-4  # sqrt(p_1/p_0)
    wanted = 0.5 * (stiffer - 1.0) * SHEAR * 1e-3**2
    for turn, order in ((-1.0, path), (1.0, [-each for each in path[::-1]])):
        assert work(follow(make(0.5), order), order) == pytest.approx(turn * wanted, rel=1e-6)


def test_a_loop_of_degradation_dissipates_what_the_curves_enclose():
    """Up along T(g), down along T(g) - T(g - g'): 2 int T - g T, T = G g/(1 + a g)."""
    n, gamma, a = 400, 2.0 * STRAIN, 0.385 / STRAIN
    path = [gamma / n * SIMPLE] * n + [-gamma / n * SIMPLE] * n
    states = follow(make(0.0, STRAIN, least=1e-3), path)
    integral = SHEAR * (gamma / a - np.log1p(a * gamma) / a**2)
    wanted = 2.0 * integral - gamma * SHEAR * gamma / (1.0 + a * gamma)
    assert work(states, path) == pytest.approx(wanted, rel=0.02)
    assert abs(states[-1].stress[3]) < 0.01 * SHEAR * gamma


APEX = 10.0 * OPENING  # far enough for the apex to move with the plastic strain
CASES = {"inside": (1e9, PUSH, REGIME_STIFFNESS), "cone": (0.0, PUSH, REGIME_CONE), "apex": (1e3, APEX, REGIME_APEX)}


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("exponent", "strain", "psi"), [(0.5, None, 0.0), (0.0, 1e-3, 20.0), (0.5, 1e-3, 10.0)])
def test_tangent_is_the_derivative_in_every_regime(surface, case, exponent, strain, psi):
    cohesion, push, regime = CASES[case]
    p = make(exponent, strain, cohesion, surface=surface, least=0.05, psi=psi)
    old = step(p, 0.3 * push, start())[0] if case == "inside" else start()
    assert step(p, push, old)[2] == regime
    tangent = step(p, push, old)[1]
    assert taylor_slope(lambda e: step(p, e, old)[0].stress, tangent, push, OTHER, SIZES) > 1.85


@pytest.mark.parametrize("surface", SURFACES)
def test_without_exponent_and_degradation_it_is_the_surface(surface):
    law = SURFACES[surface]
    p = make(0.0, None, 1e3, surface=surface)
    new, tangent, _ = stepped(law.update, p[: len(law.parameters)], PUSH, Point(START, np.zeros(1)))
    ours, slope, _ = step(p, PUSH, start())
    assert np.array_equal(ours.stress, new.stress)
    assert ours.history[0] == new.history[0]
    np.testing.assert_allclose(slope, tangent, rtol=1e-12, atol=1e-3)


def test_stiffness_is_held_at_low_and_high_pressure():
    p = make(0.5)
    for r, factor in ((0.001, 0.1), (-0.5, 0.1), (400.0, 10.0)):
        end = follow(p, [1e-12 * SIMPLE], start(r * START))[-1]
        assert end.stress[3] == pytest.approx(factor * SHEAR * 1e-12, rel=1e-9)
    far = follow(p, [ISOTROPIC * 1.0])[-1].stress
    assert np.all(np.isfinite(far))
    assert far[0] < -100.0 * PRESSURE
