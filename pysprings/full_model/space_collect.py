# SPDX-License-Identifier: MIT
"""Engine state of the whole caisson in six degrees of freedom -> the rows that `collect` makes of half a caisson.

Axes are those of the field: x, y to its left seen from above, rotations and moments right-handed with z up; w, V and
depth are positive down. The engine has y to the right of x.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.full_model.collect import slices_of_elements, stacked
from pysprings.full_model.fourier_collect import means_of_elements
from pysprings.model.contact import SURFACE
from pysprings.model.fourier import SIDES, BuiltFourier


class SpaceCollector:
    """Gathers one row per converged step of a path that leaves a plane, as `collect.Collector` does.

    ``gaps`` returns those of the stations in a state.
    """

    cavitation = None  # no water

    def __init__(self, built: BuiltFourier, gaps: Callable[[Fields], np.ndarray], fields: bool) -> None:
        self.gaps, self.keep_fields = gaps, fields
        self.stations, n = built.model.stations, len(built.azimuth)
        self.slices = slices_of_elements(built.section.depth)
        field = np.mod(-built.azimuth, 2.0 * np.pi)
        self._order = np.argsort(field)
        self.azimuth = field[self._order]
        walls = [np.flatnonzero(self.stations.surface == SURFACE[SIDES[side]]) for side in variables.SIDES]
        self.rings = [mine.reshape(-1, n).T for mine in walls]  # station of each azimuth and node
        self.rows: list[dict[str, Any]] = []

    def add(self, state: Fields, time: float, converged: bool = True) -> None:
        """Record a state; ``converged`` marks it."""
        stations = self.stations
        traction = np.einsum("sij,si->sj", stations.frame, state.traction)
        force = -stations.area[:, None] * traction
        loads = np.einsum("sij,si->j", stations.body, force)  # R^T f
        row: dict[str, Any] = {"time": time, "converged": np.int8(converged)}
        row |= dict(zip(MOTIONS, map(float, state.border), strict=True)) | dict(
            zip(LOADS, map(float, loads), strict=True)
        )
        row |= self._by_depth(force)
        if self.keep_fields:
            row |= self._wall_fields(state, traction)
        self.rows.append(row)

    def _by_depth(self, force: np.ndarray) -> dict[str, np.ndarray]:
        """Return p along x and y, vertical reaction t and torque by depth and side, per metre."""
        x, y = self.stations.position[:, 0], self.stations.position[:, 1]
        torque = y * force[:, 0] - x * force[:, 1]  # about z up, of components with y to the right
        parts = {"p_x": force[:, 0], "p_y": -force[:, 1], "t": force[:, 2], "torque": torque}
        return {
            name: np.stack(
                [self.slices.forces(part[ring].sum(axis=0)) / self.slices.height for ring in self.rings], axis=1
            )
            for name, part in parts.items()
        }

    def _wall_fields(self, state: Fields, traction: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields on both walls (side, azimuth, depth): means of the slices."""
        angle = self.stations.azimuth
        by_station = {
            "normal_effective_stress": -state.traction[:, 0],
            "shear_around": np.cos(angle) * traction[:, 1] - np.sin(angle) * traction[:, 0],
            "shear_vertical": -traction[:, 2],
            "gap": self.gaps(state),
        }
        return {
            name: np.stack([means_of_elements(values[ring])[self._order] for ring in self.rings])
            for name, values in by_station.items()
        }

    def dataset(self) -> xr.Dataset:
        """Return all rows as a Dataset with the variables of `variables.GROUPS["space_path"]`."""
        data = stacked(self.rows, "space_path") | {"depth_bounds": (("depth", "bound"), self.slices.bounds)}
        coords = {
            "depth": self.slices.depth, "side": list(variables.SIDES), "step": np.arange(len(self.rows)),
            **({"azimuth": self.azimuth} if self.keep_fields else {}),
        }  # fmt: skip
        return variables.attach(xr.Dataset(data, coords=coords), "space_path")
