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
