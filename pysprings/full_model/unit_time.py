# SPDX-License-Identifier: MIT
"""The unit in which run times are compared between machines: one factorisation and solve of the run's own tangent."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from fe_engine.assembly.bordered import Residual
from fe_engine.solve.newton import Newton
from fe_engine.solve.stage import Balance, FactorStage
from fe_engine.state import State

REPEATS = 3
_LOOSE = 1.0e9  # share of a residual that no iteration is needed for


def factorise_and_solve_seconds(newton: Newton, state: State) -> float:
    """Return the wall time [s] of factorising the tangent at a committed state and solving as an iteration does.

    The median of three, without assembly and symbolic analysis. Time step as in the last increment.
    """
    state.reset_trial()
    _, linear, tangent = newton.system.linearise(state, True)
    if isinstance(newton.stage, FactorStage):
        newton.close()
        once: Callable[[], object] = partial(_factorise_and_solve, newton.stage, linear, tangent)
    else:
        still = Balance(np.eye(len(newton.scale)), np.eye(len(newton.scale)), *3 * [newton.scale])
        once = partial(newton.stage.step, linear, tangent, still, _LOOSE, True)
    once()  # analyses the pattern
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        once()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def _factorise_and_solve(stage: FactorStage, linear: Residual, tangent: Any) -> None:
    stage.solver.factorise(tangent.matrix)
    stage.solver.solve(np.column_stack([-linear.free, tangent.columns]))
