# SPDX-License-Identifier: MIT
"""The whole half model at one state, soil and steel, for ParaView, in single precision."""

import numpy as np
import xarray as xr

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.elements import fourier as elements
from fe_engine.material import history_of
from fe_engine.soil.law import PLASTIC_STRAIN
from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.model.build import Built, body_operator
from pysprings.model.fourier import BuiltFourier


class Volume:
    """Turns a state into fields on nodes and cells; cells are the soil's elements, then those of the steel."""

    def __init__(self, built: Built, system: System) -> None:
        self.built, self.system = built, system
        nodes = built.model.mesh.nodes[built.caisson.mesh.n_nodes :]
        self.rigid = body_operator(nodes)  # steel moves with the rigid motion, too
        self.n_steel = 0 if built.steel is None else len(built.steel.hexes)

    def fields(self, state: Fields) -> dict[str, np.ndarray]:
        """Return the displacement, stress, plastic strain, pore pressure and gap; see `variables`."""
        u, n = self._displacement(state), self.built.model.mesh.n_nodes
        stress = np.vstack([state.stress.mean(axis=1), np.full((self.n_steel, 6), np.nan)])
        plastic = history_of(self.built.model, state.history, PLASTIC_STRAIN).mean(axis=1)
        strain = np.append(plastic, np.zeros(self.n_steel))
        fields = {f"volume_u{axis}": u[:, i] for i, axis in enumerate("xyz")}
        fields |= {f"volume_s{name}": stress[:, i] for i, name in enumerate(variables.STRESSES)}
        fields |= {"volume_plastic_strain": strain, "volume_gap": self._gap(state)}
        if self.built.model.water is not None:
            fields["volume_pore_pressure"] = state.pressure[:n]
        return {name: values.astype(np.float32) for name, values in fields.items()}

    def _displacement(self, state: Fields) -> np.ndarray:
        """Return the displacement (n, 3) in the axes of the model."""
        u = state.displacement.copy()
        for node, axes in self.built.model.frames.items():
            u[node] = axes.T @ u[node]
        u[self.built.caisson.mesh.n_nodes :] += self.rigid @ state.border
        return u

    def _gap(self, state: Fields) -> np.ndarray:
        """Return the largest opening (n,) of the stations that a node of the soil belongs to."""
        stations = self.system.stations
        gap = self.system.gaps(state)
        widest = np.zeros(self.built.model.mesh.n_nodes)
        station, place = np.nonzero(stations.weight > 0.0)
        np.maximum.at(widest, stations.nodes[station, place], gap[station])
        return widest


def volume_dataset(built: Built) -> xr.Dataset:
    """Return the nodes and cells of the whole half model."""
    nodes = built.model.mesh.nodes
    soil = built.model.mesh.hexes
    steel = np.zeros((0, 8), dtype=soil.dtype) if built.steel is None else built.steel.hexes
    data = {f"volume_{axis}": ("volume_node", nodes[:, i]) for i, axis in enumerate("xyz")}
    cells = np.concatenate([soil, steel]).astype(np.int32)
    flag = np.repeat(np.array([0, 1], dtype=np.int8), [len(soil), len(steel)])
    whole = xr.Dataset(data | {"volume_hex": (("volume_cell", "vertex"), cells), "volume_steel": ("volume_cell", flag)})
    return variables.attach(whole, "volume")


# --- a Fourier model as hexahedra of the half domain, for ParaView: sectors around each azimuth of the soil law ---


class FourierVolume:
    """Turns a state into fields on nodes and cells; see `volume.Volume`."""

    def __init__(self, built: BuiltFourier, system: FourierSystem) -> None:
        self.built, self.system = built, system
        self.grid = Sectors(built)
        stations = built.model.stations
        edges = self.grid.edges
        nearest = np.abs(edges[:, None] - built.azimuth[None]).argmin(axis=1)
        self._nearest = built.azimuth[nearest]
        self._station_azimuth = stations.azimuth

    def fields(self, state: Fields) -> dict[str, np.ndarray]:
        """Return the displacement, stress, plastic strain, pore pressure and gap; see `variables`."""
        u, stress = self.grid.displacement(state), self.grid.stress(state)
        fields = {f"volume_u{axis}": u[:, i] for i, axis in enumerate("xyz")}
        fields |= {f"volume_s{name}": stress[:, i] for i, name in enumerate(variables.STRESSES)}
        fields |= {"volume_plastic_strain": self.grid.plastic(state), "volume_gap": self._gap(state)}
        if self.built.model.water is not None:
            pressure = np.zeros((len(self.grid.edges), len(self.grid.corner)))
            pressure[:, : len(self.built.section.mesh.corners)] = self.grid.pressure(state)
            fields["volume_pore_pressure"] = pressure.ravel()
        return {name: values.astype(np.float32) for name, values in fields.items()}

    def _gap(self, state: Fields) -> np.ndarray:
        """Return the largest opening (n,) of the stations of a node, those at the nearest azimuth."""
        node, corner, gap = self.system.contact.node, self.grid.corner, self.system.gaps(state)
        widest = np.zeros((len(self.grid.edges), self.built.model.mesh.n_nodes))
        for i, azimuth in enumerate(self._nearest):
            mine = self._station_azimuth == azimuth
            np.maximum.at(widest[i], node[mine], gap[mine])
        return widest[:, corner].ravel()


