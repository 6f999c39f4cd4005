# SPDX-License-Identifier: MIT
"""Water around the paper's caisson: undrained and drained limits, no checkerboard, balance of the water.

Stiffness: elastic soil, incompressible water, K_N = K_T = 1e11 N/m3, a skirt of 1 mm, contact closed; the tangent of
the lid centre for a time step in which nothing flows. The reference is the same soil with nu -> 0.5 and the same G,
bonded to a skirt of no thickness: 3,541 MN/m under a free-head pull, from axisymmetric elements of order 4 and from
mixed elements at nu = 0.5 exactly (axisymmetric.py beside this package gives the former).
"""

from functools import cache

import numpy as np
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.linear.solver import LinearSolver
from fe_engine.mesh import Mesh
from fe_engine.settings import Settings
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.model.build import build_model
from pysprings.model.stages import path_stages
from pysprings.model.water import undrained_time
from pysprings.scene.sections import PAPER
from tests.support import tiny
from tests.verification.cases.undrained_column import checkerboard
from tests.verification.rows import Row

# K_H, K_C, K_M, K_free in MN and m at nu = 0.5, G = 200 MPa/2.6, 24 x 12 m, roller
UNDRAINED = {"K_H": 4747.4, "K_C": -10968.6, "K_M": 99721.0, "K_free": 3541.0}
UNITS = {"K_H": "MN/m", "K_C": "MN", "K_M": "MN m", "K_free": "MN/m"}
_SOURCE = "axisymmetric FE, mixed, nu = 0.5, thickness 0"
_NEVER = 1.0e12  # s: everything has flowed


@cache
def stiffness(
    preset: str, mode: str = "coupled", penalty: float = 1e11, time: float | None = None, **drainage: object
) -> dict[str, float]:
    """Stiffness of the whole caisson in MN and m over a time step (s); None: one in which nothing flows."""
    scene = tiny.sand(
        domain=PAPER,
        mesh={"preset": preset, "discretisation": "hex8"}, soil={"yield_surface": "elastic"},
        caisson={"skirt_thickness": 1e-3},
        interface={"normal_stiffness": penalty, "shear_stiffness": penalty, "friction_coefficient": 5.0},
        drainage={"mode": mode, "water_bulk_modulus": "incompressible", **drainage},
    )  # fmt: skip
    built = build_model(scene)
    system = System(built.model)
    system.time_step = undrained_time(scene, built.model.mesh) if time is None else time
    solver = LinearSolver("auto", system.pattern.n_free, equilibrate=True)
    k = 2e-6 * Newton(system, solver, Settings()).border_stiffness(State(built.model))
    solver.close()
    return {"K_H": k[0, 0], "K_C": k[0, 2], "K_M": k[2, 2], "K_free": k[0, 0] - k[0, 2] * k[2, 0] / k[2, 2]}


@cache
def rows() -> tuple[Row, ...]:
    """Stiffness on the medium mesh, checkerboard and drained limit on the coarse one."""
    slow, drained = (stiffness("medium", **given)["K_free"] for given in ({"time": _NEVER}, {"mode": "drained"}))
    off = Row.error(
        _case("medium"), "K_free, slowly, over drained, less 1", slow / drained - 1.0, "ours, drained", 1e-6
    )
    return (*stiffness_rows("medium"), off, *checkerboard_rows(), *drained_limit_rows())


@cache
def slow_rows() -> tuple[Row, ...]:
    """Stiffness on the paper mesh."""
    return tuple(stiffness_rows("paper"))


def stiffness_rows(preset: str) -> list[Row]:
    """Undrained limit beside its reference."""
    case, fast = _case(preset), stiffness(preset)
    return [
        Row(case, f"{name}, at once", UNITS[name], value, UNDRAINED[name], _SOURCE, 0.02 if name == "K_free" else 0.03)
        for name, value in fast.items()
    ]


def share_rows() -> tuple[Row, ...]:
    """What takes away from the undrained stiffness on the medium mesh: shown, not judged."""
    fast = stiffness("medium")["K_free"]
    # the stabilisation's softening is linear in its factor to first order
    half = stiffness("medium", stabilisation=0.5)["K_free"]
    shown = {
        "of the stabilisation": fast / (2.0 * half - fast) - 1.0,
        "of K_N = K_T = 1e10 N/m3": stiffness("medium", penalty=1e10)["K_free"] / fast - 1.0,
        "of water with 2.2 GPa": stiffness("medium", water_bulk_modulus=2.2e9)["K_free"] / fast - 1.0,
    }
    case = f"{_case('medium')}, shares"
    return tuple(Row(case, f"share {name} in K_free", "", value, 0.0, "ours", None) for name, value in shown.items())


