# SPDX-License-Identifier: MIT
"""The whole half model at one state, soil and steel, for ParaView, in single precision."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.material import history_of
from fe_engine.soil.law import PLASTIC_STRAIN
from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.model.build import Built
from pysprings.model.signs import body_operator


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
