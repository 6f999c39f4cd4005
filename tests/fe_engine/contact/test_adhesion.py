# SPDX-License-Identifier: MIT
"""Contact with adhesion, friction and a limited tension at one station, and a footing on it."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fe_engine.contact import adhesion, coulomb
from fe_engine.contact.law import Slide
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP, CONTACT_STICK
from fe_engine.soil import elastic
from tests.support.models import footing, replace, run, soil, stage, taylor_slope

KN, KT, ADHESION, PRESSURE = 1.0e10, 4.0e9, 1.5e4, 4.0e4
SLIP_AT, OPEN_AT = ADHESION / KT, PRESSURE / KN
REST = np.array([-PRESSURE, 0.0, 0.0])
VENTED, BONDED, SEALED = 0.0, np.inf, 1.2e5
LAWS = {
    "vented": adhesion.pack(KN, KT, 0.0, ADHESION, VENTED),
    "bonded": adhesion.pack(KN, KT, 0.0, ADHESION, BONDED),
    "sealed": adhesion.pack(KN, KT, 0.0, ADHESION, SEALED),
    "c-phi": adhesion.pack(KN, KT, 0.4, ADHESION, VENTED),
    "c-phi, bonded": adhesion.pack(KN, KT, 0.4, ADHESION, BONDED),
}


def update(p, jump, jump_old=(0.0, 0.0, 0.0), traction_old=REST):
    traction = np.full(3, np.nan)
    slide = Slide(np.array(jump), np.array(jump_old), np.array(traction_old), PRESSURE)
    return traction, adhesion.update(p, slide, traction)


def linearise(p, jump, guess, traction_old=REST):
    traction, tangent = np.full(3, np.nan), np.full((3, 3), np.nan)
    slide = Slide(np.array(jump), np.zeros(3), np.array(traction_old), PRESSURE)
    return traction, tangent, adhesion.linearise(p, slide, np.array(guess), traction, tangent)


def slipped(normal, distance=50.0):
    return np.array([normal, 0.6 * distance * SLIP_AT, -0.8 * distance * SLIP_AT])


# --- the law ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("normal", [-3.0e-6, 0.0, 0.5 * OPEN_AT])
def test_the_shear_of_clay_does_not_depend_on_the_pressure(normal):
    for name in ("vented", "bonded", "sealed"):
        traction, state = update(LAWS[name], slipped(normal))
        assert state == CONTACT_SLIP
        np.testing.assert_allclose(traction, [KN * normal - PRESSURE, 0.6 * ADHESION, -0.8 * ADHESION], rtol=1e-12)


def test_friction_adds_to_adhesion():
    traction, _ = update(LAWS["c-phi"], slipped(-1.0e-6))
    assert np.hypot(*traction[1:]) == pytest.approx(ADHESION + 0.4 * (PRESSURE + 1.0e4), rel=1e-12)


def test_sticks_below_the_adhesion():
    traction, state = update(LAWS["vented"], [0.0, 0.999 * SLIP_AT, 0.0])
    assert (state, traction[1]) == (CONTACT_STICK, pytest.approx(0.999 * ADHESION, rel=1e-12))


@pytest.mark.parametrize("share", [0.5, 0.1, 1.0e-6])
def test_the_adhesion_of_a_vented_contact_falls_with_the_pressure_before_it_opens(share):
    pressure = share * ADHESION
    traction, state = update(LAWS["vented"], slipped((PRESSURE - pressure) / KN))
    assert state == CONTACT_SLIP
    assert np.hypot(*traction[1:]) == pytest.approx(pressure, rel=1e-5)


@pytest.mark.parametrize("beyond", [1.0, 1.5, 1.0e3])
def test_a_vented_contact_opens_where_the_total_stress_is_that_of_the_water(beyond):
    traction, state = update(LAWS["vented"], slipped(beyond * OPEN_AT))
    np.testing.assert_array_equal(traction, 0.0)
    assert state == CONTACT_OPEN


def test_a_bonded_contact_carries_any_tension():
    traction, state = update(LAWS["bonded"], slipped(1.0e-2))
    assert (state, traction[0]) == (CONTACT_SLIP, pytest.approx(1.0e8 - PRESSURE))
    assert np.hypot(*traction[1:]) == pytest.approx(ADHESION)


def test_a_sealed_contact_keeps_its_suction_when_water_cavitates():
    limit = (PRESSURE + SEALED) / KN
    before, sucked = update(LAWS["sealed"], slipped(0.5 * limit))
    after, opened = update(LAWS["sealed"], slipped(30.0 * limit))
    assert (sucked, opened) == (CONTACT_SLIP, CONTACT_OPEN)
    assert before[0] == pytest.approx(0.5 * SEALED - 0.5 * PRESSURE)
    np.testing.assert_array_equal(after, [SEALED, 0.0, 0.0])


def test_gap_begins_where_the_tension_is_reached():
    p = np.array([LAWS[name] for name in ("vented", "bonded", "sealed")])
    jump = (PRESSURE + SEALED) / KN + 1.0e-5
    found = adhesion.gap(p, np.full(3, PRESSURE), np.full(3, jump))
    np.testing.assert_allclose(found, [1.0e-5 + SEALED / KN, 0.0, 1.0e-5], rtol=1e-9)


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(st.floats(-3.0, 3.0), st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), st.sampled_from([0.0, 0.5]))
def test_without_adhesion_and_tension_it_is_coulombs_law(normal, first, second, mu):
    jump = np.array([normal * OPEN_AT, first * SLIP_AT, second * SLIP_AT])
    old = np.array([-PRESSURE, 0.2 * mu * PRESSURE, 0.1 * mu * PRESSURE])
    slide, ours, theirs = Slide(jump, np.zeros(3), old, PRESSURE), np.zeros(3), np.zeros(3)
    p = adhesion.pack(KN, KT, mu, 0.0, 0.0)
    assert adhesion.update(p, slide, ours) == coulomb.update(p[:3], slide, theirs)
    np.testing.assert_array_equal(ours, theirs)
    tangents = np.zeros((2, 3, 3))
    states = (
        law.linearise(q, slide, theirs, ours, t)
        for law, q, t in zip((adhesion, coulomb), (p, p[:3]), tangents, strict=True)
    )
    assert len(set(states)) == 1
    np.testing.assert_array_equal(*tangents)


# --- tangent ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("normal", [-1.0e-6, 0.4 * OPEN_AT, 0.9 * OPEN_AT])
@pytest.mark.parametrize("p", LAWS.values(), ids=LAWS)
def test_tangent_in_slip_is_consistent(p, normal):
    """At 0.9 of the opening the adhesion of a vented contact falls with the pressure."""
    jump = slipped(normal, 6.0)
    own, state = update(p, jump)
    traction, tangent, assumed = linearise(p, jump, own)
    assert state == assumed == CONTACT_SLIP
    np.testing.assert_allclose(traction, own, rtol=1e-12)
    step = SLIP_AT * np.array([0.1, 0.8, 0.5])
    order = taylor_slope(lambda w: update(p, w)[0], tangent, jump, step, np.geomspace(3e-2, 1e-3, 5))
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("p", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("guess", [(0.0, 0.0), (3.0, -7.0), (-20.0, 1.0)])
def test_fixed_point_of_the_linearisation_is_the_law(p, guess):
    for normal in (-1.0e-6, 0.5 * OPEN_AT, 0.9 * OPEN_AT, 1.1 * OPEN_AT):
        jump = slipped(normal, 4.0)
        wanted, _ = update(p, jump)
        traction = np.array([0.0, *(ADHESION * np.array(guess))])
        for _ in range(30):
            traction, _, _ = linearise(p, jump, traction)
        np.testing.assert_allclose(traction, wanted, atol=1e-9 * ADHESION)


def test_smooth_is_without_friction_and_adhesion():
    assert not any(adhesion.smooth(np.array(list(LAWS.values()))))
    assert adhesion.smooth(adhesion.pack(KN, KT, 0.0, 0.0, VENTED))


# --- a footing --------------------------------------------------------------------------------------------

AREA, LOAD = 0.5, 2.0e4 * 0.5


def clay_footing(mu, tension):
    model = footing(soil(elastic.LAW))
    packed = adhesion.pack(KN, 1.0e10, mu, ADHESION, tension)[None]
    return replace(model, contact=packed, contact_laws=(adhesion.LAW,))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("tension", [BONDED, SEALED])
def test_a_footing_slides_at_its_adhesion_and_friction(mu, tension):
    """Its moment spreads the pressure unevenly, which changes nothing of the sum while nothing opens or is pulled."""
    out = run(
        clay_footing(mu, tension), stage({0: 1.0e-2, 2: 0.0}, first_fraction=0.01, max_fraction=0.5), tolerance=1e-10
    )
    assert out.steps[-1].multipliers[0] == pytest.approx(ADHESION * AREA + mu * LOAD, rel=1e-6)


@pytest.mark.parametrize("tension", [VENTED, 3.0e4])
def test_a_footing_is_lifted_by_its_load_and_its_suction(tension):
    lift = stage({0: 0.0, 1: -1.0e-2, 2: 0.0}, first_fraction=0.02, max_fraction=0.5)
    out = run(clay_footing(0.0, tension), lift, tolerance=1e-10)
    assert out.steps[-1].multipliers[1] == pytest.approx(-LOAD - tension * AREA, rel=1e-6)
