# SPDX-License-Identifier: MIT
"""Consistent tangents by the Taylor remainder |f(x + h d) - f(x) - h A d|, which is of second order in h.

Laws that are linear where they are evaluated (elastic soil, a cohesionless apex, stick, open contact) have no
remainder beyond rounding: for them its size over that of f and its change is given instead of an order. A tangent
that is not consistent leaves a remainder of first order.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.contact.law import Slide
from fe_engine.conventions import CONTACT_OPEN, CONTACT_SLIP, CONTACT_STICK, REGIME_APEX, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import plasol, van_eekelen
from fe_engine.soil.law import Point
from fe_engine.state import State
from tests.verification.blocks import POISSON, YOUNG
from tests.verification.cases.drained_push import first_increment
from tests.verification.rows import Row, fitted_rate

_SOURCE = "Taylor's theorem"
_LINEAR = "linear law"
# Strain in the direction d, and the states around which the soil is linearised (compression negative)
_D = 1e-4 * np.array([-1.0, 0.4, 0.3, 0.5, -0.7, 0.2])
_SHEAR = 1e-3 * np.array([-1.0, 0.7, 0.2, 0.8, -0.5, 0.3])
_AXIAL = 1e-3 * np.array([-0.5, -0.5, 1.0, 0.0, 0.0, 0.0])
_SPREAD = 1e-3 * np.array([1.5, 0.7, 0.9, 0.4, -0.2, 0.3])
_P0 = 100.0e3
# E, nu, phi_i, phi_f, B, psi, c: everything at work
_SAND = plasol.pack(YOUNG, POISSON, np.radians(5.0), np.radians(30.0), 0.005, np.radians(10.0), 5.0e3)
_COHESIONLESS = plasol.pack(YOUNG, POISSON, np.radians(5.0), np.radians(30.0), 0.005, 0.0, 0.0)
_CONTACT = coulomb.pack(1.0e10, 1.0e10, 0.5)


@cache
def rows() -> tuple[Row, ...]:
    """Soil, contact, and the whole caisson model."""
    return (*_soil(), *_contact(), _whole_model())


def taylor(f: Callable, a: np.ndarray, x: np.ndarray, d: np.ndarray, sizes: np.ndarray) -> tuple[float, float]:
    """Order in h of the Taylor remainder of f at x with slope a, and its largest size relative to f and h a d."""
    start, slope = f(x), a @ d
    remainder = np.array([np.linalg.norm(f(x + h * d) - start - h * slope) for h in sizes])
    scale = sizes * np.linalg.norm(slope) + np.linalg.norm(start)
    linear = float(np.max(remainder / np.where(scale > 0.0, scale, 1.0)))
    return (fitted_rate(sizes, remainder) if np.all(remainder > 0.0) else np.nan), linear


def _row(name: str, found: tuple[float, float], linear: bool) -> Row:
    case = "consistent tangent"
    if linear:
        return Row.error(case, f"{name}: remainder, relative", found[1], _LINEAR, 1e-12)
    return Row(case, f"{name}: order of the remainder", "", found[0], 2.0, _SOURCE, 0.02)


def _soil() -> list[Row]:
    cone, section = plasol.update, van_eekelen.update
    wanted = [
        ("soil, elastic", cone, _SAND, -0.01 * _SHEAR, REGIME_ELASTIC, True),
        ("soil, cone", cone, _SAND, _SHEAR, REGIME_CONE, False),
        ("soil, apex with cohesion", cone, _SAND, _SPREAD, REGIME_APEX, False),
        ("soil, apex without cohesion", cone, _COHESIONLESS, _SPREAD, REGIME_APEX, True),
        ("Van Eekelen, general", section, _SAND, _SHEAR, REGIME_CONE, False),
        ("Van Eekelen, compression meridian", section, _SAND, -_AXIAL, REGIME_CONE, False),
        ("Van Eekelen, extension meridian", section, _SAND, _AXIAL, REGIME_CONE, False),
        ("Van Eekelen, apex", section, _SAND, _SPREAD, REGIME_APEX, False),
    ]
    return [
        _row(name, _soil_point(law, parameters, strain, regime), linear)
        for name, law, parameters, strain, regime, linear in wanted
    ]


def _soil_point(law: Callable, parameters: np.ndarray, strain: np.ndarray, regime: int) -> tuple[float, float]:
    """Linearise one soil point that has hardened a little, about a strain increment."""
    old = np.array([-_P0, -_P0, -_P0, 0.0, 0.0, 0.0])
    tangent = np.zeros((6, 6))

    def stress(x: np.ndarray, want: bool = False) -> np.ndarray:
        out = np.empty(6)
        before, after = Point(old, np.array([1e-3])), Point(out, np.empty(1))
        status, found = law(parameters, x, before, after, tangent, want)
        assert (status, found) == (0, regime), f"regime {found} instead of {regime}"
        return out

    stress(strain, True)
    return taylor(stress, tangent.copy(), strain, _D, np.geomspace(1e-1, 1e-2, 5))


def _contact() -> list[Row]:
    """A station that has already slipped one way, under 50 kPa."""
    wanted = [
        ("contact, stick", [1e-6, -1e-6, 0.5e-6], CONTACT_STICK, True),
        ("contact, slip", [1e-6, 8e-6, -6e-6], CONTACT_SLIP, False),
        ("contact, open", [9e-6, 8e-6, -6e-6], CONTACT_OPEN, True),
    ]
    return [_row(name, _station(np.array(jump), state), linear) for name, jump, state, linear in wanted]


def _station(jump: np.ndarray, state: int) -> tuple[float, float]:
    """Linearise the contact of one station about a jump."""
    before, old = np.zeros(3), np.array([-50.0e3, 20.0e3, -10.0e3])

    def traction(x: np.ndarray) -> np.ndarray:
        out = np.empty(3)
        assert coulomb.update(_CONTACT, Slide(x, before, old, 50.0e3), out) == state
        return out

    tangent, linearised = np.empty((3, 3)), np.empty(3)
    coulomb.linearise(_CONTACT, Slide(jump, before, old, 50.0e3), traction(jump), linearised, tangent)
    d = np.array([1e-6, -2e-6, 3e-6])
    return taylor(traction, tangent, jump, d, np.geomspace(1e-1, 1e-2, 5))


def _whole_model() -> Row:
    """Residual of the caisson at 0.25 mm: elastic and plastic soil, sticking and slipping stations together."""
    run = first_increment()
    system, scale = run.system, run.system.model.border_scale
    state, step = State(system.model), run.steps[0].increment

    def residual(x: np.ndarray) -> np.ndarray:
        system.apply(state, x[0] * step.free, x[0] * step.border)
        found = system.residual(state)
        return np.concatenate([found.free, found.border / scale])

    def regimes(x: float) -> np.ndarray:
        residual(np.array([x]))
        return np.concatenate([system.regime.ravel(), system.contact_state])

    start = regimes(1.0)
    assert 0 < np.count_nonzero(system.regime == REGIME_CONE) < system.regime.size, "partly plastic"
    assert 0 < np.count_nonzero(system.contact_state == CONTACT_SLIP) < len(run.stations), "partly slipping"
    # small enough that no point changes its regime in between, where the residual has a kink
    largest = next(h for h in 1e-2 * 0.5 ** np.arange(12) if np.array_equal(regimes(1.0 + h), start))
    residual(np.ones(1))
    _, _, tangent = system.linearise(state, True)
    free = tangent.matrix @ step.free + tangent.columns @ step.border
    slope = np.concatenate([free, (tangent.rows @ step.free + tangent.corner @ step.border) / scale])
    sizes = largest * np.array([1.0, 0.7, 0.5, 0.35])
    one = np.ones(1)
    return _row("whole caisson, yielding and slipping", taylor(residual, slope[:, None], one, one, sizes), False)