def _case(preset: str) -> str:
    return f"elastic caisson with water, {preset} mesh"


def push(mode: str, rate: float, end: float, drainage: dict | None = None, **sections: dict) -> xr.Dataset:
    """The paper's caisson pulled at the lid centre on the coarse mesh."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "rate": rate}
    scene = tiny.sand(
        domain=PAPER,
        mesh={"preset": "coarse", "discretisation": "hex8"}, drainage={"mode": mode, **(drainage or {})}, paths=[path],
        output={"figures": False}, **sections,
    )  # fmt: skip
    return compute(scene).recorded()["paths/pull"].to_dataset()


def checkerboard_rows() -> list[Row]:
    """First step of 1e-3 s at k = 1e-12 m/s, with and without the stabilisation."""
    rows, quantity = [], "checkerboard of p over its rms"
    variants = (("", 1e-12, 1.0), (", without the stabilisation", 1e-12, 0.0), (", k 0.01 m/s: water flows", 1e-2, 1.0))
    for words, conductivity, factor in variants:
        scene = tiny.sand(
        domain=PAPER,
            mesh={"preset": "coarse", "discretisation": "hex8"}, soil={"hydraulic_conductivity": conductivity},
            drainage={"mode": "coupled", "stabilisation": factor},
        )  # fmt: skip
        pressure, mesh = first_step(scene, 0.02e-3, 1e-3)
        measure = checkerboard(mesh, pressure / np.sqrt(np.mean(pressure**2)))
        tolerance = 0.15 if factor else None
        rows.append(Row("caisson, k 1e-12 m/s, step 1e-3 s", quantity + words, "", measure, 0.0, "smooth", tolerance))
    return rows


def first_step(scene: Scene, u: float, time: float) -> tuple[np.ndarray, Mesh]:
    """Pressures of the mesh nodes (Pa) after one step of the lid centre by u (m) in a time (s), and the mesh."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": u, "duration": time}
    scene = scene.replace(paths=[path], solver={"first_step_fraction": 1.0, "max_step_fraction": 1.0})
    built = build_model(scene)
    system = System(built.model)
    newton = Newton(system, LinearSolver("auto", system.pattern.n_free, equilibrate=True), Settings())
    driver = Driver(newton, State(built.model))
    driver.run(path_stages(scene, scene.paths[0], 0.0)[0], lambda _: None)
    newton.solver.close()
    mesh = built.model.mesh
    return driver.state.committed.pressure[: mesh.n_nodes], mesh


def drained_limit_rows() -> list[Row]:
    """A push ten thousand times slower than the paper's is drained; the paper's balances its water."""
    rate, end = 0.05e-3, 2.5e-3
    drained, slow, paper = push("drained", rate, end), push("coupled", 1e-4 * rate, end), push("coupled", rate, end)
    fast, undrained = push("coupled", 1e4 * rate, end), push("undrained", rate, end)
    moved = (np.abs(paper["water_imbalance"][1:]) / paper["water_moved"][1:]).max()
    case = "drained push, coarse, to 2.5 mm, with water"
    return [
        Row.error(case, "H at a rate 1e4 times slower, over drained, less 1", _last(slow) / _last(drained) - 1.0,
                  "ours, drained", 1e-3),
        Row.error(case, "H at a rate 1e4 times faster, over undrained, less 1", _last(fast) / _last(undrained) - 1.0,
                  "ours, undrained", 0.02),
        Row.error(case, "water: imbalance over what has moved, largest", float(moved), "each term on its own", 1e-8),
        Row(case, "H at 0.05 mm/s over drained", "", _last(paper) / _last(drained), 1.0, "independent run", 0.015),
        Row(case, "H undrained over drained", "", _last(undrained) / _last(drained), 1.0, "shown", None),
    ]  # fmt: skip


def _last(path: xr.Dataset) -> float:
    return float(path["H"][-1])
