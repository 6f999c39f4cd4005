# SPDX-License-Identifier: MIT
"""Ellipsoids in parallel: strength and backbone by direction, von Mises elements as the equal case, loops, tangent."""

from itertools import pairwise

import numpy as np
import pytest

from fe_engine.conventions import OK
from fe_engine.soil import iwan_anisotropic, iwan_clay
from fe_engine.soil.elastic import moduli
from fe_engine.soil.law import Point
from tests.support.models import taylor_slope
from tests.support.soil_points import OTHER, PUSH, SIZES, START

YOUNG, POISSON, SU = 1.2e7, 0.49, 2.0e4
SHEAR = moduli(YOUNG, POISSON)[1]
FACTORS = (1.4, 1.0, 0.7)
BACKBONE = iwan_clay.pack(YOUNG, POISSON, SU, SU / SHEAR)
CLAY = iwan_anisotropic.pack(BACKBONE, FACTORS)
PLANE = np.array([0.5, 0.0, -0.5, 0.0, 0.0, 0.0])  # compression with a vertical axis, of engineering shear strain 1
IN_SHEAR = np.eye(6)[5]


def follow(p, strains, law=iwan_anisotropic.LAW, start=START):
    """Stresses (n, 6) along strains (n, 6) from a stress, and the last tangent."""
    state, before, out, tangent = Point(start.copy(), np.zeros(len(law.history))), np.zeros(6), [], np.empty((6, 6))
    for strain in strains:
        new = Point(np.empty(6), np.empty(len(law.history)))
        assert law.update(p, strain - before, state, new, tangent, True)[0] == OK
        state, before = new, strain
        out.append(new.stress)
    return np.array(out), tangent


@pytest.mark.parametrize(("direction", "factor"), [(IN_SHEAR, 1.0), (PLANE, 1.4), (-PLANE, 0.7), (-IN_SHEAR, 1.0)])
def test_stress_and_strain_of_the_backbone_grow_with_the_strength_of_a_direction(direction, factor) -> None:
    """tau = f su g(gamma G/(f su)) of simple shear, less what turns to another direction; f su at the end."""
    gamma = np.geomspace(0.01, 300.0, 60) * SU / SHEAR
    isotropic = np.full(6, START[:3].mean()) * np.array([1, 1, 1, 0, 0, 0])
    found, _ = follow(CLAY, factor * gamma[:, None] * direction, start=isotropic)
    plain, _ = follow(BACKBONE, gamma[:, None] * IN_SHEAR, iwan_clay.LAW, isotropic)
    own = np.abs(found[:, 5]) if abs(direction[5]) else np.abs(found[:, 0] - found[:, 2]) / 2.0
    wanted = factor * plain[:, 5]
    assert (own <= wanted * (1.0 + 1e-9)).all() and own == pytest.approx(wanted, rel=0.022)
    assert own[0] == pytest.approx(0.01 * factor * SU, rel=1e-9) and own[-1] == pytest.approx(factor * SU, rel=1e-4)


def test_equal_strengths_are_von_mises_elements_along_any_path() -> None:
    random = np.random.default_rng(1)
    path = np.cumsum(random.normal(size=(40, 6)), axis=0) * SU / SHEAR
    equal = iwan_anisotropic.pack(BACKBONE, (1.0, 1.0, 1.0))
    (own, tangent), (plain, other) = follow(equal, path), follow(BACKBONE, path, iwan_clay.LAW)
    np.testing.assert_allclose(own, plain, rtol=1e-9, atol=1e-6 * SU)
    np.testing.assert_allclose(tangent, other, rtol=1e-7, atol=1e-7 * SHEAR)


def test_closed_loops_dissipate_and_settle() -> None:
    """From an isotropic stress each loop is nearer to the one before it; the work of each is positive."""
    turns = [0.0, *[1.0, -1.0] * 8, 0.0]
    way = np.concatenate([np.linspace(a, b, 40)[1:] for a, b in pairwise(turns)])
    stress, _ = follow(CLAY, 3.0 * SU / SHEAR * way[:, None] * (IN_SHEAR + PLANE))
    loops = [stress[39 + 78 * k : 117 + 78 * k] for k in range(7)]
    apart = [np.abs(after - before).max() / SU for before, after in pairwise(loops)]
    assert apart == sorted(apart, reverse=True) and apart[-1] < 0.2 * apart[0]
    rates = np.diff(3.0 * SU / SHEAR * way[38 : 38 + 79])[:, None] * (IN_SHEAR + PLANE)
    assert all((each * rates).sum() > SU * SU / SHEAR for each in loops)


@pytest.mark.parametrize("strain", [PUSH, -PUSH, 30.0 * OTHER, PLANE * 0.02, -PLANE * 1e-3])
def test_tangent_is_the_symmetric_derivative(strain) -> None:
    tangent = follow(CLAY, [strain], start=START)[1]
    assert taylor_slope(lambda e: follow(CLAY, [e])[0][0], tangent, strain, OTHER, SIZES) > 1.85
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-9 * SHEAR)
