# SPDX-License-Identifier: MIT
"""Engine state -> raw rows of a path: body motion, loads, interface tractions by ring and by point.

Everything is for the whole caisson (twice the half model). Forces are those of the caisson on the soil, so
that they oppose positive displacements and sum to the applied load.

Slices of the skirt:

    bricks    a slice for each ring, half way to its neighbours; one above and one below a ring on a boundary of layers
    series    a slice for each element of the skirt's faces

A ring on the edge of two slices shares its force between them by their heights; that of the water goes to those alone
whose layer holds water. No slice reaches over a boundary.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.balance.water import WaterBalance
from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.full_model.cavitation import Watch
from pysprings.full_model.record import VOLUMES
from pysprings.full_model.volume import Volume
from pysprings.model.build import Built, moments
from pysprings.model.contact import SURFACE
from pysprings.model.fourier import SIDES


@dataclass(frozen=True)
class SkirtSlices:
    """Slices from mudline to tip.

    rings : (nz,) depths of the rings of nodes, m.
    bounds : (nd, 2) top and bottom of each slice, m.
    depth : (nd,) where the forces of a slice are said to act, m.
    shares : (nd, nz) part of the force of each ring in each slice; the parts of a ring sum to 1.
    """

    rings: np.ndarray
    bounds: np.ndarray
    depth: np.ndarray
    shares: np.ndarray

    @property
    def height(self) -> np.ndarray:
        """Heights (nd,), m."""
        return np.asarray(self.bounds[:, 1] - self.bounds[:, 0])

    def forces(self, of_rings: np.ndarray) -> np.ndarray:
        """Return the forces of slices (nd,) from those of rings (nz,)."""
        return np.asarray(self.shares @ of_rings)

    def of_water(self, wet: np.ndarray) -> Self:
        """Return the slices with the force of each ring in those alone that hold water, ``wet`` (nd,) bool."""
        shares = self.shares * wet[:, None]
        sums = shares.sum(axis=0)
        return replace(self, shares=np.where(sums > 0.0, shares / np.where(sums > 0.0, sums, 1.0), self.shares))

    def turning(self, lateral: np.ndarray) -> np.ndarray:
        """Return the moments (nd,) of the lateral forces of rings (nz,) about the depth of their slice."""
        arm = self.rings[None] - self.depth[:, None]
        return np.asarray((self.shares * arm) @ lateral)

    @property
    def main_ring(self) -> np.ndarray:
        """The ring (nd,) with the most force in each slice."""
        return np.asarray(self.shares.argmax(axis=1))

    def on_lines(self, values: np.ndarray) -> np.ndarray:
        """Return values (..., nd) at the depths of the slices, on straight lines between rings (..., nz)."""
        above = np.clip(np.searchsorted(self.rings, self.depth, side="right") - 1, 0, len(self.rings) - 2)
        low, high = self.rings[above], self.rings[above + 1]
        part = (self.depth - low) / (high - low)
        return np.asarray(values[..., above] * (1.0 - part) + values[..., above + 1] * part)


def slices_of_rings(rings: np.ndarray, boundary: np.ndarray) -> SkirtSlices:
    """Return the slices of bricks with rings at depths (nz,) m; ``boundary`` (nz,) bool marks those between layers.

    A slice acts at the depth of its ring, one of the two beside a boundary in its own middle.
    """
    middle = 0.5 * (rings[1:] + rings[:-1])
    tops, bottoms = np.concatenate([rings[:1], middle]), np.concatenate([middle, rings[-1:]])
    bounds, depth, shares = [], [], []
    for k, (z, top, bottom) in enumerate(zip(rings, tops, bottoms, strict=True)):
        cut = boundary[k] and 0 < k < len(rings) - 1
        for low, high in ((top, z), (z, bottom)) if cut else ((top, bottom),):
            bounds.append((low, high))
            depth.append(0.5 * (low + high) if cut else z)
            shares.append(np.zeros(len(rings)))
            shares[-1][k] = (high - low) / (bottom - top) if cut else 1.0
    return SkirtSlices(rings, np.array(bounds), np.array(depth), np.array(shares))


def slices_of_elements(line: np.ndarray) -> SkirtSlices:
    """Return the slices of a series with nodes at depths (nz,) m, three an element."""
    bounds = np.stack([line[:-2:2], line[2::2]], axis=1)
    shares = np.zeros((len(bounds), len(line)))
    for e, (top, bottom) in enumerate(bounds):
        shares[e, 2 * e : 2 * e + 3] = bottom - top
    return SkirtSlices(line, bounds, bounds.mean(axis=1), shares / shares.sum(axis=0))


class Collector(Watch):
    """Gathers one row per converged step of a path and turns them into a Dataset.

    ``balance`` follows the water of the path; it is None where the scene is drained. ``sea`` is (unit weight of water
    in N/m3, water depth in m); None leaves suction unchecked.
    """

    built: Built
    system: System

    def __init__(
        self, built: Any, system: Any, fields: bool, section: bool,
        balance: WaterBalance | None = None, sea: tuple[float, float] | None = None, volume: bool = False,
        holds_water: Callable[[np.ndarray], np.ndarray] = np.ones_like,
    ) -> None:  # fmt: skip
        self.balance, self.sea = balance, sea
        self.built, self.system = built, system
        self.keep_fields, self.keep_section = fields, section
        self.position, self.surface = built.model.stations.position, built.model.stations.surface
        self.rings = {side: self._ring_stations(side) for side in SIDES}
        self._take_mesh(volume)
        self.slices_of_water = self.slices.of_water(holds_water(self.slices.bounds.mean(axis=1)))
        self.rows: list[dict[str, Any]] = []

    def _take_mesh(self, volume: bool) -> None:
        """Take slices, azimuths, places of the water, and the volume where it is asked for, from the mesh."""
        caisson, nodes, film = self.built.caisson, self.built.model.mesh.nodes, self.built.film_mesh_node
        n_wet, n = caisson.mesh.n_nodes, len(nodes)
        self.wet = np.r_[:n_wet, n : n + len(film)]  # steel holds no water
        self.water_position = np.concatenate([nodes[:n_wet], nodes[film]])
        self.slices, self.azimuth = slices_of_rings(caisson.depth, caisson.boundary), caisson.azimuth
        self.volume: Volume | None = Volume(self.built, self.system) if volume else None

    def _ring_stations(self, side: str) -> np.ndarray:
        """Return the station number of each wall node, (na, nz)."""
        mine = np.flatnonzero(self.surface == SURFACE[SIDES[side]])
        number = np.full(self.built.caisson.mesh.n_nodes, -1)
        number[self.system.stations.nodes[mine, 0]] = mine
        return number[self.built.caisson.walls[side]]

    def add(self, state: Fields, time: float, converged: bool = True) -> None:
        """Record a state; ``converged`` marks it."""
        stations = self.system.stations
        traction = np.einsum("sij,si->sj", stations.frame, state.traction)
        share = self.system.film_area / stations.area
        water = self._film_pressure(state) * (share > 0.0)
        acting = water * share  # on the whole area
        force = -2.0 * stations.area[:, None] * (traction - stations.frame[:, 0] * acting[:, None])
        u, w, rotation = (float(v) for v in state.border)
        row: dict[str, Any] = {"time": time, "u": u, "w": w, "rotation": rotation, "converged": np.int8(converged)}
        row |= self._resultants(force)
        row |= self._rings(state, force, acting)
        row |= self._shape(state, u - rotation * self.slices.depth)
        row |= self._patches(state, water)
        row |= self._water(state, acting)
        if self.keep_fields:
            row |= self._wall_fields(state, traction, water)
        if self.keep_section:
            row |= self._section(state)
        if self.volume is not None:
            row |= self.volume.fields(state)
        self.rows.append(row)

    def _shape(self, state: Fields, rigid: np.ndarray) -> dict[str, np.ndarray]:
        """Return the mean-fibre displacement of each section, and the changes of its diameters if it is elastic."""
        steel = self.built.steel
        if steel is None:
            return {"y": rigid}
        # of the steel's middle, (na, nz, 3) at rings: counted from the rigid motion, which moves no diameter
        bent = 0.5 * sum(state.displacement[wall] for wall in steel.walls.values())
        bent = np.moveaxis(self.slices.on_lines(np.moveaxis(bent, 1, 2)), 2, 1)
        share = np.ones(len(bent))
        share[[0, -1]] = 0.5  # the half ring ends in the symmetry plane
        front, side, back = bent[0], bent[len(bent) // 2], bent[-1]
        return {
            "y": rigid + share @ bent[:, :, 0] / share.sum(),
            "diameter_change_x": front[:, 0] - back[:, 0],
            "diameter_change_y": 2.0 * side[:, 1],
        }

    def _resultants(self, force: np.ndarray) -> dict[str, float]:
        """Return H, V, M of each surface and in total; the tip's moment is about the axis point at its own depth."""
        row: dict[str, float] = {}
        total = {"H": force[:, 0], "V": force[:, 2], "M": moments(self.position, force)}
        for name, code in SURFACE.items():
            mine = self.surface == code
            row |= {f"{key}_{name}": float(value[mine].sum()) for key, value in total.items()}
        row |= {key: float(value.sum()) for key, value in total.items()}
        row["M_tip"] += self.slices.bounds[-1, 1] * row["H_tip"]
        return row

    def _film_pressure(self, state: Fields) -> np.ndarray:
        """Return the excess pressure (ns,) of the water between soil and caisson, Pa; 0 when drained."""
        water = self.built.model.water
        if water is None or water.film is None:
            return np.zeros(len(self.surface))
        film = state.pressure[self.built.model.mesh.n_nodes :]
        return np.einsum("sc,sc->s", water.film.weight, film[water.film.nodes])

    def _water(self, state: Fields, water: np.ndarray) -> dict[str, float]:
        """Return the water force under the lid, the balance of the water and its lowest pressure (whole caisson)."""
        lid = self.surface == SURFACE["lid"]
        stations = self.system.stations
        row = {"F_pw": 2.0 * float(np.sum((stations.area * stations.frame[:, 0, 2] * water)[lid]))}
        if self.balance is None:
            return row
        now = self.balance.now(state)
        row |= {f"water_{name}": 2.0 * getattr(now, name) for name in VOLUMES}
        return row | self._pressure_range(state) | self.suction(self._wet_pressures(state))

    def _pressure_range(self, state: Fields) -> dict[str, float]:
        """Return lowest pressure of soil and film, and highest of the soil."""
        n = self.built.model.mesh.n_nodes
        return {"pressure_min": float(state.pressure.min()), "pressure_max": float(state.pressure[:n].max())}

    def _wet_pressures(self, state: Fields) -> np.ndarray:
        """Return pressures at the places of `water_position`."""
        return state.pressure[self.wet]

    def _rings(self, state: Fields, force: np.ndarray, water: np.ndarray) -> dict[str, np.ndarray]:
        """Return the p by depth, side and component; m and t by depth and side."""
        height = self.slices.height
        stations = self.system.stations
        toward_x = 2.0 * stations.area * stations.frame[:, 0, 0]
        normal_x, water_x = -toward_x * state.traction[:, 0], toward_x * water
        parts = {"normal": normal_x, "shear": force[:, 0] - normal_x - water_x, "water": water_x}
        x = self.position[:, 0]
        p = np.empty((len(height), len(SIDES), len(parts)))
        m, t = np.empty(p.shape[:2]), np.empty(p.shape[:2])
        slices = {name: self.slices_of_water if name == "water" else self.slices for name in parts}
        for s, ring in enumerate(self.rings.values()):
            sums = {name: part[ring].sum(axis=0) for name, part in parts.items()}
            for c, name in enumerate(variables.COMPONENTS):
                p[:, s, c] = slices[name].forces(sums[name]) / height
            turning = sum(slices[name].turning(force_x) for name, force_x in sums.items())
            m[:, s] = (self.slices.forces((force[:, 2] * x)[ring].sum(axis=0)) - turning) / height
            t[:, s] = self.slices.forces(force[:, 2][ring].sum(axis=0)) / height
        return {"p_component": p, "m": m, "t": t, "p": p.sum(axis=(1, 2))}

    def _gap(self, state: Fields) -> np.ndarray:
        return self.system.gaps(state)

    def _patches(self, state: Fields, water: np.ndarray) -> dict[str, np.ndarray]:
        """Return the normal stress, water pressure and gap under the lid and the tip."""
        gap, row = self._gap(state), {}
        for name in ("lid", "tip"):
            mine = self.surface == SURFACE[name]
            row[f"{name}_normal_effective_stress"] = -state.traction[mine, 0]
            row[f"{name}_gap"] = gap[mine]
            if self.balance is not None:
                row[f"{name}_pore_pressure"] = water[mine]
        return row

    def _wall_fields(self, state: Fields, traction: np.ndarray, water: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields on both walls, (side, azimuth, depth); shear is the traction of the caisson on the soil."""
        shear = -traction + self.system.stations.frame[:, 0] * state.traction[:, :1]
        by_station = {
            "normal_effective_stress": -state.traction[:, 0],
            "shear_lateral": shear[:, 0],
            "shear_vertical": shear[:, 2],
            "pore_pressure": water,
            "gap": self._gap(state),
        }
        rings = [ring[:, self.slices.main_ring] for ring in self.rings.values()]
        return {k: np.stack([v[ring] for ring in rings]) for k, v in by_station.items()}

    def _section(self, state: Fields) -> dict[str, np.ndarray]:
        node = np.unique(self.built.caisson.section)
        row = {"section_ux": state.displacement[node, 0], "section_uz": state.displacement[node, 2]}
        return row if self.balance is None else row | {"section_pore_pressure": state.pressure[node]}

    def dataset(self) -> xr.Dataset:
        """Return all rows as a Dataset with the variables of `variables.GROUPS["result_path"]`."""
        data = stacked(self.rows, "result_path")
        for part in ("lid", "tip"):
            mine = self.position[self.surface == SURFACE[part]]
            data[f"{part}_x"] = ((f"{part}_point",), mine[:, 0])
            data[f"{part}_y"] = ((f"{part}_point",), mine[:, 1])
        for name, surface in (("F_in", "V_inner"), ("F_out", "V_outer")):
            values = np.array([row[surface] for row in self.rows])
            data[name] = ("step", values - values[0])
        data["depth_bounds"] = (("depth", "bound"), self.slices.bounds)
        coords = {
            "depth": self.slices.depth, "azimuth": self.azimuth, "side": list(variables.SIDES),
            "component": list(variables.COMPONENTS), "step": np.arange(len(self.rows)),
        }  # fmt: skip
        return variables.attach(xr.Dataset(data, coords=coords), "result_path")


def stacked(rows: list[dict[str, Any]], group: str) -> dict[str, Any]:
    """Return the values of rows, one a step, as arrays with the dimensions of a group of `variables.GROUPS`."""
    data = {}
    for name in rows[0]:
        order = variables.GROUPS[group][name].dims
        values = np.array([row[name] for row in rows])
        data[name] = xr.DataArray(values, dims=("step", *(d for d in order if d != "step"))).transpose(*order)
    return data


def section_dataset(built: Built) -> xr.Dataset:
    """Return the symmetry plane of the mesh."""
    node, quad = np.unique(built.caisson.section, return_inverse=True)
    position = built.model.mesh.nodes[node]
    data = {
        "section_x": ("section_node", position[:, 0]),
        "section_depth": ("section_node", position[:, 2]),
        "section_quad": (("section_cell", "corner"), quad.reshape(-1, 4).astype(np.int32)),
    }
    return variables.attach(xr.Dataset(data), "section")
