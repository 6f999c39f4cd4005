# SPDX-License-Identifier: MIT
"""Elastic motions of elements that relax as a Maxwell body does (jitted, `core.jit`).

z [m] of a relaxation time T [s] along an elastic motion e(t) [m]: dz/dt = de/dt - z/T, exact where e grows evenly
between two points.
"""

from __future__ import annotations

import math

import numpy as np

from pysprings.core.jit import jitted


@jitted
def _relax(before, now, step, times, state):
    """Change the state (k, m) by a step [s] from elastic motions (m,) to others."""
    for k in range(times.shape[0]):
        for j in range(times.shape[1]):
            lost = step / times[k, j]
            kept = math.exp(-lost)
            gained = (1.0 - kept) / lost if lost > 1e-9 else 1.0
            state[k, j] = kept * state[k, j] + gained * (now[j] - before[j])


@jitted
def carried(e, time, start, times, factors, state, out):
    """Write p_water (rows, n) along elastic motions e (n, m); changes the state (k, m)."""
    for i in range(e.shape[0]):
        if i == 0:
            _relax(start, e[0], time[0], times, state)
        else:
            _relax(e[i - 1], e[i], time[i] - time[i - 1], times, state)
        for r in range(out.shape[0]):
            found = 0.0
            for k in range(times.shape[0]):
                for j in range(times.shape[1]):
                    found += factors[r, k, j] * state[k, j]
            out[r, i] = found


@jitted
def relaxed(e, time, times, out):
    """Write z (n, k, m) along elastic motions e (n, m) from rest at 0 s."""
    state, start = np.zeros(times.shape), np.zeros(e.shape[1])
    for i in range(e.shape[0]):
        if i == 0:
            _relax(start, e[0], time[0], times, state)
        else:
            _relax(e[i - 1], e[i], time[i] - time[i - 1], times, state)
        out[i] = state
