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

    @property
    def corners(self) -> np.ndarray:
        """Nodes (nc,) at corners of elements, ascending: those that have a pressure where there is water."""
        nodes: np.ndarray = np.unique(self.quads[:, :4])
        return nodes

    def corner_numbers(self, nodes: np.ndarray) -> np.ndarray:
        """Return the number of each node (...) among the corners; of corners only."""
        numbers: np.ndarray = np.searchsorted(self.corners, nodes)
        return numbers

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
    Where the body is linear elements, nodes (ns, 2) are one of the soil and its node at the same place; weights 1, -1.
    """

    azimuth: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class RingFilm:
    """Water between the soil and a rigid, impervious body: a series around, linear along the line of its nodes.

    Flow along the film is integrated at points, each on the azimuth of a station whose gap holds there.

    Attributes
    ----------
    soil : (nf,) pressure node of the soil that each film node lies on.
    nodes : (ns, 2) film nodes of every station, weight : (ns, 2) their shares (sum 1).
    station : (m,) station whose gap holds at each point; ends : (m, 2) film nodes of its piece of the line.
    slope : (m, 2) derivatives along the line, over_radius : (m, 2) values over the radius, 1/m; area : (m,) m2.
    residual_aperture : D_0, m; transfer : T_w, m/(Pa s); viscosity : Pa s.
    wetted : (ns,) share of every station's area that has a film; None: all of it.
    """

    soil: np.ndarray
    nodes: np.ndarray
    weight: np.ndarray
    station: np.ndarray
    ends: np.ndarray
    slope: np.ndarray
    over_radius: np.ndarray
    area: np.ndarray
    residual_aperture: float
    transfer: float
    viscosity: float
    wetted: np.ndarray | None = None

    @property
    def n_nodes(self) -> int:
        """Number of film nodes."""
        return len(self.soil)


@dataclass(frozen=True)
class SeriesWater:
    """Pore water of the soil, and of the interface where there is a film; see model.Water.

    Pressures are excess pressures, Pa: coefficients of cos(k theta), of the other family sin(k theta), at the corners
    of the elements, then at film nodes.

    Attributes
    ----------
    mobility, storage, scale : see model.Water.
    fixed : (nc + nf,) bool, where the pressure keeps its initial value.
    initial : (nc + nf, K) Pa, at the start.
    film : water in the interface, None where the interface holds none.
    wet : (ne,) bool, see model.Water.
    """

    mobility: float | np.ndarray
    storage: float
    fixed: np.ndarray
    initial: np.ndarray
    scale: float
    film: RingFilm | None = None
    wet: np.ndarray | None = None


@dataclass(frozen=True)
class LinearRings:
    """Elements of constant stiffness beside the soil's; their displacement 0 is without stress.

    quads : (nl, 8) nodes, which stand behind the soil's; stiffness : (K, nl, 24, 24) of each slot over the revolution
    of the series, N/m; see elements.fourier.stiffness.
    """

    quads: np.ndarray
    stiffness: np.ndarray


@dataclass
class FourierModel:
    """Everything the engine needs to compute on a Fourier series.

    Attributes
    ----------
    mesh : section of the soil; its nodes include those of linear elements.
    harmonics : N, highest harmonic; azimuths : M > N, azimuths of the half circle at which the soil law is evaluated.
    whole : whether the series goes around the whole circle (M > 2 N); see elements.fourier.
    materials, material : laws in use, and the index of each element's (ne,).
    initial_stress : (ne, 4 M, 6) Pa in cylindrical axes, point g at azimuth j stands at g M + j; see model.Model.
    fixed : (n, 3) bool, directions r, theta, z held at zero in all harmonics; the axis takes care of itself.
    n_border, border_scale, contact, contact_laws, contact_law, initial_pressure : see model.Model.
    stations : interface stations on circles.
    water : pore water; None leaves every pressure unknown out (drained).
    linear : elements of constant stiffness, of what stands between the stations and the border; None where it is rigid.
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
    water: SeriesWater | None = None
    contact_laws: tuple[ContactLaw, ...] = (coulomb.LAW,)
    contact_law: np.ndarray | None = None
    linear: LinearRings | None = None
    whole: bool = False

    @property
    def numbers(self) -> np.ndarray:
        """Number k (K,) of each slot of the series."""
        return elements.numbers(self.harmonics, self.whole)

    @property
    def n_soil(self) -> int:
        """Number of nodes of the soil."""
        return self.mesh.n_nodes if self.linear is None else int(self.linear.quads.min())

    @property
    def displacement_shape(self) -> tuple[int, int, int]:
        """Shape (n, 3, K) of the coefficients of the displacement along r, theta and z."""
        return self.mesh.n_nodes, 3, len(self.numbers)

    @property
    def n_pressures(self) -> int:
        """Number of pressure nodes of soil and film; 0 when drained."""
        return 0 if self.water is None else len(self.water.fixed)

    @property
    def pressure_nodes(self) -> np.ndarray:
        """Node (np,) of the section on which each pressure stands: the soil's, then the film's; none when drained."""
        corners = self.mesh.corners
        if self.water is None:
            return corners[:0]
        return corners if self.water.film is None else np.concatenate([corners, corners[self.water.film.soil]])

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
            "stations.nodes": (self.stations.nodes.shape, (ns, 1 if self.linear is None else 2)),
        }
        if self.linear is not None:
            matrix = 3 * elements.N_NODES
            matrices = len(self.numbers), len(self.linear.quads), matrix, matrix
            shapes["linear.stiffness"] = (self.linear.stiffness.shape, matrices)
        shapes |= material_shapes(self) | contact_shapes(self)
        if self.water is not None:
            film = self.water.film
            pressures = len(self.mesh.corners) + (0 if film is None else film.n_nodes)
            shapes["water.fixed"] = (self.water.fixed.shape, (pressures,))
            shapes["water.initial"] = (self.water.initial.shape, (pressures, len(self.numbers)))
            if self.water.wet is not None:
                shapes["water.wet"] = self.water.wet.shape, (ne,)
        for name, (got, expected) in shapes.items():
            if got != expected:
                raise ModelError(f"{name} has shape {got}, expected {expected}")
        if self.azimuths < len(self.numbers):
            raise ModelError(f"{self.azimuths} azimuths cannot resolve {self.harmonics} harmonics: take more")
