# SPDX-License-Identifier: MIT
"""Flow across an interface, into a film and out of it through the transversal conductivity T_w of each side.

two sides of soil : T_w/2 between the faces; L1 gamma_w/k + 2/T_w + L2 gamma_w/k through a column
rigid side, film and soil : conductance 1/(1/T_w + gamma_w L/k) from the film to the far end of the soil; T_w = 1e-8
    m/(Pa s) resists as 1.02 m of the paper's sand does
sealed gap : a body lifted at v off soil needs the water v through T_w and the soil: suction v/T_w, and v gamma_w L/k
    more over the length L of the soil
closed interface with water under pressure : it takes the load off the contact, p_N = p'_N + p_w

(Cerfontaine et al. 2018, Eqs. 6-8, in steady state.) Flows are taken from the gradient of the pressure in the soil.
"""

from functools import cache

import numpy as np

from fe_engine.model import Model, Stage
from tests.verification.balls import faces_on
from tests.verification.blocks import block_model, box, elastic_soil, imposed, loaded, make_newton
from tests.verification.cases.patch import split
from tests.verification.films import CLOSED, KN, Interface, lay_film
from tests.verification.rows import Row
from tests.verification.water import MOBILITY, fill, follow, oedometric_modulus, timed

TRANSFER, SPEED, P0 = 1.0e-8, 0.05e-3, 10.0e3
LENGTH, WIDTH = 1.0, 0.1
# As printed in the reference table: suction over T_w, and over a metre of the paper's sand (Pa); length of sand (m)
OVER_FILM, OVER_SAND, EQUIVALENT = 5.0e3, 4.9e3, 1.02
DOWN = np.array([[0.0], [0.0], [1.0]])
# Long enough for a steady state (s)
STEADY = 1.0e9
_SOURCE = "resistances in series"


def _solve(model: Model, laid: Interface, held: np.ndarray, initial: np.ndarray, stage: Stage) -> np.ndarray:
    """Pressures (n + nf,) in Pa after a stage."""
    fill(model, held, initial=initial, film=laid.film)
    ((state, _),) = follow(make_newton(model), [stage])
    return state.committed.pressure


@cache
def rows() -> tuple[Row, ...]:
    """Two sides in series, film and soil in series, suction under a lifted body, uplift by water in a closed film."""
    return (*_two_sides(), *_film_and_soil(), *_sealed_gap(), *_uplift())


def _flux(z: np.ndarray, pressure: np.ndarray, first: float, last: float) -> float:
    """Flow per area, m/s, along z in the soil between two depths."""
    inside = (z >= first) & (z <= last)
    return -MOBILITY * float(np.polyfit(z[inside], pressure[inside], 1)[0])


def _two_sides() -> list[Row]:
    """A column cut at z = 0.5 m, p0 on its top and none at its base."""
    mesh, faces, _, twin = split(box((1, 1, 8)))
    model = block_model(mesh, elastic_soil(), np.ones(mesh.nodes.shape, dtype=bool), 1)
    laid = lay_film(model, faces, 1.0e-5, TRANSFER, twin=twin)
    n, z = mesh.n_nodes, mesh.nodes[:, 2]
    held = np.concatenate([(z == 0.0) | (z == 1.0), np.zeros(laid.film.n_nodes, dtype=bool)])
    initial = np.concatenate([np.where(z == 0.0, P0, 0.0), np.zeros(laid.film.n_nodes)])
    found = _solve(model, laid, held, initial, timed(imposed([0.0]), STEADY))
    upper, lower = found[twin[laid.nodes]].mean(), found[laid.nodes].mean()
    flux = _flux(z[1:n], found[1:n], 0.51, 1.0)
    above = _flux(z, found[:n], 0.0, 0.49)
    whole = 1.0 / (1.0 / MOBILITY + 2.0 / TRANSFER)
    case = "across a film between two soils"
    return [
        Row(case, "flow over pressure drop, face to face", "m/(Pa s)", flux / (upper - lower), TRANSFER / 2.0,
            _SOURCE, 0.005),
        Row(case, "flow over pressure drop, end to end", "m/(Pa s)", flux / P0, whole, _SOURCE, 0.005),
        Row(case, "pressure in the film over the mean of its faces", "", 2.0 * found[n:].mean() / (upper + lower), 1.0,
            _SOURCE, 0.005),
        Row(case, "flow into the film over flow out of it", "", above / flux, 1.0, "mass", 1e-6),
    ]  # fmt: skip


