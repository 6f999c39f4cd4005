# SPDX-License-Identifier: MIT
"""Duvaut & Lions' viscoplasticity: closed forms in simple shear, and its tangent over every law and regime."""

import numpy as np
import pytest

from fe_engine.conventions import REGIME_APEX, REGIME_CONE, REGIME_STIFFNESS
from fe_engine.soil import following, plasol, sand, tresca, van_eekelen, von_mises
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.law import Point
from fe_engine.soil.viscous import relax_point, share_of
from tests.support.models import soil, taylor_slope
from tests.support.soil_points import OPENING, OTHER, POISSON, PUSH, SIZES, START, YOUNG, make, stepped

STRENGTH = 5.0e4  # Pa
CLAY = von_mises.LAW.pack(YOUNG, POISSON, STRENGTH)
BULK, SHEAR = (float(each) for each in von_mises.LAW.moduli(CLAY))
MODULI, ELASTIC = np.array([BULK, SHEAR]), elastic_matrix(YOUNG, POISSON)
SAND = soil(sand.LAW, kappa_0=1.0e-4).parameters
FOLLOWS = following.pack(van_eekelen.LAW, make(psi=5.0), 1.0e5, 0.5, 2.0e-4, 0.2)
SAND_FOLLOWS = following.pack(sand.LAW, SAND, 1.0e5, 0.5, 2.0e-4, 0.2)
LAG = 2.0  # s
RATE = 1.0e-4  # 1/s, of the engineering shear strain: an overstress of 0.3 of the strength


def step(law, p, strain, share, old):
    """One viscous update: the new state, the law's tangent, and the regime."""
    new, tangent, regime = stepped(law.update, p, strain, old)
    (law.relax or relax_point)(p, MODULI, share, strain, old, new, tangent, True)
    return new, tangent, regime


def sheared(time, dt, rate=RATE, old=None):
    """Shear stresses at the ends of the steps of a test in simple shear, and the last state."""
    old, found = old or Point(np.zeros(6), np.zeros(1)), []
    for _ in range(round(time / dt)):
        old, _, _ = step(von_mises.LAW, CLAY, rate * dt * np.eye(6)[3], share_of(dt, LAG), old)
        found.append(old.stress[3])
    return np.array(found), old


def test_the_share_is_that_of_backward_euler():
    assert share_of(1.0, 3.0) == 0.25
    assert share_of(1.0e-9, 0.0) == 1.0


def test_overstress_in_simple_shear_grows_to_the_viscosity_times_the_rate():
    """tau = su + G rate T (1 - exp(-(t - t_y)/T)) after first yield at t_y (Simo & Hughes 1998); first order in dt."""
    first = STRENGTH / (SHEAR * RATE)
    end = first + 1.5 * LAG
    exact = STRENGTH + SHEAR * RATE * LAG * (1.0 - np.exp(-1.5))
    errors = [abs(sheared(end, end / n)[0][-1] - exact) for n in (400, 800, 1600)]
    assert errors[0] < 3.0e-3 * (exact - STRENGTH)
    np.testing.assert_allclose([errors[0] / errors[1], errors[1] / errors[2]], 2.0, rtol=0.05)
    steady, _ = sheared(first + 30.0 * LAG, LAG / 4.0)
    assert steady[-1] == pytest.approx(STRENGTH + SHEAR * RATE * LAG, rel=1.0e-9)


def test_overstress_relaxes_where_strain_is_held():
    """By the factor 1/(1 + dt/T) a step, while the plastic strain takes what the stress leaves."""
    before, state = sheared(4.0 * STRENGTH / (SHEAR * RATE), LAG / 8.0)
    held, end = sheared(LAG, LAG / 8.0, 0.0, state)
    over = np.concatenate([before[-1:], held]) - STRENGTH
    np.testing.assert_allclose(over[1:] / over[:-1], 1.0 / 1.125, rtol=1.0e-9)
    plastic = np.sqrt(3.0) * (end.history[0] - state.history[0])
    assert plastic == pytest.approx((before[-1] - held[-1]) / SHEAR, rel=1.0e-9)


@pytest.mark.parametrize("share", [1.0, 0.3, 1.0e-6])
@pytest.mark.parametrize(
    ("law", "p", "strain", "regime"),
    [
        (plasol.LAW, make(psi=5.0), PUSH, REGIME_CONE),
        (plasol.LAW, make(psi=5.0, cohesion=1.0e4), 2.0 * OPENING, REGIME_APEX),
        (van_eekelen.LAW, make(psi=5.0), PUSH, REGIME_CONE),
        (von_mises.LAW, CLAY, PUSH, REGIME_CONE),
        (tresca.LAW, CLAY, PUSH, REGIME_CONE),
        (sand.LAW, SAND, PUSH, REGIME_CONE),
        (following.LAW, FOLLOWS, PUSH, REGIME_CONE),
        (following.LAW, FOLLOWS, 1.0e-2 * PUSH, REGIME_STIFFNESS),
        (following.LAW, SAND_FOLLOWS, PUSH, REGIME_CONE),
    ],
)
def test_the_tangent_is_consistent_and_nearly_elastic_in_a_short_step(share, law, p, strain, regime):
    """C + s (C* - C), which the loops assemble; share 1 is the law itself."""
    old = Point(START, np.zeros(len(law.history)))
    new, own, found = step(law, p, strain, share, old)
    assert found == regime
    tangent = ELASTIC + share * (own - ELASTIC)
    if share > 1.0e-3:  # below it the remainder is rounding
        order = taylor_slope(lambda e: step(law, p, e, share, old)[0].stress, tangent, strain, OTHER, SIZES)
        assert order > 1.9
    if share == 1.0:
        exact, history = np.empty(6), np.empty(len(law.history))
        law.update(p, strain, old, Point(exact, history), np.empty((6, 6)), False)
        np.testing.assert_allclose(new.stress, exact, rtol=1.0e-14)
        np.testing.assert_array_equal(new.history, history)
    if share == 1.0e-6 and law.relax is None:
        np.testing.assert_allclose(new.stress, START + ELASTIC @ strain, rtol=1.0e-5)
        np.testing.assert_allclose(tangent, ELASTIC, atol=2.0e-6 * ELASTIC.max())
