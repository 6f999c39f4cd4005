# SPDX-License-Identifier: MIT
"""Small Fourier models that the engine's tests share."""

from dataclasses import replace

import numpy as np

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.contact import coulomb
from fe_engine.elements import fourier as elements, rigid
from fe_engine.elements.interface import local_frames
from fe_engine.fourier_model import FourierModel, LinearRings, RingFilm, RingStations, SectionMesh, SeriesWater
from fe_engine.settings import Settings
from fe_engine.soil import elastic, plasol
from fe_engine.soil.law import SoilLaw
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from tests.support.models import CONTACT, Run, rotation_matrix, soil


def section(r: np.ndarray, z: np.ndarray) -> SectionMesh:
    """Return the rectangles between lines; sets: side, bottom, top."""
    grid_r, grid_z = (np.sort(np.concatenate([x, 0.5 * (x[1:] + x[:-1])])) for x in (r, z))
    points = np.stack(np.meshgrid(grid_r, grid_z, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(points)).reshape(len(grid_r), len(grid_z))
    a, b = (x.ravel() for x in np.meshgrid(2 * np.arange(len(r) - 1), 2 * np.arange(len(z) - 1), indexing="ij"))
    at = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    quads = np.stack([number[a + i, b + j] for i, j in at], axis=1)
    used = np.unique(quads)
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    sets = {"side": number[-1], "bottom": number[:, -1], "top": number[:, 0]}
    return SectionMesh(points[used], new[quads], {name: new[ids][new[ids] >= 0] for name, ids in sets.items()})


def disc(
    harmonics: int = 2, law: SoilLaw = plasol.LAW, contact: tuple = CONTACT, skew: bool = False,
    pressure: float = 2.0e4, whole: bool = False, lines: tuple[np.ndarray, np.ndarray] | None = None, **changes: float,
) -> FourierModel:  # fmt: skip
    """Return a cylinder of soil (radius 3 m, depth 2 m, roller, fixed base) under a rigid disc of radius 1 m.

    ``skew`` turns the frames of the stations at random, and puts an elastic soil into some elements.
    ``whole``: around the whole circle, with six degrees of freedom. ``lines``: radii and
    depths (m) of another mesh.
    """
    mesh = section(*(lines or (np.array([0.0, 0.5, 1.0, 1.9, 3.0]), np.array([0.0, 0.4, 1.0, 2.0]))))
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    fixed[mesh.node_sets["side"], 0] = True
    fixed[mesh.node_sets["bottom"]] = True
    m, rng = (2 * harmonics + 5 if whole else harmonics + 3), np.random.default_rng(4)
    azimuth = elements.azimuths(2 * harmonics + 1 if whole else harmonics + 1, whole)
    body = rigid.displacement_operator if whole else rigid.in_plane
    top = mesh.node_sets["top"]
    under = top[(mesh.nodes[top, 0] > 0.0) & (mesh.nodes[top, 0] <= 1.0)]
    node, angle = np.repeat(under, len(azimuth)), np.tile(azimuth, len(under))
    r, z = mesh.nodes[node].T
    position = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
    frame = local_frames(np.tile([0.0, 0.0, 1.0], (len(node), 1)))
    if skew:
        frame = np.array([rotation_matrix(tuple(rng.normal(size=3)), 0.4) for _ in node]) @ frame
    stations = RingStations(
        position, frame, 0.3 * r * elements.span(whole) / len(azimuth), node[:, None], np.ones((len(node), 1)),
        body(position, np.zeros(3)), np.zeros(len(node), dtype=np.int64), angle,
    )  # fmt: skip
    n_border = stations.body.shape[2]
    depth = np.repeat(elements.gauss_positions(mesh.nodes, mesh.quads)[:, :, 1], m, axis=1)
    stress = np.zeros((*depth.shape, 6))
    stress[..., :3] = -(pressure + 1.0e4 * depth)[..., None]
    return FourierModel(
        mesh, harmonics, m, [soil(law, **changes), soil(elastic.LAW, young=5.0e7)],
        (np.arange(mesh.n_elements) % 4 == 3).astype(int) * int(skew), stress, fixed, n_border, np.ones(n_border),
        stations, np.tile(coulomb.pack(*contact), (len(node), 1)), np.full(len(node), pressure), whole=whole,
    )  # fmt: skip


def on_plate(model: FourierModel, young: float = 1.0e9, thickness: float = 0.1) -> FourierModel:
    """The disc as an elastic plate (nu 0.3) between the stations and the border; held within half of its radius."""
    soil_nodes, s, n = model.mesh, model.stations, model.mesh.n_nodes
    lines = np.unique(soil_nodes.nodes[s.nodes[:, 0], 0])
    r = np.concatenate([[0.0], lines[1::2]])
    plate = section(r, np.array([-thickness, 0.0]))
    nodes = np.concatenate([soil_nodes.nodes, plate.nodes])
    held = (plate.nodes[:, 0] <= 0.5 * r[-1])[:, None] & np.ones(3, dtype=bool)
    gradient, volume = elements.geometry(plate.nodes, plate.quads)
    tangent = np.broadcast_to(elastic.elastic_matrix(young, 0.3), (*volume.shape, 6, 6))
    matrices = [elements.stiffness(gradient, volume, tangent, k, model.whole) for k in model.numbers]
    under = np.array([n + np.argmin(np.abs(plate.nodes - nodes[k]).sum(axis=1)) for k in s.nodes[:, 0]])
    assert np.abs(nodes[under] - nodes[s.nodes[:, 0]]).max() < 1e-12
    stations = replace(s, nodes=np.stack([s.nodes[:, 0], under], axis=1), weight=np.tile([1.0, -1.0], (len(s), 1)))
    return replace(
        model, mesh=replace(soil_nodes, nodes=nodes), fixed=np.concatenate([model.fixed, held]), stations=stations,
        linear=LinearRings(n + plate.quads, np.array(matrices)),
    )  # fmt: skip


def wet(model: FourierModel, film: bool = True, **changes: float) -> FourierModel:
    """The disc with water: drained around the disc, a film of 0.1 mm below it; changes of mobility, storage, ..."""
    given = {"mobility": 1.0e-9, "storage": 1.0e-10, "aperture": 1.0e-4, "transfer": 1.0e-8} | changes
    mesh = model.mesh
    corner = mesh.corners
    r, z = mesh.nodes[corner].T
    fixed = (z == 0.0) & (r > 1.0)
    under = ring_film(model, given["aperture"], given["transfer"]) if film else None
    if under is not None:
        fixed = np.concatenate([fixed, np.zeros(under.n_nodes, dtype=bool)])
    initial = np.zeros((len(fixed), len(model.numbers)))
    water = SeriesWater(given["mobility"], given["storage"], fixed, initial, 2.0e8, under)
    return replace(model, water=water)


def ring_film(model: FourierModel, aperture: float, transfer: float) -> RingFilm:
    """Return the film along the top of the section, between the axis and the last of the stations."""
    mesh, s = model.mesh, model.stations
    top = mesh.node_sets["top"]
    line = top[mesh.nodes[top, 0] <= mesh.nodes[s.nodes[:, 0], 0].max()]
    corner, place = line[::2], np.argmax(line == s.nodes[:, :1], axis=1)
    ends, station, slope, over_radius, area = [], [], [], [], []
    for k in np.argsort(place, kind="stable"):  # every station once for each of its elements, weights of Simpson
        radius = mesh.nodes[line[place[k]], 0]
        for first in {(place[k] - 1) // 2 * 2, place[k] // 2 * 2} & set(range(0, len(line) - 2, 2)):
            length, i = np.ptp(mesh.nodes[line[[first, first + 2]], 0]), place[k] - first
            ends.append((first // 2, first // 2 + 1))
            station.append(k)
            slope.append((-1.0 / length, 1.0 / length))
            over_radius.append(np.array([1.0 - 0.5 * i, 0.5 * i]) / radius)
            area.append(
                (1.0, 4.0, 1.0)[i] / 6.0 * length * radius * elements.span(model.whole) / len(np.unique(s.azimuth))
            )
    return RingFilm(
        mesh.corner_numbers(corner), np.stack([place // 2, (place + 1) // 2], axis=1), np.full((len(s), 2), 0.5),
        np.array(station), np.array(ends), np.array(slope), np.array(over_radius), np.array(area),
        aperture, transfer, 1.0e-3,
    )  # fmt: skip


def start(model: FourierModel, **settings) -> Run:
    """Return a driver at the initial state of a model."""
    system, state = FourierSystem(model), State(model)
    return Run(Driver(Newton(system, FourierStage(system), Settings(**settings)), state), state, [])


def run(model: FourierModel, *stages, **settings) -> Run:
    """Run stages from the initial state."""
    out = start(model, **settings)
    for each in stages:
        out.driver.run(each, out.steps.append)
    return out


# m of displacement, which opens stations (2e4 Pa over 1e8 N/m3 is 2e-4 m, less with stiffer ones) and shears the sand,
# and of pressure in units of model.water.scale
MOVE, PRESSURE = 4.0e-5, 2.0e-5


def random_move(system: FourierSystem, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return random increments of the free coefficients, and of the border."""
    p, n = system.pattern, system.pattern.n_moving
    free = np.concatenate([MOVE * rng.normal(size=n), PRESSURE * rng.normal(size=p.n_free - n)])
    free[np.concatenate([p.held.ravel(), p.pressure_held.ravel()])] = 0.0
    return free, 3.0 * MOVE * rng.normal(size=system.model.n_border)


def moved(model: FourierModel, seed: int = 0, time: float = 0.0) -> tuple[FourierSystem, State, np.random.Generator]:
    """Return system and state after a committed random move and a trial one, in steps of a time in s."""
    system, state, rng = FourierSystem(model), State(model), np.random.default_rng(seed)
    system.time_step = time
    for commit in (True, False):
        system.apply(state, *random_move(system, rng))
        system.residual(state)
        if commit:
            state.commit()
    return system, state, rng
