# SPDX-License-Identifier: MIT
"""A meshed caisson with invented tractions, pressures and motions, and every sum of them by plain loops.

The tractions follow no soil law: hyperbolas of the motion of each station, other ones on each face, with shares that
differ from station to station, so that no two columns of a table are alike. `result` puts them through the collector
that a run has; `Raw` adds the same stations up one by one, from the mesh alone.
"""

from copy import deepcopy
from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.balance.water import WaterBalance
from fe_engine.soil.plasol import KAPPA
from fe_engine.state import Fields, State
from pysprings.core import variables
from pysprings.full_model.collect import Collector, section_dataset
from pysprings.full_model.volume import Volume
from pysprings.model.build import Built, build_model
from pysprings.model.contact import SURFACE
from pysprings.springs.checks import RESULT
from tests.support import tiny

FACES = {code: name for name, code in SURFACE.items()}
SIDE = {"outside": "outer", "inside": "inner"}
STEPS, LENGTH, RADIUS, THICKNESS = 7, 4.0, 3.9, 0.1
WEIGHT, SEA = 1.0e4, 12.0  # N/m3, m
GROWTH = np.linspace(0.0, 1.0, STEPS) ** 1.5
# End of each path: u (m), w (m), rotation; kind, role.
PATHS = {
    "slide": ((6e-3, -3e-4, 0.0), "translation", "calibration"),
    "turn": ((0.0, 1e-4, 1.2e-3), "rotation", "calibration"),
    "swept": ((4e-3, -2e-4, -5e-4), "translation", "held-back"),
    "down": ((0.0, 8e-3, 0.0), "vertical", "calibration"),
}
SHARE = {"outer": 1.0, "inner": 0.3, "lid": 0.5, "tip": 0.8}


@cache
def built() -> Built:
    """Return the tiny caisson with water, where the film joins skirt and lid."""
    path = tiny.PULL | {"rate": 1e-4}
    return build_model(tiny.scene(drainage={"mode": "coupled"}, paths=(path,)))


@cache
def states(name: str) -> list[Fields]:
    """Return the states of a path: all fields of a model filled in."""
    model, end = built().model, np.array(PATHS[name][0])
    stations, start = model.stations, State(model).committed
    assert stations is not None
    random = np.random.default_rng(len(name))
    displacement = random.normal(0.0, 2e-4, start.displacement.shape)
    pressure, stress = random.normal(0.0, 2e3, start.pressure.shape), random.normal(0.0, 1e4, start.stress.shape)
    strain = random.uniform(0.0, 1e-3, start.history.shape)
    share = np.array([SHARE[FACES[int(code)]] for code in stations.surface])
    share = share * (1.0 + 0.2 * np.sin(np.arange(len(share))))
    reached = []
    for factor in GROWTH:
        state = deepcopy(start)
        state.border[...] = factor * end
        motion = np.einsum("sij,sjk,k->si", stations.frame, stations.body, state.border)
        stiffness = share[:, None] * np.array([4e7, 1e7, 1.5e7])
        state.traction[...] = start.traction - stiffness * motion / (1.0 + np.abs(motion) / 5e-3)
        state.displacement[...], state.pressure[...] = factor * displacement, start.pressure + factor * pressure
        state.stress[...], state.history[...] = start.stress + factor * stress, factor * strain
        reached.append(state)
    for state in reached[1:] if PATHS[name][1] != "vertical" else ():  # the lid carries what the others do not
        state.traction[stations.surface == SURFACE["lid"], 0] += (vertical(state) - vertical(reached[0])) / lid_area()
    return reached


def vertical(state: Fields) -> float:
    """Return the vertical force (N) of the whole caisson on the soil."""
    stations, film = built().model.stations, built().model.water.film  # type: ignore[union-attr]
    assert stations is not None and film is not None
    pressure = state.pressure[built().model.mesh.n_nodes :]
    total = 0.0
    for k, area in enumerate(stations.area):
        water = float(film.weight[k] @ pressure[film.nodes[k]])
        total -= 2.0 * area * float(stations.frame[k, :, 2] @ state.traction[k] - stations.frame[k, 0, 2] * water)
    return total


