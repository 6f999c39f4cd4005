# SPDX-License-Identifier: MIT
"""The unit in which run times are compared between machines: one factorisation and solve of the run's own tangent."""

from __future__ import annotations

import time

import numpy as np

from fe_engine.newton import Newton
from fe_engine.state import State

REPEATS = 3


def factorise_and_solve_seconds(newton: Newton, state: State) -> float:
    """Return the wall time [s] of factorising the tangent at a committed state and solving as an iteration does.

    The median of three, without assembly and symbolic analysis. Time step as in the last increment.
    """
    state.reset_trial()
    _, linear, tangent = newton.system.linearise(state, True)
    rhs = np.column_stack([-linear.free, tangent.columns])
    times = []
    if newton.recycled is not None:
        newton.recycled.close()
    newton.solver.factorise(tangent.matrix)  # analyses the pattern
    for _ in range(REPEATS):
        start = time.perf_counter()
        newton.solver.factorise(tangent.matrix)
        newton.solver.solve(rhs)
        times.append(time.perf_counter() - start)
    return float(np.median(times))
