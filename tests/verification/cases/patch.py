# SPDX-License-Identifier: MIT
"""Patch tests: a uniform stress passes through distorted hexahedra and across an interface between them.

A linear displacement field x -> A x is imposed on the boundary; the nodes inside are free and must find it,
with the stress C : sym A at every Gauss point. With an interface across the patch, its far side moves by the
jump t/K more (t the traction of that stress on the interface, K the penalties); the free nodes inside the
interface must find it and both sides must carry t. A column under a vertical force settles by dp/K_N more with
an interface than without.
"""

from functools import cache

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.elements import interface
from fe_engine.elements.interface import Stations
from fe_engine.mesh import Mesh
from fe_engine.model import Model
from fe_engine.soil.elastic import elastic_matrix
from tests.support.models import placed
from tests.verification.blocks import (
    POISSON,
    YOUNG,
    block_model,
    border_force,
    box,
    elastic_soil,
    followers,
    imposed,
    loaded,
    make_newton,
    run,
    sand,
)
from tests.verification.cases.sliding_block import turned
from tests.verification.cases.triaxial import S3, closed_form
from tests.verification.rows import Row, worst

GRADIENT = 1.0e-4 * np.array([[-2.0, 0.4, 1.1], [0.7, -1.0, -0.3], [-0.5, 0.9, -3.0]])
TURN = turned((1.0, 0.4, -0.7), 63.0)
KN, KT = 3.0e9, 1.0e9
_SOURCE = "uniform stress"


def distorted(counts: tuple[int, int, int], keep_levels: bool = False) -> Mesh:
    """Unit box whose inner nodes are moved at random by up to a fifth of a cell (in plan only, if asked)."""
    mesh = box(counts)
    rng = np.random.default_rng(7)
    inside = ((mesh.nodes > 1e-9) & (mesh.nodes < 1.0 - 1e-9)).all(axis=1)
    shift = rng.uniform(-0.2, 0.2, mesh.nodes.shape) / np.array(counts)
    if keep_levels:
        shift[:, 2] = 0.0
    mesh.nodes[inside] += shift[inside]
    mesh.check()
    return mesh


def _voigt(tensor: np.ndarray) -> np.ndarray:
    a = tensor + tensor.T
    return np.array([a[0, 0] / 2, a[1, 1] / 2, a[2, 2] / 2, a[0, 1], a[1, 2], a[2, 0]])


def _exact_stress() -> np.ndarray:
    return elastic_matrix(YOUNG, POISSON) @ _voigt(GRADIENT)


def _as_tensor(stress: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = stress
    return np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])


def _follow_field(model: Model, boundary: np.ndarray, field: np.ndarray) -> None:
    """Let the boundary nodes move by the field (n, 3) when the one border dof goes to 1."""
    node = np.flatnonzero(boundary)
    model.followers = np.vstack([followers(node, i, 0, field[node, i]) for i in range(3)])


@cache
def rows() -> tuple[Row, ...]:
    """Patch of one piece (elastic and plastic), patch with an interface, column with an interface."""
    return (*_one_piece(), *_plastic(), *_two_pieces("nodal"), *_two_pieces("gauss"), *_column())


def _one_piece() -> list[Row]:
    mesh = distorted((3, 3, 3))
    boundary = ((mesh.nodes < 1e-9) | (mesh.nodes > 1.0 - 1e-9)).any(axis=1)
    model = block_model(mesh, elastic_soil(), np.zeros(mesh.nodes.shape, dtype=bool), 1)
    field = mesh.nodes @ GRADIENT.T
    _follow_field(model, boundary, field)
    state, _ = run(make_newton(model), imposed([1.0]))
    case = "patch test, distorted hexahedra"
    stress = worst(state.committed.stress, _exact_stress())
    move = worst(state.committed.displacement, field)
    return [
        Row.error(case, "largest error of the stress", stress, _SOURCE, 1e-10),
        Row.error(case, "largest error of the displacement", move, _SOURCE, 1e-10),
    ]


def _plastic() -> list[Row]:
    """Triaxial compression of hardening sand through distorted elements: the state of one element everywhere."""
    mesh = distorted((3, 3, 3))
    fixed = mesh.nodes == 0.0
    fixed[:, 2] = mesh.nodes[:, 2] == 1.0
    model = block_model(mesh, sand(5.0, 30.0, 10.0), fixed, 1, S3)
    model.followers = followers(np.flatnonzero(mesh.nodes[:, 2] == 0.0), 2, 0)
    q, strain, _ = closed_form(0.005, 10.0)
    state, _ = run(make_newton(model), imposed([strain]))
    stress = state.committed.stress
    exact = np.array([-S3, -S3, -S3 - q, 0.0, 0.0, 0.0])
    return [
        Row.error("patch test, distorted hexahedra, hardening sand", "largest error of the stress",
            worst(stress, exact), "triaxial compression, closed form", 1e-8)
    ]  # fmt: skip


