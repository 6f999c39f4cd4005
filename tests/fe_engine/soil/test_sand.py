# SPDX-License-Identifier: MIT
"""Sand by relative density at one point: Bolton's peak, the critical state, tangents in every regime, energy."""

from functools import partial

import numpy as np
import pytest

from fe_engine.conventions import REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.material import Material
from fe_engine.soil import following, sand
from fe_engine.soil.law import Point
from pysprings.model.element import drive, schedule
from tests.support.models import DEGREE, taylor_slope
from tests.support.soil_points import COMPRESSION, MERIDIANS, OPENING, OTHER, PUSH, SIZES, START, stepped

YOUNG, POISSON, PHI_C, Q = 2.0e8, 0.2, 33.0 * DEGREE, 10.0
NEVER = 1.0e3  # a plastic strain that is not reached
AXIAL, HELD = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), np.array([0, 1])


def pack(density=0.8, exponent=4.0, scale=0.015, fade=0.2, contraction=0.4, kappa_0=0.0):
    return sand.pack(YOUNG, POISSON, PHI_C, density, Q, exponent, scale, fade, contraction, kappa_0)


def update(p, strain, stress=START, kappa=0.0):
    """Stress, plastic strain, tangent and regime after one update."""
    new, tangent, regime = stepped(sand.update, p, strain, Point(stress, np.array([kappa])))
    return new.stress, new.history[0], tangent, regime


def triaxial(p, stress=1.0e5, direction=AXIAL, held=HELD, end=0.3):
    """Axial strain, volumetric strain, p' and q (compression positive) of a test from an isotropic stress."""
    start = -stress * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    strain, found, why = drive(Material(sand.LAW, p), start, direction, held, schedule(end))
    assert why == ""
    return -strain[:, 2], -strain[:, :3].sum(axis=1), -found[:, :3].mean(axis=1), found[:, 0] - found[:, 2]


def sine_of(p, q):
    """Return sin of the mobilised friction angle in compression (q > 0), and in extension."""
    return 3.0 * np.abs(q) / (6.0 * p + q)


@pytest.mark.parametrize(("density", "stress"), [(0.4, 5.0e4), (0.6, 1.0e5), (0.8, 4.0e5)])
def test_the_peak_is_that_of_bolton_in_compression_and_extension(density, stress):
    """phi = phi_c + 3 deg I_R and -deps_v/deps_1 = 0.3 I_R (Bolton 1986), at the p' of the peak, if nothing fades."""
    p = pack(density, fade=NEVER, contraction=0.0)
    axial, volume, mean, q = triaxial(p, stress)
    index = density * (Q - np.log(1e-3 * mean[-1])) - 1.0
    assert np.arcsin(sine_of(mean, q)[-1]) == pytest.approx(PHI_C + 3.0 * DEGREE * index, abs=0.1 * DEGREE)
    assert -np.diff(volume)[-1] / np.diff(axial)[-1] == pytest.approx(0.3 * index, rel=0.02)
    _, _, mean, q = triaxial(p, stress, -AXIAL)
    index = density * (Q - np.log(1e-3 * mean[-1])) - 1.0
    assert np.arcsin(sine_of(mean, q)[-1]) == pytest.approx(PHI_C + 3.0 * DEGREE * index, abs=0.1 * DEGREE)


def test_large_strains_end_at_the_critical_state():
    axial, volume, mean, q = triaxial(pack(fade=0.05), end=0.6)
    assert np.arcsin(sine_of(mean, q)[-1]) == pytest.approx(PHI_C, abs=0.01 * DEGREE)
    assert abs(np.diff(volume)[-1] / np.diff(axial)[-1]) < 1e-3
    assert np.degrees(np.arcsin(sine_of(mean, q).max())) > 37.0  # behind a peak


def test_the_plastic_volume_shrinks_before_it_grows():
    """-C at first yield, where nothing of the strength is mobilised."""
    most = float(sand.formulas.dilatancy_index(0.8, Q, 1.0e5))
    assert sand.mobilised(pack(), most, 0.0)[2] == pytest.approx(-0.4 / (3.0 * np.sqrt(3.0)))
    flows = [sand.mobilised(pack(), most, kappa)[2] for kappa in np.geomspace(1e-5, 0.03, 40)]
    assert flows[0] < 0.0 < flows[-1] and (np.diff(flows) > 0.0).all()
    _, volume, _, _ = triaxial(pack())
    assert volume.max() > 1e-3 and volume[-1] < -0.05


def test_loose_sand_at_constant_volume_loses_effective_stress_and_dense_sand_gains_it():
    undrained, none = np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]), np.array([], dtype=int)
    _, volume, loose, _ = triaxial(pack(0.1, scale=0.06), 2.0e5, undrained, none, 0.05)
    _, _, dense, _ = triaxial(pack(0.9), 2.0e5, undrained, none, 0.05)
    assert np.abs(volume).max() < 1e-15
    assert loose[-1] < 1.8e5 and dense[-1] > 4.0e5 and dense.min() < 2.0e5


def test_the_index_is_that_of_bolton_between_its_bounds():
    assert sand.formulas.dilatancy_index(0.8, Q, 1.0e5) == pytest.approx(0.8 * (10.0 - np.log(100.0)) - 1.0, abs=4e-3)
    assert (
        sand.formulas.dilatancy_index(0.1, Q, 4.0e5) == pytest.approx(0.0, abs=0.02)
        and sand.formulas.dilatancy_index(1.0, Q, 1.0e3) < 4.0
    )


