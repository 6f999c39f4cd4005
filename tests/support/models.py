# SPDX-License-Identifier: MIT
"""Small models and helpers that the engine's tests share."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_engine.assembly.system import System
from fe_engine.contact import coulomb
from fe_engine.elements import hex8, rigid
from fe_engine.elements.interface import Film, Stations, face_points, film_geometry, local_frames, nodal_stations
from fe_engine.linear.solver import LinearSolver
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage, Water
from fe_engine.settings import Recycling, Settings
from fe_engine.soil import elastic, iwan_clay, plasol
from fe_engine.soil.law import SoilLaw
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State

DEGREE = np.pi / 180.0
# E (Pa), nu, phi_i, phi_f, B_phi, psi, cohesion (Pa): a sand that hardens and dilates, with a little cohesion
SAND = (2.0e8, 0.3, 5.0 * DEGREE, 30.0 * DEGREE, 0.005, 3.0 * DEGREE, 1.0e3)
CONTACT = (1.0e10, 1.0e10, 0.5)
EARLIER = Recycling(start=0)  # models of any size solve with factors of earlier tangents
OWN = Recycling(start=10**9)  # every tangent is factorised


def taylor_slope(f: Callable, slope: np.ndarray, x: np.ndarray, step: np.ndarray, sizes: np.ndarray) -> float:
    """Order in h of |f(x + h step) - f(x) - h slope step|; infinite where it is rounding at every h.

    A consistent tangent has order 2, a wrong one order 1.
    """
    start, change = f(x), slope @ step
    remainder = np.array([np.linalg.norm(f(x + h * step) - start - h * change) for h in sizes])
    rounding = 1.0e-14 * (np.linalg.norm(start) + sizes * np.linalg.norm(change))
    if np.all(remainder <= 10.0 * rounding):
        return np.inf
    assert np.all(remainder > 10.0 * rounding), "the remainder drowns in rounding: take larger steps"
    return float(np.polyfit(np.log(sizes), np.log(remainder), 1)[0])


def rotation_matrix(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    """Return the rotation (3, 3) about an axis by the right-hand rule (Rodrigues)."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew


def to_matrix(voigt: np.ndarray, shear: float = 1.0) -> np.ndarray:
    """Return the tensor (3, 3) of a Voigt vector xx yy zz xy yz zx; shear = 0.5 for engineering strains."""
    xx, yy, zz = voigt[:3]
    xy, yz, zx = shear * voigt[3:]
    return np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])


def to_voigt(tensor: np.ndarray, shear: float = 1.0) -> np.ndarray:
    """Return the Voigt vector of a symmetric tensor; shear = 2 for engineering strains."""
    t = tensor
    return np.array([t[0, 0], t[1, 1], t[2, 2], shear * t[0, 1], shear * t[1, 2], shear * t[2, 0]])