def column(pressure: float, free: bool) -> tuple[Model, Interface]:
    """A column of soil, free to move or not, below a rigid body that moves down with border dof 0."""
    mesh = box((1, 1, 8), (WIDTH, WIDTH, LENGTH))
    fixed = np.ones(mesh.nodes.shape, dtype=bool)
    fixed[:, 2] = (mesh.nodes[:, 2] == LENGTH) | (not free)
    model = block_model(mesh, elastic_soil(), fixed, 1)
    faces = faces_on(mesh, mesh.nodes[:, 2] == 0.0)
    return model, lay_film(model, faces, 1.0e-5, TRANSFER, pressure, motion=DOWN)


def _film_and_soil() -> list[Row]:
    """p0 held in the film, none at the base of the soil."""
    model, laid = column(CLOSED, free=False)
    n, z = model.mesh.n_nodes, model.mesh.nodes[:, 2]
    held = np.concatenate([z == LENGTH, np.ones(laid.film.n_nodes, dtype=bool)])
    initial = np.where(np.arange(len(held)) < n, 0.0, P0)
    found = _solve(model, laid, held, initial, timed(imposed([0.0]), STEADY))
    flux = _flux(z, found[:n], 0.0, LENGTH)
    case = "from a film through soil"
    conductance = 1.0 / (1.0 / TRANSFER + LENGTH / MOBILITY)
    over_film = P0 - found[laid.nodes].mean()
    sand = over_film / (found[laid.nodes].mean() / LENGTH)
    return [
        Row(case, "flow over pressure drop", "m/(Pa s)", flux / P0, conductance, _SOURCE, 0.005),
        Row(case, "length of sand that resists as the film's side", "m", sand, EQUIVALENT, _SOURCE, 0.005),
    ]


def _sealed_gap() -> list[Row]:
    """The body is lifted off deformable soil that drains at its base only, for 27 times its consolidation time.

    The suction of the film pulls the soil up as it pulls the body down.
    """
    model, laid = column(0.0, free=True)
    n, z = model.mesh.n_nodes, model.mesh.nodes[:, 2]
    held = np.concatenate([z == LENGTH, np.zeros(laid.film.n_nodes, dtype=bool)])
    fill(model, held, film=laid.film)
    ((state, step),) = follow(make_newton(model), [timed(imposed([-10.0 * SPEED]), 10.0, 20)])
    found = state.committed.pressure
    surface = found[laid.nodes].mean()
    suction = SPEED / TRANSFER + SPEED * LENGTH / MOBILITY
    heave = (suction - 0.5 * SPEED * LENGTH / MOBILITY) * LENGTH / oedometric_modulus()
    case = "body lifted at 0.05 mm/s, sealed gap"
    return [
        Row(case, "suction over T_w", "Pa", surface - found[n:].mean(), OVER_FILM, _SOURCE, 0.005),
        Row(case, "suction per metre of sand", "Pa", -surface / LENGTH, OVER_SAND, _SOURCE, 0.005),
        Row(case, "force on the body", "N", -step.multipliers[0], suction * WIDTH**2, "suction times area", 0.005),
        Row(case, "heave of the soil", "m", -state.committed.displacement[laid.nodes, 2].mean(), heave,
            "effective stress = suction of the film less that of the pores", 0.005),
    ]  # fmt: skip


def _uplift() -> list[Row]:
    """Water under pressure in a closed interface takes over its share of the body's weight; the body rises a little."""
    model, laid = column(CLOSED, free=True)
    held = np.ones(model.mesh.n_nodes + laid.film.n_nodes, dtype=bool)
    fill(model, held, initial=np.where(np.arange(len(held)) < model.mesh.n_nodes, 0.0, P0), film=laid.film)
    ((state, _),) = follow(make_newton(model), [timed(loaded([0.0]), 1.0)])
    case = "water under pressure in a closed interface"
    contact = -state.committed.traction[:, 0].mean()
    return [
        Row(case, "loss of effective contact pressure", "Pa", CLOSED - contact, P0, "p_N = p'_N + p_w", 1e-9),
        Row(case, "rise of the body", "m", -state.committed.border[0], P0 / KN, "p_w/K_N", 1e-9),
    ]
