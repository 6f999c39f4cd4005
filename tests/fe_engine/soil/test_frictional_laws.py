# SPDX-License-Identifier: MIT
"""The frictional laws at one point: regimes, return, tangents, invariances, a sweep over extreme parameters."""

from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fe_engine.conventions import LAW_NOT_CONVERGED, OK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import plasol, van_eekelen
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.law import Point
from tests.support.models import rotation_matrix, to_matrix, to_voigt
from tests.support.soil_points import (
    COMPRESSION,
    MERIDIANS,
    OPENING,
    OTHER,
    POISSON,
    PRESSURE,
    PUSH,
    START,
    SYMMETRY,
    YOUNG,
    Answer,
    dissipation,
    elastic,
    make,
    slope_of,
    soils,
    strains,
    trial_excess,
    update_by,
)


class Law(NamedTuple):
    """A law with its module, and the function that iterates in its return to the surface."""

    module: ModuleType
    iterates: str

    def update(self, p, strain, stress=START, kappa=0.0) -> Answer:
        return update_by(self.module.update, p, strain, stress, kappa)

    def excess(self, p, strain, stress, kappa):
        return trial_excess(self.module.yield_function, p, strain, stress, kappa)


PLASOL, VAN_EEKELEN = Law(plasol, "multiplier"), Law(van_eekelen, "solve")
each_law = pytest.mark.parametrize("law", [PLASOL, VAN_EEKELEN], ids=["plasol", "van Eekelen"])

SURFACES = {
    "no dilation": make(),
    "dilation below friction": make(psi=4.0),
    "dilation is friction": make(phi_i=30.0, psi=30.0),
    "dilation beyond the friction of today": make(psi=20.0),
    "cohesion": make(cohesion=2.0e4),
    "cohesion and dilation": make(cohesion=2.0e4, psi=10.0, phi_i=12.0),
    "contraction": make(psi=-5.0),
    "von Mises": make(phi_i=0.0, phi_f=0.0, cohesion=2.0e4),
    "no friction at first": make(phi_i=0.0, psi=5.0),
}
each_surface = pytest.mark.parametrize("p", SURFACES.values(), ids=SURFACES)
each_shear = pytest.mark.parametrize("strain", [PUSH, *MERIDIANS.values()], ids=["general", *MERIDIANS])


@each_law
def test_small_strain_is_elastic(law):
    answer = law.update(make(), 0.01 * PUSH)
    assert (answer.status, answer.regime, answer.kappa) == (OK, REGIME_ELASTIC, 0.0)
    np.testing.assert_allclose(answer.stress, START + 0.01 * elastic_matrix(YOUNG, POISSON) @ PUSH, rtol=1e-13)
    np.testing.assert_allclose(answer.tangent, elastic_matrix(YOUNG, POISSON), rtol=1e-14)


@each_law
@each_shear
@each_surface
def test_shear_returns_to_the_surface(law, p, strain):
    answer = law.update(p, strain)
    trial, size = law.excess(p, strain, START, 0.0)
    assert (answer.status, answer.regime) == (OK, REGIME_CONE)
    assert trial > 1.0e-3 * size
    assert abs(law.module.yield_function(p, answer.stress, answer.kappa)) <= 1.0e-13 * size


def plane_strain(law, phi: float, cohesion: float, side: float) -> float:
    """Return the largest pressure s1 of plane strain without dilation beside a pressure s3 = ``side``."""
    p, stress, kappa = make(phi_i=phi, phi_f=phi, cohesion=cohesion), -side * np.array([1.0, 1, 1, 0, 0, 0]), 0.0
    for _ in range(150):
        across = 0.0
        for _ in range(30):
            answer = update_by(law.update, p, np.array([across, -4e-4, 0, 0, 0, 0]), stress, kappa)
            if abs(answer.stress[0] + side) < 1e-9 * side:
                break
            across -= (answer.stress[0] + side) / answer.tangent[0, 0]
        stress, kappa = answer.stress, answer.kappa
    return -float(stress[1])


@pytest.mark.parametrize(
    ("law", "phi", "angle", "share"),
    [
        (plasol, 20.0, 26.4713, 1.36812), (plasol, 30.0, 43.8538, 1.66410),
        (van_eekelen, 30.0, 33.5826, 1.15001), (van_eekelen, 40.0, 43.9409, 1.14849),
    ],
)  # fmt: skip
def test_friction_and_cohesion_in_plane_strain_without_dilation(law, phi, angle, share):
    """The formulas of the theory, worked out by hand: the middle stress is the mean of the other two."""
    cohesion, sides = 5e3, (50e3, 100e3)
    low, high = (plane_strain(law, phi, cohesion, side) for side in sides)
    ratio = (high - low) / (sides[1] - sides[0])  # s1 = ratio s3 + 2 c sqrt(ratio)
    assert np.degrees(np.arcsin((ratio - 1.0) / (ratio + 1.0))) == pytest.approx(angle, abs=2e-3)
    assert (low - ratio * sides[0]) / (2.0 * np.sqrt(ratio) * cohesion) == pytest.approx(share, abs=2e-4)