def test_an_initial_state_at_k0_is_on_its_surface():
    """e_0 is the plastic strain that mobilises sin(phi) = (1 - K0)/(1 + K0): more shear yields, less is elastic."""
    k0, stress = 0.5, np.array([-5.0e4, -5.0e4, -1.0e5, 0.0, 0.0, 0.0])
    index = sand.formulas.dilatancy_index(0.8, Q, 2.0e5 / 3.0)
    share = (1.0 - k0) / (1.0 + k0) / np.sin(PHI_C + 3.0 * DEGREE * index)
    kappa = -0.015 * np.log1p(-(share**4.0))
    p = pack(kappa_0=kappa)
    assert update(p, 1e-7 * AXIAL, stress)[3] == REGIME_CONE
    assert update(p, -1e-7 * AXIAL, stress)[3] == REGIME_ELASTIC
    assert update(pack(kappa_0=1.1 * kappa), 1e-7 * AXIAL, stress)[3] == REGIME_ELASTIC


SHEARED = np.array([-0.4e5, -0.7e5, -1.5e5, 0.2e5, -0.1e5, 0.15e5])
STATES = {
    "first yield": (pack(), START, 0.0, PUSH),
    "first yield, small": (pack(), START, 0.0, 0.05 * PUSH),
    "hardening": (pack(kappa_0=2e-3), SHEARED, 0.0, PUSH),
    "dilating at the peak": (pack(), SHEARED, 0.05, PUSH),
    "softening": (pack(fade=0.1), SHEARED, 0.1, PUSH),
    "critical": (pack(fade=0.02), SHEARED, 0.5, PUSH),
    "contracting": (pack(0.1, contraction=0.9), START, 1e-4, 0.3 * PUSH),
    "compression": (pack(), START, 0.01, COMPRESSION),
    "extension": (pack(), START, 0.01, -COMPRESSION),
    "pure shear": (pack(), START, 0.01, MERIDIANS["pure shear"]),
    "near the apex": (pack(), 0.05 * SHEARED, 0.01, 0.1 * PUSH),
    "bound of the index": (pack(1.0), 0.02 * START, 0.01, 0.05 * PUSH),
    "apex": (pack(), START, 0.0, 2.0 * OPENING),
}


@pytest.mark.parametrize("state", STATES)
def test_the_tangent_is_the_derivative_in_every_regime(state):
    p, stress, kappa, strain = STATES[state]
    tangent, regime = update(p, strain, stress, kappa)[2:]
    assert regime == (REGIME_APEX if state == "apex" else REGIME_CONE)
    other, sizes = OTHER * (np.linalg.norm(strain) / np.linalg.norm(OTHER)), SIZES
    assert taylor_slope(lambda e: update(p, e, stress, kappa)[0], tangent, strain, other, sizes) > 1.85 or (
        regime == REGIME_APEX
        and np.allclose(update(p, strain + 0.1 * other, stress, kappa)[0] - update(p, strain, stress, kappa)[0],
                        0.1 * tangent @ other, rtol=1e-9)
    )  # fmt: skip


@pytest.mark.parametrize("state", [name for name in STATES if name != "apex"])
def test_stiffness_that_changes_keeps_the_tangent(state):
    p, stress, kappa, strain = STATES[state]
    rows = following.pack(sand.LAW, p, 1.0e5, 0.5, 1.0e-4, 0.2)
    start = np.zeros(7)
    start[0] = kappa
    answer = partial(stepped, following.update, rows, old=Point(stress, start))
    other = OTHER * (np.linalg.norm(strain) / np.linalg.norm(OTHER))
    assert taylor_slope(lambda e: answer(e).new.stress, answer(strain).tangent, strain, other, SIZES) > 1.8


def test_a_return_is_on_the_surface_and_dissipates(rng=None):
    """After random steps from random states f is 0 within rounding, and plastic work is positive."""
    rng = np.random.default_rng(5)
    p, shear = pack(), YOUNG / (2.0 + 2.0 * POISSON)
    for _ in range(400):
        stress = -rng.uniform(5e3, 4e5) * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        kappa, strain = 10.0 ** rng.uniform(-6, -0.5), 10.0 ** rng.uniform(-5, -2) * rng.standard_normal(6)
        new, after, _, regime = update(p, strain, stress, kappa)
        if regime != REGIME_CONE:
            continue
        first, mean = new[:3].sum(), new[:3].mean()
        deviator = new - mean * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        second = np.sqrt(0.5 * (deviator[:3] ** 2).sum() + (deviator[3:] ** 2).sum())
        sine = sand.mobilised(p, sand.formulas.dilatancy_index(0.8, Q, -stress.sum() / 3.0), after)[0]
        cos3 = sand.lode(new, first, second).cos3
        assert second + sand._surface(sine, cos3)[0] * first == pytest.approx(0.0, abs=1e-8 * (second - first))
        elastic = np.array([*(deviator[:3] / (2.0 * shear)), *(deviator[3:] / shear)])
        volume = (mean - stress[:3].mean()) / (YOUNG / (1.0 - 2.0 * POISSON))
        plastic = strain - elastic - volume * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        assert new @ plastic > -1e-9 * second * after


def test_the_answer_hardly_depends_on_the_steps():
    """p' of I_R is that before the increment: a first-order error, 0.5 % of q at five times the steps."""
    start, p = -1.0e5 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), pack()
    found = [
        drive(Material(sand.LAW, p), start, AXIAL, HELD, np.linspace(0.0, 0.1, n + 1)[1:])[1][-1] for n in (20, 400)
    ]
    assert found[0][2] == pytest.approx(found[1][2], rel=5e-3)
