# SPDX-License-Identifier: MIT
"""Flow along an interface: parallel plates, a wedge, and a channel that leaks into its sides.

With the transmissivity h3/(12 mu) (cubic law: Witherspoon et al. 1980; Cerfontaine et al. 2018, Eqs. 5 and 10):

plates : a plunger at one end lifts at a known speed and draws the water q per width through the channel:
    dp/dx = 12 mu q/h3. The flow is known from the plunger, so that the transmissivity is measured, not put in.
wedge : one side has turned, the aperture grows from one end to the other; steady flow: p' h3 = constant.
leaky channel : held at p0 at one end, closed at the other, n sides without pressure behind T_w:
    p = p0 cosh((L - x)/l)/cosh(L/l),  l = sqrt(h3/(12 mu T_w n)).
distorted film : with the pressure held on its rim, a film of irregular faces finds a linear pressure exactly.
"""

from functools import cache

import numpy as np

from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage
from tests.verification.balls import faces_on
from tests.verification.blocks import block_model, box, elastic_soil, imposed, make_newton
from tests.verification.cases.patch import distorted, split
from tests.verification.films import Interface, lay_film
from tests.verification.rows import Row, fitted_rate, worst
from tests.verification.water import VISCOSITY, fill, follow, timed

WIDTH = 0.1
P0 = 10.0e3
TRANSFER = 1.0e-8
DOWN = np.array([[0.0], [0.0], [1.0]])
_LUBRICATION = "cubic law"


def bed(mesh: Mesh) -> Model:
    """Soil that does not move, with one border dof for what lies on it."""
    return block_model(mesh, elastic_soil(), np.ones(mesh.nodes.shape, dtype=bool), 1)


def make_bed(cells: int, length: float) -> tuple[Model, np.ndarray]:
    """A strip of bed along x, with the faces of its surface z = 0."""
    mesh = box((cells, 1, 1), (length, WIDTH, WIDTH))
    return bed(mesh), faces_on(mesh, mesh.nodes[:, 2] == 0.0)


def still(model: Model, held: np.ndarray) -> np.ndarray:
    """Where pressures are held: all of the soil, and ``held`` in the film."""
    return np.concatenate([np.ones(model.mesh.n_nodes, dtype=bool), held])


def film_pressure(model: Model, laid: Interface, held: np.ndarray, initial: np.ndarray, *stages: Stage) -> np.ndarray:
    """Pressure (nf,) in Pa after the stages, in soil without pressure."""
    fill(model, still(model, held), initial=np.concatenate([np.zeros(model.mesh.n_nodes), initial]), film=laid.film)
    *_, (state, _) = follow(make_newton(model), stages)
    return state.committed.pressure[model.mesh.n_nodes :]


@cache
def rows() -> tuple[Row, ...]:
    """Parallel plates, wedge, leaky channels of one and two sides, patch of the film."""
    return (*_plates(), *_wedge(), *_leaky(1), *_leaky(2), *_rate(), _patch())


def _plates() -> list[Row]:
    """A plunger, the stations at x = 0, draws water through 1 mm from x = 1 m."""
    aperture, length, speed = 1.0e-3, 1.0, 1.0e-5
    model, faces = make_bed(10, length)
    at = model.mesh.nodes[np.unique(faces), 0]
    motion = np.where(at[:, None, None] == 0.0, DOWN, 0.0)
    laid = lay_film(model, faces, aperture, 0.0, pressure=0.0, motion=motion)
    lift = timed(imposed([-1.0e-11]), 1.0e-11 / speed)
    pressure = film_pressure(model, laid, at == length, np.zeros(len(at)), lift)
    flow = speed * laid.area[at == 0.0].sum() / WIDTH
    drop = -pressure[at == 0.0].mean()
    line = worst(pressure, -drop * (1.0 - at / length))
    exact = aperture**3 / (12.0 * VISCOSITY)
    case = "parallel plates, 1 mm"
    return [
        Row(case, "flow per width over dp/dx", "m3/(Pa s)", flow * length / drop, exact, _LUBRICATION, 0.005),
        Row.error(case, "largest error of the linear pressure", line, _LUBRICATION, 1e-7),
    ]


