# SPDX-License-Identifier: MIT
"""The model in Fourier series: section of the soil, laws, stations of the interface, as plain data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.contact.law import ContactLaw
from fe_engine.elements import fourier as elements
from fe_engine.elements.interface import Stations
from fe_engine.errors import MeshError, ModelError
from fe_engine.material import Material, contact_shapes, material_shapes
from fe_engine.mesh import Quality


@dataclass(frozen=True)
class SectionMesh:
    """Half section of a body of revolution.

    nodes : (n, 2), r and z in m; quads : (ne, 8), see fourier_elements; node_sets : name -> (k,) int.
    """

    nodes: np.ndarray
    quads: np.ndarray
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def n_nodes(self) -> int:
        """Number of nodes of the section."""
        return len(self.nodes)

    @property
    def n_elements(self) -> int:
        """Number of elements of the section."""
        return len(self.quads)

    @property
    def on_axis(self) -> np.ndarray:
        """Whether each node (n,) lies on the axis of revolution."""
        at_zero: np.ndarray = self.nodes[:, 0] == 0.0
        return at_zero

    def shortest_edge(self) -> float:
        """Return the length of the shortest edge, m."""
        return float(self._edges().min())

    def check(self) -> Quality:
        """Return the quality figures; raise MeshError on inverted elements or unused nodes."""
        used = np.zeros(self.n_nodes, dtype=bool)
        used[self.quads] = True
        if not used.all():
            raise MeshError(f"node {int(np.argmin(used))} belongs to no element")
        edges, corner = self._edges(), self.nodes[self.quads[:, :4]]
        ahead, back = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
        area = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
        size = np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2)
        jacobian = (area / size).min(axis=1)
        worst = int(np.argmin(jacobian))
        if jacobian[worst] <= 0.0:
            raise MeshError(f"element {worst} near {np.round(corner[worst].mean(axis=0), 3)} is inverted or flat")
        return Quality(float(jacobian[worst]), float((edges.max(axis=1) / edges.min(axis=1)).max()), worst)

    def _edges(self) -> np.ndarray:
        corner = self.nodes[self.quads[:, :4]]
        lengths: np.ndarray = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
        return lengths


@dataclass(frozen=True)
class RingStations(Stations):
    """Stations on circles through nodes of the section.

    position, frame, area, body and surface as in interface.Stations (global axes, half the circle); ``nodes`` (ns, 1)
    are nodes of the section, ``weight`` (ns, 1) is 1, and ``azimuth`` (ns,) rad is their position on the circle.
    """

    azimuth: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass
class FourierModel:
    """Everything the engine needs to compute on a Fourier series.

    Attributes
    ----------
    mesh : section of the soil.
    harmonics : N, highest harmonic; azimuths : M > N, azimuths of the half circle at which the soil law is evaluated.
    materials, material : laws in use, and the index of each element's (ne,).
    initial_stress : (ne, 4 M, 6) Pa in cylindrical axes, point g at azimuth j stands at g M + j; see model.Model.
    fixed : (n, 3) bool, directions r, theta, z held at zero in all harmonics; the axis takes care of itself.
    n_border, border_scale, contact, contact_laws, contact_law, initial_pressure : see model.Model.
    stations : interface stations on circles.
    """

    mesh: SectionMesh
    harmonics: int
    azimuths: int
    materials: list[Material]
    material: np.ndarray
    initial_stress: np.ndarray
    fixed: np.ndarray
    n_border: int
    border_scale: np.ndarray
    stations: RingStations
    contact: np.ndarray
    initial_pressure: np.ndarray
    water: None = None
    contact_laws: tuple[ContactLaw, ...] = (coulomb.LAW,)
    contact_law: np.ndarray | None = None

    @property
    def displacement_shape(self) -> tuple[int, int, int]:
        """Shape (n, 3, N + 1) of the coefficients of the displacement along r, theta and z."""
        return self.mesh.n_nodes, 3, self.harmonics + 1

    def check(self) -> None:
        """Raise ModelError where the parts contradict each other."""
        ne, ns = self.mesh.n_elements, len(self.stations)
        shapes = {
            "material": (self.material.shape, (ne,)),
            "initial_stress": (self.initial_stress.shape, (ne, elements.N_POINTS * self.azimuths, 6)),
            "fixed": (self.fixed.shape, (self.mesh.n_nodes, 3)),
            "border_scale": (self.border_scale.shape, (self.n_border,)),
            "initial_pressure": (self.initial_pressure.shape, (ns,)),
            "stations.azimuth": (self.stations.azimuth.shape, (ns,)),
            "stations.nodes": (self.stations.nodes.shape, (ns, 1)),
        }
        shapes |= material_shapes(self) | contact_shapes(self)
        for name, (got, expected) in shapes.items():
            if got != expected:
                raise ModelError(f"{name} has shape {got}, expected {expected}")
        if self.azimuths <= self.harmonics:
            raise ModelError(f"{self.azimuths} azimuths cannot resolve {self.harmonics} harmonics: take more")