class Sectors:
    """Nodes and cells: corners of the section at the edges (M + 1,) between the azimuths of the law, then the steel's.

    Cells are those of the soil at all azimuths, then those of the steel.
    """

    def __init__(self, built: BuiltFourier) -> None:
        mesh, m = built.model.mesh, built.model.azimuths
        self.built, self.edges = built, np.linspace(0.0, np.pi, m + 1)
        steel = mesh.quads[:0] if built.steel is None else built.steel.quads
        self.corner = np.concatenate([mesh.corners, np.unique(steel[:, :4])])
        number = np.full(mesh.n_nodes, -1)
        number[self.corner] = np.arange(len(self.corner))
        n = len(self.corner)
        parts = (number[quads[:, [0, 3, 2, 1]]] for quads in (mesh.quads, steel))
        self.hexes = np.concatenate([np.hstack([q + j * n, q + (j + 1) * n]) for q in parts for j in range(m)])
        self.n_steel = m * len(steel)
        r, z = mesh.nodes[self.corner].T
        c, s = np.cos(self.edges)[:, None], np.sin(self.edges)[:, None]
        self.nodes = np.stack([c * r, s * r, np.broadcast_to(z, (m + 1, n))], axis=-1).reshape(-1, 3)
        self._wave = elements.waves(self.edges, built.model.harmonics)
        of_steel = np.tile(self.corner >= built.model.n_soil, m + 1)
        self._rigid = body_operator(self.nodes) * of_steel[:, None, None]

    def displacement(self, state: Fields) -> np.ndarray:
        """Return the displacement (nodes, 3) in global axes; steel moves with the rigid motion, too."""
        move = state.displacement[self.corner]
        r, t, z = (np.einsum("jk,nk->jn", self._wave[..., w], move[:, i]) for i, w in enumerate((0, 1, 0)))
        c, s = np.cos(self.edges)[:, None], np.sin(self.edges)[:, None]
        move = np.stack([c * r - s * t, s * r + c * t, z], axis=-1).reshape(-1, 3)
        whole: np.ndarray = move + self._rigid @ state.border
        return whole

    def pressure(self, state: Fields) -> np.ndarray:
        """Return the excess pore pressure (M + 1, nc) at the soil's nodes, Pa."""
        pressure: np.ndarray = self._wave[..., 0] @ state.pressure[: len(self.built.section.mesh.corners)].T
        return pressure

    def stress(self, state: Fields) -> np.ndarray:
        """Return the mean stress (cells, 6) in global axes; not a number in steel."""
        rr, tt, zz, rt, tz, zr = np.moveaxis(self._mean(state.stress), -1, 0)
        angle = elements.azimuths(self.built.model.azimuths)[:, None]
        c, s = np.cos(angle), np.sin(angle)
        xx, yy = c * c * rr + s * s * tt - 2 * c * s * rt, s * s * rr + c * c * tt + 2 * c * s * rt
        xy = c * s * (rr - tt) + (c * c - s * s) * rt
        soil = np.stack([xx, yy, zz, xy, s * zr + c * tz, c * zr - s * tz], axis=-1).reshape(-1, 6)
        return np.vstack([soil, np.full((self.n_steel, 6), np.nan)])

    def plastic(self, state: Fields) -> np.ndarray:
        """Return the mean equivalent plastic strain (cells,); 0 in steel."""
        plastic = history_of(self.built.model, state.history, PLASTIC_STRAIN)
        return np.append(self._mean(plastic[..., None]).ravel(), np.zeros(self.n_steel))

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means (M, ne, nv) over the points of a section at each azimuth."""
        ne, _, nv = values.shape
        mean: np.ndarray = values.reshape(ne, elements.N_POINTS, -1, nv).mean(axis=1).transpose(1, 0, 2)
        return mean


def fourier_volume_dataset(built: BuiltFourier) -> xr.Dataset:
    """Return the nodes and cells of the whole half model."""
    grid = Sectors(built)
    data = {f"volume_{axis}": ("volume_node", grid.nodes[:, i]) for i, axis in enumerate("xyz")}
    flag = (np.arange(len(grid.hexes)) >= len(grid.hexes) - grid.n_steel).astype(np.int8)
    cells = (("volume_cell", "vertex"), grid.hexes.astype(np.int32))
    return variables.attach(xr.Dataset(data | {"volume_hex": cells, "volume_steel": ("volume_cell", flag)}), "volume")
