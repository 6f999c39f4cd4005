# SPDX-License-Identifier: MIT
"""Answers do not depend on the units they are computed in, the size of the model, or the side that the load comes from.

Each scene is run a second time with every quantity multiplied as its dimension asks: forces F, lengths X, times T.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.linear.solver import LinearSolver
from fe_engine.model import Model
from fe_engine.settings import Settings
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.model.build import build_model
from pysprings.model.stages import path_stages
from tests.support import tiny
from tests.support.models import rotation_matrix, to_matrix, to_voigt

# dimension of each scaled quantity: powers of force, length and time; what is left out has none
DIMENSIONS: dict[str, dict[str, tuple[int, int, int]]] = {
    "caisson": {name: (0, 1, 0) for name in ("outer_diameter", "skirt_length", "skirt_thickness", "lid_thickness")},
    "domain": {"radius": (0, 1, 0), "depth": (0, 1, 0)},
    "soil": {
        "young_modulus": (1, -2, 0),
        "cohesion": (1, -2, 0),
        "effective_unit_weight": (1, -3, 0),
        "surcharge": (1, -2, 0),
        "hydraulic_conductivity": (0, 1, -1),
    },
    "interface": {
        "normal_stiffness": (1, -3, 0),
        "shear_stiffness": (1, -3, 0),
        "transversal_conductivity": (-1, 3, -1),
        "residual_aperture": (0, 1, 0),
    },
    "drainage": {"water_bulk_modulus": (1, -2, 0), "water_unit_weight": (1, -3, 0), "water_viscosity": (1, -2, 1)},
}
COHESIVE = {"cohesion": 2.0e3}
PENALTY = {"normal_stiffness": 1.0e10, "shear_stiffness": 5.0e9}


def scene(mode: str) -> Scene:
    """A tiny pull, far enough to yield, slip and (coupled) flow."""
    rate = {} if mode == "drained" else {"rate": 1e-3}
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 4e-3, "arm": 2.0} | rate
    steps = {"first_step_fraction": 0.01, "max_step_fraction": 0.2, "tolerance": 1e-9}
    return tiny.scene(paths=(path,), drainage={"mode": mode}, soil=COHESIVE, interface=PENALTY, solver=steps)


def scaled(given: Scene, force: float, length: float, time: float) -> Scene:
    """The scene in a world where forces, lengths and times are multiplied."""
    data = given.model_dump()
    for section, quantities in DIMENSIONS.items():
        for name, (f, x, t) in quantities.items():
            data[section][name] *= force**f * length**x * time**t
    path: dict[str, Any] = dict(data["paths"][0])
    path["lateral_displacement"] *= length
    path["arm"] *= length
    if path["rate"] is not None:
        path["rate"] *= length / time
    return Scene.model_validate(data | {"paths": (path,)})


@cache
def path_of(mode: str) -> xr.Dataset:
    found: xr.Dataset = run(scene(mode))["paths/pull"].to_dataset(inherit=False)
    return found


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:layer 'soil'. effective unit weight")  # of other units
@pytest.mark.parametrize(
    ("mode", "force", "length", "time"),
    [("drained", 0.3, 1.0, 1.0), ("drained", 16.0, 4.0, 1.0), ("drained", 3.0, 1.7, 0.2),
     ("coupled", 0.3, 1.0, 1.0), ("coupled", 1.0, 1.0, 30.0), ("coupled", 3.0, 1.7, 0.2)],
)  # fmt: skip
def test_other_units_and_another_size_give_the_same_answer(mode: str, force: float, length: float, time: float) -> None:
    other = run(scaled(scene(mode), force, length, time))["paths/pull"]
    mine = path_of(mode)
    factors = {"u": length, "w": length, "rotation": 1.0, "H": force, "V": force, "M": force * length}
    for name, factor in factors.items():
        expected = factor * mine[name].values
        np.testing.assert_allclose(other[name].values, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())
    np.testing.assert_allclose(
        other["p"].values, force / length * mine["p"].values, rtol=1e-6, atol=1e-3 * force / length
    )


@pytest.mark.parametrize("mode", ["drained", "coupled"])
def test_a_load_from_the_other_side_is_mirrored(mode: str) -> None:
    given = scene(mode)
    path = given.paths[0].model_dump() | {"lateral_displacement": -4e-3}
    other = run(given.replace(paths=(path,)))["paths/pull"]
    mine = path_of(mode)
    for name, sign in {"u": -1, "w": 1, "rotation": -1, "H": -1, "M": -1, "p": -1}.items():
        expected = sign * mine[name].values
        np.testing.assert_allclose(other[name].values, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


def turned(model: Model, turn: np.ndarray) -> Model:
    """The model turned by a rotation (3, 3); u, w and rotation of the body turn with it, and keep their numbers.

    Nodes of the interface have no axes of their own: what is held there (y) has to turn into another axis.
    """
    stations, water, held = model.stations, model.water, model.fixed.copy()
    assert stations is not None
    contact = np.unique(stations.nodes)
    held[contact] = held[contact] @ np.abs(turn.T) > 0.5
    frames = {
        node: model.frames.get(node, np.eye(3)) @ turn.T
        for node in np.setdiff1d(np.arange(model.mesh.n_nodes), contact).tolist()
    }
    stress = np.array([to_voigt(turn @ to_matrix(one) @ turn.T) for one in model.initial_stress.reshape(-1, 6)])
    if water is not None and water.film is not None:
        water = replace(water, film=replace(water.film, gradient=water.film.gradient @ turn.T))
    return replace(
        model, mesh=replace(model.mesh, nodes=model.mesh.nodes @ turn.T), fixed=held, frames=frames, water=water,
        initial_stress=stress.reshape(model.initial_stress.shape),
        stations=replace(
            stations, position=stations.position @ turn.T, frame=stations.frame @ turn.T, body=turn @ stations.body
        ),
    )  # fmt: skip


def steps_of(given: Scene, model: Model) -> list[Step]:
    system, steps = System(model), list[Step]()
    newton = Newton(system, LinearSolver("auto", system.pattern.n_free), Settings(tolerance=1e-9))
    Driver(newton, State(model)).run(path_stages(given, given.paths[0], 0.0)[0], steps.append)
    newton.close()
    return steps


AROUND_Y, TO_THE_NEXT_AXIS = rotation_matrix((0.0, 1.0, 0.0), 1.1), np.eye(3)[[2, 0, 1]]


@pytest.mark.parametrize("mode", ["drained", "coupled"])
@pytest.mark.parametrize("turn", [AROUND_Y, TO_THE_NEXT_AXIS @ AROUND_Y], ids=["in its plane", "out of it"])
def test_a_turned_model_gives_the_turned_answer(mode: str, turn: np.ndarray) -> None:
    """No equation knows where x and z point, once the model is built."""
    given = scene(mode)
    model = build_model(given).model
    mine, other = (steps_of(given, each) for each in (model, turned(model, turn)))
    assert len(mine) == len(other)
    for one, two in zip(mine, other, strict=True):
        np.testing.assert_allclose(two.increment.border, one.increment.border, rtol=1e-6, atol=1e-10)
        np.testing.assert_allclose(two.multipliers, one.multipliers, rtol=1e-7)
    assert {one.increment.record[-1]["n_slip"] for one in mine} != {0}
    assert mine[-1].increment.record[-1]["n_plastic"] > 0


@pytest.mark.slow
def test_half_the_step_is_half_the_error() -> None:
    """Backward Euler: the load at 4 mm with 5, 10, 20 and 40 equal steps; the rate is printed."""
    loads = []
    for steps in (5, 10, 20, 40):
        sizes = {"first_step_fraction": 1 / steps, "max_step_fraction": 1 / steps, "tolerance": 1e-9}
        loads.append(float(run(scene("drained").replace(solver=sizes))["paths/pull"]["H"][-1]))
    changes = np.abs(np.diff(loads))
    rate = float(np.polyfit(np.log([5, 10, 20]), np.log(changes), 1)[0])
    print(f"load at 4 mm [kN]: {', '.join(f'{load / 1e3:.3f}' for load in loads)}; rate of the changes {-rate:.2f}")
    assert 0.7 < -rate < 1.6
    assert changes[-1] < 2e-3 * loads[-1]


@pytest.mark.slow
def test_finer_meshes_come_closer_together() -> None:
    loads = [
        float(run(scene("drained").replace(mesh={"refinement": r}))["paths/pull"]["H"][-1]) for r in (0.4, 0.6, 0.9)
    ]
    assert abs(loads[2] - loads[1]) < 0.7 * abs(loads[1] - loads[0])
    assert loads[2] < loads[1] < loads[0]  # displacement elements are too stiff