@each_law
@pytest.mark.parametrize("psi", [0.0, 3.0])
def test_unloading_after_yield_is_elastic_and_remembers(law, psi):
    p = make(psi=psi)
    yielded = law.update(p, PUSH)
    back = law.update(p, -0.02 * PUSH, yielded.stress, yielded.kappa)
    assert (back.regime, back.kappa) == (REGIME_ELASTIC, yielded.kappa)
    np.testing.assert_allclose(back.stress - yielded.stress, -0.02 * elastic(p) @ PUSH, rtol=1e-10)
    again = law.update(p, 0.04 * PUSH, back.stress, back.kappa)
    assert again.regime == REGIME_CONE
    assert again.kappa > yielded.kappa


# --- tangents ---------------------------------------------------------------------------------------------


@each_law
@each_shear
@each_surface
def test_tangent_on_the_surface(law, p, strain):
    assert slope_of(law.update, p, strain) == pytest.approx(2.0, abs=0.1)


@each_law
def test_tangent_after_earlier_yield(law):
    p = make(psi=3.0, cohesion=5.0e3)
    yielded = law.update(p, OTHER)
    assert slope_of(law.update, p, PUSH, yielded.stress, yielded.kappa) == pytest.approx(2.0, abs=0.1)


@each_law
@pytest.mark.parametrize(("changes", "symmetric"), SYMMETRY)
def test_tangent_is_symmetric_only_for_the_associated_law(law, changes, symmetric):
    tangent = law.update(make(**changes), PUSH).tangent
    skew = np.abs(tangent - tangent.T).max() / np.abs(tangent).max()
    assert (skew < 1.0e-12) == symmetric
    assert symmetric or skew > 1.0e-3


@each_law
def test_stress_is_the_same_without_the_tangent(law):
    stress, history, untouched = np.zeros(6), np.zeros(1), np.full((6, 6), 7.0)
    for strain in (0.01 * PUSH, PUSH, OPENING):
        law.module.update(make(psi=5.0), strain, Point(START, np.zeros(1)), Point(stress, history), untouched, False)
        np.testing.assert_array_equal(stress, law.update(make(psi=5.0), strain).stress)
    assert np.all(untouched == 7.0)


# --- invariances ------------------------------------------------------------------------------------------


@each_law
@pytest.mark.parametrize("strain", [0.01 * PUSH, PUSH, COMPRESSION, -COMPRESSION, OPENING])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, -0.5)])
def test_rotated_strain_gives_the_rotated_stress(law, strain, axis):
    p, turn = make(psi=8.0, cohesion=1.0e3), rotation_matrix(axis, 0.7)
    first = law.update(p, 0.3 * OTHER)
    straight = law.update(p, strain, first.stress, first.kappa)

    def rotate(voigt, shear=1.0):
        return to_voigt(turn @ to_matrix(voigt, 1.0 / shear) @ turn.T, shear)

    rotated = law.update(p, rotate(strain, 2.0), rotate(first.stress), first.kappa)
    assert rotated.regime == straight.regime
    assert rotated.kappa == pytest.approx(straight.kappa, rel=1e-12)
    np.testing.assert_allclose(rotated.stress, rotate(straight.stress), atol=1e-10 * PRESSURE)


# --- status and sweep -------------------------------------------------------------------------------------


@each_law
def test_a_strain_that_is_no_number_never_becomes_a_finite_stress(law):
    answer = law.update(make(psi=5.0), np.full(6, np.nan))
    assert answer.status != OK or np.all(np.isnan(answer.stress))


@each_law
def test_a_local_iteration_cut_short_says_so(law, monkeypatch):
    monkeypatch.setattr(law.module, "MAX_ITERATIONS", 1)
    monkeypatch.setattr(law.module, law.iterates, getattr(law.module, law.iterates).py_func)
    answer = update_by(law.module.update.py_func, make(psi=5.0), PUSH)
    assert answer.status == LAW_NOT_CONVERGED


@each_law
@settings(max_examples=500, deadline=None, derandomize=True, database=None)
@given(p=soils(), strain_1=strains(), strain_2=strains(), pressure=st.sampled_from([0.0, 1.0, 1.0e4, 1.0e6]))
def test_no_parameters_and_no_strain_break_the_law(law, p, strain_1, strain_2, pressure):
    stress, kappa = pressure / PRESSURE * START, 0.0
    for strain in (strain_1, strain_2):
        answer = law.update(p, strain, stress, kappa)
        trial, size = law.excess(p, strain, stress, answer.kappa)
        assert answer.status == OK
        assert np.all(np.isfinite(answer.stress))
        assert np.all(np.isfinite(answer.tangent))
        assert answer.kappa >= kappa
        # beyond the apex van Eekelen's excess is that of the cone: the section has no meaning there
        beyond = trial if law is PLASOL else max(trial, size)
        left = plasol.APEX_STIFFNESS * beyond if answer.regime == REGIME_APEX else 0.0
        assert law.module.yield_function(p, answer.stress, answer.kappa) <= left + 1.0e-13 * size
        if 0.0 <= p[plasol.M_PSI] <= plasol.cone_slope(p[plasol.PHI_I]):
            rounding = 1.0e-15 * size * (size / p[plasol.SHEAR] + size / p[plasol.BULK] + np.abs(strain).max())
            assert dissipation(p, strain, stress, answer) >= -10.0 * rounding
        stress, kappa = answer.stress, answer.kappa
