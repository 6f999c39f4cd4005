# SPDX-License-Identifier: MIT
"""Engine state of a Fourier model, of half or the whole of a caisson -> the rows that `collect` makes of bricks.

Fields around the ring are those of the stations, and the one trigonometric polynomial through them elsewhere, but for
the tractions between stations that are all open, and the gap between stations that are all closed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.elements import fourier as elements
from fe_engine.state import Fields
from pysprings.core import variables
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.full_model.cavitation import Watch
from pysprings.full_model.collect import Collector, slices_of_elements, stacked
from pysprings.full_model.volume import FourierVolume
from pysprings.model.contact import SURFACE, largest_tension
from pysprings.model.fourier import SIDES, BuiltFourier

_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


class FourierCollector(Collector):
    """A `collect.Collector` of a Fourier model."""

    built: BuiltFourier  # type: ignore[assignment]
    system: FourierSystem  # type: ignore[assignment]

    def _take_mesh(self, volume: bool) -> None:
        built = self.built
        self.slices, self.azimuth = slices_of_elements(built.section.depth), output_azimuths(built.model.harmonics)
        self._around, self._beside = around(built.azimuth, self.azimuth), beside(built.azimuth, self.azimuth)
        self._plane = _Plane(built)
        self._wave = elements.waves(self.azimuth, built.model.harmonics)[..., 0]
        self.water_position = np.zeros((0, 3)) if self.balance is None else water_places(built, self.azimuth)
        self.volume = FourierVolume(built, self.system) if volume else None

    def _ring_stations(self, side: str) -> np.ndarray:
        """Return the station number of each node of a wall, (na, nz)."""
        mine = np.flatnonzero(self.surface == SURFACE[SIDES[side]])
        return mine.reshape(-1, len(self.built.azimuth)).T

    def _wall_fields(self, state: Fields, traction: np.ndarray, water: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields on both walls, (side, azimuth, depth): means of the slices."""
        model, stations = self.built.model, self.built.model.stations
        sine, cosine = np.sin(stations.azimuth), np.cos(stations.azimuth)
        even, odd = self._around
        around_ring = sine * traction[:, 0] - cosine * traction[:, 1]  # along theta, of the caisson on the soil
        tension = largest_tension(model)
        opening = self.system.jumps(state)[:, 0] - model.initial_pressure / self.system.stations.penalties[:, 0]
        opening = np.where(np.isfinite(tension), opening - tension / self.system.stations.penalties[:, 0], -1.0)
        least, gaps = -np.array([tension[ring].max() for ring in self.rings.values()])[:, None, None], opening > 0.0
        lateral = -np.sin(self.azimuth)[:, None]
        return {
            "normal_effective_stress": np.maximum(self._on_walls(even, -state.traction[:, 0], gaps), least),
            "shear_lateral": lateral * self._on_walls(odd, around_ring, gaps),
            "shear_vertical": self._on_walls(even, -traction[:, 2], gaps),
            "pore_pressure": self._on_walls(even, water),
            "gap": self._on_walls(even, opening, ~gaps).clip(min=0.0),
        }

    def _on_walls(self, operator: np.ndarray, values: np.ndarray, level: np.ndarray | None = None) -> np.ndarray:
        """Return the means of the slices (side, azimuth, depth) of values (ns,) at the stations.

        Between stations that are all level (ns,) they are the means of theirs.
        """
        walls = []
        for ring in self.rings.values():
            found = operator @ values[ring]
            if level is not None:
                found = np.where(self._beside @ level[ring] > 1.0 - 1e-9, self._beside @ values[ring], found)
            walls.append(means_of_elements(found))
        return np.stack(walls)

    def _shape(self, state: Fields, rigid: np.ndarray) -> dict[str, np.ndarray]:
        """See `collect.Collector`; in the middle of each slice."""
        steel = self.built.steel
        if steel is None:
            return {"y": rigid}
        bent = 0.5 * sum(state.displacement[wall[1::2]] for wall in steel.walls.values())
        even = np.arange(0, bent.shape[2], 2)
        return {
            "y": rigid + 0.5 * (bent[:, 0, 1:2] - bent[:, 1, 1:2]).sum(axis=1),  # the mean along x is that of k = 1
            "diameter_change_x": 2.0 * bent[:, 0, even].sum(axis=1),
            "diameter_change_y": 2.0 * bent[:, 0, even] @ (-1.0) ** (even // 2),
        }

    def _section(self, state: Fields) -> dict[str, np.ndarray]:
        fields = self._plane.fields(state)
        return fields if self.balance is None else fields | {"section_pore_pressure": self._plane.pressure(state)}

    def _film_pressure(self, state: Fields) -> np.ndarray:
        water = self.system.water
        return np.zeros(len(self.surface)) if water is None else water.film_pressure(state.pressure)

    def _wet_pressures(self, state: Fields) -> np.ndarray:
        return (state.pressure @ self._wave.T).ravel()

    def _pressure_range(self, state: Fields) -> dict[str, float]:
        every, soil = self._wet_pressures(state), len(self.built.section.mesh.corners) * len(self.azimuth)
        return {"pressure_min": float(every.min()), "pressure_max": float(every[:soil].max())}


def water_places(built: BuiltFourier, azimuth: np.ndarray) -> np.ndarray:
    """Return places (n, 3) m at which pressures are evaluated: pressure nodes at azimuths (na,)."""
    r, z = built.section.mesh.nodes[built.model.pressure_nodes].T
    around_ring = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    at = np.empty((len(r), len(azimuth), 3))
    at[..., :2], at[..., 2] = r[:, None, None] * around_ring, z[:, None]
    return at.reshape(-1, 3)


def means_of_elements(at_nodes: np.ndarray) -> np.ndarray:
    """Return the means (na, nd) over elements of values (na, nz) at their nodes, three an element."""
    parts = at_nodes[:, :-2:2], at_nodes[:, 1::2], at_nodes[:, 2::2]
    return np.asarray(sum(share * part for share, part in zip(_SIMPSON, parts, strict=True)))


def output_azimuths(harmonics: int) -> np.ndarray:
    """Return the azimuths of fields, from front to back: those of the stations and the middles between them."""
    return np.linspace(0.0, np.pi, 2 * (harmonics + 1) + 1)


def beside(stations: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Return the mean (na, number of stations) of the stations that are nearest to each azimuth."""
    apart = np.abs(azimuth[:, None] - stations)
    near = apart < apart.min(axis=1, keepdims=True) + 1e-9
    return near / near.sum(axis=1, keepdims=True)


def around(stations: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return interpolation (na, number of stations) of even fields by cosines, and of odd ones by sines."""
    n = len(stations)
    here, there = elements.waves(stations, n), elements.waves(azimuth, n)
    of_cosine, of_sine = np.full(n + 1, 2.0 / n), np.full(n + 1, 2.0 / n)
    of_cosine[0], of_cosine[n] = 1.0 / n, 0.0
    of_sine[0], of_sine[n] = 0.0, 1.0 / n
    even: np.ndarray = (there[..., 0] * of_cosine) @ here[..., 0].T
    odd: np.ndarray = (there[..., 1] * of_sine) @ here[..., 1].T
    return even, odd


class _Plane:
    """The symmetry plane: corners of the section at the front and, mirrored, at the back."""

    def __init__(self, built: BuiltFourier) -> None:
        mesh = built.section.mesh
        corner = mesh.corners
        behind = corner[mesh.nodes[corner, 0] > 0.0]
        self.node = np.concatenate([corner, behind])
        self._corner = mesh.corner_numbers(self.node)
        self.back = np.arange(len(self.node)) >= len(corner)
        front, mirrored = np.full(mesh.n_nodes, -1), np.full(mesh.n_nodes, -1)
        front[corner] = mirrored[corner] = np.arange(len(corner))  # both on the axis
        mirrored[behind] = len(corner) + np.arange(len(behind))
        self.quads = np.concatenate([front[mesh.quads[:, :4]], mirrored[mesh.quads[:, [1, 0, 3, 2]]]])
        side = np.where(self.back, -1.0, 1.0)
        self.x, self.depth = side * mesh.nodes[self.node, 0], mesh.nodes[self.node, 1]
        self._side = side
        self._wave = side[:, None] ** np.arange(built.model.harmonics + 1)

    def fields(self, state: Fields) -> dict[str, np.ndarray]:
        """Return the displacements in the plane."""
        move = np.einsum("nik,nk->ni", state.displacement[self.node], self._wave)
        return {"section_ux": self._side * move[:, 0], "section_uz": move[:, 2]}

    def pressure(self, state: Fields) -> np.ndarray:
        """Return the excess pore pressure in the plane, Pa."""
        return np.sum(state.pressure[self._corner] * self._wave, axis=1)


def fourier_section_dataset(built: BuiltFourier) -> xr.Dataset:
    """Return the symmetry plane of the section's elements, by their corners."""
    plane = _Plane(built)
    data = {
        "section_x": ("section_node", plane.x),
        "section_depth": ("section_node", plane.depth),
        "section_quad": (("section_cell", "corner"), plane.quads.astype(np.int32)),
    }
    return variables.attach(xr.Dataset(data), "section")


class SpaceCollector(Watch):
    """Gathers one row per converged step of a path that leaves a plane, as `collect.Collector` does.

    Axes are those of the field: x, y to its left seen from above, rotations and moments right-handed with z up; w, V
    and depth are positive down. The engine has y to the right of x. ``system_now`` returns that of the model, made
    where a state is added. ``sea`` is that of a `Collector`.
    """

    def __init__(
        self, built: BuiltFourier, system_now: Callable[[], Any], fields: bool, sea: tuple[float, float] | None
    ) -> None:
        self.system_now, self.keep_fields = system_now, fields
        self.stations, n, self.wet = built.model.stations, len(built.azimuth), built.model.water is not None
        self.slices = slices_of_elements(built.section.depth)
        field = np.mod(-built.azimuth, 2.0 * np.pi)
        self._order = np.argsort(field)
        self.azimuth = field[self._order]
        walls = [np.flatnonzero(self.stations.surface == SURFACE[SIDES[side]]) for side in variables.SIDES]
        self.rings = [mine.reshape(-1, n).T for mine in walls]  # station of each azimuth and node
        self.rows: list[dict[str, Any]] = []
        self.sea = sea if self.wet else None
        if self.sea is not None:
            half = output_azimuths(built.model.harmonics)
            angle = np.concatenate([half, half[1:-1] + np.pi])
            self._wave = elements.waves(angle, built.model.harmonics, whole=True)[..., 0]
            self.water_position = water_places(built, -angle)

    def add(self, state: Fields, time: float, converged: bool = True) -> None:
        """Record a state; ``converged`` marks it."""
        stations = self.stations
        traction, water = np.einsum("sij,si->sj", stations.frame, state.traction), self._film(state)
        force = -stations.area[:, None] * (traction - stations.frame[:, 0] * water[:, None])
        loads = np.einsum("sij,si->j", stations.body, force)  # R^T f
        row: dict[str, Any] = {"time": time, "converged": np.int8(converged)}
        row |= zip((*MOTIONS, *LOADS), map(float, (*state.border, *loads)), strict=True)
        row |= self._by_depth(force)
        if self.sea is not None:
            row |= self.suction((state.pressure @ self._wave.T).ravel())
        if self.keep_fields:
            row |= self._wall_fields(state, traction, water)
        self.rows.append(row)

    def _film(self, state: Fields) -> np.ndarray:
        """Return the pressure of the film at the stations (ns,) [Pa], on the whole area; 0 without water."""
        system = self.system_now()
        if system.water is None:
            return np.zeros(len(system.film_area))
        return system.water.film_pressure(state.pressure) * system.film_area / system.stations.area

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

    def _wall_fields(self, state: Fields, traction: np.ndarray, water: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields on both walls (side, azimuth, depth): means of the slices."""
        angle = self.stations.azimuth
        by_station = {
            "normal_effective_stress": -state.traction[:, 0],
            "shear_around": np.cos(angle) * traction[:, 1] - np.sin(angle) * traction[:, 0],
            "shear_vertical": -traction[:, 2],
            "gap": self.system_now().gaps(state),
        } | ({"pore_pressure": water} if self.wet else {})
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
