# SPDX-License-Identifier: MIT
"""Station forces -> rings, surfaces and totals, against a plain loop over stations with invented tractions."""

from copy import deepcopy

import numpy as np
import pytest
import xarray as xr

from fe_engine.assembly.system import System
from fe_engine.state import Fields, State
from pysprings.core import variables
from pysprings.full_model.collect import Collector, section_dataset
from pysprings.model.build import Built, build_model
from pysprings.model.contact import SURFACE
from tests.support import tiny

MOTION = np.array([1e-3, -2e-4, 5e-5])
TIMES = (0.0, 7.5)


@pytest.fixture(scope="module")
def built() -> Built:
    return build_model(tiny.scene())


@pytest.fixture(scope="module")
def states(built: Built) -> list[Fields]:
    """The initial state, and one with tractions and displacements that follow no law."""
    first = State(built.model).committed
    second, random = deepcopy(first), np.random.default_rng(7)
    second.traction[...] = random.normal(0.0, 5e4, second.traction.shape)
    second.displacement[...] = random.normal(0.0, 1e-3, second.displacement.shape)
    second.border[...] = MOTION
    return [first, second]


def collect(built: Built, states: list[Fields], fields: bool = True, section: bool = True) -> xr.Dataset:
    collector = Collector(built, System(built.model), fields, section)
    for state, time in zip(states, TIMES, strict=True):
        collector.add(state, time)
    return collector.dataset()


@pytest.fixture(scope="module")
def path(built: Built, states: list[Fields]) -> xr.Dataset:
    return collect(built, states)


def forces(built: Built, state: Fields) -> list[tuple[int, np.ndarray, np.ndarray, float]]:
    """Surface, position, force of the whole caisson on the soil (N), x-force of the normal part, by station."""
    stations = built.model.stations
    assert stations is not None
    found = []
    for k in range(len(stations)):
        normal, *tangents = stations.frame[k]
        pressure = -state.traction[k, 0]
        push = 2.0 * stations.area[k] * pressure * normal
        drag = -2.0 * stations.area[k] * sum(t * row for t, row in zip(state.traction[k, 1:], tangents, strict=True))
        found.append((int(stations.surface[k]), stations.position[k], push + drag, float(push[0])))
    return found