def box(counts: tuple[int, int, int], size: tuple[float, float, float], distort: float = 0.0) -> Mesh:
    """Return the brick mesh with a corner at the origin; distort moves every node by up to that share of a cell."""
    axes = [np.linspace(0.0, length, n + 1) for n, length in zip(counts, size, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape([n + 1 for n in counts])
    quad = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    hexes = np.stack([q[:, :, :-1] for q in quad] + [q[:, :, 1:] for q in quad], axis=-1).reshape(-1, 8)
    top = np.stack([q[:, :, 0] for q in quad], axis=-1).reshape(-1, 4)
    cell = np.array(size) / counts
    nodes = nodes + distort * cell * np.random.default_rng(7).uniform(-1.0, 1.0, nodes.shape)
    return Mesh(nodes, hexes, face_sets={"top": top})


def all_of(mesh: Mesh, axis: int, value: float) -> np.ndarray:
    """Return the nodes (n,) bool on the plane where a coordinate has a value."""
    return np.abs(mesh.nodes[:, axis] - value) < 1.0e-9


def soil(law: SoilLaw = plasol.LAW, **changes: float) -> Material:
    """Return the material of SAND with some parameters changed; those that the law has."""
    names = ("young", "poisson", "phi_i", "phi_f", "b_phi", "psi", "cohesion")
    values: dict[str, Any] = dict(zip(names, SAND, strict=True)) | {"strength": 2.0e4} | changes
    follows = {"pressure": 1.0e5, "strain": 5.0e-4, "least": 0.2}
    values |= {"phi_c": 33.0 * DEGREE, "density": 0.7, "crushing": 10.0, "exponent": 4.0, "scale": 0.015, "fade": 0.2}
    values |= {"contraction": 0.4, "kappa_0": 0.0}
    values |= {"compression": 2.5e4, "direct_shear": 2.0e4, "extension": 1.2e4}
    values |= {"exponent": 0.5} if law.name == "following" else {}
    values |= {"law": plasol.LAW, "rows": plasol.pack(*(values[name] for name in names))} | follows
    values |= {"backbone": iwan_clay.pack(values["young"], values["poisson"], 2.0e4), "factors": (1.25, 1.0, 0.6)}
    accepted = inspect.signature(law.pack).parameters
    return Material(law, law.pack(**{name: value for name, value in values.items() if name in accepted}))


Placed = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def gauss_stations(nodes: np.ndarray, faces: np.ndarray) -> Placed:
    """Place 2x2 Gauss stations on every face; return nodes (ns, 4), weight (ns, 4), normal (ns, 3), area (ns,)."""
    points = face_points(nodes[faces])
    weight = np.repeat(np.array([p[1] for p in points])[None], len(faces), axis=0).reshape(-1, 4)
    vector = np.stack([p[2] for p in points], axis=1).reshape(-1, 3)
    area = np.linalg.norm(vector, axis=1)
    return np.repeat(faces, 4, axis=0), weight, vector / area[:, None], area


def placed(nodes: np.ndarray, faces: np.ndarray, rule: str) -> Placed:
    """Place stations by a rule, nodal or gauss; return what `gauss_stations` does, with one node a station."""
    if rule == "gauss":
        return gauss_stations(nodes, faces)
    node, normal, area = nodal_stations(nodes, faces)
    return node[:, None], np.ones((len(node), 1)), normal, area


def body_stations(mesh: Mesh, faces: np.ndarray, reference: np.ndarray, rule: str = "nodal") -> Stations:
    """Return the stations of a rigid body on faces whose normals point into the soil."""
    nodes, weight, normal, area = placed(mesh.nodes, faces, rule)
    position = np.einsum("sa,sai->si", weight, mesh.nodes[nodes])
    body = rigid.in_plane(position, reference)
    return Stations(position, local_frames(normal), area, nodes, weight, body, np.zeros(len(area), dtype=np.int64))


def geostatic(mesh: Mesh, surcharge: float, weight: float, k0: float = 1.0) -> np.ndarray:
    """Return the initial stress (ne, 8, 6): vertical -(surcharge + weight z), horizontal k0 times that."""
    vertical = -(surcharge + weight * hex8.gauss_positions(mesh.nodes, mesh.hexes)[:, :, 2])
    zero = np.zeros_like(vertical)
    return np.stack([k0 * vertical, k0 * vertical, vertical, zero, zero, zero], axis=-1)


def footing(material: Material | None = None, contact: tuple = CONTACT, pressure: float = 2.0e4) -> Model:
    """Return a block of soil 3 x 0.5 x 1.5 m (rollers, fixed base) under a rigid footing on x = 1 .. 2 m."""
    mesh = box((6, 1, 3), (3.0, 0.5, 1.5))
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    fixed[all_of(mesh, 0, 0.0) | all_of(mesh, 0, 3.0), 0] = True
    fixed[:, 1] = True
    fixed[all_of(mesh, 2, 1.5)] = True
    top = mesh.face_sets["top"]
    under = np.abs(mesh.nodes[top].mean(axis=1)[:, 0] - 1.5) < 0.5
    stations = body_stations(mesh, top[under], np.array([1.5, 0.0, 0.0]))
    return Model(
        mesh, [material or soil()], np.zeros(mesh.n_elements, dtype=np.int64), geostatic(mesh, pressure, 1.0e4),
        fixed, n_border=3, border_scale=np.array([1.0, 1.0, 1.0]), stations=stations,
        contact=coulomb.pack(*contact)[None], initial_pressure=np.full(len(stations), pressure),
    )  # fmt: skip


def mixed(rule: str = "nodal", skew_stations: bool = False) -> Model:
    """Return a distorted block with everything at once: two laws, skew nodes, followers, fixed dofs, a body, stations.

    Border dofs are the body's (u, w, rotation) and one more that some nodes follow. ``rule`` is nodal, gauss, or
    pairs (a deformable side 2: stations between pairs of nodes).
    """
    counts, size = (3, 2, 2), (3.0, 2.0, 1.5)
    plain, mesh = box(counts, size), box(counts, size, distort=0.12)
    top, rng = all_of(plain, 2, 0.0), np.random.default_rng(11)
    fixed = np.zeros((mesh.n_nodes, 3), dtype=bool)
    fixed[all_of(plain, 2, 1.5)] = True
    skew = all_of(plain, 0, 0.0) & (~top | skew_stations)
    fixed[skew, 0] = True
    frames = {int(n): rotation_matrix(tuple(rng.normal(size=3)), rng.uniform(0.2, 1.0)) for n in np.flatnonzero(skew)}
    followers = [(n, 1, 3, 0.7) for n in np.flatnonzero(all_of(plain, 0, 3.0) & ~top)]
    followers += [(np.flatnonzero(skew)[1], 2, 0, -1.3), (np.flatnonzero(top)[4], 1, 1, 0.5)]
    if rule == "pairs":
        pairs = np.stack([np.flatnonzero(top)[::2], np.flatnonzero(all_of(plain, 2, 0.75) & ~skew)[:-7:-1]], axis=1)
        frame = np.stack([rotation_matrix(tuple(rng.normal(size=3)), 1.0) for _ in pairs])
        stations = Stations(
            np.zeros((6, 3)), frame, rng.uniform(0.1, 1.0, 6), pairs, np.tile([1.0, -1.0], (6, 1)),
            np.zeros((6, 3, 4)), np.arange(6) % 2,
        )  # fmt: skip
    else:
        stations = body_stations(mesh, mesh.face_sets["top"], np.array([1.2, 0.0, -0.3]), rule)
        body = np.concatenate([stations.body, np.zeros((len(stations), 3, 1))], axis=2)
        stations = replace(stations, body=body, surface=np.arange(len(stations)) % 2)
    return Model(
        mesh, [soil(phi_i=0.15), soil(elastic.LAW, young=5.0e7)], np.arange(mesh.n_elements) % 3 // 2,
        geostatic(mesh, 1.0e4, 1.0e4), fixed, frames, np.array(followers), 4, np.array([1.0, 1.0, 2.0, 1.0]),
        stations, np.array([coulomb.pack(1.0e8, 5.0e7, 0.5), coulomb.pack(2.0e8, 1.0e8, 0.3)])[stations.surface],
        rng.uniform(5.0e3, 1.5e4, len(stations)),
    )  # fmt: skip


def stage(controls: dict[int, float], force: tuple = (0.0, 0.0, 0.0), arm: float = 0.0, **options) -> Stage:
    """Return a stage with end values of border dofs, by forces on the same dofs; arm (m) lifts the lateral one."""
    control = np.array([np.eye(3)[i] for i in controls]).reshape(-1, 3)
    load = control.copy()
    load[control[:, 0] == 1.0, 2] = -arm
    return Stage("test", control, np.array(list(controls.values())), load.T, np.array(force), **options)


@dataclass
class Run:
    """A driver with what it committed."""

    driver: Driver
    state: State
    steps: list[Step]


def start(model: Model, linear: str = "superlu", **settings) -> Run:
    """Return a driver at the initial state of a model."""
    system = System(model)
    newton = Newton(system, LinearSolver(linear, system.pattern.n_free), Settings(**settings))
    state = State(model)
    return Run(Driver(newton, state), state, [])


def run(model: Model, *stages: Stage, linear: str = "superlu", **settings) -> Run:
    """Run stages from the initial state."""
    out = start(model, linear, **settings)
    for each in stages:
        out.driver.run(each, out.steps.append)
    return out


def wet(rule: str = "nodal", storage: float = 2.0e-10) -> Model:
    """Return the mixed model with pore water: a film on the stations, some pressures held, at values that are not zero.

    ``rule`` as in mixed; between pairs of nodes both sides are porous, and the film has no faces to flow along.
    """
    model, rng = mixed(rule), np.random.default_rng(5)
    n, stations, faces = model.mesh.n_nodes, model.stations, model.mesh.face_sets["top"]
    if rule == "pairs":
        n_film, nodes, corners = len(stations), np.arange(len(stations))[:, None], np.zeros((0, 4), dtype=int)
        weight, film_faces, position = np.ones((n_film, 1)), np.zeros((0, 4), dtype=int), stations.position
    else:
        node = np.unique(faces)
        number = np.full(n, -1)
        number[node] = np.arange(len(node))
        n_film, nodes, weight = len(node), number[stations.nodes], stations.weight
        film_faces, position = number[faces], model.mesh.nodes[node]
        corners = film_faces if rule == "nodal" else np.arange(len(stations)).reshape(-1, 4)
    film = Film(n_film, nodes, weight, film_faces, corners, *film_geometry(position, film_faces), 2e-5, 3e-7, 1e-3)
    fixed = rng.uniform(size=n + n_film) < 0.2
    initial = np.where(fixed, rng.uniform(-1e4, 1e4, n + n_film), 0.0)
    model.water = Water(1.0e-9, storage, 5.0e-9, fixed, initial, 3.0e8, film)
    return model
