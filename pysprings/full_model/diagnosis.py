# SPDX-License-Identifier: MIT
"""Why a path stopped: a named physical reason from the state itself, with the figure that shows it.

``limit load``   under a given load, the caisson's stiffness is gone, or nothing balances the load.
``dead load``    the path did not begin: its own vertical load was not carried; no load of it is a limit load.
``displacement limit``  under a given load, the caisson has moved too far, and the soil still resists more.
``apex``         the soil around the largest residual has lost its confining stress: no stiffness, no strength.
``localisation`` the soil's tangent there has lost its ellipticity (Rudnicki & Rice 1975): det(n.C.n) <= 0 for some
                 direction n, so that strains may concentrate in a band of any width; plasticity without hardening
                 whose dilation is less than its friction does that.
``friction``     stations there stick and slip in turn: Coulomb friction with this coefficient has no state that holds.
``unexplained``  none of these.

A share of the diameter or a rotation (`[limit]` of the scene; 10 % and 5 degrees by default) ends a path of kind
"load": small displacements do not describe more, and no foundation is used there. A soil that carries the load without
a peak (clay as cohesion without friction) would go on to metres.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.conventions import CONTACT_OPEN, REGIME_APEX, REGIME_CONE
from fe_engine.errors import FEError
from fe_engine.material import soil_rows
from fe_engine.soil.dispatch import update_of
from fe_engine.soil.elastic import elastic_tangent
from fe_engine.soil.law import Point
from fe_engine.solve.stepping import Driver, Position
from fe_engine.state import State
from pysprings.core.text import percent
from pysprings.core.words import Diagnosis, StopReason
from pysprings.scene.model import Scene

# A caisson under a given load is at its limit where this share of its initial stiffness is left
_LIMIT = 0.02
# ... or where the iterations of a step that could not be smaller leave this share of the forces
_NO_BALANCE = 0.1
# Share of the Gauss points around a place above which their regime is that of the soil there
_MOST = 0.25
_LEADS_ON = "; solver.viscous_displacement may lead on"
_NODES = 10  # with the largest residuals: what cycles is beside them as often as at the largest
_VOIGT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])


def too_far(driver: Driver, initial: np.ndarray, moved: str) -> Diagnosis:
    """Return why a given load has moved the caisson too far; ``moved`` are words for how far, ``initial`` as below."""
    left = _stiffness_left(driver, initial)
    reason = StopReason.LIMIT_LOAD if left < _LIMIT else StopReason.DISPLACEMENT_LIMIT
    return Diagnosis(reason, moved if np.isnan(left) else f"{moved}; {_left(left)}")


def diagnose(driver: Driver, given_load: bool, initial: np.ndarray) -> Diagnosis:
    """Return why no next state was found from the committed one.

    ``given_load``: forces are imposed. ``initial`` (nb, nb) is the border stiffness of the initial state (the
    model's). The trial fields are those of the last attempt.
    """
    system, state = driver.newton.system, driver.state
    elements = _around(system, state)
    if given_load and (left := _stiffness_left(driver, initial)) < _LIMIT:
        return Diagnosis(StopReason.LIMIT_LOAD, _left(left))
    if given_load and driver.given_up and (least := _least_residual(driver)) > _NO_BALANCE:
        detail = f"no motion balances any more, {100.0 * least:.0f} % of the forces are left over"
        return Diagnosis(StopReason.LIMIT_LOAD, detail)
    apex = float(np.mean(system.regime[elements] == REGIME_APEX))
    if apex >= _MOST:
        return Diagnosis(StopReason.APEX, f"{100.0 * apex:.0f} % of the soil there has no confining stress left")
    worst = _ellipticity(system, state, elements)
    if worst <= 0.0:
        detail = f"the soil there has lost its ellipticity (det n.C.n is {worst:.2g} of the elastic one)"
        return Diagnosis(StopReason.LOCALISATION, detail + ("" if given_load else _LEADS_ON))
    if np.any(system.stations_on(elements) & (system.contact_state != CONTACT_OPEN)):
        return Diagnosis(StopReason.FRICTION, "stations there stick, slip and open in turn, and no set of states holds")
    return Diagnosis(StopReason.UNEXPLAINED)


def during_dead_load(cause: Diagnosis, position: Position | None) -> Diagnosis:
    """Return why a path stopped before it began; ``position`` is that of the last converged increment, if any."""
    converged = 0.0 if position is None else position.done
    detail = f"{100.0 * converged:.3g} % of it converged"
    if converged == 0.0:
        detail = "no increment of it converged, however small; this is no limit load"
    return Diagnosis(StopReason.DEAD_LOAD, f"{detail}; {cause.detail or cause.reason}")


def _left(share: float) -> str:
    return f"{percent(100.0 * max(share, 0.0))} of the initial stiffness is left"


def _around(system: System | FourierSystem, state: State) -> np.ndarray:
    """Return the elements of the nodes with the largest residuals of the last attempt."""
    try:
        residual = np.abs(system.residual(state).free)
    except FEError:  # the law itself failed: take the elements where it does
        return np.flatnonzero((system.regime == REGIME_CONE).any(axis=1))[:8]
    if not np.all(np.isfinite(residual)):
        residual = np.nan_to_num(residual, nan=np.inf)
    worst = np.argsort(residual)[-_NODES:]
    touching = system.elements_at(worst)
    return touching if len(touching) else np.arange(min(8, len(system.regime)))  # film nodes


def _stiffness_left(driver: Driver, initial: np.ndarray) -> float:
    """Return stiffness of the last increment beside the smallest eigenvalue of the initial one, in displacements.

    NaN where no force was given: motions that are imposed do not show it.
    """
    if driver.stiffness is None:
        return math.nan
    scale = driver.newton.scale
    return float(driver.stiffness / np.linalg.eigvalsh(0.5 * (initial + initial.T) / np.outer(scale, scale))[0])


def _least_residual(driver: Driver) -> float:
    """Return the least relative residual that the iterations of the last attempt came to, its predictor aside."""
    _, _, error = driver.given_up[-1]
    return min((float(row["residual"]) for row in error.history[1:]), default=0.0)


def _ellipticity(system: System | FourierSystem, state: State, elements: np.ndarray) -> float:
    """Return least det(n.C.n) over its elastic value, of the yielding points of these elements over directions n."""
    directions = _directions()
    worst, share = 1.0, system.relaxed
    old, tangent, elastic = state.committed, np.empty((6, 6)), np.empty((6, 6))
    new = Point(np.empty(6), np.empty(old.history.shape[2]))
    code, parameters, moduli = soil_rows(system.model)
    update = update_of(tuple(np.unique(code).tolist()))
    for e in elements:
        if not (system.regime[e] == REGIME_CONE).any():
            continue
        for g in np.flatnonzero(system.regime[e] == REGIME_CONE):
            strain, before = system.strain_step(state, int(e), int(g)), Point(old.stress[e, g], old.history[e, g])
            row = int(g) * parameters.shape[1] // system.regime[0].size  # azimuths share that of their section's point
            update(code[e], parameters[e, row], strain, before, new, tangent, True)
            elastic_tangent(*moduli[e, row], 1.0, elastic)
            viscous = elastic + share * (tangent - elastic)
            worst = min(worst, float(np.min(_acoustic(viscous, directions))) / _elastic(*moduli[e, row]))
    return worst


def _directions() -> np.ndarray:
    """Return the unit vectors (k, 3) over half a sphere, evenly (Fibonacci)."""
    k = np.arange(400)
    z, turn = (k + 0.5) / 400, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _acoustic(tangent: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the det(n.C.n) (k,) of a tangent (6, 6) in Voigt order."""
    c = tangent[_VOIGT[:, :, None, None], _VOIGT[None, None, :, :]]
    return np.linalg.det(np.einsum("ni,ijkl,nl->njk", directions, c, directions))


def _elastic(bulk: float, shear: float) -> float:
    """Return the det(n.C.n) of the elastic tangent: (K + 4G/3) G^2, in Pa3."""
    return float((bulk + 4.0 / 3.0 * shear) * shear * shear)


# --- how far a given load may move the caisson ---

# An increment that ends beyond this many times the limit is tried again with half its size
OVERSHOOT = 1.1


@dataclass(frozen=True)
class DisplacementLimit:
    """The limit for a caisson.

    diameter, skirt_length : of the caisson [m].
    largest_share : of the diameter, by which the lid centre or the tip may move sideways, or the caisson up or down.
    largest_rotation : [rad].
    rest : vertical displacement [m, down] from which it counts.
    """

    diameter: float
    skirt_length: float
    largest_share: float
    largest_rotation: float
    rest: float = 0.0

    @classmethod
    def of(cls, scene: Scene, rest: float) -> Self:
        """Return the limit of a scene."""
        caisson, limit = scene.caisson, scene.limit
        return cls(caisson.outer_diameter, caisson.skirt_length, limit.displacement_over_diameter, limit.rotation, rest)

    def share(self, border: np.ndarray) -> float:
        """Return the share of the limit that a motion (m, rad) of the lid centre reaches.

        It is (u, w, rotation), or that of six degrees of freedom, where a twist counts as a rotation does.
        """
        return max(self._shift(border) / (self.largest_share * self.diameter), _turned(border) / self.largest_rotation)

    def text(self, border: np.ndarray) -> str:
        """Return words for how far the caisson has moved, and the limit."""
        turned = math.degrees(_turned(border))
        limit = f"{100.0 * self.largest_share:g} % of the diameter, {math.degrees(self.largest_rotation):g} deg"
        return f"the caisson has moved by {self._shift(border):.3g} m and turned by {turned:.2g} deg (limit {limit})"

    def refusal(self, border: np.ndarray) -> str:
        """Return why an increment that ends there is not taken, "" where it is."""
        return (
            f"{StopReason.DISPLACEMENT_LIMIT}: an increment leads too far, {self.text(border)}"
            if self.share(border) > OVERSHOOT
            else ""
        )

    def _shift(self, border: np.ndarray) -> float:
        length = self.skirt_length
        if len(border) == 3:
            u, w, rotation = border
            return float(max(abs(u), abs(u - rotation * length), abs(w - self.rest)))
        u_x, u_y, w, rot_x, rot_y, _ = border
        tip = np.hypot(u_x - rot_y * length, u_y + rot_x * length)
        return float(max(np.hypot(u_x, u_y), tip, abs(w - self.rest)))


def _turned(border: np.ndarray) -> float:
    """Return the rotation (rad) of a motion in the plane, or the larger one of rotation and twist of one in space."""
    return float(abs(border[2]) if len(border) == 3 else max(np.hypot(border[3], border[4]), abs(border[5])))
