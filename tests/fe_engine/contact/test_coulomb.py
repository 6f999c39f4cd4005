# SPDX-License-Identifier: MIT
"""Penalty contact with friction at one station."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fe_engine.contact import coulomb
from fe_engine.contact.law import Slide
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP, CONTACT_STICK
from tests.support.models import taylor_slope

KN, KT, MU, PRESSURE = 1.0e10, 4.0e9, 0.5, 2.0e4
P = coulomb.pack(KN, KT, MU)
LIMIT = MU * PRESSURE
SLIP_AT = LIMIT / KT
OPEN_AT = PRESSURE / KN
REST = np.array([-PRESSURE, 0.0, 0.0])
DIRECTIONS = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.6, -0.8), (-0.28, 0.96)]


def slide_of(jump, jump_old, traction_old, pressure):
    return Slide(np.array(jump), np.array(jump_old), np.array(traction_old), pressure)


def update(jump, jump_old=(0.0, 0.0, 0.0), traction_old=REST, p=P, pressure=PRESSURE):
    traction = np.full(3, np.nan)
    state = coulomb.update(p, slide_of(jump, jump_old, traction_old, pressure), traction)
    return traction, state


def linearise(jump, guess, jump_old=(0.0, 0.0, 0.0), traction_old=REST, p=P, pressure=PRESSURE):
    traction, tangent = np.full(3, np.nan), np.full((3, 3), np.nan)
    state = coulomb.linearise(p, slide_of(jump, jump_old, traction_old, pressure), np.array(guess), traction, tangent)
    return traction, tangent, state


def slide(distance, direction, normal=0.0):
    """Jump (3,) with a tangential part."""
    return np.array([normal, distance * direction[0], distance * direction[1]])


# --- the law ----------------------------------------------------------------------------------------------


def test_initial_state_is_the_initial_pressure():
    traction, state = update([0.0, 0.0, 0.0])
    np.testing.assert_array_equal(traction, REST)
    assert state == CONTACT_STICK


def test_penetration_is_pressure_over_stiffness():
    traction, _ = update([-3.0e-6, 0.0, 0.0])
    assert -traction[0] == pytest.approx(PRESSURE + 3.0e-6 * KN, rel=1e-14)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_sticks_below_and_slips_at_the_limit_along_the_slip(direction):
    below, stuck = update(slide(0.999 * SLIP_AT, direction))
    beyond, slipped = update(slide(7.0 * SLIP_AT, direction))
    assert (stuck, slipped) == (CONTACT_STICK, CONTACT_SLIP)
    np.testing.assert_allclose(below[1:], 0.999 * LIMIT * np.array(direction), rtol=1e-13)
    np.testing.assert_allclose(beyond[1:], LIMIT * np.array(direction), rtol=1e-13)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_reversal_slips_after_twice_the_slip_distance(direction):
    forward = slide(5.0 * SLIP_AT, direction)
    slipped, _ = update(forward)
    before, stuck = update(forward - slide(1.999 * SLIP_AT, direction), forward, slipped)
    after, state = update(forward - slide(2.001 * SLIP_AT, direction), forward, slipped)
    assert (stuck, state) == (CONTACT_STICK, CONTACT_SLIP)
    np.testing.assert_allclose(before[1:], -0.999 * LIMIT * np.array(direction), rtol=1e-10)
    np.testing.assert_allclose(after[1:], -LIMIT * np.array(direction), rtol=1e-10)


def test_slip_in_another_direction_turns_towards_it():
    first = slide(5.0 * SLIP_AT, (1.0, 0.0))
    traction, _ = update(first)
    jump_old = first
    for step in range(1, 200):
        jump = first + slide(0.1 * step * SLIP_AT, (0.0, 1.0))
        traction, _ = update(jump, jump_old, traction)
        jump_old = jump
        assert np.hypot(*traction[1:]) == pytest.approx(LIMIT, rel=1e-12)
    np.testing.assert_allclose(traction[1:], [0.0, LIMIT], atol=1e-6 * LIMIT)


def test_limit_follows_the_present_pressure():
    traction, state = update(slide(7.0 * SLIP_AT, (1.0, 0.0), normal=-1.0e-6))
    assert state == CONTACT_SLIP
    assert traction[1] == pytest.approx(MU * (PRESSURE + 1.0e-6 * KN), rel=1e-13)


@pytest.mark.parametrize("normal", [OPEN_AT, 1.5 * OPEN_AT, 1.0e-2])
def test_open_carries_nothing(normal):
    traction, state = update(slide(0.5 * SLIP_AT, (1.0, 0.0), normal))
    np.testing.assert_array_equal(traction, 0.0)
    assert state == CONTACT_OPEN


def test_contact_again_without_remembered_shear():
    slipped, _ = update(slide(5.0 * SLIP_AT, (1.0, 0.0)))
    opened_at = slide(9.0 * SLIP_AT, (1.0, 0.0), 2.0 * OPEN_AT)
    opened, _ = update(opened_at, slide(5.0 * SLIP_AT, (1.0, 0.0)), slipped)
    closed, state = update(slide(9.0 * SLIP_AT, (1.0, 0.0), 0.0), opened_at, opened)
    np.testing.assert_array_equal(closed, REST)
    assert state == CONTACT_STICK


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_without_friction_nothing_is_sheared(direction):
    traction, state = update(slide(1.0e-3, direction), p=coulomb.pack(KN, KT, 0.0))
    np.testing.assert_array_equal(np.abs(traction), [PRESSURE, 0.0, 0.0])
    assert state == CONTACT_SLIP


def test_law_without_initial_pressure_opens_at_zero():
    assert update([1.0e-12, 0.0, 0.0], traction_old=np.zeros(3), pressure=0.0)[1] == CONTACT_OPEN
    traction, state = update([-1.0e-6, 0.0, 0.0], traction_old=np.zeros(3), pressure=0.0)
    assert (traction[0], state) == (pytest.approx(-1.0e-6 * KN), CONTACT_STICK)


def test_gap_counts_from_the_stress_free_state():
    p = np.tile(P, (3, 1))
    opening = coulomb.gap(p, np.array([PRESSURE, PRESSURE, 0.0]), np.array([OPEN_AT + 1.0e-5, 0.5 * OPEN_AT, 3.0e-5]))
    np.testing.assert_allclose(opening, [1.0e-5, 0.0, 3.0e-5], atol=1e-20)


# --- tangent ----------------------------------------------------------------------------------------------

STATES = {
    "stick": (slide(0.3 * SLIP_AT, (0.6, -0.8), -1.0e-7), CONTACT_STICK),
    "slip": (slide(4.0 * SLIP_AT, (0.6, -0.8), -1.0e-7), CONTACT_SLIP),
    "barely slipping": (slide(1.2 * SLIP_AT, (-0.28, 0.96), 1.0e-7), CONTACT_SLIP),
    "open": (slide(4.0 * SLIP_AT, (0.6, -0.8), 3.0 * OPEN_AT), CONTACT_OPEN),
}


@pytest.mark.parametrize(("jump", "expected"), STATES.values(), ids=STATES)
def test_tangent_at_the_laws_own_traction_is_consistent(jump, expected):
    """Order 2 in slip; stick and open are linear, so there the remainder is rounding (order infinite)."""
    own, _ = update(jump)
    traction, tangent, state = linearise(jump, own)
    assert state == expected
    np.testing.assert_allclose(traction, own, rtol=1e-12)
    step = SLIP_AT * np.array([0.3, 0.8, 0.5])
    order = taylor_slope(lambda w: update(w)[0], tangent, jump, step, np.geomspace(3e-2, 1e-3, 5))
    assert order == (pytest.approx(2.0, abs=0.1) if state == CONTACT_SLIP else np.inf)


def test_tangent_with_committed_shear():
    forward = slide(5.0 * SLIP_AT, (1.0, 0.0))
    slipped, _ = update(forward)
    jump = forward + slide(2.0 * SLIP_AT, (-0.6, 0.8), -2.0e-7)
    own, _ = update(jump, forward, slipped)
    _, tangent, state = linearise(jump, own, forward, slipped)
    assert state == CONTACT_SLIP
    step = SLIP_AT * np.array([0.3, 0.8, 0.5])
    sizes = np.geomspace(3e-2, 1e-3, 5)
    order = taylor_slope(lambda w: update(w, forward, slipped)[0], tangent, jump, step, sizes)
    assert order == pytest.approx(2.0, abs=0.1)


def test_slip_couples_shear_to_the_normal_jump_and_not_the_reverse():
    own, _ = update(STATES["slip"][0])
    _, tangent, _ = linearise(STATES["slip"][0], own)
    np.testing.assert_allclose(tangent[:, 0], KN * np.array([1.0, -MU * 0.6, MU * 0.8]), rtol=1e-12)
    np.testing.assert_array_equal(tangent[0, 1:], 0.0)
    np.testing.assert_allclose(tangent[1:, 1:] @ [0.6, -0.8], 0.0, atol=1e-6)


def test_without_friction_there_is_no_shear_stiffness():
    p = coulomb.pack(KN, KT, 0.0)
    for jump in ([0.0, 0.0, 0.0], [-1.0e-6, 1.0e-6, 0.0]):
        _, tangent, _ = linearise(jump, update(jump, p=p)[0], p=p)
        np.testing.assert_array_equal(tangent, np.diag([KN, 0.0, 0.0]))


# --- the linearisation about another traction --------------------------------------------------------------

vectors = st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)).map(np.array)


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(
    slip=vectors,
    guess=vectors,
    committed=st.floats(0.0, 1.0),
    angle=st.floats(0.0, 6.3),
    mu=st.sampled_from([0.0, 0.5]),
)
def test_fixed_point_of_the_linearisation_is_the_law(slip, guess, committed, angle, mu):
    """From any guess, guess -> traction at a fixed jump ends at the law's traction, and stays there."""
    p = coulomb.pack(KN, KT, mu)
    shear = committed * mu * PRESSURE * np.array([np.cos(angle), np.sin(angle)])
    old = np.array([-PRESSURE, *shear])
    jump = np.array([-2.0e-7, *(SLIP_AT * slip)])
    wanted, state = update(jump, traction_old=old, p=p)
    traction = np.array([0.0, *(LIMIT * guess)])
    for _ in range(30):
        traction, _, assumed = linearise(jump, traction, traction_old=old, p=p)
    np.testing.assert_allclose(traction, wanted, atol=1e-9 * LIMIT)
    assert assumed == state or np.hypot(*traction[1:]) == pytest.approx(mu * -traction[0], rel=1e-9)


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(slip=vectors, guess=vectors, normal=st.floats(-3.0, 3.0))
def test_linearisation_never_leaves_the_numbers(slip, guess, normal):
    jump = np.array([normal * OPEN_AT, *(SLIP_AT * slip)])
    traction, tangent, _ = linearise(jump, np.array([0.0, *(LIMIT * guess)]))
    assert np.all(np.isfinite(traction))
    assert np.all(np.isfinite(tangent))
