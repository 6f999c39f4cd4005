# SPDX-License-Identifier: MIT
"""What the tests of the soil laws at one point share: an update with all it writes, invariants, draws of a sweep."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from fe_engine.conventions import OK
from fe_engine.soil import plasol
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.law import Point
from tests.support.models import DEGREE, SAND, taylor_slope, to_matrix

YOUNG, POISSON = SAND[:2]
PRESSURE = 1.0e5
START = -PRESSURE * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
# a general direction, mostly shear; and a general direction to perturb it in
PUSH = 1.0e-3 * np.array([1.0, -0.4, -0.7, 0.5, -0.3, 0.8])
OTHER = 1.0e-3 * np.array([0.3, 0.5, -0.6, -0.9, 0.4, 0.7])
OPENING = 1.0e-3 * np.array([1.5, 0.8, 0.7, 0.5, -0.3, 0.2])
SIZES = np.geomspace(3.0e-2, 1.0e-3, 5)
# strains of a triaxial test that compresses or extends, and in between
COMPRESSION = 1.0e-3 * np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0])
MERIDIANS = {"compression": COMPRESSION, "extension": -COMPRESSION, "pure shear": 1.0e-3 * np.eye(6)[3]}
# changes of the parameters, and whether the law is then associated with a tangent that is symmetric
SYMMETRY = (
    ({"phi_i": 30.0, "psi": 30.0}, True),
    ({"phi_i": 30.0, "psi": 30.0, "cohesion": 1.0e4}, True),
    ({"phi_i": 30.0, "psi": 29.0}, False),
    ({"phi_i": 30.0, "psi": 0.0}, False),
)


def make(phi_i=5.0, phi_f=30.0, psi=0.0, cohesion=0.0, b_phi=0.005, young=YOUNG, poisson=POISSON):
    """Return the packed parameters; angles in degrees."""
    return plasol.pack(young, poisson, phi_i * DEGREE, phi_f * DEGREE, b_phi, psi * DEGREE, cohesion)


@dataclass
class Answer:
    """What one update wrote and returned."""

    stress: np.ndarray
    kappa: float
    tangent: np.ndarray
    status: int
    regime: int


def update_by(law: Callable, p, strain, stress=START, kappa=0.0) -> Answer:
    """Return one update by a law from a stress and an equivalent plastic strain."""
    new, history, tangent = np.full(6, np.nan), np.full(1, np.nan), np.full((6, 6), np.nan)
    status, regime = law(p, strain, Point(stress, np.array([kappa])), Point(new, history), tangent, True)
    return Answer(new, history[0], tangent, status, regime)


class Stepped(NamedTuple):
    """What an update from a state wrote and returned."""

    new: Point
    tangent: np.ndarray
    regime: int


def stepped(law: Callable, p, strain, old: Point) -> Stepped:
    """Return one update by a law from a state, which has to succeed with finite numbers."""
    new, tangent = Point(np.full(6, np.nan), np.full(len(old.history), np.nan)), np.full((6, 6), np.nan)
    status, regime = law(p, strain, old, new, tangent, True)
    assert status == OK and np.isfinite(new.stress).all() and np.isfinite(tangent).all()
    return Stepped(new, tangent, regime)


def slope_of(update: Callable, p, strain, stress=START, kappa=0.0):
    """Return the order of the error of the tangent (2: it is the derivative) in a direction that keeps the regime."""
    answer = update(p, strain, stress, kappa)
    for size in SIZES:
        assert update(p, strain + size * OTHER, stress, kappa).regime == answer.regime
    return taylor_slope(lambda e: update(p, e, stress, kappa).stress, answer.tangent, strain, OTHER, SIZES)


def invariants(stress):
    """Return I = tr sigma and II = sqrt(s:s/2)."""
    first = stress[:3].sum()
    deviator = to_matrix(stress) - first / 3.0 * np.eye(3)
    return first, np.sqrt(0.5 * np.sum(deviator**2))


def elastic(p):
    """Return the elastic stiffness (6, 6) of packed parameters."""
    bulk, shear = p[plasol.BULK], p[plasol.SHEAR]
    return elastic_matrix(
        9.0 * bulk * shear / (3.0 * bulk + shear), (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)
    )


def trial_excess(yield_function: Callable, p, strain, stress, kappa):
    """Yield function of the elastic trial stress at a given hardening, and its size."""
    trial = stress + elastic(p) @ strain
    first, second = invariants(trial)
    return yield_function(p, trial, kappa), second + abs(first) + p[plasol.COHESION]


def dissipation(p, strain, stress, answer):
    """Return the plastic work of the step, J/m3."""
    plastic = strain - np.linalg.solve(elastic(p), answer.stress - stress)
    return answer.stress @ plastic


@st.composite
def soils(draw):
    """Return the parameters far apart, within what a scene may hold."""
    phi_f = draw(st.floats(0.5, 45.0))
    return make(
        phi_i=draw(st.sampled_from([0.0, 1.0e-6, 0.1, 0.5, 1.0])) * phi_f,
        phi_f=phi_f,
        psi=draw(st.one_of(st.floats(-5.0, 0.0), st.floats(0.0, 1.0).map(lambda share: share * phi_f))),
        cohesion=draw(st.sampled_from([0.0, 1.0, 1.0e3, 1.0e6])),
        b_phi=draw(st.sampled_from([1.0e-6, 1.0e-4, 0.005, 1.0])),
        young=10.0 ** draw(st.floats(6.0, 11.0)),
        poisson=draw(st.sampled_from([0.0, 0.2, 0.3, 0.45, 0.499])),
    )


@st.composite
def strains(draw):
    """Return the increments of strain from rounding to a tenth."""
    direction = np.array(draw(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)))
    return 10.0 ** draw(st.floats(-9.0, -1.0)) * direction
