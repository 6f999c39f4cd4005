# SPDX-License-Identifier: MIT
"""Pushes of the paper's drained caisson at model level, with copies of the state where a case wants to look."""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.elements import interface, rigid
from fe_engine.elements.interface import Stations
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import Fields, State
from pysprings import Scene
from pysprings.full_model.collect import Collector
from pysprings.model.build import Built, build_model
from pysprings.model.contact import SURFACE
from pysprings.model.mesh import SURFACES
from pysprings.model.stages import path_stages
from pysprings.scene.sections import PAPER
from tests.support import tiny
from tests.support.models import gauss_stations


@dataclass(frozen=True)
class Stop:
    """A converged state, and the load that holds it: (H, V, M) of the whole caisson at the lid centre, N and m."""

    state: Fields
    load: np.ndarray


@dataclass(frozen=True)
class Push:
    """A run: the model, its system, the stops by displacement (m), the steps with their states, and the driver."""

    built: Built
    system: System
    at: dict[float, Stop]
    steps: list[Step]
    states: list[Fields]
    driver: Driver

    @property
    def stations(self) -> Stations:
        """Stations of the interface."""
        assert self.built.model.stations is not None
        return self.built.model.stations

    @property
    def end(self) -> Stop:
        """The last state."""
        return self.at[max(self.at)]

    def dataset(self) -> xr.Dataset:
        """Initial state and stops as the tool stores a path; needs the tool's own stations."""
        collector = Collector(self.built, self.system, True, False)
        for state in (State(self.built.model).committed, *(self.at[u].state for u in sorted(self.at))):
            collector.add(state, 0.0)
        return collector.dataset()


def push_scene(end: float, stops: tuple[float, ...] = (), **sections: dict) -> Scene:
    """The paper's caisson pulled at the lid centre to ``end`` (m), on the coarse mesh unless sections say else."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "report_at": stops}
    mesh = {"preset": "coarse", "discretisation": "hex8"} | sections.pop("mesh", {})
    return tiny.sand(**({"domain": PAPER} | sections | {"mesh": mesh, "paths": [path]}))


def push(scene: Scene, gauss: bool = False, facets: bool = True) -> Push:
    """Run the first path of a scene; keep the state at its stops.

    ``gauss`` puts 2x2 stations on every face instead of the tool's nodal ones, with the normals of the flat facets
    or those of the circle.
    """
    built = build_model(scene)
    assert not built.extra_load
    if gauss:
        put_gauss_stations(built, scene, facets)
    system = System(built.model)
    solver = LinearSolver(scene.solver.linear, system.pattern.n_free)
    newton = Newton(system, solver, Settings(scene.solver.tolerance, scene.solver.max_iterations))
    driver = Driver(newton, State(built.model))
    path = scene.paths[0]
    stage = path_stages(scene, path, 0.0)[0]
    kept: dict[float, Stop] = {}
    steps: list[Step] = []
    states: list[Fields] = []

    def keep(step: Step) -> None:
        steps.append(step)
        states.append(deepcopy(driver.state.committed))
        if step.fraction in stage.stops:
            load = 2.0 * (stage.load @ step.multipliers + step.fraction * stage.force)
            kept[round(step.fraction * path.lateral_displacement, 12)] = Stop(states[-1], load)

    driver.run(stage, keep)
    solver.close()
    return Push(built, system, kept, steps, states, driver)


def put_gauss_stations(built: Built, scene: Scene, facets: bool) -> None:
    """Replace the stations of a model by 2x2 Gauss points on every interface face."""
    model = built.model
    parts = []
    for name in SURFACES:
        found = gauss_stations(model.mesh.nodes, model.mesh.face_sets[name])
        parts.append((*found, np.full(len(found[0]), SURFACE[name])))
    nodes, weight, normal, area, surface = (np.concatenate(column) for column in zip(*parts, strict=True))
    position = np.einsum("sa,sai->si", weight, model.mesh.nodes[nodes])
    if not facets:
        normal, area = _circle_normals(position, normal, area)
    model.contact = model.contact[model.stations.surface == SURFACE["outer"]][:1]
    model.stations = Stations(
        position=position, frame=interface.local_frames(normal), area=area, nodes=nodes, weight=weight,
        body=rigid.in_plane(position, np.zeros(3)), surface=surface,
    )  # fmt: skip
    model.initial_pressure = initial_pressure(scene, position)


def _circle_normals(position: np.ndarray, normal: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radial normals on the walls, and the areas projected on them."""
    wall = np.abs(normal[:, 2]) < 0.5
    radial = position * [1.0, 1.0, 0.0]
    radial /= np.linalg.norm(radial, axis=1)[:, None]
    cosine = np.einsum("si,si->s", radial, normal)
    exact = np.where(wall[:, None], np.sign(cosine)[:, None] * radial, normal)
    return exact, np.where(wall, np.abs(cosine) * area, area)


def initial_pressure(scene: Scene, position: np.ndarray) -> np.ndarray:
    """Isotropic initial effective stress (Pa) at positions (k, 3) of a scene with K0 = 1."""
    assert scene.soil.K0 == 1.0
    return scene.soil.surcharge + scene.soil.effective_unit_weight * position[:, 2]
