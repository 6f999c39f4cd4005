# SPDX-License-Identifier: MIT
"""The whole half model at one state, soil and steel, for ParaView, in single precision."""

from typing import Any

import numpy as np
import xarray as xr

from fe_engine.elements import fourier as elements
from fe_engine.material import history_of
from fe_engine.soil.law import PLASTIC_STRAIN
from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.model.build import Built, body_operator
from pysprings.model.fourier import BuiltFourier


class Volume:
    """Nodes and cells of a model of bricks, the soil's and then those of the steel; turns a state into fields on them.

    Fields need the ``system`` of the model.
    """

    built: Built
    nodes: np.ndarray
    hexes: np.ndarray
    n_steel: int

    def __init__(self, built: Any, system: Any = None) -> None:
        self.built, self.system = built, system
        self._take_cells()

    def _take_cells(self) -> None:
        mesh, steel = self.built.model.mesh, self.built.steel
        shells = mesh.hexes[:0] if steel is None else steel.hexes
        self.nodes, self.hexes, self.n_steel = mesh.nodes, np.concatenate([mesh.hexes, shells]), len(shells)
        self.rigid = body_operator(
            mesh.nodes[self.built.caisson.mesh.n_nodes :]
        )  # steel moves with the rigid motion, too

    def dataset(self) -> xr.Dataset:
        """Return the nodes and cells."""
        data = {f"volume_{axis}": ("volume_node", self.nodes[:, i]) for i, axis in enumerate("xyz")}
        flag = (np.arange(len(self.hexes)) >= len(self.hexes) - self.n_steel).astype(np.int8)
        cells = (("volume_cell", "vertex"), self.hexes.astype(np.int32))
        whole = xr.Dataset(data | {"volume_hex": cells, "volume_steel": ("volume_cell", flag)})
        return variables.attach(whole, "volume")

    def fields(self, state: Fields) -> dict[str, np.ndarray]:
        """Return the displacement, stress, plastic strain, pore pressure and gap; see `variables`."""
        u, stress = self._displacement(state), np.vstack([self._stress(state), np.full((self.n_steel, 6), np.nan)])
        fields = {f"volume_u{axis}": u[:, i] for i, axis in enumerate("xyz")}
        fields |= {f"volume_s{name}": stress[:, i] for i, name in enumerate(variables.STRESSES)}
        plastic = self._mean(history_of(self.built.model, state.history, PLASTIC_STRAIN)[..., None])
        fields["volume_plastic_strain"] = np.append(plastic.ravel(), np.zeros(self.n_steel))
        fields["volume_gap"] = self._gap(state)
        if self.built.model.water is not None:
            fields["volume_pore_pressure"] = self._pressure(state)
        return {name: values.astype(np.float32) for name, values in fields.items()}

    def _displacement(self, state: Fields) -> np.ndarray:
        """Return the displacement (n, 3) in the axes of the model."""
        u = state.displacement.copy()
        for node, axes in self.built.model.frames.items():
            u[node] = axes.T @ u[node]
        u[self.built.caisson.mesh.n_nodes :] += self.rigid @ state.border
        return u

    def _stress(self, state: Fields) -> np.ndarray:
        """Return the mean stress (cells, 6) of the soil."""
        return self._mean(state.stress)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means (..., nv) over the points of the soil's cells."""
        return np.asarray(values.mean(axis=1))

    def _pressure(self, state: Fields) -> np.ndarray:
        """Return the excess pore pressure (n,), Pa."""
        return np.asarray(state.pressure[: len(self.nodes)])

    def _gap(self, state: Fields) -> np.ndarray:
        """Return the largest opening (n,) of the stations that a node of the soil belongs to."""
        stations, gap = self.system.stations, self.system.gaps(state)
        widest = np.zeros(len(self.nodes))
        station, place = np.nonzero(stations.weight > 0.0)
        np.maximum.at(widest, stations.nodes[station, place], gap[station])
        return widest