def lid_area() -> float:
    """Return the area (m2) under the whole lid; its normal points down."""
    stations = built().model.stations
    assert stations is not None
    lid = stations.surface == SURFACE["lid"]
    return 2.0 * float(np.sum(stations.area[lid] * stations.frame[lid, 0, 2]))


def times() -> np.ndarray:
    """Time (s) of each state."""
    return 60.0 * GROWTH


@cache
def result() -> xr.DataTree:
    """Return a result of these paths, by the collector; the last step of `slide` did not converge."""
    made, groups = built(), dict[str, xr.Dataset]()
    system = System(made.model)
    for name, (_, kind, role) in PATHS.items():
        balance = WaterBalance(system, states(name)[0])
        balance.totals = (3e-3, 7e-3)  # as if so much had flowed out and moved
        collector = Collector(made, system, True, True, balance, (WEIGHT, SEA), volume=True)
        for k, (state, time) in enumerate(zip(states(name), times(), strict=True)):
            collector.add(state, float(time), converged=(name, k) != ("slide", STEPS - 1))
        data = collector.dataset()
        data.attrs = {"kind": kind, "arm_m": np.nan if kind == "vertical" else 0.0, "role": role, "status": "complete"}
        data.attrs["arm_m"], data.attrs["heave"] = 0.0, "free"
        groups[f"/paths/{name}"] = data
    dofs = list(variables.DOFS)
    root = xr.Dataset({"stiffness_initial": (("dof", "dof_conjugate"), STIFFNESS)})
    root = variables.attach(root.assign_coords(dof=dofs, dof_conjugate=dofs), "springs_root")
    root.attrs = {
        "Conventions": "CF-1.11", "schema": RESULT, "title": "raw", "source": "pysprings 0.0.0",
        "pysprings_version": "0.0.0", "scene_sha256": "0" * 64, "scene_toml": "", "status": "complete",
        "history": "made by a test",
        "drainage": "undrained", "outer_diameter_m": 2.0 * RADIUS, "skirt_length_m": LENGTH,
        "skirt_thickness_m": THICKNESS, "vertical_load_N": 1.0e6, "caisson_behaviour": "rigid",
    }  # fmt: skip
    fixed = {"/": root, "/section": section_dataset(made), "/volume": Volume(made).dataset()}
    return xr.DataTree.from_dict(fixed | groups)


STIFFNESS = np.array([[4.0e9, 1.0e6, -9.0e9], [2.0e6, 3.5e9, -3.0e6], [-9.4e9, -5.0e6, 8.0e10]])


