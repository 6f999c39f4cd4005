# SPDX-License-Identifier: MIT
"""Bodies in Tresca clay that are no caissons: a disc on the surface (Fourier series), a pile in a slice of bricks."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.contact import adhesion
from fe_engine.elements import fourier as elements, rigid
from fe_engine.elements.interface import Stations, local_frames, nodal_stations
from fe_engine.fourier_model import FourierModel, RingStations
from fe_engine.linear.solver import LinearSolver
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage
from fe_engine.settings import Settings
from fe_engine.soil import mobilised, tresca
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State
from pysprings.model.fourier import nodal_rings
from pysprings.model.mesh import graded
from tests.support.fourier_models import section

SU, RIGIDITY, POISSON = 10.0e3, 167.0, 0.49
PENALTY = 1000.0  # K D/G


def clay(strength: np.ndarray | float) -> Material:
    """Tresca with a constant G/su."""
    young = 2.0 * (1.0 + POISSON) * RIGIDITY * np.asarray(strength)
    return Material(tresca.LAW, mobilised.pack(young, POISSON, strength))


@dataclass(frozen=True)
class Disc:
    """A rigid disc of diameter 1 m on clay whose strength is SU (1 + kappa z); edge cells of 1/cells."""

    cells: float
    kappa: float = 0.0
    rough: bool = True
    harmonics: int = 0


def disc_model(disc: Disc) -> FourierModel:
    """Return the disc, bonded, on a cylinder of soil of 3 m radius and 2 m depth; gravity plays no part."""
    n, size = round(disc.cells / 4), 1.0 / disc.cells
    under = 0.5 - graded(0.0, 0.5, n, size)[::-1]
    outside = graded(0.5, 3.0, round(1.4 * n), size)
    under[0] = 0.0
    mesh = section(np.concatenate([under, outside[1:]]), graded(0.0, 2.0, round(1.4 * n), size))
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    fixed[mesh.node_sets["side"], 0] = True
    fixed[mesh.node_sets["bottom"]] = True
    azimuths, law_azimuths = elements.azimuths(disc.harmonics + 1), disc.harmonics + 3
    stations = _disc_stations(mesh.nodes, mesh.node_sets["top"], azimuths)
    depth = elements.gauss_positions(mesh.nodes, mesh.quads)[:, :, 1]
    kn = PENALTY * RIGIDITY * SU
    contact = adhesion.pack(kn, kn, 0.0, SU if disc.rough else 0.0, np.inf)
    return FourierModel(
        mesh, disc.harmonics, law_azimuths, [clay(SU * (1.0 + disc.kappa * depth))],
        np.zeros(mesh.n_elements, dtype=np.int64), np.zeros((mesh.n_elements, 4 * law_azimuths, 6)), fixed, 3,
        np.array([1.0, 1.0, 0.5]), stations, contact[None], np.zeros(len(stations)), contact_laws=(adhesion.LAW,),
    )  # fmt: skip


def _disc_stations(nodes: np.ndarray, top: np.ndarray, azimuth: np.ndarray) -> RingStations:
    under = top[nodes[top, 0] <= 0.5 + 1e-9]
    under = under[np.argsort(nodes[under, 0])]
    strip = nodal_rings(nodes[under, 0])
    under, strip = under[1:], strip[1:]  # none on the axis, where it has no area
    node, angle = np.repeat(under, len(azimuth)), np.tile(azimuth, len(under))
    r = nodes[node, 0]
    position = np.stack([r * np.cos(angle), r * np.sin(angle), 0.0 * r], axis=1)
    frame = local_frames(np.tile([0.0, 0.0, 1.0], (len(node), 1)))
    return RingStations(
        position, frame, np.repeat(strip, len(azimuth)) * np.pi / len(azimuth), node[:, None],
        np.ones((len(node), 1)), rigid.in_plane(position, np.zeros(3)),
        np.zeros(len(node), dtype=np.int64), angle,
    )  # fmt: skip


@cache
def disc_factor(disc: Disc, imposed: str = "w") -> float:
    """Return V/(A SU) at the limit of a disc pressed down, or H/(A SU) of one pushed aside ("u")."""
    model = disc_model(disc)
    system, state = FourierSystem(model), State(model)
    driver = Driver(Newton(system, FourierStage(system), Settings(1e-5, 25)), state)
    target = np.array([0.1 if name == imposed else 0.0 for name in ("u", "w", "rotation")])
    stage = Stage("push", np.eye(3), target, np.eye(3), np.zeros(3), first_fraction=2e-3, max_fraction=0.2)
    steps: list[Step] = []
    driver.run(stage, steps.append)
    return 2.0 * float(steps[-1].multipliers[np.flatnonzero(target)[0]]) / (0.25 * np.pi * SU)


def disc_moment(disc: Disc, share: float) -> float:
    """Return M/(A D SU) at the limit of a disc that turns under V = share V_ult, V_ult that of its own mesh."""
    model = disc_model(disc)
    system, state = FourierSystem(model), State(model)
    driver = Driver(Newton(system, FourierStage(system), Settings(1e-4, 25)), state)
    nothing, area = np.zeros((0, 3)), 0.25 * np.pi
    dead = np.array([0.0, 0.5 * share * disc_factor(replace(disc, harmonics=0)) * area * SU, 0.0])
    stages = [
        Stage("V", nothing, np.zeros(0), nothing.T, dead, first_fraction=0.1, max_fraction=0.25),
        Stage("turn", np.eye(3)[2:], np.array([0.2]), np.eye(3)[:, 2:], dead, first_fraction=1e-3, max_fraction=0.2),
    ]
    steps: list[Step] = []
    for stage in stages if share else stages[1:]:
        steps.clear()
        driver.run(stage, steps.append)
    return 2.0 * float(steps[-1].multipliers[0]) / (area * SU)


@dataclass(frozen=True)
class Pile:
    """A pile of diameter 1 m in a slice of clay, pushed sideways; ``around`` cells of the half ring."""

    around: int
    alpha: float


def pile_model(pile: Pile) -> tuple[Model, float]:
    """Return the slice, bricks one element thick between smooth planes, bonded to the pile, and its thickness (m)."""
    cell = 0.5 * np.pi / pile.around
    radius = graded(0.5, 6.0, round(0.75 * pile.around), 0.5 * cell)
    angle = np.linspace(0.0, np.pi, pile.around + 1)
    r, a, z = (x.ravel() for x in np.meshgrid(radius, angle, [0.0, cell], indexing="ij"))
    nodes = np.stack([r * np.cos(a), r * np.sin(a), z], axis=1)
    number = np.arange(len(nodes)).reshape(len(radius), len(angle), 2)
    low, high = slice(None, -1), slice(1, None)
    corners = [number[i, j, k] for k in (0, 1) for i, j in ((low, low), (high, low), (high, high), (low, high))]
    wall = np.stack([number[0, low, 0], number[0, high, 0], number[0, high, 1], number[0, low, 1]], axis=-1)
    mesh = Mesh(nodes, np.stack(corners, axis=-1).reshape(-1, 8))
    fixed = np.zeros(nodes.shape, dtype=bool)
    fixed[:, 2] = True
    fixed[np.abs(nodes[:, 1]) < 1e-9, 1] = True
    fixed[r > 6.0 - 1e-9] = True
    normals = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1)
    node, normal, area = nodal_stations(nodes, wall, normals)
    position = nodes[node]
    stations = Stations(
        position, local_frames(normal), area, np.repeat(node[:, None], 4, axis=1),
        np.tile([1.0, 0.0, 0.0, 0.0], (len(node), 1)), rigid.in_plane(position, np.zeros(3)),
        np.zeros(len(node), dtype=np.int64),
    )  # fmt: skip
    kn = PENALTY * RIGIDITY * SU
    model = Model(
        mesh, [clay(SU)], np.zeros(mesh.n_elements, dtype=np.int64), np.zeros((mesh.n_elements, 8, 6)), fixed,
        n_border=3, border_scale=np.ones(3), stations=stations,
        contact=adhesion.pack(kn, kn, 0.0, pile.alpha * SU, np.inf)[None], initial_pressure=np.zeros(len(node)),
        contact_laws=(adhesion.LAW,),
    )  # fmt: skip
    return model, cell


@cache
def pile_factor(pile: Pile) -> float:
    """Return the load at the limit over SU, diameter and thickness."""
    model, thickness = pile_model(pile)
    system = System(model)
    newton = Newton(system, LinearSolver("auto", system.pattern.n_free), Settings(1e-5, 25))
    driver = Driver(newton, State(model))
    stage = Stage("push", np.eye(3), np.array([0.12, 0.0, 0.0]), np.eye(3), np.zeros(3), (1.0,), 2e-3, 0.2)
    steps: list[Step] = []
    driver.run(stage, steps.append)
    return 2.0 * float(steps[-1].multipliers[0]) / (SU * thickness)