def split(mesh: Mesh) -> tuple[Mesh, np.ndarray, np.ndarray, np.ndarray]:
    """Cut a unit box at z = 0.5: mesh with doubled nodes, faces into z > 0.5, and each face node's two nodes."""
    on_plane = np.flatnonzero(np.abs(mesh.nodes[:, 2] - 0.5) < 1e-9)
    twin = np.arange(mesh.n_nodes)
    twin[on_plane] = mesh.n_nodes + np.arange(len(on_plane))
    above = mesh.nodes[mesh.hexes].mean(axis=1)[:, 2] < 0.5
    faces = mesh.hexes[~above][:, :4]
    faces = faces[(np.abs(mesh.nodes[faces, 2] - 0.5) < 1e-9).all(axis=1)]
    hexes = mesh.hexes.copy()
    hexes[above] = twin[hexes[above]]
    return Mesh(np.vstack([mesh.nodes, mesh.nodes[on_plane]]), hexes), faces, on_plane, twin


def put_interface(model: Model, faces: np.ndarray, twin: np.ndarray, rule: str, pressure: float) -> None:
    """Stations between the soil at the faces (side 1) and the elements at their twin nodes (side 2)."""
    nodes = model.mesh.nodes
    first, weight, normal, area = placed(nodes, faces, rule)
    n = len(area)
    model.stations = Stations(
        position=np.einsum("sa,sai->si", weight, nodes[first]), frame=interface.local_frames(normal), area=area,
        nodes=np.hstack([first, twin[first]]), weight=np.hstack([weight, -weight]),
        body=np.zeros((n, 3, model.n_border)), surface=np.zeros(n, dtype=np.int64),
    )  # fmt: skip
    model.contact = coulomb.pack(KN, KT, 5.0)[None]
    model.initial_pressure = np.full(n, pressure)


def _two_pieces(rule: str) -> list[Row]:
    """Distorted patch with an interface across it, all of it turned in space."""
    flat, faces, _on_plane, twin = split(distorted((3, 3, 4), keep_levels=True))
    mesh = Mesh(flat.nodes @ TURN.T, flat.hexes)
    boundary = ((flat.nodes < 1e-9) | (flat.nodes > 1.0 - 1e-9)).any(axis=1)
    model = block_model(mesh, elastic_soil(), np.zeros(mesh.nodes.shape, dtype=bool), 1)
    put_interface(model, faces, twin, rule, 200.0e3)
    normal = model.stations.frame[0, 0]
    stress = _as_tensor(_exact_stress())
    traction = stress @ normal
    pressing = normal * (normal @ traction)
    field = mesh.nodes @ GRADIENT.T
    far = np.isin(np.arange(mesh.n_nodes), mesh.hexes[flat.nodes[flat.hexes].mean(axis=1)[:, 2] > 0.5])
    field[far] += pressing / KN + (traction - pressing) / KT
    _follow_field(model, boundary, field)
    newton = make_newton(model)
    state, _ = run(newton, imposed([1.0]))
    change = state.committed.traction + np.array([200.0e3, 0.0, 0.0])
    found = np.einsum("sij,si->sj", model.stations.frame, change)
    case = f"patch test across an oblique interface, {rule} stations"
    errors = {
        "stress": worst(state.committed.stress, _exact_stress()),
        "traction": worst(found, traction),
        "displacement": worst(state.committed.displacement, field),
    }
    return [Row.error(case, f"largest error of the {name}", error, _SOURCE, 1e-9) for name, error in errors.items()]


def _column() -> list[Row]:
    """Column under a force on its top, with and without an interface half way down."""
    load = 80.0e3
    mesh = distorted((3, 3, 4), keep_levels=True)
    cut, faces, _, twin = split(mesh)
    tops = []
    for piece, has_interface in ((mesh, False), (cut, True)):
        fixed = piece.nodes == 0.0
        fixed[:, 2] = piece.nodes[:, 2] == 1.0
        model = block_model(piece, elastic_soil(), fixed, 1)
        model.followers = followers(np.flatnonzero(piece.nodes[:, 2] == 0.0), 2, 0)
        if has_interface:
            put_interface(model, faces, twin, "nodal", 10.0e3)
        newton = make_newton(model)
        state, _ = run(newton, loaded([load]))
        tops.append(float(state.committed.border[0]))
    spread = worst(state.committed.traction[:, 0], -load - 10.0e3)
    balance = float(border_force(newton, state)[0])
    case = "column with an interface"
    return [
        Row(case, "settlement beyond the column's own", "m", tops[1] - tops[0], load / KN, "dp/K_N", 1e-8),
        Row(case, "settlement of the column alone", "m", tops[0], load / YOUNG, "p L/E", 1e-9),
        Row.error(case, "largest error of the contact pressure", spread, _SOURCE, 1e-9),
        Row(case, "force under the top", "N", balance, load, "equilibrium", 1e-9),
    ]