@dataclass(frozen=True)
class Raw:
    """One state of a path, summed up station by station; forces (N) of the whole caisson on the soil."""

    path: str
    step: int

    @property
    def state(self) -> Fields:
        return states(self.path)[self.step]

    @property
    def motion(self) -> tuple[float, float, float]:
        """u (m), w (m), rotation."""
        u, w, rotation = PATHS[self.path][0]
        return GROWTH[self.step] * u, GROWTH[self.step] * w, GROWTH[self.step] * rotation

    def stations(self) -> list[tuple[str, np.ndarray, dict[str, np.ndarray]]]:
        """Return the face, position (m) and force vectors of each station: its normal, shear and water parts."""
        rows, model = [], built().model
        all_of, film = model.stations, model.water.film  # type: ignore[union-attr]
        assert all_of is not None and film is not None
        for k in range(len(all_of.area)):
            normal, first, second = all_of.frame[k]
            n, s1, s2 = self.state.traction[k]
            twice = 2.0 * float(all_of.area[k])
            parts = {"normal": -twice * n * normal, "shear": -twice * (s1 * first + s2 * second)}
            parts["water"] = twice * self.water(k) * normal
            rows.append((FACES[int(all_of.surface[k])], all_of.position[k], parts))
        return rows

    def water(self, k: int) -> float:
        """Return the excess pressure (Pa) in the film at a station."""
        model = built().model
        film = model.water.film  # type: ignore[union-attr]
        assert film is not None
        first = model.mesh.n_nodes
        pairs = zip(film.weight[k], film.nodes[k], strict=True)
        return sum(float(weight) * float(self.state.pressure[first + node]) for weight, node in pairs)

    def gap(self, k: int) -> float:
        """Return the opening (m) of a station: distance of soil and caisson less the initial penetration."""
        model = built().model
        stations = model.stations
        assert stations is not None
        soil = np.zeros(3)
        for node, weight in zip(stations.nodes[k], stations.weight[k], strict=True):
            moved = self.state.displacement[node]
            soil += weight * (model.frames[int(node)].T @ moved if int(node) in model.frames else moved)
        apart = float(stations.frame[k, 0] @ (soil - stations.body[k] @ np.array(self.motion)))
        return max(apart - float(model.initial_pressure[k]) / float(model.contact[k][0]), 0.0)

    def on(self, face: str) -> dict[str, float]:
        """Return H, V, M (about the lid centre; of the tip about the axis point at its own depth) on a face."""
        out, about = {"H": 0.0, "V": 0.0, "M": 0.0}, LENGTH if face == "tip" else 0.0
        for name, (x, _, z), parts in self.stations():
            if name == face:
                fx, _, fz = sum(parts.values())
                out["H"], out["V"], out["M"] = out["H"] + fx, out["V"] + fz, out["M"] + fz * x - fx * (z - about)
        return out

    def total(self) -> dict[str, float]:
        """Return H, V, M about the lid centre."""
        out = {"H": 0.0, "V": 0.0, "M": 0.0}
        for _, (x, _, z), parts in self.stations():
            fx, _, fz = sum(parts.values())
            out["H"], out["V"], out["M"] = out["H"] + fx, out["V"] + fz, out["M"] + fz * x - fx * z
        return out

    def ring(self, side: str, depth: float) -> dict[str, float]:
        """Return the reactions per metre of a ring on one side: p by component, m and t."""
        top, bottom = slice_of(depth)
        out = dict.fromkeys(("normal", "shear", "water", "m", "t"), 0.0)
        count = 0
        for name, (x, _, z), parts in self.stations():
            if name == SIDE[side] and abs(z - depth) < 1e-9:
                count += 1
                force = sum(parts.values())
                for part, vector in parts.items():
                    out[part] += float(vector[0]) / (bottom - top)
                out["m"] += float(force[2]) * float(x) / (bottom - top)
                out["t"] += float(force[2]) / (bottom - top)
        assert count == len(built().caisson.azimuth)
        return out

    def net(self, depth: float) -> dict[str, float]:
        """Return the p, m and t of both sides."""
        both = [self.ring(side, depth) for side in SIDE]
        out = {key: sum(one[key] for one in both) for key in ("m", "t")}
        return out | {"p": sum(one[part] for one in both for part in ("normal", "shear", "water"))}


def depths() -> list[float]:
    """Return the depths (m) of the rings, from the places of the stations."""
    stations = built().model.stations
    assert stations is not None
    outer = stations.position[stations.surface == SURFACE["outer"], 2]
    return sorted({round(float(z), 9) for z in outer})


def slice_of(depth: float) -> tuple[float, float]:
    """Return the top and bottom (m) of the slice of a ring: half way to its neighbours."""
    z = depths()
    k = min(range(len(z)), key=lambda i: abs(z[i] - depth))
    return (0.0 if k == 0 else 0.5 * (z[k - 1] + z[k])), (LENGTH if k == len(z) - 1 else 0.5 * (z[k] + z[k + 1]))


@cache
def raw(path: str, step: int) -> dict[str, dict]:
    """Return everything of one state, summed once: motion, total, on (face), ring (side, depth), net (depth), F_pw."""
    one = Raw(path, step)
    u, w, rotation = one.motion
    lid = sum(float(parts["water"][2]) for face, _, parts in one.stations() if face == "lid")
    return {
        "motion": {"u": u, "w": w, "rotation": rotation, "F_pw": lid},
        "total": one.total(),
        "on": {face: one.on(face) for face in SURFACE},
        "ring": {(side, z): one.ring(side, z) for side in SIDE for z in depths()},
        "net": {z: one.net(z) for z in depths()},
    }


def strain_of(state: Fields, cell: int) -> float:
    """Return the equivalent plastic strain of a cell: the mean of its eight points."""
    return sum(float(state.history[cell, point, KAPPA]) for point in range(8)) / 8.0
