# SPDX-License-Identifier: MIT
"""Scene -> what runs it, in the scene's discretisation: model, system, Newton, and what becomes of its states."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import xarray as xr

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.balance.water import WaterBalance
from fe_engine.clock import Clock
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.globalisation import EXACT
from fe_engine.solve.newton import Newton
from pysprings.full_model.collect import Collector, section_dataset
from pysprings.full_model.fourier_collect import FourierCollector, SpaceCollector, fourier_section_dataset
from pysprings.full_model.volume import fourier_volume_dataset, volume_dataset
from pysprings.model.build import Built
from pysprings.model.fourier import BuiltFourier

if TYPE_CHECKING:
    from pysprings.full_model.work import Whole, Work
    from pysprings.scene.model import Scene


@dataclass(frozen=True)
class Engine:
    """A system and what solves it."""

    system: System | FourierSystem
    newton: Newton


def make_engine(scene: Scene, built: Built | BuiltFourier, clock: Clock) -> Engine:
    """Make a built model ready to run. Raises LinearSolverError."""
    settings = Settings(scene.solver.tolerance, scene.solver.max_iterations)
    if isinstance(built, BuiltFourier):
        series = FourierSystem(built.model, clock)
        return Engine(series, Newton(series, FourierStage(series, clock), settings))
    bricks = System(built.model, clock)
    wet, symmetric = built.model.water is not None, built.model.symmetric
    solver = LinearSolver(scene.solver.linear, bricks.pattern.n_free, clock, wet, symmetric)
    if scene.drainage.mode == "undrained":  # volumes hardly change: a small residual does not bound the pressures
        settings = replace(settings, shares=(EXACT, EXACT))
    return Engine(bricks, Newton(bricks, solver, settings))


def make_collector(
    scene: Scene, on: Work | Whole, balance: WaterBalance | None = None, sea: tuple[float, float] | None = None
) -> Collector | SpaceCollector:
    """Make what gathers the rows of a path on its model."""
    output, built = scene.output, on.built
    requested = output.interface_fields, output.section
    wet = partial(scene.ground.holds_water, mode=scene.drainage.mode)
    if isinstance(built, BuiltFourier):
        if built.model.whole:
            return SpaceCollector(built, lambda state: on.system.gaps(state), output.interface_fields)
        assert isinstance(on.system, FourierSystem)
        return FourierCollector(built, on.system, *requested, balance, sea, output.paraview, wet)
    assert isinstance(on.system, System)
    return Collector(built, on.system, *requested, balance, sea, output.paraview, wet)


def section_of(built: Built | BuiltFourier) -> xr.Dataset:
    """Return the symmetry plane of the mesh."""
    return fourier_section_dataset(built) if isinstance(built, BuiltFourier) else section_dataset(built)


def volume_of(built: Built | BuiltFourier) -> xr.Dataset:
    """Return nodes and cells of the whole half model."""
    return fourier_volume_dataset(built) if isinstance(built, BuiltFourier) else volume_dataset(built)
