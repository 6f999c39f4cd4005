# SPDX-License-Identifier: MIT
"""What the paths of one run share, and what has been computed so far."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from fe_engine.assembly.bordered import Residual
from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.clock import Clock
from fe_engine.solve.newton import Newton
from fe_engine.solve.stage import Balance, FactorStage
from fe_engine.state import State
from pysprings.core.progress import Progress
from pysprings.core.words import StopReason
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.run_record import PathFigures
from pysprings.model.build import Built
from pysprings.model.fourier import BuiltFourier

if TYPE_CHECKING:
    from pysprings.scene.load import Scene


@dataclass
class Work:
    """A run on its way.

    Attributes
    ----------
    paths, figures : datasets by group of the result, and figures by path, of the paths that have ended.
    failures, warnings : sentences for the record.
    stopped : why the run ended before its paths did.
    condition : estimate of the condition of the last matrix.
    stiffness : (3, 3) of half the caisson at the initial state.
    resumed : time and place of each continuation.
    state : of the path that ran last.
    """

    scene: Scene
    built: Built | BuiltFourier
    system: System | FourierSystem
    newton: Newton
    clock: Clock
    progress: Progress
    checkpoints: Checkpoints | None = None
    paths: dict[str, xr.Dataset] = field(default_factory=dict)
    figures: dict[str, PathFigures] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    stopped: StopReason | None = None
    condition: float | None = None
    stiffness: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    resumed: list[dict[str, str]] = field(default_factory=list)
    state: State | None = None

    @property
    def vertical_load(self) -> float:
        """Vertical load of the whole caisson in N, positive down; the number behind "balanced"."""
        return 2.0 * (self.built.balanced_load + self.built.extra_load)

    def cost(self) -> dict[str, Any]:
        """Return the cost of the run so far, as a checkpoint keeps it."""
        assert self.checkpoints is not None
        solver = self.newton.solver
        return {
            "phases": {"wall": self.clock.wall, "cpu": self.clock.cpu},
            "solver": [solver.n_factorisations, solver.n_solves, solver.worst_residual],
            "condition": self.condition,
            "checkpoints": [self.checkpoints.written, self.checkpoints.spent],
            "resumed": self.resumed,
        } | self.checkpoints.elapsed()

    def go_on_from(self, cost: dict[str, Any]) -> None:
        """Count on from the cost of the parts of a run before this one."""
        assert self.checkpoints is not None
        solver = self.newton.solver
        for name, before in cost["phases"].items():
            mine: dict[str, float] = getattr(self.clock, name)
            for phase, seconds in before.items():
                mine[phase] = mine.get(phase, 0.0) + seconds
        solver.n_factorisations += cost["solver"][0]
        solver.n_solves += cost["solver"][1]
        solver.worst_residual = max(solver.worst_residual, cost["solver"][2])
        self.checkpoints.go_on_from(cost["wall_s"], cost["cpu_s"], *cost["checkpoints"])
        self.condition, self.resumed = cost["condition"], cost["resumed"]


# --- one factorisation and solve, timed ---

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
