# SPDX-License-Identifier: MIT
"""Pore water's part of p along sequences: what the elements do, drained over several times.

In coupled sets the elements carry soil and water together. The water's part of p, of each side and depth, is linear in
elastic motions of the elements that relax as a Maxwell body does, each with several relaxation times T_k,

    p_water = sum_k W_k z_k,   dz_k/dt = de/dt - z_k/T_k:

pressure that the motion builds up, and that drains in the meantime. It is a part of p: it adds nothing to the load. In
undrained springs no time passes. W comes from a ridge regression over the ways of the calibration, and over those at
other rates: at one rate alone, what drains and what yields look alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.memory.relaxation import carried, relaxed
from pysprings.macro.memory.ridge import ridge_fit

Array = NDArray[np.float64]

# Relaxation times, over that of a ray to the reach: none is much longer than the ways, which would not determine it
TIMES = (0.0015, 0.015, 0.15, 1.5)
RIDGE = 1e-2  # of the largest singular value of the regressors


@dataclass(frozen=True, slots=True)
class Water:
    """Water's part of p from elastic motions of elements.

    Attributes
    ----------
    factors : (rows, times, 2 n) W [N/m2], a row for each side and depth.
    times : (times, n) T [s] of each element.
    """

    factors: Array
    times: Array

    @property
    def rest(self) -> Array:
        """State z (times, 2 n) [m] at rest."""
        return np.zeros(self.factors.shape[1:])

    def along(self, e: Array, time: Array, start: Array, state: Array) -> Array:
        """Return p_water (rows, n) [N/m] at times (n,) [s] after the start, and change the state z.

        e (n, elements, 2) [m]; start (elements, 2): that at 0 s.
        """
        out = np.zeros((len(self.factors), len(e)))
        carried(*_from(start, e, time), np.repeat(self.times, 2, axis=1), self.factors, state, out)
        return out


def _from(start: Array, e: Array, time: Array) -> tuple[Array, Array]:
    """Return elastic motions (n + 1, 2 elements) and times (n + 1,) with the start at 0 s in front."""
    return np.concatenate([start[None], e]).reshape(len(e) + 1, -1), np.concatenate([[0.0], time])


def water_of(e: Sequence[Array], p_water: Sequence[Array], time: Sequence[Array], longest: float) -> Water:
    """Return the water of ways: elastic motions (n, elements, 2), p_water (rows, n) and times (n,) [s] of each.

    longest: time [s] of a ray to the reach; 0 where none drains. Errors are relative to the largest p_water of a way.
    """
    n = e[0].shape[1]
    times = np.repeat((longest or 1.0) * np.array(TIMES)[:, None], n, axis=1)
    X, Y, weights = [], [], []
    for own, known, t in zip(e, p_water, time, strict=True):
        z, size = np.empty((len(t), len(TIMES), 2 * n)), float(np.abs(known).max())
        relaxed(*_from(np.zeros((n, 2)), own, t), np.repeat(times, 2, axis=1), z)
        X.append(z.reshape(len(t), -1))
        Y.append(known.T)
        weights.append(np.full(len(t), 1.0 / np.sqrt(len(t)) / (size or np.inf)))
    factors = ridge_fit(np.concatenate(X), np.concatenate(Y), np.concatenate(weights), RIDGE)
    return Water(factors.reshape(len(factors), len(TIMES), 2 * n), times)
