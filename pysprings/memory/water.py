# SPDX-License-Identifier: MIT
"""Pore water's part of p along sequences: what the elements do, drained over several times.

In coupled sets the elements carry soil and water together. The water's part of p, of each side and depth, is linear in
elastic motions of the elements that relax as a Maxwell body does, each with several relaxation times T_k,

    p_water = sum_k W_k z_k,   dz_k/dt = de/dt - z_k/T_k:

pressure that the motion builds up, and that drains in the meantime. It is a part of p: it adds nothing to the load. In
undrained springs no time passes. W comes from a ridge regression over the ways of the calibration, and over those at
other rates: at one rate alone, what drains and what yields look alike.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.jit import jitted


def ridge_fit(X: Array, Y: Array, weights: Array, ridge: float) -> Array:
    """Return the coefficients (columns of Y, columns of X) of a weighted ridge regression.

    ridge: shrinkage, as a share of the largest singular value of the regressors, each of the size 1.
    """
    size = np.linalg.norm(X * weights[:, None], axis=0)
    size = np.where(size > 0.0, size, 1.0)
    U, s, Vt = np.linalg.svd(X * weights[:, None] / size, full_matrices=False)
    shrunk = s / (s**2 + (ridge * s[0]) ** 2)
    return ((Vt.T * shrunk) @ (U.T @ (Y * weights[:, None]))).T / size


@jitted
def _relax(before, now, step, times, state):
    """Change the state (k, m) by a step [s] from elastic motions (m,) to others, exact where they grow evenly in it."""
    for k in range(times.shape[0]):
        for j in range(times.shape[1]):
            lost = step / times[k, j]
            kept = math.exp(-lost)
            gained = (1.0 - kept) / lost if lost > 1e-9 else 1.0
            state[k, j] = kept * state[k, j] + gained * (now[j] - before[j])


@jitted
def carried(e, time, times, factors, state, out):
    """Write p_water (rows, n) at points 1 ... n of elastic motions e (n + 1, m), times (n + 1,); changes the state."""
    for i in range(out.shape[1]):
        _relax(e[i], e[i + 1], time[i + 1] - time[i], times, state)
        for r in range(out.shape[0]):
            found = 0.0
            for k in range(times.shape[0]):
                for j in range(times.shape[1]):
                    found += factors[r, k, j] * state[k, j]
            out[r, i] = found


@jitted
def relaxed(e, time, times, out):
    """Write z (n, k, m) at points 1 ... n of elastic motions e (n + 1, m) from rest, times (n + 1,)."""
    state = np.zeros(times.shape)
    for i in range(out.shape[0]):
        _relax(e[i], e[i + 1], time[i + 1] - time[i], times, state)
        out[i] = state


# Relaxation times, over that of a ray to the reach: none is much longer than the ways, which would not determine it
TIMES = (0.0015, 0.015, 0.15, 1.5)
RIDGE = 1e-2  # of the largest singular value of the regressors


@dataclass(frozen=True, slots=True)
class Water:
    """Water's part of p from elastic motions of elements.

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
