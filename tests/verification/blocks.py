# SPDX-License-Identifier: MIT
"""Small models by hand: boxes of hexahedra, border dofs that drive nodes, and one-line runs."""

from collections.abc import Callable

import numpy as np

from fe_engine.assembly.system import System
from fe_engine.linear.solver import LinearSolver
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage
from fe_engine.settings import Settings
from fe_engine.soil import elastic, plasol, van_eekelen
from fe_engine.soil.law import SoilLaw
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State

YOUNG, POISSON = 200.0e6, 0.3


def box(counts: tuple[int, int, int], lengths: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """Regular box of hexahedra with a corner at the origin; ``counts`` cells and ``lengths`` in m along x, y, z."""
    axes = [np.linspace(0.0, length, n + 1) for n, length in zip(counts, lengths, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    low, high = slice(None, -1), slice(1, None)
    sides = [(low, low), (high, low), (high, high), (low, high)]
    corners = [number[a, b, c] for c in (low, high) for a, b in sides]
    return Mesh(grid.reshape(-1, 3), np.stack(corners, axis=-1).reshape(-1, 8))


def elastic_soil() -> Material:
    """Linear elasticity with the paper's moduli."""
    return Material(elastic.LAW, elastic.pack(YOUNG, POISSON))


def sand(phi_i: float, phi_f: float | None = None, psi: float = 0.0, law: SoilLaw = plasol.LAW) -> Material:
    """Sand with the paper's moduli and B = 0.005; angles in degrees, no cohesion."""
    phi_i, phi_f, psi = np.radians([phi_i, phi_i if phi_f is None else phi_f, psi])
    return Material(law, plasol.pack(YOUNG, POISSON, phi_i, phi_f, 0.005, psi, 0.0))


def van_eekelen_sand(phi_i: float, phi_f: float | None = None, psi: float = 0.0) -> Material:
    """Sand of `sand` with Van Eekelen's surface."""
    return sand(phi_i, phi_f, psi, van_eekelen.LAW)


def block_model(mesh: Mesh, material: Material, fixed: np.ndarray, n_border: int, pressure: float = 0.0) -> Model:
    """Model of one material under an isotropic initial pressure (Pa), driven by border dofs in metres."""
    stress = np.zeros((mesh.n_elements, 8, 6))
    stress[..., :3] = -pressure
    return Model(
        mesh=mesh, materials=[material], material=np.zeros(mesh.n_elements, dtype=np.int64), initial_stress=stress,
        fixed=fixed, n_border=n_border, border_scale=np.ones(n_border),
    )  # fmt: skip


def followers(nodes: np.ndarray, component: int, border: int, weight: float | np.ndarray = 1.0) -> np.ndarray:
    """Rows (k, 4): a component of these nodes moves with a border dof."""
    rows = np.empty((len(nodes), 4))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3] = nodes, component, border, weight
    return rows


def imposed(target: list[float], fractions: tuple[float, ...] = (1.0,), force: list[float] | None = None) -> Stage:
    """Stage that imposes every border dof, in one step between the stops."""
    n = len(target)
    return Stage("imposed", np.eye(n), np.array(target), np.eye(n), np.array(force or [0.0] * n), fractions, 1.0, 1.0)


def loaded(force: list[float]) -> Stage:
    """Stage that imposes no displacement: known forces on every border dof."""
    n = len(force)
    return Stage("loaded", np.zeros((0, n)), np.zeros(0), np.zeros((n, 0)), np.array(force), (1.0,), 1.0, 1.0)


def make_newton(model: Model, tolerance: float = 1e-11, max_iterations: int = 40) -> Newton:
    """Newton on a model, with a tolerance near round-off by default."""
    system = System(model)
    solver = LinearSolver("superlu", system.pattern.n_free)
    return Newton(system, solver, Settings(tolerance, max_iterations))


def run(newton: Newton, *stages: Stage, on_step: Callable[[Step], None] = lambda _: None) -> tuple[State, Driver]:
    """Run stages from the initial state; return the state and the driver with its record."""
    state = State(newton.system.model)
    driver = Driver(newton, state)
    for stage in stages:
        driver.run(stage, on_step)
    return state, driver


def border_force(newton: Newton, state: State) -> np.ndarray:
    """Forces (nb,) in N that hold the border dofs at the committed state."""
    state.reset_trial()
    return newton.system.residual(state).border
