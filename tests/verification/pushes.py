# SPDX-License-Identifier: MIT
"""Pushes of the paper's drained caisson at model level, with copies of the state where a case wants to look."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from fe_engine import interface, rigid
from fe_engine.assembly import System
from fe_engine.interface import Stations
from fe_engine.linear import LinearSolver
from fe_engine.newton import Newton, Settings
from fe_engine.state import Fields, State
from fe_engine.stepping import Driver, Step
from pysprings import Scene
from pysprings.build import SURFACE, Built, build_model
from pysprings.caisson_mesh import SURFACES
from pysprings.stages import path_stage


@dataclass(frozen=True)
class Push:
    """A run: the model, its system, copies of the state at the displacements (m) asked for, and the record."""

    built: Built
    system: System
    at: dict[float, Fields]
    driver: Driver

    @property
    def stations(self) -> Stations:
        """Stations of the interface."""
        assert self.built.model.stations is not None
        return self.built.model.stations


def push_scene(end: float, stops: tuple[float, ...] = (), **sections: dict) -> Scene:
    """The paper's caisson pulled at the lid centre to ``end`` (m), on the coarse mesh unless sections say else."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "report_at": stops}
    return Scene(**({"mesh": {"preset": "coarse"}} | sections | {"paths": [path]}))


def push(scene: Scene, gauss: bool = False) -> Push:
    """Run the first path of a scene; keep the state at its stops. ``gauss`` puts 2x2 stations on every face."""
    built = build_model(scene)
    if gauss:
        put_gauss_stations(built, scene)
    system = System(built.model)
    solver = LinearSolver(scene.solver.linear, system.pattern.n_free)
    newton = Newton(system, solver, Settings(scene.solver.tolerance, scene.solver.max_iterations))
    driver = Driver(newton, State(built.model))
    path = scene.paths[0]
    stage = path_stage(scene, path, built.extra_load)
    kept: dict[float, Fields] = {}

    def keep(step: Step) -> None:
        if step.fraction in stage.stops:
            kept[round(step.fraction * path.lateral_displacement, 12)] = deepcopy(driver.state.committed)

    driver.run(stage, keep)
    solver.close()
    return Push(built, system, kept, driver)


def put_gauss_stations(built: Built, scene: Scene) -> None:
    """Replace the stations of a model by 2x2 Gauss points on every interface face."""
    model = built.model
    parts = []
    for name in SURFACES:
        found = interface.gauss_stations(model.mesh.nodes, model.mesh.face_sets[name])
        parts.append((*found, np.full(len(found[0]), SURFACE[name])))
    nodes, weight, normal, area, surface = (np.concatenate(column) for column in zip(*parts, strict=True))
    position = np.einsum("sa,sai->si", weight, model.mesh.nodes[nodes])
    model.stations = Stations(
        position=position, frame=interface.local_frames(normal), area=area, nodes=nodes, weight=weight,
        body=rigid.displacement_operator(position, np.zeros(3)), surface=surface,
    )  # fmt: skip
    model.initial_pressure = initial_pressure(scene, position)


def initial_pressure(scene: Scene, position: np.ndarray) -> np.ndarray:
    """Isotropic initial effective stress (Pa) at positions (k, 3) of a scene with K0 = 1."""
    assert scene.soil.K0 == 1.0
    return scene.soil.surcharge + scene.soil.effective_unit_weight * position[:, 2]
