# SPDX-License-Identifier: MIT
"""Models that carry what a scene leaves out, and a push of a model."""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_engine.assembly.system import System
from fe_engine.clock import Clock
from fe_engine.contact import coulomb
from fe_engine.linear.solver import LinearSolver
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.settings import Recycling, Settings
from fe_engine.soil import plasol
from fe_engine.solve.newton import Newton
from pysprings import Scene
from pysprings.full_model.paths import PathRun
from pysprings.full_model.run_record import COMPLETE
from pysprings.full_model.work import Work
from pysprings.model.build import Built, build_model, build_on
from pysprings.model.mesh import CaissonMesh
from pysprings.scene.sections import PAPER, PAPER_SOIL

# Steps that do not depend on how Newton does: two models then go the same way.
STEPS = {"first_step_fraction": 0.25, "max_step_fraction": 0.25, "tolerance": 1e-9, "max_iterations": 40}
SMOOTH: dict[str, Any] = {"soil": {"yield_surface": "elastic"}, "interface": {"friction_coefficient": 0.0}}


def scene(end: float = 0.5e-3, rate: float | None = None, **sections: Any) -> Scene:
    """Return a scene of 216 nodes in equal steps, pulled to ``end`` (m) at a rate (m/s)."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "rate": rate}
    small: dict[str, Any] = {
        "mesh": {"refinement": 0.4, "discretisation": "hex8"},
        "output": {"figures": False},
        "solver": STEPS,
    }
    return Scene(**small, domain=PAPER, soil=PAPER_SOIL, paths=(path,)).replace(**sections)


@dataclass(frozen=True)
class Pushed:
    """The first path of a scene on some model: rows of every step, final state, unknowns, and what it took (s)."""

    run: PathRun
    unknowns: int
    factorisations: int
    cpu: float
    clock: Clock

    @property
    def rows(self) -> dict[str, np.ndarray]:
        """Every recorded quantity (steps, ...)."""
        rows = self.run.collector.rows
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}


OWN = Recycling(start=10**9)  # every model factorises its own tangents, however large: only what is carried differs


def push(scene: Scene, built: Built | None = None, symmetric: bool | None = None) -> Pushed:
    """Run the first path of a scene on a model (the scene's own unless given).

    ``symmetric`` decides whether half of each factorisation is left out (None: as in the model).
    """
    built = build_model(scene) if built is None else built
    start, clock = time.process_time(), Clock()
    system, model = System(built.model, clock), built.model
    half = model.symmetric if symmetric is None else symmetric
    solver = LinearSolver(scene.solver.linear, system.pattern.n_free, clock, model.water is not None, half)
    newton = Newton(system, solver, Settings(scene.solver.tolerance, scene.solver.max_iterations, recycling=OWN))
    run = PathRun(Work(scene, built, newton, clock, lambda *_: None), scene.paths[0])
    run.run()
    newton.close()
    assert run.ending == COMPLETE, run.ending.failure
    cpu = time.process_time() - start
    return Pushed(run, system.pattern.n_free + model.n_border, solver.n_factorisations, cpu, clock)


def difference(one: Pushed, other: Pushed, names: tuple[str, ...] = (), last: bool = False) -> dict[str, float]:
    """Return the largest difference of each quantity over all steps, or at the last one, over the largest value it has.

    Loads of any part count beside the load H, reactions by depth beside p, shear beside the normal stress, moments with
    an arm of 1 m: where there are none, they are rounding alone.
    """
    mine, theirs = one.rows, other.rows
    beside = {"H": "H", "V": "H", "M": "H", "m": "p", "t": "p", "shear": "normal_effective_stress"}
    largest = {}
    for name in names or tuple(mine):
        a, b = (rows[name][-1:] if last else rows[name] for rows in (mine, theirs))
        assert a.shape == b.shape, name
        floor = mine[beside.get(name.split("_")[0], name)]
        size = max(np.abs(part).max() for part in (a, b, floor))
        largest[name] = float(np.abs(a - b).max() / size) if size > 0.0 else 0.0
    return largest


# --- both halves ---


def whole_model(scene: Scene) -> Built:
    """Return the model of the whole domain; its border forces are those of the whole caisson.

    Of an elastic caisson it has all nodes and unknowns, but no steel where the ring closes: to be counted, not run.
    """
    built = build_on(scene, mirrored(build_model(scene).caisson))
    if built.steel is None:
        return built
    fixed = built.model.fixed.copy()
    fixed[np.setdiff1d(built.steel.symmetry, built.steel.held), 1] = False
    return replace(built, model=replace(built.model, fixed=fixed))


def mirrored(half: CaissonMesh) -> CaissonMesh:
    """Return a half mesh with its mirror image in y = 0 beside it; nodes of the plane are shared, and free."""
    mesh, n = half.mesh, half.mesh.n_nodes
    off = np.flatnonzero(np.abs(mesh.nodes[:, 1]) > 1e-12)
    image = np.arange(n)
    image[off] = n + np.arange(len(off))
    nodes = np.concatenate([mesh.nodes, mesh.nodes[off] * [1.0, -1.0, 1.0]])
    # a mirror turns elements inside out: their corners go round the other way
    hexes = np.concatenate([mesh.hexes, image[mesh.hexes][:, [0, 3, 2, 1, 4, 7, 6, 5]]])
    faces = {name: np.concatenate([f, image[f][:, [0, 3, 2, 1]]]) for name, f in mesh.face_sets.items()}
    sets = {name: np.unique(np.concatenate([ids, image[ids]])) for name, ids in mesh.node_sets.items()}
    sets["symmetry"] = np.zeros(0, dtype=np.int64)
    walls = {side: np.concatenate([wall, image[wall[-2:0:-1]]]) for side, wall in half.walls.items()}
    azimuth = np.concatenate([half.azimuth, 2.0 * np.pi - half.azimuth[-2:0:-1]])
    return replace(half, mesh=Mesh(nodes, hexes, sets, faces), walls=walls, azimuth=azimuth)


# --- what else a model may carry ---


def with_history(scene: Scene) -> Built:
    """Return a model of elastoplastic soil that is too strong to yield, in place of an elastic one."""
    built, soil = build_model(scene), scene.soil
    strong = plasol.pack(
        young=soil.young_modulus, poisson=soil.poisson_ratio, phi_i=soil.friction_angle_initial,
        phi_f=soil.friction_angle_final, b_phi=soil.hardening_parameter, psi=0.0, cohesion=1e12,
    )  # fmt: skip
    return replace(built, model=replace(built.model, materials=[Material(plasol.LAW, strong)]))


def with_shear(scene: Scene, friction: float = 1e-9) -> Built:
    """Return a model whose stations have friction, though next to none, in place of a smooth one."""
    built = build_model(scene)
    contact = built.model.contact.copy()
    contact[:, coulomb.MU] = friction
    return replace(built, model=replace(built.model, contact=contact))


def with_water_in_steel(scene: Scene) -> Built:
    """Return a model of an elastic caisson with a pressure of its own on the caisson's side of the film.

    Steel does not conduct: what the film presses across the transfer T_w into its face has nowhere to go.
    """
    built = build_model(scene)
    water, stations, n_soil = built.model.water, built.model.stations, built.caisson.mesh.n_nodes
    assert water is not None and water.film is not None and stations is not None
    fixed = water.fixed.copy()
    touched = np.unique(stations.nodes[stations.weight < 0.0])
    assert fixed[touched].all() and touched.min() >= n_soil
    fixed[touched] = False
    wet = replace(water, fixed=fixed, film=replace(water.film, sealed=False))
    return replace(built, model=replace(built.model, water=wet))
