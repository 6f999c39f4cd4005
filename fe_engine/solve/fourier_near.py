# SPDX-License-Identifier: MIT
"""What soil that yields has beyond its elastic tangent, times motions under forces on the nodes of it, in one loop.

GMRES asks for D P^-1 v (see fourier_stage), where v and D have something on the nodes of elements that yield
alone. So forces, motions and elements are numbered by these nodes, and P^-1 goes through the columns of its factors
that they depend on, in single precision, which is far closer than GMRES is to go.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fe_engine.assembly import fourier_kernels as kernels, harmonic_factors as factors
from fe_engine.assembly.fourier_rest import AtRest
from fe_engine.assembly.fourier_system import FourierSystem, FourierTangent
from fe_engine.compiled import njit


class _Yielding(NamedTuple):
    """Elements that yield, their nodes (p,) numbered anew: tangents of `FourierTangent`, held (p, 3, K), axis (p,)."""

    elements: np.ndarray
    soil: kernels.Soil
    regime: np.ndarray
    tangent: np.ndarray
    held: np.ndarray
    axis: np.ndarray
    ones: np.ndarray


class NearProduct:
    """Products D P^-1 v for forces v (p 3 K,) on the nodes of elements that yield.

    yielding : these elements, and their nodes (p,), ascending.
    rest, interface : the soil at rest, and what solves for the interface under its load (m,) alone.
    """

    def __init__(
        self, system: FourierSystem, tangent: FourierTangent, yielding: tuple[np.ndarray, np.ndarray], rest: AtRest,
        interface: Callable[[np.ndarray], np.ndarray],
    ) -> None:  # fmt: skip
        pattern, quads = system.pattern, system.model.mesh.quads
        elements, nodes = yielding
        number = np.zeros(system.model.mesh.n_nodes, dtype=np.int64)
        number[nodes] = np.arange(len(nodes))
        self._rest, self._interface, self._near = rest, interface, rest.factors.near(nodes)
        waves = pattern.held.shape[2]
        self._yielding = _Yielding(
            elements, system.soil._replace(quads=number[quads]), tangent.regime, tangent.plastic, pattern.held[nodes],
            np.flatnonzero(pattern.axis[nodes]), np.arange(waves)[pattern.ones],
        )  # fmt: skip
        self._motion = np.empty((len(nodes), 3, waves))
        self._swept = np.empty((len(self._near.group), rest.factors.n_nodes, 3, factors.LANES), dtype=np.float32)
        self._left = np.empty((len(rest.factors.retained), 3, waves))
        self._inside = np.arange(len(self._left))

    def __call__(self, force: np.ndarray) -> np.ndarray:
        """Return the product for forces (p 3 K,) N."""
        _down(self._near, self._inside, force.reshape(self._motion.shape), self._swept, self._left)
        kept, load = self._rest.lead(self._left)
        return self._behind(kept, self._interface(load))

    def behind(self, swept: Any, interface: np.ndarray) -> np.ndarray:
        """Return the product (p 3 K,) for forces everywhere, which `AtRest.backward` takes on from here."""
        self._swept[:], kept = self._rest.of_soil(swept)
        return self._behind(kept, interface)

    def _behind(self, kept: Any, interface: np.ndarray) -> np.ndarray:
        known = self._rest.follow(kept, interface)
        _up(self._near, self._inside, known, self._swept, self._motion)
        out = np.zeros(self._motion.shape)
        _product(self._yielding, self._motion, out)
        return out.ravel()


@njit
def _down(near, inside, force, swept, left):
    """Eliminate forces (p, 3, K): write what is left (nk, 3, K) for the retained nodes, and keep the way (G, n, ..)."""
    for g in range(len(near.group)):
        lane, first, count, number = near.group[g]
        x = swept[g]
        x[...] = 0.0
        factors.put(near.number, near.place, force, lane, first, count, x)
        factors.forward(near.columns, near.pointer, near.row, near.lower[number], near.inverse[number], x)
        factors.take(inside, near.eliminated + inside, x, lane, first, count, left)


@njit
def _up(near, inside, retained, swept, motion):
    """Write the motions (p, 3, K) from those of the retained nodes (nk, 3, K) and what `_down` kept."""
    for g in range(len(near.group)):
        lane, first, count, number = near.group[g]
        x = swept[g]
        factors.put(inside, near.eliminated + inside, retained, lane, first, count, x)
        factors.backward(near.columns, near.pointer, near.row, near.lower[number], x)
        factors.take(near.number, near.place, x, lane, first, count, motion)


@njit
def _product(yielding, motion, out):
    """Add D times motions (p, 3, K) to out (p, 3, K); both are folded, see `FourierPattern`."""
    for a in yielding.axis:
        for m in yielding.ones:
            motion[a, 1, m] = -motion[a, 0, m]
    room = kernels.scratch(yielding.soil.waves.shape[1])
    for e in yielding.elements:
        kernels.element_product(yielding.soil, e, yielding.regime[e], yielding.tangent[e], motion, out, room)
    for a in yielding.axis:
        for m in yielding.ones:
            out[a, 0, m] -= out[a, 1, m]
    for a in range(len(out)):
        for i in range(3):
            for m in range(out.shape[2]):
                if yielding.held[a, i, m]:
                    out[a, i, m] = 0.0
