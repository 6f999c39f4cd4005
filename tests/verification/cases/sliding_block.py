# SPDX-License-Identifier: MIT
"""A block on a Coulomb interface: penetration, stick, slip and reversal, in any direction and on rotated faces.

The block rests with the pressure p on a plane. A force that grows with the displacement u of the block sticks,
tau = K_T u, slips at u = mu p/K_T and stays at mu p along the push; turned round, it slips back after
2 mu p/K_T more. The load that raises the pressure from its initial value to p pushes the block in by dp/K_N.

The mover is the soil block in the first problem (the nodes of its face follow three border dofs, so that
faces of any orientation can be pushed in any direction) and the rigid body in the second.
"""

from functools import cache

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.conventions import CONTACT_SLIP, CONTACT_STICK
from fe_engine.elements import interface, rigid
from fe_engine.elements.interface import Stations
from fe_engine.mesh import Mesh
from fe_engine.model import Model, Stage
from fe_engine.solve.newton import Newton
from tests.verification.blocks import block_model, box, elastic_soil, followers, make_newton, run
from tests.verification.rows import Row, worst

KN, KT, MU = 2.0e9, 5.0e8, 0.4
INITIAL, PRESSURE = 30.0e3, 100.0e3
SIDES = (1.2, 0.7)
AREA = SIDES[0] * SIDES[1]
SLIP = MU * PRESSURE / KT
# Displacement in units of mu p/K_T, and shear in units of mu p, pushed and then turned round at 3
PUSH = {0.5: 0.5, 0.999: 0.999, 1.001: 1.0, 3.0: 1.0}
BACK = {2.0: 0.0, 1.001: -0.999, 0.999: -1.0, -1.0: -1.0}
DIRECTIONS = np.radians([0.0, 30.0, 90.0, 200.0, 315.0])
_SOURCE = "Coulomb's law"


def turned(axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """Rotation matrix (3, 3) about an axis (Rodrigues)."""
    k = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


FACES = {
    "horizontal": np.eye(3),
    "wall": turned((0.0, 1.0, 0.0), 90.0),
    "wall, turned in plan": turned((0.0, 0.0, 1.0), 37.0) @ turned((0.0, 1.0, 0.0), 90.0),
    "oblique": turned((0.3, -1.0, 0.5), 128.0),
}


def make_block(rotation: np.ndarray) -> tuple[Mesh, np.ndarray, np.ndarray, np.ndarray]:
    """Turned block with its lower face on the plane: mesh, face nodes, their areas and the normal into the block."""
    flat = box((2, 2, 1), (*SIDES, 0.5))
    faces = flat.hexes[flat.nodes[flat.hexes[:, 0], 2] == 0.0][:, :4]
    mesh = Mesh(flat.nodes @ rotation.T, flat.hexes)
    node, normal, area = interface.nodal_stations(mesh.nodes, faces)
    return mesh, node, area, normal


def pushed_block(rotation: np.ndarray) -> Newton:
    """Model whose border dofs are the displacements of the block along x, y and z."""
    mesh, node, area, normal = make_block(rotation)
    model = block_model(mesh, elastic_soil(), np.zeros(mesh.nodes.shape, dtype=bool), 3)
    model.followers = np.vstack([followers(node, component, component) for component in range(3)])
    _put_on_plane(model, node, area, normal, np.zeros((len(node), 3, 3)))
    return make_newton(model)


def pushed_body(rotation: np.ndarray) -> Newton:
    """Model whose border dofs are those of a rigid body that slides under a block held at its face."""
    mesh, node, area, normal = make_block(rotation)
    fixed = np.zeros(mesh.nodes.shape, dtype=bool)
    fixed[node] = True
    model = block_model(mesh, elastic_soil(), fixed, 3)
    centre = rotation @ [0.5 * SIDES[0], 0.5 * SIDES[1], 0.0]
    _put_on_plane(model, node, area, normal, rigid.in_plane(mesh.nodes[node], centre))
    return make_newton(model)


def _put_on_plane(model: Model, node: np.ndarray, area: np.ndarray, normal: np.ndarray, body: np.ndarray) -> None:
    n = len(node)
    model.stations = Stations(
        position=model.mesh.nodes[node], frame=interface.local_frames(normal), area=area, nodes=node[:, None],
        weight=np.ones((n, 1)), body=body, surface=np.zeros(n, dtype=np.int64),
    )  # fmt: skip
    model.contact = coulomb.pack(KN, KT, MU)[None]
    model.initial_pressure = np.full(n, INITIAL)


def push(newton: Newton, across: np.ndarray, normal: np.ndarray) -> dict[str, np.ndarray]:
    """Raise the pressure, push along the first row of ``across`` (k, 3) with the others held, and turn round.

    ``normal`` (3,) is the border direction that presses. Returns the displacement, forces and contact states at
    the stops of PUSH and BACK, and the penetration under the load that was added.
    """
    k, load = len(across), (PRESSURE - INITIAL) * AREA * normal
    targets = [0.0, *PUSH, *BACK]
    found: dict[str, list] = {"force": [], "state": []}
    depth = []

    def note(step) -> None:
        found["force"].append(step.multipliers / (MU * PRESSURE * AREA))
        found["state"].append(newton.system.contact_state.copy())

    stages = []
    for target in targets:
        wanted = np.zeros(k)
        wanted[0] = target * SLIP
        stages.append(Stage("push", across, wanted, across.T, load, (1.0,), 1.0, 1.0))
    state, driver = run(newton, stages[0])
    depth.append(normal @ state.committed.border)
    for stage in stages[1:]:
        driver.run(stage, note)
    return {name: np.array(values) for name, values in found.items()} | {"penetration": np.array(depth)}


@cache
def rows() -> tuple[Row, ...]:
    """All directions and faces together: the largest error of each branch."""
    block = [_block(face, angle) for face in FACES.values() for angle in DIRECTIONS]
    body = [_body(tilt, sign) for tilt in (0.0, 35.0, 90.0) for sign in (1.0, -1.0)]
    return (
        *_judge("sliding block, 5 directions on 4 faces", block),
        *_judge("sliding rigid body, both ways on 3 faces", body),
    )


def _block(rotation: np.ndarray, angle: float) -> dict[str, np.ndarray]:
    along = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0]])
    return push(pushed_block(rotation), along @ rotation.T, -rotation[:, 2])


