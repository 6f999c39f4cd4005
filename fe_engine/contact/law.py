# SPDX-License-Identifier: MIT
"""What a contact law declares, and the motion of a station that it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


class Slide(NamedTuple):
    """Motion of a station in its frame (normal, tangent 1, tangent 2).

    jump, jump_old : (3,) m since the initial state, now and at the start of the increment.
    traction_old : (3,) Pa at the start of the increment; initial_pressure : Pa, >= 0, of the initial state.
    """

    jump: np.ndarray
    jump_old: np.ndarray
    traction_old: np.ndarray
    initial_pressure: float


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """A law of the interface: traction (3,) from the jump (3,), without memory but for the traction itself.

    Attributes
    ----------
    name : unique name of the law.
    parameters : names of the packed parameters, in their order.
    pack : keyword arguments -> packed parameters (n,).
    update : jitted function (p, slide, traction) -> contact state. It writes the traction (3,) of a Slide, and returns
        CONTACT_STICK, CONTACT_SLIP or CONTACT_OPEN.
    linearise : jitted function (p, slide, guess, traction, tangent) -> contact state. It writes traction (3,) and
        tangent (3, 3) of a linear model of the law near the present jump, about a traction iterate ``guess`` (3,); with
        the law's own traction as guess the model is the law with its consistent tangent.
    gap : (packed parameters (ns, n), initial pressure (ns,) in Pa, normal jump (ns,) in m) -> opening (ns,) in m, >= 0.
    penalties : packed parameters (..., n) -> (K_N, K_T), each (...,) in N/m3: the elastic springs of the contact.
    smooth : packed parameters (..., n) -> (...,) bool, whether every tangent is symmetric (no friction).
    """

    name: str
    parameters: tuple[str, ...]
    pack: Callable[..., np.ndarray]
    update: Any
    linearise: Any
    gap: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    penalties: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    smooth: Callable[[np.ndarray], np.ndarray]
