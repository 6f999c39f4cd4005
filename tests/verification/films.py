# SPDX-License-Identifier: MIT
"""Interfaces with a film of water on the small models: one station and one film node on every node of the faces."""

from dataclasses import dataclass

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.elements import interface
from fe_engine.elements.interface import Film, Stations
from fe_engine.model import Model
from tests.verification.water import VISCOSITY

KN, KT = 1.0e10, 1.0e10
# Initial contact pressure (Pa) that keeps an interface closed under the pressures of these cases
CLOSED = 1.0e6


@dataclass(frozen=True)
class Interface:
    """The film, the mesh nodes its nodes lie on (side 1), their positions (ns, 3) m and areas (ns,) m2."""

    film: Film
    nodes: np.ndarray
    position: np.ndarray
    area: np.ndarray


def lay_film(
    model: Model,
    faces: np.ndarray,
    aperture: float,
    transfer: float,
    pressure: float = CLOSED,
    motion: np.ndarray | None = None,
    twin: np.ndarray | None = None,
    kn: float = KN,
) -> Interface:
    """Put stations and a film on the faces (m, 4), whose normals point into the soil of side 1.

    Parameters
    ----------
    aperture : residual aperture in m; transfer : T_w in m/(Pa s); pressure : initial contact pressure in Pa.
    motion : (3, nb), or (ns, 3, nb) per node in ascending order: how a rigid, impervious side 2 moves with the
        border dofs; none if not given.
    twin : (n,) node of side 2 opposite each node of side 1, where side 2 is soil.
    """
    nodes, n_border = model.mesh.nodes, model.n_border
    node, normal, area = interface.nodal_stations(nodes, faces)
    ns = len(node)
    number = np.searchsorted(node, faces)
    body = np.zeros((3, n_border)) if motion is None else motion
    model.stations = Stations(
        position=nodes[node], frame=interface.local_frames(normal), area=area,
        nodes=node[:, None] if twin is None else np.column_stack([node, twin[node]]),
        weight=np.tile([1.0] if twin is None else [1.0, -1.0], (ns, 1)),
        body=np.broadcast_to(body, (ns, 3, n_border)).copy(), surface=np.zeros(ns, dtype=np.int64),
    )  # fmt: skip
    model.contact = coulomb.pack(kn, KT, 0.0)[None]
    model.initial_pressure = np.full(ns, pressure)
    gradient, size = interface.film_geometry(nodes[node], number)
    film = Film(
        n_nodes=ns, nodes=np.arange(ns)[:, None], weight=np.ones((ns, 1)), faces=number, corners=number,
        gradient=gradient, area=size, residual_aperture=aperture, transfer=transfer, viscosity=VISCOSITY,
    )  # fmt: skip
    return Interface(film, node, nodes[node], area)