def _body(tilt: float, sign: float) -> dict[str, np.ndarray]:
    """Push the body along its face, which is tilted about y (degrees)."""
    rotation = turned((0.0, 1.0, 0.0), tilt)
    along, normal = sign * rotation[:, 0], rotation[:, 2]
    across = np.array([[along[0], along[2], 0.0], [0.0, 0.0, 1.0]])
    return push(pushed_body(rotation), across, np.array([normal[0], normal[2], 0.0]))


def _judge(case: str, runs: list[dict[str, np.ndarray]]) -> list[Row]:
    """Largest errors over all runs, relative to mu p, and the contact states."""
    exact = np.array([*PUSH.values(), *BACK.values()])
    force = np.array([run["force"] for run in runs])
    along, astray = force[:, :, 0], force[:, :, 1]
    depth = np.concatenate([run["penetration"] for run in runs]) * KN / (PRESSURE - INITIAL)
    slips = np.array([False, False, True, True, False, False, True, True])

    def error(at: list[int]) -> float:
        return float(np.abs(along[:, at] - exact[at]).max())

    wrong = sum(np.count_nonzero(run["state"] != _state(slips)[:, None]) for run in runs)
    groups = {
        "shear before slip": ([0, 1], "K_T u"),
        "shear in slip": ([2, 3], "mu p"),
        "shear after reversal": ([4, 5], "mu p - K_T du"),
        "shear in slip back": ([6, 7], "-mu p after 2 mu p/K_T more"),
    }
    found = [
        Row.error(case, f"largest error of the {name}, over mu p", error(at), f"{_SOURCE}: {law}", 1e-9)
        for name, (at, law) in groups.items()
    ]
    return [
        *found,
        Row.error(case, "largest shear across the push, over mu p", float(np.abs(astray).max()), _SOURCE, 1e-9),
        Row.error(case, "stations in another state than stick or slip as due", float(wrong), _SOURCE, 0.0),
        Row.error(case, "largest error of the penetration, over dp/K_N", worst(depth, 1.0), "penalty contact", 1e-9),
    ]


def _state(slips: np.ndarray) -> np.ndarray:
    return np.where(slips, CONTACT_SLIP, CONTACT_STICK)