class FourierVolume(Volume):
    """A Fourier model as hexahedra of the half domain: sectors around each azimuth of the soil law.

    Nodes are the corners of the section at the edges (M + 1,) between these azimuths; cells those at all azimuths.
    """

    built: BuiltFourier  # type: ignore[assignment]

    def _take_cells(self) -> None:
        mesh, m, steel = self.built.model.mesh, self.built.model.azimuths, self.built.steel
        self.edges = np.linspace(0.0, np.pi, m + 1)
        shells = mesh.quads[:0] if steel is None else steel.quads
        self.corner = np.concatenate([mesh.corners, np.unique(shells[:, :4])])
        number = np.full(mesh.n_nodes, -1)
        number[self.corner] = np.arange(len(self.corner))
        n = len(self.corner)
        parts = (number[quads[:, [0, 3, 2, 1]]] for quads in (mesh.quads, shells))
        self.hexes = np.concatenate([np.hstack([q + j * n, q + (j + 1) * n]) for q in parts for j in range(m)])
        self.n_steel = m * len(shells)
        r, z = mesh.nodes[self.corner].T
        c, s = np.cos(self.edges)[:, None], np.sin(self.edges)[:, None]
        self.nodes = np.stack([c * r, s * r, np.broadcast_to(z, (m + 1, n))], axis=-1).reshape(-1, 3)
        self._wave = elements.waves(self.edges, self.built.model.harmonics)
        of_steel = np.tile(self.corner >= self.built.model.n_soil, m + 1)
        self.rigid = body_operator(self.nodes) * of_steel[:, None, None]

    def _displacement(self, state: Fields) -> np.ndarray:
        """Return the displacement (n, 3) in global axes."""
        move = state.displacement[self.corner]
        r, t, z = (np.einsum("jk,nk->jn", self._wave[..., w], move[:, i]) for i, w in enumerate((0, 1, 0)))
        c, s = np.cos(self.edges)[:, None], np.sin(self.edges)[:, None]
        move = np.stack([c * r - s * t, s * r + c * t, z], axis=-1).reshape(-1, 3)
        return move + self.rigid @ state.border

    def _stress(self, state: Fields) -> np.ndarray:
        """Return the mean stress (cells, 6) of the soil in global axes."""
        rr, tt, zz, rt, tz, zr = np.moveaxis(self._mean(state.stress), -1, 0)
        angle = elements.azimuths(self.built.model.azimuths)[:, None]
        c, s = np.cos(angle), np.sin(angle)
        xx, yy = c * c * rr + s * s * tt - 2 * c * s * rt, s * s * rr + c * c * tt + 2 * c * s * rt
        xy = c * s * (rr - tt) + (c * c - s * s) * rt
        return np.stack([xx, yy, zz, xy, s * zr + c * tz, c * zr - s * tz], axis=-1).reshape(-1, 6)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means (M, ne, nv) over the points of a section at each azimuth."""
        ne, _, nv = values.shape
        return values.reshape(ne, elements.N_POINTS, -1, nv).mean(axis=1).transpose(1, 0, 2)

    def _pressure(self, state: Fields) -> np.ndarray:
        """Return the excess pore pressure (n,), Pa; 0 in steel."""
        n_soil = len(self.built.section.mesh.corners)
        pressure = np.zeros((len(self.edges), len(self.corner)))
        pressure[:, :n_soil] = self._wave[..., 0] @ state.pressure[:n_soil].T
        return pressure.ravel()

    def _gap(self, state: Fields) -> np.ndarray:
        """Return the largest opening (n,) of the stations of a node, those at the nearest azimuth."""
        azimuth, stations = self.built.azimuth, self.built.model.stations
        nearest = azimuth[np.abs(self.edges[:, None] - azimuth).argmin(axis=1)]
        node, gap = self.system.contact.node, self.system.gaps(state)
        widest = np.zeros((len(self.edges), self.built.model.mesh.n_nodes))
        for i, angle in enumerate(nearest):
            mine = stations.azimuth == angle
            np.maximum.at(widest[i], node[mine], gap[mine])
        return widest[:, self.corner].ravel()
