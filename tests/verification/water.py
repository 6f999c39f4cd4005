# SPDX-License-Identifier: MIT
"""Pore water for the small models: what fills them, stages that take time, and states along a run."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from fe_engine.elements import biot
from fe_engine.elements.interface import Film
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage, Water
from fe_engine.soil import elastic as elastic_law
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State
from tests.verification.blocks import POISSON, YOUNG, block_model, elastic_soil, followers

# Unit weight (N/m3) and viscosity (Pa s) of water, and the paper's sand: 1e-4 m/s
WEIGHT, VISCOSITY = 9.81e3, 1.0e-3
MOBILITY = 1.0e-4 / WEIGHT
# Duration of a sudden load, in units of the time that consolidation takes
SUDDEN = 1.0e-9


def elastic(poisson: float = POISSON) -> Material:
    """Linear elasticity with the paper's Young's modulus."""
    return Material(elastic_law.LAW, elastic_law.pack(YOUNG, poisson))


def shear_modulus(poisson: float = POISSON) -> float:
    """G in Pa."""
    return YOUNG / (2.0 * (1.0 + poisson))


def oedometric_modulus(poisson: float = POISSON) -> float:
    """Stiffness in one-dimensional compression in Pa."""
    return YOUNG * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))


def consolidation_time(length: float, poisson: float = POISSON, mobility: float = MOBILITY) -> float:
    """Seconds in a time factor of 1: L2/c with c = k E_oed/gamma_w, for incompressible water."""
    return length**2 / (mobility * oedometric_modulus(poisson))


def fill(
    model: Model,
    held: np.ndarray,
    mobility: float = MOBILITY,
    initial: np.ndarray | float = 0.0,
    film: Film | None = None,
    stabilisation: float | None = None,
    poisson: float = POISSON,
    storage: float = 0.0,
) -> None:
    """Fill a model with water, incompressible unless a storage is given.

    Parameters
    ----------
    held : (n + nf,) bool, mesh nodes before film nodes: where the pressure stays at its initial value.
    initial : (n + nf,) Pa or one value for all; stabilisation : 1/Pa, the tool's if not given; storage : 1/Pa.
    """
    shear, oedometric = shear_modulus(poisson), oedometric_modulus(poisson)
    if stabilisation is None:
        stabilisation = biot.projection_factor(oedometric - 4.0 * shear / 3.0, shear)
    first = model.mesh.nodes[model.mesh.hexes[0]]
    model.water = Water(
        mobility=mobility, storage=storage, stabilisation=stabilisation,
        fixed=held, initial=np.broadcast_to(np.asarray(initial, dtype=float), held.shape).copy(),
        scale=shear / float(np.linalg.norm(first[1] - first[0])), film=film,
    )  # fmt: skip


def oedometer(mesh: Mesh) -> tuple[Model, np.ndarray]:
    """Box on a smooth base between smooth walls; its top z = 0, (n,) bool, moves down with border dof 0."""
    fixed = (mesh.nodes == 0.0) | (mesh.nodes == mesh.nodes.max(axis=0))
    top = mesh.nodes[:, 2] == 0.0
    fixed[top, 2] = False
    model = block_model(mesh, elastic_soil(), fixed, 1)
    model.followers = followers(np.flatnonzero(top), 2, 0)
    return model, top


def timed(stage: Stage, duration: float, steps: int = 1) -> Stage:
    """The stage in a time (s), in equal steps."""
    return replace(stage, duration=duration, first_fraction=1.0 / steps, max_fraction=1.0 / steps)


def follow(newton: Newton, stages: Iterable[Stage]) -> Iterator[tuple[State, Step]]:
    """Run stages from the initial state; give the committed state and the last step after each."""
    state = State(newton.system.model)
    driver = Driver(newton, state)
    for stage in stages:
        steps: list[Step] = []
        driver.run(stage, steps.append)
        yield state, steps[-1]


def consolidation(load: Stage, unit: float, plan: dict[float, int], refine: int = 1) -> list[Stage]:
    """A sudden load, then stages that hold it up to each time factor.

    ``plan`` gives the number of equal steps that lead to each time factor, ``refine`` multiplies them; ``unit``
    is the time (s) in a time factor of 1.
    """
    times = np.diff([0.0, *plan]) * unit
    held = [timed(load, time, refine * steps) for time, steps in zip(times, plan.values(), strict=True)]
    return [timed(load, SUDDEN * unit), *held]


def implicit_decay(rate: np.ndarray, steps: Iterable[float]) -> np.ndarray:
    """What backward Euler with these steps leaves of modes that decay as exp(-rate T): exact in space."""
    left = np.ones_like(rate)
    for step in steps:
        left /= 1.0 + rate * step
    return left