def test_totals_and_surfaces(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    length = built.caisson.depth[-1]
    total = dict.fromkeys(("H", "V", "M"), 0.0)
    for name, code in SURFACE.items():
        mine = [(x, f) for surface, x, f, _ in forces(built, states[1]) if surface == code]
        assert mine, f"no station on the {name}"
        part = {
            "H": sum(f[0] for _, f in mine),
            "V": sum(f[2] for _, f in mine),
            "M": sum(f[2] * x[0] - f[0] * x[2] for x, f in mine),
        }
        total = {key: total[key] + part[key] for key in total}
        if name == "tip":
            part["M"] += length * part["H"]  # about the axis point at the tip's own depth
        for key, value in part.items():
            assert float(path[f"{key}_{name}"][1]) == pytest.approx(value, rel=1e-9)
    for key, value in total.items():
        assert float(path[key][1]) == pytest.approx(value, rel=1e-9)


def test_rings(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    heights = np.diff(path["depth_bounds"].values, axis=1)[:, 0]
    for side, surface in (("outside", "outer"), ("inside", "inner")):
        for k, depth in enumerate(built.caisson.depth):
            ring = [
                (x, f, n)
                for code, x, f, n in forces(built, states[1])
                if code == SURFACE[surface] and abs(x[2] - depth) < 1e-9
            ]
            assert len(ring) == len(built.caisson.azimuth)
            normal, shear, water = path["p_component"].sel(side=side).values[k, :, 1]
            assert normal == pytest.approx(sum(n for *_, n in ring) / heights[k], rel=1e-9)
            assert normal + shear == pytest.approx(sum(f[0] for _, f, _ in ring) / heights[k], rel=1e-9)
            assert water == 0.0
            m, t = (float(path[name].sel(side=side)[k, 1]) for name in ("m", "t"))
            assert m == pytest.approx(sum(f[2] * x[0] for x, f, _ in ring) / heights[k], rel=1e-9)
            assert t == pytest.approx(sum(f[2] for _, f, _ in ring) / heights[k], rel=1e-9)
    np.testing.assert_allclose(path["p"], path["p_component"].sum(("side", "component")))


def test_slices_cover_the_skirt(built: Built, path: xr.Dataset) -> None:
    bounds = path["depth_bounds"].values
    assert (bounds[0, 0], bounds[-1, 1]) == (0.0, pytest.approx(4.0))
    np.testing.assert_array_equal(bounds[1:, 0], bounds[:-1, 1])
    np.testing.assert_allclose(bounds[1:, 0], 0.5 * (built.caisson.depth[1:] + built.caisson.depth[:-1]))


def test_slices_at_a_boundary_of_layers_carry_what_the_walls_carry() -> None:
    built = build_model(tiny.scene(soil={"layers": [{"top": 0.0}, {"top": 1.3}]}))
    state, random = State(built.model).committed, np.random.default_rng(11)
    state.traction[...] = random.normal(0.0, 5e4, state.traction.shape)
    path = collect(built, [state, state]).isel(step=1)
    bounds, depth = path["depth_bounds"].values, path["depth"].values
    assert 1.3 in bounds[1:, 0] and len(depth) == len(built.caisson.depth) + 1
    height = np.diff(bounds, axis=1)[:, 0]
    p, m, t = path["p"].values, path["m"].sum("side").values, path["t"].sum("side").values
    wall = {key: float(path[f"{key}_outer"] + path[f"{key}_inner"]) for key in "HVM"}
    assert float(height @ p) == pytest.approx(wall["H"], rel=1e-9)
    assert float(height @ t) == pytest.approx(wall["V"], rel=1e-9)
    assert float(height @ (m - p * depth)) == pytest.approx(wall["M"], rel=1e-9)
    above = int(np.flatnonzero(bounds[:, 1] == 1.3)[0])
    fields = path["normal_effective_stress"]  # both slices are of the ring on the boundary
    np.testing.assert_array_equal(fields.isel(depth=above), fields.isel(depth=above + 1))


def test_motion_and_time(built: Built, path: xr.Dataset) -> None:
    assert [float(path[name][1]) for name in ("u", "w", "rotation")] == MOTION.tolist()
    np.testing.assert_allclose(path["y"][:, 1], MOTION[0] - MOTION[2] * built.caisson.depth)
    np.testing.assert_array_equal(path["time"], TIMES)
    np.testing.assert_array_equal(path["converged"], [1, 1])


def test_changes_of_vertical_shear_count_from_the_first_state(built: Built, states: list[Fields]) -> None:
    path = collect(built, states[::-1])  # shear in the first state
    for change, force in (("F_in", "V_inner"), ("F_out", "V_outer")):
        np.testing.assert_allclose(path[change], path[force] - path[force][0])
        assert path[change][0] == 0.0 and abs(float(path[change][1])) > 1.0


def test_fields_stand_at_their_stations(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    stations = built.model.stations
    assert stations is not None
    contact = built.model.contact[0]
    for side, surface in (("outside", "outer"), ("inside", "inner")):
        for i, azimuth in enumerate(built.caisson.azimuth):
            for k in (0, -1):
                at = np.flatnonzero(
                    (stations.surface == SURFACE[surface])
                    & (np.abs(stations.position[:, 2] - built.caisson.depth[k]) < 1e-9)
                    & (np.abs(np.arctan2(stations.position[:, 1], stations.position[:, 0]) - azimuth) < 1e-9)
                )
                (j,) = at
                here = path.isel(step=1, azimuth=i, depth=k).sel(side=side)
                normal, first, second = stations.frame[j]
                traction = states[1].traction[j]
                drag = -(traction[1] * first + traction[2] * second)
                assert float(here["normal_effective_stress"]) == pytest.approx(-traction[0])
                assert float(here["shear_lateral"]) == pytest.approx(drag[0])
                assert float(here["shear_vertical"]) == pytest.approx(drag[2])
                soil = states[1].displacement[stations.nodes[j, 0]]
                node = int(stations.nodes[j, 0])
                if node not in built.model.frames:
                    jump = normal @ (soil - stations.body[j] @ MOTION)
                    gap = max(jump - built.model.initial_pressure[j] / contact[0], 0.0)
                    assert float(here["gap"]) == pytest.approx(gap, abs=1e-12)


def test_patches_have_places_stresses_and_gaps(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    stations = built.model.stations
    assert stations is not None
    for part in ("lid", "tip"):
        mine = stations.surface == SURFACE[part]
        np.testing.assert_array_equal(path[f"{part}_x"], stations.position[mine, 0])
        np.testing.assert_array_equal(path[f"{part}_y"], stations.position[mine, 1])
        np.testing.assert_array_equal(path[f"{part}_normal_effective_stress"][1], -states[1].traction[mine, 0])
        assert float(path[f"{part}_gap"].min()) >= 0.0


def test_the_section_is_that_of_the_mesh(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    section = section_dataset(built)
    node = np.unique(built.caisson.section)
    np.testing.assert_array_equal(section["section_x"], built.model.mesh.nodes[node, 0])
    np.testing.assert_array_equal(path["section_uz"][1], states[1].displacement[node, 2])
    quad = section["section_quad"].values
    np.testing.assert_array_equal(node[quad], built.caisson.section)


def test_variables_are_those_of_the_table(built: Built, states: list[Fields], path: xr.Dataset) -> None:
    assert list(variables.problems(path, "result_path")) == []
    bare = collect(built, states, fields=False, section=False)
    assert list(variables.problems(bare, "result_path")) == []
    fields = {name for name, data in path.data_vars.items() if "azimuth" in data.dims}
    assert len(fields) == 5
    assert set(path) - set(bare) == fields | {"section_ux", "section_uz"}
    xr.testing.assert_identical(path[list(bare)], bare.drop_vars("azimuth"))


def test_a_state_can_be_marked_as_not_converged(built: Built, states: list[Fields]) -> None:
    collector = Collector(built, System(built.model), False, False)
    collector.add(states[0], 0.0, converged=False)
    data = collector.dataset()
    assert data["converged"].values.tolist() == [0] and data["converged"].dtype == np.int8


# --- the elastic caisson: what its sections do ---


@pytest.mark.parametrize("azimuth", [8, 12])
def test_the_mean_of_a_section_is_that_of_the_whole_ring(azimuth: int) -> None:
    """Displacement of the wall's middle by a polynomial in cos(azimuth); mean by a loop around the whole circle.

    cos^2 has the mean 1/2, cos and cos^3 none: nodes in the symmetry plane belong to both halves, and count once.
    """
    scene = tiny.scene(caisson={"behaviour": "elastic"}, mesh={"refinement": 0.4, "azimuth": azimuth})
    built = build_model(scene)
    steel, mesh = built.steel, built.model.mesh
    assert steel is not None
    state = deepcopy(State(built.model).committed)
    state.border[...] = MOTION
    length, amplitude = built.caisson.depth[-1], {"outside": 3e-4, "inside": 1e-4}  # their mean is that of the middle

    def bent(cos: float, z: float, of: float) -> tuple[float, float]:
        """Displacement along x and y of a point of the wall beyond the rigid motion."""
        return of * (1.0 + z / length) * (1.0 + 2.0 * cos + 3.0 * cos**2 + cos**3), of * (2.0 + z) * (1.0 - cos**2)

    for side, wall in steel.walls.items():
        for node in wall.ravel():
            x, y, z = mesh.nodes[node]
            state.displacement[node, :2] = bent(float(x / np.hypot(x, y)), float(z), amplitude[side])
    collector = Collector(built, System(built.model), False, False)
    collector.add(state, 0.0)
    row = collector.dataset().isel(step=0)
    around = [2.0 * np.pi * k / 360 for k in range(360)]
    for k, z in enumerate(built.caisson.depth):
        mean = sum(bent(np.cos(a), z, 2e-4)[0] for a in around) / len(around)
        assert mean == pytest.approx(2e-4 * (1.0 + z / length) * 2.5, rel=1e-12)
        assert float(row["y"][k]) == pytest.approx(MOTION[0] - MOTION[2] * z + mean, rel=1e-9)
        front, back, across = (bent(cos, z, 2e-4) for cos in (1.0, -1.0, 0.0))
        assert float(row["diameter_change_x"][k]) == pytest.approx(front[0] - back[0], rel=1e-9)
        assert float(row["diameter_change_y"][k]) == pytest.approx(2.0 * across[1], rel=1e-9)
