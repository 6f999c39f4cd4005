# SPDX-License-Identifier: MIT
"""Settings of Newton's method and of its linear systems; check of the environment variable that Numba reads."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

from fe_engine.errors import SettingError

MOST_THREADS = 4096


@dataclass(frozen=True)
class Recycling:
    """When factors of an earlier tangent are used, and when they are renewed (see linear.recycled).

    Attributes
    ----------
    start : number of unknowns from which earlier factors are used; smaller models factorise each tangent.
    longest : iterations after which GMRES gives up, about a third of the cost of new factors.
    comfortable : mean iterations per system of an increment, beyond those with new factors, from which on the factors
        are renewed. ``longest`` and ``comfortable`` hold for 50,000 unknowns and grow with the model.
    many : share of the equations of the interface whose contact may change before its inverse is made anew.
    """

    start: int = 2_000
    longest: int = 30
    comfortable: float = 6.0
    many: float = 0.3


@dataclass(frozen=True)
class Settings:
    """Settings of Newton's method.

    Attributes
    ----------
    tolerance : largest residual of a converged increment, relative to the norm of the change of contact forces.
    max_iterations : linear solves after which an increment is given up.
    shares : smallest and largest share of its residual that a linear system may leave; None: by the number of
        unknowns (see solve.globalisation.bounds).
    recycling : use of earlier factors.
    """

    tolerance: float = 1.0e-5
    max_iterations: int = 20
    shares: tuple[float, float] | None = None
    recycling: Recycling = field(default_factory=Recycling)


def refuse_bad_settings() -> None:
    """Raise SettingError where NUMBA_NUM_THREADS is not a number of threads."""
    text = os.environ.get("NUMBA_NUM_THREADS")
    if text is None:
        return
    try:
        number = int(text)
    except ValueError:
        number = 0
    if not 1 <= number <= MOST_THREADS:
        raise SettingError(
            f"NUMBA_NUM_THREADS: {text!r} is not a number of threads: a whole number, 1 to {MOST_THREADS}"
        )