def _wedge() -> list[Row]:
    """Aperture from 0.5 mm at x = 0 to 1.5 mm at x = 1 m, opened slowly, then left alone."""
    narrow, slope, length = 0.5e-3, 1.0e-3, 1.0
    model, faces = make_bed(50, length)
    at = model.mesh.nodes[np.unique(faces), 0]
    laid = lay_film(model, faces, narrow, 0.0, pressure=0.0, motion=at[:, None, None] * DOWN)
    held = (at == 0.0) | (at == length)
    stages = timed(imposed([-slope]), 1.0), timed(imposed([-slope]), 1.0)
    pressure = film_pressure(model, laid, held, np.where(at == 0.0, P0, 0.0), *stages)
    resistance = narrow**-2 - (narrow + slope * at) ** -2
    exact = P0 * (1.0 - resistance / resistance.max())
    middle = np.isclose(at, 0.2 * length)
    case = "wedge, 0.5 to 1.5 mm"
    return [
        Row(case, "p/p0 at a fifth of the length", "", pressure[middle].mean() / P0, exact[middle].mean() / P0,
            _LUBRICATION, 0.005),
        Row.error(case, "largest error of p/p0", worst(pressure, exact), _LUBRICATION, 0.005),
    ]  # fmt: skip


def decay_length(aperture: float, sides: int) -> float:
    """Length l in m over which the pressure of a leaky channel decays."""
    return float(np.sqrt(aperture**3 / (12.0 * VISCOSITY * TRANSFER * sides)))


def leaky_channel(aperture: float, sides: int, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """p/p0 of a channel of three decay lengths and what it should be, by film node; two sides are soil and soil."""
    decay = decay_length(aperture, sides)
    length = 3.0 * decay
    if sides == 1:
        model, faces = make_bed(cells, length)
        laid = lay_film(model, faces, aperture, TRANSFER, motion=DOWN)
    else:
        flat, faces, _, twin = split(box((cells, 1, 2)))
        model = bed(Mesh(flat.nodes * [length, WIDTH, WIDTH], flat.hexes))
        laid = lay_film(model, faces, aperture, TRANSFER, twin=twin)
    at = laid.position[:, 0]
    pressure = film_pressure(model, laid, at == 0.0, np.where(at == 0.0, P0, 0.0), timed(imposed([0.0]), 1.0))
    return pressure / P0, np.cosh((length - at) / decay) / np.cosh(length / decay)


def _leaky(sides: int) -> list[Row]:
    found = []
    for aperture in (1.0e-4, 1.0e-3):
        pressure, exact = leaky_channel(aperture, sides, 60)
        case = f"leaky channel, {1e3 * aperture:g} mm, {sides} side{'s' * (sides - 1)}"
        # the decay length that the pressure at the closed end tells
        length = 3.0 * decay_length(aperture, sides) / np.arccosh(1.0 / pressure.min())
        found += [
            Row(case, "decay length", "m", length, decay_length(aperture, sides), _LUBRICATION, 0.005),
            Row.error(case, "largest error of p/p0", worst(pressure, exact), _LUBRICATION, 0.005),
        ]
    return found


def _rate() -> list[Row]:
    cells = (8, 16, 32)
    error = [np.subtract(*leaky_channel(1.0e-4, 1, n)).max() for n in cells]
    rate = fitted_rate(1.0 / np.array(cells), error)
    return [Row("leaky channel, 0.1 mm, 1 side", "order in h of the error of p", "", rate, 2.0, "second order", 0.1)]


def _patch() -> Row:
    """Irregular faces, pressure held on the rim."""
    mesh = distorted((4, 4, 3), keep_levels=True)
    flat = mesh.nodes[:, 2] == 0.0
    inside = flat & ((mesh.nodes[:, :2] > 1e-9) & (mesh.nodes[:, :2] < 1.0 - 1e-9)).all(axis=1)
    mesh.nodes[inside, :2] += np.random.default_rng(3).uniform(-0.06, 0.06, (np.count_nonzero(inside), 2))
    model = bed(mesh)
    laid = lay_film(model, faces_on(mesh, flat), 1.0e-4, 0.0, motion=DOWN)
    exact = P0 * (0.2 + laid.position @ [0.7, -0.4, 0.0])
    rim = ~np.isin(laid.nodes, np.flatnonzero(inside))
    pressure = film_pressure(model, laid, rim, np.where(rim, exact, 0.0), timed(imposed([0.0]), 1.0))
    return Row.error("film of irregular faces", "largest error of a linear pressure", worst(pressure, exact),
                     "patch test", 1e-10)  # fmt: skip
