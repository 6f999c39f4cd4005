# SPDX-License-Identifier: MIT
"""What a soil law declares, and the state of a point that it advances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


class Point(NamedTuple):
    """State of a Gauss point: stress (6,) in Pa, history (at least as many as the law has)."""

    stress: np.ndarray
    history: np.ndarray


def rows(*columns: Any) -> np.ndarray:
    """Return the packed parameters (n,) of n numbers, or (..., n) where any of them is an array (...,)."""
    return np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=-1), dtype=float)


@dataclass(frozen=True, eq=False)
class SoilLaw:
    """A constitutive law of the soil.

    Attributes
    ----------
    name : unique name of the law.
    parameters : names of the packed parameters, in their order.
    history : names of the history variables, in their order; they begin at 0.
    pack : keyword arguments (Pa, rad) -> packed parameters (n,), or (k, n) where an argument is an array (k,).
    moduli : packed parameters (..., n) -> (K, G), each (...,) in Pa, of the elastic tangent. Assembly adds that tangent
        once; a point that returns REGIME_ELASTIC adds nothing to it.
    update : jitted function (p, strain, old, new, tangent, with_tangent) -> (status, regime). It advances a point by
        the strain increment (6,): reads the parameters p (n,) and ``old`` (Point), writes the stress and the history of
        ``new`` (Point), and if ``with_tangent`` the consistent tangent (6, 6). A status other than OK stops the
        increment. It allocates nothing that can be avoided and calls jitted functions alone; where none of them makes
        an array, they are compiled by `compiled.lean`, else by `compiled.njit`.
    relax : jitted function (p, moduli, share, strain, old, new, tangent, with_tangent) that turns the answer into the
        viscous one, and the tangent T into one of which C + share (T - C) is consistent, see `viscous`; None for a law
        whose elastic stiffness C is that of ``moduli``, K and G, at all times.
    hardened : jitted function (p, strain, regime, old, new, out) that writes the derivative (6,) in Pa of the stress of
        an answer, which ``new`` and ``regime`` are, by the plastic strain before; of frictional surfaces, for
        `following`, alone.
    symmetric : whether every tangent is symmetric and positive definite, so that half of the factors will do.
    yields : whether points can leave the elastic regime.
    isotropic : whether no direction is preferred; a law that is not prefers the vertical, z.
    """

    name: str
    parameters: tuple[str, ...]
    history: tuple[str, ...]
    pack: Callable[..., np.ndarray]
    moduli: Callable[[np.ndarray], tuple[Any, Any]]
    update: Any
    relax: Any = None
    hardened: Any = None
    symmetric: bool = False
    yields: bool = True
    isotropic: bool = True


PLASTIC_STRAIN = "equivalent_plastic_strain"  # history variable that results show, where a law has it
